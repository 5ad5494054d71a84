//! Formats numbers with units for the reader.

use ilon_trace::Header;
use ilon_trace::quantities::{self, Quantity};

/// Returns a number with a number of decimals, without the sign of a zero.
pub(super) fn decimals(x: f64, count: usize) -> String {
    let text = format!("{x:.count$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.to_owned(),
        _ => text,
    }
}

/// Returns the words for a robot on tyres alone, or those for one with rollers.
pub(super) fn by_kind(
    header: &Header,
    on_tyres: &'static str,
    with_rollers: &'static str,
) -> &'static str {
    if header.is_on_tyres() {
        on_tyres
    } else {
        with_rollers
    }
}

/// Capitalises the start of a sentence.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// Returns a length as text: metres, or millimetres below one.
pub(super) fn length(x_m: f64) -> String {
    let size_m = x_m.abs();
    if !x_m.is_finite() {
        "not finite".to_owned()
    } else if size_m >= 1.0 {
        format!("{x_m:.3} m")
    } else if size_m >= 0.1 {
        format!("{:.1} mm", 1e3 * x_m)
    } else if size_m >= 1e-3 {
        format!("{:.2} mm", 1e3 * x_m)
    } else if size_m >= 1e-6 {
        format!("{:.3} mm", 1e3 * x_m)
    } else {
        "0 mm".to_owned()
    }
}

/// Smallest relative uncertainty of a figure: the change at half the step can be small by chance,
/// while another figure moves more.
const KNOWN_AT_BEST: f64 = 1e-3;

/// Returns a length with as many digits as its uncertainty, in metres, justifies.
pub(super) fn length_known(x_m: f64, floor_m: f64) -> String {
    match x_m.abs() >= 1.0 {
        true => format!("{} m", decimals(x_m, borne(x_m, floor_m, 3))),
        false => format!(
            "{} mm",
            decimals(1e3 * x_m, borne(1e3 * x_m, 1e3 * floor_m, 2))
        ),
    }
}

/// Returns a length with as many digits as its uncertainty justifies, in metres, if that is known.
pub(super) fn length_to(x_m: f64, floor_m: Option<f64>) -> String {
    match floor_m {
        Some(floor_m) if x_m.abs() > floor_m => length_known(x_m, floor_m),
        _ => length(x_m),
    }
}

/// Returns an angle in degrees with as many digits as its uncertainty, in radians, justifies.
pub(super) fn angle_known(x_rad: f64, floor_rad: f64) -> String {
    let [x_deg, floor_deg] = [x_rad, floor_rad].map(f64::to_degrees);
    format!("{}°", decimals(x_deg, borne(x_deg, floor_deg, 3)))
}

/// Returns the number of decimals that the uncertainty of a figure justifies, at most `most`.
pub(super) fn borne(x: f64, floor: f64, most: usize) -> usize {
    let floor = floor.max(KNOWN_AT_BEST * x.abs());
    let places = -floor.max(f64::MIN_POSITIVE).log10().floor();
    places.clamp(0.0, most as f64) as usize
}

/// Returns an angle as text, in degrees.
pub(super) fn angle(x_rad: f64) -> String {
    let x_deg = x_rad.to_degrees();
    let places = if x_deg.abs() >= 1.0 { 2 } else { 3 };
    format!("{}°", decimals(x_deg, places))
}

/// Returns a time as text.
pub(super) fn time(x_s: f64) -> String {
    format!("{x_s:.2} s")
}

/// Returns a part of a whole as text.
pub(super) fn percent(x: f64) -> String {
    let x_pct = 100.0 * x;
    if x_pct.abs() >= 0.05 || x_pct == 0.0 {
        format!("{x_pct:.1} %")
    } else {
        "less than 0.05 %".to_owned()
    }
}

/// Returns a force as text.
pub(super) fn force(x_n: f64) -> String {
    match x_n.abs() {
        size_n if size_n >= 1000.0 => format!("{x_n:.0} N"),
        size_n if size_n >= 0.1 => format!("{x_n:.1} N"),
        _ => format!("{} N", decimals(x_n, 3)),
    }
}

/// Returns a speed as text.
pub(super) fn speed(x_m_s: f64) -> String {
    if x_m_s.abs() >= 1.0 {
        format!("{x_m_s:.3} m/s")
    } else if x_m_s.abs() >= 0.1 {
        format!("{:.0} mm/s", 1e3 * x_m_s)
    } else {
        format!("{} mm/s", decimals(1e3 * x_m_s, 2))
    }
}

/// Returns an energy as text.
pub(super) fn energy(x_j: f64) -> String {
    energy_to(x_j, None)
}

