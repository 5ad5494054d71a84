//! The frames of a recorded run.

use ilon_robot::{FreeShape, LinkTree, Pose, Robot};
use ilon_trace::{BodyHeader, Change, Header, JointSample, Record, Rows, WheelSample};

use crate::description::{Description, Geometry, OtherWay, Relief, Shape};
use crate::frames::{Contact, Frame, Frames, WheelFrame};

/// How many frames of a run are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinning {
    /// Frames per second, as far as there are rows.
    pub rate_hz: f64,
    /// The largest number of frames, besides the last row's.
    pub most: usize,
}

impl Default for Thinning {
    /// The rate of a screen, for up to fifty seconds. Longer runs have fewer frames per second, so
    /// that a page stays small. A roller that turns by more than half a turn between frames seems
    /// to turn backwards.
    fn default() -> Self {
        Self {
            rate_hz: 60.0,
            most: 3000,
        }
    }
}

impl Thinning {
    /// The number of rows per frame.
    fn stride(&self, rows: usize, period_s: f64) -> usize {
        let by_rate = (1.0 / (self.rate_hz * period_s)).round();
        let by_rate = if by_rate.is_finite() {
            by_rate as usize
        } else {
            1
        };
        by_rate.max(rows.div_ceil(self.most.max(1))).max(1)
    }
}

impl Description {
    /// The static part of a run of this robot, whose file has these links. `relief_m` holds the
    /// heights of the ground's relief, row by row, in metres.
    pub fn of_run(
        header: &Header,
        robot: &Robot,
        links: Option<&LinkTree>,
        relief_m: Option<&[Vec<f64>]>,
    ) -> Self {
        let mut ground = header.ground.clone().unwrap_or_default();
        let relief = ground.relief.take().zip(relief_m);
        Self {
            relief: relief.and_then(|(relief, heights_m)| {
                let middle_m = relief.map.map_or([0.0; 2], |map| map.center_m);
                Relief::new(relief.cell_m, middle_m, heights_m)
            }),
            ground,
            faults: header.faults.clone().unwrap_or_default(),
            bodies: shapes_of_bodies(header),
            ways: ways(header),
            ..Self::of_robot(robot, links, &header.looks)
        }
    }
}

/// The motions without each cause of deviation in turn, for ghosts.
fn ways(header: &Header) -> Vec<OtherWay> {
    let moved = header.twins.iter().filter_map(|twin| match &twin.change {
        Change::Without(cause) if !twin.poses.is_empty() => Some(OtherWay {
            name: format!("without {}", cause.words),
            poses: twin
                .poses
                .iter()
                .map(|pose| pose.map(|x| x as f32))
                .collect(),
        }),
        _ => None,
    });
    moved.collect()
}

/// The free bodies of a run, each in its own frame, for [`crate::Description::bodies`].
pub fn shapes_of_bodies(header: &Header) -> Vec<Shape> {
    let form = |shape: FreeShape| match shape {
        FreeShape::Box { size_m } => Geometry::Box(size_m.map(|side| 0.5 * side as f32)),
        FreeShape::Cylinder { radius_m, length_m } => {
            Geometry::Cylinder([radius_m as f32, length_m as f32])
        }
        FreeShape::Sphere { radius_m } => Geometry::Sphere([radius_m as f32]),
    };
    let shape = |body: &BodyHeader| Shape {
        pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        form: form(body.shape),
        color: None,
    };
    header.bodies.iter().map(shape).collect()
}

/// The frames of a run of this robot.
///
/// The rollers turn by the columns `wheel0_roller0_angle_rad` if the run has them. Otherwise the
/// roller in contact turns by its recorded spin, and the others stand still; in reality they keep
/// turning, as only their bearings slow them down.
///
/// # Errors
/// If the rows cannot be read.
pub fn frames_of_run<R: Rows>(
    rows: &R,
    robot: &Robot,
    thinning: Thinning,
) -> Result<Frames, R::Error> {
    let row_dt_s = rows.header().row_dt_s();
    let row_count = rows.row_count();
    let stride = thinning.stride(row_count, row_dt_s);
    let kept = |row: usize| row.is_multiple_of(stride) || row + 1 == row_count;
    let mut rolling = Rolling::of(robot);
    let mut frames: Vec<Frame> = Vec::with_capacity(row_count / stride + 2);
    let mut row = 0;
    rows.each_batch(&mut |chunk| {
        for (record, wheels) in chunk.steps() {
            if kept(row) {
                frames.push(rolling.frame(rows.header(), record, wheels));
            }
            rolling.pass(rows.header(), record, wheels);
            row += 1;
        }
    })?;
    for (w, wheel) in robot.wheels.iter().enumerate() {
        for r in 0..wheel.rollers.len() {
            let mut row = 0;
            let mut frame = 0;
            rows.each_value(&format!("wheel{w}_roller{r}_angle_rad"), &mut |value| {
                if kept(row) {
                    let wheel = frames.get_mut(frame).and_then(|f| f.wheels.get_mut(w));
                    let angle = wheel.and_then(|w| w.roller_angles_rad.get_mut(r));
                    if let Some((angle, value)) = angle.zip(value) {
                        *angle = value;
                    }
                    frame += 1;
                }
                row += 1;
            })?;
        }
    }
    let bodies = rows.header().bodies.len();
    Ok(Frames::beside(robot, bodies, frames))
}

