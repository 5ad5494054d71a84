// The scene for a page: `ilonScene(canvas, data, options)`. The time belongs to the page, which
// calls `seek`.

const COLORS = {
  sky: '#eef1f4', floor: '#e3e7eb', line: '#b3bec8', chassis: '#5b6b7a', hub: '#c3c8cd', roller: '#2d3238', touching: '#009e73',
  grip: '#009e73', sliding: '#d55e00', slip: '#cc2f7a', ghost: '#d98f00', path: '#0072b2', reference: '#5d6875',
  accent: '#0072b2', box: '#a9a094', wet: '#56a7e0', rough: '#a2845e', shade: '#00000038',
};

// Colours from the style sheet (`--scene-sky`), as three or four numbers from 0 to 1.
function readColors(canvas) {
  const pen = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const styles = getComputedStyle(canvas);
  const read = (name) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = COLORS[name];
    pen.fillStyle = styles.getPropertyValue(`--scene-${name}`).trim() || COLORS[name];
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = pen.getImageData(0, 0, 1, 1).data;
    return a < 255 ? [r / 255, g / 255, b / 255, a / 255] : [r / 255, g / 255, b / 255];
  };
  return Object.fromEntries(Object.keys(COLORS).map((name) => [name, read(name)]));
}

function element(canvas, kind, text) {
  const made = document.createElement('p');
  made.className = kind;
  made.textContent = text || '';
  made.hidden = !text;
  canvas.after(made);
  return made;
}

