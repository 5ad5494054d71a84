//! The passive law worked out a second time, from the wheels' places and rollers alone: M by hand,
//! its pseudo-inverse by the normal equations, loads from a plane by Cramer's rule, and the sharing
//! by trying every set of wheels that could be at the bound.

use std::io::Write;
use std::process::{Command, Stdio};

#[allow(dead_code)]
use crate::fixtures;

use fixtures::{WheelSpec, mecanum4, robot, volksbot};
use ilon_control::{
    BodySense, Demand, PassiveTorque, PassiveTorqueSettings, TorqueLaw, TorqueRange,
};
use ilon_robot::Robot;
use nalgebra::{DMatrix, Matrix3, Vector3};

struct ByHand {
    /// (n_gamma, u_gamma . b) of each wheel, negative: eq. (8).
    m: Vec<Vector3<f64>>,
    levers: Vec<f64>,
    places: Vec<Vector3<f64>>,
    mass: f64,
    center: Vector3<f64>,
    height: f64,
}

impl ByHand {
    fn new(robot: &Robot) -> Self {
        let wheels = &robot.wheels;
        let row = |w: &ilon_robot::Wheel| {
            let (n, u, b) = (
                w.roller_axis(),
                w.roller_rolling_direction(),
                w.position_m(),
            );
            -Vector3::new(n.x, n.y, b.x * u.x + b.y * u.y)
        };
        let center = robot.center_of_mass_m();
        Self {
            m: wheels.iter().map(row).collect(),
            levers: wheels
                .iter()
                .map(|w| w.radius_m * w.gamma_rad.cos())
                .collect(),
            places: wheels
                .iter()
                .map(|w| Vector3::new(1.0, w.position_m().x, w.position_m().y))
                .collect(),
            mass: robot.mass_kg(),
            center,
            height: center.z + robot.ride_height_m(),
        }
    }

    fn gram(&self) -> Matrix3<f64> {
        self.m.iter().map(|row| row * row.transpose()).sum()
    }

    /// M^+ L q.
    fn rolled(&self, q: &[f64]) -> Vector3<f64> {
        let right: Vector3<f64> = (0..q.len())
            .map(|h| self.m[h] * (self.levers[h] * q[h]))
            .sum();
        solve(self.gram(), right)
    }

    /// P L q: what of the wheels' ways is no motion of the body.
    fn slid(&self, q: &[f64]) -> Vec<f64> {
        let rolled = self.rolled(q);
        (0..q.len())
            .map(|h| self.levers[h] * q[h] - self.m[h].dot(&rolled))
            .collect()
    }

    /// a + b x + c y with the weight at the centre of mass, moved downhill by the height.
    fn loads(&self, g: Vector3<f64>, gravity: f64) -> Vec<f64> {
        let sum: Matrix3<f64> = self.places.iter().map(|p| p * p.transpose()).sum();
        let x = gravity * self.center.x + self.height * g.x;
        let y = gravity * self.center.y + self.height * g.y;
        let plane = solve(sum, self.mass * Vector3::new(gravity, x, y));
        self.places.iter().map(|p| plane.dot(p)).collect()
    }

    /// The least t with |f_h| <= t N_h and M^T f = w: at the least, all wheels but two stand at
    /// their bounds.
    fn share(&self, w: Vector3<f64>, loads: &[f64]) -> Vec<f64> {
        let n = self.m.len();
        let mut best: Option<(f64, Vec<f64>)> = None;
        for i in 0..n {
            for j in i + 1..n {
                for signs in 0..1_u32 << (n - 2) {
                    let mut f = vec![0.0; n];
                    let others = (0..n).filter(|h| *h != i && *h != j);
                    let mut at_bound = Vector3::zeros();
                    for (place, h) in others.enumerate() {
                        f[h] = if signs >> place & 1 == 1 {
                            loads[h]
                        } else {
                            -loads[h]
                        };
                        at_bound += self.m[h] * f[h];
                    }
                    // w = t at_bound + m_i f_i + m_j f_j.
                    let columns = Matrix3::from_columns(&[at_bound, self.m[i], self.m[j]]);
                    if columns.determinant().abs() < 1e-9 {
                        continue;
                    }
                    let found = solve(columns, w);
                    let t = found.x;
                    f.iter_mut().for_each(|f| *f *= t);
                    (f[i], f[j]) = (found.y, found.z);
                    let holds = (0..n).all(|h| f[h].abs() <= t * loads[h] * (1.0 + 1e-12) + 1e-12);
                    if holds && best.as_ref().is_none_or(|(least, _)| t < *least) {
                        best = Some((t, f));
                    }
                }
            }
        }
        best.expect("a wrench that the wheels can give").1
    }
}

