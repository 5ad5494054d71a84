//! The reference trajectories of section III-A, eqs. (13)-(17).
//!
//! Position and heading are independent, as the paper stresses for omnidirectional robots: every
//! path can have every [`Heading`].

use std::f64::consts::TAU;

use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::{Vector1, Vector2};

use crate::ControlError;
use crate::error::{finite, positive};
use crate::guidance::pace::Pace;
use crate::guidance::spline::{Motion, Spline};
use crate::guidance::tracking::PathPoint;

/// The desired pose and motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Desired {
    /// r_d of eq. (13) and phi_d of eq. (17), in the world frame. The heading is not wrapped.
    pub pose: Pose,
    /// Their time derivatives r_d' and phi_d', in the world frame.
    pub velocity_in_world: Twist,
}

/// A reference trajectory: a path over time, and a heading over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    path: Path,
    heading: Heading,
    /// The time law of the path's own time; `None` if own time is time.
    pace: Option<Pace>,
}

/// The reference heading phi_d(t).
#[derive(Clone, Debug, PartialEq)]
pub enum Heading {
    /// Constant heading.
    Constant {
        /// phi_d in radians.
        heading_rad: f64,
    },
    /// Constant heading rate, whatever the path does.
    Rate {
        /// phi_d at time zero, in radians.
        start_rad: f64,
        /// phi_d' in rad/s.
        rate_rad_s: f64,
    },
    /// Along the path's tangent t_d of eq. (15), or at a fixed angle from it.
    Tangent {
        /// Angle from the tangent to the heading, in radians.
        offset_rad: f64,
    },
    /// One heading per waypoint, turning the shorter way from each to the next, continuous in rate
    /// and at rest at both ends. For paths by waypoints only.
    Waypoints {
        /// Headings at the waypoints, in radians.
        headings_rad: Vec<f64>,
    },
}

#[derive(Clone, Debug, PartialEq)]
enum Path {
    Hold {
        point_m: Vector2<f64>,
    },
    Line {
        from_m: Vector2<f64>,
        direction: Vector2<f64>,
        length_m: f64,
        speed_m_s: f64,
    },
    Circle {
        center_m: Vector2<f64>,
        radius_m: f64,
        start_rad: f64,
        rate_rad_s: f64,
    },
    FigureEight {
        center_m: Vector2<f64>,
        half_width_m: f64,
        axis_rad: f64,
        rate_rad_s: f64,
    },
    Waypoints {
        positions: Spline<2>,
        /// Present where the headings are given at the waypoints.
        headings: Option<Spline<1>>,
    },
}

impl Reference {
    /// A pose to hold: the paper's pose regulation, r_d' = 0 and phi_d' = 0.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`].
    pub fn hold(pose: Pose) -> Result<Self, ControlError> {
        let path = Path::Hold {
            point_m: finite_point("the pose to hold", pose.position_m())?,
        };
        let heading_rad = pose.heading_rad;
        Self::assemble(path, Heading::Constant { heading_rad })
    }

    /// A straight line at constant speed in m/s, held at its end. The reference velocity steps at
    /// both ends.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`], [`ControlError::NotPositive`] for the speed or where both ends
    /// are the same point.
    pub fn line(
        from_m: Vector2<f64>,
        to_m: Vector2<f64>,
        speed_m_s: f64,
        heading: Heading,
    ) -> Result<Self, ControlError> {
        let from_m = finite_point("the line's start", from_m)?;
        let along_m = finite_point("the line's end", to_m)? - from_m;
        let length_m = positive("the line's length in m", along_m.norm())?;
        let path = Path::Line {
            from_m,
            direction: along_m / length_m,
            length_m,
            speed_m_s: positive("the line's speed in m/s", speed_m_s)?,
        };
        Self::assemble(path, heading)
    }

