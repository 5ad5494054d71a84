"""The xacro of ROS: asked about files that ilon's own expander refuses."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping

# It keeps what it works on in variables of its modules.
_one_at_a_time = threading.Lock()


def expand(
    path: str | os.PathLike[str],
    arguments: Mapping[str, str],
    find: Callable[[str], str | os.PathLike[str] | None],
) -> tuple[str, str] | None:
    """The URDF that a file expands to, and by what; None where xacro is not installed, or refuses the file too.

    `find` gives the folder of a package of ROS by its name.
    """
    try:
        from importlib.metadata import version

        import xacro
        from xacro import substitution_args
    except ImportError:
        return None

    ask_ros = substitution_args._eval_find

    def find_package(name: str) -> str:
        folder = find(name)
        return ask_ros(name) if folder is None else os.fspath(folder)

    with _one_at_a_time:
        known = substitution_args._eval_dict
        substitution_args._eval_find = known["find"] = find_package
        try:
            text = xacro.process_file(os.fspath(path), mappings=dict(arguments)).toxml()
        except (Exception, SystemExit):
            return None
        finally:
            substitution_args._eval_find = known["find"] = ask_ros
    return text, f"xacro {version('xacro')}"
