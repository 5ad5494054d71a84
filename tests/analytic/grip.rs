//! The grip limit: wheels with growing torque begin to slide at the torque given by mu g and the
//! geometry.
//!
//! Torques grow equally on all four wheels of robot A, from rest. A contact can push only along its
//! roller's axis, which is at delta_eff from the hub axis on the ground: tan delta_eff = tan delta
//! cos phi, with phi the roller's angle from straight down. To accelerate at a along the hub axes
//! each wheel pushes with m a / (4 cos delta_eff), across them with m a / (4 sin delta_eff).
//! Meanwhile the leading wheels are unloaded: the loads' moment about the ground balances m a h_e,
//! with h_e the height of the centre of mass including the wheels' spin, m a h_e = m a h + sum I
//! q'' and q'' = a / rho in either direction. The leading wheel slides first. Sideways the contacts
//! have moved along the hub axes by e = a_ring tan(phi) tan(gamma) towards the leading side. So it
//! slides at
//!
//! a = mu g sin(delta_eff) / (1 + 2 mu sin(delta_eff) h_e / l) ahead, with l the wheels' distance,
//! and at a = mu g cos(delta_eff) (1 - 2 e / w) / (1 + 2 mu cos(delta_eff) h_e / w) sideways, with
//! w the track.

use ilon::control::Kinematics;
use ilon::robot::{Robot, Twist};
use ilon::simulate::{Commanded, Controller, Moment, Simulation};
use ilon::trace::Trace;
use ilon_formats::LoadRobot;

const FRICTION: f64 = 0.3;
const G_M_S2: f64 = 9.81;
const DT_S: f64 = 0.002;

/// Torques of equal size that grow from 0.2 s on.
struct GrowingTorque {
    signs: Vec<f64>,
    n_m_per_s: f64,
}

impl Controller for GrowingTorque {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        let torque_n_m = self.n_m_per_s * (now.t_s - 0.2).max(0.0);
        for (wheel, sign) in wheels.iter_mut().zip(&self.signs) {
            *wheel = sign * torque_n_m;
        }
        Commanded::Torques
    }
}

/// A shipped robot that accelerates in a direction with growing torque.
fn pulling(file: &str, direction: Twist) -> (Robot, Trace) {
    let path = format!("{}/assets/robots/{file}.urdf", env!("CARGO_MANIFEST_DIR"));
    let text = format!(
        "[robot]\nfile = \"{path}\"\nroller_bodies = \"near\"\n[world.floor]\nfriction = {FRICTION}\n\
         [twist]\nvx_m_s = 0\n[run]\nduration_s = 0.7\ncontrol_dt_s = {DT_S}\n"
    );
    let scenario = ilon::Scenario::from_toml(&text, "pulling", ".").expect("a scenario");
    let robot = Robot::load(&path).expect("a shipped robot");
    let mut signs = vec![0.0; robot.wheels.len()];
    let kinematics = Kinematics::new(&robot).expect("a mecanum robot");
    kinematics.wheel_rates(direction, &mut signs);
    signs.iter_mut().for_each(|sign| *sign = sign.signum());
    let controller = GrowingTorque {
        signs,
        n_m_per_s: 1.0,
    };
    let run = Simulation::with_controller(&scenario, controller).expect("it stands");
    (robot, run.run().trace)
}

/// The first step after which a wheel stays on the edge of its friction cone for three steps, and
/// that wheel.
fn onset(trace: &Trace) -> (usize, usize) {
    let on_edge = |step: usize, wheel: usize| {
        let used = trace.wheels_at(step)[wheel].friction_used();
        used.is_some_and(|used| used > 0.999)
    };
    let wheels = 0..trace.wheel_count();
    (0..trace.records().len() - 3)
        .find_map(|step| {
            let mut wheels = wheels.clone();
            let first = wheels.find(|&wheel| (step..step + 3).all(|step| on_edge(step, wheel)));
            first.map(|wheel| (step, wheel))
        })
        .expect("some wheel slides in the end")
}

/// The robot's true acceleration around a step, along a direction in the body frame, over 10 ms on
/// either side.
fn acceleration_m_s2(trace: &Trace, step: usize, direction: Twist) -> f64 {
    let speed = |step: usize| {
        let v = trace.records()[step].truth.twist_in_body;
        v.vx_m_s * direction.vx_m_s + v.vy_m_s * direction.vy_m_s
    };
    (speed(step + 5) - speed(step - 5)) / (10.0 * DT_S)
}

/// Mass in kg, and the height of the centre of mass including the wheels' spin, in metres.
fn mass_and_height(robot: &Robot) -> (f64, f64) {
    let chassis = &robot.chassis.mass;
    let mut mass_kg = chassis.mass_kg;
    let mut moment_kg_m = chassis.mass_kg * chassis.center_of_mass_m.z;
    let mut spin_kg_m = 0.0;
    for wheel in &robot.wheels {
        let rollers_kg: f64 = wheel.rollers.iter().map(|r| r.mass_kg).sum();
        let of_wheel_kg = wheel.hub.mass_kg + rollers_kg;
        mass_kg += of_wheel_kg;
        moment_kg_m += of_wheel_kg * wheel.position_m().z;
        // A roller about the hub axis: its mass at the ring. Its own inertia, below a hundredth of
        // that, is neglected.
        let ring = wheel.rollers.iter();
        let ring: f64 = ring
            .map(|r| r.mass_kg * r.center_in_hub_m.xy().norm_squared())
            .sum();
        spin_kg_m += (wheel.hub.inertia_kg_m2[(2, 2)] + ring) / wheel.radius_m;
    }
    (mass_kg, (moment_kg_m + spin_kg_m) / mass_kg)
}

