//! The law of a planar base, and its error.

use nalgebra::{Matrix3, Vector3};

use super::DriveError;
use super::drives::PlanarDrive;

/// The acceleration of a constant velocity in a rotating frame: omega x v.
fn carried(v: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.z * v.y, v.z * v.x, 0.0)
}

/// The law of the wheel loops within the acceleration limits.
pub(super) struct Law {
    pub shortfall: Matrix3<f64>,
    pub proportional_per_s: Vector3<f64>,
    pub integral_per_s2: Vector3<f64>,
    pub most: Vector3<f64>,
    pub exponent: f64,
    pub step_s: f64,
}

/// The share of the acceleration limits that an acceleration uses.
pub(super) fn taken(a: Vector3<f64>, most: Vector3<f64>, exponent: f64) -> f64 {
    let shares = a.component_div(&most);
    let sum: f64 = shares
        .iter()
        .map(|share| libm::pow(share.abs(), exponent))
        .sum();
    libm::pow(sum, 1.0 / exponent)
}

impl Law {
    /// The twists that follow the commands from rest.
    pub fn follow(&self, asked: &[Vector3<f64>], dt_s: f64) -> Vec<Vector3<f64>> {
        let parts = (dt_s / self.step_s).ceil().max(1.0);
        let h_s = dt_s / parts;
        let (mut v, mut z) = (Vector3::zeros(), Vector3::zeros());
        let mut came = Vec::with_capacity(asked.len());
        for asked in asked {
            let target = self.shortfall * asked;
            for _ in 0..parts as usize {
                let e = target - v;
                let loops = self.proportional_per_s.component_mul(&e)
                    + self.integral_per_s2.component_mul(&z);
                let wanted = loops + carried(v);
                let taken = taken(wanted, self.most, self.exponent);
                if taken <= 1.0 {
                    z += h_s * e;
                }
                v += h_s * (wanted / taken.max(1.0) - carried(v));
            }
            came.push(v);
        }
        came
    }
}

/// Integrates twists from the origin: x, y and heading after each.
pub(super) fn poses(twists: &[Vector3<f64>], dt_s: f64) -> Vec<Vector3<f64>> {
    let mut pose: Vector3<f64> = Vector3::zeros();
    let step = |twist: &Vector3<f64>| {
        let (sin, cos) = libm::sincos(pose.z + 0.5 * dt_s * twist.z);
        pose += dt_s
            * Vector3::new(
                cos * twist.x - sin * twist.y,
                sin * twist.x + cos * twist.y,
                twist.z,
            );
        pose
    };
    twists.iter().map(step).collect()
}

/// The error of a model over several drives.
pub(super) fn error(
    drives: &[PlanarDrive],
    dt_s: f64,
    model: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
) -> DriveError {
    let (mut squares, mut samples) = (Vector3::zeros(), 0);
    let (mut position, mut heading) = (0.0, 0.0);
    for drive in drives {
        let modelled = model(&drive.asked);
        for (modelled, came) in modelled.iter().zip(&drive.came) {
            let off = modelled - came;
            squares += off.component_mul(&off);
        }
        samples += modelled.len();
        let ends = [&modelled, &drive.came].map(|twists| poses(twists, dt_s).pop());
        let off = ends[0].unwrap_or_default() - ends[1].unwrap_or_default();
        let path_m: f64 = drive.came.iter().map(|v| v.xy().norm() * dt_s).sum();
        position += off.xy().norm() / path_m;
        heading += off.z * off.z;
    }
    let count = drives.len() as f64;
    DriveError {
        twist_rms: (squares / samples as f64).map(libm::sqrt).into(),
        position_over_path: position / count,
        heading_rms_rad: libm::sqrt(heading / count),
    }
}

#[cfg(test)]
mod tests;
