// The WebGL part: instanced bodies, the floor with its grid, bands. It draws lists, and keeps only
// buffers between frames, so that a lost context is restored by making a new renderer.

const SUN = unit([0.35, -0.3, 0.9]);
// A placement (12), a colour with its opacity (4), and a style (4): stripes around the axis, their
// width, gloss, own light.
const INSTANCE = 20;

const BODY = [`#version 300 es
layout(location=0) in vec3 p; layout(location=1) in vec3 n; layout(location=2) in float around;
layout(location=3) in vec4 r0; layout(location=4) in vec4 r1; layout(location=5) in vec4 r2;
layout(location=6) in vec4 color; layout(location=7) in vec4 style;
uniform mat4 clip; uniform vec3 sun; uniform float shadow;
out vec3 at; out vec3 normal; out float turn; out vec4 paint; out vec4 kind;
void main() {
  vec4 q = vec4(p, 1.0);
  at = vec3(dot(r0, q), dot(r1, q), dot(r2, q));
  if (shadow > 0.0) at -= sun * (max(at.z, 0.0) / sun.z);
  vec3 a = vec3(r0.x, r1.x, r2.x), b = vec3(r0.y, r1.y, r2.y), c = vec3(r0.z, r1.z, r2.z);
  normal = mat3(cross(b, c), cross(c, a), cross(a, b)) * n;
  turn = around; paint = color; kind = style;
  gl_Position = clip * vec4(at, 1.0);
}`, `#version 300 es
precision highp float;
in vec3 at; in vec3 normal; in float turn; in vec4 paint; in vec4 kind;
uniform vec3 sun, eye; uniform vec4 shade; uniform float shadow, fade;
out vec4 result;
void main() {
  if (shadow > 0.0) { result = shade; return; }
  vec3 n = normalize(normal), see = normalize(eye - at);
  if (dot(n, see) < 0.0) n = -n;
  vec3 base = paint.rgb;
  if (kind.x > 0.0) {
    float off = abs(fract(turn * kind.x) - 0.5) * 2.0;
    float soft = fwidth(turn * kind.x) * 2.0;
    float light = dot(base, vec3(0.3, 0.6, 0.1)) > 0.45 ? 0.35 : 2.1;
    base = mix(base, base * light + (light > 1.0 ? 0.12 : 0.0), 1.0 - smoothstep(kind.y - soft, kind.y + soft, off));
  }
  float lit = 0.6 + 0.14 * n.z + 0.42 * max(dot(n, sun), 0.0);
  float gloss = kind.z * pow(max(dot(n, normalize(sun + see)), 0.0), 40.0);
  result = vec4(mix(base * lit + gloss, base, kind.w), paint.a * fade);
}`];

const FLOOR = [`#version 300 es
layout(location=0) in vec3 p; layout(location=1) in vec3 n;
uniform mat4 clip; uniform vec4 place;
out vec3 at; out vec3 normal;
void main() { at = p * vec3(place.ww, 1.0) + vec3(place.xyz); normal = n; gl_Position = clip * vec4(at, 1.0); }`, `#version 300 es
precision highp float;
in vec3 at; in vec3 normal;
uniform vec3 sun, base, line, sky, middle; uniform vec2 cells; uniform float reach;
out vec4 result;
float grid(float cell, float width) {
  vec2 g = at.xy / cell, w = fwidth(g);
  vec2 d = abs(fract(g - 0.5) - 0.5) / max(w, 1e-6);
  float near = 1.0 - smoothstep(0.12, 0.4, max(w.x, w.y));
  return (1.0 - smoothstep(width - 0.5, width + 0.5, min(d.x, d.y))) * near;
}
void main() {
  float on = max(grid(cells.x, 0.6) * 0.55, grid(cells.y, 1.1));
  vec3 color = mix(base, line, on) * (1.0 + 2.2 * (dot(normalize(normal), sun) - sun.z));
  result = vec4(mix(color, sky, smoothstep(0.25, 1.0, distance(at, middle) / reach)), 1.0);
}`];

const BAND = [`#version 300 es
layout(location=0) in vec3 p; layout(location=1) in vec2 way; layout(location=2) in float side; layout(location=3) in float t;
uniform mat4 clip; uniform vec2 width; uniform float lift;
out float time;
void main() {
  float depth = (clip * vec4(p, 1.0)).w;
  float half_m = max(width.x, width.y * depth);
  time = t;
  gl_Position = clip * vec4(p + vec3(-way.y, way.x, 0.0) * side * half_m + vec3(0.0, 0.0, lift), 1.0);
}`, `#version 300 es
precision highp float;
in float time; uniform vec4 color; uniform float now, later; out vec4 result;
void main() { result = vec4(color.rgb, color.a * (time > now ? later : 1.0)); }`];

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`a shader does not link: ${gl.getProgramInfoLog(made)}`);
  }
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = gl.getActiveUniform(made, i);
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}

