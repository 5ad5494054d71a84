//! Events with their times: faults, postures, slides, lost contacts, ground patches and saturation.

use ilon_trace::{Announced, GroundPatch, Header, Record, WheelSample};

use super::phrases::list;
use super::posture::{Posture, Stance};
use super::shortfall::Means;
use super::spells::{Spell, Spells};
use super::touches::Touches;
use crate::text::{length, speed, time};

/// A wheel slides if it uses this share of its friction limit ...
pub(super) const SLIDING_SHARE: f64 = 0.95;
/// ... and its contact moves faster than this, in m/s. Slower motion is the creep of the solver and
/// the spin-up of a new roller.
const SLIDING_M_S: f64 = 0.005;
/// Shorter slides are ignored, in metres.
pub(super) const LEAST_SLIDE_M: f64 = 0.002;
/// A wheel off the ground for a shorter time is handing over between rollers, in seconds.
const LEAST_FLIGHT_S: f64 = 0.02;
/// Distance from a box's outline within which a contact is on its edge, in metres.
const EDGE_M: f64 = 0.005;

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    pub from_s: f64,
    pub until_s: f64,
    pub kind: EventKind,
    /// Description, as text, without times.
    pub text: String,
    /// Sliding distance, in metres; 0 if not a slide.
    pub slid_m: f64,
    /// Energy lost during it, in J.
    pub lost_j: f64,
}

/// Kinds of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventKind {
    /// A fault or a push set by the scenario.
    Fault,
    /// The robot did not stand freely on its wheels.
    Stance(Stance),
    /// A wheel was on a patch or a box.
    Ground,
    /// A task of the guidance was saturated.
    Saturated(usize),
    /// A motion beyond grip or motors, as predicted before the run.
    Announced,
    /// The robot pushed a free body.
    Touch,
    /// A wheel slid.
    Slide(usize),
    /// A wheel lost the ground.
    Airborne(usize),
}

/// Detects events from the rows of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watch {
    slides: Vec<Spells>,
    flights: Vec<Spells>,
    saturated: Vec<Spells>,
    /// For each patch and each box; for a box the distance inside its edges.
    patches: Vec<Spells>,
    boxes: Vec<Spells>,
    energy_before_j: Vec<f64>,
    pub posture: Posture,
    pub means: Means,
    pub touches: Touches,
}

