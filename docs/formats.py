#!/usr/bin/env python3
"""Writes docs/format-{scenario,robot,robot-on-tyres,study}.md from the schemas that `ilon schema` prints, with examples from assets.

`docs/formats.py ILON` writes them, with ILON the program; `docs/formats.py --check ILON` exits 1 where one is not up to date.
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FILES = {
    "scenario": (
        "The scenario file",
        "One run: a robot, its world and its motion. `ilon run` runs it, `ilon check` tests it against its `[expect]`. Pieces to copy: [cookbook](cookbook.md).",
        "assets/scenarios/*.toml",
        "assets/scenarios/mecanum4_wet_floor.toml",
    ),
    "robot": (
        "The robot in short",
        "A robot of one chassis and Swedish wheels. Every command takes it as a robot file; `ilon generate` writes it as URDF.",
        "assets/robots/*.toml",
        "assets/robots/mecanum4.toml",
    ),
    "robot-on-tyres": (
        "The robot on tyres in short",
        "A robot of one chassis and wheels on [tyres](tyres.md), some of them steered. Every command takes it as a robot file; `ilon generate` writes it as URDF.",
        "assets/robots/tricycle.toml",
        "assets/robots/tricycle.toml",
    ),
    "study": (
        "The study file",
        "Many runs of a scenario with varied keys, for `ilon sweep`. With explanations: [studies](sweeps.md).",
        "assets/studies/*.toml",
        "assets/studies/friction_path_loss.toml",
    ),
}
# The first keys of a file by task; what is not named stands in the table at the top and in the order of the schema.
TASKS = {
    "The robot": ["robot", "rollers"],
    "The world": ["world", "materials"],
    "The motion": ["twist", "reference", "playback", "guidance"],
    "Controller, wheel loops and motors": ["controller", "wheel_loop", "motors"],
    "Sensing": ["sensors"],
    "Faults and pushes": ["faults"],
    "The run": ["run"],
    "Expectations": ["expect"],
}
# Keys that mean the same in another section, by the section that has them too: where they are described, and which they are.
FLOOR = "[world.floor](#worldfloor)"
ROLLERS = "the scenario's [rollers](format-scenario.md#rollers)"
AS_IN = {
    "world.floor.patches[]": (FLOOR, "across against creep nap_deg radius_exponent rolling_resistance sliding", "else the floor's"),
    "materials.NAME.NAME": (FLOOR, "across against creep radius_exponent rolling_resistance sliding", ""),
    "robot's rollers": (
        ROLLERS,
        "axial_play_m axle_friction axle_radius_m bearings crown edge_radius_m length_factor material profile_m radius_offsets_m radius_seed radius_spread_m "
        "rolling_resistance",
        "",
    ),
    "robot's rollers.tread": (ROLLERS.replace("rollers", "rollers.tread", 1).replace("#rollers", "#rollerstread"), "damping_n_s_m relaxation_length_m shear_damping_n_s_m shear_stiffness_n_m", ""),
    "robot's wheel": ("the scenario's [motors](format-scenario.md#motors)", "gear_efficiency gear_friction_n_m gear_ratio rotor_inertia_kg_m2", ""),
}
LONGEST_EXAMPLE = 12
# A table of so many keys stands within the table of the section that has it.
SHORT_TABLE = 3
# The unit that the end of a key's name says already.
UNITS = {
    "_m": "metres",
    "_s": "seconds",
    "_deg": "degrees",
    "_kg": "kg",
    "_n": "N",
    "_n_m": "N m",
    "_m_s": "m/s",
    "_rad": "radians",
    "_rad_s": "rad/s",
    "_hz": "Hz",
    "_n_s_m": "N s/m",
    "_n_m_s": "N m s/rad",
    "_n_m_s_rad": "N m s/rad",
    "_n_m_rad": "N m/rad",
    "_per_s": "1/s",
    "_kg_m2": "kg m^2",
    "_m_s2": "m/s^2",
    "_n_s": "N s",
    "_kg_m3": "kg/m^3",
}


def words(text):
    """Text as it stands in a cell of a table."""
    return " ".join((text or "").split()).replace("|", "\\|")


def without_unit(key, text):
    """A description without the unit that its key names."""
    for end, unit in UNITS.items():
        if key.endswith(end):
            text = re.sub(rf",? in {re.escape(unit)}(?=[.,:;)]|$| \[)", "", text)
    return text


def labelled(key, what):
    """A quantity's key, with what it is where the key does not say it."""
    what = re.sub(", in [^,]*$", "", what.strip())
    known = {*key.split("_"), "the", "at", "of", "in", "by", "a", "end", "largest", "final", "error", "rms", "run"}
    return f"`{key}`" if {word.strip(",") for word in what.lower().split()} <= known else f"`{key}` ({what})"