/// Returns an energy with as many digits as its uncertainty justifies, in J, if that is known.
pub(super) fn energy_to(x_j: f64, floor_j: Option<f64>) -> String {
    let most = if x_j.abs() >= 0.1 { 2 } else { 3 };
    let places = floor_j.map_or(most, |floor_j| borne(x_j, floor_j, most));
    format!("{} J", decimals(x_j, places))
}

/// Returns the text for a part of the energy balance, or for any other quantity, by its key.
pub(super) fn label(key: &str) -> &'static str {
    quantities::by_key(key).map_or("", |quantity| quantity.label)
}

/// Rounds up to 1, 2 or 5 times a power of ten; 1 for zero.
pub(crate) fn round_up(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return 1.0;
    }
    let power = 10f64.powf(x.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let step = steps.into_iter().find(|step| step * power >= x);
    ilon_trace::significant(step.unwrap_or(10.0) * power, 2)
}

/// Rounds down to 1, 2 or 5 times a power of ten.
pub(crate) fn round_down(x: f64) -> f64 {
    1.0 / round_up(1.0 / x)
}

/// A quantity's name as a sentence has it: "rms position error", "energy lost to sliding".
pub(crate) fn spoken(quantity: &Quantity) -> String {
    let words = quantity.words();
    if quantity.key == "energy.slip_j" {
        return "energy lost to sliding, without spin-up".to_owned();
    }
    if let Some((group, label)) = words.split_once(": ") {
        let group = match quantity.unit.symbol {
            "J" => "energy",
            _ => group,
        };
        return format!("{group} {label}");
    }
    match words.split_once(", ") {
        Some((what, which @ ("rms" | "largest"))) => format!("{which} {what}"),
        Some((what, when)) => format!("{what} {when}"),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even if a run hardly changes at half its step, the effect of a cause has at most four
    /// digits.
    #[test]
    fn no_figure_of_a_cause_has_more_digits_than_are_known() {
        assert_eq!(length_known(0.161_069, 4e-5), "161.1 mm");
        assert_eq!(length_known(0.161_069, 0.0), "161.1 mm");
        assert_eq!(length_known(0.030_802, 4e-6), "30.80 mm");
        assert_eq!(length_known(0.002_47, 1e-3), "2 mm");
        assert_eq!(angle_known(-1.234_567, 0.0), "-70.74°");
    }

    #[test]
    fn what_is_shown_as_zero_has_no_sign() {
        for (x, count, shown) in [
            (-4.9e-6, 5, "0.00000"),
            (-5.1e-6, 5, "-0.00001"),
            (-0.0, 0, "0"),
            (-0.4, 0, "0"),
            (-0.6, 0, "-1"),
            (10.0, 1, "10.0"),
        ] {
            assert_eq!(decimals(x, count), shown);
        }
        assert_eq!(angle(-1e-6), "0.000°");
        assert_eq!(energy(-1e-5), "0.000 J");
        assert_eq!(force(-1e-5), "0.000 N");
        assert_eq!(speed(-1e-6), "0.00 mm/s");
        assert_eq!(speed(-1e-5), "-0.01 mm/s");
    }

    #[test]
    fn a_speed_is_in_metres_from_one_metre_a_second_on() {
        for (x_m_s, shown) in [
            (1.05, "1.050 m/s"),
            (-1.0, "-1.000 m/s"),
            (0.99, "990 mm/s"),
            (0.1, "100 mm/s"),
            (-0.0999, "-99.90 mm/s"),
        ] {
            assert_eq!(speed(x_m_s), shown);
        }
    }

    #[test]
    fn a_quantity_is_said_as_a_person_says_it() {
        for (key, said) in [
            ("position_error_rms_m", "rms position error"),
            ("slip_speed_max_m_s", "largest sliding speed"),
            ("position_error_final_m", "position error at the end"),
            ("slip_energy_j", "energy lost to sliding"),
            ("wheel_torque_max_n_m", "largest torque"),
        ] {
            let quantity = quantities::by_key(key).expect("a quantity");
            assert_eq!(spoken(quantity), said);
        }
    }

    /// A step of 1, 2 or 5 times a power of ten on either side, and the number itself if it is one.
    #[test]
    fn steps_are_round_numbers_on_either_side() {
        for (x, below, above) in [
            (0.03, 0.02, 0.05),
            (7.0, 5.0, 10.0),
            (160.0, 100.0, 200.0),
            (0.2, 0.2, 0.2),
            (5.0, 5.0, 5.0),
        ] {
            assert_eq!((round_down(x), round_up(x)), (below, above));
        }
    }
}
