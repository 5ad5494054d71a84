// The results of a run: its page, its hash, downloads and comparison.

function showOutcome(tookS) {
  const { ended, command, report } = last;
  find('outcome').hidden = false;
  find('live').hidden = true;
  find('hash').textContent = ended.hash;
  find('command').textContent = command;
  find('shared').textContent = '';
  find('log').hidden = !last.log;
  find('compare').hidden = !kept;
  find('compare').setAttribute('aria-pressed', 'false');
  showPage(report, 'The report of the run');
  const failed = ended.failed.length ? ` ${ended.failed.length} expectation${ended.failed.length > 1 ? 's' : ''} did not hold.` : '';
  say(`${ended.summary.duration_s} s simulated in ${tookS.toFixed(1)} s.${failed}`);
}

// Shows a page of the command in its frame, at its full height.
function showPage(bytes, title) {
  const frame = find('report');
  if (shownUrl) URL.revokeObjectURL(shownUrl);
  shownUrl = URL.createObjectURL(new Blob([bytes], { type: 'text/html' }));
  const old = frame.cloneNode(false);
  old.title = title;
  old.hidden = false;
  frame.replaceWith(old);
  old.addEventListener('load', () => fit(old));
  old.src = shownUrl;
}

let fitting = null;
function fit(frame) {
  const inner = frame.contentDocument;
  // From disk the frame has another origin: it scrolls by itself.
  if (!inner || !inner.body) { frame.style.height = '85vh'; return; }
  const style = inner.createElement('style');
  style.textContent = '.brand, .skip { display: none !important; } header, main, footer { padding-left: 0; padding-right: 0; } header { padding-top: 0; } nav { position: static; } html { overflow-x: hidden; }';
  inner.head.append(style);
  const high = () => { frame.style.height = `${Math.ceil(inner.body.getBoundingClientRect().height) + 8}px`; };
  if (fitting) fitting.disconnect();
  fitting = new ResizeObserver(high);
  fitting.observe(inner.body);
  high();
  const [answer] = inner.querySelectorAll('.story p');
  find('answer').hidden = !answer;
  if (answer) find('answer').textContent = answer.textContent;
  theme();
}

// The page's theme is that of the shown report.
function theme() {
  const inner = find('report').contentDocument;
  if (!inner || !inner.documentElement) return;
  inner.documentElement.dataset.theme = document.documentElement.dataset.theme;
  inner.dispatchEvent(new Event('ilon-theme'));
}

function save(bytes, name, type) {
  const url = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
}

async function copy(text, words) {
  try {
    await navigator.clipboard.writeText(text);
    find('shared').textContent = words;
  } catch {
    find('shared').textContent = text;
  }
}

function forgetKept() {
  kept = null;
  find('compare').hidden = true;
}

async function share() {
  const text = (path) => new TextDecoder('utf-8', { fatal: true }).decode(simulator.files.get(path));
  let files = [];
  try {
    files = own.paths.filter((path) => path !== chosen.path && last.path !== path).map((path) => [path, text(path)]);
  } catch { files = null; }
  const what = { v: 1, path: last.scenario, text: last.text, settings: last.settings, files: files || [] };
  const link = files && await linkOf(what);
  if (!link) {
    find('shared').textContent = 'The robot\u2019s own files are too large for a link, or no text: hand on the scenario and the robot as files.';
    return;
  }
  history.replaceState(null, '', link);
  await copy(link, 'Copied. The link holds the whole scenario; nothing was sent anywhere.');
}
