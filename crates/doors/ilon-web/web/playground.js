// The page: selection, changes, and results.

const find = (id) => document.getElementById(id);
const OWN = '/own/';
const FIRST_SCENARIO = '/scenarios/mecanum4_lateral.toml';
// The initial scenario for a robot of the user.
const OWN_SCENARIO = (file) => `# My robot, sideways: how far does it move, compared with its wheel speeds?

[robot]
file = ${JSON.stringify(file)}

[twist]
vy_m_s = 0.2

[run]
duration_s = 5
`;
const ROBOT_ENDINGS = /\.(urdf|xacro|sdf|world|xml|mjcf|toml)$/i;
// Largest total size of the user's files, in bytes; chosen.
const MOST_OF_FILES = 200e6;

const examples = window.ilonExamples || {};
const bytesOf = (text) => new TextEncoder().encode(text);
const simulator = new Simulator(Object.entries(examples).map(([path, text]) => [path, bytesOf(text)]));
simulator.files = new Map(simulator.files);

// The selection.
const chosen = { path: FIRST_SCENARIO, text: '', settings: {} };
const own = { robots: [], paths: [] };
let known = new Map();
let kinds = [];
let opened = null;
let running = false;
let asked = 0;
let kept = null;
let last = null;
let scene = null;
let shownUrl = null;

function say(text) { find('state').textContent = text; }

function showFault(error) {
  const { fault, dead } = error;
  const box = find('fault');
  box.hidden = false;
  box.firstElementChild.textContent = fault ? fault.shown : dead === 'stopped' ? 'The run was stopped.'
    : dead ? `The simulator broke down and was started again; a run that was kept is gone.\n${dead.slice(0, 2000)}` : String(error.message || error);
  if (dead) forgetKept();
}

function hideFault() { find('fault').hidden = true; }

const option = (value, text) => Object.assign(document.createElement('option'), { value, textContent: text });
const nameOf = (path) => path.split('/').pop().replace(/\.toml$/, '');

