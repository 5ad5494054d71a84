//! Disturbances of the robot against derivations by hand: momentum, weights, Coulomb's law, and an
//! energy balance that closes.

use crate::support;

use ilon_robot::{Pose, Robot, Twist};
use ilon_world::{Floor, FloorSurface, Patch, Payload, Push, RollerBodies, Settings, World};
use nalgebra::{Matrix6, Vector2, Vector3};
use support::{brake, ideal_rates, mecanum4, seize_all, volksbot};
use test_case::test_case;

const G: f64 = 9.81;

fn world(robot: &Robot, friction: f64, roller_bodies: RollerBodies) -> World {
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let settings = Settings {
        roller_bodies,
        ..Settings::default()
    };
    World::new(robot, &floor, Pose::default(), &settings).expect("a valid world")
}

/// Runs the world for a time under PI loops that keep the wheels at their rates.
fn hold(world: &mut World, targets: &[f64], duration_s: f64, mut each: impl FnMut(&mut World)) {
    let dt_s = world.dt_s();
    let mut integral = vec![0.0; targets.len()];
    for _ in 0..(duration_s / dt_s).round() as usize {
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let torques: Vec<f64> = (0..rates.len())
            .map(|i| {
                let error = targets[i] - rates[i];
                integral[i] += error * dt_s;
                0.1 * error + integral[i]
            })
            .collect();
        world.robot_mut().apply(&torques);
        each(world);
        world.step();
    }
}

fn mass_kg(robot: &Robot) -> f64 {
    let wheels = robot
        .wheels
        .iter()
        .map(|wheel| wheel.hub.mass_kg + wheel.rollers.iter().map(|r| r.mass_kg).sum::<f64>());
    robot.chassis.mass.mass_kg + wheels.sum::<f64>()
}

/// Inertia about the vertical axis through the body frame's origin, part by part.
fn yaw_inertia_kg_m2(robot: &Robot) -> f64 {
    let mut sum = robot.chassis.mass.inertia_kg_m2[(2, 2)];
    for wheel in &robot.wheels {
        // Hub axes are horizontal: an axially symmetric hub has its transverse inertia about the
        // vertical.
        sum += wheel.hub.inertia_kg_m2[(0, 0)]
            + wheel.hub.mass_kg * wheel.position_m().xy().norm_squared();
        for roller in &wheel.rollers {
            let at = wheel.body_from_hub * nalgebra::Point3::from(roller.center_in_hub_m);
            let along = (wheel.body_from_hub.rotation * roller.axis_in_hub.into_inner()).z;
            sum += roller.mass_kg * at.coords.xy().norm_squared()
                + roller.transverse_inertia_kg_m2 * (1.0 - along * along)
                + roller.axial_inertia_kg_m2 * along * along;
        }
    }
    sum
}

/// On a frictionless floor only the push acts in the plane: m v = J, I omega = x J, and the work
/// done is the kinetic energy of both.
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn a_push_gives_its_momentum_and_its_work(roller_bodies: RollerBodies) {
    let robot = mecanum4();
    let mut world = world(&robot, 0.0, roller_bodies);
    hold(&mut world, &[0.0; 4], 0.2, |_| ());
    let energy_before_j = world.energy().kinetic_j;
    let (impulse_n_s, arm_m) = (2.0, 0.2);
    let dt_s = world.dt_s();
    world.robot_mut().push(&Push {
        force_in_world_n: Vector3::y() * (impulse_n_s / dt_s),
        // At the height of the centre of mass, so that nothing tips.
        place_in_body_m: Vector3::new(arm_m, 0.0, 0.06),
    });
    world.robot_mut().apply(&[0.0; 4]);
    world.step();
    // In the world's frame: by the end of the step the body has turned by omega dt / 2.
    let body = world.robot().state();
    let twist = body.twist_in_body.rotated(body.pose.heading_rad);
    let (m, i) = (mass_kg(&robot), yaw_inertia_kg_m2(&robot));
    let (vy, omega) = (impulse_n_s / m, arm_m * impulse_n_s / i);
    // f32 velocities after an f32 factorisation of 46 degrees of freedom: a few parts in 10^5.
    assert!(
        (twist.vy_m_s / vy - 1.0).abs() < 1e-4,
        "{twist:?}, {vy} m/s"
    );
    assert!(
        (twist.omega_rad_s / omega - 1.0).abs() < 1e-4,
        "{twist:?}, {omega} rad/s"
    );
    assert!(twist.vx_m_s.abs() < 1e-4 * vy);
    let work_j = 0.5 * m * vy * vy + 0.5 * i * omega * omega;
    assert!((world.outside_energy_j() / work_j - 1.0).abs() < 2e-4);
    let gained_j = world.energy().kinetic_j - energy_before_j;
    // The centre of all masses is a millimetre below the push, which causes a small tipping motion.
    assert!(
        (gained_j / work_j - 1.0).abs() < 2e-3,
        "{gained_j} J of {work_j} J"
    );

    // A push lasts one step: nothing acts any more.
    let before = world.robot().state().twist_in_body;
    world.robot_mut().apply(&[0.0; 4]);
    world.step();
    assert!((world.robot().state().twist_in_body.vy_m_s - before.vy_m_s).abs() < 1e-4 * vy);
}

