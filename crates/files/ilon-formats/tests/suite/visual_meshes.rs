//! Visual meshes of a robot: read in any format, simplified, remarked if they cannot be drawn, and
//! no part of the model.

use crate::common;

use std::path::Path;

use common::{options, small};
use ilon_files::FileAccess;
use ilon_formats::{LoadRobot, Loaded};
use ilon_robot::{Robot, VisualMeshes};
use test_case::test_case;

type Point = [f32; 3];

/// The corners of a box from the origin, and its sides as polygons of them.
const CORNERS: [Point; 8] = [
    [0.0, 0.0, 0.0],
    [0.3, 0.0, 0.0],
    [0.3, 0.2, 0.0],
    [0.0, 0.2, 0.0],
    [0.0, 0.0, 0.1],
    [0.3, 0.0, 0.1],
    [0.3, 0.2, 0.1],
    [0.0, 0.2, 0.1],
];
const SIDES: [[usize; 4]; 6] = [
    [3, 2, 1, 0],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

fn triangles() -> Vec<[Point; 3]> {
    let of_side = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    let indices = SIDES.into_iter().flat_map(of_side);
    indices.map(|t| t.map(|k| CORNERS[k])).collect()
}

/// A binary STL that begins with these letters.
fn binary_stl(triangles: &[[Point; 3]], title: &str) -> Vec<u8> {
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        let numbers = triangle.iter().flatten();
        bytes.extend(numbers.flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> Vec<u8> {
    let facet = |t: &[Point; 3]| {
        let corners = t.map(|[x, y, z]| format!("vertex {x} {y} {z}\n"));
        format!(
            "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            corners.concat()
        )
    };
    let facets: String = triangles().iter().map(facet).collect();
    format!("solid box\n{facets}endsolid box\n").into_bytes()
}

fn words(numbers: impl IntoIterator<Item = impl ToString>) -> String {
    let words: Vec<String> = numbers.into_iter().map(|n| n.to_string()).collect();
    words.join(" ")
}

fn obj() -> Vec<u8> {
    let points = CORNERS.iter().map(|p| format!("v {}\n", words(p)));
    let faces = SIDES
        .iter()
        .map(|s| format!("f {}\n", words(s.map(|k| k + 1))));
    points.chain(faces).collect::<String>().into_bytes()
}

/// COLLADA in centimetres, placed by its scene, its corners with an index of a normal each.
fn dae(primitives: &str) -> Vec<u8> {
    let points = words(CORNERS.iter().flatten().map(|x| 100.0 * x - 100.0));
    format!(
        "<COLLADA><asset><unit meter='0.01'/></asset><library_geometries><geometry id='g'><mesh>\
         <source id='s'><float_array count='24'>{points}</float_array></source>\
         <vertices id='v'><input semantic='POSITION' source='#s'/></vertices>{primitives}</mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id='scene'><node><translate>100 100 100</translate>\
         <instance_geometry url='#g'/></node></visual_scene></library_visual_scenes></COLLADA>"
    )
    .into_bytes()
}

fn polylist() -> Vec<u8> {
    let corners = SIDES.iter().flatten().flat_map(|k| [0, *k]);
    dae(&format!(
        "<polylist count='6'><input semantic='NORMAL' source='#n' offset='0'/><input semantic='VERTEX' source='#v' offset='1'/>\
         <vcount>4 4 4 4 4 4</vcount><p>{}</p></polylist>",
        words(corners)
    ))
}

fn polygons() -> Vec<u8> {
    let lists: String = SIDES
        .iter()
        .map(|s| format!("<p>{}</p>", words(s)))
        .collect();
    dae(&format!(
        "<polygons count='6'><input semantic='VERTEX' source='#v' offset='0'/>{lists}</polygons>"
    ))
}

/// A robot with a mesh as its chassis's visual, read beside these files.
fn shown_as(mesh: &str, files: &[(&str, Vec<u8>)]) -> (Loaded, VisualMeshes) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    read_in(folder.path(), mesh, FileAccess::anywhere())
}

fn urdf(mesh: &str) -> String {
    let visual = format!("<visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual>");
    small().replacen("<visual>", &format!("{visual}<visual>"), 1)
}

fn read_in(folder: &Path, mesh: &str, access: FileAccess) -> (Loaded, VisualMeshes) {
    let file = folder.join("robot.urdf");
    let options = options(|o| o.files = access);
    let loaded = Robot::from_urdf_str_with(&urdf(mesh), &file.display().to_string(), &options);
    let loaded = loaded.expect("what is only seen stops no robot from being read");
    let looks = loaded.visual_meshes();
    (loaded, looks)
}

#[test_case("box.stl", binary_stl(&triangles(), "made by hand"); "binary")]
// Binary files of SolidWorks and others begin as the text form does.
#[test_case("box.STL", binary_stl(&triangles(), "solid box"); "binary that calls itself solid")]
#[test_case("box.stl", text_stl(); "text")]
#[test_case("box.obj", obj(); "polygons of obj")]
#[test_case("box.dae", polylist(); "polylist")]
#[test_case("box.dae", polygons(); "polygons")]
fn a_mesh_of_any_kind_is_seen_as_it_is(name: &str, bytes: Vec<u8>) {
    let (_, looks) = shown_as(name, &[(name, bytes)]);
    assert_eq!(looks.remarks, Vec::<String>::new());
    let [mesh] = &looks.meshes[..] else {
        panic!("{looks:?}")
    };
    assert_eq!((mesh.name.as_str(), mesh.triangle_count()), (name, 12));
    let mut vertices = mesh.vertices();
    vertices.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    let mut corners = CORNERS;
    corners.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    // Positions have a resolution of half of 1/65535 of the box, 2.3 um of 0.3 m; COLLADA's are
    // sums of f32 numbers around 100 before that.
    for (vertex, corner) in vertices.iter().zip(corners) {
        for k in 0..3 {
            assert!(
                (vertex[k] - corner[k]).abs() < 1e-5,
                "{vertex:?} {corner:?}"
            );
        }
    }
    assert_eq!(vertices.len(), 8, "corners that meet are one");
}

#[test]
fn what_is_seen_is_no_part_of_the_model() {
    let (with, looks) = shown_as("box.stl", &[("box.stl", text_stl())]);
    assert!(!looks.is_empty());
    let without = Robot::from_urdf_str(&small(), "robot.urdf").expect("it is read");
    assert_eq!(
        common::fingerprint(&with.robot),
        common::fingerprint(&without)
    );
}

#[test_case("no.stl", "", "no.stl"; "missing")]
#[test_case("package://nobody/a.stl", "", "nobody"; "of a package that is not there")]
#[test_case("a.fbx", "fbx", "`.fbx` are not read"; "of another kind")]
#[test_case("a.stl", "nothing", "cut short"; "cut short")]
#[test_case("a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n", "`git lfs pull` fetches it"; "not fetched")]
#[test_case("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/-9223372036854775808\n", "a point that is not there"; "an index beyond all files")]
#[test_case("a.obj", "", "no triangle"; "empty")]
#[test_case("a.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "no triangle"; "without area")]
#[test_case("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"; "not finite")]
#[test_case("a.obj", "v 1 0 0\nv 0 1 0\nf 1 2 9\n", ""; "face without its point")]
#[test_case(
    "a.dae",
    "<COLLADA><geometry><mesh><triangles><input semantic='VERTEX' offset='0'/><p>0 1 2</p></triangles></mesh></geometry></COLLADA>",
    "not there";
    "polygon without its point"
)]
#[test_case(
    "a.dae",
    "<COLLADA><geometry><mesh><triangles><input semantic='VERTEX' offset='18446744073709551615'/><p>0</p></triangles></mesh></geometry></COLLADA>",
    "no triangle";
    "offset of a stranger"
)]
#[test_case(
    "a.dae",
    "<COLLADA><geometry><mesh><polylist><vcount>9999999999</vcount><p>0</p></polylist></mesh></geometry></COLLADA>",
    "fewer corners";
    "count of a stranger"
)]
fn a_mesh_that_cannot_be_drawn_is_remarked(name: &str, text: &str, says: &str) {
    let files: &[(&str, Vec<u8>)] = match name {
        "no.stl" | "package://nobody/a.stl" => &[],
        name => &[(name, text.as_bytes().to_vec())],
    };
    let (_, looks) = shown_as(name, files);
    assert!(looks.meshes.is_empty());
    assert_eq!(looks.remarks.len(), 1, "{:?}", looks.remarks);
    let remark = &looks.remarks[0];
    assert!(
        remark.contains("is not drawn") && remark.contains(says),
        "{remark}"
    );
}

