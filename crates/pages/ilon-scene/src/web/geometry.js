// Triangles as { vertices, indices }; a vertex is position, normal, and its place around its axis,
// from 0 to 1.

// A body of revolution about z from its outline [[z, r], ...]. Edges sharper than 40 degrees stay sharp.
function lathe(outline, sides) {
  const faces = [];
  for (let k = 0; k + 1 < outline.length; k++) {
    const [dz, dr] = [outline[k + 1][0] - outline[k][0], outline[k + 1][1] - outline[k][1]];
    const length = Math.hypot(dz, dr);
    // The outline runs towards +z with the body below it: the outside is to the left of its
    // direction.
    if (length > 0) faces.push({ from: outline[k], to: outline[k + 1], n: [-dr / length, dz / length] });
  }
  const vertices = [];
  const indices = [];
  const smooth = (a, b) => {
    if (!a || !b || a.n[0] * b.n[0] + a.n[1] * b.n[1] < 0.77) return null;
    const s = [a.n[0] + b.n[0], a.n[1] + b.n[1]];
    const length = Math.hypot(s[0], s[1]);
    return [s[0] / length, s[1] / length];
  };
  const ring = ([z, r], [nz, nr]) => {
    const first = vertices.length / 7;
    for (let s = 0; s <= sides; s++) {
      const [c, d] = [Math.cos(2 * Math.PI * s / sides), Math.sin(2 * Math.PI * s / sides)];
      vertices.push(r * c, r * d, z, nr * c, nr * d, nz, s / sides);
    }
    return first;
  };
  let shared = null;
  faces.forEach((face, k) => {
    const next = smooth(face, faces[k + 1]);
    const a = shared === null ? ring(face.from, face.n) : shared;
    const b = ring(face.to, next || face.n);
    shared = next && b;
    for (let s = 0; s < sides; s++) {
      if (face.from[1]) indices.push(a + s, a + s + 1, b + s);
      if (face.to[1]) indices.push(b + s, a + s + 1, b + s + 1);
    }
  });
  return { vertices, indices };
}

// The cube of side 2 around the origin.
function cube() {
  const vertices = [];
  const indices = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const sign of [-1, 1]) {
      const n = [0, 0, 0];
      n[axis] = sign;
      const [u, v] = [n.slice(2).concat(n.slice(0, 2)), times(n.slice(1).concat(n.slice(0, 1)), sign)];
      const first = vertices.length / 7;
      for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        for (let i = 0; i < 3; i++) vertices.push(n[i] + a * u[i] + b * v[i]);
        vertices.push(...n, 0);
      }
      indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  return { vertices, indices };
}

// A mesh of a file: vertices and triangles as u16 in base64. Edges sharper than 40 degrees stay sharp.
function surface({ low, step, vertices: places, triangles }) {
  const u16 = (base64) => {
    const bytes = new DataView(bytesOf(base64).buffer);
    return Array.from({ length: bytes.byteLength / 2 }, (_, k) => bytes.getUint16(2 * k, true));
  };
  const steps = u16(places);
  const at = (k) => [0, 1, 2].map((i) => low[i] + step[i] * steps[3 * k + i]);
  const corners = u16(triangles);
  const around = new Map();
  const normals = [];
  for (let f = 0; 3 * f < corners.length; f++) {
    const [a, b, c] = [0, 1, 2].map((i) => at(corners[3 * f + i]));
    // Weighted by the triangle's area, so that large faces dominate.
    const n = cross(sub(b, a), sub(c, a));
    normals.push(n);
    for (let i = 0; i < 3; i++) {
      const k = corners[3 * f + i];
      if (!around.has(k)) around.set(k, []);
      around.get(k).push(f);
    }
  }
  const vertices = [];
  corners.forEach((k, corner) => {
    const own = unit(normals[Math.floor(corner / 3)]);
    let n = [0, 0, 0];
    // A face with the opposite winding counts equally.
    for (const f of around.get(k)) {
      const along = dot(own, unit(normals[f]));
      if (Math.abs(along) > 0.77) n = add(n, times(normals[f], Math.sign(along)));
    }
    vertices.push(...at(k), ...(norm(n) > 0 ? unit(n) : [0, 0, 1]), 0);
  });
  return { vertices, indices: corners.map((_, k) => k) };
}

// Heights on a square grid around the origin, row by row from -y to +y, each row from -x to +x.
function heightField({ cell_m: cell, points, heights, center_m: [x, y] = [0, 0] }) {
  const vertices = [];
  const indices = [];
  const rows = heights.length / points;
  const at = (i, j) => heights[clamp(j, 0, rows - 1) * points + clamp(i, 0, points - 1)];
  const left = x - 0.5 * (points - 1) * cell;
  const front = y - 0.5 * (rows - 1) * cell;
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < points; i++) {
      const n = unit([(at(i - 1, j) - at(i + 1, j)) / (2 * cell), (at(i, j - 1) - at(i, j + 1)) / (2 * cell), 1]);
      vertices.push(left + i * cell, front + j * cell, at(i, j), ...n, 0);
      if (i && j) {
        const k = j * points + i;
        indices.push(k - points - 1, k - points, k, k - points - 1, k, k - 1);
      }
    }
  }
  return { vertices, indices };
}

// A flat band along points [x, y, z, t]; NaN cuts it. A vertex is position, the band's direction in
// the plane, its side, and the time. Triangles, not a strip, so that cuts need no special case.
function band(points) {
  const vertices = [];
  const indices = [];
  points.forEach(([x, y, z, t], k) => {
    const before = points[Math.max(k - 1, 0)];
    const after = points[Math.min(k + 1, points.length - 1)];
    let [dx, dy] = [after[0] - before[0], after[1] - before[1]];
    if (!(Math.hypot(dx, dy) > 0)) [dx, dy] = [1, 0];
    const length = Math.hypot(dx, dy);
    for (const side of [-1, 1]) vertices.push(x, y, z, dx / length, dy / length, side, t);
    if (k && x === x && points[k - 1][0] === points[k - 1][0]) {
      indices.push(2 * k - 2, 2 * k - 1, 2 * k, 2 * k, 2 * k - 1, 2 * k + 1);
    }
  });
  return { vertices, indices };
}
