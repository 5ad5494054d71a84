// Draws the figures of the report: colours by theme, one time axis for all, light for print.
(function () {
  'use strict';
  const root = document.documentElement;
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const coarse = window.matchMedia('(pointer: coarse)').matches;
  let chosen = null;
  let styles;

  const color = (name) => styles.getPropertyValue('--' + name).trim();

  function applyTheme(theme) {
    root.dataset.theme = theme;
    styles = getComputedStyle(root);
  }
  const theme = () => chosen || (dark.matches ? 'dark' : 'light');

  // A copy of a value in which each string '@name' is the theme's colour of that name. Data are left alone.
  function painted(value) {
    if (typeof value === 'string') return value[0] === '@' ? color(value.slice(1)) : value;
    if (Array.isArray(value)) return typeof value[0] === 'object' && value[0] ? value.map(painted) : value;
    if (value && typeof value === 'object') {
      const copy = {};
      for (const key of Object.keys(value)) copy[key] = painted(value[key]);
      return copy;
    }
    return value;
  }

  function themed(figure) {
    const layout = painted(figure.spec.layout);
    // On paper two figures stand side by side.
    const printing = 'printing' in root.dataset;
    const polar = figure.spec.data.some((trace) => trace.type === 'scatterpolar');
    const axis = {
      gridcolor: color('grid'), zerolinecolor: color('rule'), linecolor: color('rule'), tickcolor: color('rule'),
      automargin: true,
    };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis\d*$/.test(key)) {
        layout[key] = Object.assign({}, axis, layout[key]);
        if (layout[key].title) layout[key].title = Object.assign({ standoff: 8 }, layout[key].title);
      }
    }
    const polarAxis = { gridcolor: color('grid'), linecolor: color('rule') };
    return Object.assign({
      autosize: true,
      height: printing ? Math.round(0.72 * figure.height) : figure.height,
      // The angles of a polar figure stand outside of its circle.
      margin: polar ? { l: 44, r: 44, t: 26, b: 34 } : { l: 52, r: 14, t: 8, b: 42, pad: 2 },
      paper_bgcolor: 'rgba(0,0,0,0)',
      plot_bgcolor: 'rgba(0,0,0,0)',
      font: { family: getComputedStyle(document.body).fontFamily, size: printing ? 9 : 12, color: color('muted') },
      legend: { orientation: 'h', x: 0, y: 1.02, yanchor: 'bottom', font: { color: color('fg') } },
      showlegend: !figure.panel,
      hovermode: figure.overTime ? 'x unified' : 'closest',
      hoverlabel: { bgcolor: color('card'), bordercolor: color('rule'), font: { color: color('fg') } },
      dragmode: coarse ? false : 'zoom',
      polar: {
        bgcolor: 'rgba(0,0,0,0)',
        radialaxis: Object.assign({ angle: 90, tickangle: 90, rangemode: 'tozero' }, polarAxis),
        angularaxis: Object.assign({ direction: 'counterclockwise' }, polarAxis),
      },
    }, layout);
  }

  const config = {
    // Where nothing can hover, as on a phone, the tools would cover the legend for good.
    displayModeBar: window.matchMedia('(hover: hover)').matches ? 'hover' : false,
    displaylogo: false, responsive: true, modeBarButtonsToRemove: ['lasso2d', 'select2d', 'autoScale2d'],
  };

  const figures = Array.from(document.querySelectorAll('script[data-figure]'), (script) => {
    const div = document.getElementById(script.dataset.figure);
    return {
      div, spec: JSON.parse(script.textContent), height: Number(div.dataset.height),
      overTime: 'overTime' in div.dataset, panel: 'panel' in div.dataset, drawn: false,
    };
  });

  // Zooming into the time of one figure zooms all.
  let syncing = false;
  function follow(figure, change) {
    if (syncing) return;
    const all = change['xaxis.autorange'];
    const from = change['xaxis.range[0]'];
    const to = change['xaxis.range[1]'];
    if (!all && from === undefined) return;
    const update = all ? { 'xaxis.autorange': true } : { 'xaxis.range': [from, to] };
    syncing = true;
    const others = figures.filter((other) => other !== figure && other.overTime && other.drawn);
    Promise.all(others.map((other) => Plotly.relayout(other.div, update)))
      .finally(() => { syncing = false; });
  }

  function draw(figure) {
    return Plotly.react(figure.div, painted(figure.spec.data), themed(figure), config).then(() => {
      if (!figure.drawn && figure.overTime) figure.div.on('plotly_relayout', (change) => follow(figure, change));
      figure.drawn = true;
    });
  }

  function failed(figure, error) {
    const note = document.createElement('p');
    note.className = 'failed';
    note.textContent = 'This figure could not be drawn: ' + error.message;
    figure.div.replaceChildren(note);
    console.error(figure.div.id, error);
  }

  async function drawAll() {
    let drawn = 0;
    for (const figure of figures) {
      try {
        await draw(figure);
        drawn += 1;
      } catch (error) {
        failed(figure, error);
      }
      root.dataset.figuresDrawn = drawn + '/' + figures.length;
      // Let the page answer between figures.
      await new Promise((resolve) => setTimeout(resolve));
    }
  }

  function redraw() {
    for (const figure of figures) if (figure.drawn) draw(figure);
    document.dispatchEvent(new Event('ilon-theme'));
  }

  applyTheme(theme());
  dark.addEventListener('change', () => { applyTheme(theme()); redraw(); });
  const button = document.querySelector('.theme');
  if (button) {
    button.addEventListener('click', () => {
      chosen = theme() === 'dark' ? 'light' : 'dark';
      applyTheme(chosen);
      redraw();
    });
  }
  window.addEventListener('beforeprint', () => {
    root.dataset.printing = '';
    applyTheme('light');
    redraw();
    for (const figure of figures) if (figure.drawn) Plotly.Plots.resize(figure.div);
  });
  window.addEventListener('afterprint', () => {
    delete root.dataset.printing;
    applyTheme(theme());
    redraw();
    for (const figure of figures) if (figure.drawn) Plotly.Plots.resize(figure.div);
  });
  drawAll();
})();
