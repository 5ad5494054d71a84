// The figures of the page: when they are drawn, and what redraws them.

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
