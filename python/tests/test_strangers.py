"""Untrusted robots: no content of a file is ever executed, and with a sandbox no file outside is
read.
"""

import os
import textwrap
from importlib.metadata import requires

import pytest

import ilon

HEAD = '<robot name="bait" xmlns:xacro="http://www.ros.org/wiki/xacro">'

# Each runs a shell if Python evaluates it; a lambda hides the names from checks of the outermost
# code object only.
BAITS = {
    "subclasses": "(lambda: [c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"
    ".__init__.__globals__['system']('touch MARK'))() and ''",
    "import": "__import__('os').system('touch MARK')",
    "eval": "eval('__import__(&quot;os&quot;).system(&quot;touch MARK&quot;)')",
    "yaml": "xacro.load_yaml('bait.yaml')",
}


@pytest.fixture(params=BAITS)
def bait(request, tmp_path, assets):
    """A robot that tries to run something, and the path of the file that would prove it."""
    mark = tmp_path / "mark"
    (tmp_path / "bait.yaml").write_text(f"!!python/object/apply:os.system ['touch {mark}']\n")
    expression = BAITS[request.param].replace("MARK", str(mark))
    text = (assets / "robots" / "mecanum4.urdf").read_text()
    body = text[text.index(">", text.index("<robot")) + 1 :]
    path = tmp_path / "robot.xacro"
    path.write_text(f'{HEAD}<xacro:property name="x" value="${{{expression}}}"/><link name="a${{x}}"/>{body}')
    (tmp_path / "s.toml").write_text(
        '[robot]\nfile = "robot.xacro"\n[reference.figure_eight]\nhalf_width_m = 1\nperiod_s = 16\n[run]\nduration_s = 0.2\n'
    )
    (tmp_path / "study.toml").write_text('scenario = "s.toml"\n[axes]\nworld.floor.friction = [0.3, 0.6]\n')
    (tmp_path / "log.csv").write_text("t,x\n0,1\n1,2\n")
    (tmp_path / "identify.toml").write_text(
        'robot = "robot.xacro"\n[log]\ntime = { column = "t", unit = "s" }\n[[runs]]\nfile = "log.csv"\nseries = "a"\n'
    )
    return path, mark


def entries(path):
    """All functions that read a robot, by name."""
    folder = path.parent
    scenario, study = folder / "s.toml", folder / "study.toml"
    asked = {
        "inspect": lambda: ilon.inspect(path),
        "run": lambda: ilon.run(scenario),
        "run a dict": lambda: ilon.run({"robot": {"file": str(path)}, "twist": {}, "run": {"duration_s": 0.1}}),
        "check": lambda: ilon.check(scenario),
        "sweep": lambda: ilon.sweep(study, jobs=1),
        "Simulation": lambda: ilon.Simulation(scenario),
        "identify": lambda: ilon.identify(folder / "identify.toml"),
        "tune_trainable": lambda: ilon.tune_trainable(scenario)({}),
        "generate": lambda: ilon.generate(path),
        "compare": lambda: ilon.compare(path, path),
    }
    try:
        import gymnasium
    except ImportError:
        return asked
    asked["Gymnasium"] = lambda: gymnasium.make("ilon/Track-v0", scenario=scenario)
    asked["Gymnasium, many"] = lambda: gymnasium.make_vec("ilon/Track-v0", num_envs=2, scenario=scenario)
    return asked


def test_no_entry_runs_anything_of_a_robot(bait):
    path, mark = bait
    for name, entry in entries(path).items():
        try:
            entry()
        except Exception as refused:  # noqa: BLE001
            assert isinstance(refused, (ilon.Error, ValueError)), (name, refused)
        assert not mark.exists(), name


def test_the_package_brings_no_other_interpreter():
    assert not [needed for needed in requires("ilon") if needed.startswith("xacro")]


def test_no_command_runs_anything_of_a_robot(bait, command):
    path, mark = bait
    folder = path.parent
    for arguments in (
        ["inspect", path],
        ["run", folder / "s.toml", "--out", folder / "out"],
        ["check", folder / "s.toml"],
        ["sweep", folder / "study.toml", "--out", folder / "swept"],
        ["identify", folder / "identify.toml", "--out", folder / "identified"],
        ["compare", folder / "s.toml", folder / "s.toml"],
        ["live", folder / "s.toml", "--port", "0", "--seconds", "1"],
        ["generate", path],
    ):
        # The study's rows are those of refused robots; all others end with 2.
        command(*arguments, code={0, 2} if arguments[0] == "sweep" else 2)
        assert not mark.exists(), arguments


