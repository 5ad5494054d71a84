"""The robot with a controller manager that drives its wheels over topics, by the controller that suits them."""

from launch import LaunchDescription
from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from ilon_ros import CONTROLLERS, ILON, ROBOT, SCENARIO, live, parameters


def nodes(context):
    file, controller, _ = parameters(context)
    remaps = " ".join(f"--remap {own}:={shared}" for own, shared in CONTROLLERS[controller].items())
    spawner = {"package": "controller_manager", "executable": "spawner", "output": "screen"}
    return [
        # Its /robot_description has the <ros2_control> block, for which the controller manager waits.
        live("--ros2=controllers"),
        Node(package="controller_manager", executable="ros2_control_node", parameters=[file, {"use_sim_time": True}], output="screen"),
        Node(**spawner, arguments=["joint_state_broadcaster"]),
        Node(**spawner, arguments=[controller, "--param-file", file, "--controller-ros-args", remaps]),
    ]


def generate_launch_description():
    return LaunchDescription([ROBOT, SCENARIO, ILON, OpaqueFunction(function=nodes)])
