//! A planar base as the files that others read.

use std::fmt::Write;

use serde_json::Value;

use super::drives::PlanarDrive;
use super::model::SERVO_S;
use super::{Joints, Planar};
use crate::Error;

/// The files of a planar base, by name: `planar.json` with all of it, `planar.py` for numpy, `planar.xml` for MuJoCo, `planar.sdf` for Gazebo,
/// and `held_out.csv` with the drives by which it was judged.
///
/// # Errors
/// [`Error::Invalid`] where a number is none, of a robot that went nowhere.
pub fn files(
    planar: &Planar,
    judges: &[PlanarDrive],
    dt_s: f64,
) -> Result<Vec<(&'static str, String)>, Error> {
    let is_whole = serde_json::to_value(planar).is_ok_and(|value| is_whole(&value));
    let json = serde_json::to_string_pretty(planar).ok();
    let json = json.filter(|_| is_whole).ok_or_else(|| {
        Error::invalid(
            format!(
                "no planar base fits `{}`: a number of it is none",
                planar.robot
            ),
            "look at how the robot drives with `ilon run`",
        )
    })?;
    Ok(vec![
        ("planar.json", json + "\n"),
        ("planar.py", include_str!("planar.py").to_owned()),
        ("planar.xml", mjcf(planar)),
        ("planar.sdf", sdf(planar)),
        ("held_out.csv", csv(judges, dt_s)),
    ])
}

/// Whether all numbers are some: one that is none is null.
fn is_whole(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Array(values) => values.iter().all(is_whole),
        Value::Object(values) => values.values().all(is_whole),
        _ => true,
    }
}

/// What each file says of where it comes from, and how far it is off.
fn about(planar: &Planar) -> String {
    let [joints, ideal] = [planar.held_out.joints, planar.held_out.ideal];
    format!(
        "A base in the plane that moves as the robot `{}` does in ilon {}, on a floor of friction {}.\n     \
         On {} drives of {:.1} s that it was not fitted to, its position at the end is off by {:.2} % of the path (ideal kinematics: {:.2} %).",
        name(planar),
        env!("CARGO_PKG_VERSION"),
        planar.friction,
        planar.held_out.drives,
        planar.held_out.duration_s,
        1e2 * joints.position_over_path,
        1e2 * ideal.position_over_path,
    )
}

/// The robot's name, of letters that mean nothing in XML.
fn name(planar: &Planar) -> String {
    let plain = |letter: char| match letter.is_alphanumeric() || "_- .".contains(letter) {
        true => letter,
        false => '_',
    };
    planar
        .robot
        .replace("--", "__")
        .chars()
        .map(plain)
        .collect()
}

/// Middle and half of the size of a box from one corner to another.
fn middle_and_half([least, most]: [[f64; 3]; 2]) -> ([f64; 3], [f64; 3]) {
    let of = |sign: f64| std::array::from_fn(|axis| 0.5 * (most[axis] + sign * least[axis]));
    (of(1.0), of(-1.0))
}

/// A body on two slides and a hinge, with servos along its own axes.
fn mjcf(planar: &Planar) -> String {
    let joints = &planar.joints;
    let Joints {
        mass_kg,
        center_m: [x, y, z],
        ..
    } = *joints;
    let along = 0.5 * (joints.inertia[0] + joints.inertia[1]);
    let turning = joints.inertia[2] - mass_kg * (x * x + y * y);
    let (middle, half) = middle_and_half(joints.box_m);
    let text = |of: [f64; 3]| format!("{:.6} {:.6} {:.6}", of[0], of[1], of[2]);
    let [friction, damping] = [joints.friction, joints.damping].map(|of| 0.5 * (of[0] + of[1]));
    let mut xml = format!(
        r#"<!-- {about}
     Controls are the twist that is asked: ahead and to the left in m/s, turning in rad/s, in the body frame. The servos' filter is the
     wheel loops' lag, their gain the shortfall, their force range grip and motors, the armature wheels that turn; frictionloss and damping
     are what a base that is pushed feels while its servos are off (disableactuator of their group, 1). Steps of up to {longest} s. -->
<mujoco model="{name}">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="base_link" pos="0 0 {up:.6}">
      <inertial pos="{x:.6} {y:.6} {z:.6}" mass="{mass_kg:.6}" diaginertia="{turning:.6} {turning:.6} {turning:.6}"/>
      <joint name="slide_x" type="slide" axis="1 0 0" armature="{armature:.6}" frictionloss="{friction:.6}" damping="{damping:.6}"/>
      <joint name="slide_y" type="slide" axis="0 1 0" armature="{armature:.6}" frictionloss="{friction:.6}" damping="{damping:.6}"/>
      <joint name="turn" type="hinge" axis="0 0 1" frictionloss="{turn_friction:.6}" damping="{turn_damping:.6}"/>
      <geom name="base" type="box" pos="{middle}" size="{half}" rgba="0.2 0.4 0.7 1"/>
      <site name="base"/>
    </body>
  </worldbody>
  <actuator>
"#,
        about = about(planar),
        longest = SERVO_S,
        name = name(planar),
        up = joints.height_m,
        armature = along - mass_kg,
        turn_friction = joints.friction[2],
        turn_damping = joints.damping[2],
        middle = text(middle),
        half = text(half),
    );
    let axes = [
        ("ahead", "1 0 0 0 0 0"),
        ("left", "0 1 0 0 0 0"),
        ("turn", "0 0 0 0 0 1"),
    ];
    for (axis, (name, gear)) in axes.into_iter().enumerate() {
        // The joints move one mass in all directions.
        let inertia = if axis == 2 { joints.inertia[2] } else { along };
        let most = joints.most[axis] * inertia / joints.inertia[axis];
        let kv = inertia / SERVO_S;
        let _ = writeln!(
            xml,
            r#"    <general name="{name}" site="base" gear="{gear}" group="1" dyntype="filter" dynprm="{lag:.6}" gainprm="{gain:.6}" biastype="affine" biasprm="0 0 {bias:.6}" ctrllimited="true" ctrlrange="{least:.6} {top:.6}" forcelimited="true" forcerange="{weakest:.6} {most:.6}"/>"#,
            lag = joints.lag_s,
            gain = kv * joints.gain[axis],
            bias = -kv,
            least = -planar.top[axis],
            top = planar.top[axis],
            weakest = -most,
        );
    }
    xml + "  </actuator>\n</mujoco>\n"
}

