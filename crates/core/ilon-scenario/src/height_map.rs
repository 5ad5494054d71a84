//! Ground from a height map: a grey image, or a mesh seen from above.

use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use ilon_files::FileAccess;
use ilon_trace::{GroundMap, GroundRelief};

use crate::Error;
use crate::scenario::{HeightMap, SIZES, Scenario};

/// The most points of a map: 1025 x 1025, a common size of terrain images.
const MOST_POINTS: usize = 1025 * 1025;
/// The largest image, in bytes. Chosen.
const MAX_BYTES: u64 = 64 << 20;
/// The most grid points that the triangles of a mesh may cover, each counted once per triangle.
/// Chosen.
const MOST_COVERED: f64 = 1e9;
/// Heights have 16 bits, so that a trace can store the heights of the run exactly.
const STEPS: f64 = 65535.0;

/// A fault of a file, and how to repair it.
type Fault = (String, String);

/// Heights on a grid, row by row from -y to +y, in each row from -x to +x.
struct Grid {
    columns: usize,
    /// The middle of the grid, in metres.
    center_m: [f64; 2],
    lowest_m: f64,
    step_m: f64,
    /// How to make its steps finer, in words.
    finer: &'static str,
    /// Levels above the lowest.
    levels: Vec<u16>,
    /// Warnings.
    remarks: Vec<String>,
}

/// The relief of a height map, and warnings for a robot whose smallest wheel radius is given in
/// metres.
///
/// # Errors
/// [`Error::Contents`] if the file has no height map, [`Error::Read`] if it cannot be read.
pub fn relief(
    map: &HeightMap,
    scenario: &Scenario,
    radius_m: f64,
) -> Result<(GroundRelief, Vec<String>), Error> {
    let grid = grid(map, scenario)?;
    let bytes: Vec<u8> = grid.levels.iter().flat_map(|l| l.to_le_bytes()).collect();
    let relief = GroundRelief {
        cell_m: map.cell_m,
        points: grid.columns,
        map: Some(GroundMap {
            center_m: grid.center_m,
            lowest_m: grid.lowest_m,
            step_m: grid.step_m,
            levels: BASE64_STANDARD.encode(bytes),
        }),
        ..GroundRelief::default()
    };
    Ok((relief, grid.remarks(map.cell_m, radius_m)))
}

/// The heights of a map in metres, row by row from -y to +y, with `columns` points per row; empty
/// if its text is invalid.
pub fn heights_m(map: &GroundMap, columns: usize) -> Vec<Vec<f64>> {
    let bytes = BASE64_STANDARD.decode(&map.levels).unwrap_or_default();
    let heights: Vec<f64> = bytes
        .chunks_exact(2)
        .map(|b| map.lowest_m + map.step_m * f64::from(u16::from_le_bytes([b[0], b[1]])))
        .collect();
    let rows = heights.chunks_exact(columns.max(1));
    rows.map(<[f64]>::to_vec).collect()
}

impl Grid {
    /// Warnings by its cell size and the smallest wheel radius, in metres.
    fn remarks(&self, cell_m: f64, radius_m: f64) -> Vec<String> {
        /// Relative to a wheel's radius: smaller cells are a texture. Chosen.
        const FINE: f64 = 0.5;
        /// Relative to a wheel's radius: a step of this height shakes a wheel. Chosen.
        const ROUGH: f64 = 0.02;
        let mut remarks = self.remarks.clone();
        let radius_mm = 1e3 * radius_m;
        if cell_m > FINE * radius_m {
            remarks.push(format!(
                "`world.floor.height_map.cell_m` = {cell_m} is wide for wheels of {radius_mm:.1} mm: bumps and holes narrower than two cells are not in it"
            ));
        }
        if self.step_m > ROUGH * radius_m {
            remarks.push(format!(
                "heights of the height map are multiples of {:.2} mm: wheels of {radius_mm:.1} mm climb each step; {}",
                1e3 * self.step_m,
                self.finer
            ));
        }
        let steepest_m = self.steepest_m();
        if steepest_m > cell_m {
            remarks.push(format!(
                "the height map rises by up to {steepest_m:.3} m from one point to the next, which are {cell_m} m apart: what is a wall stands as a slope of \
                 that width; `world.floor.boxes` stand upright"
            ));
        }
        remarks
    }

