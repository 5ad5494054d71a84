//! Bisection, as all crates of the project use it.

/// Halves an interval so many times; its first end stays one at which something holds, its second
/// one at which it does not. Returns both ends. The first may be the larger number.
pub fn bisected(
    (mut holds, mut fails): (f64, f64),
    halvings: u32,
    mut does_hold: impl FnMut(f64) -> bool,
) -> (f64, f64) {
    for _ in 0..halvings {
        let middle = 0.5 * (holds + fails);
        match does_hold(middle) {
            true => holds = middle,
            false => fails = middle,
        }
    }
    (holds, fails)
}
