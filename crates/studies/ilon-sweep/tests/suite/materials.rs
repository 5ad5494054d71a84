//! Studies over the materials of floor and rollers.

use crate::support;

use ilon_sweep::Status;
use support::{Folder, SCENARIO};

/// Rollers of rubber on concrete, from which the robot drives onto a carpet.
const PAIRS: &str = r#"
[world.floor]
material = "concrete"

[[world.floor.patches]]
x_m = 0.0
y_m = 0.6
length_x_m = 2.0
length_y_m = 1.15
material = "carpet"

[rollers]
material = "rubber"

[materials.rubber.concrete]
friction = 0.8
rolling_resistance = 0.01

[materials.rubber.carpet]
friction = 0.5
rolling_resistance = 0.12
creep = 0.3
sliding = { friction = 0.4, speed_m_s = 0.1 }
across = { creep = 0.5, rolling_resistance = 0.2, friction = 0.6 }
against = { rolling_resistance = 0.15 }
"#;

#[test]
fn studies_vary_pairs_and_the_materials_themselves() {
    let folder = Folder::new();
    folder.write("base.toml", &format!("{SCENARIO}{PAIRS}"));
    let rows = folder.rows(
        "quantities = [\"slip_energy_j\"]\n[axes]\nmaterials.rubber.concrete.creep = [0.0, 0.5]\nworld.floor.material = [\"concrete\", \"carpet\"]\n",
    );
    assert_eq!(rows.len(), 4);
    assert!(
        rows.iter().all(|row| row.status == Status::Done),
        "{rows:?}"
    );
    let hashes: Vec<_> = rows.iter().map(|row| row.trace_hash.clone()).collect();
    // On the carpet the concrete's keys have no effect except for its name.
    let mut different = hashes.clone();
    different.sort();
    different.dedup();
    assert_eq!(different.len(), 3, "{hashes:?}");
}
