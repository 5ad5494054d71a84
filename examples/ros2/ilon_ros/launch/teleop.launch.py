"""The robot as a node of ROS 2 that takes /cmd_vel, and a page to drive it at http://127.0.0.1:8765/."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument

from ilon_ros import ILON, live


def generate_launch_description():
    scenario = DeclareLaunchArgument("scenario", description="A scenario, or a robot's file for a level floor")
    return LaunchDescription([scenario, ILON, live()])
