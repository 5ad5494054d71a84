//! The kinematics at the rollers that really touch the ground.
//!
//! Eq. (5) assumes that the touching roller lies flat, straight below the hub. A real wheel has few
//! rollers. As it turns, the touching roller is at an angle phi from straight down. Its axis is
//! then tilted out of the ground plane, and its contact moves along the hub axis. Both change the
//! constraint that the wheel puts on the robot.
//!
//! **The constraint.** Take the point p of the touching roller that meets the ground. As a point of
//! the wheel with the roller fixed it moves with v + omega k x p + q' n x (p - p_hub). The roller's
//! spin adds a velocity across its axis d: p is the support point t* d - s(t*) k from the roller's
//! middle, so the spin adds spin d x (-s k), which is horizontal and perpendicular to d's
//! projection on the ground, d_g. Hence rolling without slip requires along d_g
//!
//!   d_g . (v + omega k x p + q' n x (p - p_hub)) = 0,
//!
//! and across d_g it only sets the roller's spin. With d_g = n_gamma and p straight below the hub
//! this is eq. (5). d_g has length one here, so that the residual of the least squares over the
//! wheels is a sliding velocity in m/s.
//!
//! **Consequences** for n rollers that hand over at pi/n. A roller axis at angle delta from the hub
//! axis, turned by phi, has components cos(delta) along n and sin(delta) cos(phi) along the ground
//! across n: tan(delta_eff) = tan(delta) cos(phi). Driving sideways at gamma = 45 deg, the robot
//! moves cos(phi) of the distance by (9): sin(pi/n)/(pi/n) in the mean (n = 9: 0.9798). Straight
//! ahead, and for gamma = 0, it changes nothing.

use ilon_robot::{Barrel, Profile, Robot, RollerForm, Twist};
use nalgebra::{Isometry3, Matrix3, MatrixXx3, Point3, RowVector3, Unit, Vector2, Vector3};

use crate::error::finite;
use crate::kinematics::matrix::multiply;
use crate::kinematics::tyres::held_rows;
use crate::{ControlError, Kinematics};

/// Where a wheel touches the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollerContact {
    /// Index of the touching roller in its wheel's list.
    pub roller: usize,
    /// Angle phi at which it stands from straight down, about the hub axis, in radians.
    pub angle_rad: f64,
    /// The contact point in the body frame, in metres.
    pub point_in_body_m: Vector3<f64>,
    /// The roller's axis in the body frame, in the sense of its joint.
    pub axis_in_body: Unit<Vector3<f64>>,
    /// Distance from the roller's axis to the contact point, straight up, in metres: s(t*) of the
    /// barrel; ring / |d_g| + ball for a roller with the shapes of its file (see [`Profile`]).
    pub radius_m: f64,
}

/// The map between wheel rates and the twist of the body frame's origin, at given wheel angles, on
/// flat ground.
///
/// From wheel angles and rates it computes the twist without slip, for odometry; from a twist it
/// computes wheel rates, for a feedforward that cancels the rollers' ripple.
#[derive(Clone, Debug)]
pub struct ContactKinematics {
    wheels: Vec<WheelContacts>,
    /// Reference point in the body frame, in metres.
    reference_point_m: Vector2<f64>,
    /// Distance by which the yaw column is scaled in the least squares, in metres.
    length_m: f64,
    contacts: Vec<RollerContact>,
    /// Row h is d_g . (v + omega k x p) as a function of (v, omega), its sign such that the lever
    /// is positive.
    rows: MatrixXx3<f64>,
    /// -d_g . (n x (p - p_hub)): the row's value per rad/s of wheel rate, in metres.
    lever_m: Vec<f64>,
    /// Row over lever: rad/s per twist.
    rate_matrix: MatrixXx3<f64>,
    /// Those without the touching rollers, at the same places.
    ideal: Kinematics,
    /// Twists that tyres allow give zero in each of these rows (see `kinematics/tyres.rs`).
    held: Vec<RowVector3<f64>>,
}

