//! Warnings about a finished run, or about a robot that has settled at its start.

use ilon_robot::{BodyJoint, JointKind, Robot};
use ilon_trace::metrics::Energy;
use ilon_trace::quantities::{self, Measure};
use ilon_trace::{Change, Convergence, GroundPatch, Quantity, Rows, Summary, Twin};
use ilon_world::{FreeBodyId, World};

/// Above this residual of the contact law, in m/s, a contact is no longer rigid. Chosen.
const WORST_RESIDUAL_M_S: f64 = 1e-3;

/// An energy that the balance does not explain, beyond this share of the energy turned over, means
/// that the step did not resolve something. So does a loss below zero by this share. Chosen.
const WORST_UNEXPLAINED: f64 = 0.01;

/// Energies below this, in J, are rounding of what a robot at rest turns over. Chosen.
const LEAST_LOSS_J: f64 = 1e-4;

/// Wheels whose rates are off by this share of the fastest target do not merely lag: their loops
/// oscillate, if these are unstable. Chosen.
const SWINGING: f64 = 0.05;

/// A wheel in the air for more than this share of the run does not carry the robot. Chosen.
const MOST_AIRBORNE: f64 = 0.5;

/// Remarks how far the joints between bodies are from zero at the start: the deflection of the
/// robot's springs.
pub fn of_joints(robot: &Robot, positions: &[f64]) -> Option<String> {
    // What rounds to zero is no deflection.
    let moved = |(_, position): &(&BodyJoint, &f64)| position.abs() >= 1e-4;
    let place = |(joint, position): (&BodyJoint, &f64)| match joint.kind {
        JointKind::Turns => format!("`{}` at {position:.4} rad", joint.name),
        JointKind::Slides => format!("`{}` at {:.2} mm", joint.name, 1e3 * position),
    };
    let places: Vec<String> = robot
        .joints
        .iter()
        .zip(positions)
        .filter(moved)
        .map(place)
        .collect();
    (!places.is_empty()).then(|| {
        format!(
            "at the start springs, stops and ground are in equilibrium, with joint{} {}",
            if places.len() == 1 { "" } else { "s" },
            places.join(", ")
        )
    })
}

/// Of patches of the floor that no wheel was on: they are not where the scenario's author meant
/// them, or the robot is not.
pub fn of_missed_patches<R: Rows>(rows: &R) -> Result<Option<String>, R::Error> {
    let header = rows.header();
    let patches = header.ground.as_ref().map_or(&[][..], |g| &g.patches);
    let missed = patches.iter().zip(nearest_wheels(rows, patches)?);
    let missed = missed.enumerate().filter(|(_, (_, near))| near.off_m > 0.0);
    let missed = missed.map(|(index, (patch, near))| {
        let [x_m, y_m] = patch.center_m;
        let place = format!("patch {index} of `world.floor.patches`, at ({x_m}, {y_m}) m");
        match near.off_m.is_finite() {
            true => format!(
                "{place}: `{}` came nearest, {:.3} m from it at {:.2} s",
                header.wheels[near.wheel].name, near.off_m, near.t_s
            ),
            false => format!("{place}: it is there from {} s on", patch.from_s),
        }
    });
    let missed: Vec<String> = missed.collect();
    Ok((!missed.is_empty()).then(|| format!("no wheel was ever on {}", missed.join("; "))))
}

/// The wheel that came nearest to a patch while the patch was there.
#[derive(Clone, Copy)]
struct Nearest {
    /// Between wheel and patch, in metres: 0 of a wheel on it.
    off_m: f64,
    wheel: usize,
    t_s: f64,
}

