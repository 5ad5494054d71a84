//! A drawing of a robot from above: chassis, wheels, the axes of the touching rollers, and the
//! vectors b_h.
//!
//! The body's x axis points right and its y axis up, as on a map. Colours are from the palette of
//! Okabe and Ito for the colour-blind; elements that differ in colour also differ in form. The
//! picture has no external references and no ids, so that several fit on one page.

use ilon_robot::Robot;
use ilon_trace::Header;
use nalgebra::Vector2;
use svg::Node;
use svg::node::element::{Polygon, Text};

#[cfg(feature = "studies")]
mod limits;
mod map;
mod marks;
mod wheel;

#[cfg(feature = "studies")]
pub use limits::limits;
use map::*;
use marks::{axes, diamond, legend, page, scale_bar};
use wheel::{b_h, b_h_name, common_figures, label, roller_axis, wheel_from_above};

/// Returns a robot as an SVG, with its joints at the start of a run, and with the point of the body
/// frame, in metres, about which position and heading are decoupled; a missing or infinitely far
/// one is not drawn.
pub fn svg(robot: &Robot, decoupling_point_m: Option<Vector2<f64>>) -> String {
    let near = |point: &Vector2<f64>| point.iter().all(|x| x.is_finite());
    let standing = robot.posed(&robot.start_positions());
    draw(
        &Header::of_robot(&standing),
        decoupling_point_m.filter(near),
    )
}

/// Returns the robot of a trace as an SVG.
pub(crate) fn svg_of_trace(header: &Header) -> String {
    draw(header, None)
}

