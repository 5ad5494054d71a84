//! How the bodies answer to impulses, as they are held in the step.

use rapier3d::math::Real;

use crate::contact::potential::Axle;
use crate::contact::row::{Row, Side};

/// What the unit impulse of each row does to the rates of the bodies that it acts on, and that of each wheel to its body.
///
/// What a row does is kept for its one or two bodies alone. Motors and bearings hold the bodies as they do in the step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Responses {
    bodies: Vec<OfBody>,
    /// Of each row the bodies that it acts on, each with the place among that body's answers.
    rows: Vec<[Option<(usize, usize)>; 2]>,
    /// Of all bodies, one after the other.
    wheels: Vec<Wheel>,
}

/// A wheel of an articulated body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wheel {
    /// Its body's place among the articulated bodies.
    pub body: usize,
    /// Its place among that body's wheels.
    pub index: usize,
    /// Its place among that body's degrees of freedom.
    pub dof: usize,
}

/// How one body answers.
#[derive(Clone, Debug, Default)]
struct OfBody {
    /// Its degrees of freedom, and how many those before it have.
    dofs: usize,
    start: usize,
    /// To the rows that act on it, one after the other.
    rows: Vec<Real>,
    /// To its wheels.
    wheels: Vec<Real>,
}

impl Responses {
    /// Begins anew for bodies of so many degrees of freedom.
    pub fn clear(&mut self, dofs: impl Iterator<Item = usize>) {
        self.rows.clear();
        self.wheels.clear();
        let (mut count, mut start) = (0, 0);
        for dofs in dofs {
            if count == self.bodies.len() {
                self.bodies.push(OfBody::default());
            }
            let body = &mut self.bodies[count];
            (body.dofs, body.start) = (dofs, start);
            body.rows.clear();
            body.wheels.clear();
            start += dofs;
            count += 1;
        }
        self.bodies.truncate(count);
    }

    /// How many bodies there are.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// Degrees of freedom of all bodies.
    pub fn dofs(&self) -> usize {
        self.bodies.last().map_or(0, |last| last.start + last.dofs)
    }

    /// Where a body's degrees of freedom stand among all.
    pub fn dofs_of(&self, body: usize) -> std::ops::Range<usize> {
        let of = &self.bodies[body];
        of.start..of.start + of.dofs
    }

    /// Finds the answers to all rows. `answer` takes a body and impulses on it, one of its degrees of freedom after the other,
    /// to the rates that they give.
    pub fn find(&mut self, rows: &[Row], mut answer: impl FnMut(usize, &mut [Real])) {
        for row in rows {
            let mut places = [None; 2];
            for (place, side) in places.iter_mut().zip(row.sides()) {
                let body = &mut self.bodies[side.body];
                let at = body.rows.len();
                *place = Some((side.body, at));
                body.rows.resize(at + body.dofs, 0.0);
                let impulse = &mut body.rows[at..];
                for (dof, c) in side.chassis.iter().enumerate() {
                    impulse[dof] = *c as Real;
                }
                if let Some((dof, c)) = side.hub {
                    impulse[dof] = c as Real;
                }
            }
            self.rows.push(places);
        }
        for (index, body) in self.bodies.iter_mut().enumerate() {
            answer(index, &mut body.rows);
        }
    }

    /// Finds the answers to all wheels as well; `dofs` are those of a body's wheels.
    pub fn find_of_wheels(
        &mut self,
        body: usize,
        dofs: impl Iterator<Item = usize>,
        answer: impl FnOnce(usize, &mut [Real]),
    ) {
        let of = &mut self.bodies[body];
        for (index, dof) in dofs.enumerate() {
            self.wheels.push(Wheel { body, index, dof });
            let at = of.wheels.len();
            of.wheels.resize(at + of.dofs, 0.0);
            of.wheels[at + dof] = 1.0;
        }
        answer(body, &mut of.wheels);
    }

    /// The wheels of all bodies.
    pub fn wheels(&self) -> &[Wheel] {
        &self.wheels
    }

    /// What the unit impulse of a row does to the rates of a body; `None` where it does not act on it.
    #[inline]
    pub fn of_row(&self, row: usize, body: usize) -> Option<&[Real]> {
        let at = match self.rows[row] {
            [Some((of, at)), _] if of == body => at,
            [_, Some((of, at))] if of == body => at,
            _ => return None,
        };
        let of = &self.bodies[body];
        Some(&of.rows[at..][..of.dofs])
    }

    /// The bodies that a row acts on, each with what its unit impulse does to that body's rates.
    pub fn each_of_row(&self, row: usize) -> impl Iterator<Item = (usize, &[Real])> {
        let places = self.rows[row].iter().flatten();
        places.map(|(body, at)| {
            (
                *body,
                &self.bodies[*body].rows[*at..][..self.bodies[*body].dofs],
            )
        })
    }

    /// What the unit impulse of a row does to a wheel's rate.
    pub fn at_wheel(&self, row: usize, wheel: usize) -> f64 {
        let Wheel { body, dof, .. } = self.wheels[wheel];
        self.of_row(row, body)
            .map_or(0.0, |rates| f64::from(rates[dof]))
    }

    /// What the unit impulse on a wheel does to a degree of freedom of a body.
    pub fn of_wheel(&self, wheel: usize, (body, dof): (usize, usize)) -> f64 {
        let wheel = &self.wheels[wheel];
        if wheel.body != body {
            return 0.0;
        }
        let of = &self.bodies[body];
        f64::from(of.wheels[wheel.index * of.dofs + dof])
    }

    /// W of a row and those up to it: what the unit impulse of each does to the velocity of this one.
    pub fn fill_w(&self, rows: &[Row], axles: &[Axle], at: usize, w: &mut [f64]) {
        let row = &rows[at];
        w.fill(0.0);
        for side in row.sides() {
            for (by, w) in w.iter_mut().enumerate() {
                if let Some(rates) = self.of_row(by, side.body) {
                    *w += side.of_bodies_f32(rates);
                }
            }
        }
        let responses = |axle: usize| axles[axle].responses();
        for (other, w) in rows.iter().zip(w) {
            *w += of_axles((row, other), responses);
        }
    }
}

/// What rollers about and along their axes add to W of two rows, given how each answers about its axis and along it.
#[inline]
pub(crate) fn of_axles((at, by): (&Row, &Row), responses: impl Fn(usize) -> [f64; 2]) -> f64 {
    let of_one = |at: &Side, by: &Side| match (at.axle, by.axle) {
        (Some((i, a)), Some((j, b))) if i == j => {
            let [about, along] = responses(i);
            a * b * about + at.slide * by.slide * along
        }
        _ => 0.0,
    };
    if at.b.is_none() && by.b.is_none() {
        return of_one(&at.a, &by.a);
    }
    let mut sum = 0.0;
    for at in at.sides() {
        for by in by.sides() {
            sum += of_one(at, by);
        }
    }
    sum
}
