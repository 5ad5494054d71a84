//! Sentences on slip and its cost, saturated tasks, and the drift of dead reckoning.

use ilon_trace::effects::floor;
use ilon_trace::slip::WheelSlip;
use ilon_trace::{Fault, FaultKind, Header, JointTravel, Summary, WheelHeader};

use super::events::{Event, EventKind, LEAST_SLIDE_M, SLIDING_SHARE};
use super::phrases::list;
use crate::page::escape;
use crate::text::{angle, energy, energy_to, length, percent, time};

/// Smaller costs are ignored, in J.
const LEAST_J: f64 = 5e-4;

/// A wheel counts as off the ground if it is for more than this share of the time.
const LEAST_OFF: f64 = 0.01;

/// Smaller costs of hub motion are ignored, in metres.
const LEAST_COST_M: f64 = 1e-4;

/// Reports the wheels that were off the ground, and the share of the run; the two longest.
pub(super) fn off_the_ground(summary: &Summary) -> Option<String> {
    let wheels = summary.wheels.iter();
    let share = |wheel: &WheelSlip| wheel.lost_contact.filter(|share| *share > LEAST_OFF);
    let mut off: Vec<(f64, &str)> = wheels
        .filter_map(|wheel| Some((share(wheel)?, wheel.name.as_str())))
        .collect();
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (share, name) = *off.first()?;
    let mut said = format!(
        "<b>{}</b> was off the ground for <b>{}</b> of the run",
        escape(name),
        percent(share)
    );
    if let Some((share, name)) = off.get(1) {
        said += &format!(", <b>{}</b> for {}", escape(name), percent(*share));
    }
    if off.len() > 2 {
        let plural = if off.len() > 3 { "s" } else { "" };
        said += &format!(", {} other wheel{plural} for less", off.len() - 2);
    }
    Some(said + ".")
}

/// Returns the energy lost to sliding under the wheels, in J.
fn under_wheels_j(summary: &Summary) -> f64 {
    summary.wheels.iter().map(|wheel| wheel.energy_j).sum()
}

/// Returns the total energy supplied, in J.
fn put_in_j(summary: &Summary) -> Option<f64> {
    let energy = &summary.energy;
    let motors_j = energy.motor_positive_j.or(energy.motor_j);
    energy.put_in_j.or(motors_j)
}

/// Returns a part in J as a share of the energy supplied, and its suppliers; empty if it cannot be
/// a part.
fn of_what_was_put_in(summary: &Summary, header: &Header, part_j: f64) -> String {
    /// A supplier of a smaller share is not named.
    const LEAST: f64 = 0.01;
    let Some(all_j) = put_in_j(summary).filter(|all_j| *all_j >= part_j) else {
        return String::new();
    };
    let energy_of = &summary.energy;
    let is_push = |fault: &Fault| matches!(fault.kind, FaultKind::Push { .. });
    let outside = match header.faults.iter().flatten().any(is_push) {
        true => "the push",
        false => "outside forces",
    };
    let who = [
        (
            "the motors",
            energy_of.motor_positive_j.or(energy_of.motor_j),
        ),
        (outside, energy_of.outside_positive_j),
        ("gravity", energy_of.fall_j),
    ];
    let named = who
        .into_iter()
        .filter(|(_, j)| j.is_some_and(|j| j > LEAST * all_j));
    let named: Vec<String> = named.map(|(who, _)| who.to_owned()).collect();
    match named.is_empty() {
        true => format!(" of {}", energy(all_j)),
        false => format!(" of the {} that {} put in", energy(all_j), list(&named)),
    }
}

