//! Models of the kinematics: the ideal matrix with free radii, levers and roller angle, and gains
//! on its output.

use ilon_control::Kinematics;
use ilon_robot::{Robot, Roller, Wheel};
use ilon_sim::Error;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3xX, Translation3, UnitQuaternion, Vector3};

use crate::motion::Tracker;
use crate::steered::is_hold;

/// A parameter of the robot, the log or the tracker that can be free.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// The radius of all wheels, in metres.
    Radius,
    /// The radius of one wheel, by its index in the robot, in metres.
    WheelRadius(usize),
    /// The arm with which a wheel rotates the robot, in metres: the radius of a ring, the sum of
    /// the two arms of mecanum wheels. All wheels move away from the middle by the same factor.
    Lever,
    /// The size of the angle gamma of all wheels, in degrees.
    Gamma,
    /// The heading of a wheel's axis in the body frame, in degrees.
    WheelAxis(usize),
    /// Angle of a steered wheel where the log reads 0, in degrees.
    Steering(usize),
    /// Position of a wheel along x of the body frame, in metres.
    WheelX(usize),
    /// Position of a wheel along y of the body frame, in metres.
    WheelY(usize),
    /// Motion along x over that of the matrix.
    GainAhead,
    /// Motion along y over that of the matrix.
    GainSideways,
    /// Rotation over that of the matrix.
    GainTurn,
    /// Share of the rows that were lost, with the wheels' rotation in them.
    RowsLost,
    /// x of the point that the tracker follows, in the body frame, for one series of runs, in
    /// metres.
    TrackerX(String),
    /// y of that point.
    TrackerY(String),
    /// Angle of the tracker's heading ahead of the body's, in degrees.
    TrackerHeading(String),
}

/// What a parameter belongs to: the robot, one of its wheels, or the tracker of a series of runs.
enum Of<'p> {
    Robot,
    Wheel(usize),
    Tracker(&'p str),
}

impl Parameter {
    /// Those of the robot.
    const OF_ROBOT: [Self; 7] = [
        Self::Radius,
        Self::Lever,
        Self::Gamma,
        Self::GainAhead,
        Self::GainSideways,
        Self::GainTurn,
        Self::RowsLost,
    ];
    /// Those of a wheel.
    const OF_WHEEL: [fn(usize) -> Self; 5] = [
        Self::WheelRadius,
        Self::WheelAxis,
        Self::Steering,
        Self::WheelX,
        Self::WheelY,
    ];

    /// The word for it in names, which ends in its unit if it has one, and what it belongs to.
    fn word(&self) -> (&'static str, Of<'_>) {
        match self {
            Self::Radius => ("radius_m", Of::Robot),
            Self::Lever => ("lever_m", Of::Robot),
            Self::Gamma => ("gamma_deg", Of::Robot),
            Self::GainAhead => ("gain.ahead", Of::Robot),
            Self::GainSideways => ("gain.sideways", Of::Robot),
            Self::GainTurn => ("gain.turn", Of::Robot),
            Self::RowsLost => ("rows_lost", Of::Robot),
            Self::WheelRadius(wheel) => ("radius_m", Of::Wheel(*wheel)),
            Self::WheelAxis(wheel) => ("axis_deg", Of::Wheel(*wheel)),
            Self::Steering(wheel) => ("steering_deg", Of::Wheel(*wheel)),
            Self::WheelX(wheel) => ("x_m", Of::Wheel(*wheel)),
            Self::WheelY(wheel) => ("y_m", Of::Wheel(*wheel)),
            Self::TrackerX(series) => ("x_m", Of::Tracker(series)),
            Self::TrackerY(series) => ("y_m", Of::Tracker(series)),
            Self::TrackerHeading(series) => ("heading_deg", Of::Tracker(series)),
        }
    }

