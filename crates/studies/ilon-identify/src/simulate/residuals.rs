//! Compares measured and simulated drives.

use nalgebra::Matrix3xX;

use super::drive_result::MeanOverPhases;
use super::steady_drives::{Course, Leg};
use crate::motion::twist_of;
use crate::outcome::{
    DriveRipple, DriveTorque, Misses, OtherDrive, SimulatedSeries, SteadyDrive, Value,
};
use crate::scatter::Interval;
use crate::study::{Simulate, Study};

/// Directions this close to ahead or sideways count as such, in degrees.
const CLOSE_DEG: f64 = 20.0;

/// Common factors on measured distances, one per fitted series; empty if they are not free.
pub(super) struct Scales {
    pub series: Vec<String>,
    /// The series of each run.
    of_run: Vec<String>,
    is_free: bool,
}

impl Scales {
    pub fn new(section: &Simulate, study: &Study, fitted: &[&Leg]) -> Self {
        let of_run: Vec<String> = study
            .file
            .runs
            .iter()
            .map(|run| run.series.clone())
            .collect();
        let mut series: Vec<String> = Vec::new();
        for leg in fitted {
            if section.free_scale && !series.contains(&of_run[leg.run]) {
                series.push(of_run[leg.run].clone());
            }
        }
        Self {
            series,
            of_run,
            is_free: section.free_scale,
        }
    }

    /// Returns the factor of a fitted leg.
    pub fn of(&self, leg: &Leg, scales: &[f64]) -> f64 {
        let name = &self.of_run[leg.run];
        let place = self.series.iter().position(|series| series == name);
        place.map_or(1.0, |place| scales[place])
    }

    /// Returns the mean result of each series, the start of the search.
    pub fn means(&self, fitted: &[&Leg]) -> Vec<f64> {
        let mean = |name: &String| {
            let own = fitted.iter().filter(|leg| self.of_run[leg.run] == *name);
            let ways: Vec<f64> = own.map(|leg| leg.along).collect();
            ways.iter().sum::<f64>() / ways.len() as f64
        };
        self.series.iter().map(mean).collect()
    }
}

/// All legs with their simulated results.
pub(super) struct SimulatedLegs<'a> {
    rows: Vec<Row<'a>>,
    pub first_scale: f64,
}

struct Row<'a> {
    leg: &'a Leg,
    made: MeanOverPhases,
    scale: f64,
    is_held_out: bool,
}

impl<'a> SimulatedLegs<'a> {
    pub fn new(
        study: &Study,
        legs: &'a [Leg],
        made: &[Option<MeanOverPhases>],
        scales: &Scales,
        values: &[f64],
    ) -> Self {
        let mut rows: Vec<Row<'a>> = legs
            .iter()
            .filter_map(|leg| {
                Some(Row {
                    made: made[leg.drive].clone()?,
                    scale: scales.of(leg, values),
                    is_held_out: study.file.runs[leg.run].held_out,
                    leg,
                })
            })
            .collect();
        // A series without fitted runs has its own factor too: least squares on its distances.
        if scales.is_free {
            for run in 0..scales.of_run.len() {
                let name = &scales.of_run[run];
                if scales.series.contains(name) {
                    continue;
                }
                let is_of = |row: &Row<'_>| scales.of_run[row.leg.run] == *name;
                let (above, below) =
                    rows.iter()
                        .filter(|row| is_of(row))
                        .fold((0.0, 0.0), |(above, below), row| {
                            let weight = row.leg.error.powi(-2);
                            (
                                above + weight * row.leg.along * row.made.mean.along,
                                below + weight * row.made.mean.along.powi(2),
                            )
                        });
                for row in rows.iter_mut().filter(|row| is_of(row)) {
                    row.scale = above / below;
                }
            }
        }
        Self {
            rows,
            first_scale: values.first().copied().unwrap_or(1.0),
        }
    }

    /// Returns root mean square residuals over fitted or held-out drives.
    pub fn misses(&self, held_out: bool) -> Misses {
        let rows = || self.rows.iter().filter(|row| row.is_held_out == held_out);
        let ways = rows().map(|row| row.leg.along / row.scale - row.made.mean.along);
        let drifts = rows().map(|row| row.leg.drift_rad_per_m[0] - row.made.mean.drift_rad_per_m);
        let torques = rows().flat_map(|row| {
            let seen = row.leg.torques_n_m.iter().zip(&row.made.mean.torques_n_m);
            seen.filter_map(|(seen, made)| Some(seen.as_ref()?[0] - made))
        });
        Misses {
            ratio: rms(ways),
            drift_rad_per_m: rms(drifts),
            torque_n_m: rms(torques),
        }
    }

