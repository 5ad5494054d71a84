//! The effect of each cause on the run: displacements, and the paths without the cause.

use ilon_robot::Pose;
use ilon_trace::effects::{Ablation, FLOORS};
use ilon_trace::{Change, Header};

use super::motion::way;
use crate::figure::{Figure, Layout, axis, bars, dashed, map_layout, plot, solid};
use crate::input::RunInput;

/// Largest number of paths without a cause; the largest effects first.
const MOST_WAYS: usize = 4;
const COLORS: [&str; MOST_WAYS] = ["@asked", "@slip", "@geometry", "@servo"];

/// Displacement of the robot's end by each cause, in the heading of the run without it; `None` if
/// there was none.
pub(crate) fn at_the_end(ablations: &[Ablation]) -> Option<Figure> {
    let mut rows: Vec<(String, f64, &'static str)> = Vec::new();
    for one in ablations {
        let name = one.cause.map_or("all of them", |cause| &cause.words);
        let parts = [
            (one.apart.ahead_m, "ahead", "@asked"),
            (one.apart.left_m, "to the left", "@slip"),
        ];
        let told = parts
            .iter()
            .filter(|(off_m, ..)| off_m.abs() > FLOORS * one.end_floor[0]);
        rows.extend(
            told.map(|(off_m, way, color)| (format!("{way}: {name}"), 1e3 * off_m, *color)),
        );
    }
    if rows.is_empty() {
        return None;
    }
    let names: Vec<String> = rows.iter().map(|(name, ..)| name.clone()).collect();
    let height_px = 60 + 34 * rows.len() as u32;
    let curves = rows.iter().enumerate().map(|(row, (name, mm, color))| {
        let values: Vec<_> = (0..rows.len()).map(|k| (k == row).then_some(*mm)).collect();
        bars(name, &values, color).unlisted()
    });
    Some(
        Figure::new(
            "causes-end",
            "Where each cause put the robot at the end",
            "The run minus the run without the cause. Bars that point left are back and to the right.",
            plot(
                curves.collect(),
                Layout::of(axis("mm"), axis("").names(names)),
            ),
        )
        .height_px(height_px),
    )
}

/// The path with all causes and without each; `None` if none moved the robot.
pub(crate) fn ways(shown: &RunInput, ablations: &[Ablation]) -> Option<Figure> {
    let trace = &*shown.trace;
    let header = &trace.header;
    let mut moved: Vec<&Ablation> = ablations.iter().filter(|one| one.moves()).collect();
    moved.sort_by(|a, b| b.apart.most_m.total_cmp(&a.apart.most_m));
    let point = |pose: Pose| header.reference_point_at(pose);
    let truth: Vec<Pose> = trace
        .records()
        .iter()
        .map(|r| point(r.truth.pose))
        .collect();
    let mut curves = vec![way("with all", &truth, solid("@real").width(2.6))];
    for (one, color) in moved.iter().zip(COLORS) {
        let Some(cause) = one.cause else { continue };
        let poses: Vec<Pose> = poses(header, &cause.key).map(point).collect();
        curves.push(way(
            &format!("without {}", cause.words),
            &poses,
            dashed(color).width(2.0),
        ));
    }
    (curves.len() > 1).then(|| {
        Figure::new(
            "causes-ways",
            "The way with each cause and without it",
            "Seen from above.",
            plot(curves, map_layout()),
        )
        .height_px(440)
    })
}

/// Returns the poses of the run without a cause, by the cause's key.
fn poses<'a>(header: &'a Header, key: &'a str) -> impl Iterator<Item = Pose> + 'a {
    let of_cause =
        move |change: &Change| matches!(change, Change::Without(cause) if cause.key == key);
    let twins = header
        .twins
        .iter()
        .filter(move |twin| of_cause(&twin.change));
    twins
        .flat_map(|twin| &twin.poses)
        .map(|[_, x_m, y_m, heading_rad]| Pose {
            x_m: *x_m,
            y_m: *y_m,
            heading_rad: *heading_rad,
        })
}
