//! Ground with a nap, and ground with other properties for rollers of another material, against
//! derivations by hand.

use crate::support;

use std::f64::consts::{FRAC_PI_2, PI};

use ilon_robot::{Pose, Robot, Tread, Twist};
use ilon_world::{
    ContactSolver, ContactSurface, Floor, FloorSurface, Nap, Patch, Push, Settings, World,
    WorldError,
};
use nalgebra::{Vector2, Vector3};
use support::rig::follow;
use support::{mecanum4, volksbot};

const G: f64 = 9.81;

/// Isotropic values, which a test then changes.
fn plain(angle_rad: f64, surface: &FloorSurface) -> Nap {
    Nap {
        angle_rad,
        friction_ratio: 1.0,
        creep_across: surface.creep,
        resistance_across: surface.rolling_resistance,
        resistance_against: surface.rolling_resistance,
    }
}

fn world(robot: &Robot, floor: &Floor, start: Pose) -> World {
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    World::new(robot, floor, start, &settings).expect("valid")
}

fn on(surface: FloorSurface) -> Floor {
    Floor {
        surface,
        ..Floor::default()
    }
}

#[test]
fn drag_over_a_nap_is_the_gradient_of_the_power_that_rolling_takes() {
    // Under Swedish wheels without tilt the place of contact moves as the robot does. With
    // h = sqrt(c_a^2 V_a^2 + c_c^2 V_c^2), and against the nap its own c_a, the drives pay m g
    // h(V) / |V| for each metre, and the drag is m g dh / dV: across the way too. Three wheels
    // whose motors give K for each rad/s that they lag behind hold 3 K / (2 r^2) newtons for each
    // m/s of the robot.
    const K: f64 = 1.0;
    let (along, across, against, v) = (0.02, 0.06, 0.04, 0.2);
    let robot = volksbot();
    let surface = FloorSurface {
        rolling_resistance: along,
        ..FloorSurface::default()
    };
    let angle_rad = 0.5;
    let napped = FloorSurface {
        nap: Some(Nap {
            resistance_across: across,
            resistance_against: against,
            ..plain(angle_rad, &surface)
        }),
        ..surface
    };
    for way_rad in [0.5, 0.5 + FRAC_PI_2, 0.5 + PI, 1.1, -1.7] {
        let twist = Twist::new(v * f64::cos(way_rad), v * f64::sin(way_rad), 0.0);
        let drive = |surface: FloorSurface| {
            let mut world = world(&robot, &on(surface), Pose::default());
            follow(&mut world, &robot, twist, 1.0, 0.0);
            let (began_j, from) = (world.motor_energy_j(), world.robot().state().pose);
            follow(&mut world, &robot, twist, 1.0, 0.0);
            let way_m = world.robot().state().pose.position_m() - from.position_m();
            (way_m, (world.motor_energy_j() - began_j) / way_m.norm())
        };
        let (hard_m, hard_n) = drive(FloorSurface::default());
        let (way_m, pays_n) = drive(napped);
        let nap = Vector2::new(f64::cos(angle_rad), f64::sin(angle_rad));
        let (lies, stands) = (nap.dot(&way_m), nap.perp(&way_m));
        let with = if lies > 0.0 { along } else { against };
        let h = (with * lies).hypot(across * stands);
        let weight_n = robot.mass_kg() * G;
        let expected_n = weight_n * h / way_m.norm();
        // As for isotropic drag: hand-overs of other rollers, a hundredth.
        let drag_n = pays_n - hard_n;
        assert!(
            (drag_n / expected_n - 1.0).abs() < 0.01,
            "{way_rad}: {drag_n} {expected_n}"
        );
        let pulls = Vector2::new(
            with * with * lies * nap.x - across * across * stands * nap.y,
            with * with * lies * nap.y + across * across * stands * nap.x,
        );
        let expected_n = weight_n / h * pulls;
        let lags_n = 1.5 * K / robot.wheels[0].radius_m.powi(2) * (hard_m - way_m);
        assert!(
            (lags_n - expected_n).norm() < 0.01 * expected_n.norm(),
            "{way_rad}: {lags_n} {expected_n}"
        );
    }
}

