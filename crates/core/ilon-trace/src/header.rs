//! The description of a run: everything a report needs besides the records.

use std::collections::BTreeMap;

use ilon_robot::{
    BodyJoint, CollisionShape, FreeShape, JointKind, Pose, Robot, VisualMeshes, Wheel, wrap_angle,
};
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::fault::{Fault, FaultKind};
use crate::metrics::Summary;
use crate::record::Record;
use crate::twin::Twin;

/// The description of a run: everything a report needs besides the records.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The scenario's name.
    pub scenario_name: String,
    /// The scenario with all its defaults written out, as TOML.
    pub scenario_toml: String,
    /// The robot's name.
    pub robot_name: String,
    /// Mass of the robot with wheels and rollers, in kg; 0 if unknown.
    #[serde(default)]
    pub mass_kg: f64,
    /// The driven wheels, in the robot's order.
    pub wheels: Vec<WheelHeader>,
    /// The joints between bodies, in the robot's order; those beyond [`crate::MAX_JOINTS`] are not
    /// recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointHeader>,
    /// Outlines of the chassis seen from above, in the body frame, in metres: convex polygons,
    /// counter-clockwise.
    #[serde(default)]
    pub chassis_outlines_m: Vec<Vec<[f64; 2]>>,
    /// The point of the body frame that follows the reference, in metres.
    #[serde(default)]
    pub reference_point_m: [f64; 2],
    /// Names of the guidance law's tasks, highest priority first; at most [`crate::MAX_TASKS`],
    /// empty without guidance.
    #[serde(default)]
    pub task_names: Vec<String>,
    /// The physics step, in seconds.
    pub physics_dt_s: f64,
    /// The control period, in seconds.
    pub control_dt_s: f64,
    /// Control periods between rows; 0, in a trace that does not specify it, counts as 1. The end
    /// of the run is always a row.
    #[serde(default)]
    pub record_every: u32,
    /// Number of control periods of the whole run; 0 if unknown.
    #[serde(default)]
    pub control_periods: u64,
    /// Start of the window of the means, in seconds; in an open-loop run it excludes rest and ramp.
    pub measure_from_s: f64,
    /// End of that window, in seconds.
    pub measure_to_s: f64,
    /// The limit of commanded wheel rates by saturation, in rad/s: q'_max of Indiveri 2009, eq.
    /// (29).
    pub wheel_rate_limit_rad_s: Option<f64>,
    /// Whether the run is open loop: a commanded twist, no reference.
    pub open_loop: bool,
    /// Versions of the programs that made the run, by name.
    pub versions: BTreeMap<String, String>,
    /// Whether the angles of the rollers are recorded, in columns such as
    /// `wheel0_roller3_angle_rad`.
    #[serde(default)]
    pub roller_angles: bool,
    /// Whether the real robot's pose from a log is recorded, in columns such as `measured_x_m`.
    #[serde(default)]
    pub measured: bool,
    /// Whether an inertial measurement unit is recorded, in columns such as `imu_rate_z_rad_s`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub imu: bool,
    /// Whether the storage function of a passive wheel law is recorded, in `storage_j` and
    /// `storage_supplied_j`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub storage: bool,
    /// A description of the robot that the controller believes in; `None` if it knows the real one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub belief: Option<String>,
    /// The URDF that the robot was read from, expanded, converted and repaired; empty without a
    /// file. Additions to the wheels are in the scenario's `[robot]`.
    #[serde(default)]
    pub urdf: String,
    /// The robot's visual meshes, reduced in size. They have no influence on the run.
    #[serde(default, skip_serializing_if = "VisualMeshes::is_empty")]
    pub looks: VisualMeshes,
    /// The ground; `None` if unknown.
    pub ground: Option<Ground>,
    /// The recorded free bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyHeader>,
    /// The injected faults; `None` if unknown.
    pub faults: Option<Vec<Fault>>,
    /// The guidance that tracked a reference; `None` without one, or if unknown.
    pub guidance: Option<Guidance>,
    /// The torque line of the DC motors at the wheels; `None` without DC motors, or if unknown.
    pub motor_line: Option<MotorLine>,
    /// The drives' dead band, in N m: they suppress smaller torques; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_band_n_m: Option<f64>,
    /// Whether the motion was predicted to exceed grip or motors; `None` if it was not, or if
    /// unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub announced: Option<Announced>,
    /// Whether wheel rates were commanded by contact kinematics instead of Indiveri 2009, eq. (7).
    #[serde(default)]
    pub commands_by_contact: bool,
    /// The results of the run's twins, if it was repeated with changes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub twins: Vec<Twin>,
    /// The figures of the run by all its control periods, where not each of them has a row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Box<Summary>>,
}

