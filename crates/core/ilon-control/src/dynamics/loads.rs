//! How the wheels share the robot's weight.

use ilon_robot::Robot;
use nalgebra::{Matrix3, Vector2, Vector3};

use super::tree_loads::TreeLoads;

/// The wheels' normal forces on flat ground, from weight, payload and acceleration.
///
/// Three wheels share the weight by statics. For more, statics has no unique answer, and the model
/// is a rigid robot on wheels of equal stiffness: the loads vary linearly over the plane, N_h = a +
/// b x_h + c y_h, with a, b, c such that they carry the weight at the centre of mass. An
/// acceleration shifts the weight against it, in proportion to the height h of the centre of mass:
/// sum N_h x_h = m (g c_x - h a_x), and alike for y.
///
/// Joints between bodies change this: a free joint bears nothing, a sprung one deflects with its
/// load, and the loads follow from statics with both.
#[derive(Clone, Debug)]
pub struct WheelLoads {
    mass_kg: f64,
    gravity_m_s2: f64,
    center_of_mass_m: Vector2<f64>,
    height_m: f64,
    positions_m: Vec<Vector2<f64>>,
    /// Corners of the polygon around the wheels, counter-clockwise.
    polygon_m: Vec<Vector2<f64>>,
    /// Inverse of the sum over h of (1, x, y)(1, x, y)^T.
    inverse: Matrix3<f64>,
    /// Loads of a robot with joints between its bodies.
    of_tree: Option<TreeLoads>,
}

impl WheelLoads {
    /// Builds the loads of a robot under gravity in m/s^2, with its joints between bodies at zero;
    /// for other poses pass the result of [`Robot::posed`].
    pub fn new(robot: &Robot, gravity_m_s2: f64) -> Self {
        let mass_kg = robot.mass_kg();
        let center = robot.center_of_mass_m();
        let positions_m: Vec<_> = robot.wheels.iter().map(|w| w.position_m().xy()).collect();
        let sum: Matrix3<f64> = positions_m
            .iter()
            .map(|b| Vector3::new(1.0, b.x, b.y))
            .map(|v| v * v.transpose())
            .sum();
        Self {
            mass_kg,
            gravity_m_s2,
            center_of_mass_m: center.xy(),
            height_m: center.z + robot.ride_height_m(),
            polygon_m: polygon_about(&positions_m),
            positions_m,
            inverse: inverse(&sum),
            of_tree: (!robot.joints.is_empty())
                .then(|| TreeLoads::new(robot, gravity_m_s2))
                .flatten(),
        }
    }

    /// Writes the normal force on each wheel in N while the body accelerates with
    /// `acceleration_in_body` in m/s^2. A wheel that would be pulled down is lifted, with force
    /// zero, and the others take its part.
    pub fn fill_n(&self, acceleration_in_body: Vector2<f64>, out: &mut [f64]) {
        if let Some(of_tree) = &self.of_tree {
            return of_tree.fill_n(self.gravity_m_s2, acceleration_in_body, out);
        }
        let c = self.gravity_m_s2 * self.center_of_mass_m - self.height_m * acceleration_in_body;
        let carried = self.mass_kg * Vector3::new(self.gravity_m_s2, c.x, c.y);
        share(carried, &self.inverse, &self.positions_m, out);
    }

    /// Returns how far inside the wheels' polygon weight and inertia meet the ground at an
    /// acceleration, in metres: the centre of mass less height over gravity times the acceleration.
    /// Below zero the robot tips over; negative infinity for wheels in one row.
    pub fn margin_m(&self, acceleration_in_body: Vector2<f64>) -> f64 {
        let meets_m =
            self.center_of_mass_m - self.height_m / self.gravity_m_s2 * acceleration_in_body;
        let edges = self
            .polygon_m
            .iter()
            .zip(self.polygon_m.iter().cycle().skip(1));
        let inside_m = edges.map(|(a, b)| {
            let way = b - a;
            way.perp(&(meets_m - a)) / way.norm()
        });
        match self.polygon_m.len() {
            0..3 => f64::NEG_INFINITY,
            _ => inside_m.fold(f64::INFINITY, f64::min),
        }
    }
}