/// Cramer's rule.
fn solve(a: Matrix3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    let whole = a.determinant();
    Vector3::from_fn(|k, _| {
        let mut with = a;
        with.set_column(k, &b);
        with.determinant() / whole
    })
}

fn noise(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn robots() -> Vec<Robot> {
    let mut seed = 3;
    // Wheels of no symmetry, so that the sharing is one and no other.
    let mut any = |n: u32| {
        let specs: Vec<_> = (0..n)
            .map(|k| {
                let mut r = || noise(&mut seed);
                let at = std::f64::consts::TAU / f64::from(n) * f64::from(k) + 0.2 * r();
                let (sin, cos) = at.sin_cos();
                let (turn, gamma) = (0.3 * r(), 0.7 * r());
                let mut spec = WheelSpec::new(0.4 * cos, 0.4 * sin, at + turn, gamma, 8);
                spec.radius_m = 0.05 + 0.01 * r();
                spec
            })
            .collect();
        robot(9.0, &specs)
    };
    let mut all = vec![mecanum4(), volksbot(), any(5), any(6)];
    for robot in &mut all {
        robot.chassis.mass.center_of_mass_m += Vector3::new(0.02, -0.013, 0.03);
    }
    all
}

/// A robot that was turned from `first` to `second`, and what its law makes of it.
struct Case {
    own: PassiveTorqueSettings,
    first: Vec<f64>,
    second: Vec<f64>,
    targets: Vec<f64>,
    rates: Vec<f64>,
    gravity: Vector3<f64>,
    got: Vec<f64>,
}

fn cases(robot: &Robot, seed: &mut u64) -> Vec<Case> {
    let n = robot.wheels.len();
    let own = PassiveTorqueSettings {
        // Out of the way: when it binds is another test's.
        wheel_limit_n_m: 1e3,
        ..PassiveTorqueSettings::for_robot(robot, 9.81, 1e-3, 0.01, 0.0).unwrap()
    };
    let mut case = || {
        let mut law = PassiveTorque::new(robot, &own).unwrap();
        let mut random = |size: f64| -> Vec<f64> { (0..n).map(|_| size * noise(seed)).collect() };
        let (first, second, targets, rates) = (random(3.0), random(3.0), random(2.0), random(2.0));
        let g = random(1.0);
        let gravity = Vector3::new(g[0], g[1], -9.7);
        let open = vec![TorqueRange::UNLIMITED; n];
        for angles in [&first, &second] {
            law.sense(&BodySense {
                angles_rad: angles,
                gravity_in_body_m_s2: Some(gravity),
            });
            law.update(&Demand::new(&targets, &rates, &open, 1e-3));
        }
        Case {
            got: law
                .update(&Demand::new(&targets, &rates, &open, 0.0))
                .to_vec(),
            own,
            first,
            second,
            targets,
            rates,
            gravity,
        }
    };
    (0..40).map(|_| case()).collect()
}

#[test]
fn torques_are_those_of_a_second_derivation() {
    let mut seed = 11;
    for robot in robots() {
        let n = robot.wheels.len();
        let hand = ByHand::new(&robot);
        let mean = hand.levers.iter().sum::<f64>() / n as f64;
        for case in cases(&robot, &mut seed) {
            let (own, g) = (&case.own, case.gravity);
            let d = Vector3::new(
                own.damping_n_s_m,
                own.damping_n_s_m,
                own.heading_damping_n_m_s_rad,
            );
            let slower = hand.rolled(&case.targets) - hand.rolled(&case.rates);
            let c = hand.center;
            let down = hand.mass * Vector3::new(g.x, g.y, c.x * g.y - c.y * g.x);
            let pushes = hand.share(d.component_mul(&slower) - down, &hand.loads(g, 9.81));
            let turned = case.first.iter().zip(&case.second);
            let turned: Vec<f64> = turned.map(|(a, b)| b - a).collect();
            let (slid, slides) = (hand.slid(&turned), hand.slid(&case.rates));
            let (k_n, d_n) = (own.wheel_stiffness_n_m_rad, own.wheel_damping_n_m_s_rad);
            for h in 0..n {
                let between = (k_n * slid[h] + d_n * slides[h]) * hand.levers[h] / (mean * mean);
                let expected = hand.levers[h] * pushes[h] - between;
                let got = case.got[h];
                // Torques of up to some N m, by determinants of sums of ten products.
                assert!((got - expected).abs() < 1e-9, "{h}: {got} {expected}");
            }
        }
        // The pseudo-inverse leaves three wheels nothing to slide against.
        let p = DMatrix::from_fn(n, n, |_, h| {
            let mut q = vec![0.0; n];
            q[h] = 1.0;
            hand.slid(&q).iter().map(|s| s * s).sum::<f64>()
        });
        assert_eq!(p.max() < 1e-20, n == 3);
    }
}

/// A Python with numpy: that under `ILON_PYTHON`, or `python3`. Without one it says that the test
/// is skipped.
fn python() -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python).args(["-c", "import numpy"]).output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, has no numpy"
    );
    println!("skipped: {python} has no numpy");
    None
}