/// The geometry of a wheel that determines its contact.
#[derive(Clone, Debug)]
struct WheelContacts {
    body_from_hub: Isometry3<f64>,
    /// Straight down in the hub frame at wheel angle zero.
    down_in_hub: Vector3<f64>,
    radius_m: f64,
    rollers: Vec<RollerGeometry>,
    has_tyre: bool,
}

/// A roller in its hub's frame.
#[derive(Clone, Debug)]
struct RollerGeometry {
    center_in_hub_m: Vector3<f64>,
    /// The direction to the roller's centre from the hub axis: its product with "down" says how
    /// close to straight down it is.
    outward: Vector3<f64>,
    axis_in_hub: Unit<Vector3<f64>>,
    outline: RollerOutline,
    /// Largest distance of any part of the roller from its middle along its axis, in metres.
    half_length_m: f64,
    /// Largest radius, in metres.
    radius_m: f64,
}

/// The outline of a roller about its axis.
#[derive(Clone, Debug)]
enum RollerOutline {
    /// The exact barrel.
    Barrel(Barrel),
    /// The shape modelled in its file, or a profile given by numbers.
    Modelled(Profile),
}

impl RollerOutline {
    /// Returns the largest distance of its parts from its middle along its axis, and the largest
    /// radius, in metres.
    fn extent_m(&self) -> (f64, f64) {
        match self {
            Self::Barrel(barrel) => (barrel.half_length_m, barrel.sphere_radius_m(0.0)),
            Self::Modelled(profile) => profile
                .parts()
                .iter()
                .map(|part| (part.t_m.abs(), part.ring_m + part.ball_m))
                .fold((0.0, 0.0), |(t, r), (part_t, part_r)| {
                    (part_t.max(t), part_r.max(r))
                }),
        }
    }

    /// Returns the support point in a unit direction `w`, from the roller's centre, and its
    /// distance from the roller's axis `axis`, measured against `w`, in metres.
    fn support_m(&self, axis: &Vector3<f64>, w: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let w_axial = axis.dot(w);
        match self {
            Self::Barrel(barrel) => {
                let t_m = barrel.support_place_m(w_axial);
                let radius_m = barrel.sphere_radius_m(t_m);
                (t_m * axis + radius_m * w, radius_m)
            }
            Self::Modelled(profile) => {
                let (part, _) = profile.furthest(w_axial);
                // The point lies in the plane of axis and w, ring + ball |w_across| off the axis,
                // and against w the axis approaches by |w_across| per metre. Rollers with upright
                // axes never touch.
                let across = w - w_axial * axis;
                let length = across.norm().max(f64::EPSILON);
                let point_m = part.t_m * axis + part.ring_m / length * across + part.ball_m * w;
                (point_m, part.ring_m / length + part.ball_m)
            }
        }
    }
}

impl ContactKinematics {
    /// The contact kinematics of a robot, about its body frame's origin, at wheel angles zero.
    ///
    /// # Errors
    /// The conditions of Lemma 1 as in [`Kinematics::new`]; [`ControlError::NoRollers`].
    pub fn new(robot: &Robot) -> Result<Self, ControlError> {
        let ideal = Kinematics::new(robot)?;
        let count = ideal.wheel_count();
        let mut wheels = Vec::with_capacity(count);
        for w in &robot.wheels {
            if w.rollers.is_empty() {
                return Err(ControlError::NoRollers {
                    wheel: w.name.clone(),
                });
            }
            let geometry = |r: &ilon_robot::Roller| {
                let outline = match &r.form {
                    RollerForm::Barrel | RollerForm::Made(_) => RollerOutline::Barrel(w.barrel(r)),
                    RollerForm::Turned(turned) | RollerForm::Tyre(turned) => {
                        RollerOutline::Modelled(turned.profile().clone())
                    }
                    RollerForm::AsModelled(modelled) => {
                        RollerOutline::Modelled(modelled.profile.clone())
                    }
                };
                let (half_length_m, radius_m) = outline.extent_m();
                RollerGeometry {
                    center_in_hub_m: r.center_in_hub_m,
                    outward: r.center_in_hub_m / r.center_in_hub_m.xy().norm(),
                    axis_in_hub: r.axis_in_hub,
                    outline,
                    half_length_m,
                    radius_m,
                }
            };
            wheels.push(WheelContacts {
                body_from_hub: w.body_from_hub,
                down_in_hub: w.body_from_hub.rotation.inverse() * -Vector3::z(),
                radius_m: w.radius_m,
                rollers: w.rollers.iter().map(geometry).collect(),
                has_tyre: w.has_tyre(),
            });
        }
        let mut kinematics = Self {
            wheels,
            reference_point_m: Vector2::zeros(),
            length_m: 0.0,
            contacts: Vec::with_capacity(count),
            rows: MatrixXx3::zeros(count),
            lever_m: vec![0.0; count],
            rate_matrix: MatrixXx3::zeros(count),
            ideal: ideal.clone(),
            held: Vec::new(),
        };
        kinematics.stand(&ideal);
        Ok(kinematics)
    }

