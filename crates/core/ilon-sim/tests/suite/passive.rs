//! A passive wheel law, an inertial measurement unit, and tilting ground.

use ilon_sim::control::{ControlError, PassiveTorqueSettings};
use ilon_sim::simulate::Run;
use ilon_sim::{Error, Plant, Scenario, Simulation, WheelCommand, load_robot};
use nalgebra::{Matrix3, Vector3};
use test_case::test_case;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
const STAND: &str = "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n\
    [reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0\n";
const SPRINGS: &str = "[wheel_loop]\nlaw = 'passive'\npassive = { stiffness_n_m = 600, damping_n_s_m = 120, \
    heading_stiffness_n_m_rad = 20, heading_damping_n_m_s_rad = 3.5 }\n";

fn scenario(keys: &str) -> Result<Scenario, Error> {
    let run = "[run]\nduration_s = 5\nphysics_dt_s = 0.001\n";
    Scenario::from_toml(&format!("{STAND}{keys}{run}"), "passive", ROBOTS)
}

fn run(keys: &str) -> Run {
    let scenario = scenario(keys).unwrap();
    Simulation::new(&scenario).unwrap().run()
}

/// The robot's position at a time, in metres.
fn at(run: &Run, t_s: f64) -> [f64; 2] {
    let near = |record: &&ilon_sim::trace::Record| record.t_s >= t_s - 1e-9;
    let record = run.trace.records().iter().find(near).unwrap();
    [record.truth.pose.x_m, record.truth.pose.y_m]
}

/// F / K under a constant push, and zero afterwards.
#[test]
fn a_push_moves_the_robot_by_force_over_stiffness() {
    let run = run(&format!(
        "{SPRINGS}[[faults]]\npush = {{ impulse_y_n_s = 44, from_s = 0.5, lasts_s = 2.2 }}\n"
    ));
    let [_, y_m] = at(&run, 2.69);
    // Poles at -5 +- 5j 1/s: exp(-5 * 2.19) of it remains, 2e-5.
    assert!((y_m / (20.0 / 600.0) - 1.0).abs() < 1e-3, "{y_m}");
    let left_m = run.summary.position_error_final_m.unwrap();
    assert!(left_m < 1e-4, "{left_m}");
    let rise_j = run.summary.storage_rise_j.unwrap();
    // A joule went in and out; the ends of rows differ by a physics step of the push.
    assert!(rise_j < 1e-3, "{rise_j}");
}

#[test]
fn an_unknown_slope_costs_its_pull_over_the_stiffness_without_an_imu_and_nothing_with_one() {
    for slope_deg in [1.0_f64, 5.0, 10.0] {
        let ground = format!("[world.floor]\nslope_deg = {slope_deg}\n");
        let keys = format!("{SPRINGS}{ground}");
        let mass_kg = load_robot(&scenario(&keys).unwrap()).unwrap().mass_kg();
        let off_m = mass_kg * 9.81 * slope_deg.to_radians().sin() / 600.0;
        let blind = run(&keys);
        let [x_m, _] = at(&blind, 4.9);
        assert!((x_m / off_m - 1.0).abs() < 5e-3, "{x_m} {off_m}");
        let seeing = run(&format!("{keys}[sensors.imu]\n"));
        let left_m = seeing.summary.position_error_final_m.unwrap();
        assert!(left_m < 1e-4, "{left_m}");
        let last = seeing.trace.records().last().unwrap().imu.unwrap();
        // Nose down, and measured by the robot's filter.
        assert!((last.pitch_rad - slope_deg.to_radians()).abs() < 1e-4);
        assert!((last.specific_force_m_s2.norm() - 9.81).abs() < 1e-3);
    }
}