/// Wheels whose rims are 30 degrees off the direction of motion, pulled back by F: each slips along
/// its rim by c_e v f / N with c_e = e . C e; its rollers turn freely for slip across the rim. The
/// robot falls back by v c_e F / (1.5 N).
#[test]
fn creep_over_a_nap_is_that_of_the_direction_of_the_pull() {
    let (v, pull_n, along, across) = (0.3, -2.0, 0.05, 0.2);
    let robot = volksbot();
    let load_n = robot.mass_kg() * G / 3.0;
    let twist = Twist::new(v, 0.0, 0.0);
    let short = |robot: &Robot, angle_rad: f64| {
        let surface = FloorSurface {
            creep: along,
            ..FloorSurface::default()
        };
        let nap = Nap {
            creep_across: across,
            ..plain(angle_rad, &surface)
        };
        let of = |pull_n: f64| {
            let surface = FloorSurface {
                nap: Some(nap),
                ..surface
            };
            let mut world = world(robot, &on(surface), Pose::default());
            follow(&mut world, robot, twist, 1.0, pull_n);
            let (x_m, angles) = (
                world.robot().state().pose.x_m,
                world.robot().wheel_angles_rad().to_vec(),
            );
            follow(&mut world, robot, twist, 1.0, pull_n);
            let turned = world.robot().wheel_angles_rad().iter().zip(&angles);
            let rates: Vec<f64> = turned.map(|(a, b)| a - b).collect();
            (world.robot().state().pose.x_m - x_m) / support::ideal_twist(robot, &rates).vx_m_s
        };
        of(0.0) - of(pull_n)
    };
    for (angle_rad, effective) in [
        (0.0, 0.75 * along + 0.25 * across),
        (FRAC_PI_2, 0.25 * along + 0.75 * across),
    ] {
        let expected = effective * -pull_n / (1.5 * load_n);
        let rigid = short(&robot, angle_rad);
        // The smaller creep of a slower robot is of second order in the pull.
        assert!((rigid / expected - 1.0).abs() < 0.02, "{rigid} {expected}");
        let mut treaded = robot.clone();
        for wheel in &mut treaded.wheels {
            wheel.surface.tread = Some(Tread::new(1e5));
        }
        let soft = short(&treaded, angle_rad);
        assert!((soft / expected - 1.0).abs() < 0.05, "{soft} {expected}");
    }
}

/// The robot as a sledge: wheels held fast, rollers seized.
fn sledge(robot: &Robot, floor: &Floor) -> World {
    let mut robot = robot.clone();
    for wheel in &mut robot.wheels {
        wheel.joint.friction_n_m = 1e4;
    }
    let mut world = world(&robot, floor, Pose::default());
    for (wheel, of) in robot.wheels.iter().enumerate() {
        (0..of.rollers.len())
            .for_each(|roller| world.robot_mut().seize_roller(wheel, roller, true));
    }
    world
}