/// A motion that exceeds the limits, as predicted before the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Announced {
    /// Start, in seconds.
    pub from_s: f64,
    /// The wheels that exceed their limits first, as indices into [`Header::wheels`]: several if
    /// the loads are too uncertain to tell which one slides first. Empty in files without this key.
    #[serde(default)]
    pub first: Vec<usize>,
    /// Time of the largest demand, in seconds.
    pub most_at_s: f64,
    /// The wheel with the largest demand, as an index into [`Header::wheels`].
    pub wheel: usize,
    /// Whether it exceeds its grip; otherwise its motor's torque.
    pub of_grip: bool,
    /// Largest demand over limit; `None` if the limit is zero.
    pub share: Option<f64>,
}

/// A joint between bodies: a rocker, a sprung wheel, a swing arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointHeader {
    /// Its name.
    pub name: String,
    /// Whether it is prismatic (metres) instead of revolute (radians).
    pub slides: bool,
    /// Its stops, in rad or m; `None` without stops, or if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
}

/// A free body: an object that can be pushed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyHeader {
    /// Its name.
    pub name: String,
    /// Its shape, around its middle.
    pub shape: FreeShape,
    /// Its mass, in kg.
    pub mass_kg: f64,
    /// Coulomb's coefficient of friction of its surface.
    pub friction: f64,
}

/// The torque line of a DC motor at its wheel; the torque falls linearly with the rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotorLine {
    /// Stall torque, in N m.
    pub stall_torque_n_m: f64,
    /// No-load rate, in rad/s.
    pub no_load_rate_rad_s: f64,
    /// Torque at the current limit, in N m; `None` without one.
    pub current_limit_n_m: Option<f64>,
}

/// The guidance law that tracked the reference of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guidance {
    /// Gain on the position error, K_r of Indiveri 2009, eq. (26), in 1/s; the largest eigenvalue
    /// of a matrix, 0 if no task uses it.
    pub position_gain_per_s: f64,
    /// Gain on the heading error, K_phi of the same equation, in 1/s.
    pub heading_gain_per_s: f64,
    /// The product of position gain and control period from which on the loop is unstable; `None` if
    /// no bound is known.
    pub position_unstable_from: Option<f64>,
    /// The same for the heading gain.
    pub heading_unstable_from: Option<f64>,
}

/// The ground of a run. All coordinates are in the plane of the floor, which may slope.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Coulomb friction coefficient outside patches.
    pub friction: f64,
    /// Slope of the floor: the angle by which it falls towards +x, in radians.
    pub slope_rad: f64,
    /// Rectangles with their own friction; later ones cover earlier ones.
    pub patches: Vec<GroundPatch>,
    /// Boxes that stand on the floor.
    pub boxes: Vec<GroundBox>,
    /// Ramps: tilted boxes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ramps: Vec<GroundRamp>,
    /// Uneven ground instead of the plane.
    pub relief: Option<GroundRelief>,
}

impl Ground {
    /// Whether a robot on it may stand on anything but the plane of the floor.
    pub fn is_uneven(&self) -> bool {
        !self.boxes.is_empty() || !self.ramps.is_empty() || self.relief.is_some()
    }
}

