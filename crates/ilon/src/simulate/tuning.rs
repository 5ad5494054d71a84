//! What the program chooses where the scenario leaves it open.

/// The physics step for `"auto"`, in seconds: the world's measured default, shortened to divide the control period.
pub(super) fn physics_dt_s(control_dt_s: f64) -> f64 {
    let longest_s = ilon_world::Settings::default().dt_s;
    // A part in 10^9 keeps a period that is a whole number of steps but for rounding from taking one more.
    let steps = (control_dt_s / longest_s - 1e-9).ceil().max(1.0);
    control_dt_s / steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chosen_step_divides_the_control_period_and_is_no_longer_than_the_default() {
        let longest_s = ilon_world::Settings::default().dt_s;
        for control_dt_s in [0.01, 1.0 / 30.0, 0.0007, 0.0123] {
            let dt_s = physics_dt_s(control_dt_s);
            let steps = control_dt_s / dt_s;
            assert!((steps - steps.round()).abs() < 1e-9 * steps);
            assert!(dt_s <= longest_s * (1.0 + 1e-9));
        }
    }
}
