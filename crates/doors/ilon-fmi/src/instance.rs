//! The simulation behind an instance of the FMU.

use std::path::Path;
use std::sync::Arc;

use ilon_files::FileAccess;
use ilon_sim::simulate::Measurements;
use ilon_sim::world::BodyState;
use ilon_sim::{Error, Plant, Scenario, WheelCommand};

use crate::keys::{Key, keys};
use crate::value::Value;
use crate::variable::{Causality, Now, Slot, Variable};
use crate::variables::{set, variables};
use crate::{SCENARIO, description};

/// The phase of an instance's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Created; parameters may be set.
    Instantiated,
    /// As before; outputs have their start values.
    Initialization,
    /// Steps are taken.
    Stepping,
    /// Ended; it can be read or reset.
    Terminated,
}

/// A simulated robot that is set, stepped and read by value references. A copy continues
/// bit-identically.
#[derive(Clone)]
pub struct Instance {
    shared: Arc<Shared>,
    phase: Phase,
    plant: Plant,
    body: BodyState,
    seen: Measurements,
    /// The current inputs, and those that the plant has received.
    values: Vec<f64>,
    given: Vec<f64>,
    keys: Vec<Value>,
    /// Whether the plant was built with the current keys.
    is_of_keys: bool,
    /// The importer's time at the plant's time zero, in seconds.
    began_s: f64,
}

/// Constant data, shared by all copies.
struct Shared {
    text: String,
    folder: std::path::PathBuf,
    files: FileAccess,
    keys: Vec<Key>,
    variables: Vec<Variable>,
}

impl Instance {
    /// An instance of the FMU whose resources are in a folder. `token` is that of its description.
    ///
    /// # Errors
    /// If the resources cannot be read, or belong to another description.
    pub fn open(resources: &Path, token: &str) -> Result<Self, Error> {
        let files = FileAccess::below([resources]).map_err(|fault| {
            Error::invalid(
                format!("the resources cannot be read: {fault}"),
                "unpack the FMU as a whole, and give its folder of resources",
            )
        })?;
        let path = resources.join(SCENARIO);
        let text = ilon_sim::scenario::read_text(&path, &files)?;
        let instance = Self::of(text, resources, files)?;
        if description::token(instance.variables()) != token {
            return Err(Error::invalid(
                "the token is not that of this FMU",
                "give the instantiationToken of its modelDescription.xml; an FMU that was changed by hand has to be exported again",
            ));
        }
        Ok(instance)
    }

    /// An instance of a scenario's text, whose paths start from a folder.
    ///
    /// # Errors
    /// If the scenario is invalid.
    pub fn of(text: String, folder: &Path, files: FileAccess) -> Result<Self, Error> {
        let scenario = Scenario::from_toml_with(&text, "scenario", folder, &[], &files)?;
        let keys = keys(&scenario)?;
        let mut plant = Plant::of_scenario(&scenario)?;
        let variables = variables(&plant, &keys);
        let seen = plant.observe().clone();
        let mut instance = Self {
            phase: Phase::Instantiated,
            body: plant.world().robot().state(),
            seen,
            values: Vec::new(),
            given: Vec::new(),
            keys: keys.iter().map(|key| key.value).collect(),
            is_of_keys: true,
            began_s: 0.0,
            plant,
            shared: Arc::new(Shared {
                text,
                folder: folder.to_owned(),
                files,
                keys,
                variables,
            }),
        };
        instance.values = instance.starts();
        instance.given.clone_from(&instance.values);
        Ok(instance)
    }

    /// The variables, in the order of their value references.
    pub fn variables(&self) -> &[Variable] {
        &self.shared.variables
    }

    /// The simulated plant.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The current phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The start values of the inputs.
    fn starts(&self) -> Vec<f64> {
        let wheels = self.plant.robot().wheels.len();
        let mut starts = vec![0.0; set::WHEELS + set::PER_WHEEL * wheels];
        for variable in self.variables() {
            if let (Slot::Set(at), Value::Real(start)) = (variable.slot, variable.start) {
                starts[at] = start;
            }
        }
        starts
    }