/// Three wheels carry a load by statics: N_i = W/3 + 2/(3 b^2) b_i . (first moment of the weight).
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn a_payload_weighs_on_the_wheels_beneath_it(roller_bodies: RollerBodies) {
    let robot = volksbot();
    let mut world = world(&robot, 0.6, roller_bodies);
    let (carried_kg, at_m) = (3.0, Vector3::new(0.1, -0.05, 0.15));
    hold(&mut world, &[0.0; 3], 0.3, |_| ());
    world
        .robot_mut()
        .carry(&[Payload::new(carried_kg, at_m).expect("a payload")]);
    hold(&mut world, &[0.0; 3], 0.5, |_| ());
    let mut sums_n = [0.0; 3];
    hold(&mut world, &[0.0; 3], 0.2, |world| {
        for (sum, contact) in sums_n.iter_mut().zip(world.robot().contacts()) {
            *sum += contact.normal_force_n;
        }
    });
    let steps = (0.2 / world.dt_s()).round();
    let weight_n = (mass_kg(&robot) + carried_kg) * G;
    for (wheel, sum_n) in robot.wheels.iter().zip(sums_n) {
        let b = wheel.position_m().xy();
        let expected_n =
            weight_n / 3.0 + 2.0 / (3.0 * b.norm_squared()) * b.dot(&at_m.xy()) * carried_kg * G;
        // The contact's spring and f32 are less than a thousandth.
        assert!(
            (sum_n / steps / expected_n - 1.0).abs() < 1e-3,
            "{} N instead of {expected_n} N",
            sum_n / steps
        );
    }
}

/// A payload comes and goes at the velocity of its place: the robot's motion does not change, and
/// only the payload's own energy enters or leaves.
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn a_payload_put_on_in_passing_changes_no_velocity_and_brings_its_own_energy(
    roller_bodies: RollerBodies,
) {
    let robot = mecanum4();
    let mut world = world(&robot, 0.6, roller_bodies);
    let targets = ideal_rates(&robot, Twist::new(0.3, 0.0, 0.5));
    hold(&mut world, &targets, 1.0, |_| ());

    let (carried_kg, at_m) = (4.0, Vector3::new(0.1, 0.05, 0.2));
    let (before, energy_before) = (world.robot().state(), world.energy());
    world
        .robot_mut()
        .carry(&[Payload::new(carried_kg, at_m).expect("a payload")]);
    let (after, energy_after) = (world.robot().state(), world.energy());
    let off = after.twist_in_body - before.twist_in_body;
    // The centre of mass moves by d = 0.03 m. Twists are in the frame at the start of the last
    // step, which differs by omega dt: omega d omega dt = 1.6e-5 m/s.
    assert!(
        off.vx_m_s.abs() < 2e-5 && off.vy_m_s.abs() < 2e-5 && off.omega_rad_s == 0.0,
        "{off:?}"
    );
    assert!((after.pose.x_m - before.pose.x_m).abs() < 1e-12);

    // The place moves with v + omega x r: its height hardly differs from 0.2 m.
    let t = before.twist_in_body;
    let velocity = Vector2::new(
        t.vx_m_s - t.omega_rad_s * at_m.y,
        t.vy_m_s + t.omega_rad_s * at_m.x,
    );
    let own_j = carried_kg * (0.5 * velocity.norm_squared() + G * 0.2);
    let gained_j = energy_after.kinetic_j + energy_after.potential_j
        - energy_before.kinetic_j
        - energy_before.potential_j;
    assert!((world.outside_energy_j() - gained_j).abs() < 1e-9 * own_j);
    // Contacts that sink in by micrometres and a twist in the frame before the step: parts in 10^4.
    assert!(
        (gained_j / own_j - 1.0).abs() < 5e-4,
        "{gained_j} J instead of {own_j} J"
    );

    world.robot_mut().apply(&[0.0; 4]);
    world.step();
    let next = world.robot().state().twist_in_body - after.twist_in_body;
    // One step of rolling friction and of contacts that take up the weight: millimetres per second.
    assert!(next.vx_m_s.abs() < 5e-3, "{next:?}");

    world.robot_mut().carry(&[]);
    let left_j = carried_kg * 0.5 * velocity.norm_squared() * 0.1;
    assert!(
        world.outside_energy_j().abs() < left_j,
        "what came goes again"
    );
}

