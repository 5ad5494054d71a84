//! The robot's posture: on its wheels, on its chassis, tipped over, in the air, fallen off the
//! ground, or against an obstacle.
//!
//! Shares of a motion are meaningful only for a robot that stands on its wheels and moves freely.
//! So the posture is found first, from the ground's forces on wheels and chassis
//! ([`ilon_trace::Support`]) and from the pose.

use ilon_trace::{GroundBox, Header, Record, WheelHeader, WheelSample};

use super::phrases::span;
use super::spells::GAP_S;
use crate::page::escape;
use crate::text::{angle, capital, energy, force, length, percent, speed};

/// A robot that leans more than this against the floor's normal has tipped over, in radians: 45
/// degrees.
pub(super) const TIPPED_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// The chassis stands on the ground if it carries more than this share; less is a passing touch.
const ON_CHASSIS_SHARE: f64 = 1e-3;
/// The same for a robot on tyres, whose casters are bodies on joints (chosen).
const BESIDE_TYRES_SHARE: f64 = 0.75;
/// A robot that achieves less than this share of the commanded motion is blocked.
const BLOCKED_SHARE: f64 = 0.1;
/// A wall pushes the robot aside if it pushes with more than this share of the weight, and with
/// more than [`ASIDE_SHARE`] of that across the commanded motion.
const PUSHED_SHARE: f64 = 0.03;
const ASIDE_SHARE: f64 = 0.2;
/// Slower commands count as standing, in m/s.
const SLOWEST_ASKED_M_S: f64 = 0.01;
/// Smaller forces count as zero, in N.
const LEAST_N: f64 = 1e-9;
/// A posture is reported from this duration on, in seconds.
const LEAST_S: f64 = 0.1;
/// The same for a flight and for a wall.
const LEAST_FLIGHT_S: f64 = 0.02;
const LEAST_BLOCKED_S: f64 = 0.3;
/// A flight is reported from this height on, in metres.
const LEAST_HEIGHT_M: f64 = 1e-3;
/// Time after which a landing's energy is dissipated, in seconds.
const LANDING_S: f64 = 0.2;
/// A smaller lean is not reported, in radians.
const LEAST_LEAN_RAD: f64 = 0.02;
/// Shares of a motion are meaningless if the robot did not stand on its wheels for more than this
/// share of the time.
const MOST_SPOILT: f64 = 0.1;

/// Postures other than standing freely on the wheels; the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stance {
    /// Below the ground, without support.
    Fallen,
    /// Tipped over.
    Tipped,
    /// Off the ground.
    InTheAir,
    /// The chassis carries a part of the weight.
    OnChassis,
    /// An obstacle is in the way.
    Blocked,
    /// A wall pushes it aside.
    Along,
}

/// A time span with one posture.
#[derive(Clone, Debug)]
pub(crate) struct Episode {
    pub stance: Stance,
    pub from_s: f64,
    pub until_s: f64,
    time_s: f64,
    /// Forces carried by wheels and chassis, and the resisting force: integrals over time, in N s.
    carried_n_s: [f64; 2],
    held_back_n_s: f64,
    /// Force to the left of the commanded motion, integrated, in N s.
    aside_n_s: f64,
    /// The commanded distance, and the one achieved along it, in metres.
    asked_m: f64,
    done_m: f64,
    /// Duration of the command, in seconds.
    asked_s: f64,
    lean_rad: f64,
    lies_on: &'static str,
    /// Height of the body's origin at the start and at most, and of the highest hub at the end, in
    /// metres.
    height_m: [f64; 2],
    highest_hub_m: f64,
    /// Energy lost in impacts at its start, and shortly after its end, in J.
    hits_j: [f64; 2],
    obstacle: Option<GroundBox>,
    /// The free body in the way, if it was not a box of the ground.
    body: Option<usize>,
}

/// Detects the robot's posture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Posture {
    episodes: Vec<Episode>,
    height_before_m: f64,
    hits_before_j: f64,
    /// End of the run, in seconds.
    pub end_s: f64,
}

/// Returns the body's lean against the floor's normal in radians, and the side on which it lies.
fn lean(record: &Record) -> (f64, &'static str) {
    let (sin_roll, cos_roll) = record.truth.roll_rad.sin_cos();
    let (sin_pitch, cos_pitch) = record.truth.pitch_rad.sin_cos();
    // The direction of the floor in the body frame.
    let [x, y, z] = [sin_pitch, -cos_pitch * sin_roll, -cos_pitch * cos_roll];
    let on = if z > 0.707 {
        "its top"
    } else if x.abs() > y.abs() {
        if x > 0.0 { "its nose" } else { "its back" }
    } else if y > 0.0 {
        "its left side"
    } else {
        "its right side"
    };
    ((-z).clamp(-1.0, 1.0).acos(), on)
}

