//! Small dense linear systems.

/// Solves a linear system, given row by row, in place by elimination with row pivots. Returns
/// whether it is regular.
pub(crate) fn solve_in_place(matrix: &mut [f64], x: &mut [f64]) -> bool {
    // The sizes of two to six contacts, as in nearly every step: a loop of known length is several
    // times as fast.
    let is_regular = match x.len() {
        6 => eliminate_square::<6>(matrix, x),
        9 => eliminate_square::<9>(matrix, x),
        12 => eliminate_square::<12>(matrix, x),
        15 => eliminate_square::<15>(matrix, x),
        18 => eliminate_square::<18>(matrix, x),
        _ => eliminate(matrix, x),
    };
    if !is_regular {
        return false;
    }
    let n = x.len();
    for row in (0..n).rev() {
        let (own, known) = x[row..].split_at_mut(1);
        let of_row = &matrix[row * n + row..(row + 1) * n];
        for (entry, x) in of_row[1..].iter().zip(known) {
            own[0] -= entry * *x;
        }
        own[0] /= of_row[0];
    }
    x.iter().all(|x| x.is_finite())
}

/// Eliminates everything below the diagonal. Returns whether the system is regular.
fn eliminate(matrix: &mut [f64], x: &mut [f64]) -> bool {
    let n = x.len();
    for column in 0..n {
        let Some(pivot) = largest(matrix[column * n..].chunks_exact(n), column) else {
            return false;
        };
        let pivot = column + pivot;
        if pivot != column {
            let (above, below) = matrix.split_at_mut(pivot * n);
            above[column * n + column..][..n - column].swap_with_slice(&mut below[column..n]);
            x.swap(pivot, column);
        }
        let (above, below) = matrix.split_at_mut((column + 1) * n);
        let leading = &above[column * n + column..];
        let (first, others) = (leading[0], &leading[1..]);
        let (solved, left) = x.split_at_mut(column + 1);
        for (row, x) in below.chunks_exact_mut(n).zip(left) {
            let share = row[column] / first;
            if share != 0.0 {
                for (own, other) in row[column + 1..].iter_mut().zip(others) {
                    *own -= share * other;
                }
                *x -= share * solved[column];
            }
        }
    }
    true
}

