//! A relief in a running world: which of its triangles are near something.
//!
//! Each cell is two triangles, which share the line from its corner at the least x and y to the one across it, as in parry. A wheel is over dozens of
//! them and near to a few: cells are passed over by their highest point alone, and blocks of cells by theirs.

use nalgebra::{Vector2, Vector3};

use super::Relief;
use crate::contact::nearest::Triangle;
use crate::contact::solid::Bounds;

/// Cells along a side of a block.
const BLOCK: usize = 8;

/// A relief, and how high its parts reach at most.
pub(crate) struct HeightField {
    cell_m: f64,
    /// Its corner at the least x and y, in metres.
    corner_m: Vector2<f64>,
    /// How many cells there are along x and along y.
    cells: [usize; 2],
    /// Heights of its points, row by row from -y to +y, in metres.
    heights_m: Vec<f64>,
    /// The highest point of each block of cells, row by row, in metres.
    blocks_m: Vec<f64>,
    /// Its lowest point, in metres.
    lowest_m: f64,
}

/// Cells from one to another that is none of them, along x and along y.
type Cells = [std::ops::Range<usize>; 2];

impl HeightField {
    /// Of a relief that was checked.
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
            // A number below 0 becomes 0.
            let from = cell(bounds.least_m[axis]).floor() as usize;
            let to = cell(bounds.most_m[axis]).ceil() as usize;
            from..to.min(self.cells[axis])
        })
    }

    /// Shows the cells that reach up to the lower side of a box, until one is held for enough: columns from -x to +x, each from +y to -y.
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
                    // All of the block's other rows lie lower too.
                    row -= row % BLOCK;
                    continue;
                }
                let at = row * points + column;
                let below = &self.heights_m[at..];
                let highest_m = below[0].max(below[1]).max(below[points]).max(below[points + 1]);
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

    /// Shows the triangles that may reach into a box.
    pub fn triangles_in(&self, bounds: &Bounds, mut show: impl FnMut(Triangle)) {
        self.find_cells(bounds, |column, row| {
            let point_m = |right: usize, up: usize| {
                let inside = (1..=self.cells[0] + 1).contains(&(column + right))
                    && (1..=self.cells[1] + 1).contains(&(row + up));
                inside.then(|| self.point_m(column + right - 1, row + up - 1))
            };
            // Counted from the point before the cell's own, which may lie outside.
            let corner = |right: usize, up: usize| self.point_m(column + right, row + up);
            let halves = [
                (
                    [corner(0, 1), corner(0, 0), corner(1, 1)],
                    [point_m(0, 1), point_m(2, 1), point_m(2, 3)],
                ),
                (
                    [corner(0, 0), corner(1, 0), corner(1, 1)],
                    [point_m(1, 0), point_m(3, 2), point_m(1, 2)],
                ),
            ];
            for (corners_m, across_m) in halves {
                if let Some(triangle) = Triangle::new(corners_m, &Vector3::z()) {
                    show(triangle.among(across_m));
                }
            }
            false
        });
    }

    /// How far a body with a box around it is from the relief, in metres, by how far it is from a triangle: infinity where that says so of all. What is
    /// further from a triangle than it is asked for may be given as infinity.
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

    /// Whether no triangle is further out than a box.
    fn lies_in(&self, bounds: &Bounds) -> bool {
        let [columns, rows] = self.cells;
        let far_m = self.corner_m + self.cell_m * Vector2::new(columns as f64, rows as f64);
        bounds.least_m.z <= self.lowest_m
            && (0..2).all(|axis| {
                bounds.least_m[axis] <= self.corner_m[axis] && bounds.most_m[axis] >= far_m[axis]
            })
    }

    /// Its lowest point, in metres.
    pub fn lowest_m(&self) -> f64 {
        self.lowest_m
    }
}
