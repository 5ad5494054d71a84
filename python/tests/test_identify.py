"""Identification from logs that ilon itself drove."""

import json
import tomllib

import numpy as np
import pytest

import ilon

# The scale error of these logs' tracker.
LONGER = 1.03


@pytest.fixture(scope="module")
def study(assets, tmp_path_factory):
    """Logs of two circles, and a study of the wheels' radius by them."""
    return written(assets, tmp_path_factory.mktemp("identify"), 1.0)


def written(assets, folder, longer):
    """The same, with a tracker of this scale."""
    robot = assets / "robots" / "mecanum4.toml"
    for name, heading in (("ahead", "along_path"), ("across", {"constant_deg": 0})):
        run = ilon.run(
            {
                "robot": {"file": str(assets / "robots" / "mecanum4.urdf")},
                "reference": {"circle": {"radius_m": 1.0, "speed_m_s": 0.3, "heading": heading}},
                "run": {"duration_s": 20.0},
            }
        )
        trace = run.trace
        columns = [
            trace["t_s"],
            longer * trace["truth_x_m"],
            longer * trace["truth_y_m"],
            trace["truth_heading_rad"],
            *(trace[f"wheel{wheel}_angle_rad"] for wheel in range(4)),
        ]
        names = [wheel["name"] for wheel in trace.header["wheels"]]
        header = ",".join(["t_s", "x_m", "y_m", "heading_rad", *names])
        np.savetxt(folder / f"{name}.csv", np.column_stack(columns), delimiter=",", header=header, comments="")
    wheels = "\n".join(f'{name} = {{ column = "{name}", unit = "rad" }}' for name in names)
    path = folder / "study.toml"
    path.write_text(
        f"""robot = '{robot}'
tracker = ["heading_deg"]

[log]
time = {{ column = "t_s", unit = "s" }}
x = {{ column = "x_m", unit = "m" }}
y = {{ column = "y_m", unit = "m" }}
heading = {{ column = "heading_rad", unit = "rad" }}

[log.wheels]
{wheels}

[[runs]]
file = "ahead.csv"

[[runs]]
file = "across.csv"
held_out = true

[[models]]
name = "size"
free = ["radius_m", "lever_m"]
"""
    )
    return path


def test_what_is_found_is_what_the_command_finds(study, command, tmp_path):
    found = ilon.identify(study)
    said = json.loads(command("identify", study, "--out", tmp_path / "theirs", "--json").stdout)
    assert found == said
    assert found == ilon.identify(study, out=tmp_path / "ours")
    assert json.loads((tmp_path / "ours" / "identified.json").read_text()) == said
    assert (tmp_path / "ours" / "report.html").exists()


def test_a_dict_is_a_study_too(study):
    with open(study, "rb") as file:
        table = tomllib.load(file)
    assert ilon.identify(table, folder=study.parent)["parameters"] == ilon.identify(study)["parameters"]
    with pytest.raises(ilon.ScenarioError, match="no run to fit"):
        ilon.identify(table | {"runs": []}, folder=study.parent)


def test_wheels_and_levers_are_as_much_larger_as_the_tracker_counts_too_long(study, assets, tmp_path):
    true, long = (ilon.identify(one)["parameters"] for one in (study, written(assets, tmp_path, LONGER)))
    for name in ("radius_m", "lever_m"):
        # Positions scale with both, and headings with their ratio.
        assert long[name]["value"] / true[name]["value"] == pytest.approx(LONGER, rel=1e-4)
        assert true[name]["unit"] == "m" and true[name]["ci95"][0] < true[name]["value"] < true[name]["ci95"][1]


def test_runs_measured_by_tape_are_fitted_as_the_command_fits_them(assets, command, tmp_path):
    tape = tmp_path / "tape.toml"
    tape.write_text(
        f'robot = "{assets}/robots/mecanum4.urdf"\nmeasured = [\n'
        "  { drive = { vx_m_s = 0.4, for_s = 5 }, x_m = 1.970, y_m = 0.004 },\n"
        "  { drive = { omega_rad_s = 1.2, for_s = 15.7 }, heading_deg = 4.5 },\n]\n"
    )
    said = json.loads(command("identify", tape, "--out", tmp_path / "theirs", "--json").stdout)
    assert ilon.identify(tape) == said == ilon.identify(tape, out=tmp_path / "ours")
    assert json.loads((tmp_path / "ours" / "identified.json").read_text()) == said
    # 1.97 of 2 m.
    assert said["parameters"]["radius_m"]["value"] == pytest.approx(0.05 * 1.97 / 2, rel=1e-3)


def test_a_bad_study_raises_what_the_command_says(study, command, tmp_path):
    bad = study.with_name("bad.toml")
    bad.write_text(study.read_text().replace("ahead.csv", "gone.csv"))
    said = command("identify", bad, "--out", tmp_path / "out", code=2).stderr
    with pytest.raises(ilon.Error) as raised:
        ilon.identify(bad, out=tmp_path / "out")
    assert raised.value.message in said
    with pytest.raises(ilon.ReadError, match="nowhere.toml"):
        ilon.identify(study.with_name("nowhere.toml"))
