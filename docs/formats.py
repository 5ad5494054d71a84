#!/usr/bin/env python3
"""Writes docs/format-{scenario,robot,study}.md from the schemas that `ilon schema` prints, with examples from assets.

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
        "One run: a robot, its world, and what it is asked to do. `ilon run` takes it, `ilon check` holds it against its own `[expect]`.",
        "assets/scenarios",
        "assets/scenarios/mecanum4_wet_floor.toml",
    ),
    "robot": (
        "The robot in short",
        "A robot of one chassis and Swedish wheels. `ilon generate` makes a URDF of it, and everything that takes a robot's file takes it too.",
        "assets/robots",
        "assets/robots/mecanum4.toml",
    ),
    "study": (
        "The study file",
        "Many runs of a scenario under keys that vary. `ilon sweep` takes it.",
        "assets/studies",
        "assets/studies/friction_path_loss.toml",
    ),
}
LONGEST_EXAMPLE = 14


def words(text):
    """Text as it stands in a cell of a table."""
    return " ".join((text or "").split()).replace("|", "\\|")


class Reference:
    """The page of one schema."""

    def __init__(self, schema, examples):
        self.definitions = schema.get("$defs", {})
        self.examples = examples
        references = re.findall(r'"#/\$defs/(\w+)"', json.dumps(schema))
        self.shared = {name for name in references if references.count(name) > 1}
        self.waiting = []
        self.named = {}
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
                return " or ".join(dict.fromkeys(self.kind(o, path) for o in options if o.get("type") != "null"))
            return self.link(schema, name, path)
        kind = schema.get("type", "any")
        if isinstance(kind, list):
            kind = next(k for k in kind if k != "null")
        if kind == "array":
            items = schema.get("items", {})
            count = schema.get("minItems")
            inner = self.kind(items, path + "[]")
            return f"{count} of: {inner}" if count and count == schema.get("maxItems") else f"list of: {inner}"
        if kind == "object":
            if schema.get("properties"):
                return self.link(schema, name or path, path)
            more = schema.get("additionalProperties")
            return "table" + (f" of {self.kind(more, path + '.NAME')}" if isinstance(more, dict) and more else "")
        said = {"number": "number", "integer": "whole number", "string": "text", "boolean": "`true` or `false`"}.get(kind, kind)
        for key, sign in (("exclusiveMinimum", "above"), ("minimum", "from"), ("exclusiveMaximum", "below"), ("maximum", "to")):
            if key in schema:
                said += f" {sign} {schema[key]:g}"
        return said

    def link(self, schema, name, path):
        """A link to the section of a schema, which is written once, under the path where it is met first."""
        if name not in self.named:
            # What stands in several places has a name of its own, the rest that of its place.
            own = re.sub(r"(?<!^)(?=[A-Z])", " ", name.removesuffix("Section")).capitalize()
            self.named[name] = own if name in self.shared else path
            self.waiting.append((schema, self.named[name]))
        title = self.named[name]
        anchor = re.sub(r"[^a-z0-9_\- ]", "", title.lower()).replace(" ", "-")
        return f"[{title}](#{anchor})"

    def rows(self, schema, path):
        required = schema.get("required", [])
        lines = ["| key | value | default | what |", "|---|---|---|---|"]
        for key, value in schema["properties"].items():
            default = "required" if key in required else ""
            if value.get("default") is not None and not isinstance(value["default"], (dict, list)):
                default = f"`{json.dumps(value['default'])}`"
            what = value.get("description") or self.resolve(value)[0].get("description")
            below = f"{path}.{key}" if path else key
            lines.append(f"| `{key}` | {self.kind(value, below)} | {default} | {words(what)} |")
        return lines

    def section(self, schema, path):
        self.text += [f"\n## {path}\n", words(schema.get("description")) + "\n"]
        example = self.examples.get(path)
        if example:
            self.text += ["```toml", example, "```\n"]
        if schema.get("properties"):
            self.text += self.rows(schema, path)
            return
        self.text += ["One of these:\n"]
        options = schema.get("oneOf") or schema.get("anyOf")
        # Where one key says which it is, those beside it are the same for all.
        optional = [set(o.get("properties", {})) - set(o.get("required", [])) for o in options]
        beside = optional[0] if all(keys == optional[0] for keys in optional) else set()
        for option in options:
            what = words(option.get("description"))
            inner = {key: value for key, value in option.get("properties", {}).items() if key not in beside}
            if len(inner) == 1:
                (key, value), = inner.items()
                resolved, _ = self.resolve(value)
                if resolved.get("properties"):
                    self.text += [f"### {path}.{key}\n", what + "\n", *self.rows(resolved, f"{path}.{key}"), ""]
                else:
                    self.text += [f"- `{key}`: {self.kind(value, f'{path}.{key}')}. {what}\n"]
            elif inner:
                self.text += [what + "\n", *self.rows(option, path), ""]
            else:
                self.text += [f"- {self.kind(option, path)}: {what}\n"]
        if beside:
            shared = {key: value for key, value in options[0]["properties"].items() if key in beside}
            self.text += ["Beside it:\n", *self.rows({"properties": shared}, path), ""]

    def page(self, schema):
        self.text += self.rows(schema, "")
        done = 0
        while done < len(self.waiting):
            self.section(*self.waiting[done])
            done += 1
        return "\n".join(self.text) + "\n"


def part(text, key):
    """The lines of a TOML file that say something below a key."""
    kept, inside = [], False
    for line in text.splitlines():
        header = re.match(r"\[+([^\]]+)\]+", line)
        if header:
            inside = header[1] == key or header[1].startswith(key + ".")
        top = re.match(rf"{re.escape(key)}(\.[\w.]+)? *=", line) and not any(h.startswith("[") for h in kept)
        if inside or top:
            kept.append(line)
    return "\n".join(kept).strip()


def examples(folder):
    """For each first key the part of an asset that says most of it in few lines."""
    found = {}
    for path in sorted((ROOT / folder).glob("*.toml")):
        text = path.read_text()
        for key in tomllib.loads(text):
            said = part(text, key)
            lines = said.count("\n") + 1
            if said and lines <= LONGEST_EXAMPLE and lines > found.get(key, "").count("\n") + (key in found):
                found[key] = said
    return {**found, **{f"{key}[]": said for key, said in found.items()}}


def page(ilon, kind):
    title, says, folder, whole = FILES[kind]
    schema = json.loads(subprocess.run([ilon, "schema", kind], check=True, capture_output=True, text=True).stdout)
    text = f"# {title}\n\n{says} It is TOML; keys that are not listed here are refused. Lengths are in metres, times in seconds, and angles in\n"
    text += f"degrees where the key ends in `_deg`. `ilon schema {kind}` prints the same as a JSON Schema, for an editor.\n"
    text += "Written by `docs/formats.py`.\n\n"
    text += f"A whole one, [{Path(whole).name}](../{whole}):\n\n```toml\n{(ROOT / whole).read_text().strip()}\n```\n\n"
    return text + Reference(schema, examples(folder)).page(schema)


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
