"""Holds the bags of runs against what others make of them: `rosbags`, `mcap` and `rerun`, and a walk through the URDF that shares
nothing with ilon.

    bag_witness.py FOLDER...   each holds the results of a run (`trace.parquet`, `scenario.toml`) and its `bag/`
    --cut                      the runs were killed: their bags have no metadata, and end somewhere
"""

import re
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyarrow.parquet
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

# In metres, and for the entries of rotation matrices.
WITHIN = 1e-6
EACH_ROW = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/robot_joint_commands": "sensor_msgs/msg/JointState",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/odom": "nav_msgs/msg/Odometry",
    "/ground_truth/odom": "nav_msgs/msg/Odometry",
    "/pose": "geometry_msgs/msg/PoseStamped",
}
OTHERS = {
    "/robot_description": "std_msgs/msg/String",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/contacts": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
LATCHED = ["/robot_description", "/tf_static"]


def rotation(x, y, z, w):
    assert abs(x * x + y * y + z * z + w * w - 1) < 1e-9
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose(turned, place):
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turned, place
    return whole


def euler(roll, pitch, yaw):
    """Rz(yaw) Ry(pitch) Rx(roll), as in URDF."""
    (cr, sr), (cp, sp), (cy, sy) = [(np.cos(a), np.sin(a)) for a in (roll, pitch, yaw)]
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def about(axis, angle):
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def of_message(transform):
    t, q = transform.translation, transform.rotation
    return pose(rotation(q.x, q.y, q.z, q.w), [t.x, t.y, t.z])


class Urdf:
    """The joints of a URDF, by the link below each."""

    def __init__(self, text):
        root = ElementTree.fromstring(text)
        self.links = {link.get("name"): link for link in root.findall("link")}
        self.above = {}
        for joint in root.findall("joint"):
            origin, axis = joint.find("origin"), joint.find("axis")
            numbers = lambda node, name: np.array([float(n) for n in ((node.get(name) if node is not None else None) or "0 0 0").split()])
            at = pose(euler(*numbers(origin, "rpy")), numbers(origin, "xyz"))
            axis = numbers(axis, "xyz") if axis is not None else np.array([1.0, 0, 0])
            assert joint.find("child").get("link") not in self.above, "a link hangs twice"
            slides = joint.get("type") == "prismatic"
            self.above[joint.find("child").get("link")] = (joint.get("name"), joint.find("parent").get("link"), at, axis, slides)
        (self.root,) = [link for link in self.links if link not in self.above]

    def in_root(self, link, angles):
        if link == self.root:
            return np.eye(4)
        name, parent, at, axis, slides = self.above[link]
        moved = np.eye(4)
        if name in angles and slides:
            moved[:3, 3] = angles[name] * axis / np.linalg.norm(axis)
        elif name in angles:
            moved = pose(about(axis, angles[name]), [0, 0, 0])
        return self.in_root(parent, angles) @ at @ moved


def in_frame(frames, frame, top):
    whole = np.eye(4)
    while frame != top:
        parent, at = frames[frame]
        whole, frame = at @ whole, parent
    return whole


def near(ours, theirs, what):
    off = np.max(np.abs(np.asarray(ours) - np.asarray(theirs)))
    assert off <= WITHIN, f"{what}: off by {off}"


def read_by_rosbags(bag):
    with Reader(bag) as reader:
        store = get_typestore(Stores.LATEST)
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        latched = {c.topic for c in reader.connections if c.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"}
        messages = defaultdict(list)
        for connection, time, raw in reader.messages():
            messages[connection.topic].append((time, store.deserialize_cdr(raw, connection.msgtype)))
        assert reader.message_count == sum(map(len, messages.values()))
    return types, latched, messages


def stamp_ns(message):
    stamp = message.clock if hasattr(message, "clock") else message.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec


def check(folder):
    trace = {name: column.to_numpy() for name, column in zip(*(lambda t: (t.column_names, t.columns))(pyarrow.parquet.read_table(folder / "trace.parquet")))}
    scenario = tomllib.loads((folder / "scenario.toml").read_text())
    rows = len(trace["t_s"])
    times = [max(1, round(t * 1e9)) for t in trace["t_s"]]
    types, latched, messages = read_by_rosbags(folder / "bag")
    wheels = len([name for name in trace if re.fullmatch(r"wheel\d+_angle_rad", name)])
    names = messages["/robot_joint_commands"][0][1].name
    assert len(names) == wheels
    # Beside the wheels, the joints between bodies.
    states = messages["/joint_states"][0][1].name
    between = {match[1]: name for name in trace if (match := re.fullmatch(r"joint_(.+)_position_(?:rad|m)", name))}
    assert sorted(states) == sorted([*names, *between]), states

    # The expected topics with types, rates and times.
    expected = EACH_ROW | OTHERS
    if "reference" in scenario:
        expected["/reference"] = "geometry_msgs/msg/PoseStamped"
    if "imu" in scenario.get("sensors", {}):
        expected["/imu"] = "sensor_msgs/msg/Imu"
    each_row = [topic for topic in expected if topic not in OTHERS]
    for topic in types:
        if topic.startswith("/wheels/"):
            expected[topic] = "geometry_msgs/msg/" + ("Vector3Stamped" if topic.endswith("/slip") else "WrenchStamped")
            each_row.append(topic)
    assert types == expected, set(types.items()) ^ set(expected.items())
    assert len([topic for topic in types if topic.startswith("/wheels/")]) == 2 * wheels
    assert latched == set(LATCHED)
    for topic in each_row:
        assert [time for time, _ in messages[topic]] == times, f"{topic}: {len(messages[topic])} messages, {rows} rows"
        if topic != "/tf":
            assert [stamp_ns(message) for _, message in messages[topic]] == times, topic
    for topic in LATCHED:
        assert [time for time, _ in messages[topic]] == [1], topic
    span = trace["t_s"][-1]
    assert len(messages["/diagnostics"]) == int(np.floor(span + 1e-6)) + 1, len(messages["/diagnostics"])
    gaps = np.diff([time for time, _ in messages["/contacts"]])
    if len(gaps):
        assert abs(np.mean(gaps) - max(1e9 / 30, np.mean(np.diff(times)))) < 0.2e9 / 30, np.mean(gaps)

    # The poses of all links, by the messages and by the URDF.
    urdf = Urdf(messages["/robot_description"][0][1].data)
    frames = {}
    for t in messages["/tf_static"][0][1].transforms:
        assert t.child_frame_id not in frames
        frames[t.child_frame_id] = (t.header.frame_id, of_message(t.transform))
    static = set(frames)
    rollers = {}
    for name in trace:
        if match := re.fullmatch(r"wheel(\d+)_roller(\d+)_angle_rad", name):
            rollers[int(match[1]), int(match[2])] = name
    looked_at = 0
    for row, (_, message) in enumerate(messages["/tf"]):
        children = [t.child_frame_id for t in message.transforms]
        assert len(set(children)) == len(children) and not static & set(children), "a frame has two parents"
        for t in message.transforms:
            assert stamp_ns(t) == times[row]
            frames[t.child_frame_id] = (t.header.frame_id, of_message(t.transform))
        if row % 7 and row + 1 != rows:
            continue
        looked_at += 1
        at = lambda prefix: [trace[f"{prefix}_{c}"][row] for c in ("x_m", "y_m", "heading_rad")]
        x, y, heading = at("truth")
        real = pose(euler(trace["truth_roll_rad"][row], trace["truth_pitch_rad"][row], heading), [x, y, trace["truth_height_m"][row]])
        near(in_frame(frames, f"ground_truth/{urdf.root}", "map"), real, "truth")
        x, y, heading = at("odometry_ideal")
        reckoned = in_frame(frames, urdf.root, "odom")
        near(reckoned[:2, 3], [x, y], "odometry")
        near(in_frame(frames, urdf.root, "map"), reckoned, "odom rests on map")
        ahead = reckoned[:3, 0]
        near(np.arctan2(ahead[1], ahead[0]), np.arctan2(np.sin(heading), np.cos(heading)), "heading")
        angles = {name: trace[f"wheel{w}_angle_rad"][row] for w, name in enumerate(names)}
        angles |= {name: trace[column][row] for name, column in between.items()}
        links = set(urdf.links)
        for link in links:
            if urdf.above.get(link, ("",))[0] in angles:
                near(in_frame(frames, link, urdf.root), urdf.in_root(link, angles), link)
        # Rollers turn too, if they were sampled; at all times every link has its pose.
        for link in links:
            in_frame(frames, link, "map")
        shown = [t.child_frame_id for t in message.transforms[2 + wheels + len(between) :]]
        if shown:
            values = [trace[rollers[key]][row] for key in sorted(rollers)]
            turned = dict(zip([urdf.above[link][0] for link in shown], values, strict=True))
            for link in shown:
                near(in_frame(frames, link, urdf.root), urdf.in_root(link, angles | turned), link)
    assert looked_at > 1

    # The numbers of a row.
    for w, name in enumerate(names):
        column = lambda what: trace[f"wheel{w}_{what}"]
        joints = [m for _, m in messages["/joint_states"]]
        at = states.index(name)
        for field, what in (("position", "angle_rad"), ("velocity", "rate_rad_s"), ("effort", "torque_n_m")):
            near([getattr(m, field)[at] for m in joints], column(what), f"{name} {field}")
        near([m.velocity[w] for _, m in messages["/robot_joint_commands"]], column("target_rad_s"), name)
        slip, force = f"/wheels/{name}/slip", f"/wheels/{name}/force"
        near([(m.vector.x, m.vector.y) for _, m in messages[slip]], np.transpose([column("slip_x_m_s"), column("slip_y_m_s")]), slip)
        near([m.wrench.force.z for _, m in messages[force]], column("normal_force_n"), force)
    for name, column in between.items():
        turns = column.endswith("_rad")
        for field, what in (("position", column), ("velocity", f"joint_{name}_rate_{'rad_s' if turns else 'm_s'}"), ("effort", f"joint_{name}_force_{'n_m' if turns else 'n'}")):
            near([getattr(m, field)[states.index(name)] for _, m in messages["/joint_states"]], trace[what], f"{name} {field}")
    if "/imu" in expected:
        for field, prefix, unit in (("linear_acceleration", "imu_specific_force", "m_s2"), ("angular_velocity", "imu_rate", "rad_s")):
            columns = np.transpose([trace[f"{prefix}_{c}_{unit}"] for c in "xyz"])
            near([[getattr(getattr(m, field), c) for c in "xyz"] for _, m in messages["/imu"]], columns, f"/imu {field}")
    planar = lambda m: (m.linear.x, m.linear.y, m.angular.z)
    # Odometry uses the encoders' counts.
    faults = {kind for fault in scenario.get("faults", []) for kind in fault}
    exact = "encoder_scaled" not in faults and not scenario["sensors"]["encoders"]["rate_noise_rad_s"]
    for topic, prefix, of in (
        ("/cmd_vel", "command", lambda m: m.twist),
        ("/odom", "ideal", lambda m: m.twist.twist),
        ("/ground_truth/odom", "truth", lambda m: m.twist.twist),
    ):
        columns = [trace[f"{prefix}_{c}"] for c in ("vx_m_s", "vy_m_s", "omega_rad_s")]
        if exact or topic != "/odom":
            near([planar(of(m)) for _, m in messages[topic]], np.transpose(columns), topic)
    for topic in ("/odom", "/ground_truth/odom"):
        for _, message in messages[topic]:
            assert min(np.diag(message.pose.covariance.reshape(6, 6))) > 0
            assert min(np.diag(message.twist.covariance.reshape(6, 6))) > 0

    # A sticking force is within its cone, a sliding one at its edge; both are at the wheel's
    # contact.
    by_time = dict(zip(times, range(rows)))
    for time, array in messages["/contacts"]:
        row = by_time[time]
        assert len(array.markers) == 3 * wheels
        keys = [(m.ns, m.id) for m in array.markers]
        assert len(set(keys)) == len(keys)
        for m in array.markers:
            assert m.header.frame_id == "map"
            # The force is the mean over the row's period: a roller that left the floor at its end
            # did carry.
            touching = trace[f"wheel{m.id}_touching_share"][row] > 0
            assert m.action == (0 if touching else 2)
            if not touching or m.ns != "force":
                continue
            foot, tip = [np.array([p.x, p.y, p.z]) for p in m.points]
            heading = trace["truth_heading_rad"][row]
            turned = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
            contact = turned @ [trace[f"wheel{m.id}_contact_x_m"][row], trace[f"wheel{m.id}_contact_y_m"][row]]
            near(foot[:2] - [trace["truth_x_m"][row], trace["truth_y_m"][row]], contact, "contact")
            across = np.hypot(trace[f"wheel{m.id}_force_x_n"][row], trace[f"wheel{m.id}_force_y_n"][row])
            normal = trace[f"wheel{m.id}_normal_force_n"][row]
            reach = np.hypot(*(tip - foot)[:2])
            assert abs(reach * normal - across * (tip - foot)[2]) <= 1e-6 * max(1, normal), "the force leans otherwise"

    counts = Counter({topic: len(found) for topic, found in messages.items()})
    check_by_mcap(folder / "bag/bag_0.mcap", counts)
    transforms = {topic: sum(len(m.transforms) for _, m in messages[topic]) for topic in ("/tf", "/tf_static")}
    check_by_rerun(folder, types, counts, transforms)
    print(f"{folder.name}: {sum(counts.values())} messages of {len(counts)} topics, {rows} rows, {looked_at} of them placed by the URDF")


def check_by_mcap(path, counts):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        read = Counter(channel.topic for _, channel, _, _ in reader.iter_decoded_messages())
        assert read == counts
        assert dict((s.name, s.encoding) for s in reader.get_summary().schemas.values()).keys() >= {"tf2_msgs/msg/TFMessage"}


def check_by_rerun(folder, types, counts, transforms):
    """Rerun's own columns, without a window: all transforms and joints, and the robot's shapes."""
    rerun = Path(sys.executable).with_name("rerun")
    recording = folder / "bag.rrd"
    path = folder / "bag/bag_0.mcap"
    for arguments in (["mcap", "convert", path, "-o", recording], ["rrd", "verify", recording]):
        done = subprocess.run([rerun, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0 and "ERROR" not in done.stderr, done.stderr
    printed = subprocess.run([rerun, "rrd", "print", str(recording)], capture_output=True, text=True, check=True).stdout
    recording.unlink()
    rows = Counter()
    for line in printed.splitlines():
        if match := re.match(r"Chunk\(\S+\) with (\d+) rows \(.*?\) - (/\S+) - data columns: \[(\S*)", line):
            rows[match[2], match[3].split(":")[0]] += int(match[1])
    assert rows["/tf", "Transform3D"] == transforms["/tf"], (rows["/tf", "Transform3D"], transforms["/tf"])
    assert rows["/robot_description", "TextDocument"] == 1 and rows["/tf_static", "Transform3D"] > 0
    for topic in ("/joint_states", "/robot_joint_commands"):
        for what in ("position", "velocity", "effort"):
            expected = 0 if (topic, what) == ("/robot_joint_commands", "effort") and not rows[f"{topic}/{what}", "Scalars"] else counts[topic]
            assert rows[f"{topic}/{what}", "Scalars"] == expected, f"{topic} {what}"
    # Types without a visualisation are kept as tables.
    for topic in ("/odom", "/ground_truth/odom", "/cmd_vel", "/contacts", "/diagnostics", "/clock"):
        assert rows[topic, types[topic].replace("/", ".")] == counts[topic], topic
    assert any("visual_geometries" in entity for entity, _ in rows), "nothing to see of the robot"


def check_cut(folder):
    """A killed run: all messages of complete chunks can be read from the file alone."""
    path = folder / "bag/bag_0.mcap.ilon-partial"
    assert not (folder / "bag/metadata.yaml").exists()
    read = Counter()
    last = 0
    with path.open("rb") as file:
        try:
            for _, channel, message, _ in NonSeekingReader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(log_time_order=False):
                read[channel.topic] += 1
                last = message.log_time
        except Exception as error:  # the end is missing, which is all that may be wrong
            assert type(error).__name__ in ("EndOfFile", "RecordLengthLimitExceeded"), error
    for topic in (*EACH_ROW, "/robot_description", "/tf_static"):
        assert read[topic] > 0, f"{topic}: nothing of it"
    print(f"{folder.name}: killed, and {sum(read.values())} messages up to {last / 1e9:.2f} s can be read")


if __name__ == "__main__":
    folders = [Path(argument) for argument in sys.argv[1:] if argument != "--cut"]
    for folder in folders:
        (check_cut if "--cut" in sys.argv else check)(folder)
