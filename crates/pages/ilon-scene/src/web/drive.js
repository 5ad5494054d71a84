// Driving the shown robot: by keys, by two joysticks for touch or mouse, by a gamepad.
// `ilonDrive(stage, tell, options)` shows the joysticks on a stage and reports the commanded twist
// (m/s, m/s, rad/s, in the body frame): at once when it changes, ten times per second while the
// robot moves, since it stops without commands, and once more for a stop.

const KEYS = {
  w: [1, 0, 0], s: [-1, 0, 0], a: [0, 1, 0], d: [0, -1, 0], q: [0, 0, 1], e: [0, 0, -1],
  arrowup: [1, 0, 0], arrowdown: [-1, 0, 0], arrowleft: [0, 1, 0], arrowright: [0, -1, 0],
};
// Dead zone around the centre of a stick; chosen.
const MIDDLE = 0.12;
const pushed = (part) => (Math.abs(part || 0) < MIDDLE ? 0 : part);
const AGAIN_MS = 100;
// Yaw rate at full stick over speed at full stick, in rad/s per m/s; chosen.
const TURN_PER_M = 2.5;

// Whether a pressed key is meant for the focused element.
function isTaken({ target, key }) {
  if (!target || !target.matches) return false;
  if (target.matches('input[type="range"]')) return key.startsWith('Arrow');
  return target.matches('input, textarea, select, [contenteditable]') || (key === ' ' && target.matches('button, summary, a'));
}

// A joystick on the stage, with its command ahead and to the left, each from -1 to 1; a turning one
// moves only sideways.
function makeStick(stage, side, changed) {
  const stick = document.createElement('div');
  stick.className = `ilon-stick ilon-stick-${side}`;
  // Users of screen readers have the keys.
  stick.setAttribute('aria-hidden', 'true');
  const thumb = document.createElement('i');
  stick.append(thumb);
  stage.append(stick);
  const asked = [0, 0];
  let finger = null;
  const put = (ahead, left) => {
    [asked[0], asked[1]] = [ahead, left];
    changed();
  };
  const follow = (event) => {
    if (event.pointerId !== finger) return;
    const box = stick.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left - box.width / 2, side === 'turn' ? 0 : event.clientY - box.top - box.height / 2];
    const far = Math.max(Math.hypot(x, y), 0.5 * box.width);
    put(pushed(-y / far), pushed(-x / far));
  };
  const let_go = (event) => {
    if (event.pointerId !== finger) return;
    finger = null;
    put(0, 0);
  };
  stick.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    finger = event.pointerId;
    stick.setPointerCapture(finger);
    follow(event);
  });
  stick.addEventListener('pointermove', follow);
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) stick.addEventListener(end, let_go);
  return {
    asked,
    drop() { finger = null; asked.fill(0); },
    show(ahead, left) { thumb.style.transform = `translate(${-100 * clamp(left, -1, 1)}%, ${-100 * clamp(ahead, -1, 1)}%)`; },
    remove() { stick.remove(); },
  };
}

function ilonDrive(stage, tell, { top = () => 0.4 } = {}) {
  const held = new Set();
  let moving = false;
  const drive = () => {
    const [moves, turns] = sticks;
    const sum = [moves.asked[0], moves.asked[1], turns.asked[1]];
    for (const key of held) KEYS[key].forEach((part, index) => { sum[index] += part; });
    for (const pad of navigator.getGamepads ? navigator.getGamepads() : []) {
      if (!pad) continue;
      [1, 0, 2].forEach((axis, index) => { sum[index] -= pushed(pad.axes[axis]); });
    }
    const [ahead, left, turn] = sum.map((part) => clamp(part, -1, 1));
    moves.show(ahead, left);
    turns.show(0, turn);
    const most = top();
    const twist = [ahead * most, left * most, turn * TURN_PER_M * most];
    const moves_now = twist.some((part) => part !== 0);
    if (moves_now || moving) tell(twist);
    moving = moves_now;
  };
  const sticks = ['move', 'turn'].map((side) => makeStick(stage, side, () => drive()));
  const let_go = () => {
    held.clear();
    sticks.forEach((stick) => stick.drop());
    drive();
  };
  const listeners = [];
  const on = (target, name, listener) => {
    target.addEventListener(name, listener, true);
    listeners.push(() => target.removeEventListener(name, listener, true));
  };
  on(window, 'keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || isTaken(event)) return;
    const key = event.key.toLowerCase();
    if (event.key === ' ') let_go();
    else if (key in KEYS) {
      held.add(key);
      if (!event.repeat) drive();
    } else return;
    // Neither the page scrolls, nor the scene rotates.
    event.preventDefault();
    event.stopPropagation();
  });
  on(window, 'keyup', (event) => { if (held.delete(event.key.toLowerCase())) drive(); });
  on(window, 'blur', let_go);
  on(document, 'visibilitychange', () => { if (document.hidden) let_go(); });
  const again = setInterval(drive, AGAIN_MS);
  stage.classList.add('ilon-driven');
  return {
    /// Releases everything, and removes the joysticks.
    end() {
      let_go();
      clearInterval(again);
      listeners.forEach((remove) => remove());
      sticks.forEach((stick) => stick.remove());
      stage.classList.remove('ilon-driven');
    },
  };
}

// A human reads no faster; chosen.
const READ_MS = 100;

