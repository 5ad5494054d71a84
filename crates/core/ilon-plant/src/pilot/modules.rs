//! Where steered wheels are sent: each module's angle follows the velocity that a twist gives its
//! wheel.
//!
//! A wheel rolls along u. Its module turns until u lies along v_h = v + omega k x b, eq. (2), or
//! against it, whichever is nearer to where the module is sent now; the wheel then turns the other
//! way. What the wheel turns at while its module is on the way, the kinematics of the measured
//! angles says: u . v_h / rho, the cosine of the missing angle of the whole.

use std::f64::consts::{FRAC_PI_2, PI};

use ilon_control::Kinematics;
use ilon_robot::{Robot, Twist, wrap_angle};
use ilon_scenario::scenario::Scenario;
use nalgebra::{Isometry3, Vector3};

/// A wheel that is asked to move slower than this keeps its angle, in m/s (chosen): a robot that
/// has arrived does not turn its modules by the noise of its errors.
const STILL_M_S: f64 = 1e-3;

/// The modules of a robot that the pilot steers.
pub(super) struct Modules(Vec<Module>);

/// A steered wheel.
struct Module {
    /// Its steering joint, among the robot's.
    joint: usize,
    wheel: usize,
    /// 1 where the joint turns counter-clockwise seen from above, else -1.
    sense: f64,
    limits: [f64; 2],
    target_rad: f64,
}

impl Modules {
    /// Those of a robot but for joints that have setpoints; `None` without any.
    pub fn of(robot: &Robot, scenario: &Scenario) -> Option<Self> {
        let module = |wheel: usize| {
            let joint = robot.steering_of(&robot.wheels[wheel])?;
            let of = &robot.joints[joint];
            let asked = scenario.robot.joints.get(&of.name);
            if asked.is_some_and(|asked| !asked.setpoints.is_empty()) {
                return None;
            }
            Some(Module {
                joint,
                wheel,
                sense: (of.body_from_joint.rotation * Vector3::z()).z.signum(),
                limits: of.limits,
                target_rad: of.servo()?.target,
            })
        };
        let modules: Vec<Module> = (0..robot.wheels.len()).filter_map(module).collect();
        (!modules.is_empty()).then_some(Self(modules))
    }

    /// Sends them where a twist of the body's origin wants them, with the hubs where they are, and
    /// the joints at these positions.
    pub fn aim(
        &mut self,
        twist_in_body: Twist,
        (kinematics, hubs): (&Kinematics, &[Isometry3<f64>]),
        positions: &[f64],
    ) {
        for module in &mut self.0 {
            let Some(v_h) = kinematics.hub_velocity_m_s(module.wheel, twist_in_body) else {
                continue;
            };
            if v_h.norm() < STILL_M_S {
                continue;
            }
            let n = hubs[module.wheel].rotation * Vector3::z();
            let now_rad = libm::atan2(-n.x, n.y);
            let sent_rad = now_rad + module.sense * (module.target_rad - positions[module.joint]);
            let missing_rad = wrap_angle(libm::atan2(v_h.y, v_h.x) - sent_rad);
            let shorter_rad = if missing_rad.abs() > FRAC_PI_2 {
                wrap_angle(missing_rad + PI)
            } else {
                missing_rad
            };
            module.send(module.target_rad + module.sense * shorter_rad);
        }
    }

    /// Where each steering joint is sent, in rad, by its index among the robot's joints.
    pub fn targets_rad(&self) -> impl Iterator<Item = (usize, f64)> {
        self.0.iter().map(|module| (module.joint, module.target_rad))
    }
}

impl Module {
    /// Sends it to an angle, or half a turn from there, where that is within its limits.
    fn send(&mut self, asked_rad: f64) {
        let [lower, upper] = self.limits;
        let is_within = |rad: &f64| (lower..=upper).contains(rad);
        let ways = [asked_rad, asked_rad - PI, asked_rad + PI];
        let way_rad = ways.into_iter().find(is_within);
        self.target_rad = way_rad.unwrap_or_else(|| asked_rad.max(lower).min(upper));
    }
}
