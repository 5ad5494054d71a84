//! Rollers that share the hand-over: what they take from sideways motion, and its ripple (docs/tread.md).

use ilon::Run;
use nalgebra::{DMatrix, DVector};

use super::run;

/// What a steady run shows at the passing of rollers, from where it is steady.
#[derive(Clone, Copy, Debug)]
struct Ripple {
    /// Real over ideal motion along the way.
    ratio: f64,
    /// Amplitude of the robot's place along its way, in mm.
    body_mm: f64,
    /// Amplitude of the wheels' rates over their mean, the mean over the wheels, in %.
    wheels_percent: f64,
}

/// Amplitude of what goes as cos and sin of the phases beside a straight line in them.
fn amplitude(phases_rad: &[f64], values: &[f64]) -> f64 {
    let terms = DMatrix::from_fn(phases_rad.len(), 8, |row, term| {
        let phase = phases_rad[row];
        match term {
            0 => 1.0,
            1 => phase,
            2 => phase.cos(),
            3 => phase.sin(),
            4 => (2.0 * phase).cos(),
            5 => (2.0 * phase).sin(),
            6 => (3.0 * phase).cos(),
            _ => (3.0 * phase).sin(),
        }
    });
    let values = DVector::from_row_slice(values);
    let fitted = terms
        .svd(true, true)
        .solve(&values, 1e-12)
        .expect("phases that pass");
    fitted[2].hypot(fitted[3])
}

fn ripple(run: &Run, rollers: f64) -> Ripple {
    let steps: Vec<_> = run
        .trace
        .steps()
        .filter(|(record, _)| record.t_s >= 3.0)
        .collect();
    let wheels = steps[0].1.len();
    let angle = |(_, samples): &(&ilon::trace::Record, &[ilon::trace::WheelSample])| {
        samples
            .iter()
            .map(|sample| sample.angle_rad.abs())
            .sum::<f64>()
            / wheels as f64
    };
    let phases: Vec<f64> = steps.iter().map(|step| rollers * angle(step)).collect();
    let along: Vec<f64> = steps
        .iter()
        .map(|(record, _)| {
            let place = record.truth.pose.position_m();
            1e3 * place.norm()
        })
        .collect();
    let ideal: Vec<f64> = steps
        .iter()
        .map(|(record, _)| 1e3 * record.odometry_ideal.position_m().norm())
        .collect();
    let way = |places: &[f64]| places[places.len() - 1] - places[0];
    let of_wheel = |wheel: usize| {
        let phases: Vec<f64> = steps
            .iter()
            .map(|(_, samples)| rollers * samples[wheel].angle_rad.abs())
            .collect();
        let rates: Vec<f64> = steps
            .iter()
            .map(|(_, samples)| samples[wheel].rate_rad_s.abs())
            .collect();
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        amplitude(&phases, &rates) / mean
    };
    Ripple {
        ratio: way(&along) / way(&ideal),
        body_mm: amplitude(&phases, &along),
        wheels_percent: 100.0 * (0..wheels).map(of_wheel).sum::<f64>() / wheels as f64,
    }
}

#[test]
fn the_robot_of_optiodom_falls_short_and_ripples_as_measured() {
    let of = |name: &str, settings: &[&str]| ripple(&run(name, settings), 8.0);
    let rigid = [
        "rollers.rolling_resistance=0",
        "rollers.tread.stiffness_n_m=1e9",
    ];
    for name in ["optiodom_lateral", "optiodom_forward"] {
        println!("{name}: {:?}", of(name, &[]));
        println!("  near to rigid {:?}", of(name, &rigid));
    }
}
