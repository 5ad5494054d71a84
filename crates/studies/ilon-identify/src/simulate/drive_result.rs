//! What simulated drives made.

/// What a simulated drive made.
#[derive(Clone, Debug)]
pub(super) struct DriveResult {
    /// The way along the direction that the wheels ask for, over the way that they ask for by the study's robot.
    pub along: f64,
    /// The same across it, to the left.
    pub across: f64,
    /// By how much it turned beyond what the wheels ask for, over the way that they ask for, in rad/m.
    pub drift_rad_per_m: f64,
    /// The mean torque of each wheel's motor, in N m at the wheel.
    pub torques_n_m: Vec<f64>,
    /// The ripple of the wheels' rates in rad/s and of the body's way in metres, root mean square; 0 where none is compared.
    pub wheels_rad_s: f64,
    pub body_m: f64,
}

/// What drives from several wheel angles made.
#[derive(Clone, Debug)]
pub(super) struct MeanOverPhases {
    /// Their mean.
    pub mean: DriveResult,
    /// Each of them.
    pub each: Vec<DriveResult>,
}

impl MeanOverPhases {
    /// All drives; `None` where one of them came to nothing.
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

    /// The standard deviation of the ways along over the wheel angles; 0 of one.
    pub fn scatter(&self) -> f64 {
        let squares = self
            .each
            .iter()
            .map(|made| (made.along - self.mean.along).powi(2));
        (squares.sum::<f64>() / (self.each.len() - 1).max(1) as f64).sqrt()
    }
}
