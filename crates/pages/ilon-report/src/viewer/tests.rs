use ilon_trace::{Ground, GroundPatch};

use super::*;

/// What the trace says in sides is drawn in half sides, where and while it is there.
#[test]
fn a_patch_is_drawn_as_large_as_it_is() {
    let header = Header {
        ground: Some(Ground {
            patches: vec![GroundPatch {
                center_m: [2.0, -1.0],
                sides_m: [1.0, 3.0],
                friction: 0.25,
                from_s: 1.0,
                until_s: Some(5.0),
                ..GroundPatch::default()
            }],
            ..Ground::default()
        }),
        ..Header::default()
    };
    let drawn = &floor(&header, None).patches[0];
    assert_eq!(drawn.center_m, [2.0, -1.0]);
    assert_eq!(drawn.half_sides_m, [0.5, 1.5]);
    assert_eq!((drawn.from_s, drawn.until_s), (1.0, Some(5.0)));
}

#[test]
fn a_push_is_drawn_for_as_long_as_it_lasts() {
    let header = Header {
        faults: Some(vec![Fault {
            from_s: 2.0,
            until_s: Some(2.5),
            kind: FaultKind::Push {
                impulse_n_s: [1.0, -2.0, 0.5],
                in_body: true,
                place_m: [0.25, 0.0, 0.125],
            },
        }]),
        ..Header::default()
    };
    let drawn = &pushes(&header)[0];
    assert_eq!((drawn.from_s, drawn.until_s), (2.0, 2.5));
    assert_eq!(drawn.impulse_n_s, [1.0, -2.0, 0.5]);
    assert_eq!(drawn.point_m, [0.25, 0.0, 0.125]);
    assert!(drawn.in_body);
}

#[test]
fn runs_beside_each_other_share_a_slider_from_the_first_start_to_the_last_end() {
    let page = of_runs(&[("a", "{}".to_owned())], [1.0, 3.5]);
    assert!(page.contains("\"start\":1.0"), "{page}");
    assert!(page.contains("\"end\":3.5"), "{page}");
}
