//! Robots with wheels on rockers, springs and arms, against statics and mechanics by hand.

use crate::support;

use std::f64::consts::{PI, TAU};

use ilon_robot::{Coupling, JointKind, JointRole, JointSpring, Pose, Robot, Twist};
use ilon_world::{Floor, GroundBox, MotorTorque, Push, Settings, World};
use nalgebra::Vector3;
use support::linked::{
    CARRIER_KG, STIFFNESS_N_M, X_M, Y_M, joint, on_a_rocker, on_arms, on_springs, sprung,
};
use support::{ideal_rates, mecanum4};

const G: f64 = 9.81;

/// A floor with a plate of a height under the wheel at a place.
fn kerb(x_m: f64, y_m: f64, height_m: f64) -> Floor {
    Floor {
        boxes: vec![GroundBox {
            center_m: Vector3::new(x_m, y_m, 0.5 * height_m),
            half_sides_m: Vector3::new(0.06, 0.06, 0.5 * height_m),
            heading_rad: 0.0,
            pitch_rad: 0.0,
        }],
        ..Floor::default()
    }
}

fn settings(dt_s: f64) -> Settings {
    Settings {
        dt_s,
        ..Settings::default()
    }
}

fn stands(robot: &Robot, floor: &Floor) -> World {
    World::new(robot, floor, Pose::default(), &settings(1e-3)).expect("it stands")
}

/// The wheels' loads after the contacts have settled, which takes milliseconds, in N.
fn loads_n(world: &mut World) -> Vec<f64> {
    for _ in 0..10 {
        world.step();
    }
    let contacts = world.robot().contacts().iter();
    contacts.map(|contact| contact.normal_force_n).collect()
}

fn assert_near(value: f64, expected: f64, within: f64, what: &str) {
    assert!(
        (value - expected).abs() <= within * expected.abs(),
        "{what}: {value} where {expected} is expected"
    );
}

/// A quarter of the weight on each wheel; the springs bear only the chassis.
#[test]
fn springs_bear_the_chassis_from_the_start() {
    let robot = on_springs(0.0);
    let mut world = stands(&robot, &Floor::default());
    let sag_m = robot.chassis.mass.mass_kg * G / 4.0 / STIFFNESS_N_M;
    for position_m in world.robot().joint_positions() {
        assert_near(*position_m, sag_m, 1e-6, "sag");
    }
    for load_n in loads_n(&mut world) {
        assert_near(load_n, robot.mass_kg() * G / 4.0, 1e-6, "load");
    }
    // And it stays there: the error of the equilibrium causes an oscillation of less than a
    // millionth of the sag.
    for _ in 0..200 {
        world.step();
    }
    for (position_m, rate_m_s) in
        (world.robot().joint_positions().iter()).zip(world.robot().joint_rates())
    {
        assert_near(*position_m, sag_m, 1e-6, "sag later");
        assert!(rate_m_s.abs() < 1e-6 * sag_m / 1e-3, "{rate_m_s}");
    }
}

/// Four springs of stiffness k share a plate of height h under one of them: its wheel and the
/// opposite one bear k h / 4 more, the others as much less. The part of the loads that no movement
/// of the chassis changes is their warp. A plate of 1 mm tilts the wheels by 1.6 mrad, which
/// changes the reach of their rollers by less than 1e-6 m.
#[test]
fn a_kerb_under_a_sprung_wheel_moves_a_quarter_of_its_springs_force() {
    let height_m = 0.001;
    let mut world = stands(&on_springs(0.0), &kerb(X_M, Y_M, height_m));
    let loads = loads_n(&mut world);
    let warp_n = 0.25 * (loads[0] - loads[1] - loads[2] + loads[3]);
    println!("{loads:?} {:?}", world.robot().joint_positions());
    let expected_n = STIFFNESS_N_M * height_m / 4.0;
    assert_near(warp_n, expected_n, 1e-3, "warp");
}