/// Honeywell HG1700, by its brochure: gyroscopes of 1 deg/h and 0.125 deg/sqrt(h), accelerometers
/// of 1 mg and 0.065 fps/sqrt(h). A random walk of N a root of a second is N sqrt(rate) in one
/// sample.
const TACTICAL: &str = "rate_hz = 500\naccelerometer = { noise = 7.4e-3, bias = 9.8e-3 }\ngyroscope = { noise = 8.1e-4, bias = 4.8e-6 }\n";
/// InvenSense MPU-6050, by its data sheet as it comes from the reel: 0.005 deg/s/sqrt(Hz) and +-20
/// deg/s at zero rate, 400 ug/sqrt(Hz) and +-50 mg. A density is that times sqrt(rate / 2) in one
/// sample; a tolerance is taken for two deviations. Its walk is not said: as it warms up.
const CHEAP: &str = "rate_hz = 100\naccelerometer = { noise = 0.028, bias = 0.25, bias_walk = 0.02 }\n\
    gyroscope = { noise = 6.2e-4, bias = 0.17, bias_walk = 0.003 }\nroll_deg = 0.5\n";

/// The robot's displacement by their errors: an accelerometer's bias and the mounting act through
/// the spring permanently; a gyroscope's bias until the filter has learned it, b t exp(-t / T) of
/// tilt with a maximum of b T / e, and about the vertical, which is unobservable, b T / 2 of the
/// slope.
#[test_case(TACTICAL, 0.0098, 4.8e-6, 0.0; "tactical")]
#[test_case(CHEAP, 0.25, 0.17, 0.5; "cheap")]
fn imus_at_both_ends_keep_the_robot_where_their_bias_puts_it(
    imu: &str,
    bias_m_s2: f64,
    bias_rad_s: f64,
    mounted_deg: f64,
) {
    for (seed, latency_s) in [(1, 0.0), (2, 0.02), (3, 0.1)] {
        let run = run(&format!(
            "{SPRINGS}[world.floor]\nslope_deg = 5\n[sensors]\nseed = {seed}\n[sensors.imu]\nx_m = 0.1\nz_m = 0.1\nlatency_s = {latency_s}\n{imu}"
        ));
        // Three deviations along each of two axes.
        let three = 3.0 * 2_f64.sqrt();
        let tilt_rad = mounted_deg.to_radians()
            + three * bias_rad_s * (1.0 / std::f64::consts::E + 0.5 * 5_f64.to_radians());
        // Until its first sample the slope is not compensated, and the first sample's noise is a
        // tilt too.
        let wrong_m_s2 = three * (bias_m_s2 + 0.03) + 9.81 * tilt_rad;
        let late_m = 0.5 * 9.81 * 5_f64.to_radians() * f64::powi(latency_s + 0.02, 2) * 2.0;
        let most_m = 12.0 * wrong_m_s2 / 600.0 + late_m;
        let worst_m = run.summary.position_error_max_m.unwrap();
        println!("{latency_s} s: {worst_m:.5} m of {most_m:.5}");
        assert!(worst_m < most_m, "{worst_m} {most_m}");
        let slid_j = run.summary.slip_energy_j.unwrap();
        assert!(slid_j < 1e-2, "{slid_j}");
    }
}

