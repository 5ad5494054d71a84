"""Writes a bag of an arm with `rosbags`, as its driver would: states with unknown positions.

    joint_bag.py BAG rate|effort
"""

import math
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

SAID = {
    # 0.4 rad/s for half a second, then at rest.
    "rate": [(0.0, 0.4), (0.5, 0.0), (1.0, 0.0)],
    # 0.4 N m until a second has passed.
    "effort": [(0.0, 0.4), (0.5, 0.4)],
}


def main(bag: str, by: str) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    state, header, time = (store.types[f"{name}"] for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"))
    with Writer(Path(bag), version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for t_s, number in SAID[by]:
            ns = 1_732_255_000_000_000_000 + round(t_s * 1e9)
            numbers = lambda known: np.array([0.0, number] if known else [math.nan, math.nan])
            message = state(
                header=header(stamp=time(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""),
                name=["gripper", "arm"],
                position=numbers(False),
                velocity=numbers(by == "rate"),
                effort=numbers(by == "effort"),
            )
            writer.write(topic, ns, store.serialize_cdr(message, state.__msgtype__))


main(*sys.argv[1:])
