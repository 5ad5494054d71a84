"""xacro: ilon's own expander and the xacro of ROS make the same of a robot, and what the own one refuses the other is asked for."""

import subprocess
import sys
import xml.dom.minidom as dom

import pytest

import ilon

xacro = pytest.importorskip("xacro")

# Wheels by macros, numbers by arguments: the robot of assets with its own text in macros.
HEAD = '<robot name="mecanum4" xmlns:xacro="http://www.ros.org/wiki/xacro">'
ARGUMENTS = """
<xacro:arg name="friction" default="0.0"/>
<xacro:property name="friction" value="$(arg friction)"/>
"""


@pytest.fixture
def robot(assets, tmp_path):
    """A xacro file of the four-wheeled robot, every roller's bearing with the friction that an argument says."""

    def write(friction="${2 * friction / 2}", more=""):
        text = (assets / "robots" / "mecanum4.urdf").read_text()
        begin = text.index("<robot"), text.index(">", text.index("<robot")) + 1
        body = text[begin[1] :].replace('friction="0"', f'friction="{friction}"')
        assert friction in body
        path = tmp_path / "robot.xacro"
        path.write_text(HEAD + ARGUMENTS + more + body)
        return path

    return write


def normal(text):
    """Elements in their order, their attributes sorted, without comments and spaces."""

    def lines(node):
        yield node.tagName, sorted(item for item in node.attributes.items() if not item[0].startswith("xmlns"))
        for child in node.childNodes:
            if child.nodeType == dom.Node.ELEMENT_NODE:
                yield from lines(child)
        yield "end", node.tagName

    return list(lines(dom.parseString(text).documentElement))


def test_both_make_the_same_of_a_robot(robot):
    path = robot()
    theirs = xacro.process_file(str(path), mappings={"friction": "0.001"}).toxml()
    ours = ilon.inspect(path, args={"friction": "0.001"})
    assert normal(ours.urdf) == normal(theirs)
    said = [remark for remark in ours["remarks"] if "expanded" in remark]
    assert said == ["xacro: expanded with friction = 0.001"]


def test_what_only_the_other_knows_is_expanded_by_it_and_said(robot, circle):
    # The own expander knows no base of `int`.
    path = robot(friction="${friction * int('0x10', 16) / 16}")
    asked = ilon.inspect(path, args={"friction": "0.001"})
    (said,) = [remark for remark in asked["remarks"] if "expanded" in remark]
    assert said.startswith(
        f"xacro: expanded by xacro {xacro_version()}, because ilon's own expander refuses it: invalid literal"
    )
    theirs = xacro.process_file(str(path), mappings={"friction": "0.001"}).toxml()
    assert normal(asked.urdf) == normal(theirs)

    def run(file):
        circle["robot"] |= {"file": str(file), "args": {"friction": "0.001"}}
        return ilon.run(circle, settings={"run.duration_s": 0.3})

    by_the_other = run(path)
    assert any("expanded by xacro" in warning for warning in by_the_other.warnings)
    by_our_own = run(robot())
    assert not any("expanded by xacro" in warning for warning in by_our_own.warnings)
    assert by_the_other.summary["trace_hash"] == by_our_own.summary["trace_hash"]


def test_packages_are_found_for_it_as_for_our_own(robot, tmp_path):
    (tmp_path / "wheels").mkdir()
    (tmp_path / "wheels" / "more.xacro").write_text(
        HEAD + "<xacro:property name='sixteen' value=\"${int('0x10', 16)}\"/></robot>"
    )
    more = "<xacro:include filename='$(find wheels)/more.xacro'/>"
    asked = ilon.inspect(robot(friction="${friction * sixteen / 16}", more=more))
    assert any("expanded by xacro" in remark for remark in asked["remarks"])


def test_what_both_refuse_is_refused_as_the_command_does(robot):
    with pytest.raises(ilon.RobotError, match="robot.xacro") as raised:
        ilon.inspect(robot(friction="${friction + 'a'}"))
    assert "cannot be expanded" in raised.value.message


def test_without_the_other_our_own_says_what_it_lacks(robot, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(ilon.RobotError, match="invalid literal for int"):
        ilon.inspect(robot(friction="${friction * int('0x10', 16) / 16}"))


def test_the_command_of_the_wheel_asks_it_too_but_not_in_a_sandbox(robot, command, tmp_path):
    path = robot(friction="${friction * int('0x10', 16) / 16}")
    assert "expanded by xacro" in command("inspect", path).stdout
    refused = command("inspect", path, "--sandbox", tmp_path, code=2)
    assert "invalid literal for int" in refused.stderr


def test_it_works_from_threads_and_in_a_study(robot, assets):
    path = robot(friction="${friction * int('0x10', 16) / 16}")
    study = {
        "scenario": str(assets / "scenarios" / "mecanum4_lateral.toml"),
        "set": {"robot.file": str(path), "run.duration_s": 0.2},
        "axes": {"robot.args.friction": ["0.0", "0.001", "0.002"]},
    }
    assert ilon.sweep(study, jobs=3)["status"] == ["done"] * 3


def xacro_version():
    from importlib.metadata import version

    return version("xacro")


HANDS = """
import _thread, sys, threading, ilon
threading.Timer(1.0, _thread.interrupt_main).start()
try:
    ilon.inspect(sys.argv[1])
except KeyboardInterrupt:
    print("interrupted")
except ilon.RobotError:
    try:
        import time; time.sleep(1)
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_ctrl_c_reaches_the_caller(robot):
    # It counts for longer than anybody waits.
    endless = "${friction * int('0x1', 16) * max(x for x in range(3000000000))}"
    done = subprocess.run(
        [sys.executable, "-c", HANDS, robot(friction=endless)], capture_output=True, text=True, timeout=60
    )
    assert done.stdout == "interrupted\n", done.stderr
