//! Robots of one shape and any size move alike (Froude): if lengths grow by s and masses by s^3,
//! times and speeds grow by sqrt(s), forces by s^3, torques and energies by s^4 and stiffnesses by
//! s^2. That holds for every law of contact, friction and drive, and no choice of the program may
//! break it: steps, stiffnesses and thresholds scale with the robot.

use ilon_formats::LoadRobot;
use ilon_robot::{Robot, Wheel};
use ilon_sim::Simulation;
use ilon_sim::scenario::Scenario;

const URDF: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");

/// The scale factors of a robot of s times the size.
#[derive(Clone, Copy)]
struct Size(f64);

impl Size {
    fn length(self) -> f64 {
        self.0
    }
    /// For times and speeds.
    fn time(self) -> f64 {
        self.0.sqrt()
    }
    fn mass(self) -> f64 {
        self.0.powi(3)
    }
    fn force(self) -> f64 {
        self.0.powi(3)
    }
    fn torque(self) -> f64 {
        self.0.powi(4)
    }
    fn inertia(self) -> f64 {
        self.0.powi(5)
    }
    fn stiffness(self) -> f64 {
        self.0.powi(2)
    }

    /// Robot A at this size.
    fn robot(self) -> Robot {
        let mut robot = Robot::from_urdf_str(URDF, "mecanum4").unwrap();
        let chassis = &mut robot.chassis;
        self.scale_mass(&mut chassis.mass);
        for collision in &mut chassis.collisions {
            collision.body_from_shape.translation.vector *= self.length();
            let ilon_robot::CollisionShape::Box { half_extents_m } = &mut collision.shape else {
                panic!("robot A has a box for a chassis");
            };
            *half_extents_m *= self.length();
        }
        for wheel in &mut robot.wheels {
            self.scale_wheel(wheel);
        }
        robot
    }

    fn scale_mass(self, mass: &mut ilon_robot::MassProperties) {
        mass.mass_kg *= self.mass();
        mass.center_of_mass_m *= self.length();
        mass.inertia_kg_m2 *= self.inertia();
    }

    fn scale_joint(self, joint: &mut ilon_robot::Joint) {
        joint.damping_n_m_s *= self.torque() * self.time();
        joint.friction_n_m *= self.torque();
    }

    fn scale_wheel(self, wheel: &mut Wheel) {
        wheel.body_from_hub.translation.vector *= self.length();
        self.scale_mass(&mut wheel.hub);
        self.scale_joint(&mut wheel.joint);
        wheel.radius_m *= self.length();
        wheel.motor.effort_n_m *= self.torque();
        wheel.motor.velocity_rad_s /= self.time();
        for roller in &mut wheel.rollers {
            roller.center_in_hub_m *= self.length();
            roller.radius_m *= self.length();
            roller.length_m *= self.length();
            roller.mass_kg *= self.mass();
            roller.axial_inertia_kg_m2 *= self.inertia();
            roller.transverse_inertia_kg_m2 *= self.inertia();
            self.scale_joint(&mut roller.joint);
        }
    }
}

/// One law: its addition to a drive, at a size.
struct Law {
    name: &'static str,
    keys: fn(Size) -> String,
}

