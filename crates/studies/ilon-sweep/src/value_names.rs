//! Short, distinct names of an axis's values: for tables, which are long and similar, only the
//! differences.

use toml::{Table, Value};

use crate::axis::text_of;

/// Returns distinct names of all values of an axis. A table is named by the keys and values that
/// only it has; a file by its name without folders.
pub(crate) fn names(values: &[Value]) -> Vec<String> {
    let tables: Option<Vec<&Table>> = values.iter().map(Value::as_table).collect();
    let Some(tables) = tables else {
        return values.iter().map(text_of).collect();
    };
    for with_path in [false, true] {
        let name = |own: &&Table| {
            let mut parts = Vec::new();
            differences(own, &tables, (with_path, ""), &mut parts);
            if parts.is_empty() {
                parts = tables.iter().flat_map(|other| lacks(own, other)).collect();
            }
            keep_first(&mut parts);
            parts.join(" and ")
        };
        let names: Vec<String> = tables.iter().map(name).collect();
        let is_only =
            |(place, name): (usize, &String)| !name.is_empty() && !names[..place].contains(name);
        if names.iter().enumerate().all(is_only) {
            return names;
        }
    }
    values.iter().map(text_of).collect()
}

/// Returns what only this table has, or what differs from some of all.
fn differences(
    own: &Table,
    all: &[&Table],
    (with_path, path): (bool, &str),
    parts: &mut Vec<String>,
) {
    for (key, value) in own {
        let theirs: Vec<&Value> = all.iter().filter_map(|table| table.get(key)).collect();
        if theirs.len() == all.len() && theirs.iter().all(|other| *other == value) {
            continue;
        }
        let full = format!("{path}{key}");
        let tables: Option<Vec<&Table>> = theirs.iter().map(|other| other.as_table()).collect();
        match (value, tables) {
            (Value::Table(table), Some(tables)) if tables.len() > 1 => {
                differences(table, &tables, (with_path, &format!("{full}.")), parts);
            }
            (Value::Table(_), _) => parts.push(full),
            (Value::String(file), _) if key == "file" && !with_path => {
                let name = file.rsplit('/').next().unwrap_or(file);
                parts.push(name.to_owned());
            }
            _ if with_path => parts.push(format!("{full} {}", text_of(value))),
            _ => parts.push(format!("{key} {}", text_of(value))),
        }
    }
}

/// Returns what another table has and this one lacks.
fn lacks<'t>(own: &'t Table, other: &'t Table) -> impl Iterator<Item = String> + 't {
    let missing = other.keys().filter(|key| !own.contains_key(*key));
    missing.map(|key| format!("without {key}"))
}

/// Removes repeated parts: four equal springs are named once.
fn keep_first(parts: &mut Vec<String>) {
    let mut said: Vec<String> = Vec::new();
    parts.retain(|part| {
        let is_new = !said.contains(part);
        said.push(part.clone());
        is_new
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_case::test_case;

    #[test_case(r#"[{ file = "a/one.urdf", wheels = { rollers = 9 } }, { file = "b/two.urdf", wheels = { rollers = 9 } }, { file = "a/one.urdf", wheels = { rollers = 9 }, joints = { lift = { target_m = 0.1 } } }]"#,
        &["one.urdf", "two.urdf", "one.urdf and joints"]; "by file, and by what only one has")]
    #[test_case("[{ left = { stiffness_n_m = 2000, damping_n_s_m = 20 }, right = { stiffness_n_m = 2000, damping_n_s_m = 20 } }, { left = { stiffness_n_m = 4000, damping_n_s_m = 20 }, right = { stiffness_n_m = 4000, damping_n_s_m = 20 } }]",
        &["stiffness_n_m 2000", "stiffness_n_m 4000"]; "what is alike is said once")]
    #[test_case("[{ a = { x = 1 }, b = { x = 2 } }, { a = { x = 2 }, b = { x = 1 } }, { a = { x = 1 }, b = { x = 1 } }, { a = { x = 2 }, b = { x = 2 } }]",
        &["x 1 and x 2", "x 2 and x 1", "x 1", "x 2"]; "in another order")]
    #[test_case("[{ a = { x = 1 }, b = { x = 2 } }, { a = { x = 1, y = 1 }, b = { x = 2, y = 1 } }]",
        &["{ a = { x = 1 }, b = { x = 2 } }", "{ a = { x = 1, y = 1 }, b = { x = 2, y = 1 } }"]; "whole where nothing else tells them apart")]
    #[test_case("[{}, { push = { impulse_y_n_s = 40 } }]", &["without push", "push"]; "one that has nothing")]
    #[test_case(r#"["B", 2, [1, 2]]"#, &["B", "2", "[1, 2]"]; "what is no table")]
    fn values_are_called_by_what_tells_them_apart(values: &str, names: &[&str]) {
        let document: Table = toml::from_str(&format!("values = {values}")).unwrap();
        let values = document["values"].as_array().unwrap();
        assert_eq!(super::names(values), names);
    }
}
