// Runs in the page of a test, beside the scene, and writes its results as JSON for the test to
// judge.
(async function () {
  'use strict';
  const found = {};
  const data = JSON.parse(document.getElementById('data').textContent);
  const canvas = document.querySelector('canvas');
  const scene = ilonScene(canvas, data);
  const picture = () => new Promise((done) => setTimeout(done, 100));
  // The pixels of the current picture, row by row from below.
  const pixels = () => {
    scene.draw();
    const gl = canvas.getContext('webgl2');
    const bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  };
  const different = (a, b) => {
    let count = 0;
    for (let k = 0; k < a.length; k += 4) {
      if (Math.abs(a[k] - b[k]) + Math.abs(a[k + 1] - b[k + 1]) + Math.abs(a[k + 2] - b[k + 2]) > 24) count++;
    }
    return count / (a.length / 4);
  };
  // The share of a rectangle, given in parts of the canvas, in which no channel is near the
  // floor's.
  const covered = (bytes, left, low, right, high) => {
    const floor = [227, 231, 235];
    let [count, all] = [0, 0];
    for (let y = Math.floor(low * canvas.height); y < high * canvas.height; y++) {
      for (let x = Math.floor(left * canvas.width); x < right * canvas.width; x++) {
        const k = 4 * (y * canvas.width + x);
        count += Math.hypot(bytes[k] - floor[0], bytes[k + 1] - floor[1], bytes[k + 2] - floor[2]) > 90;
        all++;
      }
    }
    return count / all;
  };
  const key = (name) => canvas.dispatchEvent(new KeyboardEvent('keydown', { key: name, bubbles: true, cancelable: true }));
  const pointer = (kind, x, y, more) => canvas.dispatchEvent(
    new PointerEvent(kind, { clientX: x, clientY: y, pointerId: 1, button: 0, buttons: 1, bubbles: true, ...more }));

  try {
    found.supported = scene.supported;
    const start = pixels();
    found.middle_covered = covered(start, 0.45, 0.45, 0.55, 0.55);
    found.corner_covered = covered(start, 0, 0, 0.08, 0.08);
    scene.seek(0.5 * (scene.start + scene.end));
    const half = pixels();
    found.changed_by_time = different(start, half);
    found.followed = covered(half, 0.45, 0.45, 0.55, 0.55);
    found.same_time_same_picture = different(half, pixels());
    found.time = scene.state.t;
    scene.seek(1e9);
    scene.draw();
    found.end = [scene.state.t, scene.end];
    scene.seek(NaN);
    found.touching = scene.state.wheels.filter((wheel) => wheel.touching).length;
    found.load_n = scene.state.wheels.reduce((sum, wheel) => sum + wheel.normal, 0);
    // At a contact, the drawn roller's surface reaches the ground.
    found.highest_contact_m = Math.max(...scene.state.wheels.map((wheel) => Math.abs(wheel.at[2])));

    // One frame for each change, and none without.
    let drawn = 0;
    scene.on('draw', () => drawn++);
    await picture();
    drawn = 0;
    for (let k = 0; k < 4; k++) await picture();
    found.drawn_idle = drawn;
    for (let k = 0; k < 10; k++) scene.seek(0.1 * k);
    await picture();
    found.drawn_for_ten_seeks = drawn;

    // A wheel is picked at its place in the picture, by its key, and by its index.
    const picked = [];
    const selected = [];
    scene.on('pick', ({ wheel }) => picked.push(wheel)).on('select', (wheel) => selected.push(wheel));
    const before = pixels();
    key('2');
    found.closeup_changes = different(before, pixels());
    found.note = document.querySelector('.ilon-scene-note').textContent;
    found.note_hidden = document.querySelector('.ilon-scene-note').hidden;
    key('Escape');
    scene.draw();
    found.back = different(before, pixels());
    found.note_hidden_again = document.querySelector('.ilon-scene-note').hidden;
    const box = canvas.getBoundingClientRect();
    for (let y = 5; y < box.height && !picked.some((wheel) => wheel !== null); y += 8) {
      for (let x = 5; x < box.width && !picked.some((wheel) => wheel !== null); x += 8) {
        pointer('pointerdown', box.left + x, box.top + y);
        pointer('pointerup', box.left + x, box.top + y);
      }
    }
    found.picked = picked.filter((wheel) => wheel !== null);
    scene.draw();
    found.selected = selected.slice();
    scene.select(99);
    found.selected_nonsense = scene.options.selected;
    scene.select(null);

    // Rotated, moved, zoomed: each gives another picture; Home gives the first one again.
    scene.seek(scene.start);
    scene.view('follow');
    await new Promise((done) => setTimeout(done, 400));
    const home = pixels();
    key('ArrowLeft');
    found.turned = different(home, pixels());
    key('+');
    found.nearer = covered(pixels(), 0.3, 0.3, 0.7, 0.7) - covered(home, 0.3, 0.3, 0.7, 0.7);
    pointer('pointerdown', box.left + 100, box.top + 100);
    pointer('pointermove', box.left + 160, box.top + 100, { shiftKey: true });
    pointer('pointerup', box.left + 160, box.top + 100);
    key('Home');
    await new Promise((done) => setTimeout(done, 400));
    found.home = different(home, pixels());
    scene.view('whole');
    await new Promise((done) => setTimeout(done, 400));
    found.whole = different(home, pixels());
    scene.view('top');
    await new Promise((done) => setTimeout(done, 400));
    found.top = different(home, pixels());
    scene.view('follow');
    await new Promise((done) => setTimeout(done, 400));

    // Another theme, another size.
    document.documentElement.dataset.theme = 'dark';
    await picture();
    found.dark = different(home, pixels());
    delete document.documentElement.dataset.theme;
    await picture();
    found.light_again = different(home, pixels());
    const { width } = canvas.parentElement.style;
    canvas.parentElement.style.width = '300px';
    scene.draw();
    found.width = [canvas.width, canvas.clientWidth];
    canvas.parentElement.style.width = width;
    scene.draw();

    // A restored context shows the same picture.
    const lose = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    lose.loseContext();
    await new Promise((done) => setTimeout(done, 50));
    scene.seek(0.3);
    scene.draw();
    lose.restoreContext();
    await new Promise((done) => setTimeout(done, 300));
    scene.seek(scene.start);
    found.restored = different(home, pixels());

    // Frames pushed while it runs: no more are kept than requested, and invalid ones are refused.
    const stage = document.createElement('div');
    stage.style.cssText = 'position:relative;width:300px;height:200px';
    stage.append(document.createElement('canvas'));
    document.body.append(stage);
    const names = data.frames.columns.map(({ name }) => name);
    const empty = { count: 0, columns: data.frames.columns.map(({ name, kind }) => ({ name, kind })) };
    const live = ilonScene(stage.firstChild, { ...data, frames: empty }, { kept: 100 });
    live.draw();
    found.live_before = live.state.wheels.filter((wheel) => wheel.touching).length;
    for (let k = 0; k < 1000; k++) {
      const frame = new Float32Array(names.length);
      frame[0] = k / 100;
      frame[1] = k / 1000;
      live.push(k % 2 ? frame : frame.buffer);
    }
    live.draw();
    found.live = [live.start, live.end, live.state.at[0]];
    const again = new Float32Array(names.length);
    again.set([9.99, 7]);
    live.push(again);
    live.draw();
    found.live_replaced = [live.start, live.state.at[0]];
    again.set([0.5, 3]);
    live.push(again);
    found.live_begun_again = [live.start, live.end];
    try { live.push(again.fill(NaN)); } catch (error) { found.timeless = error.message; }
    try { live.push([1, 2, 3]); } catch (error) { found.refused = error.message; }
    live.dispose();
    live.dispose();
    found.left_after_dispose = stage.querySelectorAll('.ilon-scene-note').length;

    // Without WebGL 2 a sentence is shown, and every call still works.
    const poor = document.createElement('canvas');
    poor.getContext = () => null;
    stage.replaceChildren(poor);
    const none = ilonScene(poor, data);
    none.seek(1); none.select(0); none.view('top'); none.draw(); none.recolor(); none.set({ ghost: false });
    found.without_webgl = [none.supported, stage.textContent.trim()];
  } catch (error) {
    found.error = `${error.message} ${error.stack}`;
  }
  const out = document.createElement('pre');
  out.id = 'found';
  out.textContent = `FOUND${JSON.stringify(found)}END`;
  document.body.append(out);
}());