fn nearest_wheels<R: Rows>(rows: &R, patches: &[GroundPatch]) -> Result<Vec<Nearest>, R::Error> {
    let none = Nearest {
        off_m: f64::INFINITY,
        wheel: 0,
        t_s: 0.0,
    };
    let mut nearest = vec![none; patches.len()];
    if patches.is_empty() {
        return Ok(nearest);
    }
    let mut before: Vec<Option<[f64; 2]>> = vec![None; rows.header().wheels.len()];
    rows.each_batch(&mut |some| {
        for (record, wheels) in some.steps() {
            let t_s = record.t_s;
            for (wheel, sample) in wheels.iter().enumerate().filter(|(_, it)| it.touched()) {
                let at = sample.contact_m(record.truth.pose);
                let from = before[wheel].replace(at).unwrap_or(at);
                // A small patch may lie between two rows.
                let rolled_m = (at[0] - from[0]).hypot(at[1] - from[1]);
                for (patch, nearest) in patches.iter().zip(&mut nearest) {
                    let off_m = (patch.distance_m(at) - rolled_m).max(0.0);
                    if patch.is_there(t_s) && off_m < nearest.off_m {
                        *nearest = Nearest { off_m, wheel, t_s };
                    }
                }
            }
        }
    })?;
    Ok(nearest)
}

/// Of free bodies of which the robot touched none.
pub fn of_untouched_bodies<R: Rows>(rows: &R) -> Result<Option<String>, R::Error> {
    let bodies = &rows.header().bodies;
    if bodies.is_empty() {
        return Ok(None);
    }
    let mut is_touched = false;
    rows.each_batch(&mut |some| {
        let mut samples = some.steps().flat_map(|(record, _)| record.bodies);
        is_touched |= samples.any(|body| body.push_n > 0.0);
    })?;
    let names: Vec<String> = bodies.iter().map(|it| format!("`{}`", it.name)).collect();
    Ok((!is_touched).then(|| format!("the robot never touched {}", names.join(", "))))
}

/// Remarks free bodies that were too heavy for their support.
pub fn of_bodies(robot: &Robot, world: &World) -> Vec<String> {
    /// A body pressed deeper than this, in wheel radii, was not supported. Chosen.
    const DEEP: f64 = 0.1;
    let radii_m = robot.wheels.iter().map(|wheel| wheel.radius_m);
    let deep_m = DEEP * radii_m.fold(f64::INFINITY, f64::min);
    let remark = |id: &FreeBodyId| {
        let pressed_m = world.free_body(*id)?.pressed_m;
        let name = world.free_body_name(*id)?;
        (pressed_m > deep_m).then(|| {
            format!(
                "body `{name}` and what it touched overlapped by {:.1} mm: either they came that far within a step, which a shorter `run.physics_dt_s` \
                 mends, or contacts of this stiffness do not bear the load: make it lighter, or raise `world.solver.contact_stiffness_n_m`",
                1e3 * pressed_m
            )
        })
    };
    world.free_bodies().iter().filter_map(remark).collect()
}

/// Remarks on the figures of a run.
pub fn of_summary(summary: &Summary, has_unstable_loops: bool) -> Vec<String> {
    let mut remarks = Vec::new();
    if let (true, Some(off_rad_s), Some(most_rad_s)) = (
        has_unstable_loops,
        summary.wheel_rate_error_rms_rad_s,
        summary.wheel_rate_command_max_rad_s,
    ) && off_rad_s > SWINGING * most_rad_s
    {
        remarks.push(format!(
            "the wheel loops swung: wheels were {off_rad_s:.2} rad/s off their targets (rms) of up to {most_rad_s:.2} rad/s; what slid, and how far \
             the robot was off, comes from gains that are unstable with this period or latency, and not from the floor"
        ));
    }
    remarks.extend(of_wheels_in_the_air(summary));
    if let Some(residual_m_s) = summary.contact_residual_max_m_s
        && residual_m_s > WORST_RESIDUAL_M_S
    {
        remarks.push(format!(
            "the contacts could not all be solved: the worst missed its law by {:.2} mm/s in a step; what happened then is \
             uncertain by as much (column `contact_residual_m_s`); a shorter `run.physics_dt_s` may help",
            1e3 * residual_m_s
        ));
    }
    remarks.extend(of_energy(&summary.energy));
    remarks
}

