//! Selects the controller that can drive a robot, and computes its parameters.

use std::f64::consts::{FRAC_PI_2, TAU};

use ilon_control::{ContactKinematics, ControlError, Kinematics};
use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::{MatrixXx3, Rotation2, RowVector2, RowVector3, Vector2};

/// Tolerance of the geometry that a controller assumes, as a share; chosen, as files are rounded
/// and robots are measured by hand.
const WITHIN: f64 = 0.01;
/// Number of samples of wheel angles for means; chosen.
const SAMPLES: usize = 4096;

/// A controller of ros2_controllers with its geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Controller {
    /// `mecanum_drive_controller/MecanumDriveController`.
    Mecanum {
        /// The wheel joints: front left, front right, rear right, rear left.
        wheels: [String; 4],
        /// `kinematics.wheels_radius`, in metres.
        wheels_radius_m: f64,
        /// `kinematics.sum_of_robot_center_projection_on_X_Y_axis`, in metres.
        center_sum_m: f64,
        /// `kinematics.base_frame_offset`: the position of the body frame relative to the wheels'
        /// centre, in metres, in the wheels' frame.
        base_frame_offset_m: [f64; 2],
        /// Its `theta`: the rotation of the body frame relative to the wheels' frame, whose x axis
        /// is their rolling direction, in radians.
        base_frame_offset_rad: f64,
    },
    /// `omni_wheel_drive_controller/OmniWheelDriveController`.
    Omni {
        /// The wheel joints, counter-clockwise.
        wheels: Vec<String>,
        /// `wheel_offset`: the angle of the first wheel from the x axis, in radians.
        wheel_offset_rad: f64,
        /// `robot_radius`, in metres.
        robot_radius_m: f64,
        /// `wheel_radius`, in metres.
        wheel_radius_m: f64,
    },
}

/// A controller, with the motions that it gives the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveParameters {
    /// The controller.
    pub controller: Controller,
    /// The geometric radius of the wheels, in metres.
    pub radius_m: f64,
    /// The real velocity per commanded 1 m/s ahead, 1 m/s to the left and 1 rad/s, each alone; the
    /// mean over all wheel angles, without slip.
    pub real_over_asked: [f64; 3],
    /// The wheel rates, in rad/s, that the controller commands for 1 m/s ahead, 1 m/s to the left
    /// and 1 rad/s: one row per wheel, in the robot's order.
    pub rates: MatrixXx3<f64>,
    /// The rate limits of the wheels, in rad/s, infinite for none.
    pub rate_limits_rad_s: Vec<f64>,
}

/// Why no controller of ros2_controllers can drive a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "neither mecanum_drive_controller nor omni_wheel_drive_controller can drive this robot: {mecanum}; {omni}"
)]
pub struct Unsuitable {
    /// Why the controller for mecanum wheels cannot.
    pub mecanum: String,
    /// Why the controller for omni wheels cannot.
    pub omni: String,
}

/// A controller's wheel rates for a twist: rows without the radius, the wheel positions that it
/// assumes, and its lever arm of yaw.
struct WheelRates {
    /// In the robot's order: the row times the radius, the last entry in metres.
    rows: Vec<RowVector3<f64>>,
    controller: fn(&WheelRates, radius_m: f64, lever: f64) -> Controller,
    wheels: Vec<String>,
    lever_m: f64,
    /// For omni wheels the angle of the first; for mecanum wheels that of the body frame in the
    /// wheels' frame.
    offset_rad: f64,
    /// The wheels' centre in the body frame.
    center_m: Vector2<f64>,
}

