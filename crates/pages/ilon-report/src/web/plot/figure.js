// What a figure answers to: the page's cursor, and the pointer, which seeks, chooses and reads values.

class Figure extends Drawing {
  // Moves the cursor, and says in the legend what the curves are there.
  seek(t) {
    if (!this.overTime || !this.drawn || t === null || t === undefined) return;
    const { left, right, top, bottom, toX } = this.view;
    const at = toX(t);
    this.mark.hidden = !(at >= left - 0.5 && at <= right + 0.5);
    this.mark.style.transform = `translateX(${at}px)`;
    this.mark.style.top = top + 'px';
    this.mark.style.height = bottom - top + 'px';
    for (const curve of this.curves) if (curve.value) curve.value.textContent = readable(valueAt(curve, t));
  }

  listen() {
    let from = null;
    const place = (event) => {
      const box = this.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const timeAt = (px) => {
      const { left, right, x } = this.view;
      return x[0] + (x[1] - x[0]) * Math.min(Math.max((px - left) / (right - left), 0), 1);
    };
    this.stage.addEventListener('pointerdown', (event) => {
      if (!this.view || event.button !== 0) return;
      const [px, py] = place(event);
      const clock = this.overTime && window.ilonClock;
      const near = clock && Math.abs(this.view.toX(clock.now) - px) < 7;
      from = { px, py, scrub: near || event.pointerType !== 'mouse', moved: false };
      if (event.isTrusted) this.stage.setPointerCapture(event.pointerId);
    });
    this.stage.addEventListener('pointermove', (event) => {
      if (!this.view) return;
      const [px, py] = place(event);
      if (from && Math.abs(px - from.px) + Math.abs(py - from.py) > 5) from.moved = true;
      if (from && from.moved && from.scrub && this.overTime && window.ilonClock) { window.ilonClock.seek(timeAt(px)); return; }
      if (from && from.moved && !from.scrub && !this.spec.y.names && !this.spec.bare) this.showChoice(from, px, py);
      else if (event.pointerType === 'mouse') this.showTip(px, py, timeAt(px));
    });
    this.stage.addEventListener('pointerleave', () => { this.tip.hidden = true; });
    this.stage.addEventListener('pointerup', (event) => {
      const [px, py] = place(event);
      const began = from;
      from = null;
      this.chosen.hidden = true;
      if (!began || !this.view) return;
      if (!began.moved) {
        if (this.overTime && window.ilonClock) window.ilonClock.seek(timeAt(px));
      } else if (!began.scrub) this.zoomTo(began, px, py);
    });
    this.stage.addEventListener('pointercancel', () => { from = null; this.chosen.hidden = true; });
    this.stage.addEventListener('dblclick', () => {
      this.zoom = null;
      if (this.overTime) { zoomed = null; everyFigure((f) => f.overTime && f.refresh()); } else this.draw();
    });
  }

  showChoice(from, px, py) {
    const { left, right, top, bottom } = this.view;
    const across = this.overTime;
    const [a, b] = [Math.max(Math.min(from.px, px), left), Math.min(Math.max(from.px, px), right)];
    const [c, d] = across ? [top, bottom] : [Math.max(Math.min(from.py, py), top), Math.min(Math.max(from.py, py), bottom)];
    Object.assign(this.chosen.style, { left: a + 'px', width: b - a + 'px', top: c + 'px', height: d - c + 'px' });
    this.chosen.hidden = false;
    this.tip.hidden = true;
  }

  zoomTo(from, px, py) {
    const { left, right, top, bottom, x, y } = this.view;
    if (this.spec.y.names || this.spec.bare) return;
    const part = (a, b, low, high) => [low + (high - low) * a, low + (high - low) * b];
    const share = (value, low, high) => Math.min(Math.max((value - low) / (high - low), 0), 1);
    const along = [share(from.px, left, right), share(px, left, right)].sort((a, b) => a - b);
    if (along[1] - along[0] < 0.01) return;
    const range = part(...along, ...x);
    if (this.overTime) { zoomed = range; everyFigure((f) => f.overTime && f.refresh()); return; }
    const up = [share(from.py, bottom, top), share(py, bottom, top)].sort((a, b) => a - b);
    this.zoom = { x: range, y: up[1] - up[0] < 0.02 ? null : part(...up, ...y) };
    this.draw();
  }

  showTip(px, py, t) {
    const { left, right, top, bottom, toX, toY } = this.view;
    if (px < left || px > right || py < top || py > bottom || this.spec.bare) { this.tip.hidden = true; return; }
    const lines = [];
    if (this.overTime) {
      lines.push(['', `${t.toFixed(3)} s`]);
      for (const curve of this.curves) {
        if (!curve.hidden && curve.name && !curve.unlisted) lines.push([curve.color, `${curve.name} ${readable(valueAt(curve, t))}`]);
      }
    } else if (this.spec.y.names) {
      const row = Math.round(this.spec.y.names.length * (py - top) / (bottom - top) - 0.5);
      for (const curve of this.curves) {
        const k = Array.from(curve.y).indexOf(row);
        if (k >= 0 && !curve.hidden) lines.push([curve.color, `${curve.name} ${readable(curve.x[k])}`]);
      }
    } else {
      let best = null;
      for (const curve of this.curves) {
        for (let k = 0; !curve.hidden && k < curve.x.length; k++) {
          const off = Math.hypot(toX(curve.x[k]) - px, toY(curve.y[k]) - py);
          if (off < (best ? best.off : 24)) best = { off, curve, k };
        }
      }
      if (best) lines.push([best.curve.color, `${best.curve.name}: ${readable(best.curve.x[best.k])}, ${readable(best.curve.y[best.k])}`]);
    }
    this.tip.hidden = !lines.length;
    this.tip.replaceChildren(...lines.map(([name, text]) => {
      const line = document.createElement('span');
      line.textContent = text;
      if (name) line.style.borderLeftColor = color(name);
      return line;
    }));
    const onLeft = px > (left + right) / 2;
    Object.assign(this.tip.style, { left: onLeft ? '' : px + 14 + 'px', right: onLeft ? this.stage.clientWidth - px + 14 + 'px' : '', top: top + 'px' });
  }

  // Draws now where it is seen, and else when it comes into sight.
  refresh() {
    if (this.visible || 'printing' in root.dataset) this.draw(); else this.stale = true;
  }
}
