//! A page with one scene and a timeline.

use ilon_scene::{Scene, embed};

/// The whole page.
pub fn html(title: &str, scene: &Scene) -> Result<String, serde_json::Error> {
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    Ok(include_str!("page.html")
        .replace("{{title}}", &title)
        .replace("{{style}}", embed::STYLE)
        .replace("{{script}}", &embed::script())
        .replace("{{data}}", &embed::data(scene)?))
}
