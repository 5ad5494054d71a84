"""Folders of robots and scenarios, and short runs shared by several tests."""

import gc
import subprocess
import sys
from pathlib import Path

import pytest

import ilon

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def assets() -> Path:
    return ROOT / "assets"


@pytest.fixture(scope="session")
def lateral(assets: Path) -> Path:
    return assets / "scenarios" / "mecanum4_lateral.toml"


@pytest.fixture(scope="session")
def lateral_run(lateral: Path) -> ilon.Run:
    return ilon.run(lateral)


@pytest.fixture
def circle(assets: Path) -> dict:
    """Two seconds of a circle of the four-wheeled robot, as a dict."""
    return {
        "robot": {"file": str(assets / "robots" / "mecanum4.urdf"), "x_m": 1.0, "heading_deg": 0},
        "reference": {"circle": {"radius_m": 1.0, "speed_m_s": 0.3, "heading": {"constant_deg": 0}}},
        "run": {"duration_s": 2.0},
    }


@pytest.fixture
def command():
    """Runs the `ilon` command of the wheel in a process of its own."""

    def run(*arguments: object, code: int | set[int] = 0) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [sys.executable, "-m", "ilon", *map(str, arguments)], capture_output=True, text=True, timeout=300
        )
        assert done.returncode in ({code} if isinstance(code, int) else code), done.stderr
        return done

    return run


@pytest.fixture(autouse=True)
def at_rest_between_tests():
    """Collects garbage between tests: thread pools end with their owners."""
    yield
    gc.collect()