    /// Largest height difference between neighbouring points, in metres.
    fn steepest_m(&self) -> f64 {
        let rows: Vec<&[u16]> = self.levels.chunks_exact(self.columns).collect();
        let along = rows.iter().flat_map(|row| row.windows(2));
        let along = along.map(|pair| pair[0].abs_diff(pair[1])).max();
        let across = rows.windows(2).flat_map(|pair| pair[0].iter().zip(pair[1]));
        let across = across.map(|(a, b)| a.abs_diff(*b)).max();
        self.step_m * f64::from(along.max(across).unwrap_or_default())
    }
}

fn grid(map: &HeightMap, scenario: &Scenario) -> Result<Grid, Error> {
    let path = scenario.resolve(&map.file);
    let kind = path.extension().unwrap_or_default().to_string_lossy();
    let read = match kind.to_lowercase().as_str() {
        "png" => {
            let bytes = scenario.files.read(&path, MAX_BYTES);
            picture(map, &bytes.map_err(|fault| Error::read(&path, &fault))?)
        }
        "stl" | "obj" | "dae" => {
            // A missing file is not a fault of its content.
            scenario
                .files
                .reader(&path, u64::MAX)
                .map_err(|fault| Error::read(&path, &fault))?;
            mesh(map, &path, &scenario.files)
        }
        other => Err((
            format!("height maps of the kind `.{other}` are not read"),
            "give a grey picture (`.png`) or a mesh (`.stl`, `.obj`, `.dae`)".to_owned(),
        )),
    };
    read.map_err(|(message, help)| Error::contents(&path, message, help))
}

/// Refuses a grid that is too small or too large.
fn check_size(columns: f64, rows: f64, help: &str) -> Result<(), Fault> {
    let most = MOST_POINTS as f64;
    if columns >= 2.0 && rows >= 2.0 && columns * rows <= most {
        return Ok(());
    }
    Err((
        format!(
            "it makes a grid of {columns:.0} x {rows:.0} points: it must have at least 2 x 2, and {most:.0} in all at most"
        ),
        help.to_owned(),
    ))
}

