// The page's one time: its slider, its keys and its events move the scene and the cursor of every figure. `window.ilonClock` is what
// figures listen to.
(function () {
  'use strict';
  const box = document.getElementById('run-view');
  if (!box) return;
  const data = JSON.parse(document.getElementById('clock-data').textContent);
  const find = (what) => box.querySelector(what);
  const [slider, shown, play, speed, said] = ['.time', '.now', '.play', '.speed', '.said'].map(find);
  const heard = [];
  const clock = window.ilonClock = { now: data.start, spans: data.spans, on: (listener) => heard.push(listener), seek };
  let playing = false;
  let last = 0;

  function seek(t) {
    clock.now = Math.min(Math.max(t, data.start), data.end);
    slider.value = clock.now;
    shown.textContent = clock.now.toFixed(2) + ' s';
    const now = data.events.filter((e) => e.from <= clock.now + 1e-9 && e.until >= clock.now - 1e-9);
    const text = now.slice(0, 3).map((e) => e.text).join('; ') + (now.length > 3 ? ` and ${now.length - 3} more` : '');
    said.textContent = text || '\u00a0';
    slider.setAttribute('aria-valuetext', clock.now.toFixed(2) + ' seconds' + (text ? ', ' + text : ''));
    const part = (clock.now - data.start) / Math.max(data.end - data.start, 1e-9);
    box.style.setProperty('--at', 100 * part + '%');
    heard.forEach((listener) => listener(clock.now));
  }

  function tick(stamp) {
    if (!playing) return;
    // A page in the background gets no frames; it goes on where it was.
    const passed = Math.min(stamp - last, 250) / 1000;
    last = stamp;
    seek(clock.now + passed * Number(speed.value));
    if (clock.now >= data.end) set(false); else requestAnimationFrame(tick);
  }

  function set(on) {
    playing = on;
    play.textContent = on ? 'Pause' : 'Play';
    if (!on) return;
    if (clock.now >= data.end) seek(data.start);
    last = performance.now();
    requestAnimationFrame(tick);
  }

  // The next or the last beginning or end of an event.
  function jump(ahead) {
    const times = data.events.flatMap((e) => [e.from, e.until]).concat(data.end, data.start).sort((a, b) => a - b);
    const room = 1e-6 + (playing ? 0.2 : 0);
    const next = ahead ? times.find((t) => t > clock.now + room) : times.reverse().find((t) => t < clock.now - room);
    if (next !== undefined) seek(next);
  }

  slider.min = data.start;
  slider.max = data.end;
  slider.addEventListener('input', () => { set(false); seek(Number(slider.value)); });
  play.addEventListener('click', () => set(!playing));
  // A robot alone has neither events nor a ghost.
  const on = (what, name, listener) => { const part = find(what); if (part) part.addEventListener(name, listener); };
  on('.back', 'click', () => jump(false));
  on('.next', 'click', () => jump(true));
  const step = Math.max((data.end - data.start) / 200, 0.01);
  document.addEventListener('keydown', (event) => {
    const at = event.target;
    if (event.ctrlKey || event.metaKey || event.altKey || at.closest('input:not(.time), select, textarea, summary, [contenteditable]')) return;
    if (event.key === ' ' && !at.closest('button, a')) set(!playing);
    else if (event.key === 'ArrowRight') seek(clock.now + (event.shiftKey ? 10 : 1) * step);
    else if (event.key === 'ArrowLeft') seek(clock.now - (event.shiftKey ? 10 : 1) * step);
    else if (event.key === 'n') jump(true);
    else if (event.key === 'p') jump(false);
    else return;
    event.preventDefault();
  });
  box.querySelectorAll('.lane').forEach((lane) => lane.addEventListener('click', (event) => {
    const { left, width } = lane.getBoundingClientRect();
    const from = event.target.dataset.from;
    seek(from !== undefined ? Number(from) : data.start + (data.end - data.start) * (event.clientX - left) / width);
  }));
  document.addEventListener('click', (event) => {
    const link = event.target.closest('[data-seek]');
    if (!link) return;
    event.preventDefault();
    set(false);
    seek(Number(link.dataset.seek));
    box.scrollIntoView({ block: 'nearest' });
  });

  const canvas = window.ilonScene && find('canvas');
  if (canvas) {
    const scene = window.ilonScene(canvas, JSON.parse(document.getElementById(canvas.dataset.scene).textContent), { label: canvas.getAttribute('aria-label') });
    clock.on((t) => scene.seek(t));
    // Paper cannot show a WebGL canvas once it is drawn: a picture of it stands in.
    const still = document.createElement('img');
    still.alt = canvas.getAttribute('aria-label');
    window.addEventListener('beforeprint', () => {
      scene.draw();
      still.src = canvas.toDataURL();
      canvas.after(still);
      canvas.hidden = true;
    });
    window.addEventListener('afterprint', () => { still.remove(); canvas.hidden = false; });
    box.querySelectorAll('[data-view]').forEach((b) => b.addEventListener('click', () => scene.view(b.dataset.view)));
    const ghost = find('.ghost');
    const choose = () => scene.set({ ghost: ghost.value !== 'none', way: /^[0-9]+$/.test(ghost.value) ? Number(ghost.value) : null });
    if (ghost) { ghost.addEventListener('change', choose); choose(); }
    const wheel = find('.wheel');
    if (wheel) {
      wheel.addEventListener('change', () => scene.select(wheel.value === '' ? null : Number(wheel.value)));
      scene.on('select', (index) => { wheel.value = index === null ? '' : String(index); });
    }
    window.ilonRunScene = scene;
  }
  // A moment of the run can be named in the address: #t=3.2
  const wanted = /(?:^#|&)t=([0-9.]+)/.exec(location.hash);
  seek(wanted ? Number(wanted[1]) : data.start);
})();
