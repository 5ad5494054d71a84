use std::collections::BTreeMap;

use ilon_trace::Trace;

use super::*;
use crate::sample::made_up_run;
use ilon_trace::differences;

#[test]
fn the_page_says_what_it_came_to_first_and_lists_all_signals() {
    let baseline = made_up_run(2.0, true);
    let mut run = Trace::with_capacity(baseline.header.clone(), baseline.records().len());
    for (record, wheels) in baseline.steps() {
        let (mut record, mut wheels) = (*record, wheels.to_vec());
        if record.t_s >= 0.5 {
            wheels[1].torque_n_m += 0.01;
        }
        if record.t_s >= 1.0 {
            record.truth.pose.x_m += 0.001;
        }
        run.push(record, &wheels);
    }
    let Ok(found) = differences(&run, &baseline, &BTreeMap::new(), false);
    let Ok(html) = html(&run, &baseline, &found);
    // 1 mm in x from 1 s on, of a run without a turn.
    assert!(html.contains("up to <b>1.00 mm</b> from where it was in the baseline"));
    assert!(html.contains("The first to leave was <code>wheel1_torque_n_m</code> at <b>0.5 s</b>"));
    assert!(html.contains("Both were run from the same scenario."));
    // What matters most is drawn first: 1 mm of an x that hardly changes is a tenth of the 10 mm
    // below which a span only trembles.
    let at = |words: &str| html.find(words).unwrap_or_else(|| panic!("no {words}"));
    assert!(at("At worst 1.00 mm off, 10.0 %") < at("At worst 0.01 N m off"));
    assert_eq!(html.matches("<tr><th scope=\"row\">").count(), 2);
}

#[test]
fn a_run_of_other_signals_is_drawn_too() {
    let (open, closed) = (made_up_run(1.0, true), made_up_run(1.0, false));
    let Ok(found) = differences(&open, &closed, &BTreeMap::new(), false);
    let Ok(html) = html(&open, &closed, &found);
    assert!(html.contains("desired_x_m"));
}

/// From 1 s on the run is 3 mm further along x, 4 mm back along y and turned by 0.02 rad to the
/// right: 5 mm and 0.02 rad apart.
#[test]
fn runs_are_as_far_apart_as_their_places_and_as_turned_as_their_headings() {
    let baseline = made_up_run(2.0, true);
    let mut run = Trace::with_capacity(baseline.header.clone(), baseline.records().len());
    for (record, wheels) in baseline.steps() {
        let mut record = *record;
        if record.t_s >= 1.0 {
            record.truth.pose.x_m += 0.003;
            record.truth.pose.y_m -= 0.004;
            record.truth.pose.heading_rad -= 0.02;
        }
        run.push(record, wheels);
    }
    let Ok(apart) = Apart::of(&run, &baseline);
    for (t_s, apart_m, turned_rad) in apart.rows {
        let (far_m, far_rad) = if t_s >= 1.0 {
            (0.005, 0.02)
        } else {
            (0.0, 0.0)
        };
        assert!((apart_m - far_m).abs() < 1e-12, "{t_s} {apart_m}");
        assert!((turned_rad - far_rad).abs() < 1e-12, "{t_s} {turned_rad}");
    }
}

/// Rows 10 ms apart: what is drawn around a difference at 1 s lies within as many rows of it, on
/// both sides, with the edges of the tolerance where there is one.
#[test]
fn a_difference_is_drawn_with_the_rows_around_it_and_its_tolerance() {
    let baseline = made_up_run(2.0, true);
    let mut run = Trace::with_capacity(baseline.header.clone(), baseline.records().len());
    for (record, wheels) in baseline.steps() {
        let mut record = *record;
        record.truth.pose.x_m += if record.t_s >= 1.0 { 0.003 } else { 0.0 };
        run.push(record, wheels);
    }
    for (tolerance, edges) in [(0.0, 0), (0.001, 2)] {
        let tolerances = BTreeMap::from([("truth_x_m".to_owned(), tolerance)]);
        let Ok(found) = differences(&run, &baseline, &tolerances, false);
        let one = found.iter().find(|one| one.signal == "truth_x_m").unwrap();
        let Ok(figure) = around_the_first(0, one, &run, &baseline);
        let plot: serde_json::Value = serde_json::from_str(&figure.plot).unwrap();
        let curves = plot["curves"].as_array().expect("curves");
        let named = |name: &'static str| curves.iter().filter(move |curve| curve["name"] == name);
        assert_eq!(named("tolerance").count() + named("").count(), edges);
        let Ok(whole) = over_the_run(0, &Ranked { one, share: 1.0 }, &run, &baseline);
        assert_eq!(whole.plot.matches("\"tolerance\"").count(), edges / 2);
        // Long columns of times are written as their first and a step of which there are 65535 to
        // the last.
        let times = &named("run").next().expect("the run")["x"];
        let number = |key: &str| times[key].as_f64().expect("a long column");
        let (first_s, last_s) = (number("from"), number("from") + 65535.0 * number("step"));
        let half_s = 0.01 * ROWS_AROUND as f64;
        assert!((first_s - (1.0 - half_s)).abs() < 1e-6, "{first_s}");
        assert!((last_s - (1.0 + half_s)).abs() < 1e-6, "{last_s}");
    }
}
