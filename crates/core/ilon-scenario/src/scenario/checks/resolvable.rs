//! Checks whether the steps and the contacts of a run can resolve its content.

use ilon_robot::{Robot, Scale};

use super::objection::Objection;
use crate::Error;
use crate::scenario::{Body, Contacts, Fault, Scenario};

/// The largest deflection of contacts, relative to a wheel's radius. Chosen.
const TOO_DEEP: f64 = 0.1;

impl Scenario {
    /// The longest physics step, in seconds, in which no free body can pass through what it meets,
    /// and the index of that body; `None` for bodies that do not move. In a step a body may move by
    /// its own smallest size plus that of what it meets: wheels of a radius in metres, boxes, other
    /// bodies.
    pub fn longest_step_of_bodies(&self, wheel_radius_m: f64) -> Option<(usize, f64)> {
        let bodies = &self.world.bodies;
        let boxes = self.world.floor.boxes.iter();
        let of_boxes_m = boxes.map(|of| of.length_x_m.min(of.length_y_m).min(of.height_m));
        let of_ground_m = of_boxes_m.fold(wheel_radius_m, f64::min);
        let step_s = |(index, body): (usize, &Body)| {
            let others = bodies
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != index);
            let least_m = others
                .map(|(_, other)| other.least_size_m())
                .fold(of_ground_m, f64::min);
            let speed_m_s = body.fastest_m_s(self.world.gravity_m_s2);
            (speed_m_s > 0.0).then(|| (index, (body.least_size_m() + least_m) / speed_m_s))
        };
        let steps = bodies.iter().enumerate().filter_map(step_s);
        steps.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// Refuses bodies so fast that they could pass through what they meet within a physics step of
    /// that length.
    ///
    /// # Errors
    /// [`Error::Invalid`], with the step that is short enough.
    pub fn check_bodies(&self, physics_dt_s: f64, wheel_radius_m: f64) -> Result<(), Error> {
        match self.longest_step_of_bodies(wheel_radius_m) {
            // A relative slack of 1e-9 for rounding.
            Some((index, longest_s)) if physics_dt_s > longest_s * (1.0 + 1e-9) => {
                let body = &self.world.bodies[index];
                let speed_m_s = body.fastest_m_s(self.world.gravity_m_s2);
                Err(Objection::to(
                    format!("world.bodies.{index}"),
                    format!(
                        "body `{}` moves at up to {speed_m_s:.4} m/s, by {:.4} m in a physics step of {physics_dt_s} s: it may pass through what it meets",
                        body.name,
                        speed_m_s * physics_dt_s
                    ),
                    format!(
                        "set `run.physics_dt_s` to {longest_s:.3e} at most, or make the body slower or larger"
                    ),
                ))?
            }
            _ => Ok(()),
        }
    }

    /// The depth by which the wheels sink into the ground under the robot's weight with a payload,
    /// in metres, and as a share of their radius; `None` for contacts without a stiffness.
    fn sinks(&self, robot: &Robot, payload_kg: f64) -> Option<[f64; 2]> {
        let solver = &self.world.solver;
        let scale = Scale::of(robot, self.world.gravity_m_s2);
        let (Contacts::Ilon, Some(stiffness_n_m)) = (solver.contacts, solver.contact_stiffness_n_m)
        else {
            return None;
        };
        let load_kg = scale.load_kg + payload_kg / robot.wheels.len() as f64;
        let sinks_m = load_kg * self.world.gravity_m_s2 / stiffness_n_m;
        Some([sinks_m, sinks_m / scale.length_m])
    }

    /// Refuses a payload, in kg, under which the robot would be in the ground rather than on it.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the wheels sink by more than a tenth of their radius.
    pub fn check_payload(&self, robot: &Robot, payload_kg: f64) -> Result<(), Error> {
        match self.sinks(robot, payload_kg) {
            Some([sinks_m, share]) if share > TOO_DEEP => Err(Error::invalid(
                format!(
                    "the wheels would sink by {:.3} mm into the ground, {:.0} % of their radius, under a payload of {payload_kg} kg",
                    1e3 * sinks_m,
                    100.0 * share
                ),
                "give a lighter one, or set `world.solver.contact_stiffness_n_m` higher",
            )),
            _ => Ok(()),
        }
    }

    /// Remarks contacts that deflect far under the robot's weight with its heaviest payload.
    ///
    /// # Errors
    /// [`Error::Invalid`] if they deflect by more than a tenth of a wheel's radius: such a robot
    /// would be in the ground rather than on it.
    pub fn check_contacts(&self, robot: &Robot) -> Result<Option<String>, Error> {
        /// Relative to a wheel's radius: a larger deflection means rolling on a smaller wheel.
        /// Chosen.
        const DEEP: f64 = 0.01;
        let payloads = self
            .faults
            .iter()
            .enumerate()
            .filter_map(|(index, of)| match of {
                Fault::Payload { mass_kg, .. } => Some((index, *mass_kg)),
                _ => None,
            });
        let heaviest = payloads.max_by(|one, other| one.1.total_cmp(&other.1));
        let payload_kg = heaviest.map_or(0.0, |(_, mass_kg)| mass_kg.max(0.0));
        let solver = &self.world.solver;
        let sinks = self
            .sinks(robot, payload_kg)
            .filter(|[_, share]| *share >= DEEP);
        let (Some([sinks_m, share]), Some(stiffness_n_m)) = (sinks, solver.contact_stiffness_n_m)
        else {
            return Ok(None);
        };
        let load_kg = sinks_m * stiffness_n_m / self.world.gravity_m_s2;
        let enough_n_m = stiffness_n_m * share / DEEP;
        let message = format!(
            "the wheels sink by {:.3} mm into the ground, {:.0} % of their radius, under {:.4} kg on each: \
             `world.solver.contact_stiffness_n_m` = {stiffness_n_m:.3e}",
            1e3 * sinks_m,
            100.0 * share,
            load_kg
        );
        // A payload heavier than the robot is named as the cause.
        let (key, help) = match heaviest {
            Some((index, _)) if payload_kg > robot.mass_kg() => (
                format!("faults.{index}"),
                format!(
                    "make the payload lighter, or set `world.solver.contact_stiffness_n_m` to {enough_n_m:.1e} or more"
                ),
            ),
            _ => (
                "world.solver.contact_stiffness_n_m".to_owned(),
                format!("set it to {enough_n_m:.1e} or more, or leave it out"),
            ),
        };
        if share > TOO_DEEP {
            return Err(Objection::to(key, message, help))?;
        }
        Ok(Some(format!("{message}; {help}")))
    }
}