    /// Continues with the wheels at the places of other kinematics of the same robot, at wheel
    /// angles zero. The reference point stays.
    pub fn stand(&mut self, ideal: &Kinematics) {
        self.ideal.clone_from(ideal);
        self.length_m = 0.0;
        self.contacts.clear();
        for (wheel, to) in self.wheels.iter_mut().zip(ideal.wheels()) {
            wheel.body_from_hub = to.body_from_hub;
            wheel.down_in_hub = to.body_from_hub.rotation.inverse() * -Vector3::z();
            self.length_m = self.length_m.max(to.position_m().xy().norm());
            self.contacts.push(wheel.touching(0.0));
        }
        self.held = held_rows(ideal.mounted(), self.reference_point_m);
        self.refresh_rows();
    }

    /// Returns the kinematics about another reference point, given in the body frame in metres:
    /// twists then hold the velocity of that point (like [`Kinematics::about`]).
    ///
    /// # Errors
    /// [`ControlError::NotFinite`] for a point that is not finite.
    pub fn about(&self, point_m: Vector2<f64>) -> Result<Self, ControlError> {
        let mut kinematics = self.clone();
        kinematics.reference_point_m = Vector2::new(
            finite("x of the reference point", point_m.x)?,
            finite("y of the reference point", point_m.y)?,
        );
        kinematics.held = held_rows(self.ideal.mounted(), kinematics.reference_point_m);
        kinematics.refresh_rows();
        Ok(kinematics)
    }

    /// Finds the touching rollers at wheel angles in radians, one per wheel.
    pub fn update(&mut self, wheel_angles_rad: &[f64]) {
        if self.wheels.iter().all(|wheel| wheel.has_tyre) {
            // A tyre touches in one and the same place.
            return;
        }
        for ((contact, wheel), angle_rad) in self
            .contacts
            .iter_mut()
            .zip(&self.wheels)
            .zip(wheel_angles_rad)
        {
            *contact = wheel.touching(*angle_rad);
        }
        self.refresh_rows();
    }

    /// Returns the twist without slip, in the body frame, for wheel angles in radians and rates in
    /// rad/s: least squares of the wheels' constraints. On a robot this is its odometry.
    pub fn twist(&mut self, wheel_angles_rad: &[f64], rates_rad_s: &[f64]) -> Twist {
        self.update(wheel_angles_rad);
        self.twist_here(rates_rad_s)
    }

    /// Computes the wheel rates in rad/s that move the body with this twist at these wheel angles
    /// without slip: a feedforward that cancels the rollers' ripple.
    pub fn wheel_rates(&mut self, wheel_angles_rad: &[f64], twist_in_body: Twist, out: &mut [f64]) {
        self.update(wheel_angles_rad);
        self.wheel_rates_here(twist_in_body, out);
    }

    /// [`Self::twist`] at the wheel angles of the last update.
    pub fn twist_here(&self, rates_rad_s: &[f64]) -> Twist {
        // Normal equations A^T A x = A^T y, with the yaw column divided by a length typical of the
        // robot.
        let (mut ata, mut aty) = (Matrix3::zeros(), Vector3::zeros());
        for ((row, lever_m), rate_rad_s) in self.rows.row_iter().zip(&self.lever_m).zip(rates_rad_s)
        {
            let a = Vector3::new(row[0], row[1], row[2] / self.length_m);
            ata += a * a.transpose();
            aty += a * (lever_m * rate_rad_s);
        }
        for row in &self.held {
            let a = Vector3::new(row[0], row[1], row[2] / self.length_m);
            ata += a * a.transpose();
        }
        let x = match ata.cholesky() {
            Some(factor) => factor.solve(&aty),
            // The current contacts leave one motion free, although the robot as such has rank 3:
            // take the smallest motion that fits.
            None => ata
                .pseudo_inverse(1e-12 * ata.trace())
                .map_or(Vector3::zeros(), |inverse| inverse * aty),
        };
        Twist::new(x.x, x.y, x.z / self.length_m)
    }