    /// Returns the comparison of each drive.
    pub fn drives(
        &self,
        study: &Study,
        drives: &[Course],
        nominal: &Matrix3xX<f64>,
    ) -> Vec<SteadyDrive> {
        self.rows
            .iter()
            .map(|row| SteadyDrive {
                file: study.file.runs[row.leg.run].file.display().to_string(),
                held_out: row.is_held_out,
                direction_deg: direction_deg(nominal, &drives[row.leg.drive].rates_rad_s),
                measured: row.leg.along / row.scale,
                measured_error: row.leg.error / row.scale,
                simulated: row.made.mean.along,
                simulated_scatter: row.made.scatter(),
                measured_across: row.leg.across / row.scale,
                simulated_across: row.made.mean.across,
                measured_drift_rad_per_m: row.leg.drift_rad_per_m[0],
                measured_drift_error_rad_per_m: row.leg.drift_rad_per_m[1],
                simulated_drift_rad_per_m: row.made.mean.drift_rad_per_m,
                torques: self.torques(study, row),
                ripple: row.leg.ripple.map(|ripple| DriveRipple {
                    stretches: ripple.stretches,
                    rollers_counted: ripple.line,
                    wheels_rad_s: ripple.wheels_rad_s[0],
                    wheels_error_rad_s: ripple.wheels_rad_s[1],
                    wheels_simulated_rad_s: row.made.mean.wheels_rad_s,
                    body_m: ripple.body_m[0],
                    body_error_m: ripple.body_m[1],
                    body_simulated_m: row.made.mean.body_m,
                }),
            })
            .collect()
    }

    /// Returns the torques of the wheels that turn in a drive.
    fn torques(&self, study: &Study, row: &Row<'_>) -> Vec<DriveTorque> {
        let wheels = study.robot.wheels.iter().zip(&row.leg.torques_n_m);
        wheels
            .zip(&row.made.mean.torques_n_m)
            .filter_map(|((wheel, seen), made)| {
                let [measured_n_m, measured_error_n_m] = (*seen)?;
                Some(DriveTorque {
                    wheel: wheel.name.clone(),
                    measured_n_m,
                    measured_error_n_m,
                    simulated_n_m: *made,
                })
            })
            .collect()
    }

    /// Returns the result of each drive with other values of keys.
    pub fn others(&self) -> Vec<OtherDrive> {
        self.rows
            .iter()
            .map(|row| OtherDrive {
                simulated: row.made.mean.along,
                simulated_across: row.made.mean.across,
                simulated_drift_rad_per_m: row.made.mean.drift_rad_per_m,
                simulated_torques_n_m: row.made.mean.torques_n_m.clone(),
            })
            .collect()
    }

    /// Returns the ratio of sideways to ahead motion of each series that drove both ways.
    pub fn series(
        &self,
        study: &Study,
        drives: &[Course],
        nominal: &Matrix3xX<f64>,
    ) -> Vec<SimulatedSeries> {
        let mut found: Vec<SimulatedSeries> = Vec::new();
        for run in &study.file.runs {
            if found.iter().any(|series| series.name == run.series) {
                continue;
            }
            let mean = |deg: f64| -> Option<[f64; 3]> {
                let rows: Vec<&Row<'_>> = self
                    .rows
                    .iter()
                    .filter(|row| {
                        let way = direction_deg(nominal, &drives[row.leg.drive].rates_rad_s);
                        let apart = (way - deg).rem_euclid(180.0);
                        study.file.runs[row.leg.run].series == run.series
                            && apart.min(180.0 - apart) < CLOSE_DEG
                    })
                    .collect();
                let count = rows.len() as f64;
                let sum =
                    |of: &dyn Fn(&Row<'_>) -> f64| rows.iter().map(|row| of(row)).sum::<f64>();
                (count > 0.0).then(|| {
                    [
                        sum(&|row| row.leg.along) / count,
                        sum(&|row| row.leg.error.powi(2)).sqrt() / count,
                        sum(&|row| row.made.mean.along) / count,
                    ]
                })
            };
            if let (Some(ahead), Some(sideways)) = (mean(0.0), mean(90.0)) {
                let measured = sideways[0] / ahead[0];
                let half =
                    1.96 * measured * libm::hypot(sideways[1] / sideways[0], ahead[1] / ahead[0]);
                let interval = Interval::around(measured, half);
                found.push(SimulatedSeries {
                    name: run.series.clone(),
                    held_out: run.held_out,
                    sideways_over_ahead: Value::new(measured, interval, "", 1.0),
                    simulated: sideways[2] / ahead[2],
                });
            }
        }
        found
    }
}

/// Returns the root mean square; `None` for no values.
fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let squares: Vec<f64> = values.map(|value| value * value).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (!squares.is_empty()).then(|| mean.sqrt())
}

/// Returns the direction in the body frame in which wheel rates drive the robot, in degrees.
fn direction_deg(nominal: &Matrix3xX<f64>, rates: &[f64]) -> f64 {
    let asked = twist_of(nominal, rates);
    libm::atan2(asked[1], asked[0])
        .to_degrees()
        .rem_euclid(360.0)
}
