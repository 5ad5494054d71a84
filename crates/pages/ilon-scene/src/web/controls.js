// Mouse, touch and keys. On a scrolling page they leave scrolling to the page: the wheel zooms only
// once the scene has the focus, and one finger moved up or down scrolls the page.

function controls(canvas, act) {
  const listeners = [];
  const on = (name, listener, options) => {
    canvas.addEventListener(name, listener, options);
    listeners.push(() => canvas.removeEventListener(name, listener, options));
  };
  const down = new Map();
  let moved = 0;

  on('pointerdown', (event) => {
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (down.size === 1) { moved = 0; act.grab(event.offsetX, event.offsetY); }
  });
  on('pointermove', (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    if (down.size > 1) {
      const other = [...down].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      act.zoom(apart(before) / apart(now));
      act.pan(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons > 1) act.pan(dx, dy);
    else if (moved > 4) act.orbit(dx, dy);
    down.set(event.pointerId, now);
  });
  on('pointerup', (event) => {
    if (down.size === 1 && moved <= 4) act.click(event.offsetX, event.offsetY);
    down.delete(event.pointerId);
  });
  on('pointercancel', (event) => down.delete(event.pointerId));
  on('contextmenu', (event) => event.preventDefault());
  on('dblclick', () => act.key('Home'));
  on('wheel', (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    act.grab(event.offsetX, event.offsetY);
    act.zoom(Math.exp(clamp(event.deltaY * (event.deltaMode ? 30 : 1), -200, 200) * 0.002));
  }, { passive: false });
  on('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (act.key(event.key, event.shiftKey)) {
      event.preventDefault();
      event.stopPropagation();
    }
  });
  return () => listeners.forEach((remove) => remove());
}
