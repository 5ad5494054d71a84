// The settings, made from the schemas of a scenario and of a robot description.

// The settings shown first: a key, its name, the range of its slider, and the section without which
// it would have no effect. All others are found by their keys.
const FIRST = [
  ['world.floor.friction', 'Friction of the floor', 0, 1.2],
  ['world.floor.slope_deg', 'Slope of the floor', -20, 20],
  ['twist.vx_m_s', 'Speed ahead', -1, 1],
  ['twist.vy_m_s', 'Speed to the left', -1, 1],
  ['twist.omega_rad_s', 'Yaw rate', -3, 3],
  ['robot.spec.wheels.mecanum.gamma_deg', 'Roller angle γ', 15, 75],
  ['robot.spec.wheels.ring.gamma_deg', 'Roller angle γ', -60, 60],
  ['robot.spec.rollers.per_row', 'Rollers of a wheel', 4, 24],
  ['robot.spec.chassis.mass_kg', 'Mass of the chassis', 1, 60],
  ['robot.spec.rollers.mass_kg', 'Mass of a roller', 0.001, 0.2],
  ['guidance.position_gain_per_s', 'Gain on the position error', 0.1, 8, 'reference'],
  ['guidance.heading_gain_per_s', 'Gain on the heading error', 0.1, 8, 'reference'],
  ['sensors.pose.latency_s', 'Age of a pose when it is seen', 0, 0.5, 'reference'],
  ['run.duration_s', 'Duration', 1, 60],
];

// Required values of faults that a schema cannot express.
const OF_FAULTS = {
  roller: 0, factor: 0.9, x_m: 0.2, y_m: 0, heading_deg: 20, share: 0.6, impulse_x_n_s: 0, impulse_y_n_s: 4, mass_kg: 5, friction: 0.1,
};

// A part of a schema with its references resolved.
function part(root, schema) {
  if (!schema || !schema.$ref) return schema || {};
  const found = schema.$ref.slice(2).split('/').reduce((at, key) => at[key], root);
  return { ...found, ...Object.fromEntries(Object.entries(schema).filter(([key]) => key !== '$ref')) };
}

// All alternatives of a schema, with their own description or that of the whole.
function ways(root, schema) {
  const whole = part(root, schema);
  const below = ['anyOf', 'oneOf', 'allOf'].flatMap((kind) => whole[kind] || []);
  return [whole, ...below.flatMap((one) => ways(root, one).map((way) => ({ ...way, description: whole.description || way.description })))];
}

// All keys of single values, by their dotted names: description, type, bounds.
function keysOf(root, schema, prefix, found = new Map(), depth = 0) {
  for (const way of ways(root, schema)) {
    for (const [name, below] of Object.entries(way.properties || {})) {
      const key = prefix ? `${prefix}.${name}` : name;
      if (depth < 8 && key !== 'expect' && key !== 'faults') keysOf(root, below, key, found, depth + 1);
    }
    const types = [way.type].flat().filter(Boolean);
    const type = ['integer', 'number', 'boolean', 'string'].find((one) => types.includes(one));
    if (!prefix || !(type || 'const' in way || way.enum)) continue;
    const old = found.get(prefix) || { choices: [] };
    found.set(prefix, {
      key: prefix,
      about: old.about || way.description || '',
      type: old.type && old.type !== 'string' ? old.type : type || 'string',
      min: way.minimum ?? way.exclusiveMinimum ?? old.min,
      max: way.maximum ?? way.exclusiveMaximum ?? old.max,
      above: old.above || way.exclusiveMinimum !== undefined,
      choices: [...old.choices, ...(way.enum || ('const' in way ? [way.const] : []))],
    });
  }
  return found;
}

const UNITS = [
  ['_n_m_s2', 'N m s²'], ['_n_m_s', 'N m s'], ['_kg_m3', 'kg/m³'], ['_kg_m2', 'kg m²'], ['_rad_s', 'rad/s'], ['_m_s2', 'm/s²'], ['_m_s', 'm/s'],
  ['_per_s', '1/s'], ['_deg_s', '°/s'], ['_n_m', 'N m'], ['_n_s', 'N s'], ['_deg', '°'], ['_kg', 'kg'], ['_hz', 'Hz'], ['_rad', 'rad'], ['_m', 'm'], ['_s', 's'],
];
const unitOf = (key) => (UNITS.find(([end]) => key.endsWith(end)) || ['', ''])[1];

// The value of a dotted key.
const valueAt = (values, key) => key.split('.').reduce((at, name) => (at === null || at === undefined ? undefined : at[name]), values);

// A range that contains the value, within the schema's bounds, and a round step.
function rangeOf(known, low, high, value) {
  const most = known.max ?? Infinity;
  let least = known.min ?? -Infinity;
  const top = Math.min(most, Math.max(high, Number.isFinite(value) ? value * (value > 0 ? 1.5 : 1) : high));
  const whole = known.type === 'integer';
  const step = whole ? 1 : 10 ** Math.floor(Math.log10(Math.max(top - Math.max(low, least), 1e-9) / 50));
  if (known.above && least >= 0) least += step;
  return { min: Math.max(least, Math.min(low, Number.isFinite(value) ? value : low)), max: top, step };
}

// The kinds of faults, each with its required fields.
function faultsOf(root) {
  const list = ways(root, root.properties.faults).find((way) => way.items);
  const kinds = list ? ways(root, list.items).filter((way) => way.properties) : [];
  return kinds.flatMap((kind) => Object.entries(kind.properties).map(([name, schema]) => {
    const { properties = {}, required = [] } = ways(root, schema).find((way) => way.properties) || {};
    return { name, fields: Object.keys(properties), required, about: kind.description || part(root, schema).description || '' };
  }));
}

// A fault as the value of `faults`, after the scenario's own.
function faultAs(kind, wheel, fromS, before) {
  const text = (value) => (typeof value === 'string' ? `"${value}"` : String(value));
  const fields = kind.fields.flatMap((name) => {
    if (name === 'wheel') return [`wheel = ${text(wheel)}`];
    if (name === 'from_s') return [`from_s = ${fromS}`];
    if (name === 'impulse_y_n_s' || kind.required.includes(name)) return name in OF_FAULTS ? [`${name} = ${OF_FAULTS[name]}`] : [];
    return [];
  });
  return `[${[...before, `{ ${kind.name} = { ${fields.join(', ')} } }`].join(', ')}]`;
}

// A JSON value as TOML on one line.
function asToml(value) {
  if (Array.isArray(value)) return `[${value.map(asToml).join(', ')}]`;
  if (value !== null && typeof value === 'object') {
    const pairs = Object.entries(value).filter(([, below]) => below !== null);
    return `{ ${pairs.map(([key, below]) => `${key} = ${asToml(below)}`).join(', ')} }`;
  }
  return JSON.stringify(value);
}