/// The oscillation of x and y about their means between two times, in metres.
fn swing_m(run: &Run, from_s: f64, to_s: f64) -> f64 {
    let rows = run.trace.records().iter();
    let rows: Vec<[f64; 2]> = rows
        .filter(|row| (from_s..to_s).contains(&row.t_s))
        .map(|row| [row.truth.pose.x_m, row.truth.pose.y_m])
        .collect();
    let swing = |axis: usize| {
        let values = || rows.iter().map(|row| row[axis]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    f64::hypot(swing(0), swing(1))
}

/// Both sensors, delays up to those of a slow network, fast and slow filters, soft and hard
/// springs: an accepted setting is stable after a push, and for a refused one the limit named in
/// the refusal is stable.
#[test]
fn imus_old_and_new_settle_or_are_refused_with_a_limit_that_settles() {
    let keys = |imu: &str, filter_s: f64, latency_s: f64, stiffness: f64, damping: f64| {
        format!(
            "[wheel_loop]\nlaw = 'passive'\npassive = {{ stiffness_n_m = {stiffness}, damping_n_s_m = {damping} }}\n[sensors.imu]\n\
             filter_s = {filter_s}\nlatency_s = {latency_s}\n{imu}[[faults]]\npush = {{ impulse_y_n_s = 3, from_s = 0.5, lasts_s = 0.2 }}\n"
        )
    };
    let settles = |keys: &str| {
        let run = run(keys);
        // An instability would grow in these three seconds too; noise and a random bias keep
        // shaking it, the cheap one by a millimetre.
        let (first, last) = (swing_m(&run, 0.5, 2.0), swing_m(&run, 3.5, 5.0));
        assert!(last < 0.8 * first || last < 2e-3, "{first} {last}: {keys}");
        last
    };
    let (mut runs, mut refusals) = (0, 0);
    for (imu, name) in [(TACTICAL, "tactical"), (CHEAP, "cheap")] {
        for (filter_s, latency_s, stiffness, damping) in [
            (1.0, 0.0, 600.0, 120.0),
            (1.0, 0.05, 600.0, 120.0),
            (1.0, 0.3, 600.0, 120.0),
            (0.3, 0.02, 600.0, 120.0),
            (0.1, 0.1, 600.0, 120.0),
            (0.05, 0.02, 600.0, 120.0),
            (5.0, 0.3, 600.0, 120.0),
            (1.0, 0.02, 1500.0, 60.0),
            (0.3, 0.1, 1500.0, 60.0),
            (0.2, 0.02, 100.0, 25.0),
        ] {
            let here =
                |filter_s: f64, stiffness: f64| keys(imu, filter_s, latency_s, stiffness, damping);
            match Plant::of_scenario(&scenario(&here(filter_s, stiffness)).unwrap()) {
                Ok(_) => {
                    runs += 1;
                    let last_m = settles(&here(filter_s, stiffness));
                    println!(
                        "{name} {filter_s} s, {latency_s} s old, {stiffness} N/m: {last_m:.5} m"
                    );
                }
                Err(Error::Control(ControlError::Unstable { what, most, .. })) => {
                    refusals += 1;
                    println!(
                        "{name} {filter_s} s, {latency_s} s old, {stiffness} N/m: {what} {most:.4}"
                    );
                    // Close to the limit nothing settles in time: nine tenths of it.
                    let held = 0.9 * most;
                    settles(&match what.contains("stiffness") {
                        true => here(filter_s, held),
                        false => here(1.0 / held, stiffness),
                    });
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(runs >= 8 && refusals >= 4, "{runs} {refusals}");
}

/// An unannounced ramp: the robot drives onto it and stops there. It has the effect of a slope on
/// the ramp, and nowhere else.
#[test]
fn a_ramp_that_nobody_announces_costs_what_a_slope_does_and_only_there() {
    let over = "[reference.line]\nto_x_m = 1.1\nto_y_m = 0\nspeed_m_s = 0.3\nheading = { constant_deg = 0 }\n";
    // 5 degrees, from 0.4 m on.
    let rise_m = 2.0 * 5_f64.to_radians().tan();
    let ramp = format!(
        "[[world.floor.ramps]]\nx_m = 0.4\ny_m = 0\nlength_m = 2\nwidth_m = 1\nrise_m = {rise_m}\n"
    );
    let scenario = |further: &str| {
        let text = format!(
            "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n{over}{SPRINGS}{ramp}{further}[run]\nduration_s = 9\nphysics_dt_s = 0.001\n"
        );
        Scenario::from_toml(&text, "ramp", ROBOTS).unwrap()
    };
    let run = |further: &str| Simulation::new(&scenario(further)).unwrap().run();
    let blind = run("");
    let mass_kg = load_robot(&scenario("")).unwrap().mass_kg();
    // The spring acts along the wheels' plane, by the error in the floor's.
    let off_m = mass_kg * 9.81 * 5_f64.to_radians().sin() / 600.0;
    let last = blind.trace.records().last().unwrap();
    let desired = last.desired.unwrap();
    let behind_m = desired.pose.x_m - last.truth.pose.x_m;
    println!("{behind_m} {off_m}");
    assert!((behind_m / off_m - 1.0).abs() < 5e-3, "{behind_m} {off_m}");
    let seeing = run("[sensors.imu]\n");
    let left_m = seeing.summary.position_error_final_m.unwrap();
    assert!(left_m < 1e-4, "{left_m}");
    let leans_rad = seeing
        .trace
        .records()
        .last()
        .unwrap()
        .imu
        .unwrap()
        .pitch_rad;
    assert!((leans_rad + 5_f64.to_radians()).abs() < 2e-3, "{leans_rad}");
    for run in [&blind, &seeing] {
        let rise_j = run.summary.storage_rise_j.unwrap();
        println!("{rise_j}");
        assert!(rise_j < 1e-3, "{rise_j}");
    }
}

/// Gravity is tilted relative to the floor's frame, and the gyroscope measures the ground's
/// rotation.
#[test]
fn on_rocking_ground_the_tilt_is_that_of_the_ground() {
    let run = run(&format!(
        "{SPRINGS}[[faults]]\ntilt = {{ amplitude_deg = 4, frequency_hz = 0.5, direction_deg = 90, ramp_s = 1 }}\n[sensors.imu]\n"
    ));
    for record in run.trace.records() {
        let since_s = record.t_s;
        let x = since_s.min(1.0);
        let built = x * x * (3.0 - 2.0 * x);
        let lean_rad = 4_f64.to_radians() * built * (std::f64::consts::PI * since_s).sin();
        // If the left goes down the robot rolls to the left, which is negative; the filter's
        // gyroscope has no lag, and the robot's own acceleration adds 20 mm/s^2 of gravity for a
        // fraction of the filter's second.
        let roll_rad = record.imu.unwrap().roll_rad;
        assert!(
            (roll_rad + lean_rad).abs() < 2e-3,
            "{since_s} {roll_rad} {lean_rad}"
        );
    }
    // The work of the ground is counted.
    let unexplained_j = run.summary.energy.unexplained_j.unwrap();
    assert!(unexplained_j.abs() < 1e-4, "{unexplained_j}");
    assert!(run.summary.position_error_max_m.unwrap() < 1e-3);
}

#[test]
fn gains_that_cannot_be_stable_are_refused_with_the_limit_that_holds() {
    let with = |keys: &str| {
        Plant::of_scenario(&scenario(keys).unwrap())
            .err()
            .unwrap()
            .to_string()
    };
    let late = with(
        "[sensors.pose]\nlatency_s = 0.1\n[wheel_loop]\nlaw = 'passive'\npassive = { stiffness_n_m = 9000, damping_n_s_m = 120 }\n",
    );
    assert!(
        late.contains("0.1 s old") && late.contains("it is stable"),
        "{late}"
    );
    let stiff = with("[wheel_loop]\nlaw = 'passive'\npassive = { damping_n_s_m = 90000 }\n");
    assert!(stiff.contains("wheels in the air"), "{stiff}");
    let fast = with(
        "[sensors.imu]\nfilter_s = 0.01\n[wheel_loop]\nlaw = 'passive'\npassive = { damping_n_s_m = 10 }\n",
    );
    assert!(fast.contains("tilt filter's time constant"), "{fast}");
    // Half a period of 0.01 s a sample: 50 Hz.
    let rocking = |hz: f64| {
        scenario(&format!(
            "[[faults]]\ntilt = {{ amplitude_deg = 4, frequency_hz = {hz} }}\n"
        ))
    };
    assert!(rocking(50.0).is_ok());
    let rocks = rocking(51.0).unwrap_err().to_string();
    assert!(rocks.contains("50 Hz"), "{rocks}");
    let other = scenario("[wheel_loop]\npassive = { stiffness_n_m = 600 }\n").unwrap_err();
    assert!(other.to_string().contains("wheel_loop.passive"), "{other}");
}

/// The guidance's gains are stiffness over damping, and the defaults follow from the mass.
#[test]
fn what_is_left_out_follows_from_mass_and_period() {
    let scenario = scenario("[wheel_loop]\nlaw = 'passive'\n").unwrap();
    let plant = Plant::of_scenario(&scenario).unwrap();
    let resolved = plant.resolved().scenario();
    let passive = resolved.wheel_loop.passive.as_ref().unwrap();
    let (k, d) = (
        passive.stiffness_n_m.unwrap(),
        passive.damping_n_s_m.unwrap(),
    );
    assert_eq!(resolved.guidance.position_gain_per_s, k / d);
    let own = PassiveTorqueSettings::for_robot(plant.robot(), 9.81, 1e-3, 0.01, 0.0).unwrap();
    assert_eq!((k, d), (own.stiffness_n_m, own.damping_n_s_m));
    // At most ten periods of ten milliseconds, for 11.4 kg and the wheels' inertia; a wheel in the
    // air lowers it somewhat.
    assert!((80.0..130.0).contains(&d), "{d}");
    // A controller's own rates work too.
    let mut plant = plant;
    plant.advance(WheelCommand::Rates(&[1.0; 4]), 0.5).unwrap();
    assert!(plant.truth().twist_in_body.vx_m_s > 0.02);
}

/// Equation (7) ignores which roller touches: 2 % sideways. The covariance of dead reckoning
/// includes that, and is not far above it.
#[test]
fn dead_reckoning_errs_as_its_covariance_says() {
    for twist in [
        "vx_m_s = 0.3",
        "vy_m_s = 0.3",
        "vx_m_s = 0.2\nvy_m_s = 0.2\nomega_rad_s = 0.3",
    ] {
        let text = format!(
            "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\n{twist}\n[run]\nduration_s = 3\n"
        );
        let scenario = Scenario::from_toml(&text, "odometry", ROBOTS).unwrap();
        let run = Simulation::new(&scenario).unwrap().run();
        let last = run.trace.records().last().unwrap();
        let (truth, reckoned) = (last.truth.pose, last.odometry_ideal);
        let p = Matrix3::from(last.reckoned.unwrap().pose_covariance);
        let off = truth.position_m() - reckoned.position_m();
        let e = Vector3::new(off.x, off.y, truth.heading_rad - reckoned.heading_rad);
        let weighed = e.dot(&(p.try_inverse().unwrap() * e));
        let sure_m = p.m11.max(p.m22).sqrt();
        println!("{twist:?}: off {e:?}, {weighed:.2}, sure to {sure_m:.4} m");
        // 16.3 is exceeded once in a thousand times.
        assert!(weighed < 16.3, "{weighed}");
        assert!(sure_m < 0.1 * run.summary.travelled_m, "{sure_m}");
    }
}

/// A robot with an arm and a lift, driven by `keys`, on the springs of `SPRINGS`.
fn jointed(keys: &str, dt_s: f64) -> Scenario {
    let text = format!(
        "[robot]\nfile = 'mecanum4_arm.urdf'\n[robot.wheels]\nrollers = 9\nroller_radius_m = 0.012\nroller_mass_kg = 0.01\n\
         damping_n_m_s = 1e-6\ngamma.x_deg = 45\n[reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0\n{SPRINGS}{keys}\
         [run]\nduration_s = 3\nphysics_dt_s = {dt_s}\n"
    );
    Scenario::from_toml(&text, "jointed", ROBOTS).unwrap()
}

/// All disturbances at once: the work of servos, a push, a payload and tilting ground is supply, in
/// every physics step.
#[test]
fn what_servos_pushes_payloads_and_leaning_ground_bring_is_supply() {
    let lift = "[robot.joints.lift]\nrole = 'driven'\nsetpoints = [{ t_s = 0.5, position_m = 0 }, { t_s = 2.5, position_m = 0.4 }]\n";
    let arm = "[robot.joints.arm]\nrole = 'driven'\nsetpoints = [{ t_s = 0.5, position_rad = 0 }, { t_s = 1.1, position_rad = 1.57 }]\n";
    let rest = "[[faults]]\npush = { impulse_y_n_s = 6, from_s = 1, lasts_s = 0.5 }\n[[faults]]\npayload = { mass_kg = 1, from_s = 2 }\n\
        [[faults]]\ntilt = { amplitude_deg = 3, frequency_hz = 0.7 }\n[sensors.imu]\n";
    for (name, keys, least_j) in [
        // 4 kg by 0.4 m.
        ("lift", lift.to_owned(), 4.0 * 9.81 * 0.4 - 0.1),
        ("arm", arm.to_owned(), 0.0),
        ("both, and all else", format!("{lift}{arm}{rest}"), 15.0),
    ] {
        for dt in [0.001, 0.0025] {
            let mut simulation = Simulation::new(&jointed(&keys, dt)).unwrap();
            let mut most_j = f64::NEG_INFINITY;
            while !simulation.is_done() {
                simulation.step();
                most_j = most_j.max(simulation.plant().storage().unwrap().rise_j);
            }
            let last = simulation.plant().storage().unwrap();
            let gained_j = last.supplied_j;
            println!("{name} at {dt} s: {last:?}");
            assert!(gained_j > least_j, "{name}: {gained_j} of {least_j}");
            // The balance of energy itself has an error of 1e-6 of the servos' work.
            assert!(
                most_j < 1e-6 * gained_j.max(1.0),
                "{name} {dt}: {most_j} of {gained_j}"
            );
        }
    }
}

/// The search for the equilibrium of a robot with joints uses frictionless ground; the floor's
/// properties are restored afterwards.
#[test]
fn patches_lie_under_robots_with_joints_too() {
    let arm = "[robot.joints.arm]\nrole = 'driven'\ntarget_rad = 0\n";
    let ice = "[[world.floor.patches]]\nx_m = 0.15\ny_m = 0.16\nlength_x_m = 0.1\nlength_y_m = 0.1\nfriction = 0.02\n";
    let mut simulation = Simulation::new(&jointed(&format!("{arm}{ice}"), 0.001)).unwrap();
    (0..30).for_each(|_| simulation.step());
    let last = simulation.trace().steps().last().unwrap();
    let frictions: Vec<f64> = last.1.iter().map(|wheel| wheel.friction).collect();
    assert_eq!(frictions, [0.02, 0.6, 0.6, 0.6]);
}

/// The passivity of each shipped scenario with a passive law is checked.
#[test]
fn every_shipped_scenario_of_the_passive_law_bounds_the_rise_of_its_storage() {
    let folder = std::path::Path::new(ROBOTS).join("../scenarios");
    let mut found = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        if text.contains("law = \"passive\"") {
            found += 1;
            let bound = text
                .lines()
                .find(|line| line.starts_with("storage_rise_j = { max = "));
            assert!(bound.is_some(), "{}", path.display());
        }
    }
    assert!(found >= 5, "{found}");
}

/// Between poses the filter uses the gyroscope's rotation, to rounding, whatever the wheels do: a
/// push that turns the robot on sliding wheels is measured.
#[test]
fn a_fusion_with_a_gyroscope_turns_as_the_gyroscope_says() {
    let run = |fusion: &str| {
        run(&format!(
            "[world.floor]\nfriction = 0.1\n[sensors.pose]\nrate_hz = 0.01\n[sensors.fusion]\n{fusion}\n[sensors.imu]\n\
             gyroscope = {{ noise = 0.01, bias = 0.002 }}\n[[faults]]\npush = {{ impulse_y_n_s = 12, x_m = 0.15, from_s = 0.5, lasts_s = 0.5 }}\n"
        ))
    };
    let gap = |run: &Run| {
        let mut turned_rad = 0.0;
        let mut apart = (0.0_f64, 0.0_f64);
        let mut last_s = 0.0;
        for record in run.trace.records() {
            turned_rad += record.imu.unwrap().rate_rad_s.z * (record.t_s - last_s);
            last_s = record.t_s;
            let seen_rad = record.seen_pose.heading_rad;
            apart.0 = apart.0.max((seen_rad - turned_rad).abs());
            apart.1 = apart
                .1
                .max((seen_rad - record.truth.pose.heading_rad).abs());
        }
        apart
    };
    let (by_gyroscope, off_rad) = gap(&run("gyroscope = true"));
    let (by_wheels, lost_rad) = gap(&run(""));
    println!("{by_gyroscope} {off_rad}, {by_wheels} {lost_rad}");
    assert!(by_gyroscope < 1e-12, "{by_gyroscope}");
    // Five seconds of a bias within three deviations, and a random walk of noise of 0.01 rad/s
    // sqrt(5 s 0.01 s).
    assert!(
        off_rad < 3.0 * (0.002 * 5.0 + 0.01 * 0.05_f64.sqrt()),
        "{off_rad}"
    );
    assert!(lost_rad > 2.0 * off_rad, "{lost_rad} {off_rad}");
}

#[test]
fn a_gyroscope_that_is_not_there_is_refused() {
    let refused = scenario("[sensors.fusion]\ngyroscope = true\n").unwrap_err();
    let refused = refused.to_string();
    assert!(refused.contains("[sensors.imu]"), "{refused}");
}

/// On a floor without friction a robot slides down the floor that leans more and more: from rest it
/// gains the integral of g sin(a(t)), with a(t) = A (3 x^2 - 2 x^3), x = t / T, the way a tilt is
/// built up. The gravity of a step is that of its middle, which errs by dt^2 / 24 g a'(T / 2): 3e-5
/// m/s; that of its beginning would by dt / 2 g sin(A), 25 mm/s.
#[test]
fn ground_that_begins_to_lean_pulls_as_in_the_middle_of_each_step() {
    const DT_S: f64 = 0.01;
    const AMPLITUDE_DEG: f64 = 30.0;
    const RAMP_S: f64 = 1.0;
    let text = format!(
        "robot.file = 'mecanum4.urdf'\ntwist.vx_m_s = 0\n[world.floor]\nfriction = 0\n\
         [[faults]]\ntilt = {{ amplitude_deg = {AMPLITUDE_DEG}, ramp_s = {RAMP_S} }}\n\
         [run]\nduration_s = {RAMP_S}\nphysics_dt_s = {DT_S}\ncontrol_dt_s = {DT_S}\n"
    );
    let scenario = Scenario::from_toml(&text, "tilt", ROBOTS).unwrap();
    let run = Simulation::new(&scenario).unwrap().run();
    let last = run.trace.records().last().unwrap();
    assert!(last.t_s > 0.9 * RAMP_S, "{}", last.t_s);
    // The sum of a thousand middles, exact to 1e-7 of it.
    let pull = |k: i32| {
        let x = (f64::from(k) + 0.5) / 1000.0 * last.t_s / RAMP_S;
        9.81 * (AMPLITUDE_DEG.to_radians() * x * x * (3.0 - 2.0 * x)).sin()
    };
    let expected_m_s = (0..1000).map(pull).sum::<f64>() * last.t_s / 1000.0;
    let found_m_s = last.truth.twist_in_body.vx_m_s;
    // The robot's motion on its contacts is some 0.1 mm/s.
    assert!(
        (found_m_s - expected_m_s).abs() < 1e-3,
        "{found_m_s} {expected_m_s}"
    );
}
