// Draws the figures of a page on canvases: curves over time, maps, areas, bars. Figures over time share their zoom and, where the
// page has a clock (`window.ilonClock`), its cursor: a click seeks.
(function () {
  'use strict';
  const root = document.documentElement;
  const DASHES = { dash: [7, 4], dot: [2, 3], dashdot: [7, 3, 2, 3] };
  // Of the parts of a curve's time, so many of the highest may lie beyond the axis if they dwarf the rest.
  const PARTS = 240;
  const PARTS_BEYOND = 6;
  let colors = {};
  let zoomed = null;

  function color(name) {
    if (!(name in colors)) colors[name] = getComputedStyle(root).getPropertyValue('--' + name).trim() || name;
    return colors[name];
  }

  function column(given) {
    if (Array.isArray(given)) return Float64Array.from(given, (value) => (value === null ? NaN : value));
    const text = atob(given.u16 || given.f32);
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
    if (given.f32) return new Float32Array(bytes.buffer);
    return Float64Array.from(new Uint16Array(bytes.buffer), (value) => given.from + value * given.step);
  }

  function ticks(low, high, most) {
    const least = (high - low) / Math.max(most, 1);
    if (!(least > 0)) return { values: [low], show: String };
    const power = Math.pow(10, Math.floor(Math.log10(least)));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= least * 0.999);
    const values = [];
    for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) values.push(k * step);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const plain = decimals <= 5 && Math.max(Math.abs(low), Math.abs(high)) < 1e6;
    return { values, show: (value) => (plain ? value.toFixed(decimals) : value.toExponential(1)).replace('-', '−') };
  }

  function logTicks(low, high) {
    const decades = Math.log10(high / low);
    const steps = decades > 2.5 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 3, 5, 7];
    const values = [];
    for (let p = Math.floor(Math.log10(low)); p <= Math.log10(high); p++) {
      for (const step of steps) {
        const value = step * Math.pow(10, p);
        if (value >= low * 0.999 && value <= high * 1.001) values.push(value);
      }
    }
    return { values, show: (value) => String(Number(value.toPrecision(2))) };
  }

  // Where the last value lies that is not later; the columns of curves over time rise.
  function before(x, t) {
    let low = 0;
    let high = x.length - 1;
    if (high < 0 || t < x[0]) return -1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (x[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  // The value of a curve over time at an instant.
  function valueAt(curve, t) {
    const k = before(curve.x, t);
    if (k < 0 || t > curve.x[curve.x.length - 1] + 1e-9) return NaN;
    const next = Math.min(k + 1, curve.x.length - 1);
    const span = curve.x[next] - curve.x[k];
    if (curve.kind === 'steps' || !(span > 0)) return curve.own[k];
    return curve.own[k] + (curve.own[next] - curve.own[k]) * (t - curve.x[k]) / span;
  }

  function readable(value) {
    if (!Number.isFinite(value)) return '–';
    const size = Math.abs(value);
    const text = size >= 1000 ? value.toFixed(0) : size >= 100 ? value.toFixed(1) : size >= 1 ? value.toFixed(2)
      : size >= 0.001 || size === 0 ? value.toFixed(4) : size < 1e-6 ? '0' : value.toExponential(1);
    return text.replace('-', '−');
  }

  class Figure {
    constructor(div, spec) {
      this.div = div;
      this.spec = spec;
      this.height = Number(div.dataset.height);
      this.overTime = 'overTime' in div.dataset;
      this.panel = 'panel' in div.dataset;
      this.curves = null;
      this.zoom = null;
      this.visible = false;
      this.drawn = false;
    }

    // Decodes the data and builds what stands around the canvas, once.
    prepare() {
      if (this.curves) return;
      this.curves = this.spec.curves.map((given) => {
        const own = column(given.y);
        return { ...given, x: column(given.x), y: own, own, hidden: false };
      });
      this.stack();
      if (!this.panel) this.makeLegend();
      this.canvas = document.createElement('canvas');
      this.canvas.setAttribute('aria-hidden', 'true');
      this.stage = document.createElement('div');
      this.stage.className = 'stage';
      this.stage.append(this.canvas);
      this.div.append(this.stage);
      this.mark = document.createElement('div');
      this.mark.className = 'cursor';
      this.mark.hidden = true;
      this.tip = document.createElement('div');
      this.tip.className = 'tip';
      this.tip.hidden = true;
      this.chosen = document.createElement('div');
      this.chosen.className = 'chosen';
      this.chosen.hidden = true;
      this.stage.append(this.mark, this.chosen, this.tip);
      this.listen();
    }

    // Areas lie on top of each other: of those that are shown.
    stack() {
      let sum = null;
      for (const curve of this.curves.filter((c) => c.kind === 'area')) {
        if (curve.hidden) continue;
        curve.base = sum;
        curve.y = sum ? curve.own.map((value, k) => value + (sum[k] || 0)) : Float64Array.from(curve.own);
        sum = curve.y;
      }
    }

    makeLegend() {
      const listed = this.curves.filter((c) => !c.unlisted && c.name);
      if (listed.length < 2 && !this.overTime) return;
      const list = document.createElement('ul');
      list.className = 'legend';
      for (const curve of listed) {
        const item = document.createElement('li');
        const button = document.createElement('button');
        button.type = 'button';
        button.setAttribute('aria-pressed', 'true');
        button.title = 'Show or hide';
        const swatch = document.createElement('i');
        swatch.className = curve.kind === 'dots' ? 'dots' : curve.kind === 'area' || curve.kind === 'bars' ? 'area' : curve.dash || 'line';
        swatch.style.setProperty('--c', `var(--${curve.color})`);
        curve.value = document.createElement('b');
        button.append(swatch, curve.name, curve.value);
        button.addEventListener('click', () => {
          curve.hidden = !curve.hidden;
          button.setAttribute('aria-pressed', String(!curve.hidden));
          this.stack();
          this.draw();
        });
        item.append(button);
        list.append(item);
      }
      this.div.append(list);
    }

    // The span of the data along x and y, before any zoom.
    spans() {
      const { x: xAxis, y: yAxis } = this.spec;
      let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
      const shown = this.curves.filter((c) => !c.hidden && c.kind !== 'bars');
      const window_ = this.window();
      for (const { x } of shown) for (const value of x) { if (value < left) left = value; if (value > right) right = value; }
      const [from, to] = window_ || [left, right];
      const peaks = [];
      for (const { x, y, kind, base } of shown) {
        for (let k = 0; k < x.length; k++) {
          if (window_ && (x[k] < from || x[k] > to)) continue;
          const value = y[k];
          if (!Number.isFinite(value)) continue;
          if (value < low) low = value;
          if (value > high) high = value;
          const part = Math.floor((x[k] - from) / (to - from) * PARTS);
          if (this.overTime && part >= 0 && part <= PARTS) {
            const peak = peaks[part] || (peaks[part] = [value, value]);
            if (value < peak[0]) peak[0] = value;
            if (value > peak[1]) peak[1] = value;
          }
        }
        if (kind === 'area' && !base) { low = Math.min(low, 0); high = Math.max(high, 0); }
      }
      this.beyond = null;
      const found = peaks.filter(Boolean);
      if (this.overTime && found.length > 60 && !yAxis.range) {
        const lows = found.map((p) => p[0]).sort((a, b) => a - b);
        const highs = found.map((p) => p[1]).sort((a, b) => b - a);
        const [calmLow, calmHigh] = [lows[PARTS_BEYOND], highs[PARTS_BEYOND]];
        const calm = Math.max(calmHigh - calmLow, yAxis.least || 0);
        if (high - low > 4 * calm && calm > 0) {
          this.beyond = [low, high];
          low = Math.max(low, calmLow - 0.25 * calm);
          high = Math.min(high, calmHigh + 0.25 * calm);
        }
      }
      if (this.spec.curves.some((c) => c.kind === 'bars')) [left, right] = this.barSpan(left, right);
      const [x, y] = [[left, right], [low, high]];
      return [this.widen(x, xAxis, this.overTime), this.widen(y, yAxis, false)];
    }

    barSpan(left, right) {
      const rows = this.spec.y.names.length;
      let [low, high] = [Math.min(0, left), Math.max(0, right)];
      for (let row = 0; row < rows; row++) {
        let [plus, minus] = [0, 0];
        for (const curve of this.curves.filter((c) => c.kind === 'bars' && !c.hidden)) {
          const value = curve.x[row];
          if (!Number.isFinite(value)) continue;
          if (this.spec.grouped) { plus = Math.max(plus, value); minus = Math.min(minus, value); }
          else if (value > 0) plus += value; else minus += value;
        }
        high = Math.max(high, plus);
        low = Math.min(low, minus);
      }
      return [low, high];
    }

    widen([low, high], axis, tight) {
      if (axis.range) return axis.range;
      if (!Number.isFinite(low)) return [0, 1];
      if (axis.log) {
        const room = Math.pow(high / low, 0.08) * 1.05;
        return [low / room, high * room];
      }
      if (axis.zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
      const least = axis.least || Math.max(Math.abs(high), Math.abs(low)) * 1e-6 || 1e-9;
      if (high - low < least) {
        const missing = (least - (high - low)) / 2;
        if (axis.zero && low === 0) high = least; else [low, high] = [low - missing, high + missing];
      }
      const room = tight ? 0 : 0.05 * (high - low);
      return [axis.zero && low === 0 ? 0 : low - room, axis.zero && high === 0 ? 0 : high + room];
    }

    window() {
      if (this.overTime && zoomed) return zoomed;
      return this.zoom && this.zoom.x;
    }

    draw() {
      this.prepare();
      const width = this.stage.clientWidth;
      if (!width) return;
      const height = 'printing' in root.dataset ? Math.round(0.72 * this.height) : this.height;
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
      const rows = this.spec.y.names;
      const bare = this.spec.bare;
      const top = bare ? 6 : this.spec.y.title ? 22 : 8;
      const bottom = height - (bare ? 6 : 38);
      const yTicks = rows || bare ? null : this.spec.y.log ? logTicks(...y) : ticks(...y, (bottom - top) / 42);
      const labelWidth = yTicks ? Math.max(...yTicks.values.map((v) => pen.measureText(yTicks.show(v)).width), 12) : 0;
      const [left, right] = [bare || rows ? 8 : labelWidth + 10, width - 12];
      if (this.spec.equal) [x, y] = this.equalise(x, y, right - left, bottom - top);
      if (rows) y = [rows.length - 0.5, -0.5];
      const scale = (axis, [from, to], a, b) => (axis.log
        ? (value) => a + (b - a) * Math.log(value / from) / Math.log(to / from)
        : (value) => a + (b - a) * (value - from) / (to - from));
      const [toX, toY] = [scale(this.spec.x, x, left, right), scale(this.spec.y, y, bottom, top)];
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
      const xTicks = spec.x.log ? logTicks(...x) : ticks(...x, (right - left) / 74);
      pen.lineWidth = 1;
      pen.strokeStyle = color('grid');
      pen.fillStyle = color('muted');
      pen.beginPath();
      for (const value of xTicks.values) { const at = Math.round(toX(value)) + 0.5; pen.moveTo(at, top); pen.lineTo(at, bottom); }
      if (yTicks) for (const value of yTicks.values) { const at = Math.round(toY(value)) + 0.5; pen.moveTo(left, at); pen.lineTo(right, at); }
      pen.stroke();
      pen.strokeStyle = color('rule');
      pen.beginPath();
      if (!spec.y.log && y[0] < 0 && y[1] > 0) { const at = Math.round(toY(0)) + 0.5; pen.moveTo(left, at); pen.lineTo(right, at); }
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
          if (curve.hidden) continue;
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
      if (this.spec.y.names || this.spec.bare || this.spec.x.log || this.spec.y.log) return;
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

  const figures = Array.from(document.querySelectorAll('script[data-figure]'), (script) =>
    new Figure(document.getElementById(script.dataset.figure), JSON.parse(script.textContent)));
  const everyFigure = (act) => figures.forEach(act);

  function guarded(figure) {
    try {
      figure.draw();
      figure.stale = false;
    } catch (error) {
      const note = document.createElement('p');
      note.className = 'failed';
      note.textContent = 'This figure could not be drawn: ' + error.message;
      figure.div.replaceChildren(note);
      console.error(figure.div.id, error);
    }
  }

  const seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const figure = figures.find((f) => f.div === target);
      figure.visible = isIntersecting;
      if (isIntersecting && (!figure.drawn || figure.stale)) guarded(figure);
      else if (isIntersecting) figure.seek(window.ilonClock ? window.ilonClock.now : null);
    }
  }, { rootMargin: '300px' });
  everyFigure((figure) => seen.observe(figure.div));

  // What nobody has seen yet is drawn while the page rests, so that it is there when it is scrolled to.
  function rest(next) {
    const figure = figures.slice(next).find((f) => !f.drawn && f.div.clientWidth);
    if (!figure) return;
    guarded(figure);
    setTimeout(rest, 8, figures.indexOf(figure) + 1);
  }
  setTimeout(rest, 60, 0);
  document.addEventListener('toggle', (event) => { if (event.target.open) setTimeout(rest, 0, 0); }, true);

  let width = root.clientWidth;
  window.addEventListener('resize', () => {
    if (root.clientWidth === width) return;
    width = root.clientWidth;
    everyFigure((figure) => figure.drawn && figure.refresh());
  });
  document.addEventListener('ilon-theme', () => {
    colors = {};
    everyFigure((figure) => {
      if ('printing' in root.dataset) guarded(figure); else if (figure.drawn) figure.refresh();
    });
  });
  if (window.ilonClock) window.ilonClock.on((t) => everyFigure((figure) => figure.visible && figure.seek(t)));
  window.ilonFigures = figures;
})();
