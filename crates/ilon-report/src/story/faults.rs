//! What went wrong on purpose, in words, and what came of it.

use ilon_robot::{Pose, Twist, wrap_angle};
use ilon_trace::metrics::error;
use ilon_trace::{Fault, FaultKind, Header, Record};

use super::phrases::list;
use super::posture::{Episode, Posture};
use crate::short;
use crate::text::{angle, length, percent};

/// How long after a fault what comes of it still counts, in seconds; and how long before it the motion is looked at.
const AROUND_S: f64 = 0.5;
/// A fall takes its time: what the robot does within this after a fault came of it, in seconds.
const FALLS_WITHIN_S: f64 = 1.5;
/// Ways and turns below these did not come of a fault: in metres and radians, and as a share of the way asked for.
const LEAST_M: f64 = 1e-3;
const LEAST_RAD: f64 = 2e-3;
const LEAST_SHARE: f64 = 5e-3;
/// Twists nearer than this are the same, in m/s or rad/s.
const SAME: f64 = 1e-9;
/// Floors of less friction are called slippery.
const SLIPPERY: f64 = 0.1;

/// A fault that happened, with what came of it.
#[derive(Clone, Debug)]
pub(crate) struct Trouble {
    pub from_s: f64,
    pub until_s: f64,
    /// What it was, without its times.
    pub text: String,
    pub is_slippery: bool,
    effect: Effect,
}

/// What a robot did around a fault.
#[derive(Clone, Copy, Debug, Default)]
struct Effect {
    /// Real minus asked twist before it, summed over time, and for how long; none where another motion was asked for.
    off_before: Twist,
    before_s: f64,
    asked_at_start: Twist,
    /// Where the robot would be if it had gone on as before, and where it is.
    expected: Option<Pose>,
    real: Pose,
    /// The last row: its time in seconds, and how the robot would go on.
    goes: (f64, Twist),
    /// The way asked for, in metres.
    asked_m: f64,
    /// The distance from the reference at the start, and at most, in metres.
    error_m: Option<[f64; 2]>,
}

/// Watches the rows around each fault.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watch {
    faults: Vec<(Fault, Effect)>,
    /// The rows of the last moments: time, asked and real twist.
    recent: std::collections::VecDeque<(f64, Twist, Twist)>,
    end_s: f64,
}

impl Watch {
    pub fn new(header: &Header) -> Self {
        let faults = header.faults.iter().flatten();
        Self {
            faults: faults.map(|f| (f.clone(), Effect::default())).collect(),
            ..Self::default()
        }
    }

    pub fn add(&mut self, header: &Header, record: &Record) {
        self.end_s = record.t_s;
        if self.faults.is_empty() {
            return;
        }
        let (t_s, dt_s) = (record.t_s, header.row_dt_s());
        let (asked, real) = (record.command_twist_in_body, record.truth.twist_in_body);
        for (fault, effect) in &mut self.faults {
            let until_s = fault.until_s.unwrap_or(f64::INFINITY) + AROUND_S;
            // Half a row is rounding.
            if t_s > fault.from_s - 0.5 * dt_s && t_s < until_s {
                if effect.expected.is_none() {
                    effect.begin(asked, self.recent.iter());
                }
                effect.add(header, record);
            }
        }
        self.recent.push_back((dt_s, asked, real));
        while self.recent.len() as f64 * dt_s > AROUND_S {
            self.recent.pop_front();
        }
    }

    /// Those that happened before the end, in the order of time; alike ones of the same time are one.
    pub fn troubles(&self, header: &Header) -> Vec<Trouble> {
        let mut troubles: Vec<Trouble> = Vec::new();
        let happened = |fault: &Fault| fault.from_s <= self.end_s;
        let faults: Vec<_> = self.faults.iter().filter(|(f, _)| happened(f)).collect();
        let mut told = vec![false; faults.len()];
        for (index, (fault, effect)) in faults.iter().enumerate() {
            if told[index] {
                continue;
            }
            let mut together = vec![&fault.kind];
            for ((other, _), told) in faults.iter().zip(&mut told).skip(index + 1) {
                let window = |f: &Fault| (f.from_s, f.until_s);
                if window(other) == window(fault) && alike(&other.kind, &fault.kind) {
                    *told = true;
                    together.push(&other.kind);
                }
            }
            let until_s = fault.until_s.unwrap_or(self.end_s);
            troubles.push(Trouble {
                from_s: fault.from_s,
                until_s: until_s.min(self.end_s.max(fault.from_s)),
                text: in_words(&together, fault, header),
                is_slippery: matches!(fault.kind, FaultKind::FrictionChanged { friction } if friction < SLIPPERY),
                effect: *effect,
            });
        }
        troubles.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        troubles
    }
}