/// Remarks wheels in the air for most of the run: one or two that do not carry the robot, or so
/// many that it hops.
fn of_wheels_in_the_air(summary: &Summary) -> Option<String> {
    let wheels = summary.wheels.iter();
    let aloft = wheels.filter_map(|wheel| {
        let share = wheel.lost_contact.filter(|share| *share > MOST_AIRBORNE)?;
        Some(format!("`{}` for {:.0} %", wheel.name, 100.0 * share))
    });
    let aloft: Vec<String> = aloft.collect();
    // Two wheels or fewer cannot carry the robot, so it stands on others in turn, or lies.
    let hops = aloft.len() + 2 > summary.wheels.len();
    let lies = summary.chassis_load_share.is_some_and(|share| share > 0.5);
    let what = match (aloft.len(), hops) {
        (0, _) => return None,
        (_, true) if lies => "the robot lies on its chassis",
        (_, true) => "the robot hops from wheel to wheel, which carry it in turn",
        (1, false) => "it does not carry the robot",
        (_, false) => "they do not carry the robot",
    };
    Some(format!(
        "in the air were, of the run, {}: {what}",
        aloft.join(", ")
    ))
}

/// Remarks energies that do not balance, and losses that added energy.
fn of_energy(energy: &Energy) -> Vec<String> {
    const REMEDY: &str = "the step is too long for this motion, or the wheel loops are too stiff for the step; shorten \
                          `run.physics_dt_s` or lower `wheel_loop.bandwidth_rad_s`";
    let mut remarks = Vec::new();
    if let Some(share) = energy.unexplained_share
        && share.abs() > WORST_UNEXPLAINED
    {
        remarks.push(format!(
            "the energies do not close: {:.1} % of what motors, pushes and gravity put in is unaccounted for: {REMEDY}",
            100.0 * share
        ));
    }
    let [motor_j, drove_j, outside_j, stored_j] = [
        energy.motor_j,
        energy.motor_positive_j,
        energy.outside_j,
        energy.stored_j,
    ]
    .map(|joules| joules.unwrap_or(0.0));
    let losses = [
        ("sliding", energy.slip_j),
        ("spinning rollers up", energy.spin_up_j),
        ("bearings and gears", energy.bearing_j),
        ("impacts", energy.impact_j),
    ];
    let losses = losses.map(|(what, lost_j)| (what, lost_j.unwrap_or(0.0)));
    let sizes = losses.iter().map(|(_, lost_j)| lost_j.abs());
    let most_j = sizes.fold(drove_j + outside_j.abs(), f64::max);
    let rounding_j = (WORST_UNEXPLAINED * most_j).max(LEAST_LOSS_J);
    for (what, lost_j) in losses {
        if lost_j < -rounding_j {
            remarks.push(format!(
                "a loss is negative: {what} took {lost_j:.4} J, which is impossible: {REMEDY}"
            ));
        }
    }
    let (slip_j, there_j) = (losses[0].1, motor_j + outside_j - stored_j);
    if slip_j > there_j + rounding_j {
        remarks.push(format!(
            "sliding took {slip_j:.4} J, more than the {there_j:.4} J that were available: {REMEDY}"
        ));
    }
    remarks
}

/// Remarks figures that change at half the step by more than their stated accuracy, and a run that
/// could not be repeated at half the step. If this was not requested, only figures of the robot's
/// path count.
pub fn of_convergence(converge: &Convergence, twins: &[Twin], was_asked: bool) -> Vec<String> {
    let is_beside = |twin: &&Twin| matches!(twin.change, Change::StartBeside(_));
    let halves = twins
        .iter()
        .filter(|twin| twin.change.is_noise() && !is_beside(twin));
    let failed = halves.filter_map(|twin| twin.error.as_ref());
    let mut remarks: Vec<String> = failed
        .map(|error| format!("the run could not be repeated at half its step: {error}"))
        .collect();
    let words = |(quantity, moved): (&Quantity, &ilon_trace::convergence::Moved)| {
        format!("{} by {:.2} %", quantity.words(), 100.0 * moved.share)
    };
    let goes = |quantity: &Quantity| {
        quantities::accuracy(quantity.key).is_some_and(|accuracy| accuracy.of != Measure::Itself)
    };
    let beyond = converge
        .beyond()
        .filter(|(quantity, _)| was_asked || goes(quantity));
    let beyond: Vec<String> = beyond.map(words).collect();
    if !beyond.is_empty() {
        remarks.push(format!(
            "at half the step figures move by more than their stated accuracy: {}; a shorter `run.physics_dt_s`, or a shorter \
             `world.solver.split_dt_s`, makes them more accurate",
            beyond.join(", ")
        ));
    }
    remarks
}