/// Returns the unit vector of the commanded motion, and its speed in m/s; `None` for a command to
/// stand.
fn asked(record: &Record) -> Option<([f64; 2], f64)> {
    let v = record.command_twist_in_body;
    let speed_m_s = v.vx_m_s.hypot(v.vy_m_s);
    let along = [v.vx_m_s / speed_m_s, v.vy_m_s / speed_m_s];
    (speed_m_s > SLOWEST_ASKED_M_S).then_some((along, speed_m_s))
}

/// Returns the speed along the commanded motion in m/s, and the resisting force in N.
fn progress(header: &Header, record: &Record) -> Option<(f64, f64)> {
    let ([x, y], _) = asked(record)?;
    let real = record.truth.twist_in_body;
    let support = record.support.unwrap_or_default();
    let by_ground_n = -(support.obstacles_x_n * x + support.obstacles_y_n * y);
    let held_back_n = by_ground_n + in_the_way(header, record).map_or(0.0, |(_, push_n)| push_n);
    Some((real.vx_m_s * x + real.vy_m_s * y, held_back_n))
}

/// Returns the free body on which the robot presses hardest, and the force in N, without bodies on
/// its deck, within its wheels.
fn in_the_way(header: &Header, record: &Record) -> Option<(usize, f64)> {
    let pose = record.truth.pose;
    let (sin, cos) = pose.heading_rad.sin_cos();
    let bounds = |axis: usize| {
        let places = header
            .wheels
            .iter()
            .map(move |wheel| wheel.position_m[axis]);
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], m| {
            [low.min(m), high.max(m)]
        })
    };
    let [xs, ys] = [bounds(0), bounds(1)];
    let is_on_deck = |place_m: [f64; 3]| {
        let [dx, dy] = [place_m[0] - pose.x_m, place_m[1] - pose.y_m];
        let [x, y] = [cos * dx + sin * dy, cos * dy - sin * dx];
        (xs[0]..=xs[1]).contains(&x) && (ys[0]..=ys[1]).contains(&y)
    };
    let bodies = record.bodies.iter().take(header.bodies.len()).enumerate();
    let pressed = bodies.filter(|(_, body)| body.push_n > 0.0 && !is_on_deck(body.place_m));
    pressed
        .map(|(index, body)| (index, body.push_n))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns what a robot may stand on besides its wheels, and what carries there: a trace does not
/// distinguish the chassis from bodies on joints.
fn on_which(header: &Header) -> [&'static str; 2] {
    match header.joints.is_empty() {
        true => ["its chassis", "the chassis"],
        false => ["its chassis, or on a body on one of its joints", "these"],
    }
}

/// Returns the robot's posture in a row, if it does not stand freely on its wheels.
fn stances(header: &Header, record: &Record, samples: &[WheelSample]) -> [Option<Stance>; 2] {
    let touches = samples.iter().any(WheelSample::touched);
    let (carried_n, chassis_n, pushed_n) = match record.support {
        Some(s) => (
            s.wheels_n + s.chassis_n,
            s.chassis_n,
            s.obstacles_x_n.hypot(s.obstacles_y_n),
        ),
        // Older traces only contain which wheels touch.
        None => (f64::from(u8::from(touches)), 0.0, 0.0),
    };
    let in_the_air = carried_n <= LEAST_N && pushed_n <= LEAST_N && !touches;
    let below = samples.iter().all(|sample| sample.hub_height_m < 0.0);
    // Casters carry their share beside tyres.
    let on_chassis = match header.wheels.iter().any(WheelHeader::has_tyre) {
        true => BESIDE_TYRES_SHARE,
        false => ON_CHASSIS_SHARE,
    };
    let stands = if in_the_air && below {
        Some(Stance::Fallen)
    } else if lean(record).0 > TIPPED_RAD {
        Some(Stance::Tipped)
    } else if in_the_air {
        Some(Stance::InTheAir)
    } else if chassis_n - pushed_n > on_chassis * carried_n {
        // A wall carries a small part of a chassis that scrapes along it.
        Some(Stance::OnChassis)
    } else {
        None
    };
    let blocked = asked(record).zip(progress(header, record)).is_some_and(
        |((_, asked_m_s), (done_m_s, held_back_n))| {
            done_m_s < BLOCKED_SHARE * asked_m_s && held_back_n > ON_CHASSIS_SHARE * carried_n
        },
    );
    let along = aside_n(record).is_some_and(|aside_n| {
        let is_pushed = pushed_n > PUSHED_SHARE * carried_n;
        is_pushed && aside_n.abs() > ASIDE_SHARE * pushed_n && is_at_wall(header, record)
    });
    let way = match (blocked, along) {
        (true, _) => Some(Stance::Blocked),
        (false, true) => Some(Stance::Along),
        (false, false) => None,
    };
    [stands, way]
}

