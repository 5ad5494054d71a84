use nalgebra::Matrix3;

use super::*;
use crate::{Body, Collision, CollisionShape, Coupling, JointServo, JointSpring, MassProperties};

pub fn joint(parent: Option<usize>, kind: JointKind, at_m: Vector3<f64>) -> BodyJoint {
    BodyJoint {
        name: "joint".to_owned(),
        parent,
        kind,
        body_from_joint: Isometry3::from(at_m),
        body: Body {
            name: "body".to_owned(),
            mass: MassProperties {
                mass_kg: 2.0,
                center_of_mass_m: Vector3::new(0.4, 0.0, 0.1),
                inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.3)),
            },
            collisions: Vec::new(),
        },
        role: JointRole::Free,
        limits: [-1.0, 2.0],
        damping: 0.0,
        friction: 0.0,
    }
}

pub fn robot(joints: Vec<BodyJoint>) -> Robot {
    Robot {
        name: "posed".to_owned(),
        chassis: crate::Chassis {
            name: "base".to_owned(),
            mass: MassProperties::point(1.0, Vector3::zeros()),
            collisions: Vec::new(),
        },
        joints,
        couplings: Vec::new(),
        wheels: Vec::new(),
        remarks: Vec::new(),
    }
}

/// A lift that raises a turntable: the arm's centre, 0.4 m out and 0.1 m up on a pivot at (0.2,
/// 0.1), turned by a right angle and raised by 0.3 m.
#[test]
fn what_hangs_by_what_moves_with_it() {
    let lift = joint(None, JointKind::Slides, Vector3::new(0.0, 0.0, 0.5));
    let mut arm = joint(Some(0), JointKind::Turns, Vector3::new(0.2, 0.1, 0.7));
    arm.role = JointRole::Driven(JointServo {
        target: 1.5,
        ..JointServo::for_inertia(1.0)
    });
    // A ball about its centre, in the body frame.
    arm.body.collisions.push(Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.6, 0.1, 0.8),
        shape: CollisionShape::Sphere { radius_m: 0.05 },
    });
    let quarter = std::f64::consts::FRAC_PI_2;
    let posed = robot(vec![lift, arm]).posed(&[0.3, quarter]);
    let expected_m = Vector3::new(0.2, 0.1 + 0.4, 0.7 + 0.1 + 0.3);
    let middle_m = posed.joints[1].center_of_mass_m();
    assert!((middle_m - expected_m).norm() < 1e-15, "{middle_m}");
    let ball = &posed.joints[1].body.collisions[0].body_from_shape;
    assert!((ball.translation.vector - expected_m).norm() < 1e-15);
    assert_eq!(posed.joints[1].limits, [-1.0 - quarter, 2.0 - quarter]);
    assert_eq!(
        posed.joints[1].servo().map(|of| of.target),
        Some(1.5 - quarter)
    );
}

/// A servo starts its joint at 0.8; its follower, and the follower's follower, start as the
/// couplings require, whatever their order; a free joint whose stops exclude zero starts at the
/// nearer one.
#[test]
fn a_run_begins_where_servos_start_and_couplings_follow() {
    let turns = || joint(None, JointKind::Turns, Vector3::zeros());
    let mut whole = robot(vec![turns(), turns(), turns(), turns()]);
    whole.joints[3].role = JointRole::Driven(JointServo {
        target: 0.8,
        ..JointServo::for_inertia(1.0)
    });
    whole.joints[2].limits = [0.3, 2.0];
    let coupling = |joint, follows, factor, offset| Coupling {
        joint,
        follows,
        factor,
        offset,
    };
    whole.couplings = vec![coupling(0, 1, 2.0, 0.1), coupling(1, 3, -1.0, 0.0)];
    let begins = whole.start_positions();
    let expected = [2.0 * -0.8 + 0.1, -0.8, 0.3, 0.8];
    let pairs = begins.iter().zip(expected);
    pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-15, "{begins:?}"));
    assert_eq!(robot(Vec::new()).start_positions(), []);
}

/// An upright arm on a turntable, 2 kg at 0.4 m: upright it adds nothing to the turntable's
/// inertia, tilted to its limit it adds m (l sin q)^2.
#[test]
fn a_turntable_moves_most_where_its_arm_is_laid_over() {
    for limit in [2.0_f64, 0.5] {
        let mut turntable = joint(None, JointKind::Turns, Vector3::zeros());
        turntable.body.mass = MassProperties::point(1.0, Vector3::zeros());
        let mut arm = joint(Some(0), JointKind::Turns, Vector3::zeros());
        let quarter = std::f64::consts::FRAC_PI_2;
        arm.body_from_joint = Isometry3::rotation(-quarter * Vector3::x());
        arm.body.mass = MassProperties::point(2.0, Vector3::new(0.0, -0.4, 0.0));
        arm.limits = [-0.1, limit];
        let whole = robot(vec![turntable, arm]);
        assert!((whole.joints[1].center_of_mass_m().z - 0.4).abs() < 1e-12);
        assert!(whole.inertia_on_joint(0) < 1e-12);
        let expected = 2.0 * (0.4 * limit.min(quarter).sin()).powi(2);
        let most = whole.most_inertia_on_joint(0);
        assert!((most - expected).abs() < 1e-12, "{most} {expected}");
        // The arm carries nothing.
        let [one, other] = [whole.most_inertia_on_joint(1), whole.inertia_on_joint(1)];
        assert_eq!(one.to_bits(), other.to_bits());
    }
}

/// Springs and couplings act in space as before, and posing a posed robot adds the positions.
#[test]
fn springs_and_couplings_stay_in_space_and_poses_add_up() {
    let mut slide = joint(None, JointKind::Slides, Vector3::zeros());
    slide.role = JointRole::Sprung(JointSpring {
        stiffness: 400.0,
        rest: 0.02,
        preload: 3.0,
    });
    let turns = joint(Some(0), JointKind::Turns, Vector3::x());
    let mut whole = robot(vec![slide, turns]);
    whole.couplings.push(Coupling {
        joint: 1,
        follows: 0,
        factor: -2.0,
        offset: 0.1,
    });
    let posed = whole.posed(&[0.05, 0.7]);
    let [before, after] = [&whole, &posed].map(|of| of.joints[0].spring().copied());
    assert!((before.unwrap().force_at(0.08) - after.unwrap().force_at(0.03)).abs() < 1e-12);
    // 0.7 + q = -2 (0.05 + p) + 0.1 is q = -2 p + (0.1 - 0.1 - 0.7).
    assert!((posed.couplings[0].offset + 0.7).abs() < 1e-15);
    let (twice, once) = (posed.posed(&[-0.02, 0.1]), whole.posed(&[0.03, 0.8]));
    for (a, b) in twice.joints.iter().zip(&once.joints) {
        let off = a.body_from_joint.inv_mul(&b.body_from_joint);
        assert!(off.translation.vector.norm() + off.rotation.angle() < 1e-14);
    }
    assert!((twice.couplings[0].offset - once.couplings[0].offset).abs() < 1e-15);
}

#[test]
fn a_rigid_robot_and_one_at_zero_are_as_they_were() {
    let rigid = robot(Vec::new());
    assert_eq!(rigid.posed(&[]), rigid);
    let whole = robot(vec![joint(None, JointKind::Turns, Vector3::y())]);
    assert_eq!(whole.posed(&[]), whole);
}