/// With every roller seized the wheels are plain discs: pushed along their axles the robot slides
/// and Coulomb friction decelerates it by mu g, until it stands. All its kinetic energy becomes
/// heat of sliding.
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn seized_rollers_slide_as_coulomb_says_and_free_ones_roll(roller_bodies: RollerBodies) {
    const MU: f64 = 0.3;
    let robot = mecanum4();
    let m = mass_kg(&robot);
    let slowed_by = |seized: bool| {
        let mut world = world(&robot, MU, roller_bodies);
        if seized {
            seize_all(&mut world, &robot);
        }
        hold(&mut world, &[0.0; 4], 0.2, |_| ());
        let dt_s = world.dt_s();
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::y() * (m * 0.5 / dt_s),
            place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
        });
        let free = |world: &mut World, duration_s: f64| {
            for _ in 0..(duration_s / world.dt_s()).round() as usize {
                world.robot_mut().apply(&[0.0; 4]);
                world.step();
            }
        };
        free(&mut world, 0.02);
        let (fast, slip_j) = (
            world.robot().state().twist_in_body.vy_m_s,
            world.slip_energy_j(),
        );
        free(&mut world, 0.1);
        let slow = world.robot().state().twist_in_body.vy_m_s;
        let lost_j = 0.5 * m * (fast * fast - slow * slow);
        let heat_j = world.slip_energy_j() - slip_j;
        free(&mut world, 0.3);
        let end = world.robot().state().twist_in_body.vy_m_s;
        ((fast - slow) / 0.1, heat_j / lost_j, end)
    };
    let (deceleration, heat_share, end) = slowed_by(true);
    // Oscillation on the contacts' springs affects single steps, not the mean over fifty.
    assert!(
        (deceleration / (MU * G) - 1.0).abs() < 0.01,
        "{deceleration} m/s^2"
    );
    assert!(
        (heat_share - 1.0).abs() < 1e-3,
        "{heat_share} of the motion ends as heat"
    );
    // 0.5 m/s over 2.94 m/s^2: at rest after 0.17 s.
    assert!(end.abs() < 1e-4, "{end} m/s");
    let (rolling, ..) = slowed_by(false);
    assert!(rolling < 0.1 * MU * G, "{rolling} m/s^2");
}

/// One seized roller of one wheel: while it touches, and only then, it does not turn and slides.
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn a_seized_roller_does_not_spin_and_its_neighbours_do(roller_bodies: RollerBodies) {
    let robot = mecanum4();
    let mut world = world(&robot, 0.6, roller_bodies);
    world.robot_mut().seize_roller(1, 4, true);
    // A wheel or roller that does not exist is ignored.
    world.robot_mut().seize_roller(9, 0, true);
    world.robot_mut().seize_roller(0, 99, true);
    let targets = ideal_rates(&robot, Twist::new(0.0, 0.2, 0.0));
    let (mut seized_spin, mut seized_slip) = (0.0f64, 0.0f64);
    let mut others_spin = f64::INFINITY;
    hold(&mut world, &targets, 0.5, |_| ());
    hold(&mut world, &targets, 2.0, |world| {
        let contact = world.robot().contacts()[1];
        if !contact.touching {
            return;
        }
        let slip = contact.sliding_in_body_m_s.norm();
        if contact.roller == 4 {
            seized_spin = seized_spin.max(contact.roller_spin_rad_s.abs());
            seized_slip = seized_slip.max(slip);
        } else {
            others_spin = others_spin.min(contact.roller_spin_rad_s.abs());
        }
    });
    assert!(seized_spin < 1e-3, "{seized_spin} rad/s");
    // Sideways at 0.2 m/s a roller at 45 deg rolls at 0.28 m/s, or slides as fast while the others
    // drag it along.
    assert!(seized_slip > 0.1, "{seized_slip} m/s");
    assert!(others_spin > 5.0, "{others_spin} rad/s");
}

