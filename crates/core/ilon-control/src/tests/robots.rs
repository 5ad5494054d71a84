//! Hand-built robots for tests: the two of the physics notes, a six-wheel one, and arbitrary
//! arrangements.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use ilon_robot::{
    Barrel, Chassis, Joint, MassProperties, MotorLimits, Robot, Roller, Wheel, wrap_angle,
};
use nalgebra::{Isometry3, Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

/// Geometry of a wheel of a hand-built robot.
#[derive(Clone, Copy, Debug)]
pub struct WheelSpec {
    /// Centre in the body frame, in metres.
    pub x_m: f64,
    /// Centre in the body frame, in metres.
    pub y_m: f64,
    /// Direction of the hub axis from the body's x axis, in radians.
    pub axis_rad: f64,
    /// The paper's rho, in metres.
    pub radius_m: f64,
    /// The paper's gamma, signed, in radians.
    pub gamma_rad: f64,
    /// Rollers per row.
    pub rollers: usize,
    /// Number of rows; two rows are half a pitch apart and 0.02 m from each other along the hub
    /// axis.
    pub rows: usize,
}

impl WheelSpec {
    /// A wheel of radius 0.05 m with `rollers` rollers in one row.
    pub fn new(x_m: f64, y_m: f64, axis_rad: f64, gamma_rad: f64, rollers: usize) -> Self {
        Self {
            x_m,
            y_m,
            axis_rad,
            radius_m: 0.05,
            gamma_rad,
            rollers,
            rows: 1,
        }
    }

    /// Largest radius of its rollers: the 0.012 m of the physics notes, scaled with the wheel.
    fn roller_radius_m(&self) -> f64 {
        0.24 * self.radius_m
    }

    fn wheel(&self, index: usize) -> Wheel {
        let n = Vector3::new(self.axis_rad.cos(), self.axis_rad.sin(), 0.0);
        let down = -Vector3::z();
        // Hub frame: x straight down, z along the hub axis n, y completes it (y = n x down = -u).
        let rotation =
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[down, n.cross(&down), n]));
        let body_from_hub = Isometry3::from_parts(
            Vector3::new(self.x_m, self.y_m, self.radius_m).into(),
            UnitQuaternion::from_rotation_matrix(&rotation),
        );
        let (sg, cg) = self.gamma_rad.sin_cos();
        let barrel = Barrel::handing_over(
            self.radius_m,
            self.roller_radius_m(),
            self.gamma_rad,
            self.rollers * self.rows,
        );
        let (length_m, r_m) = (2.0 * barrel.half_length_m, self.roller_radius_m());
        let mut rollers: Vec<Roller> = (0..self.rollers * self.rows)
            .map(|j| {
                let place = TAU * j as f64 / (self.rollers * self.rows) as f64;
                let row = (j % self.rows) as f64 - 0.5 * (self.rows - 1) as f64;
                let (s, c) = place.sin_cos();
                Roller {
                    name: format!("wheel_{index}_roller_{j}"),
                    center_in_hub_m: Vector3::new(
                        barrel.ring_radius_m * c,
                        barrel.ring_radius_m * s,
                        0.02 * row,
                    ),
                    // At the bottom the axis is n_gamma = -sin(gamma) n - cos(gamma) u, and u = -y
                    // of the hub frame.
                    axis_in_hub: Unit::new_normalize(Vector3::new(-cg * s, cg * c, -sg)),
                    radius_m: r_m,
                    length_m,
                    mass_kg: 0.01,
                    axial_inertia_kg_m2: 0.5 * 0.01 * 0.009 * 0.009,
                    transverse_inertia_kg_m2: 0.01 * (3.0 * 0.009 * 0.009 + length_m * length_m)
                        / 12.0,
                    joint: Joint::default(),
                    form: ilon_robot::RollerForm::Barrel,
                }
            })
            .collect();
        rollers.sort_by(|a, b| wrap_angle(a.place_rad()).total_cmp(&wrap_angle(b.place_rad())));
        let across = 0.25 * (3.0 * 0.03 * 0.03 + 0.04 * 0.04) / 12.0;
        Wheel {
            name: format!("wheel_{index}"),
            carrier: None,
            body_from_hub,
            hub: MassProperties {
                mass_kg: 0.25,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(
                    across,
                    across,
                    0.5 * 0.25 * 0.03 * 0.03,
                )),
            },
            radius_m: self.radius_m,
            gamma_rad: self.gamma_rad,
            rollers,
            motor: MotorLimits::default(),
            joint: Joint::default(),
            drive: ilon_robot::DriveTrain::default(),
            surface: ilon_robot::RollerSurface::default(),
            material: None,
            made: ilon_robot::RollersAsMade::default(),
        }
    }
}