#[test]
fn a_sledge_over_a_nap_begins_to_slide_on_its_ellipse_and_along_its_normal() {
    let (mu, ratio, angle_rad) = (0.5, 0.6, 0.3);
    let surface = FloorSurface::default();
    let floor = Floor {
        friction: mu,
        surface: FloorSurface {
            nap: Some(Nap {
                friction_ratio: ratio,
                ..plain(angle_rad, &surface)
            }),
            ..surface
        },
        ..Floor::default()
    };
    let robot = mecanum4();
    let weight_n = robot.mass_kg() * G;
    for pull_rad in [0.3, 1.1, 0.3 + FRAC_PI_2, 2.6] {
        let (s, c) = f64::sin_cos(pull_rad - angle_rad);
        let limit_n = weight_n / (c / mu).hypot(s / (ratio * mu));
        let pulled = |share: f64| {
            let mut world = sledge(&robot, &floor);
            let (y, x) = f64::sin_cos(pull_rad);
            for _ in 0..100 {
                world.robot_mut().push(&Push {
                    force_in_world_n: share * limit_n * Vector3::new(x, y, 0.0),
                    place_in_body_m: Vector3::zeros(),
                });
                world.robot_mut().apply(&[0.0; 4]);
                world.step();
            }
            let (twist, contacts) = (
                world.robot().state().twist_in_body,
                world.robot().contacts().to_vec(),
            );
            (
                Vector2::new(twist.vx_m_s, twist.vy_m_s),
                contacts,
                world.slip_energy_j(),
            )
        };
        // Rounding and the tilt by a pull at the ground: a hundredth.
        let (held, ..) = pulled(0.99);
        assert!(held.norm() < 1e-5, "{held}");
        let (slides, contacts, slip_j) = pulled(1.05);
        let (along, across) = (c / mu.powi(2), s / (ratio * mu).powi(2));
        let (sa, ca) = f64::sin_cos(angle_rad);
        let normal = Vector2::new(ca * along - sa * across, sa * along + ca * across).normalize();
        // It moves along the normal: the remaining pull is a twentieth of it, and changes direction
        // by a part of that.
        let off = slides.normalize().perp(&normal).abs();
        assert!(slides.norm() > 1e-2 && off < 0.12, "{slides} {normal}");
        assert!(slip_j > 0.0);
        for contact in contacts {
            // The reported coefficient is that of the friction's own direction.
            let used = contact.force_in_body_n.norm() / contact.normal_force_n;
            assert!(
                (used / contact.friction - 1.0).abs() < 1e-3,
                "{used} {}",
                contact.friction
            );
        }
    }
}

/// All effects of a nap at once.
fn carpet(angle_rad: f64) -> FloorSurface {
    FloorSurface {
        rolling_resistance: 0.04,
        radius_exponent: 0.5,
        creep: 0.2,
        sliding: None,
        nap: Some(Nap {
            angle_rad,
            friction_ratio: 0.7,
            creep_across: 0.5,
            resistance_across: 0.09,
            resistance_against: 0.06,
        }),
    }
}

#[test]
fn a_robot_that_is_turned_is_a_floor_that_is_turned_back() {
    // Three wheels: four share the weight in ways that rounding decides, and over a nap the drag
    // depends on each share.
    for tread in [None, Some(Tread::new(1e5))] {
        let mut robot = volksbot();
        for wheel in &mut robot.wheels {
            wheel.surface.tread = tread;
        }
        let drive = |heading_rad: f64, floor_rad: f64| {
            let floor = on(carpet(floor_rad));
            let start = Pose {
                heading_rad,
                ..Pose::default()
            };
            let mut world = world(&robot, &floor, start);
            follow(&mut world, &robot, Twist::new(0.3, 0.4, 0.8), 1.5, 3.0);
            let pose = world.robot().state().pose;
            let (s, c) = heading_rad.sin_cos();
            let (x, y) = (pose.x_m, pose.y_m);
            let in_body =
                Vector3::new(c * x + s * y, c * y - s * x, pose.heading_rad - heading_rad);
            (in_body, world.slip_energy_j(), world.bearing_energy_j())
        };
        let quarter = FRAC_PI_2;
        for angle_rad in [quarter, -0.6] {
            let (turned, slip_j, bearing_j) = drive(angle_rad, 0.4 + angle_rad);
            let (straight, straight_slip_j, straight_bearing_j) = drive(0.0, 0.4);
            // Rates are rounded to f32 in the world's frame: 1e-7 of 0.5 m/s in each of 1500 steps.
            assert!((turned - straight).norm() < 1e-4, "{turned} {straight}");
            assert!((slip_j / straight_slip_j - 1.0).abs() < 1e-3);
            assert!((bearing_j / straight_bearing_j - 1.0).abs() < 1e-3);
            // And the nap has an effect at all.
            let (across, ..) = drive(0.0, 0.4 + angle_rad);
            assert!((across - straight).norm() > 1e-3, "{across} {straight}");
        }
    }
}

