// Draws all runs of a study as parallel coordinates. Drag along an axis to keep the runs that pass there, click it to let go.
(function () {
  'use strict';
  const canvas = document.getElementById('parallel');
  const source = document.getElementById('parallel-data');
  if (!canvas || !source) return;
  const { runs, columns, colour } = JSON.parse(source.textContent);
  const words = document.getElementById('parallel-words');
  const STEPS = 4095, BOTTOM = 26, SIDE = 70, LINE = 12;
  // Where the axes begin: below the names, which stand in as many lines as it takes.
  let top = 34;
  const kept = columns.map(() => null);
  let drag = null;

  const xOf = (index, width) => SIDE + (columns.length < 2 ? 0 : index * (width - 2 * SIDE) / (columns.length - 1));
  const yOf = (step, height) => height - BOTTOM - step / STEPS * (height - top - BOTTOM);
  const value = (column, share) => {
    if (column.words.length) return column.words[Math.round(share * (column.words.length - 1))];
    const x = column.log ? column.low * Math.pow(column.high / column.low, share) : column.low + share * (column.high - column.low);
    return String(Number(x.toPrecision(3)));
  };
  // The middle and the line of each name, so that none runs into another or out of the picture.
  const places = (paint, width) => {
    const ends = [];
    return columns.map((column, index) => {
      const half = Math.min(paint.measureText(column.name).width, width) / 2;
      const x = Math.max(half, Math.min(width - half, xOf(index, width)));
      let line = ends.findIndex((end) => end + 8 < x - half);
      if (line < 0) line = ends.push(0) - 1;
      ends[line] = x + half;
      return { x, line };
    });
  };
  const passes = (run) => kept.every((range, index) => {
    const at = columns[index].at[run];
    return !range || (at >= range[0] && at <= range[1]);
  });

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const paint = canvas.getContext('2d');
    paint.scale(ratio, ratio);
    const style = getComputedStyle(document.documentElement);
    const tone = (name) => style.getPropertyValue('--' + name).trim();
    const by = columns[Math.min(colour, columns.length - 1)];
    paint.font = '11px system-ui, sans-serif';
    const names = places(paint, width);
    top = 22 + LINE * Math.max(...names.map(({ line }) => line + 1));
    let count = 0;
    for (const shown of [false, true]) {
      paint.globalAlpha = shown ? Math.max(0.06, Math.min(0.8, 40 / runs.length)) : 0.05;
      for (let run = 0; run < runs.length; run += 1) {
        if (passes(run) !== shown) continue;
        if (shown) count += 1;
        paint.strokeStyle = !shown ? tone('muted') : by.at[run] > 0.75 * STEPS ? tone('limit') : by.at[run] > 0.4 * STEPS ? tone('ideal') : tone('real');
        paint.beginPath();
        let pen = false;
        columns.forEach((column, index) => {
          if (column.at[run] < 0) { pen = false; return; }
          const x = xOf(index, width), y = yOf(column.at[run], height);
          if (pen) paint.lineTo(x, y); else paint.moveTo(x, y);
          pen = true;
        });
        paint.stroke();
      }
    }
    paint.globalAlpha = 1;
    paint.textAlign = 'center';
    columns.forEach((column, index) => {
      const x = xOf(index, width);
      paint.strokeStyle = tone('fg');
      paint.fillStyle = tone('fg');
      paint.beginPath();
      paint.moveTo(x, top);
      paint.lineTo(x, height - BOTTOM);
      paint.stroke();
      const name = names[index];
      // The last line stands right above the values.
      paint.fillText(column.name, name.x, top - LINE * (name.line + 1) - 4, width);
      paint.fillStyle = tone('muted');
      paint.fillText(value(column, 1), x, top - 2);
      paint.fillText(value(column, 0), x, height - BOTTOM + 14);
      if (kept[index]) {
        paint.fillStyle = tone('accent');
        paint.globalAlpha = 0.3;
        const upper = yOf(kept[index][1], height);
        paint.fillRect(x - 8, upper, 16, yOf(kept[index][0], height) - upper);
        paint.globalAlpha = 1;
      }
    });
    words.textContent = count === runs.length
      ? 'Colour: ' + by.name + ', from least (blue) to largest (orange).'
      : count + ' of ' + runs.length + ' runs' + (count && count <= 12 ? ': ' + runs.filter((_, run) => passes(run)).join(', ') : '');
  }

  const stepAt = (event) => {
    const box = canvas.getBoundingClientRect();
    const share = (box.height - BOTTOM - (event.clientY - box.top)) / (box.height - top - BOTTOM);
    return Math.max(0, Math.min(1, share)) * STEPS;
  };
  canvas.addEventListener('pointerdown', (event) => {
    const box = canvas.getBoundingClientRect();
    const near = columns.map((_, index) => Math.abs(xOf(index, box.width) - (event.clientX - box.left)));
    const index = near.indexOf(Math.min(...near));
    if (near[index] > 40) return;
    drag = { index, from: stepAt(event) };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!drag) return;
    const to = stepAt(event);
    kept[drag.index] = [Math.min(drag.from, to), Math.max(drag.from, to)];
    draw();
  });
  canvas.addEventListener('pointerup', (event) => {
    if (drag && Math.abs(stepAt(event) - drag.from) < 0.01 * STEPS) kept[drag.index] = null;
    drag = null;
    draw();
  });
  new ResizeObserver(draw).observe(canvas);
  new MutationObserver(draw).observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
})();