/// The roller angles after the rows so far: makes frames from rows as they arrive.
#[derive(Clone, Debug, PartialEq)]
pub struct Rolling {
    /// The angle of each wheel's rollers about their axes, in radians.
    angles_rad: Vec<Vec<f64>>,
    /// The number of joints between the robot's bodies.
    joints: usize,
}

impl Rolling {
    /// All rollers at angle zero.
    pub fn of(robot: &Robot) -> Self {
        let of_wheel = |wheel: &ilon_robot::Wheel| vec![0.0; wheel.rollers.len()];
        Self {
            angles_rad: robot.wheels.iter().map(of_wheel).collect(),
            joints: robot.joints.len(),
        }
    }

    /// The frame of a row.
    pub fn frame(&self, header: &Header, record: &Record, wheels: &[WheelSample]) -> Frame {
        let position = |joint| {
            let sample = record.joints.get(joint);
            sample.map_or(0.0, |of: &JointSample| of.position)
        };
        Frame {
            joints: (0..self.joints).map(position).collect(),
            ..frame(header, record, wheels, &self.angles_rad)
        }
    }

    /// Turns the rollers in contact by their spin until the next row.
    pub fn pass(&mut self, header: &Header, record: &Record, wheels: &[WheelSample]) {
        let span_s = header.row_end_s(record.t_s) - record.t_s;
        for (angles_rad, wheel) in self.angles_rad.iter_mut().zip(wheels) {
            let roller = angles_rad.get_mut(wheel.roller as usize);
            if let Some(angle_rad) = roller.filter(|_| wheel.touching) {
                *angle_rad += wheel.roller_spin_rad_s * span_s;
            }
        }
    }
}

/// The frame of a row, without its joints, with these roller angles.
fn frame(header: &Header, record: &Record, wheels: &[WheelSample], angles: &[Vec<f64>]) -> Frame {
    let truth = &record.truth;
    // The reference is for a point of the body, whereas the drawn path is that of the body frame.
    let body_of = |wanted: Pose| {
        let point = header.reference_point_at(wanted);
        Pose {
            x_m: 2.0 * wanted.x_m - point.x_m,
            y_m: 2.0 * wanted.y_m - point.y_m,
            ..wanted
        }
    };
    let bodies = record.bodies.iter().take(header.bodies.len()).map(|body| {
        let [x, y, z] = body.place_m;
        [x, y, z, body.roll_rad, body.pitch_rad, body.heading_rad]
    });
    Frame {
        bodies: bodies.collect(),
        joints: Vec::new(),
        t_s: record.t_s,
        pose: truth.pose,
        height_m: truth.height_m,
        roll_rad: truth.roll_rad,
        pitch_rad: truth.pitch_rad,
        ghost: Some(record.odometry_ideal),
        wanted: record.desired.map(|desired| body_of(desired.pose)),
        wheels: wheels
            .iter()
            .zip(angles)
            .map(|(sample, angles)| WheelFrame {
                angle_rad: sample.angle_rad,
                contact: sample.touched().then_some(Contact {
                    place_m: [sample.contact_x_m, sample.contact_y_m],
                    normal_force_n: sample.normal_force_n,
                    force_n: [sample.force_x_n, sample.force_y_n],
                    slip_m_s: [sample.slip_x_m_s, sample.slip_y_m_s],
                    friction: sample.friction,
                }),
                roller: sample.roller as usize,
                roller_angles_rad: angles.clone(),
            })
            .collect(),
    }
}
