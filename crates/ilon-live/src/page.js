(function () {
  'use strict';
  const find = (id) => document.getElementById(id);
  const settings = JSON.parse(find('settings').textContent);
  document.documentElement.dataset.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  const scene = ilonScene(document.querySelector('canvas'), JSON.parse(find('data').textContent));
  const state = find('state');
  const note = find('note');
  let socket = null;
  let frames = 0;

  const tell = (message) => {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  };

  // Figures: what they are called, and how they are written.
  const deg = 180 / Math.PI;
  const shown = [
    ['Time', (f) => `${f.t_s.toFixed(1)} s`],
    ['Pace', (f) => `${f.real_time_factor.toFixed(2)} times real time`],
    ['Asked', (f) => `${f.asked[0].toFixed(2)}, ${f.asked[1].toFixed(2)} m/s, ${(deg * f.asked[2]).toFixed(0)} deg/s`],
    ['Real', (f) => `${f.real[0].toFixed(2)}, ${f.real[1].toFixed(2)} m/s, ${(deg * f.real[2]).toFixed(0)} deg/s`],
    ['Fastest sliding', (f) => `${(1000 * f.slip_m_s).toFixed(1)} mm/s`],
    ['Grip used', (f) => `${(100 * f.friction_used).toFixed(0)} %`],
    ['Odometry is off by', (f) => `${(1000 * f.odometry_error_m).toFixed(1)} mm`],
    ['Reference is away', (f) => (f.reference_error_m === null ? '' : `${(1000 * f.reference_error_m).toFixed(1)} mm`)],
  ].map(([name, write]) => {
    const tile = document.createElement('div');
    const label = document.createElement('span');
    const value = document.createElement('b');
    label.textContent = name;
    tile.append(label, value);
    find('figures').append(tile);
    return (figures) => {
      const text = write(figures);
      value.textContent = text;
      tile.hidden = text === '';
    };
  });

  function connect() {
    socket = new WebSocket(`ws://${location.host}/live`);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      state.textContent = '';
      tell({ mode: find('mode').value, speed: Number(find('speed').value) });
    };
    socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer) {
        frames += 1;
        document.documentElement.dataset.frames = frames;
        scene.push(data);
        return;
      }
      const message = JSON.parse(data);
      if (message.figures) shown.forEach((show) => show(message.figures));
      if (message.note) note.textContent = message.note;
    };
    socket.onclose = () => {
      state.textContent = '(not connected)';
      setTimeout(connect, 1000);
    };
  }

  // Driving: keys and a gamepad, repeated ten times a second, for the robot stops without.
  const held = new Set();
  const keys = { w: [1, 0, 0], s: [-1, 0, 0], a: [0, 1, 0], d: [0, -1, 0], q: [0, 0, 1], e: [0, 0, -1] };
  const ours = (event) => !event.ctrlKey && !event.altKey && !event.metaKey && event.key.toLowerCase() in keys;
  addEventListener('keydown', (event) => {
    if (event.key === ' ' && event.target === document.body) {
      event.preventDefault();
      held.clear();
      drive();
    } else if (ours(event)) {
      held.add(event.key.toLowerCase());
      if (!event.repeat) drive();
    }
  });
  addEventListener('keyup', (event) => {
    if (held.delete(event.key.toLowerCase())) drive();
  });
  addEventListener('blur', () => {
    held.clear();
    drive();
  });
  const stick = (value) => (Math.abs(value) < 0.12 ? 0 : value);
  let moving = false;
  function drive() {
    const sum = [0, 0, 0];
    for (const key of held) keys[key].forEach((part, index) => { sum[index] += part; });
    for (const pad of navigator.getGamepads ? navigator.getGamepads() : []) {
      if (!pad) continue;
      sum[0] -= stick(pad.axes[1] || 0);
      sum[1] -= stick(pad.axes[0] || 0);
      sum[2] -= stick(pad.axes[2] || 0);
    }
    const top = Number(find('top').value);
    const turn = 2.5 * top;
    const twist = [sum[0] * top, sum[1] * top, sum[2] * turn];
    const moves = twist.some((part) => part !== 0);
    if (moves || moving) tell({ twist });
    moving = moves;
  }
  setInterval(drive, 100);

  const write = () => {
    find('friction_value').textContent = Number(find('friction').value).toFixed(2);
    find('top_value').textContent = `${Number(find('top').value).toFixed(2)} m/s`;
  };
  find('friction').value = settings.friction;
  find('friction').addEventListener('input', () => {
    write();
    tell({ friction: Number(find('friction').value) });
  });
  find('top').addEventListener('input', write);
  find('mode').addEventListener('change', () => tell({ mode: find('mode').value }));
  find('priority').addEventListener('change', () => tell({ priority: find('priority').value }));
  find('speed').addEventListener('change', () => tell({ speed: Number(find('speed').value) }));
  find('reset').addEventListener('click', () => tell({ reset: true }));
  find('pause').addEventListener('click', () => {
    const paused = find('pause').textContent === 'Pause';
    find('pause').textContent = paused ? 'Go on' : 'Pause';
    tell({ paused });
  });
  if (!settings.reference) {
    find('mode').closest('label').hidden = true;
    find('priority').closest('label').hidden = true;
  }
  write();
  connect();
})();
