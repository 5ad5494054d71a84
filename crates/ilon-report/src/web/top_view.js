// Plays the run from above: chassis, wheels with their rollers, contacts, slip arrows.
(function () {
  'use strict';
  const box = document.getElementById('top-view');
  if (!box) return;
  const data = JSON.parse(document.getElementById('top-view-data').textContent);
  const canvas = box.querySelector('canvas');
  const pen = canvas.getContext('2d');
  const play = box.querySelector('.play');
  const slider = box.querySelector('input[type="range"]');
  const clock = box.querySelector('output');
  const speed = box.querySelector('select');
  const chase = box.querySelector('.chase');
  const frames = data.t.length;
  const end = frames ? data.t[frames - 1] : 0;
  let now = 0;
  let playing = false;
  let last = null;

  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();

  // The frame at a time, by bisection: the last one that is not later.
  function frameAt(t) {
    let low = 0;
    let high = frames - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (data.t[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  const reach = data.reach;
  const bounds = (function () {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [xs, ys] of [[data.x, data.y], [data.wantX, data.wantY]]) {
      for (let k = 0; k < xs.length; k++) {
        if (xs[k] === null) continue;
        left = Math.min(left, xs[k]); right = Math.max(right, xs[k]);
        low = Math.min(low, ys[k]); high = Math.max(high, ys[k]);
      }
    }
    return { left: left - 1.3 * reach, right: right + 1.3 * reach, low: low - 1.3 * reach, high: high + 1.3 * reach };
  })();

  function view(frame, width, height) {
    if (chase.checked) {
      const scale = Math.min(width, height) / (3.2 * reach);
      return { scale, x: data.x[frame], y: data.y[frame] };
    }
    const scale = Math.min(width / (bounds.right - bounds.left), height / (bounds.high - bounds.low));
    return { scale, x: (bounds.left + bounds.right) / 2, y: (bounds.low + bounds.high) / 2 };
  }

  function line(points, style, width, dash) {
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.strokeStyle = style; pen.lineWidth = width; pen.setLineDash(dash || []);
    pen.stroke(); pen.setLineDash([]);
  }

  function arrow(x, y, dx, dy, style, width) {
    const length = Math.hypot(dx, dy);
    if (length < 2) return;
    const [ux, uy] = [dx / length, dy / length];
    const head = Math.min(8, 0.4 * length);
    const [tipX, tipY] = [x + dx, y + dy];
    line([[x, y], [tipX, tipY]], style, width);
    line([
      [tipX - head * (ux - 0.6 * uy), tipY - head * (uy + 0.6 * ux)], [tipX, tipY],
      [tipX - head * (ux + 0.6 * uy), tipY - head * (uy - 0.6 * ux)],
    ], style, width);
  }

  // A round step for the floor's grid, at least 50 px apart.
  function gridStep(scale) {
    const least = 50 / scale;
    const power = Math.pow(10, Math.floor(Math.log10(least)));
    return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= least);
  }

  // One wheel from above. `at` takes the body frame to the screen.
  function wheel(at, w, angle) {
    const [ax, ay] = w.axis;
    const corner = (along, across) => at(w.x + along * ax + across * ay, w.y + along * ay - across * ax);
    const [h, r] = [w.width / 2, w.radius];
    pen.beginPath();
    [[-h, -r], [h, -r], [h, r], [-h, r]].forEach(([a, c], k) => {
      const [x, y] = corner(a, c);
      if (k) pen.lineTo(x, y); else pen.moveTo(x, y);
    });
    pen.closePath();
    pen.fillStyle = color('card'); pen.fill();
    pen.save(); pen.clip();
    // Rollers of the upper side, as seen from above: their axes lie mirrored to those that touch. Along the hub axis
    // sin gamma, across it -cos gamma, foreshortened by the turn from the top.
    const [sinGamma, cosGamma] = [Math.sin(w.gamma), Math.cos(w.gamma)];
    const half = Math.abs(sinGamma) > 0.1 ? h / Math.abs(sinGamma) : r * Math.tan(Math.PI / Math.max(w.rollers, 3));
    for (let k = 0; k < w.rollers; k++) {
      const place = angle + (2 * Math.PI * k) / w.rollers;
      if (Math.cos(place) <= 0) continue;
      const middle = r * Math.sin(place);
      const [along, across] = [half * sinGamma, -half * cosGamma * Math.cos(place)];
      line([corner(-along, middle - across), corner(along, middle + across)], color('muted'), 1.6);
    }
    pen.restore();
    pen.strokeStyle = color('fg'); pen.lineWidth = 1.3; pen.stroke();
  }

  function render() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !frames) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio);
    }
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const k = frameAt(now);
    const v = view(k, width, height);
    const screen = (x, y) => [width / 2 + (x - v.x) * v.scale, height / 2 - (y - v.y) * v.scale];

    const step = gridStep(v.scale);
    for (let x = Math.ceil((v.x - width / 2 / v.scale) / step) * step; x < v.x + width / 2 / v.scale; x += step) {
      line([[screen(x, 0)[0], 0], [screen(x, 0)[0], height]], color('grid'), 1);
    }
    for (let y = Math.ceil((v.y - height / 2 / v.scale) / step) * step; y < v.y + height / 2 / v.scale; y += step) {
      line([[0, screen(0, y)[1]], [width, screen(0, y)[1]]], color('grid'), 1);
    }

    const way = (xs, ys, to) => {
      const points = [];
      for (let i = 0; i <= to; i++) if (xs[i] !== null) points.push(screen(xs[i], ys[i]));
      return points;
    };
    if (data.wantX.length) line(way(data.wantX, data.wantY, frames - 1), color('asked'), 1.6, [6, 5]);
    line(way(data.x, data.y, k), color('real'), 2);

    const heading = data.heading[k];
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    const world = (x, y) => [data.x[k] + c * x - s * y, data.y[k] + s * x + c * y];
    const at = (x, y) => screen(...world(x, y));

    if (data.wantX.length && data.wantX[k] !== null) {
      const [x, y] = screen(data.wantX[k], data.wantY[k]);
      const h = data.wantHeading[k];
      const length = 0.6 * reach * v.scale;
      arrow(x, y, length * Math.cos(h), -length * Math.sin(h), color('asked'), 1.6);
      pen.beginPath(); pen.arc(x, y, 4, 0, 2 * Math.PI); pen.fillStyle = color('asked'); pen.fill();
    }

    for (const outline of data.outlines) {
      pen.beginPath();
      outline.forEach(([x, y], i) => { const p = at(x, y); if (i) pen.lineTo(...p); else pen.moveTo(...p); });
      pen.closePath();
      pen.globalAlpha = 0.16; pen.fillStyle = color('real'); pen.fill();
      pen.globalAlpha = 1; pen.strokeStyle = color('real'); pen.lineWidth = 1.5; pen.stroke();
    }
    data.wheels.forEach((w) => wheel(at, w, w.angle[k]));
    const nose = at(0.75 * reach, 0);
    const centre = at(0, 0);
    arrow(centre[0], centre[1], nose[0] - centre[0], nose[1] - centre[1], color('real'), 2.4);

    // A slip arrow of half the robot's reach is the largest slip of the run, but no less than 1 cm/s.
    const slipScale = 0.5 * reach * v.scale / Math.max(data.slipMax, 0.01);
    data.wheels.forEach((w) => {
      if (w.load[k] <= 0) return;
      const [x, y] = at(w.contactX[k], w.contactY[k]);
      const size = 2.5 + 3.5 * Math.sqrt(w.load[k] / Math.max(data.loadMax, 1e-9));
      pen.beginPath(); pen.arc(x, y, size, 0, 2 * Math.PI);
      pen.fillStyle = w.grip[k] >= 0.98 ? color('slip') : color('contact');
      pen.fill();
      const [sx, sy] = [c * w.slipX[k] - s * w.slipY[k], s * w.slipX[k] + c * w.slipY[k]];
      arrow(x, y, sx * slipScale, -sy * slipScale, color('slip'), 2.2);
    });

    pen.fillStyle = color('muted');
    pen.font = '12px ' + getComputedStyle(document.body).fontFamily;
    pen.textBaseline = 'bottom';
    const bar = step * v.scale;
    line([[14, height - 14], [14 + bar, height - 14]], color('muted'), 2);
    pen.fillText(step >= 1 ? step + ' m' : Math.round(step * 1000) + ' mm', 14, height - 18);
    slider.value = String(now);
    clock.value = now.toFixed(2) + ' s';
  }

  function tick(stamp) {
    if (!playing) { last = null; return; }
    if (last !== null) now += (stamp - last) / 1000 * Number(speed.value);
    last = stamp;
    if (now >= end) { now = end; setPlaying(false); }
    render();
    if (playing) requestAnimationFrame(tick);
  }

  function setPlaying(on) {
    playing = on;
    play.textContent = on ? 'Pause' : 'Play';
    if (!on) return;
    if (now >= end) now = 0;
    last = null;
    requestAnimationFrame(tick);
  }

  slider.max = String(end);
  slider.step = String(Math.max(end / 2000, 1e-4));
  play.addEventListener('click', () => setPlaying(!playing));
  slider.addEventListener('input', () => { setPlaying(false); now = Number(slider.value); render(); });
  chase.addEventListener('change', render);
  document.addEventListener('ilon-theme', render);
  new ResizeObserver(render).observe(canvas);
  now = data.poster;
  render();
})();
