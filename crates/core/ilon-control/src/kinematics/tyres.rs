//! What wheels with tyres add to the kinematics: they do not move sideways.
//!
//! A tyre rolls along **u** as a Swedish wheel of gamma = 0 does, so that its row of eq. (7) is the
//! same: u . v_h = rho q'. It has no rollers, and holds its hub along the hub axis besides: n . v_h
//! = 0. These rows have no motor. Twists that they exclude cannot be driven (nonholonomic); with
//! the driven rows they determine the twist of given wheel rates (odometry).
//!
//! **Skid steering.** Unsteered tyres on parallel axles that do not lie on one line contradict each
//! other in every turn: some of them slide. The rows of such axles are therefore taken together as
//! their mean, the row of a wheel in their middle: a robot of two axles is expected to turn about
//! the middle of both. By how much less it turns, its contacts decide. Axles with toe, nearly
//! parallel, are such too: their tyres scrub as they roll, about along the mean. A steered tyre has a
//! row of its own.
//!
//! **Casters.** A tyre that swivels freely and has no motor turns to any motion. It has no rows.

use ilon_robot::{Robot, Wheel};
use nalgebra::{RowVector3, Vector2};

/// A motion this much beside what a tyre allows is allowed, over its size: files hold rounded
/// angles.
pub(crate) const ROUNDED: f64 = 1e-3;
/// Axles count as parallel within this sine of the angle between them (chosen, 5.7 degrees): tyres
/// with toe drive ahead all the same, and slide a little.
const PARALLEL: f64 = 0.1;

/// How a wheel stands on its robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mount {
    Fixed,
    /// A servo turns it about an upright axis at this place in the body frame, in metres.
    Steered(Vector2<f64>),
    /// A caster's: it turns by itself.
    Swivels,
}

/// A row n . v_h = 0 and the tyres that give it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldRow {
    /// The wheels of these tyres, by name: one that is steered, or all unsteered ones with parallel
    /// axles.
    pub wheels: Vec<String>,
    /// As a function of (v_x, v_y, omega): n, and its moment about the reference point in metres.
    pub row: RowVector3<f64>,
    /// Whether it turns with a steering joint, and so excludes no twist for good.
    pub is_steered: bool,
    /// The largest distance between two of the axles, in metres: tyres of axles that do not lie on
    /// one line slide in every turn.
    pub axles_apart_m: f64,
}

/// Tyres that give one row together.
struct Group<'w> {
    /// The direction of the first one's axle.
    n: Vector2<f64>,
    wheels: Vec<&'w Wheel>,
    is_steered: bool,
}

/// Returns the tyres by the rows that they give: each steered one alone, the others by the
/// direction of their axles.
fn grouped<'w>(wheels: impl Iterator<Item = (&'w Wheel, Mount)>) -> Vec<Group<'w>> {
    let mut groups: Vec<Group<'w>> = Vec::new();
    let holds = |(wheel, mount): &(&Wheel, Mount)| wheel.has_tyre() && *mount != Mount::Swivels;
    for (wheel, mount) in wheels.filter(holds) {
        let (n, is_steered) = (wheel.axis(), matches!(mount, Mount::Steered(_)));
        let joins =
            |of: &&mut Group<'w>| !is_steered && !of.is_steered && of.n.perp(&n).abs() < PARALLEL;
        match groups.iter_mut().find(joins) {
            Some(of) => of.wheels.push(wheel),
            None => groups.push(Group {
                n,
                wheels: vec![wheel],
                is_steered,
            }),
        }
    }
    groups
}

impl Group<'_> {
    fn row(&self, reference_point_m: Vector2<f64>) -> RowVector3<f64> {
        let places_m = self.wheels.iter().map(|wheel| wheel.position_m().xy());
        let sum: Vector2<f64> = places_m.map(|b| b - reference_point_m).sum();
        let b = sum / self.wheels.len() as f64;
        // Their mean; axles are lines, so that each may point either way.
        let along = |wheel: &&Wheel| wheel.axis() * wheel.axis().dot(&self.n).signum();
        let sum: Vector2<f64> = self.wheels.iter().map(along).sum();
        let mean = sum / self.wheels.len() as f64;
        // Of axles without toe it is one long but for rounding.
        let n = match (mean.norm() - 1.0).abs() < 1e-12 {
            true => mean,
            false => mean.normalize(),
        };
        RowVector3::new(n.x, n.y, b.perp(&n))
    }

    fn axles_apart_m(&self) -> f64 {
        let along = |wheel: &&Wheel| wheel.position_m().xy().perp(&self.n);
        let places = self.wheels.iter().map(along);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (at.min(low), at.max(high))
        });
        high - low
    }
}

