//! Prints docs/terrain.md with its tables: what the laws of wheel torques do on ground that they do
//! not know.
//!
//! `cargo run --release -p ilon-sim --example terrain > docs/terrain.md`

use ilon_sim::simulate::Simulation;
use ilon_sim::{Error, Scenario};
use ilon_trace::Summary;

/// The laws, each as its keys, without and with the IMU.
const LAWS: [(&str, &str); 6] = [
    ("rate loops", GUIDED),
    (
        "computed torque",
        "[guidance]\nposition_gain_per_s = 5\nheading_gain_per_s = 5.7\n[wheel_loop]\nlaw = \"computed_torque\"",
    ),
    (
        "by priority",
        "[guidance]\nposition_gain_per_s = 5\nheading_gain_per_s = 5.7\n[wheel_loop]\nlaw = \"prioritised_torque\"",
    ),
    (
        "passive, uncoupled",
        "[wheel_loop]\nlaw = \"passive\"\npassive = { stiffness_n_m = 600, damping_n_s_m = 120, heading_stiffness_n_m_rad = 20, heading_damping_n_m_s_rad = 3.5, wheel_stiffness_n_m_rad = 0, wheel_damping_n_m_s_rad = 0 }",
    ),
    ("passive", PASSIVE),
    ("passive, IMU", PASSIVE),
];
const GUIDED: &str = "[guidance]\nposition_gain_per_s = 5\nheading_gain_per_s = 5.7";
const PASSIVE: &str = "[wheel_loop]\nlaw = \"passive\"\npassive = { stiffness_n_m = 600, damping_n_s_m = 120, heading_stiffness_n_m_rad = 20, heading_damping_n_m_s_rad = 3.5 }";

const SPRINGS: [&str; 2] = [
    "stiffness_n_m = 600, damping_n_s_m = 120, heading_stiffness_n_m_rad = 20, heading_damping_n_m_s_rad = 3.5, ",
    "stiffness_n_m = 600, damping_n_s_m = 120, heading_stiffness_n_m_rad = 20, heading_damping_n_m_s_rad = 3.5 ",
];
const STAND: &str = "[reference.hold_pose]\nx_m = 0\ny_m = 0\nheading_deg = 0";
const ICE: &str = "[[world.floor.patches]]\nx_m = 0.15\ny_m = 0.16\nlength_x_m = 0.1\nlength_y_m = 0.1\nfriction = 0.02";
const SLOPE: &str = "[world.floor]\nslope_deg = 5";
const ROCKING: &str = "[[faults]]\ntilt = { amplitude_deg = 4, frequency_hz = 0.5 }";
const PUSH: &str = "[[faults]]\npush = { impulse_y_n_s = 40, from_s = 2, lasts_s = 2 }";
const EIGHT: &str =
    "[reference.figure_eight]\nhalf_width_m = 0.8\nperiod_s = 8\nheading = { constant_deg = 0 }";
const BARS: &str = "[[world.floor.boxes]]\nx_m = 0.35\ny_m = 0.3\nlength_x_m = 0.03\nlength_y_m = 0.4\nheight_m = 0.004";
const OVER: &str =
    "[reference.line]\nto_x_m = 1.2\nto_y_m = 0\nspeed_m_s = 0.2\nheading = { constant_deg = 0 }";

const WHEELS: &str = "[robot.wheels]\nrollers = 9\nroller_radius_m = 0.012\nroller_mass_kg = 0.01\ndamping_n_m_s = 1e-6\ngamma.x_deg = 45";
const SWING: &str = "[robot.joints.arm]\nrole = \"driven\"\nsetpoints = [{ t_s = 0.5, position_rad = 0 }, { t_s = 1.1, position_rad = 1.5707963 }]";

/// A scene: its name, the robot, and everything except the law.
struct Scene {
    name: String,
    robot: String,
    keys: Vec<String>,
}

fn scene(name: &str, robot: &str, keys: &[&str]) -> Scene {
    Scene {
        name: name.to_owned(),
        robot: robot.to_owned(),
        keys: keys.iter().map(ToString::to_string).collect(),
    }
}

fn of_file(robot: &str) -> String {
    format!("[robot]\nfile = \"assets/robots/{robot}\"\nroller_bodies = \"near\"")
}

