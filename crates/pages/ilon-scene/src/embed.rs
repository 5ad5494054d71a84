//! Embeds a scene in a page: a style sheet, a classic script (a page opened from disk may not load
//! modules), and data.

use crate::description::Scene;

/// The style sheet: the scene's colours by theme, and its elements.
pub const STYLE: &str = include_str!("web/scene.css");

/// The project's mark: a wheel with slanted rollers.
pub const MARK: &str = r#"<svg viewBox="0 0 32 32" aria-hidden="true" fill="none" stroke="currentColor" stroke-width="2.6" stroke-linecap="round"><circle cx="16" cy="16" r="13"/><path d="M9 20.5 14.5 9M14 24 21 9.5M19.5 24 24 14.5"/></svg>"#;

/// The style of the line with the mark and the switch of the theme.
pub const BRAND_STYLE: &str = include_str!("web/brand.css");

/// The script of a page's light and dark theme, which a button of the class `theme` switches.
pub const THEME: &str = include_str!("web/theme.js");

/// The parts of the script, in order of dependency.
const PARTS: [&str; 7] = [
    include_str!("web/math.js"),
    include_str!("web/geometry.js"),
    include_str!("web/frames.js"),
    include_str!("web/camera.js"),
    include_str!("web/renderer.js"),
    include_str!("web/model.js"),
    concat!(
        include_str!("web/controls.js"),
        include_str!("web/scene.js")
    ),
];

/// The style sheet for [`driving_script`].
pub const DRIVE_STYLE: &str = include_str!("web/drive.css");

/// Instructions for driving, as HTML to show beside the robot.
pub const HOW_TO_DRIVE: &str = "<kbd>W</kbd> <kbd>S</kbd> ahead and back, <kbd>A</kbd> <kbd>D</kbd> to the sides (or the arrows), \
     <kbd>Q</kbd> <kbd>E</kbd> turn, <kbd>Space</kbd> stops; or the two sticks in the picture, or those of a gamepad: left drives, right turns. \
     Pale robot: position by wheel odometry.";

/// The script: it defines `ilonScene(canvas, data, options)` and no other name.
pub fn script() -> String {
    joined(&PARTS)
}

/// The script with controls for driving: it also defines `ilonDrive(stage, tell, options)`,
/// `ilonWheels(box, scene)`, `ilonFigures(box)` and `ilonPush(stage, scene, robot, tell, isOn)`.
pub fn driving_script() -> String {
    joined(&[&PARTS[..], &[include_str!("web/drive.js")]].concat())
}

/// Joins parts into one script without comment lines and indentation.
fn joined(parts: &[&str]) -> String {
    let lines = parts.iter().flat_map(|part| part.lines()).map(str::trim);
    let code = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    let code: Vec<&str> = code.collect();
    format!(
        "(function () {{\n'use strict';\n{}\n}})();\n",
        code.join("\n")
    )
}

/// The data as JSON that can stand inside a `<script>` element.
///
/// # Errors
/// Never for a scene made by this crate; otherwise those of serde.
pub fn data(scene: &Scene) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string(scene)?.replace('<', "\\u003c"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_is_small_and_loads_nothing() {
        // A fortieth of the largest page; the driving controls come on top.
        assert!(script().len() < 50_000, "{} bytes", script().len());
        let script = driving_script();
        assert!(script.len() < 60_000, "{} bytes", script.len());
        for word in [
            "http",
            "fetch(",
            "import ",
            "import(",
            "XMLHttpRequest",
            "eval(",
            "</script",
        ] {
            assert!(!script.contains(word), "{word}");
        }
        for style in [STYLE, DRIVE_STYLE] {
            assert!(!style.contains("url(") && !style.contains("@import"));
        }
    }
}