function ilonScene(canvas, data, given) {
  const options = {
    ghost: true, way: null, wanted: true, follow: true, selected: null, kept: 36000, inset: true, antialias: undefined,
    label: 'The robot in three dimensions',
    ...given,
  };
  const heard = { pick: [], select: [], draw: [], view: [] };
  const tell = (name, ...what) => heard[name].forEach((listener) => listener(...what));
  const context = (more) => canvas.getContext('webgl2', { antialias: true, alpha: false, stencil: true, ...more });
  // With software rendering, antialiasing would take half of the time, and high resolution three
  // quarters.
  const quick = context({ antialias: options.antialias !== false, failIfMajorPerformanceCaveat: true });
  const gl = quick || context({ antialias: options.antialias === true });
  const frames = new Frames(data.frames, options.kept);
  const note = element(canvas, 'ilon-scene-note');
  note.append(document.createElement('span'));
  let cleaned = [() => note.remove()];
  canvas.classList.add('ilon-scene');
  canvas.tabIndex = canvas.tabIndex < 0 ? 0 : canvas.tabIndex;
  canvas.setAttribute('role', 'img');
  if (!canvas.hasAttribute('aria-label')) canvas.setAttribute('aria-label', options.label);
  if (!gl) {
    const said = element(canvas, 'ilon-scene-missing',
      'This browser shows no WebGL 2, so the robot is not drawn in three dimensions. All figures are below.');
    cleaned.push(() => said.remove());
    canvas.hidden = true;
  }

  const model = new Model(data);
  const reach = data.robot.reach_m;
  // The floor falls towards +x by the slope: gravity is vertical in the picture, and the floor is
  // tilted.
  const [level, fromLevel] = [1, -1].map((sign) => fromAngles(0, 0, 0, 0, sign * data.ground.slope_rad, 0));
  const camera = new Camera(-0.9, 0.5, 3.7 * reach);
  const close = new Camera(0, 0.3, 1);
  const still = window.matchMedia('(prefers-reduced-motion: reduce)');
  let renderer = null;
  let colors = readColors(canvas);
  let now = frames.start;
  let state = null;
  let moved = [0, 0, 0];
  let held = 'main';
  let glide = null;
  // The view chosen by a button, until the user turns the camera: it fits the canvas at every size.
  let fitted = 'follow';
  let waiting = 0;
  let bandsOf = -1;
  let fed = false;
  let shown = options.selected;

  function refresh() {
    if (!waiting && renderer) waiting = requestAnimationFrame(() => { waiting = 0; draw(); });
  }

  // The paths over the floor: of the body, of the reference, of the ghost.
  function makeBands() {
    bandsOf = frames.count;
    const t = frames.column('t');
    if (!t) return;
    const stand = model.robot.ride_height_m;
    const make = (name, prefix, height) => {
      const [x, y] = ['x', 'y'].map((axis) => frames.column(prefix + axis));
      if (!x) return;
      const points = [];
      const last = x.length - 1;
      // More points are not visible, and they are rebuilt while frames arrive.
      const stride = Math.ceil(x.length / 4000);
      for (let k = 0; k <= last; k = k < last ? Math.min(k + stride, last) : k + 1) {
        const old = points[points.length - 1];
        const near = old && Math.hypot(x[k] - old[0], y[k] - old[1]) < 0.004;
        if (!near || k === last) points.push([x[k], y[k], Math.max(height(k), 0), t[k]]);
      }
      renderer.mesh(name, band(points), [3, 2, 1, 1], false);
    };
    const z = frames.column('z');
    make('path', '', (k) => z[k] - stand);
    make('wanted', 'want_', () => 0);
    make('dreamt', 'ghost_', () => 0);
    (data.ways || []).forEach((way, k) => renderer.mesh(`way${k}`, band(way.poses.map(([at, x, y]) => [x, y, 0, at])), [3, 2, 1, 1], false));
    const planned = data.reference || [];
    if (planned.length) renderer.mesh('planned', band(planned.map(([x, y]) => [x, y, 0, -Infinity])), [3, 2, 1, 1], false);
  }

  function sizes() {
    const ratio = Math.min(window.devicePixelRatio || 1, quick ? 2 : 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
      if (fitted && !glide) place(look(fitted));
    }
    return { width, height, ratio };
  }

  // The close-up's rectangle from the style sheet, in the page's pixels from the canvas's upper
  // left corner.
  const insetBox = () => [note.offsetLeft - canvas.offsetLeft, note.offsetTop - canvas.offsetTop, note.offsetWidth, note.offsetHeight];

  const isClose = () => options.inset && options.selected !== null && state && state.wheels[options.selected];

  const aspect = () => canvas.clientWidth / Math.max(canvas.clientHeight, 1);

  // Beside the close-up, or above it on a narrow canvas, the robot stays centred: the shift of the
  // picture, as a part of the canvas's half.
  function shift() {
    if (!isClose()) return [0, 0];
    const [, , w, h] = insetBox();
    return canvas.clientWidth > 640 ? [-w / canvas.clientWidth, 0] : [0, h / canvas.clientHeight];
  }

  function look(mode) {
    if (mode === 'whole') {
      const [xs, ys] = ['x', 'y'].map((axis) => [axis, `want_${axis}`, `ghost_${axis}`].flatMap(
        (name) => Array.from(frames.column(name) || []).filter(Number.isFinite)));
      const [left, right, low, high] = [xs, ys].flatMap((v) => v.length
        ? [v.reduce((a, b) => Math.min(a, b)), v.reduce((a, b) => Math.max(a, b))] : [0, 0]);
      const [wide, high_m] = [(right - left) / 2 + 1.3 * reach, (high - low) / 2 + 1.3 * reach];
      // Near objects look larger: by half of the depth.
      return { yaw: -Math.PI / 2, pitch: 0.85, distance: Math.max(wide / aspect(), high_m) / Math.tan(FOV / 2) + 0.6 * high_m,
        moved: [(left + right) / 2, (low + high) / 2, 0], follow: false };
    }
    const distance = 3.9 * reach / Math.min(1, aspect());
    const [yaw, pitch] = mode === 'top' ? [-Math.PI / 2, 1.55] : [-0.9, 0.5];
    return { yaw, pitch, distance: mode === 'top' ? 1.4 * distance : distance, moved: [0, 0, 0], follow: true };
  }

  function place(to) {
    Object.assign(camera, { yaw: to.yaw, pitch: to.pitch, distance: to.distance });
    moved = to.moved;
  }

  function view(mode) {
    const to = look(mode);
    fitted = mode;
    options.follow = to.follow;
    const from = { yaw: camera.yaw, pitch: camera.pitch, distance: camera.distance, target: camera.target };
    moved = to.moved;
    const until = still.matches || !renderer ? 0 : performance.now() + 250;
    glide = (time) => {
      const left = until > time ? ((until - time) / 250) ** 2 : 0;
      const mix = (a, b) => a + (b - a) * left;
      Object.assign(camera, {
        yaw: mix(to.yaw, from.yaw), pitch: mix(to.pitch, from.pitch), distance: mix(to.distance, from.distance),
        target: camera.target.map((x, i) => mix(x, from.target[i])),
      });
      return left > 0;
    };
    refresh();
    tell('view', mode);
  }

  function describe(wheel) {
    const of = model.robot.wheels[wheel.index];
    const onTyre = of.rollers.length === 1;
    if (!wheel.touching) return `${wheel.name}: ${onTyre ? 'it does not touch' : 'no roller touches'} the ground`;
    const { tilt_rad: tilt, turned_rad: turned, ahead_m: ahead, aside_m: aside } = model.touch(wheel);
    const degrees = (rad) => `${(rad * 180 / Math.PI).toFixed(1)}°`;
    const away = Math.hypot(ahead, aside) * 1e3;
    const slide = wheel.sliding > NO_SLIDE_M_S ? `slides at ${(wheel.sliding * 1e3).toFixed(0)} mm/s` : 'no sliding';
    const surface = onTyre ? 'tyre'
      : `roller ${wheel.roller + 1} of ${of.rollers.length}: axis leans ${degrees(tilt)}, turned ${degrees(turned)} from the ideal one`;
    return `${wheel.name}, ${surface}, contact ${away.toFixed(1)} mm off the point below the hub. ${wheel.normal.toFixed(1)} N, `
      + `${(wheel.used * 100).toFixed(0)} % of the friction limit, ${slide}.`;
  }

  function draw() {
    if (!renderer || gl.isContextLost()) return;
    const { width, height, ratio } = sizes();
    // While frames arrive, the last few are under the robot.
    if (bandsOf < 0 || frames.count < bandsOf || frames.count > bandsOf + (fed ? 6 : 0)) makeBands();
    frames.seek(now);
    state = model.state(frames);
    const here = Number.isFinite(state.at[0]) ? [state.at[0], state.at[1], 0.3 * reach] : [0, 0, 0];
    camera.target = apply(level, options.follow ? add(here, moved) : moved);
    const gliding = glide && glide(performance.now());
    if (!gliding) glide = null;

    const inset = isClose();
    note.hidden = !inset;
    const floorColor = model.floorColor(now, colors);
    const line = colors.line.map((c, i) => clamp(c + floorColor[i] - colors.floor[i], 0, 1));
    const scene = { colors: { ...colors, line }, now, relief: model.relief, floorColor };
    const picture = (eyes, box, layers, bands, cells) => {
      renderer.picture({
        box, clip: eyes.matrix(box[2] / box[3], level, eyes === camera ? shift() : [0, 0]), eye: apply(fromLevel, eyes.axes().eye),
        middle: apply(fromLevel, eyes.target), reach: 22 * eyes.distance, cells, bands,
      }, { ...scene, layers });
    };
    const ribbon = (name, color, w, later, opacity) => ({ name, color: [...color, opacity], width: w * model.unit, later });
    const bands = [
      ribbon('planned', colors.reference, 0.05, 1, 0.5), ribbon('wanted', colors.reference, 0.07, 1, 0.75),
      ...(options.ghost ? [ribbon(options.way === null ? 'dreamt' : `way${options.way}`, colors.ghost, 0.06, 0.12, 0.8)] : []), ribbon('path', colors.path, 0.09, 0.15, 0.95),
    ];
    picture(camera, [0, 0, width, height], model.bodies(frames, state, colors, options), bands, [0.1, 1]);

    if (inset) {
      const [x, y, w, h] = insetBox();
      const box = [x, canvas.clientHeight - y - h, w, h].map((side) => Math.round(side * ratio));
      const wheel = state.wheels[options.selected];
      close.target = apply(level, [wheel.center[0], wheel.center[1], wheel.center[2] - 0.4 * model.unit]);
      // From outside and across the roller's axis, so that its tilt is visible; the user's own
      // rotation is added.
      const { rolling } = model.touch(wheel);
      const from = sub(wheel.center, state.at);
      const side = rolling[0] * from[0] + rolling[1] * from[1] < 0 ? -1 : 1;
      const own = { ...close };
      close.yaw += Math.atan2(side * rolling[1], side * rolling[0]);
      close.distance *= 5.6 * model.unit / Math.min(1, w / h);
      picture(close, box, model.bodies(frames, state, colors, { ...options, alone: wheel.index }), [], [0.01, 0.1]);
      Object.assign(close, { yaw: own.yaw, distance: own.distance });
      note.firstChild.textContent = describe(wheel);
    }
    if (shown !== options.selected) { shown = options.selected; tell('select', shown); }
    tell('draw', state);
    if (gliding) refresh();
  }

  // The ray through a place of the canvas.
  function rayAt(x, y) {
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    const [right, up] = shift();
    return camera.ray(2 * x / w - 1 - right, 1 - 2 * y / h - up, w / h);
  }

  // The wheel that a ray hits first, as spheres; null if it hits none.
  function pickAt(x, y) {
    if (!state) return null;
    const { eye, way } = rayAt(x, y);
    const met = state.wheels.map(({ center }, index) => {
      const to = sub(apply(level, center), eye);
      const ahead = dot(to, way);
      return { index, ahead, off: norm(sub(to, times(way, ahead))) };
    }).filter(({ index, ahead, off }) => ahead > 0 && off < model.robot.wheels[index].radius_m);
    return met.sort((a, b) => a.ahead - b.ahead)[0]?.index ?? null;
  }

  function free() {
    if (held === 'main') { glide = null; fitted = null; }
  }

  const eyes = () => (held === 'close' ? close : camera);
  const act = {
    grab(x, y) {
      const [left, top, w, h] = insetBox();
      held = isClose() && x >= left && x <= left + w && y >= top && y <= top + h ? 'close' : 'main';
    },
    orbit(dx, dy) { free(); eyes().orbit(dx * 0.008, dy * 0.008); refresh(); },
    zoom(factor) {
      free();
      if (held === 'close') close.zoom(factor, 0.3, 3);
      else camera.zoom(factor, 0.4 * reach, 400 * reach);
      refresh();
    },
    pan(dx, dy) {
      if (held === 'close') return;
      free();
      const { right } = camera.axes();
      const perPixel = 2 * camera.distance * Math.tan(FOV / 2) / Math.max(canvas.clientHeight, 1);
      const ahead = [-right[1], right[0], 0];
      moved = add(moved, add(times(right, -dx * perPixel), times(ahead, dy * perPixel)));
      refresh();
    },
    click(x, y) {
      if (held === 'close') return;
      const wheel = pickAt(x, y);
      tell('pick', { wheel, name: wheel === null ? null : model.robot.wheels[wheel].name });
      if (!options.keepSelection) scene.select(wheel === options.selected ? null : wheel);
    },
    // Whether a key has a function here.
    key(key, shift) {
      held = 'main';
      const step = { ArrowLeft: [-24, 0], ArrowRight: [24, 0], ArrowUp: [0, -24], ArrowDown: [0, 24] }[key];
      if (step) act[shift ? 'pan' : 'orbit'](...step);
      else if (key === '+' || key === '=') act.zoom(0.85);
      else if (key === '-') act.zoom(1 / 0.85);
      else if (key === 'Home' || key === 'f') view('follow');
      else if (key === 'w') view('whole');
      else if (key === 't') view('top');
      else if (key === 'g') scene.set({ ghost: !options.ghost });
      else if (key === 'Escape') scene.select(null);
      else if (/^[1-9]$/.test(key) && model.robot.wheels[key - 1]) scene.select(key - 1);
      else return false;
      return true;
    },
  };

  const scene = {
    /// Shows a time of the run, in seconds.
    seek(t) { if (t === t && t !== now) { now = t; refresh(); } },
    /// Selects a wheel by its index, and shows it close up; null for none.
    select(wheel) { options.selected = model.robot.wheels[wheel] ? wheel : null; refresh(); },
    /// Changes options: push (the point that a push's arrow points at, or null), ghost, way (the
    /// index of the ghost's alternative motion, or null), wanted, follow, inset.
    set(changed) { Object.assign(options, changed); refresh(); },
    /// The robot from the side ('follow'), the whole run ('whole'), from above ('top').
    view,
    /// Calls a listener: 'pick' ({wheel, name}), 'select' (wheel), 'draw' (state), 'view' (mode).
    on(name, listener) {
      if (!heard[name]) throw new Error(`there is no event ${name}, but ${Object.keys(heard).join(', ')}`);
      heard[name].push(listener);
      return scene;
    },
    /// Adds a frame and shows it: its values in the order of `data.frames.columns`, as an array, Float32Array or its bytes.
    push(frame) {
      fed = true;
      frames.push(frame instanceof ArrayBuffer ? new Float32Array(frame) : frame);
      now = frames.end;
      refresh();
    },
    /// Draws at once. The canvas can be read or copied until the page continues.
    draw,
    /// Reads the colours again, after a change of the page's theme.
    recolor() { colors = readColors(canvas); refresh(); },
    /// Ends the scene and releases its resources.
    dispose() {
      cleaned.forEach((clean) => clean());
      cleaned = [];
      cancelAnimationFrame(waiting);
      if (renderer) renderer.dispose();
      renderer = null;
    },
    /// The ray through a place of the canvas; the floor's frame, which leans by the slope.
    rayAt, fromLevel,
    /// The last drawn state: time, body, wheels with contact, force and slip.
    get state() { return state; },
    get options() { return { ...options }; },
    get start() { return frames.start; },
    get end() { return frames.end; },
    get supported() { return Boolean(gl); },
  };
  if (!gl) return scene;

  function start() {
    renderer = new Renderer(gl);
    model.load(renderer);
    bandsOf = -1;
    refresh();
  }
  const listen = (target, name, listener) => {
    target.addEventListener(name, listener);
    cleaned.push(() => target.removeEventListener(name, listener));
  };
  listen(canvas, 'webglcontextlost', (event) => { event.preventDefault(); renderer = null; });
  listen(canvas, 'webglcontextrestored', start);
  listen(window.matchMedia('(prefers-color-scheme: dark)'), 'change', scene.recolor);
  const themes = new MutationObserver(scene.recolor);
  themes.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme', 'class'] });
  // At once: a stretched picture would be visible for a moment.
  const resized = new ResizeObserver(() => draw());
  resized.observe(canvas);
  cleaned.push(() => themes.disconnect(), () => resized.disconnect(), controls(canvas, act));
  place(look('follow'));
  start();
  return scene;
}

window.ilonScene = ilonScene;
