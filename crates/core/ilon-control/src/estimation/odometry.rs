//! Dead reckoning from wheel angles, by the rollers that really touch.
//!
//! Eq. (7) converts wheel rates to a twist as if every touching roller pointed straight down. For a
//! mecanum robot that drives sideways it overestimates the distance by 2 % (nine rollers per wheel)
//! to 4.5 % (six). The contact kinematics corrects this, since the wheel angles determine which
//! roller touches, and where. The remaining error is slip, which no wheel measures.

use ilon_robot::{Pose, Twist};

use crate::{ContactKinematics, Kinematics};

/// Dead reckoning by the contact kinematics: wheel angles in, pose out.
///
/// **Input.** The wheels' absolute angles in radians, unwrapped, in the robot's wheel order, each
/// counted from where the robot's description has its rollers: which roller touches is read off
/// them. An encoder that counts from wherever it was switched on has to find that mark once; off by
/// half a roller pitch the ripple is corrected the wrong way round.
///
/// **Law.** The kinematics is linear in the rates, so the angles turned since the last call give
/// the displacement in the body frame, with the touching rollers taken at the middle of the way; it
/// is laid on the pose with the heading at its middle. Both are exact to second order in what is
/// turned between calls: call it several times a roller pitch (2 pi / n of a wheel's turn), at 0.3
/// m/s and nine rollers of a 5 cm wheel more often than every 40 ms.
///
/// **Errors.** None; it allocates nothing once it is built.
///
/// ```
/// use ilon_control::{ContactKinematics, Odometry};
/// use ilon_formats::LoadRobot;
/// use ilon_robot::{Pose, Robot};
///
/// let robot = Robot::load("../../../assets/robots/mecanum4.urdf")?;
/// let start = Pose::default();
/// let mut angles_rad = [0.0; 4]; // from the encoders
/// let mut odometry = Odometry::new(ContactKinematics::new(&robot)?, start, &angles_rad);
///
/// // To the left: front left and rear right backwards. One roller pitch in 100 steps.
/// for _ in 0..100 {
///     for (angle_rad, sign) in angles_rad.iter_mut().zip([-1.0, 1.0, 1.0, -1.0]) {
///         *angle_rad += sign * 40_f64.to_radians() / 100.0;
///     }
///     odometry.update(&angles_rad);
/// }
/// let ideal_m = 0.05 * 40_f64.to_radians(); // what eq. (7) believes
/// let short = 20_f64.to_radians().sin() / 20_f64.to_radians();
/// assert!((odometry.pose().y_m - short * ideal_m).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Odometry {
    kinematics: ContactKinematics,
    pose: Pose,
    last_angles_rad: Vec<f64>,
    middle_rad: Vec<f64>,
    turned_rad: Vec<f64>,
}

impl Odometry {
    /// Starts from a pose of the body frame, at wheel angles in radians; missing ones are zero.
    pub fn new(kinematics: ContactKinematics, start: Pose, wheel_angles_rad: &[f64]) -> Self {
        let count = kinematics.contacts().len();
        let mut last_angles_rad = wheel_angles_rad.to_vec();
        last_angles_rad.resize(count, 0.0);
        Self {
            kinematics,
            pose: start,
            last_angles_rad,
            middle_rad: vec![0.0; count],
            turned_rad: vec![0.0; count],
        }
    }

    /// Takes the current wheel angles, in radians, and returns the resulting pose. A missing wheel
    /// counts as not turned.
    pub fn update(&mut self, wheel_angles_rad: &[f64]) -> Pose {
        self.update_carried(wheel_angles_rad, &[], Twist::default())
    }

    /// Continues with other kinematics: those of the same robot after its wheels moved on the body.
    pub fn stand(&mut self, kinematics: &Kinematics) {
        self.kinematics.stand(kinematics);
    }

