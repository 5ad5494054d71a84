//! One variable, and the table that it is in.

use ilon_sim::Plant;
use ilon_sim::simulate::Measurements;
use ilon_sim::world::BodyState;

use crate::value::Value;

/// What a variable is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set between steps.
    Input,
    /// Set once, before a simulation begins.
    Parameter,
    /// Read.
    Output,
}

/// One variable. Its reference is its place in the table.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its structured name.
    pub name: String,
    /// What it is, for a person.
    pub about: String,
    /// What it is for.
    pub causality: Causality,
    /// The name of its unit, where it has one.
    pub unit: Option<&'static str>,
    /// What it is before anybody sets it; of an output what it is at the start.
    pub start: Value,
    pub(crate) slot: Slot,
}

/// Where a variable's value is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Slot {
    Time,
    /// A place among what is set: inputs, and whether torques are commanded.
    Set(usize),
    /// A place among the keys.
    Key(usize),
    /// Read from the plant; the number is the function's own.
    Read(fn(&Now<'_>, usize) -> f64, usize),
}

/// What outputs are read from.
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