    /// Its name in a study and in the results.
    pub fn name(&self, robot: &Robot) -> String {
        match self.word() {
            (word, Of::Robot) => word.to_owned(),
            (word, Of::Wheel(wheel)) => format!("{word}.{}", robot.wheels[wheel].name),
            (word, Of::Tracker("")) => format!("tracker.{word}"),
            (word, Of::Tracker(series)) => format!("tracker.{word}.{series}"),
        }
    }

    /// Its unit; empty if dimensionless.
    pub fn unit(&self) -> &'static str {
        let (word, _) = self.word();
        match word.rsplit_once('_') {
            Some((_, unit @ ("m" | "deg"))) => unit,
            _ => "",
        }
    }

    /// Its value before the fit.
    pub fn nominal(&self, robot: &Robot) -> f64 {
        match self {
            Self::Radius => robot.mean_wheel_radius_m(),
            Self::WheelRadius(wheel) => robot.wheels[*wheel].radius_m,
            Self::Lever => lever_m(robot),
            Self::Gamma => gamma_rad(robot).to_degrees(),
            Self::WheelAxis(wheel) => {
                let axis = robot.wheels[*wheel].axis();
                libm::atan2(axis.y, axis.x).to_degrees()
            }
            Self::WheelX(wheel) => robot.wheels[*wheel].position_m().x,
            Self::WheelY(wheel) => robot.wheels[*wheel].position_m().y,
            Self::GainAhead | Self::GainSideways | Self::GainTurn => 1.0,
            Self::Steering(_)
            | Self::RowsLost
            | Self::TrackerX(_)
            | Self::TrackerY(_)
            | Self::TrackerHeading(_) => 0.0,
        }
    }

    /// Its expected deviation: a parameter that a log does not narrow below this is not determined.
    pub fn scale(&self, robot: &Robot) -> f64 {
        match self {
            Self::Radius | Self::WheelRadius(_) | Self::Lever => 0.1 * self.nominal(robot),
            Self::WheelX(_) | Self::WheelY(_) => 0.1 * lever_m(robot),
            Self::Gamma | Self::WheelAxis(_) | Self::Steering(_) | Self::TrackerHeading(_) => 5.0,
            Self::GainAhead | Self::GainSideways | Self::GainTurn | Self::RowsLost => 0.1,
            Self::TrackerX(_) | Self::TrackerY(_) => 0.1,
        }
    }

    /// Whether it belongs to the tracker and not to the robot.
    pub fn is_of_tracker(&self) -> bool {
        matches!(self.word(), (_, Of::Tracker(_)))
    }

    /// Whether it is the position of a wheel, or the direction of its axis.
    pub fn is_of_place(&self) -> bool {
        matches!(
            self,
            Self::WheelAxis(_) | Self::Steering(_) | Self::WheelX(_) | Self::WheelY(_)
        )
    }

    /// Returns the parameters of a name in a study; `radius_m.*` and the like are one per wheel.
    fn named(name: &str, robot: &Robot) -> Option<Vec<Self>> {
        if let Some(one) = Self::OF_ROBOT.into_iter().find(|of| of.word().0 == name) {
            return Some(vec![one]);
        }
        let (word, wheel) = name.split_once('.')?;
        let of = Self::OF_WHEEL
            .into_iter()
            .find(|of| of(0).word().0 == word)?;
        let mut wheels = named_wheels(robot);
        wheels.retain(|at| {
            (wheel == "*" || robot.wheels[*at].name == wheel)
                && (word != "steering_deg" || stands_for_steered(robot, *at))
        });
        (!wheels.is_empty()).then(|| wheels.into_iter().map(of).collect())
    }
}

/// The wheels that have names, by their indices: of two that stand for a steered one the first.
pub(crate) fn named_wheels(robot: &Robot) -> Vec<usize> {
    let wheels = &robot.wheels;
    let is_first = |at: &usize| {
        wheels[..*at]
            .iter()
            .all(|other| other.name != wheels[*at].name)
    };
    let named = (0..wheels.len()).filter(|at| !is_hold(&wheels[*at]));
    named.filter(is_first).collect()
}

