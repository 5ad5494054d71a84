//! Arbitrary bytes, in any number.

use super::bare_wheels::rollers;
use super::load;
use crate::traits::common::{SPEC, options, small};
use ilon_formats::{LoadOptions, LoadRobot, Spec, generate};
use ilon_robot::Robot;

/// `ILON_DAMAGE_ROUNDS=100000` runs more cases.
#[test]
fn no_damage_to_the_text_fells_the_loader() {
    let text = small();
    let rounds =
        std::env::var("ILON_DAMAGE_ROUNDS").map_or(600, |r| r.parse().expect("a number of rounds"));
    // A linear congruential generator (Knuth's MMIX constants): the same damage in every run.
    let mut state = 1973u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let spices = [
        "0",
        "-1",
        "1e308",
        "nan",
        "inf",
        "\"",
        "<",
        "</link>",
        "continuous",
        "fixed",
        "",
        " ",
        "1e-320",
        "&amp;",
        "\u{fffd}",
        "<limit/>",
        "base_link",
        "1e9",
    ];
    let options = [
        LoadOptions::default(),
        options(|o| {
            o.repair = true;
        }),
        options(|o| {
            o.wheels = Some(rollers());
        }),
    ];
    let mut loaded = 0;
    for round in 0..rounds {
        let mut damaged = text.clone();
        for _ in 0..=random(3) {
            let boundary = |i: usize| {
                (0..=i)
                    .rev()
                    .find(|&i| damaged.is_char_boundary(i))
                    .unwrap_or(0)
            };
            let from = boundary(random(damaged.len()));
            let to = boundary((from + random(40)).min(damaged.len())).max(from);
            damaged.replace_range(from..to, spices[random(spices.len())]);
        }
        match Robot::from_urdf_str_with(&damaged, "damaged.urdf", &options[round % 3]) {
            Ok(robot) => {
                loaded += 1;
                let finite = |w: &ilon_robot::Wheel| {
                    w.radius_m.is_finite() && w.hub.inertia_kg_m2.iter().all(|x| x.is_finite())
                };
                assert!(robot.robot.wheels.iter().all(finite));
            }
            Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
        }
    }
    // Some damage hits text that is not read; most does not.
    assert!(loaded > 0 && loaded < rounds, "{loaded}");
}

#[test]
fn a_closing_bracket_in_quotes_closes_no_element() {
    let mut text = small().replace("</robot>", "");
    for i in 0..200 {
        text += &format!("<gazebo reference=\"a > b {i}\"/>\n");
    }
    assert_eq!(load(&(text + "</robot>")).wheels.len(), 3);
}

#[test]
fn thousands_of_rollers_load_in_good_time() {
    let spec = SPEC.replace("per_row = 8", "per_row = 1000");
    let text = generate(&Spec::from_toml_str(&spec, "many.toml").expect("good")).expect("in range");
    let start = std::time::Instant::now();
    assert_eq!(load(&text).wheels[0].rollers.len(), 1000);
    // A second or two on a slow machine; anything quadratic takes minutes.
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    println!("{} bytes in {:?}", text.len(), start.elapsed());
}

#[test]
fn a_long_chain_of_links_loads_in_good_time() {
    let mut chain = String::new();
    for i in 0..20_000 {
        let parent = if i == 0 {
            "base_link".to_owned()
        } else {
            format!("c{}", i - 1)
        };
        chain += &format!(
            "<link name=\"c{i}\"/><joint name=\"c{i}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"c{i}\"/></joint>\n"
        );
    }
    let start = std::time::Instant::now();
    assert_eq!(
        load(&small().replace("</robot>", &(chain + "</robot>")))
            .wheels
            .len(),
        3
    );
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    println!("{:?}", start.elapsed());
}