/// Returns the corners of the convex hull of points, counter-clockwise, by Andrew's monotone chain;
/// fewer than three for points in one row.
fn polygon_about(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let size = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let turns_left = |chain: &[Vector2<f64>], to: &Vector2<f64>| match chain {
        // Points off by rounding count as on the edge.
        [.., a, b] => (b - a).perp(&(to - a)) > 1e-9 * size * size,
        _ => true,
    };
    let chain = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for point in points {
            while !turns_left(&chain, point) {
                chain.pop();
            }
            chain.push(*point);
        }
        // The other chain starts where this one ends.
        chain.pop();
        chain
    };
    let mut polygon = chain(&mut sorted.iter());
    polygon.extend(chain(&mut sorted.iter().rev()));
    polygon
}

/// Computes the loads in N of wheels of equal stiffness that carry a weight in N with its moments
/// sum N x and sum N y, in N m. `inverse_of_all` is the inverse of the sum over all wheels of (1,
/// x, y)(1, x, y)^T; a wheel that would be pulled down is lifted.
pub(super) fn share(
    carried: Vector3<f64>,
    inverse_of_all: &Matrix3<f64>,
    positions_m: &[Vector2<f64>],
    out: &mut [f64],
) {
    let at = |b: &Vector2<f64>| Vector3::new(1.0, b.x, b.y);
    let plane = inverse_of_all * carried;
    for (out, b) in out.iter_mut().zip(positions_m) {
        *out = plane.dot(&at(b));
    }
    // Each round lifts at least one wheel.
    while out.iter().any(|n| *n < 0.0) {
        let standing = out.iter().zip(positions_m).filter(|(n, _)| **n > 0.0);
        let sum: Matrix3<f64> = standing.map(|(_, b)| at(b) * at(b).transpose()).sum();
        let plane = inverse(&sum) * carried;
        for (out, b) in out.iter_mut().zip(positions_m) {
            *out = if *out > 0.0 { plane.dot(&at(b)) } else { 0.0 };
        }
    }
}