#[test]
fn a_nap_that_is_the_same_in_all_directions_is_none_to_the_bit() {
    let robot = mecanum4();
    let end = |nap: bool, tread: bool| {
        let surface = FloorSurface {
            rolling_resistance: 0.05,
            creep: 0.3,
            ..FloorSurface::default()
        };
        let surface = FloorSurface {
            nap: nap.then(|| plain(0.7, &surface)),
            ..surface
        };
        let mut robot = robot.clone();
        if tread {
            for wheel in &mut robot.wheels {
                wheel.surface.tread = Some(Tread::new(1e5));
            }
        }
        let mut world = world(&robot, &on(surface), Pose::default());
        follow(&mut world, &robot, Twist::new(0.2, 0.3, 0.5), 1.0, 0.0);
        world.robot().state()
    };
    for tread in [false, true] {
        assert_eq!(end(true, tread), end(false, tread));
    }
}

#[test]
fn the_energies_close_over_a_nap() {
    for tread in [None, Some(Tread::new(1e5))] {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.surface.tread = tread;
        }
        let mut world = world(&robot, &on(carpet(0.4)), Pose::default());
        let stored = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
        let began_j = stored(&world);
        follow(&mut world, &robot, Twist::new(0.3, 0.2, 0.5), 3.0, 0.0);
        let lost_j = world.slip_energy_j()
            + world.spin_up_energy_j()
            + world.bearing_energy_j()
            + world.impact_energy_j();
        let unexplained_j =
            world.motor_energy_j() + world.outside_energy_j() - lost_j - (stored(&world) - began_j);
        let share = unexplained_j.abs() / world.motor_energy_j();
        // f32 rates and second order: as for isotropic floors.
        assert!(share < 2e-3, "{share}");
    }
}

/// Two wheels of rubber and two of steel, on a floor that acts like wet steel on steel: each slides
/// at its own limit.
#[test]
fn each_wheel_grips_as_its_own_pair_of_materials_and_patches_have_pairs_too() {
    let mut robot = mecanum4();
    for (index, wheel) in robot.wheels.iter_mut().enumerate() {
        wheel.material = Some(if index % 2 == 0 { "rubber" } else { "steel" }.to_owned());
    }
    let footing = |friction| ContactSurface {
        friction,
        surface: FloorSurface::default(),
    };
    let floor = Floor {
        friction: 0.6,
        materials: vec!["steel".to_owned(), "rubber".to_owned()],
        footings: vec![footing(0.1), footing(0.7)],
        patches: vec![Patch {
            center_m: Vector2::new(10.0, 0.0),
            half_sides_m: Vector2::new(5.0, 5.0),
            friction: 0.2,
            surface: FloorSurface::default(),
            footings: vec![footing(0.3), footing(0.4)],
        }],
        ..Floor::default()
    };
    for (x_m, of_rubber, of_steel) in [(0.0, 0.7, 0.1), (10.0, 0.4, 0.3)] {
        let start = Pose {
            x_m,
            ..Pose::default()
        };
        let mut world = world(&robot, &floor, start);
        follow(&mut world, &robot, Twist::new(0.2, 0.0, 0.0), 0.5, 0.0);
        let frictions: Vec<f64> = world
            .robot()
            .contacts()
            .iter()
            .map(|c| c.friction)
            .collect();
        assert_eq!(frictions, [of_rubber, of_steel, of_rubber, of_steel]);
        // A friction set later applies to all; without it, each has its own again.
        world.set_friction(Some(0.5), &floor.patches);
        world.step();
        let of_all = if x_m == 0.0 { 0.5 } else { of_rubber };
        assert_eq!(world.robot().contacts()[0].friction, of_all);
        world.set_friction(None, &floor.patches);
        world.step();
        assert_eq!(world.robot().contacts()[0].friction, of_rubber);
    }
}

