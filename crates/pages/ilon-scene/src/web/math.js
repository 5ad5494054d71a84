// Vectors are arrays of 3. A placement is the 3 x 4 matrix of a rigid or scaled motion, row by row:
// 12 numbers.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => times(a, 1 / (norm(a) || 1));
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// From [x, y, z, qx, qy, qz, qw].
function fromPose([x, y, z, i, j, k, w]) {
  return [
    1 - 2 * (j * j + k * k), 2 * (i * j - k * w), 2 * (i * k + j * w), x,
    2 * (i * j + k * w), 1 - 2 * (i * i + k * k), 2 * (j * k - i * w), y,
    2 * (i * k - j * w), 2 * (j * k + i * w), 1 - 2 * (i * i + j * j), z,
  ];
}

// Rz(yaw) Ry(pitch) Rx(roll), the angles of URDF and of the trace.
function fromAngles(x, y, z, roll, pitch, yaw) {
  const [sr, cr, sp, cp, sy, cy] = [roll, pitch, yaw].flatMap((a) => [Math.sin(a), Math.cos(a)]);
  return [
    cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x,
    sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y,
    -sp, cp * sr, cp * cr, z,
  ];
}

function mul(a, b) {
  const m = new Array(12);
  for (let r = 0; r < 12; r += 4) {
    for (let c = 0; c < 4; c++) {
      m[r + c] = a[r] * b[c] + a[r + 1] * b[4 + c] + a[r + 2] * b[8 + c] + (c === 3 ? a[r + 3] : 0);
    }
  }
  return m;
}

// The inverse of a rigid motion.
function inverse(a) {
  const back = [a[0], a[4], a[8], 0, a[1], a[5], a[9], 0, a[2], a[6], a[10], 0];
  const at = turn(back, originOf(a));
  [back[3], back[7], back[11]] = times(at, -1);
  return back;
}

const turnedZ = (a, angle) => mul(a, fromAngles(0, 0, 0, 0, 0, angle));
const scaled = (a, x, y, z) => [
  a[0] * x, a[1] * y, a[2] * z, a[3], a[4] * x, a[5] * y, a[6] * z, a[7], a[8] * x, a[9] * y, a[10] * z, a[11],
];
const originOf = (a) => [a[3], a[7], a[11]];
const turn = (a, v) => [dot(a.slice(0, 3), v), dot(a.slice(4, 7), v), dot(a.slice(8, 11), v)];
const apply = (a, p) => add(turn(a, p), originOf(a));

// A frame at a point whose z axis is a unit vector.
function along(at, z) {
  const x = unit(cross(Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], z));
  const y = cross(z, x);
  return [x[0], y[0], z[0], at[0], x[1], y[1], z[1], at[1], x[2], y[2], z[2], at[2]];
}

// Column-major, as WebGL expects.
function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
}

function mul4(a, b) {
  const m = new Float32Array(16);
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      for (let k = 0; k < 4; k++) m[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    }
  }
  return m;
}
