//! Meshes of rollers, as binary STL.

use std::f64::consts::TAU;

use super::fit::CORNERS;

/// A body of revolution about z with a profile `[place along the axis, radius]` in metres. Its corners lie as far outside of the
/// circles as the middles of its sides lie inside.
pub(super) fn turned(points: &[[f64; 2]]) -> Vec<u8> {
    let half_rad = 0.5 * TAU / CORNERS as f64;
    let grown = 2.0 / (1.0 + libm::cos(half_rad));
    let corner = |[t, r]: [f64; 2], i: usize| {
        let (sin, cos) = libm::sincos(2.0 * half_rad * i as f64);
        [grown * r * cos, grown * r * sin, t].map(|x| x as f32)
    };
    let [first, last] = [points[0], points[points.len() - 1]];
    let mut triangles = Vec::new();
    for i in 0..CORNERS {
        for pair in points.windows(2) {
            let [a, b, c, d] = [
                corner(pair[0], i),
                corner(pair[0], i + 1),
                corner(pair[1], i + 1),
                corner(pair[1], i),
            ];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let middle = |t: f64| [0.0, 0.0, t as f32];
        triangles.push([middle(first[0]), corner(first, i + 1), corner(first, i)]);
        triangles.push([middle(last[0]), corner(last, i), corner(last, i + 1)]);
    }
    let triangles = triangles.into_iter().map(|corners| stl_io::Triangle {
        // Readers find the normal by the order of the corners.
        normal: stl_io::Normal::new([0.0; 3]),
        vertices: corners.map(stl_io::Vertex::new),
    });
    let mut bytes = Vec::new();
    // A vector takes all that is written.
    let _ = stl_io::write_stl(&mut bytes, triangles.collect::<Vec<_>>().iter());
    bytes
}
