"""Studies: the results of `ilon.sweep` are the command's."""

import json
import pickle
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import ilon

FRICTIONS = [0.01, 0.1, 0.2, 0.8]
RESULTS = ["runs.parquet", "findings.json", "report.html"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, assets):
    """A folder with a scenario of half a second."""
    folder = tmp_path_factory.mktemp("studies")
    (folder / "short.toml").write_text(
        f"robot.file = '{assets / 'robots' / 'mecanum4.urdf'}'\ntwist = {{ vy_m_s = 0.3, rest_s = 0.1, ramp_s = 0.1, settle_s = 0.1 }}\nrun.duration_s = 0.5\n"
    )
    (folder / "study.toml").write_text(f'scenario = "short.toml"\n[axes]\nworld.floor.friction = {FRICTIONS}\n')
    return folder


@pytest.fixture
def study(folder):
    """The same study as a dict."""
    return {"scenario": str(folder / "short.toml"), "axes": {"world.floor.friction": FRICTIONS}}


def bytes_of(folder):
    return [(folder / name).read_bytes() for name in RESULTS]


def test_a_study_is_the_same_to_the_byte_as_that_of_the_command(folder, command, tmp_path):
    command("sweep", folder / "study.toml", "--out", tmp_path / "theirs")
    sweep = ilon.sweep(folder / "study.toml", out=tmp_path / "ours", jobs=2)
    assert bytes_of(tmp_path / "ours") == bytes_of(tmp_path / "theirs")
    assert sweep.findings == json.loads((tmp_path / "theirs" / "findings.json").read_text())
    assert sweep.folder == tmp_path / "ours"


def test_a_dict_and_its_file_are_the_same_study(folder, study):
    by_path = ilon.sweep(folder / "study.toml")
    by_dict = ilon.sweep({**study, "scenario": "short.toml"}, folder=folder)
    assert [by_dict["key"], by_dict["trace_hash"]] == [by_path["key"], by_path["trace_hash"]]