def merged(rows):
    """Rows of keys that say the same, such as those of x and y or of joints that turn and that slide, as one."""
    lines = []
    for row in rows:
        name, rest = re.match(r"- (\S+)(.*)", row, re.DOTALL).groups()
        name = name.removesuffix(":")
        alike = re.sub(r"\b[xyz]\b", "x", rest)
        if lines and lines[-1][1] == alike:
            lines[-1][0].append((name, rest))
        else:
            lines.append(([(name, rest)], alike))
    text = []
    for names, _ in lines:
        axes = [re.search(r"\b[xyz]\b", rest) for _, rest in names]
        rest = names[0][1]
        if len(names) > 1 and all(axes):
            rest = re.sub(r"\b[xyz]\b", ", ".join(axis[0] for axis in axes), rest, count=1)
        colon = "" if not rest.strip() or rest.lstrip().startswith("(") else ":"
        text.append(f"- {', '.join(name for name, _ in names)}{colon}{rest}")
    return text


def news(text, said):
    """The sentences of a text that say more than another text."""
    known = set(re.findall(r"[\w`]+", said.lower())) | {"a", "an", "the", "of", "and", "in", "on", "that", "which", "is", "it", "its"}
    sentences = re.split(r"(?<=[.?])\s(?=[A-Z`])", text)
    return " ".join(s for s in sentences if len(set(re.findall(r"[\w`]+", s.lower())) - known) > 2)


def is_bound(schema):
    return schema.get("$ref", "").endswith("/Bound") or any(is_bound(o) for o in schema.get("anyOf", []))


