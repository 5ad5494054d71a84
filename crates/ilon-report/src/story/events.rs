//! What happened, and when: faults and pushes from the scenario; slides, lost contacts, other ground and saturation from the rows.

use ilon_trace::{Header, Record, WheelSample};
use toml::Value;

use crate::words::{length, speed, time};

/// Spells of the same kind that are nearer to each other than this are one.
const GAP_S: f64 = 0.2;

/// A wheel slides where it uses this share of its friction limit ...
const SLIDING_SHARE: f64 = 0.95;
/// ... and moves over the ground faster than this. What is slower is the creep of the solver and the spin-up of a new roller.
const SLIDING_M_S: f64 = 0.005;
/// A slide that is shorter than this says nothing.
const LEAST_SLIDE_M: f64 = 0.002;
/// A wheel that is off the ground for less is handing over from roller to roller.
const LEAST_FLIGHT_S: f64 = 0.02;
/// Room around a box within which a contact is on its edge.
const EDGE_M: f64 = 0.005;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    pub from_s: f64,
    pub until_s: f64,
    pub kind: EventKind,
    /// In words, as text, without its times.
    pub text: String,
    /// Distance slid, in metres; 0 of what is no slide.
    pub slid_m: f64,
    /// Energy lost meanwhile, in J.
    pub lost_j: f64,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventKind {
    /// A fault or a push that the scenario sets.
    Fault,
    /// A wheel was on a patch or a box.
    Ground,
    /// A task of the guidance did not get what it asked for.
    Saturated(usize),
    /// A wheel slid.
    Slide(usize),
    /// A wheel lost the ground.
    Airborne(usize),
}

/// An unbroken time in which something held.
#[derive(Clone, Copy, Debug, Default)]
struct Spell {
    from_s: f64,
    until_s: f64,
    /// Sum over the rows of what was given.
    sum: f64,
    largest: f64,
    /// A counter of energy where it began, and now.
    energy_j: [f64; 2],
}

/// Joins rows into spells.
#[derive(Clone, Debug, Default)]
struct Spells {
    found: Vec<Spell>,
}

impl Spells {
    /// Adds a row in which it held, with a value that stands for a period.
    fn add(&mut self, t_s: f64, period_s: f64, value: f64, energy_j: [f64; 2]) {
        match self.found.last_mut() {
            Some(last) if t_s - last.until_s <= GAP_S => {
                last.until_s = t_s;
                last.sum += value * period_s;
                last.largest = last.largest.max(value);
                last.energy_j[1] = energy_j[1];
            }
            _ => self.found.push(Spell {
                from_s: (t_s - period_s).max(0.0),
                until_s: t_s,
                sum: value * period_s,
                largest: value,
                energy_j,
            }),
        }
    }
}

