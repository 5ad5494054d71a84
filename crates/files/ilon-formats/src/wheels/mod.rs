//! A robot with its wheels as made, for other simulators: MJCF, SDF and URDF.
//!
//! | module | has |
//! |---|---|
//! | `fit` | the native shape that is nearest to a roller as made |
//! | `parts` | the robot as a tree of bodies on joints |
//! | `frame` | what every file has around the robot: ground, step, the comment at its head |
//! | `mjcf`, `tags` | the formats |
//! | `tyres` | what stands for a tyre |
//! | `stl` | meshes of rollers for which no native shape is near |

mod fit;
mod frame;
mod mjcf;
mod parts;
mod stl;
mod tags;
mod tyres;

pub use fit::{FittedRobot, RollerShape, Shapes, fit};
pub use frame::{Ground, STEP_S};
pub use mjcf::contact_stiffness_n_m;

/// A format that robots are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's, with a scene.
    Mjcf,
    /// Gazebo's, with a world.
    Sdf,
    /// The plainest: solids and meshes.
    Urdf,
}

impl Format {
    /// The shapes that it has.
    pub fn shapes(self) -> Shapes {
        match self {
            Self::Mjcf | Self::Sdf => Shapes::All,
            Self::Urdf => Shapes::Plain,
        }
    }
}

/// The files of a fitted robot, by name: the robot's, called after `stem`, meshes of its rollers, and a world to start in. `about` is put at
/// their head as a comment.
pub fn write_fitted(
    fitted: &FittedRobot,
    format: Format,
    stem: &str,
    ground: &Ground,
    about: &str,
) -> Vec<(String, Vec<u8>)> {
    let parts = parts::parts(fitted);
    let meshes = parts::meshes(fitted);
    let names: Vec<String> = (0..meshes.len())
        .map(|i| format!("{stem}_roller_{i}.stl"))
        .collect();
    let bodies = meshes.iter().map(|points| stl::turned(points));
    let mut files: Vec<(String, Vec<u8>)> = names.iter().cloned().zip(bodies).collect();
    let tags = |dialect| tags::Tags {
        dialect,
        fitted,
        parts: &parts,
        meshes: &names,
        ground,
        about,
    };
    let mut add = |name: String, text: String| files.push((name, text.into_bytes()));
    match format {
        Format::Mjcf => {
            let name = format!("{stem}.xml");
            add(format!("{stem}_scene.xml"), mjcf::scene(&name, ground));
            add(name, mjcf::write(fitted, &parts, &names, ground, about));
        }
        Format::Sdf => {
            let tags = tags(tags::Dialect::Sdf);
            add(format!("{stem}.sdf"), tags.file(false));
            add(format!("{stem}_world.sdf"), tags.file(true));
        }
        Format::Urdf => {
            let text = tags(tags::Dialect::Urdf).file(false);
            add(format!("{stem}.urdf"), text);
        }
    }
    files
}
