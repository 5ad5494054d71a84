"""Is a filter of the field consistent when it is fed with `/odom` and `/imu` of a bag?

    fusion_witness.py ILON ROBOT

The filter is the extended Kalman filter of `robot_localization` (T. Moore, D. Stouch, "A Generalized Extended Kalman Filter Implementation for
the Robot Operating System", 2014), written a second time: its 15 states, its omnidirectional model, its process noise; `two_d_mode`, with vx, vy
and vyaw of odometry and vyaw of the IMU. Robots go random ways. NEES is e^T P^-1 e of x, y and heading at the end, against the truth; over the runs
its mean is 3 where the filter is consistent. With the process noise that `robot_localization` has unless it is told otherwise, whose x and y wander
by 0.2 m in a second, it is far too careful; and as it has no state for a gyroscope's bias, one that is not zeroed makes it far too sure.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from scipy.stats import chi2

RUNS, SECONDS = 12, 16.0
X, Y, YAW, VX, VY, VYAW, AX, AY = 0, 1, 5, 6, 7, 11, 12, 13
# The defaults of robot_localization, and a model whose positions are integrals of its velocities:
# without position noise, with velocities that change by 1 m/s or 1 rad/s within a second.
DEFAULT = [0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015]
EXACT = [0.0] * 6 + [1.0] * 6 + [0.01, 0.01, 0.015]


class Filter:
    """The filter of `robot_localization`; a 16th state is the gyroscope's bias, which the original
    lacks.
    """

    def __init__(self, process_noise, bias=0.0, bias_walk=0.0):
        self.x = np.zeros(16)
        self.p = np.diag([1e-9] * 15 + [bias**2])
        self.q = np.diag([*process_noise, bias_walk**2])
        self.t = None

    def predict(self, t):
        dt, self.t = (0.0, t) if self.t is None else (t - self.t, t)
        if dt <= 0.0:
            return
        x, f = self.x, np.eye(16)
        c, s = np.cos(x[YAW]), np.sin(x[YAW])
        # Derivatives by the velocity and by the acceleration.
        for u, v, by in ((VX, VY, dt), (AX, AY, 0.5 * dt * dt)):
            f[X, u], f[X, v], f[Y, u], f[Y, v] = c * by, -s * by, s * by, c * by
            f[X, YAW] += (-s * x[u] - c * x[v]) * by
            f[Y, YAW] += (c * x[u] - s * x[v]) * by
        f[YAW, VYAW] = f[VX, AX] = f[VY, AY] = dt
        linear = f.copy()
        linear[X, YAW] = linear[Y, YAW] = 0.0
        self.x = linear @ x
        self.p = f @ self.p @ f.T + dt * self.q

    def correct(self, states, z, r, with_bias=False):
        h = np.zeros((len(states), 16))
        h[range(len(states)), states] = 1.0
        if with_bias:
            h[:, 15] = 1.0
        gain = self.p @ h.T @ np.linalg.inv(h @ self.p @ h.T + r)
        self.x = self.x + gain @ (z - h @ self.x)
        left = np.eye(16) - gain @ h
        self.p = left @ self.p @ left.T + gain @ r @ gain.T


def scenario(robot, folder, run, imu):
    """A robot on a random path around random points, turning."""
    rng = np.random.default_rng(run)
    times = np.arange(0.0, SECONDS + 1.0, 2.0)
    steps = rng.uniform(0.2, 0.6, times.size) * (times > 0.0)
    towards = rng.uniform(-np.pi, np.pi) + np.cumsum(rng.normal(0.0, 0.6, times.size))
    x, y = np.cumsum(steps * np.cos(towards)), np.cumsum(steps * np.sin(towards))
    heading = np.cumsum(rng.normal(0.0, 23.0, times.size) * (times > 0.0))
    rows = zip(times, x, y, heading, strict=True)
    text = "t_s,x_m,y_m,heading_deg\n" + "\n".join(",".join(map(str, row)) for row in rows)
    (folder / "way.csv").write_text(text)
    (folder / "run.toml").write_text(
        f"""
