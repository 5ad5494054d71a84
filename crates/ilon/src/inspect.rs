//! A robot as it is understood: what `ilon inspect` prints.

use ilon_control::Kinematics;
use ilon_robot::{Robot, Wheel};
use nalgebra::{Matrix2, MatrixXx3, Vector2};
use serde::Serialize;

/// A robot as it is understood, and what follows from where its wheels sit.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// The robot's name.
    pub name: String,
    /// Mass of the whole robot, in kg.
    pub mass_kg: f64,
    /// The driven wheels.
    pub wheels: Vec<WheelInspection>,
    /// The rows of M, Indiveri 2009, equation (8): one a wheel; the last column in metres.
    #[serde(rename = "M")]
    pub m: Vec<[f64; 3]>,
    /// Rank of M: 3, or the robot cannot be controlled (Lemma 1).
    pub rank: usize,
    /// Singular values of M, largest first.
    pub singular_values: Vec<f64>,
    /// What is wrong with the arrangement of the wheels, if anything is.
    pub singularity: Option<String>,
    /// Whether position and heading do not disturb each other about the body's origin: M_a orthogonal to span(M_l).
    pub decoupled: bool,
    /// The point of the body frame about which they never do, in metres; `None` where there is none.
    pub decoupling_point_m: Option<[f64; 2]>,
    /// How fast the robot can be within its wheels' rates; `None` where they have no limit.
    pub speed_limits: Option<SpeedLimits>,
    /// What of the file was ignored, assumed or doubted.
    pub remarks: Vec<String>,
}

/// A wheel as it is understood.
#[derive(Clone, Debug, Serialize)]
pub struct WheelInspection {
    /// The name of its joint.
    pub name: String,
    /// Its centre in the body frame, in metres.
    pub position_m: [f64; 3],
    /// Its hub axis in the body frame, in the ground plane.
    pub axis: [f64; 2],
    /// Its radius, in metres.
    pub radius_m: f64,
    /// The angle from its hub axis to the rolling direction of its lowest roller, in radians, signed.
    pub gamma_rad: f64,
    /// How many rollers it carries.
    pub rollers: usize,
    /// The largest radius of its rollers, in metres.
    pub roller_radius_m: f64,
    /// The length of its rollers, in metres.
    pub roller_length_m: f64,
    /// Mass with its rollers, in kg.
    pub mass_kg: f64,
    /// The largest torque of its motor, in N m; `None` where the file sets none.
    pub effort_n_m: Option<f64>,
    /// The largest rate of its motor, in rad/s; `None` where the file sets none.
    pub velocity_rad_s: Option<f64>,
}

/// How fast a robot can be within the rates of its wheels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SpeedLimits {
    /// The rate that no wheel exceeds, in rad/s.
    pub wheel_rate_rad_s: f64,
    /// Top speed in the slowest direction, without turning, in m/s.
    pub slowest_direction_m_s: f64,
    /// Top speed in the fastest direction, without turning, in m/s.
    pub fastest_direction_m_s: f64,
    /// Top yaw rate on the spot, in rad/s.
    pub yaw_rate_rad_s: f64,
}

impl Inspection {
    /// Looks at a robot.
    pub fn of(robot: &Robot) -> Self {
        let m: Vec<[f64; 3]> = robot.wheels.iter().map(m_row).collect();
        let kinematics = Kinematics::new(robot);
        let singular_values = singular_values(&m);
        let decoupling_point = decoupling_point_m(&robot.wheels);
        // The origin itself decouples if M_l^T M_a is zero, up to the rounding of coordinates in a file (1e-6 m).
        let coupling = m.iter().fold(Vector2::zeros(), |sum, [x, y, a]| {
            sum + Vector2::new(x * a, y * a)
        });
        let finite = |x: f64| x.is_finite().then_some(x);
        Self {
            name: robot.name.clone(),
            mass_kg: robot.mass_kg(),
            wheels: robot.wheels.iter().map(WheelInspection::of).collect(),
            rank: match kinematics {
                Ok(_) => 3,
                Err(_) => singular_values
                    .iter()
                    .filter(|value| **value > 1e-4 * singular_values[0])
                    .count(),
            },
            singular_values,
            singularity: kinematics.as_ref().err().map(ToString::to_string),
            decoupled: coupling.norm() < 1e-6 * m.len() as f64,
            decoupling_point_m: decoupling_point.map(|d| [d.x, d.y]),
            speed_limits: finite(robot.wheel_rate_limit_rad_s())
                .zip(kinematics.ok())
                .map(|(limit_rad_s, kinematics)| {
                    SpeedLimits::of(kinematics.rate_matrix(), limit_rad_s)
                }),
            remarks: robot
                .remarks
                .iter()
                .map(|remark| format!("{}: {}", remark.subject, remark.text))
                .collect(),
            m,
        }
    }
}

