//! Small dense linear systems.

/// Solves a linear system, given row by row, in place by elimination with row pivots. Says whether it is regular.
pub(crate) fn solve_in_place(matrix: &mut [f64], x: &mut [f64]) -> bool {
    let n = x.len();
    for column in 0..n {
        let size = |row: &usize| matrix[row * n + column].abs();
        let Some(pivot) = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))) else {
            return false;
        };
        if matrix[pivot * n + column] == 0.0 {
            return false;
        }
        if pivot != column {
            for k in column..n {
                matrix.swap(pivot * n + k, column * n + k);
            }
            x.swap(pivot, column);
        }
        let (above, below) = matrix.split_at_mut((column + 1) * n);
        let leading = &above[column * n..];
        for (offset, row) in below.chunks_exact_mut(n).enumerate() {
            let share = row[column] / leading[column];
            if share != 0.0 {
                for k in column + 1..n {
                    row[k] -= share * leading[k];
                }
                x[column + 1 + offset] -= share * x[column];
            }
        }
    }
    for row in (0..n).rev() {
        for k in row + 1..n {
            x[row] -= matrix[row * n + k] * x[k];
        }
        x[row] /= matrix[row * n + row];
    }
    x.iter().all(|x| x.is_finite())
}