/// The same for a system of N rows, to the bit. The remainders below the diagonal are meaningless.
fn eliminate_square<const N: usize>(matrix: &mut [f64], x: &mut [f64]) -> bool {
    let (rows, _) = matrix.as_chunks_mut::<N>();
    for column in 0..N {
        let Some(pivot) = largest(rows[column..].iter().map(|row| &row[..]), column) else {
            return false;
        };
        rows.swap(column, column + pivot);
        x.swap(column, column + pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let leading = &above[column];
        let (solved, left) = x.split_at_mut(column + 1);
        for (row, x) in below.iter_mut().zip(left) {
            let share = row[column] / leading[column];
            if share != 0.0 {
                for (own, other) in row.iter_mut().zip(leading) {
                    *own -= share * other;
                }
                *x -= share * solved[column];
            }
        }
    }
    true
}

/// Solves a linear system of n rows for several right-hand sides by one elimination with row
/// pivots. Each row of `rows` holds a row of the matrix and then an entry of each right-hand side,
/// which the solutions replace: to the bit those of [`solve_in_place`]. Returns whether it is
/// regular.
pub(crate) fn solve_for_all(rows: &mut [f64], n: usize) -> bool {
    let width = rows.len() / n.max(1);
    for column in 0..n {
        let Some(pivot) = largest(rows[column * width..].chunks_exact(width), column) else {
            return false;
        };
        let pivot = column + pivot;
        if pivot != column {
            let (above, below) = rows.split_at_mut(pivot * width);
            above[column * width..][..width].swap_with_slice(&mut below[..width]);
        }
        let (above, below) = rows.split_at_mut((column + 1) * width);
        let leading = &above[column * width + column..];
        let (first, others) = (leading[0], &leading[1..]);
        for row in below.chunks_exact_mut(width) {
            let share = row[column] / first;
            if share != 0.0 {
                for (own, other) in row[column + 1..].iter_mut().zip(others) {
                    *own -= share * other;
                }
            }
        }
    }
    for row in (0..n).rev() {
        let (above, solved) = rows.split_at_mut((row + 1) * width);
        let (of_matrix, own) = above[row * width..].split_at_mut(n);
        for (entry, known) in of_matrix[row + 1..].iter().zip(solved.chunks_exact(width)) {
            for (x, known) in own.iter_mut().zip(&known[n..]) {
                *x -= entry * known;
            }
        }
        own.iter_mut().for_each(|x| *x /= of_matrix[row]);
    }
    let mut solutions = rows.chunks_exact(width.max(1)).flat_map(|row| &row[n..]);
    solutions.all(|x| x.is_finite())
}

/// Factorises a symmetric matrix of n rows to L L^T, in place: L on and below the diagonal
/// (Cholesky). Returns whether it is positive definite.
pub(crate) fn factorise(matrix: &mut [f64], n: usize) -> bool {
    for row in 0..n {
        let (above, own) = matrix.split_at_mut(row * n);
        for column in 0..row {
            let other = &above[column * n..][..=column];
            let known = dot(&own[..column], other);
            own[column] = (own[column] - known) / other[column];
        }
        let left = own[row] - dot(&own[..row], &own[..row]);
        // NaN is not positive either.
        if !matches!(left.partial_cmp(&0.0), Some(std::cmp::Ordering::Greater)) {
            return false;
        }
        own[row] = left.sqrt();
    }
    true
}

/// Solves a linear system in place with the result of [`factorise`].
pub(crate) fn solve_factorised(factors: &[f64], x: &mut [f64]) {
    let n = x.len();
    for row in 0..n {
        let of_row = &factors[row * n..][..=row];
        x[row] = (x[row] - dot(&of_row[..row], x)) / of_row[row];
    }
    for row in (0..n).rev() {
        let of_row = &factors[row * n..][..=row];
        x[row] /= of_row[row];
        let (others, known) = x.split_at_mut(row);
        for (other, l) in others.iter_mut().zip(of_row) {
            *other -= l * known[0];
        }
    }
}

/// The sum of products over the shorter length.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The row with the largest entry of a column, the last of equals; `None` if all are zero.
fn largest<'r>(rows: impl Iterator<Item = &'r [f64]>, column: usize) -> Option<usize> {
    let (mut place, mut most) = (0, 0);
    for (row, entries) in rows.enumerate() {
        // Bits of numbers without sign have the order of the numbers, with NaN above all.
        let size = entries[column].abs().to_bits();
        if size >= most {
            (place, most) = (row, size);
        }
    }
    (most != 0).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1, always the same.
    fn numbers(count: usize, seed: u32) -> impl Iterator<Item = f64> {
        let mut state = seed;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 23) - 1.0
        })
        .take(count)
    }

    /// Whichever way it is solved: the second column of zeros leaves nothing to divide by.
    #[test]
    fn a_system_with_a_column_of_zeros_is_no_regular_one() {
        let matrix = [2.0, 0.0, 1.0, 0.0];
        assert!(!eliminate(&mut matrix.to_vec(), &mut [1.0, 1.0]));
        assert!(!eliminate_square::<2>(
            &mut matrix.to_vec(),
            &mut [1.0, 1.0]
        ));
        assert!(!solve_for_all(&mut [2.0, 0.0, 1.0, 1.0, 0.0, 1.0], 2));
    }

    /// The loops of known length give the result of the general one, to the bit.
    #[test]
    fn a_square_of_a_known_size_is_eliminated_as_any_other() {
        fn held<const N: usize>() {
            let matrix: Vec<f64> = numbers(N * N, N as u32).collect();
            let x: Vec<f64> = numbers(N, 5).collect();
            let (mut one, mut other) = ((matrix.clone(), x.clone()), (matrix, x));
            assert!(eliminate(&mut one.0, &mut one.1));
            assert!(eliminate_square::<N>(&mut other.0, &mut other.1));
            assert_eq!(one.1, other.1);
            for row in 0..N {
                let from_diagonal = row * N + row..(row + 1) * N;
                assert_eq!(one.0[from_diagonal.clone()], other.0[from_diagonal]);
            }
        }
        held::<6>();
        held::<9>();
        held::<18>();
    }

    #[test]
    fn elimination_solves_and_says_where_there_is_no_solution() {
        for n in [1, 3, 6, 9, 12, 15, 18, 20] {
            let matrix: Vec<f64> = numbers(n * n, 3).collect();
            let x: Vec<f64> = numbers(n, 4).collect();
            let rows = matrix.chunks_exact(n);
            let b = rows.map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum());
            let mut solution: Vec<f64> = b.collect();
            assert!(solve_in_place(&mut matrix.clone(), &mut solution));
            for (found, x) in solution.iter().zip(&x) {
                // Rounding times a condition number of some hundreds.
                assert!((found - x).abs() < 1e-12, "{found} {x}");
            }
        }
        // Two equal rows, a column of zeros, and NaN.
        assert!(!solve_in_place(&mut [1.0, 2.0, 1.0, 2.0], &mut [1.0, 1.0]));
        assert!(!solve_in_place(&mut [0.0, 2.0, 0.0, 1.0], &mut [1.0, 1.0]));
        assert!(!solve_in_place(&mut [f64::NAN], &mut [1.0]));
        assert!(solve_in_place(&mut [], &mut []));
    }

    #[test]
    fn one_elimination_gives_each_solution_to_the_bit() {
        for (n, seed) in [(1, 5), (4, 6), (16, 7)] {
            let matrix: Vec<f64> = numbers(n * n, seed).collect();
            let asked: Vec<f64> = numbers(n * n, seed + 10).collect();
            let rows = matrix.chunks_exact(n).zip(asked.chunks_exact(n));
            let mut both: Vec<f64> = rows.flat_map(|(a, b)| [a, b].concat()).collect();
            assert!(solve_for_all(&mut both, n));
            for column in 0..n {
                let mut x: Vec<f64> = asked[column..].iter().step_by(n).copied().collect();
                assert!(solve_in_place(&mut matrix.clone(), &mut x));
                let solved = both[n + column..].iter().step_by(2 * n);
                assert_eq!(x, solved.copied().collect::<Vec<f64>>());
            }
        }
        assert!(!solve_for_all(&mut [1.0, 2.0, 1.0, 1.0, 2.0, 1.0], 2));
        assert!(!solve_for_all(&mut [f64::NAN, 1.0], 1) && solve_for_all(&mut [], 0));
    }

    /// L L^T of whole numbers is factorised again, and solved for a known product.
    #[test]
    fn a_symmetric_matrix_is_taken_apart_and_solved() {
        let l = [2.0, 0.0, 0.0, -1.0, 3.0, 0.0, 4.0, 0.5, 1.0];
        let entry = |i: usize, j: usize| (0..3).map(|k| l[3 * i + k] * l[3 * j + k]).sum::<f64>();
        let mut matrix: Vec<f64> = (0..9).map(|at| entry(at / 3, at % 3)).collect();
        let sought = [1.0, -2.0, 0.5];
        let mut x = [0, 1, 2].map(|i| (0..3).map(|j| entry(i, j) * sought[j]).sum::<f64>());
        assert!(factorise(&mut matrix, 3));
        solve_factorised(&matrix, &mut x);
        for (at, known) in l.iter().enumerate().filter(|(at, _)| at % 3 <= at / 3) {
            assert!((matrix[at] - known).abs() < 1e-12, "{matrix:?}");
        }
        for (found, sought) in x.iter().zip(sought) {
            assert!((found - sought).abs() < 1e-12, "{x:?}");
        }
        // Not positive, and NaN.
        assert!(!factorise(&mut [1.0, 2.0, 2.0, 1.0], 2) && !factorise(&mut [f64::NAN], 1));
    }
}
