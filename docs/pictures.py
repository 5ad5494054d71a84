#!/usr/bin/env python3
"""Makes the pictures of README and docs, and holds what README and docs quote against what the program says today.

    docs/pictures.py ILON            pictures anew, and the sentences quoted; needs Chromium and Pillow
    docs/pictures.py --check ILON    exit 1 where a page quotes something else than the program says; needs nothing

ILON is the program, such as target/release/ilon. Chromium is `chromium`, or what ILON_CHROMIUM names.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SAYING = [ROOT / "README.md", ROOT / "docs" / "causes.md"]
BLOCK = re.compile(r"(<!-- said of (\w+) -->\n```\n)(.*?)(\n```)", re.DOTALL)

# What a frame of the animation shows: the scene alone, over the whole window.
SCENE_ALONE = """<style>
.scene-stage { position: fixed !important; inset: 0; height: 100vh !important; z-index: 99; border-radius: 0; }
</style><script>ilonRunScene.view('%s'); ilonRunScene.select(%s);</script>"""


def run(ilon, scenario, folder):
    """Runs a scenario; gives its folder and the sentences that it begins with."""
    out = Path(folder) / scenario
    command = [ilon, "run", f"assets/scenarios/{scenario}.toml", "--out", out]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    paragraphs = done.stdout.strip().split("\n\n")
    return out, "\n".join(paragraphs[0].splitlines())


def screenshot(page, out, width, height):
    """What a browser shows of a page; the address may name a time."""
    browser = os.environ.get("ILON_CHROMIUM", "chromium")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options = ["--headless", "--no-sandbox", "--hide-scrollbars", "--no-first-run", "--disable-background-networking"]
        options += [f"--user-data-dir={profile}", f"--window-size={width},{height}", "--virtual-time-budget=9000"]
        # Now and then a browser without a screen does not come to an end.
        for _ in range(3):
            try:
                subprocess.run([browser, *options, f"--screenshot={out}", page], check=True, capture_output=True, timeout=40)
                return
            except subprocess.TimeoutExpired:
                print(f"the browser hung on {page}", file=sys.stderr)
    sys.exit("the browser does not come to an end")


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
    for k in range(12):
        frames.append(Path(folder) / f"frame{k:03}.png")
        screenshot(f"{page}#t={3.8 + 0.34 * k:.2f}", frames[-1], 520, 300)
    animation(frames, 0.34, docs / "run.png")


def animation(frames, period_s, out):
    """An animated PNG of screenshots, in the colours that serve all of them best, so that it stays small."""
    from PIL import Image

    shots = [Image.open(path).convert("RGB") for path in frames]
    width, height = shots[0].size
    sheet = Image.new("RGB", (width, height * len(shots)))
    for k, shot in enumerate(shots):
        sheet.paste(shot, (0, height * k))
    palette = sheet.quantize(256, kmeans=8)
    first, *others = [shot.quantize(palette=palette, dither=Image.Dither.NONE) for shot in shots]
    first.save(out, save_all=True, append_images=others, duration=round(1000 * period_s), optimize=True)


def sentences(ilon, page, folder):
    """A page with what the program says today."""
    return BLOCK.sub(lambda m: m[1] + run(ilon, m[2], folder)[1] + m[4], page.read_text())


def main():
    arguments = sys.argv[1:]
    check = "--check" in arguments
    arguments = [a for a in arguments if a != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    ilon = Path(arguments[0]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        for page in SAYING:
            now = sentences(ilon, page, folder)
            if check and now != page.read_text():
                sys.exit(f"{page.name} says something else than the program: run docs/pictures.py and look at what changed")
            page.write_text(now)
        if not check:
            pictures(ilon, folder)


if __name__ == "__main__":
    main()
