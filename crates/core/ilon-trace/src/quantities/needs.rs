//! What a run needs for its quantities to exist.

/// Quantities that exist under a condition, by the start of their names (longer ones first), with
/// that condition.
const NEEDS: &[(&[&str], &str)] = &[
    (
        &["ledger.belief"],
        "it needs a controller that believes in another robot; write `[controller.robot]`",
    ),
    (
        &["ledger.incline"],
        "the ground has no inclines, or the robot drives on none; give the floor `ramps`, and let the robot drive up one",
    ),
    (
        &["rate_conflict_share"],
        "it is a share of what the wheels turned, and none turned; give the robot a motion",
    ),
    (
        &["twist_ripple"],
        "it is that of an open-loop drive over the window of the means, which begins `twist.settle_s` after the last ramp; drive a \
         `[twist]`, and let `run.duration_s` reach beyond that",
    ),
    (
        &["twist_ratio"],
        "it is taken along what the robot drives, over the window of the means, which begins `twist.settle_s` after the last ramp; drive \
         that component, and let `run.duration_s` reach beyond that",
    ),
    (
        &["twist_", "hub_ripple"],
        "it is taken over the window of the means, which begins `twist.settle_s` after the last ramp; let `run.duration_s` reach beyond \
         that, or lower `twist.settle_s`",
    ),
    (
        &["position_converged"],
        "the position error is not below 5 cm at the end of the run, or there is no path to follow; let `run.duration_s` be longer, or give \
         a `[reference]`",
    ),
    (
        &["heading_converged"],
        "the heading error is not below 3 degrees at the end of the run, or there is no path to follow; let `run.duration_s` be longer, or \
         give a `[reference]`",
    ),
    (
        &["position_error", "heading_error"],
        "there is no path to follow; give the scenario a `[reference]`",
    ),
    (
        &["seen_"],
        "the robot knows its pose exactly; give the scenario `[sensors.pose]` or `[sensors.fusion]`",
    ),
    (
        &["saturated_share"],
        "no guidance drives the robot; give the scenario a `[reference]`",
    ),
    (
        &["odometry_joints"],
        "no joints move the wheels' hubs; the figure is for robots whose wheels are on joints",
    ),
    (
        &["odometry_"],
        "it is taken per metre or per turn of the way, and the robot hardly moves; let it drive or turn further",
    ),
    (
        &["design."],
        "the arrangement is singular, or no wheel has a rate limit; take other angles or places of wheels, or give the wheels limits",
    ),
    (
        &["storage_rise_j"],
        "only the passive law stores anything; give the scenario `wheel_loop.law` = \"passive\"",
    ),
    (
        &["chassis_load_share"],
        "nothing of the ground carries the robot while it is recorded; let it stand on the ground",
    ),
    (
        &["slip_speed", "friction_used_max"],
        "no wheel touches the ground while it is recorded; let the robot stand on its wheels",
    ),
    (
        &["energy.unexplained_share"],
        "too little energy is turned over for a meaningful share; let the robot drive further",
    ),
];

/// Why a run may lack a quantity, and what gives it one; `None` of what every run has.
pub fn needs(quantity: &str) -> Option<&'static str> {
    let is_of = |beginnings: &[&str]| beginnings.iter().any(|it| quantity.starts_with(it));
    let known = NEEDS.iter().find(|(beginnings, _)| is_of(beginnings));
    known.map(|(_, needs)| *needs)
}
