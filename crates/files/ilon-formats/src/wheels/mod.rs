//! A robot with its wheels as made, for other simulators: MJCF, SDF and URDF.
//!
//! | module | has |
//! |---|---|
//! | `shape` | the shapes that stand for rollers and tyres |
//! | `fit` | the native shape that is nearest to a roller as made |
//! | `parts` | the robot as a tree of bodies on joints |
//! | `frame` | what every file has around the robot: format, ground, step, the comment at its head |
//! | `mjcf`, `tags` | the formats |
//! | `tyres` | what stands for a tyre |

mod fit;
mod frame;
mod mjcf;
mod parts;
mod shape;
mod tags;
mod tyres;

pub use fit::{FittedRobot, fit};
pub use frame::{Format, Ground, STEP_S};
pub use mjcf::contact_stiffness_n_m;
pub use shape::RollerShape;

/// The files of a fitted robot, by name: the robot's, called after `stem`, and a world to start in.
/// `about` is put at their head as a comment.
pub fn write_fitted(
    fitted: &FittedRobot,
    format: Format,
    stem: &str,
    ground: &Ground,
    about: &str,
) -> Vec<(String, Vec<u8>)> {
    let parts = parts::parts(fitted);
    let tags = |dialect| tags::Tags {
        dialect,
        fitted,
        parts: &parts,
        ground,
        about,
    };
    let files = match format {
        Format::Mjcf => {
            let name = format!("{stem}.xml");
            let scene = mjcf::scene(&name, &parts, ground);
            let model = mjcf::write(fitted, &parts, ground, about);
            vec![(format!("{stem}_scene.xml"), scene), (name, model)]
        }
        Format::Sdf => {
            let tags = tags(tags::Dialect::Sdf);
            let world = tags.file(true);
            vec![
                (format!("{stem}.sdf"), tags.file(false)),
                (format!("{stem}_world.sdf"), world),
            ]
        }
        Format::Urdf => vec![(
            format!("{stem}.urdf"),
            tags(tags::Dialect::Urdf).file(false),
        )],
    };
    let bytes = |(name, text): (String, String)| (name, text.into_bytes());
    files.into_iter().map(bytes).collect()
}