impl Effect {
    fn begin<'a>(&mut self, asked: Twist, before: impl Iterator<Item = &'a (f64, Twist, Twist)>) {
        self.asked_at_start = asked;
        for (dt_s, then_asked, then_real) in before {
            if !same(*then_asked, asked) {
                // A robot that speeds up is no measure of how it goes on.
                (self.off_before, self.before_s) = (Twist::default(), 0.0);
                continue;
            }
            self.off_before = self.off_before + (*then_real - *then_asked).scaled(*dt_s);
            self.before_s += dt_s;
        }
    }

    fn add(&mut self, header: &Header, record: &Record) {
        let (since_s, went) = self.goes;
        let dt_s = record.t_s - since_s;
        self.expected = Some(match self.expected {
            Some(expected) => {
                self.asked_m += went.linear_m_s().norm() * dt_s;
                expected.moved(went.scaled(dt_s))
            }
            None => record.truth.pose,
        });
        self.real = record.truth.pose;
        let mut goes = record.command_twist_in_body;
        if self.before_s > 0.0 && same(goes, self.asked_at_start) {
            goes = goes + self.off_before.scaled(1.0 / self.before_s);
        }
        self.goes = (record.t_s, goes);
        if let Some((off_m, _)) = error(header, record) {
            let [_, most_m] = self.error_m.get_or_insert([off_m; 2]);
            *most_m = most_m.max(off_m);
        }
    }
}

fn same(a: Twist, b: Twist) -> bool {
    let off = a - b;
    [off.vx_m_s, off.vy_m_s, off.omega_rad_s]
        .iter()
        .all(|x| x.abs() <= SAME)
}

/// Whether two faults are the same but for their wheel.
fn alike(a: &FaultKind, b: &FaultKind) -> bool {
    use FaultKind::{EncoderLost, EncoderScaled, MotorLost};
    match (a, b) {
        (MotorLost { shorted: a, .. }, MotorLost { shorted: b, .. }) => a == b,
        (EncoderLost { .. }, EncoderLost { .. }) => true,
        (EncoderScaled { factor: a, .. }, EncoderScaled { factor: b, .. }) => a == b,
        _ => false,
    }
}

fn in_words(together: &[&FaultKind], fault: &Fault, header: &Header) -> String {
    let name = |wheel: usize| {
        let known = header.wheels.get(wheel).map(|of| of.name.as_str());
        known.unwrap_or("a wheel").to_owned()
    };
    let wheels = together.iter().filter_map(|kind| match kind {
        FaultKind::MotorLost { wheel, .. }
        | FaultKind::EncoderLost { wheel }
        | FaultKind::EncoderScaled { wheel, .. } => Some(name(*wheel)),
        _ => None,
    });
    let wheels: Vec<String> = wheels.collect();
    let of = |part: &str| match wheels.len() {
        0 | 1 => format!("the {part} of {}", list(&wheels)),
        _ => format!("the {part}s of {}", list(&wheels)),
    };
    match &fault.kind {
        FaultKind::MotorLost { shorted: true, .. } => match wheels.len() {
            0 | 1 => format!("{} was shorted", of("motor")),
            _ => format!("{} were shorted", of("motor")),
        },
        FaultKind::MotorLost { .. } => format!("{} gave no torque", of("motor")),
        FaultKind::EncoderLost { .. } => format!("{} read zero", of("encoder")),
        FaultKind::EncoderScaled { factor, .. } => {
            format!(
                "{} read {} times the rate",
                of("encoder"),
                short(*factor, 4)
            )
        }
        FaultKind::PoseLost => "the pose sensor saw nothing".to_owned(),
        FaultKind::PoseShifted { by_m, by_rad } => {
            let way_m = by_m[0].hypot(by_m[1]);
            let parts = [
                (way_m > 0.0).then(|| length(way_m)),
                (*by_rad != 0.0).then(|| angle(*by_rad)),
            ];
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            match parts.is_empty() {
                true => "the pose sensor was off by nothing".to_owned(),
                false => format!("the pose sensor was off by {}", list(&parts)),
            }
        }
        FaultKind::BatterySag { share } => {
            format!("the battery gave {} of its voltage", percent(*share))
        }
        FaultKind::Push { impulse_n_s, .. } => {
            let size_n_s = impulse_n_s.iter().map(|i| i * i).sum::<f64>().sqrt();
            let lasts_s = fault.until_s.unwrap_or(fault.from_s) - fault.from_s;
            let with = match lasts_s > 0.0 {
                true => format!(" ({} N)", short(size_n_s / lasts_s, 4)),
                false => String::new(),
            };
            format!(
                "the chassis was pushed with {} N s{with}",
                short(size_n_s, 4)
            )
        }
        FaultKind::Payload { mass_kg, .. } => {
            let part = match header.mass_kg > 0.0 {
                true => format!(
                    " ({} of the robot's own mass)",
                    percent(mass_kg / header.mass_kg)
                ),
                false => String::new(),
            };
            format!(
                "a payload of {} kg lay on the robot{part}",
                short(*mass_kg, 4)
            )
        }
        FaultKind::RollerStuck { wheel, roller } => {
            format!(
                "roller {roller} of {} did not turn on its axle",
                name(*wheel)
            )
        }
        FaultKind::FrictionChanged { friction } => match *friction < SLIPPERY {
            true => format!("the floor was slippery (friction {friction})"),
            false => format!("the floor's friction was {friction}"),
        },
        FaultKind::Tilt {
            amplitude_rad,
            frequency_hz,
            ..
        } => {
            let by_deg = short(amplitude_rad.to_degrees().abs(), 3);
            match *frequency_hz > 0.0 {
                true => format!(
                    "the ground rocked by {by_deg} deg at {} Hz",
                    short(*frequency_hz, 3)
                ),
                false => format!("the ground leaned by {by_deg} deg"),
            }
        }
    }
}