    /// A circle at constant speed, from the point at `start_rad` from the world's x axis seen from
    /// its centre; counter-clockwise for a positive speed in m/s, clockwise for a negative one.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`], [`ControlError::NotPositive`] for the radius or the amount of
    /// the speed.
    pub fn circle(
        center_m: Vector2<f64>,
        radius_m: f64,
        speed_m_s: f64,
        start_rad: f64,
        heading: Heading,
    ) -> Result<Self, ControlError> {
        let radius_m = positive("the circle's radius in m", radius_m)?;
        positive("the amount of the circle's speed in m/s", speed_m_s.abs())?;
        let path = Path::Circle {
            center_m: finite_point("the circle's centre", center_m)?,
            radius_m,
            start_rad: finite("the circle's start angle in rad", start_rad)?,
            rate_rad_s: speed_m_s / radius_m,
        };
        Self::assemble(path, heading)
    }

    /// A figure eight: the lemniscate of Bernoulli, starting at its crossing, with `half_width_m`
    /// from there to each tip along an axis at `axis_rad` from the world's x axis, one lap in
    /// `period_s`.
    ///
    /// In the axis's frame, with T = 2 pi t / period: (x, y) = half_width sin T / (1 + cos^2 T) (1,
    /// cos T). Its speed is 2 pi half_width / period over sqrt(1 + cos^2 T): largest at the tips,
    /// smallest at the crossing.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`], [`ControlError::NotPositive`].
    pub fn figure_eight(
        center_m: Vector2<f64>,
        half_width_m: f64,
        axis_rad: f64,
        period_s: f64,
        heading: Heading,
    ) -> Result<Self, ControlError> {
        let path = Path::FigureEight {
            center_m: finite_point("the figure eight's centre", center_m)?,
            half_width_m: positive("the figure eight's half width in m", half_width_m)?,
            axis_rad: finite("the figure eight's axis in rad", axis_rad)?,
            rate_rad_s: TAU / positive("the figure eight's period in s", period_s)?,
        };
        Self::assemble(path, heading)
    }

    /// A path through points at given times in seconds, continuous in velocity and at rest at both
    /// ends. A point given twice is a stop.
    ///
    /// # Errors
    /// [`ControlError::TooFewWaypoints`], [`ControlError::LengthMismatch`],
    /// [`ControlError::TimesNotGrowing`], [`ControlError::NotFinite`]; [`ControlError::NoTangent`]
    /// for a heading along the tangent with a stop inside.
    pub fn waypoints(
        times_s: &[f64],
        points_m: Vec<Vector2<f64>>,
        heading: Heading,
    ) -> Result<Self, ControlError> {
        let positions = Spline::new(times_s, points_m)?;
        let headings = match &heading {
            Heading::Waypoints { headings_rad } => {
                Some(Spline::new(times_s, unwrapped(headings_rad))?)
            }
            _ => None,
        };
        Self::assemble(
            Path::Waypoints {
                positions,
                headings,
            },
            heading,
        )
    }

    /// A path through points with this mean speed in m/s on each chord, from time zero, otherwise
    /// like [`Self::waypoints`].
    ///
    /// # Errors
    /// Those of [`Self::waypoints`]; [`ControlError::NotPositive`] for the speed. Neighbours must
    /// differ.
    pub fn waypoints_at_speed(
        points_m: Vec<Vector2<f64>>,
        speed_m_s: f64,
        heading: Heading,
    ) -> Result<Self, ControlError> {
        positive("the speed along the waypoints in m/s", speed_m_s)?;
        let mut times_s = vec![0.0; points_m.len()];
        for i in 1..points_m.len() {
            let chord_m = (points_m[i] - points_m[i - 1]).norm();
            let what = || format!("the distance between waypoints {} and {i} in m", i - 1);
            times_s[i] = times_s[i - 1] + positive(&what(), chord_m)? / speed_m_s;
        }
        Self::waypoints(&times_s, points_m, heading)
    }

