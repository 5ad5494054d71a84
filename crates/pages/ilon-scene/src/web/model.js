// The drawn content at a time: the robot, its ghost and the forces, as lists of bodies for the
// renderer.

// Share of the friction limit from which it counts as reached: below it a contact grips.
const AT_THE_LIMIT = 0.985;
// Below this a contact does not slide: the solver's rounding, in m/s.
const NO_SLIDE_M_S = 1e-3;

const ARROW = { shaft: [[-0.5, 0], [-0.5, 1], [0.5, 1]], head: [[0, 0], [0, 1], [1, 0]] };

// Whether something with a start, and an end or none, exists at a time.
const isThere = ({ from_s: from, until_s: until }, t) => t >= from && !(t >= (until ?? Infinity));

class Model {
  constructor(data) {
    this.data = data;
    this.robot = data.robot;
    this.floor = data.ground;
    this.relief = data.relief;
    for (const wheel of this.robot.wheels) {
      wheel.at = fromPose(wheel.body_from_hub);
      wheel.rollers.forEach((roller) => { roller.at = fromPose(roller.hub_from_roller); });
    }
    // A body on a joint is drawn in the body frame, at its zero position, and moved about its
    // joint's axis or along it.
    this.parts = this.robot.bodies || [];
    this.parts.forEach((part) => { part.at = fromPose(part.body_from_joint); });
    const load = this.robot.weight_n / this.robot.wheels.length;
    const radius = Math.max(...this.robot.wheels.map((wheel) => wheel.radius_m));
    this.unit = radius;
    // The load of a wheel at rest is an arrow of 1.7 radii. Sliding: half a radius for a tenth of a
    // metre per second.
    this.meterPerNewton = 1.7 * radius / load;
    this.meterPerSpeed = 5 * radius;
    this.slideMax = 2.5 * radius;
    if (this.relief) {
      const relief = this.relief;
      relief.heights = decoded({ data: relief.data, scale: relief.scale }, bytesOf(relief.data).length / 2);
    }
  }

