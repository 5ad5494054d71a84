// Driving in the page. A drive becomes a scenario that plays back its log, which is run as any
// other.

const HANDS = 'Drive by W A S D, Q and E, by the sticks or a gamepad.';

async function drive() {
  if (running) return;
  begin_running();
  find('outcome').hidden = find('report').hidden = find('answer').hidden = find('stop').hidden = true;
  find('live').hidden = find('driving').hidden = false;
  say(compiledYet ? HANDS : 'Loading the simulator');
  let [hands, endWheels, driven, shown] = [null, null, null, 0];
  const show = ilonFigures(find('figures'));
  try {
    await simulator.put([[chosen.path, bytesOf(chosen.text)]]);
    const ended = await simulator.call('drive', { scenario: chosen.path, settings: settingsOf() }, ({ opened: said, progress, figures, frame }) => {
      if (said) {
        adopt(said);
        say(HANDS);
        hands = ilonDrive(find('live'), (twist) => simulator.steer(twist), { top: () => Number(find('top').value) });
        if (scene) endWheels = ilonWheels(find('wheels'), scene);
        find('live').scrollIntoView({ block: matchMedia('(max-width: 960px)').matches ? 'start' : 'nearest' });
        document.activeElement.blur();
        document.documentElement.dataset.driving = 'yes';
        return;
      }
      find('progress').value = progress.t_s / progress.duration_s;
      if (performance.now() - shown > 100) { show(figures); shown = performance.now(); }
      if (scene && frame.length) scene.push(frame.slice().buffer);
    });
    driven = ended.driven;
  } catch (error) {
    showFault(error);
    say('The drive ended.');
  } finally {
    if (hands) hands.end();
    if (endWheels) endWheels();
    find('figures').replaceChildren();
    delete document.documentElement.dataset.driving;
    find('driving').hidden = true;
    end_running();
    if (!driven && last) find('outcome').hidden = find('answer').hidden = false;
  }
  if (!driven) return;
  await takeOver({ ...driven, settings: {} });
  await run();
}

// The log that drives a scenario, among the page's files; null if there is none.
function logOf(path) {
  const file = opened && opened.values.playback && opened.values.playback.file;
  const log = file && path.replace(/[^/]*$/, file);
  return log && simulator.files.has(log) ? log : null;
}

function listenToDrive() {
  find('log').addEventListener('click', () => save(simulator.files.get(last.log), last.log.split('/').pop(), 'text/csv'));
  find('drive').addEventListener('click', drive);
  find('end_drive').addEventListener('click', () => simulator.stop());
  find('top').addEventListener('input', () => { find('top_value').textContent = `${Number(find('top').value).toFixed(2)} m/s`; });
}
