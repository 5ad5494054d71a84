//! Two measurements on rapier's multibodies:
//!
//! 1. how far a contact still slides that should stick, against the number of sweeps and the way the two friction
//!    directions lie to what the contact presses on;
//! 2. what a step costs, against the number of degrees of freedom.
//!
//! The scene of both is a cart: a free box on rollers, each a ball on a hinge with a level axis, on a plane. Across its axis
//! a roller is light, because it can spin; along its axis it is heavy, because it carries the box.

use std::time::Instant;

use rapier3d::prelude::*;

#[allow(
    clippy::unnecessary_cast,
    reason = "it is built with the engine's reals of either size"
)]
const TAU: Real = std::f64::consts::TAU as Real;
const BOX_KG: Real = 10.0;
const ROLLER_KG: Real = 0.01;
const ROLLER_RADIUS_M: Real = 0.012;
const FRICTION: Real = 0.6;
const STEP_S: Real = 0.002;

fn main() {
    friction();
    println!();
    cost();
}

/// The cart rolls across the axes of its rollers and is pushed along them, to and fro, with half of what friction can
/// hold. Exactly solved, no contact slides.
fn friction() {
    const SWEEPS: [usize; 6] = [4, 8, 16, 32, 64, 128];
    println!(
        "sliding of contacts that should stick, rms, in mm/s: a column for each number of sweeps,"
    );
    println!(
        "a row for each angle between the rollers' axes and rapier's friction directions, in degrees"
    );
    print!("{:>6}", "");
    for sweeps in SWEEPS {
        print!("{sweeps:>10}");
    }
    println!();
    let angles_deg: [Real; 4] = [0.0, 15.0, 30.0, 45.0];
    for angle_deg in angles_deg {
        print!("{angle_deg:>6}");
        for sweeps in SWEEPS {
            print!(
                "{:>10.3}",
                1e3 * sliding_m_s(angle_deg.to_radians(), sweeps)
            );
        }
        println!();
    }
}

/// Sliding speed of the rollers' lowest points, rms over rollers and steps of one period of the push.
fn sliding_m_s(angle_rad: Real, sweeps: usize) -> Real {
    const PUSHES_HZ: Real = 2.0;
    let mut cart = Cart::new(4, angle_rad, sweeps);
    let along = Vector::new(angle_rad.cos(), angle_rad.sin(), 0.0);
    let across = Vector::new(-angle_rad.sin(), angle_rad.cos(), 0.0);
    cart.start(0.3 * across, -0.3 / ROLLER_RADIUS_M);
    let push_n = 0.5 * FRICTION * 9.81 * BOX_KG;
    let period_steps = (1.0 / (PUSHES_HZ * STEP_S)).round() as usize;
    let (mut squares, mut count) = (0.0, 0);
    for step in 0..3 * period_steps {
        let phase = TAU * PUSHES_HZ * STEP_S * step as Real;
        cart.push(push_n * phase.sin() * along);
        cart.world.step();
        if step >= 2 * period_steps {
            for roller in &cart.rollers {
                let roller = &cart.world.bodies[*roller];
                let lowest = roller.translation() - ROLLER_RADIUS_M * Vector::Z;
                let velocity = roller.velocity_at_point(lowest);
                squares += velocity.x * velocity.x + velocity.y * velocity.y;
                count += 1;
            }
        }
    }
    (squares / count as Real).sqrt()
}

/// A step of the cart at rest, on ever more rollers.
fn cost() {
    println!("a step of the cart, 8 sweeps");
    println!("{:>8}{:>10}{:>10}", "rollers", "dofs", "us");
    for rollers in [4, 8, 16, 32, 64] {
        let mut cart = Cart::new(rollers, 0.0, 8);
        let mut best_us = f64::INFINITY;
        for _ in 0..10 {
            const STEPS: u32 = 20;
            let clock = Instant::now();
            for _ in 0..STEPS {
                cart.world.step();
            }
            best_us = best_us.min(1e6 * clock.elapsed().as_secs_f64() / f64::from(STEPS));
        }
        println!("{rollers:>8}{:>10}{best_us:>10.0}", 6 + rollers);
    }
}

struct Cart {
    world: PhysicsWorld,
    chassis: RigidBodyHandle,
    rollers: Vec<RigidBodyHandle>,
}