    /// Like [`Self::twist_here`], with each wheel weighted by its load, in any unit. Motions that
    /// the loaded wheels leave free, as when fewer than three carry a load, are taken from `real`,
    /// the robot's true twist.
    pub fn twist_by_load_here(&self, rates_rad_s: &[f64], loads: &[f64], real: Twist) -> Twist {
        /// A motion with a smaller part of the load than this counts as free.
        const LEAST_HOLD: f64 = 1e-6;
        // Relative to the real motion: A^T W A x = A^T W (y - A real).
        let (mut ata, mut aty) = (Matrix3::zeros(), Vector3::zeros());
        let moved = Vector3::new(real.vx_m_s, real.vy_m_s, real.omega_rad_s);
        let wheels = self.rows.row_iter().zip(&self.lever_m);
        for (((row, lever_m), rate_rad_s), load) in wheels.zip(rates_rad_s).zip(loads) {
            let a = Vector3::new(row[0], row[1], row[2] / self.length_m);
            ata += a * a.transpose() * *load;
            aty += a * (*load * (lever_m * rate_rad_s - (row * moved).x));
        }
        // What tyres hold counts as their mean load does.
        let mean_load = loads.iter().sum::<f64>() / loads.len().max(1) as f64;
        for row in &self.held {
            let a = Vector3::new(row[0], row[1], row[2] / self.length_m);
            ata += a * a.transpose() * mean_load;
            aty -= a * (mean_load * (row * moved).x);
        }
        let held = ata + Matrix3::identity() * (LEAST_HOLD * ata.trace());
        let Some(factor) = held.cholesky() else {
            return real;
        };
        let x = factor.solve(&aty);
        real + Twist::new(x.x, x.y, x.z / self.length_m)
    }

    /// [`Self::wheel_rates`] at the wheel angles of the last update.
    pub fn wheel_rates_here(&self, twist_in_body: Twist, out: &mut [f64]) {
        multiply(&self.rate_matrix, twist_in_body, out);
    }

    /// Where each wheel touches, at the wheel angles of the last update.
    pub fn contacts(&self) -> &[RollerContact] {
        &self.contacts
    }

    /// The reference point in the body frame, in metres.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.reference_point_m
    }

    /// Computes the velocity at which each contact slides along its roller's axis on the ground, in
    /// m/s, if the body moves with `twist_in_body` and the wheels with these rates: zero is rolling
    /// without slip. A tyre slides along its wheel's way.
    pub fn residuals_here(&self, twist_in_body: Twist, rates_rad_s: &[f64], out: &mut [f64]) {
        multiply(&self.rows, twist_in_body, out);
        for ((out, lever_m), rate_rad_s) in out.iter_mut().zip(&self.lever_m).zip(rates_rad_s) {
            *out -= lever_m * rate_rad_s;
        }
    }

    /// Updates rows, levers and rate matrix for the current contacts.
    fn refresh_rows(&mut self) {
        for (h, (contact, wheel)) in self.contacts.iter().zip(&self.wheels).enumerate() {
            if self.ideal.swivels(h) {
                // Its row, lever and rate stay zero.
                continue;
            }
            let hub_m = wheel.body_from_hub.translation.vector;
            let n = wheel.body_from_hub.rotation * Vector3::z();
            let p = contact.point_in_body_m.xy() - self.reference_point_m;
            // A roller axis never stands upright: |gamma| < 90 deg keeps it off the hub's radius.
            let d_g = contact.axis_in_body.xy().normalize();
            // A tyre is driven across its own axis.
            let d_g = if wheel.has_tyre {
                Vector2::new(d_g.y, -d_g.x)
            } else {
                d_g
            };
            let turn_m = n.cross(&(contact.point_in_body_m - hub_m));
            let lever_m = -d_g.dot(&turn_m.xy());
            let d_g = d_g * lever_m.signum();
            let row = Vector3::new(d_g.x, d_g.y, p.x * d_g.y - p.y * d_g.x).transpose();
            self.lever_m[h] = lever_m.abs();
            self.rows.set_row(h, &row);
            self.rate_matrix.set_row(h, &(row / lever_m.abs()));
        }
    }
}

