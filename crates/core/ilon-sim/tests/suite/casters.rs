//! Casters: how fast they turn over, that they stay at rest, when they shimmy, and what they leave
//! of a turn.

use ilon_sim::robot::Robot;
use ilon_sim::{Scenario, Simulation, load_robot};
use test_case::test_case;

use crate::support::Folder;
use crate::support::urdf::{ForkPart, Urdf, WheelPart};

/// A caster of trail d under a robot.
#[derive(Clone, Copy)]
struct Caster {
    trail_m: f64,
    width_m: f64,
    inertia_kg_m2: f64,
}

/// A robot of 20 kg on two driven tyres, and casters behind it on both sides. Three quarters of its
/// weight are on the driven tyres.
fn on_casters(caster: Caster) -> String {
    let mut urdf = Urdf::new(20.0, [-0.075, 0.0, 0.1]);
    for (name, y_m) in [("left", 0.2), ("right", -0.2)] {
        urdf = urdf.wheel(WheelPart {
            name,
            parent: "base_link",
            at_m: [0.0, y_m, 0.06],
            radius_m: 0.06,
            width_m: 0.03,
            is_driven: true,
        });
        let swivel = format!("{name}_caster_swivel");
        urdf = urdf.fork(ForkPart {
            name: &swivel,
            at_m: [-0.3, 0.75 * y_m, 0.08],
            mass_kg: 0.5,
            inertia_kg_m2: caster.inertia_kg_m2,
            is_steered: false,
        });
        urdf = urdf.wheel(WheelPart {
            name: &format!("{name}_caster_roll"),
            parent: &format!("{swivel}_fork"),
            at_m: [-caster.trail_m, 0.0, -0.04],
            radius_m: 0.04,
            width_m: caster.width_m,
            is_driven: false,
        });
    }
    urdf.text()
}

fn scenario(folder: &Folder, urdf: &str, lines: &str) -> Scenario {
    folder.write("small.urdf", urdf);
    let text = format!("robot.file = \"small.urdf\"\n{lines}\n");
    Scenario::from_toml(&text, "casters", folder.path("")).expect("a scenario")
}

/// A robot on wheels of 69 and 70 mm leans by 1 mm in 300 mm. Without friction its caster would
/// swing downhill before the run; the ground holds it where the file has it.
#[test]
fn the_caster_of_a_leaning_robot_begins_where_its_file_has_it() {
    let folder = Folder::new();
    let mut urdf = Urdf::new(20.0, [-0.03, 0.0, 0.1]);
    for (name, y_m, radius_m) in [("left", 0.15, 0.069), ("right", -0.15, 0.07)] {
        urdf = urdf.wheel(WheelPart {
            name,
            parent: "base_link",
            at_m: [0.0, y_m, 0.07],
            radius_m,
            width_m: 0.03,
            is_driven: true,
        });
    }
    urdf = urdf.fork(ForkPart {
        name: "rear_caster_swivel",
        at_m: [-0.12, 0.0, 0.06],
        mass_kg: 0.2,
        inertia_kg_m2: 1e-4,
        is_steered: false,
    });
    urdf = urdf.wheel(WheelPart {
        name: "rear_caster_roll",
        parent: "rear_caster_swivel_fork",
        at_m: [-0.025, 0.0, -0.03],
        radius_m: 0.03,
        width_m: 0.02,
        is_driven: false,
    });
    let scenario = scenario(&folder, &urdf.text(), "twist = {}\nrun.duration_s = 0.5");
    let run = Simulation::new(&scenario).expect("it stands").run();
    let swivel = joints(&load_robot(&scenario).expect("a robot"), "caster_swivel")[0];
    let record = &run.trace.records()[0];
    assert_eq!(record.joints[swivel].position, 0.0);
    // It leans: 3.3 mrad.
    assert!(record.truth.roll_rad.abs() > 2e-3, "{:?}", record.truth);
}

/// Indices of the joints whose names end so.
fn joints(robot: &Robot, ending: &str) -> Vec<usize> {
    let names = robot.joints.iter().map(|joint| joint.name.as_str());
    let found = names.enumerate().filter(|(_, name)| name.ends_with(ending));
    found.map(|(index, _)| index).collect()
}