/// Groups remarks of the form `subject: text` by their text, in order of first appearance.
pub fn gathered(remarks: &[String]) -> Vec<String> {
    /// Largest number of subjects named in a remark; chosen.
    const MOST_SUBJECTS: usize = 8;
    let mut gathered: Vec<(Vec<&str>, &str)> = Vec::new();
    for remark in remarks {
        let (subject, said) = remark.split_once(": ").unwrap_or(("", remark));
        match gathered.iter_mut().find(|(_, known)| *known == said) {
            Some((subjects, _)) => subjects.push(subject),
            None => gathered.push((vec![subject], said)),
        }
    }
    let line = |(subjects, said): (Vec<&str>, &str)| {
        let rest = match subjects.len().saturating_sub(MOST_SUBJECTS) {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        match subjects[..subjects.len().min(MOST_SUBJECTS)].join(", ") {
            none if none.is_empty() => said.to_owned(),
            subjects => format!("{subjects}{rest}: {said}"),
        }
    };
    gathered.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use ilon_trace::slip::WheelSlip;
    use ilon_trace::{Ground, Header, Record, Trace, WheelHeader, WheelSample};

    use super::*;

    /// From row to row the wheel rolls 0.2 m: across one patch of 20 mm, and past the other.
    #[test]
    fn a_patch_that_lies_between_two_rows_is_not_missed() {
        let patch = |y_m: f64| {
            let mut patch = GroundPatch::default();
            (patch.center_m, patch.sides_m) = ([0.1, y_m], [0.02; 2]);
            patch
        };
        let (mut header, mut ground) = (Header::default(), Ground::default());
        ground.patches = vec![patch(0.0), patch(0.5)];
        (header.ground, header.wheels) = (Some(ground), vec![WheelHeader::default()]);
        let mut trace = Trace::with_capacity(header, 2);
        for x_m in [0.0, 0.2] {
            let (mut record, mut wheel) = (Record::default(), WheelSample::default());
            record.truth.pose.x_m = x_m;
            (wheel.touching, wheel.touching_share) = (true, 1.0);
            trace.push(record, &[wheel]);
        }
        let Ok(remark) = of_missed_patches(&trace);
        let remark = remark.expect("one was missed");
        assert!(
            !remark.contains("patch 0 ") && remark.contains("patch 1 "),
            "{remark}"
        );
    }

    #[test]
    fn like_remarks_on_several_parts_are_one() {
        let remarks = ["wheel `a`: too short", "alone", "wheel `b`: too short"];
        let shown = gathered(&remarks.map(str::to_owned));
        assert_eq!(shown, ["wheel `a`, wheel `b`: too short", "alone"]);
    }

    #[test]
    fn a_wheel_in_the_air_and_unsolved_contacts_are_remarked_with_their_figures() {
        let wheel = |name: &str, lost| {
            let mut wheel = WheelSlip::default();
            wheel.name = name.to_owned();
            wheel.lost_contact = Some(lost);
            wheel
        };
        let mut summary = Summary::default();
        summary.wheels = ["left", "right", "front"]
            .map(|name| wheel(name, 0.02))
            .into();
        summary.wheels.push(wheel("rear", 1.0));
        summary.contact_residual_max_m_s = Some(1e-8);
        let [remark] = &of_summary(&summary, false)[..] else {
            panic!("one wheel does not touch");
        };
        assert!(
            remark.contains("`rear` for 100 %") && remark.ends_with("it does not carry the robot"),
            "{remark}"
        );
        for wheel in &mut summary.wheels {
            wheel.lost_contact = Some(0.6);
        }
        // No wheel carries the robot all the time, but together they do.
        let [hops] = &of_summary(&summary, false)[..] else {
            panic!("one remark for all");
        };
        assert!(
            hops.contains("hops") && !hops.contains("does not carry"),
            "{hops}"
        );
        // A robot that tipped over lies there.
        summary.chassis_load_share = Some(0.96);
        let lies = of_summary(&summary, false).join("");
        assert!(lies.ends_with("lies on its chassis"), "{lies}");
        summary.wheels.clear();
        summary.energy.unexplained_share = Some(0.004);
        summary.contact_residual_max_m_s = Some(0.02);
        assert!(of_summary(&summary, false)[0].contains("20.00 mm/s"));
        summary.contact_residual_max_m_s = None;
        summary.energy.unexplained_share = Some(-69.0);
        assert!(of_summary(&summary, false)[0].contains("-6900.0 %"));
    }

    /// A loss below zero by a hundredth of the motors' work is not rounding, nor is sliding that
    /// took more energy than there was.
    #[test]
    fn losses_that_give_and_sliding_that_takes_more_than_there_is_are_remarked() {
        let remarks = |slip_j: f64, bearing_j: f64, impact_j: f64| {
            let mut energy = Energy::default();
            energy.motor_j = Some(0.7);
            energy.motor_positive_j = Some(1.0);
            energy.stored_j = Some(0.3);
            (energy.slip_j, energy.bearing_j) = (Some(slip_j), Some(bearing_j));
            energy.impact_j = Some(impact_j);
            of_energy(&energy)
        };
        assert!(remarks(0.25, 0.15, -0.005).is_empty());
        let [bearing] = &remarks(0.3, -4.7, 0.0)[..] else {
            panic!("a bearing that drives");
        };
        assert!(
            bearing.contains("bearings") && bearing.contains("-4.7"),
            "{bearing}"
        );
        assert_eq!(remarks(0.81, 0.13, -0.55).len(), 2);
    }

    /// At rest springs and contacts turn over less than is printed: a tenth of a millijoule.
    #[test]
    fn a_robot_at_rest_neither_gains_energy_nor_has_joints_that_moved() {
        let mut energy = Energy::default();
        (energy.slip_j, energy.impact_j) = (Some(2e-6), Some(-3e-5));
        (energy.motor_j, energy.motor_positive_j) = (Some(1e-7), Some(1e-7));
        assert!(of_energy(&energy).is_empty());
        energy.impact_j = Some(-3e-4);
        assert_eq!(of_energy(&energy).len(), 1);
    }

    #[test]
    fn loops_that_cannot_settle_are_named_where_wheels_are_far_off() {
        let mut summary = Summary::default();
        summary.wheel_rate_command_max_rad_s = Some(8.0);
        summary.wheel_rate_error_rms_rad_s = Some(0.1);
        assert!(of_summary(&summary, true).is_empty());
        summary.wheel_rate_error_rms_rad_s = Some(1.2);
        assert!(of_summary(&summary, true)[0].contains("swung"));
        assert!(of_summary(&summary, false).is_empty());
    }

    /// What pushes from outside put in may be lost to sliding: 1 J of a push, of which 0.2 J is
    /// still there. More than these 0.8 J cannot be lost.
    #[test]
    fn sliding_may_take_what_was_put_in_from_outside_and_no_more() {
        let energy = |slip_j: f64| {
            let mut energy = Energy::default();
            (energy.outside_j, energy.stored_j) = (Some(1.0), Some(0.2));
            energy.slip_j = Some(slip_j);
            energy
        };
        assert_eq!(of_energy(&energy(0.7)), [""; 0]);
        let [remark] = &of_energy(&energy(0.9))[..] else {
            panic!("0.9 J were not there");
        };
        assert!(remark.contains("more than the 0.8000 J"), "{remark}");
    }

    /// A loss below zero by a hundredth of what was turned over is remarked, and rounding is not.
    #[test]
    fn a_loss_that_gives_energy_is_remarked() {
        let remarks = |bearing_j: f64| {
            let mut energy = Energy::default();
            (energy.motor_j, energy.motor_positive_j) = (Some(10.0), Some(10.0));
            energy.bearing_j = Some(bearing_j);
            of_energy(&energy)
        };
        assert_eq!(remarks(-0.09), [""; 0]);
        assert!(remarks(-0.11)[0].contains("bearings and gears took -0.1100 J"));
    }
}
