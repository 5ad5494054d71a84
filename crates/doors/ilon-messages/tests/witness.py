"""Holds ilon's messages against two implementations of ROS 2's that share nothing with ilon: `rosbags` and, where it is to be had, `rclpy`.

    witness.py write FILE   writes what `rosbags` makes of messages (fixtures/messages.json)
    witness.py check FILE   checks such a file, made by ilon (tests/witness.rs does), against `rosbags` for every distribution
                            from Humble on, and against `rclpy`
    witness.py bags FILE    checks the bags beside such a file, made by ilon (tests/bag.rs does), against what it says of them

The files of the first two hold `types` (name -> definition and hash) and `samples` (type, value, and its CDR in both byte orders, in hex; from
`write` also what `rclpy` makes of it, where that is installed).
`rclpy` and its messages come with a ROS installation or, for some distributions, from PyPI: `ros-jazzy-rclpy[fastrtps]`,
`ros-jazzy-nav-msgs`, `ros-jazzy-visualization-msgs`, `ros-jazzy-diagnostic-msgs`, `ros-jazzy-rosgraph-msgs`.
"""

import importlib
import json
import random
import sys
from pathlib import Path

import numpy
from mcap.exceptions import EndOfFile, McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore
from ruamel.yaml import YAML

TOP_LEVEL = [
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/Vector3Stamped",
    "geometry_msgs/msg/WrenchStamped",
    "nav_msgs/msg/Odometry",
    "nav_msgs/msg/Path",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/String",
    "tf2_msgs/msg/TFMessage",
    "trajectory_msgs/msg/JointTrajectory",
    "visualization_msgs/msg/MarkerArray",
]
DISTRIBUTIONS = [store for store in Stores if store.name.startswith("ROS2_") and store.name >= "ROS2_HUMBLE"]
NEWEST = get_typestore(Stores.LATEST)
TEXTS = ["", "a", "odom", "base_link", "Grüße, 世界", "x" * 17]
NUMBERS = {
    "bool": lambda dice: dice.random() < 0.5,
    "byte": lambda dice: dice.randrange(128),  # rosbags takes it as signed, rclpy as unsigned
    "uint8": lambda dice: dice.randrange(256),
    "int32": lambda dice: dice.choice([-(2**31), -1, 0, 7, 2**31 - 1]),
    "uint32": lambda dice: dice.choice([0, 1, 999_999_999, 2**32 - 1]),
    "float32": lambda dice: dice.choice([-0.0, 0.5, float(numpy.float32(0.1)), 3.4028234663852886e38]),
    "float64": lambda dice: dice.choice([-0.0, 0.1, -1.5, 5e-324, 1.7976931348623157e308, round(dice.uniform(-9, 9), 3)]),
}


# Values are JSON values. ilon holds the 36 numbers of a covariance as 6 rows, and 9 as 3.


def fields_of(store, name):
    return store.fielddefs[name][1]


def draw(name, dice, fill):
    """A value of a message type; sequences have no elements unless `fill`."""

    def one(kind, of):
        if kind.name == "NAME":
            return draw(of, dice, fill)
        if of[0] == "string":
            return dice.choice(TEXTS) if fill else ""
        return NUMBERS[of[0]](dice)

    def value(kind, of):
        if kind.name == "ARRAY":
            side = {36: 6, 9: 3}[of[1]]
            return [[one(*of[0]) for _ in range(side)] for _ in range(side)]
        if kind.name == "SEQUENCE":
            return [one(*of[0]) for _ in range(dice.randrange(1, 4) if fill else 0)]
        return one(kind, of)

    return {field: value(*desc) for field, desc in fields_of(NEWEST, name)}