/// A rectangle of floor along the world's axes with its own friction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroundPatch {
    /// Its middle, x and y, in metres.
    pub center_m: [f64; 2],
    /// Its lengths along x and y, in metres.
    pub sides_m: [f64; 2],
    /// Coulomb's coefficient of friction there.
    pub friction: f64,
    /// Changed floor properties besides friction, as text; empty if there are none, or unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<String>,
    /// Time when it appears, in seconds.
    pub from_s: f64,
    /// Time when it disappears, in seconds; `None` if it stays.
    pub until_s: Option<f64>,
}

impl GroundPatch {
    /// Whether it is there at a time in seconds.
    pub fn is_there(&self, t_s: f64) -> bool {
        t_s >= self.from_s && self.until_s.is_none_or(|until_s| t_s < until_s)
    }

    /// How far a point of the floor lies from it, in metres; 0 on it.
    pub fn distance_m(&self, [x_m, y_m]: [f64; 2]) -> f64 {
        let beside_m = |at_m: f64, axis: usize| {
            ((at_m - self.center_m[axis]).abs() - 0.5 * self.sides_m[axis]).max(0.0)
        };
        beside_m(x_m, 0).hypot(beside_m(y_m, 1))
    }
}

/// A box that stands on the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroundBox {
    /// The centre of its base, x and y, in metres.
    pub center_m: [f64; 2],
    /// Its lengths along its own axes and its height, in metres.
    pub sides_m: [f64; 3],
    /// Its heading, in radians.
    pub heading_rad: f64,
}

/// A tilted box: its upper side is a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroundRamp {
    /// Its middle, in metres.
    pub center_m: [f64; 3],
    /// Its lengths along its own axes, in metres.
    pub sides_m: [f64; 3],
    /// Its heading, in radians.
    pub heading_rad: f64,
    /// The angle by which the end along its own x axis is lowered, in radians.
    pub pitch_rad: f64,
}

/// A grid of heights: a square around the origin, or a map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroundRelief {
    /// Distance between neighbouring points, in metres.
    pub cell_m: f64,
    /// Number of points on a side; of a map, along x.
    pub points: usize,
    /// The seed of the random heights: `ilon_sim::simulate::relief_heights_m`.
    pub seed: u64,
    /// The largest height, in metres; 0 if the roughness determines the heights.
    pub height_m: f64,
    /// Spectral density of the displacement at 0.1 cycles/m, Gd(n0) of ISO 8608, in m^3; `None` for
    /// independent random heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness_m3: Option<f64>,
    /// The heights of a map, instead of random ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<GroundMap>,
}

/// The heights of a map as used in the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroundMap {
    /// The middle of its grid, x and y, in metres.
    pub center_m: [f64; 2],
    /// The height of level 0, in metres.
    pub lowest_m: f64,
    /// Height difference between two levels, in metres.
    pub step_m: f64,
    /// The level of each point, row by row from -y to +y, in each row from -x to +x: u16,
    /// little-endian, in base64.
    pub levels: String,
}

/// A driven wheel, as far as records refer to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WheelHeader {
    /// The name of the wheel's joint.
    pub name: String,
    /// The wheel's centre in the body frame, x and y: **b** of Indiveri 2009, in metres.
    pub position_m: [f64; 2],
    /// The wheel's radius rho, in metres.
    pub radius_m: f64,
    /// The angle gamma from the hub axis to the rolling direction of the lowest roller, in radians.
    pub gamma_rad: f64,
    /// The hub axis **n** in the body frame, x and y, of length 1.
    pub axis: [f64; 2],
    /// The wheel's extent along its axis, in metres.
    pub width_m: f64,
    /// Number of its rollers; 1 for a tyre (see [`Self::has_tyre`]).
    pub roller_count: usize,
    /// The wheel's own rate limit, in rad/s.
    pub rate_limit_rad_s: Option<f64>,
    /// The wheel's torque limit, in N m.
    pub torque_limit_n_m: Option<f64>,
    /// Strength of its motor relative to the others, forwards and backwards, if motors differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_strength: Option<[f64; 2]>,
    /// Coulomb friction of bearing and gear, in N m, if there is any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dry_friction_n_m: Option<f64>,
    /// Whether a joint turns it about an upright axis: its axis above is that at an angle of zero.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_steered: bool,
}