impl DriveParameters {
    /// The parameters of the controller that can drive a robot.
    ///
    /// # Errors
    /// If the robot cannot be controlled at all.
    pub fn of(robot: &Robot) -> Result<Result<Self, Unsuitable>, ControlError> {
        let kinematics = Kinematics::new(robot)?;
        let contact = ContactKinematics::new(robot)?;
        let radius_m = robot.mean_wheel_radius_m();
        let form = match suits(mecanum(&robot.wheels), &kinematics, radius_m) {
            Ok(form) => form,
            Err(mecanum) => match suits(omni(&robot.wheels), &kinematics, radius_m) {
                Ok(form) => form,
                Err(omni) => return Ok(Err(Unsuitable { mecanum, omni })),
            },
        };
        let mean = |rates: &[f64]| mean_twist(&contact, rates);
        let rates = |radius_m: f64, lever: f64| -> MatrixXx3<f64> {
            let row = |row: &RowVector3<f64>| {
                // The part of the last column from the centre's offset does not scale with the
                // lever.
                let center = row.x * -form.center_m.y + row.y * form.center_m.x;
                RowVector3::new(row.x, row.y, (row.z - center) * lever + center) / radius_m
            };
            MatrixXx3::from_rows(&form.rows.iter().map(row).collect::<Vec<_>>())
        };
        let gained = |rates: &MatrixXx3<f64>| -> [f64; 3] {
            let column = |k: usize| -> Vec<f64> { rates.column(k).iter().copied().collect() };
            [
                mean(&column(0)).vx_m_s,
                mean(&column(1)).vy_m_s,
                mean(&column(2)).omega_rad_s,
            ]
        };
        let by_shape = gained(&rates(radius_m, 1.0));
        // The radius that is right ahead, and the lever at which the yaw rate is then right.
        let is_omni = matches!((form.controller)(&form, 1.0, 1.0), Controller::Omni { .. });
        let ahead = if is_omni {
            0.5 * (by_shape[0] + by_shape[1])
        } else {
            by_shape[0]
        };
        let (rolling_m, lever) = (radius_m * ahead, ahead / by_shape[2]);
        let rates = rates(rolling_m, lever);
        Ok(Ok(Self {
            controller: (form.controller)(&form, rolling_m, lever),
            radius_m,
            real_over_asked: gained(&rates),
            rates,
            rate_limits_rad_s: robot
                .wheels
                .iter()
                .map(|wheel| wheel.motor.velocity_rad_s)
                .collect(),
        }))
    }

    /// The share of its rate limit that the busiest wheel uses for a twist; 0 without limits.
    pub fn share(&self, twist: Twist) -> f64 {
        let twist = nalgebra::Vector3::new(twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s);
        let shares = self.rates.row_iter().zip(&self.rate_limits_rad_s);
        shares
            .map(|(row, limit)| (row * twist).x.abs() / limit)
            .fold(0.0, f64::max)
    }

    /// Half the sides, in m/s, m/s and rad/s, of a box of twists, all within the wheels' limits.
    /// Its sides have the proportions of the top speeds along the axes. `None` without limits.
    pub fn box_within(&self) -> Option<[f64; 3]> {
        let top = |twist: Twist| 1.0 / self.share(twist);
        let tops = [
            top(Twist::new(1.0, 0.0, 0.0)),
            top(Twist::new(0.0, 1.0, 0.0)),
            top(Twist::new(0.0, 0.0, 1.0)),
        ];
        if !tops.iter().all(|top| top.is_finite()) {
            return None;
        }
        let corners = (0..8).map(|corner| {
            let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            self.share(Twist::new(
                sign(0) * tops[0],
                sign(1) * tops[1],
                sign(2) * tops[2],
            ))
        });
        let largest = corners.fold(1.0, f64::max);
        Some(tops.map(|top| top / largest))
    }
}

/// Returns the form if the robot's wheels match it.
fn suits(
    form: Result<WheelRates, String>,
    kinematics: &Kinematics,
    radius_m: f64,
) -> Result<WheelRates, String> {
    let form = form?;
    let size_m = form.lever_m;
    for ((wheel, row), real) in kinematics
        .wheels()
        .iter()
        .zip(&form.rows)
        .zip(kinematics.rate_matrix().row_iter())
    {
        let name = &wheel.name;
        if (wheel.radius_m / radius_m - 1.0).abs() > WITHIN {
            return Err(format!("its wheels differ in radius, such as `{name}`"));
        }
        let real = real * wheel.radius_m;
        let off = |sign: f64| {
            let d = real * sign - row;
            d.x.abs().max(d.y.abs()).max(d.z.abs() / size_m)
        };
        if off(1.0) > WITHIN {
            if off(-1.0) <= WITHIN {
                return Err(format!(
                    "its wheel `{name}` turns the other way than it takes it: turn the `<axis>` of its joint round"
                ));
            }
            return Err(format!(
                "its wheel `{name}` takes ({:.3}, {:.3}, {:.3} m) rad/s times its radius for vx, vy and yaw, where the controller \
                 takes ({:.3}, {:.3}, {:.3} m)",
                real.x, real.y, real.z, row.x, row.y, row.z
            ));
        }
    }
    Ok(form)
}

