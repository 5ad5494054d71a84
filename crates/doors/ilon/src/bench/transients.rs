//! Drives in which wheels slide, with contacts solved by ilon and by rapier, side by side.

use ilon_report::bench::{Slide, Transient};
use ilon_robot::Robot;
use ilon_trace::metrics::Energy;

use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::Simulation;

/// The step of both solvers, in seconds: the longest that rapier's contacts allow.
const STEP_S: f64 = 1e-3;
/// The step of the reference run, in seconds: ilon's contacts, which the second engine confirms
/// (docs/measured.md).
const FINE_STEP_S: f64 = 2.5e-4;
const FRICTION: f64 = 0.3;
/// Duration of the push, in seconds; chosen.
const PUSH_S: f64 = 0.4;
/// The push's force over the friction limit on a level floor; chosen.
const PUSH_OVER_GRIP: f64 = 1.5;
const GRAVITY_M_S2: f64 = 9.81;

/// A run with its path.
struct Course {
    places_m: Vec<[f64; 2]>,
    slide: Slide,
}

/// Simulates a robot that slides at friction 0.3: starts ahead and sideways at 10 m/s^2, and a
/// push.
///
/// # Errors
/// If the robot cannot drive, or one of the solvers does not support a property of it.
pub(super) fn transients(robot: &Robot) -> Result<Vec<Transient>, Error> {
    let grip_n_s = FRICTION * GRAVITY_M_S2 * robot.mass_kg() * PUSH_S;
    let push_n_s = PUSH_OVER_GRIP * grip_n_s;
    let (sin, cos) = libm::sincos(30f64.to_radians());
    let push = format!(
        "[[faults]]\npush = {{ impulse_x_n_s = {}, impulse_y_n_s = {}, from_s = 0.2, lasts_s = {PUSH_S} }}\n",
        push_n_s * cos,
        push_n_s * sin
    );
    let cases = [
        ("start ahead", "vx_m_s = 0.5", ""),
        ("start sideways", "vy_m_s = 0.5", ""),
        (
            "push from behind, 30 degrees to the left",
            "",
            push.as_str(),
        ),
    ];
    let cases = cases.map(|(name, twist, more)| {
        let course = |contacts, step_s| Course::of(robot, twist, more, contacts, step_s);
        let fine = course("ilon", FINE_STEP_S)?;
        Ok(Transient {
            name: name.to_owned(),
            ilon: course("ilon", STEP_S)?.beside(&fine),
            rapier: course("rapier", STEP_S)?.beside(&fine),
            fine: fine.slide,
        })
    });
    cases.into_iter().collect()
}

impl Course {
    fn of(
        robot: &Robot,
        twist: &str,
        more: &str,
        contacts: &str,
        step_s: f64,
    ) -> Result<Self, Error> {
        let text = format!(
            "[robot]\nfile = \"\"\n[twist]\n{twist}\nrest_s = 0.2\nramp_s = 0.05\nsettle_s = 0.1\n{more}[world.floor]\nfriction = {FRICTION}\n\
             [world.solver]\ncontacts = \"{contacts}\"\n[run]\nduration_s = 1.2\nphysics_dt_s = {step_s}\ncontrol_dt_s = 0.01\n"
        );
        let scenario = Scenario::from_toml(&text, "bench", "")?;
        let run = Simulation::with_robot(&scenario, robot)?.run();
        let places_m: Vec<[f64; 2]> = run
            .trace
            .records()
            .iter()
            .map(|row| [row.truth.pose.x_m, row.truth.pose.y_m])
            .collect();
        let Energy {
            slip_j,
            spin_up_j,
            unexplained_share,
            ..
        } = run.summary.energy;
        let number = |figure: Option<f64>| figure.unwrap_or(f64::NAN);
        let end_m = match (places_m.first(), places_m.last()) {
            (Some(first), Some(last)) => [last[0] - first[0], last[1] - first[1]],
            _ => [f64::NAN; 2],
        };
        Ok(Self {
            places_m,
            slide: Slide {
                end_m,
                apart_m: 0.0,
                heat_j: number(slip_j) + number(spin_up_j),
                slip_speed_max_m_s: number(run.summary.slip_speed_max_m_s),
                unexplained_share: number(unexplained_share),
            },
        })
    }

    /// Compares the run with another one of the same robot.
    fn beside(self, other: &Self) -> Slide {
        let places = self.places_m.iter().zip(&other.places_m);
        let apart = places.map(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]));
        Slide {
            apart_m: apart.fold(0.0, f64::max),
            ..self.slide
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Options;

    #[test]
    fn both_solvers_slide_and_account_for_their_energy() {
        let robot = Options::built_in("volksbot").unwrap();
        let transients = transients(&robot).unwrap();
        assert_eq!(transients.len(), 3);
        for transient in &transients {
            assert_eq!(transient.fine.apart_m, 0.0);
            for (solver, slide) in transient.rows() {
                let share = slide.unexplained_share.abs();
                assert!(share < 0.01, "{}, {solver}: {share}", transient.name);
                // Faster than any creep: at mu g the robot takes 0.17 s to 0.5 m/s, while the
                // wheels' targets take 0.05 s.
                assert!(slide.slip_speed_max_m_s > 0.1, "{}", transient.name);
                assert!(slide.heat_j > 0.0, "{}", transient.name);
            }
            // Both solvers simulate one robot: the ends differ by less than a tenth of the path.
            let [x, y] = transient.fine.end_m;
            let way_m = libm::hypot(x, y);
            let apart_m = transient.rapier.apart_m.max(transient.ilon.apart_m);
            assert!(apart_m < 0.1 * way_m, "{}: {apart_m}", transient.name);
        }
        // Each drive goes in its direction: 0.5 m/s for a second, less the delay by sliding.
        let [ahead, sideways, _] = &transients[..] else {
            panic!("three of them")
        };
        assert!(ahead.fine.end_m[0] > 0.3 && sideways.fine.end_m[1] > 0.3);
    }
}
