//! Reduces a mesh to few triangles by clustering its vertices: those within a cell of a grid are
//! merged to their mean. Triangles that lose their area are removed. It accepts any triangles,
//! closed or not: CAD meshes are often no surface.
//!
//! J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex
//! scenes*, 1993.

use std::collections::{HashMap, HashSet};

use super::soup::Triangle;

/// Vertices, and triangles of their indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Indexed {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Cells along the longest side of the finest grid: finer than a pixel of any screen, and coarser
/// than the grid to which positions are rounded.
const FINEST: u32 = 1 << 14;

/// Returns the triangles unchanged, if they are at most `most`; otherwise the finest clustering
/// within the limit.
pub(super) fn of(soup: &[Triangle], most: usize) -> Indexed {
    let whole = clustered(soup, FINEST);
    if whole.triangles.len() <= most {
        return whole;
    }
    // The number of triangles nearly always grows with the cells: bisection finds a crossing of the
    // limit.
    let (mut coarse, mut fine) = (1, FINEST);
    let mut best = Indexed::default();
    while fine - coarse > 1 && fine > coarse + coarse / 32 {
        let cells =
            ((f64::from(coarse) * f64::from(fine)).sqrt() as u32).clamp(coarse + 1, fine - 1);
        let tried = clustered(soup, cells);
        if tried.triangles.len() <= most {
            (coarse, best) = (cells, tried);
        } else {
            fine = cells;
        }
    }
    best
}

/// Clusters with a number of cells along the longest side.
fn clustered(soup: &[Triangle], cells: u32) -> Indexed {
    let corners = || soup.iter().flatten();
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for corner in corners() {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let longest = (0..3).map(|k| f64::from(high[k]) - f64::from(low[k]));
    let cell = longest.fold(0.0, f64::max) / f64::from(cells);
    if !(cell > 0.0 && cell.is_finite()) {
        return Indexed::default();
    }
    let mut of_cell: HashMap<[u32; 3], u32> = HashMap::new();
    let mut sums: Vec<([f64; 3], f64)> = Vec::new();
    let mut seen: HashSet<[u32; 3]> = HashSet::new();
    let mut triangles = Vec::new();
    for triangle in soup {
        let [a, b, c] = triangle.map(|corner| {
            let key = [0, 1, 2].map(|k| ((f64::from(corner[k]) - f64::from(low[k])) / cell) as u32);
            let index = *of_cell.entry(key).or_insert_with(|| {
                sums.push(([0.0; 3], 0.0));
                sums.len() as u32 - 1
            });
            let (sum, count) = &mut sums[index as usize];
            (0..3).for_each(|k| sum[k] += f64::from(corner[k]));
            *count += 1.0;
            index
        });
        if a == b || b == c || c == a {
            continue;
        }
        let mut same = [a, b, c];
        same.sort_unstable();
        if seen.insert(same) {
            triangles.push([a, b, c]);
        }
    }
    let mean = |(sum, count): ([f64; 3], f64)| sum.map(|x| (x / count) as f32);
    used(&sums.into_iter().map(mean).collect::<Vec<_>>(), &triangles)
}

/// Removes unused vertices.
fn used(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Indexed {
    let mut kept: HashMap<u32, u32> = HashMap::new();
    let mut indexed = Indexed::default();
    for triangle in triangles {
        let renamed = triangle.map(|old| {
            *kept.entry(old).or_insert_with(|| {
                indexed.vertices.push(vertices[old as usize]);
                indexed.vertices.len() as u32 - 1
            })
        });
        indexed.triangles.push(renamed);
    }
    indexed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 1 as a globe with a number of meridians.
    fn globe(meridians: usize) -> Vec<Triangle> {
        let at = |i: usize, j: usize| {
            let angle = |k: usize| std::f64::consts::PI * k as f64 / meridians as f64;
            let (across, up) = (2.0 * angle(i % meridians), angle(j));
            let r = libm::sin(up);
            [r * libm::cos(across), r * libm::sin(across), libm::cos(up)].map(|x| x as f32)
        };
        let cell = |k: usize| (k / meridians, k % meridians);
        let quads = (0..meridians * meridians).map(cell);
        quads
            .flat_map(|(j, i)| {
                let [a, b] = [at(i, j), at(i + 1, j)];
                let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    #[test]
    fn few_triangles_stay_as_they_are() {
        let corner = |k: usize| [k as f32, (k * k) as f32, 0.5];
        let soup = [
            [corner(0), corner(1), corner(2)],
            [corner(1), corner(2), corner(3)],
        ];
        let indexed = of(&soup, 2);
        assert_eq!(indexed.triangles, [[0, 1, 2], [1, 2, 3]]);
        assert_eq!(indexed.vertices, [0, 1, 2, 3].map(corner));
    }

    #[test]
    fn a_ball_stays_a_ball_with_few_triangles() {
        let ball = globe(200);
        assert_eq!(ball.len(), 80_000);
        let indexed = of(&ball, 2_000);
        let count = indexed.triangles.len();
        // At most the limit, and not much less: on a grid of 32nds the count of a surface changes
        // in steps of a sixteenth.
        assert!((1_500..=2_000).contains(&count), "{count}");
        // A cell of n along the diameter has means no deeper than the sagitta of its diagonal,
        // (sqrt(3)/n)^2 / 2 of the radius; 2000 triangles need more than 15 cells.
        for vertex in &indexed.vertices {
            let radius = vertex.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((0.97..=1.0001).contains(&radius), "{radius}");
        }
    }

    #[test]
    fn what_has_no_area_is_nothing() {
        assert_eq!(of(&[], 10), Indexed::default());
        assert_eq!(of(&[[[1.0; 3]; 3]; 5], 10), Indexed::default());
    }
}
