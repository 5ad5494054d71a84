//! Which controller of ros2_controllers drives a robot on tyres, and its geometry.
//!
//! | robot | controller |
//! |---|---|
//! | wheels to the left and right, none steered | `diff_drive_controller` |
//! | one wheel that is driven and steered, an axle that rolls along | `tricycle_controller` |
//! | one steered wheel, two driven on an axle | `tricycle_steering_controller` |
//! | one steered wheel, one driven | `bicycle_steering_controller` |
//! | two steered wheels, two driven on an axle | `ackermann_steering_controller` |
//! | all wheels steered | none that is released |

use ilon_robot::{Robot, Wheel};
use nalgebra::Vector3;

/// Tolerance of the geometry that a controller assumes, over the wheels' distances; chosen as for
/// controllers of rollers.
const WITHIN: f64 = 0.01;

/// A controller of ros2_controllers for a robot on tyres.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TyreController {
    /// `diff_drive_controller/DiffDriveController`.
    Differential {
        /// The joints of the wheels on the left, and on the right.
        sides: [Vec<String>; 2],
        /// Distance between both sides, in metres.
        separation_m: f64,
        /// Whether tyres scrub in turns: their axles do not lie on one line.
        is_skid: bool,
    },
    /// `tricycle_controller/TricycleController`.
    Tricycle {
        /// The joint that drives the wheel, and the one that steers it.
        joints: [String; 2],
        /// From the axle that rolls along to the steered wheel, in metres.
        wheelbase_m: f64,
        /// Largest steering angle to both sides, in radians.
        limit_rad: f64,
    },
    /// One of the controllers of the steering library.
    Steering {
        /// `tricycle`, `bicycle` or `ackermann`.
        kind: &'static str,
        /// The driven joints, right before left.
        traction: Vec<String>,
        /// The steering joints, right before left.
        steering: Vec<String>,
        /// From the driven axle to the steered one, in metres.
        wheelbase_m: f64,
        /// Distance of the driven wheels, and of the steered ones, in metres.
        tracks_m: [f64; 2],
    },
}

/// A controller with what all of them have.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TyreDrive {
    /// The controller.
    pub controller: TyreController,
    /// Radius of the wheels, in metres.
    pub radius_m: f64,
    /// Largest rate of the driven wheels, in rad/s; infinite for none.
    pub rate_rad_s: f64,
    /// Where the controller takes the robot's origin to be, in the body frame, in metres.
    pub origin_m: [f64; 2],
}

/// A wheel by its side.
struct Placed<'r> {
    wheel: &'r Wheel,
    /// The joint that steers it.
    steering: Option<usize>,
    x_m: f64,
    y_m: f64,
}

impl TyreDrive {
    /// The controller that can drive a robot on tyres.
    ///
    /// # Errors
    /// Why none can, in words.
    pub fn of(robot: &Robot) -> Result<Self, String> {
        let wheels: Vec<Placed> = robot
            .wheels
            .iter()
            .map(|wheel| placed(robot, wheel))
            .collect();
        let size_m = wheels
            .iter()
            .map(|of| of.x_m.hypot(of.y_m))
            .fold(0.0, f64::max);
        for of in &wheels {
            straight(robot, of)?;
        }
        let radius_m = robot.mean_wheel_radius_m();
        if let Some(of) = wheels
            .iter()
            .find(|of| (of.wheel.radius_m / radius_m - 1.0).abs() > WITHIN)
        {
            return Err(format!(
                "its wheels differ in radius, such as `{}`",
                of.wheel.name
            ));
        }
        let is_driven = |of: &&Placed| of.wheel.motor.effort_n_m > 0.0;
        let driven: Vec<&Placed> = wheels.iter().filter(is_driven).collect();
        let (steered, fixed): (Vec<&Placed>, Vec<&Placed>) =
            wheels.iter().partition(|of| of.steering.is_some());
        let rates = driven.iter().map(|of| of.wheel.motor.velocity_rad_s);
        let rate_rad_s = rates.fold(f64::INFINITY, f64::min);
        let found = if steered.is_empty() {
            differential(&driven, size_m)
        } else if fixed.is_empty() {
            Err(
                "all its wheels are steered, and of the released controllers none takes a swerve drive"
                    .to_owned(),
            )
        } else {
            steering(robot, (&steered, &fixed, &driven), size_m)
        };
        let (controller, origin_m) = found?;
        Ok(Self {
            controller,
            radius_m,
            rate_rad_s,
            origin_m,
        })
    }
}

type Found = Result<(TyreController, [f64; 2]), String>;

fn placed<'r>(robot: &'r Robot, wheel: &'r Wheel) -> Placed<'r> {
    let at = wheel.position_m();
    Placed {
        wheel,
        steering: robot.steering_of(wheel),
        x_m: at.x,
        y_m: at.y,
    }
}

/// Refuses a wheel that does not roll along the body's x axis, or a joint that steers the other
/// way.
fn straight(robot: &Robot, of: &Placed) -> Result<(), String> {
    let (name, n) = (&of.wheel.name, of.wheel.axis());
    if n.x.abs() > WITHIN {
        return Err(format!(
            "its wheel `{name}` does not roll along the body's x axis"
        ));
    }
    if n.y < 0.0 {
        return Err(format!(
            "its wheel `{name}` turns the other way than controllers take it: turn the `<axis>` of its joint round"
        ));
    }
    let Some(joint) = of.steering.map(|at| &robot.joints[at]) else {
        return Ok(());
    };
    if (joint.body_from_joint.rotation * Vector3::z()).z < 0.0 {
        return Err(format!(
            "its joint `{}` steers the other way than controllers take it: turn its `<axis>` upwards",
            joint.name
        ));
    }
    Ok(())
}

