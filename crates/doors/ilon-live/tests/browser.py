"""Drives ilon live by the keys and the gamepad of a real browser, over its DevTools protocol:
browser.py PORT CHROMIUM
"""

import asyncio
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import tempfile

import websockets

PORT, CHROMIUM = sys.argv[1], sys.argv[2]
# A gamepad controlled by the test: browsers without one return an empty list.
PAD = "window.pad = null; navigator.getGamepads = () => [window.pad];"


class Page:
    """One page of the browser."""

    def __init__(self, socket):
        self.socket, self.numbers = socket, itertools.count(1)

    async def ask(self, method, **parameters):
        number = next(self.numbers)
        await self.socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(await asyncio.wait_for(self.socket.recv(), 20))
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]

    async def value(self, expression):
        result = await self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    async def key(self, kind, key):
        await self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=f"Key{key.upper()}", text=key if kind == "keyDown" else "")

    async def twists(self):
        """The commanded and the real twist, as shown on the page: m/s, m/s, deg/s."""
        text = await self.value("[...document.querySelectorAll('#figures div')].map((tile) => tile.textContent).join('|')")
        number = r"(-?[\d.]+)"
        found = {}
        for name in ("Commanded", "Real"):
            match = re.search(rf"{name}{number}, {number} m/s, {number} deg/s", text)
            assert match, text
            found[name] = [float(part) for part in match.groups()]
        return found

    async def until(self, holds, what):
        for _ in range(100):
            twists = await self.twists()
            if holds(twists):
                return
            await asyncio.sleep(0.1)
        raise AssertionError(f"{what}: {twists}")


async def main():
    # Its helper processes may write into the profile for a moment after its end.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu-sandbox", f"--user-data-dir={profile}", "--remote-debugging-port=0", "about:blank"],
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            for line in browser.stderr:
                if match := re.search(r"ws://([\d.:]+)/", line):
                    break
            else:
                raise AssertionError("the browser does not listen")
            import urllib.request

            with urllib.request.urlopen(f"http://{match.group(1)}/json/list", timeout=20) as answer:
                target = next(page for page in json.load(answer) if page["type"] == "page")
            async with websockets.connect(target["webSocketDebuggerUrl"], max_size=None) as socket:
                await drive(Page(socket))
        finally:
            os.killpg(browser.pid, signal.SIGKILL)
            browser.wait()


async def drive(page):
    await page.ask("Page.enable")
    await page.ask("Page.addScriptToEvaluateOnNewDocument", source=PAD)
    await page.ask("Page.navigate", url=f"http://127.0.0.1:{PORT}/")
    for _ in range(200):
        if int(await page.value("(document.documentElement && document.documentElement.dataset.frames) || 0") or 0) > 5:
            break
        await asyncio.sleep(0.1)
    else:
        raise AssertionError("no frames come")
    await page.value("document.getElementById('mode').value = 'hand'; document.getElementById('mode').dispatchEvent(new Event('change'))")
    top = float(await page.value("document.getElementById('top').value"))
    stands = lambda twists: all(abs(part) < 0.02 for part in twists["Commanded"])

    # Each key moves in its direction, and two at once; once released, the robot stops.
    await page.until(stands, "it stands at first")
    for keys, sign in (("w", (1, 0, 0)), ("s", (-1, 0, 0)), ("a", (0, 1, 0)), ("d", (0, -1, 0)), ("q", (0, 0, 1)), ("e", (0, 0, -1)), ("wa", (1, 1, 0))):
        for key in keys:
            await page.key("keyDown", key)
        goes = lambda twists: all((abs(part) < 0.02) if s == 0 else (part * s > 0.9 * top) for part, s in zip(twists["Commanded"], sign))
        await page.until(goes, f"key {keys}")
        # The robot follows; on the way its rates are below the command.
        follows = lambda twists: all(s == 0 or part * s > 0.3 * top for part, s in zip(twists["Real"], sign))
        await page.until(follows, f"the robot at key {keys}")
        for key in keys:
            await page.key("keyUp", key)
        await page.until(stands, f"after key {keys}")
    # The space bar, and a page that loses the focus, stop it even with keys held.
    for stop in ("dispatchEvent(new Event('blur'))", "document.body.dispatchEvent(new KeyboardEvent('keydown', {key: ' ', bubbles: true}))"):
        await page.key("keyDown", "w")
        await page.until(lambda twists: twists["Commanded"][0] > 0.9 * top, "key w")
        await page.value(stop)
        await page.until(stands, stop)
        await page.key("keyUp", "w")

    # The joysticks in the picture, by a finger each, and both at once.
    await page.ask("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    middles = {}
    await page.value("document.querySelector('.stage').scrollIntoView()")
    for side in ("move", "turn"):
        at = f"(() => {{ const box = document.querySelector('.ilon-stick-{side}').getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2] }})()"
        middles[side] = await page.value(at)
    for moves, sign in (({"move": (0, -200)}, (1, 0, 0)), ({"move": (-200, 0)}, (0, 1, 0)), ({"turn": (200, 90)}, (0, 0, -1)), ({"move": (0, 200), "turn": (-200, 0)}, (-1, 0, 1))):
        fingers = lambda far: [
            {"x": middles[side][0] + far * x, "y": middles[side][1] + far * y, "id": index} for index, (side, (x, y)) in enumerate(moves.items())
        ]
        await page.ask("Input.dispatchTouchEvent", type="touchStart", touchPoints=fingers(0))
        await page.ask("Input.dispatchTouchEvent", type="touchMove", touchPoints=fingers(1))
        goes = lambda twists: all((abs(part) < 0.02) if s == 0 else (part * s > 0.9 * top) for part, s in zip(twists["Commanded"], sign))
        await page.until(goes, f"fingers at {moves}")
        await page.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        await page.until(stands, "fingers lifted")
    wheels = await page.value("document.querySelector('#wheels').innerText")
    assert wheels.count("mm/s") == 4, wheels

    # The sticks of a gamepad: left ahead and sideways, right turns, with a dead zone at the centre.
    for axes, sign in (([0, -1, 0], (1, 0, 0)), ([1, 0, 0], (0, -1, 0)), ([0, 0, -1], (0, 0, 1)), ([0.05, -0.05, 0.05], (0, 0, 0))):
        await page.value(f"window.pad = {{axes: {axes}, buttons: []}}")
        goes = lambda twists: all((abs(part) < 0.02) if s == 0 else (part * s > 0.9 * top) for part, s in zip(twists["Commanded"], sign))
        await page.until(goes, f"sticks at {axes}")
        await page.value("window.pad = null")
        await page.until(stands, "sticks let go")
    print("keys and sticks drive")


asyncio.run(main())
