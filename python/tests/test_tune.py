"""Ray Tune with Optuna: trials are runs."""

import os

import pytest

import ilon

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
ray = pytest.importorskip("ray")
pytest.importorskip("optuna")
tune = pytest.importorskip("ray.tune")

from ray.tune.search.optuna import OptunaSearch  # noqa: E402

pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.timeout(300)]


@pytest.fixture(scope="module", autouse=True)
def here():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


def test_optuna_finds_better_gains_by_tune(assets, tmp_path, monkeypatch):
    # A path relative to the working directory, whereas trials run elsewhere.
    monkeypatch.chdir(assets / "scenarios")
    key, metric = "guidance.position_gain_per_s", "position_error_rms_m"
    settings = {"run.duration_s": 1.0}
    trainable = ilon.tune_trainable("mecanum4_figure_eight.toml", settings=settings)
    tuner = tune.Tuner(
        trainable,
        param_space={key: tune.uniform(0.5, 8.0)},
        tune_config=tune.TuneConfig(search_alg=OptunaSearch(seed=1), metric=metric, mode="min", num_samples=5),
        run_config=tune.RunConfig(storage_path=str(tmp_path), verbose=0),
    )
    results = tuner.fit()
    assert len(results) == 5 and not results.errors
    best = results.get_best_result()
    errors = [result.metrics[metric] for result in results]
    assert best.metrics[metric] == min(errors) < max(errors)
    by_hand = ilon.run("mecanum4_figure_eight.toml", settings={**settings, key: best.config[key]})
    assert best.metrics[metric] == by_hand.summary[metric]


def test_a_trial_that_cannot_be_run_is_an_error_of_its_own(assets, tmp_path):
    trainable = ilon.tune_trainable(assets / "scenarios" / "mecanum4_lateral.toml", settings={"run.duration_s": 0.2})
    tuner = tune.Tuner(
        trainable,
        param_space={"world.floor.friction": tune.grid_search([0.5, -1.0])},
        run_config=tune.RunConfig(storage_path=str(tmp_path), verbose=0),
    )
    results = tuner.fit()
    assert len(results) == 2 and results.num_errors == 1