#[test]
fn ground_that_makes_no_sense_is_refused() {
    let nap = plain(0.0, &FloorSurface::default());
    let of = |nap: Nap| FloorSurface {
        nap: Some(nap),
        ..FloorSurface::default()
    };
    let build = |floor: Floor, contacts| {
        let settings = Settings {
            contacts,
            ..Settings::default()
        };
        World::new(&mecanum4(), &floor, Pose::default(), &settings).map(drop)
    };
    for bad in [
        Nap {
            friction_ratio: 0.0,
            ..nap
        },
        Nap {
            friction_ratio: f64::NAN,
            ..nap
        },
        Nap {
            angle_rad: f64::INFINITY,
            ..nap
        },
        Nap {
            creep_across: -1.0,
            ..nap
        },
        Nap {
            resistance_across: -1.0,
            ..nap
        },
        Nap {
            resistance_against: f64::NAN,
            ..nap
        },
    ] {
        let refused = build(on(of(bad)), ContactSolver::Ilon);
        assert!(
            matches!(refused, Err(WorldError::Setting { .. })),
            "{refused:?}"
        );
    }
    // A pair for each material, on the floor and on each patch.
    let lacking = Floor {
        materials: vec!["rubber".to_owned()],
        ..Floor::default()
    };
    assert!(build(lacking, ContactSolver::Ilon).is_err());
    // rapier's own solver supports neither.
    let napped = on(of(Nap {
        friction_ratio: 0.5,
        ..nap
    }));
    let paired = Floor {
        materials: vec!["rubber".to_owned()],
        footings: vec![ContactSurface {
            friction: 0.5,
            surface: FloorSurface::default(),
        }],
        ..Floor::default()
    };
    for floor in [napped, paired] {
        let refused = build(floor, ContactSolver::Rapier);
        assert!(
            matches!(refused, Err(WorldError::NotInRapier { .. })),
            "{refused:?}"
        );
    }
}

/// A nap whose creep along it hardly differs from that across it is no nap, in any direction:
/// robots on treads move as without it.
#[test]
fn treads_feel_no_nap_that_makes_no_difference() {
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(Tread::new(2e5));
    }
    let plain_floor = FloorSurface {
        creep: 0.05,
        ..FloorSurface::default()
    };
    let went = |surface: FloorSurface| {
        let mut world = world(&robot, &on(surface), Pose::default());
        follow(&mut world, &robot, Twist::new(0.2, 0.3, 0.5), 1.0, 0.0);
        world.robot().state().pose
    };
    let without = went(plain_floor);
    for angle_rad in [0.0, 0.5, 1.2] {
        let napped = FloorSurface {
            nap: Some(Nap {
                creep_across: plain_floor.creep * (1.0 + 1e-9),
                ..plain(angle_rad, &plain_floor)
            }),
            ..plain_floor
        };
        let with = went(napped);
        let apart_m = (with.position_m() - without.position_m()).norm();
        println!("{angle_rad}: {apart_m:e} m of {:?}", without.position_m());
        // The share of a deflection that follows the velocity after a step depends on the response
        // along the nap instead of along the roller: some 1e-4 of the path.
        assert!(apart_m < 1e-4, "{apart_m:e} m");
    }
}

/// A nap with resistance only against it: with it a robot rolls as on hard ground, and against it
/// it pays c m g per metre.
#[test]
fn a_nap_may_cost_against_it_alone() {
    let robot = volksbot();
    let against = 0.04;
    let surface = FloorSurface {
        nap: Some(Nap {
            resistance_against: against,
            ..plain(0.0, &FloorSurface::default())
        }),
        ..FloorSurface::default()
    };
    let pays_n = |surface: FloorSurface, v_m_s: f64| {
        let mut world = world(&robot, &on(surface), Pose::default());
        let twist = Twist::new(v_m_s, 0.0, 0.0);
        follow(&mut world, &robot, twist, 1.0, 0.0);
        let (began_j, from) = (world.motor_energy_j(), world.robot().state().pose);
        follow(&mut world, &robot, twist, 1.0, 0.0);
        let way_m = (world.robot().state().pose.position_m() - from.position_m()).norm();
        (world.motor_energy_j() - began_j) / way_m
    };
    let weight_n = robot.mass_kg() * G;
    for (v_m_s, expected_n) in [(0.2, 0.0), (-0.2, against * weight_n)] {
        let more_n = pays_n(surface, v_m_s) - pays_n(FloorSurface::default(), v_m_s);
        println!("{v_m_s} m/s: {more_n} of {expected_n} N");
        // Rollers spin up slightly differently under drag: a hundredth of it.
        assert!((more_n - expected_n).abs() < 0.01 * against * weight_n);
    }
}