def test_the_bait_bites_where_python_evaluates_it(tmp_path):
    mark = tmp_path / "mark"
    eval(BAITS["subclasses"].replace("MARK", str(mark)))
    assert mark.exists()


@pytest.fixture
def confined(tmp_path, assets):
    """A folder with a scenario and a robot, beside another robot and other scenarios outside of it.
    """
    inside = tmp_path / "in"
    inside.mkdir()
    robot = (assets / "robots" / "mecanum4.urdf").read_text()
    for place in (inside, tmp_path):
        (place / "robot.urdf").write_text(robot)
    for name, file in (("good", "robot.urdf"), ("bad", "../robot.urdf")):
        (inside / f"{name}.toml").write_text(
            textwrap.dedent(f"""\
            [robot]
            file = "{file}"
            [reference.circle]
            radius_m = 1
            speed_m_s = 0.2
            [run]
            duration_s = 0.2
            """)
        )
        (inside / f"{name}_study.toml").write_text(f'scenario = "{name}.toml"\n[axes]\nworld.floor.friction = [0.3]\n')
    return inside


def asked(folder, name, sandbox):
    """All functions with a sandbox argument, with the valid scenario or the one that names a robot
    outside.
    """
    import gymnasium

    scenario = folder / f"{name}.toml"
    robot = folder / ("robot.urdf" if name == "good" else "../robot.urdf")
    return {
        "inspect": lambda: ilon.inspect(robot, sandbox=sandbox),
        "run": lambda: ilon.run(scenario, sandbox=sandbox),
        "run a dict": lambda: ilon.run(
            {"robot": {"file": str(robot)}, "twist": {}, "run": {"duration_s": 0.1}}, sandbox=sandbox
        ),
        "check": lambda: ilon.check(scenario, sandbox=sandbox),
        "sweep": lambda: rows_of(ilon.sweep(folder / f"{name}_study.toml", sandbox=sandbox, jobs=1)),
        "Simulation": lambda: ilon.Simulation(scenario, sandbox=sandbox),
        "tune_trainable": lambda: ilon.tune_trainable(scenario, sandbox=sandbox)({}),
        "Gymnasium": lambda: gymnasium.make("ilon/Track-v0", scenario=scenario, sandbox=sandbox).reset(),
        "randomise": lambda: gymnasium.make(
            "ilon/Track-v0", scenario=scenario, sandbox=sandbox, randomise={"robot.x_m": (0, 1)}
        ).reset(),
    }


def rows_of(sweep):
    (status,), (error,) = sweep["status"], sweep["error"]
    if status != "done":
        raise ilon.RobotError(error)


@pytest.mark.parametrize("several", [False, True])
def test_in_a_sandbox_what_lies_inside_is_read_and_nothing_else(confined, several):
    pytest.importorskip("gymnasium")
    sandbox = [confined / ".", os.fspath(confined)] if several else confined
    for name, entry in asked(confined, "good", sandbox).items():
        assert entry() is not False, name
    for name, entry in asked(confined, "bad", sandbox).items():
        with pytest.raises((ilon.Error, ValueError), match="outside of what may be read"):
            entry()
            pytest.fail(name)
    for name, entry in asked(confined, "bad", None).items():
        assert entry() is not False, name


def test_in_a_sandbox_the_environment_is_not_seen(confined, monkeypatch):
    monkeypatch.setenv("TOKEN", "secret")
    path = confined / "robot.xacro"
    path.write_text(f'{HEAD}<link name="$(env TOKEN)"/></robot>')
    with pytest.raises(ilon.RobotError) as refused:
        ilon.inspect(path, sandbox=confined)
    assert "secret" not in str(refused.value)


def test_identify_keeps_to_its_sandbox(confined):
    (confined / "identify.toml").write_text('robot = "../robot.urdf"\n[log]\n[[runs]]\nfile = "log.csv"\nseries = "a"\n')
    with pytest.raises(ilon.Error, match="outside of what may be read"):
        ilon.identify(confined / "identify.toml", sandbox=confined)


def test_a_run_of_a_sandbox_stays_in_it_when_it_is_pickled(confined):
    import pickle

    run = pickle.loads(pickle.dumps(ilon.run(confined / "good.toml", sandbox=confined)))
    assert run.parts()[5] == [confined.resolve()]


@pytest.mark.parametrize(
    ("sandbox", "fault"), [("nowhere", ilon.ReadError), ([], ValueError), (3, TypeError), ([3], TypeError)]
)
def test_what_is_no_sandbox_is_refused(confined, sandbox, fault):
    with pytest.raises(fault, match="sandbox"):
        ilon.run(confined / "good.toml", sandbox=sandbox)
