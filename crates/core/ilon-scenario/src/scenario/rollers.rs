//! `[rollers]`: shape, bearings and tread of the rollers.

use std::collections::BTreeMap;

use ilon_formats::RollerBearings;
use ilon_robot::{
    NotMade, Robot, Roller, RollerSurface as RobotSurface, RollersAsMade, Tread as RobotTread,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::scenario::checks::objection::given;

/// Shape, bearings and tread of the rollers. Defaults: the robot's file, else rigid and without
/// loss.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "RollersSection")]
pub struct RollerSurface {
    /// Length of a roller; 1 leaves neither gap nor overlap. Longer rollers share the ground (with
    /// a tread); shorter ones leave gaps.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub length_factor: Option<f64>,
    /// Curvature along a roller at its middle, relative to the ideal barrel: 1 makes the wheel a
    /// circle, less is flatter, more is rounder.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub crown: Option<f64>,
    /// `[[t, radius], ...]`, in metres: outline instead of a barrel, t along the axis from the
    /// middle, joined by straight lines. Two points make a cylinder.
    pub profile_m: Option<Vec<[f64; 2]>>,
    /// Radius to which all edges of `profile_m` are rounded, in metres.
    #[schemars(range(min = 0.0))]
    pub edge_radius_m: Option<f64>,
    /// Tolerance of the rollers' radius, in metres: each differs at random, evenly between minus
    /// and plus this.
    #[schemars(range(min = 0.0))]
    pub radius_spread_m: Option<f64>,
    /// Seed of `radius_spread_m`.
    pub radius_seed: Option<u32>,
    /// Error of the radius of single rollers, in metres, by joint name. Instead of random ones.
    pub radius_offsets_m: Option<BTreeMap<String, f64>>,
    /// Rolling resistance: drag per load on a level floor, added to the floor's.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// Material of the rollers: a name of `[materials]` [default: the robot's file].
    pub material: Option<String>,
    /// Material of the rollers of single wheels, by joint name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub wheel_materials: BTreeMap<String, String>,
    /// Play of each roller along its axle, from stop to stop, in metres.
    #[schemars(range(min = 0.0))]
    pub axial_play_m: Option<f64>,
    /// Class of the rollers' bearings: `"bushings"` dry plastic or bronze on a pin, `axle_friction`
    /// 0.2 on 0.15 of the roller's radius; `"ball"` 0.0015 on the same; `"industrial"` needle or
    /// tapered rollers, 0.0020 on 0.3 [default: the robot's file, else no friction that grows with
    /// the load].
    pub bearings: Option<RollerBearings>,
    /// Friction coefficient between roller and axle; overrides `bearings`. The torque is this times
    /// `axle_radius_m` times the load.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub axle_friction: Option<f64>,
    /// Radius of the rollers' axles, in metres; overrides `bearings`. Of a rolling bearing that of
    /// its bore.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub axle_radius_m: Option<f64>,
    /// A soft tread. Without it rollers are rigid.
    pub tread: Option<Tread>,
}

/// A tread: spring and damper along the ground's normal and across it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "TreadSection")]
pub struct Tread {
    /// Stiffness along the ground's normal, in N/m; rubber has 1e4 to 1e6. Required unless the
    /// robot's file has a tread.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m: Option<f64>,
    /// Damping along the normal, in N s/m [default: a tenth of critical under the load of a wheel].
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: Option<f64>,
    /// Stiffness across the normal, in N/m [default: 2/3 of that along it].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub shear_stiffness_n_m: Option<f64>,
    /// Damping across the normal, in N s/m [default: the same share of stiffness as along it].
    #[schemars(range(min = 0.0))]
    pub shear_damping_n_s_m: Option<f64>,
    /// Rolled distance over which sheared tread is renewed, in metres. A roller creeps by pull /
    /// (`shear_stiffness_n_m` times this) [default: no creep].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub relaxation_length_m: Option<f64>,
}

impl RollerSurface {
    /// Whether it is empty.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Overrides the roller properties of the robot's file with those of this section.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a tread has no stiffness, or a roller cannot be that long.
    pub fn apply(&self, robot: &mut Robot) -> Result<(), Error> {
        self.refuse_on_tyres(robot)?;
        for wheel in &mut robot.wheels {
            let surface = &mut wheel.surface;
            surface.rolling_resistance = self
                .rolling_resistance
                .unwrap_or(surface.rolling_resistance);
            surface.axial_play_m = self.axial_play_m.unwrap_or(surface.axial_play_m);
            self.put_on_axles(surface, &wheel.rollers);
            check_axle(surface, &wheel.name)?;
            if let Some(tread) = &self.tread {
                surface.tread = Some(tread.laid_over(surface.tread, &wheel.name)?);
            }
        }
        self.apply_materials(robot)?;
        self.check_names(robot)?;
        for wheel in &mut robot.wheels {
            let made = self.made_over(&wheel.made);
            if made == wheel.made && self.length_factor.is_none() {
                continue;
            }
            let name = wheel.name.clone();
            let made = wheel.make_rollers(made, self.length_factor);
            made.map_err(|fault| of_wheel(&name, &fault))?;
        }
        Ok(())
    }

    /// Refuses keys that only rollers have for a robot with tyres.
    fn refuse_on_tyres(&self, robot: &Robot) -> Result<(), Error> {
        let Some(wheel) = robot.wheels.iter().find(|wheel| wheel.has_tyre()) else {
            return Ok(());
        };
        let keys = given!(
            self,
            length_factor,
            crown,
            profile_m,
            edge_radius_m,
            radius_spread_m,
            radius_offsets_m,
            axial_play_m,
            bearings,
            axle_friction,
            axle_radius_m,
        );
        match keys.into_iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) => Err(Error::invalid(
                format!(
                    "`rollers.{key}` needs rollers, but the wheel `{}` has a tyre",
                    wheel.name
                ),
                "leave it out; tyres are described in `robot.tyres`",
            )),
            None => Ok(()),
        }
    }

    /// Sets how the rollers of a wheel turn on their axles.
    fn put_on_axles(&self, surface: &mut RobotSurface, rollers: &[Roller]) {
        if let Some(bearings) = self.bearings {
            let radius_m = rollers.iter().map(|r| r.radius_m).fold(0.0, f64::max);
            surface.axle_friction = bearings.axle_friction();
            surface.axle_radius_m = bearings.axle_radius_m(radius_m);
        }
        surface.axle_friction = self.axle_friction.unwrap_or(surface.axle_friction);
        surface.axle_radius_m = self.axle_radius_m.unwrap_or(surface.axle_radius_m);
    }

    /// Sets the materials of the rollers.
    fn apply_materials(&self, robot: &mut Robot) -> Result<(), Error> {
        for wheel in &mut robot.wheels {
            let said = self.wheel_materials.get(&wheel.name);
            if let Some(material) = said.or(self.material.as_ref()) {
                wheel.material = Some(material.clone());
            }
        }
        let is_wheel = |name: &&String| robot.wheels.iter().any(|wheel| wheel.name == **name);
        match self.wheel_materials.keys().find(|name| !is_wheel(name)) {
            None => Ok(()),
            Some(name) => {
                let wheels: Vec<&str> = robot.wheels.iter().map(|w| w.name.as_str()).collect();
                Err(Error::invalid(
                    format!(
                        "`rollers.wheel_materials` names `{name}`, but the robot has no such wheel"
                    ),
                    format!("its wheels are {}", wheels.join(", ")),
                ))
            }
        }
    }

    /// The manufacturing parameters, with missing ones from the robot's file.
    fn made_over(&self, below: &RollersAsMade) -> RollersAsMade {
        let mut made = below.clone();
        made.crown = self.crown.unwrap_or(made.crown);
        made.profile_m = self.profile_m.clone().or(made.profile_m);
        made.edge_radius_m = self.edge_radius_m.unwrap_or(made.edge_radius_m);
        made.radius_spread_m = self.radius_spread_m.unwrap_or(made.radius_spread_m);
        made.radius_seed = self.radius_seed.map_or(made.radius_seed, u64::from);
        if let Some(offsets_m) = &self.radius_offsets_m {
            made.radius_offsets_m.clone_from(offsets_m);
        }
        made
    }

    /// Refuses radii of rollers that the robot does not have.
    fn check_names(&self, robot: &Robot) -> Result<(), Error> {
        let mut names = self.radius_offsets_m.iter().flat_map(BTreeMap::keys);
        let rollers = || robot.wheels.iter().flat_map(|wheel| &wheel.rollers);
        let Some(name) = names.find(|name| rollers().all(|roller| roller.name != **name)) else {
            return Ok(());
        };
        let known = rollers().next().map_or("", |roller| &roller.name);
        Err(Error::invalid(
            format!("`rollers.radius_offsets_m` names `{name}`, but the robot has no such roller"),
            format!("write the name of a roller's joint, such as `{known}`"),
        ))
    }
}