    fn assemble(path: Path, heading: Heading) -> Result<Self, ControlError> {
        match &heading {
            Heading::Constant { heading_rad } => {
                finite("the heading in rad", *heading_rad)?;
            }
            Heading::Rate {
                start_rad,
                rate_rad_s,
            } => {
                finite("the heading at the start in rad", *start_rad)?;
                finite("the heading's rate in rad/s", *rate_rad_s)?;
            }
            Heading::Tangent { offset_rad } => {
                finite("the heading's offset from the tangent in rad", *offset_rad)?;
                path.check_tangent()?;
            }
            Heading::Waypoints { .. } => {
                if !matches!(
                    path,
                    Path::Waypoints {
                        headings: Some(_),
                        ..
                    }
                ) {
                    return Err(ControlError::HeadingsWithoutWaypoints);
                }
            }
        }
        Ok(Self {
            path,
            heading,
            pace: None,
        })
    }

    /// Returns the reference at a time in seconds: r_d and phi_d of eqs. (13), (17), with their
    /// derivatives, in the world frame. Before time zero it is that of time zero.
    pub fn at(&self, t_s: f64) -> Desired {
        let Some(pace) = &self.pace else {
            return self.at_own(t_s);
        };
        let (own_s, passes) = pace.at(t_s, |own_s| self.flow(own_s));
        let desired = self.at_own(own_s);
        Desired {
            velocity_in_world: desired.velocity_in_world.scaled(passes),
            ..desired
        }
    }

    /// Returns the rate of change of the reference's velocity at a time in seconds, in the world
    /// frame, in m/s^2 and rad/s^2: a forward difference quotient. At a step of the velocity, which
    /// no robot can follow, it is the value after the step.
    pub fn acceleration_in_world(&self, t_s: f64) -> Twist {
        const OVER_S: f64 = 1e-5;
        /// A larger value is a step.
        const STEP: f64 = 1e3;
        let quotient = |t_s: f64| {
            let [now, then] = [t_s, t_s + OVER_S].map(|t_s| self.at(t_s).velocity_in_world);
            (then + now.scaled(-1.0)).scaled(1.0 / OVER_S)
        };
        let found = quotient(t_s.max(0.0));
        if found.linear_m_s().norm() < STEP && found.omega_rad_s.abs() < STEP {
            return found;
        }
        let after = quotient(t_s.max(0.0) + OVER_S);
        match after.linear_m_s().norm() < STEP && after.omega_rad_s.abs() < STEP {
            true => after,
            false => Twist::default(),
        }
    }

    /// Returns when a time-optimal path starts to rest, or to repeat its last lap, in seconds;
    /// `None` for a path at its own pace.
    pub fn nothing_new_from_s(&self) -> Option<f64> {
        self.pace.as_ref().map(Pace::end_s)
    }

    /// Returns the same path with another time law.
    pub(super) fn at_pace(&self, pace: Pace) -> Self {
        Self {
            pace: Some(pace),
            ..self.clone()
        }
    }

