//! Contacts as shapes for a viewer: force, friction cone and sliding of each wheel.

use std::f64::consts::TAU;

use ilon_robot::Robot;
use ilon_trace::{Record, WheelSample};

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::{Point, Vector3};
use crate::std_msgs::{ColorRGBA, Header};
use crate::visualization_msgs::{Marker, MarkerArray};

/// Largest rate of contact markers, per second of simulated time.
pub const MARKER_RATE_HZ: f64 = 30.0;

/// Drawn length of a wheel's share of the robot's weight, in wheel radii.
const RADII_PER_LOAD: f64 = 2.5;
/// Drawn length of a sliding velocity, in metres per m/s.
const METRES_PER_M_S: f64 = 1.0;
/// Number of corners of a cone's rim.
const RIM: usize = 16;
/// A force at this share of its friction limit slides.
const ON_THE_EDGE: f64 = 0.999;

const GRAVITY_M_S2: f64 = 9.81;

const HELD: ColorRGBA = color(0.16, 0.47, 0.84, 1.0);
const SLIDING: ColorRGBA = color(0.86, 0.24, 0.16, 1.0);
const CONE: ColorRGBA = color(0.5, 0.5, 0.5, 0.6);

const fn color(r: f32, g: f32, b: f32, a: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a }
}

/// Builds the contact markers of a robot.
#[derive(Clone, Debug)]
pub(super) struct Contacts {
    frame: String,
    radii_m: Vec<f64>,
    metres_per_n: f64,
}

impl Contacts {
    /// For a robot in the world frame.
    pub fn of(robot: &Robot, frame: &str) -> Self {
        let radii_m: Vec<f64> = robot.wheels.iter().map(|wheel| wheel.radius_m).collect();
        let count = radii_m.len().max(1) as f64;
        let mean_m = radii_m.iter().sum::<f64>() / count;
        let load_n = robot.mass_kg() * GRAVITY_M_S2 / count;
        Self {
            frame: frame.to_owned(),
            metres_per_n: RADII_PER_LOAD * mean_m / load_n,
            radii_m,
        }
    }

    /// Returns three markers for each wheel, always: without contact they delete the earlier ones.
    pub fn message(&self, stamp: Time, record: &Record, wheels: &[WheelSample]) -> MarkerArray {
        let mut markers = Vec::with_capacity(3 * wheels.len());
        let pose = record.truth.pose;
        let (sin, cos) = libm::sincos(pose.heading_rad);
        let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
        for ((id, sample), radius_m) in wheels.iter().enumerate().zip(&self.radii_m) {
            let [x, y] = turned(sample.contact_x_m, sample.contact_y_m);
            // On a kerb the ground is higher by as much as the wheel.
            let foot = Point {
                x: pose.x_m + x,
                y: pose.y_m + y,
                z: (sample.hub_height_m - radius_m).max(0.0),
            };
            let above = |x: f64, y: f64, z: f64| Point {
                x: foot.x + x,
                y: foot.y + y,
                z: foot.z + z,
            };
            let slides = sample
                .friction_used()
                .is_some_and(|used| used > ON_THE_EDGE);
            let scale = self.metres_per_n;
            let [force_x, force_y] = turned(sample.force_x_n * scale, sample.force_y_n * scale);
            let height = sample.normal_force_n * scale;
            let [slip_x, slip_y] = turned(
                sample.slip_x_m_s * METRES_PER_M_S,
                sample.slip_y_m_s * METRES_PER_M_S,
            );
            let thick = 0.1 * radius_m;
            let mut marker = |ns: &str, r#type: i32, color: ColorRGBA, points: Vec<Point>| {
                let arrow = r#type == Marker::ARROW;
                markers.push(Marker {
                    header: Header {
                        stamp,
                        frame_id: self.frame.clone(),
                    },
                    ns: ns.to_owned(),
                    id: id as i32,
                    r#type,
                    action: if sample.touched() {
                        Marker::ADD
                    } else {
                        Marker::DELETE
                    },
                    scale: Vector3 {
                        x: if arrow { thick } else { 0.2 * thick },
                        y: if arrow { 2.0 * thick } else { 0.0 },
                        z: 0.0,
                    },
                    color,
                    points: if sample.touched() { points } else { Vec::new() },
                    ..Marker::default()
                });
            };
            let held = if slides { SLIDING } else { HELD };
            let tip = above(force_x, force_y, height);
            marker("force", Marker::ARROW, held, vec![foot, tip]);
            let rim_m = sample.friction * height;
            marker(
                "friction_cone",
                Marker::LINE_LIST,
                CONE,
                cone(above, rim_m, height),
            );
            marker(
                "slip",
                Marker::ARROW,
                SLIDING,
                vec![foot, above(slip_x, slip_y, 0.0)],
            );
        }
        MarkerArray { markers }
    }
}

/// Returns the lines of a cone that stands on its tip: its rim, and four of its flanks.
fn cone(at: impl Fn(f64, f64, f64) -> Point, rim_m: f64, height_m: f64) -> Vec<Point> {
    let rim = |corner: usize| {
        let (sin, cos) = libm::sincos(TAU * corner as f64 / RIM as f64);
        at(rim_m * cos, rim_m * sin, height_m)
    };
    let around = (0..RIM).flat_map(|corner| [rim(corner), rim(corner + 1)]);
    let flanks = (0..RIM)
        .step_by(RIM / 4)
        .flat_map(|corner| [at(0.0, 0.0, 0.0), rim(corner)]);
    around.chain(flanks).collect()
}