    /// Like [`Self::update`], if joints moved the wheels on the body since the last call.
    /// `carried_rad` is how far each wheel rolled over the ground beyond its encoder's angle, as if
    /// the body had stood still, in radians; missing ones are zero. `along_axles` is how the body
    /// moved because joints moved tyres along their axles.
    pub fn update_carried(
        &mut self,
        wheel_angles_rad: &[f64],
        carried_rad: &[f64],
        along_axles: Twist,
    ) -> Pose {
        self.turned_rad.fill(0.0);
        let last = self.last_angles_rad.iter_mut();
        let increments = self.turned_rad.iter_mut().zip(&mut self.middle_rad);
        for (((turned, middle), last), now) in increments.zip(last).zip(wheel_angles_rad) {
            *turned = now - *last;
            *middle = now - 0.5 * *turned;
            *last = *now;
        }
        for (turned, carried) in self.turned_rad.iter_mut().zip(carried_rad) {
            *turned += carried;
        }
        // Angles instead of rates: the displacement in the body frame, in metres and radians.
        let displacement = self.kinematics.twist(&self.middle_rad, &self.turned_rad);
        self.pose = self.pose.moved(displacement + along_axles);
        self.pose
    }

    /// The estimated pose of the body frame.
    pub fn pose(&self) -> Pose {
        self.pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{mecanum4, six_wheels, volksbot};
    use ilon_robot::Robot;

    /// Moves a robot by twists without slip. Returns its true pose and its estimated pose.
    fn driven(robot: &Robot, twist_at: impl Fn(f64) -> Twist, dt_s: f64) -> (Pose, Pose) {
        let mut world = ContactKinematics::new(robot).unwrap();
        let count = robot.wheels.len();
        let (mut angles, mut rates) = (vec![0.3; count], vec![0.0; count]);
        let start = Pose {
            x_m: 1.0,
            y_m: -2.0,
            heading_rad: 2.0,
        };
        let mut odometry = Odometry::new(world.clone(), start, &angles);
        let mut truth = start;
        // The true motion uses steps a hundred times finer.
        const FINER: u32 = 100;
        let fine_s = dt_s / f64::from(FINER);
        for step in 0..(2.0 / dt_s) as u32 {
            for k in 0..FINER {
                let t_s = f64::from(step) * dt_s + f64::from(k) * fine_s;
                let twist = twist_at(t_s);
                world.wheel_rates(&angles, twist, &mut rates);
                for (angle, rate) in angles.iter_mut().zip(&rates) {
                    *angle += rate * fine_s;
                }
                truth = truth.moved(twist.scaled(fine_s));
            }
            odometry.update(&angles);
        }
        (truth, odometry.pose())
    }

    #[test]
    fn without_slip_it_is_where_the_robot_is() {
        let twist_at = |t: f64| Twist::new(0.3 * t.cos(), 0.3 * (2.0 * t).sin(), 0.8 * t.sin());
        for robot in [mecanum4(), volksbot(), six_wheels()] {
            let (truth, believed) = driven(&robot, twist_at, 0.005);
            let off_m = (truth.position_m() - believed.position_m()).norm();
            // Second order in 6 rad/s * 5 ms = 0.03 rad of wheel turn, plus one change of roller
            // within a step: 1e-4 of the distance of half a metre.
            assert!(off_m < 2e-4, "{off_m}");
            assert!((truth.heading_rad - believed.heading_rad).abs() < 1e-3);
        }
    }

    #[test]
    fn the_ideal_kinematics_is_two_per_cent_off_where_it_is_not() {
        let robot = mecanum4();
        let left = |_: f64| Twist::new(0.0, 0.3, 0.0);
        let (truth, believed) = driven(&robot, left, 0.005);
        let ideal = Kinematics::new(&robot).unwrap();
        let mut world = ContactKinematics::new(&robot).unwrap();
        let (mut angles, mut rates) = (vec![0.3; 4], vec![0.0; 4]);
        let mut way_m = 0.0;
        for _ in 0..20_000 {
            world.wheel_rates(&angles, left(0.0), &mut rates);
            way_m += ideal.twist(&rates).vy_m_s * 1e-4;
            for (angle, rate) in angles.iter_mut().zip(&rates) {
                *angle += rate * 1e-4;
            }
        }
        // 0.6 m; over whole pitches 1 / 0.9798 of it (weighted by time instead of by angle:
        // 1.0205), the rest of a pitch left over.
        assert!((way_m / 0.6 - 1.0205).abs() < 0.004, "{way_m}");
        assert!((truth.position_m() - believed.position_m()).norm() < 1e-4);
    }
}
