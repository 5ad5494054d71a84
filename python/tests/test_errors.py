"""The command line's messages about bad input arrive as exceptions."""

import pickle

import numpy as np
import pytest

import ilon

FAULTS = {
    "no such file": (None, ilon.ReadError),
    "not toml": ("[robot\n", ilon.ScenarioError),
    "a misspelt key": ('[robot]\nfile = "ROBOT"\n[world.floor]\nfrictoin = 0.2\n[twist]\n[run]\nduration_s = 1\n', ilon.ScenarioError),
    "a value that cannot be": ('[robot]\nfile = "ROBOT"\n[world.floor]\nfriction = -1\n[twist]\n[run]\nduration_s = 1\n', ilon.ScenarioError),
    "two motions": (
        '[robot]\nfile = "ROBOT"\n[twist]\n[reference.hold_pose]\nx_m=0\ny_m=0\nheading_deg=0\n[run]\nduration_s = 1\n',
        ilon.ScenarioError,
    ),
    "no such robot": ('[robot]\nfile = "nowhere.urdf"\n[twist]\n[run]\nduration_s = 1\n', ilon.RobotError),
    "no robot": ('[robot]\nfile = "s.toml"\n[twist]\n[run]\nduration_s = 1\n', ilon.RobotError),
    "no such wheel": (
        '[robot]\nfile = "ROBOT"\n[twist]\n[run]\nduration_s = 1\n[[faults]]\nmotor_lost = { wheel = "nose" }\n',
        ilon.Error,
    ),
    "nothing to expect": (
        '[robot]\nfile = "ROBOT"\n[twist]\n[run]\nduration_s = 1\n[expect]\nbeauty = { min = 1 }\n',
        ilon.ScenarioError,
    ),
}


@pytest.fixture(params=FAULTS)
def fault(request, tmp_path, assets):
    text, kind = FAULTS[request.param]
    path = tmp_path / "s.toml"
    if text is not None:
        path.write_text(text.replace("ROBOT", str(assets / "robots" / "mecanum4.urdf")))
    return path, kind


def words(text):
    return " ".join(text.replace("×", " ").replace("│", " ").split())


def test_each_message_of_the_command_line_arrives_as_an_exception(fault, command, tmp_path):
    path, kind = fault
    with pytest.raises(kind) as caught:
        ilon.run(path)
    error = caught.value
    said = command("run", path, "--out", tmp_path / "out", code=2).stderr
    assert error.message and words(error.message) in words(said)
    assert words(str(error)) in words(said)
    if error.help:
        assert words(error.help) in words(said) and words(error.help) in words(str(error))
    with pytest.raises(kind):
        ilon.Simulation(path)


def test_an_error_can_be_pickled(tmp_path):
    with pytest.raises(ilon.ReadError) as caught:
        ilon.run(tmp_path / "nowhere.toml")
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is ilon.ReadError and str(again) == str(caught.value) and again.help == caught.value.help


def test_errors_are_also_what_python_calls_them():
    assert issubclass(ilon.ReadError, OSError)
    assert issubclass(ilon.ScenarioError, ValueError) and issubclass(ilon.RobotError, ValueError)
    assert issubclass(ilon.DivergedError, ArithmeticError)


@pytest.mark.parametrize("scenario", [3, None, b"bytes", ["list"], object()])
def test_what_is_no_scenario_is_refused(scenario):
    with pytest.raises(TypeError, match="path of a file or a dict"):
        ilon.run(scenario)


def test_what_a_scenario_cannot_hold_is_named(circle):
    circle["world"] = {"floor": {"friction": object()}}
    with pytest.raises(TypeError, match=r"`world\.floor\.friction` is a object"):
        ilon.run(circle)
    circle["world"] = {1: 2}
    with pytest.raises(TypeError, match="no text"):
        ilon.run(circle)


def test_a_dict_that_holds_itself_is_refused(circle):
    circle["world"] = circle
    with pytest.raises(ValueError, match="tables or lists"):
        ilon.run(circle)


def test_numbers_that_are_none_are_refused(circle):
    for wild in (float("nan"), np.float64("inf")):
        with pytest.raises(ilon.ScenarioError):
            ilon.run(circle, settings={"world.floor.friction": wild})


def test_an_integer_beyond_all_bounds_is_refused(circle):
    with pytest.raises((OverflowError, ilon.ScenarioError)):
        ilon.run(circle, settings={"sensors.seed": 2**70})


def test_a_fault_in_a_setting_names_no_flag(lateral):
    for settings in ({"world.floor.friction": "wide"}, {"world.flor.friction": 1}, {"faults.1.payload.mass_kg": 1}):
        with pytest.raises(ilon.ScenarioError) as raised:
            ilon.run(lateral, settings=settings)
        said = str(raised.value)
        assert "--" not in said and "[settings:1:" in said, said


@pytest.mark.parametrize("key", ["", "world.", "world..floor", " "])
def test_a_setting_without_a_name_is_refused(lateral, key):
    with pytest.raises(ValueError, match="names no key"):
        ilon.run(lateral, settings={key: 1})


def test_a_folder_is_for_dicts(lateral):
    with pytest.raises(TypeError, match="folder"):
        ilon.run(lateral, folder="/")


def test_a_robot_that_cannot_be_read_says_what_would_do(tmp_path):
    path = tmp_path / "r.urdf"
    path.write_text("<robot name='r'><link name='a'/></robot>")
    with pytest.raises(ilon.RobotError) as caught:
        ilon.inspect(path)
    assert caught.value.message
    with pytest.raises(ilon.ScenarioError, match="repare"):
        ilon.inspect(path, repare=True)


def test_wrong_values_are_named_in_words_of_ilon(lateral, lateral_run):
    simulation = ilon.Simulation(lateral)
    for wrong, kind, said in (
        (lambda: ilon.run(lateral, settings=[("world.floor.friction", 0.2)]), TypeError, "`settings` is a dict"),
        (lambda: ilon.run(lateral, settings={1: 2}), ilon.ScenarioError, "unknown key `1`"),
        (lambda: ilon.run(lateral, settings={"sensors.seed": 2**70}), OverflowError, "beyond 64 bits"),
        (lambda: simulation.reset(seed=-1), OverflowError, "whole number from 0"),
        (lambda: simulation.reset(seed=1.5), TypeError, "whole number from 0"),
        (lambda: simulation.restore(None), TypeError, r"what `snapshot\(\)` returned"),
        (lambda: lateral_run.trace[0], KeyError, "no column `0`"),
        (lambda: ilon.identify(3), TypeError, "a study is the path of a file or a dict"),
    ):
        with pytest.raises(kind, match=said):
            wrong()