/// Watches the rows of a run as they come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watch {
    slides: Vec<Spells>,
    flights: Vec<Spells>,
    saturated: Vec<Spells>,
    /// Of each patch and each box.
    patches: Vec<Spells>,
    boxes: Vec<Spells>,
    energy_before_j: Vec<f64>,
    end_s: f64,
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
            end_s: 0.0,
        }
    }

    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let (t_s, dt_s) = (record.t_s, header.row_span_s(record.t_s));
        self.end_s = t_s;
        for (task, spells) in record.tasks.iter().zip(&mut self.saturated) {
            if task.asked_rad_s > 0.0 && task.weight < 1.0 {
                spells.add(t_s, dt_s, 1.0, [0.0; 2]);
            }
        }
        for (index, sample) in samples.iter().enumerate() {
            let energy_j = sample.slip_energy_j;
            let before_j = std::mem::replace(&mut self.energy_before_j[index], energy_j);
            let slip_m_s = sample.slip_speed_m_s();
            let at_limit = sample
                .friction_used()
                .is_some_and(|used| used >= SLIDING_SHARE);
            // On ice the limit is near zero, and so is all that tells the force from it.
            if sample.touching && slip_m_s > SLIDING_M_S && (at_limit || sample.friction == 0.0) {
                self.slides[index].add(t_s, dt_s, slip_m_s, [before_j, energy_j]);
            }
            if !sample.touching && t_s > 0.0 {
                self.flights[index].add(t_s, dt_s, 1.0, [0.0; 2]);
            }
            if sample.touching {
                self.on_ground(header, record, sample);
            }
        }
    }

    fn on_ground(&mut self, header: &Header, record: &Record, sample: &WheelSample) {
        let Some(ground) = &header.ground else { return };
        let (t_s, dt_s) = (record.t_s, header.row_span_s(record.t_s));
        let pose = record.truth.pose;
        let (s, c) = pose.heading_rad.sin_cos();
        let x_m = pose.x_m + c * sample.contact_x_m - s * sample.contact_y_m;
        let y_m = pose.y_m + s * sample.contact_x_m + c * sample.contact_y_m;
        for (patch, spells) in ground.patches.iter().zip(&mut self.patches) {
            let there = t_s >= patch.from_s && patch.until_s.is_none_or(|until_s| t_s < until_s);
            let [dx, dy] = [x_m - patch.center_m[0], y_m - patch.center_m[1]];
            if there && 2.0 * dx.abs() <= patch.sides_m[0] && 2.0 * dy.abs() <= patch.sides_m[1] {
                spells.add(t_s, dt_s, 1.0, [0.0; 2]);
            }
        }
        for (one, spells) in ground.boxes.iter().zip(&mut self.boxes) {
            let (sin, cos) = one.heading_rad.sin_cos();
            let [dx, dy] = [x_m - one.center_m[0], y_m - one.center_m[1]];
            let [along, across] = [cos * dx + sin * dy, cos * dy - sin * dx];
            let inside = |off: f64, side: f64| off.abs() <= 0.5 * side + EDGE_M;
            if inside(along, one.sides_m[0]) && inside(across, one.sides_m[1]) {
                spells.add(t_s, dt_s, 1.0, [0.0; 2]);
            }
        }
    }

    /// All that happened, in the order of time.
    pub fn events(&self, header: &Header) -> Vec<Event> {
        let mut events = faults(header, self.end_s);
        let mut push = |kind, spell: &Spell, text: String, slid_m: f64| {
            events.push(Event {
                from_s: spell.from_s,
                until_s: spell.until_s,
                kind,
                text,
                slid_m,
                lost_j: (spell.energy_j[1] - spell.energy_j[0]).max(0.0),
            });
        };
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
                    let text = format!("wheels are on a patch of friction {}", patch.friction);
                    push(EventKind::Ground, spell, text, 0.0);
                }
            }
            for (one, spells) in ground.boxes.iter().zip(&self.boxes) {
                for spell in &spells.found {
                    let height = length(one.sides_m[2]);
                    let text = format!("wheels cross a box {height} high");
                    push(EventKind::Ground, spell, text, 0.0);
                }
            }
        }
        events.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        events
    }
}

impl Event {
    /// Its times in words.
    pub fn when(&self) -> String {
        if self.until_s - self.from_s < 0.005 {
            format!("at {}", time(self.from_s))
        } else {
            format!("from {:.2} to {}", self.from_s, time(self.until_s))
        }
    }

    /// Whether it overlaps a time.
    pub fn overlaps(&self, from_s: f64, until_s: f64) -> bool {
        self.from_s <= until_s && self.until_s >= from_s
    }

    /// Whether it comes from outside of the robot.
    pub fn is_outside(&self) -> bool {
        matches!(self.kind, EventKind::Fault | EventKind::Ground)
    }
}

/// The faults of the scenario. What this version does not know is named by its key.
fn faults(header: &Header, end_s: f64) -> Vec<Event> {
    let Ok(scenario) = header.scenario_toml.parse::<toml::Table>() else {
        return Vec::new();
    };
    let faults = scenario.get("faults").and_then(Value::as_array);
    let faults = faults.into_iter().flatten().filter_map(Value::as_table);
    faults
        .flat_map(|fault| fault.iter())
        .filter_map(|(kind, fault)| {
            let number = |key: &str| {
                let value = fault.get(key)?;
                value.as_float().or(value.as_integer().map(|x| x as f64))
            };
            let from_s = number("from_s").unwrap_or(0.0);
            let until_s = number("until_s")
                .or_else(|| Some(from_s + number("lasts_s")?))
                .unwrap_or(end_s)
                .min(end_s.max(from_s));
            // A fault that would begin after the run's end did not happen.
            (from_s <= end_s).then(|| Event {
                from_s,
                until_s,
                kind: EventKind::Fault,
                text: fault_in_words(kind, fault, &number),
                slid_m: 0.0,
                lost_j: 0.0,
            })
        })
        .collect()
}

