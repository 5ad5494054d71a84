//! A swerve drive whose motions a robot can all perform.

use ilon_control::{AccelerationPolytope, Kinematics, SpeedLimits};
use ilon_robot::{MassProperties, Robot, Twist};
use nalgebra::Vector3;

use crate::ros2_control::DriveParameters;
use crate::simulate::Limits;

/// Gravity in the planners' models, in m/s^2.
const PLANNERS_GRAVITY_M_S2: f64 = 9.8;

/// Share of the limits that is given to planners; chosen.
pub(super) const SHARE: f64 = 0.9;

/// A swerve drive: the robot can reach from rest every acceleration that it allows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Swerve {
    /// The robot's name.
    pub name: String,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Inertia about the vertical through the centre of mass, in kg m^2.
    pub inertia_kg_m2: f64,
    /// The places in the body frame, in metres: front left, front right, back left, back right. Of
    /// steered wheels those of their steering axes, which alone stand still as modules turn: the
    /// planners' angles are then the modules', and so are their speeds but for omega times what the
    /// wheel lies beside its axis.
    pub modules_m: [[f64; 2]; 4],
    /// Radius of the wheels, in metres.
    pub wheel_radius_m: f64,
    /// The friction coefficient for the planner, with a quarter of the weight on each module.
    pub friction: f64,
    /// The corresponding torque at a wheel, in N m.
    pub torque_n_m: f64,
    /// Top speed in the slowest direction, without turning, in m/s.
    pub speed_m_s: f64,
    /// Top yaw rate on the spot, in rad/s.
    pub yaw_rate_rad_s: f64,
    /// Box of accelerations ahead, left and turning, in m/s^2 and rad/s^2; the robot reaches every
    /// corner.
    pub acceleration_box: [f64; 3],
    /// Extent of the robot from the origin of its body frame ahead, back, left and right, in
    /// metres.
    pub reach_m: [f64; 4],
}

/// Why a robot cannot be described as a swerve drive.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoSwerve {
    /// It has not four wheels, one in each quadrant.
    #[error(
        "planners for swerve drives take four wheels, one in each corner: front left, front right, back left, back right; this robot has {0}"
    )]
    NotFourCorners(String),
    /// An acceleration along some axis cannot be reached from rest.
    #[error(
        "there is no direction-free acceleration to give: on this ground the robot cannot even stand, or a motor holds it"
    )]
    NothingToGive,
    /// It rolls on tyres that are not all driven and steered.
    #[error(
        "planners for swerve drives take robots that move in every direction, and the tyre of `{0}` is not driven and steered"
    )]
    NotSteered(String),
    /// Its wheels have no rate limit.
    #[error(
        "the robot's file sets no rate limits of its wheels: give its joints <limit velocity=...>"
    )]
    NoRateLimit,
}

impl Swerve {
    /// The robot as a swerve drive under the conditions of its limits.
    ///
    /// # Errors
    /// If it cannot be described as one.
    pub fn of(robot: &Robot, limits: &Limits) -> Result<Self, NoSwerve> {
        let modules_m = corners(robot)?;
        let polytope = limits.polytope.as_ref().ok_or(NoSwerve::NothingToGive)?;
        let whole = whole(robot).ok_or(NoSwerve::NothingToGive)?;
        let inertia_kg_m2 = whole.inertia_kg_m2.m33;
        let kinematics = Kinematics::new(robot).map_err(|_| NoSwerve::NothingToGive)?;
        let rates: Vec<f64> = robot
            .wheels
            .iter()
            .map(|w| w.motor.velocity_rad_s)
            .collect();
        let tops = SpeedLimits::new(&kinematics, &rates);
        let speed_m_s = slowest_m_s(&tops);
        let turning = Twist::new(0.0, 0.0, 1.0);
        // As for the controllers of ROS 2 and Road Runner, with the yaw rate that the rollers give.
        let drive = DriveParameters::of(robot).ok().and_then(Result::ok);
        let share = drive.map_or_else(|| tops.share(turning), |drive| drive.share(turning));
        let yaw_rate_rad_s = 1.0 / share;
        let force_n = SHARE * force_within_n(&modules_m, (whole.mass_kg, inertia_kg_m2), polytope);
        let top = [speed_m_s, yaw_rate_rad_s];
        Self::with(robot, force_n, top, limits.acceleration_box)
    }

    /// A robot whose modules push with a force, with its top speed and yaw rate and the box of its
    /// accelerations.
    pub(super) fn with(
        robot: &Robot,
        force_n: f64,
        [speed_m_s, yaw_rate_rad_s]: [f64; 2],
        acceleration_box: [f64; 3],
    ) -> Result<Self, NoSwerve> {
        if !(speed_m_s.is_finite() && yaw_rate_rad_s.is_finite()) {
            return Err(NoSwerve::NoRateLimit);
        }
        let whole = whole(robot).ok_or(NoSwerve::NothingToGive)?;
        let wheel_radius_m = robot.mean_wheel_radius_m();
        Ok(Self {
            name: robot.name.clone(),
            mass_kg: whole.mass_kg,
            inertia_kg_m2: whole.inertia_kg_m2.m33,
            modules_m: corners(robot)?,
            wheel_radius_m,
            friction: force_n / (0.25 * whole.mass_kg * PLANNERS_GRAVITY_M_S2),
            torque_n_m: force_n * wheel_radius_m,
            speed_m_s,
            yaw_rate_rad_s,
            acceleration_box,
            reach_m: reaches_m(robot),
        })
    }
}

