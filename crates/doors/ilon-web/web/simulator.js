// The simulator in its worker: calls return promises, and it is restarted after a crash.

// The module is compiled once for all instances.
let compiled = null;
let compiledYet = false;

// A page from disk may load scripts, but no other files.
function fromDisk() {
  return new Promise((done, refuse) => {
    const script = document.createElement('script');
    script.src = 'ilon.wasm.js';
    script.onload = () => done(WebAssembly.compile(Uint8Array.from(atob(window.ilonWasm), (c) => c.charCodeAt(0))));
    script.onerror = () => refuse(new Error('ilon.wasm.js is not beside this page'));
    document.head.append(script);
  });
}

async function fromServer() {
  const answer = await fetch('ilon.wasm');
  if (!answer.ok) throw new Error(`ilon.wasm is not beside this page (${answer.status})`);
  const typed = (answer.headers.get('content-type') || '').startsWith('application/wasm');
  return typed ? WebAssembly.compileStreaming(answer) : WebAssembly.compile(await answer.arrayBuffer());
}

function compile() {
  compiled = compiled || (location.protocol === 'file:' ? fromDisk() : fromServer());
  return compiled;
}

class Simulator {
  constructor(files) {
    this.files = files;
    this.calls = 0;
    this.waiting = new Map();
    this.worker = null;
  }

  // Calls the worker; `tell` receives its progress. Rejects with `fault`, the command's message, or
  // `dead` after a crash.
  async call(act, what = {}, tell = () => {}) {
    if (!this.worker) await this.start();
    return this.post(act, what, tell);
  }

  post(act, what, tell) {
    this.calls += 1;
    const id = this.calls;
    return new Promise((done, refuse) => {
      this.waiting.set(id, { done, refuse, tell });
      this.worker.postMessage({ id, act, ...what });
    });
  }

  start() {
    this.started = this.started || this.begin().finally(() => { this.started = null; });
    return this.started;
  }

  async begin() {
    const module = await compile();
    compiledYet = true;
    const url = URL.createObjectURL(new Blob([WORKER], { type: 'text/javascript' }));
    this.worker = new Worker(url);
    URL.revokeObjectURL(url);
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.end(event.message || 'the worker ended');
    await this.post('start', { module }, () => {});
    await this.post('files', { files: [...this.files], clear: true }, () => {});
  }

  hear({ id, end, ...said }) {
    const call = this.waiting.get(id);
    if (!call) return;
    if (!end) { call.tell(said); return; }
    this.waiting.delete(id);
    if (said.fault) call.refuse(Object.assign(new Error(said.fault.message), { fault: said.fault }));
    else if (said.dead) {
      const error = Object.assign(new Error(said.dead), { dead: said.dead });
      call.refuse(error);
      this.end(said.dead);
    } else call.done(said);
  }

  // Terminates the worker in any state; the next call starts another.
  end(why) {
    if (this.worker) this.worker.terminate();
    this.worker = null;
    const left = [...this.waiting.values()];
    this.waiting.clear();
    left.forEach(({ refuse }) => refuse(Object.assign(new Error(why), { dead: why })));
  }

  // Ends a run: between two frames, or with the worker if it does not respond.
  stop() {
    const { worker, calls } = this;
    if (!worker) return;
    const under = [...this.waiting.keys()].filter((id) => id <= calls);
    worker.postMessage({ act: 'stop' });
    setTimeout(() => { if (this.worker === worker && under.some((id) => this.waiting.has(id))) this.end('stopped'); }, 700);
  }

  // Commands a driven robot. There is no answer.
  steer(twist) {
    if (this.worker) this.worker.postMessage({ act: 'steer', twist });
  }

  // Adds files, here and in the worker.
  async put(files) {
    for (const [path, bytes] of files) this.files.set(path, bytes);
    if (this.worker) await this.call('files', { files: [...files] });
  }
}
