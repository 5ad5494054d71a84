"""The robot with Nav2, which drives it to goals by /odom, /tf and /cmd_vel, as fast as its wheels and their grip allow."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from ilon_ros import ILON, ROBOT, SCENARIO, live, parameters

SERVERS = {
    "controller_server": "nav2_controller",
    "planner_server": "nav2_planner",
    "behavior_server": "nav2_behaviors",
    "bt_navigator": "nav2_bt_navigator",
}


def nodes(context):
    limits, _, base_frame = parameters(context)
    # Without a name these reach the costmaps too, which are nodes within their servers.
    common = {"use_sim_time": True, "robot_base_frame": base_frame, "enable_stamped_cmd_vel": True}
    of_all = [LaunchConfiguration("params_file"), limits, common]
    managed = {"use_sim_time": True, "autostart": True, "node_names": list(SERVERS)}
    servers = [Node(package=package, executable=server, parameters=of_all, output="screen") for server, package in SERVERS.items()]
    return [live(), *servers, Node(package="nav2_lifecycle_manager", executable="lifecycle_manager", parameters=[managed], output="screen")]


def generate_launch_description():
    file = Path(get_package_share_directory("ilon_ros")) / "config" / "nav2.yaml"
    params = DeclareLaunchArgument("params_file", default_value=str(file), description="Parameters of Nav2, but for speeds and accelerations")
    return LaunchDescription([ROBOT, SCENARIO, ILON, params, OpaqueFunction(function=nodes)])
