"""Expands the cases beside this file with the xacro of ROS (PyPI's `xacro`), and compares with what is kept of each.

    python real.py          says which cases differ, and ends with 1 if one does
    python real.py --write  keeps what xacro makes of them

What is kept is a normal form: a line for each element, with its attributes sorted; declarations of namespaces and comments
left out; the words of texts, one space between them.
"""

import json
import os
import re
import sys
import types
import xml.dom.minidom as dom
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

HERE = Path(__file__).resolve().parent
NAMESPACE = "http://www.ros.org/wiki/xacro"

# xacro asks ROS for the folders of packages; here they are beside the cases.
packages = types.ModuleType("ament_index_python.packages")
def get_package_share_directory(name):
    folder = HERE / "packages" / name
    if not folder.is_dir():
        raise LookupError(name)
    return str(folder)
packages.get_package_share_directory = get_package_share_directory
parent = types.ModuleType("ament_index_python")
parent.packages = packages
sys.modules["ament_index_python"] = parent
sys.modules["ament_index_python.packages"] = packages

import xacro  # noqa: E402


def normal(node, depth=0):
    """The lines of an element in normal form."""
    attributes = sorted(
        (name, value) for name, value in node.attributes.items() if not name.startswith("xmlns")
    )
    words = "".join(f" {name}={json.dumps(value, ensure_ascii=False)}" for name, value in attributes)
    yield "  " * depth + node.tagName + words
    text = ""
    for child in node.childNodes:
        if child.nodeType == dom.Node.ELEMENT_NODE:
            if text.strip():
                yield "  " * depth + "  " + json.dumps(" ".join(text.split()), ensure_ascii=False)
            text = ""
            yield from normal(child, depth + 1)
        elif child.nodeType in (dom.Node.TEXT_NODE, dom.Node.CDATA_SECTION_NODE):
            text += child.data
    if text.strip():
        yield "  " * depth + "  " + json.dumps(" ".join(text.split()), ensure_ascii=False)


def expanded(path, arguments):
    """The normal form of xacro's output for a file."""
    with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
        text = xacro.process_file(str(path), mappings=dict(arguments)).toxml()
    lines = normal(dom.parseString(text).documentElement)
    return "\n".join(lines).replace(str(HERE), "HERE") + "\n"


def arguments_of(text):
    """The arguments in a case's first comment."""
    said = re.match(r"<!-- arguments: (.*) -->", text)
    return [word.split(":=") for word in said.group(1).split()] if said else []


def main():
    os.environ["CARGO_PKG_NAME"] = "xacro-expand"
    write = "--write" in sys.argv
    wrong = []
    for case in sorted((HERE / "cases").glob("*.xacro")):
        kept = case.with_suffix(".expected")
        try:
            found = expanded(case, arguments_of(case.read_text(encoding="utf-8")))
        except Exception as error:
            wrong.append(f"{case.name}: xacro refuses it: {error}")
            continue
        if write:
            kept.write_text(found, encoding="utf-8")
        elif not kept.exists() or kept.read_text(encoding="utf-8") != found:
            wrong.append(f"{case.name}: what is kept is not what xacro makes of it")
    scratch = HERE / "cases" / "refused.tmp"
    try:
        for line in (HERE / "refused.txt").read_text(encoding="utf-8").splitlines():
            if line.startswith("#"):
                continue
            scratch.write_text(f'<robot name="r" xmlns:xacro="{NAMESPACE}">{line}</robot>', encoding="utf-8")
            try:
                expanded(scratch, [])
                wrong.append(f"xacro expands: {line}")
            except (Exception, RecursionError, SystemExit):
                pass
    finally:
        scratch.unlink(missing_ok=True)
    print("\n".join(wrong) if wrong else f"xacro {xacro_version()} agrees with every case")
    return 1 if wrong else 0


def xacro_version():
    from importlib.metadata import version

    return version("xacro")


if __name__ == "__main__":
    sys.exit(main())