/// Returns the rows n . v_h = 0 of the tyres about a reference point, as functions of (v_x, v_y,
/// omega): one for each steered tyre, and one for each direction of the others' axles; none for a
/// robot on rollers.
pub(crate) fn held_rows<'w>(
    wheels: impl Iterator<Item = (&'w Wheel, Mount)>,
    reference_point_m: Vector2<f64>,
) -> Vec<RowVector3<f64>> {
    let groups = grouped(wheels);
    groups.iter().map(|of| of.row(reference_point_m)).collect()
}

/// Returns the largest sine of the angle between a tyre's axle and the mean of those that give a row
/// with it.
pub(crate) fn toe<'w>(wheels: impl Iterator<Item = (&'w Wheel, Mount)>) -> f64 {
    let groups = grouped(wheels).into_iter();
    let of_group = groups.flat_map(|of| {
        let n = of.row(Vector2::zeros()).transpose().xy();
        let wheels = of.wheels.into_iter();
        wheels.map(move |wheel| wheel.axis().perp(&n).abs())
    });
    of_group.fold(0.0, f64::max)
}

/// Returns the same rows of a robot about its body's origin, with their wheels.
pub(crate) fn named_rows(robot: &Robot) -> Vec<HeldRow> {
    let groups = grouped(robot.wheels.iter().zip(mounts(robot)));
    let named = groups.iter().map(|of| HeldRow {
        wheels: of.wheels.iter().map(|wheel| wheel.name.clone()).collect(),
        row: of.row(Vector2::zeros()),
        is_steered: of.is_steered,
        axles_apart_m: of.axles_apart_m(),
    });
    named.collect()
}

/// How each wheel of a robot stands on it.
pub(crate) fn mounts(robot: &Robot) -> Vec<Mount> {
    let mount = |wheel| match robot.steering_of(wheel) {
        Some(at) => Mount::Steered(robot.joints[at].body_from_joint.translation.vector.xy()),
        None if robot.swivels(wheel) => Mount::Swivels,
        None => Mount::Fixed,
    };
    robot.wheels.iter().map(mount).collect()
}

#[cfg(test)]
mod tests {
    use ilon_robot::Twist;
    use nalgebra::{UnitQuaternion, Vector2, Vector3};

    use super::{Mount, held_rows};
    use crate::tests::joints::joint;
    use crate::tests::tyres::on_tyres;
    use crate::{Arrangement, ContactKinematics, ControlError, Kinematics, SpeedLimits};

    fn close(one: Twist, other: Twist) -> bool {
        let off = one - other;
        off.linear_m_s().norm() + off.omega_rad_s.abs() < 1e-12
    }

    /// v = rho (q'_r + q'_l) / 2 and omega = rho (q'_r - q'_l) / b of any textbook, by both
    /// kinematics.
    #[test]
    fn a_differential_robot_has_the_textbook_odometry() {
        let robot = on_tyres(&[[0.0, 0.2], [0.0, -0.2]]);
        let rho = robot.wheels[0].radius_m;
        let kinematics = Kinematics::new(&robot).expect("two tyres drive");
        let mut contact = ContactKinematics::new(&robot).expect("two tyres drive");
        let rates = [3.0, 5.0];
        let expected = Twist::new(rho * 4.0, 0.0, rho * 2.0 / 0.4);
        assert!(close(kinematics.twist(&rates), expected));
        assert!(close(contact.twist(&[0.3, -2.0], &rates), expected));
        let mut back = [0.0; 2];
        kinematics.wheel_rates(expected, &mut back);
        assert!((back[0] - 3.0).abs() + (back[1] - 5.0).abs() < 1e-12);
        assert!(!kinematics.is_omnidirectional());
        assert_eq!(Arrangement::of(&robot).expect("it drives").rank, 3);
    }

    /// About an axle behind the origin the origin moves sideways in a turn; what is asked sideways
    /// of the axle itself is left out.
    #[test]
    fn what_tyres_exclude_is_taken_out_of_a_twist_and_its_yaw_rate_stays() {
        let kinematics = Kinematics::new(&on_tyres(&[[-0.2, 0.2], [-0.2, -0.2]])).expect("drives");
        let turn = kinematics.reachable(Twist::new(0.3, 0.0, 0.5));
        assert!(close(turn, Twist::new(0.3, 0.2 * 0.5, 0.5)));
        assert!(close(kinematics.reachable(turn), turn));
        assert!((kinematics.sideways_m_s(Twist::new(0.0, 0.3, 0.0)) - 0.3).abs() < 1e-12);
        let tops = SpeedLimits::new(&kinematics, &[10.0; 2]);
        let [ahead, aside] = [0.0, 90_f64.to_radians()].map(|rad| tops.top_speed_m_s(rad));
        assert!(ahead > 0.4 && aside == 0.0, "{ahead} {aside}");
    }