    /// Returns the intervals on which the path is smooth, in its own time, in seconds; one lap for
    /// a path without end.
    pub(super) fn pieces(&self) -> Pieces<'_> {
        match &self.path {
            Path::Hold { .. } => Pieces::None,
            Path::Line {
                length_m,
                speed_m_s,
                ..
            } => Pieces::Line(length_m / speed_m_s),
            Path::Circle { rate_rad_s, .. } | Path::FigureEight { rate_rad_s, .. } => {
                Pieces::Lap(TAU / rate_rad_s.abs())
            }
            Path::Waypoints { positions, .. } => Pieces::Between(positions.times_s()),
        }
    }

    /// Returns the reference's speed in its own time, in m/s: that of its point plus that of the
    /// end of an arm that turns with it.
    pub(super) fn flow_on(&self, own_s: f64, arm_m: f64) -> f64 {
        let v = self.at_own(own_s).velocity_in_world;
        libm::hypot(v.linear_m_s().norm(), arm_m * v.omega_rad_s)
    }

    fn flow(&self, own_s: f64) -> f64 {
        self.flow_on(own_s, self.pace.as_ref().map_or(0.0, Pace::arm_m))
    }

    /// Returns the reference at its own time, at a pace of one.
    pub(super) fn at_own(&self, t_s: f64) -> Desired {
        let t_s = t_s.max(0.0);
        let r_d = self.path.at(t_s);
        let (heading_rad, omega_rad_s) = match &self.heading {
            Heading::Constant { heading_rad } => (*heading_rad, 0.0),
            Heading::Rate {
                start_rad,
                rate_rad_s,
            } => (start_rad + rate_rad_s * t_s, *rate_rad_s),
            Heading::Tangent { offset_rad } => {
                let d = self.path.direction(t_s);
                let (v, a) = (r_d.velocity, r_d.acceleration);
                // d/dt atan2(v_y, v_x); in a stop the heading is constant.
                let speed_squared = v.norm_squared();
                let turning = speed_squared > 1e-12 * d.norm_squared() && speed_squared > 0.0;
                let rate = if turning {
                    v.perp(&a) / speed_squared
                } else {
                    0.0
                };
                (libm::atan2(d.y, d.x) + offset_rad, rate)
            }
            Heading::Waypoints { .. } => self.path.heading_at(t_s),
        };
        Desired {
            pose: Pose {
                x_m: r_d.value.x,
                y_m: r_d.value.y,
                heading_rad,
            },
            velocity_in_world: Twist::new(r_d.velocity.x, r_d.velocity.y, omega_rad_s),
        }
    }

    /// Whether its heading is against the path all the way: a robot that cannot move sideways
    /// drives it backwards.
    fn is_backwards(&self) -> bool {
        let beside_rad = match (&self.heading, &self.path) {
            (Heading::Tangent { offset_rad }, _) => *offset_rad,
            (Heading::Constant { heading_rad }, Path::Line { direction, .. }) => {
                heading_rad - libm::atan2(direction.y, direction.x)
            }
            _ => 0.0,
        };
        libm::cos(beside_rad) < -1e-9
    }

    /// Returns how its path goes at a time in seconds, for a robot that cannot move sideways. While
    /// it stands, its direction is the reference heading.
    pub fn path_at(&self, t_s: f64) -> PathPoint {
        /// Half of the time over which the turning of the path is taken, in seconds (chosen).
        const HALF_S: f64 = 1e-3;
        let sign = if self.is_backwards() { -1.0 } else { 1.0 };
        let direction_rad = |desired: &Desired| {
            let v = sign * desired.velocity_in_world.linear_m_s();
            (v.norm() > 0.0).then(|| libm::atan2(v.y, v.x))
        };
        let now = self.at(t_s);
        let sides = [-HALF_S, HALF_S].map(|off_s| direction_rad(&self.at(t_s + off_s)));
        let turned_rad = match sides {
            [Some(before), Some(after)] => wrap_angle(after - before),
            _ => 0.0,
        };
        PathPoint {
            position_m: now.pose.position_m(),
            direction_rad: direction_rad(&now).unwrap_or(now.pose.heading_rad),
            speed_m_s: sign * now.velocity_in_world.linear_m_s().norm(),
            turning_rad_s: turned_rad / (2.0 * HALF_S),
        }
    }

    /// Returns the largest reference speed in m/s and heading rate in rad/s up to a time, from
    /// `samples` equal steps, for the feasibility conditions (36) and (37).
    pub fn peaks(&self, until_s: f64, samples: usize) -> (f64, f64) {
        let samples = samples.max(1);
        (0..=samples).fold((0.0, 0.0), |(speed, rate), k| {
            let d = self
                .at(until_s * k as f64 / samples as f64)
                .velocity_in_world;
            (
                d.linear_m_s().norm().max(speed),
                d.omega_rad_s.abs().max(rate),
            )
        })
    }
}

/// The smooth intervals of a path, in its own time.
pub(super) enum Pieces<'a> {
    /// The path does not move.
    None,
    /// From zero to this time, in seconds.
    Line(f64),
    /// Repeated laps of this duration, in seconds.
    Lap(f64),
    /// Between these times, in seconds.
    Between(&'a [f64]),
}

