//! Range checks of a description's values.

use std::f64::consts::PI;

use ilon_files::keys::MOST_FAULTS;

use super::{
    Arrangement, ChassisShape, ChassisSpec, Described, RollerSpec, Spec, SuspensionLaw,
    SuspensionSpec,
};
use crate::error::{Fault, RobotError};

const POSITIVE: &str = "a finite number above 0";
const NOT_NEGATIVE: &str = "a finite number, 0 or above";
const FINITE: &str = "a finite number";

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

/// The faults of those of some values, by key, that fail a check.
pub(super) fn failing<'a>(
    values: impl IntoIterator<Item = (&'a str, f64)>,
    check: fn(&str, f64) -> Result<(), Fault>,
) -> impl Iterator<Item = Fault> {
    let values = values.into_iter();
    values.filter_map(move |(key, value)| check(key, value).err())
}

pub(super) fn out_of_range(key: &str, value: impl ToString, range: &'static str) -> Fault {
    Fault::OutOfRange {
        key: key.to_owned(),
        value: value.to_string(),
        range,
    }
}

pub(super) fn positive(key: &str, value: f64) -> Result<(), Fault> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(out_of_range(key, value, POSITIVE))
}

/// Checks a length of a wheel's part: millimetres written as metres are a thousand times too large.
pub(super) fn length_of_wheel(key: &str, value_m: f64) -> Result<(), Fault> {
    const MOST_M: f64 = 5.0;
    positive(key, value_m)?;
    if value_m < MOST_M {
        return Ok(());
    }
    Err(out_of_range(
        key,
        value_m,
        "a length in metres, below 5: 50 mm are 0.05",
    ))
}

pub(super) fn not_negative(key: &str, value: f64) -> Result<(), Fault> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(out_of_range(key, value, NOT_NEGATIVE))
}

pub(super) fn finite(key: &str, value: f64) -> Result<(), Fault> {
    if value.is_finite() {
        return Ok(());
    }
    Err(out_of_range(key, value, FINITE))
}

/// The faults of a chassis.
pub(super) fn faults_of_chassis(c: &ChassisSpec) -> Vec<Fault> {
    let cylinder = "chassis.shape.cylinder";
    let sides = match &c.shape {
        ChassisShape::Box { size_m } => size_m.map(|side_m| ("chassis.shape.box.size_m", side_m)),
        ChassisShape::Cylinder { radius_m, height_m } => {
            [*radius_m, *height_m, *height_m].map(|side_m| (cylinder, side_m))
        }
    };
    let positives = sides.into_iter().chain([("chassis.mass_kg", c.mass_kg)]);
    let places = c.center_m.map(|value_m| ("chassis.center_m", value_m));
    failing(positives, positive)
        .chain(failing(places, finite))
        .collect()
}