fn draw(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> String {
    let map = Map::of(header, decoupling_point_m);
    let name = printable(&header.robot_name);
    let head = Text::new(format!("{name}, seen from above"));
    let head = head.set("x", 40).set("y", 36);
    let mut picture = page(SIZE_PX, &format!("{name} from above"), head);
    if let Some(figures) = common_figures(&header.wheels) {
        picture.append(
            Text::new(figures)
                .set("x", 40)
                .set("y", 56)
                .set("fill", GREY),
        );
    }
    for outline in &header.chassis_outlines_m {
        picture.append(
            Polygon::new()
                .set(
                    "points",
                    map.points(outline.iter().map(|&p| Vector2::from(p))),
                )
                .set("fill", CHASSIS)
                .set("fill-opacity", 0.7)
                .set("stroke", GREY),
        );
    }
    for wheel in &header.wheels {
        picture.append(wheel_from_above(&map, wheel));
    }
    for wheel in &header.wheels {
        picture.append(b_h(&map, wheel));
    }
    picture.append(axes(&map));
    for (index, wheel) in header.wheels.iter().enumerate() {
        if !wheel.has_tyre() {
            picture.append(roller_axis(&map, wheel));
        }
        picture.append(b_h_name(&map, index, wheel));
        picture.append(label(&map, header, wheel));
    }
    if let Some(point_m) = decoupling_point_m {
        picture.append(diamond(map.px(point_m)));
    }
    picture.append(scale_bar(&map));
    picture.append(legend(header, decoupling_point_m));
    picture.to_string() + "\n"
}

#[cfg(test)]
mod tests {
    use ilon_trace::WheelHeader;

    use super::*;
    use ilon_formats::LoadRobot;
    use ilon_robot::{
        Body, BodyJoint, Collision, CollisionShape, JointKind, JointRole, JointServo,
        MassProperties,
    };
    use nalgebra::{Isometry3, Vector3};

    /// A wheel 40 mm wide of radius 50 mm, its axis along y: 20 mm to either side, 50 ahead and
    /// back.
    #[test]
    fn a_wheel_is_drawn_as_wide_and_as_long_as_it_is() {
        let wheel = &header().wheels[0];
        let corners = map::corners_m(wheel).map(|at| at - Vector2::from(wheel.position_m));
        for corner in corners {
            assert!((corner.x.abs() - 0.05).abs() < 1e-15 && (corner.y.abs() - 0.02).abs() < 1e-15);
        }
    }

    fn header() -> Header {
        let wheel = |name: &str, x: f64, y: f64| WheelHeader {
            name: name.to_owned(),
            position_m: [x, y],
            radius_m: 0.05,
            axis: [0.0, 1.0],
            width_m: 0.04,
            gamma_rad: 45f64.to_radians(),
            roller_count: 9,
            ..WheelHeader::default()
        };
        Header {
            robot_name: "a <robot> & \"more\"".to_owned(),
            wheels: vec![wheel("front", 0.2, 0.1), wheel("rear", -0.2, -0.1)],
            ..Header::default()
        }
    }

    #[test]
    fn the_picture_is_well_formed_whatever_names_hold() {
        let mut header = header();
        header.wheels[0].name = "\u{1}</svg>".to_owned();
        let picture = draw(&header, Some(Vector2::zeros()));
        let document = roxmltree::Document::parse(&picture).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        assert!(texts.iter().any(|t| t.trim() == "</svg>"), "{texts:?}");
        assert!(texts.iter().any(|t| t.contains("a <robot> & \"more\"")));
    }

    #[test]
    fn a_roller_axis_lies_where_gamma_says() {
        // n = y, gamma = 45 deg: u_gamma is y turned by 45 deg counter-clockwise, (-1, 1)/sqrt 2,
        // and n_gamma = k x u_gamma = (-1, -1)/sqrt 2: from the lower left to the upper right of a
        // map.
        let header = header();
        let map = Map::of(&header, None);
        let path = roller_axis(&map, &header.wheels[0]).to_string();
        let data = path.split("d=\"").nth(1).unwrap();
        let numbers: Vec<f64> = data[..data.find('"').unwrap()]
            .split(['M', 'L', ',', ' '])
            .filter_map(|word| word.parse().ok())
            .collect();
        let (dx, dy) = (numbers[2] - numbers[0], numbers[3] - numbers[1]);
        // The page's y points down; positions are rounded to a tenth.
        assert!((dx + dy).abs() < 0.3 && dx.abs() > 20.0, "{dx} {dy}");
    }

    /// A wheel's name and figures, two lines of 16 pixels whose letters reach 13 above their line,
    /// do not overlap the wheel's outline on the side where its axis points outward: above it,
    /// below it, or beside its middle.
    #[test]
    fn a_wheels_figures_stand_clear_of_it_on_each_side() {
        let mut header = header();
        let mut beside = header.wheels[0].clone();
        (beside.position_m, beside.axis) = ([0.2, -0.1], [1.0, 0.0]);
        header.wheels.push(beside);
        let map = Map::of(&header, None);
        for (wheel, side) in header.wheels.iter().zip(["above", "below", "beside"]) {
            let text = label(&map, &header, wheel).to_string();
            let y = text.split(" y=\"").nth(1).expect("it has a place");
            let y: f64 = y[..y.find('"').expect("an end")].parse().expect("a number");
            let (top, bottom) = (y - 13.0, y + 16.0);
            let corners = corners_m(wheel).map(|corner| map.px(corner).y);
            let highest = corners.iter().copied().fold(f64::INFINITY, f64::min);
            let lowest = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let middle = map.px(Vector2::from(wheel.position_m)).y;
            let is_clear = match side {
                "above" => bottom < highest,
                "below" => top > lowest,
                _ => (0.5 * (top + bottom) - middle).abs() < 4.0,
            };
            assert!(
                is_clear,
                "{side}: {top} to {bottom}, wheel {highest} to {lowest}"
            );
        }
    }

    #[test]
    fn everything_drawn_lies_in_the_picture() {
        let header = header();
        let map = Map::of(&header, None);
        for corner in header.wheels.iter().flat_map(corners_m) {
            let [x, y] = map.px(corner).into();
            assert!(
                (0.0..SIZE_PX.x).contains(&x) && (60.0..580.0).contains(&y),
                "{x} {y}"
            );
        }
    }

    /// A ball 0.3 m ahead on an arm whose servo starts a quarter turn to the left is drawn 0.3 m to
    /// the left.
    #[test]
    fn bodies_are_drawn_where_their_servos_start() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let with_ball_at = |x_m: f64, y_m: f64, target: f64| {
            let mut robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
            let ball = Collision {
                friction: None,
                body_from_shape: Isometry3::translation(x_m, y_m, 0.2),
                shape: CollisionShape::Sphere { radius_m: 0.05 },
            };
            robot.joints.push(BodyJoint {
                name: "arm".to_owned(),
                parent: None,
                kind: JointKind::Turns,
                body_from_joint: Isometry3::identity(),
                body: Body {
                    name: "arm".to_owned(),
                    mass: MassProperties::point(1.0, Vector3::zeros()),
                    collisions: vec![ball],
                },
                role: JointRole::Driven(JointServo {
                    target,
                    ..JointServo::for_inertia(1.0)
                }),
                limits: [-2.0, 2.0],
                damping: 0.0,
                friction: 0.0,
            });
            svg(&robot, None)
        };
        let turned = with_ball_at(0.3, 0.0, std::f64::consts::FRAC_PI_2);
        assert_eq!(turned, with_ball_at(0.0, 0.3, 0.0));
        assert_ne!(turned, with_ball_at(0.3, 0.0, 0.0));
    }

    #[test]
    fn an_infinitely_far_point_is_not_drawn_whichever_of_its_coordinates_is() {
        let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let without = svg(&robot, None);
        assert_ne!(svg(&robot, Some(Vector2::zeros())), without);
        for (x, y) in [(f64::INFINITY, 0.0), (0.0, f64::NAN)] {
            assert_eq!(svg(&robot, Some(Vector2::new(x, y))), without);
        }
    }
}
