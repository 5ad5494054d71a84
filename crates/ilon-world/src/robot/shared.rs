//! A robot made ready for worlds.

use std::ops::Deref;
use std::sync::Arc;

use ilon_robot::Robot;

use crate::robot::roller::{FixedRoller, RollerState};

/// A robot made ready for worlds: all worlds that are built of one share what never changes in it, so that a thousand of them
/// take the memory of their states.
///
/// ```no_run
/// # use ilon_robot::{Pose, Robot};
/// # use ilon_world::{Floor, Settings, SharedRobot, World};
/// let robot = SharedRobot::from(&Robot::load("robot.urdf")?);
/// let place = |index: i32| Pose { y_m: f64::from(index), ..Pose::default() };
/// let fleet: Result<Vec<World>, _> = (0..1000)
///     .map(|index| World::new(&robot, &Floor::default(), place(index), &Settings::default()))
///     .collect();
/// # fleet?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SharedRobot(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    robot: Robot,
    /// Wheel by wheel.
    rollers: Vec<Vec<Arc<FixedRoller>>>,
}

impl SharedRobot {
    /// The rollers of all wheels, at rest.
    pub(crate) fn rollers_at_rest(&self) -> Vec<Vec<RollerState>> {
        let at_rest = |roller: &Arc<FixedRoller>| RollerState::at_rest(Arc::clone(roller));
        let wheels = self.0.rollers.iter();
        wheels
            .map(|rollers| rollers.iter().map(at_rest).collect())
            .collect()
    }
}

impl Deref for SharedRobot {
    type Target = Robot;

    fn deref(&self) -> &Robot {
        &self.0.robot
    }
}

impl From<&Robot> for SharedRobot {
    fn from(robot: &Robot) -> Self {
        let fixed = |wheel| move |roller| Arc::new(FixedRoller::new(wheel, roller));
        let wheels = robot.wheels.iter();
        Self(Arc::new(Shared {
            rollers: wheels
                .map(|wheel| wheel.rollers.iter().map(fixed(wheel)).collect())
                .collect(),
            robot: robot.clone(),
        }))
    }
}

impl From<&SharedRobot> for SharedRobot {
    fn from(robot: &SharedRobot) -> Self {
        robot.clone()
    }
}