/// Returns the force with which obstacles of the ground push the robot to the left of the commanded
/// motion, in N.
fn aside_n(record: &Record) -> Option<f64> {
    let ([x, y], _) = asked(record)?;
    let support = record.support?;
    Some(support.obstacles_y_n * x - support.obstacles_x_n * y)
}

impl Posture {
    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let t_s = record.t_s;
        self.end_s = t_s;
        for episode in &mut self.episodes {
            if t_s - episode.until_s <= LANDING_S {
                episode.hits_j[1] = record.impact_energy_j;
            }
        }
        // At the start no step has been made yet.
        if t_s > 0.0 && !samples.is_empty() {
            for stance in stances(header, record, samples).into_iter().flatten() {
                self.extend(stance, header, record, samples);
            }
        }
        self.height_before_m = record.truth.height_m;
        self.hits_before_j = record.impact_energy_j;
    }

    fn extend(
        &mut self,
        stance: Stance,
        header: &Header,
        record: &Record,
        samples: &[WheelSample],
    ) {
        let (t_s, dt_s) = (record.t_s, header.row_dt_s());
        let mut own = self.episodes.iter_mut().rev();
        let latest = own.find(|episode| episode.stance == stance);
        let goes_on = |episode: &Episode| t_s - episode.until_s <= GAP_S + dt_s;
        let episode = match latest.filter(|episode| goes_on(episode)) {
            Some(episode) => episode,
            None => {
                self.episodes.push(Episode {
                    stance,
                    from_s: (t_s - dt_s).max(0.0),
                    until_s: t_s,
                    time_s: 0.0,
                    carried_n_s: [0.0; 2],
                    held_back_n_s: 0.0,
                    aside_n_s: 0.0,
                    asked_m: 0.0,
                    done_m: 0.0,
                    asked_s: 0.0,
                    lean_rad: 0.0,
                    lies_on: "",
                    height_m: [self.height_before_m; 2],
                    highest_hub_m: 0.0,
                    hits_j: [self.hits_before_j; 2],
                    body: match stance {
                        Stance::Blocked => in_the_way(header, record).map(|(body, _)| body),
                        _ => None,
                    },
                    obstacle: match stance {
                        Stance::Blocked | Stance::Along => nearest_box(header, record),
                        _ => None,
                    },
                });
                let last = self.episodes.len() - 1;
                &mut self.episodes[last]
            }
        };
        episode.until_s = t_s;
        episode.time_s += dt_s;
        let support = record.support.unwrap_or_default();
        episode.carried_n_s[0] += support.wheels_n * dt_s;
        episode.carried_n_s[1] += support.chassis_n * dt_s;
        if let (Some((_, asked_m_s)), Some((done_m_s, held_back_n))) =
            (asked(record), progress(header, record))
        {
            episode.asked_s += dt_s;
            episode.asked_m += asked_m_s * dt_s;
            episode.done_m += done_m_s * dt_s;
            episode.held_back_n_s += held_back_n * dt_s;
            episode.aside_n_s += aside_n(record).unwrap_or(0.0) * dt_s;
        }
        let (lean_rad, lies_on) = lean(record);
        episode.lean_rad = episode.lean_rad.max(lean_rad);
        episode.lies_on = lies_on;
        episode.height_m[1] = episode.height_m[1].max(record.truth.height_m);
        let hubs_m = samples.iter().map(|sample| sample.hub_height_m);
        episode.highest_hub_m = hubs_m.fold(f64::NEG_INFINITY, f64::max);
        episode.hits_j[1] = record.impact_energy_j;
    }

    /// Returns the reportable episodes, the worst first.
    pub fn episodes(&self) -> Vec<&Episode> {
        let mut told: Vec<&Episode> = self.episodes.iter().filter(|e| e.is_told()).collect();
        told.sort_by(|a, b| {
            let by_stance = a.stance.cmp(&b.stance);
            by_stance.then(b.time_s.total_cmp(&a.time_s))
        });
        told
    }

    /// Whether shares of a motion between two times are meaningless, because the robot did not
    /// stand freely on its wheels.
    pub fn spoils(&self, from_s: f64, until_s: f64) -> bool {
        let until_s = until_s.min(self.end_s);
        let overlap_s = |e: &Episode| (e.until_s.min(until_s) - e.from_s.max(from_s)).max(0.0);
        let spoilt_s: f64 = self.episodes().into_iter().map(overlap_s).sum();
        // A run that ends before the window of its means has none that could be meaningless.
        spoilt_s > MOST_SPOILT * (until_s - from_s).max(0.0)
    }
}