/// Returns the inverse of the sum over wheels of (1, x, y)(1, x, y)^T. Wheels in one row carry no
/// tilting moment; the pseudo-inverse then leaves it out.
pub(super) fn inverse(sum: &Matrix3<f64>) -> Matrix3<f64> {
    sum.pseudo_inverse(1e-12 * sum.trace())
        .unwrap_or_else(|_| Matrix3::zeros())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::joints::{driven, joint, on_springs};
    use crate::tests::robots::{mecanum4, volksbot};
    use ilon_robot::{BodyJoint, Coupling, JointKind};

    /// Robot A: axles at 0.15 m, its centre of mass h above the ground. It tips over its rear axle
    /// from a h = g (0.15 + c_x) on; wheels in one row hold no moment.
    #[test]
    fn it_tips_where_weight_and_inertia_leave_the_wheels() {
        let robot = mecanum4();
        let loads = WheelLoads::new(&robot, 9.81);
        let (c, axle_m) = (robot.center_of_mass_m(), robot.wheels[0].position_m().x);
        let height_m = c.z + robot.ride_height_m();
        let tips = 9.81 * (axle_m + c.x) / height_m;
        for (share, sign) in [(0.999, 1.0), (1.001, -1.0)] {
            let margin_m = loads.margin_m(Vector2::new(share * tips, 0.0));
            let expected = (1.0 - share) * (axle_m + c.x);
            assert!(
                (margin_m - expected).abs() < 1e-9 && margin_m * sign > 0.0,
                "{margin_m}"
            );
        }
        let mut row = robot.clone();
        for wheel in &mut row.wheels {
            wheel.body_from_hub.translation.vector.x = 0.1 * wheel.position_m().y;
        }
        assert_eq!(
            WheelLoads::new(&row, 9.81).margin_m(Vector2::zeros()),
            f64::NEG_INFINITY
        );
    }

    /// Returns the loads of a robot at rest, in N.
    fn at_rest<const N: usize>(robot: &Robot) -> [f64; N] {
        let mut n = [0.0; N];
        WheelLoads::new(robot, 9.81).fill_n(Vector2::zeros(), &mut n);
        n
    }

    /// Two wheels at x metres hang on a rocker about the long axis, 50 mm above the ground, that
    /// turns by 0.1 rad either way.
    fn put_on_rocker(robot: &mut Robot, x_m: f64) {
        let at_m = Vector3::new(x_m, 0.0, 0.05);
        let mut rocker = joint(at_m, Vector3::x(), (0.2, Vector3::zeros()));
        rocker.limits = [-0.1, 0.1];
        robot.joints.push(rocker);
        let joint = robot.joints.len() - 1;
        for wheel in &mut robot.wheels {
            if (wheel.position_m().x - x_m).abs() < 1e-9 {
                wheel.carrier = Some(joint);
            }
        }
    }

    /// An arm on a pivot above the middle of the robot, with 3 kg at 0.5 m ahead of the pivot and
    /// 0.3 m above it: the loads follow from moments at every arm angle, about the vertical and
    /// about an axis along y.
    #[test]
    fn the_mass_of_an_arm_loads_the_wheels_under_it() {
        let (arm_kg, out_m, up_m) = (3.0, 0.5, 0.3);
        for (axis, angle_rad) in [(0, 0.0), (0, 0.7), (0, 2.5), (1, -0.6), (1, 0.4)] {
            let mut robot = mecanum4();
            let axis = [Vector3::z(), Vector3::y()][axis];
            let bare = (robot.mass_kg(), robot.center_of_mass_m());
            let pivot_m = Vector3::new(0.0, 0.0, 0.2);
            let mass = (arm_kg, Vector3::new(out_m, 0.0, up_m));
            robot.joints.push(driven(joint(pivot_m, axis, mass)));
            let n: [f64; 4] = at_rest(&robot.posed(&[angle_rad]));
            let (sin, cos) = angle_rad.sin_cos();
            let at_m = match axis.z {
                1.0 => Vector2::new(out_m * cos, out_m * sin),
                _ => Vector2::new(out_m * cos + up_m * sin, 0.0),
            };
            let moment = (bare.0 * bare.1.xy() + arm_kg * at_m) * 9.81;
            let quarter = 0.25 * (bare.0 + arm_kg) * 9.81;
            for (n, wheel) in n.iter().zip(&robot.wheels) {
                let side = wheel.position_m().xy();
                let expected = quarter + 0.25 * moment.x / side.x + 0.25 * moment.y / side.y;
                assert!((n / expected - 1.0).abs() < 1e-6, "{n} {expected}");
            }
        }
    }

    /// A joint that carries wheels moves their contact points: a rear axle that slides back by 0.1
    /// m bears less.
    #[test]
    fn wheels_bear_where_their_joints_have_taken_them() {
        let mut robot = mecanum4();
        robot.joints.push(driven(BodyJoint {
            kind: JointKind::Slides,
            ..joint(Vector3::zeros(), -Vector3::x(), (0.2, Vector3::zeros()))
        }));
        for wheel in &mut robot.wheels[2..] {
            wheel.carrier = Some(0);
        }
        let posed = robot.posed(&[0.1]);
        let n: [f64; 4] = at_rest(&posed);
        // By moments about the rear axle, 0.25 m behind the origin.
        let weight = robot.mass_kg() * 9.81;
        let front = 0.5 * weight * (posed.center_of_mass_m().x + 0.25) / 0.4;
        for (n, expected) in
            n.iter()
                .zip([front, front, 0.5 * weight - front, 0.5 * weight - front])
        {
            assert!((n / expected - 1.0).abs() < 1e-6, "{n} {expected}");
        }
    }

    /// The part of four spring positions that no plane explains is the ground under them: a plate
    /// of height h under one wheel adds k h / 4 to it and to the diagonal one. A pitched robot has
    /// the same loads as a level one.
    #[test]
    fn springs_press_by_the_ground_that_their_positions_say() {
        let (k, h) = (4000.0, 0.004);
        let robot = on_springs(k);
        let level: [f64; 4] = at_rest(&robot);
        // A plate lifts its wheel by 3 h / 4 against the mean, and the diagonal one by as much,
        // because the chassis tilts.
        let warp = [0.25 * h, -0.25 * h, -0.25 * h, 0.25 * h];
        let lifted: [f64; 4] = at_rest(&robot.posed(&warp));
        for ((lifted, level), warp) in lifted.iter().zip(level).zip(warp) {
            let expected = level + k * warp;
            assert!(
                (lifted / expected - 1.0).abs() < 1e-6,
                "{lifted} {expected}"
            );
        }
        let pitched = [0.003, 0.003, -0.003, -0.003];
        let pitched: [f64; 4] = at_rest(&robot.posed(&pitched));
        for (pitched, level) in pitched.iter().zip(level) {
            assert!((pitched / level - 1.0).abs() < 1e-6, "{pitched} {level}");
        }
    }

    /// A rocker on its stop bears the moment that presses it there; one that would leave the stop
    /// bears none. In the first case all four wheels stand on one rigid body, and the plane through
    /// front left and rear right decides.
    #[test]
    fn a_rocker_on_its_stop_is_rigid_where_it_is_pressed_on_it() {
        let mut robot = mecanum4();
        put_on_rocker(&mut robot, -0.15);
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.0, 0.05, 0.06);
        let free: [f64; 4] = at_rest(&robot);
        // Weight on the left turns the chassis left side down and the rocker against it: by the
        // left-hand rule about x it is at its positive stop.
        let [pressed, leaves]: [[f64; 4]; 2] = [0.1, -0.1].map(|at| at_rest(&robot.posed(&[at])));
        let rolls = |n: &[f64; 4]| [n[0] - n[1], n[2] - n[3]];
        let [front, rear] = rolls(&leaves);
        assert!(
            (front - rolls(&free)[0]).abs() < 1e-2 * front && rear.abs() < 1e-6,
            "{front} {rear}"
        );
        let [front, rear] = rolls(&pressed);
        // Both axles bear half of the moment, except for the changes by the turned rocker's own
        // mass and narrower track.
        assert!((front / rear - 1.0).abs() < 2e-2, "{front} {rear}");
        let moment: f64 = pressed
            .iter()
            .zip(&robot.posed(&[0.1]).wheels)
            .map(|(n, wheel)| n * wheel.position_m().y)
            .sum();
        let expected = robot.posed(&[0.1]).center_of_mass_m().y * robot.mass_kg() * 9.81;
        assert!(
            (moment / expected - 1.0).abs() < 1e-6,
            "{moment} {expected}"
        );
    }

    /// Two rockers on a differential bar bear alike in sum: a chassis stands that would fall to one
    /// side on free rockers.
    #[test]
    fn a_differential_bar_bears_what_leans_over() {
        let mut robot = mecanum4();
        for y_m in [0.16, -0.16] {
            let mut bogie = joint(
                Vector3::new(0.0, y_m, 0.05),
                Vector3::y(),
                (0.2, Vector3::zeros()),
            );
            bogie.limits = [-0.3, 0.3];
            robot.joints.push(bogie);
        }
        for wheel in &mut robot.wheels {
            wheel.carrier = Some(usize::from(wheel.position_m().y < 0.0));
        }
        robot.couplings.push(Coupling {
            joint: 1,
            follows: 0,
            factor: -1.0,
            offset: 0.0,
        });
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.02, 0.03, 0.06);
        let n: [f64; 4] = at_rest(&robot);
        // Each side bears by moments about x. The bar takes as much from one bogie as it gives the
        // other, so both have the same difference between front and rear, which in sum is that of
        // the centre of mass.
        let (weight, center) = (robot.mass_kg() * 9.81, robot.center_of_mass_m());
        let left = 0.5 * weight * (1.0 + center.y / 0.16);
        let parted = 0.5 * weight * center.x / 0.15;
        let expected = [
            0.5 * (left + parted),
            0.5 * (weight - left + parted),
            0.5 * (left - parted),
            0.5 * (weight - left - parted),
        ];
        for (n, expected) in n.iter().zip(expected) {
            assert!((n / expected - 1.0).abs() < 1e-6, "{n} {expected}");
        }
    }

    #[test]
    fn loads_carry_the_weight_at_the_centre_of_mass() {
        let mut robot = mecanum4();
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.05, -0.02, 0.2);
        let loads = WheelLoads::new(&robot, 9.81);
        let mut n = [0.0; 4];
        loads.fill_n(Vector2::zeros(), &mut n);
        let weight = robot.mass_kg() * 9.81;
        assert!((n.iter().sum::<f64>() - weight).abs() < 1e-10);
        let moment_x: f64 = n
            .iter()
            .zip(&robot.wheels)
            .map(|(n, w)| n * w.position_m().x)
            .sum();
        // The wheels and their rollers balance about the middle: only the chassis tilts the loads.
        assert!((moment_x - 10.0 * 9.81 * 0.05).abs() < 1e-10);
        // Front and left differ only by sign: the diagonals carry equal sums.
        assert!((n[0] + n[3] - n[1] - n[2]).abs() < 1e-10);
    }

    /// If the centre of mass lies beyond the line between two neighbours of a wheel, that wheel
    /// lifts, and the three others carry by statics alone.
    #[test]
    fn what_a_lifted_wheel_carried_is_shared_by_the_others() {
        let mut robot = mecanum4();
        let others_kg = robot.mass_kg() - robot.chassis.mass.mass_kg;
        // Puts the whole robot's centre of mass at (0.12, 0.13) m; wheels stand at (+-0.15, +-0.16)
        // m.
        let share = robot.mass_kg() / (robot.mass_kg() - others_kg);
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.12 * share, 0.13 * share, 0.1);
        let loads = WheelLoads::new(&robot, 9.81);
        let mut n = [0.0; 4];
        loads.fill_n(Vector2::zeros(), &mut n);
        // Moments about x and y on front left, front right and rear left: 0.5 (1 + 0.12 / 0.15) -
        // front right, and so on.
        let weight = robot.mass_kg() * 9.81;
        let front_right = 0.5 * (1.0 - 0.13 / 0.16);
        let rear_left = 0.5 * (1.0 - 0.12 / 0.15);
        let expected = [1.0 - front_right - rear_left, front_right, rear_left, 0.0];
        for (n, expected) in n.iter().zip(expected) {
            assert!((n / weight - expected).abs() < 1e-3, "{n} {expected}");
        }
        assert!((n.iter().sum::<f64>() / weight - 1.0).abs() < 1e-12);
    }

    /// A rocker loads its two wheels equally wherever the weight lies; the other axle bears the
    /// offset.
    #[test]
    fn a_rocker_bears_its_wheels_alike() {
        let mut robot = mecanum4();
        put_on_rocker(&mut robot, -0.15);
        robot.chassis.mass.center_of_mass_m = Vector3::new(0.0, 0.05, 0.06);
        let loads = WheelLoads::new(&robot, 9.81);
        let mut n = [0.0; 4];
        loads.fill_n(Vector2::zeros(), &mut n);
        let (weight, center) = (robot.mass_kg() * 9.81, robot.center_of_mass_m());
        let rear = weight * (0.15 - center.x) / 0.3;
        let leans = weight * center.y / 0.16;
        let front = 0.5 * (weight - rear);
        let expected = [
            front + 0.5 * leans,
            front - 0.5 * leans,
            0.5 * rear,
            0.5 * rear,
        ];
        for (n, expected) in n.iter().zip(expected) {
            assert!((n / expected - 1.0).abs() < 1e-9, "{n} {expected}");
        }
        // Acceleration to the left, all pull alike: the rocker passes its share on at its axis, 50
        // mm above the ground.
        loads.fill_n(Vector2::new(0.0, 1.0), &mut n);
        let rear_moment = 0.5 * robot.mass_kg() * 0.05;
        let parted = (n[3] - n[2]) * 0.16;
        assert!(
            (parted - rear_moment).abs() < 1e-9,
            "{parted} {rear_moment}"
        );
        let sum: f64 = n.iter().sum();
        assert!((sum / weight - 1.0).abs() < 1e-12);
    }

    #[test]
    fn three_wheels_share_by_statics_and_acceleration_shifts_back() {
        let robot = volksbot();
        let loads = WheelLoads::new(&robot, 9.81);
        let mut n = [0.0; 3];
        loads.fill_n(Vector2::zeros(), &mut n);
        assert!(n.iter().all(|n| (n - 8.0 * 9.81 / 3.0).abs() < 0.02));
        let level = n[0];
        loads.fill_n(Vector2::new(2.0, 0.0), &mut n);
        // Wheel 0 is in front: it loses m h a / (1.5 |b|).
        let height = loads.height_m;
        let lost = robot.mass_kg() * height * 2.0 / (1.5 * 0.25);
        assert!((level - n[0] - lost).abs() < 1e-10);
    }
}
