//! One contact that is alone, solved exactly.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::system::TOLERANCE;

/// The impulse of one contact that is alone, with the response W and the velocity `free` that it would have without: normal and
/// two tangents, for its law with an approach and a compliance.
///
/// With the friction that belongs to it, the normal velocity is a continuous function of the normal impulse: below 0 without
/// any, or there is no contact, and in the end growing, because a contact that is pressed hard enough sticks. Between the two it is
/// 0, however strongly friction presses the contact down or lifts it: solving for the one with the other as it was would swing to
/// and fro for ever where mu |W_nt| > W_nn.
pub(super) fn contact_impulse(
    w: &Matrix3<f64>,
    free: &Vector3<f64>,
    friction: f64,
    (approach_m_s, compliance): (f64, f64),
) -> Vector3<f64> {
    /// Halvings of the bracket, at the least.
    const ROUNDS: usize = 100;
    let tangents = w.fixed_view::<2, 2>(1, 1).into_owned();
    let coupling = Vector2::new(w[(1, 0)], w[(2, 0)]);
    let rubbed = |normal: f64| {
        friction_impulse(
            &tangents,
            &(free.yz() + coupling * normal),
            friction * normal,
        )
    };
    let excess = |normal: f64| {
        let rubs = coupling.dot(&rubbed(normal));
        free.x + approach_m_s + (w[(0, 0)] + compliance) * normal + rubs
    };
    let mut low = (0.0, excess(0.0));
    if low.1 >= 0.0 {
        return Vector3::zeros();
    }
    let mut high_n_s = -low.1 / (w[(0, 0)] + compliance);
    let mut high = (high_n_s, excess(high_n_s));
    for _ in 0..ROUNDS {
        if high.1 >= 0.0 {
            break;
        }
        low = high;
        high_n_s *= 2.0;
        high = (high_n_s, excess(high_n_s));
    }
    // The secant, with the end that stays behind halved (Illinois, Dowell and Jarratt 1971).
    let mut normal = high.0;
    for _ in 0..ROUNDS {
        if high.1 - low.1 <= 0.0 || high.0 - low.0 <= 1e-15 * high.0 {
            break;
        }
        normal = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let here = excess(normal);
        if here.abs() < 1e-2 * TOLERANCE {
            break;
        }
        if here > 0.0 {
            high = (normal, here);
            low.1 *= 0.5;
        } else {
            low = (normal, here);
            high.1 *= 0.5;
        }
    }
    let rubbed = rubbed(normal);
    Vector3::new(normal, rubbed.x, rubbed.y)
}

/// The friction impulse of one contact: W p + free = 0 where |p| may be that large, and else the p of size `most` that
/// opposes the sliding W p + free, which is (W + a 1) p = -free for the a > 0 that makes it that large.
///
/// 1/|p| is nearly straight in a, so that Newton's method on it converges from the left in a few steps (More and
/// Sorensen 1983).
pub(super) fn friction_impulse(w: &Matrix2<f64>, free: &Vector2<f64>, most: f64) -> Vector2<f64> {
    if most <= 0.0 {
        return Vector2::zeros();
    }
    let mut a = 0.0;
    let mut impulse = Vector2::zeros();
    for _ in 0..30 {
        let (xx, xy, yy) = (w[(0, 0)] + a, w[(0, 1)], w[(1, 1)] + a);
        let determinant = (xx * yy - xy * xy).max(f64::MIN_POSITIVE);
        let solve =
            |f: &Vector2<f64>| Vector2::new(yy * f.x - xy * f.y, xx * f.y - xy * f.x) / determinant;
        impulse = -solve(free);
        let size = impulse.norm();
        if size <= most * (1.0 + 1e-12) {
            break;
        }
        a += (size / most - 1.0) * size * size / impulse.dot(&solve(&impulse));
    }
    // What is left of the iteration's error may not leave the friction disc.
    let size = impulse.norm();
    if size > most {
        impulse * (most / size)
    } else {
        impulse
    }
}
