//! A case in either engine.

use ilon_oracle::{ContactLaw, Drive, Engine, LEVEL_GRAVITY_M_S2, Nap, Plate, Push};
use ilon_robot::{Pose, Robot, Tread};
use ilon_world::{Floor, FloorSurface, GroundBox, MotorTorque, RollerBodies, World};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2};

use crate::oracle::case::{Case, GAIN_N_M_S, TICK_S};
use crate::oracle::course::{Course, Row, Sums};

/// The stiffness of the oracle's springs, and the step that resolves them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    pub stiffness_n_m: f64,
    pub step_s: f64,
}

impl Springs {
    /// Springs of this stiffness in N/m; half the step for four times the stiffness, 5 us for
    /// 2e7 N/m.
    pub fn of(stiffness_n_m: f64) -> Self {
        Self {
            stiffness_n_m,
            step_s: 5e-6 * (2e7 / stiffness_n_m).sqrt(),
        }
    }
}

/// The oracle's course.
pub fn on_springs(case: &Case, springs: Springs) -> Course {
    let steps = (TICK_S / springs.step_s).ceil();
    let nap = case.nap.map(|(angle_rad, ratio)| Nap { angle_rad, ratio });
    let settings = ilon_oracle::Settings {
        step_s: TICK_S / steps,
        contact: ContactLaw {
            nap,
            ..case.contact(springs.stiffness_n_m)
        },
        gravity_m_s2: LEVEL_GRAVITY_M_S2,
    };
    let mut engine = Engine::new(&case.robot, settings).expect("the oracle takes the robot");
    engine.lay_plates(&case.plates);
    if !(case.robot.joints.is_empty() && case.plates.is_empty()) {
        stand_up(&mut engine, case);
    }
    let mut course = Course::default();
    for tick in 0..case.ticks() {
        let t_s = tick as f64 * TICK_S;
        let targets = case.targets_rad_s(t_s);
        for wheel in 0..case.robot.wheels.len() {
            let drive = match &targets {
                _ if case.locked_wheel == Some(wheel) => Drive::Locked,
                Some(targets) if case.drives(wheel) => Drive::Rate {
                    target_rad_s: targets[wheel],
                    gain_n_m_s: GAIN_N_M_S,
                    limit_n_m: f64::INFINITY,
                },
                _ => Drive::Free,
            };
            engine.drive(wheel, drive);
        }
        engine.push(case.force_n(t_s).map(|force_in_world_n| Push {
            force_in_world_n,
            point_in_body_m: case.pushed_at_m(),
        }));
        let mut loads_n = vec![0.0; case.robot.wheels.len()];
        for _ in 0..steps as usize {
            engine.step().expect("the motion stays finite");
            for contact in engine.contacts() {
                loads_n[contact.wheel] += contact.normal_n / steps;
            }
        }
        course.record(row_of(&engine, loads_n));
    }
    course
}

/// Starts at ilon's standing pose. The robot stands by itself before it moves, so that an error in
/// the pose would show.
fn stand_up(engine: &mut Engine, case: &Case) {
    let world = in_world(case, &case.robot, 1e-3, None);
    let stands = world.robot().state();
    let turn = UnitQuaternion::from_euler_angles(
        stands.roll_rad,
        stands.pitch_rad,
        stands.pose.heading_rad,
    );
    let position_m = stands.pose.position_m();
    let at_m = Translation3::new(position_m.x, position_m.y, stands.height_m);
    engine.set_world_from_body(Isometry3::from_parts(at_m, turn));
    engine.set_joint_positions(world.robot().joint_positions());
}

fn row_of(engine: &Engine, loads_n: Vec<f64>) -> Row {
    let pose = engine.world_from_body();
    let mut slides = vec![(0.0, Vector2::zeros()); loads_n.len()];
    for contact in engine.contacts() {
        let (load, slide) = &mut slides[contact.wheel];
        *load += contact.normal_n;
        *slide += contact.normal_n * contact.velocity_m_s;
    }
    let touching = slides.iter().filter(|(load, _)| *load > 0.0);
    let energy = engine.energy();
    let (roll, pitch, heading_rad) = pose.rotation.euler_angles();
    Row {
        t_s: engine.time_s(),
        position_m: pose.translation.vector.xy(),
        heading_rad,
        yaw_rate_rad_s: engine.speeds().angular.z,
        slide_m_s: touching
            .map(|(load, slide)| slide.norm() / load)
            .fold(0.0, f64::max),
        loads_n,
        wheels_rad: engine.wheel_angles_rad().to_vec(),
        stands: [pose.translation.z, roll, pitch],
        joints: engine.joint_positions().to_vec(),
        sums: Sums {
            slip_j: energy.slip_j,
            along_ground_j: energy.slip_j + energy.bristles_j,
            other_j: energy.bristles_j + energy.normals_j,
            drives_j: energy.drives_j,
            bearings_j: energy.wheel_bearings_j + energy.roller_bearings_j,
            kinetic_j: energy.kinetic_j,
        },
    }
}

/// Dry friction that locks a wheel in ilon, in N m; more than any wheel's torque here.
const LOCK_N_M: f64 = 6.0;