impl Episode {
    fn is_told(&self) -> bool {
        match self.stance {
            Stance::Fallen | Stance::Tipped | Stance::OnChassis => self.time_s >= LEAST_S,
            Stance::InTheAir => self.time_s >= LEAST_FLIGHT_S && self.rise_m() >= LEAST_HEIGHT_M,
            Stance::Blocked | Stance::Along => self.time_s >= LEAST_BLOCKED_S,
        }
    }

    fn rise_m(&self) -> f64 {
        self.height_m[1] - self.height_m[0]
    }

    /// Returns a short description.
    pub fn text(&self) -> String {
        match self.stance {
            Stance::Fallen => "the robot fell off the ground".to_owned(),
            Stance::Tipped => format!("the robot lay tipped over on {}", self.lies_on),
            Stance::InTheAir => "the robot was in the air".to_owned(),
            Stance::OnChassis => "the robot stood on its chassis".to_owned(),
            Stance::Blocked => "the robot stood against an obstacle".to_owned(),
            Stance::Along => "the robot slid along an obstacle".to_owned(),
        }
    }

    /// Returns the chassis's share of the carried load.
    fn chassis_share(&self) -> f64 {
        let [wheels_n_s, chassis_n_s] = self.carried_n_s;
        chassis_n_s / (wheels_n_s + chassis_n_s)
    }

    /// Returns a sentence with figures, as HTML.
    pub fn sentence(&self, header: &Header, end_s: f64) -> String {
        let when = capital(&span(self.from_s, self.until_s, end_s, header.row_dt_s()));
        let what = match self.stance {
            Stance::Fallen => format!(
                "<b>fell off the ground</b>: nothing was under it, and at last it was <b>{}</b> below the floor",
                length(-self.highest_hub_m)
            ),
            Stance::Tipped => self.tipped(),
            Stance::InTheAir => self.in_the_air(end_s - self.until_s > header.row_dt_s()),
            Stance::OnChassis => self.on_chassis(header),
            Stance::Blocked => self.blocked(header),
            Stance::Along => self.along(),
        };
        format!("{when} the robot {what}.")
    }

    fn tipped(&self) -> String {
        let carried = match self.carried_n().iter().sum::<f64>() > LEAST_N {
            true => format!(
                ", and its wheels carried {} of what the ground held",
                percent(1.0 - self.chassis_share())
            ),
            false => String::new(),
        };
        format!(
            "lay <b>tipped over on {}</b>: it leaned by up to <b>{}</b>{carried}",
            self.lies_on,
            angle(self.lean_rad)
        )
    }

    fn in_the_air(&self, has_landed: bool) -> String {
        let landed = match has_landed {
            true => format!(
                "the landing took <b>{}</b>",
                energy(self.hits_j[1] - self.hits_j[0])
            ),
            false => "it has not landed".to_owned(),
        };
        format!(
            "was <b>in the air</b>, up to <b>{}</b> above where it left the ground; {landed}",
            length(self.rise_m())
        )
    }

    fn on_chassis(&self, header: &Header) -> String {
        let lean = match self.lean_rad > LEAST_LEAN_RAD {
            true => format!(", leaning by up to {}", angle(self.lean_rad)),
            false => String::new(),
        };
        let of_asked = self.of_asked();
        let motion = match of_asked.is_empty() {
            true => of_asked,
            false => format!("; {of_asked}"),
        };
        let [wheels_n, chassis_n] = self.carried_n();
        let [on, what] = on_which(header);
        format!(
            "stood <b>on {on}</b>{lean}: the wheels carried {}, and {what} {}, <b>{}</b> of the weight{motion}",
            force(wheels_n),
            force(chassis_n),
            percent(self.chassis_share())
        )
    }

