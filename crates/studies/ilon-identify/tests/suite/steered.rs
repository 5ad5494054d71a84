//! Robots whose tyres are steered: logs of wheel angles, steering angles and poses, by the exact
//! motion of a robot that rolls without sliding.

use std::fmt::Write;

use crate::support;

use ilon_identify::{Identified, Study, identify};
use ilon_sim::Error;
use support::assets;

/// A steered tyre: its axis, and how far to the left of it the hub lies.
struct Module {
    name: &'static str,
    at_m: [f64; 2],
    left_m: f64,
    radius_m: f64,
    /// What its steering angle is where the log reads 0, in degrees.
    zero_deg: f64,
}

/// Four modules in the corners of a rectangle.
fn corners(half_m: [f64; 2], radius_m: f64, left_m: f64) -> Vec<Module> {
    let names = ["front_left", "front_right", "rear_left", "rear_right"];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let module = |(name, [x, y]): (&'static str, [f64; 2])| Module {
        name,
        at_m: [x * half_m[0], y * half_m[1]],
        left_m,
        radius_m,
        zero_deg: 0.0,
    };
    names.into_iter().zip(signs).map(module).collect()
}

/// A robot that turns its modules without a break: it goes round in the body frame while it turns to
/// one side and the other.
fn swerves(t_s: f64) -> [f64; 3] {
    let (s, c) = libm::sincos(0.4 * t_s);
    [0.3 * c, 0.3 * s, 0.35 * libm::sin(0.55 * t_s)]
}

/// The table of a drive that follows a twist, by steps of a fifth of a millisecond.
fn table(modules: &[Module], twist: impl Fn(f64) -> [f64; 3], for_s: f64) -> String {
    const STEP_S: f64 = 2e-4;
    let mut csv = "t,x,y,heading".to_owned();
    for module in modules {
        let _ = write!(csv, ",{0}_drive,{0}_steer", module.name);
    }
    csv.push('\n');
    let angle_of = |module: &Module, [vx, vy, omega]: [f64; 3]| {
        let v = [vx - omega * module.at_m[1], vy + omega * module.at_m[0]];
        (libm::atan2(v[1], v[0]), libm::hypot(v[0], v[1]))
    };
    let [mut x, mut y, mut heading] = [0.0_f64; 3];
    let mut turned = vec![0.0; modules.len()];
    let first = twist(0.0);
    let mut angles: Vec<f64> = modules.iter().map(|of| angle_of(of, first).0).collect();
    let steps = (for_s / STEP_S).round() as usize;
    for step in 0..=steps {
        let t_s = step as f64 * STEP_S;
        if step % 50 == 0 {
            let _ = write!(csv, "{t_s:.3},{x:.9},{y:.9},{heading:.9}");
            for (module, (turned, angle)) in modules.iter().zip(turned.iter().zip(&angles)) {
                // Within half a turn, as encoders of modules read.
                let read = ilon_robot::wrap_angle(angle - module.zero_deg.to_radians());
                let _ = write!(csv, ",{turned:.9},{read:.9}");
            }
            csv.push('\n');
        }
        let [vx, vy, omega] = twist(t_s + 0.5 * STEP_S);
        let (s, c) = libm::sincos(heading + 0.5 * omega * STEP_S);
        x += (c * vx - s * vy) * STEP_S;
        y += (s * vx + c * vy) * STEP_S;
        heading += omega * STEP_S;
        let at_end = twist(t_s + STEP_S);
        for ((module, turned), angle) in modules.iter().zip(&mut turned).zip(&mut angles) {
            let speed_m_s = angle_of(module, [vx, vy, omega]).1;
            let swung = ilon_robot::wrap_angle(angle_of(module, at_end).0 - *angle);
            *angle += swung;
            // A hub to the left of its axis goes back where the axis turns to the left.
            let hub_m = speed_m_s * STEP_S - (omega * STEP_S + swung) * module.left_m;
            *turned += hub_m / module.radius_m;
        }
    }
    csv
}

/// The study of a table with these modules, for a robot of the project.
fn study(robot: &str, modules: &[Module], table: &str, more: &str) -> Result<Identified, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), table).expect("written");
    let robot = assets().join("robots").join(robot);
    let of = |kind: &str, joint: &dyn Fn(&Module) -> String| {
        let lines = modules.iter().map(|module| {
            let (name, column) = (joint(module), format!("{}_{kind}", module.name));
            format!("{name} = {{ column = \"{column}\", unit = \"rad\" }}\n")
        });
        lines.collect::<String>()
    };
    let drive = |module: &Module| match module.name == "drive" {
        true => module.name.to_owned(),
        false => format!("{}_drive", module.name),
    };
    let text = format!(
        "robot = {:?}\n[log]\ntime = {{ column = \"t\", unit = \"s\" }}\nx = {{ column = \"x\", unit = \"m\" }}\n\
         y = {{ column = \"y\", unit = \"m\" }}\nheading = {{ column = \"heading\", unit = \"rad\" }}\n[log.wheels]\n{}\n\
         [log.steering]\n{}\n[[runs]]\nfile = \"log.csv\"\n{more}",
        robot.display().to_string(),
        of("drive", &drive),
        of("steer", &|module| format!("{}_steer", module.name)),
    );
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).expect("written");
    identify(&Study::load(&path)?, &|_| ())
}

