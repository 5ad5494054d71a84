//! `ilon inspect --limits`: the speeds and accelerations that a robot can reach.

use crate::support::{Folder, ended_with, stdout};

/// The largest acceleration from rest of a motion, with its limiting cause.
fn from_rest(json: &serde_json::Value, motion: &str) -> (f64, String) {
    let rows = json["limits"]["rows"].as_array().expect("rows");
    let row = rows
        .iter()
        .find(|row| row["motion"] == motion && row["speed"] == 0.0)
        .expect("a row at rest");
    let limit = &row["speeding_up"];
    let cause = limit["cause"].as_str().expect("a cause").to_owned();
    (limit["largest"].as_f64().expect("a number"), cause)
}

/// Half of the friction leaves about half of the acceleration; with a motor of 0.01 N m the motor
/// is the limit.
#[test]
fn limits_follow_the_conditions_that_are_set() {
    let folder = Folder::new();
    let inspected = |further: &[&str]| -> serde_json::Value {
        let mut arguments = vec!["inspect", "robot.urdf", "--limits", "--json"];
        arguments.extend(further);
        let out = folder.ilon(&arguments);
        ended_with(0, &out);
        serde_json::from_str(&stdout(&out)).expect("JSON")
    };
    let grippy = from_rest(&inspected(&["--set", "world.floor.friction=0.4"]), "back");
    let slippery = from_rest(&inspected(&["--set", "world.floor.friction=0.2"]), "back");
    let ratio = slippery.0 / grippy.0;
    assert!((0.5..0.6).contains(&ratio), "{ratio}");
    assert_eq!(slippery.1, "grip");
    let weak = "motors.dc={stall_torque_n_m=0.01,no_load_rate_rad_s=20}";
    assert_eq!(from_rest(&inspected(&["--set", weak]), "ahead").1, "motor");
}

#[test]
fn the_table_names_wheels_and_what_is_set_for_nothing_is_refused() {
    let folder = Folder::new();
    let table = folder.ilon(&[
        "inspect",
        "robot.urdf",
        "--limits",
        "--ros2-controllers",
        "c.yaml",
    ]);
    let words = stdout(&table);
    assert!(
        words.contains("turning left") && words.contains("wheel_1"),
        "{words}"
    );
    let yaml = folder.read("c.yaml");
    assert!(
        yaml.contains("ax_max: ") && yaml.contains("max_decel: [-"),
        "{yaml}"
    );
    // DWB has the same values, under its own names.
    let value = |key: &str| -> f64 {
        let at = yaml.find(&format!(" {key}: ")).expect(key);
        let rest = &yaml[at + key.len() + 3..];
        rest.lines()
            .next()
            .and_then(|text| text.parse().ok())
            .expect(key)
    };
    for (dwb, mppi) in [
        ("acc_lim_x", "ax_max"),
        ("decel_lim_y", "ay_min"),
        ("acc_lim_theta", "az_max"),
        ("max_vel_y", "vy_max"),
        ("min_vel_x", "vx_min"),
        ("max_vel_theta", "wz_max"),
    ] {
        assert_eq!(value(dwb), value(mppi), "{yaml}");
    }
    let idle = folder.ilon(&["inspect", "robot.urdf", "--set", "world.floor.friction=0.2"]);
    assert!(ended_with(2, &idle).contains("add --limits"));
    let key = "world.flor.friction=1";
    let unknown = folder.ilon(&["inspect", "robot.urdf", "--limits", "--set", key]);
    assert!(ended_with(2, &unknown).contains("did you mean `floor`"));
}

/// The outline is that of the table, the polytope contains the box reduced by a tenth, and the
/// picture and the page show both.
#[test]
fn limits_are_drawn_and_given_as_a_polytope() {
    let folder = Folder::new();
    let out = folder.ilon(&[
        "inspect",
        "robot.urdf",
        "--limits",
        "--json",
        "--svg",
        "l.svg",
        "--html",
        "l.html",
    ]);
    ended_with(0, &out);
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).expect("JSON");
    let limits = &json["limits"];
    let at_rest = &limits["outlines"][0];
    assert_eq!(at_rest["share_of_top"], 0.0);
    for (eighth, motion) in ["ahead", "ahead and left", "left"].into_iter().enumerate() {
        let point = &at_rest["points"][9 * eighth];
        assert_eq!(point["direction_deg"], 45.0 * eighth as f64);
        assert_eq!(point["largest"].as_f64(), Some(from_rest(&json, motion).0));
    }
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        let numbers = value.as_array().expect("numbers");
        numbers
            .iter()
            .map(|x| x.as_f64().expect("a number"))
            .collect()
    };
    let sides = limits["polytope"]["half_spaces"]
        .as_array()
        .expect("half-spaces");
    let share = |point: &[f64]| {
        let products = sides.iter().map(|side| {
            let side = numbers(side);
            side.iter().zip(point).map(|(a, b)| a * b).sum::<f64>()
        });
        products.fold(0.0, f64::max)
    };
    let corners = limits["polytope"]["corners"].as_array().expect("corners");
    for corner in corners {
        assert!((share(&numbers(corner)) - 1.0).abs() < 1e-5);
    }
    let of_box = numbers(&limits["acceleration_box"]);
    let largest = (0..8).map(|corner: usize| {
        let signed = |axis: usize| {
            if corner >> axis & 1 == 1 {
                -of_box[axis]
            } else {
                of_box[axis]
            }
        };
        share(&[signed(0), signed(1), signed(2)])
    });
    let largest = largest.fold(0.0, f64::max);
    // The box is 0.9 of one that touches the boundary, and the polytope underestimates that by a
    // few per cent at most.
    assert!((0.9 - 1e-9..0.9 / 0.94).contains(&largest), "{largest}");
    let (picture, page) = (folder.read("l.svg"), folder.read("l.html"));
    for shown in [&picture, &page] {
        assert!(shown.contains("accelerations without slip"));
    }
    // From rest each piece has the colour of its wheel; at speed an outline is one thin line.
    let pieces = picture.matches("stroke-linecap=\"round\"").count();
    assert_eq!(Some(pieces), at_rest["points"].as_array().map(Vec::len));
    assert!(picture.contains("wheel_1") && page.contains("How hard it may be driven"));
}
