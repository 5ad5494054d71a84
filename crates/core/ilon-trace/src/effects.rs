//! The effects of causes: the run minus the same run without a cause.
//!
//! An effect is the difference of two runs with the same robot, step and seeds. Its noise floor is
//! the largest change of the same figure at half the step, from starts beside the run's and, with
//! noisy sensors, with another seed. A difference below [`FLOORS`] floors is not significant.
//!
//! Where starts that differ by nothing end apart, the run is chaotic: all these changes are then
//! drawn by chance, as is that of any cause, and a few draws do not show how far they scatter. The
//! floor is [`CHAOTIC`] times as high there.

use crate::convergence::{self, Apart, Cause, Change, Twin};
pub use crate::effect::{APART_M, APART_RAD, Effect, Effects};
use crate::header::Header;
use crate::metrics::Summary;
use crate::quantities::{self, Scales, by_key};

/// A difference of fewer noise floors than this is not significant. Chosen.
pub const FLOORS: f64 = 3.0;

/// By how much the largest of three changes by chance counts as more. A fourth change exceeds
/// [`FLOORS`] times that in less than 1 case of 1000, where each outcome is normally distributed.
/// Chosen.
pub const CHAOTIC: f64 = 3.0;

/// A run whose starts beside it end further apart than this share of a wheel's radius is chaotic:
/// they began within 4e-8 of it, and no regular run spreads what is between them a hundred times.
/// Chosen.
const APART: f64 = 4e-6;

/// Causes that are noise. The change with another seed has their own size, so it is not their
/// floor.
const NOISES: [&str; 3] = ["sensors.pose.noise", "sensors.encoders", "sensors.imu"];

/// Figures that are reported for every cause, whether they differ or not.
const ALWAYS: [&str; 4] = [
    "end_x_m",
    "end_y_m",
    "end_heading_rad",
    "position_error_max_m",
];

impl Effects {
    /// The effects of a run whose header has its twins.
    pub(crate) fn of(summary: &Summary, header: &Header) -> Self {
        let ablations = of_causes(summary, header);
        let mut effects: Vec<Effect> = Vec::new();
        effects.extend(ablations.iter().flat_map(|one| one.effects.iter().cloned()));
        effects.extend(interplay(&ablations));
        Self::new(effects)
    }
}

/// A run compared with its twin without a cause, or with a remedy.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ablation<'a> {
    /// What was removed; `None` for all causes at once.
    pub cause: Option<&'a Cause>,
    /// The distance between the two runs.
    pub apart: Apart,
    /// The largest distance between the run and its twins that measure noise, in metres and radians,
    /// [`CHAOTIC`] times as large of a chaotic run.
    pub floor: [f64; 2],
    /// The same at the end.
    pub end_floor: [f64; 2],
    /// The effects on the figures.
    pub effects: Vec<Effect>,
}

impl Ablation<'_> {
    /// Whether anything differs significantly.
    pub fn differs(&self) -> bool {
        self.effects.iter().any(|effect| effect.differs)
    }

    /// Whether the robot's path or heading differs significantly.
    pub fn moves(&self) -> bool {
        let of_way = |key: &str| [APART_M, APART_RAD].contains(&key);
        self.effects.iter().any(|it| of_way(&it.key) && it.differs)
    }

    /// Whether without it the robot would have been further from its reference, or in open loop
    /// from what was asked of it, in place or in heading, by a part that is worth a word, and in
    /// neither nearer.
    ///
    /// Noise never helps: with another seed it moves the robot another way.
    pub fn helped(&self) -> bool {
        /// A smaller part of the error is not.
        const WORTH: f64 = 0.05;
        let errors = |keys: [&str; 2]| keys.map(|key| self.get(key)?.with.and(self.get(key)));
        let of = match errors(["position_error_max_m", "heading_error_max_rad"]) {
            // What jitters has a long way, and leads nowhere.
            [None, None] => ["path_m", "turned_rad", "x_m", "y_m"]
                .map(|part| self.get(&format!("ledger.total.{part}")))
                .to_vec(),
            tracked => tracked.to_vec(),
        };
        let differs = |by: &Effect, more: f64| {
            let [with, without] = [by.with, by.without].map(|x| x.unwrap_or(0.0).abs());
            by.differs && more * (with - without) > WORTH * with
        };
        let is_any = |more: f64| of.iter().flatten().any(|by| differs(by, more));
        is_any(-1.0) && !is_any(1.0) && !self.cause.is_some_and(is_noise)
    }

    /// The effect on a figure, by its key.
    pub fn get(&self, key: &str) -> Option<&Effect> {
        self.effects.iter().find(|effect| effect.key == key)
    }
}

