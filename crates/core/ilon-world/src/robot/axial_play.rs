//! A roller along its axle, between two stops.
//!
//! A roller with play has one number more than its rate about its axis: its place q on its axle, within half of the play to either
//! side of the middle.
//!
//! **On the ground** its rate q' is a degree of freedom of the contact problem, with the roller's mass m. The ground holds the roller,
//! and the hub slides along the axle, until a stop that is reached within the step holds on
//! ([`Law::Slide`](crate::contact::law::Law)). What the ground puts on the roller along its axle, of the friction and of the load where
//! the axle leans, only stops hand on to the hub: a roller that spins uses up its bearing's friction across the axle, and what little acts
//! along it is left out. The hub carries the roller's mass along the axle too,
//! as it does where there is no play: while the axle slides under a roller, robot and wheel are heavier along it by up to 2 m.
//!
//! **What it comes to.** A roller comes down at the lower end of its axle, which is the rear one. A wheel that pulls with more than N tan(beta) along the
//! axle, sin(beta) = cos(gamma) sin(phi), pushes each roller in turn through its play p before it pulls: of the way is lost n p / (2 pi rho cos(gamma)).
//! One that pulls less is moved by its load, ahead of the middle back and behind it forward again. Held wheels have a backlash of p / cos(gamma).
//!
//! **In the air** it slides under its weight along the leaning axle, and stops at a stop. What
//! the robot's acceleration adds moves it sooner or later, and not to another end before it comes down; the circular motion
//! adds nothing at the middle of the axle, which is square to the radius there, and omega^2 q elsewhere. The hub feels nothing of it: per turn
//! of the wheel that leaves out less than 2 m g p a roller.

/// Where a roller is on its axle, and how it slides.
#[derive(Clone, Debug)]
pub(crate) struct Slide {
    /// Half of the play, in metres.
    half_m: f64,
    /// The roller's mass, in kg.
    mass_kg: f64,
    /// Place along the axis from the middle of the play, in metres: within a step that in its middle, as its rate takes it there.
    pub place_m: f64,
    /// The same when the last step began.
    began_m: f64,
    /// Its rate, in m/s.
    rate_m_s: f64,
    /// Whether the ground pressed on the roller in the last step: only then its kinetic energy counts.
    on_ground: bool,
    /// Its rate after the step, as the contact problem found it.
    solved_m_s: Option<f64>,
}

/// How a roller that may touch something slides along its axle; all 0 of one without play.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxleSlide {
    /// Its rate when the step began, in m/s.
    pub before_m_s: f64,
    /// Its rate at the end of the step without any reaction, and then with them, in m/s.
    pub rate_m_s: f64,
    /// What an impulse of 1 N s along the axle does to it, in 1/kg.
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

    /// How it begins to slide in the contact problem of a step.
    pub fn on_ground(&self) -> AxleSlide {
        AxleSlide {
            before_m_s: self.rate_on_ground_m_s(),
            rate_m_s: self.rate_on_ground_m_s(),
            response_1_kg: 1.0 / self.mass_kg,
        }
    }

    /// Its rate when the step began, for the contact problem, in m/s. The ground stops a roller that comes down on it.
    fn rate_on_ground_m_s(&self) -> f64 {
        if self.on_ground { self.rate_m_s } else { 0.0 }
    }

    /// Begins a step: goes to where it is in the step's middle.
    pub fn begin_step(&mut self, dt_s: f64) {
        self.began_m = self.place_m;
        self.place_m = self.after_m(self.rate_on_ground_m_s(), 0.5 * dt_s);
    }

    /// Goes back to where it was when the last step began, to take the step anew.
    pub fn begin_again(&mut self) {
        self.place_m = self.began_m;
    }

    /// The rates that take it to either stop within a step, in m/s: one not above 0, one not below.
    pub fn to_stops_m_s(&self, dt_s: f64) -> [f64; 2] {
        [-self.half_m, self.half_m].map(|stop_m| (stop_m - self.began_m) / dt_s)
    }

    /// Takes over its rate from the contact problem, in m/s.
    pub fn solved(&mut self, rate_m_s: f64) {
        self.solved_m_s = Some(rate_m_s);
    }

    /// Stands still on its axle.
    pub fn seize(&mut self) {
        (self.rate_m_s, self.on_ground, self.solved_m_s) = (0.0, false, None);
    }

    /// Kinetic energy that is its own, in J.
    pub fn kinetic_j(&self) -> f64 {
        0.5 * self.mass_kg * self.rate_on_ground_m_s().powi(2)
    }

    /// Ends a step, with gravity along the axis in m/s^2: moves the roller. Gives what is lost as it leaves the ground, in J.
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

    /// Where a rate takes it from where the step began, in metres.
    fn after_m(&self, rate_m_s: f64, dt_s: f64) -> f64 {
        (self.began_m + rate_m_s * dt_s).clamp(-self.half_m, self.half_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On an axle that leans by 30 degrees: t = sqrt(2 p / (g sin)).
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
        // Of first order in the step.
        assert!((f64::from(steps) * DT_S - expected_s).abs() < 2.0 * DT_S);
        assert_eq!((slide.place_m, slide.rate_m_s), (2e-4, 0.0));
    }

    /// A roller that seizes while it slides along its axle stands still, and has nothing left.
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
        // And with it the way on.
        assert_eq!((slide.place_m, slide.rate_m_s), (3e-5, 0.0));
    }
}
