//! The report of a run, made again from its trace: `cargo run --release --example report -- TRACE
//! OUT.html`.

use std::error::Error;
use std::path::PathBuf;

use ilon_trace::{Settings, Summary, Trace};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [trace, out] = arguments.as_slice() else {
        return Err("give a trace and the page to write".into());
    };
    let trace = Trace::read_parquet(trace)?;
    let summary = Summary::of(&trace, &Settings::default());
    ilon_report::write(out, &trace, &summary)?;
    println!("{}", out.display());
    Ok(())
}
