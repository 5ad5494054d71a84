#!/usr/bin/env python3
"""Makes the pictures of README and docs, and holds README's sentences against what the program says today.

    docs/pictures.py ILON            pictures anew, and the sentences in README; needs Chromium and ImageMagick
    docs/pictures.py --check ILON    exit 1 where README says something else than the program; needs nothing

ILON is the program, such as target/release/ilon. Chromium is `chromium`, or what ILON_CHROMIUM names.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
BLOCK = re.compile(r"(<!-- said of (\w+) -->\n```\n)(.*?)(\n```)", re.DOTALL)

# What a frame of the animation shows: the scene alone, over the whole window.
SCENE_ALONE = """<style>
.scene-stage { position: fixed !important; inset: 0; height: 100vh !important; z-index: 99; border-radius: 0; }
</style><script>ilonRunScene.view('%s'); ilonRunScene.select(%s);</script>"""


def run(ilon, scenario, folder):
    """Runs a scenario; gives its folder and the sentences that it ends with."""
    out = Path(folder) / scenario
    command = [ilon, "run", f"assets/scenarios/{scenario}.toml", "--out", out]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    paragraphs = done.stdout.strip().split("\n\n")
    return out, "\n".join(paragraphs[-2].splitlines())


def screenshot(page, out, width, height):
    """What a browser shows of a page; the address may name a time."""
    browser = os.environ.get("ILON_CHROMIUM", "chromium")
    with tempfile.TemporaryDirectory() as profile:
        options = ["--headless", "--no-sandbox", "--hide-scrollbars", "--no-first-run", "--disable-background-networking"]
        options += [f"--user-data-dir={profile}", f"--window-size={width},{height}", "--virtual-time-budget=9000"]
        subprocess.run([browser, *options, f"--screenshot={out}", page], check=True, capture_output=True)


def scene_page(report, view, wheel, folder):
    """A copy of a report that shows its scene alone."""
    text = report.read_text().replace("</body>", SCENE_ALONE % (view, wheel) + "</body>")
    page = Path(folder) / f"{view}_{wheel}.html"
    page.write_text(text)
    return f"file://{page}"


def pictures(ilon, folder):
    wet, _ = run(ilon, "mecanum4_wet_floor", folder)
    lateral, _ = run(ilon, "mecanum4_lateral", folder)
    docs = ROOT / "docs"
    screenshot(f"file://{wet}/report.html#t=5.5", docs / "report.png", 1280, 860)
    screenshot(scene_page(lateral / "report.html", "follow", 0, folder) + "#t=3.02", docs / "wheel.png", 900, 480)
    page = scene_page(wet / "report.html", "follow", "null", folder)
    frames = []
    for k in range(30):
        frames.append(Path(folder) / f"frame{k:03}.png")
        screenshot(f"{page}#t={3.6 + 0.14 * k:.2f}", frames[-1], 560, 330)
    gif = ["convert", "-delay", "14", "-loop", "0", *frames, "-layers", "Optimize", "-colors", "96", docs / "run.gif"]
    subprocess.run(gif, check=True)
    for picture in ["report.png", "wheel.png"]:
        subprocess.run(["convert", docs / picture, "-colors", "128", docs / picture], check=True)


def sentences(ilon, folder):
    """README with what the program says today."""
    return BLOCK.sub(lambda m: m[1] + run(ilon, m[2], folder)[1] + m[4], README.read_text())


def main():
    arguments = sys.argv[1:]
    check = "--check" in arguments
    arguments = [a for a in arguments if a != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    ilon = Path(arguments[0]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        now = sentences(ilon, folder)
        if check:
            if now != README.read_text():
                sys.exit("README.md says something else than the program: run docs/pictures.py and look at what changed")
            return
        README.write_text(now)
        pictures(ilon, folder)


if __name__ == "__main__":
    main()