/// A caster of trail d that stands at the angle a from where its wheel leads turns over by d a' = v
/// sin(a): within (d / v) ln(tan(a1/2) / tan(a0/2)) from a0 to a1.
///
/// Its wheel is a body that touches with the two ends of its width w, which scrub as it swivels. In
/// balance about the swivel both slide askew, by w / (2 d) more to the side than along: the wheel
/// goes aside by a' w^2 / (4 d), and the caster turns as one with the trail d + w^2 / (4 d) does.
#[test_case(0.04, 0.004)]
#[test_case(0.04, 0.02)]
#[test_case(0.025, 0.02)]
fn casters_turn_over_as_their_trail_says(trail_m: f64, width_m: f64) {
    let caster = Caster {
        trail_m,
        width_m,
        inertia_kg_m2: 3e-4,
    };
    // An arc sets the casters askew, and then it backs off.
    let lines = "twist = { vx_m_s = 0.3, omega_rad_s = 0.3, rest_s = 0, ramp_s = 0.2, schedule = [\
                 { from_s = 2, vx_m_s = -0.3, omega_rad_s = 0 }] }\nrun.duration_s = 5";
    let folder = Folder::new();
    let scenario = scenario(&folder, &on_casters(caster), lines);
    let swivels = joints(&load_robot(&scenario).expect("a robot"), "_swivel");
    let mut simulation = Simulation::new(&scenario).expect("it drives");
    // The way of the swivels while a goes from 30 to 150 degrees.
    let mut ways_m = [0.0; 2];
    while !simulation.is_done() {
        simulation.step();
        let world = simulation.world();
        let back_m_s = -world.robot().state().twist_in_body.vx_m_s;
        for (way_m, swivel) in ways_m.iter_mut().zip(&swivels) {
            let a_rad = world.robot().joint_positions()[*swivel].abs();
            if back_m_s > 0.0 && (30_f64.to_radians()..150_f64.to_radians()).contains(&a_rad) {
                *way_m += back_m_s * world.dt_s();
            }
        }
    }
    let tan = |deg: f64| f64::tan(0.5 * deg.to_radians());
    let longer_m = trail_m + width_m * width_m / (4.0 * trail_m);
    let expected_m = longer_m * f64::ln(tan(150.0) / tan(30.0));
    for way_m in ways_m {
        assert!(
            (way_m / expected_m - 1.0).abs() < 0.02,
            "{way_m} m, by hand {expected_m} m"
        );
    }
}

/// A caster that stands askew under a robot at rest has no reason to turn.
#[test]
fn casters_do_not_turn_at_rest() {
    let caster = Caster {
        trail_m: 0.04,
        width_m: 0.02,
        inertia_kg_m2: 3e-4,
    };
    let lines = "twist = { vx_m_s = 0.3, omega_rad_s = 0.6, rest_s = 0, ramp_s = 0.2, schedule = [\
                 { from_s = 2, vx_m_s = 0, omega_rad_s = 0 }] }\nrun.duration_s = 4";
    let folder = Folder::new();
    let scenario = scenario(&folder, &on_casters(caster), lines);
    let swivels = joints(&load_robot(&scenario).expect("a robot"), "_swivel");
    let mut simulation = Simulation::new(&scenario).expect("it drives");
    let mut at_rest = None;
    while !simulation.is_done() {
        simulation.step();
        if simulation.world().time_s() > 2.7 && at_rest.is_none() {
            at_rest = Some(simulation.world().robot().joint_positions().to_vec());
        }
    }
    let at_rest = at_rest.expect("it ran on");
    for swivel in swivels {
        let ended_rad = simulation.world().robot().joint_positions()[swivel];
        assert!(ended_rad.abs() > 0.3, "{ended_rad} rad: it stands askew");
        let turned_rad = ended_rad - at_rest[swivel];
        assert!(turned_rad.abs() < 1e-6, "{turned_rad} rad in 1.3 s");
    }
}

/// Fork, wheel and tread of a caster of trail e: I psi'' = -e k s, s' = v psi + e psi' - (v / l) s,
/// with s the shear of the tyre's three places and l its relaxation length. Without damping this
/// shimmies where the trail is shorter than l, at any speed (Routh: k e^2 I v / l < I k e v). Here
/// it falls by e in 50 ms, or grows by e in 90 ms until the tyre's grip ends: then k s = mu N, at 7
/// mrad in a shimmy of 24 Hz, and more as it slides.
#[test_case(0.015, false)]
#[test_case(0.06, true)]
fn a_caster_shimmies_where_its_trail_is_shorter_than_the_relaxation_length(
    relaxation_m: f64,
    shimmies: bool,
) {
    let caster = Caster {
        trail_m: 0.03,
        // Hardly any scrub, which holds a caster still.
        width_m: 0.002,
        inertia_kg_m2: 2e-3,
    };
    let lines = format!(
        "robot.tyres = {{ joints = [\"left\", \"right\"], free = [\"left_caster_roll\", \"right_caster_roll\"] }}\n\
         rollers.tread = {{ stiffness_n_m = 4e4, shear_damping_n_s_m = 0, relaxation_length_m = {relaxation_m} }}\n\
         robot.joints.left_caster_swivel.role = \"free\"\nrobot.joints.right_caster_swivel.role = \"free\"\n\
         twist = {{ vx_m_s = 1.5, rest_s = 0, ramp_s = 1 }}\nrun = {{ duration_s = 3.5, physics_dt_s = 5e-4 }}\n\
         faults = [{{ push = {{ impulse_y_n_s = 4, from_s = 1.5, lasts_s = 0.05 }} }}]"
    );
    let folder = Folder::new();
    let scenario = scenario(&folder, &on_casters(caster), &lines);
    let swivels = joints(&load_robot(&scenario).expect("a robot"), "_swivel");
    let mut simulation = Simulation::new(&scenario).expect("it drives");
    let mut largest_rad = 0.0_f64;
    while !simulation.is_done() {
        simulation.step();
        let world = simulation.world();
        if world.time_s() > 3.0 {
            let now = world.robot().joint_positions();
            largest_rad = swivels
                .iter()
                .fold(largest_rad, |most, at| most.max(now[*at].abs()));
        }
    }
    assert_eq!(largest_rad > 7e-3, shimmies, "{largest_rad} rad");
    assert!(shimmies || largest_rad < 1e-6, "{largest_rad} rad");
}