/// The mean place of wheels along x, if they stand on one axle.
fn axle_m(wheels: &[&Placed], size_m: f64) -> Option<f64> {
    let mean_m = wheels.iter().map(|of| of.x_m).sum::<f64>() / wheels.len() as f64;
    let is_on_it = |of: &&Placed| (of.x_m - mean_m).abs() < WITHIN * size_m;
    (!wheels.is_empty() && wheels.iter().all(is_on_it)).then_some(mean_m)
}

/// The wheels to the left and to the right, each at one distance from the same middle.
fn sides<'a, 'r>(
    wheels: &[&'a Placed<'r>],
    size_m: f64,
) -> Result<([Vec<&'a Placed<'r>>; 2], f64), String> {
    let middle_m = wheels.iter().map(|of| of.y_m).sum::<f64>() / wheels.len().max(1) as f64;
    let (left, right): (Vec<_>, Vec<_>) = wheels.iter().copied().partition(|of| of.y_m > middle_m);
    if left.len() != right.len() || left.is_empty() {
        return Err(format!(
            "of its {} driven or steered wheels there are {} on the left and {} on the right",
            wheels.len(),
            left.len(),
            right.len()
        ));
    }
    let reach_m = wheels
        .iter()
        .map(|of| (of.y_m - middle_m).abs())
        .sum::<f64>()
        / wheels.len() as f64;
    let off = |of: &&&Placed| ((of.y_m - middle_m).abs() - reach_m).abs() > WITHIN * size_m;
    if let Some(of) = wheels.iter().find(off) {
        let name = &of.wheel.name;
        return Err(format!(
            "its wheel `{name}` stands nearer to the middle, or further, than others"
        ));
    }
    Ok(([left, right], 2.0 * reach_m))
}

fn names(wheels: &[&Placed]) -> Vec<String> {
    wheels.iter().map(|of| of.wheel.name.clone()).collect()
}

fn differential(driven: &[&Placed], size_m: f64) -> Found {
    let (sides, separation_m) = sides(driven, size_m)?;
    let count = driven.len() as f64;
    let origin_m = [
        driven.iter().map(|of| of.x_m).sum::<f64>() / count,
        driven.iter().map(|of| of.y_m).sum::<f64>() / count,
    ];
    let controller = TyreController::Differential {
        is_skid: axle_m(driven, size_m).is_none(),
        sides: sides.map(|side| names(&side)),
        separation_m,
    };
    Ok((controller, origin_m))
}

fn steering(
    robot: &Robot,
    (steered, fixed, driven): (&[&Placed], &[&Placed], &[&Placed]),
    size_m: f64,
) -> Found {
    let axle = |wheels: &[&Placed], of: &str| {
        axle_m(wheels, size_m).ok_or_else(|| format!("its {of} wheels stand on several axles"))
    };
    let (ahead_m, behind_m) = (axle(steered, "steered")?, axle(fixed, "unsteered")?);
    let wheelbase_m = ahead_m - behind_m;
    if wheelbase_m <= 0.0 {
        return Err(
            "it is steered behind its axle, and controllers take steering ahead of it".to_owned(),
        );
    }
    let middle_m = fixed.iter().map(|of| of.y_m).sum::<f64>() / fixed.len() as f64;
    let origin_m = [behind_m, middle_m];
    let joint = |of: &Placed| {
        of.steering
            .map_or(String::new(), |at| robot.joints[at].name.clone())
    };
    let is_middle = |of: &Placed| (of.y_m - middle_m).abs() < WITHIN * size_m;
    let all_fixed = driven.iter().all(|of| of.steering.is_none());
    if let ([one], [drives]) = (steered, driven)
        && is_middle(one)
        && drives.steering.is_some()
    {
        let limits = one.steering.map_or([0.0; 2], |at| robot.joints[at].limits);
        let controller = TyreController::Tricycle {
            joints: [one.wheel.name.clone(), joint(one)],
            wheelbase_m,
            limit_rad: limits[1].min(-limits[0]),
        };
        return Ok((controller, origin_m));
    }
    let kind = match (steered, driven) {
        ([one], [_]) if all_fixed && is_middle(one) => "bicycle",
        ([one], [_, _]) if all_fixed && is_middle(one) => "tricycle",
        ([_, _], [_, _]) if all_fixed => "ackermann",
        _ => {
            return Err(format!(
                "{} of its wheels are steered and {} driven, which no controller takes together",
                steered.len(),
                driven.len()
            ));
        }
    };
    let right_first = |wheels: &[&Placed]| -> Result<(Vec<usize>, f64), String> {
        let mut order: Vec<usize> = (0..wheels.len()).collect();
        order.sort_by(|a, b| wheels[*a].y_m.total_cmp(&wheels[*b].y_m));
        let track_m = match wheels.len() {
            1 => 0.0,
            _ => sides(wheels, size_m)?.1,
        };
        Ok((order, track_m))
    };
    let (traction, track_m) = right_first(driven)?;
    let (steers, steered_track_m) = right_first(steered)?;
    let controller = TyreController::Steering {
        kind,
        traction: traction
            .iter()
            .map(|at| driven[*at].wheel.name.clone())
            .collect(),
        steering: steers.iter().map(|at| joint(steered[*at])).collect(),
        wheelbase_m,
        tracks_m: [track_m, steered_track_m],
    };
    Ok((controller, origin_m))
}