impl Header {
    /// Whether the controller knows its robot: believes in no other, and in no encoder that counts
    /// wrong.
    pub fn knows_its_robot(&self) -> bool {
        let is_scaled = |fault: &Fault| matches!(fault.kind, FaultKind::EncoderScaled { .. });
        self.belief.is_none() && !self.faults.iter().flatten().any(is_scaled)
    }

    /// What puts the robot off by the term `belief` of the ledger: the robot that the controller
    /// believes in, or, where it believes in the real one, its encoders.
    pub fn belief_in_words(&self) -> &'static str {
        match &self.belief {
            Some(_) => "what the controller believes of the robot",
            None => "what the encoders read wrong",
        }
    }

    /// Whether the run records a term of the ledger (see [`crate::ledger::NAMES`]).
    pub fn has_term(&self, term: &str) -> bool {
        match term {
            "belief" => !self.knows_its_robot(),
            "incline" => self.ground.as_ref().is_some_and(Ground::is_uneven),
            _ => true,
        }
    }

    /// Whether all its wheels roll on tyres.
    pub fn is_on_tyres(&self) -> bool {
        !self.wheels.is_empty() && self.wheels.iter().all(WheelHeader::has_tyre)
    }

    /// The farthest wheel's distance from the body's origin, in metres; 0 without wheels.
    pub(crate) fn arm_m(&self) -> f64 {
        let positions = self.wheels.iter().map(|wheel| wheel.position_m);
        positions
            .map(|[x_m, y_m]| libm::hypot(x_m, y_m))
            .fold(0.0, f64::max)
    }

    /// The number of rollers with recorded angles: those of all wheels, or none.
    pub(crate) fn rollers_recorded(&self) -> usize {
        let all = self.wheels.iter().map(|wheel| wheel.roller_count);
        match self.roller_angles {
            true => all.fold(0, usize::saturating_add),
            false => 0,
        }
    }

    /// Whether an instant is in the window of the means. A slack of half a control period absorbs
    /// the rounding of times on its edges.
    pub fn is_measured(&self, t_s: f64) -> bool {
        let slack_s = 0.5 * self.control_dt_s;
        t_s > self.measure_from_s - slack_s && t_s < self.measure_to_s - slack_s
    }

    /// The time between rows, in seconds; the last row may follow sooner.
    pub fn row_dt_s(&self) -> f64 {
        self.control_dt_s * self.periods_a_row()
    }

    /// The length of the period that ends at the row of an instant, in seconds; 0 for the first
    /// row.
    pub fn row_span_s(&self, t_s: f64) -> f64 {
        match t_s > 0.0 {
            true => self.control_dt_s * self.periods_up_to(t_s),
            false => 0.0,
        }
    }

    /// The time until which the decision of the row of an instant holds, in seconds: the next row,
    /// or the end of the run.
    pub fn row_end_s(&self, t_s: f64) -> f64 {
        if self.control_dt_s <= 0.0 {
            return t_s;
        }
        let next = (t_s / self.control_dt_s).round() + self.periods_a_row();
        let end = match self.control_periods {
            0 => f64::INFINITY,
            periods => periods as f64,
        };
        next.min(end) * self.control_dt_s
    }

    /// The number of control instants after the previous row up to this instant; 1 for the first
    /// row.
    pub(crate) fn periods_up_to(&self, t_s: f64) -> f64 {
        let every = self.periods_a_row();
        let instant = (t_s / self.control_dt_s).round();
        let beyond = instant.rem_euclid(every);
        match (instant > 0.0, beyond > 0.0) {
            (true, true) => beyond,
            (true, false) => every,
            (false, _) => 1.0,
        }
    }

    fn periods_a_row(&self) -> f64 {
        f64::from(self.record_every.max(1))
    }

    /// The pose of the point that follows the reference when the body frame is at `pose`; the
    /// heading is the same.
    pub fn reference_point_at(&self, pose: Pose) -> Pose {
        let [x_m, y_m] = self.reference_point_m;
        let (sin, cos) = libm::sincos(pose.heading_rad);
        Pose {
            x_m: pose.x_m + cos * x_m - sin * y_m,
            y_m: pose.y_m + sin * x_m + cos * y_m,
            ..pose
        }
    }

    /// Distance of the reference point from the desired position in metres and magnitude of the
    /// heading error in radians, Indiveri 2009, eqs. (16)-(17); `None` without a reference.
    pub fn tracking_error(&self, record: &Record) -> Option<(f64, f64)> {
        let desired = record.desired?.pose;
        let truth = self.reference_point_at(record.truth.pose);
        let e_r = desired.position_m() - truth.position_m();
        let e_phi = wrap_angle(desired.heading_rad - truth.heading_rad);
        Some((e_r.norm(), e_phi.abs()))
    }

    /// Fills in what follows from the robot: its name, wheels, outlines and the wheel rate limit.
    pub fn of_robot(robot: &Robot) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        // With all joints at zero.
        let bodies_of_joints = robot.joints.iter().flat_map(|joint| &joint.body.collisions);
        Self {
            robot_name: robot.name.clone(),
            mass_kg: robot.mass_kg(),
            wheels: robot.wheels.iter().map(WheelHeader::of_wheel).collect(),
            joints: joints_of(&robot.joints),
            chassis_outlines_m: robot
                .chassis
                .collisions
                .iter()
                .chain(bodies_of_joints)
                .map(|c| outline_from_above_m(&c.body_from_shape, &c.shape))
                .filter(|polygon| polygon.len() >= 3)
                .collect(),
            wheel_rate_limit_rad_s: finite(robot.wheel_rate_limit_rad_s()),
            ..Self::default()
        }
    }
}

