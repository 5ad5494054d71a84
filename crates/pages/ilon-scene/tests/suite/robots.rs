//! Drawings of robots, from their model and their file.

use ilon_formats::{JointOptions, LoadOptions, LoadRobot, RoleOption, RollerForms, link_tree};
use ilon_robot::{Robot, VisualMeshes};
use ilon_scene::description::{Geometry, Shape};
use ilon_scene::{Description, Frames, Scene, embed};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use test_case::test_case;

fn urdf(name: &str) -> String {
    let path = format!(
        "{}/../../../assets/robots/{name}.urdf",
        env!("CARGO_MANIFEST_DIR")
    );
    std::fs::read_to_string(path).expect("a shipped robot")
}

fn robot(urdf: &str) -> Robot {
    Robot::from_urdf_str(urdf, "robot.urdf").expect("a shipped robot is read")
}

fn assert_near<const N: usize>(is: [f32; N], wanted: [f32; N]) {
    // Rounded to f32 in numbers below 1.
    let near = is.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near, "{is:?} is not {wanted:?}");
}

/// A number of the description that is not finite would be `null` in JSON, as is the relief of flat
/// ground.
fn assert_finite(description: &Description) {
    let json = serde_json::to_string(description).expect("a description is JSON");
    let json = json.replace("\"relief\":null", "");
    assert!(!json.contains("null"), "{json}");
}

#[test]
fn chassis_and_hubs_are_drawn_as_the_file_shows_them() {
    let urdf = urdf("mecanum4");
    let shape = Description::of_robot(
        &robot(&urdf),
        link_tree(&urdf).as_ref(),
        &VisualMeshes::default(),
    )
    .robot;
    // <origin xyz="0 0 0.06"/> <box size="0.4 0.24 0.1"/> <color rgba="0.35 0.40 0.45 1"/>
    let [
        Shape {
            pose,
            form: Geometry::Box(half),
            color,
        },
    ] = &shape.chassis[..]
    else {
        panic!("{:?}", shape.chassis);
    };
    assert_near(*pose, [0.0, 0.0, 0.06, 0.0, 0.0, 0.0, 1.0]);
    assert_near(*half, [0.2, 0.12, 0.05]);
    assert_eq!(*color, Some([0.35, 0.4, 0.45, 1.0]));
    for wheel in &shape.wheels {
        let [
            Shape {
                pose,
                form: Geometry::Cylinder(size),
                ..
            },
        ] = &wheel.hub[..]
        else {
            panic!("{:?}", wheel.hub);
        };
        assert_near(*size, [0.03, 0.04]);
        // Its axis is the hub's, in either direction: z stays, or turns by half a turn about x.
        let [x, y, z, i, j, _, _] = *pose;
        assert_near([x, y, z], [0.0; 3]);
        let up = 1.0 - 2.0 * (i * i + j * j);
        assert!((up.abs() - 1.0).abs() < 1e-6, "{pose:?}");
    }
}

#[test]
fn rollers_stand_where_the_model_has_them_and_share_their_outline() {
    let urdf = urdf("mecanum4");
    let robot = robot(&urdf);
    let shape = Description::of_robot(&robot, None, &VisualMeshes::default()).robot;
    // Left and right rollers are mirror images: as bodies of revolution they are equal.
    assert_eq!(shape.lathes.len(), 1);
    let widest = shape.lathes[0].iter().map(|p| p[1]).fold(0.0, f32::max);
    assert_near([widest], [robot.wheels[0].rollers[0].radius_m as f32]);
    for (drawn, wheel) in shape.wheels.iter().zip(&robot.wheels) {
        assert_eq!(drawn.rollers.len(), wheel.rollers.len());
        for (drawn, roller) in drawn.rollers.iter().zip(&wheel.rollers) {
            let [x, y, z, ..] = drawn.hub_from_roller;
            assert_near([x, y, z], roller.center_in_hub_m.map(|x| x as f32).into());
        }
    }
}

#[test]
fn rollers_as_modelled_are_drawn_by_the_hull_of_their_shapes() {
    let urdf = urdf("mecanum4");
    let mut options = LoadOptions::default();
    options.rollers = RollerForms::AsModelled;
    let loaded = Robot::from_urdf_str_with(&urdf, "robot.urdf", &options).expect("it is read");
    let shape = Description::of_robot(
        &loaded.robot,
        loaded.links().as_ref(),
        &VisualMeshes::default(),
    )
    .robot;
    // The outermost spheres of the stack: <origin xyz="0 0 0.01956"/> <sphere radius="0.00956"/>.
    let (first, last) = (shape.lathes[0].first(), shape.lathes[0].last());
    let end = 0.0195598 + 0.0095612;
    let ends = [first, last].map(|p| p.expect("an outline")[0]);
    assert_near(ends, [-end, end]);
    assert_finite(&Description::of_robot(
        &loaded.robot,
        None,
        &VisualMeshes::default(),
    ));
}

#[test_case(
    "<visual>",
    "<visual_of_another_kind>",
    "</visual>",
    "</visual_of_another_kind>";
    "nothing shown"
)]
#[test_case(
    "<box size=\"0.4 0.24 0.1\"/>",
    "<mesh filename=\"no.stl\"/>",
    "",
    "";
    "nothing to touch either"
)]
fn a_robot_whose_chassis_shows_nothing_is_drawn_by_what_there_is(
    from: &str,
    to: &str,
    and_from: &str,
    and_to: &str,
) {
    let whole = urdf("mecanum4");
    let mut shown = whole.replace(from, to);
    if !and_from.is_empty() {
        shown = shown.replace(and_from, and_to);
    }
    let mut robot = robot(&whole);
    if from.starts_with("<box") {
        robot.chassis.collisions.clear();
    }
    let description =
        Description::of_robot(&robot, link_tree(&shown).as_ref(), &VisualMeshes::default());
    assert_eq!(description.robot.chassis.len(), 1);
    assert_eq!(
        description.robot.meshes_left_out,
        usize::from(from.starts_with("<box"))
    );
    assert_finite(&description);
}

