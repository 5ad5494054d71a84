//! The motion of a scene: one instant as [`Frame`], and many as [`Frames`], in compact columns.

use std::f64::consts::{PI, TAU};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ilon_robot::{Pose, Robot};
use serde::{Deserialize, Serialize};

/// One instant of a run. Vectors and poses in the world are along the world's axes, on the floor's
/// plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time in seconds.
    pub t_s: f64,
    /// Pose of the body frame.
    pub pose: Pose,
    /// Height of its origin above the floor's plane, in metres.
    pub height_m: f64,
    /// Its roll, in radians.
    pub roll_rad: f64,
    /// Its pitch, in radians.
    pub pitch_rad: f64,
    /// Its pose by ideal kinematics: dead reckoning by Indiveri 2009, eq. (7), from the real wheel
    /// angles.
    pub ghost: Option<Pose>,
    /// The reference pose of the body frame.
    pub wanted: Option<Pose>,
    /// The wheels, in the robot's order.
    pub wheels: Vec<WheelFrame>,
    /// Free bodies, in the order of [`crate::Description::bodies`]: the position of the centre in
    /// metres, and roll, pitch and heading in radians.
    pub bodies: Vec<[f64; 6]>,
    /// The position of each joint between bodies, in rad or m.
    pub joints: Vec<f64>,
}

/// A wheel at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelFrame {
    /// The wheel's angle in radians.
    pub angle_rad: f64,
    /// Its contact with the ground, if any.
    pub contact: Option<Contact>,
    /// Index of the roller in contact.
    pub roller: usize,
    /// The angles of all its rollers about their axes, in radians.
    pub roller_angles_rad: Vec<f64>,
}

/// A contact with the ground, along the body's axes projected to the horizontal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Its position from the body frame's origin, in metres.
    pub place_m: [f64; 2],
    /// Normal force on the wheel, in N.
    pub normal_force_n: f64,
    /// Tangential force of the ground on the wheel, in N.
    pub force_n: [f64; 2],
    /// Velocity of the roller's contact point over the ground, in m/s.
    pub slip_m_s: [f64; 2],
    /// Friction coefficient.
    pub friction: f64,
}

/// Interpolation of a column's values between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Linear.
    Line,
    /// Along the circle, the shorter way round.
    Angle,
    /// None: the value changes at the next frame.
    Step,
}

/// One quantity over time: one value for all frames, or one per frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Column {
    /// Its name: `x`, `w0_angle`, `w0_r3`.
    pub name: String,
    /// Its interpolation between frames.
    pub kind: Interpolation,
    /// The value at every frame, if `data` is empty; `None` for no value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f32>,
    /// The unit of one step of `data`, if that is i16, where -32768 stands for no value. If `None`,
    /// `data` is f32.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f32>,
    /// The values, little-endian, in base64.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub data: String,
}

/// Many frames of one robot, one column per quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Frames {
    /// The number of frames.
    pub count: usize,
    /// The columns, time first.
    pub columns: Vec<Column>,
}

/// Storage of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Store {
    /// As f32: positions that may be far away.
    Exact,
    /// As i16: 1/32767 of the largest value.
    Small,
}

impl Frame {
    /// A robot at rest at the world's origin on a level floor, its joints at their start positions.
    pub fn at_rest(robot: &Robot) -> Self {
        let joints = robot.start_positions();
        let posed = robot.posed(&joints);
        let standing = posed.standing_pose();
        Self {
            height_m: standing.map_or_else(|| posed.ride_height_m(), |s| s.height_m),
            roll_rad: standing.map_or(0.0, |s| s.roll_rad),
            pitch_rad: standing.map_or(0.0, |s| s.pitch_rad),
            wheels: robot
                .wheels
                .iter()
                .map(|wheel| WheelFrame {
                    roller_angles_rad: vec![0.0; wheel.rollers.len()],
                    ..WheelFrame::default()
                })
                .collect(),
            joints,
            ..Self::default()
        }
    }

    /// Its values in the order of [`Frames::columns`], for a robot with as many wheels and rollers;
    /// NaN for no value.
    pub fn values(&self) -> Vec<f32> {
        let pose =
            |pose: Option<Pose>| pose.map_or([f64::NAN; 3], |p| [p.x_m, p.y_m, p.heading_rad]);
        let Self {
            t_s,
            pose: at,
            height_m,
            roll_rad,
            pitch_rad,
            ghost,
            wanted,
            wheels,
            bodies,
            joints,
        } = self;
        let mut values = vec![
            *t_s,
            at.x_m,
            at.y_m,
            *height_m,
            *roll_rad,
            *pitch_rad,
            at.heading_rad,
        ];
        values.extend(pose(*ghost));
        values.extend(pose(*wanted));
        for wheel in wheels {
            let contact = wheel.contact.unwrap_or_default();
            let [x, y] = contact.place_m;
            let [force_x, force_y] = contact.force_n;
            let [slip_x, slip_y] = contact.slip_m_s;
            values.extend([wheel.angle_rad, x, y, contact.normal_force_n]);
            values.extend([force_x, force_y, slip_x, slip_y, contact.friction]);
            values.push(wheel.roller as f64);
            values.extend(&wheel.roller_angles_rad);
        }
        values.extend(bodies.iter().flatten());
        values.extend(joints);
        values.into_iter().map(|x| x as f32).collect()
    }