    fn variable(&self, reference: u32) -> Result<&Variable, Error> {
        let found = self.variables().get(reference as usize);
        found.ok_or_else(|| {
            Error::invalid(
                format!("there is no variable with the reference {reference}"),
                "take references from modelDescription.xml",
            )
        })
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// For an unknown reference, and if the parameters give an invalid scenario.
    pub fn get(&mut self, reference: u32) -> Result<Value, Error> {
        self.take_keys()?;
        let variable = self.variable(reference)?;
        let now = Now {
            plant: &self.plant,
            body: &self.body,
            seen: &self.seen,
        };
        Ok(match (variable.slot, variable.start) {
            (Slot::Time, _) => Value::Real(self.time_s()),
            (Slot::Set(at), Value::Flag(_)) => Value::Flag(self.values[at] != 0.0),
            (Slot::Set(at), _) => Value::Real(self.values[at]),
            (Slot::Key(at), _) => self.keys[at],
            (Slot::Read(read, of), _) => Value::Real(read(&now, of)),
        })
    }

    /// Sets a variable.
    ///
    /// # Errors
    /// For an unknown reference or that of an output, a value of another type or one that is not
    /// finite, and a parameter that is set too late.
    pub fn set(&mut self, reference: u32, value: Value) -> Result<(), Error> {
        let variable = self.variable(reference)?;
        let (name, slot) = (&variable.name, variable.slot);
        let refused = |why: &str, help: &str| {
            Err(Error::invalid(
                format!("`{name}` cannot be set: {why}"),
                help.to_owned(),
            ))
        };
        let before_steps = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        match variable.causality {
            Causality::Parameter if !before_steps => {
                return refused(
                    "it is a fixed parameter",
                    "set it before the simulation begins",
                );
            }
            Causality::Independent | Causality::Output => {
                return refused("it is no input", "set inputs and parameters alone");
            }
            _ if self.phase == Phase::Terminated => {
                return refused("the simulation has ended", "reset the instance first");
            }
            _ => {}
        }
        if std::mem::discriminant(&variable.start) != std::mem::discriminant(&value) {
            return refused(
                "it is of another type",
                "take the type from modelDescription.xml",
            );
        }
        if matches!(value, Value::Real(number) if !number.is_finite()) {
            return refused("the value is no finite number", "give finite numbers");
        }
        match (slot, value) {
            (Slot::Set(at), Value::Real(number)) => self.values[at] = number,
            (Slot::Set(at), Value::Flag(flag)) => self.values[at] = f64::from(u8::from(flag)),
            (Slot::Key(at), value) if self.keys[at] != value => {
                self.keys[at] = value;
                self.is_of_keys = false;
            }
            _ => {}
        }
        Ok(())
    }

    /// Builds the plant with the current parameters.
    fn take_keys(&mut self) -> Result<(), Error> {
        if self.is_of_keys {
            return Ok(());
        }
        let shared = &self.shared;
        let changed = shared.keys.iter().zip(&self.keys);
        let changed = changed.filter(|(key, value)| key.value != **value);
        let settings: Vec<_> = changed.map(|(key, value)| key.setting(*value)).collect();
        let scenario = Scenario::from_toml_with(
            &shared.text,
            "scenario",
            shared.folder.clone(),
            &settings,
            &shared.files,
        )?;
        let plant = Plant::of_scenario(&scenario)?;
        // The input for the floor's friction starts at the new floor's value, unless it was set.
        if self.values[set::FRICTION] == self.given[set::FRICTION] {
            self.values[set::FRICTION] = plant.floor_friction();
        }
        self.given[set::FRICTION] = plant.floor_friction();
        self.plant = plant;
        self.is_of_keys = true;
        self.look();
        Ok(())
    }

    fn look(&mut self) {
        self.body = self.plant.world().robot().state();
        self.seen.clone_from(self.plant.observe());
    }

    /// Begins initialisation at the importer's time in seconds.
    ///
    /// # Errors
    /// In another phase, and for a time that is not finite.
    pub fn enter_initialization(&mut self, start_s: f64) -> Result<(), Error> {
        self.expect(Phase::Instantiated)?;
        if !start_s.is_finite() {
            return Err(Error::invalid(
                format!("it cannot start at {start_s} s"),
                "give a finite time",
            ));
        }
        self.began_s = start_s;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Ends initialisation: steps may be taken.
    ///
    /// # Errors
    /// In another phase, and if the parameters give an invalid scenario.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        self.expect(Phase::Initialization)?;
        self.take_keys()?;
        self.phase = Phase::Stepping;
        Ok(())
    }

    /// Simulated time on the importer's clock, in seconds.
    pub fn time_s(&self) -> f64 {
        self.began_s + self.plant.time_s()
    }

    /// Advances from a time by a step, both in seconds, with the current inputs. Any step is
    /// allowed; with sampled or late wheel loops a whole number of physics steps.
    ///
    /// # Errors
    /// In another phase, for a time other than the current one, for a step that is not positive and
    /// finite, and if the robot's motion is no longer finite.
    pub fn step(&mut self, at_s: f64, step_s: f64) -> Result<(), Error> {
        self.expect(Phase::Stepping)?;
        let dt_s = self.plant.resolved().physics_dt_s();
        if (at_s - self.time_s()).abs() > 0.5 * dt_s || at_s.is_nan() {
            return Err(Error::invalid(
                format!(
                    "a step from {at_s} s cannot be taken: the FMU is at {} s",
                    self.time_s()
                ),
                "take steps one after the other; to go back, set a state that was got there",
            ));
        }
        self.give()?;
        let (first, second) = (set::WHEELS, set::WHEELS + 1);
        let is_torque = self.values[set::TORQUES] != 0.0;
        let from = if is_torque { second } else { first };
        let commands = self.values[from..].iter().step_by(set::PER_WHEEL);
        let commands: Vec<f64> = commands
            .copied()
            .take(self.plant.robot().wheels.len())
            .collect();
        let command = if is_torque {
            WheelCommand::Torques(&commands)
        } else {
            WheelCommand::Rates(&commands)
        };
        self.plant.advance(command, step_s)?;
        self.look();
        Ok(())
    }

    /// Passes inputs that changed since the last step to the plant.
    fn give(&mut self) -> Result<(), Error> {
        let (now, plant) = (&self.values, &mut self.plant);
        let triple = |at: usize| [now[at], now[at + 1], now[at + 2]];
        let changed = |range: std::ops::Range<usize>| now[range.clone()] != self.given[range];
        if changed(set::FORCE..set::PAYLOAD) {
            let place_in_body_m = Some(triple(set::PLACE));
            plant.set_wrench(triple(set::FORCE), triple(set::MOMENT), place_in_body_m)?;
        }
        if changed(set::PAYLOAD..set::FRICTION) {
            plant.carry_at(now[set::PAYLOAD], Some(triple(set::PAYLOAD_PLACE)))?;
        }
        if changed(set::FRICTION..set::WHEELS) {
            plant.set_friction(now[set::FRICTION])?;
        }
        for wheel in 0..plant.robot().wheels.len() {
            let at = set::WHEELS + set::PER_WHEEL * wheel + 2;
            if now[at] != self.given[at] {
                plant.set_grip(wheel, now[at])?;
            }
        }
        self.given.copy_from_slice(now);
        Ok(())
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// In another phase.
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.expect(Phase::Stepping)?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// Resets to the state after instantiation.
    ///
    /// # Errors
    /// If the scenario cannot be built again.
    pub fn reset(&mut self) -> Result<(), Error> {
        let shared = &self.shared;
        let (folder, files) = (shared.folder.clone(), shared.files.clone());
        *self = Self::of(shared.text.clone(), &folder, files)?;
        Ok(())
    }

    fn expect(&self, phase: Phase) -> Result<(), Error> {
        if self.phase == phase {
            return Ok(());
        }
        Err(Error::invalid(
            format!(
                "this cannot be called now: the instance is {:?}",
                self.phase
            ),
            format!("call it while it is {phase:?}"),
        ))
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance")
            .field("phase", &self.phase)
            .field("plant", &self.plant)
            .finish_non_exhaustive()
    }
}
