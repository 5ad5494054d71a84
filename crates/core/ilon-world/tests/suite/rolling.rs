//! Rolling resistance against derivations by hand.

use crate::free::hold;
use crate::support;

use std::f64::consts::FRAC_PI_4;

use ilon_robot::{
    Collision, CollisionShape, ModelledRoller, Pose, Profile, ProfilePart, Robot, RollerForm,
    RollersAsMade, Twist,
};
use ilon_world::{Floor, FloorSurface, MotorTorque, Settings, World, WorldError};
use nalgebra::{Isometry3, Vector2};
use support::rig::follow;
use support::{ideal_rates, ideal_twist, mecanum4, mecanum6, volksbot, with_phases};

const G: f64 = 9.81;

fn on(robot: &Robot, floor: &Floor, start: Pose) -> World {
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    World::new(robot, floor, start, &settings).expect("valid")
}

fn world(robot: &Robot, resistance: f64, slope_rad: f64, start: Pose) -> World {
    let floor = Floor {
        surface: FloorSurface {
            rolling_resistance: resistance,
            ..FloorSurface::default()
        },
        slope_rad,
        ..Floor::default()
    };
    on(robot, &floor, start)
}

/// The contact of a wheel, in the floor's frame, with the load in N.
#[derive(Clone, Copy)]
struct Place {
    at_m: Vector2<f64>,
    load_n: f64,
    /// Sliding velocity of the roller there, in m/s.
    slides_m_s: Vector2<f64>,
    /// The roller, if only one touches.
    roller: Option<usize>,
}

fn places(world: &World) -> Vec<Place> {
    let pose = world.robot().state().pose;
    let (s, c) = pose.heading_rad.sin_cos();
    let turned = |v: Vector2<f64>| Vector2::new(c * v.x - s * v.y, s * v.x + c * v.y);
    let contacts = world.robot().contacts().iter();
    contacts
        .map(|contact| Place {
            at_m: pose.position_m() + turned(contact.place_in_body_m.xy()),
            slides_m_s: turned(contact.sliding_in_body_m_s),
            load_n: contact.normal_force_n,
            roller: (contact.touching_rollers == 1).then_some(contact.roller),
        })
        .collect()
}

/// With lossless bearings each metre by which a contact point moves over the ground takes c N,
/// whichever body turns. The contact points are those reported by the world, and nothing of the law
/// is used.
#[test]
fn rolling_takes_its_share_of_the_load_for_each_metre_that_the_places_move() {
    let c = 0.1;
    let mut crowned = mecanum4();
    for wheel in &mut crowned.wheels {
        let made = RollersAsMade {
            crown: 0.6,
            ..RollersAsMade::default()
        };
        wheel.make_rollers(made, None).expect("rollers");
    }
    for (name, robot) in [
        ("mecanum4", mecanum4()),
        ("mecanum6", mecanum6()),
        ("crowned", crowned),
        ("volksbot", volksbot()),
    ] {
        // A robot on crowned wheels rocks from step to step when it drives at an angle.
        let twists = if name == "crowned" { 2 } else { 4 };
        for twist in &[
            Twist::new(0.3, 0.0, 0.0),
            Twist::new(0.0, 0.3, 0.0),
            Twist::new(0.2, 0.2, 0.0),
            Twist::new(0.1, -0.2, 0.5),
        ][..twists]
        {
            let mut world = world(&robot, c, 0.0, Pose::default());
            follow(&mut world, &robot, *twist, 1.0, 0.0);
            let mut shares = Vec::new();
            let (mut before, mut before_j) = (places(&world), world.bearing_energy_j());
            for _ in 0..1500 {
                follow(&mut world, &robot, *twist, 1e-3, 0.0);
                let (now, now_j) = (places(&world), world.bearing_energy_j());
                let pairs = || before.iter().zip(&now);
                // When a roller comes down, or two share the load, the contact point jumps.
                if pairs().all(|(then, now)| then.roller.is_some() && then.roller == now.roller) {
                    let drag_j = |(then, now): (&Place, &Place)| {
                        c * then.load_n * (now.at_m - then.at_m - 1e-3 * now.slides_m_s).norm()
                    };
                    let expected_j: f64 = pairs().map(drag_j).sum();
                    shares.push((now_j - before_j) / expected_j);
                }
                (before, before_j) = (now, now_j);
            }
            // The law uses the loads at the beginning of a step, and the points are those in the
            // middle of steps: one or two hundredths. When a contact point leaves a barrel for its
            // end within a step its speed falls by a factor of ten.
            assert!(shares.len() > 400, "{name} {twist:?}");
            shares.sort_by(f64::total_cmp);
            let at = |share: f64| shares[(share * shares.len() as f64) as usize];
            let (low, middle, high) = (at(0.1), at(0.5), at(0.9));
            assert!(
                low > 0.98 && (middle - 1.0).abs() < 0.01 && high < 1.02,
                "{name} {twist:?}: {low} {middle} {high}"
            );
        }
    }
}

