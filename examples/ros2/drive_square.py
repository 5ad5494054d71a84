#!/usr/bin/env python3
"""Drives a robot around a square by its own odometry, and compares that with where the robot really went.

    ilon live --ros2 assets/scenarios/mecanum4_circle.toml      # in one terminal
    python3 examples/ros2/drive_square.py --side 1.0            # in another one

A client of ROS 2 like any other: it hears /odom and /ground_truth/odom, and publishes geometry_msgs/TwistStamped on /cmd_vel. The robot
drives the sides without turning its heading, as omnidirectional robots can: ahead, to the left, back, to the right. It needs rclpy,
geometry_msgs and nav_msgs, of a ROS installation or of PyPI (`pip install "ros-jazzy-rclpy[fastrtps]" ros-jazzy-nav-msgs`).
"""

import argparse
import math
import sys

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

RATE_HZ = 50.0
# Proportional gains on what is left of the way (1/s), and how near a corner counts as reached.
POSITION_GAIN, HEADING_GAIN = 2.0, 2.0
NEAR_M, STILL_M_S = 0.005, 0.01


def pose(message: Odometry) -> tuple[float, float, float]:
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    return place.x, place.y, math.atan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2))


def wrapped(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


class Driver(Node):
    """Goes to points of the odometry's frame, one after the other."""

    def __init__(self, side_m: float, speed_m_s: float):
        super().__init__("drive_square")
        self.side_m, self.speed_m_s = side_m, speed_m_s
        self.odometry = self.truth = None
        self.corners: list[tuple[float, float]] = []
        self.start = self.true_start = None
        # At each corner: odometry and truth, both as seen from the start.
        self.reached: list[tuple[tuple, tuple]] = []
        self.done = False
        self.create_subscription(Odometry, "/odom", lambda message: setattr(self, "odometry", message), 10)
        self.create_subscription(Odometry, "/ground_truth/odom", lambda message: setattr(self, "truth", message), 10)
        self.commands = self.create_publisher(TwistStamped, "/cmd_vel", 10)
        self.create_timer(1.0 / RATE_HZ, self.drive)

    def drive(self):
        if self.done or self.odometry is None or self.truth is None:
            return
        x, y, heading = pose(self.odometry)
        if self.start is None:
            self.start, self.true_start = (x, y, heading), pose(self.truth)
            c, s, a = math.cos(heading), math.sin(heading), self.side_m
            # Ahead, to the left, back and to the right of the start.
            self.corners = [(x + c * dx - s * dy, y + s * dx + c * dy) for dx, dy in ((a, 0), (a, a), (0, a), (0, 0))]
        goal = self.corners[len(self.reached)]
        ex, ey = goal[0] - x, goal[1] - y
        left = math.hypot(ex, ey)
        now = self.odometry.twist.twist.linear
        if left < NEAR_M and math.hypot(now.x, now.y) < STILL_M_S:
            self.reached.append((seen_from(self.start, pose(self.odometry)), seen_from(self.true_start, pose(self.truth))))
            if len(self.reached) == len(self.corners):
                self.done = True
                self.command(0.0, 0.0, 0.0)
            return
        speed = min(POSITION_GAIN * left, self.speed_m_s)
        vx, vy = (speed * ex / left, speed * ey / left) if left > 0 else (0.0, 0.0)
        c, s = math.cos(heading), math.sin(heading)
        turn = max(-1.0, min(1.0, HEADING_GAIN * wrapped(self.start[2] - heading)))
        self.command(c * vx + s * vy, -s * vx + c * vy, turn)

    def command(self, vx: float, vy: float, omega: float):
        message = TwistStamped()
        # The robot's clock, so that a command that comes late is noticed.
        message.header.stamp = self.odometry.header.stamp
        message.header.frame_id = self.odometry.child_frame_id
        message.twist.linear.x, message.twist.linear.y, message.twist.angular.z = vx, vy, omega
        self.commands.publish(message)


def seen_from(start: tuple, here: tuple) -> tuple[float, float, float]:
    dx, dy, c, s = here[0] - start[0], here[1] - start[1], math.cos(start[2]), math.sin(start[2])
    return c * dx + s * dy, -s * dx + c * dy, wrapped(here[2] - start[2])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=float, default=1.0, help="length of a side, m")
    parser.add_argument("--speed", type=float, default=0.4, help="fastest speed, m/s")
    parser.add_argument("--patience", type=float, default=120.0, help="give up after this many seconds")
    arguments = parser.parse_args()
    rclpy.init()
    driver = Driver(arguments.side, arguments.speed)
    end = driver.get_clock().now().nanoseconds + int(arguments.patience * 1e9)
    while rclpy.ok() and not driver.done and driver.get_clock().now().nanoseconds < end:
        rclpy.spin_once(driver, timeout_sec=0.1)
    done, reached, heard = driver.done, driver.reached, driver.odometry is not None
    driver.destroy_node()
    rclpy.shutdown()
    if not heard:
        print("nothing came on /odom: is `ilon live --ros2` running, in the same ROS_DOMAIN_ID?", file=sys.stderr)
        return 1
    print("corner   odometry x, y (m), heading (deg)   truth x, y (m), heading (deg)     apart (mm)")
    for corner, (believed, real) in enumerate(reached, 1):
        apart_mm = 1e3 * math.hypot(believed[0] - real[0], believed[1] - real[1])
        row = "   ".join(f"{x:8.4f} {y:8.4f} {math.degrees(turn):8.3f}" for x, y, turn in (believed, real))
        print(f"{corner:6}   {row}   {apart_mm:10.1f}")
    if not done:
        print(f"only {len(reached)} of 4 corners were reached in {arguments.patience:g} s", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
