"""How `ilon live --ros2` holds out: messages lost, latency and jitter, at 100 Hz, as rclpy sees them.

    ros2_endurance.py ILON MINUTES [DEPTH]      with the loopback interface up

It hears /odom and /joint_states (reliable), sends a twist at 20 Hz, and drives the robot on a circle. Latency is from when ilon hands a
message to the middleware, which is its source timestamp, until rclpy hands it to the callback; jitter is the spread of the times between
two callbacks. Both ends are on this machine, so that they share a clock. Counted are stamps that did not come. DEPTH is how many messages
the reader keeps: one that keeps ten, as is usual, overwrites the oldest of them whenever it is not run for a tenth of a second.
"""

import statistics
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

REPO = Path(__file__).resolve().parents[4]
MINUTES = float(sys.argv[2])
DEPTH = int(sys.argv[3]) if len(sys.argv) > 3 else 10
SETTINGS = ["robot.roller_bodies=near", "run.control_dt_s=0.01"]


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def main():
    command = [sys.argv[1], "live", str(REPO / "assets/scenarios/mecanum4_circle.toml"), "--port", "0", "--ros2"]
    for setting in SETTINGS:
        command += ["--set", setting]
    ilon = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    rclpy.init()
    node = rclpy.create_node("endurance")
    came = {"/odom": [], "/joint_states": []}

    def listen(kind, topic):
        def heard(message, info):
            now_ns = time.time_ns()
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            came[topic].append((stamp, now_ns, now_ns - info["source_timestamp"]))

        node.create_subscription(kind, topic, heard, DEPTH)

    listen(Odometry, "/odom")
    listen(JointState, "/joint_states")
    commands = node.create_publisher(TwistStamped, "/cmd_vel", 10)
    message = TwistStamped()
    message.twist.linear.x, message.twist.angular.z = 0.3, 0.5
    node.create_timer(0.05, lambda: commands.publish(message))
    end = time.monotonic() + 20
    while not all(came.values()) and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    began = time.monotonic()
    while time.monotonic() < began + 60 * MINUTES and ilon.poll() is None:
        rclpy.spin_once(node, timeout_sec=0.1)
    passed = time.monotonic() - began
    ended = ilon.poll()
    ilon.kill()
    said = ilon.stderr.read().strip()
    for topic, messages in came.items():
        stamps = [stamp for stamp, _, _ in messages]
        steps = [b - a for a, b in zip(stamps, stamps[1:])]
        period = statistics.median(steps)
        lost = sum(round(step / period) - 1 for step in steps if step > 0)
        disorder = sum(step <= 0 for step in steps)
        latency_ms = [latency * 1e-6 for _, _, latency in messages]
        apart_ms = [(b - a) * 1e-6 for (_, a, _), (_, b, _) in zip(messages, messages[1:])]
        print(
            f"{topic}: {len(messages)} messages in {passed / 60:.1f} min, a stamp each {period * 1e-6:.1f} ms, {lost} lost, {disorder} out of order; "
            f"latency median {statistics.median(latency_ms):.2f} ms, 99 % {percentile(latency_ms, 0.99):.2f} ms, "
            f"worst {max(latency_ms):.1f} ms; between callbacks median {statistics.median(apart_ms):.2f} ms, "
            f"standard deviation {statistics.pstdev(apart_ms):.2f} ms, 99 % {percentile(apart_ms, 0.99):.2f} ms"
        )
    print(f"ilon said: {said or 'nothing'}" + (f"; it ended with {ended}" if ended is not None else ""))
    return 0 if ended is None else 1


if __name__ == "__main__":
    sys.exit(main())
