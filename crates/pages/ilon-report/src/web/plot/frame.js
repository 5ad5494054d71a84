// What a figure is before anything is drawn: its curves, its legend, and the spans of its axes.

class Frame {
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
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', this.said());
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

  // The figure in words, for those who do not see it.
  said() {
    const names = this.curves.filter((c) => !c.unlisted && c.name).map((c) => c.name);
    const over = [this.spec.y.title, this.spec.x.title].filter(Boolean).join(' over ');
    return [this.div.getAttribute('aria-label'), over, names.join(', ')].filter(Boolean).join(': ');
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
}