[robot]
file = "{robot}"
roller_bodies = "near"
[reference.waypoints]
file = "way.csv"
[guidance]
position_gain_per_s = 2
heading_gain_per_s = 2
[sensors]
seed = {run}
[sensors.encoders]
rate_noise_rad_s = 0.1
[sensors.imu]
{imu}
[run]
duration_s = {SECONDS}
"""
    )


def messages(bag):
    """`/odom`, `/imu` and the truth of a bag, row by row."""
    topics = ("/odom", "/imu", "/ground_truth/odom")
    rows = {topic: [] for topic in topics}
    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        for connection, stamp, data in reader.messages(connections=wanted):
            rows[connection.topic].append((1e-9 * stamp, reader.deserialize(data, connection.msgtype)))
    return zip(*(rows[topic] for topic in topics), strict=True)


def planar(covariance):
    return covariance.reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]


def pose(message):
    q = message.pose.pose.orientation
    yaw = np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    return np.array([message.pose.pose.position.x, message.pose.pose.position.y, yaw])


def squared(error, covariance):
    error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
    return error @ np.linalg.solve(covariance, error)


def judged(rows, process_noise, bias=0.0, bias_walk=0.0, states_bias=False):
    """NEES of the pose at the end and of the twist on the way, and that of odometry alone by its
    own covariance.
    """
    filter_ = Filter(process_noise, bias if states_bias else 0.0, bias_walk if states_bias else 0.0)
    of_twist = []
    for (t, odom), (_, imu), (_, truth) in rows:
        filter_.predict(t)
        twist = odom.twist.twist
        z = np.array([twist.linear.x, twist.linear.y, twist.angular.z])
        filter_.correct([VX, VY, VYAW], z, planar(odom.twist.covariance))
        variance = imu.angular_velocity_covariance.reshape(3, 3)[2, 2]
        if states_bias:
            variance -= bias**2 + bias_walk**2 * (t - rows[0][0][0])
        filter_.correct([VYAW], np.array([imu.angular_velocity.z]), np.array([[variance]]), states_bias)
        real = truth.twist.twist
        off = np.array([real.linear.x, real.linear.y, real.angular.z]) - filter_.x[[VX, VY, VYAW]]
        of_twist.append(squared(off, filter_.p[np.ix_([VX, VY, VYAW], [VX, VY, VYAW])]))
    places = [X, Y, YAW]
    of_pose = squared(pose(truth) - filter_.x[places], filter_.p[np.ix_(places, places)])
    of_odometry = squared(pose(truth) - pose(odom), planar(odom.pose.covariance))
    return of_pose, np.mean(of_twist), of_odometry


def main(ilon, robot):
    low, high = chi2.ppf([0.025, 0.975], 3 * RUNS) / RUNS
    # Noise per sample of a cheap gyroscope, and 0.3 deg/s left after zeroing its bias.
    white = "gyroscope = { noise = 0.005 }\n"
    biased = "gyroscope = { noise = 0.005, bias = 0.005, bias_walk = 0.0005 }\n"
    bags = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for imu in (white, biased):
            for run in range(RUNS):
                scenario(robot, folder, run, imu)
                command = [ilon, "run", folder / "run.toml", "--mcap", "--no-report", "-q", "--out", folder / "out"]
                subprocess.run(command, check=True)
                bags.setdefault(imu, []).append(list(messages(folder / "out" / "bag")))
    print(f"consistent at 95 % of confidence: NEES of {low:.2f} to {high:.2f}")

    def nees(what, imu, *how):
        pose, twist, odometry = np.mean([judged(rows, *how) for rows in bags[imu]], axis=0)
        print(f"{what}: pose {pose:.3f}, twist {twist:.2f}; odometry alone {odometry:.2f}")
        # A twist's covariance is that of accumulated twists: never too small for a single one.
        assert twist < 3.0 and low < odometry < high
        return pose

    assert nees("default process noise", white, DEFAULT) < 0.1
    assert low < nees("process noise of velocities alone", white, EXACT) < high
    assert nees("the same, a biased gyroscope", biased, EXACT) > high
    assert low < nees("the same, with a state for the bias", biased, EXACT, 0.005, 0.0005, True) < high


if __name__ == "__main__":
    main(*sys.argv[1:])
