//! Converts the free bodies of a scenario for the world and for the trace.

use ilon_robot::roll_pitch_yaw;
use ilon_trace::{BodyHeader, BodySample, MAX_BODIES};
use ilon_world::{FreeBody, World};
use nalgebra::{UnitQuaternion, Vector2, Vector3};

use ilon_scenario::Error;
use ilon_scenario::scenario::{Body, Scenario};

/// Puts the bodies of a scenario into a world, in order.
///
/// # Errors
/// If one has no size or mass, or would start inside something.
pub(crate) fn put_in(scenario: &Scenario, world: &mut World) -> Result<(), Error> {
    for body in &scenario.world.bodies {
        world.add_body(&free_body(body))?;
    }
    Ok(())
}

/// The header entries of the recorded bodies.
pub(crate) fn header(scenario: &Scenario) -> Vec<BodyHeader> {
    let recorded = scenario.world.bodies.iter().take(MAX_BODIES);
    let header = |body: &Body| BodyHeader {
        name: body.name.clone(),
        shape: body.shape(),
        mass_kg: body.mass_kg,
        friction: body.friction,
    };
    recorded.map(header).collect()
}

/// Samples of the recorded bodies.
pub(crate) fn samples(world: &World) -> [BodySample; MAX_BODIES] {
    let mut samples = [BodySample::default(); MAX_BODIES];
    let ids = world.free_bodies().iter();
    let states = ids.filter_map(|id| world.free_body(*id));
    for (sample, state) in samples.iter_mut().zip(states) {
        let [roll_rad, pitch_rad, heading_rad] =
            roll_pitch_yaw(&state.rotation.to_rotation_matrix());
        *sample = BodySample {
            place_m: state.place_m.into(),
            roll_rad,
            pitch_rad,
            heading_rad,
            velocity_m_s: state.velocity_m_s.into(),
            work_j: state.work_of_robots_j,
            ..BodySample::default()
        };
    }
    samples
}

/// Magnitude of the force of all robots on each recorded body in the last step, in N.
pub(crate) fn pushes_n(world: &World) -> impl Iterator<Item = f64> {
    let ids = world.free_bodies().iter().take(MAX_BODIES);
    let states = ids.filter_map(|id| world.free_body(*id));
    states.map(|state| state.force_from_robots_n.norm())
}

fn free_body(body: &Body) -> FreeBody {
    FreeBody {
        friction: body.friction,
        friction_on_robots: body.friction_on_robots,
        height_m: body.z_m,
        rotation: UnitQuaternion::from_euler_angles(
            body.roll_deg.to_radians(),
            body.pitch_deg.to_radians(),
            body.heading_deg.to_radians(),
        ),
        velocity_m_s: Vector3::new(body.vx_m_s, body.vy_m_s, body.vz_m_s),
        angular_rad_s: Vector3::z() * body.omega_rad_s,
        ..FreeBody::new(
            &body.name,
            body.shape(),
            body.mass_kg,
            Vector2::new(body.x_m, body.y_m),
        )
    }
}
