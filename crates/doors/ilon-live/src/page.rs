//! The page that drives the robot.

use ilon_scene::{Frames, Scene, embed};

use crate::control::priority_in_words;
use crate::session::Session;

/// Returns the whole page; only the data of its socket is separate.
pub(crate) fn html(session: &Session) -> Result<String, serde_json::Error> {
    let description = session.description();
    let frames = Frames::beside(session.robot(), description.bodies.len(), []);
    let scene = Scene::new(description, frames);
    let title = session.name().replace('&', "&amp;").replace('<', "&lt;");
    let settings = serde_json::json!({
        "friction": session.friction(),
        "priority": priority_in_words(session.priority()),
        "reference": session.has_reference(),
    });
    Ok(include_str!("page.html")
        .replace(
            "{{style}}",
            &[embed::BRAND_STYLE, embed::STYLE, embed::DRIVE_STYLE].concat(),
        )
        .replace("{{mark}}", embed::MARK)
        .replace("{{theme}}", embed::THEME)
        .replace("{{how}}", embed::HOW_TO_DRIVE)
        .replace("{{script}}", &embed::driving_script())
        .replace("{{live}}", include_str!("page.js"))
        .replace("{{settings}}", &settings.to_string())
        .replace("{{data}}", &embed::data(&scene)?)
        // The name is inserted last, so that nothing in it is replaced.
        .replace("{{title}}", &title))
}
