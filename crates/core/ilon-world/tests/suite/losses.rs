//! Losses never decrease: under wheel loops that oscillate from sample to sample no friction adds
//! energy.

use ilon_robot::{Pose, Twist};
use ilon_world::{Floor, World};

use crate::support::rig::near;
use crate::support::{ideal_rates, mecanum4};

/// A digital wheel loop: a torque from the rates of a sample, held until the next.
struct Held {
    proportional_n_m_s: f64,
    derivative_n_m_s2: f64,
    before_rad_s: Vec<f64>,
}

/// The energies of the world, in J.
#[derive(Clone, Copy, Debug)]
struct Account {
    motor_j: f64,
    drove_j: f64,
    stored_j: f64,
    slip_j: f64,
    bearing_j: f64,
    impact_j: f64,
    /// The largest decrease of a loss.
    fell_j: f64,
}

/// Drives mecanum4 for a second by wheel loops sampled at 300 Hz, each sample over several steps.
fn chatter(friction: f64, proportional_n_m_s: f64, derivative_n_m_s2: f64, steps: u32) -> Account {
    const SAMPLE_HZ: f64 = 300.0;
    const EFFORT_N_M: f64 = 0.5;
    let robot = mecanum4();
    let settings = near(SAMPLE_HZ * f64::from(steps));
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let mut world = World::new(&robot, &floor, Pose::default(), &settings).expect("a world");
    let targets = ideal_rates(&robot, Twist::new(0.2, 0.2, 0.0));
    let mut law = Held {
        proportional_n_m_s,
        derivative_n_m_s2,
        before_rad_s: vec![0.0; targets.len()],
    };
    let stored_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let losses = |world: &World| {
        [
            world.slip_energy_j(),
            world.spin_up_energy_j(),
            world.bearing_energy_j(),
            world.impact_energy_j(),
        ]
    };
    let began_j = stored_j(&world);
    let (mut most, mut fell_j) = ([0.0_f64; 4], 0.0_f64);
    for sample in 0..300 {
        let share = (f64::from(sample) / 60.0).min(1.0);
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let torques: Vec<f64> = (0..rates.len())
            .map(|i| {
                let gained = (rates[i] - law.before_rad_s[i]) * SAMPLE_HZ;
                let asked = law.proportional_n_m_s * (share * targets[i] - rates[i])
                    - law.derivative_n_m_s2 * gained;
                asked.clamp(-EFFORT_N_M, EFFORT_N_M)
            })
            .collect();
        law.before_rad_s = rates;
        for _ in 0..steps {
            world.robot_mut().apply(&torques);
            world.step();
            for (most, now) in most.iter_mut().zip(losses(&world)) {
                *most = most.max(now);
                fell_j = fell_j.max(*most - now);
            }
        }
    }
    Account {
        motor_j: world.motor_energy_j(),
        drove_j: world.motor_positive_energy_j(),
        stored_j: stored_j(&world) - began_j,
        slip_j: world.slip_energy_j(),
        bearing_j: world.bearing_energy_j() + world.spin_up_energy_j(),
        impact_j: world.impact_energy_j(),
        fell_j,
    }
}

/// Wheels driven to and fro by 0.5 N m from sample to sample stick on a floor with enough friction
/// (limit 0.8 N m), and slide to and fro on one without (limit 0.1 N m).
///
/// Sliding takes no more energy than there was, no loss decreases, and the balance closes, all to
/// parts in a thousand of the motors' positive work: a step in which a wheel reverses leaves mu N
/// dt |u| / 2 = 0.07 x 28 N x 3.3 ms x 0.3 m/s / 2 = 1e-3 J to be taken back. In such a step
/// friction has the wrong sign for a part of the time, so that the sliding is of first order only.
#[test]
fn friction_gives_no_energy_under_loops_that_swing() {
    for friction in [0.6, 0.07] {
        for (p, d) in [
            (0.3, 0.0),
            (2.0, 0.0),
            (5.0, 0.0),
            (50.0, 0.0),
            (0.44, 0.002),
            (0.44, 0.1),
        ] {
            let accounts = [1, 2, 4, 16].map(|steps| chatter(friction, p, d, steps));
            for a in &accounts {
                let name = format!("friction {friction}, gains {p}, {d}: {a:?}");
                let there_j = a.motor_j - a.stored_j;
                let open_j = there_j - a.slip_j - a.bearing_j - a.impact_j;
                assert!(open_j.abs() < 2e-3 * a.drove_j, "{open_j:.1e} {name}");
                assert!(a.slip_j < there_j + 2e-3 * a.drove_j, "{name}");
                assert!(a.fell_j < 3e-4 * a.drove_j, "{name}");
                assert!(a.drove_j >= a.motor_j, "{name}");
            }
            let [.., coarse, fine] = accounts;
            let off_j = (coarse.slip_j - fine.slip_j).abs();
            assert!(
                off_j < 0.25 * fine.slip_j + 1e-3,
                "friction {friction}, gains {p}, {d}: {coarse:?} {fine:?}"
            );
        }
    }
}
