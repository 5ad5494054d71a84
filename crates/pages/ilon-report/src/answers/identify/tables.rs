//! Tables with the figures behind the sentences.

use crate::page::Table;
use crate::sweep::figure as number;
use ilon_identify::Identified;
use ilon_identify::outcome::{
    Direction, DriveRipple, DriveTorque, Judged, Misses, Run, SimulatedSeries, Simulation,
    SteadyDrive, Value,
};

/// A column of a table: its heading, and its cell for one row.
type Column<'c, T> = (&'c str, &'c dyn Fn(&T) -> String);

/// Returns a table with one row per item.
fn table_of<T>(
    title: &str,
    columns: &[Column<'_, T>],
    things: impl IntoIterator<Item = T>,
) -> Table {
    let row = |thing: T| columns.iter().map(|(_, cell)| cell(&thing)).collect();
    Table {
        title: title.to_owned(),
        head: columns
            .iter()
            .map(|(heading, _)| (*heading).to_owned())
            .collect(),
        rows: things.into_iter().map(row).collect(),
    }
}

/// Returns a number with four decimals.
fn fine(value: f64) -> String {
    format!("{value:.4}")
}

fn known(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), fine)
}

/// Returns a number in thousandths of its unit.
fn milli(value: f64) -> String {
    number(1e3 * value)
}

/// Returns whether a run was held out.
fn whether(held_out: bool) -> String {
    if held_out { "unseen" } else { "fitted" }.to_owned()
}

/// Returns all tables, in the order of the page.
pub fn tables(found: &Identified) -> Vec<Table> {
    let mut tables = vec![
        parameters(found),
        series(found),
        directions(&found.residual),
    ];
    tables.extend(found.simulation.iter().flat_map(of_simulation));
    tables.extend([errors(found)]);
    tables.extend(of_models(found));
    tables.push(runs(found));
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Returns the tables of the fit by simulation.
pub fn of_simulation(simulation: &Simulation) -> Vec<Table> {
    vec![
        misses(simulation),
        simulated_series(&simulation.series),
        ripple(simulation),
        torques(simulation),
        drives(simulation),
    ]
}

/// Returns a table of values by name.
fn values<'v>(title: &str, values: impl Iterator<Item = (String, &'v Value)>) -> Table {
    let end = |end: Option<f64>| end.map_or("?".to_owned(), number);
    table_of::<(String, &Value)>(
        title,
        &[
            ("name", &|(name, _)| name.clone()),
            ("value", &|(_, value)| {
                ilon_trace::significant(value.value, 5).to_string()
            }),
            ("from", &|(_, value)| end(value.ci95[0])),
            ("to", &|(_, value)| end(value.ci95[1])),
            ("unit", &|(_, value)| value.unit.clone()),
            ("before", &|(_, value)| number(value.nominal)),
        ],
        values,
    )
}

/// Returns the table of fitted values.
pub fn parameters(found: &Identified) -> Table {
    let all = found.parameters.iter().chain(&found.derived);
    values("Parameters", all.map(|(name, value)| (name.clone(), value)))
}

/// Returns the table of results for each of several series.
pub fn series(found: &Identified) -> Table {
    let several = found.series.iter().filter(|_| found.series.len() > 1);
    let gains = several.flat_map(|series| {
        let gains = series.gains.iter();
        gains.map(|(gain, value)| (format!("{}: {gain}", series.name), value))
    });
    values("Each series by itself", gains)
}

/// Returns the table of directions of motion.
pub fn directions(directions: &[Direction]) -> Table {
    table_of::<&Direction>(
        "By direction",
        &[
            ("degrees", &|d| format!("{:.1}", d.direction_deg)),
            ("m/s", &|d| number(d.speed_m_s)),
            ("stretches", &|d| d.stretches.to_string()),
            ("measured", &|d| fine(d.measured)),
            ("standard error", &|d| fine(d.measured_error)),
            ("contact", &|d| known(d.contact)),
            ("fitted", &|d| fine(d.fitted)),
            ("simulated", &|d| known(d.simulated)),
            ("measured across", &|d| fine(d.measured_across)),
            ("fitted across", &|d| fine(d.fitted_across)),
            ("drift left, rad/m", &|d| number(d.drift_rad_per_m)),
        ],
        directions,
    )
}

/// Returns the table of errors of each model.
pub fn errors(found: &Identified) -> Table {
    table_of::<&Judged>(
        "Errors",
        &[
            ("model", &|model| model.name.clone()),
            ("parameters", &|model| model.parameters.len().to_string()),
            ("fitted, mm", &|model| milli(model.fit.position_rms_m)),
            ("over noise", &|model| number(model.fit.over_noise)),
            ("not fitted, mm", &|model| {
                milli(model.held_out.position_rms_m)
            }),
            ("mrad", &|model| milli(model.held_out.heading_rms_rad)),
            ("over noise", &|model| number(model.held_out.over_noise)),
            ("end of a run, mm", &|model| {
                milli(model.held_out.end_position_rms_m)
            }),
        ],
        &found.models,
    )
}

/// Returns the tables of values of each model.
pub fn of_models(found: &Identified) -> Vec<Table> {
    let of = |model: &Judged| {
        let own = model.parameters.iter();
        values(&model.name, own.map(|(name, value)| (name.clone(), value)))
    };
    found.models.iter().map(of).collect()
}

/// Returns the table of final errors of dead reckoning.
pub fn runs(found: &Identified) -> Table {
    table_of::<&Run>(
        "Ends of runs",
        &[
            ("log", &|run| run.file.clone()),
            ("", &|run| whether(run.held_out)),
            ("s", &|run| number(run.duration_s)),
            ("m", &|run| number(run.path_m)),
            ("nominal robot, mm", &|run| {
                milli(run.end_position_nominal_m)
            }),
            ("off after, mm", &|run| milli(run.end_position_m)),
            ("heading after, mrad", &|run| milli(run.end_heading_rad)),
        ],
        &found.runs,
    )
}

