//! Uneven ground in a running world: finds its triangles near something.
//!
//! Each cell is two triangles, which share the line from its corner at the smallest x and y to the
//! opposite one, as in parry. A wheel is over dozens of them and near to a few: cells are skipped
//! by their highest point, and blocks of cells by theirs.

use nalgebra::{Vector2, Vector3};

use super::Relief;
use crate::contact::search::bounds::Bounds;
use crate::contact::search::nearest::Triangle;

/// Cells along a side of a block. Chosen.
const BLOCK: usize = 8;

/// Uneven ground with upper bounds of its parts.
pub(crate) struct HeightField {
    cell_m: f64,
    /// Its corner at the smallest x and y, in metres.
    corner_m: Vector2<f64>,
    /// The number of cells along x and along y.
    cells: [usize; 2],
    /// Heights of its points, row by row from -y to +y, in metres.
    heights_m: Vec<f64>,
    /// The highest point of each block of cells, row by row, in metres.
    blocks_m: Vec<f64>,
    /// Its lowest point, in metres.
    lowest_m: f64,
}

/// Ranges of cells along x and along y.
type Cells = [std::ops::Range<usize>; 2];

impl HeightField {
    /// From a relief that was checked.
    pub fn of(relief: &Relief) -> Self {
        let cells = relief.points().map(|points| points - 1);
        let heights_m: Vec<f64> = relief.heights_m.iter().flatten().copied().collect();
        let mut field = Self {
            cell_m: relief.cell_m,
            corner_m: relief.corner_m(),
            cells,
            lowest_m: heights_m.iter().copied().fold(f64::INFINITY, f64::min),
            heights_m,
            blocks_m: Vec::new(),
        };
        let [columns, rows] = cells.map(|cells| cells.div_ceil(BLOCK));
        field.blocks_m = (0..rows * columns)
            .map(|block| field.highest_of_block_m([block % columns, block / columns]))
            .collect();
        field
    }