def test_rows_are_columns_of_numpy_and_of_arrow(study, tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    sweep = ilon.sweep(study, out=tmp_path)
    assert len(sweep) == 4 and sweep.failed == 0
    np.testing.assert_array_equal(sweep["world.floor.friction"], FRICTIONS)
    assert sweep["status"] == ["done"] * 4 and sweep["error"] == [None] * 4
    # Figures that do not apply to a run without a reference are absent.
    assert np.isnan(sweep["position_error_max_m"]).all()
    ours, written = pyarrow.table(sweep.to_arrow()), parquet.read_table(tmp_path / "runs.parquet")
    assert ours.equals(written.cast(ours.schema))
    with pytest.raises(KeyError, match="did you mean `slip_energy_j`"):
        sweep["slip_energi_j"]


def test_each_run_is_what_ilon_run_gives(folder, study):
    sweep = ilon.sweep(study)
    run = ilon.run(folder / "short.toml", settings={"world.floor.friction": FRICTIONS[1]})
    assert sweep["trace_hash"][1] == run.summary["trace_hash"]
    assert run.figures["slip_energy_j"] == sweep["slip_energy_j"][1]


def test_a_search_answers_as_the_command_does(folder, command, tmp_path):
    path = folder / "search.toml"
    path.write_text(
        'scenario = "short.toml"\n[find]\nkey = "world.floor.friction"\nfrom = 0.02\nto = 1.0\n'
        'quantity = "friction_used_max"\ncrosses = 0.99\ntolerance = 0.05\nscan = 4\n'
    )
    command("sweep", path, "--out", tmp_path)
    sweep = ilon.sweep(path)
    assert sweep.findings == json.loads((tmp_path / "findings.json").read_text())
    assert "most grip used by a wheel exceeds 99 %" in str(sweep)


def test_nothing_is_written_without_out(study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sweep = ilon.sweep({**study, "keep": "all"})
    assert sweep.folder is None and not list(tmp_path.iterdir())
    assert "world.floor.friction" in sweep.report()


def test_what_was_run_is_not_run_again(study, tmp_path):
    seen = []
    first = ilon.sweep(study, out=tmp_path, progress=lambda done, most: seen.append((done, most)))
    assert seen[-1] == (4, 4)
    log = (tmp_path / "rows.log").read_bytes()
    again = ilon.sweep(study, out=tmp_path, progress=lambda done, most: seen.append((done, most)))
    assert (tmp_path / "rows.log").read_bytes() == log
    assert again["trace_hash"] == first["trace_hash"] and seen[-1] == (4, 4)


def test_a_row_that_was_damaged_is_run_anew_and_said(study, tmp_path):
    ilon.sweep(study, out=tmp_path)
    before = bytes_of(tmp_path)
    log = (tmp_path / "rows.log").read_text()
    (tmp_path / "rows.log").write_text(log.replace('"run":2', '"run":3', 1))
    with pytest.warns(UserWarning, match="1 rows could not be read again"):
        ilon.sweep(study, out=tmp_path)
    assert bytes_of(tmp_path) == before


def test_shards_are_merged_to_the_same_bytes(study, tmp_path):
    ilon.sweep(study, out=tmp_path / "whole")
    for shard in ("1/3", "2/3"):
        part = ilon.sweep(study, out=tmp_path / "parts", shard=shard)
    assert part.findings is None and not part.held and list(part["run"]) == [1]
    with pytest.raises(ValueError, match="merge all shards"):
        part.report()
    with pytest.raises(ilon.ScenarioError, match="1 of 4 runs are missing, the first of them run 2"):
        ilon.merge_sweeps(tmp_path / "parts")
    ilon.sweep(study, out=tmp_path / "parts", shard="3/3")
    merged = ilon.merge_sweeps(tmp_path / "parts")
    assert len(merged) == 4 and bytes_of(tmp_path / "parts") == bytes_of(tmp_path / "whole")
    ilon.merge_sweeps(tmp_path / "parts", out=tmp_path / "elsewhere")
    assert bytes_of(tmp_path / "elsewhere") == bytes_of(tmp_path / "whole")


def test_traces_are_kept_where_the_study_says(study, tmp_path):
    sweep = ilon.sweep({**study, "keep": "worst 1", "quantities": ["slip_energy_j"]}, out=tmp_path)
    (kept,) = (tmp_path / "kept").iterdir()
    assert kept.name == f"run_{np.argmax(sweep['slip_energy_j']):06}"
    assert {path.name for path in kept.iterdir()} >= {"summary.json", "trace.parquet", "scenario.toml"}


def test_expectations_are_held_against_the_rows(study):
    # It slides only on the most slippery of the four floors.
    least, most = np.sort(ilon.sweep(study)["slip_energy_j"])[-2:]
    for share, held in ((0.75, True), (1.0, False)):
        bound = {"max": float(0.5 * (least + most)), "share": share}
        assert ilon.sweep({**study, "expect": {"slip_energy_j": bound}}).held == held


def test_an_impossible_robot_is_a_failed_row(assets):
    study = {
        "scenario": str(assets / "scenarios" / "mecanum4_lateral.toml"),
        "set": {"run.duration_s": 0.2},
        "axes": {"robot.file": ["../robots/mecanum4.urdf", "../robots/gone.urdf"]},
    }
    sweep = ilon.sweep(study)
    assert sweep["status"] == ["done", "failed"] and sweep.failed == 1
    assert "gone.urdf" in sweep["error"][1] and np.isnan(sweep["slip_energy_j"][1])


BAD = {
    "an unknown key": "[axes]\nworld.floor.fricton = [0.1]\n",
    "an empty axis": "[axes]\nworld.floor.friction = []\n",
    "a quantity that there is not": "[axes]\nworld.floor.friction = [0.1]\n[expect]\nslip_energi_j = { max = 1 }\n",
    "no runs": 'method = "random"\npoints = 0\n[axes]\nworld.floor.friction = { from = 0.1, to = 0.2 }\n',
    "no scenario": "",
    "no TOML": "[axes\n",
}


@pytest.mark.parametrize("what", BAD)
def test_bad_studies_raise_what_the_command_says(folder, command, tmp_path, what):
    path = tmp_path / "bad.toml"
    scenario = "" if what == "no scenario" else f"scenario = '{folder / 'short.toml'}'\n"
    path.write_text(scenario + BAD[what])
    said = command("sweep", path, "--out", tmp_path / "out", code=2).stderr
    with pytest.raises(ilon.ScenarioError) as raised:
        ilon.sweep(path, out=tmp_path / "out")
    assert raised.value.message in said and (raised.value.help or "") in said
    assert not (tmp_path / "out").exists()


def test_a_folder_of_other_results_is_refused_and_left_as_it_is(study, command, folder, tmp_path):
    ilon.sweep(study, out=tmp_path)
    before = bytes_of(tmp_path)
    other = {**study, "axes": {"world.floor.friction": [0.3]}}
    with pytest.raises(ilon.ScenarioError, match="before it, its scenarios or its robots were changed"):
        ilon.sweep(other, out=tmp_path)
    assert bytes_of(tmp_path) == before
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "runs.parquet").write_text("mine")
    with pytest.raises(ilon.ScenarioError, match="was not written by a study"):
        ilon.sweep(study, out=tmp_path / "foreign")
    assert (tmp_path / "foreign" / "runs.parquet").read_text() == "mine"
    with pytest.raises(ilon.ReadError, match="nowhere.toml"):
        ilon.sweep(folder / "nowhere.toml")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"jobs": 0}, "jobs is a whole number"),
        ({"jobs": 1.5}, "jobs is a whole number"),
        ({"on": "slurm"}, "not on 'slurm'"),
        ({"shard": "1/2"}, "name it by out"),
        ({"shard": "3/2", "out": "x"}, "write I/N"),
    ],
)
def test_wrong_arguments_are_refused(study, tmp_path, monkeypatch, wrong, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=message):
        ilon.sweep(study, **wrong)
    with pytest.raises(TypeError, match="a study is the path of a file or a dict, not a int"):
        ilon.sweep(3)
    assert not list(tmp_path.iterdir())


