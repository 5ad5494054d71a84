//! The services of `simulation_interfaces` 1 and 2 supported by a live run: simulation state,
//! single steps, and reset.

use serde::{Deserialize, Serialize};

use crate::control::{Change, Controls};

/// Result of a request: `simulation_interfaces/msg/Result`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Outcome {
    pub result: u8,
    pub error_message: String,
}

const FEATURE_UNSUPPORTED: u8 = 0;
const OK: u8 = 1;
const INCORRECT_STATE: u8 = 3;
const OPERATION_FAILED: u8 = 4;
/// Only for `SetSimulationState`.
const ALREADY_IN_TARGET_STATE: u8 = 101;

impl Outcome {
    pub fn ok() -> Self {
        Self::of(OK, "")
    }

    pub fn incorrect_state(why: &str) -> Self {
        Self::of(INCORRECT_STATE, why)
    }

    pub fn failed(why: &str) -> Self {
        Self::of(OPERATION_FAILED, why)
    }

    fn of(result: u8, why: &str) -> Self {
        Self {
            result,
            error_message: why.to_owned(),
        }
    }
}

/// An empty request or answer, which still has one byte.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Nothing {
    pub structure_needs_at_least_one_member: u8,
}

/// The requests of `GetSimulatorFeatures` and `GetSimulationState`.
impl ros2_client::Message for Nothing {}

/// The answer of services with only a result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Answer {
    pub result: Outcome,
}
impl ros2_client::Message for Answer {}

/// `StepSimulation`: a step is a control period.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Step {
    pub steps: u64,
}
impl ros2_client::Message for Step {}

/// `ResetSimulation`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Reset {
    pub scope: u8,
}
impl ros2_client::Message for Reset {}

const SCOPE_DEFAULT: u8 = 0;
const SCOPE_TIME: u8 = 1;
const SCOPE_STATE: u8 = 2;
const SCOPE_ALL: u8 = 255;

impl Reset {
    /// Returns the change, or the reason for none. Every scope resets the state; time continues,
    /// because nodes do not tolerate a jump back.
    pub fn change(&self) -> Result<Change, Outcome> {
        match self.scope {
            SCOPE_DEFAULT | SCOPE_STATE | SCOPE_ALL => Ok(Change {
                reset: Some(true),
                ..Change::default()
            }),
            scope if scope & SCOPE_TIME != 0 => Err(Outcome::of(
                FEATURE_UNSUPPORTED,
                "time does not go back: reset the state (2), or all (0)",
            )),
            _ => Err(Outcome::of(
                FEATURE_UNSUPPORTED,
                "nothing was spawned: reset the state (2), or all (0)",
            )),
        }
    }
}

/// `simulation_interfaces/msg/SimulationState`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct State {
    pub state: u8,
}

const STOPPED: u8 = 0;
const PLAYING: u8 = 1;
const PAUSED: u8 = 2;
const QUITTING: u8 = 3;

/// `SetSimulationState`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SetState {
    pub state: State,
}
impl ros2_client::Message for SetState {}

impl SetState {
    /// Returns the change, or the reason for none.
    pub fn change(&self, controls: &Controls) -> Result<Change, Outcome> {
        let paused = match self.state.state {
            PLAYING => false,
            PAUSED => true,
            // Paused, at the start.
            STOPPED => {
                return Ok(Change {
                    paused: Some(true),
                    reset: Some(true),
                    ..Change::default()
                });
            }
            QUITTING => {
                let why = "the program ends only where it was started";
                return Err(Outcome::of(FEATURE_UNSUPPORTED, why));
            }
            other => {
                let why = format!("there is no state {other} here: 0, 1 or 2");
                return Err(Outcome::of(FEATURE_UNSUPPORTED, &why));
            }
        };
        if paused == controls.paused {
            return Err(Outcome::of(ALREADY_IN_TARGET_STATE, ""));
        }
        Ok(Change {
            paused: Some(paused),
            ..Change::default()
        })
    }
}

/// The answer of `GetSimulationState`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct IsState {
    pub state: State,
    pub result: Outcome,
}
impl ros2_client::Message for IsState {}

impl IsState {
    pub fn of(controls: &Controls) -> Self {
        let state = if controls.paused { PAUSED } else { PLAYING };
        Self {
            state: State { state },
            result: Outcome::ok(),
        }
    }
}

/// The answer of `GetSimulatorFeatures`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Features {
    pub features: Vec<u16>,
    pub spawn_formats: Vec<String>,
    pub custom_info: String,
}
impl ros2_client::Message for Features {}

impl Features {
    pub fn own() -> Self {
        Self {
            // Reset of the state; getting and setting the state, including pause; single and
            // multiple steps.
            features: vec![20, 22, 24, 25, 26, 31, 32],
            spawn_formats: Vec::new(),
            custom_info:
                "ilon: a step is a control period; a reset puts the state back, and time goes on"
                    .to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_state_is_reset() {
        for scope in [0, 2, 255] {
            let change = Reset { scope }.change().expect("a change");
            assert_eq!(change.reset, Some(true), "{scope}");
        }
        for scope in [1, 3, 4, 5] {
            let refused = Reset { scope }.change().expect_err("refused");
            assert_eq!(refused.result, FEATURE_UNSUPPORTED, "{scope}");
        }
    }

    #[test]
    fn states_are_set_and_what_is_so_already_is_said() {
        let mut controls = Controls::default();
        let set = |state, controls: &Controls| {
            SetState {
                state: State { state },
            }
            .change(controls)
        };
        assert_eq!(set(PAUSED, &controls).expect("a change").paused, Some(true));
        assert_eq!(
            set(PLAYING, &controls).expect_err("no change").result,
            ALREADY_IN_TARGET_STATE
        );
        controls.paused = true;
        assert_eq!(
            set(PLAYING, &controls).expect("a change").paused,
            Some(false)
        );
        let stopped = set(STOPPED, &controls).expect("a change");
        assert_eq!((stopped.paused, stopped.reset), (Some(true), Some(true)));
        for state in [QUITTING, 4, 200] {
            assert_eq!(
                set(state, &controls).expect_err("refused").result,
                FEATURE_UNSUPPORTED
            );
        }
    }
}
