//! The data of the picture that plays the run from above.

use ilon_trace::WheelSample;
use serde_json::{Value, json};

use super::gathered::OfWheel;
use super::page::json_in_script;
use super::shown::Shown;
use super::thin::{evenly, short};

/// The script that plays them.
pub(super) const SCRIPT: &str = include_str!("web/top_view.js");

/// The most frames that the picture plays.
const MAX_FRAMES: usize = 1500;

/// The picture with its controls and data, as HTML.
pub(super) fn html(shown: &Shown) -> String {
    format!(
        "<figure class=\"whole\" id=\"top-view\"><figcaption><h3>The run from above</h3>\
         <p>Green dots are contacts that grip, orange ones are at their friction limit; they grow with the load. Orange \
         arrows are sliding velocities, to the run's own scale. The dashed line is the reference, the grey arrow where the \
         robot should be.</p></figcaption>\n\
         <canvas role=\"img\" aria-label=\"The robot seen from above while it moves\"></canvas>\n\
         <div class=\"controls\"><button type=\"button\" class=\"play\">Play</button>\
         <input type=\"range\" min=\"0\" max=\"1\" step=\"0.01\" value=\"0\" aria-label=\"Time\"><output></output>\
         <label>Speed <select><option value=\"0.1\">0.1×</option><option value=\"0.25\">0.25×</option>\
         <option value=\"1\" selected>1×</option><option value=\"4\">4×</option></select></label>\
         <label><input type=\"checkbox\" class=\"chase\"> Follow the robot</label></div>\n\
         <script type=\"application/json\" id=\"top-view-data\">{}</script></figure>\n",
        json_in_script(&data(shown).to_string())
    )
}

/// Frames, columns by quantity, in the units of the trace; places to a tenth of a millimetre.
fn data(shown: &Shown) -> Value {
    let trace = &*shown.trace;
    let frames = evenly(trace.records().len(), MAX_FRAMES);
    let records = || frames.iter().map(|&k| &trace.records()[k]);
    let places = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        values.map(|x| (x * 1e4).round() / 1e4).collect()
    };
    let desired = |f: fn(&ilon_robot::Pose) -> f64| -> Vec<Option<f64>> {
        if records().all(|r| r.desired.is_none()) {
            return Vec::new();
        }
        let values = records().map(|r| r.desired.map(|d| f(&d.pose)));
        values.map(|x| x.map(|x| (x * 1e4).round() / 1e4)).collect()
    };
    let header = &trace.header;
    let wheels: Vec<Value> = header
        .wheels
        .iter()
        .enumerate()
        .map(|(index, wheel)| {
            let of = |f: fn(&WheelSample) -> f64, digits: usize| -> Vec<f64> {
                let samples = frames.iter().map(|&k| f(&trace.wheels_at(k)[index]));
                samples.map(|x| short(x, digits)).collect()
            };
            json!({
                "x": wheel.position_m[0], "y": wheel.position_m[1], "axis": wheel.axis,
                "radius": wheel.radius_m, "width": wheel.width_m, "gamma": wheel.gamma_rad,
                "rollers": wheel.roller_count,
                "angle": of(|s| s.angle_rad.rem_euclid(std::f64::consts::TAU), 4),
                "contactX": of(|s| s.contact_x_m, 4), "contactY": of(|s| s.contact_y_m, 4),
                "slipX": of(|s| s.slip_x_m_s, 3), "slipY": of(|s| s.slip_y_m_s, 3),
                "load": of(|s| if s.touching { s.normal_force_n } else { 0.0 }, 3),
                "grip": of(|s| s.friction_used().unwrap_or(0.0), 3),
            })
        })
        .collect();
    // The farthest point of the robot from its origin.
    let corners = header.chassis_outlines_m.iter().flatten().copied();
    let rims = header.wheels.iter().map(|w| w.position_m);
    let reach_m = corners
        .chain(rims)
        .map(|[x, y]| x.hypot(y))
        .fold(0.05, f64::max);
    json!({
        "t": records().map(|r| short(r.t_s, 7)).collect::<Vec<_>>(),
        "x": places(&mut records().map(|r| r.truth.pose.x_m)),
        "y": places(&mut records().map(|r| r.truth.pose.y_m)),
        "heading": places(&mut records().map(|r| r.truth.pose.heading_rad)),
        "wantX": desired(|p| p.x_m), "wantY": desired(|p| p.y_m), "wantHeading": desired(|p| p.heading_rad),
        "outlines": header.chassis_outlines_m, "wheels": wheels, "reach": short(1.1 * reach_m, 4),
        "slipMax": short(shown.all.largest(OfWheel::SlipSpeed), 4),
        "loadMax": short(shown.all.largest(OfWheel::NormalForce), 4),
        // The picture on paper, and before the first play: a moment well into the run.
        "poster": short(0.35 * trace.duration_s(), 4),
    })
}
