//! Frames of runs: which are kept, and how accurately.

use std::collections::HashMap;
use std::convert::Infallible;
use std::f64::consts::TAU;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ilon_formats::{
    Handedness, JointOptions, LoadOptions, LoadRobot, RoleOption, WheelOptions, link_tree,
};
use ilon_robot::{Pose, Robot, VisualMeshes};
use ilon_scene::{Description, Frame, Frames, Interpolation, Thinning, frames_of_run};
use ilon_trace::{Desired, Header, Record, Rows, Trace, WheelSample};

const PERIOD_S: f64 = 0.01;

fn robot() -> Robot {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/volksbot.urdf"
    );
    Robot::load(path).expect("a shipped robot")
}

/// Three seconds in which every wheel turns at 12 rad/s on its rollers 0, 1, 2, ... for half a
/// second each, spinning at 5 rad/s.
fn run(robot: &Robot, rows: usize) -> Trace {
    let header = Header {
        control_dt_s: PERIOD_S,
        ..Header::of_robot(robot)
    };
    let mut trace = Trace::with_capacity(header, rows);
    for row in 0..rows {
        let t_s = row as f64 * PERIOD_S;
        let mut record = Record {
            t_s,
            ..Record::default()
        };
        record.truth.pose = Pose {
            x_m: 1000.0 + t_s,
            y_m: -t_s,
            heading_rad: 2.0 * t_s,
        };
        record.truth.height_m = 0.01 * libm::sin(t_s);
        let wheel = |index: usize| {
            WheelSample {
                angle_rad: 12.0 * t_s,
                touching: index != 2 || t_s < 1.0,
                normal_force_n: 20.0 + t_s,
                force_x_n: -7.5,
                friction: 0.6,
                roller: (row / 50) as u32,
                roller_spin_rad_s: 5.0,
                ..WheelSample::default()
            }
            .steady()
        };
        let wheels: Vec<WheelSample> = (0..robot.wheels.len()).map(wheel).collect();
        trace.push(record, &wheels);
    }
    trace
}

/// The values of all columns, as a page reads them.
fn read(frames: &Frames) -> HashMap<&str, Vec<f64>> {
    let values = |column: &ilon_scene::Column| {
        let bytes = BASE64_STANDARD.decode(&column.data).expect("base64");
        match (column.data.is_empty(), column.scale) {
            (true, _) => vec![column.value.map_or(f64::NAN, f64::from); frames.count],
            (false, Some(scale)) => bytes
                .chunks_exact(2)
                .map(|b| i16::from_le_bytes([b[0], b[1]]))
                .map(|steps| {
                    if steps == i16::MIN {
                        f64::NAN
                    } else {
                        f64::from(steps) * f64::from(scale)
                    }
                })
                .collect(),
            (false, None) => bytes
                .chunks_exact(4)
                .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
                .collect(),
        }
    };
    let columns = frames.columns.iter().map(|c| (c.name.as_str(), values(c)));
    let columns: HashMap<&str, Vec<f64>> = columns.collect();
    assert!(columns.values().all(|values| values.len() == frames.count));
    columns
}

fn off_by_turns(a: f64, b: f64) -> f64 {
    (a - b - TAU * ((a - b) / TAU).round()).abs()
}

#[test]
fn a_frame_holds_what_its_row_holds() {
    let robot = robot();
    let trace = run(&robot, 300);
    let Ok(frames) = frames_of_run(
        &trace,
        &robot,
        Thinning {
            rate_hz: 50.0,
            most: 1000,
        },
    );
    // Every second row, and the last.
    assert_eq!(frames.count, 151);
    let columns = read(&frames);
    for (frame, &t_s) in columns["t"].iter().enumerate() {
        let row = (2 * frame).min(299);
        let is = |name: &str| columns[name][frame];
        assert!((t_s - row as f64 * PERIOD_S).abs() < 1e-6);
        let t_s = row as f64 * PERIOD_S;
        // At a distance of 1 km, f32 has a resolution of 0.06 mm.
        assert!((is("x") - 1000.0 - t_s).abs() < 4e-5 && (is("y") + t_s).abs() < 2e-7);
        // Half a step: a turn has 65534 of them, and the largest height 32767.
        assert!(off_by_turns(is("yaw"), 2.0 * t_s) < 1e-4);
        assert!(off_by_turns(is("w0_angle"), 12.0 * t_s) < 1e-4);
        assert!((is("z") - 0.01 * t_s.sin()).abs() < 1e-6);
        assert!((is("w1_normal") - 20.0 - t_s).abs() < 1e-3);
        assert_eq!(is("w1_roller"), (row / 50) as f64);
        assert_eq!(is("w1_force_x"), -7.5);
        // In the air there is no force.
        assert_eq!(is("w2_normal") == 0.0, t_s >= 1.0);
        assert!(is("want_x").is_nan());
        assert_eq!(is("ghost_x"), 0.0);
    }
}

