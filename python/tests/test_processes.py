"""Processes: Ctrl-C, pools, memory, and the command."""

import gc
import json
import multiprocessing
import pickle
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import ilon

INTERRUPTED = """
import sys, ilon
sys.stdout.write("ready\\n"); sys.stdout.flush()
scenario = {{"robot": {{"file": {robot!r}}}, "twist": {{"vx_m_s": 0.2}}, "run": {{"duration_s": 20000}}}}
try:
    {act}
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process there")
@pytest.mark.parametrize(
    "act",
    [
        "ilon.run(scenario)",
        "ilon.run(scenario, controller=lambda now, desired: [5.0] * 4)",
        "ilon.Simulation(scenario).advance([5.0] * 4, period_s=20000)",
    ],
)
def test_ctrl_c_ends_a_long_run(assets, act):
    robot = str(assets / "robots" / "mecanum4.urdf")
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED.format(robot=robot, act=act)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=10)
        assert out == "interrupted\n" and process.returncode == 0
    finally:
        process.kill()


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process there")
def test_ctrl_c_ends_the_command_as_any_other(assets, tmp_path):
    scenario = assets / "scenarios" / "mecanum4_lateral.toml"
    process = subprocess.Popen(
        [sys.executable, "-m", "ilon", "run", scenario, "--out", tmp_path, "--set", "run.duration_s=20000"],
        stderr=subprocess.PIPE,
    )
    try:
        # It has begun to write its results.
        deadline = time.monotonic() + 30
        while not (tmp_path / "scenario.toml").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=10)
        assert process.returncode == -signal.SIGINT
        assert not (tmp_path / "summary.json").exists()
    finally:
        process.kill()
        process.stderr.close()


def hash_of(arguments):
    scenario, settings = arguments
    return ilon.run(scenario, settings=settings)


@pytest.mark.parametrize("start", ["spawn", "fork", "forkserver"])
def test_pools_of_processes_run_scenarios(lateral, lateral_run, start):
    if start not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {start} here")
    work = [(lateral, {"run.duration_s": duration_s}) for duration_s in (0.5, 1.0)]
    with multiprocessing.get_context(start).Pool(2) as pool:
        runs = pool.map(hash_of, work)
    expected = [hash_of(one).summary["trace_hash"] for one in work]
    assert [run.summary["trace_hash"] for run in runs] == expected
    assert isinstance(runs[0], ilon.Run)


@pytest.mark.parametrize("make", [lambda s: s, lambda s: s.snapshot()])
def test_what_cannot_be_pickled_says_why(circle, make):
    with pytest.raises(TypeError, match="engine's own state"):
        pickle.dumps(make(ilon.Simulation(circle)))


def resident_kb():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read from /proc")
@pytest.mark.parametrize("what", ["steps", "environments", "snapshots", "columns"])
def test_memory_does_not_grow(circle, lateral_run, what):
    gymnasium = pytest.importorskip("gymnasium")
    simulation = ilon.Simulation(circle)
    environment = gymnasium.make("ilon/Track-v0", episode_s=0.4).unwrapped

    def steps():
        environment.reset(seed=0)
        for _ in range(200):
            action = 0.02 * environment.action_space.sample()
            if any(environment.step(action)[2:4]):
                environment.reset()

    def environments():
        made = gymnasium.make_vec("ilon/Track-v0", num_envs=2, threads=2)
        made.reset(seed=0)
        made.step(np.zeros((2, 3), dtype=np.float32))
        made.close()

    def snapshots():
        for _ in range(20):
            simulation.restore(simulation.snapshot())
            simulation.advance([1.0] * 4)

    def columns():
        pickle.loads(pickle.dumps(lateral_run)).trace["truth_x_m"]

    act = locals()[what]
    for _ in range(10):
        act()
    gc.collect()
    before = resident_kb()
    for _ in range(30):
        act()
    gc.collect()
    # A leak over thirty rounds would be larger: a robot alone takes about 100 kB, a trace 1 MB.
    # Allocators keep some pages.
    assert resident_kb() - before < 3000


def test_the_command_of_the_wheel_is_the_command(command, assets, tmp_path):
    robot = assets / "robots" / "mecanum4.urdf"
    said = json.loads(command("inspect", robot, "--json").stdout)
    assert said == ilon.inspect(robot)
    assert "Usage: ilon" in command("--help").stdout
    assert ilon.__version__ in command("--version").stdout
    assert "no command `fly`" in command("fly", code=2).stderr
    assert "nowhere.toml" in command("run", "nowhere.toml", "--out", tmp_path / "x", code=2).stderr
    check = command("check", assets / "scenarios" / "mecanum4_lateral.toml", "--set", "twist.vy_m_s=0", code=1)
    assert "failed" in check.stdout


def test_the_command_bears_a_reader_that_goes_away(assets):
    whole = subprocess.run([sys.executable, "-m", "ilon", "schema"], capture_output=True, check=True).stdout
    assert len(whole) > 1 << 16, "too short to fill a pipe"
    process = subprocess.Popen(
        [sys.executable, "-m", "ilon", "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    process.stdout.read(10)
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=10) == 0 and said == b""
