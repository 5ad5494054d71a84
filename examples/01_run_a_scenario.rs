//! Runs a scenario from Rust, and reads its summary and its trace.

fn main() -> Result<(), ilon::Error> {
    let scenario = ilon::Scenario::load("assets/scenarios/volksbot_position_first.toml")?;
    let run = ilon::run(&scenario)?;
    let reached_s = run.summary.position_converged_s;
    println!("under 5 cm from {reached_s:?} s on");
    println!("{} rows in the trace", run.trace.records().len());
    Ok(())
}
