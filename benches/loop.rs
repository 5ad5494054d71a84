//! One step of the whole loop (sensors, guidance, wheel loops, motors, world, record): time and
//! allocations. The bench `step` measures the world alone.

use divan::{AllocProfiler, Bencher};
use ilon::Scenario;
use ilon::simulate::Simulation;

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// Open loop, sideways, as in `ilon run`: a row of the trace every 10 ms.
#[divan::bench(args = ["volksbot_lateral", "mecanum4_lateral"])]
fn open_loop(bencher: Bencher, scenario: &str) {
    bench(bencher, scenario, 1);
}

/// With guidance, which updates every 10 ms.
#[divan::bench(args = ["volksbot_position_first", "mecanum4_circle"])]
fn closed_loop(bencher: Bencher, scenario: &str) {
    bench(bencher, scenario, 1);
}

/// The same, with a row of the trace every second.
#[divan::bench(args = ["volksbot_position_first", "mecanum4_circle"])]
fn thinned(bencher: Bencher, scenario: &str) {
    bench(bencher, scenario, 100);
}

/// Steps of 1 ms in the contact window, after two seconds of warm-up.
fn bench(bencher: Bencher, scenario: &str, record_every: u32) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/scenarios");
    let settings = [
        "robot.roller_bodies=near".to_owned(),
        "run.physics_dt_s=0.001".to_owned(),
        "run.duration_s=1000.0".to_owned(),
        format!("run.record_every={record_every}"),
    ];
    let settings = settings.map(|setting| setting.parse().expect("a setting"));
    let path = format!("{folder}/{scenario}.toml");
    let scenario = Scenario::load_with(path, &settings).expect("a shipped scenario");
    let mut simulation = Simulation::new(&scenario).expect("a shipped scenario runs");
    for _ in 0..2000 {
        simulation.step();
    }
    bencher.bench_local(|| simulation.step());
}