impl Path {
    fn at(&self, t_s: f64) -> Motion<2> {
        match self {
            Self::Hold { point_m } => Motion {
                value: *point_m,
                velocity: Vector2::zeros(),
                acceleration: Vector2::zeros(),
            },
            Self::Line {
                from_m,
                direction,
                length_m,
                speed_m_s,
            } => {
                let s = speed_m_s * t_s;
                let speed_m_s = if s < *length_m { *speed_m_s } else { 0.0 };
                Motion {
                    value: from_m + direction * s.min(*length_m),
                    velocity: direction * speed_m_s,
                    acceleration: Vector2::zeros(),
                }
            }
            Self::Circle {
                center_m,
                radius_m,
                start_rad,
                rate_rad_s,
            } => {
                let (s, c) = libm::sincos(start_rad + rate_rad_s * t_s);
                let arm = *radius_m * Vector2::new(c, s);
                Motion {
                    value: center_m + arm,
                    velocity: *rate_rad_s * Vector2::new(-arm.y, arm.x),
                    acceleration: -rate_rad_s * rate_rad_s * arm,
                }
            }
            Self::FigureEight {
                center_m,
                half_width_m: a,
                axis_rad,
                rate_rad_s: w,
            } => {
                let (s, c) = libm::sincos(w * t_s);
                let d = 1.0 + c * c;
                // x = a s / d and y = c x, differentiated by T, with d' = -2 c s.
                let x = a * s / d;
                let numerator = a * c * (3.0 - c * c);
                let x_1 = numerator / (d * d);
                let x_2 = (4.0 * numerator * c * s / d - 3.0 * a * s * s * s) / (d * d);
                let y = c * x;
                let y_1 = c * x_1 - s * x;
                let y_2 = c * x_2 - 2.0 * s * x_1 - c * x;
                let (sin_axis, cos_axis) = libm::sincos(*axis_rad);
                let turned = |x: f64, y: f64| {
                    Vector2::new(cos_axis * x - sin_axis * y, sin_axis * x + cos_axis * y)
                };
                Motion {
                    value: center_m + turned(x, y),
                    velocity: *w * turned(x_1, y_1),
                    acceleration: w * w * turned(x_2, y_2),
                }
            }
            Self::Waypoints { positions, .. } => positions.at(t_s),
        }
    }

    /// Returns the direction of motion, not normalised; in a stop, that of the adjacent motion.
    fn direction(&self, t_s: f64) -> Vector2<f64> {
        match self {
            Self::Line { direction, .. } => *direction,
            Self::Waypoints { positions, .. } => positions.direction(t_s),
            _ => self.at(t_s).velocity,
        }
    }

    fn check_tangent(&self) -> Result<(), ControlError> {
        let reason = match self {
            Self::Hold { .. } => "a pose to hold has no tangent".to_owned(),
            Self::Waypoints { positions, .. } => {
                let same = positions.points().windows(2).position(|w| w[0] == w[1]);
                match same {
                    Some(i) => format!("waypoints {i} and {} are the same point", i + 1),
                    None => return Ok(()),
                }
            }
            _ => return Ok(()),
        };
        Err(ControlError::NoTangent { reason })
    }

    fn heading_at(&self, t_s: f64) -> (f64, f64) {
        match self {
            Self::Waypoints {
                headings: Some(headings),
                ..
            } => {
                let motion = headings.at(t_s);
                (motion.value.x, motion.velocity.x)
            }
            _ => (0.0, 0.0),
        }
    }
}

/// Adds whole turns to headings so that each differs from the one before by at most half a turn.
fn unwrapped(headings_rad: &[f64]) -> Vec<Vector1<f64>> {
    let mut previous = headings_rad.first().copied().unwrap_or_default();
    headings_rad
        .iter()
        .map(|heading_rad| {
            previous += ilon_robot::wrap_angle(heading_rad - previous);
            Vector1::new(previous)
        })
        .collect()
}

/// Returns `point_m` if both of its coordinates are finite.
fn finite_point(what: &str, point_m: Vector2<f64>) -> Result<Vector2<f64>, ControlError> {
    finite(&format!("x of {what}"), point_m.x)?;
    finite(&format!("y of {what}"), point_m.y)?;
    Ok(point_m)
}
