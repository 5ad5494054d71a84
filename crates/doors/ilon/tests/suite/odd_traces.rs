//! Traces that no run writes, and figures that belong to another run: programs get errors, not
//! panics.

use ilon::compare::{ComparedRun, Comparison};
use ilon::trace::{Header, Record, Settings, Summary, Trace, WheelHeader, WheelSample};

fn trace(rows: usize, wheels: usize, open_loop: bool) -> Trace {
    let header = Header {
        scenario_name: "odd".to_owned(),
        wheels: vec![WheelHeader::default(); wheels],
        control_dt_s: 0.01,
        physics_dt_s: 0.01,
        open_loop,
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, rows);
    for row in 0..rows {
        let record = Record {
            t_s: 0.01 * row as f64,
            ..Record::default()
        };
        // A roller index beyond the header's count.
        let sample = WheelSample {
            roller: u32::MAX,
            touching: true,
            ..WheelSample::default()
        }
        .steady();
        trace.push(record, &vec![sample; wheels]);
    }
    trace
}

#[test]
fn a_page_is_made_of_any_trace_with_the_figures_of_any_other() {
    let odd: Vec<Trace> = [(0, 0), (0, 3), (1, 0), (1, 3), (2, 1), (50, 4)]
        .into_iter()
        .flat_map(|(rows, wheels)| [true, false].map(|open_loop| trace(rows, wheels, open_loop)))
        .collect();
    let summary = |trace| Summary::of(trace, &Settings::default());
    for shown in &odd {
        for figures in odd.iter().map(summary).chain([Summary::default()]) {
            assert!(ilon::report::html(shown, &figures).contains("</html>"));
        }
    }
    let run = |trace: &Trace| ComparedRun {
        name: "odd".to_owned(),
        trace: trace.clone(),
        summary: Summary::default(),
    };
    for pair in odd.windows(2) {
        let runs = pair.iter().map(run).collect();
        let comparison = Comparison::of(runs, &[]).expect("they are two");
        assert!(ilon::report::compare::html(&comparison).contains("</html>"));
    }
    let none = Comparison {
        runs: Vec::new(),
        differences: Vec::new(),
    };
    assert!(ilon::report::compare::html(&none).contains("</html>"));
}
