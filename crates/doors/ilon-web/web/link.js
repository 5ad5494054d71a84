// A run in a link: all its data, compressed behind the `#`, which browsers send to no server.

// The longest link that other programs pass on unchanged; chosen.
const LONGEST_LINK = 60000;

const bytesThrough = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

function toBase64(bytes) {
  let text = '';
  for (let at = 0; at < bytes.length; at += 8192) text += String.fromCharCode(...bytes.subarray(at, at + 8192));
  return btoa(text).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
}

const fromBase64 = (text) => Uint8Array.from(atob(text.replace(/-/g, '+').replace(/_/g, '/')), (c) => c.charCodeAt(0));

// The link of a run; null if it would be too long.
async function linkOf(what) {
  const packed = await bytesThrough(new TextEncoder().encode(JSON.stringify(what)), new CompressionStream('deflate-raw'));
  const link = `${location.href.split('#')[0]}#run=${toBase64(packed)}`;
  return link.length > LONGEST_LINK ? null : link;
}

// Largest decompressed size of a link, in characters; chosen: a small one can be made to hold
// gigabytes.
const MOST_UNFOLDED = 4e6;

// A link that can be typed: `#scenario=mecanum4_lateral&set=world.floor.friction=0.2`, with
// `&drive` to drive.
function fromWords() {
  const words = new URLSearchParams(location.hash.slice(1));
  const name = words.get('scenario');
  if (name === null) return null;
  const path = `/scenarios/${name}.toml`;
  if (examples[path] === undefined) throw new Error(`There is no example scenario ${name}.`);
  const pairs = words.getAll('set').map((setting) => [setting.split('=', 1)[0], setting.slice(setting.indexOf('=') + 1)]);
  return { path, text: examples[path], settings: Object.fromEntries(pairs), drive: words.has('drive') };
}

// The content of a link; null if it has none.
async function fromLink() {
  const packed = /[#&]run=([\w-]+)/.exec(location.hash);
  if (!packed) return fromWords();
  try {
    return await unfolded(packed[1]);
  } catch (error) {
    throw new Error(`This link holds no scenario: it was cut or changed. Copy it again from where it was made. (${error.message})`);
  }
}

async function unfolded(packed) {
  const reader = new Blob([fromBase64(packed)]).stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader();
  const parts = [];
  let size = 0;
  for (let { done, value } = await reader.read(); !done; { done, value } = await reader.read()) {
    parts.push(value);
    size += value.length;
    if (size > MOST_UNFOLDED) throw new Error('the link holds too much');
  }
  const what = JSON.parse(await new Blob(parts).text());
  const good = what && typeof what.path === 'string' && typeof what.text === 'string' && what.settings && typeof what.settings === 'object'
    && (what.files || []).every((file) => Array.isArray(file) && file.every((entry) => typeof entry === 'string'));
  if (!good) throw new Error('the link does not hold a scenario');
  return what;
}
