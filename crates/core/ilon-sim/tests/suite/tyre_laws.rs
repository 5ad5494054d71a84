//! Closed forms of robots on tyres: circles of steered robots, and turns on casters.

use std::path::Path;

use ilon_sim::robot::Twist;
use ilon_sim::{Plant, Scenario, Simulation, WheelCommand};
use test_case::test_case;

use crate::support::Folder;
use crate::support::urdf::{ForkPart, Urdf, WheelPart};

fn written(folder: &Folder, urdf: Urdf, lines: &str) -> Scenario {
    folder.write("small.urdf", &urdf.text());
    let text = format!("robot.file = \"small.urdf\"\n{lines}\n");
    Scenario::from_toml(&text, "tyre_laws", folder.path("")).expect("a scenario")
}

/// Drives for some seconds at wheel rates that are reached within one, and returns the twist of the
/// body's origin then, and the positions of its joints.
fn driven(scenario: &Scenario, rates_rad_s: &[f64], time_s: f64) -> (Twist, Vec<f64>) {
    let mut plant = Plant::of_scenario(scenario).expect("it stands");
    let mut now = rates_rad_s.to_vec();
    for tick in 0..(100.0 * time_s) as usize {
        let share = (0.01 * tick as f64).min(1.0);
        for (now, rate) in now.iter_mut().zip(rates_rad_s) {
            *now = share * rate;
        }
        plant
            .advance(WheelCommand::Rates(&now), 0.01)
            .expect("it runs");
    }
    let positions = plant.world().robot().joint_positions().to_vec();
    (plant.truth().twist_in_body, positions)
}

/// The middle of a rear axle at this x, which does not move sideways, goes round on a radius of
/// v / omega. Returns it, and the share of the speed that goes sideways.
fn circle(twist: Twist, axle_x_m: f64) -> (f64, f64) {
    let aside_m_s = twist.vy_m_s + axle_x_m * twist.omega_rad_s;
    (twist.vx_m_s / twist.omega_rad_s, aside_m_s / twist.vx_m_s)
}

/// A tricycle whose wheel, l ahead of its axle, stands at s goes round on l / tan(s). Its servo
/// gives by some milliradians to what the tyre scrubs: s is where it stands.
#[test_case(0.15)]
#[test_case(-0.5)]
#[test_case(0.9)]
#[test_case(1.2)]
fn a_tricycle_goes_round_on_l_over_tan_s(steer_rad: f64) {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!(
        "robot.file = \"tricycle.urdf\"\ntwist = {{}}\nrun.duration_s = 4\n\
         [robot.joints.steer]\nrole = \"driven\"\nsetpoints = [{{ t_s = 0, position_rad = {steer_rad} }}]"
    );
    let scenario = Scenario::from_toml(&text, "circle", robots).expect("a scenario");
    let (twist, stands_rad) = driven(&scenario, &[4.0, 0.0, 0.0], 4.0);
    assert!((stands_rad[0] - steer_rad).abs() < 6e-3, "{stands_rad:?}");
    let (radius_m, aside) = circle(twist, -0.2);
    let expected_m = 0.45 / stands_rad[0].tan();
    assert!(
        (radius_m / expected_m - 1.0).abs() < 1e-3,
        "{radius_m} m, by hand {expected_m} m"
    );
    assert!(aside.abs() < 1e-3, "{aside}");
}

