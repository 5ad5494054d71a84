//! Ground that tilts over time: the rotation of the floor against gravity.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use ilon_scenario::scenario::Fault;

/// The tilts of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tilts(Vec<Fault>);

impl Tilts {
    pub fn new(faults: &[Fault]) -> Self {
        let tilts = faults.iter();
        let tilts = tilts.filter(|fault| matches!(fault, Fault::Tilt { .. }));
        Self(tilts.cloned().collect())
    }

    /// Whether the ground ever tilts.
    pub fn is_any(&self) -> bool {
        !self.0.is_empty()
    }

    /// The rotation of the floor at a time in seconds, relative to the floor without tilts.
    pub fn turned(&self, t_s: f64) -> UnitQuaternion<f64> {
        self.0
            .iter()
            .map(|fault| turned_by(fault, t_s))
            .fold(UnitQuaternion::identity(), |all, one| all * one)
    }
}

/// The rotation by one tilt: about the axis to the left of the direction that goes down.
fn turned_by(fault: &Fault, t_s: f64) -> UnitQuaternion<f64> {
    let &Fault::Tilt {
        amplitude_deg,
        frequency_hz,
        direction_deg,
        ramp_s,
        from_s,
        until_s,
    } = fault
    else {
        return UnitQuaternion::identity();
    };
    let since_s = t_s - from_s;
    let left_s = until_s.map_or(f64::INFINITY, |until_s| until_s - t_s);
    if since_s < 0.0 || left_s < 0.0 {
        return UnitQuaternion::identity();
    }
    let wave = match frequency_hz > 0.0 {
        true => libm::sin(TAU * frequency_hz * since_s),
        false => 1.0,
    };
    let angle_rad = amplitude_deg.to_radians() * wave * built_up(since_s.min(left_s), ramp_s);
    let (sin, cos) = libm::sincos(direction_deg.to_radians());
    UnitQuaternion::from_scaled_axis(angle_rad * Vector3::new(-sin, cos, 0.0))
}

/// From 0 to 1 over a ramp, with zero rate at both ends.
pub(crate) fn built_up(since_s: f64, ramp_s: f64) -> f64 {
    if since_s >= ramp_s {
        return 1.0;
    }
    let x = since_s / ramp_s;
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilts(toml: &str) -> Tilts {
        #[derive(serde::Deserialize)]
        struct Section {
            faults: Vec<Fault>,
        }
        let section: Section = toml::from_str(toml).expect("faults");
        Tilts::new(&section.faults)
    }

    /// Gravity in the floor's frame leans towards the direction that goes down.
    #[test]
    fn the_ground_goes_down_where_it_is_said_to() {
        let leaning = tilts(
            "[[faults]]\ntilt = { amplitude_deg = 30, direction_deg = 90, from_s = 1, until_s = 5, ramp_s = 1 }",
        );
        let down = |t_s| leaning.turned(t_s).inverse() * -Vector3::z();
        assert_eq!(down(0.9), -Vector3::z());
        // Half of the ramp is half of the angle.
        for (t_s, angle_deg) in [(1.5, 15.0_f64), (2.0, 30.0), (3.0, 30.0), (4.5, 15.0)] {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            assert!((down(t_s) - Vector3::new(0.0, sin, -cos)).norm() < 1e-15);
        }
        assert_eq!(down(5.1), -Vector3::z());
        let rocking = tilts("[[faults]]\ntilt = { amplitude_deg = 4, frequency_hz = 0.5 }");
        let at = |t_s| (rocking.turned(t_s).inverse() * -Vector3::z()).x;
        assert!((at(0.5) - 4_f64.to_radians().sin()).abs() < 1e-15);
        assert!((at(1.5) + 4_f64.to_radians().sin()).abs() < 1e-15);
        assert!(rocking.is_any() && !tilts("faults = []").is_any());
    }
}