/// A robot of joints, whose file has plain wheels.
fn jointed(robot: &str) -> String {
    format!("[robot]\nfile = \"assets/robots/{robot}\"\n{WHEELS}")
}

fn sprung() -> String {
    let wheels = ["front_left", "front_right", "rear_left", "rear_right"];
    let springs = wheels.map(|wheel| {
        format!("[robot.joints.{wheel}_spring]\nstiffness_n_m = 4000\ndamping_n_s_m = 60")
    });
    let robot = jointed("mecanum4_sprung.urdf");
    format!("{robot}\n{}", springs.join("\n"))
}

fn scenes() -> Vec<Scene> {
    let four = of_file("mecanum4.urdf");
    let mut all = vec![
        scene("push 20 N for 2 s", &four, &[STAND, PUSH]),
        scene("slope 5 deg", &four, &[STAND, SLOPE]),
        scene("slope 5 deg, a wheel on ice", &four, &[STAND, SLOPE, ICE]),
    ];
    all.push(scene("rocking 4 deg, 0.5 Hz", &four, &[STAND, ROCKING]));
    all.push(scene(
        "rocking, a wheel on ice",
        &four,
        &[STAND, ROCKING, ICE],
    ));
    for (name, robot) in [("N = 3", "volksbot.urdf"), ("N = 6", "mecanum6.urdf")] {
        let robot = of_file(robot);
        let [x, y] = match name {
            "N = 3" => ["-0.125", "0.2165"],
            _ => ["0.32", "0.26"],
        };
        let ice = ICE.replace("0.15", x).replace("0.16", y);
        all.push(scene(
            &format!("{name}: slope 5 deg, a wheel on ice"),
            &robot,
            &[STAND, SLOPE, &ice],
        ));
    }
    all.push(scene(
        "bar 4 mm under the left wheels, rigid",
        &four,
        &[OVER, BARS],
    ));
    all.push(scene("the same, sprung wheels", &sprung(), &[OVER, BARS]));
    let arm = format!("{}\n{SWING}", jointed("mecanum4_arm.urdf"));
    all.push(scene("an arm of 2 kg swings out in 0.6 s", &arm, &[STAND]));
    all.push(scene("figure eight, 1 m/s", &four, &[EIGHT]));
    all
}

fn run(scene: &Scene, law: usize) -> Result<Summary, Error> {
    let imu = if law == 5 { "[sensors.imu]" } else { "" };
    let mut keys = LAWS[law].1.to_owned();
    if !scene.robot.contains("mecanum4") {
        // For another mass: springs that follow from it.
        for spring in SPRINGS {
            keys = keys.replace(spring, "");
        }
    }
    let text = format!(
        "{}\n{}\n{keys}\n{imu}\n[run]\nduration_s = 8\nphysics_dt_s = 0.001\n",
        scene.robot,
        scene.keys.join("\n"),
    );
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");
    let scenario = Scenario::from_toml(&text, "terrain", root)?;
    Ok(Simulation::new(&scenario)?.run().summary)
}

/// The largest and the final error in mm, and the loss to sliding in J; three numbers.
fn cell(summary: &Summary) -> String {
    let number = |value: Option<f64>, per: f64, decimals: usize| {
        value.map_or("-".to_owned(), |value| {
            format!("{:.decimals$}", value * per)
        })
    };
    [
        number(summary.position_error_max_m, 1e3, 2),
        number(summary.position_error_final_m, 1e3, 2),
        number(summary.slip_energy_j, 1.0, 3),
    ]
    .join("; ")
}

fn main() -> Result<(), Error> {
    println!("# Ground that the robot does not know\n");
    println!("{}\n", include_str!("terrain.md").trim_end());
    println!("| | {} |", LAWS.map(|(name, _)| name).join(" | "));
    println!("|---|{}", "---|".repeat(LAWS.len()));
    for scene in scenes() {
        let cells: Result<Vec<String>, Error> = (0..LAWS.len())
            .map(|law| Ok(cell(&run(&scene, law)?)))
            .collect();
        println!("| {} | {} |", scene.name, cells?.join(" | "));
    }
    Ok(())
}