impl Cart {
    /// A cart at rest on the plane z = 0, turned by an angle about z; its rollers' axes point ahead.
    ///
    /// On a level plane rapier's friction directions are the world's x and y: `orthonormal_vector` of the normal.
    fn new(rollers: usize, angle_rad: Real, sweeps: usize) -> Self {
        let stiff = SpringCoefficients::new(1000.0, 1.0);
        let mut world = PhysicsWorld {
            gravity: Vector::new(0.0, 0.0, -9.81),
            integration_parameters: IntegrationParameters {
                dt: STEP_S,
                contact_softness: stiff,
                static_contact_softness: stiff,
                num_solver_iterations: 1,
                // With stabilisation friction would be solved after the bodies have moved.
                num_internal_stabilization_iterations: 0,
                num_internal_pgs_iterations: sweeps,
                normalized_prediction_distance: 1e-3,
                contact_clustering: false,
                contact_recycling: false,
                friction_model: FrictionModel::Coulomb,
                max_ccd_substeps: 0,
                ..IntegrationParameters::default()
            },
            ..PhysicsWorld::default()
        };
        let ground = InteractionGroups::new(Group::GROUP_1, Group::ALL, InteractionTestMode::And);
        let roller =
            InteractionGroups::new(Group::GROUP_2, Group::GROUP_1, InteractionTestMode::And);
        world.insert_collider(
            ColliderBuilder::new(SharedShape::halfspace(Vector::Z))
                .friction(FRICTION)
                .collision_groups(ground),
            None,
        );

        let heading = Rotation::from_rotation_z(angle_rad);
        let place = Pose::from_parts(Vector::new(0.0, 0.0, 0.06), heading);
        // 0.40 x 0.24 x 0.10 m.
        let inertia = BOX_KG / 12.0
            * Vector::new(
                0.24 * 0.24 + 0.1 * 0.1,
                0.4 * 0.4 + 0.1 * 0.1,
                0.4 * 0.4 + 0.24 * 0.24,
            );
        let chassis = world.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(place)
                .can_sleep(false)
                .additional_mass_properties(MassProperties::new(Vector::ZERO, BOX_KG, inertia)),
        );
        let ball = 0.4 * ROLLER_KG * ROLLER_RADIUS_M * ROLLER_RADIUS_M;
        let rollers: Vec<_> = (0..rollers)
            .map(|index| {
                // Around the box; the hinge of rapier turns about x, which is the box's own x here.
                let at_rad = TAU * (index as Real + 0.5) / rollers as Real;
                let at = Vector::new(
                    0.2 * at_rad.cos(),
                    0.2 * at_rad.sin(),
                    ROLLER_RADIUS_M - 0.06,
                );
                let body = world.bodies.insert(
                    RigidBodyBuilder::dynamic()
                        .pose(place * Pose::from_parts(at, Rotation::IDENTITY))
                        .can_sleep(false)
                        .additional_mass_properties(MassProperties::new(
                            Vector::ZERO,
                            ROLLER_KG,
                            Vector::splat(ball),
                        )),
                );
                let mut hinge = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
                hinge.set_local_frame1(Pose::from_parts(at, Rotation::IDENTITY));
                world.insert_multibody_joint(chassis, body, hinge);
                world.insert_collider(
                    ColliderBuilder::ball(ROLLER_RADIUS_M)
                        .density(0.0)
                        .friction(FRICTION)
                        .collision_groups(roller),
                    Some(body),
                );
                body
            })
            .collect();
        let mut cart = Self {
            world,
            chassis,
            rollers,
        };
        // Multibodies come with 0.1 of damping on every angular axis, which would hold rollers as light as these.
        cart.multibody().damping_mut().fill(0.0);
        cart
    }

    fn multibody(&mut self) -> &mut Multibody {
        let joints = &mut self.world.multibody_joints;
        let index = joints
            .rigid_body_link(self.chassis)
            .expect("the box is part of the multibody")
            .multibody;
        joints
            .get_multibody_mut(index)
            .expect("it lives as long as the world")
    }

    /// Sets the velocity of the box and the spin of all rollers.
    fn start(&mut self, velocity_m_s: Vector, spin_rad_s: Real) {
        let mut rates = self.multibody().generalized_velocity_mut();
        rates.fill(spin_rad_s);
        for (axis, rate) in velocity_m_s.to_array().into_iter().enumerate() {
            rates[axis] = rate;
            rates[3 + axis] = 0.0;
        }
    }

    /// Pushes the box for one step, at the height of the ground, so that it does not tip.
    fn push(&mut self, force_n: Vector) {
        let chassis = &mut self.world.bodies[self.chassis];
        let at = Vector::new(chassis.translation().x, chassis.translation().y, 0.0);
        chassis.reset_forces(false);
        chassis.reset_torques(false);
        chassis.add_force_at_point(force_n, at, true);
    }
}