/// Reports the energy lost in impacts and landings, if it is a relevant share of the energy
/// supplied.
pub(super) fn landings(summary: &Summary, header: &Header) -> Option<String> {
    /// Smaller shares are not reported.
    const LEAST: f64 = 0.05;
    let hits_j = summary.energy.impact_j?;
    let is_told = hits_j > LEAST_J && hits_j > LEAST * put_in_j(summary)?;
    let of_work = of_what_was_put_in(summary, header, hits_j);
    is_told.then(|| format!("Hits and landings cost <b>{}</b>{of_work}.", energy(hits_j)))
}

/// Returns the sliding loss that was not under the wheels, and its place; `None` if negligible.
fn rubbing(summary: &Summary, header: &Header) -> Option<(f64, &'static str)> {
    /// Smaller shares of all sliding are not reported.
    const LEAST: f64 = 0.02;
    let slip_j = summary.energy.slip_j?;
    let under_wheels_j = under_wheels_j(summary);
    let rubbed_j = slip_j - under_wheels_j;
    let who = match (header.bodies.is_empty(), header.is_on_tyres()) {
        (true, false) => "friction of its body",
        (true, true) => "friction of its body and casters",
        (false, false) => "friction of its body and of what it pushes",
        (false, true) => "friction of its body, its casters and what it pushes",
    };
    (rubbed_j > LEAST_J.max(LEAST * slip_j)).then_some((rubbed_j, who))
}

/// Reports sliding if no wheel slid far: short slides and creep below the limit, if they cost a
/// share of the work, and other rubbing.
fn without_slides(
    summary: &Summary,
    header: &Header,
    rubbing: Option<(f64, &str)>,
    of_work: &str,
) -> String {
    /// Smaller shares of the energy supplied are not reported.
    const LEAST: f64 = 0.01;
    let under_wheels_j = under_wheels_j(summary);
    let all_j = put_in_j(summary).unwrap_or(0.0);
    let costs = under_wheels_j > LEAST_J.max(LEAST * all_j);
    let cost = energy(under_wheels_j);
    let reached = summary
        .friction_used_max
        .is_some_and(|used| used >= SLIDING_SHARE);
    let far = format!("{} mm", 1e3 * LEAST_SLIDE_M);
    let under_wheels = match (reached, costs) {
        (false, false) => "No wheel lost grip".to_owned(),
        (false, true) if header.wheels.iter().any(WheelHeader::has_tyre) => {
            let kind = if header.is_on_tyres() {
                "creep"
            } else {
                "micro-slip"
            };
            format!(
                "No wheel lost grip; {kind}, and scrub across the tyres' width, cost <b>{cost}</b>{of_work}"
            )
        }
        (false, true) => format!("No wheel lost grip; micro-slip cost <b>{cost}</b>{of_work}"),
        (true, false) => format!("No wheel slid by {far} or more at a time"),
        (true, true) => format!(
            "No wheel slid by {far} or more at a time; shorter slides cost <b>{cost}</b>{of_work}"
        ),
    };
    let of_work = if costs { "" } else { of_work };
    let rubbed = rubbing.map_or_else(String::new, |(rubbed_j, who)| {
        format!("; <b>{}</b>{of_work} went into {who}", energy(rubbed_j))
    });
    format!("{under_wheels}{rubbed}.")
}

/// A smaller share of creep in all slip is not reported beside slides.
const LEAST_CREEP: f64 = 0.1;