    fn highest_of_block_m(&self, block: [usize; 2]) -> f64 {
        let [columns, rows] = [0, 1].map(|axis| {
            let from = block[axis] * BLOCK;
            from..=(from + BLOCK).min(self.cells[axis])
        });
        let rows = rows.map(|row| &self.heights_m[row * (self.cells[0] + 1)..]);
        let heights = rows.flat_map(|row| &row[columns.clone()]);
        heights.copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The point of a column and a row, in metres.
    fn point_m(&self, column: usize, row: usize) -> Vector3<f64> {
        let at_m = self.corner_m + self.cell_m * Vector2::new(column as f64, row as f64);
        at_m.push(self.heights_m[row * (self.cells[0] + 1) + column])
    }

    /// The cells beneath and above a box.
    fn cells_in(&self, bounds: &Bounds) -> Cells {
        [0, 1].map(|axis| {
            let cell = |at_m: f64| (at_m - self.corner_m[axis]) / self.cell_m;
            // Negative numbers become 0.
            let from = cell(bounds.least_m[axis]).floor() as usize;
            let to = cell(bounds.most_m[axis]).ceil() as usize;
            from..to.min(self.cells[axis])
        })
    }

    /// Passes the cells that reach up to the lower side of a box to `is_enough`, until it returns
    /// true: columns from -x to +x, each from +y to -y.
    fn find_cells(&self, bounds: &Bounds, mut is_enough: impl FnMut(usize, usize) -> bool) {
        if bounds.most_m.z < self.lowest_m {
            return;
        }
        let floor_m = bounds.least_m.z;
        let points = self.cells[0] + 1;
        let blocks = self.cells[0].div_ceil(BLOCK);
        let [columns, rows] = self.cells_in(bounds);
        for column in columns {
            let mut row = rows.end;
            while row > rows.start {
                row -= 1;
                if self.blocks_m[row / BLOCK * blocks + column / BLOCK] < floor_m {
                    // All other rows of the block are lower too.
                    row -= row % BLOCK;
                    continue;
                }
                let at = row * points + column;
                let below = &self.heights_m[at..];
                let highest_m = below[0]
                    .max(below[1])
                    .max(below[points])
                    .max(below[points + 1]);
                if highest_m >= floor_m && is_enough(column, row) {
                    return;
                }
            }
        }
    }

    /// Whether it may reach into a box.
    pub fn reaches(&self, bounds: &Bounds) -> bool {
        let mut found = false;
        self.find_cells(bounds, |_, _| {
            found = true;
            true
        });
        found
    }

    /// An upper bound of its height beneath and above a box, in metres; minus infinity if there is
    /// none.
    pub fn ceiling_m(&self, bounds: &Bounds) -> f64 {
        let blocks = self.cells[0].div_ceil(BLOCK);
        let [columns, rows] = self.cells_in(bounds).map(|cells| {
            let is_some = cells.start < cells.end;
            cells.start / BLOCK..if is_some {
                cells.end.div_ceil(BLOCK)
            } else {
                0
            }
        });
        let heights_m = rows.flat_map(|row| {
            let columns = columns.clone();
            columns.map(move |column| self.blocks_m[row * blocks + column])
        });
        heights_m.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Passes the triangles that may reach into a box to `show`.
    pub fn triangles_in(&self, bounds: &Bounds, mut show: impl FnMut(Triangle)) {
        self.find_cells(bounds, |column, row| {
            let corner = |right: usize, up: usize| self.point_m(column + right, row + up);
            let (from, to) = (corner(0, 0), corner(1, 1));
            let halves = [[corner(0, 1), from, to], [from, corner(1, 0), to]];
            for (corners_m, has_ridge) in halves.into_iter().zip(self.ridges(column, row)) {
                if let Some(triangle) = Triangle::new(corners_m, &Vector3::z()) {
                    show(triangle.with_ridge(has_ridge));
                }
            }
            false
        });
    }

    /// Whether something can touch the edges of a cell's upper left triangle, and of its lower
    /// right one: there the surface ends, or a neighbour's corner is lower than the triangle's
    /// plane.
    fn ridges(&self, column: usize, row: usize) -> [bool; 2] {
        /// Differences below this are not bends, in metres. Chosen.
        const FLAT_M: f64 = 1e-12;
        let [columns, rows] = self.cells;
        if column == 0 || row == 0 || column + 1 == columns || row + 1 == rows {
            return [true; 2];
        }
        // From the point before the cell's first.
        let from = (row - 1) * (columns + 1) + column - 1;
        let z = |right: usize, up: usize| self.heights_m[from + up * (columns + 1) + right];
        let falls = |corner_m: f64, plane_m: f64| corner_m < plane_m - FLAT_M;
        let (z_00, z_10, z_01, z_11) = (z(1, 1), z(2, 1), z(1, 2), z(2, 2));
        let (along_x, along_y) = (z_11 - z_01, z_01 - z_00);
        let upper = falls(z(0, 1), z_00 - along_x)
            || falls(z(2, 3), z_11 + along_y)
            || falls(z_10, z_00 + along_x);
        let (along_x, along_y) = (z_10 - z_00, z_11 - z_10);
        let lower = falls(z(1, 0), z_00 - along_y)
            || falls(z(3, 2), z_11 + along_x)
            || falls(z_01, z_00 + along_y);
        [upper, lower]
    }

    /// The distance of a body, with a box around it, from the uneven ground, in metres, given its
    /// distance from a triangle; infinity if it is infinite for all. `gap_m` may return infinity
    /// for triangles beyond the given distance.
    pub fn gap_m(&self, bounds: &Bounds, gap_m: impl Fn(&Triangle, f64) -> f64) -> f64 {
        let mut within_m = self.cell_m;
        loop {
            let around = bounds.grown(within_m);
            let mut least_m = f64::INFINITY;
            self.triangles_in(&around, |triangle| {
                least_m = least_m.min(gap_m(&triangle, least_m));
            });
            if least_m <= within_m || self.lies_in(&around) {
                return least_m;
            }
            within_m *= 2.0;
        }
    }

    /// Whether no triangle is outside a box.
    fn lies_in(&self, bounds: &Bounds) -> bool {
        let [columns, rows] = self.cells;
        let far_m = self.corner_m + self.cell_m * Vector2::new(columns as f64, rows as f64);
        bounds.least_m.z <= self.lowest_m
            && (0..2).all(|axis| {
                bounds.least_m[axis] <= self.corner_m[axis] && bounds.most_m[axis] >= far_m[axis]
            })
    }

    /// Its height at a point of the plane, in metres; `None` beside it.
    pub fn height_m(&self, at_m: &Vector2<f64>) -> Option<f64> {
        let off = (at_m - self.corner_m) / self.cell_m;
        let is_on = |axis: usize| (0.0..=self.cells[axis] as f64).contains(&off[axis]);
        if !(is_on(0) && is_on(1)) {
            return None;
        }
        let [column, row] = [0, 1].map(|axis| (off[axis] as usize).min(self.cells[axis] - 1));
        let (right, up) = (off.x - column as f64, off.y - row as f64);
        let z = |right: usize, up: usize| self.point_m(column + right, row + up).z;
        let middle = if up > right { z(0, 1) } else { z(1, 0) };
        let (first, last) = (right.max(up), right.min(up));
        Some(z(0, 0) + first * (middle - z(0, 0)) + last * (z(1, 1) - middle))
    }

    /// Its lowest point, in metres.
    pub fn lowest_m(&self) -> f64 {
        self.lowest_m
    }
}

#[cfg(test)]
mod tests {
    use ilon_robot::Barrel;

    use super::*;
    use crate::contact::search::nearest::{Piece, PlacedBarrel};

    /// Over each of the two triangles of a cell the height is that of the triangle's plane; beside
    /// the grid there is none.
    #[test]
    fn heights_are_those_of_the_triangles() {
        let field = HeightField::of(&Relief {
            cell_m: 0.5,
            center_m: Vector2::new(1.0, -2.0),
            heights_m: vec![vec![0.0, 1.0, 3.0], vec![2.0, 7.0, 4.0]],
        });
        // Its corner is at (0.5, -2.25).
        let at = |x: f64, y: f64| field.height_m(&Vector2::new(0.5 + 0.5 * x, -2.25 + 0.5 * y));
        assert_eq!(at(0.0, 0.0), Some(0.0));
        assert_eq!(at(2.0, 1.0), Some(4.0));
        // By hand: 0 + 0.5 (2 - 0) + 0.25 (7 - 2), and 1 + 0.75 (3 - 1) + 0.5 (4 - 3).
        assert_eq!(at(0.25, 0.5), Some(2.25));
        assert_eq!(at(1.75, 0.5), Some(3.0));
        assert_eq!(at(-0.01, 0.5), None);
        assert_eq!(at(1.0, 1.01), None);
    }

    /// Random numbers from 0 to 1, by a multiplicative generator (Lehmer 1951).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0 * 48_271 % 0x7fff_ffff;
            self.0 as f64 / f64::from(0x7fff_ffff)
        }
    }