/// Whether a wheel is one of two that stand for a steered one.
pub(crate) fn stands_for_steered(robot: &Robot, wheel: usize) -> bool {
    let name = &robot.wheels[wheel].name;
    let is_it = |other: &&Wheel| !is_hold(other) && other.name == *name;
    robot.wheels.iter().filter(is_it).count() > 1
}

/// Returns the mean arm with which a wheel rotates the robot, in metres: |b . u_gamma| / cos(gamma)
/// about the middle of all wheels; of steered ones the distance of their axes from the middle of
/// those that are not steered, if there are any.
fn lever_m(robot: &Robot) -> f64 {
    let middle = middle_m(robot);
    let mut named = named_wheels(robot);
    if named.iter().any(|at| stands_for_steered(robot, *at)) {
        named.retain(|at| stands_for_steered(robot, *at));
    }
    let arm_m = |at: &usize| {
        let wheel = &robot.wheels[*at];
        let b = (wheel.position_m() - middle).xy();
        match stands_for_steered(robot, *at) {
            true => b.norm(),
            false => (b.dot(&wheel.roller_rolling_direction()) / libm::cos(wheel.gamma_rad)).abs(),
        }
    };
    named.iter().map(arm_m).sum::<f64>() / named.len() as f64
}

fn gamma_rad(robot: &Robot) -> f64 {
    let sizes = robot.wheels.iter().map(|wheel| wheel.gamma_rad.abs());
    sizes.sum::<f64>() / robot.wheels.len() as f64
}

fn middle_m(robot: &Robot) -> Vector3<f64> {
    let is_fixed = |at: &usize| !stands_for_steered(robot, *at);
    let mut places: Vec<usize> = (0..robot.wheels.len()).filter(is_fixed).collect();
    if places.is_empty() {
        places = named_wheels(robot);
    }
    let sum: Vector3<f64> = places.iter().map(|at| robot.wheels[*at].position_m()).sum();
    sum / places.len() as f64
}

/// A robot with its free parameters.
#[derive(Clone, Debug)]
pub struct Model {
    robot: Robot,
    /// The free parameters, those of the tracker last.
    pub parameters: Vec<Parameter>,
    /// Known factors on motion ahead, sideways and of rotation.
    known_gains: [f64; 3],
}

impl Model {
    /// A model of a robot with these parameters free.
    ///
    /// # Errors
    /// An unknown parameter, a repeated one, or one contained in another; a robot with steered
    /// tyres.
    pub fn new(robot: &Robot, free: &[String]) -> Result<Self, Error> {
        refuse_steered(robot)?;
        let mut parameters: Vec<Parameter> = Vec::new();
        for name in free {
            let Some(named) = Parameter::named(name, robot) else {
                return Err(Error::invalid(
                    format!("`{name}` is not a parameter of the kinematics"),
                    format!(
                        "there are radius_m, lever_m, gamma_deg, gain.ahead, gain.sideways, gain.turn and rows_lost, and radius_m, axis_deg, x_m and \
                         y_m of a wheel, and steering_deg of a steered one, as radius_m.WHEEL or radius_m.* ({}); keys of the scenario are fitted below `[simulate]`",
                        named_wheels(robot)
                            .iter()
                            .map(|at| robot.wheels[*at].name.as_str())
                            .collect::<Vec<_>>()
                            .join(", ")
                    ),
                ));
            };
            for parameter in named {
                let is_radius = |other: &Parameter| matches!(other, Parameter::WheelRadius(_));
                let contains = (parameter == Parameter::Radius && parameters.iter().any(is_radius))
                    || (is_radius(&parameter) && parameters.contains(&Parameter::Radius));
                if contains || parameters.contains(&parameter) {
                    return Err(Error::invalid(
                        format!("`{name}` is free twice in one model"),
                        "leave one of them out",
                    ));
                }
                parameters.push(parameter);
            }
        }
        Ok(Self {
            robot: bare(robot),
            parameters,
            known_gains: [1.0; 3],
        })
    }

