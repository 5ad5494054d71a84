//! The meshes of a robot's file: where they are drawn, in which size and colour, and which are left
//! out.

use ilon_formats::{LoadOptions, LoadRobot};
use ilon_robot::Robot;
use ilon_scene::description::{Geometry, Shape, WheelShape};
use ilon_scene::{Description, RobotShape};

/// A tetrahedron with its vertices at this distance from the origin along the axes.
fn tetrahedron(reach: f64) -> String {
    format!(
        "v 0 0 0\nv {reach} 0 0\nv 0 {reach} 0\nv 0 0 {reach}\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
    )
}

/// The drawing of the shipped mecanum robot with some of its text replaced, beside `part.obj`.
fn drawn(part: &str, (from, to): (&str, &str)) -> RobotShape {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("part.obj"), part).expect("a file");
    let path = format!(
        "{}/../../../assets/robots/mecanum4.urdf",
        env!("CARGO_MANIFEST_DIR")
    );
    let urdf = std::fs::read_to_string(path).expect("a shipped robot");
    assert!(urdf.contains(from), "{from}");
    let urdf = urdf.replace(from, to);
    let file = folder.path().join("robot.urdf").display().to_string();
    let loaded = Robot::from_urdf_str_with(&urdf, &file, &LoadOptions::default());
    let loaded = loaded.expect("it is read");
    Description::of_robot(
        &loaded.robot,
        loaded.links().as_ref(),
        &loaded.visual_meshes(),
    )
    .robot
}

const CHASSIS: &str = "<box size=\"0.4 0.24 0.1\"/></geometry><material name=\"chassis\">";
const HUB: &str = "<cylinder radius=\"0.03\" length=\"0.04\"/></geometry><material name=\"hub\">";

#[test]
fn a_mesh_is_drawn_in_the_place_size_and_colour_that_the_file_gives_it() {
    let mesh = "<mesh filename=\"part.obj\" scale=\"0.001 0.002 0.003\"/></geometry><material name=\"chassis\">";
    let shape = drawn(&tetrahedron(100.0), (CHASSIS, mesh));
    let [
        Shape {
            pose,
            form: Geometry::Mesh(placed),
            color,
        },
    ] = &shape.chassis[..]
    else {
        panic!("{:?}", shape.chassis)
    };
    assert_eq!((placed.index, placed.scale), (0, [0.001, 0.002, 0.003]));
    // <origin xyz="0 0 0.06"/>, <color rgba="0.35 0.40 0.45 1"/>
    assert_eq!((pose[2], *color), (0.06, Some([0.35, 0.4, 0.45, 1.0])));
    assert_eq!((shape.meshes.len(), shape.meshes_left_out), (1, 0));
    assert_eq!(shape.remarks, Vec::<String>::new());
    // The nose is on top of the highest corner: 100 mm scaled by three, above the link's origin.
    assert!(
        shape.nose[2] > 0.06 + 0.3 && shape.nose[2] < 0.06 + 0.32,
        "{:?}",
        shape.nose
    );
}

#[test]
fn a_mesh_of_a_hub_is_drawn_and_one_of_a_whole_wheel_is_not() {
    let mesh = "<mesh filename=\"part.obj\"/></geometry><material name=\"hub\">";
    // The wheel's radius is 50 mm.
    let inside = drawn(&tetrahedron(0.03), (HUB, mesh));
    let only_form = |wheel: &WheelShape| match &wheel.hub[..] {
        [Shape { form, .. }] => *form,
        several => panic!("{several:?}"),
    };
    for wheel in &inside.wheels {
        assert!(
            matches!(only_form(wheel), Geometry::Mesh(_)),
            "{:?}",
            wheel.hub
        );
    }
    assert_eq!(inside.meshes.len(), 1, "all hubs share it");
    let whole = drawn(&tetrahedron(0.05), (HUB, mesh));
    for wheel in &whole.wheels {
        assert!(
            matches!(only_form(wheel), Geometry::Cylinder(_)),
            "{:?}",
            wheel.hub
        );
    }
    assert_eq!((whole.meshes.len(), whole.meshes_left_out), (0, 4));
    assert_eq!(whole.remarks.len(), 1, "{:?}", whole.remarks);
    assert!(whole.remarks[0].contains("rollers"), "{:?}", whole.remarks);
}

#[test]
fn a_mesh_in_other_units_does_not_dwarf_the_robot() {
    // Millimetres without a scale.
    let mesh = "<mesh filename=\"part.obj\"/></geometry><material name=\"chassis\">";
    let shape = drawn(&tetrahedron(100.0), (CHASSIS, mesh));
    assert!(shape.reach_m < 1.0, "{}", shape.reach_m);
    // The collision shape is drawn instead.
    assert!(
        matches!(
            shape.chassis[..],
            [Shape {
                form: Geometry::Box(_),
                ..
            }]
        ),
        "{:?}",
        shape.chassis
    );
    // The far corner of the box around it: 100 m along each axis.
    assert!(
        shape.remarks[0].contains("reaches 173 m"),
        "{:?}",
        shape.remarks
    );
}
