"""Speaks with `ilon live --ros2` as ROS 2 does: by rclpy over Fast DDS, and by CycloneDDS, which share nothing with ilon. One file,
though long: each case begins it anew, as a process of its own.

    ros2_witness.py ILON CASE      with the loopback interface up; each case starts ilon for itself
"""

import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("ROS_DOMAIN_ID", "17")
os.environ["CYCLONEDDS_URI"] = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address='127.0.0.1' multicast='true'/></Interfaces>"
    "</General></Domain></CycloneDDS>"
)

import rclpy
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from visualization_msgs.msg import MarkerArray

REPO = Path(__file__).resolve().parents[4]
ILON = sys.argv[1]
# The robot at the origin, with only the rollers within reach, which leaves the machine time for all that listens.
SETTINGS = ["robot.roller_bodies=near", "robot.x_m=0", "robot.y_m=0", "robot.heading_deg=0"]
WHEELS = ["front_left", "front_right", "rear_left", "rear_right"]
# When CycloneDDS has found the other side, the other side need not have found it: an answer to a reader that is not known yet is lost.
MATCH_S = 1.5
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


class Ilon:
    """A live run, and what it says to whoever watches it."""

    def __init__(self, *arguments, settings=()):
        command = [ILON, "live", str(REPO / "assets/scenarios/mecanum4_circle.toml"), "--port", "0"]
        for setting in [*SETTINGS, *settings]:
            command += ["--set", setting]
        self.process = subprocess.Popen([*command, *(arguments or ("--ros2",))], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said = []
        self.reader = threading.Thread(target=lambda: self.said.extend(self.process.stderr), daemon=True)
        self.reader.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()

    def has_said(self, *parts, within=5.0):
        end = time.monotonic() + within
        while time.monotonic() < end:
            if any(all(part in line for part in parts) for line in list(self.said)):
                return True
            time.sleep(0.05)
        raise AssertionError(f"{parts} was not said, but {self.said}")

    def goes_on(self):
        assert self.process.poll() is None, f"ilon has ended: {self.said}"


class Other:
    """One of the cases below in a process of its own, which is killed at the end."""

    def __init__(self, case):
        self.process = subprocess.Popen([sys.executable, __file__, ILON, case], stdout=subprocess.PIPE, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


class Client:
    """A node of rclpy that keeps what it hears."""

    def __init__(self, name="witness"):
        self.node = rclpy.create_node(name)
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.heard, self.times = {}, {}
        self.thread = threading.Thread(target=self.spin, daemon=True)
        self.running = True
        self.thread.start()

    def spin(self):
        while self.running:
            self.executor.spin_once(timeout_sec=0.05)

    def listen(self, kind, topic, qos=10):
        kept = self.heard.setdefault(topic, [])
        self.node.create_subscription(kind, topic, kept.append, qos)
        return kept

    def publish(self, kind, topic, qos=10):
        return self.node.create_publisher(kind, topic, qos)

    def close(self):
        self.running = False
        self.thread.join()
        self.executor.shutdown()
        self.node.destroy_node()


def wait_for(condition, what, within=20.0):
    end = time.monotonic() + within
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError(f"{what} did not come in {within} s")


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def stamped(vx, vy=0.0, omega=0.0):
    message = TwistStamped()
    message.twist.linear.x, message.twist.linear.y, message.twist.angular.z = vx, vy, omega
    return message


def repeat(publisher, message, lasts_s, rate_hz=20):
    for _ in range(round(lasts_s * rate_hz)):
        publisher.publish(message)
        time.sleep(1.0 / rate_hz)


def place(odometry):
    at = odometry.pose.pose.position
    return at.x, at.y


def matched(publisher):
    wait_for(lambda: publisher.get_subscription_count() > 0, f"a reader of {publisher.topic_name}")


def topics():
    """Every topic that rclpy has a type for arrives, with frames, stamps and numbers that make sense."""
    with Ilon() as ilon:
        client = Client()
        kinds = {
            "/clock": (Clock, SENSOR),
            "/robot_description": (String, LATCHED),
            "/joint_states": (JointState, 10),
            "/robot_joint_states": (JointState, SENSOR),
            "/ilon/wheel_commands": (JointState, 10),
            "/ilon/cmd_vel": (TwistStamped, 10),
            "/odom": (Odometry, 10),
            "/ground_truth/odom": (Odometry, 10),
            "/pose": (PoseStamped, 10),
            "/wheels/front_left/slip": (Vector3Stamped, 10),
            "/wheels/front_left/force": (WrenchStamped, 10),
            "/contacts": (MarkerArray, 10),
        }
        for topic, (kind, qos) in kinds.items():
            client.listen(kind, topic, qos)
        for topic in kinds:
            wait_for(lambda: client.heard[topic], topic)
        wait_for(lambda: len(client.heard["/odom"]) > 100, "odometry")
        heard = client.heard
        assert len(heard["/robot_description"]) == 1
        assert xml.fromstring(heard["/robot_description"][0].data).tag == "robot"
        joints = heard["/joint_states"][-1]
        assert len(joints.name) == 4 == len(joints.position) == len(joints.velocity) == len(joints.effort), joints
        assert list(joints.name) == list(heard["/robot_joint_states"][-1].name)
        odometry, truth = heard["/odom"][-1], heard["/ground_truth/odom"][-1]
        assert (odometry.header.frame_id, truth.header.frame_id) == ("odom", "map")
        assert truth.child_frame_id == f"ground_truth/{odometry.child_frame_id}"
        for message in (odometry, truth):
            turn = message.pose.pose.orientation
            assert abs(turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2 - 1) < 1e-9
            assert all(message.pose.covariance[7 * axis] > 0 for axis in range(6))
        # The robot stands: four wheels carry it.
        carried = heard["/wheels/front_left/force"][-1].wrench.force.z
        assert carried > 1.0, carried
        # A row each control period, none twice and none left out.
        stamps = [seconds(message.header.stamp) for message in heard["/odom"]]
        gaps = [b - a for a, b in zip(stamps, stamps[1:])]
        assert max(gaps) - min(gaps) < 1e-6 and min(gaps) > 0, (min(gaps), max(gaps))
        assert len(heard["/contacts"]) > 0 and len(heard["/contacts"][-1].markers) >= 4
        # The graph knows the node and its topics.
        assert "ilon" in client.node.get_node_names()
        names = dict(client.node.get_topic_names_and_types())
        assert names["/tf"] == ["tf2_msgs/msg/TFMessage"] and names["/cmd_vel"] == ["geometry_msgs/msg/TwistStamped"], names
        ilon.goes_on()
        client.close()


def late():
    """Who comes late gets a robot description of 300 kB."""
    source = REPO / "assets/robots/mecanum4.urdf"
    with tempfile.TemporaryDirectory() as folder:
        text = source.read_text()
        padding = "<!-- " + "a robot with very much to say of itself " * 8000 + "-->"
        large = Path(folder) / "large.urdf"
        end = text.rindex("</robot>")
        large.write_text(text[:end] + padding + text[end:])
        with Ilon(settings=[f'robot.file="{large}"']) as ilon:
            time.sleep(3.0)
            for name in ("late_one", "later_one"):
                client = Client(name)
                heard = client.listen(String, "/robot_description", LATCHED)
                wait_for(lambda: heard, "the description")
                assert len(heard[0].data) > 300_000 and heard[0].data.rstrip().endswith("</robot>"), len(heard[0].data)
                client.close()
            ilon.goes_on()


def drive():
    """TwistStamped drives the robot; what makes no sense is limited or refused, and said; the watchdog stops it."""
    with Ilon() as ilon:
        client = Client()
        truth = client.listen(Odometry, "/ground_truth/odom")
        granted = client.listen(TwistStamped, "/ilon/cmd_vel")
        commands = client.publish(TwistStamped, "/cmd_vel")
        matched(commands)
        wait_for(lambda: truth, "the truth")
        before = place(truth[-1])
        repeat(commands, stamped(0.3), 2.0)
        wait_for(lambda: place(truth[-1])[0] - before[0] > 0.4, "the way ahead", 3.0)
        assert abs(place(truth[-1])[1] - before[1]) < 0.02
        ilon.has_said("no command for 0.5 s")
        time.sleep(0.7)
        stood = place(truth[-1])
        time.sleep(0.5)
        assert math.dist(stood, place(truth[-1])) < 2e-3, "it goes on without a command"
        # To the side, as none but omnidirectional robots can.
        repeat(commands, stamped(0.0, 0.3), 1.5)
        wait_for(lambda: place(truth[-1])[1] - stood[1] > 0.25, "the way to the side", 3.0)

        commands.publish(stamped(math.nan))
        ilon.has_said("vx is no number")
        commands.publish(stamped(0.0, 1e9))
        ilon.has_said("vy 1000000000 is out of range", "20 is taken")
        commands.publish(stamped(0.0))
        time.sleep(0.3)
        assert all(math.isfinite(m.twist.linear.x) and abs(m.twist.linear.y) <= 20.0 for m in granted)
        # An old stamp is refused, one of the wall's clock is taken and said.
        old = stamped(0.3)
        old.header.stamp.nanosec = 1
        commands.publish(old)
        ilon.has_said("its stamp is", "s old")
        wall = stamped(0.0)
        wall.header.stamp = client.node.get_clock().now().to_msg()
        commands.publish(wall)
        ilon.has_said("use_sim_time")
        # The other type, and the other reliability, are said; a process of its own, for one cannot have two types on a topic.
        with Other("misfits"):
            ilon.has_said("/cmd_vel is published as geometry_msgs/msg/Twist,", within=15.0)
            ilon.has_said("/robot_joint_commands is published with best effort")
            ilon.has_said("another node publishes /clock")
        ilon.goes_on()
        client.close()


def unstamped():
    """Twist drives where it is asked for, and TwistStamped is said to be the other type."""
    with Ilon("--ros2", "--unstamped") as ilon:
        client = Client()
        truth = client.listen(Odometry, "/ground_truth/odom")
        commands = client.publish(Twist, "/cmd_vel")
        matched(commands)
        message = Twist()
        message.linear.x = 0.3
        repeat(commands, message, 1.5)
        wait_for(lambda: truth and place(truth[-1])[0] > 0.25, "the way ahead", 3.0)
        with Other("stamped_one"):
            ilon.has_said("/cmd_vel is published as geometry_msgs/msg/TwistStamped", within=15.0)
        client.close()


def wheels():
    """Wheel commands as joint_state_topic_hardware_interface gives them, and as an array; joint states as it reads them."""
    with Ilon("--ros2=controllers") as ilon:
        client = Client()
        states = client.listen(JointState, "/robot_joint_states", SENSOR)
        truth = client.listen(Odometry, "/ground_truth/odom")
        commands = client.publish(JointState, "/robot_joint_commands", 1)
        array = client.publish(Float64MultiArray, "/wheel_commands")
        matched(commands)
        matched(array)
        wait_for(lambda: states, "joint states")
        names = list(states[-1].name)
        assert len(names) == 4
        # What its controllers publish is left to them.
        published = dict(client.node.get_topic_names_and_types())
        assert not {"/joint_states", "/odom"} & set(published), published
        # A controller manager takes this description, and fails on one without the block.
        described = client.listen(String, "/robot_description", LATCHED)
        wait_for(lambda: described, "the description")
        (block,) = xml.fromstring(described[0].data).findall("ros2_control")
        assert sorted(joint.get("name") for joint in block.findall("joint")) == sorted(names)
        # In another order than the robot's, as a hardware interface has its own; first NaN, as before the controllers are active.
        message = JointState(name=list(reversed(names)), velocity=[math.nan] * 4)
        repeat(commands, message, 0.5)
        ilon.has_said("NaN", "it stands")
        assert max(abs(rate) for rate in states[-1].velocity) < 0.1
        message.velocity = [4.0, 3.0, 2.0, 1.0]
        repeat(commands, message, 1.0, 100)
        rates = dict(zip(states[-1].name, states[-1].velocity))
        for name, wanted in zip(names, (1.0, 2.0, 3.0, 4.0)):
            assert abs(rates[name] - wanted) < 0.3, rates
        # Positions for every name, finite, as the interface reads them.
        assert all(math.isfinite(angle) for angle in states[-1].position) and len(states[-1].position) == 4
        before = place(truth[-1])
        repeat(array, Float64MultiArray(data=[3.0] * 4), 1.5, 50)
        assert math.dist(before, place(truth[-1])) > 0.1, "the array drives nothing"
        array.publish(Float64MultiArray(data=[1.0, 2.0]))
        ilon.has_said("2 numbers for the 4 wheels")
        commands.publish(JointState(name=names, velocity=[1.0]))
        ilon.has_said("4 names and 1 velocities")
        array.publish(Float64MultiArray(data=[1e6, 0.0, 0.0, 0.0]))
        ilon.has_said("out of range")
        ilon.goes_on()
        client.close()


def restart():
    """Either side goes away, killed, and comes again: the other one goes on with it."""
    client = Client()
    odometry = client.listen(Odometry, "/odom")
    latched = client.listen(String, "/robot_description", LATCHED)
    commands = client.publish(TwistStamped, "/cmd_vel")
    for turn in range(2):
        with Ilon() as ilon:
            came = len(odometry)
            wait_for(lambda: len(odometry) > came + 50, f"odometry of run {turn}", 30.0)
            wait_for(lambda: len(latched) > turn, f"the description of run {turn}")
            matched(commands)
            repeat(commands, stamped(0.3), 1.5)
            wait_for(lambda: place(odometry[-1])[0] > 0.2, f"the way of run {turn}", 3.0)
            if turn == 1:
                # Now the others: a process that is killed, and one that comes after it.
                for _ in range(2):
                    with Other("listen") as other:
                        line = other.process.stdout.readline()
                        assert "heard" in line, line
                came = len(odometry)
                wait_for(lambda: len(odometry) > came + 50, "odometry after the others have gone")
            ilon.goes_on()
    client.close()


def listen():
    """Of `restart`: hears odometry and waits to be killed."""
    client = Client("other")
    odometry = client.listen(Odometry, "/odom")
    latched = client.listen(String, "/robot_description", LATCHED)
    wait_for(lambda: len(odometry) > 20 and latched, "odometry")
    print("heard", flush=True)
    time.sleep(60)


def leave():
    """Interrupted, terminated, or at its end by itself: the command ends well, and its node has left the graph within a second."""
    client = Client()
    names = lambda: client.node.get_node_names()
    for signal_sent in (signal.SIGINT, signal.SIGTERM, None):
        arguments = ("--ros2",) if signal_sent else ("--ros2", "--seconds", "4")
        with Ilon(*arguments) as ilon:
            wait_for(lambda: "ilon" in names(), "the node")
            if signal_sent:
                ilon.process.send_signal(signal_sent)
            assert ilon.process.wait(10.0) == 0, ilon.said
            wait_for(lambda: "ilon" not in names(), f"the node's leaving after {signal_sent}", 1.0)
    client.close()


def namespaces():
    """Two robots in one domain: each has its own node, topics, services and time below its namespace, and hears its own commands alone."""
    client = Client()
    odometry = [client.listen(Odometry, f"/{name}/odom") for name in ("one", "fleet/two")]
    commands = client.publish(TwistStamped, "/fleet/two/cmd_vel")
    with Ilon("--ros2", "--namespace", "one"), Ilon("--ros2", "--namespace", "/fleet/two") as second:
        assert "/fleet/two/ilon" in second.process.stdout.readline()
        wait_for(lambda: all(odometry), "odometry of both")
        places = lambda: sorted(place for name, place in client.node.get_node_names_and_namespaces() if name == "ilon")
        wait_for(lambda: places() == ["/fleet/two", "/one"], "both nodes")
        topics = lambda: {name for name, _ in client.node.get_topic_names_and_types()}
        wait_for(lambda: {"/one/clock", "/fleet/two/clock", "/one/tf"} <= topics(), "the topics of both")
        assert not {"/clock", "/tf", "/odom", "/cmd_vel", "/ilon/cmd_vel"} & topics(), topics()
        services = lambda: {name for name, _ in client.node.get_service_names_and_types()}
        wait_for(lambda: {"/one/ilon/reset_simulation", "/fleet/two/ilon/set_parameters"} <= services(), "the services of both")
        matched(commands)
        wait_for(lambda: repeat(commands, stamped(0.3), 0.2) or place(odometry[1][-1])[0] > 0.2, "the drive of the second")
        # The other stands still.
        assert abs(place(odometry[0][-1])[0]) < 1e-3, place(odometry[0][-1])
    for wrong in ("1st", "a b", "a//b", "/"):
        with Ilon("--ros2", "--namespace", wrong) as refused:
            assert refused.process.wait(10.0) == 2 and refused.has_said("letters, digits and _")
    client.close()


def misfits():
    """Of `drive`: publishers that do not go with ilon."""
    client = Client("misfits")
    kept = [client.publish(Twist, "/cmd_vel"), client.publish(JointState, "/robot_joint_commands", SENSOR), client.publish(Clock, "/clock")]
    time.sleep(60)
    client.close()
    del kept


def stamped_one():
    """Of `unstamped`: a publisher of the other type."""
    client = Client("stamped_one")
    kept = client.publish(TwistStamped, "/cmd_vel")
    time.sleep(60)
    client.close()
    del kept


def square():
    """The example drives its square, and the two odometries are as far apart as slip makes them."""
    with Ilon():
        script = REPO / "examples/ros2/drive_square.py"
        ran = subprocess.run(
            [sys.executable, str(script), "--side", "0.6", "--patience", "90"], capture_output=True, text=True, timeout=120
        )
        print(ran.stdout)
        assert ran.returncode == 0, ran.stderr
        rows = [line.split() for line in ran.stdout.splitlines() if line.strip()[:1].isdigit()]
        assert len(rows) == 4, ran.stdout
        for (x, y), row in zip(((0.6, 0), (0.6, 0.6), (0, 0.6), (0, 0)), rows):
            # By its own odometry it is at the corner; really, a few per cent of the way off at most: rollers creep.
            assert math.dist((x, y), (float(row[1]), float(row[2]))) < 0.01, row
            assert math.dist((x, y), (float(row[4]), float(row[5]))) < 0.1, row
        assert any(float(row[-1]) > 0.1 for row in rows), "the estimate is the truth"


def cyclone():
    """CycloneDDS hears /tf, /tf_static, /diagnostics and odometry, drives, and has time paused, stepped and reset by services."""
    from typing import Sequence

    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.annotations import final
    from cyclonedds.idl.types import array, float64, int32, sequence, uint8, uint32, uint64
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    def struct(name):
        package, kind, short = name.split("/")

        def made(cls):
            fields = {key: value for key, value in cls.__dict__.items() if key not in ("__dict__", "__weakref__")}
            named = {"typename": f"{package}::{kind}::dds_::{short}_"}
            return dataclass(final(types.new_class(cls.__name__, (IdlStruct,), named, lambda body: body.update(fields))))

        return made

    @struct("builtin_interfaces/msg/Time")
    class Time:
        sec: int32 = 0
        nanosec: uint32 = 0

    @struct("std_msgs/msg/Header")
    class Header:
        stamp: Time
        frame_id: str = ""

    @struct("geometry_msgs/msg/Vector3")
    class Vector3:
        x: float64 = 0.0
        y: float64 = 0.0
        z: float64 = 0.0

    @struct("geometry_msgs/msg/Quaternion")
    class Quaternion:
        x: float64
        y: float64
        z: float64
        w: float64

    @struct("geometry_msgs/msg/Transform")
    class Transform:
        translation: Vector3
        rotation: Quaternion

    @struct("geometry_msgs/msg/TransformStamped")
    class TransformStamped:
        header: Header
        child_frame_id: str
        transform: Transform

    @struct("tf2_msgs/msg/TFMessage")
    class TFMessage:
        transforms: sequence[TransformStamped]

    @struct("geometry_msgs/msg/Pose")
    class Pose:
        position: Vector3
        orientation: Quaternion

    @struct("geometry_msgs/msg/PoseWithCovariance")
    class PoseWithCovariance:
        pose: Pose
        covariance: array[float64, 36]

    @struct("geometry_msgs/msg/Twist")
    class CycloneTwist:
        linear: Vector3
        angular: Vector3

    @struct("geometry_msgs/msg/TwistWithCovariance")
    class TwistWithCovariance:
        twist: CycloneTwist
        covariance: array[float64, 36]

    @struct("nav_msgs/msg/Odometry")
    class CycloneOdometry:
        header: Header
        child_frame_id: str
        pose: PoseWithCovariance
        twist: TwistWithCovariance

    @struct("geometry_msgs/msg/TwistStamped")
    class CycloneTwistStamped:
        header: Header
        twist: CycloneTwist

    @struct("diagnostic_msgs/msg/KeyValue")
    class KeyValue:
        key: str
        value: str

    @struct("diagnostic_msgs/msg/DiagnosticStatus")
    class DiagnosticStatus:
        level: uint8
        name: str
        message: str
        hardware_id: str
        values: sequence[KeyValue]

    @struct("diagnostic_msgs/msg/DiagnosticArray")
    class DiagnosticArray:
        header: Header
        status: sequence[DiagnosticStatus]

    @struct("simulation_interfaces/msg/Result")
    class Result:
        result: uint8
        error_message: str

    @struct("simulation_interfaces/srv/StepSimulation_Request")
    class Step:
        steps: uint64

    @struct("simulation_interfaces/srv/StepSimulation_Response")
    class StepAnswer:
        result: Result

    @struct("simulation_interfaces/srv/ResetSimulation_Request")
    class Reset:
        scope: uint8

    @struct("simulation_interfaces/srv/ResetSimulation_Response")
    class ResetAnswer:
        result: Result

    @struct("simulation_interfaces/srv/SetSimulationState_Request")
    class SetState:
        state: uint8

    @struct("simulation_interfaces/srv/SetSimulationState_Response")
    class SetStateAnswer:
        result: Result

    reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
    # ROS 2 writes plain CDR, which CycloneDDS calls version 0.
    plain = Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False)
    volatile = Qos(plain, reliable, Policy.Durability.Volatile, Policy.History.KeepLast(200))
    latched = Qos(plain, reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
    with Ilon() as ilon:
        participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))

        def reader(name, kind, qos=volatile):
            return DataReader(participant, Topic(participant, name, kind, qos=qos), qos=qos)

        def writer(name, kind):
            return DataWriter(participant, Topic(participant, name, kind, qos=volatile), qos=volatile)

        def come(source, what, within=20.0):
            kept = []
            wait_for(lambda: kept.extend(source.take(1000)) or kept, what, within)
            return kept

        time.sleep(1.0)
        frames = reader("rt/tf", TFMessage)
        odometry = reader("rt/odom", CycloneOdometry)
        truth = reader("rt/ground_truth/odom", CycloneOdometry)
        moving = {t.child_frame_id: t.header.frame_id for t in come(frames, "/tf")[-1].transforms}
        fixed = {t.child_frame_id: t.header.frame_id for t in come(reader("rt/tf_static", TFMessage, latched), "/tf_static")[-1].transforms}
        base = come(odometry, "/odom")[-1].child_frame_id
        assert moving[base] == "odom" and fixed["odom"] == "map", (moving, fixed)
        assert moving[f"ground_truth/{base}"] == "map"
        # Each frame hangs on one other, up to the map.
        tree = {**fixed, **moving}
        assert not set(fixed) & set(moving)
        for frame in tree:
            for _ in range(len(tree)):
                frame = tree.get(frame, frame)
            assert frame == "map", frame
        report = come(reader("rt/diagnostics", DiagnosticArray), "/diagnostics")[-1]
        assert any("error budget" in status.name for status in report.status), report
        assert come(odometry, "odometry")[-1].pose.covariance[0] > 0

        commands = writer("rt/cmd_vel", CycloneTwistStamped)
        ahead = CycloneTwistStamped(Header(Time(), "base_link"), CycloneTwist(Vector3(0.3), Vector3()))
        wait_for(commands.get_matched_subscriptions, "a reader of /cmd_vel")
        time.sleep(MATCH_S)
        for _ in range(40):
            commands.write(ahead)
            time.sleep(0.05)
        assert come(truth, "the truth")[-1].pose.pose.position.x > 0.3

        def ask(name, request_type, answer_type, request, within=20.0):
            asks = writer(f"rq/ilon/{name}Request", request_type)
            answers = reader(f"rr/ilon/{name}Reply", answer_type)
            wait_for(lambda: asks.get_matched_subscriptions() and answers.get_matched_publications(), f"the service {name}")
            time.sleep(MATCH_S)
            asks.write(request)
            return come(answers, f"the answer of {name}", within)[-1].result

        refused = ask("step_simulation", Step, StepAnswer, Step(1))
        assert refused.result == 3 and "pause" in refused.error_message, refused
        assert ask("set_simulation_state", SetState, SetStateAnswer, SetState(2)).result == 1
        time.sleep(0.5)
        truth.take(1000)
        time.sleep(0.5)
        assert not truth.take(1000), "time goes on"
        # Lockstep: so many steps, so many rows, and then none.
        assert ask("step_simulation", Step, StepAnswer, Step(7)).result == 1
        rows = come(truth, "the rows of the steps", 5.0)
        time.sleep(0.5)
        rows += truth.take(1000)
        assert len(rows) == 7, len(rows)
        assert ask("reset_simulation", Reset, ResetAnswer, Reset(1)).result == 0
        assert ask("reset_simulation", Reset, ResetAnswer, Reset(0)).result == 1
        assert ask("step_simulation", Step, StepAnswer, Step(1)).result == 1
        back = come(truth, "the row after the reset", 5.0)[-1]
        assert abs(back.pose.pose.position.x) < 1e-3, back.pose.pose
        stamps = [row.header.stamp.sec + 1e-9 * row.header.stamp.nanosec for row in [*rows, back]]
        assert all(b > a for a, b in zip(stamps, stamps[1:])), "time went back"
        assert ask("set_simulation_state", SetState, SetStateAnswer, SetState(2)).result == 101
        assert ask("set_simulation_state", SetState, SetStateAnswer, SetState(1)).result == 1
        come(truth, "time that goes on again", 5.0)
        ilon.goes_on()


