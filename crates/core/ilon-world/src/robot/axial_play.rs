//! A roller with axial play: it slides along its axle between two stops.
//!
//! A roller with play has one more coordinate besides its rate about its axis: its position q on
//! its axle, within half of the play to either side of the middle.
//!
//! **On the ground** its rate q' is a degree of freedom of the contact problem, with the roller's
//! mass m. The ground holds the roller, and the hub slides along the axle until a stop that is
//! reached within the step holds it ([`Law::Slide`](crate::contact::law::Law)). The ground's force
//! on the roller along its axle, by friction and by the load on a tilted axle, is passed to the hub
//! only by stops: a spinning roller uses up its bearing's friction across the axle, and the small
//! part along it is left out. The hub carries the roller's mass along the axle too, as without
//! play: while the axle slides under a roller, robot and wheel are heavier along it by up to 2 m.
//!
//! **The effect.** A roller comes down at the lower end of its axle, which is the rear one. A wheel
//! that pulls with more than N tan(beta) along the axle, sin(beta) = cos(gamma) sin(phi), pushes
//! each roller in turn through its play p before it pulls: this loses n p / (2 pi rho cos(gamma))
//! of the way. A roller of a wheel that pulls less is moved by its load, before the middle
//! backwards and after it forwards again. Held wheels have a backlash of p / cos(gamma).
//!
//! **In the air** it slides under its weight along the tilted axle until it reaches a stop. The
//! robot's acceleration moves it earlier or later, but not to the other end before it comes down;
//! the circular motion adds nothing at the middle of the axle, which is perpendicular to the radius
//! there, and omega^2 q elsewhere. The hub feels none of this: per turn of the wheel that leaves
//! out less than 2 m g p per roller.

/// The position and velocity of a roller on its axle.
#[derive(Clone, Debug)]
pub(crate) struct Slide {
    /// Half of the play, in metres.
    half_m: f64,
    /// The roller's mass, in kg.
    mass_kg: f64,
    /// Position along the axis from the middle of the play, in metres: within a step that in its
    /// middle, by its rate.
    pub place_m: f64,
    /// The same at the beginning of the last step.
    began_m: f64,
    /// Its rate, in m/s.
    rate_m_s: f64,
    /// Whether the ground pressed on the roller in the last step: only then its kinetic energy
    /// counts.
    on_ground: bool,
    /// Its rate after the step, from the contact problem.
    solved_m_s: Option<f64>,
}

/// The axial motion of a roller that may touch something; all 0 without play.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxleSlide {
    /// Its rate at the beginning of the step, in m/s.
    pub before_m_s: f64,
    /// Its rate at the end of the step without any reaction, and then with them, in m/s.
    pub rate_m_s: f64,
    /// Its velocity change per impulse of 1 N s along the axle, in 1/kg.
    pub response_1_kg: f64,
}

impl Slide {
    /// A roller of a mass in kg at rest in the middle of its play, which is given in metres.
    pub fn in_the_middle(play_m: f64, mass_kg: f64) -> Self {
        Self {
            half_m: 0.5 * play_m,
            mass_kg,
            place_m: 0.0,
            began_m: 0.0,
            rate_m_s: 0.0,
            on_ground: false,
            solved_m_s: None,
        }
    }

    /// Its axial motion at the beginning of a step, for the contact problem.
    pub fn on_ground(&self) -> AxleSlide {
        AxleSlide {
            before_m_s: self.rate_on_ground_m_s(),
            rate_m_s: self.rate_on_ground_m_s(),
            response_1_kg: 1.0 / self.mass_kg,
        }
    }

    /// Its rate at the beginning of the step, for the contact problem, in m/s. The ground stops a
    /// roller that comes down on it.
    fn rate_on_ground_m_s(&self) -> f64 {
        if self.on_ground { self.rate_m_s } else { 0.0 }
    }

    /// Begins a step: advances to the step's middle.
    pub fn begin_step(&mut self, dt_s: f64) {
        self.began_m = self.place_m;
        self.place_m = self.after_m(self.rate_on_ground_m_s(), 0.5 * dt_s);
    }

    /// Returns to the beginning of the last step, to repeat it.
    pub fn begin_again(&mut self) {
        self.place_m = self.began_m;
    }

    /// The rates that take it to either stop within a step, in m/s: the first not above 0, the
    /// second not below.
    pub fn to_stops_m_s(&self, dt_s: f64) -> [f64; 2] {
        [-self.half_m, self.half_m].map(|stop_m| (stop_m - self.began_m) / dt_s)
    }

    /// Takes over its rate from the contact problem, in m/s.
    pub fn solved(&mut self, rate_m_s: f64) {
        self.solved_m_s = Some(rate_m_s);
    }

    /// Stops on its axle.
    pub fn seize(&mut self) {
        (self.rate_m_s, self.on_ground, self.solved_m_s) = (0.0, false, None);
    }