  // Loads all constant shapes into a new renderer.
  load(renderer) {
    const body = (name, triangles) => renderer.mesh(name, triangles, [3, 3, 1], true);
    body('box', cube());
    body('cylinder', lathe([[-0.5, 0], [-0.5, 1], [0.5, 1], [0.5, 0]], 40));
    body('ring', lathe([[0, 0.9], [0, 1]], 60));
    body('shaft', lathe(ARROW.shaft, 12));
    body('head', lathe(ARROW.head, 16));
    body('cone', lathe([[0, 0], [1, 1]], 40));
    body('sphere', lathe(Array.from({ length: 17 }, (_, k) => {
      const angle = Math.PI * (k / 16 - 0.5);
      return [Math.sin(angle), k % 16 ? Math.cos(angle) : 0];
    }), 24));
    this.robot.lathes.forEach((outline, k) => body(`lathe${k}`, lathe(outline, 14)));
    (this.robot.meshes || []).forEach((mesh, k) => renderer.mesh(`mesh${k}`, surface(mesh), [3, 3, 1], true, true));
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([x, y]) => [x, y, 0, 0, 0, 1, 0]);
    renderer.mesh('plane', { vertices: corners, indices: [0, 1, 2, 0, 2, 3] }, [3, 3, 1]);
    if (this.relief) renderer.mesh('relief', heightField(this.relief), [3, 3, 1]);
  }

  // The body frame as moved by each body on a joint.
  moved(frames, body) {
    const moved = [];
    this.parts.forEach((part, k) => {
      const q = frames.get(`j${k}`) || 0;
      const there = part.slides ? mul(part.at, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, q]) : turnedZ(part.at, q);
      moved.push(mul(part.parent === undefined ? body : moved[part.parent], mul(there, inverse(part.at))));
    });
    return moved;
  }

  // The robot's state from the current frames.
  state(frames) {
    const get = (name) => frames.get(name);
    const of = (names) => names.split(' ').map(get);
    const body = fromAngles(...of('x y z roll pitch yaw'));
    const parts = this.moved(frames, body);
    const wheels = this.robot.wheels.map((wheel, w) => {
      const name = (what) => `w${w}_${what}`;
      const carrier = wheel.carrier === undefined ? body : parts[wheel.carrier];
      const hub = turnedZ(mul(carrier, wheel.at), get(name('angle')));
      const [cx, cy, normal, fx, fy, sx, sy, friction] =
        'contact_x contact_y normal force_x force_y slip_x slip_y friction'.split(' ').map((what) => get(name(what)));
      // The contact's place, force and sliding are along the body's axes, projected to the
      // horizontal.
      const yaw = get('yaw');
      const level = (x, y, z) => [x * Math.cos(yaw) - y * Math.sin(yaw), x * Math.sin(yaw) + y * Math.cos(yaw), z];
      const center = originOf(hub);
      const at = add([get('x'), get('y'), 0], level(cx, cy, 0));
      // On the circle of the wheel's outline: below the hub, or on its flank while it climbs.
      const axis = turn(hub, [0, 0, 1]);
      const ahead = dot(sub([at[0], at[1], center[2]], center), unit(cross(axis, [0, 0, 1])));
      at[2] = center[2] - Math.sqrt(Math.max(wheel.radius_m ** 2 - ahead ** 2, 0));
      const roller = Math.round(get(name('roller')));
      return {
        name: wheel.name, index: w, hub, center, axis, touching: normal > 0, normal, friction, at,
        roller: wheel.rollers[roller] ? roller : 0,
        force: level(fx, fy, normal), slip: level(sx, sy, 0),
        used: normal * friction > 0 ? Math.hypot(fx, fy) / (normal * friction) : 0,
        sliding: Math.hypot(sx, sy),
        rollerAngles: wheel.rollers.map((_, r) => get(name(`r${r}`)) || 0),
      };
    });
    return { t: get('t'), body, parts, wheels, at: originOf(body), yaw: get('yaw') };
  }

  // The wheel's loaded roller, seen from the ground: the tilt of its axis, and how far ahead it
  // touches.
  touch(wheel) {
    const of = this.robot.wheels[wheel.index];
    const at = mul(wheel.hub, of.rollers[wheel.roller].at);
    const axis = turn(at, [0, 0, 1]);
    // The direction of the roller's axis when it is straight below: that of the ideal kinematics.
    const level = unit([wheel.axis[0], wheel.axis[1], 0]);
    const [c, s] = [Math.cos(of.gamma_rad), Math.sin(of.gamma_rad)];
    const rolling = [c * level[0] - s * level[1], s * level[0] + c * level[1], 0];
    // A tyre turns about the hub's own axis.
    const ideal = of.rollers.length === 1 ? level : cross([0, 0, 1], rolling);
    const offset = sub(wheel.at, wheel.center);
    const ahead = cross(level, [0, 0, 1]);
    const flat = unit([axis[0], axis[1], 0]);
    return {
      at: originOf(at), axis, ideal, rolling, tilt_rad: Math.asin(clamp(Math.abs(axis[2]), 0, 1)),
      turned_rad: Math.acos(clamp(Math.abs(dot(flat, ideal)), 0, 1)),
      ahead_m: dot(offset, ahead), aside_m: dot(offset, level),
    };
  }

  // The ghost's pose: by the ideal kinematics, or on an alternative motion by its index among the
  // scene's.
  ghost(frames, t, way) {
    const poses = way === null || way === undefined ? null : this.data.ways[way].poses;
    if (!poses) return ['ghost_x', 'ghost_y', 'ghost_yaw'].map((name) => frames.get(name));
    const next = poses.findIndex((pose) => pose[0] > t);
    const [from, to] = next < 0 ? [poses.at(-1), poses.at(-1)] : [poses[Math.max(next - 1, 0)], poses[next]];
    const part = to[0] > from[0] ? Math.max((t - from[0]) / (to[0] - from[0]), 0) : 0;
    const turned = Math.atan2(Math.sin(to[3] - from[3]), Math.cos(to[3] - from[3]));
    return [from[1] + part * (to[1] - from[1]), from[2] + part * (to[2] - from[2]), from[3] + part * turned];
  }

  bodies(frames, state, colors, options) {
    const layers = Object.fromEntries(['decal', 'world', 'solid', 'mark', 'glass', 'cone'].map((name) => [name, new Map()]));
    const put = (layer, mesh, at, color, style) => {
      if (!layers[layer].has(mesh)) layers[layer].set(mesh, []);
      layers[layer].get(mesh).push(...at, ...color.slice(0, 3), color.length > 3 ? color[3] : 1, ...(style || [0, 0, 0.15, 0]));
    };
    const arrow = (layer, from, way, radius, color) => {
      const length = norm(way);
      if (!(length > 1e-6)) return;
      const head = Math.min(4 * radius, 0.6 * length);
      const z = times(way, 1 / length);
      const shaft = along(add(from, times(z, (length - head) / 2)), z);
      put(layer, 'shaft', scaled(shaft, radius, radius, length - head), color, [0, 0, 0, 0.6]);
      const tip = along(add(from, times(z, length - head)), z);
      put(layer, 'head', scaled(tip, 2.1 * radius, 2.1 * radius, head), color, [0, 0, 0, 0.6]);
    };
    const shape = (layer, { kind, pose, size, color }, body, paint) => {
      const at = mul(body, fromPose(pose));
      const scale = { cylinder: [size[0], size[0], size[1]], sphere: [size[0], size[0], size[0]], mesh: size.scale }[kind] || size;
      put(layer, kind === 'mesh' ? `mesh${size.index}` : kind, scaled(at, ...scale), paint || color || colors.chassis);
    };
    const { robot, unit: u } = this;

    this.ground(state.t, put, arrow, state, colors);
    (this.data.bodies || []).forEach((part, b) => {
      const at = ['x', 'y', 'z', 'roll', 'pitch', 'yaw'].map((name) => frames.get(`b${b}_${name}`));
      if (at.every(Number.isFinite)) shape('solid', part, fromAngles(...at), part.color || colors.box);
    });
    if (!Number.isFinite(state.at[0])) return layers;
    const { alone } = options;
    if (alone === undefined) {
      robot.chassis.forEach((part) => shape('solid', part, state.body));
      this.parts.forEach((part, k) => part.shapes.forEach((one) => shape('solid', one, state.parts[k])));
      // This points ahead.
      arrow('solid', apply(state.body, robot.nose), turn(state.body, [0.9 * u, 0, 0]), 0.06 * u, colors.accent);
    }
    const rollers = (layer, hub, wheel, angles, paint) => {
      robot.wheels[wheel].rollers.forEach((roller, r) => {
        const color = paint(r);
        const at = turnedZ(mul(hub, roller.at), angles[r]);
        if (color) put(color[3] < 1 ? 'glass' : layer, `lathe${roller.lathe}`, at, color, [4, 0.16, 0.18, 0]);
      });
    };
    const hubs = (layer, hub, wheel, paint) => robot.wheels[wheel].hub.forEach((part) => {
      const at = mul(hub, fromPose(part.pose));
      const scale = part.kind === 'cylinder' ? [part.size[0], part.size[0], part.size[1]] : null;
      if (scale) put(layer, 'cylinder', scaled(at, ...scale), paint, [5, 0.18, 0.3, 0]);
      else shape(layer, part, hub, part.color || paint);
    });
    state.wheels.forEach((wheel, w) => {
      if (alone !== undefined && alone !== w) return;
      const near = alone === w;
      const touching = (r) => wheel.touching && r === wheel.roller;
      const gripping = wheel.used < AT_THE_LIMIT;
      rollers('solid', wheel.hub, w, wheel.rollerAngles, (r) => {
        if (touching(r)) return gripping ? colors.touching : colors.sliding;
        return near ? [...colors.roller, 0.3] : colors.roller;
      });
      hubs(near ? 'glass' : 'solid', wheel.hub, w, near ? [...colors.hub, 0.3] : colors.hub);
      if (!near && options.selected === w) {
        const ring = scaled(along([wheel.center[0], wheel.center[1], 0.001], [0, 0, 1]), 1.5 * u, 1.5 * u, 1e-4);
        put('decal', 'ring', ring, [...colors.accent, 0.8], [0, 0, 0, 1]);
      }
      if (!wheel.touching) return;
      const paint = gripping ? colors.grip : colors.sliding;
      put('mark', 'sphere', scaled(along(wheel.at, [0, 0, 1]), 0.09 * u, 0.09 * u, 0.09 * u), paint, [0, 0, 0, 0.6]);
      arrow('mark', wheel.at, times(wheel.force, this.meterPerNewton), 0.045 * u, paint);
      // The friction cone, as high as the load.
      const height = wheel.normal * this.meterPerNewton;
      const cone = along(wheel.at, [0, 0, 1]);
      put('cone', 'cone', scaled(cone, height * wheel.friction, height * wheel.friction, height), [...paint, 0.16], [0, 0, 0, 0.7]);
      if (wheel.sliding > NO_SLIDE_M_S) {
        const length = Math.min(wheel.sliding * this.meterPerSpeed, this.slideMax);
        arrow('mark', add(wheel.at, [0, 0, 0.05 * u]), times(unit(wheel.slip), length), 0.045 * u, colors.slip);
      }
      if (near) this.axes(wheel, put, colors);
    });
    const ghost = options.ghost && alone === undefined ? this.ghost(frames, state.t, options.way) : [NaN];
    if (Number.isFinite(ghost[0])) {
      const [x, y, yaw] = ghost;
      const lean = ['roll', 'pitch'].map((name) => frames.get(name));
      const body = fromAngles(x, y, frames.get('z'), ...lean, yaw);
      const paint = [...colors.ghost, 0.32];
      robot.chassis.forEach((part) => shape('glass', part, body, paint));
      const parts = this.moved(frames, body);
      this.parts.forEach((part, k) => part.shapes.forEach((one) => shape('glass', one, parts[k], paint)));
      state.wheels.forEach((wheel, w) => {
        const { carrier, at } = robot.wheels[w];
        const hub = turnedZ(mul(carrier === undefined ? body : parts[carrier], at), frames.get(`w${w}_angle`));
        rollers('glass', hub, w, wheel.rollerAngles, () => paint);
        hubs('glass', hub, w, paint);
      });
    }
    if (options.push) arrow('mark', state.at, sub(options.push, state.at), 0.12 * u, colors.sliding);
    if (options.wanted && alone === undefined && Number.isFinite(frames.get('want_x'))) {
      const at = fromAngles(frames.get('want_x'), frames.get('want_y'), 0.002, 0, 0, frames.get('want_yaw'));
      put('mark', 'sphere', scaled(at, 0.13 * u, 0.13 * u, 0.03 * u), colors.reference, [0, 0, 0, 0.7]);
      arrow('mark', originOf(at), turn(at, [1.2 * u, 0, 0]), 0.04 * u, colors.reference);
    }
    return layers;
  }

  // In the close-up: the contacting roller's axis, its projection on the ground, and that of the
  // ideal kinematics.
  axes(wheel, put, colors) {
    const { at, axis, ideal } = this.touch(wheel);
    const u = this.unit;
    const rod = (center, way, length, color, radius) => put('mark', 'shaft',
      scaled(along(center, unit(way)), radius, radius, length), color, [0, 0, 0, 0.7]);
    rod(at, axis, 1.9 * u, colors.touching, 0.022 * u);
    const ground = wheel.at[2] + 0.004 * u;
    rod([wheel.at[0], wheel.at[1], ground], [axis[0], axis[1], 0], 2.4 * u, colors.touching, 0.014 * u);
    rod([wheel.center[0], wheel.center[1], ground], ideal, 2.4 * u, colors.ghost, 0.014 * u);
    // Straight below the hub, where the ideal kinematics places the contact.
    const foot = along([wheel.center[0], wheel.center[1], ground], [0, 0, 1]);
    put('mark', 'sphere', scaled(foot, 0.06 * u, 0.06 * u, 0.03 * u), colors.ghost, [0, 0, 0, 0.7]);
  }

  // Patches, boxes, pushes: the world's content at a time.
  ground(t, put, arrow, state, colors) {
    for (const patch of this.floor.patches.filter((patch) => isThere(patch, t))) {
      const [[x, y], [a, b]] = [patch.center_m, patch.sides_m.map((side) => 0.5 * side)];
      put('decal', 'box', [a, 0, 0, x, 0, b, 0, y, 0, 0, 1e-4, 5e-4], [...this.frictionColor(patch.friction, colors), 0.55], [0, 0, 0, 1]);
    }
    // A box is placed by the centre of its base, a ramp by its own centre.
    for (const { center_m: [x, y, z], sides_m: sides, heading_rad: heading, pitch_rad: pitch = 0 } of [...this.floor.boxes, ...this.floor.ramps || []]) {
      put('world', 'box', scaled(fromAngles(x, y, z ?? 0.5 * sides[2], 0, pitch, heading), ...sides.map((side) => 0.5 * side)), colors.box);
    }
    for (const { from_s: from, until_s: until, kind: { push } } of this.data.faults || []) {
      // A short push is shown for half a second, so that it is visible.
      if (!push || !(t >= from && t < Math.max(until, from + 0.5)) || !Number.isFinite(state.at[0])) continue;
      const level = fromAngles(0, 0, 0, 0, 0, push.in_body ? state.yaw : 0);
      const way = times(unit(turn(level, push.impulse_n_s)), 4 * this.unit);
      const tip = apply(state.body, push.place_m);
      arrow('mark', sub(tip, way), way, 0.12 * this.unit, colors.sliding);
    }
  }

  // Slippery is blue, rough is brown, and the friction of the rest of the floor has no colour.
  frictionColor(friction, colors) {
    const part = clamp(Math.abs(friction - this.floor.friction) / Math.max(this.floor.friction, 0.1), 0.15, 1);
    const to = friction < this.floor.friction ? colors.wet : colors.rough;
    return colors.floor.map((c, i) => c + (to[i] - c) * part);
  }

  // The whole floor's colour: it shows a change of the overall friction.
  floorColor(t, colors) {
    const now = (this.data.faults || []).filter((fault) => fault.kind.friction_changed && isThere(fault, t)).pop();
    return now ? this.frictionColor(now.kind.friction_changed.friction, colors).map((c, i) => c + 0.6 * (colors.floor[i] - c)) : colors.floor;
  }
}