/// A rocker loads both of its wheels equally, whatever is under one, and turns by the height over
/// the track.
#[test]
fn a_rocker_bears_its_wheels_alike() {
    let height_m = 0.001;
    let robot = on_a_rocker();
    let mut world = stands(&robot, &kerb(-X_M, Y_M, height_m));
    let loads = loads_n(&mut world);
    println!("{loads:?} {:?}", world.robot().joint_positions());
    // Rollers tilted by 3 mrad touch up to 0.2 mm beside their middles, on a half track of 160 mm.
    assert_near(loads[2], loads[3], 2e-3, "rear loads");
    assert_near(loads.iter().sum(), robot.mass_kg() * G, 1e-4, "sum");
    let turned = world.robot().joint_positions()[0];
    assert_near(libm::sin(turned), height_m / (2.0 * Y_M), 1e-2, "turned");
    // The same robot without the rocker stands on a diagonal.
    let mut rigid = stands(&mecanum4(), &kerb(-X_M, Y_M, height_m));
    for _ in 0..500 {
        rigid.step();
    }
    let rigid = loads_n(&mut rigid);
    assert!(rigid.iter().any(|load_n| *load_n < 1.0), "{rigid:?}");
}

/// The contact point of each wheel in the body frame: below its hub as moved by the rocker,
/// wherever the chassis's centre of mass is. The rollers of a wheel tilted by a touch beside their
/// middles, by less than a times the radius of their outline along their axes, rho / sin^2(45
/// deg) = 0.1 m, and their reach is smaller by the square of it.
#[test]
fn wheels_touch_where_the_rocker_has_taken_them() {
    let height_m = 0.006;
    let mut robot = on_a_rocker();
    robot.chassis.mass.center_of_mass_m = Vector3::new(0.04, -0.03, 0.06);
    let mut world = stands(&robot, &kerb(-X_M, Y_M, height_m));
    loads_n(&mut world);
    let body = world.robot();
    let turned = body.joint_positions()[0];
    assert!(turned.abs() > 0.018, "{turned}");
    let up_in_body = body.state().world_from_body.inverse() * Vector3::z();
    let below = |hub_m: Vector3<f64>| hub_m - 0.05 * up_in_body;
    // Turned about an axis along x through the middle between both hubs.
    let rear = |y_m: f64| {
        let (sin, cos) = turned.sin_cos();
        Vector3::new(-X_M, y_m * cos, 0.05 + y_m * sin)
    };
    let hubs_m = [
        Vector3::new(X_M, Y_M, 0.05),
        Vector3::new(X_M, -Y_M, 0.05),
        rear(Y_M),
        rear(-Y_M),
    ];
    for (contact, hub_m) in body.contacts().iter().zip(hubs_m) {
        let off_m = contact.place_in_body_m - below(hub_m);
        assert!(off_m.norm() < 0.1 * turned.abs(), "{off_m}");
        let deeper_m = off_m.dot(&up_in_body);
        assert!(deeper_m.abs() < 0.05 * turned * turned, "{deeper_m}");
    }
}

/// Arms with their centre 50 mm ahead of their wheels move the load of 4 x 0.1 kg forward by as
/// much.
#[test]
fn trailing_arms_move_their_own_weight_forward() {
    let mut robot = on_arms(0.0);
    let load_n = robot.mass_kg() * G / 4.0;
    // Level: each spring bears its wheel's load without the mass on the arm, at 0.1 and 0.05 m from
    // the pivot.
    let wheel_kg = 0.25 + 9.0 * 0.01;
    let preload = (load_n - wheel_kg * G) * 0.1 - CARRIER_KG * G * 0.05;
    for joint in &mut robot.joints {
        joint.role = JointRole::Sprung(JointSpring {
            stiffness: STIFFNESS_N_M * 0.1 * 0.1,
            rest: 0.0,
            preload: -preload,
        });
    }
    let mut world = stands(&robot, &Floor::default());
    let loads = loads_n(&mut world);
    println!("{loads:?} {:?}", world.robot().joint_positions());
    let moved_n = 4.0 * CARRIER_KG * G * 0.05 / (4.0 * X_M);
    for (index, load_n) in loads.iter().enumerate() {
        let side = if index < 2 { 1.0 } else { -1.0 };
        let expected_n = robot.mass_kg() * G / 4.0 + side * moved_n;
        assert_near(*load_n, expected_n, 1e-3, "load");
    }
}

