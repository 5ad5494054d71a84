//! Checks whether differences smaller than the deflection of real rollers decide which wheels of a
//! robot touch the ground.
//!
//! Four wheels on a rigid chassis stand on a plane with contacts of stiffness k each. If one of
//! them is d higher than the plane of the others, a load of k d / 4 moves from each wheel of its
//! diagonal to the other diagonal, so that under a load N on each wheel all touch while k d < 4 N.
//! If hubs rise and fall by t, two wheels of a diagonal may be up while the other two are down, d =
//! 2 t: all touch while k t < 2 N.

use ilon_robot::{Robot, RollerForm, Scale, StandingPose, Wheel};
use nalgebra::Vector3;

/// The share of a wheel's load that may move to others without a remark. Chosen.
const MOVED: f64 = 0.1;

/// Height differences by rounding, in metres. Chosen.
const EXACT_M: f64 = 1e-9;

/// A height difference of redundant wheels, in metres, its cause, and the largest contact stiffness
/// in N/m with which all wheels stay down.
struct Uneven {
    words: String,
    bears_n_m: f64,
}

/// Remarks on a robot with redundant wheels on contacts of a given stiffness in N/m, by default
/// that for a robot of its size.
pub fn remark(
    robot: &Robot,
    contact_stiffness_n_m: Option<f64>,
    gravity_m_s2: f64,
) -> Option<String> {
    let is_rigid = |wheel: &Wheel| {
        let is_modelled = |form: &RollerForm| matches!(form, RollerForm::AsModelled(_));
        let mut forms = wheel.rollers.iter().map(|roller| &roller.form);
        wheel.surface.tread.is_none()
            && wheel.surface.axial_play_m == 0.0
            && !forms.any(is_modelled)
    };
    if !robot.has_wheels_to_spare() || !robot.wheels.iter().all(is_rigid) {
        return None;
    }
    let scale = Scale::of(robot, gravity_m_s2);
    let load_n = scale.load_kg * scale.gravity_m_s2;
    let stiffness_n_m =
        contact_stiffness_n_m.unwrap_or_else(|| ilon_world::contact_stiffness_n_m(&scale));
    let pose = robot.standing_pose();
    let uneven = [
        of_hubs(robot, load_n),
        (pose.as_ref()).and_then(|pose| of_standing(robot, pose, load_n)),
        pose.and_then(|pose| of_leans(robot, &pose.up_in_body(), load_n)),
    ];
    let uneven = uneven.into_iter().flatten();
    let softest = |a: &Uneven, b: &Uneven| a.bears_n_m.total_cmp(&b.bears_n_m);
    let Uneven { words, bears_n_m } = uneven.min_by(softest)?;
    let moved = stiffness_n_m / bears_n_m;
    let (effect, softer_n_m) = match moved > 1.0 {
        true => (
            format!(
                "the robot stands on two or three of its {} wheels. Which ones touch decides slip and heading, and depends on less than real rollers yield",
                robot.wheels.len()
            ),
            bears_n_m,
        ),
        false => (
            format!(
                "{:.0} % of a wheel's load moves to others. Slip and heading follow that share, which depends on less than real rollers yield",
                100.0 * moved
            ),
            MOVED * bears_n_m,
        ),
    };
    let stay = if moved > 1.0 {
        "all wheels stay down"
    } else {
        "hardly any moves"
    };
    (moved > MOVED).then(|| {
        format!(
            "the wheels: {words}, and a rigid contact yields only {:.2} um under a wheel's load: {effect}. On treads softer than {softer_n_m:.0e} N/m {stay}: \
             give the stiffness of yours as `rollers.tread.stiffness_n_m`",
            1e6 * load_n / stiffness_n_m,
        )
    })
}

/// The rise and fall of hubs as rollers pass.
fn of_hubs(robot: &Robot, load_n: f64) -> Option<Uneven> {
    let wheels = robot.wheels.iter().filter(|wheel| !wheel.is_round());
    let travels_m = wheels.map(|wheel| wheel.hub_heights().travel_m);
    let travel_m = travels_m
        .reduce(f64::max)
        .filter(|travel_m| *travel_m > EXACT_M)?;
    Some(Uneven {
        words: format!(
            "their hubs rise and fall by {:.3} mm as rollers pass",
            1e3 * travel_m
        ),
        bears_n_m: 2.0 * load_n / travel_m,
    })
}

/// A wheel that is higher than the plane of the others.
fn of_standing(robot: &Robot, pose: &StandingPose, load_n: f64) -> Option<Uneven> {
    let gaps = robot.wheels.iter().map(|wheel| (pose.gap_m(wheel), wheel));
    let (gap_m, highest) = gaps
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(gap_m, _)| *gap_m > EXACT_M)?;
    Some(Uneven {
        words: format!(
            "they do not end in one plane, as it stands `{}` is {:.4} mm off the floor",
            highest.name,
            1e3 * gap_m
        ),
        bears_n_m: 4.0 * load_n / gap_m,
    })
}

/// A wheel whose axis leans: it touches now with one end of a roller, now with the other.
fn of_leans(robot: &Robot, up: &Vector3<f64>, load_n: f64) -> Option<Uneven> {
    let sine = |wheel: &Wheel| (wheel.body_from_hub.rotation * Vector3::z()).dot(up).abs();
    let travel_m = |wheel: &Wheel| {
        let ends_m = wheel.rollers.iter().map(|roller| {
            roller.center_in_hub_m.z.abs() + 0.5 * roller.length_m * roller.axis_in_hub.z.abs()
        });
        2.0 * sine(wheel) * ends_m.fold(0.0, f64::max)
    };
    let travels_m = robot.wheels.iter().map(|wheel| (travel_m(wheel), wheel));
    let (travel_m, wheel) = travels_m
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(travel_m, wheel)| *travel_m > EXACT_M && !wheel.has_tyre())?;
    Some(Uneven {
        words: format!(
            "the axis of `{}` leans by {:.3} deg, so that its hub rises and falls by up to {:.3} mm as rollers pass",
            wheel.name,
            libm::asin(sine(wheel)).to_degrees(),
            1e3 * travel_m
        ),
        bears_n_m: 2.0 * load_n / travel_m,
    })
}
