//! A robot on a circle, in a bag for `ros2 bag play`, Foxglove, Rerun or PlotJuggler:
//! `cargo run --release --example circle -- FOLDER`

use ilon_messages::bag::{BagWriter, Qos};
use ilon_messages::builtin_interfaces::Time;
use ilon_messages::geometry_msgs::{Quaternion, Transform, TransformStamped, Vector3};
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::rosgraph_msgs::Clock;
use ilon_messages::std_msgs::{Header, String as Text};
use ilon_messages::tf2_msgs::TFMessage;

const ROBOT: &str = r#"<robot name="box"><link name="base_link"><visual><geometry><box size="0.6 0.4 0.2"/></geometry></visual></link></robot>"#;
const RADIUS_M: f64 = 1.5;
const RATE_RAD_S: f64 = 0.5;
const PERIOD_NS: u64 = 20_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args()
        .nth(1)
        .ok_or("name the folder for the bag")?;
    let mut bag = BagWriter::create(folder.as_ref())?;
    bag.declare::<Text>("/robot_description", Qos::reliable(1).transient_local())?;
    bag.declare::<Clock>("/clock", Qos::best_effort(1))?;
    bag.declare::<TFMessage>("/tf", Qos::reliable(100))?;
    bag.declare::<Odometry>("/odom", Qos::reliable(10))?;
    bag.write(
        "/robot_description",
        &Text { data: ROBOT.into() },
        PERIOD_NS,
    )?;
    // Time begins above zero, which tf2 takes for "the latest".
    for period in 1..=1000 {
        let time_ns = period * PERIOD_NS;
        let stamp = Time::from_nanoseconds(time_ns).ok_or("the time is too late for ROS 2")?;
        let header = Header {
            stamp,
            frame_id: "odom".into(),
        };
        let angle = RATE_RAD_S * time_ns as f64 * 1e-9;
        let (x, y) = (RADIUS_M * angle.sin(), RADIUS_M * (1.0 - angle.cos()));
        let rotation = Quaternion {
            z: (angle / 2.0).sin(),
            w: (angle / 2.0).cos(),
            ..Default::default()
        };
        let transform = Transform {
            translation: Vector3 { x, y, z: 0.0 },
            rotation,
        };
        let frame = TransformStamped {
            header: header.clone(),
            child_frame_id: "base_link".into(),
            transform,
        };
        let mut odometry = Odometry {
            header,
            child_frame_id: "base_link".into(),
            ..Default::default()
        };
        odometry.pose.pose.position.x = x;
        odometry.pose.pose.position.y = y;
        odometry.pose.pose.orientation = rotation;
        odometry.twist.twist.linear.x = RADIUS_M * RATE_RAD_S;
        odometry.twist.twist.angular.z = RATE_RAD_S;
        bag.write("/clock", &Clock { clock: stamp }, time_ns)?;
        bag.write(
            "/tf",
            &TFMessage {
                transforms: vec![frame],
            },
            time_ns,
        )?;
        bag.write("/odom", &odometry, time_ns)?;
    }
    Ok(bag.finish()?)
}