    /// [`Frame::values`] as f32, little-endian: a message for the page's `push`.
    pub fn bytes(&self) -> Vec<u8> {
        self.values().iter().flat_map(|x| x.to_le_bytes()).collect()
    }
}

impl Frames {
    /// A robot at rest.
    pub fn at_rest(robot: &Robot) -> Self {
        Self::of(robot, [Frame::at_rest(robot)])
    }

    /// No frames yet: they arrive one by one, as [`Frame::bytes`].
    pub fn live(robot: &Robot) -> Self {
        Self::of(robot, [])
    }

    /// Frames of a robot without free bodies, in order of time. A frame with another number of
    /// wheels, rollers or joints is left out.
    pub fn of(robot: &Robot, frames: impl IntoIterator<Item = Frame>) -> Self {
        Self::beside(robot, 0, frames)
    }

    /// As [`Frames::of`], with free bodies; a frame with another number of them is also left out.
    pub fn beside(robot: &Robot, bodies: usize, frames: impl IntoIterator<Item = Frame>) -> Self {
        let rollers: Vec<usize> = robot.wheels.iter().map(|w| w.rollers.len()).collect();
        let names = names(&rollers, bodies, robot.joints.len());
        let mut values: Vec<Vec<f32>> = vec![Vec::new(); names.len()];
        let mut count = 0;
        for frame in frames {
            let row = frame.values();
            if row.len() == names.len() {
                count += 1;
                values.iter_mut().zip(row).for_each(|(v, x)| v.push(x));
            }
        }
        let columns = names.into_iter().zip(values);
        Self {
            count,
            columns: columns
                .map(|((name, kind, store), values)| column(name, kind, store, &values))
                .collect(),
        }
    }
}

/// All columns of a robot with these numbers of rollers per wheel, of free bodies, and of joints
/// between its bodies.
fn names(rollers: &[usize], bodies: usize, joints: usize) -> Vec<(String, Interpolation, Store)> {
    use Interpolation::{Angle, Line, Step};
    use Store::{Exact, Small};
    // After the time the pose of the body; free bodies have the same columns.
    let of_body = [
        ("t", Line, Exact),
        ("x", Line, Exact),
        ("y", Line, Exact),
        ("z", Line, Small),
        ("roll", Angle, Small),
        ("pitch", Angle, Small),
        ("yaw", Angle, Small),
        ("ghost_x", Line, Exact),
        ("ghost_y", Line, Exact),
        ("ghost_yaw", Angle, Small),
        ("want_x", Line, Exact),
        ("want_y", Line, Exact),
        ("want_yaw", Angle, Small),
    ];
    let of_wheel = [
        ("angle", Angle),
        // Without contact the values are zero: interpolation would draw a contact under the robot's
        // centre.
        ("contact_x", Step),
        ("contact_y", Step),
        ("normal", Step),
        ("force_x", Step),
        ("force_y", Step),
        ("slip_x", Step),
        ("slip_y", Step),
        ("friction", Step),
        ("roller", Step),
    ];
    let mut names: Vec<(String, Interpolation, Store)> = of_body
        .iter()
        .map(|&(name, kind, store)| (name.to_owned(), kind, store))
        .collect();
    for (wheel, &rollers) in rollers.iter().enumerate() {
        names.extend(of_wheel.map(|(name, kind)| (format!("w{wheel}_{name}"), kind, Small)));
        names.extend((0..rollers).map(|r| (format!("w{wheel}_r{r}"), Angle, Small)));
    }
    for body in 0..bodies {
        let of_free = of_body[1..7].iter();
        names.extend(of_free.map(|&(name, kind, store)| (format!("b{body}_{name}"), kind, store)));
    }
    names.extend((0..joints).map(|joint| (format!("j{joint}"), Line, Small)));
    names
}

fn column(name: String, kind: Interpolation, store: Store, values: &[f32]) -> Column {
    let mut column = Column {
        name,
        kind,
        value: None,
        scale: None,
        data: String::new(),
    };
    let Some(&first) = values.first() else {
        return column;
    };
    if values.iter().all(|v| v.to_bits() == first.to_bits()) {
        column.value = first.is_finite().then_some(first);
        return column;
    }
    if store == Store::Exact {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        column.data = BASE64_STANDARD.encode(bytes);
        return column;
    }
    let wrapped = |v: f32| match kind {
        Interpolation::Angle => f64::from(v) - TAU * (f64::from(v) / TAU).round(),
        Interpolation::Line | Interpolation::Step => f64::from(v),
    };
    let finite = values.iter().filter(|v| v.is_finite());
    let largest = finite.map(|v| wrapped(*v).abs()).fold(0.0, f64::max);
    // Integers stay integers.
    let scale = match kind {
        Interpolation::Angle => PI / f64::from(i16::MAX),
        Interpolation::Step if values.iter().all(|v| v.fract() == 0.0 && v.abs() < 32767.0) => 1.0,
        Interpolation::Line | Interpolation::Step => {
            (largest / f64::from(i16::MAX)).max(f64::MIN_POSITIVE)
        }
    } as f32;
    let bytes = values.iter().flat_map(|v| {
        let steps = (wrapped(*v) / f64::from(scale)).round();
        let steps = if v.is_finite() {
            steps.clamp(-32767.0, 32767.0) as i16
        } else {
            i16::MIN
        };
        steps.to_le_bytes()
    });
    column.data = BASE64_STANDARD.encode(bytes.collect::<Vec<u8>>());
    column.scale = Some(scale);
    column
}