const LAWS: &[Law] = &[
    Law {
        name: "grip",
        keys: |_| "world.floor.friction = 0.6".into(),
    },
    Law {
        name: "sliding",
        keys: |_| "world.floor.friction = 0.05".into(),
    },
    Law {
        name: "Stribeck",
        keys: |s| {
            format!(
                "world.floor.friction = 0.1\nworld.floor.sliding = {{ friction = 0.05, speed_m_s = {:e} }}",
                0.1 * s.time()
            )
        },
    },
    Law {
        name: "drag",
        keys: |_| "world.floor.rolling_resistance = 0.05\nworld.floor.radius_exponent = 0.5".into(),
    },
    Law {
        name: "creep",
        keys: |_| "world.floor.creep = 0.3".into(),
    },
    Law {
        name: "nap",
        keys: |_| {
            "[world.floor]\nfriction = 0.3\nnap_deg = 30.0\nrolling_resistance = 0.05\ncreep = 0.2\nacross = { friction = 0.4, creep = 0.4, rolling_resistance = 0.1 }\nagainst = { rolling_resistance = 0.08 }".into()
        },
    },
    Law {
        name: "slope",
        keys: |_| "world.floor.slope_deg = 8.0".into(),
    },
    Law {
        name: "tread",
        keys: |s| {
            format!(
                "world.floor.friction = 0.3\nrollers.tread = {{ stiffness_n_m = {:e}, relaxation_length_m = {:e} }}",
                1e5 * s.stiffness(),
                5e-3 * s.length()
            )
        },
    },
    Law {
        name: "crown",
        keys: |_| "rollers.crown = 0.8".into(),
    },
    Law {
        name: "cylinders",
        keys: |s| {
            format!(
                "rollers.profile_m = [[{:e}, {:e}], [{:e}, {:e}]]\nrollers.edge_radius_m = {:e}",
                -0.016 * s.length(),
                0.012 * s.length(),
                0.016 * s.length(),
                0.012 * s.length(),
                1e-3 * s.length()
            )
        },
    },
    Law {
        name: "unequal",
        keys: |s| format!("rollers.radius_spread_m = {:e}", 5e-5 * s.length()),
    },
    Law {
        name: "bushings",
        keys: |s| {
            format!(
                "rollers.axle_friction = 0.2\nrollers.axle_radius_m = {:e}",
                2e-3 * s.length()
            )
        },
    },
    Law {
        name: "play",
        keys: |s| format!("rollers.axial_play_m = {:e}", 2e-4 * s.length()),
    },
    Law {
        name: "motors",
        keys: |s| {
            format!(
                "[motors]\ndc = {{ stall_torque_n_m = {:e}, no_load_rate_rad_s = {:e} }}\ngear_ratio = 20.0\ngear_efficiency = 0.8\ngear_friction_n_m = {:e}\nrotor_inertia_kg_m2 = {:e}",
                0.5 * s.torque(),
                20.0 / s.time(),
                0.01 * s.torque(),
                1e-6 * s.inertia()
            )
        },
    },
    Law {
        name: "kerb and push",
        keys: |s| {
            format!(
                "[[world.floor.boxes]]\nx_m = {:e}\ny_m = 0.0\nlength_x_m = {:e}\nlength_y_m = {:e}\nheight_m = {:e}\n[[faults]]\npush = {{ impulse_y_n_s = {:e}, from_s = {:e}, lasts_s = {:e} }}",
                0.6 * s.length(),
                0.3 * s.length(),
                4.0 * s.length(),
                5e-3 * s.length(),
                2.0 * s.force() * s.time(),
                0.5 * s.time(),
                0.1 * s.time()
            )
        },
    },
];

/// The results of a drive, in units of the size.
#[derive(Debug)]
struct Came {
    x: f64,
    y: f64,
    heading: f64,
    travelled: f64,
    /// Sliding with spin-up, whose split depends on the step, and landings.
    lost: [f64; 2],
    airborne: f64,
    grip: f64,
}

/// A turn under a law, at a size; `dt` is the step, or empty.
fn drive(law: &Law, size: Size, dt: &str) -> Came {
    drive_robot(size.robot(), (law.keys)(size), size, dt)
}