/// The spin energy of rollers that seize goes into their bearings at once: it equals the loss of
/// kinetic energy.
#[test]
fn the_spin_of_rollers_that_seize_goes_into_their_bearings() {
    let robot = mecanum4();
    let mut world = world(&robot, 0.6, RollerBodies::All);
    let targets = ideal_rates(&robot, Twist::new(0.0, 0.2, 0.0));
    hold(&mut world, &targets, 0.5, |_| ());
    let (moving_j, lost_j) = (world.energy().kinetic_j, world.bearing_energy_j());
    seize_all(&mut world, &robot);
    let stopped_j = moving_j - world.energy().kinetic_j;
    let into_bearings_j = world.bearing_energy_j() - lost_j;
    assert!(stopped_j > 0.0, "{stopped_j} J");
    // Differences of some joules.
    assert!(
        (into_bearings_j - stopped_j).abs() < 1e-14,
        "{into_bearings_j} J of {stopped_j} J"
    );
}

/// Pulled at 0.45 of its weight, a robot whose wheels cannot roll sideways stands on mu 0.6, slides
/// with (0.45 - 0.3) g once the floor is wet, and comes to rest on the dry patch beyond.
#[test_case(RollerBodies::All; "every roller a body")]
#[test_case(RollerBodies::Near; "in the contact window")]
fn a_floor_that_turns_slippery_lets_go_of_what_it_held(roller_bodies: RollerBodies) {
    let robot = mecanum4();
    let mut world = world(&robot, 0.6, roller_bodies);
    seize_all(&mut world, &robot);
    let pull = Push {
        force_in_world_n: Vector3::y() * (0.45 * mass_kg(&robot) * G),
        place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
    };
    let pulled = |world: &mut World, duration_s: f64| {
        hold(world, &[0.0; 4], duration_s, |world| {
            world.robot_mut().push(&pull)
        });
    };
    hold(&mut world, &[0.0; 4], 0.2, |_| ());
    pulled(&mut world, 0.5);
    let held_m_s = world.robot().state().twist_in_body.vy_m_s;
    assert!(held_m_s.abs() < 1e-4, "{held_m_s} m/s on dry ground");

    world.set_friction(Some(0.3), &[]);
    pulled(&mut world, 0.1);
    let start_m_s = world.robot().state().twist_in_body.vy_m_s;
    pulled(&mut world, 0.2);
    let acceleration = (world.robot().state().twist_in_body.vy_m_s - start_m_s) / 0.2;
    assert!(
        (acceleration / (0.15 * G) - 1.0).abs() < 0.01,
        "{acceleration} m/s^2"
    );

    let dry = Patch {
        center_m: Vector2::zeros(),
        half_sides_m: Vector2::new(10.0, 10.0),
        friction: 0.6,
        surface: FloorSurface::default(),
        footings: Vec::new(),
    };
    world.set_friction(Some(0.3), &[dry]);
    let start_m_s = world.robot().state().twist_in_body.vy_m_s;
    pulled(&mut world, 0.2);
    let acceleration = (world.robot().state().twist_in_body.vy_m_s - start_m_s) / 0.2;
    assert!(
        (acceleration / (-0.15 * G) - 1.0).abs() < 0.01,
        "{acceleration} m/s^2"
    );
}

#[test]
fn a_payload_without_mass_or_place_is_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Payload::new(bad, Vector3::zeros()).is_err());
    }
    assert!(Payload::new(1.0, Vector3::new(0.0, f64::NAN, 0.0)).is_err());
}