impl Watch {
    pub fn new(header: &Header) -> Self {
        let ground = header.ground.as_ref();
        let many = |count: usize| vec![Spells::default(); count];
        Self {
            slides: many(header.wheels.len()),
            flights: many(header.wheels.len()),
            saturated: many(header.task_names.len().min(ilon_trace::MAX_TASKS)),
            patches: many(ground.map_or(0, |g| g.patches.len())),
            boxes: many(ground.map_or(0, |g| g.boxes.len())),
            energy_before_j: vec![0.0; header.wheels.len()],
            posture: Posture::default(),
            means: Means::default(),
            touches: Touches::new(header),
        }
    }

    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let (t_s, dt_s) = (record.t_s, header.row_span_s(record.t_s));
        self.posture.add(header, record, samples);
        self.means.add(header, record, samples);
        self.touches.add(header, record);
        for (task, spells) in record.tasks.iter().zip(&mut self.saturated) {
            if task.asked_rad_s > 0.0 && task.weight < 1.0 {
                spells.add(t_s, dt_s, [1.0; 2], 0.0);
            }
        }
        for (index, sample) in samples.iter().enumerate() {
            let energy_j = sample.slip_energy_j;
            let before_j = std::mem::replace(&mut self.energy_before_j[index], energy_j);
            let slip_m_s = sample.slip_speed_m_s();
            let at_limit = sample
                .friction_used()
                .is_some_and(|used| used >= SLIDING_SHARE);
            // On ice both the limit and the force are near zero.
            if sample.touched() && slip_m_s > SLIDING_M_S && (at_limit || sample.friction == 0.0) {
                // A row may contain a roller in its spin-up, whose energy is not that of sliding:
                // the friction force counts.
                let force_n = sample.force_x_n.hypot(sample.force_y_n);
                let slid_m_s = match force_n > 0.0 {
                    true => slip_m_s.min((energy_j - before_j) / (force_n * dt_s)),
                    false => slip_m_s,
                };
                let most_m_s = sample.slip_speed_max_m_s.max(slid_m_s);
                self.slides[index].add(t_s, dt_s, [slid_m_s, most_m_s], energy_j - before_j);
            }
            if !sample.touched() && t_s > 0.0 {
                self.flights[index].add(t_s, dt_s, [1.0; 2], 0.0);
            }
            if sample.touched() {
                self.on_ground(header, record, sample);
            }
        }
    }

    fn on_ground(&mut self, header: &Header, record: &Record, sample: &WheelSample) {
        let Some(ground) = &header.ground else { return };
        let (t_s, dt_s) = (record.t_s, header.row_span_s(record.t_s));
        let [x_m, y_m] = sample.contact_m(record.truth.pose);
        for (patch, spells) in ground.patches.iter().zip(&mut self.patches) {
            if patch.is_there(t_s) && patch.distance_m([x_m, y_m]) == 0.0 {
                spells.add(t_s, dt_s, [1.0; 2], 0.0);
            }
        }
        // If boxes overlap, as the steps of stairs do, a wheel is on the highest.
        let mut highest: Option<(usize, f64)> = None;
        for (index, one) in ground.boxes.iter().enumerate() {
            let (sin, cos) = one.heading_rad.sin_cos();
            let [dx, dy] = [x_m - one.center_m[0], y_m - one.center_m[1]];
            let [along, across] = [cos * dx + sin * dy, cos * dy - sin * dx];
            let inside_m = |off_m: f64, side_m: f64| 0.5 * side_m - off_m.abs();
            let inside_m = inside_m(along, one.sides_m[0]).min(inside_m(across, one.sides_m[1]));
            let is_higher =
                |(other, _): (usize, f64)| one.sides_m[2] > ground.boxes[other].sides_m[2];
            if inside_m >= -EDGE_M && highest.is_none_or(is_higher) {
                highest = Some((index, inside_m));
            }
        }
        if let Some((index, inside_m)) = highest {
            self.boxes[index].add(t_s, dt_s, [inside_m; 2], 0.0);
        }
    }

    /// Returns all events, in the order of time.
    pub fn events(&self, header: &Header) -> Vec<Event> {
        let end_s = self.posture.end_s;
        let name_of = |wheel: usize| header.wheels.get(wheel).map(|wheel| wheel.name.as_str());
        let faults = header.faults.iter().flatten();
        let faults = faults.filter(|fault| fault.from_s <= end_s).map(|fault| {
            let until_s = fault.until_s.unwrap_or(end_s);
            let window_s = [fault.from_s, until_s.min(end_s.max(fault.from_s))];
            Event::of(EventKind::Fault, window_s, fault.kind.words(name_of))
        });
        let stances = self.posture.episodes().into_iter().map(|episode| {
            let kind = EventKind::Stance(episode.stance);
            Event::of(kind, [episode.from_s, episode.until_s], episode.text())
        });
        let mut events: Vec<Event> = faults.chain(stances).collect();
        let mut push = |kind, spell: &Spell, text: String, slid_m: f64| {
            events.push(Event {
                slid_m,
                lost_j: spell.energy_j.max(0.0),
                ..Event::of(kind, [spell.from_s, spell.until_s], text)
            });
        };
        for (spell, text) in self.touches.episodes(header) {
            push(EventKind::Touch, &spell, text, 0.0);
        }
        for (index, spells) in self.slides.iter().enumerate() {
            for spell in &spells.found {
                let slid_m = spell.sum;
                if slid_m >= LEAST_SLIDE_M {
                    let text = format!(
                        "{} slides {} at up to {}",
                        header.wheels[index].name,
                        length(slid_m),
                        speed(spell.largest)
                    );
                    push(EventKind::Slide(index), spell, text, slid_m);
                }
            }
        }
        for (index, spells) in self.flights.iter().enumerate() {
            for spell in &spells.found {
                if spell.until_s - spell.from_s >= LEAST_FLIGHT_S {
                    let text = format!("{} has lost the ground", header.wheels[index].name);
                    push(EventKind::Airborne(index), spell, text, 0.0);
                }
            }
        }
        for (index, spells) in self.saturated.iter().enumerate() {
            for spell in &spells.found {
                let text = format!("the task `{}` is saturated", header.task_names[index]);
                push(EventKind::Saturated(index), spell, text, 0.0);
            }
        }
        if let Some(ground) = &header.ground {
            for (patch, spells) in ground.patches.iter().zip(&self.patches) {
                for spell in &spells.found {
                    let text = format!(
                        "wheels are on a patch of {}",
                        of_patch(patch, ground.friction)
                    );
                    push(EventKind::Ground, spell, text, 0.0);
                }
            }
            for (one, spells) in ground.boxes.iter().zip(&self.boxes) {
                for spell in &spells.found {
                    let height = length(one.sides_m[2]);
                    let text = match spell.largest > EDGE_M {
                        true => format!("wheels cross a box {height} high"),
                        false => format!("wheels touch the edge of a box {height} high"),
                    };
                    push(EventKind::Ground, spell, text, 0.0);
                }
            }
        }
        if let Some(announced) = &header.announced {
            let text = against_seen(header, announced, &events);
            let window_s = [announced.from_s, announced.most_at_s];
            events.push(Event::of(EventKind::Announced, window_s, text));
        }
        events.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        events
    }
}