/// A case for `passive_in_numpy.py`, as a line of JSON.
fn line(robot: &Robot, case: &Case) -> String {
    let wheel = |w: &ilon_robot::Wheel| {
        let (at, n) = (w.position_m(), w.roller_axis());
        [at.x, at.y, n.x, n.y, w.radius_m, w.gamma_rad]
    };
    let wheels: Vec<_> = robot.wheels.iter().map(wheel).collect();
    let center = robot.center_of_mass_m();
    let center = [center.x, center.y, center.z + robot.ride_height_m()];
    let own = &case.own;
    let numbers = [
        ("mass", robot.mass_kg()),
        ("g", 9.81),
        ("damping", own.damping_n_s_m),
        ("heading_damping", own.heading_damping_n_m_s_rad),
        ("between", own.wheel_stiffness_n_m_rad),
        ("between_damping", own.wheel_damping_n_m_s_rad),
    ];
    let numbers = numbers.map(|(name, number)| format!("{name:?}: {number:?}"));
    format!(
        "{{\"wheels\": {wheels:?}, \"center\": {center:?}, \"gravity\": {:?}, \"rates\": {:?}, \"targets\": {:?}, \"first\": {:?}, \
         \"second\": {:?}, {}}}\n",
        <[f64; 3]>::from(case.gravity),
        case.rates,
        case.targets,
        case.first,
        case.second,
        numbers.join(", ")
    )
}

#[test]
fn torques_are_those_of_numpy() {
    let Some(python) = python() else { return };
    let mut seed = 12;
    let (mut lines, mut got) = (String::new(), Vec::new());
    for robot in robots() {
        for case in cases(&robot, &mut seed) {
            lines += &line(&robot, &case);
            got.push(case.got);
        }
    }
    let mut running = Command::new(python)
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/passive_in_numpy.py"
        ))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut into = running.stdin.take().unwrap();
    let asks = std::thread::spawn(move || into.write_all(lines.as_bytes()));
    let output = running.wait_with_output().unwrap();
    asks.join().unwrap().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let mut worst = 0.0_f64;
    for (line, got) in said.lines().zip(&got) {
        for (theirs, ours) in line.split(' ').zip(got) {
            worst = worst.max((theirs.parse::<f64>().unwrap() - ours).abs());
        }
    }
    println!("{} cases, apart by at most {worst:.1e} N m", got.len());
    assert_eq!(said.lines().count(), got.len());
    assert!(worst < 1e-9, "{worst}");
}