/// The mean position of wheels in the body frame.
fn center_m(wheels: &[Wheel]) -> Vector2<f64> {
    let sum: Vector2<f64> = wheels.iter().map(|wheel| wheel.position_m().xy()).sum();
    sum / wheels.len() as f64
}

/// Four wheels, one in each quarter, with rollers at 45 degrees. The rates are (1, -1, -L), (1, 1,
/// L), (1, -1, L), (1, 1, -L) over the radius for front left, front right, rear right, rear left,
/// in a frame whose x axis is the wheels' rolling direction.
fn mecanum(wheels: &[Wheel]) -> Result<WheelRates, String> {
    if wheels.len() != 4 {
        return Err(format!("it has {} wheels and not four", wheels.len()));
    }
    let center_m = center_m(wheels);
    let wheels_from_body = Rotation2::new(-heading_rad(wheels));
    let mut names: [Option<&Wheel>; 4] = [None; 4];
    let mut quarters = Vec::new();
    let at = |wheel: &Wheel| wheels_from_body * (wheel.position_m().xy() - center_m);
    for wheel in wheels {
        let at = at(wheel);
        let quarter = match (at.x > 0.0, at.y > 0.0) {
            (true, true) => 0,
            (true, false) => 1,
            (false, false) => 2,
            (false, true) => 3,
        };
        if names[quarter].replace(wheel).is_some() {
            return Err("its wheels do not stand one in each quarter".to_owned());
        }
        quarters.push(quarter);
    }
    let reach = |wheel: &Wheel| at(wheel).x.abs() + at(wheel).y.abs();
    let lever_m = wheels.iter().map(reach).sum::<f64>() / 4.0;
    let rows = quarters.iter().map(|quarter| {
        let (vy, yaw) = [(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)][*quarter];
        let linear = RowVector2::new(1.0, vy) * wheels_from_body.matrix();
        // About the body's origin: the velocity at the centre is v + omega x center.
        let center = -linear.x * center_m.y + linear.y * center_m.x;
        RowVector3::new(linear.x, linear.y, yaw * lever_m + center)
    });
    Ok(WheelRates {
        rows: rows.collect(),
        wheels: names
            .iter()
            .flatten()
            .map(|wheel| wheel.name.clone())
            .collect(),
        lever_m,
        offset_rad: wheels_from_body.angle(),
        center_m,
        controller: |form, radius_m, lever| {
            let center_m = Rotation2::new(form.offset_rad) * form.center_m;
            Controller::Mecanum {
                wheels: std::array::from_fn(|k| form.wheels[k].clone()),
                wheels_radius_m: radius_m,
                center_sum_m: form.lever_m * lever,
                base_frame_offset_m: [-center_m.x, -center_m.y],
                base_frame_offset_rad: form.offset_rad,
            }
        },
    })
}

/// The rolling direction of wheels with parallel axes, by the majority of them: the angle from the
/// body's x axis, in radians. Values within rounding count as zero.
fn heading_rad(wheels: &[Wheel]) -> f64 {
    /// Files round angles to four digits.
    const ROUNDED_RAD: f64 = 2e-3;
    let sum: Vector2<f64> = wheels
        .iter()
        .map(|wheel| Vector2::new(wheel.axis().y, -wheel.axis().x))
        .sum();
    let angle_rad = libm::atan2(sum.y, sum.x);
    let quarters = (angle_rad / FRAC_PI_2).round() * FRAC_PI_2;
    match (angle_rad - quarters).abs() < ROUNDED_RAD {
        true => quarters,
        false => angle_rad,
    }
}