/// Whether a cause is noise.
fn is_noise(cause: &Cause) -> bool {
    NOISES.contains(&cause.key.as_str())
}

/// Compares the run with each twin without a cause, in the order of the causes; the twin without
/// all causes comes last.
pub fn of_causes<'a>(summary: &Summary, header: &'a Header) -> Vec<Ablation<'a>> {
    let left_out = header.twins.iter().filter_map(|twin| match &twin.change {
        Change::Without(cause) => ablation(summary, header, twin, Some(cause)),
        Change::WithoutAll => ablation(summary, header, twin, None),
        _ => None,
    });
    left_out.collect()
}

/// Compares the run with each twin that tries a remedy.
pub fn of_remedies<'a>(summary: &Summary, header: &'a Header) -> Vec<Ablation<'a>> {
    let tried = header.twins.iter().filter_map(|twin| match &twin.change {
        Change::With(remedy) => ablation(summary, header, twin, Some(remedy)),
        _ => None,
    });
    tried.collect()
}

/// How far a figure of a run is known, by its key: what it moves by at half the step, from starts
/// beside the run's and with another seed, and [`CHAOTIC`] times that of a chaotic run; `None` of a
/// run without twins.
pub fn floor(key: &str, summary: &Summary, header: &Header) -> Option<f64> {
    let (quantity, with) = (by_key(key)?, by_key(key)?.value(summary)?);
    let noise = header.twins.iter().filter(|twin| twin.change.is_noise());
    let moved = noise.filter_map(|twin| twin.figures.get(key));
    let moved = moved.map(|other| convergence::difference(key, with, *other).abs());
    let most = moved.reduce(f64::max)?;
    Some((spread(header) * most).max(Scales::of(summary, header).floor(quantity)))
}

/// The factor on the changes by noise: [`CHAOTIC`] of a chaotic run, else 1.
fn spread(header: &Header) -> f64 {
    let radii_m = header.wheels.iter().map(|wheel| wheel.radius_m);
    let least_m = radii_m.fold(f64::INFINITY, f64::min);
    let is_apart = |twin: &Twin| {
        let is_beside = matches!(twin.change, Change::StartBeside(_));
        is_beside && (twin.apart).is_some_and(|apart| apart.most_m > APART * least_m)
    };
    match header.twins.iter().any(is_apart) {
        true => CHAOTIC,
        false => 1.0,
    }
}

/// Compares a run with a twin that could be run.
fn ablation<'a>(
    summary: &Summary,
    header: &Header,
    twin: &Twin,
    cause: Option<&'a Cause>,
) -> Option<Ablation<'a>> {
    let apart = twin.apart?;
    let by_seed = cause.is_some_and(is_noise);
    let is_floor = move |twin: &&Twin| {
        twin.change.is_noise() && !(by_seed && twin.change == Change::OtherSeed)
    };
    let noise = || header.twins.iter().filter(is_floor);
    let scales = Scales::of(summary, header);
    let place = by_key("end_x_m").map_or(0.0, |quantity| scales.floor(quantity));
    let turn = by_key("end_heading_rad").map_or(0.0, |quantity| scales.floor(quantity));
    let spread = spread(header);
    let of_noise = |of: fn(&Apart) -> f64, least: f64| {
        let moved = noise().filter_map(|twin| twin.apart.as_ref()).map(of);
        moved.fold(least, |most, moved| most.max(spread * moved))
    };
    let floor = [
        of_noise(|apart| apart.most_m, place),
        of_noise(|apart| apart.most_rad, turn),
    ];
    let end_floor = [
        of_noise(|apart| apart.ahead_m.hypot(apart.left_m), place),
        of_noise(|apart| apart.turned_rad.abs(), turn),
    ];
    let named = |key: &str, with, without, difference: f64, floor: f64| Effect {
        cause: cause.map_or("all", |cause| &cause.key).to_owned(),
        words: cause.map_or("all of them", |cause| &cause.words).to_owned(),
        key: key.to_owned(),
        with,
        without,
        difference,
        floor,
        differs: difference.abs() > FLOORS * floor,
    };
    let apart_by = |key, by, floor| named(key, Some(by), Some(0.0), by, floor);
    let mut effects = vec![
        apart_by(APART_M, apart.most_m, floor[0]),
        apart_by(APART_RAD, apart.most_rad, floor[1]),
    ];
    for quantity in quantities::compared() {
        let key = quantity.key;
        let at = |twin: &Twin| twin.figures.get(key).copied();
        let (with, without) = (quantity.value(summary), at(twin));
        if with.is_none() && without.is_none() || !quantities::says_something(key, summary) {
            continue;
        }
        let off = |from: f64| convergence::difference(key, with.unwrap_or(0.0), from);
        let moved = noise().filter_map(at).map(|half| off(half).abs());
        let floor = moved.fold(scales.floor(quantity), |most, moved| {
            most.max(spread * moved)
        });
        let effect = named(key, with, without, off(without.unwrap_or(0.0)), floor);
        if effect.differs || ALWAYS.contains(&key) {
            effects.push(effect);
        }
    }
    Some(Ablation {
        cause,
        apart,
        floor,
        end_floor,
        effects,
    })
}