/// Reports which wheels slid, when, and the cost, with the cost of new rollers.
pub(super) fn slipping(summary: &Summary, header: &Header, events: &[Event]) -> Option<String> {
    let slip_j = summary.energy.slip_j?;
    let rubbing = rubbing(summary, header);
    let of_work = of_what_was_put_in(summary, header, slip_j);
    let hand_over = summary
        .energy
        .spin_up_j
        .filter(|&j| j > 0.005)
        .map_or_else(String::new, |j| {
            format!(
                " Spinning up each roller as it touches down cost {}.",
                energy(j)
            )
        });
    let slides: Vec<&Event> = events
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Slide(_)))
        .collect();
    let Some(worst) = slides.iter().max_by(|a, b| a.lost_j.total_cmp(&b.lost_j)) else {
        return Some(without_slides(summary, header, rubbing, &of_work) + &hand_over);
    };
    // Overlapping slides are reported together.
    let (from_s, until_s) = slides
        .iter()
        .filter(|e| e.overlaps(worst.from_s, worst.until_s))
        .fold((worst.from_s, worst.until_s), |(a, b), e| {
            (a.min(e.from_s), b.max(e.until_s))
        });
    let together: Vec<&&Event> = slides
        .iter()
        .filter(|e| e.overlaps(from_s, until_s))
        .collect();
    let mut wheels: Vec<usize> = together
        .iter()
        .filter_map(|e| match e.kind {
            EventKind::Slide(wheel) => Some(wheel),
            _ => None,
        })
        .collect();
    wheels.sort_unstable();
    wheels.dedup();
    let who = if wheels.len() == 1 {
        let name = worst.text.split(" slides").next().unwrap_or("a wheel");
        format!("<b>{}</b>", escape(name))
    } else {
        format!("<b>{} wheels</b>", wheels.len())
    };
    let each = if wheels.len() > 1 { " each" } else { "" };
    let slid_m = together.iter().map(|e| e.slid_m).fold(0.0, f64::max);
    if slip_j < LEAST_J {
        return Some(format!(
            "<b>From {from_s:.2} to {}</b> {who} slid by up to <b>{}</b>{each}, which cost less than 1 mJ: there is next to no friction.{hand_over}",
            time(until_s),
            length(slid_m)
        ));
    }
    let lost_j = |of: &mut dyn Iterator<Item = &Event>| of.map(|slide| slide.lost_j).sum::<f64>();
    let share = match lost_j(&mut together.iter().map(|slide| **slide)) / slip_j {
        0.999.. => "all".to_owned(),
        share => percent(share),
    };
    let creep_j = under_wheels_j(summary) - lost_j(&mut slides.iter().copied());
    let creep = (creep_j > LEAST_J.max(LEAST_CREEP * slip_j)).then(|| {
        let scrub = match header.wheels.iter().any(WheelHeader::has_tyre) {
            true => ", shorter slides, and scrub across the tyres' width",
            false => " and shorter slides",
        };
        format!(" {} of it was creep{scrub}.", energy(creep_j))
    });
    let creep = creep.unwrap_or_default();
    let rubbed = rubbing.map_or_else(String::new, |(rubbed_j, what)| {
        format!(" {} of it went into {what}.", energy(rubbed_j))
    });
    Some(format!(
        "Sliding cost <b>{}</b>{of_work}, {share} of it <b>from {:.2} to {}</b>, when {who} slid by up to {}{each}.{creep}{rubbed}{hand_over}",
        energy_to(slip_j, floor("slip_energy_j", summary, header)),
        from_s,
        time(until_s),
        length(slid_m),
    ))
}

/// Reports how long the guidance could not fulfil its tasks.
pub(super) fn saturation(summary: &Summary, header: &Header, events: &[Event]) -> Option<String> {
    let share = summary.saturated_share.filter(|&s| s > 0.005)?;
    let held_back = |event: &Event| match event.kind {
        EventKind::Saturated(task) => Some((event.until_s - event.from_s, task, event.when())),
        _ => None,
    };
    let longest = events.iter().filter_map(held_back);
    let longest = longest.max_by(|a, b| a.0.total_cmp(&b.0));
    // Wheels that are clipped one by one hold back no task.
    let task = longest.map_or(String::new(), |(_, task, when)| {
        let name = header.task_names.get(task).map_or("", String::as_str);
        format!(
            "; the task <b>{}</b> was held back longest, {when}",
            escape(name)
        )
    });
    Some(format!(
        "The wheel rates were saturated for {} of the run{task}.",
        percent(share)
    ))
}