/// A chassis of m on four springs k oscillates at sqrt(4 k / m), and keeps its energy.
#[test]
fn a_sprung_chassis_bounces_at_its_frequency() {
    let robot = on_springs(0.0);
    let mut world = stands(&robot, &Floor::default());
    world.step();
    world.robot_mut().push(&Push {
        force_in_world_n: Vector3::new(0.0, 0.0, 1000.0),
        place_in_body_m: robot.chassis.mass.center_of_mass_m,
    });
    world.step();
    let total_j = |world: &World| {
        let energy = world.energy();
        energy.kinetic_j + energy.potential_j + world.impact_energy_j() + world.slip_energy_j()
    };
    let from_j = total_j(&world);
    let kicked_j = world.energy().kinetic_j;
    let sag_m = robot.chassis.mass.mass_kg * G / 4.0 / STIFFNESS_N_M;
    let mut passes_s = Vec::new();
    let mut before_m = world.robot().joint_positions()[0] - sag_m;
    let mut worst_j: f64 = 0.0;
    while passes_s.len() < 21 {
        world.step();
        let now_m = world.robot().joint_positions()[0] - sag_m;
        if before_m * now_m < 0.0 {
            passes_s.push(world.time_s() - 1e-3 * now_m / (now_m - before_m));
        }
        before_m = now_m;
        worst_j = worst_j.max((total_j(&world) - from_j).abs());
        assert!(world.time_s() < 5.0);
    }
    let frequency_hz = 10.0 / (passes_s[20] - passes_s[0]);
    let expected_hz = (4.0 * STIFFNESS_N_M / robot.chassis.mass.mass_kg).sqrt() / TAU;
    println!("{frequency_hz} {expected_hz} {worst_j:e} of {kicked_j}");
    assert_near(frequency_hz, expected_hz, 1e-3, "frequency");
    assert!(worst_j < 1e-4 * kicked_j, "{worst_j} of {kicked_j}");
}