    fn blocked(&self, header: &Header) -> String {
        let body = self.body.and_then(|body| header.bodies.get(body));
        let what = match (body, self.obstacle.map(|of| of.sides_m[2])) {
            (Some(body), _) => format!(
                "stood <b>against {}</b>, which it could not push on",
                escape(&body.name)
            ),
            (None, Some(height_m)) if height_m < least_radius_m(header) => format!(
                "was <b>caught at a kerb</b>, a box {} high",
                length(height_m)
            ),
            (None, Some(height_m)) => format!(
                "stood <b>against a wall</b>, a box {} high",
                length(height_m)
            ),
            (None, None) => "stood <b>against a bump</b> of the ground".to_owned(),
        };
        format!(
            "{what}: {}, held back by <b>{}</b>",
            self.of_asked(),
            force(self.held_back_n_s / self.asked_over_s())
        )
    }

    fn along(&self) -> String {
        let height_m = self.obstacle.map_or(0.0, |of| of.sides_m[2]);
        let side = match self.aside_n_s > 0.0 {
            true => "left",
            false => "right",
        };
        let asked_s = self.asked_over_s();
        format!(
            "slid <b>along a wall</b>, a box {} high: {}; the wall held it back by <b>{}</b> and pushed it to the {side} by <b>{}</b>",
            length(height_m),
            self.of_asked(),
            force(self.held_back_n_s / asked_s),
            force(self.aside_n_s.abs() / asked_s)
        )
    }

    /// Returns the mean loads carried by wheels and chassis, in N.
    fn carried_n(&self) -> [f64; 2] {
        let over_s = self.time_s.max(f64::MIN_POSITIVE);
        self.carried_n_s.map(|sum| sum / over_s)
    }

    /// How long a motion was commanded, in seconds; above 0.
    fn asked_over_s(&self) -> f64 {
        self.asked_s.max(f64::MIN_POSITIVE)
    }

    /// Returns the commanded speed and the one reached, as HTML; empty if hardly any was commanded.
    fn of_asked(&self) -> String {
        let asked_s = self.asked_over_s();
        let (asked_m_s, done_m_s) = (self.asked_m / asked_s, self.done_m / asked_s);
        match asked_m_s > SLOWEST_ASKED_M_S {
            true => format!(
                "of <b>{}</b> commanded it reached <b>{}</b>",
                speed(asked_m_s),
                speed(done_m_s)
            ),
            false => String::new(),
        }
    }
}

/// Returns the smallest radius of a wheel, in metres: lower obstacles are kerbs, others walls.
fn least_radius_m(header: &Header) -> f64 {
    let radii_m = header.wheels.iter().map(|wheel| wheel.radius_m);
    radii_m.fold(f64::INFINITY, f64::min)
}

/// Whether the box nearest to the robot is a wall.
fn is_at_wall(header: &Header, record: &Record) -> bool {
    nearest_box(header, record).is_some_and(|of| of.sides_m[2] >= least_radius_m(header))
}

/// Returns the box of the ground nearest to the robot's hubs and outlines.
fn nearest_box(header: &Header, record: &Record) -> Option<GroundBox> {
    let pose = record.truth.pose;
    let (sin, cos) = pose.heading_rad.sin_cos();
    let hubs = header.wheels.iter().map(|wheel| wheel.position_m);
    let points: Vec<[f64; 2]> = hubs
        .chain(header.chassis_outlines_m.iter().flatten().copied())
        .map(|[x, y]| [pose.x_m + cos * x - sin * y, pose.y_m + sin * x + cos * y])
        .collect();
    let distance_m = |of: &GroundBox| {
        let (sin, cos) = of.heading_rad.sin_cos();
        let from_point = |[x, y]: &[f64; 2]| {
            let [dx, dy] = [x - of.center_m[0], y - of.center_m[1]];
            let along = (cos * dx + sin * dy).abs() - 0.5 * of.sides_m[0];
            let across = (cos * dy - sin * dx).abs() - 0.5 * of.sides_m[1];
            along.max(0.0).hypot(across.max(0.0))
        };
        points.iter().map(from_point).fold(f64::INFINITY, f64::min)
    };
    let boxes = header.ground.iter().flat_map(|ground| &ground.boxes);
    boxes
        .copied()
        .min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)))
}

#[cfg(test)]
mod tests;