    /// Heights up to 10 mm in cells of 20 mm; one half is level, and in the other half a block of
    /// level cells is beside an uneven one.
    fn field(numbers: &mut Numbers) -> HeightField {
        let mut height_m = |row, column| {
            if column < 12 || (BLOCK..=2 * BLOCK).contains(&row) {
                0.0
            } else {
                0.01 * numbers.next()
            }
        };
        HeightField::of(&Relief {
            cell_m: 0.02,
            center_m: Vector2::new(0.1, -0.3),
            heights_m: (0..19)
                .map(|row| (0..25).map(|column| height_m(row, column)).collect())
                .collect(),
        })
    }

    fn triangles(field: &HeightField, bounds: &Bounds) -> Vec<Triangle> {
        let mut found = Vec::new();
        field.triangles_in(bounds, |triangle| found.push(triangle));
        found
    }

    /// All of its triangles, with touchable edges.
    fn all(field: &HeightField) -> Vec<Triangle> {
        let found = triangles(field, &Bounds::of_ball(&Vector3::zeros(), 10.0));
        assert_eq!(found.len(), 2 * 24 * 18);
        found.into_iter().map(|one| one.with_ridge(true)).collect()
    }

    #[test]
    fn what_reaches_into_a_box_is_found() {
        let mut numbers = Numbers(1973);
        let field = field(&mut numbers);
        let all = all(&field);
        let mut empty = 0;
        for _ in 0..2000 {
            let mut at = |from: f64, to: f64| from + (to - from) * numbers.next();
            let center_m = Vector3::new(at(-0.3, 0.5), at(-0.6, 0.0), at(-0.01, 0.03));
            let bounds = Bounds::of_ball(&center_m, at(0.0, 0.05));
            let around = |one: &Triangle| {
                let corners = one.corners_m().into_iter();
                corners.fold(Bounds::NONE, |around, corner_m| {
                    around.merged(&Bounds::of_ball(&corner_m, 0.0))
                })
            };
            let expected: Vec<_> = (all.iter())
                .filter(|one| around(one).meets(&bounds))
                .map(Triangle::corners_m)
                .collect();
            let found = triangles(&field, &bounds);
            let found: Vec<_> = found.iter().map(Triangle::corners_m).collect();
            assert!(expected.iter().all(|corners| found.contains(corners)));
            assert!(field.reaches(&bounds) || expected.is_empty());
            let corners = found.iter().flatten();
            let highest_m = corners
                .map(|corner_m| corner_m.z)
                .fold(f64::NEG_INFINITY, f64::max);
            assert!(field.ceiling_m(&bounds) >= highest_m);
            empty += usize::from(found.is_empty());
        }
        // Most boxes are above it or beside it, and cost nothing.
        assert!(empty > 500, "{empty}");
    }