/// A grey image: black is the lowest, white the highest, the upper edge is at +y.
fn picture(map: &HeightMap, bytes: &[u8]) -> Result<Grid, Fault> {
    let unreadable = |error: png::DecodingError| {
        (
            format!("it cannot be read as a PNG picture: {error}"),
            "save it again as PNG, in grey".to_owned(),
        )
    };
    let Some(height_m) = map.height_m else {
        return Err((
            "nothing says how high white is".to_owned(),
            "add `world.floor.height_map.height_m`, from black to white in metres".to_owned(),
        ));
    };
    let limits = png::Limits { bytes: 64 << 20 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    // Fewer than eight bits are expanded to eight.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(unreadable)?;
    let (columns, rows) = (reader.info().width, reader.info().height);
    check_size(
        columns.into(),
        rows.into(),
        "scale the picture to fewer points, or to more",
    )?;
    let (color, depth) = reader.output_color_type();
    if color != png::ColorType::Grayscale {
        return Err((
            "it has colours or transparent parts, so the height of a point is not one number"
                .to_owned(),
            "save it in grey, of 8 or 16 bits, without an alpha channel".to_owned(),
        ));
    }
    let size = reader.output_buffer_size().unwrap_or_default();
    let mut buffer = vec![0; size];
    reader.next_frame(&mut buffer).map_err(unreadable)?;
    let wide = depth == png::BitDepth::Sixteen;
    let levels: Vec<u16> = if wide {
        let pairs = buffer.chunks_exact(2);
        pairs.map(|b| u16::from_be_bytes([b[0], b[1]])).collect()
    } else {
        buffer.iter().map(|grey| u16::from(*grey)).collect()
    };
    let columns = columns as usize;
    let upwards = levels.chunks_exact(columns).rev();
    Ok(Grid {
        columns,
        center_m: [map.x_m, map.y_m],
        lowest_m: map.base_m,
        step_m: height_m / if wide { STEPS } else { 255.0 },
        finer: if wide {
            "give `world.floor.height_map.height_m` of the ground alone"
        } else {
            "a picture of 16 bits has finer ones"
        },
        levels: upwards.flatten().copied().collect(),
        remarks: Vec::new(),
    })
}

/// A mesh from above: the highest place at each point of the grid.
fn mesh(map: &HeightMap, path: &Path, files: &FileAccess) -> Result<Grid, Fault> {
    if map.height_m.is_some() {
        return Err((
            "a mesh has heights of its own".to_owned(),
            "leave `world.floor.height_map.height_m` out".to_owned(),
        ));
    }
    let triangles = ilon_formats::mesh_triangles(path, files)
        .map_err(|reason| (reason, "export the mesh again".to_owned()))?;
    if triangles.is_empty() {
        return Err((
            "it holds no triangles".to_owned(),
            "export the mesh again".to_owned(),
        ));
    }
    let corners = triangles.iter().flatten().flatten();
    if let Some(far) = corners
        .map(|m| f64::from(*m))
        .find(|m| m.is_nan() || m.abs() > *SIZES.end())
    {
        return Err((
            format!("one of its corners is at {far:e} m"),
            format!(
                "export the mesh in metres, with corners within {:e} m",
                SIZES.end()
            ),
        ));
    }
    let above = FromAbove::new(&triangles, map.cell_m)?;
    above.check_depth(&triangles)?;
    let heights = above.heights_m(&triangles);
    // Flat ground has steps too, of size zero.
    let (lowest_m, highest_m) = above.ends_m[2];
    let step_m = (highest_m - lowest_m) / STEPS;
    let level = |height: &f64| match step_m > 0.0 {
        true => ((height.max(lowest_m) - lowest_m) / step_m).round() as u16,
        false => 0,
    };
    let middle =
        |axis: usize, count: usize| above.ends_m[axis].0 + 0.5 * map.cell_m * (count - 1) as f64;
    Ok(Grid {
        columns: above.columns,
        center_m: [
            map.x_m + middle(0, above.columns),
            map.y_m + middle(1, above.rows),
        ],
        lowest_m: map.base_m + lowest_m,
        step_m,
        finer: "cut off what is far above or below the ground that is driven on: a mesh has 65535 heights from its lowest place to its highest",
        levels: heights.iter().map(level).collect(),
        remarks: above.remarks(&triangles, &heights),
    })
}

type Triangle = [[f32; 3]; 3];

/// A grid of points over a mesh, seen from above.
struct FromAbove {
    cell_m: f64,
    /// Smallest and largest coordinates of the mesh, per axis.
    ends_m: [(f64, f64); 3],
    columns: usize,
    rows: usize,
}

impl FromAbove {
    fn new(triangles: &[Triangle], cell_m: f64) -> Result<Self, Fault> {
        let ends_m = [0, 1, 2].map(|axis| {
            let corners = triangles.iter().flatten();
            least_and_most(corners.map(|corner| f64::from(corner[axis])))
        });
        // A slight excess over a whole number of cells is rounding.
        let points = |(from, to): (f64, f64)| ((to - from) / cell_m + 1e-6).floor() + 1.0;
        let (columns, rows) = (points(ends_m[0]), points(ends_m[1]));
        check_size(
            columns,
            rows,
            "choose `world.floor.height_map.cell_m` by the mesh, which counts in metres",
        )?;
        Ok(Self {
            cell_m,
            ends_m,
            columns: columns as usize,
            rows: rows as usize,
        })
    }

    /// The columns and rows of the points that may be within a triangle.
    fn cells(&self, triangle: &Triangle) -> (Range<usize>, Range<usize>) {
        let range = |axis: usize, count: usize| {
            let origin_m = self.ends_m[axis].0;
            let values = triangle.map(|corner| (f64::from(corner[axis]) - origin_m) / self.cell_m);
            let (least, most) = least_and_most(values.into_iter());
            // A point on an edge counts for both sides.
            let from = (least - 1e-6).ceil().max(0.0) as usize;
            let to = ((most + 1e-6).floor() + 1.0).clamp(0.0, count as f64) as usize;
            from..to.max(from)
        };
        (range(0, self.columns), range(1, self.rows))
    }

    /// Refuses a mesh whose triangles cover too many points.
    fn check_depth(&self, triangles: &[Triangle]) -> Result<(), Fault> {
        let over = |triangle: &Triangle| {
            let (across, up) = self.cells(triangle);
            across.len() as f64 * up.len() as f64
        };
        let covered: f64 = triangles.iter().map(over).sum();
        if covered > MOST_COVERED {
            return Err((
                format!(
                    "its triangles lie {:.0} deep above one another",
                    covered / (self.columns * self.rows) as f64
                ),
                "export the ground alone, or choose a larger `world.floor.height_map.cell_m`"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// The highest place of the mesh at each point, row by row, in metres; negative infinity if
    /// there is none.
    fn heights_m(&self, triangles: &[Triangle]) -> Vec<f64> {
        /// Relative to a triangle's size: points on an edge belong to both sides.
        const SLACK: f64 = 1e-6;
        let [(x_0, _), (y_0, _), (z_0, z_1)] = self.ends_m;
        let cell_m = self.cell_m;
        let mut heights = vec![f64::NEG_INFINITY; self.columns * self.rows];
        for triangle in triangles {
            let (across, up) = self.cells(triangle);
            let [a, b, c] = triangle.map(|corner| corner.map(f64::from));
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            // A vertical triangle covers no point.
            if area.abs() < 1e-12 * cell_m * cell_m {
                continue;
            }
            for row in up {
                for column in across.clone() {
                    let (x, y) = (x_0 + column as f64 * cell_m, y_0 + row as f64 * cell_m);
                    let of_b = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                    let of_c = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                    if of_b >= -SLACK && of_c >= -SLACK && of_b + of_c <= 1.0 + SLACK {
                        let z = a[2] + of_b * (b[2] - a[2]) + of_c * (c[2] - a[2]);
                        let height = &mut heights[row * self.columns + column];
                        *height = height.max(z.clamp(z_0, z_1));
                    }
                }
            }
        }
        heights
    }

    /// Remarks features of the mesh that the grid does not show.
    fn remarks(&self, triangles: &[Triangle], heights: &[f64]) -> Vec<String> {
        let bare = heights.iter().filter(|height| height.is_infinite()).count();
        let mut remarks = Vec::new();
        if bare > 0 {
            remarks.push(format!(
                "the mesh of the height map is empty at {:.1} % of its points: the ground there has the height of its lowest point",
                100.0 * bare as f64 / heights.len() as f64
            ));
        }
        let fine = triangles.iter().filter(|triangle| {
            let (across, up) = self.cells(triangle);
            across.is_empty() || up.is_empty()
        });
        let share = fine.count() as f64 / triangles.len() as f64;
        if share > 0.1 {
            remarks.push(format!(
                "{:.0} % of the triangles of the height map's mesh lie between points of the grid: a smaller `world.floor.height_map.cell_m` \
                 than {} resolves them",
                100.0 * share,
                self.cell_m
            ));
        }
        remarks
    }
}

fn least_and_most(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), value| (least.min(value), most.max(value)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief_heights_m(relief: &GroundRelief) -> Vec<Vec<f64>> {
        heights_m(relief.map.as_ref().unwrap(), relief.points)
    }

    /// Reads a file from its own folder, with the map keys beside it.
    fn read(name: &str, bytes: &[u8], keys: &str) -> Result<GroundRelief, Error> {
        Ok(read_remarked(name, bytes, keys)?.0)
    }

    fn read_remarked(
        name: &str,
        bytes: &[u8],
        keys: &str,
    ) -> Result<(GroundRelief, Vec<String>), Error> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let text = format!(
            "robot.file = ''\ntwist = {{}}\nrun.duration_s = 1\n[world.floor.height_map]\nfile = '{name}'\n{keys}"
        );
        let scenario = Scenario::from_toml(&text, "map", folder.path())?;
        let map = scenario.world.floor.height_map.as_ref().unwrap();
        relief(map, &scenario, 0.05)
    }

    fn refused(name: &str, bytes: &[u8], keys: &str) -> String {
        let error = read(name, bytes, keys).unwrap_err();
        match error {
            Error::Contents { message, help, .. } => format!("{message}; {help}"),
            other => other.to_string(),
        }
    }

    fn png(size: [u32; 2], color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    fn grey(size: [u32; 2], data: &[u8]) -> Vec<u8> {
        png(size, png::ColorType::Grayscale, png::BitDepth::Eight, data)
    }

    const KEYS: &str = "cell_m = 0.5\nheight_m = 0.51\nbase_m = -0.1\n";

    #[test]
    fn a_picture_of_eight_bits_and_one_of_sixteen_are_heights_with_the_upper_edge_at_y() {
        // Black, white and a grey, 1/255 above the next darker one.
        let relief = read("map.png", &grey([3, 2], &[0, 255, 51, 1, 0, 0]), KEYS).unwrap();
        let heights = relief_heights_m(&relief);
        let expected = [[-0.1 + 0.002, -0.1, -0.1], [-0.1, 0.41, 0.002]];
        for (row, expected) in heights.iter().zip(expected) {
            for (height, expected) in row.iter().zip(expected) {
                assert!((height - expected).abs() < 1e-12, "{heights:?}");
            }
        }
        assert_eq!((heights.len(), relief.points, relief.cell_m), (2, 3, 0.5));
        let wide = [0_u16, 65535, 13107, 257, 0, 0]
            .map(u16::to_be_bytes)
            .concat();
        let wide = png(
            [3, 2],
            png::ColorType::Grayscale,
            png::BitDepth::Sixteen,
            &wide,
        );
        let again = relief_heights_m(&read("map.png", &wide, KEYS).unwrap());
        for (a, b) in again.iter().flatten().zip(heights.iter().flatten()) {
            assert!((a - b).abs() < 1e-12);
        }
        // One bit a pixel: black and white.
        let bits = png(
            [2, 2],
            png::ColorType::Grayscale,
            png::BitDepth::One,
            &[0x40, 0x80],
        );
        let heights = relief_heights_m(&read("map.png", &bits, KEYS).unwrap());
        assert!((heights[0][0] - 0.41).abs() < 1e-12 && (heights[1][0] + 0.1).abs() < 1e-12);
    }

    #[test]
    fn pictures_that_are_no_map_are_refused_in_words() {
        let whole = grey([3, 3], &[7; 9]);
        for (bytes, keys, says) in [
            (grey([1, 5], &[0; 5]), KEYS, "1 x 5 points"),
            (grey([1100, 1000], &[0; 1_100_000]), KEYS, "at most"),
            (
                png([2, 2], png::ColorType::Rgb, png::BitDepth::Eight, &[0; 12]),
                KEYS,
                "colours",
            ),
            (
                png(
                    [2, 2],
                    png::ColorType::GrayscaleAlpha,
                    png::BitDepth::Eight,
                    &[0; 8],
                ),
                KEYS,
                "colours",
            ),
            (whole[..whole.len() - 20].to_vec(), KEYS, "cannot be read"),
            (whole[..20].to_vec(), KEYS, "cannot be read"),
            (Vec::new(), KEYS, "cannot be read"),
            (
                b"\xff\xd8\xff\xe0 a photograph".to_vec(),
                KEYS,
                "cannot be read",
            ),
            (whole.clone(), "cell_m = 0.5\n", "how high white is"),
        ] {
            let said = refused("map.png", &bytes, keys);
            assert!(said.contains(says), "{said}");
        }
        // The header claims 4 thousand million points, in 60 bytes.
        let mut huge = whole.clone();
        huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
        let said = refused("map.png", &huge, KEYS);
        assert!(
            said.contains("cannot be read") || said.contains("at most"),
            "{said}"
        );
        for (keys, says) in [
            ("cell_m = 0\nheight_m = 1\n", "cell_m"),
            ("cell_m = nan\nheight_m = 1\n", "cell_m"),
            ("cell_m = 0.1\nheight_m = -1\n", "height_m"),
            ("cell_m = 0.1\nheight_m = inf\n", "height_m"),
            ("height_m = 1\n", "cell_m"),
        ] {
            let said = refused("map.png", &whole, keys);
            assert!(said.contains(says), "{said}");
        }
        assert!(refused("map.jpg", &whole, KEYS).contains("`.jpg`"));
    }

    /// A roof over a square of 2 m: 1 m high over the line x = 0, in the mesh's own coordinates.
    const ROOF: &str = "v 4 -1 0\nv 5 -1 1\nv 6 -1 0\nv 4 1 0\nv 5 1 1\nv 6 1 0\nf 1 2 5\nf 1 5 4\nf 2 3 6\nf 2 6 5\n";

    #[test]
    fn a_mesh_is_as_high_as_it_looks_from_above_and_stands_where_it_is() {
        // Something beneath it, which is not seen.
        let under = format!("{ROOF}v 4 -1 -0.5\nv 6 -1 -0.5\nv 6 1 -0.5\nf 7 8 9\n");
        for (text, lowest_m) in [(ROOF.to_owned(), 0.0), (under, -0.5)] {
            let relief = read(
                "roof.obj",
                text.as_bytes(),
                "cell_m = 0.25\nx_m = -5\nbase_m = 0.1\n",
            )
            .unwrap();
            let heights = relief_heights_m(&relief);
            assert_eq!((heights.len(), relief.points), (9, 9));
            for row in &heights {
                for (column, height) in row.iter().enumerate() {
                    let expected = 1.1 - 0.25 * (column as f64 - 4.0).abs();
                    // Half a step of 16 bits.
                    let step_m = (1.0 - lowest_m) / STEPS;
                    assert!((height - expected).abs() < 0.51 * step_m, "{heights:?}");
                }
            }
            assert_eq!(relief.map.unwrap().center_m, [0.0, 0.0]);
        }
    }

    #[test]
    fn meshes_that_are_no_map_are_refused_in_words() {
        let keys = "cell_m = 0.25\n";
        let with_nan = ROOF.replace("v 5 -1 1\n", "v 5 -1 nan\n");
        let far = ROOF.replace("v 5 -1 1\n", "v 5 -1 1e10\n");
        let upright = "v 0 0 0\nv 1 0 0\nv 1 0 1\nf 1 2 3\n";
        for (text, keys, says) in [
            (with_nan.as_str(), keys, "not finite"),
            (far.as_str(), keys, "1e10 m"),
            ("", keys, "no triangles"),
            (upright, keys, "points"),
            (ROOF, "cell_m = 3\n", "points"),
            (ROOF, "cell_m = 1e-9\n", "at most"),
            (ROOF, "cell_m = 0.25\nheight_m = 1\n", "heights of its own"),
            ("f 1 2 3\n", keys, ""),
        ] {
            let said = refused("roof.obj", text.as_bytes(), keys);
            assert!(said.contains(says), "{said}");
        }
        assert!(!refused("roof.stl", b"solid", keys).is_empty());
    }

    /// A roof of 1 m has steps of 15 um; with a mast of 1 km on it they are of 15 mm, and the
    /// remedy is not an image.
    #[test]
    fn a_mesh_that_is_too_high_for_its_steps_says_what_mends_them() {
        let remarks = |text: &str| {
            let (_, remarks) =
                read_remarked("roof.obj", text.as_bytes(), "cell_m = 0.25\n").unwrap();
            remarks.join("; ")
        };
        let high = ROOF.replace("v 5 -1 1\n", "v 5 -1 1000\n");
        assert_ne!(high, ROOF);
        assert!(!remarks(ROOF).contains("multiples"), "{}", remarks(ROOF));
        let said = remarks(&high);
        assert!(
            said.contains("multiples of 15.26 mm: wheels of 50.0 mm") && said.contains("cut off"),
            "{said}"
        );
        assert!(!said.contains("picture"), "{said}");
    }

    #[test]
    fn a_text_that_is_no_levels_gives_no_heights() {
        let of = |levels: &str| GroundMap {
            levels: levels.to_owned(),
            ..GroundMap::default()
        };
        assert!(heights_m(&of("%%%"), 3).is_empty());
        assert!(heights_m(&of(""), 0).is_empty());
    }
}