/// Three or more wheels at even angles on a circle about the body's origin, with rollers across:
/// the rates are (sin a, -cos a, -R) over the radius for the wheel at angle a.
fn omni(wheels: &[Wheel]) -> Result<WheelRates, String> {
    let count = wheels.len();
    let robot_radius_m = wheels
        .iter()
        .map(|wheel| wheel.position_m().xy().norm())
        .sum::<f64>()
        / count as f64;
    let angle = |wheel: &Wheel| {
        let at = wheel.position_m();
        // The wheel straight ahead, to rounding, comes first.
        (libm::atan2(at.y, at.x) + 1e-6).rem_euclid(TAU) - 1e-6
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| angle(&wheels[*a]).total_cmp(&angle(&wheels[*b])));
    let apart_rad = TAU / count as f64;
    let mut rows = vec![RowVector3::zeros(); count];
    // The offset is the mean over what each wheel implies for the first.
    let offsets = order
        .iter()
        .enumerate()
        .map(|(k, wheel)| angle(&wheels[*wheel]) - apart_rad * k as f64);
    let offset_rad = offsets.sum::<f64>() / count as f64;
    for (k, wheel) in order.iter().enumerate() {
        let (sin, cos) = libm::sincos(offset_rad + apart_rad * k as f64);
        let at = wheels[*wheel].position_m().xy();
        let meant = Vector2::new(cos, sin) * robot_radius_m;
        if (at - meant).norm() > WITHIN * robot_radius_m {
            return Err(
                "its wheels do not stand at even angles on a circle about its origin".to_owned(),
            );
        }
        rows[*wheel] = RowVector3::new(sin, -cos, -robot_radius_m);
    }
    Ok(WheelRates {
        rows,
        wheels: order
            .iter()
            .map(|wheel| wheels[*wheel].name.clone())
            .collect(),
        lever_m: robot_radius_m,
        offset_rad,
        center_m: Vector2::zeros(),
        controller: |form, radius_m, lever| Controller::Omni {
            wheels: form.wheels.clone(),
            wheel_offset_rad: form.offset_rad,
            robot_radius_m: form.lever_m * lever,
            wheel_radius_m: radius_m,
        },
    })
}

/// The mean twist of wheel rates over all combinations of wheel angles, without slip.
fn mean_twist(contact: &ContactKinematics, rates_rad_s: &[f64]) -> Twist {
    let mut contact = contact.clone();
    let mut angles_rad = vec![0.0; rates_rad_s.len()];
    let mut sum = Twist::default();
    for sample in 0..SAMPLES {
        for (k, angle_rad) in angles_rad.iter_mut().enumerate() {
            // Kronecker's sequence with the roots of primes covers the angles evenly, and
            // identically on every machine.
            let step = libm::sqrt(PRIMES[k % PRIMES.len()]) + (k / PRIMES.len()) as f64 * 0.1;
            *angle_rad = TAU * (sample as f64 * step).fract();
        }
        sum = sum + contact.twist(&angles_rad, rates_rad_s);
    }
    sum.scaled(1.0 / SAMPLES as f64)
}

