//! Checks for what cannot be simulated.

use ilon_robot::{Robot, Roller, RollerForm, Wheel};

use super::check_joints::check_joints;
use crate::contact::reactions::Reactions;
use crate::contact::scene::Scenes;
use crate::contact::search::free_bodies::parts;
use crate::engine::shapes::shape_of_roller;
use crate::ground::Ground;
use crate::robot::articulated::Articulated;
use crate::settings::NEAR;
use crate::{ContactSolver, Floor, FloorSurface, RollerBodies, Settings, WorldError};

/// Refuses what cannot be simulated.
pub(super) fn check(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let positive = [
        ("dt_s", Some(settings.dt_s)),
        ("split_dt_s", settings.split_dt_s),
        ("contact_stiffness_n_m", settings.contact_stiffness_n_m),
    ];
    for (name, value) in positive {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and above 0",
            });
        }
    }
    let not_negative = [
        ("gravity_m_s2", Some(settings.gravity_m_s2)),
        ("contact_relaxation_s", settings.contact_relaxation_s),
    ];
    for (name, value) in not_negative {
        if let Some(value) = value
            && !(value.is_finite() && value >= 0.0)
        {
            return Err(WorldError::Setting {
                name,
                value,
                range: "finite and not below 0",
            });
        }
    }
    floor.check()?;
    if robot.wheels.is_empty() {
        return Err(WorldError::NoWheels);
    }
    check_joints(robot, settings)?;
    if settings.contacts == ContactSolver::Rapier {
        check_reference(robot, floor, settings)?;
    }
    let load_n = robot.mass_kg() * settings.gravity_m_s2 / robot.wheels.len() as f64;
    robot.wheels.iter().try_for_each(|wheel| {
        check_wheel(wheel)?;
        check_rolling(wheel, floor)?;
        check_tread(wheel, load_n)
    })
}

/// Refuses bodies that cannot start together.
pub(super) fn check_together(
    bodies: &[Articulated],
    ground: &Ground,
    settings: &Settings,
) -> Result<(), WorldError> {
    if bodies.is_empty() {
        return Err(WorldError::NoBodies);
    }
    if bodies.len() == 1 {
        return Ok(());
    }
    if settings.contacts == ContactSolver::Rapier {
        return Err(WorldError::NotInRapier {
            what: "several robots".to_owned(),
            remedy: "give each a world of its own",
        });
    }
    let scenes = Scenes {
        ground,
        settings,
        dt_s: settings.dt_s,
        bodies,
        reactions: &Reactions::default(),
    };
    let mut near = Vec::new();
    scenes.find_between_chassis(&mut near);
    match near.iter().find(|place| place.gap_m < 0.0) {
        Some(_) => Err(WorldError::NoPlaceToStand {
            reason: "its chassis would lie in another robot's".to_owned(),
        }),
        None => Ok(()),
    }
}

/// Refuses a body on a joint that would start in the ground, deeper than the contact could push it
/// out.
pub(super) fn check_links(body: &Articulated, ground: &Ground) -> Result<(), WorldError> {
    let shallow_m = NEAR * body.scale.length_m;
    for (joint, solid) in parts(body, &body.state) {
        let Some(joint) = joint else {
            continue;
        };
        let bounds = solid.bounds();
        let mut gap_m = match ground.is_solid_below() {
            true => bounds.least_m.z,
            false => f64::INFINITY,
        };
        for on_ground in ground.solids().filter(|of| of.bounds().meets(&bounds)) {
            solid.near(&on_ground, shallow_m, |near| gap_m = gap_m.min(near.gap_m));
        }
        if gap_m < -shallow_m {
            let of = &body.robot.joints[joint];
            return Err(WorldError::NoPlaceToStand {
                reason: format!(
                    "its body `{}` on joint `{}` would begin {:.0} mm deep in the ground, with that joint at {:.3}: begin it at another position",
                    of.body.name,
                    of.name,
                    -1e3 * gap_m,
                    body.state.joint_positions()[joint]
                ),
            });
        }
    }
    Ok(())
}

/// Refuses a tread that an even share of the weight, in N, compresses by more than the radius of
/// the wheel's rollers.
fn check_tread(wheel: &Wheel, load_n: f64) -> Result<(), WorldError> {
    let Some(tread) = wheel.surface.tread else {
        return Ok(());
    };
    let radii_m = wheel.rollers.iter().map(|roller| roller.radius_m);
    let radius_m = radii_m.fold(f64::INFINITY, f64::min);
    let sag_m = load_n / tread.stiffness_n_m;
    if sag_m <= radius_m {
        return Ok(());
    }
    Err(WorldError::TreadTooSoft {
        wheel: wheel.name.clone(),
        stiffness_n_m: tread.stiffness_n_m,
        sag_mm: 1e3 * sag_m,
        radius_mm: 1e3 * radius_m,
        least_n_m: load_n / radius_m,
    })
}

/// Refuses rolling resistance and creep for rollers whose contact motion is unknown.
fn check_rolling(wheel: &Wheel, floor: &Floor) -> Result<(), WorldError> {
    let is_modelled = |roller: &Roller| matches!(roller.form, RollerForm::AsModelled(_));
    let mut footings = floor.all_footings();
    let costs = wheel.surface.rolling_resistance > 0.0
        || footings.any(|footing| {
            footing.surface.drags() || footing.surface.creeps().iter().any(|creep| *creep > 0.0)
        });
    if costs && wheel.rollers.iter().any(is_modelled) {
        return Err(WorldError::DragOnModelled {
            wheel: wheel.name.clone(),
        });
    }
    Ok(())
}