/// The places of [`Swerve::modules_m`].
pub(super) fn corners(robot: &Robot) -> Result<[[f64; 2]; 4], NoSwerve> {
    let not = |where_they_are| {
        NoSwerve::NotFourCorners(format!("{} wheels{where_they_are}", robot.wheels.len()))
    };
    if robot.wheels.len() != 4 {
        return Err(not(""));
    }
    let places_m = robot.wheels.iter().map(|wheel| {
        let steering = robot.steering_of(wheel).map(|at| &robot.joints[at]);
        let axis_m = steering.map(|of| of.body_from_joint.translation.vector);
        axis_m.unwrap_or_else(|| wheel.position_m())
    });
    let at = |x: f64, y: f64| {
        let mut places_m = places_m.clone();
        let there = places_m.find(|place_m| x * place_m.x > 0.0 && y * place_m.y > 0.0);
        let place_m = there.ok_or_else(|| not(" elsewhere"))?;
        Ok([place_m.x, place_m.y])
    };
    Ok([
        at(1.0, 1.0)?,
        at(1.0, -1.0)?,
        at(-1.0, 1.0)?,
        at(-1.0, -1.0)?,
    ])
}

/// The robot as one rigid body, its joints at zero.
pub(super) fn whole(robot: &Robot) -> Option<MassProperties> {
    let mut parts = vec![robot.chassis.mass.clone()];
    for joint in &robot.joints {
        parts.push(joint.body.mass.moved(&joint.body_from_joint));
    }
    for wheel in &robot.wheels {
        parts.push(wheel.hub.moved(&wheel.body_from_hub));
        let rollers = wheel.rollers.iter();
        parts.extend(rollers.map(|roller| roller.mass_in_hub().moved(&wheel.body_from_hub)));
    }
    MassProperties::merged(&parts)
}

/// Top speed in the slowest direction.
fn slowest_m_s(tops: &SpeedLimits) -> f64 {
    let shares = (0..360).map(|degrees| {
        let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
        tops.share(Twist::new(cos, sin, 0.0))
    });
    1.0 / shares.fold(0.0, f64::max)
}

/// The largest force of a module, in N, at which all accelerations of the swerve drive lie in a
/// polytope.
///
/// Modules at b_i that push with any f_i, |f_i| <= F, give m a = sum f_i and J
/// alpha = sum b_i x f_i. Along the normal of a face n . (a, alpha) <= 1 they reach at
/// most F sum |n_a / m + (n_alpha / J) k x b_i|, each pushing along its own term.
fn force_within_n(
    modules_m: &[[f64; 2]; 4],
    (mass_kg, inertia_kg_m2): (f64, f64),
    polytope: &AccelerationPolytope,
) -> f64 {
    let per_newton = |[ahead, left, turning]: &[f64; 3]| -> f64 {
        let turning = turning / inertia_kg_m2;
        let term = |[x, y]: &[f64; 2]| {
            let (along, across) = (ahead / mass_kg - turning * y, left / mass_kg + turning * x);
            along.hypot(across)
        };
        modules_m.iter().map(term).sum()
    };
    1.0 / polytope
        .half_spaces
        .iter()
        .map(per_newton)
        .fold(0.0, f64::max)
}

/// The extent of the robot ahead, back, left and right, in metres.
fn reaches_m(robot: &Robot) -> [f64; 4] {
    [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()].map(|way| reach_m(robot, &way))
}

/// The extent of chassis and wheels from the origin of the body frame in a horizontal direction, in
/// metres.
fn reach_m(robot: &Robot, way: &Vector3<f64>) -> f64 {
    let chassis = robot.chassis.collisions.iter().map(|c| c.reach_m(way));
    let wheels = robot.wheels.iter().map(|wheel| {
        let along = wheel.axis().dot(&way.xy()).abs();
        let across = (1.0 - along * along).max(0.0).sqrt();
        let half_widths_m = wheel.rollers.iter().map(|roller| {
            let lies = roller.axis_in_hub.z.abs();
            let round = (1.0 - lies * lies).max(0.0).sqrt();
            roller.center_in_hub_m.z.abs() + 0.5 * roller.length_m * lies + roller.radius_m * round
        });
        let half_width_m = half_widths_m.fold(0.0, f64::max);
        wheel.position_m().dot(way) + wheel.radius_m * across + half_width_m * along
    });
    chassis.chain(wheels).fold(0.0, f64::max)
}
