//! A list of causes, each with the change (the null) that removes it.

use ilon_robot::Robot;
use ilon_trace::{Cause, Header};

use crate::scenario::Scenario;

/// A change of a scenario and its robot.
pub(crate) type Null = Box<dyn Fn(&mut Scenario, &mut Robot) + Send + Sync>;

/// The run whose causes are listed.
#[derive(Clone, Copy)]
pub(in crate::causes) struct Run<'a> {
    /// The resolved scenario.
    pub scenario: &'a Scenario,
    pub robot: &'a Robot,
    /// The header of its trace.
    pub header: &'a Header,
    /// Positions of the robot's joints at the start, in rad or m.
    pub stands: &'a [f64],
    /// Physics step in seconds.
    pub physics_dt_s: f64,
}

/// If a scenario has more than this many patches or bodies of one kind, they count as one cause
/// together. Chosen.
pub(super) const MOST_OF_A_KIND: usize = 3;

#[derive(Default)]
pub(super) struct List(pub Vec<(Cause, Null)>);

impl List {
    pub fn add(
        &mut self,
        key: impl Into<String>,
        words: impl Into<String>,
        null: impl Fn(&mut Scenario, &mut Robot) + Send + Sync + 'static,
    ) {
        let cause = Cause {
            key: key.into(),
            words: words.into(),
        };
        self.0.push((cause, Box::new(null)));
    }

    /// Adds each thing of a list by itself; if there are too many, adds them as one cause named
    /// `many`.
    pub fn each<T>(
        &mut self,
        key: &str,
        things: &[T],
        of: fn(&mut Scenario) -> &mut Vec<T>,
        many: &str,
        words: impl Fn(&T) -> String,
    ) where
        T: 'static,
    {
        let count = things.len();
        if count > MOST_OF_A_KIND {
            return self.add(key, format!("the {count} {many}"), move |scenario, _| {
                of(scenario).clear();
            });
        }
        for (index, thing) in things.iter().enumerate() {
            self.add(
                format!("{key}.{index}"),
                words(thing),
                move |scenario, _| {
                    of(scenario).remove(index);
                },
            );
        }
    }
}
