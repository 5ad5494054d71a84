//! The **physics**: a world in which every roller of an omnidirectional robot touches the ground by
//! itself.
//!
//! [`World`] holds robots on a floor, usually one: its input is motor torques, its output the true
//! state. Each robot is an articulated body with an identity; contacts are between pairs of bodies
//! and the ground. [`World::add_body`] adds boxes, cylinders and spheres, which robots push and
//! carry. Only this crate of the project uses rapier or parry.
//!
//! # One step
//!
//! ```text
//! world/advance.rs              poses advance by half a step; all of this is computed there
//! contact/search/on_ground.rs   the rollers and chassis points that may touch (nearest.rs: the exact barrel, in f64)
//! dynamics/                     mass matrix L^T L along the branches, forces of rotating frames, rates without contact
//! contact/reactions/assembly.rs the laws: contacts, dry bearings, motors at their limits
//! contact/reactions/response.rs the bodies' response: W = Z Z^T, a row z = L^-T J^T as sparse as its path to the root
//! contact/law/                  the impulses that satisfy all laws at once (solver.rs: Newton's method, newton.rs; better starts, splitting.rs)
//! world/advance.rs              a step in which something lands under load, or whose laws could not be satisfied, is discarded here, and taken in two parts; otherwise rates change by the impulses, work is counted, poses advance with the mean rates
//! world/user_bodies.rs          rapier takes the same step with a program's user bodies, if there are any
//! ```
//!
//! # Modes of a step
//!
//! Conditions that change how a part of a step is taken:
//!
//! | of | mode | condition | effect |
//! |---|---|---|---|
//! | body | `is_settling` | the equilibrium at the start is searched for | springs act with their force at the step's end; poses advance with the rates after the step |
//! | | `is_pressed` | something pressed on it in the last step | the forces of rotating frames use the rates at the step's beginning, otherwise their mean |
//! | its step | `resolves_rollers` | each roller takes six steps or more to pass over the ground | contacts rotate within the step; otherwise they keep their state of its middle, and poses advance with the rates after it |
//! | | `lands` | a contact would end deeper in the ground than it began, or a joint beyond its stop | poses advance with the rates after it |
//! | wheel | `is_round` | its barrels leave no gap and have no play | it touches a plane only at its lowest point, and a roller's contact passes to the next one |
//! | | `is_compliant` | its rollers have treads | each roller carries with the part that reaches into the ground |
//! | roller | `seized` | it was set as seized | it turns with its hub |
//! | | `touched` | it had a contact in the last part of a step | its bearing acts within the reactions, otherwise by itself |
//! | | `pressed` | the ground pressed on it then | otherwise a contact on it has come down |
//! | contact | `came_down` | its roller is rigid and was not pressed | its tangents are those of the step's beginning, and its jump is separated from the rest of the step |
//!
//! # Where to find
//!
//! | topic | place |
//! |---|---|
//! | the free motion of a robot | `dynamics/` |
//! | the law of contact and dry friction | `contact/law.rs`; its rows: `contact/reactions/` |
//! | the nearest points of a roller and the ground | `contact/search/nearest.rs`; rollers by numbers: `contact/search/turned_profile.rs` |
//! | treads, creep, rolling resistance | `contact/law/tread.rs`, `contact/reactions/{compliance,rolling}.rs` |
//! | the hand-over from roller to roller | `contact/search/handover.rs`, its work: `contact/reactions/handover_impulse.rs` |
//! | landings within a step, and their time | `contact/reactions/landing.rs` |
//! | rollers with play along their axles | `robot/axial_play.rs` |
//! | floors: friction, nap, boxes, heights | `ground/` |
//! | springs, dampers and servos of joints | `robot/joints.rs`, `robot/servo.rs`; stops and couplings: `contact/reactions/joints.rs` |
//! | motor and gear on a wheel, within a step | `motor_torque.rs`, `robot/drive.rs`, `contact/law/curve.rs` |
//! | pushes, payloads, seized rollers | `world/disturbance.rs` |
//! | boxes, cylinders and spheres that can be pushed | `free.rs`, `world/free/`; their shapes: `contact/search/solid.rs` |
//! | a program's user bodies, moved by rapier | `world/user_bodies/` |
//! | chassis, bodies on joints and free bodies near the ground and one another | `contact/search/free_bodies.rs` |
//! | data shared by worlds of one robot | `robot/shared_robot.rs` |
//! | rapier moving everything, as a cross-check | `reference/` |
//!
//! # Decisions
//!
//! - **f64 everywhere**, in rapier and parry too: a kilometre from the origin a robot drives like
//!   at the origin.
//! - **A slope is tilted gravity**: the world's frame is the floor's, and z = 0 its plane.
//! - **A roller is a flywheel on its hub**: it is round, so its mass and the inertia across its
//!   axis move with the hub, and its rate is one number. That is exact, and saves 36 bodies in a
//!   robot with 36 rollers.
//! - **A step is solved in its middle**: second order if nothing lands, and a sticking contact does
//!   no work in a turn.
//! - **All contacts are springs of one stiffness**, which determines how loads are shared. It is
//!   given in the robot's own units ([`ilon_robot::Scale`]), like every threshold.
//! - **A free body is one more body of the same problem**, without joints: the same f64 dynamics,
//!   laws and balances as a robot's, exact momentum, and no errors of a second solver between the
//!   two.
//! - **User bodies are rapier's** ([`World::rapier_mut`]), of any shape and with joints. One that
//!   is near is coupled to the step, as one more body of the same problem; its impulses there act
//!   in rapier's following step.
//! - **Work is impulse times mean velocity**, which is exact for a step of constant inertia: the
//!   energy balance closes, and its remainder shows the step's error.
//! - **Wheel loops act within the step**, unless they are sampled: torque falls as the wheel gains
//!   rate, like a damping in the mass matrix. Limits of motors and losses of gears are curves among
//!   the reactions.

mod contact;
mod dynamics;
mod engine;
mod error;
mod free;
mod ground;
mod loss;
mod motor_torque;
mod objects;
mod reference;
mod robot;
mod settings;
mod world;

pub use contact::reactions::support::Support;
pub use contact::reactions::wheel_contact::WheelContact;
pub use contact::reactions::wheel_tally::WheelTally;
pub use error::WorldError;
pub use free::{FreeBody, FreeBodyId};
pub use ground::{ContactSurface, Floor, FloorSurface, GroundBox, Nap, Patch, Relief, Stribeck};
pub use motor_torque::MotorTorque;
pub use objects::{BodyId, WorldObject};
pub use rapier3d;
pub use robot::energy::Energy;
pub use robot::shared_robot::SharedRobot;
pub use settings::{
    ContactSolver, RollerBodies, Settings, contact_relaxation_s, contact_stiffness_n_m,
    contact_stiffness_of_robot_n_m,
};
pub use world::{
    Body, BodyMut, BodyState, ContactSolution, FreeBodyState, Payload, PlaceMotion, Push, RayHit,
    World, longest_step_of_springs_s,
};