/// A pure moment of M for a step turns the robot on ice by I omega = M dt, about its middle, and
/// its work is the robot's kinetic energy.
#[test]
fn a_moment_gives_its_angular_momentum_and_its_work() {
    let robot = mecanum4();
    let mut world = world(&robot, 0.0, RollerBodies::All);
    hold(&mut world, &[0.0; 4], 0.2, |_| ());
    let dt_s = world.dt_s();
    let given_n_m_s = 0.4;
    world.robot_mut().turn(Vector3::z() * (given_n_m_s / dt_s));
    world.robot_mut().apply(&[0.0; 4]);
    world.step();
    let twist = world.robot().state().twist_in_body;
    let inertia_kg_m2 = yaw_inertia_kg_m2(&robot);
    let omega_rad_s = given_n_m_s / inertia_kg_m2;
    // Rollers tilted with their wheels turn a little about their axles: some parts in 10^5.
    assert!(
        (twist.omega_rad_s / omega_rad_s - 1.0).abs() < 1e-4,
        "{twist:?}, {omega_rad_s} rad/s"
    );
    assert!(twist.vx_m_s.hypot(twist.vy_m_s) < 1e-6);
    let work_j = 0.5 * inertia_kg_m2 * omega_rad_s.powi(2);
    assert!((world.outside_energy_j() / work_j - 1.0).abs() < 2e-4);
}

/// A robot with held wheels that is pushed without sliding is kept in place by the ground's forces
/// on its wheels: their sum is the opposite of the push, in the body's axes, at any heading.
#[test]
fn the_ground_holds_a_pushed_robot_by_the_opposite_force() {
    let robot = mecanum4();
    for heading_rad in [0.0, 0.9] {
        let start = Pose {
            heading_rad,
            ..Pose::default()
        };
        let floor = Floor::default();
        let mut world = World::new(&robot, &floor, start, &Settings::default()).expect("valid");
        let push_n = Vector3::new(8.0, -5.0, 0.0);
        for _ in 0..500 {
            brake(&mut world);
            world.robot_mut().push(&Push {
                force_in_world_n: push_n,
                place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
            });
            world.step();
        }
        let contacts = world.robot().contacts();
        let sum_n: Vector2<f64> = contacts.iter().map(|of| of.force_in_body_n.xy()).sum();
        let (s, c) = heading_rad.sin_cos();
        let expected_n = -Vector2::new(c * push_n.x + s * push_n.y, c * push_n.y - s * push_n.x);
        // Braked wheels creep by the push over their brakes' droop, and no longer accelerate.
        assert!(
            (sum_n - expected_n).norm() < 1e-3 * push_n.norm(),
            "{sum_n} {expected_n}"
        );
    }
}

/// The ground under a standing robot tilts: what its weight has less of potential energy then, (1 -
/// cos 10 deg) of that above the origin, the ground took.
#[test]
fn ground_that_tilts_takes_the_potential_energy() {
    let robot = volksbot();
    let mut world = world(&robot, 0.5, RollerBodies::Near);
    let before_j = world.energy().potential_j;
    let (sin, cos) = 10f64.to_radians().sin_cos();
    // To its side, where its middle is.
    world.lean(&Vector3::new(0.0, sin, -cos));
    let after_j = world.energy().potential_j;
    assert!(
        (after_j / before_j - cos).abs() < 1e-6,
        "{before_j} {after_j}"
    );
    let outside_j = world.outside_energy_j();
    assert!(
        (outside_j - (after_j - before_j)).abs() < 1e-12,
        "{outside_j}"
    );
}

/// An inertia that is coupled to the chassis stays where it is when a payload moves the chassis's
/// centre of mass: the robot moves as if it had been coupled after the payload was put on. Places
/// differ by rounding.
#[test]
fn what_is_attached_stays_at_its_place_under_a_payload() {
    let payload = Payload::new(8.0, Vector3::new(0.2, 0.1, 0.1)).expect("a payload");
    let inertia = Matrix6::from_diagonal_element(3.0);
    let ends = [true, false].map(|is_first| {
        let robot = mecanum4();
        let mut world = world(&robot, 0.5, RollerBodies::Near);
        if is_first {
            world.robot_mut().attach(Some(&inertia));
        }
        world.robot_mut().carry(&[payload]);
        if !is_first {
            world.robot_mut().attach(Some(&inertia));
        }
        for _ in 0..100 {
            world.robot_mut().apply(&[0.3, -0.1, 0.2, 0.4]);
            world.step();
        }
        world.robot().state().pose
    });
    let off_m = (ends[0].position_m() - ends[1].position_m()).norm();
    assert!(ends[0].position_m().norm() > 1e-4, "{ends:?}");
    assert!(off_m < 1e-9, "{off_m}");
    assert!((ends[0].heading_rad - ends[1].heading_rad).abs() < 1e-9);
}