/// Describes how a patch differs from the floor, without its friction if equal.
fn of_patch(patch: &GroundPatch, floor_friction: f64) -> String {
    let is_own = patch.friction != floor_friction || patch.changes.is_empty();
    let friction = is_own.then(|| format!("friction {}", patch.friction));
    let all: Vec<String> = friction
        .into_iter()
        .chain(patch.changes.iter().cloned())
        .collect();
    list(&all)
}

/// Slides that start within this time of each other are simultaneous, in seconds.
const AT_ONCE_S: f64 = 0.02;

/// Compares the prediction before the run with the observed slides.
fn against_seen(header: &Header, announced: &Announced, events: &[Event]) -> String {
    let name = |wheel: usize| {
        header
            .wheels
            .get(wheel)
            .map_or("a wheel", |wheel| wheel.name.as_str())
    };
    let of_what = match announced.of_grip {
        true => "grip",
        false => "motor's torque",
    };
    let up_to = match announced.share {
        Some(share) => format!("up to {:.0} % of its {of_what}", 100.0 * share),
        None => format!("more than its {of_what}"),
    };
    let slides = events.iter().filter_map(|event| match event.kind {
        EventKind::Slide(wheel) if event.until_s >= announced.from_s => Some((event.from_s, wheel)),
        _ => None,
    });
    let slides: Vec<(f64, usize)> = slides.collect();
    let first = slides.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let seen = match first {
        None => "no wheel slides after that".to_owned(),
        Some((first_s, first)) => {
            // Identical wheels start to slide together.
            let of = |wheels: &[usize]| {
                let slides = slides.iter().filter(|slide| slide.0 <= first_s + AT_ONCE_S);
                slides.copied().find(|slide| wheels.contains(&slide.1))
            };
            match (of(&[announced.wheel]), of(&announced.first)) {
                (Some((from_s, _)), _) => format!("it slides first, at {}", time(from_s)),
                (None, Some((from_s, wheel))) => format!(
                    "{} slides first, as announced, at {}",
                    name(wheel),
                    time(from_s)
                ),
                (None, None) => format!("{} slides first, at {}", name(*first), time(*first_s)),
            }
        }
    };
    format!(
        "expected before the run: {} needs {up_to}; seen: {seen}",
        name(announced.wheel)
    )
}

