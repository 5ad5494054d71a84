"""What the launch files share: ilon as a process, and the parameters that it writes for a robot."""

import os
import subprocess
import tempfile

import yaml
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.substitutions import LaunchConfiguration

ILON = DeclareLaunchArgument("ilon", default_value="ilon", description="The command, of a build with ROS 2")
ROBOT = DeclareLaunchArgument("robot", description="The robot's file: URDF, xacro, SDF, MJCF or TOML")
SCENARIO = DeclareLaunchArgument(
    "scenario", default_value=LaunchConfiguration("robot"), description="The scenario in which that robot drives, or the robot's file for a level floor"
)
CONTROLLERS = {
    # What a controller publishes for itself alone, and where others expect it. The one for omni wheels sends its frame to /tf.
    "mecanum_drive_controller": {"~/odometry": "/odom", "~/tf_odometry": "/tf"},
    "omni_wheel_drive_controller": {"~/odom": "/odom"},
}


def live(option="--ros2"):
    """`ilon live` as a node. When it ends, everything ends."""
    command = [LaunchConfiguration("ilon"), "live", LaunchConfiguration("scenario"), option]
    return ExecuteProcess(cmd=command, output="screen", on_exit=Shutdown(reason="ilon has ended"))


def parameters(context):
    """A file of parameters for the robot's controller and for Nav2, the controller's name, and the robot's base frame."""
    handle, path = tempfile.mkstemp(prefix="ilon_", suffix=".yaml")
    os.close(handle)
    ilon, robot = (LaunchConfiguration(name).perform(context) for name in ("ilon", "robot"))
    command = [ilon, "inspect", robot, "--limits", "--ros2-controllers", path, "--quiet"]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stderr}")
    with open(path) as file:
        written = yaml.safe_load(file)
    controller = next(name for name in CONTROLLERS if name in written)
    return path, controller, written[controller]["ros__parameters"]["base_frame_id"]
