//! Memory for traces in a page. The command writes long traces to a file while they grow; here they
//! are held in memory.

use ilon_sim::simulate::load_robot;
use ilon_sim::{Error, Scenario};
use ilon_trace::{Record, WheelSample};

/// The largest trace, in bytes; chosen as a quarter of the page's gibibyte, since files made from
/// it need memory too.
const MOST_BYTES: f64 = 256e6;

/// Refuses a scenario whose trace would exceed the memory of a page.
pub(super) fn admit(scenario: &Scenario) -> Result<(), Error> {
    let run = &scenario.run;
    // Its duration is that of a log; it is checked again once the log is read.
    if run.is_open() {
        return Ok(());
    }
    let robot = load_robot(scenario)?;
    let wheels = robot.wheels.len();
    let rollers: usize = robot.wheels.iter().map(|wheel| wheel.rollers.len()).sum();
    let angles = if run.roller_angles_hz.is_some() {
        rollers
    } else {
        0
    };
    let row_bytes =
        size_of::<Record>() + wheels * size_of::<WheelSample>() + angles * size_of::<f64>();
    let bytes = run.row_count() as f64 * row_bytes as f64;
    if bytes <= MOST_BYTES {
        return Ok(());
    }
    let most_s = MOST_BYTES / row_bytes as f64 * run.row_s();
    Err(Error::invalid(
        format!(
            "a run of {} s records more than a page has room for, which is {most_s:.0} s of this robot",
            run.duration_s
        ),
        "make `run.duration_s` smaller or `run.record_every` larger, or run it with the command, which writes its trace to a file",
    ))
}