impl WheelContacts {
    /// Returns the lowest roller at this wheel angle. If several are equally low (overlapping
    /// barrels, or two rows at once), the one closest to straight down.
    fn touching(&self, wheel_angle_rad: f64) -> RollerContact {
        // Depths that differ by less than this share of the radius count as equal: far above
        // rounding, far below the scale of a contact.
        let tie_m = 1e-9 * self.radius_m;
        // "Down" is rotated into the wheel's frame, which is cheaper than rotating every roller.
        let (sin, cos) = libm::sincos(wheel_angle_rad);
        let d = self.down_in_hub;
        let w = Vector3::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x, d.z);
        let depth_of = |roller: &RollerGeometry| {
            let (from_center_m, radius_m) = roller.outline.support_m(&roller.axis_in_hub, &w);
            let point_m = roller.center_in_hub_m + from_center_m;
            (point_m.dot(&w), point_m, radius_m)
        };
        if self.has_tyre {
            let axis = Unit::new_unchecked(self.body_from_hub.rotation * Vector3::z());
            let down = self.body_from_hub.rotation * d;
            return RollerContact {
                roller: 0,
                angle_rad: 0.0,
                point_in_body_m: self.body_from_hub.translation.vector + self.radius_m * down,
                axis_in_body: axis,
                radius_m: self.radius_m,
            };
        }
        let nearness = |roller: &RollerGeometry| roller.outward.dot(&w);
        let rollers = || self.rollers.iter().enumerate();
        // The first of several, which is the last of the reversed list.
        let nearest = rollers()
            .rev()
            .max_by(|(_, a), (_, b)| nearness(a).total_cmp(&nearness(b)));
        // The constructor rejects wheels without rollers; a wheel without any would touch below its
        // hub.
        let Some((mut index, nearest)) = nearest else {
            return RollerContact {
                roller: 0,
                angle_rad: 0.0,
                point_in_body_m: self.body_from_hub.translation.vector
                    - self.radius_m * Vector3::z(),
                axis_in_body: self.body_from_hub.rotation * Vector3::y_axis(),
                radius_m: self.radius_m,
            };
        };
        let (mut best, mut best_nearness) = (depth_of(nearest), nearness(nearest));
        for (other, roller) in rollers() {
            let near = nearness(roller);
            // Upper bound of the depth: that of the middle, plus the end's below the middle, plus
            // the thickness. A roller beyond a quarter turn from down never touches flat ground.
            let at_most_m = roller.center_in_hub_m.dot(&w)
                + roller.half_length_m * roller.axis_in_hub.dot(&w).abs()
                + roller.radius_m;
            if other == index || near <= 0.0 || at_most_m <= best.0 - tie_m {
                continue;
            }
            let found = depth_of(roller);
            if found.0 > best.0 + tie_m || (found.0 > best.0 - tie_m && near > best_nearness) {
                (index, best, best_nearness) = (other, found, near);
            }
        }
        let (_, point_m, radius_m) = best;
        let roller = &self.rollers[index];
        // The angle about the hub axis z from straight down.
        let center = roller.center_in_hub_m;
        let turned =
            |v: Vector3<f64>| Vector3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
        let axis = Unit::new_unchecked(turned(roller.axis_in_hub.into_inner()));
        RollerContact {
            roller: index,
            angle_rad: libm::atan2(w.cross(&center).z, w.dot(&center)),
            point_in_body_m: (self.body_from_hub * Point3::from(turned(point_m))).coords,
            axis_in_body: self.body_from_hub.rotation * axis,
            radius_m,
        }
    }
}

#[cfg(test)]
mod tests;