/// A robot with these wheels and a chassis of `mass_kg`, 0.4 m by 0.24 m.
pub fn robot(mass_kg: f64, wheels: &[WheelSpec]) -> Robot {
    let (l, w, h) = (0.40, 0.24, 0.10);
    let inertia = mass_kg / 12.0 * Vector3::new(w * w + h * h, l * l + h * h, l * l + w * w);
    Robot {
        name: "made by hand".to_owned(),
        chassis: Chassis {
            name: "base".to_owned(),
            mass: MassProperties {
                mass_kg,
                center_of_mass_m: Vector3::new(0.0, 0.0, 0.06),
                inertia_kg_m2: Matrix3::from_diagonal(&inertia),
            },
            collisions: Vec::new(),
        },
        joints: Vec::new(),
        couplings: Vec::new(),
        wheels: wheels.iter().enumerate().map(|(i, w)| w.wheel(i)).collect(),
        remarks: Vec::new(),
    }
}

/// The mecanum robot's wheels with a given handedness: +1 gives the lever arm 0.15 + 0.16, -1 the
/// difference.
pub fn mecanum4_specs(handedness: f64) -> Vec<WheelSpec> {
    [
        (0.15, 0.16, 1.0),
        (0.15, -0.16, -1.0),
        (-0.15, 0.16, -1.0),
        (-0.15, -0.16, 1.0),
    ]
    .iter()
    .map(|&(x, y, side)| WheelSpec::new(x, y, PI / 2.0, side * handedness * FRAC_PI_4, 9))
    .collect()
}

/// Robot A: mecanum, rho = 0.05 m, hubs at (+-0.15, +-0.16) m, nine rollers per wheel.
pub fn mecanum4() -> Robot {
    robot(10.0, &mecanum4_specs(MECANUM_HANDEDNESS))
}

/// The handedness that gives M the rows (1, -1, -0.31)/sqrt 2 and their kin: for the front left
/// wheel, n_gamma = R(90 deg + gamma) n with n = +y is (-cos gamma, -sin gamma), and -n_gamma must
/// be (1, -1)/sqrt 2.
pub const MECANUM_HANDEDNESS: f64 = -1.0;

/// Robot B: three wheels at 120 deg, |b| = 0.25 m, rho = 0.05 m, gamma = 0, eight rollers per
/// wheel.
pub fn volksbot() -> Robot {
    let wheels: Vec<_> = (0..3)
        .map(|i| {
            let a = TAU * f64::from(i) / 3.0;
            WheelSpec::new(0.25 * a.cos(), 0.25 * a.sin(), a, 0.0, 8)
        })
        .collect();
    robot(8.0 - 3.0 * 0.33, &wheels)
}

/// Six wheels on a circle of 0.3 m, gamma = +-30 deg in alternation.
pub fn six_wheels() -> Robot {
    let wheels: Vec<_> = (0..6)
        .map(|i| {
            let a = TAU * f64::from(i) / 6.0;
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            WheelSpec::new(0.3 * a.cos(), 0.3 * a.sin(), a, side * PI / 6.0, 10)
        })
        .collect();
    robot(15.0, &wheels)
}
