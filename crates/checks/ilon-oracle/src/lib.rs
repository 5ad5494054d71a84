//! An oracle for slip: a second, independent simulation of ilon's robots, against which its
//! contacts are tested.
//!
//! It is slow and simple. Chassis, bodies on joints, hubs and rollers are separate bodies in f64
//! (`dynamics.rs` derives their equations of motion). A roller that touches the floor rests on an
//! explicit spring, damper and bristle ([`ContactLaw`]). Steps of microseconds resolve these
//! springs, and there is no contact solver. As the springs stiffen, the motion tends to that of
//! rigid contacts with Coulomb friction, which ilon solves directly by another method: no formula
//! is shared. Only the description of the robot is shared, [`ilon_robot::Robot`].
//!
//! It supports a level or tilted floor with plates on it, exact barrels with or without axial play
//! and with load-dependent friction on their axles, tyres off the plates, and revolute or prismatic
//! joints, free or sprung, with damping, dry friction, stops and couplings. The chassis has no
//! contacts.
//!
//! Frames and signs are those of [`ilon_robot`].
//!
//! ```
//! use ilon_oracle::{ContactLaw, Drive, Engine, LEVEL_GRAVITY_M_S2, Settings};
//! use ilon_formats::LoadRobot;
//! use ilon_robot::Robot;
//!
//! let robot = Robot::load("../../../assets/robots/mecanum4.urdf")?;
//! let settings = Settings {
//!     step_s: 1e-5,
//!     contact: ContactLaw::stiff(2e6, 0.6, &robot), // N/m, friction
//!     gravity_m_s2: LEVEL_GRAVITY_M_S2,
//! };
//! let mut engine = Engine::new(&robot, settings)?;
//! for wheel in 0..4 {
//!     engine.drive(wheel, Drive::Torque(0.1)); // N m
//! }
//! for _ in 0..20_000 {
//!     engine.step()?;
//! }
//! // 8 N on 11.4 kg, and on the inertia of wheels and rollers, for 0.2 s.
//! assert!((engine.speeds().linear.x - 0.14).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod contact;
mod dynamics;
mod energy;
mod engine;
mod error;
mod forces;
mod generalised;
mod ground;
mod joint;
mod linkage;
mod motion;
mod outline;
mod play;
mod posture;
mod settings;
mod solution;
mod stability;
mod step;
mod touch;
mod tree;

pub use contact::{ContactLaw, Nap};
pub use energy::Energy;
pub use engine::Engine;
pub use error::OracleError;
pub use generalised::Generalised;
pub use joint::{Drive, Push};
pub use motion::Motion;
pub use settings::{Contact, LEVEL_GRAVITY_M_S2, Plate, Settings};