fn drive_robot(mut robot: Robot, keys: String, size: Size, dt: &str) -> Came {
    let text = format!(
        "robot.file = \"\"\n{}\n[twist]\nvx_m_s = {:e}\nvy_m_s = {:e}\nomega_rad_s = {:e}\nrest_s = {:e}\nramp_s = {:e}\nsettle_s = 0.0\n\
         [wheel_loop]\nbandwidth_rad_s = {:e}\n[run]\nduration_s = {:e}\ncontrol_dt_s = {:e}\n{dt}",
        keys,
        0.5 * size.time(),
        0.3 * size.time(),
        0.6 / size.time(),
        0.2 * size.time(),
        0.3 * size.time(),
        40.0 / size.time(),
        2.0 * size.time(),
        0.01 * size.time(),
    );
    let scenario =
        Scenario::from_toml(&text, "similar", "").unwrap_or_else(|e| panic!("{e:?}\n{text}"));
    scenario.motors.apply(&mut robot);
    scenario.rollers.apply(&mut robot).unwrap();
    let simulation = Simulation::with_robot(&scenario, &robot).unwrap_or_else(|e| panic!("{e:?}"));
    let run = simulation.run();
    let end = run.trace.records().last().unwrap();
    let pose = end.truth.pose;
    let energies = [
        end.slip_energy_j + end.spin_up_energy_j,
        end.impact_energy_j,
    ];
    Came {
        x: pose.x_m / size.length(),
        y: pose.y_m / size.length(),
        heading: pose.heading_rad,
        travelled: run.summary.travelled_m / size.length(),
        lost: energies.map(|j| j / size.torque()),
        airborne: run.summary.airborne_share.unwrap_or(0.0),
        grip: run.summary.friction_used_max.unwrap_or(0.0),
    }
}

/// From 4 cm to 50 t. For rollers that land, rounding can decide in which step, and robots of
/// nearly the same size differ by as much as any: these laws are tested within about three times
/// the spread of sizes of 1 to 1.06.
#[test]
fn robots_of_one_shape_move_alike_at_any_size() {
    for law in LAWS {
        // For the path, the heading, and the losses.
        let (way, lost) = match law.name {
            "cylinders" => (5e-3, 5e-2),
            "crown" | "unequal" | "play" | "kerb and push" => (1e-3, 5e-2),
            // If friction falls with the sliding distance of a roller, more than one set of
            // impulses may satisfy the laws.
            "nap" => (1e-3, 1e-2),
            _ => (1e-3, 1e-3),
        };
        let one = drive(law, Size(1.0), "");
        for s in [0.1, 16.4] {
            let other = drive(law, Size(s), "");
            let off = (one.x - other.x).hypot(one.y - other.y) / one.travelled;
            let turned_off = (other.heading / one.heading - 1.0).abs();
            // Below a tenth of a millijoule is rounding.
            let differs = |a: f64, b: f64| (a - b).abs() > lost * a.abs().max(b.abs()) + 1e-4;
            let energies = one.lost.iter().zip(&other.lost);
            assert!(
                off < way && turned_off < way,
                "{}, {s}: {one:?} {other:?}",
                law.name
            );
            assert!(
                !energies.into_iter().any(|(a, b)| differs(*a, *b)),
                "{}, {s}: {one:?} {other:?}",
                law.name
            );
        }
    }
}

