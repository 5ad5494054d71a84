//! The robot and its run **in three dimensions**: data and script for a page that needs no network.
//!
//! A [`Description`] is the static part: the robot with the exact barrel of each roller, and the
//! ground and faults from a trace's header. [`Frames`] are the motion: the robot's pose, the ghost
//! of the ideal kinematics, wheel and roller angles, and the contacts, over time. The two make a
//! [`Scene`], which [`embed::data`] writes into a page beside [`embed::script`] and
//! [`embed::STYLE`]. There `ilonScene(canvas, data)` draws it with WebGL 2. A page that shows a
//! driving robot begins with [`Frames::live`], and passes each [`Frame`] as [`Frame::bytes`] to
//! `push`.
//!
//! ```js
//! const scene = ilonScene(canvas, data, { selected: 0 });
//! scene.seek(3.2);                                         // the time belongs to the page: its slider calls this
//! scene.on('pick', ({ wheel, name }) => {});               // and 'select', 'draw', 'view'
//! scene.select(1);                                         // a wheel close up; null for none
//! scene.view('whole');                                     // 'follow', 'whole', 'top'
//! scene.set({ ghost: false });
//! socket.binaryType = 'arraybuffer';                       // a WebSocket whose messages are `Frame::bytes`
//! socket.onmessage = (message) => scene.push(message.data);
//! ```
//!
//! The canvas fills its parent, which must be positioned (`position: relative`), as the text of the
//! close-up is laid over it. Colours are the style sheet's `--scene-...`, with a dark set under
//! `:root[data-theme="dark"]`. Forces are drawn in proportion to the load of a wheel at rest.
//!
//! | module | answers |
//! |---|---|
//! | [`description`] | what is drawn: robot, ground, faults |
//! | [`outline`] | the exact outline of a roller |
//! | [`frames`] | one instant, and many in compact form |
//! | [`run`] | the frames of a recorded run |
//! | [`embed`] | how the scene and its driving controls are embedded in a page |
//!
//! ```
//! use ilon_formats::{LoadRobot, link_tree};
//! use ilon_robot::{VisualMeshes, Robot};
//! use ilon_scene::{Description, Frames, Scene, embed};
//!
//! let urdf = std::fs::read_to_string("../../../assets/robots/volksbot.urdf")?;
//! let robot = Robot::from_urdf_str(&urdf, "volksbot.urdf")?;
//! let scene = Scene::new(Description::of_robot(&robot, link_tree(&urdf).as_ref(), &VisualMeshes::default()), Frames::at_rest(&robot));
//! let page = format!(
//!     "<style>{}</style><canvas style='height: 20rem'></canvas><script>{}</script>
//!      <script>ilonScene(document.querySelector('canvas'), {});</script>",
//!     embed::STYLE, embed::script(), embed::data(&scene)?,
//! );
//! assert!(page.len() < 80_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod description;
pub mod embed;
pub mod frames;
pub mod outline;
mod robot;
pub mod run;
mod visuals;

pub use description::{
    Description, OtherWay, PlacedMesh, Relief, RobotShape, RollerShape, Scene, Shape, WheelShape,
};
pub use frames::{Column, Contact, Frame, Frames, Interpolation, WheelFrame};
pub use run::{Rolling, Thinning, frames_of_run, shapes_of_bodies};
