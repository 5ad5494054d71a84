//! How far the figures of a run move at half its step, as text for a terminal.

use ilon_trace::Convergence;
use ilon_trace::convergence::Moved;

use super::table::Table;

/// The option of commands that run scenarios.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct Converge {
    /// Repeat each run at half the step, and report figures that move by more than their stated
    /// accuracy.
    #[arg(long)]
    pub converge: bool,
}

/// A sentence and the figures that moved by more than their stated accuracy; `None` for a run that
/// was not repeated.
pub(super) fn table(convergence: &Convergence) -> Option<Table> {
    if convergence.is_empty() {
        return None;
    }
    let mut table = Table::new();
    table.heading(&convergence.sentence());
    let beyond: Vec<_> = convergence.beyond().collect();
    if beyond.is_empty() {
        return Some(table);
    }
    let names: Vec<String> = beyond
        .iter()
        .map(|(quantity, _)| match quantity.unit.symbol {
            "" => quantity.words(),
            symbol => format!("{}, {symbol}", quantity.words()),
        })
        .collect();
    let heads = ["as it is", "half the step", "half the split", "moves by"];
    table.words("", &heads.map(str::to_owned));
    for (name, (quantity, moved)) in names.iter().zip(beyond) {
        let Moved {
            value,
            half_step,
            half_split,
            share,
            ..
        } = *moved;
        let shown = |value: Option<f64>| match value {
            Some(value) => format!("{:.*}", quantity.decimals, value * quantity.unit.per_si),
            None => "-".to_owned(),
        };
        let mut words = [value, half_step, half_split].map(shown).to_vec();
        words.push(format!("{:.2} %", 100.0 * share));
        table.words(name, &words);
    }
    Some(table)
}