#[test]
fn a_mesh_outside_of_what_may_be_read_is_not_read() {
    let outside = tempfile::tempdir().expect("a folder");
    std::fs::write(outside.path().join("box.stl"), text_stl()).expect("a file");
    let inside = tempfile::tempdir().expect("a folder");
    let access = FileAccess::below([inside.path()]).expect("a folder");
    let mesh = outside.path().join("box.stl").display().to_string();
    let (_, looks) = read_in(inside.path(), &mesh, access);
    assert!(
        looks.meshes.is_empty() && looks.remarks.len() == 1,
        "{looks:?}"
    );
}

#[test]
fn a_mesh_of_many_triangles_is_simplified_and_its_size_stays() {
    // A wavy square of 2 x 250 x 250 triangles.
    let at = |i: usize, j: usize| {
        let (x, y) = (i as f32 / 250.0, j as f32 / 250.0);
        [x, y, 0.05 * (12.0 * x).sin() * (9.0 * y).cos()]
    };
    let cells = (0..250 * 250).map(|k| (k / 250, k % 250));
    let soup: Vec<[Point; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let (_, looks) = shown_as("wave.stl", &[("wave.stl", binary_stl(&soup, ""))]);
    let mesh = &looks.meshes[0];
    assert!(
        (8_000..=16_000).contains(&mesh.triangle_count()),
        "{}",
        mesh.triangle_count()
    );
    assert!(
        looks.remarks[0].contains("for 125000"),
        "{:?}",
        looks.remarks
    );
    // The means of the outermost cells lie within a cell of the edge: a hundredth.
    let [low, high] = mesh.bounds();
    for k in 0..2 {
        assert!(low[k] >= 0.0 && low[k] < 0.015 && high[k] <= 1.0 && high[k] > 0.985);
    }
    // The form in a page and a trace.
    let json = serde_json::to_string(&looks).expect("JSON");
    assert!(json.len() < 250_000, "{}", json.len());
    assert_eq!(
        serde_json::from_str::<VisualMeshes>(&json).expect("JSON"),
        looks
    );
}