fn fault_in_words(kind: &str, fault: &Value, number: &dyn Fn(&str) -> Option<f64>) -> String {
    let wheel = fault
        .get("wheel")
        .and_then(Value::as_str)
        .unwrap_or("a wheel");
    let x = |key: &str| number(key).unwrap_or(0.0);
    match kind {
        "friction_changed" => {
            let friction = x("friction");
            let kind = if friction < 0.1 { "slippery" } else { "other" };
            match kind {
                "slippery" => format!("the floor was slippery (friction {friction})"),
                _ => format!("the floor's friction was {friction}"),
            }
        }
        "motor_lost" => format!("the motor of {wheel} gave no torque"),
        "encoder_lost" => format!("the encoder of {wheel} read zero"),
        "encoder_scaled" => format!("the encoder of {wheel} read {} times the rate", x("factor")),
        "pose_lost" => "the pose sensor saw nothing".to_owned(),
        "pose_shifted" => format!(
            "the pose sensor was off by {}",
            length(x("x_m").hypot(x("y_m")))
        ),
        "battery_sag" => format!(
            "the battery gave {:.0} % of its voltage",
            100.0 * x("factor")
        ),
        "push" => {
            let impulse = [x("impulse_x_n_s"), x("impulse_y_n_s"), x("impulse_z_n_s")];
            let size = impulse.iter().map(|i| i * i).sum::<f64>().sqrt();
            format!("the chassis was pushed with {size:.3} N s")
        }
        "payload" => format!("a payload of {} kg lay on the robot", x("mass_kg")),
        "roller_stuck" => format!("roller {} of {wheel} was stuck", x("roller")),
        other => other.replace('_', " "),
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
            scenario_toml:
                "[[faults]]\nfriction_changed = { friction = 0.02, from_s = 4, until_s = 7 }\n\
                            [[faults]]\nmotor_lost = { wheel = \"front\", from_s = 99 }\n"
                    .to_owned(),
            ..Header::default()
        }
    }

    /// Ten seconds ahead at 0.2 m/s; from 4 to 5 s the wheel slides at 0.1 m/s at its friction limit.
    fn watched() -> Vec<Event> {
        let header = header();
        let mut watch = Watch::new(&header);
        for row in 0..=1000 {
            let t_s = 0.01 * f64::from(row);
            let sliding = (4.0..5.0).contains(&t_s);
            let mut record = Record {
                t_s,
                ..Record::default()
            };
            record.truth.pose.x_m = 0.2 * t_s;
            let sample = WheelSample {
                touching: true,
                normal_force_n: 10.0,
                friction: 0.6,
                force_x_n: if sliding { 6.0 } else { 1.0 },
                slip_x_m_s: if sliding { 0.1 } else { 0.001 },
                ..WheelSample::default()
            };
            watch.add(&header, &record, &[sample]);
        }
        watch.events(&header)
    }

    #[test]
    fn a_slide_is_found_with_its_times_and_its_length() {
        let events = watched();
        let slides: Vec<_> = events
            .iter()
            .filter(|e| e.kind == EventKind::Slide(0))
            .collect();
        assert_eq!(slides.len(), 1);
        // A hundred rows of 0.1 m/s over 10 ms; the ends to a row.
        assert!(
            (slides[0].slid_m - 0.1).abs() < 1e-3,
            "{}",
            slides[0].slid_m
        );
        assert!((slides[0].from_s - 4.0).abs() < 0.015 && (slides[0].until_s - 5.0).abs() < 0.015);
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

    #[test]
    fn a_fault_that_begins_after_the_end_did_not_happen() {
        let faults: Vec<_> = watched()
            .into_iter()
            .filter(|e| e.kind == EventKind::Fault)
            .collect();
        assert_eq!(faults.len(), 1);
        assert_eq!((faults[0].from_s, faults[0].until_s), (4.0, 7.0));
        assert!(faults[0].text.contains("slippery"), "{}", faults[0].text);
    }
}