def test_two_at_once_into_one_folder_are_refused(study, tmp_path):
    tries = []

    def again(done, most):
        if not tries:
            with pytest.raises(ilon.TraceError, match="is being written to by another run"):
                ilon.sweep(study, out=tmp_path)
            tries.append(done)

    ilon.sweep(study, out=tmp_path, progress=again)
    assert tries
    ilon.sweep(study, out=tmp_path)


def test_what_the_caller_raises_ends_it_and_what_was_run_stays(study, tmp_path):
    long = {
        **study,
        "set": {"run.duration_s": 20.0},
        "axes": {"world.floor.friction": list(np.linspace(0.5, 0.9, 120))},
    }

    def tire(done, most):
        if done >= 2:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        ilon.sweep(long, out=tmp_path, jobs=2, progress=tire)
    rows = (tmp_path / "rows.log").read_bytes().count(b"\n")
    assert 2 <= rows < 120 and not (tmp_path / "runs.parquet").exists()
    with pytest.raises(LookupError):
        ilon.sweep(long, out=tmp_path, progress=tire)


INTERRUPTED = """
import sys, ilon
study = {{"scenario": {scenario!r}, "set": {{"run.duration_s": 3000.0}}, "axes": {{"world.floor.friction": [0.5, 0.6]}}}}
try:
    ilon.sweep(study, out={out!r}, progress=lambda done, most: print("begun", flush=True))
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process there")
def test_ctrl_c_ends_a_study_in_the_middle_of_a_run(folder, tmp_path):
    text = INTERRUPTED.format(scenario=str(folder / "short.toml"), out=str(tmp_path / "out"))
    process = subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=10)
        assert out.endswith("interrupted\n") and process.returncode == 0
        # A stopped run is no row.
        assert (tmp_path / "out" / "rows.log").read_bytes() == b""
    finally:
        process.kill()


def test_a_trainable_gives_the_figures_of_a_run(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(folder)
    trainable = ilon.tune_trainable("short.toml", settings={"run.duration_s": 0.3})
    # Tune runs trials in folders of their own, in other processes.
    monkeypatch.chdir(tmp_path)
    figures = trainable({"world.floor.friction": np.float64(0.3)})
    settings = {"run.duration_s": 0.3, "world.floor.friction": 0.3}
    expected = ilon.run(folder / "short.toml", settings=settings).figures
    for each in (figures, expected):
        # This one measures the machine.
        each.pop("sim_seconds_per_cpu_second")
    assert figures == expected and figures["duration_s"] == pytest.approx(0.3, abs=0.011)
    with pytest.raises(ilon.ScenarioError, match="fricton"):
        trainable({"world.floor.fricton": 0.3})


def test_a_result_says_that_it_cannot_be_pickled(study):
    with pytest.raises(TypeError):
        pickle.dumps(ilon.sweep(study))
