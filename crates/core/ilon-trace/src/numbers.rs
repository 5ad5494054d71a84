//! Numbers as people read them.

/// Removes the rounding of a sum of steps from a time in seconds.
pub fn to_microseconds(t_s: f64) -> f64 {
    (t_s * 1e6).round() / 1e6
}

/// A number with all its digits, and with an exponent if zeros would hide them.
pub fn number(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-3..1e6).contains(&size) || !size.is_finite() => {
            value.to_string()
        }
        _ => format!("{value:e}"),
    }
}

/// Rounds to `digits` significant decimal digits; what is not finite stays.
pub fn significant(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1))
        .parse()
        .unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits_without_rows_of_zeros() {
        let told = [
            0.0,
            -0.25,
            1e-3,
            1234.5,
            2.977_733e-9,
            -1.5e7,
            f64::INFINITY,
        ]
        .map(number);
        assert_eq!(
            told,
            [
                "0",
                "-0.25",
                "0.001",
                "1234.5",
                "2.977733e-9",
                "-1.5e7",
                "inf"
            ]
        );
    }

    /// Half a unit rounds as text does; signs, zeros and infinities stay.
    #[test]
    fn significant_digits_do_not_depend_on_the_size() {
        let rounded = [0.0, -123456.0, 1.23456e-9, f64::NEG_INFINITY].map(|x| significant(x, 3));
        assert_eq!(rounded, [0.0, -123000.0, 1.23e-9, f64::NEG_INFINITY]);
        assert!(significant(f64::NAN, 3).is_nan());
    }
}
