// The run over time: columns by name, all of the same length, and their interpolated values.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

// A column is one value for all, or f32, or i16 times a scale, with the smallest number for no
// value. All little-endian.
function decoded(column, count) {
  if (!column.data) return new Float32Array(count).fill(column.value === undefined ? NaN : column.value);
  const bytes = new DataView(bytesOf(column.data).buffer);
  const whole = column.scale !== undefined;
  const values = new Float32Array(count);
  for (let k = 0; k < count; k++) {
    if (!whole) values[k] = bytes.getFloat32(4 * k, true);
    else {
      const steps = bytes.getInt16(2 * k, true);
      values[k] = steps === -32768 ? NaN : steps * column.scale;
    }
  }
  return values;
}

class Frames {
  constructor(data, kept) {
    this.columns = data.columns;
    this.index = new Map(data.columns.map((column, i) => [column.name, i]));
    this.count = data.count;
    this.values = data.columns.map((column) => decoded(column, data.count));
    this.now = new Float64Array(data.columns.length);
    this.kept = kept;
  }

  get start() { return this.count ? this.values[0][0] : 0; }

  get end() { return this.count ? this.values[0][this.count - 1] : 0; }

  // Adds a frame: its values in the order of the columns. An earlier time begins a new run, the
  // same time replaces the last frame. If there are too many, the oldest half is dropped.
  push(frame) {
    if (frame.length !== this.columns.length) {
      throw new Error(`a frame has ${this.columns.length} values, not ${frame.length}`);
    }
    if (!Number.isFinite(frame[0])) throw new Error('a frame has no time');
    if (this.count && frame[0] < this.end) this.count = 0;
    else if (this.count && frame[0] === this.end) this.count--;
    if (this.count >= this.kept) {
      const half = this.count >> 1;
      for (const column of this.values) column.copyWithin(0, half, this.count);
      this.count -= half;
    }
    for (let i = 0; i < frame.length; i++) {
      if (this.values[i].length <= this.count) {
        const room = new Float32Array(Math.min(2 * this.count + 256, this.kept + 1));
        room.set(this.values[i].subarray(0, this.count));
        this.values[i] = room;
      }
      this.values[i][this.count] = frame[i];
    }
    this.count++;
  }

  // Sets the time for `get`: linear between frames, for angles the shorter way round.
  seek(t) {
    if (!this.count) { this.now.fill(NaN); return; }
    const times = this.values[0];
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t) low = middle; else high = middle - 1;
    }
    const next = Math.min(low + 1, this.count - 1);
    const part = next > low ? clamp((t - times[low]) / (times[next] - times[low]), 0, 1) : 0;
    this.columns.forEach(({ kind }, i) => {
      const a = this.values[i][low];
      let step = this.values[i][next] - a;
      if (kind === 'angle') step -= 2 * Math.PI * Math.round(step / (2 * Math.PI));
      this.now[i] = kind === 'step' || !part ? a : a + part * step;
    });
  }

  // A current value; NaN without such a column, or without a value in it.
  get(name) {
    const i = this.index.get(name);
    return i === undefined ? NaN : this.now[i];
  }

  column(name) {
    const i = this.index.get(name);
    return i === undefined ? null : this.values[i].subarray(0, this.count);
  }
}