class Renderer {
  constructor(gl) {
    this.gl = gl;
    this.bodies = program(gl, BODY);
    this.floors = program(gl, FLOOR);
    this.bands = program(gl, BAND);
    this.meshes = new Map();
    gl.clearStencil(0);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  // Uploads triangles. `sizes` are the numbers per attribute. For open meshes both sides are drawn,
  // as the winding of other programs' meshes is unreliable.
  mesh(name, { vertices, indices }, sizes, instanced, open) {
    const { gl } = this;
    const old = this.meshes.get(name);
    if (old) this.forget(old);
    const mesh = { vao: gl.createVertexArray(), open, count: indices.length, buffers: [gl.createBuffer(), gl.createBuffer()] };
    gl.bindVertexArray(mesh.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    this.attributes(0, sizes, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.buffers[1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    if (instanced) {
      mesh.buffers.push(mesh.instances = gl.createBuffer());
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.instances);
      this.attributes(sizes.length, [4, 4, 4, 4, 4], 1);
    }
    gl.bindVertexArray(null);
    this.meshes.set(name, mesh);
  }

  attributes(first, sizes, divisor) {
    const { gl } = this;
    const stride = 4 * sizes.reduce((a, b) => a + b);
    let offset = 0;
    sizes.forEach((size, i) => {
      gl.enableVertexAttribArray(first + i);
      gl.vertexAttribPointer(first + i, size, gl.FLOAT, false, stride, offset);
      gl.vertexAttribDivisor(first + i, divisor);
      offset += 4 * size;
    });
  }

  forget(mesh) {
    mesh.buffers.forEach((buffer) => this.gl.deleteBuffer(buffer));
    this.gl.deleteVertexArray(mesh.vao);
  }

  dispose() {
    this.meshes.forEach((mesh) => this.forget(mesh));
    [this.bodies, this.floors, this.bands].forEach(({ made }) => this.gl.deleteProgram(made));
  }

  use({ made, places }, values) {
    const { gl } = this;
    gl.useProgram(made);
    for (const [name, value] of Object.entries(values)) {
      const place = places[name];
      if (!place) continue;
      if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else if (value.length) gl[`uniform${value.length}fv`](place, value);
      else gl.uniform1f(place, value);
    }
  }

  // Draws the bodies of a layer: mesh name -> numbers of its instances, one after the other.
  layer(bodies, values) {
    const { gl } = this;
    this.use(this.bodies, { sun: SUN, shadow: 0, fade: 1, shade: [0, 0, 0, 0], ...values });
    for (const [name, numbers] of bodies || []) {
      const mesh = this.meshes.get(name);
      gl.bindVertexArray(mesh.vao);
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.instances);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STREAM_DRAW);
      const culled = mesh.open && gl.isEnabled(gl.CULL_FACE);
      if (culled) gl.disable(gl.CULL_FACE);
      gl.drawElementsInstanced(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0, numbers.length / INSTANCE);
      if (culled) gl.enable(gl.CULL_FACE);
    }
  }

  draw(name, shader, values) {
    const mesh = this.meshes.get(name);
    if (!mesh) return;
    this.use(shader, values);
    this.gl.bindVertexArray(mesh.vao);
    this.gl.drawElements(this.gl.TRIANGLES, mesh.count, this.gl.UNSIGNED_INT, 0);
  }

  // Draws a frame into a rectangle of the canvas [x, y, width, height], in pixels from below.
  picture(view, scene) {
    const { gl } = this;
    const [x, y, width, height] = view.box;
    gl.viewport(x, y, width, height);
    gl.scissor(x, y, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
    gl.colorMask(true, true, true, true);
    gl.disable(gl.BLEND);
    gl.clearColor(...scene.colors.sky, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    const { clip, eye } = view;
    const { colors, layers } = scene;

    const floor = { clip, sun: SUN, base: scene.floorColor, line: colors.line, sky: colors.sky, cells: view.cells };
    const [tx, ty] = view.middle;
    floor.middle = view.middle;
    floor.reach = view.reach;
    if (scene.relief) this.draw('relief', this.floors, { ...floor, place: [0, 0, 0, 1] });
    else this.draw('plane', this.floors, { ...floor, place: [tx, ty, 0, view.reach] });

    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-1, -2);
    this.layer(layers.decal, { clip, eye });
    if (!scene.relief) {
      // Each pixel is darkened once, for any number of bodies.
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      this.layer(layers.solid, { clip, eye, shadow: 1, shade: colors.shade });
      gl.disable(gl.STENCIL_TEST);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.enable(gl.CULL_FACE);
    this.layer(layers.world, { clip, eye });
    // No glass is drawn over the robot itself: a ghost a millimetre away would only make it
    // spotted.
    gl.clear(gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.ALWAYS, 1, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    this.layer(layers.solid, { clip, eye });
    gl.disable(gl.STENCIL_TEST);
    this.layer(layers.mark, { clip, eye });
    gl.disable(gl.CULL_FACE);

    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-4, -16);
    for (const { name, color, width, later } of view.bands) {
      const band = { clip, width: [width, 1.1 * 2 * Math.tan(FOV / 2) / height], lift: 0.0008, color, now: scene.now, later };
      this.draw(name, this.bands, band);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    // Hidden parts shine faintly through the robot: contacts lie under wheels.
    gl.depthFunc(gl.GREATER);
    this.layer(layers.mark, { clip, eye, fade: 0.25 });
    gl.depthFunc(gl.LEQUAL);
    // Of glass only the nearest surface is drawn, and none before or behind the robot.
    gl.enable(gl.CULL_FACE);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 4);
    gl.depthMask(true);
    gl.colorMask(false, false, false, false);
    this.layer(layers.glass, { clip, eye });
    gl.colorMask(true, true, true, true);
    gl.depthMask(false);
    this.layer(layers.glass, { clip, eye });
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    this.layer(layers.cone, { clip, eye });
    gl.depthMask(true);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindVertexArray(null);
  }
}