impl WheelInspection {
    fn of(wheel: &Wheel) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let largest =
            |of: fn(&ilon_robot::Roller) -> f64| wheel.rollers.iter().map(of).fold(0.0, f64::max);
        let rollers_kg: f64 = wheel.rollers.iter().map(|roller| roller.mass_kg).sum();
        Self {
            name: wheel.name.clone(),
            position_m: wheel.position_m().into(),
            axis: wheel.axis().into(),
            radius_m: wheel.radius_m,
            gamma_rad: wheel.gamma_rad,
            rollers: wheel.rollers.len(),
            roller_radius_m: largest(|roller| roller.radius_m),
            roller_length_m: largest(|roller| roller.length_m),
            mass_kg: wheel.hub.mass_kg + rollers_kg,
            effort_n_m: finite(wheel.motor.effort_n_m),
            velocity_rad_s: finite(wheel.motor.velocity_rad_s),
        }
    }
}

impl SpeedLimits {
    /// From the matrix of equation (9): rates = matrix * twist.
    fn of(rate_matrix: &MatrixXx3<f64>, limit_rad_s: f64) -> Self {
        let fastest_wheel = |x: f64, y: f64, omega: f64| {
            rate_matrix
                .row_iter()
                .map(|row| (row[0] * x + row[1] * y + row[2] * omega).abs())
                .fold(0.0, f64::max)
        };
        // Top speed by direction has its least and greatest values at corners and edges of a polygon; a tenth of a
        // degree finds them to 1 - cos(0.05 deg), 4e-7 of their value.
        let speeds_m_s = (0..3600).map(|tenth| {
            let (s, c) = (f64::from(tenth) * 0.1).to_radians().sin_cos();
            limit_rad_s / fastest_wheel(c, s, 0.0)
        });
        Self {
            wheel_rate_rad_s: limit_rad_s,
            slowest_direction_m_s: speeds_m_s.clone().fold(f64::INFINITY, f64::min),
            fastest_direction_m_s: speeds_m_s.fold(0.0, f64::max),
            yaw_rate_rad_s: limit_rad_s / fastest_wheel(0.0, 0.0, 1.0),
        }
    }
}

/// A row of M, Indiveri 2009, equation (8): -(n_gamma, b . u_gamma).
fn m_row(wheel: &Wheel) -> [f64; 3] {
    let (n_g, u_g) = (wheel.roller_axis(), wheel.roller_rolling_direction());
    let b = wheel.position_m().xy();
    [-n_g.x, -n_g.y, -b.dot(&u_g)]
}

fn singular_values(m: &[[f64; 3]]) -> Vec<f64> {
    let rows: Vec<_> = m
        .iter()
        .map(|row| nalgebra::RowVector3::from(*row))
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let mut values: Vec<f64> = MatrixXx3::from_rows(&rows)
        .singular_values()
        .iter()
        .copied()
        .collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// The point d about which M_a is orthogonal to span(M_l): d = (sum n_g u_g^T)^-1 sum n_g (b . u_g), in the body frame.
///
/// About d, row h of M_a is -(b_h - d) . u_g,h, and M_l^T M_a = sum n_g ((b - d) . u_g) = 0 is linear in d.
fn decoupling_point_m(wheels: &[Wheel]) -> Option<Vector2<f64>> {
    let mut matrix = Matrix2::zeros();
    let mut right = Vector2::zeros();
    for wheel in wheels {
        let (n_g, u_g) = (wheel.roller_axis(), wheel.roller_rolling_direction());
        matrix += n_g * u_g.transpose();
        right += n_g * wheel.position_m().xy().dot(&u_g);
    }
    // n_g and u_g are unit vectors: the determinant of a sum over N of them is below N^2, and rounding 1e-16 of that.
    if matrix.determinant().abs() < 1e-9 {
        return None;
    }
    Some(matrix.try_inverse()? * right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speeds_of_the_paper_follow_from_three_wheels_at_120_degrees() {
        // Indiveri 2009, section IV: rho 5 cm, |b| 25 cm, gamma 0, 8.7 rad/s: 99.7 deg/s and about 0.5 m/s. With
        // gamma = 0 a row of equation (9) is (sin t, -cos t, -0.25)/0.05 or its negative, so that the yaw rate is
        // 8.7 * 0.05 / 0.25 rad/s, and the speed lies between 8.7 * 0.05 (along a wheel's rolling direction) and
        // that over cos 30 deg (across a wheel's).
        let rows: Vec<_> = [0.0_f64, 120.0, 240.0]
            .iter()
            .map(|deg| {
                let (s, c) = deg.to_radians().sin_cos();
                nalgebra::RowVector3::new(s, -c, -0.25) / 0.05
            })
            .collect();
        let limits = SpeedLimits::of(&MatrixXx3::from_rows(&rows), 8.7);
        assert!((limits.yaw_rate_rad_s.to_degrees() - 99.7).abs() < 0.05);
        assert!((limits.slowest_direction_m_s - 0.435).abs() < 1e-6);
        assert!((limits.fastest_direction_m_s - 0.435 / 30f64.to_radians().cos()).abs() < 1e-6);
    }
}
