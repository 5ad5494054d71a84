// The simulator in Node: `node node.mjs PLAYGROUND hashes NAME...` or `... memory NAME COUNT`, or `... times NAME COUNT`. Says JSON.
import fs from 'node:fs';
import path from 'node:path';
import vm from 'node:vm';

const [folder, act, ...rest] = process.argv.slice(2);
const module = new WebAssembly.Module(fs.readFileSync(path.join(folder, 'ilon.wasm')));
const imports = WebAssembly.Module.imports(module);
if (imports.length) throw new Error(`it imports ${JSON.stringify(imports)}`);
const window = {};
vm.runInNewContext(fs.readFileSync(path.join(folder, 'examples.js'), 'utf8'), { window });
const { exports } = new WebAssembly.Instance(module, {});
exports.ilon_begin();

const encode = (text) => new TextEncoder().encode(text);
function put(bytes) {
  const at = exports.ilon_room(bytes.length);
  new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
}
function ask(request) {
  put(encode(JSON.stringify(request)));
  const length = exports.ilon_ask();
  const reply = Buffer.from(new Uint8Array(exports.memory.buffer, exports.ilon_reply(), length));
  const end = reply.indexOf(10);
  const { ok, fault } = JSON.parse(reply.subarray(0, end < 0 ? reply.length : end));
  if (fault) throw new Error(fault.shown);
  return ok;
}
for (const [name, text] of Object.entries(window.ilonExamples)) {
  put(Buffer.concat([encode(name), encode(text)]));
  exports.ilon_put(encode(name).length);
}
function run(name) {
  ask({ do: 'open', scenario: `/scenarios/${name}.toml`, settings: [] });
  while (!ask({ do: 'advance', periods: 1000 }).done);
  return ask({ do: 'finish', command: '' });
}
let said;
if (act === 'hashes') {
  said = Object.fromEntries(rest.map((name) => [name, run(name).hash]));
} else if (act === 'memory') {
  said = Array.from({ length: Number(rest[1]) }, () => {
    run(rest[0]);
    ask({ do: 'take', what: 'report' });
    ask({ do: 'drive', scenario: `/scenarios/${rest[0]}.toml`, settings: [] });
    ask({ do: 'steer', twist: [0.3, 0, 0.2] });
    ask({ do: 'advance', periods: 100 });
    ask({ do: 'end_drive' });
    return exports.memory.buffer.byteLength;
  });
} else {
  // How long a run takes, and its report, in milliseconds.
  said = Array.from({ length: Number(rest[1]) }, () => {
    const from = performance.now();
    run(rest[0]);
    const ran = performance.now();
    ask({ do: 'take', what: 'report' });
    return [ran - from, performance.now() - ran].map(Math.round);
  });
}
console.log(JSON.stringify(said));
