//! Range checks of a description's values.

use std::f64::consts::PI;

use ilon_files::keys::MOST_FAULTS;

use super::ranges::out_of_range;
use super::{Arrangement, Described, RollerSpec, Spec, SuspensionLaw, SuspensionSpec, ranges};
use crate::error::{Fault, RobotError};

/// Rejects values that are out of their ranges, by their keys.
pub(crate) fn check(spec: &Spec, wheels: &[Described]) -> Result<(), RobotError> {
    let error = |fault| RobotError::new(&spec.name, fault);
    let common = faults_in_common(spec, wheels);
    let of_wheels = wheels.iter().enumerate().flat_map(|(index, wheel)| {
        let faults = faults_of_wheel(spec, index, wheel, &common).into_iter();
        faults.map(|fault| match wheel.is_overridden {
            true => error(fault).about(format!("wheel `{}`", wheel.placed.name)),
            false => error(fault),
        })
    });
    let of_wheels: Vec<RobotError> = of_wheels.collect();
    refused(common.into_iter().map(error).chain(of_wheels))
}

/// Rejects a robot with faults, each key of them told once.
pub(super) fn refused(errors: impl IntoIterator<Item = RobotError>) -> Result<(), RobotError> {
    let mut told: Vec<RobotError> = Vec::new();
    for error in errors {
        let is_told = told.iter().any(|other| match error.fault().key() {
            Some(key) => other.fault().key() == Some(key),
            None => other.fault() == error.fault(),
        });
        if !is_told && told.len() < MOST_FAULTS {
            told.push(error);
        }
    }
    RobotError::of_all(told).map_or(Ok(()), Err)
}

/// The faults of all but the shapes of the single wheels.
fn faults_in_common(spec: &Spec, wheels: &[Described]) -> Vec<Fault> {
    let mut faults = ranges::faults(spec);
    faults.extend(faults_of_names(spec, wheels));
    faults.extend(faults_of_rollers(&spec.rollers));
    faults.extend(faults_of_suspensions(spec, wheels));
    if !(3..=1000).contains(&wheels.len()) {
        let range = "from 3 to 1000 wheels";
        faults.push(out_of_range("wheels", wheels.len(), range));
    }
    faults
}

/// The faults of names of wheels and rollers that have values of their own.
fn faults_of_names(spec: &Spec, wheels: &[Described]) -> Vec<Fault> {
    let of_rollers = spec.rollers.radius_offsets_m.keys();
    let of_rollers = of_rollers.filter(|name| !wheels.iter().any(|w| w.has_roller(name)));
    let of_rollers = of_rollers.map(|name| {
        let range = "the name of a roller's joint, such as `front_left_roller_1`";
        out_of_range(
            &format!("rollers.radius_offsets_m.{name}"),
            format!("`{name}`"),
            range,
        )
    });
    let of_wheels = spec.overrides.keys();
    let of_wheels = of_wheels.filter(|name| !wheels.iter().any(|w| w.placed.name == **name));
    let of_wheels = of_wheels.map(|name| no_such_wheel(&format!("overrides.{name}"), name, wheels));
    of_rollers.chain(of_wheels).collect()
}

fn no_such_wheel(key: &str, name: &str, wheels: &[Described]) -> Fault {
    let wheels = wheels.iter().map(|wheel| wheel.placed.name.clone());
    Fault::NoSuchWheel {
        key: key.to_owned(),
        wheel: name.to_owned(),
        wheels: wheels.collect(),
    }
}

/// The faults of what the rollers have beside their size and mass.
fn faults_of_rollers(r: &RollerSpec) -> Vec<Fault> {
    let mut faults = Vec::new();
    if r.profile_m.is_some() && r.length_factor != 1.0 {
        let range = "left out beside `rollers.profile_m`, which has its own length";
        faults.push(out_of_range(
            "rollers.length_factor",
            r.length_factor,
            range,
        ));
    }
    let surface = r.surface();
    let axle_m = surface.axle_radius_m;
    let fits = axle_m > 0.0 && axle_m < r.radius_m;
    // A negative radius and a negative axle are reported above.
    if surface.axle_friction > 0.0 && r.radius_m > 0.0 && axle_m >= 0.0 && !fits {
        let range = "above 0 and below `rollers.radius_m`, where there is `rollers.axle_friction`";
        faults.push(out_of_range("rollers.axle_radius_m", axle_m, range));
    }
    if !(1..=2).contains(&r.rows) {
        faults.push(out_of_range("rollers.rows", r.rows, "1 or 2"));
    }
    faults
}

/// The faults of the suspensions.
fn faults_of_suspensions(spec: &Spec, wheels: &[Described]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut hung: Vec<&str> = Vec::new();
    for (name, of) in &spec.suspension {
        let key = |of: &str| format!("suspension.{name}.{of}");
        for (index, wheel) in of.wheels.iter().enumerate() {
            let at = key(&format!("wheels.{index}"));
            if !wheels.iter().any(|known| known.placed.name == *wheel) {
                faults.push(no_such_wheel(&at, wheel, wheels));
            } else if hung.contains(&wheel.as_str()) {
                let range = "a wheel that hangs on nothing else, named once";
                faults.push(out_of_range(&at, wheel, range));
            }
            hung.push(wheel);
        }
        if of.wheels.is_empty() {
            faults.push(out_of_range(&key("wheels"), "empty", "one wheel or more"));
        }
        let is_rocker = matches!(of.law, SuspensionLaw::Rocker { .. });
        faults.extend(
            is_rocker
                .then(|| check_bar(name, of, wheels).err())
                .flatten(),
        );
        // Rockers have the name of their suspension, the others that of their wheel.
        if is_rocker && is_taken(name, wheels) {
            let range = "a name that no wheel's joint or link has";
            faults.push(out_of_range(
                &format!("suspension.{name}"),
                format!("`{name}`"),
                range,
            ));
        }
    }
    faults
}

