// What a figure looks like: axes, curves, areas, bars and their words, on its canvas.

class Drawing extends Frame {
  draw() {
    this.prepare();
    const width = this.stage.clientWidth;
    if (!width) return;
    const rows = this.spec.y.names;
    const height = 'printing' in root.dataset ? Math.round(Math.max(0.5 * this.height, rows ? 50 + 26 * rows.length : 0)) : this.height;
    const ratio = Math.max(1, window.devicePixelRatio || 1);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.canvas.style.height = height + 'px';
    const pen = this.pen = this.canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = `11.5px ${getComputedStyle(document.body).fontFamily}`;

    let [x, y] = this.spans();
    if (this.window()) x = this.window();
    if (this.zoom && this.zoom.y) y = this.zoom.y;
    const bare = this.spec.bare;
    const top = bare ? 6 : this.spec.y.title ? 22 : 8;
    const bottom = height - (bare ? 6 : 38);
    // Equal axes show more of y than its data span; the labels take some of the width.
    const LABELS = 40;
    if (this.spec.equal && !bare) y = this.equalise(x, y, width - 22 - LABELS, bottom - top)[1];
    const yTicks = rows || bare ? null : ticks(...y, (bottom - top) / 42);
    const labelWidth = yTicks ? Math.max(...yTicks.values.map((v) => pen.measureText(yTicks.show(v)).width), 12) : 0;
    const [left, right] = [bare || rows ? 8 : labelWidth + 10, width - 12];
    if (this.spec.equal) [x, y] = this.equalise(x, y, right - left, bottom - top);
    if (rows) y = [rows.length - 0.5, -0.5];
    const scale = ([from, to], a, b) => (value) => a + (b - a) * (value - from) / (to - from);
    const [toX, toY] = [scale(x, left, right), scale(y, bottom, top)];
    this.view = { left, right, top, bottom, x, y, toX, toY };

    if (!bare) this.drawAxes(yTicks);
    pen.save();
    pen.beginPath();
    pen.rect(left, top - 3, right - left, bottom - top + 6);
    pen.clip();
    if (this.overTime) this.drawSpans();
    let bar = 0;
    const bars = this.curves.filter((c) => c.kind === 'bars' && !c.hidden);
    this.piled = rows ? rows.map(() => [0, 0]) : null;
    for (const curve of this.curves) {
      if (curve.hidden) continue;
      pen.globalAlpha = curve.opacity || 1;
      pen.strokeStyle = pen.fillStyle = color(curve.color);
      pen.lineWidth = curve.width;
      pen.setLineDash(DASHES[curve.dash] || []);
      if (curve.kind === 'area') this.drawArea(curve);
      else if (curve.kind === 'bars') this.drawBars(curve, bar++, bars.length);
      else {
        if (curve.kind !== 'dots') this.drawLine(curve);
        pen.setLineDash([]);
        if (curve.size) this.drawDots(curve);
      }
      if (curve.labels) this.drawLabels(curve);
    }
    pen.restore();
    pen.globalAlpha = 1;
    pen.setLineDash([]);
    if (rows) this.drawNames(rows);
    if (this.beyond) this.drawBeyond();
    if (!this.drawn) {
      this.drawn = true;
      this.div.dataset.drawn = '';
      this.div.style.minHeight = '';
    }
    this.seek(window.ilonClock ? window.ilonClock.now : null);
  }

  equalise([left, right], [low, high], width, height) {
    const metres = Math.max((right - left) / width, (high - low) / height, 1e-12);
    const [cx, cy] = [(left + right) / 2, (low + high) / 2];
    const [hx, hy] = [metres * width / 2, metres * height / 2];
    return [[cx - hx, cx + hx], [cy - hy, cy + hy]];
  }

  drawAxes(yTicks) {
    const { pen, view: { left, right, top, bottom, x, y, toX, toY }, spec } = this;
    const xTicks = ticks(...x, (right - left) / 74);
    pen.lineWidth = 1;
    pen.strokeStyle = color('grid');
    pen.fillStyle = color('muted');
    pen.beginPath();
    for (const value of xTicks.values) { const at = Math.round(toX(value)) + 0.5; pen.moveTo(at, top); pen.lineTo(at, bottom); }
    if (yTicks) for (const value of yTicks.values) { const at = Math.round(toY(value)) + 0.5; pen.moveTo(left, at); pen.lineTo(right, at); }
    pen.stroke();
    pen.strokeStyle = color('rule');
    pen.beginPath();
    if (y[0] < 0 && y[1] > 0) { const at = Math.round(toY(0)) + 0.5; pen.moveTo(left, at); pen.lineTo(right, at); }
    if (spec.y.names && x[0] <= 0 && x[1] >= 0) { const at = Math.round(toX(0)) + 0.5; pen.moveTo(at, top); pen.lineTo(at, bottom); }
    pen.moveTo(left, bottom + 0.5);
    pen.lineTo(right, bottom + 0.5);
    pen.stroke();
    pen.textBaseline = 'top';
    pen.textAlign = 'center';
    for (const value of xTicks.values) pen.fillText(xTicks.show(value), Math.min(toX(value), right - 4), bottom + 5);
    pen.textAlign = 'right';
    pen.fillText(spec.x.title, right, bottom + 21);
    pen.textBaseline = 'middle';
    if (yTicks) for (const value of yTicks.values) pen.fillText(yTicks.show(value), left - 5, toY(value));
    pen.textAlign = 'left';
    pen.textBaseline = 'top';
    pen.fillText(spec.y.title, 2, 2);
  }

