// The page's light and dark theme: the system's, until a person chooses. Whoever draws hears of it by `ilon-theme`.
(function () {
  'use strict';
  const root = document.documentElement;
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  let chosen = null;
  const wanted = () => chosen || (dark.matches ? 'dark' : 'light');

  function apply(theme) {
    root.dataset.theme = theme;
    document.dispatchEvent(new Event('ilon-theme'));
  }

  apply(wanted());
  dark.addEventListener('change', () => apply(wanted()));
  const button = document.querySelector('.theme');
  if (button) {
    button.addEventListener('click', () => {
      chosen = root.dataset.theme === 'dark' ? 'light' : 'dark';
      apply(chosen);
    });
  }
  // Paper is white, and shows what is open on the screen.
  window.addEventListener('beforeprint', () => {
    root.dataset.printing = '';
    apply('light');
  });
  window.addEventListener('afterprint', () => {
    delete root.dataset.printing;
    apply(wanted());
  });
  document.querySelectorAll('.unfold').forEach((unfold) => unfold.addEventListener('click', () => {
    const all = Array.from(document.querySelectorAll('details.topic'));
    const open = all.some((details) => !details.open);
    all.forEach((details) => { details.open = open; });
  }));
  // A link into a folded topic opens it.
  function reveal() {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (let at = target; at; at = at.parentElement) if (at.tagName === 'DETAILS') at.open = true;
    const topic = target && target.closest('section') && target.closest('section').querySelector('details.topic');
    if (topic && target.tagName === 'H2') topic.open = true;
    if (target) target.scrollIntoView();
  }
  window.addEventListener('hashchange', reveal);
  if (location.hash) reveal();
})();