/// A shorter event is reported as a moment, in seconds.
pub(super) const INSTANT_S: f64 = 0.005;

/// Returns a time, or a time span, as text.
pub(super) fn when(from_s: f64, until_s: f64) -> String {
    if until_s - from_s < INSTANT_S {
        format!("at {}", time(from_s))
    } else {
        format!("from {from_s:.2} to {}", time(until_s))
    }
}

impl Event {
    /// An event without sliding and loss.
    fn of(kind: EventKind, [from_s, until_s]: [f64; 2], text: String) -> Self {
        Self {
            from_s,
            until_s,
            kind,
            text,
            slid_m: 0.0,
            lost_j: 0.0,
        }
    }

    /// Returns its times as text.
    pub fn when(&self) -> String {
        when(self.from_s, self.until_s)
    }

    /// Whether it overlaps a time span.
    pub fn overlaps(&self, from_s: f64, until_s: f64) -> bool {
        self.from_s <= until_s && self.until_s >= from_s
    }

    /// Whether its cause is outside the robot.
    pub fn is_outside(&self) -> bool {
        matches!(self.kind, EventKind::Fault | EventKind::Ground)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::{Ground, GroundBox, WheelHeader};

    fn header() -> Header {
        Header {
            wheels: vec![WheelHeader {
                name: "front".to_owned(),
                ..WheelHeader::default()
            }],
            control_dt_s: 0.01,
            ground: Some(Ground {
                friction: 0.6,
                boxes: vec![GroundBox {
                    center_m: [1.0, 0.0],
                    sides_m: [0.2, 1.0, 0.005],
                    heading_rad: 0.0,
                }],
                ..Ground::default()
            }),
            ..Header::default()
        }
    }

    fn watched() -> Vec<Event> {
        watched_on(&header())
    }

    /// The prediction is reported with the observation: the wheel, and the time, from the row
    /// before the first slide.
    #[test]
    fn what_was_announced_stands_beside_what_was_seen() {
        let said = |from_s: f64, wheel: usize, first: usize| {
            let mut header = header();
            header.announced = Some(Announced {
                from_s,
                first: vec![first],
                most_at_s: from_s + 0.2,
                wheel,
                of_grip: true,
                share: Some(1.27),
            });
            let events = watched_on(&header);
            let found = events
                .iter()
                .find(|event| event.kind == EventKind::Announced);
            found.expect("announced").text.clone()
        };
        assert_eq!(
            said(3.9, 0, 0),
            "expected before the run: front needs up to 127 % of its grip; seen: it slides first, at 3.99 s"
        );
        assert!(said(6.0, 0, 0).ends_with("seen: no wheel slides after that"));
        assert!(said(3.9, 7, 7).ends_with("seen: front slides first, at 3.99 s"));
        assert!(said(3.9, 7, 0).ends_with("seen: front slides first, as announced, at 3.99 s"));
        assert!(
            watched()
                .iter()
                .all(|event| event.kind != EventKind::Announced)
        );
    }

    /// A roller that touches down at rest appears at the end of a row, at 0.5 m/s and its friction
    /// limit, before it has its spin: the loss is that of spinning up. It has not slid.
    #[test]
    fn a_roller_that_is_spun_up_as_a_row_ends_is_no_slide() {
        let header = header();
        let mut watch = Watch::new(&header);
        for row in 0..100 {
            let is_caught = row == 50;
            let sample = WheelSample {
                touching: true,
                normal_force_n: 10.0,
                friction: 0.6,
                force_y_n: if is_caught { 6.0 } else { 1.0 },
                slip_y_m_s: if is_caught { 0.5 } else { 0.0 },
                spin_up_energy_j: if row >= 50 { 3e-4 } else { 0.0 },
                ..WheelSample::default()
            }
            .steady();
            let record = Record {
                t_s: 0.01 * f64::from(row),
                ..Record::default()
            };
            watch.add(&header, &record, &[sample]);
        }
        let events = watch.events(&header);
        let slides = events
            .iter()
            .filter(|event| matches!(event.kind, EventKind::Slide(_)));
        assert_eq!(slides.count(), 0, "{events:?}");
    }

    /// Ten seconds ahead at 0.2 m/s; from 4 to 5 s the wheel slides at 0.1 m/s at its friction
    /// limit.
    fn watched_on(header: &Header) -> Vec<Event> {
        let mut watch = Watch::new(header);
        let mut slip_energy_j = 0.0;
        for row in 0..=1000 {
            let t_s = 0.01 * f64::from(row);
            let sliding = (4.0..5.0).contains(&t_s);
            let mut record = Record {
                t_s,
                ..Record::default()
            };
            record.truth.pose.x_m = 0.2 * t_s;
            // 6 N at 0.1 m/s for 10 ms.
            slip_energy_j += if sliding { 6e-3 } else { 0.0 };
            let mut sample = WheelSample {
                slip_energy_j,
                touching: true,
                normal_force_n: 10.0,
                friction: 0.6,
                force_x_n: if sliding { 6.0 } else { 1.0 },
                slip_x_m_s: if sliding { 0.1 } else { 0.001 },
                ..WheelSample::default()
            }
            .steady();
            // Twice as fast for a moment within its row.
            if row == 450 {
                sample.slip_speed_max_m_s = 0.2;
            }
            watch.add(header, &record, &[sample]);
        }
        watch.events(header)
    }

    #[test]
    fn a_slide_is_found_with_its_times_and_its_length() {
        let events = watched();
        let slides: Vec<_> = events
            .iter()
            .filter(|e| e.kind == EventKind::Slide(0))
            .collect();
        assert_eq!(slides.len(), 1);
        // A hundred rows of 0.1 m/s over 10 ms; the ends to within a row.
        assert!(
            (slides[0].slid_m - 0.1).abs() < 1e-3,
            "{}",
            slides[0].slid_m
        );
        assert!((slides[0].from_s - 4.0).abs() < 0.015 && (slides[0].until_s - 5.0).abs() < 0.015);
        // 6 mJ in each of the hundred rows.
        let lost_j = slides[0].lost_j;
        assert!((lost_j - 0.6).abs() < 0.01, "{lost_j}");
        let fastest = "at up to 200 mm/s";
        assert!(slides[0].text.ends_with(fastest), "{}", slides[0].text);
    }

    #[test]
    fn a_box_is_crossed_while_the_contact_is_over_it() {
        let events = watched();
        let ground: Vec<_> = events
            .iter()
            .filter(|e| e.kind == EventKind::Ground)
            .collect();
        assert_eq!(ground.len(), 1);
        // From 0.9 to 1.1 m at 0.2 m/s, and 5 mm on either side.
        assert!(
            (ground[0].from_s - 4.475).abs() < 0.02 && (ground[0].until_s - 5.525).abs() < 0.02
        );
    }

    /// Steps that extend under the next ones, from 0.8 and 1.2 m on to 1.6 m: a wheel is on one at
    /// a time.
    #[test]
    fn a_wheel_on_stairs_is_on_the_highest_box_under_it() {
        let mut header = header();
        let step = |from_m: f64, height_m: f64| GroundBox {
            center_m: [0.5 * (from_m + 1.6), 0.0],
            sides_m: [1.6 - from_m, 1.0, height_m],
            heading_rad: 0.0,
        };
        if let Some(ground) = &mut header.ground {
            ground.boxes = vec![step(0.8, 0.01), step(1.2, 0.02)];
        }
        let events = watched_on(&header);
        let ground: Vec<_> = events
            .iter()
            .filter(|e| e.kind == EventKind::Ground)
            .collect();
        assert_eq!(ground.len(), 2);
        // At 0.2 m/s, and 5 mm before each edge.
        for (event, [from_m, until_m]) in ground.iter().zip([[0.795, 1.195], [1.195, 1.605]]) {
            assert!((event.from_s - from_m / 0.2).abs() < 0.02, "{}", event.text);
            assert!(
                (event.until_s - until_m / 0.2).abs() < 0.02,
                "{}",
                event.text
            );
        }
    }

    /// A robot at (1, 2) faces along y: a contact 0.3 m ahead and 0.1 m to the left of it is at
    /// (0.9, 2.3).
    #[test]
    fn a_contact_is_on_a_patch_where_it_is_in_the_world_and_while_the_patch_is_there() {
        let mut header = header();
        let patch = |x_m: f64, y_m: f64, until_s: Option<f64>| ilon_trace::GroundPatch {
            center_m: [x_m, y_m],
            sides_m: [0.1, 0.1],
            friction: 0.2,
            changes: vec!["creep 0.1".to_owned()],
            from_s: 1.0,
            until_s,
        };
        if let Some(ground) = &mut header.ground {
            // The second is where the contact would be if the body frame were the world's.
            ground.patches = vec![patch(0.9, 2.3, Some(2.0)), patch(1.3, 2.1, None)];
        }
        let mut watch = Watch::new(&header);
        for row in 0..=300 {
            let mut record = Record {
                t_s: 0.01 * f64::from(row),
                ..Record::default()
            };
            (record.truth.pose.x_m, record.truth.pose.y_m) = (1.0, 2.0);
            record.truth.pose.heading_rad = std::f64::consts::FRAC_PI_2;
            let sample = WheelSample {
                touching: true,
                contact_x_m: 0.3,
                contact_y_m: 0.1,
                ..WheelSample::default()
            }
            .steady();
            watch.add(&header, &record, &[sample]);
        }
        let events = watch.events(&header);
        let [event] = &events[..] else {
            panic!("one patch was touched: {events:?}")
        };
        assert_eq!(event.kind, EventKind::Ground);
        assert!(
            event
                .text
                .ends_with("a patch of friction 0.2 and creep 0.1"),
            "{}",
            event.text
        );
        // The floor's own friction is not reported.
        if let Some(ground) = &mut header.ground {
            ground.friction = 0.2;
        }
        let as_the_floor = &watch.events(&header)[0].text;
        assert!(
            as_the_floor.ends_with("a patch of creep 0.1"),
            "{as_the_floor}"
        );
        // To within a row.
        assert!((event.from_s - 1.0).abs() < 0.015 && (event.until_s - 2.0).abs() < 0.015);
    }

    /// A task without a request cannot be saturated, nor one that is fulfilled.
    #[test]
    fn a_task_is_saturated_while_it_gets_less_than_it_asks_for() {
        let header = Header {
            task_names: vec!["heading".to_owned()],
            ..header()
        };
        let mut watch = Watch::new(&header);
        for row in 0..=300 {
            let t_s = 0.01 * f64::from(row);
            let mut record = Record {
                t_s,
                ..Record::default()
            };
            record.tasks[0].asked_rad_s = if t_s < 2.0 { 1.0 } else { 0.0 };
            record.tasks[0].weight = if t_s < 1.0 { 1.0 } else { 0.5 };
            watch.add(&header, &record, &[WheelSample::default()]);
        }
        let events = watch.events(&header);
        let saturated: Vec<_> = events
            .iter()
            .filter(|event| event.kind == EventKind::Saturated(0))
            .collect();
        assert_eq!(saturated.len(), 1, "{events:?}");
        let (from_s, until_s) = (saturated[0].from_s, saturated[0].until_s);
        assert!((from_s - 1.0).abs() < 0.015 && (until_s - 2.0).abs() < 0.015);
    }
}