    /// The nearest point of a roller is found on the triangles near it, and on the touchable edges:
    /// as near as on all triangles.
    #[test]
    fn the_nearest_place_is_that_of_the_whole_surface() {
        let mut numbers = Numbers(1972);
        let field = field(&mut numbers);
        let all = all(&field);
        let barrel = Barrel::handing_over(0.05, 0.012, std::f64::consts::FRAC_PI_4, 9);
        let mut near = 0;
        for _ in 0..300 {
            let mut at = |from: f64, to: f64| from + (to - from) * numbers.next();
            let placed = PlacedBarrel {
                barrel: &barrel,
                center_m: Vector3::new(at(-0.1, 0.3), at(-0.4, -0.2), at(0.012, 0.025)),
                axis: Vector3::new(at(-1.0, 1.0), at(-1.0, 1.0), at(-0.2, 0.2)).normalize(),
            };
            let gaps = all
                .iter()
                .map(|one| placed.nearest_to(&Piece::Triangle(*one)).gap_m);
            let expected_m = gaps.fold(f64::INFINITY, f64::min);
            let found_m = field.gap_m(&placed.bounds(), |one, within_m| {
                let nearest = placed.nearest_within(&Piece::Triangle(*one), within_m);
                nearest.map_or(f64::INFINITY, |nearest| nearest.gap_m)
            });
            // Inside the ground, the depth depends on the triangle.
            if expected_m > 0.0 {
                near += 1;
                // The accuracy of the search along the roller, at a flat minimum.
                assert!(
                    (found_m - expected_m).abs() < 1e-12,
                    "{found_m} {expected_m}"
                );
            }
        }
        assert!(near > 100, "{near}");
    }

    /// A tilted plane that is bent down along a line of its points has touchable edges only along
    /// that line, on both sides.
    #[test]
    fn only_where_it_bends_down_can_edges_be_touched() {
        let bends = [
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 0.0],
            [-1.0, 0.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        let leans = [[0.3, 0.2], [0.3, -0.2], [-0.3, 0.2], [-0.3, -0.2]];
        for (bend, lean) in bends
            .into_iter()
            .flat_map(|bend| leans.map(|lean| (bend, lean)))
        {
            // Points from -3 to 3 each way, in metres.
            let off = |column: usize, row: usize| {
                bend[0] * (column as f64 - 3.0) + bend[1] * (row as f64 - 3.0)
            };
            let height_m = |column: usize, row: usize| {
                lean[0] * column as f64 + lean[1] * row as f64 - off(column, row).max(0.0)
            };
            let field = HeightField::of(&Relief {
                cell_m: 1.0,
                center_m: Vector2::zeros(),
                heights_m: (0..7)
                    .map(|row| (0..7).map(|column| height_m(column, row)).collect())
                    .collect(),
            });
            for (column, row) in (1..5).flat_map(|column| (1..5).map(move |row| (column, row))) {
                let lies_along = |corners: [[usize; 2]; 3]| {
                    let on_line = corners.map(|[right, up]| off(column + right, row + up) == 0.0);
                    on_line.into_iter().filter(|on_line| *on_line).count() == 2
                };
                let halves = [[[0, 1], [0, 0], [1, 1]], [[0, 0], [1, 0], [1, 1]]];
                let expected = halves.map(lies_along);
                assert_eq!(
                    field.ridges(column, row),
                    expected,
                    "{bend:?} {lean:?} {column} {row}"
                );
            }
        }
    }
}