/// The error of the energy balance of a drive, and the motors' work, in J.
fn open_j(robot: &Robot, twist: Twist, dt_s: f64) -> (f64, f64) {
    let mut world =
        World::new(robot, &Floor::default(), Pose::default(), &settings(dt_s)).expect("it stands");
    world.step();
    let stored_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let spent_j = |world: &World| {
        world.slip_energy_j()
            + world.spin_up_energy_j()
            + world.impact_energy_j()
            + world.bearing_energy_j()
            - world.motor_energy_j()
    };
    let from_j = stored_j(&world) + spent_j(&world);
    let target = ideal_rates(robot, twist);
    while world.time_s() < 1.5 {
        let share = (world.time_s() / 0.5).min(1.0);
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let motors: Vec<MotorTorque> = rates
            .iter()
            .zip(&target)
            .map(|(rate, target)| MotorTorque::with_droop(0.5 * (share * target - rate), 0.5))
            .collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
    let open_j = stored_j(&world) + spent_j(&world) - from_j;
    (open_j.abs(), world.motor_energy_j())
}

#[test]
fn the_energy_of_drives_on_springs_and_arms_closes_to_second_order() {
    let ahead = Twist::new(1.0, 0.0, 0.0);
    for robot in [on_springs(30.0), on_arms(0.3)] {
        let (coarse_j, work_j) = open_j(&robot, ahead, 1e-3);
        let (fine_j, _) = open_j(&robot, ahead, 5e-4);
        let (rigid_j, _) = open_j(&mecanum4(), ahead, 1e-3);
        println!("{coarse_j:e} {fine_j:e} of {work_j}; rigid {rigid_j:e}");
        assert!(coarse_j < 1e-5 * work_j, "{coarse_j} of {work_j}");
        // Below 1e-7 of the work only rounding and hand-overs remain.
        assert!(
            fine_j < 0.3 * coarse_j + 1e-7 * work_j,
            "{fine_j} {coarse_j}"
        );
    }
}

/// A slide without a spring is on its stop and bears as if it were fixed there. It fell on it
/// without gaining energy.
#[test]
fn a_joint_lies_on_its_stop() {
    let mut robot = on_springs(0.0);
    for joint in &mut robot.joints {
        joint.role = JointRole::Free;
        joint.limits = [-0.01, 0.004];
    }
    let mut world = stands(&robot, &Floor::default());
    for load_n in loads_n(&mut world) {
        assert_near(load_n, robot.mass_kg() * G / 4.0, 1e-4, "load");
    }
    for position_m in world.robot().joint_positions() {
        assert_near(*position_m, 0.004, 1e-4, "stop");
    }
    // Thrown up, the wheels fall to the other stop, and everything comes down again.
    world.robot_mut().push(&Push {
        force_in_world_n: Vector3::new(0.0, 0.0, 2e4),
        place_in_body_m: robot.chassis.mass.center_of_mass_m,
    });
    let before_j = world.energy().kinetic_j + world.energy().potential_j;
    let mut gained_j = f64::NEG_INFINITY;
    for _ in 0..1000 {
        world.step();
        for position_m in world.robot().joint_positions() {
            assert!(
                (-0.01 - 1e-4..0.004 + 1e-4).contains(position_m),
                "{position_m}"
            );
        }
        let now_j = world.energy().kinetic_j + world.energy().potential_j;
        gained_j = gained_j.max(now_j - before_j - world.outside_energy_j());
    }
    // It received 20 J; impacts take a part of it.
    println!("{gained_j}");
    assert!(gained_j < 1e-3 * world.outside_energy_j(), "{gained_j}");
    for load_n in loads_n(&mut world) {
        assert_near(load_n, robot.mass_kg() * G / 4.0, 1e-2, "load afterwards");
    }
}

/// Seven joints may follow one another from the chassis on, a wheel's own among them.
#[test]
fn a_wheel_counts_among_the_joints_of_its_chain() {
    let refused = |joints: usize, carries: bool| {
        let mut robot = mecanum4();
        for index in 0..joints {
            let middle_m = Vector3::new(0.0, 0.0, 0.1);
            let law = (JointKind::Turns, sprung(STIFFNESS_N_M));
            let mut link = joint("link", law, (middle_m, Vector3::y()), (0.3, middle_m));
            link.parent = index.checked_sub(1);
            robot.joints.push(link);
        }
        if carries {
            robot.wheels[0].carrier = Some(joints - 1);
        }
        let world = World::new(&robot, &Floor::default(), Pose::default(), &settings(1e-3));
        let told = world.err().map(|error| error.to_string());
        told.is_some_and(|told| told.contains("follow one another from the chassis on"))
    };
    assert_eq!([refused(7, false), refused(8, false)], [false, true]);
    assert_eq!([refused(6, true), refused(7, true)], [false, true]);
}

/// A differential bar turns one side's rocker backwards by as much as the other's forwards, so that
/// four wheels have equal loads on any kerb.
#[test]
fn a_differential_bar_couples_two_rockers() {
    let mut robot = mecanum4();
    for (index, side) in [1.0, -1.0].into_iter().enumerate() {
        let middle_m = Vector3::new(0.0, side * Y_M, 0.1);
        let law = (JointKind::Turns, JointRole::Free);
        robot.joints.push(joint(
            "side",
            law,
            (middle_m, Vector3::y()),
            (0.3, middle_m),
        ));
        for wheel in &mut robot.wheels {
            if wheel.position_m().y * side > 0.0 {
                wheel.carrier = Some(index);
            }
        }
    }
    robot.couplings.push(Coupling {
        joint: 1,
        follows: 0,
        factor: -1.0,
        offset: 0.0,
    });
    let mut world = stands(&robot, &kerb(X_M, Y_M, 0.01));
    let loads = loads_n(&mut world);
    let positions = world.robot().joint_positions();
    println!("{loads:?} {positions:?}");
    assert!((positions[0] + positions[1]).abs() < 1e-9);
    // The front left wheel is h higher: each side turns by half of h over the base.
    assert_near(positions[0].abs(), 0.5 * 0.01 / (2.0 * X_M), 1e-2, "turned");
    // The four loads have one warp, which the bar leaves free.
    let warp_n = loads[0] - loads[1] - loads[2] + loads[3];
    assert!(warp_n.abs() < 1e-2 * robot.mass_kg() * G, "{loads:?}");
}

/// Dry friction makes the loads of a rocker's wheels unequal, by its torque over the half track at
/// most.
#[test]
fn dry_friction_parts_the_loads_of_a_rocker() {
    for friction in [0.0, 0.5, 1.0] {
        let mut robot = on_a_rocker();
        robot.joints[0].friction = friction;
        let mut world = stands(&robot, &kerb(-X_M, Y_M, 0.001));
        let loads = loads_n(&mut world);
        println!("{friction} {loads:?}");
        let moment = (loads[2] - loads[3]) * Y_M;
        // The settling of the contacts is some 1e-3 of a load.
        assert!((moment - friction).abs() < 0.02, "{friction}: {moment}");
    }
}

/// In the air, a robot on springs keeps its energy, to second order in the step.
#[test]
fn a_thrown_robot_on_arms_keeps_its_energy() {
    let robot = on_arms(0.0);
    let lost = |dt_s: f64| {
        let settings = Settings {
            gravity_m_s2: 0.0,
            ..settings(dt_s)
        };
        let mut world =
            World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("it stands");
        let kick = |force_n: Vector3<f64>, place_in_body_m: Vector3<f64>| Push {
            force_in_world_n: force_n * (1e-3 / dt_s),
            place_in_body_m,
        };
        world.robot_mut().push(&kick(
            Vector3::new(0.0, 0.0, 2e4),
            Vector3::new(0.0, 0.0, 0.06),
        ));
        world.step();
        world.robot_mut().push(&kick(
            Vector3::new(0.0, 1e3, 1e3),
            Vector3::new(0.1, 0.05, 0.2),
        ));
        world.step();
        let total_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
        let from_j = total_j(&world);
        while world.time_s() < 0.5 {
            world.step();
        }
        ((total_j(&world) - from_j) / from_j).abs()
    };
    let (coarse, fine) = (lost(5e-4), lost(2.5e-4));
    println!("{coarse:e} {fine:e}");
    assert!(coarse < 1e-4, "{coarse}");
    // Of second order, or better.
    assert!(fine < 0.3 * coarse, "{fine} {coarse}");
}

/// A robot and its mirror image behave alike.
#[test]
fn a_kerb_on_the_other_side_loads_the_other_wheels() {
    for robot in [on_springs(0.0), on_a_rocker()] {
        let mut left = stands(&robot, &kerb(-X_M, Y_M, 0.005));
        let mut right = stands(&robot, &kerb(-X_M, -Y_M, 0.005));
        let (left, right) = (loads_n(&mut left), loads_n(&mut right));
        for (of_left, of_right) in [(0, 1), (1, 0), (2, 3), (3, 2)] {
            // The touching rollers have mirrored axes, and reach the plate slightly differently.
            let (a, b) = (left[of_left], right[of_right]);
            assert!(
                (a - b).abs() < 1e-3 * robot.mass_kg() * G,
                "{left:?} {right:?}"
            );
        }
    }
}

/// A spring of k on an arm turns like one of k over the arm's length squared on a slide: within the
/// effect of the arm's arc.
#[test]
fn an_arm_sags_as_a_slide_does() {
    let slides = stands(&on_springs(0.0), &Floor::default());
    let arms = stands(&on_arms(0.0), &Floor::default());
    let sag_m = slides.robot().joint_positions()[0];
    let turned = arms.robot().joint_positions()[0].abs();
    assert!(turned > 0.0 && turned < PI / 8.0);
    // The arm also bears half of its own weight.
    let expected = sag_m / 0.1;
    assert_near(turned, expected, 0.05, "turned");
}

/// A joint with a spring whose period is less than 1.5 steps is refused; one with a longer period
/// is accepted, and its robot stands.
#[test]
fn a_spring_that_no_step_can_follow_is_refused_and_another_is_not() {
    const STEP_S: f64 = 1e-3;
    let stands = |steps: f64| {
        let mut robot = on_springs(0.0);
        robot.wheels[0].carrier = None;
        let omega_rad_s = std::f64::consts::TAU / (steps * STEP_S);
        robot.joints[0].role = sprung(robot.inertia_on_joint(0) * omega_rad_s.powi(2));
        World::new(
            &robot,
            &Floor::default(),
            Pose::default(),
            &settings(STEP_S),
        )
        .map(|_| ())
    };
    let error = stands(1.49).expect_err("it swings too fast").to_string();
    assert!(error.contains("within 1.5 steps of 1.000 ms"), "{error}");
    assert!(stands(1.51).is_ok(), "{:?}", stands(1.51));
}

/// Invalid trees, and numbers that no step can follow, are refused with the joint's name and a
/// remedy.
#[test]
fn hostile_trees_are_refused_in_words() {
    type Spoils = fn(&mut Robot);
    let cases: [(&str, Spoils); 11] = [
        ("without mass", |robot| {
            robot.joints[0].body.mass.mass_kg = 0.0
        }),
        ("not below its upper", |robot| {
            robot.joints[0].limits = [0.1, -0.1]
        }),
        ("not below its upper", |robot| {
            robot.joints[0].limits = [f64::NAN, 0.1]
        }),
        ("stiffness above 0", |robot| {
            robot.joints[0].role = sprung(0.0)
        }),
        ("finite and not below 0", |robot| {
            robot.joints[0].damping = -1.0
        }),
        ("its parent is itself", |robot| {
            robot.joints[0].parent = Some(0)
        }),
        ("within 1.5 steps", |robot| {
            // A gram on a spring of 1e9 N/m has a period of 6 us.
            robot.wheels[0].carrier = None;
            robot.joints[0].body.mass.mass_kg = 1e-3;
            robot.joints[0].role = sprung(1e9);
        }),
        ("at most 7", |robot| {
            for parent in 0..7 {
                let mut next = robot.joints[0].clone();
                next.parent = Some(if parent == 0 { 0 } else { 3 + parent });
                robot.joints.push(next);
            }
        }),
        ("must follow another joint", |robot| {
            robot.couplings.push(Coupling {
                joint: 0,
                follows: robot.joints.len(),
                factor: 1.0,
                offset: 0.0,
            });
        }),
        ("by a finite factor", |robot| {
            robot.couplings.push(Coupling {
                joint: 0,
                follows: 1,
                factor: f64::INFINITY,
                offset: 0.0,
            });
        }),
        ("follows itself", |robot| {
            for (joint, follows) in [(0, 1), (1, 0)] {
                robot.couplings.push(Coupling {
                    joint,
                    follows,
                    factor: 1.0,
                    offset: 0.0,
                });
            }
        }),
    ];
    for (words, spoil) in cases {
        let mut robot = on_springs(0.0);
        spoil(&mut robot);
        let error = World::new(&robot, &Floor::default(), Pose::default(), &settings(1e-3));
        let error = error.err().expect(words).to_string();
        assert!(
            error.contains(words) && error.contains("slide"),
            "{words}: {error}"
        );
    }
}