/// A robot of 40 or of 20 mm, which pushes a crate off its middle, behaves like one of 400 mm: free
/// bodies scale too.
#[test]
fn small_robots_push_small_crates_as_large_ones_do() {
    let pushed = |size: Size| {
        let text = format!(
            "robot.file = \"\"\n[[world.bodies]]\nname = \"crate\"\nbox = {{ size_m = [{1:e}, {0:e}, {0:e}] }}\nmass_kg = {2:e}\nfriction = 0.4\n\
             x_m = {3:e}\ny_m = {4:e}\n[twist]\nvx_m_s = {5:e}\nomega_rad_s = {6:e}\nrest_s = {7:e}\nramp_s = {8:e}\n\
             [wheel_loop]\nbandwidth_rad_s = {9:e}\n[run]\nduration_s = {10:e}\ncontrol_dt_s = {11:e}\n",
            0.1 * size.length(),
            0.14 * size.length(),
            2.0 * size.mass(),
            0.4 * size.length(),
            0.03 * size.length(),
            0.4 * size.time(),
            0.2 / size.time(),
            0.2 * size.time(),
            0.3 * size.time(),
            40.0 / size.time(),
            2.0 * size.time(),
            0.01 * size.time(),
        );
        let scenario = Scenario::from_toml(&text, "similar", "").expect("a scenario");
        let simulation = Simulation::with_robot(&scenario, &size.robot()).expect("it stands");
        let run = simulation.run();
        let end = run.trace.records().last().expect("a row");
        let [x_m, y_m, z_m] = end.bodies[0].place_m;
        let robot = end.truth.pose;
        let heading = end.bodies[0].heading_rad;
        let lengths = [x_m, y_m, z_m, robot.x_m, robot.y_m].map(|m| m / size.length());
        (lengths, [heading, robot.heading_rad])
    };
    let (one, one_turned) = pushed(Size(1.0));
    // It was pushed on, and aside.
    assert!(
        one[0] > 0.6 && one_turned[0].abs() > 0.01,
        "{one:?} {one_turned:?}"
    );
    for s in [0.1, 0.05] {
        let (other, turned) = pushed(Size(s));
        let off = |some: &[f64], others: &[f64]| {
            let pairs = some.iter().zip(others);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (off_way, off_turned) = (off(&one, &other), off(&one_turned, &turned));
        println!("{s}: {off_way:e} of its size, {off_turned:e} rad");
        // The solver's tolerance at either size, 1e-8 m/s, over the run.
        assert!(
            off_way < 1e-5 && off_turned < 1e-5,
            "{s}: {off_way} {off_turned}"
        );
    }
}

/// Robot A with wheels of 250 mm and a chassis of 10 and of 50 t, under the automatic step and
/// under one of a tenth of it.
#[test]
fn heavy_robots_neither_bounce_nor_slip_by_their_step() {
    let size = Size(5.0);
    for mass_kg in [1e4, 5e4] {
        let mut robot = size.robot();
        let heavier = mass_kg / robot.chassis.mass.mass_kg;
        robot.chassis.mass.mass_kg *= heavier;
        robot.chassis.mass.inertia_kg_m2 *= heavier;
        for wheel in &mut robot.wheels {
            wheel.motor.effort_n_m *= heavier;
        }
        let keys = "world.floor.friction = 0.6".to_owned();
        let chosen = drive_robot(robot.clone(), keys.clone(), size, "");
        let fine_s = 3.333e-4 * size.time();
        let steps = (0.01 * size.time() / fine_s).round();
        let fine = format!("physics_dt_s = {:e}\n", 0.01 * size.time() / steps);
        let fine = drive_robot(robot, keys, size, &fine);
        let off = (chosen.x - fine.x).hypot(chosen.y - fine.y) / fine.travelled;
        assert!(off < 1e-3, "{mass_kg} kg: {chosen:?} {fine:?}");
        assert_eq!(chosen.airborne, 0.0, "{mass_kg} kg: {chosen:?}");
        assert!(
            (chosen.grip - fine.grip).abs() < 0.1,
            "{mass_kg} kg: {chosen:?} {fine:?}"
        );
    }
}

/// The default stiffness of a robot of 50 t, and more, can be written into a scenario.
#[test]
fn contacts_may_be_written_as_stiff_as_heavy_robots_need_them() {
    let written = |stiffness: &str| {
        let text = format!(
            "robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\nworld.solver.contact_stiffness_n_m = {stiffness}"
        );
        Scenario::from_toml(&text, "stiff", "")
    };
    for stiffness in ["1e6", "1e9", "2.7e10", "1e13"] {
        assert!(written(stiffness).is_ok(), "{stiffness}");
    }
    for stiffness in ["0.0", "-1e8", "1e16", "inf"] {
        assert!(written(stiffness).is_err(), "{stiffness}");
    }
}
