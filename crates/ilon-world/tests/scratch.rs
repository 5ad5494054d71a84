mod support;
use ilon_robot::*;
use ilon_world::*;
use nalgebra::Vector3;
use support::*;
#[test]
fn look() {
    let p: f64 = std::env::var("P").unwrap_or("2e-4".into()).parse().unwrap();
    let f: f64 = std::env::var("F").unwrap_or("-35".into()).parse().unwrap();
    let dt: f64 = std::env::var("DT")
        .unwrap_or("5e-4".into())
        .parse()
        .unwrap();
    let mut robot = mecanum4();
    for w in &mut robot.wheels {
        w.surface.axial_play_m = p;
        if let Ok(k) = std::env::var("K") {
            w.surface.tread = Some(Tread::new(k.parse().unwrap()));
        }
    }
    let floor = Floor {
        friction: std::env::var("MU").unwrap_or("1".into()).parse().unwrap(),
        ..Floor::default()
    };
    let settings = Settings {
        dt_s: dt,
        ..Settings::default()
    };
    let mut world = World::new(&robot, &floor, Pose::default(), &settings).unwrap();
    let targets = ideal_rates(&robot, Twist::new(0.1, 0.0, 0.0));
    let mut worst: f64 = 0.0;
    let e0 = world.energy().kinetic_j + world.energy().potential_j;
    let mut k = 0;
    while world.time_s() < 2.0 {
        let share = (world.time_s() / 0.4).min(1.0);
        let rates = world.wheel_rates_rad_s().to_vec();
        let motors: Vec<_> = targets
            .iter()
            .zip(&rates)
            .map(|(t, r)| MotorTorque::with_droop(5.0 * (share * t - r), 5.0))
            .collect();
        world.drive(&motors);
        world.push(&Push {
            force_in_world_n: Vector3::new(share * f, 0.0, 0.0),
            place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
        });
        world.step();
        worst = worst.max(world.contact_residual_m_s());
        k += 1;
        if world.time_s() > 0.9 && world.time_s() < 1.35 && k % (((2.5e-3 / dt) as i32).max(1)) == 0
        {
            let c = &world.contacts()[0];
            let places: Vec<f64> = world.roller_places_m(0).collect();
            println!(
                "{:.4} roller {} n{} q {:+.4} N {:6.2} F {:+6.2} {:+6.2} h-rho {:+.1}um slide {:.4} v {:.4} wh {:.4} res {:.1e} x-ideal {:.4}mm",
                world.time_s(),
                c.roller,
                c.touching_rollers,
                1e3 * places[c.roller],
                c.normal_force_n,
                c.force_in_body_n.x,
                c.force_in_body_n.y,
                1e6 * (world.hub_height_m(0) - 0.05),
                c.sliding_in_body_m_s.norm(),
                world.body().twist_in_body.vx_m_s,
                world.wheel_rates_rad_s()[0] * 0.05,
                world.contact_residual_m_s(),
                1e3 * (world.body().pose.x_m - 0.05 * world.wheel_angles_rad()[0])
            );
        }
    }
    println!(
        "end x-ideal {:.4} turned {:.4} open {:e}",
        1e3 * (world.body().pose.x_m - 0.05 * world.wheel_angles_rad()[0]),
        world.wheel_angles_rad()[0],
        world.motor_energy_j() + world.outside_energy_j()
            - world.slip_energy_j()
            - world.impact_energy_j()
            - world.bearing_energy_j()
            - world.spin_up_energy_j()
            - world.energy().kinetic_j
            - world.energy().potential_j
            + e0
    );
    println!(
        "worst {worst:e} slip {} impact {} bearing {} motor {} outside {}",
        world.slip_energy_j(),
        world.impact_energy_j(),
        world.bearing_energy_j(),
        world.motor_energy_j(),
        world.outside_energy_j()
    );
}