/// Whether the joints and links of wheels and of what they hang on have a name.
fn is_taken(name: &str, wheels: &[Described]) -> bool {
    let mut names = wheels.iter().map(|wheel| wheel.placed.name.as_str());
    let joints = [
        Some(name),
        name.strip_suffix("_spring"),
        name.strip_suffix("_arm"),
    ];
    name.is_empty() || name == "base" || names.any(|wheel| joints.contains(&Some(wheel)))
}

/// Checks the two wheels of a rocker.
fn check_bar(name: &str, of: &SuspensionSpec, wheels: &[Described]) -> Result<(), Fault> {
    let named = of.wheels.iter();
    let known = named.filter_map(|name| wheels.iter().find(|wheel| wheel.placed.name == *name));
    let places: Vec<[f64; 2]> = known.map(|wheel| wheel.placed.position_m).collect();
    let is_named_twice = |(index, name): (usize, &String)| of.wheels[..index].contains(name);
    let names_are_wrong = of.wheels.iter().enumerate().any(is_named_twice)
        || places.len() < of.wheels.len()
        || of.wheels.is_empty();
    if names_are_wrong {
        // The caller reports names that are unknown, repeated or missing.
        return Ok(());
    }
    let range = match places[..] {
        [a, b] if (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6 => {
            "the names of two wheels at different places"
        }
        [_, _] => return Ok(()),
        _ => "the names of two wheels, which its bar joins",
    };
    let key = format!("suspension.{name}.wheels");
    Err(out_of_range(&key, of.wheels.join(", "), range))
}

/// The faults of a wheel, including its overrides; `common` are those of all wheels.
fn faults_of_wheel(spec: &Spec, index: usize, wheel: &Described, common: &[Fault]) -> Vec<Fault> {
    let (placed, r) = (&wheel.placed, &wheel.rollers);
    let overrides = spec.overrides.get(&placed.name);
    let overrides = overrides.and_then(|of| toml::Table::try_from(of).ok());
    let of = |common: &str, overridden: &str| {
        if (overrides.iter()).any(|overrides| overrides.contains_key(overridden)) {
            format!("overrides.{}.{overridden}", placed.name)
        } else {
            common.to_owned()
        }
    };
    let of_wheels = match &spec.wheels {
        Arrangement::Mecanum { .. } => "wheels.mecanum".to_owned(),
        Arrangement::Ring { .. } => "wheels.ring".to_owned(),
        Arrangement::List(_) => format!("wheels.list.{index}"),
    };
    let roller_radius = of("rollers.radius_m", "roller_radius_m");
    let mut faults = Vec::new();
    if !(3..=1000).contains(&r.per_row) {
        let key = of("rollers.per_row", "per_row");
        faults.push(out_of_range(&key, r.per_row, "from 3 to 1000"));
    }
    // At 90 deg the rollers turn about the hub axis and the wheel cannot drive.
    if placed.gamma_deg.abs() > 85.0 {
        let range =
            "from -85 to 85 degrees: nearer to 90 the rollers turn with the hub and carry no drive";
        let key = of(&format!("{of_wheels}.gamma_deg"), "gamma_deg");
        faults.push(out_of_range(&key, placed.gamma_deg, range));
    }
    // From a wrong size nothing follows about the shape.
    let mut keys = common.iter().chain(&faults).filter_map(Fault::key);
    if keys.any(|key| sets_the_shape(key, &placed.name)) {
        return faults;
    }
    faults.extend(check_shape(wheel, roller_radius).err());
    faults
}

/// Whether the shape of a wheel's rollers follows from a key.
fn sets_the_shape(key: &str, wheel: &str) -> bool {
    const KEYS: &str = "radius_m roller_radius_m per_row rows gamma_deg length_factor";
    let Some((rest, last)) = key.rsplit_once('.') else {
        return false;
    };
    let of = rest.strip_prefix("overrides.").unwrap_or(wheel);
    of == wheel && !rest.starts_with("chassis") && KEYS.split(' ').any(|known| known == last)
}

/// Checks that the rollers of a wheel can be made; `roller_radius` is the key of their radius.
fn check_shape(wheel: &Described, roller_radius: String) -> Result<(), Fault> {
    let (w, r) = (&wheel.wheel, &wheel.rollers);
    if r.radius_m >= w.radius_m {
        return Err(out_of_range(
            &roller_radius,
            r.radius_m,
            "below `wheel.radius_m`",
        ));
    }
    // The end spheres keep a positive radius where rho > a / cos(pi/n): r_max > rho (1 -
    // cos(pi/n)).
    let half_pitch_rad = PI / wheel.roller_count() as f64;
    let least_radius_m = w.radius_m * (1.0 - libm::cos(half_pitch_rad));
    if r.radius_m <= least_radius_m {
        return Err(Fault::RollersTooSlender {
            key: roller_radius,
            roller_radius_mm: 1e3 * r.radius_m,
            least_radius_mm: 1e3 * least_radius_m,
        });
    }
    let barrel = wheel.barrel();
    if barrel.sphere_radius_m(barrel.half_length_m) <= 0.0 {
        return Err(out_of_range(
            "rollers.length_factor",
            r.length_factor,
            "short enough for rollers of this radius, which taper to nothing before their ends",
        ));
    }
    let names = (0..wheel.roller_count()).map(|i| wheel.roller_name(i));
    r.made()
        .check_on(&barrel, names)
        .map_err(|e| Fault::RollersNotMade {
            reason: e.to_string(),
        })
}
