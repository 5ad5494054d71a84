use super::*;

#[test]
fn an_event_lasts_from_its_begin_to_its_end() {
    let event = Event {
        from_s: 1.5,
        until_s: 4.0,
        kind: EventKind::Fault,
        text: String::new(),
        slid_m: 0.0,
        lost_j: 0.0,
    };
    let table = events_table(&[event]);
    assert!(table.contains("<td>2.50 s</td>"), "{table}");
}

#[test]
fn runs_beside_each_other_share_a_slider_from_the_first_start_to_the_last_end() {
    let page = of_runs(&[("a", "{}".to_owned())], [1.0, 3.5]);
    assert!(page.contains("\"start\":1.0"), "{page}");
    assert!(page.contains("\"end\":3.5"), "{page}");
}
