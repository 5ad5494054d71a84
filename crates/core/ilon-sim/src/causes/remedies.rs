//! Remedies that the figures of a run suggest.

use ilon_trace::{Cause, Summary};

use super::null::Null;
use crate::scenario::{Kinematics, Motion, Saturation, Scenario, Twist, WheelLaw};

/// From this loss of motion to the rollers' geometry on, contact kinematics are tried (a share).
/// Chosen.
const GEOMETRY_TAKES: f64 = 3e-3;
/// From this lag of the wheel loops on, stiffer loops are tried (a share of the motion). Chosen.
const LOOPS_LACK: f64 = 0.02;
/// From this loss to sliding on, a gentler start is tried (a share of the motors' work). Chosen.
const SLIDING_TAKES: f64 = 0.03;
/// From this share of the run with a saturated task on, a higher limit is tried. Chosen.
const TASKS_WAIT: f64 = 0.2;

/// The friction that the torque law is given, as a share of the floor's. Chosen.
const ESTIMATED: f64 = 0.8;

/// The remedies, each with its change of the scenario.
pub(super) fn of(scenario: &Scenario, summary: &Summary) -> Vec<(Cause, Null)> {
    let mut remedies: Vec<(Cause, Null)> = Vec::new();
    let mut add = |key: String, words: &str, change: Null| {
        let words = words.to_owned();
        remedies.push((Cause { key, words }, change));
    };
    let is_open_loop = !matches!(scenario.motion(), Some(Motion::Tracked(_)));
    let slips = summary.energy.slip_j.unwrap_or(0.0)
        > SLIDING_TAKES * summary.energy.motor_positive_j.unwrap_or(f64::INFINITY);
    if is_open_loop
        && scenario.guidance.kinematics == Kinematics::Ideal
        && lacks(summary, Link::Geometry) > GEOMETRY_TAKES
    {
        add(
            "guidance.kinematics = \"contact\"".to_owned(),
            "commands by the rollers that touch",
            Box::new(|scenario, _| scenario.guidance.kinematics = Kinematics::Contact),
        );
    }
    if scenario.wheel_loop.law == WheelLaw::Pid
        && is_open_loop
        && lacks(summary, Link::Loops) > LOOPS_LACK
        && let Some(gain) = scenario.wheel_loop.proportional_n_m_s
    {
        add(
            format!("wheel_loop.proportional_n_m_s = {:.3}", 4.0 * gain),
            "stiffer wheel loops",
            Box::new(|scenario, _| {
                let gain = &mut scenario.wheel_loop.proportional_n_m_s;
                *gain = gain.map(|gain| 4.0 * gain);
            }),
        );
    }
    // With a schedule a longer ramp leads elsewhere.
    let of_one = |twist: &&Twist| twist.schedule.is_empty();
    if slips && let Some(twist) = scenario.twist.as_ref().filter(of_one) {
        let ramp_s = 2.0 * twist.ramp_s.max(0.1);
        add(
            format!("twist.ramp_s = {ramp_s}"),
            "a gentler start",
            Box::new(move |scenario, _| {
                if let Some(twist) = &mut scenario.twist {
                    twist.ramp_s = ramp_s;
                }
            }),
        );
    }
    if slips && !is_open_loop && scenario.wheel_loop.law == WheelLaw::Pid {
        // Estimated by as much as the floor may be worse than stated: at its limit wheels slide.
        let friction = ilon_trace::significant(ESTIMATED * scenario.world.floor.friction(), 2);
        add(
            format!("wheel_loop = {{ law = \"prioritised_torque\", friction = {friction} }}"),
            "torques weighed by grip",
            Box::new(move |scenario, _| {
                scenario.wheel_loop.law = WheelLaw::PrioritisedTorque;
                scenario.wheel_loop.friction = Some(friction);
            }),
        );
    }
    if let Some(limit_rad_s) = scenario.guidance.wheel_rate_limit_rad_s
        && scenario.guidance.saturation != Saturation::None
        && summary
            .saturated_share
            .is_some_and(|share| share > TASKS_WAIT)
    {
        add(
            format!("guidance.wheel_rate_limit_rad_s = {:.3}", 1.5 * limit_rad_s),
            "a higher limit on commanded wheel rates",
            Box::new(|scenario, _| {
                let limit = &mut scenario.guidance.wheel_rate_limit_rad_s;
                *limit = limit.map(|limit_rad_s| 1.5 * limit_rad_s);
            }),
        );
    }
    remedies
}

/// Whether there is a remedy to try.
pub(crate) fn has_remedies(scenario: &Scenario, summary: &Summary) -> bool {
    !of(scenario, summary).is_empty()
}

/// Two links of the chain from commanded to real motion, between which motion is lost.
#[derive(Clone, Copy)]
enum Link {
    Loops,
    Geometry,
}

/// The largest share of a commanded component of motion that is lost in this link.
fn lacks(summary: &Summary, link: Link) -> f64 {
    let (Some(asked), Some(ideal), Some(contact)) = (
        summary.twist_asked_mean,
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
    ) else {
        return 0.0;
    };
    let ratio = summary.twist_ratio_ideal;
    let driven = [ratio.vx, ratio.vy, ratio.omega].map(|ratio| ratio.is_some());
    let of = |twist: ilon_robot::Twist| [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s];
    let (asked, ideal, contact) = (of(asked), of(ideal), of(contact));
    let share = |axis: usize| match link {
        Link::Loops => (asked[axis] - ideal[axis]) / asked[axis],
        Link::Geometry => (ideal[axis] - contact[axis]) / ideal[axis],
    };
    let shares = (0..3).filter(|axis| driven[*axis]).map(share);
    shares.filter(|share| share.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use ilon_robot::Twist;

    use super::*;

    /// Of 0.4 m/s commanded the loops leave 0.2, of which the rollers leave 0.19: half of the
    /// command, and a twentieth of what is left of it. Only the component that was commanded
    /// counts.
    #[test]
    fn each_link_takes_its_share_of_what_reaches_it() {
        let mut summary = Summary::default();
        summary.twist_asked_mean = Some(Twist::new(0.4, 0.0, 0.0));
        summary.twist_ideal_mean = Some(Twist::new(0.2, 0.1, 0.0));
        summary.twist_contact_mean = Some(Twist::new(0.19, 0.0, 0.0));
        summary.twist_ratio_ideal.vx = Some(0.5);
        assert!((lacks(&summary, Link::Loops) - 0.5).abs() < 1e-12);
        assert!((lacks(&summary, Link::Geometry) - 0.05).abs() < 1e-12);
    }
}
