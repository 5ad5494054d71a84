// The robots of a gallery: a still of each once it comes into sight, and a scene to turn after a click on it. A browser has few
// contexts for 3D, so stills are drawn one after the other, and one scene is open at a time.
(function () {
  'use strict';
  let open = null;

  function show(thumb) {
    const canvas = document.createElement('canvas');
    thumb.prepend(canvas);
    const data = JSON.parse(thumb.querySelector('script').textContent);
    const scene = window.ilonScene(canvas, data, { inset: false, label: thumb.dataset.name + ' in three dimensions' });
    return { canvas, scene };
  }

  function close({ canvas, scene }) {
    scene.dispose();
    const gl = canvas.getContext('webgl2');
    const lose = gl && gl.getExtension('WEBGL_lose_context');
    if (lose) lose.loseContext();
    canvas.remove();
  }

  function still(thumb) {
    const shown = show(thumb);
    // The flat drawing stays where there is no scene.
    if (!shown.scene.supported) return close(shown);
    const image = document.createElement('img');
    image.alt = '';
    shown.scene.draw();
    image.src = shown.canvas.toDataURL('image/jpeg', 0.9);
    close(shown);
    const button = document.createElement('button');
    button.type = 'button';
    button.setAttribute('aria-label', 'Turn ' + thumb.dataset.name + ' in three dimensions');
    button.title = 'Click, then drag to turn it';
    button.append(image);
    button.addEventListener('click', () => {
      if (open) { close(open.shown); open.button.hidden = false; }
      button.hidden = true;
      open = { shown: show(thumb), button };
      open.shown.canvas.focus();
    });
    thumb.querySelectorAll('button').forEach((old) => old.remove());
    thumb.prepend(button);
    thumb.querySelector('.flat').hidden = true;
  }

  const waiting = [];
  let busy = false;
  function next() {
    const thumb = waiting.shift();
    busy = Boolean(thumb);
    if (!thumb) return;
    still(thumb);
    requestAnimationFrame(next);
  }
  const seen = new IntersectionObserver((changes) => {
    changes.filter((change) => change.isIntersecting).forEach(({ target }) => {
      seen.unobserve(target);
      waiting.push(target);
    });
    if (!busy) next();
  }, { rootMargin: '300px' });
  const thumbs = document.querySelectorAll('.thumb');
  thumbs.forEach((thumb) => seen.observe(thumb));
  document.addEventListener('ilon-theme', () => thumbs.forEach((thumb) => seen.observe(thumb)));
})();