/// Whether a fitted parameter is what it should be; rows of 10 ms take steering angles as constant
/// in between, which here moves no value by 1e-4 of itself.
fn assert_is(found: &Identified, name: &str, expected: f64) {
    let value = found.parameters[name].value;
    let off = (value - expected).abs() / expected.abs();
    assert!(off < 2e-4, "{name} = {value} in place of {expected}");
}

/// Modules that stand 2 % further out on wheels 1.2 % smaller than the file says: the radius, and
/// the distance of the modules from the middle, hypot(0.25, 0.2) = 0.32016 m by the file.
#[test]
fn radius_and_lever_of_a_swerve_robot_are_found_from_its_steering_angles() {
    let modules = corners([0.255, 0.204], 0.0494, 0.0);
    let found = study(
        "swerve4.urdf",
        &modules,
        &table(&modules, swerves, 40.0),
        "",
    )
    .unwrap();
    assert_eq!(found.model, "radius and lever");
    assert_is(&found, "radius_m", 0.0494);
    assert_is(&found, "lever_m", 1.02 * libm::hypot(0.25, 0.2));
}

/// One of four modules was set 2.5 degrees off. Four angles move the robot in three ways alone: that
/// it is this one shows in what the wheels contradict each other.
#[test]
fn a_module_that_stands_otherwise_is_found_with_its_angle() {
    let mut modules = corners([0.25, 0.2], 0.05, 0.0);
    modules[2].zero_deg = 2.5;
    let log = table(&modules, swerves, 40.0);
    let more = "[[models]]\nname = \"angles\"\nfree = [\"radius_m\", \"steering_deg.*\"]\n";
    let found = study("swerve4.urdf", &modules, &log, more).unwrap();
    let of = |name: &str| found.parameters[&format!("steering_deg.{name}_drive")].value;
    let others = ["front_left", "front_right", "rear_right"].map(of);
    assert!((of("rear_left") - 2.5).abs() < 1e-2, "{found:?}");
    assert!(others.iter().all(|off| off.abs() < 1e-2), "{others:?}");
}

/// Wheels of four radii on modules with four zeros: by default both are found together, and the
/// lever is not drawn off its place by what one radius cannot explain.
#[test]
fn radii_and_zeros_of_modules_are_found_together_without_being_asked_for() {
    let mut modules = corners([0.25, 0.2], 0.05, 0.0);
    let truth = [(0.0505, 1.5), (0.0497, -0.8), (0.0502, 0.4), (0.0499, -1.1)];
    for (module, (radius_m, zero_deg)) in modules.iter_mut().zip(truth) {
        (module.radius_m, module.zero_deg) = (radius_m, zero_deg);
    }
    let log = table(&modules, swerves, 40.0);
    let found = study("swerve4.urdf", &modules, &log, "").unwrap();
    assert_is(&found, "lever_m", libm::hypot(0.25, 0.2));
    for (module, (radius_m, zero_deg)) in modules.iter().zip(truth) {
        let of = |what: &str| format!("{what}.{}_drive", module.name);
        assert_is(&found, &of("radius_m"), radius_m);
        let zero = found.parameters[&of("steering_deg")].value;
        assert!((zero - zero_deg).abs() < 1e-2, "{zero} {zero_deg}");
    }
}

/// Hubs 45 mm to the left of their axes, as in the file: what they turn by steering is no motion of
/// the robot, and nothing is left to fit.
#[test]
fn wheels_beside_their_steering_axes_do_not_move_the_robot_by_steering() {
    let robot = "offset4.urdf";
    let at_m = [0.25, 0.19];
    let radius_m = 0.09;
    let modules = corners(at_m, radius_m, 0.045);
    let found = study(robot, &modules, &table(&modules, swerves, 40.0), "").unwrap();
    assert_is(&found, "radius_m", radius_m);
    assert_is(&found, "lever_m", libm::hypot(at_m[0], at_m[1]));
}

/// A tricycle logs its steered wheel alone: radius, wheelbase (450 mm by the file) and the zero of
/// its steering follow, and the controller's keys with them.
#[test]
fn the_wheelbase_of_a_tricycle_is_found_without_a_column_of_the_wheels_behind() {
    let modules = [Module {
        name: "drive",
        at_m: [0.265, 0.0],
        left_m: 0.0,
        radius_m: 0.0605,
        zero_deg: 1.5,
    }];
    // About points of the axle at x = -0.2: its middle goes ahead.
    let twist = |t_s: f64| {
        let omega = 0.5 * libm::sin(0.5 * t_s);
        [0.3, 0.2 * omega, omega]
    };
    let found = study("tricycle.toml", &modules, &table(&modules, twist, 60.0), "").unwrap();
    assert_is(&found, "radius_m", 0.0605);
    assert_is(&found, "lever_m", 0.465);
    assert!((found.parameters["steering_deg.drive"].value - 1.5).abs() < 1e-2);
    let kind = found.controller.kind;
    assert_eq!(kind, Some(ilon_identify::outcome::ControllerKind::Tricycle));
}