/// By Ackermann's rule the axles of all wheels meet in one point: of two steered wheels the inner
/// one stands at atan(l / (R - w / 2)), the outer one at atan(l / (R + w / 2)). Driven by its rear
/// wheels at their shares, the robot goes round on R.
#[test_case(0.6)]
#[test_case(1.5)]
#[test_case(-4.0)]
fn ackermann_steering_goes_round_where_the_axles_meet(radius_m: f64) {
    let (length_m, half_m, wheel_m) = (0.5, 0.2, 0.08);
    let mut urdf = Urdf::new(20.0, [0.25, 0.0, 0.12]);
    let mut lines = "twist = {}\nrun.duration_s = 4\nrobot.tyres = {}\n".to_owned();
    let mut rates = Vec::new();
    for (side, y_m) in [("left", half_m), ("right", -half_m)] {
        let wheel = |name, parent, at_m, is_driven| WheelPart {
            name,
            parent,
            at_m,
            radius_m: wheel_m,
            width_m: 0.03,
            is_driven,
        };
        let knuckle = format!("{side}_steer");
        urdf = urdf.fork(ForkPart {
            name: &knuckle,
            at_m: [length_m, y_m, wheel_m],
            mass_kg: 0.5,
            inertia_kg_m2: 1e-3,
            is_steered: true,
        });
        let (front, rear) = (format!("front_{side}"), format!("rear_{side}"));
        let on = format!("{knuckle}_fork");
        urdf = urdf.wheel(wheel(&front, &on, [0.0; 3], false));
        urdf = urdf.wheel(wheel(&rear, "base_link", [0.0, y_m, wheel_m], true));
        let steer_rad = f64::atan(length_m / (radius_m - y_m));
        lines += &format!(
            "[robot.joints.{knuckle}]\nrole = \"driven\"\nstiffness_n_m_rad = 1e4\n\
             setpoints = [{{ t_s = 0, position_rad = {steer_rad} }}]\n"
        );
        // 0.4 m/s in the middle of the rear axle.
        rates.extend([0.0, 0.4 * (1.0 - y_m / radius_m) / wheel_m]);
    }
    let folder = Folder::new();
    // Servos so stiff that they give by 30 microradians to what the tyres scrub.
    let (twist, _) = driven(&written(&folder, urdf, &lines), &rates, 4.0);
    let (round_m, aside) = circle(twist, 0.0);
    assert!(
        (round_m / radius_m - 1.0).abs() < 1e-3,
        "{round_m} m where {radius_m} m is expected"
    );
    assert!(aside.abs() < 1e-3, "{aside}");
}

/// A robot of 400 kg whose casters carry 48 % turns as commanded: from rest, with casters that
/// stand ahead, and then steadily. What their wheels scrub with their ends, mu N w / 2, they bring
/// to the driven tyres as a pull of mu N w / (2 d) along the line to the middle of the turn, here
/// 0.4 of the grip of these: 3 % are lost.
#[test]
fn a_heavy_robot_turns_on_its_casters() {
    let (behind_m, trail_m, share) = (0.6, 0.05, 0.48);
    let mut urdf = Urdf::new(400.0, [-share * behind_m, 0.0, 0.3]);
    for (side, y_m) in [("left", 0.3), ("right", -0.3)] {
        urdf = urdf.wheel(WheelPart {
            name: side,
            parent: "base_link",
            at_m: [0.0, y_m, 0.1],
            radius_m: 0.1,
            width_m: 0.05,
            is_driven: true,
        });
        let swivel = format!("{side}_caster_swivel");
        urdf = urdf.fork(ForkPart {
            name: &swivel,
            at_m: [-behind_m, y_m, 0.15],
            mass_kg: 2.0,
            inertia_kg_m2: 5e-3,
            is_steered: false,
        });
        urdf = urdf.wheel(WheelPart {
            name: &format!("{side}_caster_roll"),
            parent: &format!("{swivel}_fork"),
            at_m: [-trail_m, 0.0, -0.075],
            radius_m: 0.075,
            width_m: 0.04,
            is_driven: false,
        });
    }
    let lines = "twist = { omega_rad_s = 0.5, rest_s = 0, ramp_s = 1 }\nrun.duration_s = 7";
    let folder = Folder::new();
    let mut simulation = Simulation::new(&written(&folder, urdf, lines)).expect("it drives");
    let mut turned_rad = 0.0;
    while !simulation.is_done() {
        simulation.step();
        let world = simulation.world();
        turned_rad += world.robot().state().twist_in_body.omega_rad_s * world.dt_s();
    }
    let support = simulation.world().robot().support();
    let carried = support.chassis_n / (support.chassis_n + support.wheels_n);
    assert!((carried - 0.48).abs() < 0.02, "casters carry {carried}");
    let asked_rad = 0.5 * (7.0 - 0.5);
    assert!(
        (0.95..1.01).contains(&(turned_rad / asked_rad)),
        "{turned_rad} of {asked_rad} rad"
    );
    let omega_rad_s = simulation.world().robot().state().twist_in_body.omega_rad_s;
    assert!((0.95..1.01).contains(&(omega_rad_s / 0.5)), "{omega_rad_s}");
}