    /// A file says `rpy="0 0 1.5708"` for a right angle, 3.7e-6 more: the way ahead is still there,
    /// and sideways still is not.
    #[test]
    fn a_right_angle_that_a_file_rounds_excludes_no_way_ahead() {
        let mut robot = on_tyres(&[[0.0, 0.2], [0.0, -0.2]]);
        let off_rad = 3.7e-6;
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), off_rad);
        for wheel in &mut robot.wheels {
            wheel.body_from_hub.rotation = turn * wheel.body_from_hub.rotation;
        }
        let tops = SpeedLimits::uniform(&Kinematics::new(&robot).expect("it drives"), 10.0);
        let ahead_m_s = 10.0 * robot.wheels[0].radius_m;
        assert!((tops.top_speed_m_s(0.0) / ahead_m_s - 1.0).abs() < 1e-9);
        assert_eq!(tops.top_speed_m_s(0.01), 0.0);
    }

    /// Wheels that converge by half a degree each: ahead is between them.
    #[test]
    fn tyres_that_converge_by_a_degree_drive_ahead() {
        let mut robot = on_tyres(&[[0.0, 0.2], [0.0, -0.2]]);
        for (wheel, toe_deg) in robot.wheels.iter_mut().zip([-0.5_f64, 0.5]) {
            let toe_rad = nalgebra::Vector3::z() * toe_deg.to_radians();
            let turn = nalgebra::UnitQuaternion::from_scaled_axis(toe_rad);
            wheel.body_from_hub.rotation = turn * wheel.body_from_hub.rotation;
        }
        let kinematics = Kinematics::new(&robot).expect("it drives");
        assert!(kinematics.sideways_m_s(Twist::new(0.3, 0.0, 0.5)) < 1e-15);
        let tops = SpeedLimits::uniform(&kinematics, 10.0);
        assert!(tops.top_speed_m_s(0.0) > 9.9 * robot.wheels[0].radius_m);
    }

    /// One wheel of four with a toe of 3 degrees: all drive about along the mean, 0.75 degrees aside,
    /// and turn about their middle. (Taken as two directions they left a turn about a point 5 m away,
    /// and 0.8 rad/s was 4 m/s ahead.)
    #[test]
    fn a_wheel_with_toe_leaves_the_way_ahead_and_the_turn_on_the_spot() {
        let mut robot = on_tyres(&[[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]]);
        let toe_rad = 3.0_f64.to_radians();
        let turn = UnitQuaternion::from_scaled_axis(toe_rad * Vector3::z());
        robot.wheels[0].body_from_hub.rotation = turn * robot.wheels[0].body_from_hub.rotation;
        let kinematics = Kinematics::new(&robot).expect("it drives");
        let spot = kinematics.reachable(Twist::new(0.0, 0.0, 0.8));
        assert!(close(spot, Twist::new(0.0, 0.0, 0.8)), "{spot:?}");
        let ahead = kinematics.reachable(Twist::new(0.3, 0.0, 0.0));
        // The mean of three unit vectors and one at the toe.
        let aside_rad = f64::atan2(toe_rad.sin(), 3.0 + toe_rad.cos());
        let found_rad = f64::atan2(ahead.vy_m_s, ahead.vx_m_s);
        assert!((found_rad - aside_rad).abs() < 1e-12, "{ahead:?}");
        assert!((kinematics.toe() - (toe_rad - aside_rad).sin()).abs() < 1e-12);
        let tops = SpeedLimits::uniform(&kinematics, 10.0);
        let ahead_m_s = tops.top_speed_m_s(0.0) / (10.0 * robot.wheels[0].radius_m);
        // The wheel with toe, or the others, roll by the cosines of small angles of the way.
        assert!((0.99..1.01).contains(&ahead_m_s), "{ahead_m_s}");
        assert!(tops.top_yaw_rate_rad_s() > 0.0 && tops.top_speed_m_s(1.0) == 0.0);
    }

    /// Two axles contradict each other in every turn: the mean axle counts.
    #[test]
    fn a_skid_robot_is_expected_to_turn_about_the_middle_of_its_axles() {
        let places_m = [[0.2, 0.2], [0.2, -0.2], [-0.1, 0.2], [-0.1, -0.2]];
        let robot = on_tyres(&places_m);
        let rho = robot.wheels[0].radius_m;
        let kinematics = Kinematics::new(&robot).expect("it drives");
        let twist = kinematics.twist(&[-2.0, 2.0, -2.0, 2.0]);
        let omega = rho * 4.0 / 0.4;
        // The middle, 0.05 m ahead, stands still.
        assert!(close(twist, Twist::new(0.0, -0.05 * omega, omega)));
        let about = kinematics.about(Vector2::new(0.05, 0.0)).expect("finite");
        assert!(close(
            about.twist(&[-2.0, 2.0, -2.0, 2.0]),
            Twist::new(0.0, 0.0, omega)
        ));
    }

    /// A module that stands parallel to others for a moment goes on to hold its own hub: n . v + x
    /// omega = 0 each. Of axles that nothing steers the mean counts, x = 0.05 m here.
    #[test]
    fn steered_tyres_hold_a_row_each_where_they_stand_parallel() {
        let robot = on_tyres(&[[0.2, 0.2], [0.2, -0.2], [-0.1, 0.2], [-0.1, -0.2]]);
        let levers_m = |steered: [bool; 4]| -> Vec<f64> {
            let mounts = steered.map(|of| match of {
                true => Mount::Steered(Vector2::zeros()),
                false => Mount::Fixed,
            });
            let rows = held_rows(robot.wheels.iter().zip(mounts), Vector2::zeros());
            rows.iter().map(|row| row.z * row.y.signum()).collect()
        };
        let close = |one: Vec<f64>, other: &[f64]| {
            let off = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
            one.len() == other.len() && one.iter().zip(other).all(off)
        };
        assert!(close(levers_m([true; 4]), &[0.2, 0.2, -0.1, -0.1]));
        assert!(close(levers_m([false; 4]), &[0.05]));
        assert!(close(
            levers_m([true, true, false, false]),
            &[0.2, 0.2, -0.1]
        ));
        assert!(close(
            levers_m([false, false, true, true]),
            &[0.2, -0.1, -0.1]
        ));
    }

    /// Two axles at +-10 degrees meet in one point: a turn about it is all that they leave.
    #[test]
    fn axles_of_two_directions_leave_the_turn_about_their_meeting_point() {
        let mut robot = on_tyres(&[[0.3, 0.2], [0.3, -0.2], [-0.3, 0.0]]);
        for (wheel, deg) in robot.wheels.iter_mut().zip([10.0_f64, 10.0, -10.0]) {
            let turn = nalgebra::UnitQuaternion::from_axis_angle(
                &nalgebra::Vector3::z_axis(),
                deg.to_radians(),
            );
            wheel.body_from_hub.rotation = turn * wheel.body_from_hub.rotation;
        }
        let kinematics = Kinematics::new(&robot).expect("it turns");
        let turn = kinematics.reachable(Twist::new(0.4, 0.3, 0.5));
        assert!(kinematics.sideways_m_s(turn) < 1e-12 && turn.omega_rad_s == 0.5);
        assert!(close(kinematics.reachable(turn), turn));
    }

    /// A robot of two driven tyres and a caster's behind them, which stands across: its motion is
    /// that of the two alone.
    #[test]
    fn a_caster_on_a_tyre_changes_no_motion() {
        let bare = on_tyres(&[[0.0, 0.2], [0.0, -0.2]]);
        let mut robot = on_tyres(&[[0.0, 0.2], [0.0, -0.2], [-0.3, 0.0]]);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * 1.5);
        robot.wheels[2].body_from_hub.rotation = turn * robot.wheels[2].body_from_hub.rotation;
        let at_m = robot.wheels[2].position_m();
        robot.joints = vec![joint(at_m, Vector3::z(), (0.1, Vector3::zeros()))];
        robot.wheels[2].carrier = Some(0);
        robot.wheels[2].motor.effort_n_m = 0.0;
        let twist = Twist::new(0.4, 0.0, 0.7);
        let [without, with] = [bare, robot].map(|robot| {
            let kinematics = Kinematics::new(&robot).expect("it drives");
            let mut contact = ContactKinematics::new(&robot).expect("it drives");
            let mut rates = [0.0; 3];
            kinematics.wheel_rates(twist, &mut rates);
            assert_eq!(rates[2], 0.0);
            let found = [kinematics.twist(&rates), contact.twist(&[0.0; 3], &rates)];
            assert!(found.iter().all(|of| close(*of, twist)), "{found:?}");
            assert!(close(kinematics.reachable(twist), twist));
            // However the caster spins, it contradicts nothing.
            let count = robot.wheels.len();
            let spun = [rates[0], rates[1], 7.0];
            let mut off = vec![1.0; count];
            kinematics.contradiction(&spun[..count], &mut off);
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{off:?}");
            kinematics.residuals(twist, &spun[..count], &mut off);
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{off:?}");
            (rates, Arrangement::of(&robot).expect("it drives").reachable)
        });
        assert_eq!(without, with);
    }

    #[test]
    fn one_tyre_alone_is_refused() {
        let error = Kinematics::new(&on_tyres(&[[0.0, 0.0]])).unwrap_err();
        assert_eq!(error, ControlError::TooFewWheels { count: 1 });
    }
}
