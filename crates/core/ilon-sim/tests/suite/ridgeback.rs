//! A Ridgeback, whose front axle is on a rocker, with a kerb under its front left wheel: loads by
//! statics, up to the rocker's stop and at it.

use std::path::Path;

use ilon_sim::{Plant, Scenario, WheelCommand};
use nalgebra::{Matrix3, Rotation3, Vector3};
use test_case::test_case;

const FRONT_LEFT: usize = 0;
/// Half of the track, and half of the wheelbase, in metres.
const HALF_TRACK_M: f64 = 0.2755;
const AXLE_M: f64 = 0.319;
/// Its mass, and its centre of mass in the body frame: chassis of 165.304 kg, two axles of 10.267
/// kg and four wheels of 2.3 kg, of which axles and wheels lie around (0, 0, 0.05).
const MASS_KG: f64 = 165.304 + 2.0 * 10.267 + 4.0 * 2.3;
const STOP_RAD: f64 = 0.08726;

fn center_m() -> Vector3<f64> {
    let axles_and_wheels_kg = MASS_KG - 165.304;
    let chassis = 165.304 * Vector3::new(0.012, 0.002, 0.067);
    (chassis + axles_and_wheels_kg * Vector3::new(0.0, 0.0, 0.05)) / MASS_KG
}

/// The robot at rest with a kerb of a given height under its front left wheel, and the rocker's
/// keys. The ground is ice, so that only normal forces bear it: braked wheels at different heights
/// may otherwise push against one another.
fn plant(kerb_m: f64, rocker: &str) -> Plant {
    let kerb = match kerb_m {
        0.0 => String::new(),
        _ => format!(
            "[[world.floor.boxes]]\nx_m = {AXLE_M}\ny_m = {HALF_TRACK_M}\nlength_x_m = 0.2\nlength_y_m = 0.1\nheight_m = {kerb_m}\n"
        ),
    };
    let text = format!(
        "[robot]\nfile = \"ridgeback.urdf\"\n\
         wheels = {{ rollers = 12, roller_radius_m = 0.0152, roller_mass_kg = 0.0336, damping_n_m_s = 1e-6, gamma.x_deg = 45 }}\n\
         {rocker}\n\
         [world.floor]\nfriction = 0\n{kerb}\
         [twist]\nvx_m_s = 0\n[run]\nduration_s = 1\n"
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let scenario = Scenario::from_toml(&text, "ridgeback", folder).expect("a scenario");
    let mut plant = Plant::of_scenario(&scenario).expect("it stands");
    // The remaining error of the equilibrium decays.
    plant
        .advance(WheelCommand::Rates(&[0.0; 4]), 0.8)
        .expect("it stands");
    plant
}

/// Loads of the wheels, in N: front left, front right, rear left, rear right.
fn loads_n(plant: &Plant) -> [f64; 4] {
    let contacts = plant.world().robot().contacts();
    [0, 1, 2, 3].map(|wheel| contacts[wheel].normal_force_n)
}

const HELD: &str = "[robot.joints.front_rocker]\nrole = \"held\"";

/// Until its stop the rocker passes no torque: its wheels have equal loads, each half of the front
/// load by moments about the rear axle; the rear wheels share the rest by the lateral position of
/// the centre of mass.
#[test_case(0.0)]
#[test_case(0.005)]
#[test_case(0.01)]
#[test_case(0.02)]
fn wheels_on_a_rocker_bear_alike(kerb_m: f64) {
    let plant = plant(kerb_m, "");
    let [front_left, front_right, rear_left, rear_right] = loads_n(&plant);
    assert!(
        (front_left / front_right - 1.0).abs() < 0.01,
        "{front_left} {front_right}"
    );
    let weight_n = MASS_KG * 9.81;
    let state = plant.world().robot().state();
    // The front axle is raised by half of the kerb: the centre of mass moves back by its height
    // over the axles times the pitch.
    let center_m = Rotation3::from_euler_angles(state.roll_rad, state.pitch_rad, 0.0) * center_m();
    let front_n = weight_n * (0.5 + 0.5 * center_m.x / AXLE_M);
    assert!(
        ((front_left + front_right) / front_n - 1.0).abs() < 0.01,
        "{front_n}"
    );
    // The rocker's pivot and the rear wheels carry: three points, with the pivot in the middle. The
    // lateral positions of its wheels do not matter.
    let sides_n = weight_n * center_m.y / HALF_TRACK_M;
    let found_n = rear_left - rear_right;
    assert!(
        (found_n - sides_n).abs() < 0.01 * weight_n / 4.0,
        "{found_n} {sides_n}"
    );
    let rocker_rad = plant.world().robot().joint_positions()[0];
    let hand_rad = (kerb_m / (2.0 * HALF_TRACK_M)).asin();
    assert!(
        (rocker_rad - hand_rad).abs() < 1e-3,
        "{rocker_rad} {hand_rad}"
    );
}

/// At its stop the rocker is rigid, and the robot stands on three wheels: their loads are those of
/// statics on three points.
#[test]
fn at_the_stop_it_stands_on_three_wheels_as_statics_says() {
    let plant = plant(0.06, "");
    let robot = plant.world().robot();
    let rocker_rad = robot.joint_positions()[0];
    assert!((rocker_rad - STOP_RAD).abs() < 1e-3, "{rocker_rad}");
    stands_on_three(&plant);
}

/// A rigid one does so on any kerb.
#[test_case(0.005)]
#[test_case(0.02)]
fn a_rigid_one_stands_on_three_wheels(kerb_m: f64) {
    let plant = plant(kerb_m, HELD);
    assert!(plant.robot().joints.is_empty());
    stands_on_three(&plant);
}

/// If the centre of mass is right of the diagonal through the wheel on the kerb, as here, the left
/// rear wheel is up, and the others carry what balances the weight about each of them.
fn stands_on_three(plant: &Plant) {
    let robot = plant.world().robot();
    let state = robot.state();
    let turned = Rotation3::from_euler_angles(state.roll_rad, state.pitch_rad, 0.0);
    let loads_n = loads_n(plant);
    let [_, _, rear_left_n, _] = loads_n;
    assert!(rear_left_n < 1e-6, "{loads_n:?}");
    let carry = [FRONT_LEFT, 1, 3];
    let places = carry.map(|wheel| turned * robot.contacts()[wheel].place_in_body_m);
    let center_m = turned * center_m();
    let [a, b, c] = places;
    let moments = Matrix3::new(1.0, 1.0, 1.0, a.x, b.x, c.x, a.y, b.y, c.y);
    let weight_n = MASS_KG * 9.81;
    let right = weight_n * Vector3::new(1.0, center_m.x, center_m.y);
    let by_hand = moments.try_inverse().expect("no line") * right;
    for (wheel, by_hand_n) in carry.into_iter().zip(&by_hand) {
        let found_n = loads_n[wheel];
        assert!(
            (found_n / by_hand_n - 1.0).abs() < 0.01,
            "{wheel}: {found_n} {by_hand_n}"
        );
    }
}
