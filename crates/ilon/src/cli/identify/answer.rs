//! What an identification found, as a person reads it on a terminal.

use ilon_identify::Identified;
use ilon_identify::plan::Plan;
use ilon_report::sweep::figure as number;

use crate::answers::identify::{answers, tables};
use crate::cli::table::Table;

/// What was found: sentences, the values, and all other figures where they are asked for.
pub(super) fn words(found: &Identified, in_full: bool) -> String {
    let mut text = format!("{}\n", found.study);
    for answer in answers(found) {
        text += &format!("\n{}\n", answer.text);
    }
    let mut table = Table::new();
    match in_full {
        true => tables::tables(found).iter().for_each(|one| table.of(one)),
        false => table.of(&tables::parameters(found)),
    }
    format!("{text}\n{table}")
}

/// A course, and what it determines.
pub(super) fn course(plan: &Plan) -> String {
    let mut table = Table::new();
    table.heading("drive: m/s ahead, m/s to the left, rad/s, seconds");
    for (index, way) in plan.ways.iter().enumerate() {
        let [vx, vy, omega] = way.twist;
        let words = [vx, vy, omega, way.for_s].map(number);
        table.words(&format!("{}", index + 1), &words);
    }
    table.heading(
        "standard error that it leaves, of displacements seen to 1 mm and 1 mrad a second",
    );
    for (name, error) in &plan.errors {
        table.words(name, &[number(*error)]);
    }
    table.to_string()
}
