"""Views and drives as Foxglove does, with `websockets` and decoders that share no code with ilon:
foxglove.py URL
"""

import asyncio
import json
import os
import struct
import sys
import xml.etree.ElementTree as xml

import websockets
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

URL = sys.argv[1]
PROTOCOL = websockets.Subprotocol("foxglove.sdk.v1")
STORE = get_typestore(Stores.ROS2_JAZZY)


class Viewer:
    """One client, with the server's messages by kind."""

    async def __aenter__(self):
        self.socket = await websockets.connect(URL, subprotocols=[PROTOCOL], max_size=None)
        assert self.socket.subprotocol == PROTOCOL
        self.channels, self.info, self.status, self.values, self.updates = {}, None, [], {}, {}
        self.messages, self.times, self.subscribed = {}, [], {}
        self.states = []
        self.task = asyncio.create_task(self.read())
        await self.until(lambda: self.info and "/odom" in self.channels, "the channels")
        return self

    async def __aexit__(self, *_):
        self.task.cancel()
        await self.socket.close()

    async def read(self):
        async for data in self.socket:
            if isinstance(data, str):
                message = json.loads(data)
                if message["op"] == "serverInfo":
                    self.info = message
                elif message["op"] == "advertise":
                    self.channels.update({channel["topic"]: channel for channel in message["channels"]})
                elif message["op"] == "status":
                    self.status.append(message["message"])
                elif message["op"] == "parameterValues":
                    self.updates.update({p["name"]: p.get("value") for p in message["parameters"]})
                    if "id" in message:
                        self.values[message["id"]] = {p["name"]: p.get("value") for p in message["parameters"]}
            elif data[0] == 1:
                subscription, log_time = struct.unpack_from("<IQ", data, 1)
                self.messages.setdefault(self.subscribed[subscription], []).append((log_time, data[13:]))
            elif data[0] == 2:
                self.times.append(struct.unpack_from("<Q", data, 1)[0])
            elif data[0] == 5:
                status, now_ns, speed, did_seek, length = struct.unpack_from("<BQfBI", data, 1)
                self.states.append((("playing", "paused", "buffering", "ended")[status], now_ns, speed, bool(did_seek), data[19 : 19 + length].decode()))

    async def say(self, **message):
        await self.socket.send(json.dumps(message))

    async def subscribe(self, *topics):
        for topic in topics:
            number = len(self.subscribed) + 1
            self.subscribed[number] = topic
            await self.say(op="subscribe", subscriptions=[{"id": number, "channelId": self.channels[topic]["id"]}])

    async def until(self, holds, what, within=20.0):
        end = asyncio.get_running_loop().time() + within
        while not holds():
            assert asyncio.get_running_loop().time() < end, f"{what} did not come; said: {self.status[-3:]}"
            assert not self.task.done(), f"{what}: the server has closed: {self.task}"
            await asyncio.sleep(0.02)

    async def last(self, topic):
        """A message that is not older than this call."""
        came = len(self.messages.get(topic, []))
        await self.until(lambda: len(self.messages.get(topic, [])) > came, topic)
        return self.decoded(topic)

    def decoded(self, topic):
        channel = self.channels[topic]
        assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg"), channel
        schema = Schema(id=1, name=channel["schemaName"], encoding="ros2msg", data=channel["schema"].encode())
        return DecoderFactory().decoder_for("cdr", schema)(self.messages[topic][-1][1])

    async def advertise(self, number, topic, kind, encoding):
        await self.say(op="advertise", channels=[{"id": number, "topic": topic, "encoding": encoding, "schemaName": kind}])

    async def publish(self, number, payload):
        await self.socket.send(struct.pack("<BI", 1, number) + payload)

    async def control_time(self, name, pause=False, speed=1.0, seek_ns=None):
        request = struct.pack("<BBfBQI", 3, pause, speed, seek_ns is not None, seek_ns or 0, len(name)) + name.encode()
        await self.socket.send(request)
        await self.until(lambda: any(state[4] == name for state in self.states), f"the answer to {name}")
        return next(state for state in self.states if state[4] == name)[:4]

    async def has_said(self, *parts):
        await self.until(lambda: any(all(part in line for part in parts) for line in self.status), parts)

    async def set(self, **values):
        self.values.pop("set", None)
        await self.say(op="setParameters", id="set", parameters=[{"name": name, "value": value} for name, value in values.items()])
        await self.until(lambda: "set" in self.values, f"the answer to {values}")
        return self.values["set"]