const PRIMES: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;
    use nalgebra::{Isometry3, Vector3};
    use std::f64::consts::PI;

    use super::*;

    fn robot(name: &str) -> Robot {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots/");
        Robot::load(format!("{folder}{name}.urdf")).unwrap()
    }

    #[test]
    fn a_mecanum_robot_rolls_ahead_on_its_radius_and_short_sideways() {
        let drive = DriveParameters::of(&robot("mecanum4")).unwrap().unwrap();
        let Controller::Mecanum {
            wheels,
            wheels_radius_m,
            base_frame_offset_m,
            ..
        } = &drive.controller
        else {
            panic!("{:?}", drive.controller);
        };
        assert!(
            wheels[0].contains("left") && wheels[0].contains("front"),
            "{wheels:?}"
        );
        // Ahead, a barrel rolls on the wheel's radius, whichever roller touches.
        assert!((wheels_radius_m / drive.radius_m - 1.0).abs() < 1e-4);
        assert!(base_frame_offset_m.iter().all(|x| x.abs() < 1e-9));
        let [x, y, yaw] = drive.real_over_asked;
        assert!((x - 1.0).abs() < 1e-9 && (yaw - 1.0).abs() < 1e-9);
        // With nine rollers per wheel, sin(pi/9)/(pi/9) of eq. (9) for wheels in step. Here each
        // wheel has any angle, and the least squares over four wheels weight them with a
        // second-order term in their differences.
        let short = (PI / 9.0).sin() / (PI / 9.0);
        assert!((y - short).abs() < 2e-3, "{y} against {short}");
    }

    /// A robot whose hubs lie along x rolls along -y: the controller's frame is turned by
    /// -90 degrees from the body's, so that the body's is turned by 90 degrees from it,
    /// v_C = R(theta) v_B. The rates are still those of eq. (9).
    #[test]
    fn a_robot_that_rolls_along_y_is_driven_with_the_offset_of_its_frame() {
        let mut turned = robot("mecanum4");
        let quarter = Isometry3::rotation(Vector3::z() * -FRAC_PI_2);
        for wheel in &mut turned.wheels {
            wheel.body_from_hub = quarter * wheel.body_from_hub;
        }
        let [plain, turned] = [robot("mecanum4"), turned].map(|robot| {
            let drive = DriveParameters::of(&robot).unwrap().unwrap();
            let real = Kinematics::new(&robot).unwrap().rate_matrix().clone();
            // The lever compensates what turning on nine rollers loses: 2.1 %, from pi/9 over
            // sin(pi/9).
            let off = (&drive.rates - real).amax() / drive.rates.amax();
            assert!(off < 0.021, "{off}");
            drive.controller
        });
        let (
            Controller::Mecanum { wheels, .. },
            Controller::Mecanum {
                wheels: same,
                base_frame_offset_rad,
                ..
            },
        ) = (plain, turned)
        else {
            panic!("no mecanum controller");
        };
        // Front left is defined by the wheels' rolling direction.
        assert_eq!(wheels, same);
        assert!((base_frame_offset_rad - FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn an_omni_robot_has_its_wheels_counter_clockwise() {
        let drive = DriveParameters::of(&robot("volksbot")).unwrap().unwrap();
        let Controller::Omni {
            wheels,
            wheel_offset_rad,
            robot_radius_m,
            wheel_radius_m,
        } = &drive.controller
        else {
            panic!("{:?}", drive.controller);
        };
        assert_eq!(wheels, &["wheel_1", "wheel_2", "wheel_3"]);
        assert!(wheel_offset_rad.abs() < 1e-9);
        assert!(
            (robot_radius_m / 0.25 - 1.0).abs() < 1e-2,
            "{robot_radius_m}"
        );
        assert!(
            (wheel_radius_m / 0.05 - 1.0).abs() < 1e-2,
            "{wheel_radius_m}"
        );
        let [x, y, yaw] = drive.real_over_asked;
        assert!((x - 1.0).abs() < 1e-3 && (y - 1.0).abs() < 1e-3 && (yaw - 1.0).abs() < 1e-9);
    }

    #[test]
    fn six_wheels_and_a_wheel_that_turns_back_are_refused_with_the_reason() {
        let six = DriveParameters::of(&robot("mecanum6"))
            .unwrap()
            .unwrap_err()
            .to_string();
        assert!(six.contains("6 wheels and not four"), "{six}");
        let text = std::fs::read_to_string(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/robots/mecanum4.urdf"
        ))
        .unwrap();
        let first = text.find("<axis xyz=\"0 1 0\"/>").unwrap();
        let turned = format!(
            "{}<axis xyz=\"0 -1 0\"/>{}",
            &text[..first],
            &text[first + 19..]
        );
        let back = Robot::from_urdf_str(&turned, "turned.urdf").unwrap();
        let told = DriveParameters::of(&back).unwrap().unwrap_err().to_string();
        assert!(told.contains("turns the other way"), "{told}");
    }

    #[test]
    fn every_twist_of_the_box_is_within_the_wheels_rates() {
        for name in ["mecanum4", "volksbot"] {
            let drive = DriveParameters::of(&robot(name)).unwrap().unwrap();
            let [x, y, yaw] = drive.box_within().unwrap();
            let mut largest: f64 = 0.0;
            for corner in 0..8 {
                let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                largest =
                    largest.max(drive.share(Twist::new(sign(0) * x, sign(1) * y, sign(2) * yaw)));
            }
            // It is as large as possible: one corner is at the limit.
            assert!((largest - 1.0).abs() < 1e-12, "{name}: {largest}");
        }
    }
}