/// Reports the motion of joints between bodies, the two largest of those that followed the ground
/// or their servos, and the cost of moving hubs for dead reckoning.
pub(super) fn joints(header: &Header, summary: &Summary) -> Option<String> {
    // A joint that sags by less than this at the start, and stays, is not reported: m or rad.
    const LEAST: f64 = 1e-3;
    let mut moved: Vec<&JointTravel> = summary.joints.iter().collect();
    let way = |of: &JointTravel| of.most - of.least;
    // What rolls on, such as a caster's wheel, is not between two angles.
    moved.retain(|of| way(of) > LEAST && (of.slides || way(of) < std::f64::consts::TAU));
    // Casters and steering turn by themselves.
    let is_stopped = |of: &JointTravel| of.on_stop.is_some_and(|share| share > LEAST_OFF);
    moved.retain(|of| of.slides || !header.is_on_tyres() || is_stopped(of));
    moved.sort_by(|a, b| way(b).total_cmp(&way(a)));
    let first = moved.first()?;
    let said = |of: &JointTravel| {
        let at = |value: f64| {
            if of.slides {
                length(value)
            } else {
                angle(value)
            }
        };
        let verb = if of.slides { "moved" } else { "turned" };
        let stop = of.on_stop.filter(|share| *share > LEAST_OFF);
        let stop = stop.map_or_else(String::new, |share| {
            format!(", on a stop for {} of the run", percent(share))
        });
        format!(
            "<b>{}</b> {verb} between {} and {}{stop}",
            escape(&of.name),
            at(of.least),
            at(of.most)
        )
    };
    let mut text = said(first);
    if let Some(second) = moved.get(1) {
        text += &format!(", {}", said(second));
    }
    if moved.len() > 2 {
        text += &format!(" and {} more by less", moved.len() - 2);
    }
    let costs = summary.odometry_joints_m.filter(|m| *m > LEAST_COST_M);
    let costs = costs.map_or_else(String::new, |m| {
        format!(
            " Odometry ends <b>{}</b> off because wheels moved on joints that nothing measures; it takes these joints as at zero.",
            length(m)
        )
    });
    Some(format!("{text}.{costs}"))
}