    /// Returns the model with known factors on motion ahead, sideways and of rotation, such as those
    /// of the rollers that touch.
    pub(crate) fn with_gains(self, known_gains: [f64; 3]) -> Self {
        Self {
            known_gains,
            ..self
        }
    }

    /// Returns the model with the tracker's parameters free too, for each of these series.
    pub fn with_tracker(mut self, of_tracker: &[String], series: &[String]) -> Self {
        for one in series {
            for name in of_tracker {
                self.parameters.push(match name.as_str() {
                    "x_m" => Parameter::TrackerX(one.clone()),
                    "y_m" => Parameter::TrackerY(one.clone()),
                    _ => Parameter::TrackerHeading(one.clone()),
                });
            }
        }
        self
    }

    fn each<T>(&self, of: fn(&Parameter, &Robot) -> T) -> Vec<T> {
        let parameters = self.parameters.iter();
        parameters
            .map(|parameter| of(parameter, &self.robot))
            .collect()
    }

    /// Returns the robot's own values of the parameters.
    pub fn nominal(&self) -> Vec<f64> {
        self.each(Parameter::nominal)
    }

    /// Returns the expected deviation of each parameter.
    pub fn scales(&self) -> Vec<f64> {
        self.each(Parameter::scale)
    }

    /// The names of the parameters.
    pub fn names(&self) -> Vec<String> {
        self.each(Parameter::name)
    }

    /// The robot with these values, without its rollers.
    pub fn robot(&self, values: &[f64]) -> Robot {
        let mut robot = self.robot.clone();
        let middle = middle_m(&self.robot);
        for (parameter, value) in self.parameters.iter().zip(values) {
            match parameter {
                Parameter::Radius => {
                    let factor = value / parameter.nominal(&self.robot);
                    robot
                        .wheels
                        .iter_mut()
                        .for_each(|wheel| wheel.radius_m *= factor);
                }
                Parameter::WheelRadius(wheel) => {
                    of_one(&mut robot, *wheel).for_each(|wheel| wheel.radius_m = *value);
                }
                Parameter::Lever => {
                    let factor = value / parameter.nominal(&self.robot);
                    for wheel in &mut robot.wheels {
                        let arm = wheel.body_from_hub.translation.vector - middle;
                        let mut moved = middle + factor * arm;
                        moved.z = wheel.body_from_hub.translation.vector.z;
                        wheel.body_from_hub = Isometry3::from_parts(
                            Translation3::from(moved),
                            wheel.body_from_hub.rotation,
                        );
                    }
                }
                Parameter::WheelAxis(wheel) | Parameter::Steering(wheel) => {
                    let by_deg = value - parameter.nominal(&self.robot);
                    let turn =
                        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), by_deg.to_radians());
                    of_one(&mut robot, *wheel).for_each(|wheel| {
                        wheel.body_from_hub.rotation = turn * wheel.body_from_hub.rotation;
                    });
                }
                Parameter::WheelX(wheel) => {
                    of_one(&mut robot, *wheel)
                        .for_each(|wheel| wheel.body_from_hub.translation.x = *value);
                }
                Parameter::WheelY(wheel) => {
                    of_one(&mut robot, *wheel)
                        .for_each(|wheel| wheel.body_from_hub.translation.y = *value);
                }
                Parameter::Gamma => {
                    for wheel in &mut robot.wheels {
                        let sign = if wheel.gamma_rad < 0.0 { -1.0 } else { 1.0 };
                        wheel.gamma_rad = sign * value.to_radians();
                    }
                }
                _ => {}
            }
        }
        robot
    }

    /// Returns the map from wheel rates to twists with these values; `None` if the robot cannot be
    /// moved with them.
    pub fn twist_matrix(&self, values: &[f64]) -> Option<Matrix3xX<f64>> {
        if values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let kinematics = Kinematics::new(&self.robot(values)).ok()?;
        let mut matrix = kinematics.twist_matrix().clone();
        for (mut row, gain) in matrix.row_iter_mut().zip(self.known_gains) {
            row *= gain;
        }
        for (parameter, value) in self.parameters.iter().zip(values) {
            match parameter {
                Parameter::GainAhead => matrix.row_mut(0).scale_mut(*value),
                Parameter::GainSideways => matrix.row_mut(1).scale_mut(*value),
                Parameter::GainTurn => matrix.row_mut(2).scale_mut(*value),
                // The tracked part of a rotation is the share that was not lost.
                Parameter::RowsLost if *value < 1.0 => matrix.scale_mut(1.0 / (1.0 - value)),
                Parameter::RowsLost => return None,
                _ => {}
            }
        }
        Some(matrix)
    }

    /// Returns the map from wheel angles to what no motion of the robot explains of each wheel's
    /// way, in metres; `None` without steered wheels, or if the robot cannot be moved.
    pub fn contradiction(&self, values: &[f64]) -> Option<DMatrix<f64>> {
        let mut wheels = 0..self.robot.wheels.len();
        if !wheels.any(|at| stands_for_steered(&self.robot, at)) {
            return None;
        }
        let robot = self.robot(values);
        let kinematics = Kinematics::new(&robot).ok()?;
        let count = robot.wheels.len();
        let radii_m = robot.wheels.iter().map(|wheel| wheel.radius_m);
        let radii_m = DVector::from_iterator(count, radii_m);
        let explained = kinematics.rate_matrix() * kinematics.twist_matrix();
        Some(DMatrix::from_diagonal(&radii_m) * (DMatrix::identity(count, count) - explained))
    }

    /// Returns the tracker of a series with these values.
    pub fn tracker(&self, values: &[f64], series: &str) -> Tracker {
        let mut tracker = Tracker::default();
        for (parameter, value) in self.parameters.iter().zip(values) {
            match parameter {
                Parameter::TrackerX(known) if known == series => tracker.point_m[0] = *value,
                Parameter::TrackerY(known) if known == series => tracker.point_m[1] = *value,
                Parameter::TrackerHeading(known) if known == series => {
                    tracker.turned_rad = -value.to_radians();
                }
                _ => {}
            }
        }
        tracker
    }

    /// Returns the model with some of its parameters held.
    pub fn without(&self, held: &[Parameter]) -> Self {
        let mut model = self.clone();
        model
            .parameters
            .retain(|parameter| !held.contains(parameter));
        model
    }
}

