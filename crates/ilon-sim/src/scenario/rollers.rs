//! `[rollers]`: what the rollers touch the ground with.

use ilon_robot::{Barrel, Robot, RollerForm, Tread as RobotTread};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;

/// What the rollers touch the ground with. What is left out stays as the robot's file says, or else rigid and without loss.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "RollersSection")]
pub struct RollerSurface {
    /// Length of each roller over that at which neighbours hand over with neither gap nor overlap: longer rollers share the ground
    /// about each hand-over, where they have a tread. The robot is drawn with the rollers of its file.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 10.0))]
    pub length_factor: Option<f64>,
    /// Rolling resistance of the rollers: drag per load on a level floor, dimensionless. That of the floor comes on top.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// A tread: rollers that give, so that every roller which reaches the ground carries its share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tread: Option<Tread>,
}

/// A tread between a roller's core and the ground: a spring with a damper beside it, along the normal and across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "TreadSection")]
pub struct Tread {
    /// Stiffness along the ground's normal, in N/m: that of rubber on hard ground is 1e4 to 1e6. Needed where the robot's file
    /// says nothing of a tread.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness_n_m: Option<f64>,
    /// Damping along the normal, in N s/m; left out, what the robot's file says, or else a tenth of what is critical for the load
    /// on a wheel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: Option<f64>,
    /// Stiffness across the normal, in N/m; left out, what the robot's file says, or else 2/3 of that along it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub shear_stiffness_n_m: Option<f64>,
    /// Damping across the normal, in N s/m; left out, what the robot's file says, or else as much of the stiffness as along it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub shear_damping_n_s_m: Option<f64>,
    /// The way over which sheared tread leaves the ground as the roller rolls on, in metres: a roller that pulls creeps by its
    /// pull over `shear_stiffness_n_m` times this. Left out, what the robot's file says, or else no creep.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub relaxation_length_m: Option<f64>,
}

impl RollerSurface {
    /// Whether nothing is said.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Puts what is said here of the rollers in the place of what the robot's file says of them.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a tread has no stiffness, or a roller cannot be so long.
    pub fn apply(&self, robot: &mut Robot) -> Result<(), Error> {
        for wheel in &mut robot.wheels {
            let surface = &mut wheel.surface;
            surface.rolling_resistance = self
                .rolling_resistance
                .unwrap_or(surface.rolling_resistance);
            if let Some(tread) = &self.tread {
                surface.tread = Some(tread.laid_over(surface.tread, &wheel.name)?);
            }
        }
        match self.length_factor {
            Some(factor) => lengthen(robot, factor),
            None => Ok(()),
        }
    }
}

impl Tread {
    /// This tread, with what it leaves out from another.
    fn laid_over(&self, below: Option<RobotTread>, wheel: &str) -> Result<RobotTread, Error> {
        let stiffness_n_m = self
            .stiffness_n_m
            .or(below.map(|tread| tread.stiffness_n_m));
        let Some(stiffness_n_m) = stiffness_n_m else {
            return Err(Error::invalid(
                format!(
                    "`rollers.tread` says nothing of the stiffness, and the robot's file has no tread on the wheel `{wheel}`"
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

/// Gives the barrels of a robot another length, at the same mass and density along it.
fn lengthen(robot: &mut Robot, factor: f64) -> Result<(), Error> {
    for wheel in &mut robot.wheels {
        let count = wheel.rollers.len();
        for index in 0..count {
            let roller = &wheel.rollers[index];
            if roller.form != RollerForm::Barrel {
                return Err(Error::invalid(
                    format!(
                        "the rollers of the wheel `{}` have the shapes of their file, which have their own length",
                        wheel.name
                    ),
                    "leave `rollers.length_factor` out, or take barrels: `robot.rollers` = \"barrel\"",
                ));
            }
            let before = wheel.barrel(roller);
            let thick_m = wheel.radius_m - roller.ring_radius_m();
            let even = Barrel::handing_over(wheel.radius_m, thick_m, wheel.gamma_rad, count);
            let after = Barrel {
                half_length_m: factor * even.half_length_m,
                ..before
            };
            let end_mm = 1e3 * after.sphere_radius_m(after.half_length_m);
            if end_mm <= 0.0 {
                return Err(Error::invalid(
                    format!(
                        "`rollers.length_factor` = {factor} is too long for the wheel `{}`: its rollers would taper to nothing \
                         before their ends",
                        wheel.name
                    ),
                    "write a smaller factor, or take thicker rollers",
                ));
            }
            let mass_kg = roller.mass_kg;
            let ratio = |of: fn((f64, f64)) -> f64| {
                of(after.solid_moments_kg_m2(mass_kg)) / of(before.solid_moments_kg_m2(mass_kg))
            };
            let (axial, across) = (ratio(|moments| moments.0), ratio(|moments| moments.1));
            let roller = &mut wheel.rollers[index];
            roller.length_m = 2.0 * after.half_length_m;
            roller.axial_inertia_kg_m2 *= axial;
            roller.transverse_inertia_kg_m2 *= across;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: &str = "../../assets/robots/mecanum4.toml";

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
        // The same factor in the description of the robot: lengths and moments agree to what the file's digits hold.
        let mut options = ilon_robot::LoadOptions::default();
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
    fn a_roller_that_would_taper_to_nothing_is_refused() {
        let fault = applied("length_factor = 3.0").unwrap_err().to_string();
        assert!(fault.contains("taper to nothing"), "{fault}");
    }
}
