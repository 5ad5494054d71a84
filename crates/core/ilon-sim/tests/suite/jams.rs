//! Robots that press bodies into walls and into one another: each step is solved, in halves if
//! necessary.

use ilon_sim::Scenario;
use ilon_sim::simulate::Simulation;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

/// The largest violation of the laws in a step of a jam, in m/s: a two-thousandth of the robots'
/// speeds of 0.2 m/s and more.
const HELD_M_S: f64 = 1e-4;

/// Random numbers between two bounds, the same in every run.
struct Draw(u64);

impl Draw {
    fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005);
        self.0 = self.0.wrapping_add(1442695040888963407);
        least + (most - least) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn wall([x_m, y_m]: [f64; 2], [length_x_m, length_y_m]: [f64; 2], heading_deg: f64) -> String {
    format!(
        "[[world.floor.boxes]]\nx_m = {x_m}\ny_m = {y_m}\nlength_x_m = {length_x_m}\nlength_y_m = {length_y_m}\n\
         height_m = 0.5\nheading_deg = {heading_deg}\n"
    )
}

/// A box, a standing or lying can, or a ball.
fn body(draw: &mut Draw, name: usize, [x_m, y_m]: [f64; 2]) -> String {
    let mut size = |least: f64, most: f64| draw.between(least, most);
    let radius_m = size(0.03, 0.06);
    let length_m = size(0.08, 0.15);
    let shape = match size(0.0, 4.0) as u32 {
        0 => {
            let sides = [size(0.06, 0.16), size(0.06, 0.16), size(0.08, 0.2)];
            format!("box = {{ size_m = {sides:?} }}")
        }
        1 => format!("cylinder = {{ radius_m = {radius_m}, length_m = {length_m} }}"),
        2 => {
            format!("cylinder = {{ radius_m = {radius_m}, length_m = {length_m} }}\nroll_deg = 90")
        }
        _ => format!("sphere = {{ radius_m = {radius_m} }}"),
    };
    format!(
        "[[world.bodies]]\nname = 'b{name}'\n{shape}\nmass_kg = {}\nfriction = {}\nfriction_on_robots = {}\nx_m = {x_m}\n\
         y_m = {y_m}\nheading_deg = {}\n",
        size(0.5, 6.0),
        size(0.2, 1.2),
        size(0.2, 1.2),
        size(0.0, 90.0)
    )
}

/// A robot that pushes bodies to the end of a lane between two walls.
fn jam(seed: u64, robot: &str, keys: &str, bodies: usize) -> String {
    let mut draw = Draw(seed);
    let mut text = format!(
        "[robot]\nfile = '{robot}.urdf'\n{keys}\n[run]\nduration_s = 2\n[twist]\nvx_m_s = {}\nvy_m_s = {}\nomega_rad_s = {}\n\
         rest_s = 0.1\nramp_s = 0.3\n[world.floor]\nfriction = {}\n",
        draw.between(0.2, 0.4),
        draw.between(-0.3, 0.3),
        draw.between(-0.5, 0.5),
        draw.between(0.4, 1.5),
    );
    let end_deg = draw.between(-25.0, 25.0);
    text += &wall([0.95, 0.0], [0.2, 3.0], end_deg);
    for side in [1.0, -1.0] {
        let apart_m = draw.between(0.62, 0.77);
        let lean_deg = draw.between(-12.0, 12.0);
        text += &wall([0.5, side * apart_m], [1.2, 0.1], lean_deg);
    }
    for name in 0..bodies {
        let column = (name % 2) as f64;
        let row = (name / 2) as f64;
        let at_m = [0.38 + 0.2 * column, -0.3 + 0.2 * row];
        text += &body(&mut draw, name, at_m);
    }
    text
}

/// The largest violation of the laws in a step of a scenario, in m/s.
fn worst_m_s(text: &str) -> f64 {
    let scenario = Scenario::from_toml(text, "jam", ROBOTS).expect("a scenario");
    let mut simulation = Simulation::new(&scenario).expect("it can be run");
    let mut worst_m_s = 0.0_f64;
    while !simulation.is_done() {
        simulation.step();
        worst_m_s = worst_m_s.max(simulation.world().contact_residual_m_s());
    }
    worst_m_s
}

/// A robot pushes a box of 2 kg askew along a wall. When the chassis meets the wall, after 2.24 s,
/// one step used to violate its laws by 0.165 m/s.
#[test]
fn a_box_wedged_between_a_robot_and_two_walls_is_solved_in_every_step() {
    let walls = wall([1.0, 0.0], [0.2, 3.0], 0.0) + &wall([0.5, 0.6], [1.0, 0.1], 0.0);
    let text = format!(
        "[robot]\nfile = 'mecanum4.urdf'\n[run]\nduration_s = 3\n[twist]\nvx_m_s = 0.25\nvy_m_s = 0.25\nomega_rad_s = 0\n\
         rest_s = 0.5\n[world.floor]\nfriction = 0.6\n{walls}[[world.bodies]]\nname = 'a'\nbox = {{ size_m = [0.2, 0.2, 0.1] }}\n\
         mass_kg = 2\nfriction = 0.5\nx_m = 0.5\ny_m = 0.2\nheading_deg = 40\n"
    );
    let worst_m_s = worst_m_s(&text);
    println!("{worst_m_s:.1e} m/s");
    assert!(worst_m_s < HELD_M_S, "{worst_m_s:e} m/s");
}

/// Random jams: three robots; rollers with axial play, rolling resistance or treads; motors with
/// gear losses.
#[test]
fn jams_drawn_at_random_are_solved_in_every_step() {
    let play = "[rollers]\naxial_play_m = 3e-4\n";
    let drag = "[rollers]\nrolling_resistance = 0.02\n";
    let tread = "[rollers]\nlength_factor = 1.4\n[rollers.tread]\nstiffness_n_m = 1e5\nshear_stiffness_n_m = 4e4\n";
    let gears = "[motors]\ngear_efficiency = 0.5\n";
    let kinds = [
        ("mecanum4", "", 4),
        ("volksbot", "", 3),
        ("mecanum6", "", 4),
        ("mecanum4", "", 7),
        ("mecanum4", play, 3),
        ("mecanum4", drag, 3),
        ("mecanum4", tread, 3),
        ("mecanum4", gears, 3),
    ];
    for (index, (robot, keys, bodies)) in kinds.into_iter().cycle().take(16).enumerate() {
        let seed = 700 + index as u64;
        let worst_m_s = worst_m_s(&jam(seed, robot, keys, bodies));
        println!("{seed} {robot} {keys:?}: {worst_m_s:.1e} m/s");
        assert!(
            worst_m_s < HELD_M_S,
            "{seed} {robot} {keys}: {worst_m_s:e} m/s"
        );
    }
}
