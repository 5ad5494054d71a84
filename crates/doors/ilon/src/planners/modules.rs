//! A real swerve drive for the planners: its modules push in any direction, so that the planners'
//! model is its own.

use ilon_control::{Kinematics, SpeedLimits, WheelLoads};
use ilon_robot::Robot;
use nalgebra::Vector2;

use super::swerve::{SHARE, corners, whole};
use super::{NoSwerve, Swerve};
use crate::scenario::Scenario;

impl Swerve {
    /// A robot whose four wheels on tyres are all driven and steered, on the floor of a scenario. A
    /// module pushes with what the least loaded wheel holds at rest, or its motor gives, less a
    /// tenth.
    ///
    /// # Errors
    /// If it is no such robot, or its wheels have no rate limit.
    pub fn of_modules(robot: &Robot, scenario: &Scenario) -> Result<Self, NoSwerve> {
        let is_module = |wheel: &&ilon_robot::Wheel| {
            robot.steering_of(wheel).is_some() && wheel.motor.effort_n_m > 0.0
        };
        if let Some(wheel) = robot.wheels.iter().find(|wheel| !is_module(wheel)) {
            return Err(NoSwerve::NotSteered(wheel.name.clone()));
        }
        let modules_m = corners(robot)?;
        let whole = whole(robot).ok_or(NoSwerve::NothingToGive)?;
        let (mass_kg, inertia_kg_m2) = (whole.mass_kg, whole.inertia_kg_m2.m33);
        let kinematics = Kinematics::new(robot).map_err(|_| NoSwerve::NothingToGive)?;
        let wheels = || robot.wheels.iter();
        let rates: Vec<f64> = wheels().map(|wheel| wheel.motor.velocity_rad_s).collect();
        let tops = SpeedLimits::new(&kinematics, &rates);
        let top = [tops.top_speed_range_m_s().0, tops.top_yaw_rate_rad_s()];
        let mut loads_n = vec![0.0; robot.wheels.len()];
        WheelLoads::new(robot, scenario.world.gravity_m_s2).fill_n(Vector2::zeros(), &mut loads_n);
        let friction = scenario.world.floor.friction();
        let each = wheels().zip(loads_n).map(|(wheel, load_n)| {
            let motor_n = wheel.motor.effort_n_m / wheel.radius_m;
            motor_n.min(friction * load_n)
        });
        let force_n = SHARE * each.fold(f64::INFINITY, f64::min);
        let acceleration_box = box_within(&modules_m, force_n, (mass_kg, inertia_kg_m2));
        Self::with(robot, force_n, top, acceleration_box)
    }
}

/// Accelerations ahead, left and turning, of which every corner takes no more than a force from any
/// module, in the proportions of the largest of each alone. Modules share a push equally, and a
/// turn across their distance from the origin.
fn box_within(
    modules_m: &[[f64; 2]; 4],
    force_n: f64,
    (mass_kg, inertia_kg_m2): (f64, f64),
) -> [f64; 3] {
    let lever_m: f64 = modules_m.iter().map(|[x, y]| x.hypot(*y)).sum();
    let tops = [
        4.0 * force_n / mass_kg,
        4.0 * force_n / mass_kg,
        lever_m * force_n / inertia_kg_m2,
    ];
    // At a corner each module pushes force_n ahead, force_n to the left, and force_n across b.
    let used = modules_m.iter().flat_map(|[x, y]| {
        let far = x.hypot(*y);
        let (ahead, left) = (-y / far, x / far);
        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(a, l)| f64::hypot(a + ahead, l + left))
    });
    let most = used.fold(1.0, f64::max);
    tops.map(|top| top / most)
}