impl Tread {
    /// This tread, with missing values from another.
    fn laid_over(&self, below: Option<RobotTread>, wheel: &str) -> Result<RobotTread, Error> {
        let stiffness_n_m = self
            .stiffness_n_m
            .or(below.map(|tread| tread.stiffness_n_m));
        let Some(stiffness_n_m) = stiffness_n_m else {
            return Err(Error::invalid(
                format!(
                    "`rollers.tread` has no stiffness, and neither has the robot's file for the wheel `{wheel}`"
                ),
                "add `rollers.tread.stiffness_n_m`, in N/m: that of rubber on hard ground is 1e4 to 1e6",
            ));
        };
        let mut tread = below.unwrap_or(RobotTread::new(stiffness_n_m));
        tread.stiffness_n_m = stiffness_n_m;
        for (value, said) in [
            (&mut tread.damping_n_s_m, self.damping_n_s_m),
            (&mut tread.shear_stiffness_n_m, self.shear_stiffness_n_m),
            (&mut tread.shear_damping_n_s_m, self.shear_damping_n_s_m),
            (&mut tread.relaxation_length_m, self.relaxation_length_m),
        ] {
            *value = said.or(*value);
        }
        Ok(tread)
    }
}

/// Refuses friction on axles of unknown radius.
fn check_axle(surface: &RobotSurface, wheel: &str) -> Result<(), Error> {
    if surface.axle_friction == 0.0 || surface.axle_radius_m > 0.0 {
        return Ok(());
    }
    Err(Error::invalid(
        format!(
            "`rollers.axle_friction` is given, but the radius of the axles of the wheel `{wheel}` is not"
        ),
        "add `rollers.axle_radius_m`, in metres, or a class of wheels: `rollers.bearings` = \"bushings\"",
    ))
}