/// On ground with a rolling resistance of half of the load a robot on mecanum wheels covers the
/// commanded distance, as long as the force of no wheel reaches its grip: driving at 45 degrees two
/// wheels stand still and roll on their rollers, across which a moment of c N r needs a force of c
/// N.
#[test]
fn drag_below_the_grip_makes_no_roller_slide() {
    let robot = mecanum4();
    let v = 0.2 * FRAC_PI_4.cos();
    let mut world = world(&robot, 0.3, 0.0, Pose::default());
    let twist = Twist::new(v, v, 0.0);
    follow(&mut world, &robot, twist, 1.0, 0.0);
    let (from, angles) = (
        world.robot().state().pose,
        world.robot().wheel_angles_rad().to_vec(),
    );
    let slid_j = world.slip_energy_j();
    follow(&mut world, &robot, twist, 2.0, 0.0);
    let turned = world.robot().wheel_angles_rad().iter().zip(&angles);
    let turned: Vec<f64> = turned.map(|(now, then)| now - then).collect();
    let asked = ideal_twist(&robot, &turned);
    let way_m = world.robot().state().pose.position_m() - from.position_m();
    // The motion of the contact point along the rollers within a pitch: a hundredth, as on a floor
    // without drag.
    let share = way_m.norm() / asked.vx_m_s.hypot(asked.vy_m_s);
    assert!((share - 1.0).abs() < 0.02, "{share}");
    let rolling_j = 0.3 * robot.mass_kg() * G * way_m.norm();
    assert!(world.slip_energy_j() - slid_j < 1e-3 * rolling_j);
}

/// A robot with free wheels stands on a slope of angle a while c > tan a, at any heading, and rolls
/// down beyond it. With Swedish wheels the limit is sharp; with mecanum wheels the contact points
/// move further than the robot, and more drag is needed to move it.
#[test]
fn a_robot_stands_on_a_slope_below_its_rolling_resistance_whichever_way_it_faces() {
    let slope_rad: f64 = 0.05;
    for (robot, rolls_at) in [(volksbot(), 0.97), (mecanum4(), 0.4)] {
        for heading_rad in [0.0, 0.5, 1.6, 2.8] {
            let after = |share: f64| {
                let start = Pose {
                    heading_rad,
                    ..Pose::default()
                };
                let mut world = world(&robot, share * slope_rad.tan(), slope_rad, start);
                (0..1000).for_each(|_| world.step());
                let pose = world.robot().state().pose;
                (pose.position_m() - start.position_m()).norm()
            };
            // The slope shifts the robot's loads, and their sum is its weight.
            let (stands_m, rolls_m) = (after(1.03), after(rolls_at));
            assert!(stands_m < 1e-6, "{heading_rad}: {stands_m}");
            assert!(rolls_m > 1e-3, "{heading_rad}: {rolls_m}");
        }
    }
}

