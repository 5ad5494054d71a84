"""What each launch file starts. In place of the nodes, and of `ilon live`, stand scripts that note their arguments; `ilon inspect` is the real one.

It needs `ilon` on the path, and the file of a robot with mecanum wheels in ILON_ROBOT.
"""

import os
import shutil
from collections import defaultdict
from pathlib import Path

import pytest
import yaml
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

PACKAGE = Path(__file__).parents[1]
NODES = """controller_manager/ros2_control_node controller_manager/spawner nav2_controller/controller_server nav2_planner/planner_server
    nav2_behaviors/behavior_server nav2_bt_navigator/bt_navigator nav2_lifecycle_manager/lifecycle_manager""".split()
ILON, ROBOT = shutil.which("ilon"), os.environ.get("ILON_ROBOT", "")
pytestmark = pytest.mark.skipif(not (ILON and ROBOT), reason="no ilon on the path, or no ILON_ROBOT")


@pytest.fixture
def started(tmp_path, monkeypatch):
    """Runs a launch file; gives the arguments of all that it started, by program."""
    notes, index = tmp_path / "notes", tmp_path / "share/ament_index/resource_index/packages"
    note = f'printf "%s\\n" "$@" > "{notes}/$(basename "$0")-$$"\n'
    scripts = {tmp_path / "lib" / node: note for node in NODES}
    scripts[tmp_path / "ilon"] = f'[ "$1" = inspect ] && exec "{ILON}" "$@"\n{note}sleep 3\n'
    notes.mkdir(), index.mkdir(parents=True)
    for path, text in scripts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        (index / path.parent.name).touch()
    (index / "ilon_ros").touch()
    (tmp_path / "share/ilon_ros").symlink_to(PACKAGE)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))

    def run(name, **arguments):
        source = PythonLaunchDescriptionSource(str(PACKAGE / "launch" / f"{name}.launch.py"))
        arguments["ilon"] = str(tmp_path / "ilon")
        service = LaunchService(noninteractive=True)
        service.include_launch_description(LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments.items())]))
        # It ends because `ilon live` ends.
        assert service.run() == 0
        lines = defaultdict(list)
        for path in notes.iterdir():
            lines[path.name.rsplit("-", 1)[0]].append(path.read_text().splitlines())
        return lines

    return run


def files(line):
    """The files of parameters in a command line."""
    return [yaml.full_load(Path(path).read_text()) for option, path in zip(line, line[1:]) if option == "--params-file"]


def test_teleop(started):
    assert started("teleop", scenario="a.toml") == {"ilon": [["live", "a.toml", "--ros2"]]}


def test_ros2_control(started):
    lines = started("ros2_control", robot=ROBOT)
    assert lines["ilon"] == [["live", ROBOT, "--ros2=controllers"]]
    written, time = files(lines["ros2_control_node"][0])
    assert "mecanum_drive_controller" in written["controller_manager"]["ros__parameters"] and time["/**"]["ros__parameters"] == {"use_sim_time": True}
    broadcaster, drive = sorted(lines["spawner"])
    assert broadcaster[0] == "joint_state_broadcaster" and drive[0] == "mecanum_drive_controller"
    assert "--remap ~/odometry:=/odom --remap ~/tf_odometry:=/tf" in drive


def test_nav2(started):
    lines = started("nav2", robot=ROBOT, scenario="a.toml")
    assert lines["ilon"] == [["live", "a.toml", "--ros2"]]
    *servers, common = files(lines["controller_server"][0])
    assert common["/**"]["ros__parameters"] == {"use_sim_time": True, "robot_base_frame": "base_link", "enable_stamped_cmd_vel": True}
    # Both files speak of the same controller, and the later one has the robot's limits.
    shipped, limits = (of["controller_server"]["ros__parameters"]["FollowPath"] for of in servers)
    assert all(shipped[key] == limits[key] for key in ("plugin", "motion_model")) and limits["vy_max"] > 0 and limits["ay_max"] > 0
    managed = files(lines["lifecycle_manager"][0])[0]["/**"]["ros__parameters"]["node_names"]
    assert sorted(managed) == sorted(set(lines) - {"ilon", "lifecycle_manager"})
