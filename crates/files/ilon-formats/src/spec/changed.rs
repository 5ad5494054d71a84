//! Changes of a description's keys.

use toml::{Table, Value};

/// Lays one table over another: tables are merged key by key, everything else is replaced. A table
/// whose keys are all indices of a list changes the elements of that list.
pub(super) fn lay_over(below: &mut Table, above: &Table) {
    for (key, value) in above {
        match below.get_mut(key) {
            Some(slot) => lay_value_over(slot, value),
            None => {
                below.insert(key.clone(), value.clone());
            }
        }
    }
}

fn lay_value_over(slot: &mut Value, value: &Value) {
    match (slot, value) {
        (Value::Table(below), Value::Table(above)) => lay_over(below, above),
        (Value::Array(items), Value::Table(above)) if are_indices(above, items.len()) => {
            for (key, value) in above {
                if let Some(item) = key.parse().ok().and_then(|at: usize| items.get_mut(at)) {
                    lay_value_over(item, value);
                }
            }
        }
        (slot, value) => *slot = value.clone(),
    }
}

fn are_indices(table: &Table, count: usize) -> bool {
    let is_index = |key: &String| key.parse::<usize>().is_ok_and(|at| at < count);
    !table.is_empty() && table.keys().all(is_index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(below: &str, above: &str) -> Table {
        let mut below: Table = below.parse().unwrap();
        lay_over(&mut below, &above.parse().unwrap());
        below
    }

    #[test]
    fn keys_are_replaced_and_what_stands_beside_them_stays() {
        let laid = laid("a.b = 1\na.c = 2\nd = [1, 2]", "a.b = 3\nd = [4]");
        assert_eq!(laid, "a.b = 3\na.c = 2\nd = [4]".parse().unwrap());
    }

    #[test]
    fn elements_of_a_list_are_named_by_their_index() {
        let laid = laid("a = [{ x = 1, y = 2 }, { x = 3 }]", "a.1.x = 5\na.0.x = 4");
        let expected = "a = [{ x = 4, y = 2 }, { x = 5 }]".parse().unwrap();
        assert_eq!(laid, expected);
    }
}