// Shows each wheel's current slip: `ilonWheels(box, scene)`. Returns a function that ends it.
function ilonWheels(box, scene) {
  const table = document.createElement('table');
  table.className = 'ilon-wheels';
  const head = table.createTHead().insertRow();
  for (const name of ['Wheel', 'Sliding', 'Grip used', 'Load']) {
    head.append(Object.assign(document.createElement('th'), { scope: 'col', textContent: name }));
  }
  const body = table.createTBody();
  box.replaceChildren(table);
  let rows = [];
  let read = -Infinity;
  let ended = false;
  const row = (wheel) => {
    const line = body.insertRow();
    line.append(Object.assign(document.createElement('th'), { scope: 'row', textContent: wheel.name }));
    const cells = [0, 1, 2].map(() => line.insertCell());
    const bar = document.createElement('meter');
    Object.assign(bar, { min: 0, max: 1, high: AT_THE_LIMIT });
    bar.setAttribute('aria-label', `Part of the friction limit that ${wheel.name} uses`);
    const used = document.createElement('span');
    cells[1].append(bar, used);
    return { line, bar, used, cells };
  };
  scene.on('draw', (state) => {
    const now = performance.now();
    if (ended || !state || now - read < READ_MS) return;
    read = now;
    if (!rows.length) rows = state.wheels.map(row);
    state.wheels.forEach((wheel, index) => {
      const { line, bar, used, cells } = rows[index];
      const slides = wheel.touching && wheel.used >= AT_THE_LIMIT;
      line.classList.toggle('sliding', slides);
      cells[0].textContent = wheel.touching ? `${(1000 * wheel.sliding).toFixed(0)} mm/s` : 'in the air';
      bar.value = wheel.used;
      used.textContent = ` ${(100 * wheel.used).toFixed(0)} %`;
      cells[2].textContent = `${Math.max(wheel.normal, 0).toFixed(1)} N`;
    });
  });
  return () => { ended = true; box.replaceChildren(); };
}

// Figures of the robot's state, with names and formats. `ilonFigures(box)` returns a function that
// shows them; an unknown value has no tile.
function ilonFigures(box) {
  // A zero has no minus sign.
  const written = (value, digits) => value.toFixed(digits).replace(/^-(?=[0.]*$)/, '');
  const twist = ([vx, vy, omega]) => `${written(vx, 2)}, ${written(vy, 2)} m/s, ${written(omega * 180 / Math.PI, 0)} deg/s`;
  const length = (m) => (m < 1 ? `${(1000 * m).toFixed(1)} mm` : `${m.toFixed(2)} m`);
  const tiles = [
    ['Time', 't_s', (t_s) => `${t_s.toFixed(1)} s`],
    ['Simulated', 'real_time_factor', (factor) => `${factor.toFixed(2)} times real time`],
    ['Commanded', 'asked', twist],
    ['Real', 'real', twist],
    ['Fastest sliding', 'slip_m_s', (m_s) => `${length(m_s)}/s`],
    ['Grip used', 'friction_used', (share) => `${(100 * share).toFixed(0)} %`],
    ['Odometry error', 'odometry_error_m', length],
    ['Distance to the reference', 'reference_error_m', length],
  ].map(([name, key, write]) => {
    const tile = document.createElement('div');
    const label = Object.assign(document.createElement('span'), { textContent: name });
    const value = document.createElement('b');
    tile.append(label, value);
    tile.hidden = true;
    box.append(tile);
    return (figures) => {
      const known = figures[key] !== null && figures[key] !== undefined;
      tile.hidden = !known;
      if (known) value.textContent = write(figures[key]);
    };
  });
  return (figures) => tiles.forEach((show) => show(figures));
}

// The point of the floor under a place of the canvas; in the sky it is far away.
function floorAt(scene, place) {
  const ray = scene.rayAt(...place);
  const [eye, way] = [apply(scene.fromLevel, ray.eye), turn(scene.fromLevel, ray.way)];
  return add(eye, times(way, eye[2] / Math.max(-way[2], 0.02)));
}

// Pushing the robot with the mouse or a finger, while `isOn()`: an arrow from the robot to the
// pointer shows the force, which grows with its length up to the robot's weight; `tell` gets the
// force along x and y of the world, in N.
function ilonPush(stage, scene, robot, tell, isOn) {
  const { weight_n: weight, reach_m: reach } = robot;
  const words = document.createElement('output');
  words.className = 'ilon-push';
  stage.append(words);
  let to = null;
  const push = () => {
    if (!to || !scene.state) return;
    const point = floorAt(scene, to);
    const way = sub(point, scene.state.at);
    const length = Math.hypot(way[0], way[1]) || 1;
    const force = weight * Math.min(1, 0.3 * length / reach);
    words.textContent = `${force.toFixed(0)} N`;
    words.style.translate = `${to[0] + 12}px ${to[1]}px`;
    scene.set({ push: point });
    tell([force * way[0] / length, force * way[1] / length]);
  };
  setInterval(push, AGAIN_MS / 2);
  const drag = (event) => {
    if (!isOn() || event.target.tagName !== 'CANVAS' || (event.type === 'pointermove' && !to)) return;
    event.stopPropagation();
    if (event.type === 'pointerdown') event.target.setPointerCapture(event.pointerId);
    to = [event.offsetX, event.offsetY];
    push();
  };
  const end = () => {
    if (!to) return;
    to = null;
    words.textContent = '';
    scene.set({ push: null });
    tell([0, 0]);
  };
  for (const name of ['pointerdown', 'pointermove']) stage.addEventListener(name, drag, true);
  for (const name of ['pointerup', 'pointercancel', 'lostpointercapture']) stage.addEventListener(name, end, true);
}

Object.assign(window, { ilonDrive, ilonWheels, ilonFigures, ilonPush });