  // What the page's clock knows of times: faults and pushes, shaded.
  drawSpans() {
    const { pen, view: { top, bottom, toX } } = this;
    for (const { from, until, color: name } of (window.ilonClock ? window.ilonClock.spans : [])) {
      pen.globalAlpha = 0.11;
      pen.fillStyle = color(name);
      pen.fillRect(toX(from), top, Math.max(toX(until) - toX(from), 1.5), bottom - top);
    }
    pen.globalAlpha = 1;
  }

  drawLine({ x, y, kind }) {
    const { pen, view: { toX, toY } } = this;
    pen.lineJoin = 'round';
    pen.beginPath();
    let open = false;
    for (let k = 0; k < x.length; k++) {
      if (!Number.isFinite(y[k]) || !Number.isFinite(x[k])) { open = false; continue; }
      const [px, py] = [toX(x[k]), toY(y[k])];
      if (open && kind === 'steps') pen.lineTo(px, toY(y[k - 1]));
      if (open) pen.lineTo(px, py); else pen.moveTo(px, py);
      open = true;
    }
    pen.stroke();
  }

  drawDots({ x, y, size }) {
    const { pen, view: { toX, toY } } = this;
    pen.beginPath();
    for (let k = 0; k < x.length; k++) {
      if (!Number.isFinite(y[k]) || !Number.isFinite(x[k])) continue;
      const [px, py] = [toX(x[k]), toY(y[k])];
      pen.moveTo(px + size / 2, py);
      pen.arc(px, py, size / 2, 0, 2 * Math.PI);
    }
    pen.fill();
  }

  drawArea({ x, y, base }) {
    const { pen, view: { toX, toY } } = this;
    pen.beginPath();
    for (let k = 0; k < x.length; k++) pen.lineTo(toX(x[k]), toY(y[k]));
    for (let k = x.length - 1; k >= 0; k--) pen.lineTo(toX(x[k]), toY(base ? base[k] : 0));
    pen.closePath();
    pen.globalAlpha *= 0.72;
    pen.fill();
  }

  drawBars({ x, y }, index, count) {
    const { pen, view: { toX, toY } } = this;
    const row = Math.abs(toY(1) - toY(0));
    const room = Math.min(row - 17, 26 * (this.spec.grouped ? count : 1));
    const thick = this.spec.grouped ? room / count : room;
    for (let k = 0; k < x.length; k++) {
      if (!Number.isFinite(x[k])) continue;
      const pile = this.piled[y[k]];
      const from = this.spec.grouped ? 0 : pile[x[k] < 0 ? 0 : 1];
      if (!this.spec.grouped) pile[x[k] < 0 ? 0 : 1] += x[k];
      const above = toY(y[k]) - row / 2 + 16 + (this.spec.grouped ? index * thick : 0);
      const [a, b] = [toX(from), toX(from + x[k])];
      pen.fillRect(Math.min(a, b), above, Math.max(Math.abs(b - a), 1), Math.max(thick - 1, 2));
    }
  }

  drawNames(names) {
    const { pen, view: { left, right, toY } } = this;
    pen.fillStyle = color('fg');
    pen.textAlign = 'left';
    pen.textBaseline = 'top';
    const row = Math.abs(toY(1) - toY(0));
    names.forEach((name, k) => {
      let text = name;
      while (text.length > 4 && pen.measureText(text).width > right - left) text = text.slice(0, -2) + '…';
      pen.fillText(text, left, toY(k) - row / 2 + 1);
    });
  }

  drawLabels({ x, y, labels, below }) {
    const { pen, view: { toX, toY } } = this;
    pen.globalAlpha = 1;
    pen.textAlign = 'center';
    pen.textBaseline = below ? 'top' : 'bottom';
    labels.forEach((label, k) => { if (label) pen.fillText(label, toX(x[k]), toY(y[k]) + (below ? 6 : -6)); });
  }

  // A short peak that would flatten the rest lies beyond the axis: where, and how far.
  drawBeyond() {
    const { pen, view: { top, bottom, y, toX, left, right } } = this;
    const said = [];
    for (const [edge, sign, at] of [[y[1], 1, top], [y[0], -1, bottom]]) {
      let [where, worst] = [null, edge];
      for (const curve of this.curves) {
        if (curve.hidden || isLevel(curve)) continue;
        for (let k = 0; k < curve.x.length; k++) {
          if (sign * curve.y[k] > sign * worst) [where, worst] = [curve.x[k], curve.y[k]];
        }
      }
      if (where === null || where < this.view.x[0] || where > this.view.x[1]) continue;
      const px = Math.min(Math.max(toX(where), left + 4), right - 4);
      pen.fillStyle = color('limit');
      pen.beginPath();
      pen.moveTo(px - 5, at + 7 * sign);
      pen.lineTo(px + 5, at + 7 * sign);
      pen.lineTo(px, at);
      pen.fill();
      said.push([px, at, sign, `${readable(worst)} at ${where.toFixed(2)} s`]);
    }
    pen.fillStyle = color('fg');
    pen.textBaseline = 'middle';
    for (const [px, at, sign, text] of said) {
      const onLeft = px > (left + right) / 2;
      pen.textAlign = onLeft ? 'right' : 'left';
      pen.fillText(text, px + (onLeft ? -9 : 9), at + 6 * sign);
    }
  }
}