def to_rosbags(store, name, value):
    def one(kind, of, value):
        return to_rosbags(store, of, value) if kind.name == "NAME" else value

    def convert(kind, of, value):
        if kind.name == "ARRAY":
            return numpy.array(value, dtype=of[0][1][0]).reshape(-1)
        if kind.name == "SEQUENCE":
            inner = of[0]
            if inner[0].name == "BASE" and inner[1][0] != "string":
                return numpy.array(value, dtype=inner[1][0])
            return [one(*inner, element) for element in value]
        return one(kind, of, value)

    return store.types[name](**{field: convert(*desc, value[field]) for field, desc in fields_of(store, name)})


def from_rosbags(store, name, message):
    def one(kind, of, value):
        return from_rosbags(store, of, value) if kind.name == "NAME" else value

    def convert(kind, of, value):
        if kind.name == "ARRAY":
            side = {36: 6, 9: 3}[of[1]]
            return value.reshape(side, side).tolist()
        if kind.name == "SEQUENCE":
            return value.tolist() if isinstance(value, numpy.ndarray) else [one(*of[0], element) for element in value]
        return one(kind, of, value)

    return {field: convert(*desc, getattr(message, field)) for field, desc in fields_of(store, name)}


def exact(value):
    """As text in which different values, such as 0.0 and -0.0, differ."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False)


def sample(name, value):
    message = to_rosbags(NEWEST, name, value)
    encoded = {
        order: NEWEST.serialize_cdr(message, name, little_endian=order == "little").hex() for order in ("little", "big")
    }
    try:
        from rclpy.serialization import serialize_message

        encoded["rclpy"] = serialize_message(to_rclpy(load(name), value)).hex()
    except ImportError as error:
        print(f"{name}: without the bytes of rclpy, {error}")
    return {"type": name, "value": value, **encoded}


def write(path):
    samples = []
    for name in TOP_LEVEL:
        dice = random.Random(name)
        samples += [sample(name, draw(name, dice, fill)) for fill in (False, True, True)]
    types = {}

    def add(name):
        types[name] = {"definition": NEWEST.generate_msgdef(name, ros_version=2)[0], "hash": NEWEST.hash_rihs01(name)}
        for _, (kind, of) in fields_of(NEWEST, name):
            inner = of if kind.name == "NAME" else of[0][1] if of[0][0].__class__ is kind.__class__ else None
            if isinstance(inner, str) and inner not in types:
                add(inner)

    for name in TOP_LEVEL:
        add(name)
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"types": dict(sorted(types.items())), "samples": samples}, file, indent=0, ensure_ascii=False)
        file.write("\n")


def check_rosbags(said):
    for distribution in DISTRIBUTIONS:
        store = get_typestore(distribution)
        for name, spoken in said["types"].items():
            where = f"{distribution.name} {name}"
            assert store.hash_rihs01(name) == spoken["hash"], f"{where}: the hash differs"
            # The definition that ilon puts into bags, parsed by rosbags, has the fields of this
            # distribution, and so the hash.
            understood = Typestore()
            understood.register(get_types_from_msg(spoken["definition"], name))
            assert understood.fielddefs[name][1] == fields_of(store, name), f"{where}: the definition differs"
            assert understood.hash_rihs01(name) == spoken["hash"], f"{where}: the definition does not have the hash"
        for number, spoken in enumerate(said["samples"]):
            name, value = spoken["type"], spoken["value"]
            where = f"{distribution.name} {name}, sample {number}"
            for order in ("little", "big"):
                encoded = bytes.fromhex(spoken[order])
                message = store.deserialize_cdr(encoded, name)
                assert exact(from_rosbags(store, name, message)) == exact(value), f"{where}: rosbags reads another value ({order})"
                again = store.serialize_cdr(to_rosbags(store, name, value), name, little_endian=order == "little")
                assert bytes(again) == encoded, f"{where}: rosbags writes other bytes ({order})"
        print(f"rosbags, {distribution.name}: {len(said['types'])} types and {len(said['samples'])} samples agree")
    newest = {name: NEWEST.generate_msgdef(name, ros_version=2)[0] for name in said["types"]}
    for name, spoken in said["types"].items():
        assert spoken["definition"] == newest[name], f"{name}: the text of the definition differs from the newest"


def to_rclpy(cls, value):
    message = cls()
    for field, slot in zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True):
        kind, given = type(slot).__name__, value[field]
        inner = getattr(slot, "value_type", slot)
        if kind == "Array":
            given = numpy.array(given).reshape(-1)
        elif type(inner).__name__ == "NamespacedType":
            cls_within = load(f"{inner.namespaces[0]}/msg/{inner.name}")
            given = to_rclpy(cls_within, given) if inner is slot else [to_rclpy(cls_within, element) for element in given]
        elif getattr(slot, "typename", "") == "octet":
            given = bytes([given])
        setattr(message, field, given)
    return message


def from_rclpy(message):
    if hasattr(message, "get_fields_and_field_types"):
        return {field: from_rclpy(getattr(message, field)) for field in message.get_fields_and_field_types()}
    if isinstance(message, bytes):
        return message[0]
    if isinstance(message, numpy.ndarray):
        return message.reshape(6, 6).tolist() if message.size == 36 else message.tolist()
    if isinstance(message, str | bool | int | float):
        return message
    return [from_rclpy(element) for element in message]


def load(name):
    package, _, cls = name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), cls)


def share_of(package):
    """The folder of a package's descriptions, in a ROS installation or beside the wheels of PyPI.
    """
    try:
        from ament_index_python import get_package_share_directory

        return Path(get_package_share_directory(package))
    except (ImportError, LookupError, OSError):
        return Path(sys.prefix) / "share" / package


def check_rclpy(said):
    try:
        from rclpy.serialization import deserialize_message, serialize_message
    except ImportError as error:
        print(f"rclpy: skipped, {error}")
        return
    checked, missing = 0, set()
    for number, spoken in enumerate(said["samples"]):
        name, value = spoken["type"], spoken["value"]
        where = f"rclpy {name}, sample {number}"
        try:
            cls = load(name)
        except ImportError:
            missing.add(name)
            continue
        for order in ("little", "big"):
            message = deserialize_message(bytes.fromhex(spoken[order]), cls)
            assert exact(from_rclpy(message)) == exact(value), f"{where}: another value is read ({order})"
        ours, theirs = bytes.fromhex(spoken["little"]), serialize_message(to_rclpy(cls, value))
        # rclpy reserves alignment after an empty sequence, does not use it, and leaves extra bytes
        # at the end.
        assert len(ours) <= len(theirs) <= len(ours) + 8 * exact(value).count("[]"), f"{where}: other bytes are written"
        # It leaves padding before aligned values unset: its reading must not depend on these bytes.
        gaps = [at for at in range(len(ours)) if ours[at] != theirs[at]]
        assert not any(ours[at] for at in gaps), f"{where}: other bytes are written at {gaps}"
        assert exact(from_rclpy(deserialize_message(theirs, cls))) == exact(value), f"{where}: {gaps} are not gaps"
        checked += 1
    hashes = 0
    for name, spoken in said["types"].items():
        package, path = name.split("/", 1)
        described = share_of(package) / f"{path}.json"
        if not described.exists():
            continue
        described = json.loads(described.read_text())
        known = {entry["type_name"]: entry["hash_string"] for entry in described["type_hashes"]}
        assert known[name] == spoken["hash"], f"rclpy {name}: the hash differs"
        hashes += 1
    print(f"rclpy: {checked} samples agree; without a package: {', '.join(sorted(missing)) or 'none'}; {hashes} hashes agree")
    assert checked, "rclpy is here, but none of the messages"


def check(path):
    with open(path, encoding="utf-8") as file:
        said = json.load(file)
    assert said["samples"] and said["types"], "there is nothing to check"
    check_rosbags(said)
    check_rclpy(said)


def check_bags(path):
    expected = json.loads(Path(path).read_text())
    for name, written in expected["bags"].items():
        folder = Path(path).parent / name
        if name == "killed":
            check_killed(folder / "bag_0.mcap.ilon-partial", written)
            continue
        check_folder(folder, written, expected["qos"])
        check_file(folder / "bag_0.mcap", written)
        print(f"{name}: rosbags and mcap find all {len(written)} messages")


def check_folder(folder, written, all_qos):
    """Checks the bag as rosbags finds it by its metadata.yaml."""
    with Reader(folder) as reader:
        assert reader.message_count == len(written)
        if written:
            times = [time for _, time, _ in written]
            assert (reader.start_time, reader.end_time - 1) == (min(times), max(times)), "the times differ"
        for connection in reader.connections:
            topic = connection.topic
            count = sum(said == topic for said, _, _ in written)
            assert connection.msgcount == count, f"{topic}: {connection.msgcount} messages, not {count}"
            assert connection.digest == NEWEST.hash_rihs01(connection.msgtype), f"{topic}: another hash"
            (qos,) = connection.ext.offered_qos_profiles
            seen = [qos.reliability.name, qos.durability.name, qos.depth]
            assert seen == all_qos.get(topic, ["RELIABLE", "VOLATILE", 10]), f"{topic}: {seen}"
            assert (qos.history.name, qos.liveliness.name) == ("KEEP_LAST", "AUTOMATIC")
        for (connection, time, encoded), (topic, said, value) in zip(reader.messages(), by_time(written), strict=True):
            assert (connection.topic, time) == (topic, said)
            message = NEWEST.deserialize_cdr(encoded, connection.msgtype)
            assert exact(from_rosbags(NEWEST, connection.msgtype, message)) == exact(value), f"{topic}: another value"


def check_file(path, written):
    """Checks the file alone, by its own index and its own definitions."""
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        decoded = list(reader.iter_decoded_messages())
        assert reader.get_summary().statistics.message_count == len(decoded) == len(written)
        for (schema, channel, message, value), (topic, time, said) in zip(decoded, by_time(written), strict=True):
            assert (channel.topic, message.log_time) == (topic, time)
            assert exact(from_mcap(value)) == exact(said), f"{topic}: another value of {schema.name}"
        (about,) = [record for record in reader.iter_metadata() if record.name == "rosbag2"]
        inner = YAML(typ="safe").load(about.metadata["serialized_metadata"])
        outer = YAML(typ="safe").load((path.parent / "metadata.yaml").read_text())
        assert inner == outer["rosbag2_bagfile_information"], "the metadata in the file and beside it differ"


def check_killed(path, written):
    """Checks the file of a killed writer, read from its start until it ends."""
    with open(path, "rb") as file:
        found = []
        try:
            for _, channel, message in NonSeekingReader(file).iter_messages(log_time_order=False):
                found.append((channel.topic, message.log_time))
        except (McapError, EndOfFile) as error:
            print(f"killed: ends with {error!r}")
        assert found and found == [(topic, time) for topic, time, _ in written][: len(found)], "other messages"
        assert len(found) > 0.5 * len(written), f"only {len(found)} of {len(written)}"
        print(f"killed: mcap finds {len(found)} of {len(written)} messages")


def by_time(written):
    """In order of time; with equal times in the order of writing."""
    return sorted(written, key=lambda message: message[1])


def from_mcap(message):
    if hasattr(message, "__slots__"):
        return {field: from_mcap(getattr(message, field)) for field in message.__slots__}
    if isinstance(message, bytes):
        return list(message)
    if isinstance(message, list | tuple):
        rows = [from_mcap(element) for element in message]
        return [rows[at : at + 6] for at in range(0, 36, 6)] if len(rows) == 36 else rows
    return message


if __name__ == "__main__":
    {"write": write, "check": check, "bags": check_bags}[sys.argv[1]](sys.argv[2])
