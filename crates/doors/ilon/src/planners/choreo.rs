//! A project file for Choreo.

use serde_json::{Value, json};

use super::Swerve;

/// The robot as a project of Choreo (`.chor`, schema 2), without trajectories. Motors are written
/// at the wheel, with a gear ratio of 1.
///
/// Choreo takes two wheel positions and mirrors them; they are the mean of left and right.
pub fn choreo(swerve: &Swerve) -> String {
    let [front_m, back_m, left_m, right_m] = swerve.reach_m;
    let [fl, fr, bl, br] = swerve.modules_m;
    let pair = |left: [f64; 2], right: [f64; 2]| {
        json!({
            "x": said(0.5 * (left[0] + right[0]), "m"),
            "y": said(0.5 * (left[1] - right[1]), "m"),
        })
    };
    let project = json!({
        "name": swerve.name,
        "version": 2,
        "type": "Swerve",
        "variables": { "expressions": {}, "poses": {} },
        "config": {
            "frontLeft": pair(fl, fr),
            "backLeft": pair(bl, br),
            "mass": said(swerve.mass_kg, "kg"),
            "inertia": said(swerve.inertia_kg_m2, "kg m ^ 2"),
            "gearing": said(1.0, ""),
            "radius": said(swerve.wheel_radius_m, "m"),
            "vmax": said(swerve.speed_m_s / swerve.wheel_radius_m, "rad / s"),
            "cof": said(swerve.friction, ""),
            "tmax": said(swerve.torque_n_m, "N * m"),
            "bumper": {
                "front": said(front_m, "m"),
                "side": said(left_m.max(right_m), "m"),
                "back": said(back_m, "m"),
            },
            "differentialTrackWidth": said(fl[1] - fr[1], "m"),
        },
        "generationFeatures": [],
        "codegen": { "root": Value::Null, "genVars": true, "genTrajData": true, "useChoreoLib": true },
    });
    format!("{project:#}\n")
}

/// A number in Choreo's form: an expression with unit, and the value in SI units.
fn said(value: f64, unit: &str) -> Value {
    let exp = format!("{value} {unit}");
    json!({ "exp": exp.trim_end(), "val": value })
}