    /// Its own kinetic energy, in J.
    pub fn kinetic_j(&self) -> f64 {
        0.5 * self.mass_kg * self.rate_on_ground_m_s().powi(2)
    }

    /// Ends a step, with gravity along the axis in m/s^2: moves the roller. Returns the energy lost
    /// as it leaves the ground, in J.
    pub fn end_step(&mut self, pressed: bool, gravity: f64, dt_s: f64) -> f64 {
        let before_j = self.kinetic_j();
        let solved_m_s = self.solved_m_s.take();
        if pressed {
            self.rate_m_s = solved_m_s.unwrap_or(0.0);
            self.on_ground = true;
            self.place_m = self.after_m(self.rate_m_s, dt_s);
            return 0.0;
        }
        let lost_j = match solved_m_s {
            // Stops and friction have taken their part of it.
            Some(rate_m_s) if self.on_ground => 0.5 * self.mass_kg * rate_m_s * rate_m_s,
            _ => before_j,
        };
        if self.on_ground {
            self.rate_m_s = 0.0;
        }
        self.on_ground = false;
        self.rate_m_s += gravity * dt_s;
        self.place_m = self.after_m(self.rate_m_s, dt_s);
        if self.place_m.abs() >= self.half_m {
            self.rate_m_s = 0.0;
        }
        lost_j
    }

    /// Its position after a time from the beginning of the step at a rate, in metres.
    fn after_m(&self, rate_m_s: f64, dt_s: f64) -> f64 {
        (self.began_m + rate_m_s * dt_s).clamp(-self.half_m, self.half_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On an axle tilted by 30 degrees: t = sqrt(2 p / (g sin)).
    #[test]
    fn in_the_air_a_roller_slides_to_its_lower_end_as_on_an_inclined_plane() {
        const DT_S: f64 = 1e-5;
        let gravity = 9.81 * 0.5;
        let mut slide = Slide::in_the_middle(4e-4, 0.01);
        let mut steps = 0;
        while slide.place_m < 2e-4 {
            slide.begin_step(DT_S);
            assert_eq!(slide.end_step(false, gravity, DT_S), 0.0);
            steps += 1;
        }
        let expected_s = (2.0 * 2e-4 / gravity).sqrt();
        // First order in the step.
        assert!((f64::from(steps) * DT_S - expected_s).abs() < 2.0 * DT_S);
        assert_eq!((slide.place_m, slide.rate_m_s), (2e-4, 0.0));
    }

    /// Within a step it is taken to stand in the step's middle, but the stops are reached from
    /// where it began: 0.5 mm to either side of the axle's middle, from 0.125 mm, in 1 ms.
    #[test]
    fn stops_are_reached_from_where_a_step_began() {
        let mut slide = Slide::in_the_middle(1e-3, 0.02);
        slide.begin_step(1e-3);
        slide.solved(0.125);
        slide.end_step(true, 0.0, 1e-3);
        slide.begin_step(1e-3);
        let [back, ahead] = slide.to_stops_m_s(1e-3);
        assert!((back + 0.625).abs() < 1e-12 && (ahead - 0.375).abs() < 1e-12);
        assert!((slide.place_m - 1.875e-4).abs() < 1e-15);
    }

    /// A roller that seizes while it slides along its axle stops, and keeps no velocity.
    #[test]
    fn a_roller_that_seizes_slides_no_further() {
        let mut slide = Slide::in_the_middle(1e-3, 0.02);
        slide.begin_step(1e-3);
        slide.solved(0.03);
        slide.end_step(true, 0.0, 1e-3);
        slide.solved(0.03);
        slide.seize();
        assert_eq!((slide.place_m, slide.kinetic_j()), (3e-5, 0.0));
        slide.begin_step(1e-3);
        slide.end_step(false, 0.0, 1e-3);
        assert_eq!((slide.place_m, slide.rate_m_s), (3e-5, 0.0));
    }

    #[test]
    fn what_a_roller_has_when_it_leaves_the_ground_is_lost() {
        let mut slide = Slide::in_the_middle(1e-3, 0.02);
        slide.begin_step(1e-3);
        assert_eq!(slide.to_stops_m_s(1e-3), [-0.5, 0.5]);
        slide.solved(0.03);
        assert_eq!(slide.end_step(true, 0.0, 1e-3), 0.0);
        assert_eq!(
            (slide.place_m, slide.kinetic_j()),
            (3e-5, 0.5 * 0.02 * 0.03_f64.powi(2))
        );
        slide.begin_step(1e-3);
        assert_eq!(slide.place_m, 4.5e-5);
        let lost_j = slide.end_step(false, 0.0, 1e-3);
        assert_eq!(
            (lost_j, slide.kinetic_j()),
            (0.5 * 0.02 * 0.03_f64.powi(2), 0.0)
        );
        // And with it the displacement.
        assert_eq!((slide.place_m, slide.rate_m_s), (3e-5, 0.0));
    }
}
