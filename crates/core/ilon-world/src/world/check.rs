//! Checks for what cannot be simulated.

use ilon_robot::{BodyJoint, Robot, Roller, RollerForm, Wheel};

use super::check_joints::check_joints;
use crate::contact::reactions::Reactions;
use crate::contact::scene::Scenes;
use crate::contact::search::free_bodies::parts;
use crate::engine::shapes::shape_of_roller;
use crate::error::{NOT_NEGATIVE, POSITIVE, check_numbers};
use crate::ground::Ground;
use crate::robot::articulated::Articulated;
use crate::settings::NEAR;
use crate::{ContactSolver, Floor, FloorSurface, RollerBodies, Settings, WorldError};

/// Refuses what cannot be simulated.
pub(super) fn check(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let given = [
        ("dt_s", Some(settings.dt_s), POSITIVE),
        ("split_dt_s", settings.split_dt_s, POSITIVE),
        (
            "contact_stiffness_n_m",
            settings.contact_stiffness_n_m,
            POSITIVE,
        ),
        ("gravity_m_s2", Some(settings.gravity_m_s2), NOT_NEGATIVE),
        (
            "contact_relaxation_s",
            settings.contact_relaxation_s,
            NOT_NEGATIVE,
        ),
    ];
    let given = given.into_iter();
    check_numbers(given.filter_map(|(name, value, range)| Some((name, value?, range))))?;
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
    scenes.find_between_robots(&mut near);
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
        let gap_m = ground.gap_m(&solid);
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
    refused(
        wheel,
        format!(
            "its tread of {} N/m would be pressed by {:.1} mm under its share of the weight, deeper than its rollers' radius of {:.1} mm; \
             give it {:.0} N/m or more",
            tread.stiffness_n_m,
            1e3 * sag_m,
            1e3 * radius_m,
            load_n / radius_m
        ),
    )
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
        return refused(
            wheel,
            "its rollers have the shapes of their file, of which rolling resistance and creep are not known; take barrels, or \
             leave the floor's and the rollers' rolling resistance and the creep out",
        );
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
        return refused(
            wheel,
            "its rollers have play along their axles, which only barrels can have; take barrels, with a crown or without, or \
             leave the play out",
        );
    }
    if play_m >= 0.0 && play_m <= most_m {
        return Ok(());
    }
    refused(
        wheel,
        format!(
            "its rollers have a play of {play_m} m along their axles; write one in metres from 0 to their radius, {most_m} m: \
             0.2 mm is 0.0002"
        ),
    )
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
    refused(
        wheel,
        format!(
            "its rollers have friction of coefficient {friction} on axles of radius {axle_m} m; write a coefficient of 0 or more, and a \
             radius in metres above 0 and below that of the rollers, {most_m} m: 2 mm is 0.002"
        ),
    )
}

/// Refuses features that rapier's own solver does not have.
fn check_reference(robot: &Robot, floor: &Floor, settings: &Settings) -> Result<(), WorldError> {
    let of_wheel = |what: &str, has: fn(&Wheel) -> bool| {
        let wheel = robot.wheels.iter().find(|wheel| has(wheel))?;
        Some(format!("{what} (wheel `{}`)", wheel.name))
    };
    let mut footings = floor.all_footings();
    let if_so = |is_so: bool, what: &str| is_so.then(|| what.to_owned());
    let has_joint = |joint: &BodyJoint| format!("bodies on joints (joint `{}`)", joint.name);
    let is_near = settings.roller_bodies != RollerBodies::All;
    let is_soft = footings.any(|footing| footing.surface != FloorSurface::default());
    let by_numbers = |wheel: &Wheel| {
        let mut forms = wheel.rollers.iter().map(|roller| &roller.form);
        forms.any(|form| matches!(form, RollerForm::Turned(_) | RollerForm::Tyre(_)))
    };
    #[rustfmt::skip]
    let features = [
        (if_so(settings.split_dt_s.is_some(), "steps taken in parts"), "take shorter steps"),
        (robot.joints.first().map(has_joint), "hold its joints"),
        (if_so(is_near, "only the rollers near the ground"), "take all of them: each is a body of its own"),
        (of_wheel("rollers with play along their axles", |wheel| wheel.surface.axial_play_m > 0.0), "leave the play out"),
        (
            of_wheel("friction on the rollers' axles that follows the load", |wheel| wheel.surface.axle_friction > 0.0),
            "leave it out, or write dry friction of the rollers' joints",
        ),
        (
            of_wheel("rollers with a tread or rolling resistance", |wheel| {
                wheel.surface.tread.is_some() || wheel.surface.rolling_resistance > 0.0
            }),
            "leave the rollers rigid",
        ),
        (of_wheel("rollers with a profile by numbers", by_numbers), "take barrels"),
        (
            if_so(!floor.materials.is_empty(), "a floor whose friction depends on the rollers' material"),
            "say its friction instead",
        ),
        (if_so(is_soft, "a floor that drags, creeps, or whose friction falls"), "leave the floor hard"),
        (
            of_wheel("a gear that loses a share of the torque", |wheel| wheel.drive.gear_efficiency < 1.0),
            "give the gear an efficiency of 1",
        ),
    ];
    match features
        .into_iter()
        .find_map(|(what, remedy)| Some((what?, remedy)))
    {
        Some((what, remedy)) => Err(WorldError::NotInRapier { what, remedy }),
        None => Ok(()),
    }
}

fn check_wheel(wheel: &Wheel) -> Result<(), WorldError> {
    if wheel.rollers.is_empty() {
        return refused(wheel, "it has no rollers: it would touch nothing");
    }
    check_play(wheel)?;
    check_axles(wheel)?;
    let has_tread = wheel.surface.tread.is_some();
    for roller in &wheel.rollers {
        match &roller.form {
            RollerForm::AsModelled(_) if has_tread => {
                return refused(
                    wheel,
                    "its rollers have the shapes of their file and a tread, which only barrels can have; take barrels, or \
                     leave the tread out",
                );
            }
            RollerForm::Turned(_) if has_tread => {
                return refused(
                    wheel,
                    "its rollers have a profile by numbers and a tread, which only barrels can have; make them barrels with a \
                     crown, or leave the tread out",
                );
            }
            RollerForm::AsModelled(modelled) if shape_of_roller(modelled).is_none() => {
                let name = &roller.name;
                return refused(
                    wheel,
                    format!(
                        "roller `{name}` has a collision mesh without volume; take barrels, or mend the mesh"
                    ),
                );
            }
            RollerForm::AsModelled(_) | RollerForm::Turned(_) | RollerForm::Tyre(_) => {}
            RollerForm::Barrel | RollerForm::Made(_) => {
                let barrel = wheel.barrel(roller);
                let end_radius_m = barrel.sphere_radius_m(barrel.half_length_m);
                if end_radius_m <= 0.0 {
                    return refused(
                        wheel,
                        format!(
                            "its rollers are so long for their radius that their profile vanishes {:.2} mm before the end; use more or \
                             thicker rollers",
                            -1e3 * end_radius_m
                        ),
                    );
                }
            }
        }
    }
    Ok(())
}

fn refused(wheel: &Wheel, reason: impl Into<String>) -> Result<(), WorldError> {
    Err(WorldError::Wheel {
        wheel: wheel.name.clone(),
        reason: reason.into(),
    })
}