/// Returns a wheel, or both that stand for a steered one.
fn of_one(robot: &mut Robot, wheel: usize) -> impl Iterator<Item = &mut Wheel> {
    let name = robot.wheels[wheel].name.clone();
    robot
        .wheels
        .iter_mut()
        .filter(move |other| other.name == name)
}

/// Whether tyres hold a robot sideways.
pub(crate) fn is_held(robot: &Robot) -> bool {
    robot
        .wheels
        .iter()
        .any(|wheel| wheel.has_tyre() || is_hold(wheel))
}

/// Refuses a robot whose kinematics depends on steering angles.
fn refuse_steered(robot: &Robot) -> Result<(), Error> {
    let mut wheels = robot.wheels.iter();
    let steered = wheels.find(|wheel| wheel.has_tyre() && robot.steering_of(wheel).is_some());
    match steered {
        None => Ok(()),
        Some(wheel) => Err(Error::invalid(
            format!(
                "`{}` is steered: its effect depends on the steering angle, which no tape measures and no planned course holds",
                wheel.name
            ),
            "log a drive with the wheels, the steering angles and the poses, and fit the log (`[log.steering]`)",
        )),
    }
}

/// Returns the robot without the parts that its ideal kinematics does not need.
fn bare(robot: &Robot) -> Robot {
    let mut robot = robot.clone();
    robot
        .wheels
        .iter_mut()
        .for_each(|wheel| wheel.rollers.retain(Roller::is_tyre));
    robot.chassis.collisions.clear();
    robot.remarks.clear();
    robot
}