#[test]
fn the_reference_of_a_point_ahead_is_drawn_where_it_wants_the_body() {
    let robot = robot();
    let mut trace = run(&robot, 0);
    trace.header.reference_point_m = [0.2, 0.0];
    let desired = Desired {
        pose: Pose {
            x_m: 1.0,
            y_m: 1.0,
            heading_rad: std::f64::consts::FRAC_PI_2,
        },
        ..Desired::default()
    };
    let record = Record {
        desired: Some(desired),
        ..Record::default()
    };
    trace.push(record, &vec![WheelSample::default(); robot.wheels.len()]);
    let Ok(frames) = frames_of_run(&trace, &robot, Thinning::default());
    let columns = read(&frames);
    // Looking along y, the body stands 0.2 m below the reference point, which lies ahead of it.
    assert!((columns["want_x"][0] - 1.0).abs() < 1e-6);
    assert!((columns["want_y"][0] - 0.8).abs() < 1e-6);
}

#[test]
fn without_their_angles_rollers_turn_while_they_touch() {
    let robot = robot();
    let trace = run(&robot, 300);
    let Ok(frames) = frames_of_run(&trace, &robot, Thinning::default());
    let columns = read(&frames);
    let end = frames.count - 1;
    for roller in 0..6 {
        // Half a second at 5 rad/s; the last row begins a period whose end is not recorded. Two
        // roundings of an angle.
        let turned = if roller == 5 {
            2.5 - 5.0 * PERIOD_S
        } else {
            2.5
        };
        let is = columns[format!("w0_r{roller}").as_str()][end];
        assert!(off_by_turns(is, turned) < 2e-4, "{is} of roller {roller}");
    }
    assert_eq!(columns["w0_r6"][end], 0.0);
    // A wheel in the air turns none.
    assert_eq!(columns["w2_r3"][end], 0.0);
}

/// A run with columns of roller angles.
struct WithAngles(Trace);

impl Rows for WithAngles {
    type Error = Infallible;

    fn header(&self) -> &Header {
        self.0.header()
    }

    fn row_count(&self) -> usize {
        self.0.row_count()
    }

    fn each_batch(&self, see: &mut dyn FnMut(&Trace)) -> Result<(), Infallible> {
        self.0.each_batch(see)
    }

    fn each_value(&self, signal: &str, see: &mut dyn FnMut(Option<f64>)) -> Result<(), Infallible> {
        if signal == "wheel1_roller4_angle_rad" {
            (0..self.row_count()).for_each(|row| see(Some(0.001 * row as f64)));
        }
        Ok(())
    }
}

#[test]
fn rollers_turn_by_their_angles_where_the_run_has_them() {
    let robot = robot();
    let run = WithAngles(run(&robot, 201));
    let Ok(frames) = frames_of_run(
        &run,
        &robot,
        Thinning {
            rate_hz: 25.0,
            most: 1000,
        },
    );
    let columns = read(&frames);
    for (frame, is) in columns["w1_r4"].iter().enumerate() {
        assert!(
            (is - 0.004 * frame as f64).abs() < 1e-4,
            "{is} of frame {frame}"
        );
    }
}

#[test]
fn a_long_run_has_no_more_frames_than_asked_for_and_ends_where_it_ends() {
    let robot = robot();
    for rows in [0, 1, 2, 99, 100, 101, 1000] {
        let Ok(frames) = frames_of_run(
            &run(&robot, rows),
            &robot,
            Thinning {
                rate_hz: 1e9,
                most: 100,
            },
        );
        assert!(
            frames.count <= 101,
            "{} frames of {rows} rows",
            frames.count
        );
        assert_eq!(frames.count == 0, rows == 0);
        let last_s = read(&frames)["t"].last().copied();
        let end_s = rows.checked_sub(1).map(|row| row as f64 * PERIOD_S);
        assert!(
            last_s
                .zip(end_s)
                .is_none_or(|(is, end)| (is - end).abs() < 1e-6)
        );
    }
}