class Reference:
    """The page of one schema."""

    def __init__(self, schema, examples, within=""):
        self.within = within
        self.definitions = schema.get("$defs", {})
        self.examples = examples
        references = re.findall(r'"#/\$defs/(\w+)"', json.dumps(schema))
        self.shared = {name for name in references if references.count(name) > 1}
        self.waiting = []
        self.named = {}
        # The description of the row that is being written: the section that it leads to does not repeat it.
        self.row_says = ""
        self.text = []

    def resolve(self, schema):
        """A schema without the reference that it may be, and its name if it is one."""
        if "$ref" in schema:
            name = schema["$ref"].split("/")[-1]
            return self.definitions[name], name
        for kind in ("anyOf", "oneOf", "allOf"):
            options = [o for o in schema.get(kind, []) if o.get("type") != "null"]
            if len(options) == 1:
                return self.resolve(options[0])
        return schema, None

    def kind(self, schema, path):
        """What a value may be, in words; objects and choices are described further down the page, at this path."""
        schema, name = self.resolve(schema)
        if "const" in schema:
            return f"`{json.dumps(schema['const'])}`"
        if "enum" in schema:
            return ", ".join(f"`{json.dumps(v)}`" for v in schema["enum"])
        options = schema.get("oneOf") or schema.get("anyOf")
        if options:
            if name is None or all("type" in o and o["type"] not in ("object", "array") for o in options):
                return ", ".join(dict.fromkeys(self.kind(o, path) for o in options if o.get("type") != "null"))
            return self.link(schema, name, path)
        kind = schema.get("type", "any")
        if isinstance(kind, list):
            kind = next(k for k in kind if k != "null")
        if kind == "array":
            items = schema.get("items", {})
            count = schema.get("minItems")
            inner = self.kind(items, path + "[]")
            return f"{count} x {inner}" if count and count == schema.get("maxItems") else f"list: {inner}"
        if kind == "object":
            if schema.get("properties"):
                return self.link(schema, name or path, path)
            more = schema.get("additionalProperties")
            return "table" + (f": {self.kind(more, path + '.NAME')}" if isinstance(more, dict) and more else "")
        return self.scalar(schema, kind)

    @staticmethod
    def scalar(schema, kind):
        """A number with its range, a text or a truth value, in words."""
        said = {"number": "number", "integer": "whole", "string": "text", "boolean": "`true`, `false`"}.get(kind, kind)
        low, high = schema.get("minimum"), schema.get("maximum")
        above, below = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
        if low is not None and high is not None:
            said += f" {low:g} to {high:g}"
        else:
            said += "".join(f" {sign} {limit:g}" for sign, limit in (("≥", low), (">", above), ("<", below), ("≤", high)) if limit is not None)
        return said

    def link(self, schema, name, path):
        """A link to the section of a schema, which is written once, under the path where it is met first."""
        if name not in self.named:
            # What stands in several places has a name of its own, the rest that of its place.
            own = re.sub(r"(?<!^)(?=[A-Z])", " ", name.removesuffix("Section")).capitalize()
            self.named[name] = own if name in self.shared else path
            self.waiting.append((schema, self.named[name], "" if name in self.shared else self.row_says))
        title = self.named[name]
        anchor = re.sub(r"[^a-z0-9_\- ]", "", title.lower()).replace(" ", "-")
        return f"[{title}](#{anchor})"

    def short_table(self, value):
        """The keys of a small table that stands in one place only, or none."""
        schema, name = self.resolve(value)
        keys = schema.get("properties")
        small = keys and len(keys) <= SHORT_TABLE and name not in self.shared and "array" not in (value.get("type"), schema.get("type"))
        return schema if small else None

    def row(self, key, value, path, required):
        """One key: name, bold where it is required; value with its default; what it does."""
        default = value.get("default")
        what = value.get("description") or self.resolve(value)[0].get("description") or ""
        self.row_says = what
        kind = self.kind(value, path)
        if default is not None and not isinstance(default, (dict, list)):
            kind += f"; `{json.dumps(default).removesuffix('.0')}`"
        name = f"**`{key}`**" if required else f"`{key}`"
        kind = re.sub(r"^number[; ]*", "", kind)
        value = f" ({kind})" if kind else ""
        what = words(without_unit(key, what))
        # A description that only repeats the key is left out.
        is_news = set(re.findall(r"\w+", what.lower())) - set(key.split("_")) - {"a", "the", "its", "their", "of", "coefficient"}
        return f"- {name}{value}: {what}" if is_news or not value else f"- {name}{value}"

    def rows(self, schema, path, before=""):
        lines = []
        there, alike, default = AS_IN.get(self.within + path, ("", "", ""))
        alike = alike.split()
        assert set(alike) <= set(schema["properties"]), f"AS_IN names keys that {path} does not have"
        for key, value in schema["properties"].items():
            if key in alike:
                continue
            below = f"{path}.{key}" if path else key
            inner = self.short_table(value)
            if inner:
                lines += self.rows(inner, below, f"{before}{key}.")
            else:
                lines.append(self.row(before + key, value, below, key in schema.get("required", [])))
        lines = merged(lines)
        if alike:
            lines.append(f"- {', '.join(f'`{key}`' for key in alike)}: as in {there}{default and f', {default}'}.")
        return lines

    def bounds(self, schema):
        """The quantities of `[expect]`, by what they are about; tables with the same keys stand together."""
        said, tables = {}, {}
        for key, value in schema["properties"].items():
            if is_bound(value):
                about, what = value["description"].split(":", 1)
                said.setdefault(about, []).append(labelled(key, what))
            elif key == "ledger":
                terms = self.resolve(value)[0]["properties"]
                keys = self.resolve(next(iter(terms.values())))[0]["properties"]
                said["error budget"] = [f"`ledger.TERM.KEY`, TERM one of {', '.join(terms)}; KEY one of {', '.join(keys)}"]
            elif self.all_bounds(value):
                inner = self.resolve(value)[0]["properties"]
                about = next(iter(inner.values()))["description"].split(":", 1)[0]
                names = [labelled(k, v["description"].split(":", 1)[1]) for k, v in inner.items()]
                tables.setdefault(", ".join(names), []).append(f"`{key}` ({about})")
        lines = [f"- **{about}:** {', '.join(each)}." for about, each in said.items()]
        lines += [f"- **below** {', '.join(owners)}: {names}." for names, owners in tables.items()]
        return ["Quantities, each with a [bound](#bound):\n", *lines, ""]

    def section(self, schema, path, row_says, level):
        self.text += [f"{'#' * level} {path}\n", news(words(schema.get("description")), row_says) + "\n"]
        example = self.examples.get(path)
        if example:
            self.text += ["```toml", example, "```\n"]
        if schema.get("properties"):
            others = {k: v for k, v in schema["properties"].items() if not self.all_bounds(v)}
            if len(others) < len(schema["properties"]) / 2:
                self.text += self.bounds(schema)
                schema = {**schema, "properties": others}
                self.kind({"$ref": "#/$defs/Bound"}, path)
            self.text += [*self.rows(schema, path), ""]
        else:
            self.choices(schema, path)
        below, self.waiting = self.waiting, []
        for inner in below:
            self.section(*inner, level=min(level + 1, 4))

    def all_bounds(self, value):
        """Whether a key is a bound, or a table of nothing but bounds."""
        inner = self.resolve(value)[0].get("properties")
        return is_bound(value) or bool(inner) and all(self.all_bounds(v) for v in inner.values())

    def choices(self, schema, path):
        """A choice: each option with its keys, and once the keys that most of them have."""
        options = schema.get("oneOf") or schema.get("anyOf")
        # Where one key says which it is, those beside it are the same for all.
        optional = [set(o.get("properties", {})) - set(o.get("required", [])) for o in options]
        beside = optional[0] if all(keys == optional[0] for keys in optional) else set()
        tables, plain = [], []
        for option in options:
            inner = {key: value for key, value in option.get("properties", {}).items() if key not in beside}
            if len(inner) == 1:
                (key, value), = inner.items()
                resolved, _ = self.resolve(value)
                if resolved.get("properties"):
                    rows = dict(zip(resolved["properties"], self.rows(resolved, f"{path}.{key}")))
                    tables.append((key, words(option.get("description")), rows))
                else:
                    plain.append(f"- `{key}` = {self.kind(value, f'{path}.{key}')}: {words(option.get('description'))}")
            elif inner:
                plain += [words(option.get("description")), *self.rows(option, path)]
            else:
                plain.append(f"- {self.kind(option, path)}: {words(option.get('description'))}")
        if plain:
            self.text += ["One of:\n", *plain, ""]
        if tables:
            every = [row for _, _, rows in tables for row in rows.values()]
            common = [row for row in dict.fromkeys(every) if every.count(row) > max(2, len(tables) / 2)]
            self.text.append("One of:\n" if not plain else "Or:\n")
            for key, what, rows in tables:
                self.text.append(f"- **{key}**: {what}")
                self.text += ["  " + row for row in rows.values() if row not in common]
            self.text.append("")
            for row in common:
                lacking = [f"`{key}`" for key, _, rows in tables if row not in rows.values()]
                but = f" but {', '.join(lacking)}" if lacking else ""
                self.text.append(f"Each{but} also has {row.removeprefix('- ')}\n")
        if beside:
            shared = {key: value for key, value in options[0]["properties"].items() if key in beside}
            self.text += ["Beside it:\n", *self.rows({"properties": shared}, path), ""]

    def page(self, schema, tasks):
        rows = {key: self.row(key, value, key, key in schema.get("required", [])) for key, value in schema["properties"].items()}
        waiting, self.waiting = {path.removesuffix("[]").split(".")[0]: (inner, path, says) for inner, path, says in self.waiting}, []
        order = tasks or {"": list(rows)}
        self.text += [*(rows[key] for keys in order.values() for key in keys), ""]
        assert sorted(key for keys in order.values() for key in keys) == sorted(rows), "TASKS names every first key once"
        for task, keys in order.items():
            if task:
                self.text += [f"## {task}\n"]
            for key in keys:
                if key in waiting:
                    self.section(*waiting[key], level=3 if task else 2)
        return re.sub(r"\n{3,}", "\n\n", "\n".join(self.text)).rstrip() + "\n"