// The title of a scenario: the comment at its head.
function headOf(text) {
  const lines = [];
  for (const line of text.split('\n')) {
    if (!line.startsWith('#')) break;
    lines.push(line.replace(/^#\s?/, ''));
  }
  return lines.join(' ');
}

function fillScenarios() {
  const select = find('scenario');
  const groups = new Map();
  for (const path of Object.keys(examples).filter((one) => one.startsWith('/scenarios/') && one.endsWith('.toml'))) {
    const robot = nameOf(path).split('_')[0];
    if (!groups.has(robot)) groups.set(robot, Object.assign(document.createElement('optgroup'), { label: robot }));
    groups.get(robot).append(option(path, nameOf(path).replace(`${robot}_`, '').replaceAll('_', ' ')));
  }
  const mine = own.paths.filter((path) => path.endsWith('.toml'));
  if (mine.length) {
    const group = Object.assign(document.createElement('optgroup'), { label: 'your own' });
    group.append(...mine.map((path) => option(path, path.startsWith(OWN) ? path.slice(OWN.length) : nameOf(path).replaceAll('_', ' '))));
    groups.set('', group);
  }
  select.replaceChildren(...groups.values());
  select.value = chosen.path;
}

function fillRobots() {
  const shipped = Object.keys(examples).filter((one) => /^\/robots\/.*\.(urdf|toml)$/.test(one));
  const way = chosen.path.startsWith(OWN) ? '../robots/' : '../robots/';
  const select = find('robot');
  const options = [option('', 'as the scenario says')];
  for (const path of own.robots) options.push(option(chosen.path.startsWith(OWN) ? path.slice(OWN.length) : `..${path}`, path.slice(OWN.length)));
  for (const path of shipped) options.push(option(way + path.slice(8), path.slice(8)));
  const set = chosen.settings['robot.file'];
  if (set && !options.some(({ value }) => value === set)) options.push(option(set, set));
  select.replaceChildren(...options);
  select.value = set || '';
}

// The settings in the form of `--set`.
const settingsOf = () => Object.entries(chosen.settings).map(([key, value]) => `${key}=${value}`);

const quoted = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

function commandOf() {
  const edited = chosen.text !== examples[chosen.path];
  const file = edited ? `${nameOf(chosen.path)}.toml` : `assets${chosen.path}`;
  return ['ilon run', quoted(file), ...settingsOf().map((setting) => `--set ${quoted(setting)}`)].join(' ');
}

// Sets a key, or resets it to the file's value.
function set(key, value) {
  if (value === null) delete chosen.settings[key];
  else chosen.settings[key] = value;
  if (key.startsWith('robot.spec.') && value !== null && opened && opened.spec) chosen.settings['robot.file'] = opened.spec.file;
  showSettings();
  look();
}

function showSettings() {
  const entries = Object.entries(chosen.settings);
  find('back').disabled = entries.length === 0;
  find('set_keys').replaceChildren(...entries.map(([key, value]) => {
    const item = document.createElement('li');
    const code = Object.assign(document.createElement('code'), { textContent: `${key} = ${value}` });
    const remove = Object.assign(document.createElement('button'), { type: 'button', textContent: 'Undo' });
    remove.setAttribute('aria-label', `Undo ${key}`);
    remove.addEventListener('click', () => { set(key, null); fillRobots(); find('back').focus(); });
    item.append(code, remove);
    return item;
  }));
}

// The current value of a key: the setting, or otherwise that of the scenario or its robot's
// description.
function valueNow(key) {
  if (key in chosen.settings) return Number(chosen.settings[key]);
  if (!key.startsWith('robot.spec.')) return valueAt(opened.values, key);
  return opened.spec ? valueAt(opened.spec.values, key.slice('robot.spec.'.length)) : undefined;
}

const rounded = (value) => String(Number(value.toPrecision(5)));

function slider([key, words, low, high, needed]) {
  const about = known.get(key);
  const value = valueNow(key);
  if (!about || typeof value !== 'number' || (needed && !opened.values[needed])) return null;
  const { min, max, step } = rangeOf(about, low, high, value);
  const row = document.createElement('div');
  row.className = 'slider';
  row.classList.toggle('set', key in chosen.settings);
  const id = `key-${key.replaceAll('.', '-')}`;
  const label = Object.assign(document.createElement('label'), { textContent: words, htmlFor: id, title: about.about });
  const range = Object.assign(document.createElement('input'), { type: 'range', id, min, max, step });
  range.value = value;
  range.dataset.key = key;
  const number = Object.assign(document.createElement('input'), { type: 'number', step: 'any', value: rounded(value) });
  number.setAttribute('aria-label', `${words}, as a number`);
  const unit = Object.assign(document.createElement('span'), { className: 'unit', textContent: unitOf(key) });
  const take = (text) => {
    row.classList.add('set');
    // A TOML number: an integer is accepted for a float.
    set(key, text);
  };
  range.addEventListener('input', () => { number.value = rounded(Number(range.value)); take(number.value); });
  number.addEventListener('change', () => {
    if (!Number.isFinite(number.valueAsNumber)) { number.value = rounded(Number(range.value)); return; }
    range.value = number.value;
    take(String(number.valueAsNumber));
  });
  row.append(label, number, unit, range);
  return row;
}

function showSliders() {
  const focused = document.activeElement && document.activeElement.id;
  find('sliders').replaceChildren(...FIRST.map(slider).filter(Boolean));
  if (focused && focused.startsWith('key-') && find(focused)) find(focused).focus();
  const wheels = opened.robot.wheels.map(({ name }) => option(name, name));
  const at = find('wheel_of_fault').value;
  find('wheel_of_fault').replaceChildren(...wheels);
  if (wheels.some(({ value }) => value === at)) find('wheel_of_fault').value = at;
}

function fillFaults() {
  const select = find('broken');
  select.replaceChildren(option('', 'as in the file'), ...kinds.map(({ name }) => option(name, name.replaceAll('_', ' '))));
}

function breakIt() {
  const kind = kinds.find(({ name }) => name === find('broken').value);
  find('at_wheel').hidden = !kind || !kind.fields.includes('wheel');
  if (!kind) { set('faults', null); return; }
  const fromS = Math.round(opened.duration_s * 3) / 10;
  set('faults', faultAs(kind, find('wheel_of_fault').value, fromS, (opened.before || []).map(asToml)));
}

function showScene({ scene: data, rest }) {
  if (scene) scene.dispose();
  scene = null;
  const old = find('live').querySelector('canvas');
  const canvas = Object.assign(document.createElement('canvas'), {});
  canvas.setAttribute('aria-label', old.getAttribute('aria-label'));
  old.replaceWith(canvas);
  if (!data) return;
  scene = window.ilonScene(canvas, JSON.parse(data), { label: canvas.getAttribute('aria-label') });
  scene.push(Float32Array.from(rest, (x) => (x === null ? NaN : x)));
}

// Reads the scenario again after a short delay, as several changes may follow.
function look(now) {
  asked += 1;
  const mine = asked;
  const read = async () => {
    if (mine !== asked || running) return;
    try {
      await simulator.put([[chosen.path, bytesOf(chosen.text)]]);
      const { said } = await simulator.call('ask', { request: { do: 'open', scenario: chosen.path, settings: settingsOf() } });
      if (mine !== asked) return;
      adopt(said);
      hideFault();
      say(last ? 'Changed since the last run: run it again.' : 'Ready');
    } catch (error) {
      if (mine !== asked) return;
      showFault(error);
      say('It cannot be run without a change.');
    }
  };
  return now ? read() : new Promise((done) => { setTimeout(() => done(read()), 250); });
}

function adopt(said) {
  const faults = said.values.faults || [];
  said.before = 'faults' in chosen.settings && opened ? opened.before : faults;
  opened = said;
  showSliders();
  if (find('outcome').hidden) showScene(said);
}

async function choose(path, text, settings) {
  Object.assign(chosen, { path, text, settings: settings || {} });
  opened = null;
  find('broken').value = '';
  find('at_wheel').hidden = true;
  find('text').value = text;
  find('says').textContent = headOf(text);
  fillScenarios();
  fillRobots();
  showSettings();
  await look(true);
}

function begin_running() {
  running = true;
  asked += 1;
  hideFault();
  find('run').disabled = find('drive').disabled = true;
  find('stop').hidden = find('progress').hidden = false;
  find('progress').value = 0;
}

function end_running() {
  running = false;
  find('run').disabled = find('drive').disabled = false;
  find('stop').hidden = find('progress').hidden = true;
  if (last) { find('report').hidden = false; find('live').hidden = true; }
}

async function run() {
  if (running) return;
  begin_running();
  const command = commandOf();
  say(compiledYet ? 'Running' : 'Loading the simulator');
  try {
    await simulator.start();
    const begun = performance.now();
    say('Running');
    await simulator.put([[chosen.path, bytesOf(chosen.text)]]);
    const what = { scenario: chosen.path, settings: settingsOf(), command };
    const ended = await simulator.call('run', what, ({ opened: said, progress, frame }) => {
      if (said) { adopt(said); return; }
      find('progress').value = progress.t_s / progress.duration_s;
      // A run that ends at once needs no live picture: the report has one.
      if (performance.now() - begun > 400 && find('live').hidden) { find('live').hidden = false; find('report').hidden = true; showScene(opened); }
      if (scene && !find('live').hidden && frame.length) scene.push(frame.slice().buffer);
    });
    if (ended.stopped) { say('Stopped.'); return; }
    last = { ...what, text: chosen.text, settings: { ...chosen.settings }, log: logOf(chosen.path), ended: ended.finished, report: ended.bytes };
    document.documentElement.dataset.memory = ended.memory;
    document.documentElement.dataset.runs = 1 + Number(document.documentElement.dataset.runs || 0);
    showOutcome((performance.now() - begun) / 1000);
  } catch (error) {
    showFault(error);
    say('No result.');
  } finally {
    end_running();
  }
}

// The user's files: robots, scenarios, meshes.
async function takeIn(files) {
  const size = files.reduce((sum, [, file]) => sum + file.size, 0);
  if (size > MOST_OF_FILES) { showFault(new Error(`These files hold ${Math.round(size / 1e6)} MB; the page takes up to ${MOST_OF_FILES / 1e6} MB.`)); return; }
  const read = [];
  for (const [path, file] of files) read.push([OWN + path.replace(/^\/+/, ''), new Uint8Array(await file.arrayBuffer())]);
  await simulator.put(read).catch(showFault);
  own.paths = [...new Set([...own.paths, ...read.map(([path]) => path)])];
  const text = (bytes) => new TextDecoder().decode(bytes);
  const isScenario = ([path, bytes]) => path.endsWith('.toml') && /^\s*\[?\s*robot\b/m.test(text(bytes)) && !/^\s*\[chassis\]/m.test(text(bytes));
  const scenarios = read.filter(isScenario);
  const robots = read.filter((one) => ROBOT_ENDINGS.test(one[0]) && !scenarios.includes(one)).map(([path]) => path);
  own.robots = [...new Set([...own.robots, ...robots])];
  if (scenarios.length) { await choose(scenarios[0][0], text(scenarios[0][1])); return; }
  // The main file is at the highest level, and named like a robot rather than like a part of one.
  const [robot] = robots.sort((a, b) => a.split('/').length - b.split('/').length || a.length - b.length);
  if (!robot) { showFault(new Error('Among these files is no robot and no scenario: a robot is a .urdf, .xacro, .sdf, .xml (MJCF) or .toml.')); return; }
  const path = `${OWN}drive.toml`;
  if (!own.paths.includes(path)) own.paths.push(path);
  await choose(path, OWN_SCENARIO(robot.slice(OWN.length)));
}

// The dropped files, including those in dropped folders.
async function dropped(items) {
  const found = [];
  async function enter(entry, above) {
    if (entry.isFile) found.push([above + entry.name, await new Promise((done, refuse) => entry.file(done, refuse))]);
    else {
      const reader = entry.createReader();
      for (;;) {
        const some = await new Promise((done, refuse) => reader.readEntries(done, refuse));
        if (!some.length || found.length > 5000) break;
        for (const one of some) await enter(one, `${above}${entry.name}/`);
      }
    }
  }
  const entries = items.map((item) => item.webkitGetAsEntry && item.webkitGetAsEntry()).filter(Boolean);
  for (const entry of entries) await enter(entry, '');
  return found;
}

function listen() {
  const on = (id, name, listener) => find(id).addEventListener(name, listener);
  on('setup', 'submit', (event) => { event.preventDefault(); run(); });
  on('stop', 'click', () => simulator.stop());
  listenToDrive();
  on('scenario', 'change', () => {
    const path = find('scenario').value;
    choose(path, examples[path] ?? new TextDecoder().decode(simulator.files.get(path)));
  });
  on('robot', 'change', () => { for (const key of Object.keys(chosen.settings)) if (key.startsWith('robot.spec.')) delete chosen.settings[key]; set('robot.file', find('robot').value || null); });
  on('broken', 'change', breakIt);
  on('wheel_of_fault', 'change', breakIt);
  on('text', 'input', () => { chosen.text = find('text').value; find('says').textContent = headOf(chosen.text); look(); });
  on('back', 'click', () => choose(chosen.path, chosen.text));
  on('key', 'input', () => { const about = known.get(find('key').value); find('about_key').textContent = about ? about.about : ''; });
  on('set', 'click', () => {
    const [key, value] = [find('key').value.trim(), find('value').value.trim()];
    if (key && value) { set(key, value); find('key').value = find('value').value = ''; }
  });
  on('value', 'keydown', (event) => { if (event.key === 'Enter') { event.preventDefault(); find('set').click(); } });
  for (const id of ['files', 'folder']) {
    on(id, 'change', () => { const list = [...find(id).files]; find(id).value = ''; takeIn(list.map((file) => [file.webkitRelativePath || file.name, file])); });
  }
  addEventListener('dragover', (event) => { event.preventDefault(); find('drop').classList.add('over'); });
  addEventListener('dragleave', () => find('drop').classList.remove('over'));
  addEventListener('drop', async (event) => {
    event.preventDefault();
    find('drop').classList.remove('over');
    const found = await dropped([...event.dataTransfer.items]).catch(() => []);
    takeIn(found.length ? found : [...event.dataTransfer.files].map((file) => [file.name, file]));
  });
  on('copy_hash', 'click', () => copy(last.ended.hash, 'Copied.'));
  on('copy_command', 'click', () => copy(last.command, 'Copied.'));
  on('share', 'click', share);
  document.querySelectorAll('[data-take]').forEach((button) => button.addEventListener('click', async () => {
    try {
      const { bytes } = await simulator.call('ask', { request: { do: 'take', what: button.dataset.take } });
      save(bytes, `${last.ended.name}-${button.dataset.name}`, button.dataset.take === 'report' ? 'text/html' : 'application/octet-stream');
    } catch (error) { showFault(error); }
  }));
  on('keep', 'click', async () => {
    try {
      const name = `${last.ended.name}: ${Object.entries(last.settings).map(([key, value]) => `${key.split('.').pop()} ${value}`).join(', ') || 'as in its file'}`;
      await simulator.call('ask', { request: { do: 'keep', name } });
      kept = name;
      find('shared').textContent = 'Kept. Change something, run again, and compare.';
    } catch (error) { showFault(error); }
  });
  on('compare', 'click', async () => {
    const on = find('compare').getAttribute('aria-pressed') !== 'true';
    find('compare').setAttribute('aria-pressed', String(on));
    if (!on) { showPage(last.report, 'The report of the run'); return; }
    const changes = Object.entries(last.settings).map(([key, value]) => `${key.split('.').pop()} ${value}`).join(', ') || 'as in its file';
    try {
      const { bytes } = await simulator.call('ask', { request: { do: 'compare', name: `${last.ended.name}: ${changes}` } });
      showPage(bytes, 'Two runs compared');
    } catch (error) { showFault(error); }
  });
  document.addEventListener('ilon-theme', theme);
  addEventListener('hashchange', () => openLink().catch(showFault));
}

// Loads a scenario with the files that it needs.
async function takeOver({ path, text, settings, files = [] }) {
  const given = [...files, ...(examples[path] === undefined ? [[path, text]] : [])];
  await simulator.put(given.map(([name, content]) => [name, bytesOf(content)]));
  own.paths = [...new Set([...own.paths, ...given.map(([name]) => name)])];
  own.robots = [...new Set([...own.robots, ...files.map(([name]) => name).filter((name) => ROBOT_ENDINGS.test(name) && name !== path)])];
  await choose(path, text, settings);
}

// Loads the content of a link; returns whether there was any.
async function openLink() {
  const what = await fromLink();
  if (!what) return false;
  await takeOver(what);
  await (what.drive ? drive() : run());
  return true;
}

// Stores the schemas.
function know({ scenario, robot }) {
  known = new Map([...keysOf(scenario, scenario, ''), ...keysOf(robot, robot, 'robot.spec')]);
  kinds = faultsOf(scenario);
  find('keys').replaceChildren(...[...known.keys()].map((key) => option(key, '')));
  fillFaults();
}

// The simulator is large and loads last: its first replies are part of the page, so that everything
// can be selected meanwhile.
async function begin() {
  listen();
  // In a narrow window, where the parts are stacked, the result comes before the settings.
  find('changes').open = !matchMedia('(max-width: 960px)').matches;
  const { schemas, opened: first } = window.ilonFirst;
  know(schemas);
  find('text').value = chosen.text = examples[FIRST_SCENARIO];
  find('says').textContent = headOf(chosen.text);
  fillScenarios();
  fillRobots();
  showSettings();
  if (!location.hash) adopt(first);
  find('run').disabled = find('drive').disabled = false;
  document.documentElement.dataset.usable = 'yes';
  let touched = false;
  const touch = () => { touched = true; };
  for (const name of ['input', 'change', 'submit', 'click']) find('setup').addEventListener(name, touch, { once: true });
  try {
    const [isLinked] = await Promise.all([openLink(), simulator.start()]);
    if (!isLinked && !touched) await run();
  } catch (error) {
    showFault(error);
    say(compiledYet || location.hash ? 'It cannot be opened.' : 'The simulator could not be loaded.');
  } finally {
    document.documentElement.dataset.ready = 'yes';
  }
}

begin();