impl Body {
    /// Its smallest dimension, in metres.
    fn least_size_m(&self) -> f64 {
        let of_box = self.cuboid.iter().flat_map(|of| of.size_m);
        let of_cylinder = self
            .cylinder
            .iter()
            .flat_map(|of| [2.0 * of.radius_m, of.length_m]);
        let of_sphere = self.sphere.iter().map(|of| 2.0 * of.radius_m);
        let sizes_m = of_box.chain(of_cylinder).chain(of_sphere);
        sizes_m.fold(f64::INFINITY, f64::min)
    }

    /// The largest speed of its centre by itself, in m/s: its start velocity plus a fall from its
    /// start height.
    fn fastest_m_s(&self, gravity_m_s2: f64) -> f64 {
        let falls = 2.0 * gravity_m_s2 * self.z_m.unwrap_or(0.0).max(0.0);
        let at_start =
            self.vx_m_s * self.vx_m_s + self.vy_m_s * self.vy_m_s + self.vz_m_s * self.vz_m_s;
        (at_start + falls).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    fn scenario(toml: &str) -> Scenario {
        let text = format!("robot.file = 'r.urdf'\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\n{toml}");
        Scenario::from_toml(&text, "s", ".").expect("a scenario")
    }

    /// A box of 0.2 m at 100 m/s before wheels of 50 mm may move by 0.25 m in a step, which takes
    /// 2.5 ms; one that falls from 20 m reaches sqrt(2 g z), 19.8 m/s. Beside a plate of 4 mm it
    /// may move by 0.204 m.
    #[test]
    fn bodies_move_by_less_than_what_they_meet_in_a_step() {
        let body = |keys: &str| {
            format!(
                "[[world.bodies]]\nname = 'b'\nbox.size_m = [0.2, 0.3, 0.4]\nmass_kg = 2\nx_m = 1\ny_m = 0\n{keys}\n"
            )
        };
        let plate = "[[world.bodies]]\nname = 'p'\nbox.size_m = [1, 1, 0.004]\nmass_kg = 2\nx_m = 5\ny_m = 0\n";
        let fast = body("vx_m_s = -60\nvz_m_s = 80");
        for (toml, longest_s) in [
            (fast.clone(), 0.25 / 100.0),
            (body("z_m = 20"), 0.25 / (2.0 * 9.81 * 20.0_f64).sqrt()),
            (format!("{fast}{plate}"), 0.204 / 100.0),
        ] {
            let scenario = scenario(&toml);
            let (index, found_s) = scenario.longest_step_of_bodies(0.05).expect("one moves");
            assert!(
                index == 0 && (found_s / longest_s - 1.0).abs() < 1e-12,
                "{found_s}"
            );
            assert!(scenario.check_bodies(longest_s, 0.05).is_ok());
            let refused = scenario.check_bodies(1.1 * longest_s, 0.05).unwrap_err();
            assert!(refused.to_string().contains("pass through"), "{refused}");
        }
        assert_eq!(scenario(&body("")).longest_step_of_bodies(0.05), None);
    }

    /// The shipped robot of 11 kg on four wheels of 50 mm: on springs of 1e8 N/m it sinks by less
    /// than a micrometre, on 2e4 N/m by some 3 % of the wheels' radius, on 100 N/m by more than all
    /// of it, and under a payload of 1e6 kg by half of it.
    #[test]
    fn contacts_bear_the_robot_or_it_is_said_what_to_change() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/robots/mecanum4.urdf"
        );
        let robot = Robot::load(path).expect("a shipped robot");
        let check = |stiffness: &str, faults: &str| {
            let toml = format!("world.solver.contact_stiffness_n_m = {stiffness}\n{faults}");
            scenario(&toml).check_contacts(&robot)
        };
        let payload = |mass_kg: &str| format!("[[faults]]\npayload.mass_kg = {mass_kg}\n");
        assert_eq!(check("1e8", "").unwrap(), None);
        assert_eq!(check("1e8", &payload("50")).unwrap(), None);
        let remark = check("2e4", "").unwrap().expect("a remark");
        // A quarter of its weight on each spring.
        let sinks_mm = 1e3 * robot.mass_kg() * 9.81 / 4.0 / 2e4;
        assert!(
            remark.contains(&format!("sink by {sinks_mm:.3} mm"))
                && remark.contains("contact_stiffness"),
            "{remark}"
        );
        assert!(check("100", "").is_err());
        let refused = check("1e8", &payload("1e6")).unwrap_err().to_string();
        assert!(refused.contains("sink"), "{refused}");
        assert!(check("1e8", &payload("1e5")).unwrap().is_some());
    }
}
