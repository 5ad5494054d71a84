"""Tunes gains by Ray Tune with Optuna: which follow a fast figure eight best?

A trial is a run of a scenario with the gains that Optuna proposes; Tune runs as many side by side as there are cores.

    pip install "./python[tune]"
    python python/examples/tune_gains.py [--trials 40]
"""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

from ray import tune  # noqa: E402
from ray.tune.search.optuna import OptunaSearch  # noqa: E402

import ilon  # noqa: E402

SCENARIO = Path(__file__).resolve().parents[2] / "assets" / "scenarios" / "mecanum4_fast_eight_pid.toml"
METRIC = "position_error_rms_m"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=40)
    arguments = parser.parse_args()
    settings = {"run.duration_s": 9.0}
    space = {
        "guidance.position_gain_per_s": tune.loguniform(0.5, 20),
        "guidance.heading_gain_per_s": tune.loguniform(0.5, 20),
        "wheel_loop.bandwidth_rad_s": tune.loguniform(10, 200),
    }
    with tempfile.TemporaryDirectory() as folder:
        tuner = tune.Tuner(
            ilon.tune_trainable(SCENARIO, settings=settings),
            param_space=space,
            tune_config=tune.TuneConfig(
                search_alg=OptunaSearch(seed=1), metric=METRIC, mode="min", num_samples=arguments.trials
            ),
            run_config=tune.RunConfig(storage_path=folder, verbose=0),
        )
        best = tuner.fit().get_best_result()
    as_it_is = ilon.run(SCENARIO, settings=settings).figures[METRIC]
    print(f"as the scenario says: {1e3 * as_it_is:.2f} mm rms; tuned: {1e3 * best.metrics[METRIC]:.2f} mm rms with")
    for key, value in best.config.items():
        print(f"  {key} = {value:.3g}")


if __name__ == "__main__":
    main()
