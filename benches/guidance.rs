//! One controller update: the guidance law, the contact kinematics, the wheel loops.

use divan::{AllocProfiler, Bencher, black_box};
use ilon_control::{
    ContactKinematics, Demand, Gain, Guidance, GuidanceSettings, Kinematics, LoopTiming, Priority,
    Reference, Saturation, TorqueLaw, TorqueRange, WheelGains, WheelLoop, WheelLoopSettings,
};
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

const ROBOTS: [&str; 3] = ["volksbot", "mecanum4", "mecanum6"];

fn main() {
    divan::main();
}

fn robot(name: &str) -> Robot {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/robots");
    Robot::load(format!("{folder}/{name}.urdf")).expect("a shipped robot loads")
}

/// From a pose and a desired pose half a metre apart to saturated wheel rates: eqs. (29)-(50).
#[divan::bench(args = ROBOTS)]
fn prioritised_guidance(bencher: Bencher, name: &str) {
    let kinematics = Kinematics::new(&robot(name)).expect("a shipped robot has kinematics");
    let settings = GuidanceSettings {
        position_gain: Gain::Scalar(1.0),
        heading_gain: 1.0,
        wheel_rate_limit_rad_s: 8.7,
        saturation: Saturation::Prioritised(Priority::Position),
    };
    let mut guidance = Guidance::new(kinematics, &settings).expect("valid settings");
    let reference = Reference::hold(Pose {
        x_m: 0.5,
        ..Pose::default()
    })
    .expect("a finite pose");
    let desired = reference.at(1.0);
    bencher.bench_local(|| {
        guidance
            .update(black_box(&Pose::default()), &desired)
            .wheel_rates_rad_s[0]
    });
}

/// The twist without slip at the rollers in contact.
#[divan::bench(args = ROBOTS)]
fn contact_kinematics(bencher: Bencher, name: &str) {
    let robot = robot(name);
    let mut contact = ContactKinematics::new(&robot).expect("a shipped robot has kinematics");
    let angles_rad = vec![0.3; robot.wheels.len()];
    let rates_rad_s = vec![2.0; robot.wheels.len()];
    bencher.bench_local(|| contact.twist(black_box(&angles_rad), &rates_rad_s));
}

/// One PID per wheel.
#[divan::bench(args = [3, 4, 6])]
fn wheel_loops(bencher: Bencher, wheels: usize) {
    let gains = WheelGains::propose_continuous(7e-3, 60.0).expect("valid figures");
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        ..WheelLoopSettings::new(gains)
    };
    let mut loops = WheelLoop::new(wheels, settings).expect("valid gains");
    let (targets, rates) = (vec![5.0; wheels], vec![4.9; wheels]);
    let limits = vec![TorqueRange::UNLIMITED; wheels];
    bencher
        .bench_local(|| loops.update(&Demand::new(black_box(&targets), &rates, &limits, 1e-3))[0]);
}