/// The joints between bodies, each with a unique name.
fn joints_of(joints: &[BodyJoint]) -> Vec<JointHeader> {
    let header = |(index, joint): (usize, &BodyJoint)| {
        let stands_twice = joints[..index].iter().any(|other| other.name == joint.name);
        JointHeader {
            name: if stands_twice {
                format!("{}_{index}", joint.name)
            } else {
                joint.name.clone()
            },
            slides: joint.kind == JointKind::Slides,
            limits: Some(joint.limits).filter(|of| of.iter().all(|at| at.is_finite())),
        }
    };
    joints.iter().enumerate().map(header).collect()
}

impl WheelHeader {
    /// Whether it rolls on a tyre: no Swedish wheel has a single roller.
    pub fn has_tyre(&self) -> bool {
        self.roller_count == 1
    }

    /// The recorded properties of a wheel.
    pub fn of_wheel(wheel: &Wheel) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let b = wheel.position_m();
        let n = wheel.axis();
        // Each roller spans the projection of its axis on the hub axis; its thickness at the ends
        // is small compared with that.
        let half_width_m = wheel
            .rollers
            .iter()
            .map(|r| r.row_offset_m().abs() + 0.5 * r.length_m * r.axis_in_hub.z.abs())
            .fold(0.0, f64::max);
        let rollers = wheel.rollers.iter().filter(|r| !r.is_tyre());
        let thickest_m = rollers.map(|r| r.radius_m).fold(0.0, f64::max);
        Self {
            name: wheel.name.clone(),
            position_m: [b.x, b.y],
            radius_m: wheel.radius_m,
            gamma_rad: wheel.gamma_rad,
            axis: [n.x, n.y],
            width_m: 2.0 * half_width_m.max(thickest_m),
            roller_count: wheel.rollers.len(),
            rate_limit_rad_s: finite(wheel.motor.velocity_rad_s),
            torque_limit_n_m: finite(wheel.motor.effort_n_m),
            motor_strength: None,
            dry_friction_n_m: Some(wheel.dry_friction_n_m()).filter(|n_m| *n_m > 0.0),
            is_steered: false,
        }
    }

    /// The row of M that belongs to this wheel, Indiveri 2009, eq. (8): -(n_gamma_x, n_gamma_y,
    /// **b** . **u**_gamma).
    pub fn m_row(&self) -> [f64; 3] {
        let (s, c) = libm::sincos(self.gamma_rad);
        let [n_x, n_y] = self.axis;
        let [b_x, b_y] = self.position_m;
        // u_gamma is n turned by gamma, n_gamma = k x u_gamma.
        let (u_x, u_y) = (c * n_x - s * n_y, s * n_x + c * n_y);
        let (n_gamma_x, n_gamma_y) = (-u_y, u_x);
        [-n_gamma_x, -n_gamma_y, -(b_x * u_x + b_y * u_y)]
    }
}