/// ilon's course with these settings, otherwise the default ones.
pub fn in_ilon(case: &Case, step_s: f64, contact_stiffness_n_m: Option<f64>) -> Course {
    course_in_ilon(case, case.robot.clone(), step_s, contact_stiffness_n_m)
}

/// ilon's course on treads with the oracle's springs.
pub fn on_treads(case: &Case, stiffness_n_m: f64, step_s: f64) -> Course {
    let law = case.contact(stiffness_n_m);
    let mut tread = Tread::new(law.normal_stiffness_n_m);
    tread.damping_n_s_m = Some(law.normal_damping_n_s_m);
    tread.shear_stiffness_n_m = Some(law.bristle_stiffness_n_m);
    tread.shear_damping_n_s_m = Some(law.bristle_damping_n_s_m);
    let mut robot = case.robot.clone();
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(tread);
    }
    course_in_ilon(case, robot, step_s, None)
}

fn course_in_ilon(
    case: &Case,
    mut robot: Robot,
    step_s: f64,
    contact_stiffness_n_m: Option<f64>,
) -> Course {
    let steps = (TICK_S / step_s).ceil();
    if let Some(wheel) = case.locked_wheel {
        robot.wheels[wheel].joint.friction_n_m = LOCK_N_M;
    }
    let mut world = in_world(case, &robot, TICK_S / steps, contact_stiffness_n_m);
    let mut course = Course::default();
    for tick in 0..case.ticks() {
        let t_s = tick as f64 * TICK_S;
        let targets = case.targets_rad_s(t_s);
        let mut loads_n = vec![0.0; robot.wheels.len()];
        for _ in 0..steps as usize {
            drive(&mut world, case, targets.as_deref());
            if let Some(force_in_world_n) = case.force_n(t_s) {
                world.robot_mut().push(&ilon_world::Push {
                    force_in_world_n,
                    place_in_body_m: case.pushed_at_m(),
                });
            }
            world.step();
            for (load, contact) in loads_n.iter_mut().zip(world.robot().contacts()) {
                *load += contact.normal_force_n / steps;
            }
        }
        course.record(row_in(&world, loads_n));
    }
    course
}

/// The robot on the case's floor.
fn in_world(case: &Case, robot: &Robot, dt_s: f64, contact_stiffness_n_m: Option<f64>) -> World {
    let nap = case.nap.map(|(angle_rad, ratio)| ilon_world::Nap {
        angle_rad,
        friction_ratio: ratio,
        creep_across: 0.0,
        resistance_across: 0.0,
        resistance_against: 0.0,
    });
    let floor = Floor {
        friction: case.friction,
        surface: FloorSurface {
            nap,
            ..FloorSurface::default()
        },
        boxes: case.plates.iter().map(as_box).collect(),
        ..Floor::default()
    };
    let settings = ilon_world::Settings {
        dt_s,
        roller_bodies: RollerBodies::Near,
        contact_stiffness_n_m,
        ..ilon_world::Settings::default()
    };
    World::new(robot, &floor, Pose::default(), &settings).expect("ilon takes the robot")
}

fn as_box(plate: &Plate) -> GroundBox {
    let (middle_m, half_m) = (
        0.5 * (plate.from_m + plate.to_m),
        0.5 * (plate.to_m - plate.from_m),
    );
    let half_height_m = 0.5 * plate.height_m;
    GroundBox {
        center_m: middle_m.push(half_height_m),
        half_sides_m: half_m.push(half_height_m),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    }
}

/// The wheels' torques for one step, which fall with the rates gained within it.
fn drive(world: &mut World, case: &Case, targets: Option<&[f64]>) {
    let Some(targets) = targets else { return };
    let rates = world
        .robot()
        .wheel_rates_rad_s()
        .iter()
        .zip(targets)
        .enumerate();
    let motors: Vec<MotorTorque> = rates
        .map(|(wheel, (rate, target))| {
            let gain = if case.drives(wheel) { GAIN_N_M_S } else { 0.0 };
            MotorTorque::with_droop(gain * (target - rate), gain)
        })
        .collect();
    world.robot_mut().drive(&motors);
}

fn row_in(world: &World, loads_n: Vec<f64>) -> Row {
    let body = world.robot().state();
    let touching = world
        .robot()
        .contacts()
        .iter()
        .filter(|contact| contact.touching);
    Row {
        t_s: world.time_s(),
        position_m: body.pose.position_m(),
        heading_rad: body.pose.heading_rad,
        yaw_rate_rad_s: body.twist_in_body.omega_rad_s,
        slide_m_s: touching
            .map(|contact| contact.sliding_in_body_m_s.norm())
            .fold(0.0, f64::max),
        loads_n,
        wheels_rad: world.robot().wheel_angles_rad().to_vec(),
        stands: [body.height_m, body.roll_rad, body.pitch_rad],
        joints: world.robot().joint_positions().to_vec(),
        sums: Sums {
            slip_j: world.slip_energy_j() + world.spin_up_energy_j(),
            along_ground_j: world.slip_energy_j() + world.spin_up_energy_j(),
            other_j: world.impact_energy_j(),
            drives_j: world.motor_energy_j(),
            bearings_j: world.bearing_energy_j(),
            kinetic_j: world.energy().kinetic_j,
        },
    }
}
