(function () {
  'use strict';
  const find = (id) => document.getElementById(id);
  const settings = JSON.parse(find('settings').textContent);
  const data = JSON.parse(find('data').textContent);
  const scene = ilonScene(document.querySelector('canvas'), data);
  const state = find('state');
  const note = find('note');
  let socket = null;
  let frames = 0;

  const tell = (message) => {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  };

  // A note tells of a moment: it goes again.
  const NOTE_MS = 8000;
  let noteGoes = 0;
  const say = (text) => {
    note.textContent = text;
    clearTimeout(noteGoes);
    noteGoes = setTimeout(() => { note.textContent = ''; }, NOTE_MS);
  };

  const show = ilonFigures(find('figures'));
  ilonWheels(find('wheels'), scene);

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
      if (message.figures) show(message.figures);
      if (message.note) say(message.note);
    };
    socket.onclose = () => {
      state.textContent = '(not connected)';
      setTimeout(connect, 1000);
    };
  }

  ilonDrive(document.querySelector('.stage'), (twist) => tell({ twist }), { top: () => Number(find('top').value) });
  ilonPush(document.querySelector('.stage'), scene, data.robot, (push_n) => tell({ push_n }), () => find('mouse').value === 'push');
  // Keys drive again once something is chosen.
  document.querySelectorAll('select').forEach((select) => select.addEventListener('change', () => select.blur()));

  const write = () => {
    find('friction_value').textContent = Number(find('friction').value).toFixed(2);
    find('top_value').textContent = `${Number(find('top').value).toFixed(2)} m/s`;
  };
  find('friction').value = settings.friction;
  find('friction').addEventListener('input', () => {
    write();
    tell({ friction: Number(find('friction').value) });
  });
  find('priority').value = settings.priority;
  find('top').addEventListener('input', write);
  find('mode').addEventListener('change', () => tell({ mode: find('mode').value }));
  find('priority').addEventListener('change', () => tell({ priority: find('priority').value }));
  find('speed').addEventListener('change', () => tell({ speed: Number(find('speed').value) }));
  find('reset').addEventListener('click', () => tell({ reset: true }));
  find('record').addEventListener('click', () => {
    const records = find('record').getAttribute('aria-pressed') === 'false';
    find('record').setAttribute('aria-pressed', records);
    find('record').textContent = records ? 'Stop recording' : 'Record';
    tell({ record: records });
  });
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