/// Returns the table of residuals of the fitted keys and of other values.
fn misses(simulation: &Simulation) -> Table {
    let found = (
        "with the values found",
        &simulation.fit,
        &simulation.held_out,
    );
    let beside = simulation.beside.iter();
    let beside = beside.map(|one| (one.name.as_str(), &one.fit, &one.held_out));
    let rows = std::iter::once(found).chain(beside);
    table_of::<(&str, bool, &Misses)>(
        "Measured less simulated, root mean square over drives",
        &[
            ("model", &|(name, ..)| (*name).to_owned()),
            ("", &|(_, held_out, _)| whether(*held_out)),
            ("distance", &|(.., misses)| known(misses.ratio)),
            ("drift, rad/m", &|(.., misses)| {
                known(misses.drift_rad_per_m)
            }),
            ("torque, N m", &|(.., misses)| known(misses.torque_n_m)),
        ],
        rows.flat_map(|(name, fit, held_out)| [(name, false, fit), (name, true, held_out)]),
    )
}

fn simulated_series(series: &[SimulatedSeries]) -> Table {
    table_of::<&SimulatedSeries>(
        "Sideways over ahead",
        &[
            ("series", &|series| series.name.clone()),
            ("", &|series| whether(series.held_out)),
            ("measured", &|series| fine(series.sideways_over_ahead.value)),
            ("from", &|series| known(series.sideways_over_ahead.ci95[0])),
            ("to", &|series| known(series.sideways_over_ahead.ci95[1])),
            ("simulated", &|series| fine(series.simulated)),
        ],
        series,
    )
}

fn ripple(simulation: &Simulation) -> Table {
    table_of::<(&SteadyDrive, DriveRipple)>(
        "What wheels (mrad/s) and body (mm) do once a roller: amplitudes",
        &[
            ("log", &|(drive, _)| drive.file.clone()),
            ("", &|(drive, _)| whether(drive.held_out)),
            ("degrees", &|(drive, _)| {
                format!("{:.0}", drive.direction_deg)
            }),
            ("wheels", &|(_, ripple)| milli(ripple.wheels_rad_s)),
            ("standard error", &|(_, ripple)| {
                milli(ripple.wheels_error_rad_s)
            }),
            ("simulated", &|(_, ripple)| {
                milli(ripple.wheels_simulated_rad_s)
            }),
            ("body", &|(_, ripple)| milli(ripple.body_m)),
            ("standard error", &|(_, ripple)| milli(ripple.body_error_m)),
            ("simulated", &|(_, ripple)| milli(ripple.body_simulated_m)),
            ("rollers counted", &|(_, ripple)| {
                format!("{:.3}", ripple.rollers_counted)
            }),
        ],
        (simulation.drives.iter()).filter_map(|drive| Some((drive, drive.ripple?))),
    )
}

fn torques(simulation: &Simulation) -> Table {
    let drives = simulation.drives.iter();
    table_of::<(&SteadyDrive, &DriveTorque)>(
        "Torques of the wheels that turn, in N m",
        &[
            ("log", &|(drive, _)| drive.file.clone()),
            ("", &|(drive, _)| whether(drive.held_out)),
            ("degrees", &|(drive, _)| {
                format!("{:.0}", drive.direction_deg)
            }),
            ("wheel", &|(_, torque)| torque.wheel.clone()),
            ("measured", &|(_, torque)| fine(torque.measured_n_m)),
            ("standard error", &|(_, torque)| {
                fine(torque.measured_error_n_m)
            }),
            ("simulated", &|(_, torque)| fine(torque.simulated_n_m)),
        ],
        drives.flat_map(|drive| drive.torques.iter().map(move |torque| (drive, torque))),
    )
}

fn drives(simulation: &Simulation) -> Table {
    table_of::<&SteadyDrive>(
        "Drives",
        &[
            ("log", &|drive| drive.file.clone()),
            ("", &|drive| whether(drive.held_out)),
            ("degrees", &|drive| format!("{:.1}", drive.direction_deg)),
            ("measured", &|drive| fine(drive.measured)),
            ("standard error", &|drive| fine(drive.measured_error)),
            ("simulated", &|drive| fine(drive.simulated)),
            ("measured across", &|drive| fine(drive.measured_across)),
            ("simulated across", &|drive| fine(drive.simulated_across)),
            ("measured drift, rad/m", &|drive| {
                fine(drive.measured_drift_rad_per_m)
            }),
            ("standard error", &|drive| {
                fine(drive.measured_drift_error_rad_per_m)
            }),
            ("simulated drift", &|drive| {
                fine(drive.simulated_drift_rad_per_m)
            }),
        ],
        &simulation.drives,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each figure stands below its own heading.
    #[test]
    fn a_measured_ratio_stands_before_the_ends_of_its_interval() {
        let table = simulated_series(&[SimulatedSeries {
            name: "carpet".to_owned(),
            held_out: true,
            sideways_over_ahead: Value {
                value: 0.96,
                ci95: [Some(0.95), Some(0.98)],
                unit: String::new(),
                nominal: 1.0,
            },
            simulated: 0.97,
        }]);
        let row = ["carpet", "unseen", "0.9600", "0.9500", "0.9800", "0.9700"];
        let head = ["series", "", "measured", "from", "to", "simulated"];
        assert_eq!(table.head, head);
        assert_eq!(table.rows, [row]);
    }
}
