"""Studies on Ray: the rows are those of this machine, even if workers and nodes are lost."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import pytest

import ilon

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
ray = pytest.importorskip("ray")

from ray.cluster_utils import Cluster  # noqa: E402

from ilon import _ilon, _ray  # noqa: E402

pytestmark = [
    # Ray's own warnings: sockets and processes that it leaves to the garbage collector, and
    # deprecations.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.timeout(300),
]
RESULTS = ["runs.parquet", "findings.json", "report.html"]


@pytest.fixture(scope="module")
def here():
    """Ray on this machine, with two workers."""
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, assets):
    """A folder with a scenario of one second, and studies of it."""
    folder = tmp_path_factory.mktemp("studies")
    (folder / "short.toml").write_text(
        f"robot.file = '{assets / 'robots' / 'mecanum4.urdf'}'\ntwist = {{ vy_m_s = 0.3, rest_s = 0.1, ramp_s = 0.1, settle_s = 0.1 }}\nrun.duration_s = 1.0\n"
    )
    studies = {
        "grid": "[axes]\nworld.floor.friction = { from = 0.03, to = 0.8, steps = 12 }\n",
        "random": 'method = "random"\npoints = 150\nkeep = "worst 2"\nrepetitions = 2\n'
        "[axes]\nworld.floor.friction = { from = 0.05, to = 0.8 }\n",
        "find": 'repetitions = 2\n[axes]\ntwist.vy_m_s = [0.1, 0.3]\n[find]\nkey = "world.floor.friction"\nfrom = 0.02\n'
        'to = 0.4\nquantity = "friction_used_max"\ncrosses = 0.99\ntolerance = 0.02\nscan = 4\n',
        "minimise": "[axes]\nworld.floor.friction = { from = 0.05, to = 0.8 }\n"
        '[minimise]\nquantity = "slip_energy_j"\nstarts = 3\nevaluations = 8\n',
        "failing": '[axes]\nrobot.file = ["gone.urdf", "gone_too.urdf"]\n',
    }
    for name, text in studies.items():
        (folder / f"{name}.toml").write_text(f'scenario = "short.toml"\n{text}')
    return folder


def assert_equal(ours, theirs):
    for name in RESULTS:
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    kept = [sorted(path.relative_to(one) for path in one.glob("kept/*/*")) for one in (ours, theirs)]
    assert kept[0] == kept[1]


@pytest.mark.parametrize("name", ["grid", "random", "find", "minimise", "failing"])
def test_rows_and_findings_are_those_of_this_machine_to_the_byte(here, folder, tmp_path, name):
    there = ilon.sweep(folder / f"{name}.toml", on="ray", out=tmp_path / "ray")
    ilon.sweep(folder / f"{name}.toml", out=tmp_path / "local")
    assert_equal(tmp_path / "ray", tmp_path / "local")
    assert there.folder == tmp_path / "ray"


def test_tasks_on_two_cpus_give_the_same(here, folder, tmp_path):
    ilon.sweep(folder / "random.toml", on="ray", out=tmp_path / "ray", jobs=2)
    ilon.sweep(folder / "random.toml", out=tmp_path / "local", jobs=1)
    assert_equal(tmp_path / "ray", tmp_path / "local")


def test_without_out_nothing_is_written(here, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    there = ilon.sweep(folder / "grid.toml", on="ray")
    assert there["trace_hash"] == ilon.sweep(folder / "grid.toml")["trace_hash"]
    assert there.folder is None and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["random", "find"])
def test_it_goes_on_where_this_machine_stopped_and_the_other_way(here, folder, tmp_path, name):
    path, out = folder / f"{name}.toml", tmp_path / "both"

    def rows():
        return set((out / "rows.log").read_bytes().splitlines())

    def tire(done, most):
        if done > least:
            raise LookupError("enough")

    least, before = 5, set()
    for on in (None, "ray"):
        with pytest.raises(LookupError):
            ilon.sweep(path, on=on, out=out, progress=tire)
        assert before < rows()
        least, before = len(rows()) + 1, rows()
    ilon.sweep(path, out=out)
    assert before <= rows()
    ilon.sweep(path, out=tmp_path / "local")
    assert_equal(out, tmp_path / "local")


def test_traces_that_are_all_kept_are_there(here, folder, tmp_path):
    study = {"scenario": str(folder / "short.toml"), "keep": "all", "axes": {"world.floor.friction": [0.1, 0.5]}}
    for on, out in (("ray", tmp_path / "ray"), (None, tmp_path / "local")):
        ilon.sweep(study, on=on, out=out)
    assert_equal(tmp_path / "ray", tmp_path / "local")
    assert len(list((tmp_path / "ray").glob("kept/*/trace.parquet"))) == 2


def test_bad_studies_raise_what_the_command_says_before_anything_runs(here, folder, command, tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(f"scenario = '{folder / 'short.toml'}'\n[axes]\nworld.floor.fricton = [0.1]\n")
    said = command("sweep", path, "--out", tmp_path / "out", code=2).stderr
    with pytest.raises(ilon.ScenarioError) as raised:
        ilon.sweep(path, on="ray", out=tmp_path / "out")
    assert raised.value.message in said and raised.value.help in said
    assert not (tmp_path / "out").exists()


def test_what_no_node_can_run_is_waited_for_and_then_given_up(here, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(_ray, "_PATIENCE_S", 3.0)
    begun_s = time.monotonic()
    with (
        pytest.warns(UserWarning, match="no node of the Ray cluster has 3 CPUs .* but 2 at most; its tasks wait"),
        pytest.raises(ilon.Error, match="none came in 3 s"),
    ):
        ilon.sweep(folder / "grid.toml", on="ray", jobs=3, out=tmp_path)
    assert 3.0 < time.monotonic() - begun_s < 60.0


def test_a_worker_of_another_version_is_refused(here, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(_ilon, "__version__", "0.0.9")
    with pytest.raises(ilon.Error, match=r"a worker of Ray has ilon .*, and this is ilon 0\.0\.9") as raised:
        ilon.sweep(folder / "grid.toml", on="ray", out=tmp_path)
    assert "same version" in raised.value.help
    assert not (tmp_path / "runs.parquet").exists()


def test_a_worker_that_reads_other_files_is_refused(folder, tmp_path):
    study = _ilon.Study(folder / "grid.toml")
    order = _ray._Order(_ilon.__version__, study.fingerprint, study.text, (str(study.path),), 1, None, (None,))
    rows, took_s = _ray._work(order, [0, 3])
    assert rows.startswith(b'[{"run":0,') and took_s > 0
    (tmp_path / "short.toml").write_text((folder / "short.toml").read_text().replace("0.3", "0.2"))
    _ray._read.clear()
    with pytest.raises(ilon.Error, match="the scenarios or robots are others than there"):
        _ray._work(replace(order, paths=(str(tmp_path / "grid.toml"),)), [0])
    with pytest.raises(ilon.Error, match="does not read the study .* as this process does: cannot read") as raised:
        _ray._work(replace(order, paths=(str(tmp_path / "nowhere" / "grid.toml"),)), [0])
    assert "working_dir" in raised.value.help


def test_tasks_last_seconds_and_get_shorter_towards_the_end():
    # At 28 ms each, 71 runs last two seconds.
    assert _ray._batch(1000, 4, 1, None) == 1
    assert _ray._batch(1000, 4, 1, 0.028) == 71
    assert _ray._batch(100, 4, 1, 0.028) == 13
    assert _ray._batch(1, 4, 1, 0.028) == 1
    # Longer runs are tasks of their own, or as many as the task has CPUs.
    assert _ray._batch(1000, 4, 1, 60.0) == 1
    assert _ray._batch(1000, 4, 8, 60.0) == 8
    assert _ray._batch(3, 4, 8, 60.0) == 3


INTERRUPTED = """
import ray, ilon
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
try:
    ilon.sweep({study!r}, on="ray", out={out!r}, progress=lambda done, most: print("made", flush=True))
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process there")
def test_ctrl_c_ends_it_and_what_was_made_stays(here, folder, tmp_path):
    text = INTERRUPTED.format(study=str(folder / "random.toml"), out=str(tmp_path / "out"))
    process = subprocess.Popen(
        [sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        assert process.stdout.readline() == "made\n"
        process.send_signal(signal.SIGINT)
        begun = time.monotonic()
        assert "interrupted" in process.communicate(timeout=60)[0].splitlines()
        assert time.monotonic() - begun < 30 and process.returncode == 0
    finally:
        process.kill()
    rows = (tmp_path / "out" / "rows.log").read_bytes().count(b"\n")
    assert 1 <= rows < 300 and not (tmp_path / "out" / "runs.parquet").exists()
    ilon.sweep(folder / "random.toml", on="ray", out=tmp_path / "out")
    ilon.sweep(folder / "random.toml", out=tmp_path / "local")
    assert_equal(tmp_path / "out", tmp_path / "local")


@pytest.fixture
def cluster():
    """Three nodes on this machine, of one CPU each, whatever Ray the tests had before."""
    ray.shutdown()
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    nodes = [cluster.add_node(num_cpus=1) for _ in range(2)]
    ray.init(address=cluster.address, log_to_driver=False)
    yield cluster, nodes
    ray.shutdown()
    cluster.shutdown()


def test_a_node_that_is_lost_in_the_middle_costs_no_row(cluster, folder, tmp_path):
    cluster, (_, lost) = cluster

    def lose(done, most):
        if done >= 30 and lost in cluster.worker_nodes:
            cluster.remove_node(lost, allow_graceful=False)

    there = ilon.sweep(folder / "random.toml", on="ray", out=tmp_path / "ray", progress=lose)
    assert lost not in cluster.worker_nodes
    ilon.sweep(folder / "random.toml", out=tmp_path / "local")
    assert_equal(tmp_path / "ray", tmp_path / "local")
    assert list(there["run"]) == list(range(300))
    # Each once.
    assert (tmp_path / "ray" / "rows.log").read_bytes().count(b"\n") == 300


GROWING = """
import os, sys, threading, time, warnings
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
import ray, ilon
from ray.cluster_utils import Cluster

cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
ray.init(cluster.address, log_to_driver=False)

found = []

def study():
    found.append(ilon.sweep(sys.argv[1], on="ray", out=sys.argv[2]))

# Ray starts nodes in the main thread alone.
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    waiting = threading.Thread(target=study)
    waiting.start()
    time.sleep(5)
    cluster.add_node(num_cpus=2)
    waiting.join()
print([str(one.message) for one in said if "no node of the Ray cluster has 1 CPUs" in str(one.message)])
print(found[0]["status"])
ray.shutdown()
cluster.shutdown()
"""


def test_a_cluster_whose_nodes_come_later_is_waited_for(folder, tmp_path):
    """As for a RayJob whose head has no CPUs and whose workers start later. In its own process, as
    it is another cluster.
    """
    done = subprocess.run(
        [sys.executable, "-c", GROWING, folder / "grid.toml", tmp_path / "ray"], capture_output=True, text=True, timeout=240
    )
    assert done.returncode == 0, done.stderr
    warned, status = done.stdout.splitlines()[-2:]
    assert "but 0 at most; its tasks wait until one has, for at most 600 s" in warned
    assert status == str(["done"] * 12)
    ilon.sweep(folder / "grid.toml", out=tmp_path / "local")
    assert_equal(tmp_path / "ray", tmp_path / "local")