/// The angle phi of a wheel's roller in contact from straight down: robot A's nine rollers are
/// 40 deg apart, one straight down at wheel angle zero.
fn phi_rad(angle_rad: f64) -> f64 {
    let pitch_rad = std::f64::consts::TAU / 9.0;
    angle_rad - pitch_rad * (angle_rad / pitch_rad).round()
}

#[test]
fn hard_acceleration_begins_to_slide_where_mu_g_and_the_geometry_say() {
    for (name, direction, lever_m) in [
        ("ahead", Twist::new(1.0, 0.0, 0.0), 0.30),
        ("sideways", Twist::new(0.0, 1.0, 0.0), 0.32),
    ] {
        let (robot, trace) = pulling("mecanum4", direction);
        let (step, wheel) = onset(&trace);
        let measured = acceleration_m_s2(&trace, step, direction);

        let (_, h_e) = mass_and_height(&robot);
        let phi = phi_rad(trace.wheels_at(step)[wheel].angle_rad);
        let delta_eff = phi.cos().atan(); // tan delta = 1
        let is_ahead = direction.vx_m_s > 0.0;
        let along = if is_ahead {
            delta_eff.sin()
        } else {
            delta_eff.cos()
        };
        // Sideways all contacts move along the hub axes by the same e; towards the leading wheels
        // this unloads them further. The recorded contact place has the sign.
        let e_m = if is_ahead {
            0.0
        } else {
            trace.wheels_at(step)[wheel].contact_y_m - robot.wheels[wheel].position_m().y
        };
        // mu N = m a / (4 along), N = m (g (1/2 - e/lever) - a h_e / lever) / 2.
        let predicted = FRICTION * G_M_S2 * along * (1.0 - 2.0 * e_m / lever_m)
            / (1.0 + 2.0 * along * FRICTION * h_e / lever_m);
        println!(
            "{name}: slides from {measured:.3} m/s^2 on, derived {predicted:.3}, phi {:.1} deg; mu g = {:.3}",
            phi.to_degrees(),
            FRICTION * G_M_S2
        );
        // Neglected: the rollers' own inertia (0.3 %), bearings, and the torque's growth within the
        // 20 ms over which the acceleration is taken.
        assert!((measured / predicted - 1.0).abs() < 0.03, "{name}");
        // The leading wheels slide first: the front ones ahead, the left ones sideways.
        let place = robot.wheels[wheel].position_m();
        assert!(if is_ahead {
            place.x > 0.0
        } else {
            place.y > 0.0
        });
    }
}

#[test]
fn with_a_payload_over_one_corner_the_opposite_wheel_slides_first_and_much_sooner() {
    let ahead = Twist::new(1.0, 0.0, 0.0);
    let sliding_torque_n_m = |file: &str| {
        let (robot, trace) = pulling(file, ahead);
        let (step, wheel) = onset(&trace);
        let at = trace.wheels_at(step)[wheel];
        println!(
            "{file}: {} slides at {:.3} N m, {:.2} m/s^2, under {:.1} N",
            robot.wheels[wheel].name,
            at.torque_n_m,
            acceleration_m_s2(&trace, step, ahead),
            at.normal_force_n
        );
        (robot, wheel, trace, step)
    };
    let (_, _, centred, centred_step) = sliding_torque_n_m("mecanum4");
    let (robot, wheel, loaded, loaded_step) = sliding_torque_n_m("mecanum4_payload");
    // The payload is over the rear left wheel.
    assert_eq!(robot.wheels[wheel].name, "front_right");

    // Loads by statics with equal contact stiffness: N = m/4 (g (1 + x_c x / X^2 + y_c y / Y^2) - 2
    // a h_e / l) for the front right wheel, with (x_c, y_c) the centre of mass and (X, Y) half of
    // the wheels' distances. Its grip limits its torque.
    let (mass_kg, h_e) = mass_and_height(&robot);
    let chassis = &robot.chassis.mass;
    let c = chassis.center_of_mass_m * chassis.mass_kg / mass_kg;
    let a = acceleration_m_s2(&loaded, loaded_step, ahead);
    let share = 1.0 + c.x / 0.15 - c.y / 0.16;
    let load_n = mass_kg / 4.0 * (G_M_S2 * share - 2.0 * a * h_e / 0.30);
    let measured_n = loaded.wheels_at(loaded_step)[wheel].normal_force_n;
    println!("load of the front right wheel {measured_n:.1} N, by statics {load_n:.1} N");
    // Four supports on a floor: statics leaves one unknown, the load on the diagonals. The solver's
    // choice changes a load by several per cent.
    assert!((measured_n / load_n - 1.0).abs() < 0.15);
    let slower = a / acceleration_m_s2(&centred, centred_step, ahead);
    assert!((0.5..0.75).contains(&slower), "{slower}");
}
