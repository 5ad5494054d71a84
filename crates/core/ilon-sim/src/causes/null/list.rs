//! A list of causes, each with its null.

use ilon_robot::Robot;
use ilon_trace::{Cause, Header};

use crate::scenario::Scenario;

/// A change of a scenario and its robot.
pub(crate) type Null = Box<dyn Fn(&mut Scenario, &mut Robot) + Send + Sync>;

/// A run whose causes are asked for.
#[derive(Clone, Copy)]
pub(in crate::causes) struct Run<'a> {
    /// Its scenario, resolved.
    pub scenario: &'a Scenario,
    pub robot: &'a Robot,
    /// The header of its trace.
    pub header: &'a Header,
    /// Where the robot's joints stand as it begins, in rad or m.
    pub stands: &'a [f64],
    /// Its physics step in seconds.
    pub physics_dt_s: f64,
}

/// Of ground and bodies of one kind more than this are one cause together.
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

    /// Each thing of a list of the scenario by itself; of many all together, called by `many`.
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
