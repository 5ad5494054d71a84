"""Whole runs: the results of `ilon.run` are the command's."""

import json
import os
import pickle
import subprocess
import tomllib

import numpy as np
import pytest

import ilon


def test_a_run_is_the_same_to_the_bit_as_that_of_the_command(lateral, lateral_run, command, tmp_path):
    command("run", lateral, "--no-twins", "--out", tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert lateral_run.summary["trace_hash"] == summary["trace_hash"]
    # All figures except the one that measures this machine.
    for each in (summary, ours := lateral_run.summary):
        each.pop("sim_seconds_per_cpu_second")
    assert ours == summary


@pytest.mark.skipif("ILON_COMMAND" not in os.environ, reason="ILON_COMMAND names no command that cargo built")
@pytest.mark.parametrize("name", ["mecanum4_lateral", "volksbot_section_iv_position_first", "mecanum4_slippery_plain"])
def test_a_run_is_the_same_to_the_bit_as_that_of_the_command_that_cargo_builds(assets, name, tmp_path):
    scenario = assets / "scenarios" / f"{name}.toml"
    said = subprocess.run(
        [os.environ["ILON_COMMAND"], "run", scenario, "--out", tmp_path, "--json"], capture_output=True, check=True
    )
    assert ilon.run(scenario).summary["trace_hash"] == json.loads(said.stdout)["trace_hash"]


def test_what_a_run_writes_is_what_the_command_writes(lateral, lateral_run, command, tmp_path):
    command("run", lateral, "--no-twins", "--out", tmp_path / "theirs")
    lateral_run.write(tmp_path / "ours")
    names = {path.name for path in (tmp_path / "ours").iterdir()}
    assert {"summary.json", "trace.parquet", "report.html", "scenario.toml"} <= names
    for name in ("trace.parquet", "scenario.toml"):
        assert (tmp_path / "ours" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()


def test_what_a_person_wrote_is_not_replaced(lateral_run, tmp_path):
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(ilon.TraceError, match="was not written by a run"):
        lateral_run.write(tmp_path)
    assert (tmp_path / "summary.json").read_text() == "{}"


def test_a_dict_and_its_file_are_the_same_run(lateral, lateral_run):
    scenario = tomllib.loads(lateral.read_text())
    run = ilon.run(scenario, folder=lateral.parent)
    assert run.summary["trace_hash"] == lateral_run.summary["trace_hash"]


def test_the_scenario_of_a_run_runs_again_to_the_same_trace(lateral, lateral_run):
    again = ilon.run(lateral_run.scenario, folder=lateral.parent)
    assert again.summary["trace_hash"] == lateral_run.summary["trace_hash"]


@pytest.mark.parametrize("as_dict", [False, True])
def test_settings_change_keys(lateral, as_dict):
    scenario = tomllib.loads(lateral.read_text()) if as_dict else lateral
    run = ilon.run(
        scenario,
        settings={"world.floor.friction": 0.25, "run.duration_s": np.float64(1.0), "twist.vy_m_s": np.int64(0)},
        folder=lateral.parent if as_dict else None,
    )
    assert run.scenario["world"]["floor"]["friction"] == 0.25
    assert run.summary["duration_s"] == 1.0
    assert run.scenario["twist"]["vy_m_s"] == 0.0


def test_none_in_a_dict_leaves_a_key_out(circle):
    circle["guidance"] = {"wheel_rate_limit_rad_s": None}
    with_none = ilon.run(circle)
    del circle["guidance"]
    assert with_none.summary["trace_hash"] == ilon.run(circle).summary["trace_hash"]


def test_columns_are_numpy_arrays_of_their_kind(lateral_run):
    trace = lateral_run.trace
    # One at the beginning of each control period, and one at the end.
    rows = round(lateral_run.summary["duration_s"] / lateral_run.scenario["run"]["control_dt_s"]) + 1
    assert trace["truth_x_m"].dtype == np.float64
    assert trace["truth_x_m"].shape == (rows,) == (trace.rows,)
    assert trace["wheel0_touching"].dtype == np.bool_
    assert trace["wheel0_roller"].dtype == np.uint32
    assert trace["t_s"][0] == 0.0
    np.testing.assert_allclose(np.diff(trace["t_s"]), 0.01, atol=1e-12)


def test_a_column_is_made_once_and_cannot_be_written_to(lateral_run):
    column = lateral_run.trace["truth_x_m"]
    assert lateral_run.trace["truth_x_m"] is column
    with pytest.raises(ValueError, match="read-only"):
        column[0] = 1.0


def test_what_does_not_apply_is_nan(lateral_run):
    assert np.isnan(lateral_run.trace["desired_x_m"]).all()


def test_a_trace_is_a_mapping(lateral_run):
    trace = lateral_run.trace
    assert "truth_x_m" in trace and "truth_q_m" not in trace and 3 not in trace
    assert list(trace) == trace.columns and len(trace) == len(trace.columns)
    assert list(dict(trace)) == trace.columns
    # A copy holds the columns that nobody has read yet, too.
    for copy in (dict(trace), {**trace}, dict(trace.items()), dict(zip(trace, trace.values(), strict=True))):
        assert all(copy[name] is trace[name] for name in trace.columns)
    assert trace.get("truth_q_m") is None and trace.get("t_s") is trace["t_s"]


def test_a_misspelt_column_is_named_with_the_nearest_one(lateral_run):
    with pytest.raises(KeyError, match="did you mean `truth_x_m`"):
        lateral_run.trace["truth_x"]


def test_the_ideal_kinematics_are_missed_by_the_tilt_of_the_touching_roller(lateral_run):
    # Nine rollers at 45 degrees: sin(20 deg) / (20 deg in rad) = 0.9798, which the scenario itself
    # checks to half a per cent.
    expected = np.sin(np.radians(20)) / np.radians(20)
    trace = lateral_run.trace
    late = trace["t_s"] > 2.0
    real = trace["truth_vy_m_s"][late].mean()
    ideal = trace["ideal_vy_m_s"][late].mean()
    assert real / ideal == pytest.approx(expected, abs=0.005)


def test_a_pickled_run_is_the_same_run(lateral_run):
    again = pickle.loads(pickle.dumps(lateral_run))
    assert again.summary == lateral_run.summary
    assert again.scenario == lateral_run.scenario
    assert again.name == lateral_run.name and again.warnings == lateral_run.warnings
    for name in lateral_run.trace:
        np.testing.assert_array_equal(again.trace[name], lateral_run.trace[name])


def test_the_report_is_a_page_that_a_notebook_shows(lateral_run, tmp_path):
    report = lateral_run.report()
    assert report.startswith("<!") and report.rstrip().endswith("</html>")
    report.write(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == report
    shown = lateral_run._repr_html_()
    assert shown.startswith("<iframe") and shown.count("<iframe") == 1
    # Escaped, otherwise the page would end its own attribute.
    inner = shown.split('srcdoc="', 1)[1].split('" sandbox', 1)[0]
    assert '"' not in inner and "<" not in inner


def test_a_controller_of_ones_own_drives_the_wheels(circle):
    seen = []

    def controller(now, desired):
        seen.append((now.t_s, now.pose, desired.pose))
        return [5.0, 5.0, 5.0, 5.0]

    run = ilon.run(circle, controller=controller)
    # At the end of the run there is no further control update.
    assert len(seen) == run.trace.rows - 1
    assert seen[0][0] == 0.0
    np.testing.assert_allclose(seen[0][1], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(seen[0][2], [1.0, 0.0, 0.0], atol=1e-12)
    assert (run.trace["wheel2_target_rad_s"] == 5.0).all()
    # Straight ahead at rate times radius; a mecanum wheel of nine barrels rolls on its outline to
    # within a per cent.
    assert run.trace["truth_vx_m_s"][-1] == pytest.approx(5.0 * 0.05, rel=0.01)


def test_a_controller_may_command_torques(circle):
    run = ilon.run(circle, controller=lambda now, desired: ilon.Torques(np.full(4, 0.05)))
    assert run.trace["wheel0_torque_n_m"][10:].mean() == pytest.approx(0.05)


def test_what_a_controller_raises_comes_out(circle):
    class Own(Exception):
        pass

    def controller(now, desired):
        if now.t_s > 0.5:
            raise Own("enough")
        return [0.0] * 4

    with pytest.raises(Own, match="enough"):
        ilon.run(circle, controller=controller)


@pytest.mark.parametrize("answer", [[1.0] * 3, [1.0, 2.0, 3.0, float("nan")], None, "fast", [[1.0] * 4]])
def test_what_is_no_command_is_refused(circle, answer):
    with pytest.raises((ValueError, TypeError), match="wheel rates"):
        ilon.run(circle, controller=lambda now, desired: answer)


def test_runs_are_compared(lateral, lateral_run, tmp_path):
    slippery = ilon.run(lateral, settings={"world.floor.friction": 0.2})
    slippery.write(tmp_path / "slippery")
    comparison = ilon.compare(lateral_run, tmp_path / "slippery")
    assert [row["key"] for row in comparison.differences] == ["world.floor.friction"]
    figures = list(comparison.summaries.values())
    assert figures[0]["trace_hash"] == lateral_run.summary["trace_hash"]
    assert figures[1]["trace_hash"] == slippery.summary["trace_hash"]
    assert comparison.page.rstrip().endswith("</html>")


def test_one_run_is_nothing_to_compare(lateral_run):
    with pytest.raises(ilon.TraceError, match="(?i)two"):
        ilon.compare(lateral_run)


def test_a_scenario_is_checked_against_its_own_expectations(lateral):
    assert ilon.check(lateral)
    failed = ilon.check(lateral, settings={"twist.vy_m_s": 0.0, "twist.vx_m_s": 0.3})
    assert not failed
    # An undriven direction has no ratio.
    fallen = {verdict.quantity for verdict in failed.verdicts if not verdict.held}
    assert fallen == {"twist_ratio_ideal.vy", "twist_ratio_contact.vy"}
    assert "failed" in repr(failed)


def test_a_robot_is_inspected(assets):
    robot = ilon.inspect(assets / "robots" / "mecanum4.urdf")
    assert robot["rank"] == 3 and len(robot["wheels"]) == 4
    # sqrt(2) rho / (sqrt(2) ...): forwards each wheel turns at v / rho.
    row = np.array(robot["M"])[0] / robot["wheels"][0]["radius_m"]
    assert robot["wheels"][0]["radius_m"] == pytest.approx(0.05, abs=1e-6)
    assert np.isfinite(row).all()
    assert robot.svg.startswith("<svg") and "<robot" in robot.urdf
    again = pickle.loads(pickle.dumps(robot))
    assert again == robot and again.svg == robot.svg


def test_a_urdf_is_generated_that_the_repository_holds(assets, tmp_path):
    urdf = ilon.generate(assets / "robots" / "mecanum4.toml", tmp_path / "robot.urdf")
    assert urdf == (assets / "robots" / "mecanum4.urdf").read_text()
    assert (tmp_path / "robot.urdf").read_text() == urdf


def test_a_robot_on_tyres_is_generated(assets, tmp_path):
    ilon.generate(assets / "robots" / "tricycle.toml", tmp_path / "robot.urdf")
    assert len(ilon.inspect(tmp_path / "robot.urdf")["wheels"]) == 3


def test_the_schema_names_the_sections():
    assert {"robot", "run", "reference", "twist"} <= set(ilon.schema()["properties"])


def test_a_run_is_repeated_at_half_the_step(circle):
    circle["run"]["duration_s"] = 0.5
    alone = ilon.run(circle)
    run = ilon.run(circle, converge=True)
    assert "converge" not in alone.summary
    assert run.summary["trace_hash"] == alone.summary["trace_hash"]
    place = run.summary["converge"]["end_x_m"]
    assert place["value"] == alone.summary["end_x_m"]
    # On a tracked circle, half the step changes nothing significant.
    assert 0 < place["moved"] < 1e-3 and not place["exceeds"]
    assert ilon.check(circle, converge=True).run.summary["converge"] == run.summary["converge"]
    assert pickle.loads(pickle.dumps(run)).summary == run.summary


def test_a_controller_of_ones_own_is_not_repeated(circle):
    with pytest.raises(ilon.Error, match="cannot be repeated"):
        ilon.run(circle, converge=True, controller=lambda seen, desired: [0.0] * 4)


def test_what_a_cause_did_is_a_difference_of_two_runs(assets):
    scenario = {
        "robot": {"file": "robots/mecanum4.urdf", "roller_bodies": "near"},
        "twist": {"vx_m_s": 0.3, "rest_s": 0.1, "ramp_s": 0.4},
        "faults": [{"push": {"impulse_y_n_s": 8.0, "from_s": 0.8}}],
        "run": {"duration_s": 1.5},
    }
    found = ilon.run(scenario, folder=assets, causes="named")
    without = ilon.run({**scenario, "faults": []}, folder=assets)
    assert without.effects == []
    of_push = {effect["key"]: effect for effect in found.effects if effect["cause"] == "faults.0"}
    place = of_push["end_y_m"]
    assert (place["with"], place["without"]) == (found.summary["end_y_m"], without.summary["end_y_m"])
    assert place["differs"] and of_push["apart_m"]["differs"]
    assert {"sliding", "geometry"} <= {effect["cause"] for effect in ilon.explain(scenario, folder=assets).effects}
    with pytest.raises(ilon.Error, match="cannot be started again"):
        ilon.run(scenario, folder=assets, causes="all", controller=lambda seen, desired: [0.0] * 4)
    with pytest.raises(ValueError, match="named"):
        ilon.run(scenario, folder=assets, causes="some")


def test_suspects_drift(assets):
    found = ilon.suspects(assets / "robots/mecanum4.urdf")
    smaller = next(one for one in found if one["wheel"] == "front_left" and "smaller" in one["words"])
    # One wheel of four that rolls 1 % less reduces the distance ahead by a quarter of that.
    assert smaller["drifts"][0]["ahead_m"] == pytest.approx(-0.0025, rel=0.02)


def test_a_run_is_a_frame_of_pandas(lateral_run):
    pytest.importorskip("pandas")
    frame = lateral_run.to_pandas()
    assert list(frame.columns) == lateral_run.trace.columns
    assert frame["truth_x_m"].to_numpy().tolist() == lateral_run.trace["truth_x_m"].tolist()