/// Reports the drift of dead reckoning.
pub(super) fn reckoning(header: &Header, summary: &Summary) -> Option<String> {
    let ideal = summary.odometry_ideal.m_per_m?;
    let contact = summary.odometry_contact.m_per_m?;
    if header.is_on_tyres() {
        return Some(format!(
            "Wheel odometry drifts by {} per metre.",
            length(contact)
        ));
    }
    Some(format!(
        "Wheel odometry drifts by {} per metre with the ideal kinematics, by {} with the kinematics of the touching rollers.",
        length(ideal),
        length(contact)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joint(
        name: &str,
        slides: bool,
        [least, most]: [f64; 2],
        on_stop: Option<f64>,
    ) -> JointTravel {
        let mut joint = JointTravel::default();
        joint.name = name.to_owned();
        (joint.slides, joint.least, joint.most, joint.on_stop) = (slides, least, most, on_stop);
        joint
    }

    /// The two joints that moved furthest are reported, with their stops; the cost of hub motion
    /// only if it is relevant.
    #[test]
    fn joints_that_moved_are_told_of() {
        let mut summary = Summary::default();
        assert_eq!(joints(&Header::default(), &summary), None);
        summary.joints = vec![
            joint("still", true, [0.006, 0.0061], Some(0.0)),
            joint("spring", true, [0.002, 0.012], Some(0.0)),
            joint("rocker", false, [-0.0873, 0.02], Some(0.25)),
            joint("other", true, [0.0, 0.002], None),
        ];
        summary.odometry_joints_m = Some(1e-6);
        let said = joints(&Header::default(), &summary).expect("three moved");
        assert!(said.starts_with("<b>rocker</b> turned between "), "{said}");
        assert!(said.contains("on a stop for 25"), "{said}");
        assert!(
            said.contains("<b>spring</b> moved between 2.00 mm and 12.00 mm and 1 more by less."),
            "{said}"
        );
        assert!(
            !said.contains("still") && !said.contains("Odometry"),
            "{said}"
        );
        summary.odometry_joints_m = Some(0.0031);
        let said = joints(&Header::default(), &summary).expect("three moved");
        assert!(said.contains("<b>3.10 mm</b> off"), "{said}");
    }

    /// Suppliers of a hundredth of the energy or more are named, in words that do not depend on
    /// their order.
    #[test]
    fn who_put_the_energy_in_is_named() {
        let mut summary = Summary::default();
        let energy = &mut summary.energy;
        (energy.put_in_j, energy.motor_positive_j) = (Some(10.0), Some(0.05));
        (energy.outside_positive_j, energy.fall_j) = (Some(0.0), Some(9.95));
        let said = of_what_was_put_in(&summary, &Header::default(), 1.0);
        assert_eq!(said, " of the 10.00 J that gravity put in");
        summary.energy.motor_positive_j = Some(2.0);
        let said = of_what_was_put_in(&summary, &Header::default(), 1.0);
        assert_eq!(said, " of the 10.00 J that the motors and gravity put in");
    }

    /// If no wheel slid far, the sentence depends on the used grip; losses under the wheels are
    /// reported from 1 % of the work, others from 2 % of all sliding.
    #[test]
    fn short_slides_creeping_and_rubbing_are_told_apart() {
        let said = |grip: f64, under_wheels_j: f64, slip_j: f64| {
            let mut summary = Summary::default();
            summary.energy.motor_j = Some(10.0);
            summary.energy.slip_j = Some(slip_j);
            summary.friction_used_max = Some(grip);
            let mut wheel = WheelSlip::default();
            wheel.energy_j = under_wheels_j;
            summary.wheels = vec![wheel];
            let header = Header::default();
            slipping(&summary, &header, &[]).expect("what slid is known")
        };
        assert_eq!(said(0.4, 0.09, 0.09), "No wheel lost grip.");
        assert_eq!(
            said(0.4, 0.5, 0.5),
            "No wheel lost grip; micro-slip cost <b>0.50 J</b> of the 10.00 J that the motors put in."
        );
        assert_eq!(
            said(1.0, 0.05, 0.05),
            "No wheel slid by 2 mm or more at a time."
        );
        assert_eq!(
            said(1.0, 0.5, 2.0),
            "No wheel slid by 2 mm or more at a time; shorter slides cost <b>0.50 J</b> of the 10.00 J that the motors put in; \
             <b>1.50 J</b> went into friction of its body."
        );
        // A wheel that loses 0.5 J in a slide of a second, of 2 J in all: what the others and its
        // creep lost meanwhile is not the slide's.
        let mut summary = Summary::default();
        summary.energy.motor_j = Some(10.0);
        summary.energy.slip_j = Some(2.0);
        let mut wheel = WheelSlip::default();
        wheel.energy_j = 2.0;
        summary.wheels = vec![wheel];
        let slide = Event {
            from_s: 1.0,
            until_s: 2.0,
            kind: EventKind::Slide(0),
            text: "front slides 4.00 mm at up to 5.00 mm/s".to_owned(),
            slid_m: 4e-3,
            lost_j: 0.5,
        };
        assert_eq!(
            slipping(&summary, &Header::default(), &[slide]).expect("what slid is known"),
            "Sliding cost <b>2.00 J</b> of the 10.00 J that the motors put in, 25.0 % of it <b>from 1.00 to 2.00 s</b>, \
             when <b>front</b> slid by up to 4.00 mm. 1.50 J of it was creep and shorter slides."
        );
        // Rounding of two sums is no rubbing.
        assert_eq!(said(0.4, 0.09, 0.09 + 1e-3), "No wheel lost grip.");
    }
}