/// On a floor where small radii cost more, each wheel of a robot on Swedish wheels takes c N
/// sqrt(V1^2 + ((rho / s)^p V2)^2), V1 along its rim, where the outline is the wheel's circle of
/// radius rho, and V2 across it, where it rolls on a roller with the radius s = rho - a / cos(phi),
/// at the angle phi from the roller's middle.
#[test]
fn small_radii_cost_more_where_the_floor_says_so() {
    let (c, v) = (0.05, 0.2);
    let robot = volksbot();
    for exponent in [0.5, 1.0] {
        for way_rad in [0.3, 0.8, 1.3] {
            let twist = Twist::new(v * f64::cos(way_rad), v * f64::sin(way_rad), 0.0);
            // The drives' work per metre, and the mean loads of the wheels: drag reduces those of
            // the front ones.
            let drive = |resistance: f64| {
                let floor = Floor {
                    surface: FloorSurface {
                        rolling_resistance: resistance,
                        radius_exponent: exponent,
                        ..FloorSurface::default()
                    },
                    ..Floor::default()
                };
                let mut world = on(&robot, &floor, Pose::default());
                follow(&mut world, &robot, twist, 1.0, 0.0);
                let (began_j, from) = (world.motor_energy_j(), world.robot().state().pose);
                let mut loads_n = [0.0; 3];
                for _ in 0..4000 {
                    follow(&mut world, &robot, twist, 1e-3, 0.0);
                    for (mean, place) in loads_n.iter_mut().zip(places(&world)) {
                        *mean += place.load_n / 4000.0;
                    }
                }
                let way_m = world.robot().state().pose.position_m() - from.position_m();
                ((world.motor_energy_j() - began_j) / way_m.norm(), loads_n)
            };
            let (plain_n, _) = drive(0.0);
            let (dragged_n, loads_n) = drive(c);
            let wheels = robot.wheels.iter().zip(loads_n);
            let expected_n: f64 = wheels
                .map(|(wheel, load_n)| {
                    let (axis, way) = (wheel.axis(), Vector2::new(way_rad.cos(), way_rad.sin()));
                    let (v1, v2) = (axis.perp(&way), axis.dot(&way));
                    let (rho, a) = (wheel.radius_m, wheel.rollers[0].ring_radius_m());
                    let half_pitch = std::f64::consts::PI / wheel.rollers.len() as f64;
                    let at = |phi: f64| {
                        let s = rho - a / phi.cos();
                        c * load_n * v1.hypot((rho / s).powf(exponent) * v2)
                    };
                    // The mean over a pitch, by the middles of its parts.
                    let parts = (0..100).map(|i| at(half_pitch * (f64::from(i) + 0.5) / 100.0));
                    parts.sum::<f64>() / 100.0
                })
                .sum();
            let drag_n = dragged_n - plain_n;
            // Every wheel turns by some rollers more or less than whole pitches: a hundredth.
            assert!(
                (drag_n / expected_n - 1.0).abs() < 0.01,
                "{exponent} {way_rad}: {drag_n} {expected_n}"
            );
        }
    }
}

/// The rollers' own resistance is the same on any ground: one with a radius exponent but zero
/// resistance changes nothing to the bit.
#[test]
fn ground_that_takes_nothing_by_radius_leaves_rollers_their_own_drag() {
    let run = |of_rollers: f64, radius_exponent: f64| {
        let mut robot = mecanum4();
        let wheels = robot.wheels.iter_mut();
        wheels.for_each(|wheel| wheel.surface.rolling_resistance = of_rollers);
        let floor = Floor {
            surface: FloorSurface {
                radius_exponent,
                ..FloorSurface::default()
            },
            ..Floor::default()
        };
        let mut world = on(&robot, &floor, Pose::default());
        for _ in 0..100 {
            hold(&mut world, 3.0);
            world.step();
        }
        (world.robot().state(), world.motor_energy_j())
    };
    let (plain, by_radius) = (run(0.05, 0.0), run(0.05, 1.0));
    assert_eq!(plain, by_radius);
    assert!(plain.1 > run(0.0, 0.0).1);
}

/// The radius of a ball for a roller, in metres.
const BALL_M: f64 = 0.012;

/// A roller that is a ball, as modelled in a file.
fn ball() -> RollerForm {
    let part = ProfilePart {
        t_m: 0.0,
        ring_m: 0.0,
        ball_m: BALL_M,
    };
    RollerForm::AsModelled(ModelledRoller {
        shapes: vec![Collision {
            friction: None,
            body_from_shape: Isometry3::identity(),
            shape: CollisionShape::Sphere { radius_m: BALL_M },
        }],
        profile: Profile::of(part),
    })
}

