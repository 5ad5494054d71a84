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
NODES = {
    "controller_manager": ["ros2_control_node", "spawner"],
    "nav2_controller": ["controller_server"],
    "nav2_planner": ["planner_server"],
    "nav2_behaviors": ["behavior_server"],
    "nav2_bt_navigator": ["bt_navigator"],
    "nav2_lifecycle_manager": ["lifecycle_manager"],
}
NOTE = '#!/bin/sh\nprintf "%s\\n" "$@" > "{notes}/$(basename "$0")-$$"\n'
ROBOT = os.environ.get("ILON_ROBOT", "")
pytestmark = pytest.mark.skipif(not (shutil.which("ilon") and ROBOT), reason="no ilon on the path, or no ILON_ROBOT")


@pytest.fixture
def started(tmp_path, monkeypatch):
    """Runs a launch file; gives the arguments of all that it started, by program."""
    notes, index = tmp_path / "notes", tmp_path / "share/ament_index/resource_index/packages"
    notes.mkdir(), index.mkdir(parents=True)

    def script(path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    for package, programs in NODES.items():
        (index / package).touch()
        for program in programs:
            script(tmp_path / "lib" / package / program, NOTE.format(notes=notes))
    (index / "ilon_ros").touch()
    (tmp_path / "share/ilon_ros").symlink_to(PACKAGE)
    real = f'[ "$1" = inspect ] && exec "{shutil.which("ilon")}" "$@"\n'
    note = NOTE.format(notes=notes)
    script(tmp_path / "bin/ilon", note.replace("\n", "\n" + real, 1) + "sleep 3\n")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))

    def run(name, **arguments):
        source = PythonLaunchDescriptionSource(str(PACKAGE / "launch" / f"{name}.launch.py"))
        arguments["ilon"] = str(tmp_path / "bin/ilon")
        service = LaunchService(noninteractive=True)
        service.include_launch_description(LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments.items())]))
        # It ends because `ilon live` ends.
        assert service.run() == 0
        lines = defaultdict(list)
        for path in notes.iterdir():
            lines[path.name.rsplit("-", 1)[0]].append(path.read_text().splitlines())
        return lines

    return run


def parameters(line):
    """The parameters of each node in a command line: files later in it count more."""
    merged = defaultdict(dict)
    for option, path in zip(line, line[1:]):
        if option == "--params-file":
            for node, of in yaml.full_load(Path(path).read_text()).items():
                merged[node].update(of.get("ros__parameters", of))
    return merged


def test_teleop(started):
    lines = started("teleop", scenario="a.toml")
    assert lines == {"ilon": [["live", "a.toml", "--ros2"]]}


def test_ros2_control(started):
    lines = started("ros2_control", robot=ROBOT)
    assert lines["ilon"] == [["live", ROBOT, "--ros2=controllers"]]
    of = parameters(lines["ros2_control_node"][0])
    assert of["/**"] == {"use_sim_time": True}
    assert of["controller_manager"]["mecanum_drive_controller"]["type"] == "mecanum_drive_controller/MecanumDriveController"
    drive = next(line for line in lines["spawner"] if line[0] == "mecanum_drive_controller")
    assert "--remap ~/odometry:=/odom --remap ~/tf_odometry:=/tf" in drive
    assert ["joint_state_broadcaster"] in [line[:1] for line in lines["spawner"]]


def test_nav2(started):
    lines = started("nav2", robot=ROBOT, scenario="a.toml")
    assert lines["ilon"] == [["live", "a.toml", "--ros2"]]
    of = parameters(lines["controller_server"][0])
    assert of["/**"] == {"use_sim_time": True, "robot_base_frame": "base_link", "enable_stamped_cmd_vel": True}
    managed = parameters(lines["lifecycle_manager"][0])["/**"]
    assert sorted(managed["node_names"]) == sorted(set(lines) - {"ilon", "lifecycle_manager"})
    # Both files of parameters speak of the same controller, and the robot's limits are in it.
    follow = [yaml.full_load(Path(path).read_text()).get("controller_server") for path in lines["controller_server"][0] if path.endswith(".yaml")]
    follow = [of["ros__parameters"]["FollowPath"] for of in follow if of]
    assert {of["plugin"] for of in follow} == {"nav2_mppi_controller::MPPIController"} and {of["motion_model"] for of in follow} == {"Omni"}
    assert follow[1]["vy_max"] > 0 and follow[1]["ay_max"] > 0