#[test_case("not a robot"; "no xml")]
#[test_case(""; "empty")]
#[test_case(
    "<robot><link name='a'/><link name='b'/><link name='c'/><joint name='1'><parent link='a'/><child link='b'/></joint>\
     <joint name='2'><parent link='b'/><child link='c'/></joint><joint name='3'><parent link='c'/><child link='b'/></joint></robot>";
    "loop of links"
)]
#[test_case(
    "<robot><link name='a'><visual><origin xyz='x y z'/><geometry><box size='1 nan 3'/><sphere radius='inf'/>\
     <cylinder radius='1'/></geometry><material><color rgba='1 2'/></material></visual><visual/></link></robot>";
    "words for numbers"
)]
fn a_text_that_shows_nothing_sensible_leaves_the_model_to_be_drawn(text: &str) {
    let robot = robot(&urdf("volksbot"));
    let description =
        Description::of_robot(&robot, link_tree(text).as_ref(), &VisualMeshes::default());
    assert_eq!(
        description,
        Description::of_robot(&robot, None, &VisualMeshes::default())
    );
}

#[test]
fn a_name_cannot_end_the_script_that_holds_the_data() {
    let mut robot = robot(&urdf("volksbot"));
    robot.name = "</script><script>alert(1)</script>".to_owned();
    let scene = Scene::new(
        Description::of_robot(&robot, None, &VisualMeshes::default()),
        Frames::at_rest(&robot),
    );
    let data = embed::data(&scene).expect("a scene is JSON");
    assert!(!data.contains('<'));
    let read: Scene = serde_json::from_str(&data).expect("it is read again");
    assert_eq!(read, scene);
}

#[test_case("mecanum4")]
#[test_case("mecanum4_6_rollers")]
#[test_case("mecanum4_12_rollers")]
#[test_case("mecanum4_hard_rollers")]
#[test_case("mecanum4_payload")]
#[test_case("mecanum6")]
#[test_case("volksbot")]
fn every_shipped_robot_is_described_in_few_bytes_without_a_number_that_is_none(name: &str) {
    let urdf = urdf(name);
    let description = Description::of_robot(
        &robot(&urdf),
        link_tree(&urdf).as_ref(),
        &VisualMeshes::default(),
    );
    assert_finite(&description);
    let bytes = serde_json::to_string(&description).expect("JSON").len();
    assert!(bytes < 20_000, "{bytes}");
}

fn isometry(pose: [f32; 7]) -> Isometry3<f64> {
    let [x, y, z, i, j, k, w] = pose.map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

#[test_case("mecanum4")]
#[test_case("mecanum4_6_rollers")]
#[test_case("mecanum6")]
#[test_case("volksbot")]
fn a_wheel_stands_on_the_floor_at_every_angle_as_it_is_drawn(name: &str) {
    let robot = robot(&urdf(name));
    let shape = Description::of_robot(&robot, None, &VisualMeshes::default()).robot;
    for wheel in &shape.wheels {
        let body_from_hub = isometry(wheel.body_from_hub);
        for step in 0..20 {
            let turned = Isometry3::rotation(Vector3::z() * 0.17 * f64::from(step));
            let lowest_m = wheel
                .rollers
                .iter()
                .flat_map(|roller| {
                    let placed = body_from_hub * turned * isometry(roller.hub_from_roller);
                    // The lowest point of a circle about the axis: down, without the part along the
                    // axis.
                    let axis = placed * Vector3::z();
                    let down = (axis * axis.z - Vector3::z()).normalize();
                    let circles = shape.lathes[roller.lathe].iter();
                    circles.map(move |[z, r]| {
                        let center = placed * Point3::new(0.0, 0.0, f64::from(*z));
                        (center + down * f64::from(*r)).z
                    })
                })
                .fold(f64::INFINITY, f64::min);
            let above_m = lowest_m + robot.ride_height_m();
            // Between the circles of the outline its chords lie at most a hundredth of the roller's
            // radius inside; f32.
            let most_m = 0.01 * robot.wheels[0].rollers[0].radius_m;
            assert!(
                (-1e-7..most_m).contains(&above_m),
                "{above_m} of {} at {step}",
                wheel.name
            );
        }
    }
}

/// A robot whose wheels hang on driven slides, which start 10 mm down: it stands 10 mm higher, with
/// its joints at their start positions.
#[test]
fn a_robot_at_rest_stands_on_its_joints_where_they_start() {
    let at_rest = |target_m: f64| {
        let mut options = LoadOptions::default();
        for wheel in ["front_left", "front_right", "rear_left", "rear_right"] {
            let slide = JointOptions {
                role: Some(RoleOption::Driven),
                target_m: Some(target_m),
                ..JointOptions::default()
            };
            options.joints.insert(format!("{wheel}_spring"), slide);
        }
        let text = urdf("mecanum4_sprung");
        let loaded = Robot::from_urdf_str_with(&text, "robot.urdf", &options);
        ilon_scene::Frame::at_rest(&loaded.expect("a shipped robot is read").robot)
    };
    let (before, after) = (at_rest(0.0), at_rest(-0.01));
    let higher_m = after.height_m - before.height_m;
    assert!((higher_m - 0.01).abs() < 1e-9, "{higher_m}");
    assert_eq!(after.joints, [-0.01; 4]);
}
