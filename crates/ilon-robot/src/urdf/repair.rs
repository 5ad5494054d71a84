//! Mends what can be mended safely in the text of a URDF, and says what it changed.
//!
//! Each change replaces or inserts within a line, so that every line keeps its number.

use std::f64::consts::PI;
use std::ops::Range;

use super::form::{self, SINGLE};
use super::remark;
use super::source::{Source, child, describe};
use crate::error::RobotError;
use crate::model::Remark;

/// Density of a part of which only the mass is known, in kg/m^3: between plastic and aluminium.
const DENSITY_KG_M3: f64 = 1500.0;

/// The mended text, and a remark for each change.
pub(super) fn mend(source: &Source) -> (String, Vec<Remark>) {
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    let mut remarks = Vec::new();
    for outer in source.all("link").chain(source.all("joint")) {
        for node in outer.descendants().filter(|n| n.is_element()) {
            let singles = SINGLE.iter().find(|(tag, _)| node.has_tag_name(*tag));
            for single in singles.map_or(&[][..], |s| s.1) {
                for second in node.children().filter(|n| n.has_tag_name(*single)).skip(1) {
                    edits.push((second.range(), lines_of(&source.text[second.range()])));
                    remarks.push(remark(
                        describe(second),
                        format!(
                            "mended: the second `<{single}>`, on line {}, left out",
                            source.line_of(second)
                        ),
                    ));
                }
            }
        }
    }
    for link in source.all("link") {
        let Some(inertial) = child(link, "inertial") else {
            continue;
        };
        let mass = child(inertial, "mass").and_then(|m| m.attribute("value"));
        let Some(mass_kg) = mass.and_then(|m| m.trim().parse::<f64>().ok()) else {
            continue;
        };
        if !(mass_kg.is_finite() && mass_kg > 0.0) {
            continue;
        }
        let of_ball = ball_inertia(mass_kg);
        let said = match child(inertial, "inertia") {
            None => {
                if let Some(mass) = child(inertial, "mass") {
                    let end = mass.range().end;
                    edits.push((end..end, of_ball));
                }
                "missing"
            }
            Some(inertia) => {
                let fault: Result<(), RobotError> = form::check_inertial(source, inertial);
                if fault.is_ok() || form::check_numbers(source, inertia).is_err() {
                    continue;
                }
                let lines = lines_of(&source.text[inertia.range()]);
                edits.push((inertia.range(), of_ball + &lines));
                "impossible"
            }
        };
        remarks.push(remark(
            describe(inertial),
            format!(
                "mended: its {said} inertia is taken as that of a ball of {mass_kg} kg with a density of {DENSITY_KG_M3} kg/m^3"
            ),
        ));
    }
    edits.sort_by_key(|(range, _)| range.start);
    let mut text = String::with_capacity(source.text.len());
    let mut done = 0;
    for (range, replacement) in edits {
        // An edit inside one that is already made has nothing left to change.
        if range.start < done {
            continue;
        }
        text.push_str(&source.text[done..range.start]);
        text.push_str(&replacement);
        done = range.end;
    }
    text.push_str(&source.text[done..]);
    (text, remarks)
}

/// The line breaks of a text, which keep the numbers of the lines that follow.
fn lines_of(text: &str) -> String {
    "\n".repeat(text.matches('\n').count())
}

/// 2/5 m r^2 about every axis, with r = (3 m / 4 pi density)^(1/3).
fn ball_inertia(mass_kg: f64) -> String {
    let radius_m = libm::cbrt(3.0 * mass_kg / (4.0 * PI * DENSITY_KG_M3));
    let i = 0.4 * mass_kg * radius_m * radius_m;
    format!("<inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" izz=\"{i}\"/>")
}
