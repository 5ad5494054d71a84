use super::*;

#[test]
fn runs_beside_each_other_share_a_slider_from_the_first_start_to_the_last_end() {
    let page = of_runs(&[("a", "{}".to_owned())], [1.0, 3.5]);
    assert!(page.contains("\"start\":1.0"), "{page}");
    assert!(page.contains("\"end\":3.5"), "{page}");
}
