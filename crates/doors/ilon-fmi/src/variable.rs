//! A variable, and the table of variables.

use ilon_sim::Plant;
use ilon_sim::simulate::Measurements;
use ilon_sim::world::BodyState;

use crate::value::Value;

/// The causality of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set between steps.
    Input,
    /// Set once, before the simulation begins.
    Parameter,
    /// Read.
    Output,
}

/// A variable. Its value reference is its index in the table.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its structured name.
    pub name: String,
    /// Its description.
    pub about: String,
    /// Its causality.
    pub causality: Causality,
    /// The name of its unit, if any.
    pub unit: Option<&'static str>,
    /// Its start value; for an output the value at the start of the simulation.
    pub start: Value,
    pub(crate) slot: Slot,
}

/// Where a variable's value is stored.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Slot {
    Time,
    /// An index into the inputs, which include whether torques are commanded.
    Set(usize),
    /// An index into the keys.
    Key(usize),
    /// Read from the plant; the number is passed to the function.
    Read(fn(&Now<'_>, usize) -> f64, usize),
}

/// What outputs are computed from.
#[derive(Clone, Copy)]
pub(crate) struct Now<'a> {
    pub plant: &'a Plant,
    pub body: &'a BodyState,
    pub seen: &'a Measurements,
}

impl std::fmt::Debug for Now<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.plant.fmt(f)
    }
}

/// The variables so far.
pub(crate) struct Table(pub Vec<Variable>);

impl Table {
    pub fn add(
        &mut self,
        name: &str,
        about: &str,
        causality: Causality,
        unit: Option<&'static str>,
        start: Value,
        slot: Slot,
    ) {
        self.0.push(Variable {
            name: name.to_owned(),
            about: about.to_owned(),
            causality,
            unit,
            start,
            slot,
        });
    }

    pub fn input(
        &mut self,
        name: &str,
        about: &str,
        unit: Option<&'static str>,
        start: f64,
        at: usize,
    ) {
        let start = Value::Real(start);
        self.add(name, about, Causality::Input, unit, start, Slot::Set(at));
    }

    pub fn output(
        &mut self,
        name: &str,
        about: &str,
        unit: Option<&'static str>,
        read: fn(&Now<'_>, usize) -> f64,
        of: usize,
    ) {
        let slot = Slot::Read(read, of);
        self.add(name, about, Causality::Output, unit, Value::Real(0.0), slot);
    }
}

/// The axes of a frame.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