/// Wheels with balls as rollers on a ring of radius c: if the bearing ball is at an angle phi from
/// straight down it touches c cos phi + r below the hub, and does not slide along its axis. So the
/// robot moves with w (c cos phi + r), between two angles by c (sin phi_1 - sin phi_0) + r (phi_1 -
/// phi_0).
#[test]
fn on_balls_of_its_file_a_robot_goes_as_far_as_they_reach_below_its_hubs() {
    const PHASE_RAD: f64 = -0.3;
    let mut robot = with_phases(mecanum4(), &[PHASE_RAD; 4]);
    let rollers = robot.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers);
    rollers.for_each(|roller| roller.form = ball());
    let ring_m = robot.wheels[0].radius_m - BALL_M;
    let mut world = on(&robot, &Floor::default(), Pose::default());
    let mut drive_to = |angle_rad: f64| loop {
        hold(&mut world, 3.0);
        world.step();
        let now_rad = PHASE_RAD + world.robot().wheel_angles_rad()[0];
        if now_rad > angle_rad {
            break (world.robot().state().pose.x_m, now_rad);
        }
    };
    // By then it drives without sliding.
    let (from_m, from_rad) = drive_to(-0.2);
    let (to_m, to_rad) = drive_to(0.0);
    let expected_m = ring_m * (to_rad.sin() - from_rad.sin()) + BALL_M * (to_rad - from_rad);
    let off = (to_m - from_m) / expected_m - 1.0;
    // Each of 70 steps of 0.15 mm finds its places to the f32 of 0.2 m, 1.5e-8 m: together a
    // hundred-thousandth of the way, and four times that.
    assert!(off.abs() < 5e-5, "{off:e}");
}

/// Rollers with the shapes of their file would roll over a soft floor without loss.
#[test]
fn drag_and_creep_are_refused_of_rollers_with_the_shapes_of_their_file() {
    let mut robot = volksbot();
    robot.wheels[1].rollers[3].form = ball();
    let found = |robot: &Robot, surface: FloorSurface| {
        let floor = Floor {
            surface,
            ..Floor::default()
        };
        World::new(robot, &floor, Pose::default(), &Settings::default()).err()
    };
    let drags = FloorSurface {
        rolling_resistance: 0.1,
        ..FloorSurface::default()
    };
    let creeps = FloorSurface {
        creep: 0.1,
        ..FloorSurface::default()
    };
    let name = robot.wheels[1].name.clone();
    let is_refused = |found: Option<WorldError>| match found {
        Some(WorldError::Wheel { wheel, reason }) => {
            wheel == name && reason.contains("resistance and creep are not known")
        }
        _ => false,
    };
    assert_eq!(found(&robot, FloorSurface::default()), None);
    assert!(is_refused(found(&robot, drags)));
    assert!(is_refused(found(&robot, creeps)));
    robot.wheels[1].surface.rolling_resistance = 0.02;
    assert!(is_refused(found(&robot, FloorSurface::default())));
}

/// Each wheel reports its own rollers. Diagonally two wheels stand, each on the middle of a roller,
/// which turns by the way over its radius; the wheels' loops have an error of less than a
/// thousandth. The other two turn at 4 rad/s, so that the roller beneath is left after half of an
/// eighth of a turn, 0.1 s. Its bearing then takes 2.5 of its rate in a second, so that in 0.6 s it
/// goes on by what it rolled in 0.31 s: 0.41 s of 0.7 s, on a radius that is not below two thirds
/// of its middle's.
#[test]
fn each_wheel_tells_of_its_own_rollers() {
    let robot = mecanum4();
    let rates = ideal_rates(&robot, Twist::new(0.1, 0.1, 0.0));
    let mut world = on(&robot, &Floor::default(), Pose::default());
    for _ in 0..700 {
        let now = world.robot().wheel_rates_rad_s().to_vec();
        let motor = |(rate, now): (&f64, &f64)| MotorTorque::with_droop(2.0 * (rate - now), 2.0);
        let motors: Vec<MotorTorque> = rates.iter().zip(&now).map(motor).collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
    let way_m = world.robot().state().pose.position_m().norm();
    let mut stand = 0;
    for (wheel, rate) in rates.iter().enumerate() {
        let angles = world.robot().roller_angles_rad(wheel).map(f64::abs);
        let most_rad = angles.fold(0.0, f64::max);
        let of_way = most_rad * robot.wheels[wheel].rollers[0].radius_m / way_m;
        println!("{wheel}: {rate} rad/s, {of_way}");
        if rate.abs() < 1e-9 {
            stand += 1;
            assert!((of_way - 1.0).abs() < 1e-3, "{wheel}: {of_way}");
        } else {
            assert!(of_way < 0.41 / 0.7 * 1.5, "{wheel}: {of_way}");
        }
    }
    assert_eq!(stand, 2);
}