/// A wheel that steers behind its axle is no `tricycle_controller`'s: its turns would be the other
/// way round.
#[test]
fn a_wheel_that_steers_behind_its_axle_has_no_such_controller() {
    let modules = [Module {
        name: "drive",
        at_m: [-0.65, 0.0],
        left_m: 0.0,
        radius_m: 0.06,
        zero_deg: 0.0,
    }];
    let twist = |t_s: f64| {
        let omega = 0.5 * libm::sin(0.5 * t_s);
        [0.3, 0.2 * omega, omega]
    };
    let log = table(&modules, twist, 60.0);
    let behind = "[set.robot.spec]\nwheels = [\n\
                  { name = \"drive\", position_m = [-0.65, 0], steered = true },\n\
                  { name = \"left\", position_m = [-0.2, 0.18], driven = false },\n\
                  { name = \"right\", position_m = [-0.2, -0.18], driven = false },\n]\n";
    let found = study("tricycle.toml", &modules, &log, behind).unwrap();
    assert_eq!(found.controller.kind, None);
    assert!(found.is_held);
    assert!(found.nominal.position_rms_m < 1e-4, "{:?}", found.nominal);
}

/// Steering that is logged otherwise than the file counts is refused with what to write.
#[test]
fn steering_that_counts_otherwise_is_told() {
    let modules = corners([0.25, 0.2], 0.05, 0.0);
    let log = table(&modules, swerves, 40.0);
    let changed = |change: &dyn Fn(f64) -> f64| {
        let mut lines = log.lines();
        let mut text = format!("{}\n", lines.next().unwrap());
        for line in lines {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            for steering in (5..cells.len()).step_by(2) {
                let read: f64 = cells[steering].parse().unwrap();
                cells[steering] = format!("{:.9}", change(read));
            }
            text += &format!("{}\n", cells.join(","));
        }
        match study("swerve4.urdf", &modules, &text, "") {
            Err(Error::Contents { message, help, .. }) => format!("{message}; {help}"),
            other => panic!("{other:?}"),
        }
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    for (change, says) in [
        (&(|read: f64| -read) as &dyn Fn(f64) -> f64, "`scale = -1`"),
        (&|read| read + quarter, "90 degrees too large"),
        (&|read| read - quarter, "90 degrees too small"),
    ] {
        let help = changed(change);
        assert!(help.contains(says), "{help}");
    }
}

/// What steering angles decide is not fitted where there are none.
#[test]
fn what_has_no_steering_angles_is_refused_for_a_steered_robot() {
    let modules = corners([0.25, 0.2], 0.05, 0.0);
    let log = table(&modules, swerves, 10.0);
    let simulate = "[simulate]\nfree = { \"contact.compliance\" = [0.0, 1.0] }\n";
    let refused = study("swerve4.urdf", &modules, &log, simulate).unwrap_err();
    assert!(refused.to_string().contains("steering angles"), "{refused}");
    let unnamed = log.replace("front_left_steer", "other");
    let refused = study("swerve4.urdf", &modules, &unnamed, "").unwrap_err();
    assert!(
        refused.to_string().contains("front_left_steer"),
        "{refused}"
    );
    let rollers = "[set.robot.wheels]\njoints = [\"front_left_drive\", \"front_right_drive\", \"rear_left_drive\", \
                   \"rear_right_drive\"]\nrollers = 10\ngamma.all_deg = 0\n\
                   [set.robot.joints.front_left_steer]\nrole = \"driven\"\n";
    let refused = study("omni4_steered.urdf", &modules[..1], &log, rollers).unwrap_err();
    assert!(refused.to_string().contains("has rollers"), "{refused}");
}

/// The columns of two wheels are exchanged, but not those of their steering: no wiring of modules
/// explains that, and what the wheels contradict each other by shows it.
#[test]
fn wheels_that_contradict_each_other_are_doubted() {
    let modules = corners([0.25, 0.2], 0.05, 0.0);
    let log = table(&modules, swerves, 40.0);
    let right = study("swerve4.urdf", &modules, &log, "").unwrap();
    assert!(right.doubts.is_empty(), "{:?}", right.doubts);
    let header = log.lines().next().unwrap();
    let exchanged = header
        .replace("front_left_drive", "other")
        .replace("front_right_drive", "front_left_drive")
        .replace("other", "front_right_drive");
    let found = study(
        "swerve4.urdf",
        &modules,
        &log.replace(header, &exchanged),
        "",
    )
    .unwrap();
    let doubts: Vec<&str> = found
        .doubts
        .iter()
        .map(|odd| &odd.doubt.message[..])
        .collect();
    assert!(
        doubts
            .iter()
            .any(|said| said.contains("contradict each other")),
        "{doubts:?}"
    );
}
