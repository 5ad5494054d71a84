"""Drives ilon live over its socket with `websockets`, which shares no code with ilon: client.py
PORT FRAME_FLOATS
"""

import asyncio
import json
import struct
import sys
import urllib.error
import urllib.request

import websockets

PORT, FLOATS = int(sys.argv[1]), int(sys.argv[2])
URL = f"ws://127.0.0.1:{PORT}/live"
OWN = f"http://127.0.0.1:{PORT}"


def frame(data):
    values = struct.unpack(f"<{len(data) // 4}f", data)
    assert len(values) == FLOATS, len(values)
    return values


async def frames(socket, seconds):
    """The frames and texts received within a time."""
    found, texts = [], []
    end = asyncio.get_running_loop().time() + seconds
    while (left := end - asyncio.get_running_loop().time()) > 0:
        try:
            data = await asyncio.wait_for(socket.recv(), left)
        except asyncio.TimeoutError:
            break
        if isinstance(data, bytes):
            found.append(frame(data))
        else:
            texts.append(json.loads(data))
    return found, texts


async def say(socket, **message):
    await socket.send(json.dumps(message))


def get(path="/", **headers):
    request = urllib.request.Request(OWN + path, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


async def refused(**arguments):
    try:
        async with websockets.connect(URL, **arguments):
            return None
    except websockets.exceptions.InvalidStatus as error:
        return error.response.status_code


async def main():
    loop = asyncio.get_running_loop()
    # Which clients are admitted.
    status, page = await loop.run_in_executor(None, get)
    assert status == 200 and "ilonScene" in page and "http://" not in page.split("</style>")[1].split("<script")[0]
    assert (await loop.run_in_executor(None, lambda: get(Host=f"evil.example:{PORT}")))[0] == 403
    assert (await loop.run_in_executor(None, lambda: get(Origin="http://evil.example")))[0] == 403
    assert (await loop.run_in_executor(None, lambda: get("/other")))[0] == 404
    assert await refused(origin="http://evil.example") == 403
    assert await refused(origin="null") == 403
    assert await refused(origin=OWN) is None

    async with websockets.connect(URL, origin=OWN) as socket:
        # It stands, then follows its commands, and stops without further ones.
        await say(socket, mode="hand", reset=True)
        for _ in range(10):
            await say(socket, twist=[0.3, 0.0, 0.0])
            await asyncio.sleep(0.1)
        driven, texts = await frames(socket, 0.3)
        # A second at 0.3 m/s and some tenths, less the start.
        assert len(driven) > 10 and 0.15 < driven[-1][1] < 0.5, f"{len(driven)} frames, x = {driven[-1][1]}"
        times = [values[0] for values in driven]
        assert all(b > a for a, b in zip(times, times[1:])), "time does not grow"
        figures = [text["figures"] for text in texts if "figures" in text]
        assert figures and max(f["real"][0] for f in figures) > 0.2
        await asyncio.sleep(1.0)
        await frames(socket, 0.1)
        stood, _ = await frames(socket, 0.5)
        assert abs(stood[-1][1] - stood[0][1]) < 2e-3, "it goes on without a command"

        # Values out of range and invalid messages are reported, and change nothing.
        for text in ("", "{", "[1, 2]", '{"twist": [NaN, 0, 0]}', '{"twist": [1e999, 0, 0]}', '{"other": 1}', "\x00" * 1000):
            await socket.send(text)
        await asyncio.sleep(0.3)
        await say(socket, twist=[1e9, 0, 0], friction=-1)
        await asyncio.sleep(0.3)
        await say(socket, twist=[0, 0, 0], friction=0.6)
        _, texts = await frames(socket, 1.0)
        notes = " ".join(text["note"] for text in texts if "note" in text)
        assert "not understood" in notes and "out of range" in notes, notes

        # Back to the start, and paused.
        await say(socket, reset=True)
        await asyncio.sleep(0.5)
        await frames(socket, 0.1)
        again, _ = await frames(socket, 0.3)
        assert abs(again[-1][1]) < 0.05, again[-1][1]
        await say(socket, paused=True)
        await asyncio.sleep(0.3)
        await frames(socket, 0.1)
        standing, _ = await frames(socket, 0.5)
        assert len({values[0] for values in standing}) == 1, "time goes on"
        await say(socket, paused=False)

        # Invalid frames, messages that are too long, bytes in place of text: only that client is
        # disconnected.
        for junk in (b"\xff" * 64, b"\x81\xfe\xff\xff" + b"x" * 100, b"\x88\x80"):
            reader, writer = await asyncio.open_connection("127.0.0.1", PORT)
            writer.write(
                f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{PORT}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
            )
            await reader.readuntil(b"\r\n\r\n")
            writer.write(junk)
            await writer.drain()
            writer.close()
        async with websockets.connect(URL) as other:
            await other.send("x" * 100_000)
            try:
                while True:
                    await asyncio.wait_for(other.recv(), 5)
            except websockets.exceptions.ConnectionClosed:
                pass
        for junk in (b"\r\n\r\n", b"GET\r\n\r\n", b"\x00" * 9000, b"GET / HTTP/1.1\r\n"):
            reader, writer = await asyncio.open_connection("127.0.0.1", PORT)
            writer.write(junk)
            await writer.drain()
            writer.close()

        # Fifty viewers, of which five read nothing and five send all they can.
        others = [await websockets.connect(URL, max_queue=1) for _ in range(50)]
        for sleeper in others[:5]:
            sleeper.transport.pause_reading()
        sent = 0
        for _ in range(200):
            for flood in others[5:10]:
                for _ in range(20):
                    await flood.send('{"twist": [0.1, 0, 0]}')
                    sent += 1
            await asyncio.sleep(0)
        seen, _ = await frames(socket, 2.0)
        # At least one second of frames: the machine has other load.
        assert len(seen) > 30, f"{len(seen)} frames while {sent} commands came"
        went = seen[-1][0] - seen[0][0]
        assert went > 1.0, f"{went} s of simulation in two seconds"
        for other in others:
            other.transport.abort()
        await asyncio.sleep(0.5)
        await frames(socket, 0.1)
        seen, _ = await frames(socket, 0.5)
        assert len(seen) > 10
        print(f"{sent} commands, 50 clients: {went:.2f} s simulated in two seconds meanwhile")


asyncio.run(main())