/// The faults of the chassis and of the values shared by all wheels.
fn faults_in_common(spec: &Spec, wheels: &[Described]) -> Vec<Fault> {
    let (w, r) = (&spec.wheel, &spec.rollers);
    let mut faults = faults_of_chassis(&spec.chassis);
    let positives = [
        ("wheel.hub_mass_kg", w.hub_mass_kg),
        ("wheel.motor_effort_n_m", w.motor_effort_n_m),
        ("wheel.motor_velocity_rad_s", w.motor_velocity_rad_s),
        ("wheel.gear_ratio", w.gear_ratio),
        ("wheel.gear_efficiency", w.gear_efficiency),
        ("rollers.mass_kg", r.mass_kg),
        ("rollers.length_factor", r.length_factor),
    ];
    faults.extend(failing(positives, positive));
    let lengths_m = [
        ("wheel.radius_m", w.radius_m),
        ("wheel.hub_radius_m", w.hub_radius_m),
        ("wheel.hub_width_m", w.hub_width_m),
        ("rollers.radius_m", r.radius_m),
    ];
    faults.extend(failing(lengths_m, length_of_wheel));
    let losses = [
        ("wheel.damping_n_m_s", w.damping_n_m_s),
        ("wheel.friction_n_m", w.friction_n_m),
        ("wheel.rotor_inertia_kg_m2", w.rotor_inertia_kg_m2),
        ("wheel.gear_friction_n_m", w.gear_friction_n_m),
        ("rollers.damping_n_m_s", r.damping_n_m_s),
        ("rollers.friction_n_m", r.friction_n_m),
        ("rollers.row_spacing_m", r.row_spacing_m),
        ("rollers.rolling_resistance", r.rolling_resistance),
        ("rollers.axial_play_m", r.axial_play_m),
        ("rollers.axle_friction", r.axle_friction.unwrap_or(0.0)),
        ("rollers.axle_radius_m", r.axle_radius_m.unwrap_or(0.0)),
    ];
    faults.extend(failing(losses, not_negative));
    faults.extend(faults_of_names(spec, wheels));
    faults.extend(faults_of_rollers(r));
    faults.extend(faults_of_suspensions(spec, wheels));
    if w.gear_efficiency > 1.0 {
        let (key, range) = ("wheel.gear_efficiency", "above 0 and at most 1");
        faults.push(out_of_range(key, w.gear_efficiency, range));
    }
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
    let mut faults = faults_of_tread(r);
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

/// The faults of the tread, if there is one.
fn faults_of_tread(rollers: &RollerSpec) -> Vec<Fault> {
    let Some(tread) = &rollers.tread else {
        return Vec::new();
    };
    let positives = [
        ("rollers.tread.stiffness_n_m", Some(tread.stiffness_n_m)),
        (
            "rollers.tread.shear_stiffness_n_m",
            tread.shear_stiffness_n_m,
        ),
        (
            "rollers.tread.relaxation_length_m",
            tread.relaxation_length_m,
        ),
    ];
    let losses = [
        ("rollers.tread.damping_n_s_m", tread.damping_n_s_m),
        (
            "rollers.tread.shear_damping_n_s_m",
            tread.shear_damping_n_s_m,
        ),
    ];
    let given = |(key, value): (&'static str, Option<f64>)| value.map(|value| (key, value));
    failing(positives.into_iter().filter_map(given), positive)
        .chain(failing(losses.into_iter().filter_map(given), not_negative))
        .collect()
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
        faults.extend(positive(&key("mass_kg"), of.mass_kg).err());
        faults.extend(faults_of_law(name, of));
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

/// The faults of the numbers of one suspension.
fn faults_of_law(name: &str, of: &SuspensionSpec) -> Vec<Fault> {
    let key = |kind: &str, of: &str| format!("suspension.{name}.law.{kind}.{of}");
    type Numbers = Vec<(&'static str, f64)>;
    let (kind, positives, others): (&str, Numbers, Numbers) = match of.law {
        SuspensionLaw::Rocker {
            limit_deg,
            damping_n_m_s_rad,
            friction_n_m,
        } => (
            "rocker",
            vec![("limit_deg", limit_deg)],
            vec![
                ("damping_n_m_s_rad", damping_n_m_s_rad),
                ("friction_n_m", friction_n_m),
            ],
        ),
        SuspensionLaw::Sprung {
            stiffness_n_m,
            damping_n_s_m,
            friction_n,
            preload_n,
            travel_m,
        } => (
            "sprung",
            vec![("stiffness_n_m", stiffness_n_m), ("travel_m", travel_m)],
            vec![
                ("damping_n_s_m", damping_n_s_m),
                ("friction_n", friction_n),
                ("preload_n", preload_n),
            ],
        ),
        SuspensionLaw::TrailingArm {
            length_m,
            stiffness_n_m_rad,
            damping_n_m_s_rad,
            friction_n_m,
            preload_n_m,
            travel_deg,
        } => (
            "trailing_arm",
            vec![
                ("length_m", length_m.abs()),
                ("stiffness_n_m_rad", stiffness_n_m_rad),
                ("travel_deg", travel_deg),
            ],
            vec![
                ("damping_n_m_s_rad", damping_n_m_s_rad),
                ("friction_n_m", friction_n_m),
                ("preload_n_m", preload_n_m),
            ],
        ),
    };
    let mut faults = Vec::new();
    for (of, value) in positives {
        let key = key(kind, of);
        faults.extend(positive(&key, value).err());
        if of.ends_with("_deg") && value >= 90.0 && value.is_finite() {
            faults.push(out_of_range(&key, value, "above 0 and below 90 degrees"));
        }
    }
    let others = others.into_iter();
    faults.extend(others.filter_map(|(of, value)| not_negative(&key(kind, of), value).err()));
    faults
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
    let (placed, w, r) = (&wheel.placed, &wheel.wheel, &wheel.rollers);
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
    let ranges = [
        length_of_wheel(&of("wheel.radius_m", "radius_m"), w.radius_m),
        positive(&of("wheel.hub_mass_kg", "hub_mass_kg"), w.hub_mass_kg),
        length_of_wheel(&roller_radius, r.radius_m),
        positive(&of("rollers.mass_kg", "roller_mass_kg"), r.mass_kg),
        finite(&of("", "phase_deg"), wheel.phase_rad),
    ];
    let mut faults: Vec<Fault> = ranges.into_iter().filter_map(Result::err).collect();
    if !(3..=1000).contains(&r.per_row) {
        let key = of("rollers.per_row", "per_row");
        faults.push(out_of_range(&key, r.per_row, "from 3 to 1000"));
    }
    let place = [placed.position_m[0], placed.position_m[1], placed.axis_deg];
    faults.extend(
        place
            .iter()
            .filter_map(|value| finite(&of_wheels, *value).err()),
    );
    // At 90 deg the rollers turn about the hub axis and the wheel cannot drive.
    if placed.gamma_deg.is_nan() || placed.gamma_deg.abs() > 85.0 {
        let range =
            "from -85 to 85 degrees: nearer to 90 the rollers turn with the hub and carry no drive";
        let key = of(&format!("{of_wheels}.gamma_deg"), "gamma_deg");
        faults.push(out_of_range(&key, placed.gamma_deg, range));
    }
    // From a wrong size nothing follows about the shape.
    let sized = common.iter().chain(&faults).filter_map(Fault::key);
    if sized.into_iter().any(sets_the_shape) {
        return faults;
    }
    faults.extend(check_shape(wheel, roller_radius).err());
    faults
}

/// Whether the shape of the rollers follows from a key.
fn sets_the_shape(key: &str) -> bool {
    const KEYS: &str = "radius_m roller_radius_m per_row rows gamma_deg length_factor";
    let last = key.rsplit('.').next();
    KEYS.split(' ').any(|known| Some(known) == last)
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