/// The convex outline of a collision shape seen from above, in the body frame, in metres,
/// counter-clockwise.
fn outline_from_above_m(
    body_from_shape: &nalgebra::Isometry3<f64>,
    shape: &CollisionShape,
) -> Vec<[f64; 2]> {
    let points = silhouette_points_m(shape);
    let seen = points
        .iter()
        .map(|p| (body_from_shape * nalgebra::Point3::from(*p)).xy().coords)
        .collect();
    convex_hull(seen).iter().map(|p| [p.x, p.y]).collect()
}

/// Points whose convex hull is the shape, or close to it: round shapes are sampled every 15 deg.
fn silhouette_points_m(shape: &CollisionShape) -> Vec<Vector3<f64>> {
    const SIDES: usize = 24;
    let ring = |radius_m: f64, z_m: f64| {
        (0..SIDES).map(move |k| {
            let (s, c) = libm::sincos(std::f64::consts::TAU * k as f64 / SIDES as f64);
            Vector3::new(radius_m * c, radius_m * s, z_m)
        })
    };
    let ball = |radius_m: f64, z_m: f64| {
        (-6..=6).flat_map(move |k| {
            let (s, c) = libm::sincos(f64::from(k) * std::f64::consts::PI / 12.0);
            ring(radius_m * c, z_m + radius_m * s)
        })
    };
    match *shape {
        CollisionShape::ConvexHull { ref points_m } => points_m.iter().map(|p| p.coords).collect(),
        CollisionShape::Box { half_extents_m: h } => [-1.0, 1.0]
            .iter()
            .flat_map(|&x| [-1.0, 1.0].iter().map(move |&y| (x, y)))
            .flat_map(|(x, y)| [-1.0, 1.0].map(|z| Vector3::new(x * h.x, y * h.y, z * h.z)))
            .collect(),
        CollisionShape::Cylinder { radius_m, length_m } => ring(radius_m, -0.5 * length_m)
            .chain(ring(radius_m, 0.5 * length_m))
            .collect(),
        CollisionShape::Capsule { radius_m, length_m } => ball(radius_m, -0.5 * length_m)
            .chain(ball(radius_m, 0.5 * length_m))
            .collect(),
        CollisionShape::Sphere { radius_m } => ball(radius_m, 0.0).collect(),
    }
}

/// Andrew's monotone chain: the convex hull of points in the plane, counter-clockwise.
fn convex_hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for &p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp(&(p - b)) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter());
    hull.extend(half(&mut points.iter().rev()));
    hull
}

#[cfg(test)]
mod tests;
