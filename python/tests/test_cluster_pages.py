"""The commands of docs/clusters.md and its files, run here with processes in place of a cluster's jobs and pods.
"""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import ilon

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "clusters.md"
FILES = ROOT / "examples" / "cluster"
RESULTS = ["runs.parquet", "findings.json", "report.html"]

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="these pages are for other systems"),
    pytest.mark.timeout(300),
]


def section(heading):
    """The page's text below a heading, up to the next one of any level."""
    (text,) = re.findall(rf"^#+ {heading}\n(.*?)(?=^##|\Z)", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    return text


def blocks(heading, language):
    """The blocks of code below a heading of the page."""
    return re.findall(rf"^```{language}\n(.*?)^```$", section(heading), re.MULTILINE | re.DOTALL)


@pytest.fixture
def study(assets, tmp_path):
    """A study of 64 runs in its own folder, and its result on one machine."""
    folder = tmp_path / "study"
    folder.mkdir()
    (folder / "short.toml").write_text(
        f"robot.file = '{assets / 'robots' / 'mecanum4.urdf'}'\ntwist = {{ vy_m_s = 0.3, rest_s = 0.1, ramp_s = 0.1, settle_s = 0.1 }}\nrun.duration_s = 2.0\n"
    )
    path = folder / "study.toml"
    path.write_text(
        'scenario = "short.toml"\nmethod = "sobol"\npoints = 64\n[axes]\nworld.floor.friction = { from = 0.1, to = 0.8 }\n'
    )
    ilon.sweep(path, out=tmp_path / "whole")
    return path


def environment(**more):
    """An environment with the `ilon` command of this Python first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, **{name: str(value) for name, value in more.items()}}


def assert_whole(results, whole, names=RESULTS):
    for name in names:
        assert (results / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_slurm_array_whose_task_is_killed_and_submitted_again_is_merged_to_the_same_bytes(study, tmp_path):
    (submission,) = blocks("Slurm", "sh")
    script = (FILES / "sweep.sbatch").read_text()
    count = 4

    def task(index):
        variables = {"SLURM_ARRAY_TASK_ID": index, "SLURM_ARRAY_TASK_COUNT": count, "SLURM_CPUS_PER_TASK": 1}
        return subprocess.Popen(
            ["bash", "-c", script],
            cwd=study.parent,
            env=environment(SCRATCH=tmp_path, **variables),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    tasks = [task(index) for index in range(1, count + 1)]
    log = tmp_path / "study-results" / f"shard-2-of-{count}" / "rows.log"
    deadline = time.monotonic() + 60
    while not (log.exists() and log.read_bytes()) and time.monotonic() < deadline:
        time.sleep(0.01)
    # Slurm kills all processes of a task.
    os.killpg(tasks[1].pid, signal.SIGKILL)
    for index, process in enumerate(tasks):
        _, said = process.communicate(timeout=120)
        assert (process.returncode == 0) == (index != 1), said
    (merge,) = re.findall(r"--wrap '(.*)'", submission)
    merged = lambda: subprocess.run(
        ["bash", "-c", merge], env=environment(SCRATCH=tmp_path), capture_output=True, text=True
    )  # noqa: E731
    early = merged()
    assert early.returncode == 2 and "runs are missing" in early.stderr
    rows = log.read_bytes().count(b"\n")
    assert 1 <= rows < 16
    again = task(2)
    _, said = again.communicate(timeout=120)
    assert again.returncode == 0, said
    assert log.read_bytes().count(b"\n") == 16
    done = merged()
    assert done.returncode == 0, done.stderr
    # Its page names the study as the script does, from the folder that it was submitted in.
    assert_whole(tmp_path / "study-results", tmp_path / "whole", RESULTS[:2])


def test_the_pods_of_the_kubernetes_job_make_all_of_a_study(study, tmp_path):
    yaml = pytest.importorskip("yaml")
    job = yaml.safe_load((FILES / "job.yaml").read_text())
    assert (job["apiVersion"], job["kind"]) == ("batch/v1", "Job")
    spec = job["spec"]
    assert spec["completionMode"] == "Indexed"
    pod = spec["template"]["spec"]
    assert pod["restartPolicy"] == "Never"
    (container,) = pod["containers"]
    volumes = {volume["name"] for volume in pod["volumes"]}
    mounts = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
    assert set(mounts) == volumes
    (line,) = container["args"]
    assert f'/{spec["completions"]}"' in line, "each completion is a shard"
    assert f"--jobs {container['resources']['limits']['cpu']}" in line
    # Mounted volumes become folders of this machine, and there are fewer pods.
    few = 3
    (merge,) = re.findall(r"`(ilon sweep --merge [^`]*)`", section("Kubernetes"))
    places = {mounts["study"]: str(study.parent), mounts["results"]: str(tmp_path / "results")}

    def here(command):
        command = command.replace(f'/{spec["completions"]}"', f'/{few}"')
        for place, folder in places.items():
            command = re.sub(rf"(?<![\w/]){re.escape(place)}(?=/)", folder, command)
        return command

    for index in range(few):
        done = subprocess.run(
            [*container["command"], here(line)],
            env=environment(JOB_COMPLETION_INDEX=index),
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
    done = subprocess.run(["sh", "-c", here(merge)], env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert_whole(tmp_path / "results" / "study", tmp_path / "whole")


def test_the_ray_job_of_the_kubernetes_page_is_yaml(study):
    yaml = pytest.importorskip("yaml")
    job = yaml.safe_load((FILES / "rayjob.yaml").read_text())
    assert (job["apiVersion"], job["kind"]) == ("ray.io/v1", "RayJob")
    cluster = job["spec"]["rayClusterSpec"]
    groups = [cluster["headGroupSpec"], *cluster["workerGroupSpecs"]]
    images = {container["image"] for group in groups for container in group["template"]["spec"]["containers"]}
    assert len(images) == 1, "all nodes have the same ilon"
    # The entry point is valid Python.
    compile(*re.findall(r'python -c "(.*)"', job["spec"]["entrypoint"]), "entrypoint", "exec")
