//! A scenario written in Rust instead of a file, and changed from run to run: a mecanum robot's
//! sideways motion depends only on geometry, not on the floor.

use ilon::Scenario;

const SIDEWAYS: &str = r#"
[robot]
file = "assets/robots/mecanum4.urdf"

[twist]
vy_m_s = 0.3

[run]
duration_s = 5.5
"#;

fn main() -> Result<(), ilon::Error> {
    let mut scenario = Scenario::from_toml(SIDEWAYS, "sideways", ".")?;
    println!("friction  real/ideal  real/touching rollers");
    for friction in [0.2, 0.6, 1.0] {
        scenario.world.floor.friction = Some(friction);
        let summary = ilon::run(&scenario)?.summary;
        let ideal = summary.twist_ratio_ideal.vy.unwrap_or(f64::NAN);
        let contact = summary.twist_ratio_contact.vy.unwrap_or(f64::NAN);
        println!("{friction:8.1}  {ideal:10.4}  {contact:21.4}");
        // Nine rollers at 45 deg: sin(20 deg) / 20 deg = 0.980 by geometry; the rest is slip, and
        // small.
        assert!((ideal - 0.980).abs() < 0.005 && (contact - 1.0).abs() < 0.005);
    }
    Ok(())
}