/// Refuses an implausible play: rollers slide along their axles by a part of their own size.
fn check_play(wheel: &Wheel) -> Result<(), WorldError> {
    let play_m = wheel.surface.axial_play_m;
    let radii_m = wheel.rollers.iter().map(|roller| roller.radius_m);
    let most_m = radii_m.fold(f64::INFINITY, f64::min);
    let is_barrel =
        |roller: &Roller| matches!(roller.form, RollerForm::Barrel | RollerForm::Made(_));
    if play_m > 0.0 && !wheel.rollers.iter().all(is_barrel) {
        let wheel = wheel.name.clone();
        return Err(WorldError::PlayOfNoBarrel { wheel });
    }
    if play_m >= 0.0 && play_m <= most_m {
        return Ok(());
    }
    Err(WorldError::NoSuchPlay {
        wheel: wheel.name.clone(),
        play_m,
        most_m,
    })
}

/// Refuses friction on invalid axles.
fn check_axles(wheel: &Wheel) -> Result<(), WorldError> {
    let (friction, axle_m) = (wheel.surface.axle_friction, wheel.surface.axle_radius_m);
    let radii_m = wheel.rollers.iter().map(|roller| roller.radius_m);
    let most_m = radii_m.fold(f64::INFINITY, f64::min);
    let is_there = axle_m > 0.0 && axle_m < most_m;
    if friction == 0.0 || (friction > 0.0 && friction.is_finite() && is_there) {
        return Ok(());
    }
    Err(WorldError::NoSuchAxle {
        wheel: wheel.name.clone(),
        friction,
        axle_m,
        most_m,
    })
}

/// Refuses features that rapier's own solver does not have.
fn check_reference(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let refused = |what: String, remedy| Err(WorldError::NotInRapier { what, remedy });
    if settings.split_dt_s.is_some() {
        return refused("steps taken in parts".to_owned(), "take shorter steps");
    }
    if let Some(joint) = robot.joints.first() {
        return refused(
            format!("bodies on joints (joint `{}`)", joint.name),
            "hold its joints",
        );
    }
    if settings.roller_bodies != RollerBodies::All {
        return refused(
            "only the rollers near the ground".to_owned(),
            "take all of them: each is a body of its own",
        );
    }
    let has_play = |wheel: &&Wheel| wheel.surface.axial_play_m > 0.0;
    if let Some(wheel) = robot.wheels.iter().find(has_play) {
        return refused(
            format!(
                "rollers with play along their axles (wheel `{}`)",
                wheel.name
            ),
            "leave the play out",
        );
    }
    let has_axles = |wheel: &&Wheel| wheel.surface.axle_friction > 0.0;
    if let Some(wheel) = robot.wheels.iter().find(has_axles) {
        return refused(
            format!(
                "friction on the rollers' axles that follows the load (wheel `{}`)",
                wheel.name
            ),
            "leave it out, or write dry friction of the rollers' joints",
        );
    }
    let gives =
        |wheel: &&Wheel| wheel.surface.tread.is_some() || wheel.surface.rolling_resistance > 0.0;
    if let Some(wheel) = robot.wheels.iter().find(gives) {
        let what = format!(
            "rollers with a tread or rolling resistance (wheel `{}`)",
            wheel.name
        );
        return refused(what, "leave the rollers rigid");
    }
    let turned =
        |roller: &Roller| matches!(roller.form, RollerForm::Turned(_) | RollerForm::Tyre(_));
    let of_profile = |wheel: &&Wheel| wheel.rollers.iter().any(turned);
    if let Some(wheel) = robot.wheels.iter().find(of_profile) {
        return refused(
            format!("rollers with a profile by numbers (wheel `{}`)", wheel.name),
            "take barrels",
        );
    }
    if !floor.materials.is_empty() {
        return refused(
            "a floor whose friction depends on the rollers' material".to_owned(),
            "say its friction instead",
        );
    }
    let mut footings = floor.all_footings();
    if footings.any(|footing| footing.surface != FloorSurface::default()) {
        return refused(
            "a floor that drags, creeps, or whose friction falls".to_owned(),
            "leave the floor hard",
        );
    }
    let lossy = |wheel: &&Wheel| wheel.drive.gear_efficiency < 1.0;
    match robot.wheels.iter().find(lossy) {
        Some(wheel) => refused(
            format!(
                "a gear that loses a share of the torque (wheel `{}`)",
                wheel.name
            ),
            "give the gear an efficiency of 1",
        ),
        None => Ok(()),
    }
}

fn check_wheel(wheel: &Wheel) -> Result<(), WorldError> {
    if wheel.rollers.is_empty() {
        return Err(WorldError::NoRollers {
            wheel: wheel.name.clone(),
        });
    }
    check_play(wheel)?;
    check_axles(wheel)?;
    for roller in &wheel.rollers {
        if let RollerForm::AsModelled(modelled) = &roller.form {
            if wheel.surface.tread.is_some() {
                return Err(WorldError::TreadOnModelled {
                    wheel: wheel.name.clone(),
                });
            }
            if shape_of_roller(modelled).is_none() {
                return Err(WorldError::FlatRoller {
                    wheel: wheel.name.clone(),
                    roller: roller.name.clone(),
                });
            }
            continue;
        }
        if roller.is_tyre() {
            continue;
        }
        if let RollerForm::Turned(_) = &roller.form {
            if wheel.surface.tread.is_some() {
                return Err(WorldError::TreadOnTurned {
                    wheel: wheel.name.clone(),
                });
            }
            continue;
        }
        let barrel = wheel.barrel(roller);
        let end_radius_m = barrel.sphere_radius_m(barrel.half_length_m);
        if end_radius_m <= 0.0 {
            return Err(WorldError::RollerEndsVanish {
                wheel: wheel.name.clone(),
                missing_mm: -1e3 * end_radius_m,
            });
        }
    }
    Ok(())
}