/// A chain of two prismatic joints and one that turns.
fn sdf(planar: &Planar) -> String {
    let joints = &planar.joints;
    let [x, y, z] = joints.center_m;
    let along = 0.5 * (joints.inertia[0] + joints.inertia[1]);
    let turning = joints.inertia[2] - along * (x * x + y * y);
    let (middle, half) = middle_and_half(joints.box_m);
    let small = 1e-4;
    let light = small * turning;
    let mut xml = format!(
        r#"<?xml version="1.0"?>
<!-- {about}
     These joints lie in the world's frame, so that along both of them the lesser force and the mean friction hold. What moves with the base,
     wheels that turn too, is in its mass. Lag and shortfall are not in joints: planar.json has them. -->
<sdf version="1.9">
  <model name="{name}">
    <pose>0 0 {up:.6} 0 0 0</pose>
    <link name="along_x"><inertial><mass>{light_kg:.6}</mass><inertia><ixx>{light:.8}</ixx><iyy>{light:.8}</iyy><izz>{light:.8}</izz></inertia></inertial></link>
    <link name="along_y"><inertial><mass>{light_kg:.6}</mass><inertia><ixx>{light:.8}</ixx><iyy>{light:.8}</iyy><izz>{light:.8}</izz></inertia></inertial></link>
    <link name="base_link">
      <inertial><pose>{x:.6} {y:.6} {z:.6} 0 0 0</pose><mass>{along:.6}</mass><inertia><ixx>{turning:.6}</ixx><iyy>{turning:.6}</iyy><izz>{turning:.6}</izz></inertia></inertial>
"#,
        about = about(planar),
        name = name(planar),
        up = joints.height_m,
        light_kg = small * along,
    );
    for shape in ["collision", "visual"] {
        let _ = writeln!(
            xml,
            r#"      <{shape} name="{shape}"><pose>{:.6} {:.6} {:.6} 0 0 0</pose><geometry><box><size>{:.6} {:.6} {:.6}</size></box></geometry></{shape}>"#,
            middle[0],
            middle[1],
            middle[2],
            2.0 * half[0],
            2.0 * half[1],
            2.0 * half[2],
        );
    }
    xml += "    </link>\n";
    let least = |of: [f64; 3]| of[0].min(of[1]);
    let mean = |of: [f64; 3]| 0.5 * (of[0] + of[1]);
    let level = [
        least(joints.most),
        least(planar.top),
        mean(joints.damping),
        mean(joints.friction),
    ];
    let turn = [
        joints.most[2],
        planar.top[2],
        joints.damping[2],
        joints.friction[2],
    ];
    for (name, kind, parent, child, axis, [effort, velocity, damping, friction]) in [
        ("slide_x", "prismatic", "world", "along_x", "1 0 0", level),
        ("slide_y", "prismatic", "along_x", "along_y", "0 1 0", level),
        ("turn", "revolute", "along_y", "base_link", "0 0 1", turn),
    ] {
        let _ = write!(
            xml,
            r#"    <joint name="{name}" type="{kind}">
      <parent>{parent}</parent>
      <child>{child}</child>
      <axis>
        <xyz>{axis}</xyz>
        <limit><lower>-1e16</lower><upper>1e16</upper><effort>{effort:.6}</effort><velocity>{velocity:.6}</velocity></limit>
        <dynamics><damping>{damping:.6}</damping><friction>{friction:.6}</friction></dynamics>
      </axis>
    </joint>
"#
        );
    }
    xml + "  </model>\n</sdf>\n"
}

/// Drives as a table: number, time, the twist that was asked, the twist that came.
fn csv(drives: &[PlanarDrive], dt_s: f64) -> String {
    let mut text =
        "drive,t_s,asked_vx_m_s,asked_vy_m_s,asked_omega_rad_s,vx_m_s,vy_m_s,omega_rad_s\n"
            .to_owned();
    for (number, drive) in drives.iter().enumerate() {
        for (step, (asked, came)) in drive.asked.iter().zip(&drive.came).enumerate() {
            let _ = write!(text, "{number},{:.6}", (step + 1) as f64 * dt_s);
            for value in asked.iter().chain(came) {
                let _ = write!(text, ",{value:.7}");
            }
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::is_whole;

    /// A name may be anything; a number that is none is found however deep it lies.
    #[test]
    fn numbers_that_are_none_are_found_and_names_are_not_looked_at() {
        assert!(is_whole(
            &json!({ "robot": "nullbot: null", "grip": { "most": [1.0, 2.0] } })
        ));
        let infinite = json!({ "robot": "bot", "grip": { "most": [1.0, f64::INFINITY] } });
        assert!(!is_whole(&infinite));
    }
}
