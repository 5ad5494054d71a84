"""xacro: ilon's expander and ROS xacro give the same robot."""

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
    """A xacro file of the four-wheeled robot, with the friction of every roller bearing set by an
    argument.
    """

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
    """Elements in order, with sorted attributes, without comments and spaces."""

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


def test_what_ilon_does_not_know_is_refused_in_its_words_though_the_other_would_expand_it(robot, command):
    # ilon's expander does not support a base in `int`; the other one evaluates it.
    path = robot(friction="${friction * int('0x10', 16) / 16}")
    with pytest.raises(ilon.RobotError, match="invalid literal for int"):
        ilon.inspect(path, args={"friction": "0.001"})
    assert "invalid literal for int" in command("inspect", path, code=2).stderr


def test_what_both_refuse_is_refused_as_the_command_does(robot):
    with pytest.raises(ilon.RobotError, match="robot.xacro") as raised:
        ilon.inspect(robot(friction="${friction + 'a'}"))
    assert "cannot be expanded" in raised.value.message