/// The interaction of the causes: their joint effect minus the sum of the single ones, on the final
/// position and heading.
fn interplay(ablations: &[Ablation]) -> Vec<Effect> {
    let singles = ablations.iter().filter(|one| one.cause.is_some());
    let Some(all) = ablations.iter().find(|one| one.cause.is_none()) else {
        return Vec::new();
    };
    let of_key = |key: &str| {
        let whole = all.get(key)?;
        let each = singles.clone().filter_map(|one| one.get(key));
        let difference = whole.difference - each.clone().map(|one| one.difference).sum::<f64>();
        let floor = whole.floor + each.map(|one| one.floor).sum::<f64>();
        Some(Effect {
            cause: "interplay".to_owned(),
            words: "what they do together".to_owned(),
            key: key.to_owned(),
            difference,
            floor,
            differs: difference.abs() > FLOORS * floor,
            ..Effect::default()
        })
    };
    let of_end = ["end_x_m", "end_y_m", "end_heading_rad"];
    of_end.into_iter().filter_map(of_key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Settings;
    use crate::sample::made_up_trace;

    /// A twin that ended `by_m` metres from the run along x.
    fn twin(change: Change, alone: &Summary, by_m: f64) -> Twin {
        let apart = Apart {
            most_m: by_m.abs(),
            ..Apart::default()
        };
        let mut twin = Twin::new(change, Ok((alone.clone(), Some(apart))));
        *twin.figures.get_mut("end_x_m").expect("a figure") -= by_m;
        twin
    }

    fn without(key: &str) -> Change {
        Change::Without(Cause {
            key: key.to_owned(),
            words: format!("the {key}"),
        })
    }

    /// A run of a robot whose farthest wheel is at 0.4 m, so that the resolution of positions is
    /// 0.04 mm.
    fn with_twins(twins: impl Fn(&Summary) -> Vec<Twin>) -> Summary {
        let mut trace = made_up_trace(1, 40, true);
        trace.header.wheels[0].position_m = [0.0, 0.4];
        let alone = Summary::of(&trace, &Settings::default());
        assert!(alone.effects.is_empty());
        trace.header.twins = twins(&alone);
        Summary::of(&trace, &Settings::default())
    }

    #[test]
    fn what_half_the_step_moves_as_far_made_no_difference() {
        for (by_m, half_m, differs) in [
            (1.3e-4, 0.0, true),
            (1.1e-4, 0.0, false),
            (0.02, 0.007, false),
            (0.02, 0.006, true),
        ] {
            let summary = with_twins(|alone| {
                vec![
                    twin(Change::HalfStep, alone, half_m),
                    twin(without("load"), alone, by_m),
                ]
            });
            let effect = summary.effects.get("load", "end_x_m").expect("an effect");
            // Rounding of one sum.
            assert!((effect.difference - by_m).abs() < 1e-12, "{effect:?}");
            assert_eq!(effect.differs, differs, "{effect:?}");
            let apart = summary.effects.get("load", APART_M).expect("an effect");
            assert_eq!(apart.differs, differs);
        }
    }

    /// Starts that end further apart than 4e-6 of a wheel's radius, here 0.2 um, make the run chaotic:
    /// changes by chance count three times, so that 20 mm are no effect beside one of 4 mm.
    #[test]
    fn where_starts_end_apart_the_floor_is_three_times_as_high() {
        for (beside_m, differs) in [(1e-7, true), (1e-6, false)] {
            let summary = with_twins(|alone| {
                vec![
                    twin(Change::HalfStep, alone, 0.004),
                    twin(Change::StartBeside(0), alone, beside_m),
                    twin(without("load"), alone, 0.02),
                ]
            });
            let effect = summary.effects.get("load", "end_x_m").expect("an effect");
            assert_eq!(effect.differs, differs, "{effect:?}");
            let floor_m = if differs { 0.004 } else { 0.012 };
            assert!((effect.floor - floor_m).abs() < 1e-12, "{effect:?}");
        }
    }

    #[test]
    fn what_causes_do_together_is_what_the_sum_of_each_leaves() {
        let summary = with_twins(|alone| {
            vec![
                twin(without("a"), alone, 0.01),
                twin(without("b"), alone, 0.02),
                twin(Change::WithoutAll, alone, 0.07),
            ]
        });
        let interplay = summary
            .effects
            .get("interplay", "end_x_m")
            .expect("an effect");
        assert!((interplay.difference - 0.04).abs() < 1e-12 && interplay.differs);
        let turned = summary.effects.get("interplay", "end_heading_rad");
        assert!(turned.is_some_and(|turned| !turned.differs));
    }

    /// Another seed moves the end by 5 mm: an effect of 6 mm of another cause is not significant,
    /// one of the noise itself is.
    #[test]
    fn another_seed_is_no_floor_of_the_noise_itself() {
        for (key, differs) in [("load", false), (NOISES[0], true)] {
            let summary = with_twins(|alone| {
                vec![
                    twin(Change::OtherSeed, alone, 5e-3),
                    twin(without(key), alone, 6e-3),
                ]
            });
            let effect = summary.effects.get(key, "end_x_m").expect("an effect");
            assert_eq!(effect.differs, differs, "{effect:?}");
        }
    }

    /// In open loop, by the way and the turn of asked minus real without a cause over those with
    /// it: what brought the robot nearer in one and further off in the other did not help.
    #[test]
    fn what_helped_brought_the_robot_nearer_in_place_or_heading_and_in_neither_further() {
        for (path, turned, x, helped) in [
            (1.2, 1.0, 1.0, true),
            (1.0, 1.2, 1.0, true),
            (1.2, 0.8, 1.0, false),
            (0.8, 1.2, 1.0, false),
            (1.03, 1.0, 1.0, false),
            (0.8, 1.0, 1.0, false),
            // It jittered more, and ended nearer to where it was sent.
            (1.2, 1.0, 0.5, false),
            (1.0, 1.0, -1.5, true),
        ] {
            let mut trace = made_up_trace(1, 40, true);
            trace.header.open_loop = true;
            trace.header.wheels[0].position_m = [0.0, 0.4];
            let mut alone = Summary::of(&trace, &Settings::default());
            (alone.position_error_max_m, alone.heading_error_max_rad) = (None, None);
            alone.ledger.total.path_m = 0.1;
            alone.ledger.total.turned_rad = 0.2;
            alone.ledger.total.x_m = -0.05;
            let mut twin = twin(without("push"), &alone, 0.0);
            twin.figures
                .insert("ledger.total.path_m".to_owned(), 0.1 * path);
            twin.figures
                .insert("ledger.total.turned_rad".to_owned(), 0.2 * turned);
            twin.figures
                .insert("ledger.total.x_m".to_owned(), -0.05 * x);
            trace.header.twins = vec![twin];
            let found = of_causes(&alone, &trace.header);
            assert_eq!(found[0].helped(), helped, "{path} {turned} {x}");
        }
    }

    #[test]
    fn a_twin_that_could_not_be_run_has_no_effects() {
        let summary = with_twins(|_| vec![Twin::new(without("a"), Err("it diverged".to_owned()))]);
        assert!(summary.effects.is_empty());
    }

    /// A figure is known no better than its resolution, 0.04 mm of a wheel at 0.4 m, however little
    /// half the step moves it.
    #[test]
    fn a_figure_is_known_to_its_resolution_at_best() {
        for (half_m, known_m) in [(0.0, 4e-5), (3e-3, 3e-3)] {
            let mut trace = made_up_trace(1, 40, true);
            trace.header.wheels[0].position_m = [0.0, 0.4];
            let alone = Summary::of(&trace, &Settings::default());
            trace.header.twins = vec![twin(Change::HalfStep, &alone, half_m)];
            let summary = Summary::of(&trace, &Settings::default());
            let found_m = floor("end_x_m", &summary, &trace.header).expect("a twin");
            assert!((found_m - known_m).abs() < 1e-12, "{found_m}");
        }
    }
}
