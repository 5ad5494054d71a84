//! Results of simulated drives.

/// The result of a simulated drive.
#[derive(Clone, Debug)]
pub(super) struct DriveResult {
    /// Distance along the direction commanded by the wheels, over the distance commanded by the
    /// study's robot.
    pub along: f64,
    /// The same across it, to the left.
    pub across: f64,
    /// Rotation beyond the one commanded by the wheels, over the commanded distance, in rad/m.
    pub drift_rad_per_m: f64,
    /// The mean torque of each wheel's motor, in N m at the wheel.
    pub torques_n_m: Vec<f64>,
    /// Ripple of the wheels' rates in rad/s and of the body's position in metres, root mean square;
    /// 0 if not compared.
    pub wheels_rad_s: f64,
    pub body_m: f64,
}

/// Results of a drive from several sets of initial wheel angles.
#[derive(Clone, Debug)]
pub(super) struct MeanOverPhases {
    /// Their mean.
    pub mean: DriveResult,
    /// The result of each set.
    pub each: Vec<DriveResult>,
}

impl MeanOverPhases {
    /// Combines all drives; `None` if one of them failed.
    pub fn new(all: &[Option<DriveResult>]) -> Option<Self> {
        let each: Vec<DriveResult> = all.iter().cloned().collect::<Option<_>>()?;
        let wheels = each.first()?.torques_n_m.len();
        let mean =
            |of: &dyn Fn(&DriveResult) -> f64| each.iter().map(of).sum::<f64>() / each.len() as f64;
        let mean = DriveResult {
            along: mean(&|made| made.along),
            across: mean(&|made| made.across),
            drift_rad_per_m: mean(&|made| made.drift_rad_per_m),
            torques_n_m: (0..wheels)
                .map(|wheel| mean(&|made| made.torques_n_m[wheel]))
                .collect(),
            wheels_rad_s: mean(&|made| made.wheels_rad_s),
            body_m: mean(&|made| made.body_m),
        };
        Some(Self { mean, each })
    }

    /// Returns the standard deviation of the distances along over the sets; 0 for one.
    pub fn scatter(&self) -> f64 {
        let squares = self
            .each
            .iter()
            .map(|made| (made.along - self.mean.along).powi(2));
        (squares.sum::<f64>() / (self.each.len() - 1).max(1) as f64).sqrt()
    }
}