/// The error for a wheel whose rollers cannot be made like this.
fn of_wheel(wheel: &str, fault: &NotMade) -> Error {
    let help = match fault {
        NotMade::AsModelled => {
            "leave out the keys of their shape, or take barrels: `robot.rollers` = \"barrel\""
        }
        _ => "write a value within its range, or leave it out",
    };
    Error::invalid(format!("the rollers of the wheel `{wheel}`: {fault}"), help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_formats::LoadRobot;

    const ROBOT: &str = "../../../assets/robots/mecanum4.toml";

    fn applied(lines: &str) -> Result<Robot, Error> {
        let mut robot = Robot::load(ROBOT).unwrap();
        let section: RollerSurface = toml::from_str(lines).unwrap();
        section.apply(&mut robot)?;
        Ok(robot)
    }

    #[test]
    fn what_is_left_out_stays_as_the_file_says() {
        let mut robot = applied("rolling_resistance = 0.02\ntread.stiffness_n_m = 1e5").unwrap();
        let more: RollerSurface = toml::from_str("tread.shear_stiffness_n_m = 4e4").unwrap();
        more.apply(&mut robot).unwrap();
        for wheel in &robot.wheels {
            let tread = wheel.surface.tread.unwrap();
            assert_eq!(
                (tread.stiffness_n_m, tread.shear_stiffness_n_m),
                (1e5, Some(4e4))
            );
            assert_eq!(wheel.surface.rolling_resistance, 0.02);
        }
    }

    #[test]
    fn bearings_say_friction_and_axle_and_single_keys_go_before() {
        let axles = |lines: &str| {
            let surface = applied(lines).unwrap().wheels[0].surface;
            (surface.axle_friction, surface.axle_radius_m)
        };
        // Rollers of 12 mm.
        let close = |found: (f64, f64), said: (f64, f64)| {
            let off = (found.0 - said.0).abs() + (found.1 - said.1).abs();
            assert!(off < 1e-9, "{found:?} {said:?}");
        };
        close(axles(""), (0.0, 0.0));
        close(axles("bearings = 'bushings'"), (0.2, 1.8e-3));
        close(axles("bearings = 'ball'"), (0.0015, 1.8e-3));
        close(axles("bearings = 'industrial'"), (0.002, 3.6e-3));
        close(
            axles("bearings = 'ball'\naxle_friction = 0.1"),
            (0.1, 1.8e-3),
        );
        close(
            axles("bearings = 'ball'\naxle_radius_m = 2e-3"),
            (0.0015, 2e-3),
        );
        let fault = applied("axle_friction = 0.1").unwrap_err().to_string();
        assert!(
            fault.contains("the radius of the axles") && fault.contains("front_left"),
            "{fault}"
        );
    }

    #[test]
    fn a_description_says_the_same_of_the_axles() {
        for lines in [
            "bearings = 'bushings'",
            "axle_friction = 0.3\naxle_radius_m = 2.5e-3",
        ] {
            let mut options = ilon_formats::LoadOptions::default();
            options.spec = toml::from_str(&format!("[rollers]\n{lines}")).unwrap();
            let described = Robot::load_with(ROBOT, &options).unwrap().robot;
            let (a, b) = (
                described.wheels[1].surface,
                applied(lines).unwrap().wheels[1].surface,
            );
            assert!((a.axle_friction - b.axle_friction).abs() < 1e-12);
            assert!((a.axle_radius_m - b.axle_radius_m).abs() < 1e-12);
        }
    }

    #[test]
    fn a_tread_without_a_stiffness_is_refused() {
        let fault = applied("tread.damping_n_s_m = 3.0")
            .unwrap_err()
            .to_string();
        assert!(
            fault.contains("stiffness") && fault.contains("front_left"),
            "{fault}"
        );
    }

    #[test]
    fn a_longer_roller_is_as_a_description_makes_it() {
        // The same factor in the robot's description: lengths and moments agree to the file's
        // digits.
        let mut options = ilon_formats::LoadOptions::default();
        options.spec = toml::from_str("rollers.length_factor = 1.3").unwrap();
        let described = Robot::load_with(ROBOT, &options).unwrap().robot;
        let applied = applied("length_factor = 1.3").unwrap();
        for (a, b) in applied.wheels.iter().zip(&described.wheels) {
            for (a, b) in a.rollers.iter().zip(&b.rollers) {
                assert!((a.length_m / b.length_m - 1.0).abs() < 1e-9);
                assert!((a.axial_inertia_kg_m2 / b.axial_inertia_kg_m2 - 1.0).abs() < 1e-6);
                let across = a.transverse_inertia_kg_m2 / b.transverse_inertia_kg_m2;
                assert!((across - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_scenario_makes_rollers_as_a_description_does() {
        // Key by key: the description's crown is kept if the scenario sets a length.
        let lines =
            "rollers.crown = 0.8\nrollers.length_factor = 0.9\nrollers.radius_spread_m = 1e-4";
        let mut options = ilon_formats::LoadOptions::default();
        options.spec = toml::from_str(lines).unwrap();
        let described = Robot::load_with(ROBOT, &options).unwrap().robot;
        options.spec = toml::from_str("rollers.crown = 0.8").unwrap();
        let mut robot = Robot::load_with(ROBOT, &options).unwrap().robot;
        let section: RollerSurface =
            toml::from_str("length_factor = 0.9\nradius_spread_m = 1e-4").unwrap();
        section.apply(&mut robot).unwrap();
        for (a, b) in robot.wheels.iter().zip(&described.wheels) {
            assert_eq!(a.made, b.made);
            for (one, other) in a.rollers.iter().zip(&b.rollers) {
                let (p, q) = (a.barrel(one), b.barrel(other));
                // Accuracy of the file's fifteen digits.
                assert!((p.wheel_radius_m / q.wheel_radius_m - 1.0).abs() < 1e-9);
                assert!((p.half_length_m / q.half_length_m - 1.0).abs() < 1e-9);
                assert!((one.axial_inertia_kg_m2 / other.axial_inertia_kg_m2 - 1.0).abs() < 1e-6);
            }
        }
        // An empty section changes nothing.
        let before = robot.wheels[0].rollers.clone();
        RollerSurface::default().apply(&mut robot).unwrap();
        assert_eq!(before, robot.wheels[0].rollers);
    }

    #[test]
    fn rollers_that_cannot_be_made_are_refused_in_words() {
        for (lines, said) in [
            ("radius_offsets_m = { nobody = 1e-4 }", "front_left_roller"),
            ("crown = 30.0", "front_left"),
            (
                "profile_m = [[-0.01, 0.012], [0.0, 0.01], [0.01, 0.012]]",
                "hollow",
            ),
            ("profile_m = [[-10.0, 12.0], [10.0, 12.0]]", "metres"),
        ] {
            let fault = applied(lines).unwrap_err();
            let text = format!("{fault:?}");
            assert!(text.contains(said), "{lines}: {text}");
        }
    }

    #[test]
    fn a_roller_that_would_taper_to_nothing_is_refused() {
        let fault = applied("length_factor = 3.0").unwrap_err().to_string();
        assert!(fault.contains("taper to nothing"), "{fault}");
    }
}
