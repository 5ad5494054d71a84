//! What could be tried, in words.

use ilon_trace::{Header, Summary};

use super::events::{Event, EventKind, when};
use super::faults::Trouble;
use crate::text::{energy, length, percent};

/// What could be tried, each with what the run itself says that it would gain.
pub(super) fn tries(
    header: &Header,
    summary: &Summary,
    events: &[Event],
    troubles: &[Trouble],
) -> Vec<String> {
    let mut tries = Vec::new();
    if let (Some(ideal), Some(contact), true, false) = (
        summary.twist_ideal_mean,
        summary.twist_contact_mean,
        header.open_loop,
        header.commands_by_contact,
    ) {
        let ratio = summary.twist_ratio_ideal;
        let missing = [
            (ratio.vx, ideal.vx_m_s, contact.vx_m_s, "ahead"),
            (ratio.vy, ideal.vy_m_s, contact.vy_m_s, "sideways"),
            (
                ratio.omega,
                ideal.omega_rad_s,
                contact.omega_rad_s,
                "in turning",
            ),
        ]
        .into_iter()
        .filter_map(|(driven, ideal, contact, way)| {
            driven.map(|_| ((ideal - contact) / ideal, way))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((gain, way)) = missing.filter(|(gain, _)| *gain > 0.003) {
            tries.push(format!(
                "Command by the contact kinematics, <code>guidance.kinematics = \"contact\"</code>: <b>{} more {way}</b>, which is \
                 what the rollers' geometry takes.",
                percent(gain)
            ));
        }
    }
    if let (Some(ideal_m), Some(contact_m)) = (
        summary.odometry_ideal.m_per_m,
        summary.odometry_contact.m_per_m,
    ) && ideal_m > 1e-3
        && contact_m < 0.5 * ideal_m
    {
        tries.push(format!(
            "Reckon with the rollers that touch (<code>ilon_control::Odometry</code>): drift falls from {} to <b>{}</b> for each metre.",
            length(ideal_m),
            length(contact_m)
        ));
    }
    let at_start: f64 = events
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Slide(_)) && e.from_s < 0.2)
        .map(|e| e.lost_j)
        .sum();
    if let Some(slip_j) = summary
        .energy
        .slip_j
        .filter(|&j| j > 0.05 && at_start > 0.3 * j)
    {
        let how = if header.open_loop {
            "raise <code>twist.ramp_s</code>"
        } else {
            "begin nearer to the reference, or weigh torques by grip"
        };
        tries.push(format!(
            "Start more gently ({how}): {} of the {} that sliding cost were lost in the first moments, <b>{}</b>.",
            energy(at_start.min(slip_j)),
            energy(slip_j),
            percent((at_start / slip_j).min(1.0))
        ));
    }
    if let (Some(share), Some(limit)) = (summary.saturated_share, header.wheel_rate_limit_rad_s)
        && share > 0.2
    {
        tries.push(format!(
            "Raise <code>guidance.wheel_rate_limit_rad_s</code> ({limit:.3} rad/s) or slow the reference: tasks waited for <b>{}</b> of the run.",
            percent(share)
        ));
    }
    if let Some(floor) = troubles.iter().find(|trouble| trouble.is_slippery) {
        tries.push(format!(
            "Slow down where the floor is slippery, or weigh torques by grip (compare <code>mecanum4_slippery_by_grip</code> with \
             <code>mecanum4_slippery_plain</code>): what was lost was lost {}.",
            when(floor.from_s, floor.until_s)
        ));
    }
    tries.truncate(4);
    tries
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reckoning by the rollers that touch is worth a try where it halves a drift of more than a millimetre a metre.
    #[test]
    fn reckoning_with_rollers_is_proposed_where_it_halves_the_drift() {
        let proposed = |ideal_m: f64, contact_m: f64| {
            let mut summary = Summary::default();
            summary.odometry_ideal.m_per_m = Some(ideal_m);
            summary.odometry_contact.m_per_m = Some(contact_m);
            let tries = tries(&Header::default(), &summary, &[], &[]);
            tries.iter().any(|line| line.contains("Odometry"))
        };
        assert!(proposed(0.02, 0.009));
        assert!(!proposed(0.02, 0.011));
        assert!(!proposed(0.0009, 0.0));
    }
}
