//! The robot as the rest of the project sees it, whatever file it came from.

pub mod barrel;
mod collision;
mod droop;
mod joint;
mod linkage;
mod looks;
pub mod made;
pub mod mass;
mod planar;
pub mod profile;
mod remark;
mod robot;
mod roller;
mod scale;
mod standing;
pub mod tread;
pub mod turned;
mod wheel;

pub use barrel::Barrel;
pub use collision::{Collision, CollisionShape};
pub use droop::mean_of_gain;
pub use joint::{DriveTrain, Joint, MotorLimits};
pub use linkage::{Body, BodyJoint, Coupling, JointKind, JointRole, JointSpring};
pub use looks::{Looks, Mesh};
pub use made::{NotMade, RollersAsMade};
pub use mass::MassProperties;
pub use planar::{Pose, Twist, wrap_angle};
pub use profile::{Profile, ProfilePart};
pub use remark::Remark;
pub use robot::{Chassis, Robot};
pub use roller::{ModelledRoller, Roller, RollerForm};
pub use scale::Scale;
pub use standing::StandingPose;
pub use tread::{RollerSurface, Tread};
pub use turned::{NotTurned, Turned};
pub use wheel::Wheel;