def part(text, key):
    """The lines of a TOML file that say something below a key."""
    kept, inside = [], False
    for line in text.splitlines():
        header = re.match(r"\[+([^\]]+)\]+", line)
        if header:
            inside = header[1] == key or header[1].startswith(key + ".")
        top = re.match(rf"{re.escape(key)}(\.[\w.]+)? *=", line) and not any(h.startswith("[") for h in kept)
        if (inside or top) and not line.startswith("#"):
            kept.append(re.sub(r"\s+# .*$", "", line))
    return "\n".join(kept).strip()


def examples(files):
    """For each first key the part of an asset that says most of it in few lines."""
    found = {}
    for path in sorted(ROOT.glob(files)):
        text = path.read_text()
        whole = tomllib.loads(text)
        # Robots on tyres have a page of their own.
        for key in whole if "tyres" not in whole or path.name == Path(files).name else ():
            said = part(text, key)
            lines = said.count("\n") + 1
            if said and lines <= LONGEST_EXAMPLE and lines > found.get(key, "").count("\n") + (key in found):
                found[key] = said
    return {**found, **{f"{key}[]": said for key, said in found.items()}}


def page(ilon, kind):
    title, says, files, whole = FILES[kind]
    schema = json.loads(subprocess.run([ilon, "schema", kind], check=True, capture_output=True, text=True).stdout)
    text = f"# {title}\n\n{says}\n\n"
    text += "The file is TOML. Unknown keys are refused. **Bold** keys are required. In brackets: the kind of value (a number unless said) or the possible\n"
    text += "values; then the range and the default. The end of a name is the unit: `_m` metres, `_s` seconds, `_deg` degrees, `_n_m` N m, `_per_s` 1/s.\n"
    text += f"For an editor: `ilon schema {kind}` prints a JSON Schema. Written by `docs/formats.py`.\n\n"
    text += f"A whole file: [{Path(whole).name}](../{whole}).\n\n"
    return text + Reference(schema, examples(files), "robot's " if kind == "robot" else "").page(schema, TASKS if kind == "scenario" else {})


def main():
    check = sys.argv[1:2] == ["--check"]
    ilon = sys.argv[2 if check else 1]
    for kind in FILES:
        file = ROOT / "docs" / f"format-{kind}.md"
        text = page(ilon, kind)
        if not check:
            file.write_text(text)
        elif not file.exists() or file.read_text() != text:
            sys.exit(f"docs/{file.name} is not up to date: run docs/formats.py with the program")


if __name__ == "__main__":
    main()
