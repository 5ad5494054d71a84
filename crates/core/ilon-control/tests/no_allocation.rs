//! After construction nothing in the update paths allocates, so that the crate can run in a robot's
//! control loop.

#[path = "../src/tests/robots.rs"]
#[allow(dead_code)]
mod fixtures;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use ilon_control::{
    BodySense, ComputedTorque, ComputedTorqueSettings, ContactKinematics, DcMotor, Demand,
    DynamicModel, Gain, Guidance, GuidanceSettings, Heading, Kinematics, LoopTiming, Motor,
    MotorCurve, PassiveTorque, PassiveTorqueSettings, PoseFilter, PoseFilterSettings,
    PrioritisedTorque, PrioritisedTorqueSettings, Priority, Reference, Saturation, TiltFilter,
    TorqueLaw, TorqueRange, WheelGains, WheelLoop, WheelLoopSettings,
};
use ilon_robot::{MotorLimits, Pose};
use nalgebra::{Vector2, Vector3};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn a_control_step_allocates_nothing() {
    let robot = fixtures::mecanum4();
    let kinematics = Kinematics::new(&robot).unwrap();
    let mut contact = ContactKinematics::new(&robot).unwrap();
    let points = vec![
        Vector2::zeros(),
        Vector2::new(1.0, 0.0),
        Vector2::new(1.0, 1.0),
    ];
    let along = Heading::Tangent { offset_rad: 0.1 };
    let reference = Reference::waypoints_at_speed(points, 0.3, along).unwrap();
    let model = DynamicModel::new(&robot).unwrap();
    let gains = WheelGains::for_robot(&model, LoopTiming::Sampled, (1e-3, 0.0), 20.0).unwrap();
    let mut wheel_loop = WheelLoop::new(4, WheelLoopSettings::new(gains)).unwrap();
    let settings = ComputedTorqueSettings {
        bandwidth_rad_s: 20.0,
        target_filter_s: 0.01,
        dt_s: 1e-3,
    };
    let mut computed = ComputedTorque::new(model, &settings).unwrap();
    let settings = PrioritisedTorqueSettings {
        bandwidth_rad_s: 20.0,
        target_filter_s: 0.01,
        dt_s: 1e-3,
        priority: Priority::Position,
        reference_point_m: Vector2::zeros(),
        friction: 0.3,
        gravity_m_s2: 9.81,
    };
    let mut prioritised = PrioritisedTorque::new(&robot, &settings).unwrap();
    let settings = PassiveTorqueSettings::for_robot(&robot, 9.81, 1e-3, 0.03, 0.0).unwrap();
    let mut passive = PassiveTorque::new(&robot, &settings).unwrap();
    let mut tilt = TiltFilter::new(1.0).unwrap();
    let limits = MotorLimits {
        effort_n_m: 1.0,
        velocity_rad_s: 20.0,
    };
    let dc = DcMotor {
        stall_torque_n_m: 2.0,
        no_load_rate_rad_s: 25.0,
        current_limit_n_m: f64::INFINITY,
        regenerates: true,
    };
    let motor = Motor::new(&limits, MotorCurve::dc(dc).unwrap()).unwrap();

    for saturation in [
        Saturation::Prioritised(Priority::Position),
        Saturation::Prioritised(Priority::Heading),
        Saturation::Clip,
        Saturation::Scale,
        Saturation::None,
    ] {
        let settings = GuidanceSettings {
            position_gain: Gain::Scalar(1.0),
            heading_gain: 1.0,
            wheel_rate_limit_rad_s: 8.7,
            saturation,
        };
        let mut guidance = Guidance::new(kinematics.clone(), &settings).unwrap();
        let (mut angles, mut rates) = ([0.0; 4], [0.0; 4]);
        let filter_settings = PoseFilterSettings {
            measured_position_m: 0.02,
            measured_heading_rad: 0.03,
            drift_position_m: 0.01,
            drift_heading_rad: 0.02,
            size_m: 0.22,
            memory: 8,
        };
        let mut filter = PoseFilter::new(0.0, Pose::default(), &filter_settings).unwrap();
        assert_no_alloc(|| {
            for k in 0..200 {
                let t_s = 0.03 * f64::from(k);
                let desired = reference.at(t_s);
                let twist = contact.twist(&angles, &rates);
                let seen = Pose {
                    x_m: -0.5,
                    y_m: 0.1,
                    heading_rad: t_s,
                };
                filter.predict(t_s, twist.scaled(0.03));
                // Measured within a step: the step is split.
                let _ = filter.correct(t_s - 0.1, &seen);
                let _ = guidance.update(&seen, &desired);
                let targets = &guidance
                    .update_on_contact(&seen, &desired, &contact)
                    .wheel_rates_rad_s;
                let ranges: [TorqueRange; 4] = std::array::from_fn(|h| motor.range(rates[h]));
                let _ = wheel_loop.update(&Demand::new(targets, &rates, &ranges, 1e-3));
                let _ = computed.update(&Demand::new(targets, &rates, &ranges, 1e-3));
                tilt.update(&Vector3::zeros(), &Vector3::new(0.1, 0.0, 9.8), 0.03);
                passive.sense(&BodySense {
                    angles_rad: &angles,
                    gravity_in_body_m_s2: Some(9.81 * tilt.down_in_body()),
                });
                let _ = passive.update(&Demand::new(targets, &rates, &ranges, 1e-3));
                let torques = prioritised.update(&Demand::new(targets, &rates, &ranges, 1e-3));
                for h in 0..4 {
                    rates[h] += 0.1 * motor.range(rates[h]).clamp(torques[h]);
                    angles[h] += 0.03 * rates[h];
                }
            }
        });
    }
}