def twist_cdr(kind, vx, vy=0.0, omega=0.0):
    types = STORE.types
    vector = types["geometry_msgs/msg/Vector3"]
    twist = types["geometry_msgs/msg/Twist"](linear=vector(x=vx, y=vy, z=0.0), angular=vector(x=0.0, y=0.0, z=omega))
    if kind.endswith("TwistStamped"):
        stamp = types["builtin_interfaces/msg/Time"](sec=1_790_000_000, nanosec=0)
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")
        twist = types[kind](header=header, twist=twist)
    return bytes(STORE.serialize_cdr(twist, kind))


def place(odometry):
    at = odometry.pose.pose.position
    return at.x, at.y


def resident_mb():
    """Memory of the serving process, which has started this one."""
    with open(f"/proc/{os.getppid()}/status") as status:
        line = next(line for line in status if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


async def refused(*protocols):
    try:
        async with websockets.connect(URL, subprotocols=[websockets.Subprotocol(name) for name in protocols] or None):
            return False
    except (websockets.exceptions.InvalidHandshake, websockets.exceptions.InvalidMessage):
        return True


async def looks_on():
    async with Viewer() as viewer:
        assert {"clientPublish", "parameters", "parametersSubscribe", "time"} <= set(viewer.info["capabilities"]), viewer.info
        assert set(viewer.info["supportedEncodings"]) == {"json", "cdr"}
        wanted = {"/clock", "/robot_description", "/tf", "/tf_static", "/joint_states", "/odom", "/ground_truth/odom", "/ilon/cmd_vel", "/contacts", "/diagnostics", "/pose"}
        assert wanted <= set(viewer.channels), wanted - set(viewer.channels)
        assert "/cmd_vel" not in viewer.channels
        await viewer.subscribe(*viewer.channels)
        # A robot driven by hand follows no reference.
        every = set(viewer.channels) - {"/reference"}
        for topic in every:
            await viewer.until(lambda: topic in viewer.messages, topic)
        assert "/reference" not in viewer.messages
        for topic in every:
            assert viewer.decoded(topic) is not None
        # A latched message arrives though nobody listened when it was sent.
        assert len(viewer.messages["/robot_description"]) == 1 == len(viewer.messages["/tf_static"])
        assert xml.fromstring(viewer.decoded("/robot_description").data).tag == "robot"
        log_time, _ = viewer.messages["/odom"][-1]
        stamp = viewer.decoded("/odom").header.stamp
        assert log_time == stamp.sec * 10**9 + stamp.nanosec
        await viewer.until(lambda: len(viewer.times) > 5, "the time")
        assert all(b >= a for a, b in zip(viewer.times, viewer.times[1:]))


async def drives():
    async with Viewer() as viewer:
        await viewer.subscribe("/ground_truth/odom", "/ilon/cmd_vel")
        cases = [
            ("geometry_msgs/Twist", "json", lambda vx, vy: json.dumps({"linear": {"x": vx, "y": vy, "z": 0}, "angular": {"z": 0}}).encode()),
            ("geometry_msgs/msg/Twist", "cdr", lambda vx, vy: twist_cdr("geometry_msgs/msg/Twist", vx, vy)),
            ("geometry_msgs/msg/TwistStamped", "cdr", lambda vx, vy: twist_cdr("geometry_msgs/msg/TwistStamped", vx, vy)),
            ("geometry_msgs/TwistStamped", "json", lambda vx, vy: json.dumps({"twist": {"linear": {"x": vx, "y": vy}}}).encode()),
        ]
        for number, (kind, encoding, payload) in enumerate(cases, 1):
            await viewer.advertise(number, "/cmd_vel", kind, encoding)
            before = place(await viewer.last("/ground_truth/odom"))
            for _ in range(12):
                await viewer.publish(number, payload(0.0, 0.3))
                await asyncio.sleep(0.1)
            after = place(await viewer.last("/ground_truth/odom"))
            assert after[1] - before[1] > 0.2 and abs(after[0] - before[0]) < 0.05, (kind, encoding, before, after)
        await viewer.has_said("no command for 0.5 s")

        # Invalid commands are refused or limited, with a message, and the robot stands.
        await viewer.publish(2, twist_cdr("geometry_msgs/msg/Twist", float("nan")))
        await viewer.has_said("vx is no number")
        await viewer.publish(2, twist_cdr("geometry_msgs/msg/Twist", 0.0, 0.0, float("inf")))
        await viewer.has_said("omega inf is out of range")
        await viewer.publish(1, b'{"linear": {"x": 0}}')
        for number, payload in ((1, b"{"), (1, b'{"linear": {"x": null}}'), (2, b"\x00\x01\x00\x00"), (2, b""), (3, b"\xff" * 40)):
            viewer.status.clear()
            await viewer.publish(number, payload)
            await viewer.has_said("/cmd_vel is not taken")
        await viewer.advertise(9, "/cmd_vel", "std_msgs/msg/String", "cdr")
        await viewer.publish(9, b"\x00\x01\x00\x00\x01\x00\x00\x00\x00")
        await viewer.has_said("std_msgs/String as cdr drives nothing")
        await viewer.advertise(10, "/wheel_commands", "std_msgs/Float64MultiArray", "json")
        await viewer.publish(10, b'{"data": [1, 2]}')
        await viewer.has_said("2 numbers for the 4 wheels")
        command = await viewer.last("/ilon/cmd_vel")
        assert abs(command.twist.linear.x) < 1e-9, command


async def changes():
    async with Viewer() as viewer:
        await viewer.subscribe("/ground_truth/odom", "/contacts", "/wheels/front_left/force")
        await viewer.say(op="getParameters", parameterNames=[], id="get")
        await viewer.until(lambda: "get" in viewer.values, "the parameters")
        values = viewer.values["get"]
        assert {"friction", "payload_kg", "position_gain_per_s", "heading_gain_per_s", "mode", "priority", "speed", "paused", "resets"} == set(values), values
        assert values["mode"] == "hand" and values["payload_kg"] == 0 and values["friction"] > 0.1
        await viewer.say(op="subscribeParameterUpdates", parameterNames=list(values))

        # A load increases the wheels' forces.
        force = (await viewer.last("/wheels/front_left/force")).wrench.force.z
        assert await viewer.set(payload_kg=20) == {"payload_kg": 20}
        await asyncio.sleep(0.5)
        loaded = (await viewer.last("/wheels/front_left/force")).wrench.force.z
        assert loaded - force > 20 * 9.81 / 4 / 2, (force, loaded)
        await viewer.set(payload_kg=0)

        # On ice the robot hardly moves.
        assert await viewer.set(friction=0.01) == {"friction": 0.01}
        await viewer.advertise(1, "/cmd_vel", "geometry_msgs/Twist", "json")

        async def way():
            await viewer.set(resets=1e6)
            await asyncio.sleep(0.3)
            before = place(await viewer.last("/ground_truth/odom"))
            for _ in range(6):
                await viewer.publish(1, b'{"linear": {"x": 0.5}}')
                await asyncio.sleep(0.1)
            return place(await viewer.last("/ground_truth/odom"))[0] - before[0]

        ice = await way()
        await viewer.set(friction=values["friction"])
        floor = await way()
        assert ice < 0.5 * floor and floor > 0.15, (ice, floor)

        # Pause and resume; changes by one client are shown to another.
        async with Viewer() as other:
            await other.say(op="subscribeParameterUpdates", parameterNames=["paused"])
            assert await viewer.set(paused=True) == {"paused": True}
            await other.until(lambda: other.updates.get("paused") is True, "the pause")
        await asyncio.sleep(0.3)
        came = len(viewer.messages["/ground_truth/odom"])
        await asyncio.sleep(0.5)
        assert len(viewer.messages["/ground_truth/odom"]) == came, "time goes on"
        await viewer.set(paused=False)
        await viewer.last("/ground_truth/odom")

        # Limits, texts and names.
        assert await viewer.set(friction=-5) == {"friction": values["friction"]}
        await viewer.has_said("a parameter is not set: friction is from 0 to 2, not -5")
        await viewer.set(friction=values["friction"])
        for bad in ({"mode": "fly"}, {"friction": "much"}, {"paused": 3}, {"other": 1}, {"priority": [1, 2]}):
            viewer.status.clear()
            await viewer.set(**bad)
            await viewer.has_said("a parameter is not set")
        # The guidance takes over with other gains.
        await viewer.subscribe("/reference")
        await viewer.set(position_gain_per_s=3.0, heading_gain_per_s=2.0, priority="heading", mode="reference")
        before = place(await viewer.last("/ground_truth/odom"))
        await asyncio.sleep(2.0)
        after = place(await viewer.last("/ground_truth/odom"))
        await viewer.last("/reference")
        assert abs(after[0] - before[0]) + abs(after[1] - before[1]) > 0.05
        await viewer.set(mode="hand")


async def controls_time():
    async with Viewer() as viewer:
        # The timeline is the scenario's, and a new client receives its state.
        assert "playbackControl" in viewer.info["capabilities"], viewer.info
        ends = viewer.info["dataEndTime"]
        assert viewer.info["dataStartTime"] == {"sec": 0, "nsec": 0} and 1 < ends["sec"] < 1000, viewer.info
        await viewer.until(lambda: viewer.states, "the state")
        assert viewer.states[0][0] == "playing" and viewer.states[0][2] == 1.0, viewer.states
        await viewer.subscribe("/ground_truth/odom")
        await viewer.advertise(1, "/cmd_vel", "geometry_msgs/Twist", "json")
        await viewer.set(resets=2e6)
        for _ in range(8):
            await viewer.publish(1, b'{"linear": {"x": 0.4}}')
            await asyncio.sleep(0.1)
        away = place(await viewer.last("/ground_truth/odom"))

        # Paused, time stands; other viewers are notified without a request.
        async with Viewer() as other:
            state, stands_ns, speed, did_seek = await viewer.control_time("pause", pause=True)
            assert (state, speed, did_seek) == ("paused", 1.0, False), state
            await other.until(lambda: other.states and other.states[-1][0] == "paused", "the pause")
        await asyncio.sleep(0.3)
        assert abs(viewer.times[-1] - stands_ns) < 60e6, (viewer.times[-1], stands_ns)

        # At half speed a second takes two. The bounds allow for a slow machine, which only makes it
        # slower.
        assert (await viewer.control_time("slow", speed=0.5))[0::2] == ("playing", 0.5)
        await asyncio.sleep(0.2)
        first, began = viewer.times[-1], asyncio.get_running_loop().time()
        await asyncio.sleep(1.0)
        went_s, took_s = (viewer.times[-1] - first) * 1e-9, asyncio.get_running_loop().time() - began
        assert 0.05 < went_s < 0.5 * took_s + 0.1, (went_s, took_s)

        # Back to the start while paused: the robot and the time are there.
        await viewer.control_time("stand", pause=True)
        before = len(viewer.times)
        assert await viewer.control_time("back", pause=True, seek_ns=0) == ("paused", 0, 1.0, True)
        await viewer.until(lambda: len(viewer.times) > before + 3, "the time")
        assert viewer.times[-1] <= 1, viewer.times[-3:]
        viewer.messages.clear()
        await viewer.control_time("on")
        await viewer.until(lambda: viewer.messages.get("/ground_truth/odom"), "the first row")
        first_ns = viewer.messages["/ground_truth/odom"][0][0]
        # A stamp of zero would mean that there is none.
        assert first_ns == 1, first_ns
        at_start = place(viewer.decoded("/ground_truth/odom"))
        assert away[0] - at_start[0] > 0.15, (away, at_start)

        # Impossible requests are reported, and do not stop the simulation.
        await asyncio.sleep(1.0)
        state = await viewer.control_time("middle", seek_ns=600_000_000)
        assert state[1] == 0 and state[3], state
        await viewer.has_said("no moment but its start")
        state = await viewer.control_time("ahead", seek_ns=10**12)
        assert state[0] == "playing" and not state[3], state
        await viewer.has_said("cannot leap ahead")
        state = await viewer.control_time("fast", speed=1e9)
        assert 1.0 < state[2] < 1e3, state
        await viewer.has_said("speed 1000000000 is out of range")
        assert (await viewer.control_time("none", speed=float("nan")))[2] == state[2]
        await viewer.control_time("as before")
        # Half a request, and one with an unknown command.
        await viewer.socket.send(struct.pack("<BB", 3, 0))
        await viewer.socket.send(struct.pack("<BBfBQI", 3, 9, 1.0, 0, 0, 1) + b"x")
        await viewer.last("/ground_truth/odom")


async def does_no_harm():
    assert await refused() and await refused("foxglove.websocket.v1") and await refused("other")
    async with Viewer() as viewer:
        await viewer.subscribe("/odom")
        await viewer.last("/odom")
        before_mb = resident_mb()
        # Invalid frames, invalid JSON, wrong numbers: only that client gets an error or is
        # disconnected.
        for junk in ("", "{", "[]", '{"op": "fly"}', '{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99999}]}',
                     '{"op": "advertise", "channels": [{"id": -1}]}', '{"op": "setParameters"}', b"", b"\x01", b"\x01\xff\xff\xff\xff", b"\xff" * 100):
            async with Viewer() as other:
                await other.socket.send(junk)
                await asyncio.sleep(0.02)
        host, port = URL.removeprefix("ws://").split(":")
        for junk in (b"\x00" * 9000, b"GET / HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n"):
            _, writer = await asyncio.open_connection(host, int(port))
            writer.write(junk)
            await writer.drain()
            writer.close()
        # Fifty view everything; five of them read nothing, five send all they can.
        others = [await Viewer().__aenter__() for _ in range(50)]
        for other in others:
            await other.subscribe(*other.channels)
        for sleeper in others[:5]:
            sleeper.socket.transport.pause_reading()
        flood = others[5:10]
        for other in flood:
            await other.advertise(1, "/cmd_vel", "geometry_msgs/Twist", "json")
        began, sent = asyncio.get_running_loop().time(), 0
        first = (await viewer.last("/odom")).header.stamp
        while asyncio.get_running_loop().time() < began + 5.0:
            for other in flood:
                for _ in range(20):
                    await other.publish(1, b'{"linear": {"x": 0.01}}')
                    sent += 1
            await asyncio.sleep(0)
        last = (await viewer.last("/odom")).header.stamp
        went = last.sec - first.sec + 1e-9 * (last.nanosec - first.nanosec)
        assert went > 1.0, f"{went} s of simulation in five seconds"
        grown_mb = resident_mb() - before_mb
        # 50 backlogs of 512 messages of about a kilobyte, and markers of 20 kB at 30 Hz among them.
        assert grown_mb < 300, f"{grown_mb} MB more"
        for other in others:
            other.task.cancel()
            other.socket.transport.abort()
        await asyncio.sleep(0.5)
        await viewer.last("/odom")
        print(f"50 viewers, {sent} commands: {went:.1f} s simulated in five seconds, {grown_mb:.0f} MB more")


async def main():
    for part in (looks_on, drives, changes, controls_time, does_no_harm):
        await asyncio.wait_for(part(), 120)
        print(f"{part.__name__}: held", flush=True)


asyncio.run(main())