impl Trouble {
    /// What came of it, as a clause.
    pub fn consequence(&self, posture: &Posture) -> String {
        let after = self.from_s - 1e-9..self.until_s + FALLS_WITHIN_S;
        let came = |episode: &&Episode| after.contains(&episode.from_s);
        if let Some(episode) = posture.episodes().into_iter().find(came) {
            return episode.consequence();
        }
        match self.effect.error_m {
            Some([before_m, most_m]) if most_m > before_m + LEAST_M => format!(
                "the position error grew from {} to {}",
                length(before_m),
                length(most_m)
            ),
            Some([_, most_m]) => format!("the position error stayed within {}", length(most_m)),
            None => self.effect.went(),
        }
    }
}

impl Effect {
    /// How the robot went against how it had gone before.
    fn went(&self) -> String {
        let Some(expected) = self.expected else {
            return "nothing came of it".to_owned();
        };
        let (sin, cos) = expected.heading_rad.sin_cos();
        let [dx, dy] = [self.real.x_m - expected.x_m, self.real.y_m - expected.y_m];
        let (along_m, left_m) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let turn_rad = wrap_angle(self.real.heading_rad - expected.heading_rad);
        let least_m = LEAST_M.max(LEAST_SHARE * self.asked_m);
        let side =
            |x: f64, plus: &'static str, minus: &'static str| if x < 0.0 { minus } else { plus };
        let places = [
            (along_m, side(along_m, "ahead", "behind")),
            (left_m, side(left_m, "to the left", "to the right")),
        ];
        let places = places.iter().filter(|(off_m, _)| off_m.abs() > least_m);
        let places: Vec<String> = places
            .map(|(off_m, way)| format!("{} {way}", length(off_m.abs())))
            .collect();
        let turned = (turn_rad.abs() > LEAST_RAD).then(|| {
            let way = side(turn_rad, "left", "right");
            format!("by {} to the {way}", angle(turn_rad.abs()))
        });
        match (places.is_empty(), turned) {
            (true, None) => "the robot went on as before".to_owned(),
            (true, Some(turned)) => format!("it turned the robot {turned}"),
            (false, None) => format!("it put the robot {}", list(&places)),
            (false, Some(turned)) => {
                format!("it put the robot {} and turned it {turned}", list(&places))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::{Support, Truth, WheelHeader, WheelSample};

    fn fault(from_s: f64, until_s: Option<f64>, kind: FaultKind) -> Fault {
        Fault {
            from_s,
            until_s,
            kind,
        }
    }

    /// Ten seconds ahead at 0.2 m/s, of which the robot does a hundredth less, and from 4 to 6 s half; there are these faults.
    fn watched(faults: Vec<Fault>) -> Vec<Trouble> {
        let names = ["a", "b", "c", "d"].map(|name| WheelHeader {
            name: name.to_owned(),
            ..WheelHeader::default()
        });
        let header = Header {
            wheels: names.to_vec(),
            control_dt_s: 0.01,
            faults: Some(faults),
            ..Header::default()
        };
        let mut watch = Watch::new(&header);
        let mut x_m = 0.0;
        for row in 0..=1000 {
            let t_s = 0.01 * f64::from(row);
            let slow = (3.995..5.995).contains(&t_s);
            let real = Twist::new(if slow { 0.1 } else { 0.198 }, 0.0, 0.0);
            let record = Record {
                t_s,
                command_twist_in_body: Twist::new(0.2, 0.0, 0.0),
                truth: Truth {
                    pose: Pose {
                        x_m,
                        ..Pose::default()
                    },
                    twist_in_body: real,
                    ..Truth::default()
                },
                ..Record::default()
            };
            watch.add(&header, &record);
            x_m += 0.01 * real.vx_m_s;
        }
        watch.troubles(&header)
    }

    #[test]
    fn a_fault_says_by_how_much_the_robot_left_its_way_against_how_it_went_before() {
        let kind = FaultKind::BatterySag { share: 0.5 };
        let troubles = watched(vec![fault(4.0, Some(6.0), kind.clone())]);
        assert_eq!(troubles[0].text, "the battery gave 50.0 % of its voltage");
        // 0.198 - 0.1 m/s for two seconds.
        let came = troubles[0].consequence(&Posture::default());
        assert_eq!(came, "it put the robot 196.0 mm behind");
        // Where nothing changes nothing came of it, though the robot always falls a hundredth short.
        let quiet = watched(vec![fault(7.0, Some(8.0), kind)]);
        assert_eq!(
            quiet[0].consequence(&Posture::default()),
            "the robot went on as before"
        );
    }

    /// A robot that stands on its wheels, and from a time on lies on its nose.
    fn tips_over(at_s: f64) -> Posture {
        let header = Header {
            wheels: vec![WheelHeader {
                radius_m: 0.05,
                ..WheelHeader::default()
            }],
            control_dt_s: 0.01,
            ..Header::default()
        };
        let mut posture = Posture::default();
        for row in 0..=1000 {
            let t_s = 0.01 * f64::from(row);
            let pitch_rad = if t_s < at_s { 0.0 } else { 1.4 };
            let record = Record {
                t_s,
                support: Some(Support {
                    wheels_n: 50.0,
                    chassis_n: if t_s < at_s { 0.0 } else { 50.0 },
                    ..Support::default()
                }),
                truth: Truth {
                    pitch_rad,
                    ..Truth::default()
                },
                ..Record::default()
            };
            let sample = WheelSample {
                touching: true,
                hub_height_m: 0.05,
                ..WheelSample::default()
            }
            .steady();
            posture.add(&header, &record, &[sample]);
        }
        posture
    }

    /// What comes from the beginning of a fault on until a second and a half after its end came of it; what was before it and what comes
    /// later did not. A row speaks of the 10 ms since the row before it: what it shows at 4 s was there before 4 s.
    #[test]
    fn a_fall_comes_of_a_fault_from_its_beginning_until_a_while_after_its_end() {
        let kind = FaultKind::BatterySag { share: 0.5 };
        let trouble = &watched(vec![fault(4.0, Some(6.0), kind)])[0];
        for (at_s, came_of_it) in [
            (4.0, false),
            (4.01, true),
            (5.0, true),
            (6.2, true),
            (7.4, true),
            (7.6, false),
        ] {
            let came = trouble.consequence(&tips_over(at_s));
            assert_eq!(came.contains("tipped over"), came_of_it, "{at_s} s: {came}");
        }
    }

    #[test]
    fn alike_faults_of_the_same_time_are_told_together_and_all_are_named() {
        let motor = |wheel, shorted| fault(2.0, None, FaultKind::MotorLost { wheel, shorted });
        let lost = |wheel| motor(wheel, false);
        let troubles = watched((0..4).map(lost).collect());
        assert_eq!(troubles.len(), 1);
        assert_eq!(
            troubles[0].text,
            "the motors of a, b, c and d gave no torque"
        );
        let troubles = watched(vec![motor(0, true), lost(1), motor(2, true)]);
        let texts: Vec<_> = troubles.iter().map(|t| t.text.as_str()).collect();
        assert_eq!(
            texts,
            [
                "the motors of a and c were shorted",
                "the motor of b gave no torque"
            ]
        );
        let mut other = lost(3);
        other.from_s = 3.0;
        let troubles = watched(vec![lost(0), other, lost(1)]);
        let texts: Vec<_> = troubles.iter().map(|t| t.text.as_str()).collect();
        assert_eq!(
            texts,
            [
                "the motors of a and b gave no torque",
                "the motor of d gave no torque"
            ]
        );
    }

    #[test]
    fn a_fault_that_begins_after_the_end_did_not_happen() {
        assert!(watched(vec![fault(99.0, None, FaultKind::PoseLost)]).is_empty());
        let open = watched(vec![fault(4.0, Some(99.0), FaultKind::PoseLost)]);
        assert_eq!((open[0].from_s, open[0].until_s), (4.0, 10.0));
    }
}