def parameters():
    """Parameters are listed, described, read and set by rclpy's own client, over services; the floor turns to ice."""
    from rclpy.parameter import Parameter
    from rclpy.parameter_client import AsyncParameterClient

    with Ilon() as ilon:
        client = Client()
        truth = client.listen(Odometry, "/ground_truth/odom")
        commands = client.publish(TwistStamped, "/cmd_vel")
        asks = AsyncParameterClient(client.node, "ilon")
        assert asks.wait_for_services(20.0), "the services of parameters do not come"

        def answer(future):
            wait_for(future.done, "an answer")
            return future.result()

        names = answer(asks.list_parameters()).result.names
        assert {"friction", "payload_kg", "paused", "mode", "speed", "resets"} <= set(names), names
        # Each answer goes to its own question.
        for name, kind in (("friction", 3), ("mode", 4), ("paused", 1), ("resets", 2), ("other", 0)):
            assert answer(asks.get_parameters([name])).values[0].type == kind, name
            assert answer(asks.get_parameter_types([name])).types[0] == kind, name
            assert answer(asks.describe_parameters([name])).descriptors[0].type == kind, name
        first, second = asks.get_parameters(["mode"]), asks.get_parameters(["paused"])
        assert (answer(first).values[0].type, answer(second).values[0].type) == (4, 1)

        def way():
            answer(asks.set_parameters([Parameter("resets", value=10**6)]))
            time.sleep(0.5)
            before = place(truth[-1])
            repeat(commands, stamped(0.5), 0.6)
            return place(truth[-1])[0] - before[0]

        matched(commands)
        floor = way()
        assert answer(asks.set_parameters([Parameter("friction", value=0.01)])).results[0].successful
        assert answer(asks.get_parameters(["friction"])).values[0].double_value == 0.01
        ice = way()
        assert ice < 0.5 * floor and floor > 0.15, (ice, floor)
        # What would not hold is refused, and changes nothing.
        refused = answer(asks.set_parameters([Parameter("friction", value=-3.0)])).results[0]
        assert not refused.successful and "from 0 to 2" in refused.reason, refused
        for name, value in (("friction", "much"), ("mode", "fly"), ("other", 1), ("paused", 3)):
            refused = answer(asks.set_parameters([Parameter(name, value=value)])).results[0]
            assert not refused.successful and name in refused.reason, refused
        # All or none.
        both = [Parameter("friction", value=0.7), Parameter("mode", value="fly")]
        assert not answer(asks.set_parameters_atomically(both)).result.successful
        assert answer(asks.get_parameters(["friction"])).values[0].double_value == 0.01
        both = [Parameter("friction", value=0.7), Parameter("mode", value="reference")]
        assert answer(asks.set_parameters_atomically(both)).result.successful
        ilon.goes_on()
        client.close()


def environment():
    """The domain counts; what makes no sense ends with a reason."""
    for name, value in (("ROS_DOMAIN_ID", "300"), ("ROS_LOCALHOST_ONLY", "maybe"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")):
        before = os.environ.get(name)
        os.environ[name] = value
        with Ilon() as ilon:
            assert ilon.process.wait(20) == 2, ilon.said
            ilon.has_said(name, value)
        del os.environ[name]
        if before is not None:
            os.environ[name] = before
    client = Client()
    odometry = client.listen(Odometry, "/odom")
    os.environ["ROS_DOMAIN_ID"] = "18"
    with Ilon() as ilon:
        assert "domain 18" in ilon.process.stdout.readline()
        time.sleep(4.0)
        assert not odometry, "heard over another domain"
    client.close()


if __name__ == "__main__":
    case = sys.argv[2]
    rclpy.init()
    try:
        globals()[case]()
        print(f"{case}: held")
    finally:
        if rclpy.ok():
            rclpy.shutdown()