#[test]
fn a_run_of_another_robot_shows_no_frame_that_would_not_fit() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let other = Robot::load(path).expect("a shipped robot");
    let Ok(frames) = frames_of_run(&run(&robot(), 100), &other, Thinning::default());
    assert_eq!(frames.count, 0);
}

#[test]
fn a_live_frame_has_the_values_of_the_columns_in_their_order() {
    let robot = robot();
    let frame = Frame {
        t_s: 1.5,
        ghost: Some(Pose {
            x_m: 0.25,
            ..Pose::default()
        }),
        ..Frame::at_rest(&robot)
    };
    let frames = Frames::live(&robot);
    assert_eq!(frames.count, 0);
    assert!(frames.columns.iter().all(|column| column.data.is_empty()));
    let values = frame.values();
    assert_eq!(values.len(), frames.columns.len());
    let at = |name: &str| {
        frames
            .columns
            .iter()
            .position(|c| c.name == name)
            .expect("a column")
    };
    assert_eq!(values[at("t")], 1.5);
    assert_eq!(values[at("ghost_x")], 0.25);
    assert!(values[at("want_yaw")].is_nan());
    assert_eq!(values[at("z")], robot.ride_height_m() as f32);
    assert_eq!(frames.columns[at("w0_angle")].kind, Interpolation::Angle);
    assert_eq!(frame.bytes().len(), 4 * values.len());
    assert_eq!(frame.bytes()[..4], 1.5f32.to_le_bytes());
}

#[test]
fn what_is_not_a_number_is_no_value_and_what_is_too_large_is_held() {
    let robot = robot();
    let frame = |height_m: f64| Frame {
        height_m,
        ..Frame::at_rest(&robot)
    };
    let frames = Frames::of(&robot, [0.1, f64::NAN, f64::INFINITY, -0.2].map(frame));
    let heights = &read(&frames)["z"];
    assert!((heights[0] - 0.1).abs() < 1e-5 && (heights[3] + 0.2).abs() < 1e-5);
    assert!(heights[1].is_nan() && heights[2].is_nan());
}

/// The mecanum4 with its arm on a servo.
fn with_an_arm() -> (Robot, String) {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4_arm.urdf"
    );
    let mut options = LoadOptions::default();
    options.wheels = Some(WheelOptions::new(9, Handedness::XDeg(45.0)));
    let arm = JointOptions {
        role: Some(RoleOption::Driven),
        ..JointOptions::default()
    };
    options.joints.insert("arm".to_owned(), arm);
    let text = std::fs::read_to_string(path).expect("a shipped robot");
    let loaded = Robot::from_urdf_str_with(&text, path, &options).expect("a shipped robot");
    (loaded.robot, text)
}

/// A body on a joint is a separate part, in the body frame, and a frame holds its joint's position.
#[test]
fn a_body_on_a_joint_is_drawn_where_its_joint_stands() {
    let (robot, text) = with_an_arm();
    let shown =
        Description::of_robot(&robot, link_tree(&text).as_ref(), &VisualMeshes::default()).robot;
    let [body] = &shown.bodies[..] else {
        panic!("{:?}", shown.bodies);
    };
    assert_eq!(
        (body.name.as_str(), body.parent, body.slides),
        ("arm", None, false)
    );
    // The middle of the arm's box at zero, and its joint's position.
    let place = |pose: [f32; 7]| [pose[0], pose[1], pose[2]].map(|x| (1e4 * x).round() / 1e4);
    assert_eq!(place(body.shapes[0].pose), [0.2, 0.0, 0.21]);
    assert_eq!(place(body.body_from_joint), [0.0, 0.0, 0.21]);
    // Chassis, mast and carriage; the carriage's lift is locked.
    assert_eq!(shown.chassis.len(), 3);
    let mut trace = Trace::with_capacity(Header::of_robot(&robot), 2);
    for row in 0..2 {
        let mut record = Record {
            t_s: row as f64 * PERIOD_S,
            ..Record::default()
        };
        record.joints[0].position = 0.75 * row as f64;
        trace.push(record, &[WheelSample::default(); 4]);
    }
    let frames = frames_of_run(&trace, &robot, Thinning::default()).expect("in memory");
    let values = read(&frames);
    assert!((values["j0"][1] - 0.75).abs() < 1e-4, "{:?}", values["j0"]);
    assert_eq!(values["j0"][0], 0.0);
}
