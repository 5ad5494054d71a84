// Simulates in a worker, so that the page stays responsive. Input: `WebAssembly.Module` and files.
// Output: replies, frames and bytes.
'use strict';
let exports = null;
let stopped = false;
const text = { to: new TextEncoder(), from: new TextDecoder() };

function put(bytes) {
  const at = exports.ilon_room(bytes.length);
  new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
}

// Sends a request; returns the reply, and the bytes after it.
function ask(request) {
  put(text.to.encode(JSON.stringify(request)));
  const length = exports.ilon_ask();
  const reply = new Uint8Array(exports.memory.buffer, exports.ilon_reply(), length).slice();
  const end = reply.indexOf(10);
  const { ok, fault } = JSON.parse(text.from.decode(end < 0 ? reply : reply.subarray(0, end)));
  if (fault) throw Object.assign(new Error(fault.message), { fault });
  return { said: ok, bytes: end < 0 ? null : reply.subarray(end + 1) };
}

// The reason why the instance ended: the message of a panic, or the engine's error.
function lastWords(error) {
  try {
    const length = exports.ilon_last_words_length();
    if (length) return text.from.decode(new Uint8Array(exports.memory.buffer, exports.ilon_last_words(), length));
  } catch { /* Nothing can be asked of it any more. */ }
  return String(error);
}

const turn = new MessageChannel();
const others = () => new Promise((go) => { turn.port1.onmessage = go; turn.port2.postMessage(null); });

async function run({ scenario, settings, command }, tell) {
  const opened = ask({ do: 'open', scenario, settings }).said;
  tell({ opened });
  let periods = 20;
  stopped = false;
  for (;;) {
    const from = performance.now();
    const { said } = ask({ do: 'advance', periods });
    const took = performance.now() - from;
    // The number of periods between two frames.
    periods = Math.max(1, Math.min(2000, Math.round(periods * Math.min(4, 33 / Math.max(took, 0.5)))));
    tell({ progress: said, frame: ask({ do: 'frame' }).bytes });
    if (said.done) break;
    await others();
    if (stopped) return { stopped: true };
  }
  const { said } = ask({ do: 'finish', command });
  const { bytes } = ask({ do: 'take', what: 'report' });
  return { finished: said, bytes, memory: exports.memory.buffer.byteLength };
}

// The user's last command, and its time.
let steered = { twist: [0, 0, 0], at: 0 };
const STAND = [0, 0, 0];
// Without a command for this time the robot stops, in milliseconds; as in a live run.
const WATCHDOG_MS = 500;
// A longer delay of the simulation is skipped, so that it does not hurry afterwards.
const BEHIND_MS = 200;
const PICTURE_MS = 15;

// Simulates in real time while the user drives; returns the scenario that repeats the drive.
async function drive({ scenario, settings }, tell) {
  const opened = ask({ do: 'drive', scenario, settings }).said;
  tell({ opened });
  const period = 1000 * opened.control_dt_s;
  stopped = false;
  let due = performance.now();
  let cost = period / 2;
  let [since, passed, factor] = [due, 0, 1];
  while (!stopped) {
    const now = performance.now();
    due = Math.max(due, now - BEHIND_MS);
    const periods = Math.min(Math.floor((now - due) / period), Math.max(1, Math.floor(40 / cost)));
    if (periods > 0 && now - due >= PICTURE_MS) {
      ask({ do: 'steer', twist: now - steered.at < WATCHDOG_MS ? steered.twist : STAND });
      const { said } = ask({ do: 'advance', periods });
      due += periods * period;
      passed += periods * period;
      cost += 0.2 * ((performance.now() - now) / periods - cost);
      if (now - since > 1000) [factor, since, passed] = [passed / (now - since), now, 0];
      tell({ progress: said, figures: { ...said.figures, real_time_factor: factor }, frame: ask({ do: 'frame' }).bytes });
      if (said.done) break;
    }
    await new Promise((go) => { setTimeout(go, 4); });
  }
  return { driven: ask({ do: 'end_drive' }).said };
}

const acts = {
  async start({ module }) {
    exports = (await WebAssembly.instantiate(module, {})).exports;
    exports.ilon_begin();
    return {};
  },
  files({ files, clear }) {
    if (clear) ask({ do: 'clear' });
    for (const [path, bytes] of files) {
      const name = text.to.encode(path);
      const both = new Uint8Array(name.length + bytes.byteLength);
      both.set(name);
      both.set(new Uint8Array(bytes), name.length);
      put(both);
      exports.ilon_put(name.length);
    }
    return {};
  },
  ask: ({ request }) => ask(request),
  run,
  drive,
};

onmessage = async ({ data }) => {
  if (data.act === 'stop') { stopped = true; return; }
  if (data.act === 'steer') { steered = { twist: data.twist, at: performance.now() }; return; }
  const tell = (what) => postMessage({ id: data.id, ...what });
  try {
    tell({ end: true, ...await acts[data.act](data, tell) });
  } catch (error) {
    tell({ end: true, ...(error.fault ? { fault: error.fault } : { dead: lastWords(error) }) });
  }
};
