//! How a velocity follows from the rates of the bodies that it is between.

use rapier3d::math::Real;

/// How one velocity follows from the rates of the bodies that it is between, and what a unit impulse there does to them: of a
/// contact how fast body A moves against body B, of a joint how fast parts of body A turn against each other.
///
/// It is sparse: it holds only what stands for the one or two bodies that move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub a: Side,
    /// `None` where B is the ground, which never moves, and of joints within A.
    pub b: Option<Side>,
}

/// What stands in a row for one articulated body: its chassis, one of its wheels, and one of its rollers about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Its place among the articulated bodies.
    pub body: usize,
    pub chassis: [f64; 6],
    /// Degree of freedom and share.
    pub hub: Option<(usize, f64)>,
    /// Place among the axles and share.
    pub axle: Option<(usize, f64)>,
    /// Share of the velocity with which that roller slides along its axle.
    pub slide: f64,
}

impl Row {
    /// Of what acts on A alone.
    pub fn of_one(a: Side) -> Self {
        Self { a, b: None }
    }

    /// The one or two bodies that move.
    #[inline]
    pub fn sides(&self) -> impl Iterator<Item = &Side> {
        std::iter::once(&self.a).chain(&self.b)
    }
}

impl Side {
    /// The part of the velocity that chassis and wheel make, with these rates by degree of freedom of the body.
    pub fn of_bodies(&self, rates: &[f64]) -> f64 {
        self.sum(|dof| rates[dof])
    }

    /// The same of rates as rapier has them.
    #[inline]
    pub fn of_bodies_f32(&self, rates: &[Real]) -> f64 {
        let (chassis, c) = (&rates[..6], &self.chassis);
        let mut sum = c[0] * f64::from(chassis[0]);
        for (c, rate) in c[1..].iter().zip(&chassis[1..]) {
            sum += c * f64::from(*rate);
        }
        sum + self.hub.map_or(0.0, |(dof, c)| c * f64::from(rates[dof]))
    }

    #[inline]
    fn sum(&self, rate: impl Fn(usize) -> f64) -> f64 {
        let chassis = self.chassis.iter().enumerate().map(|(i, c)| c * rate(i));
        chassis.sum::<f64>() + self.hub.map_or(0.0, |(dof, c)| c * rate(dof))
    }

    /// The same body, moving the other way.
    pub fn reversed(&self) -> Self {
        let back = |(place, c): (usize, f64)| (place, -c);
        Self {
            body: self.body,
            chassis: self.chassis.map(|c| -c),
            hub: self.hub.map(back),
            axle: self.axle.map(back),
            slide: -self.slide,
        }
    }
}
