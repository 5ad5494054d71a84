//! What can make a difference to a run, and the null of each: what the scenario and the robot are without it.

use ilon_robot::{Joint, MotorLimits, Robot, RollersAsMade};
use ilon_trace::{Cause, Header};

use crate::scenario::{
    Encoders, Floor, FloorPatch, Imu, ImuNoise, Kinematics, LoopTiming, PoseSensor, Saturation,
    Scenario, WheelLaw,
};

/// A change of a scenario and its robot.
pub(crate) type Null = Box<dyn Fn(&mut Scenario, &mut Robot) + Send + Sync>;

/// Of ground and bodies of one kind more than this are one cause together.
const MOST_OF_A_KIND: usize = 3;

/// Friction at which nothing slides.
const HOLDS: f64 = 100.0;

/// By how much wheel loops that follow at once are stiffer than those of the run.
const AT_ONCE: f64 = 50.0;

/// What a scenario names that is no default: what goes wrong, what is there, and what the robot sees badly.
pub(super) fn named(scenario: &Scenario, header: &Header) -> Vec<(Cause, Null)> {
    let mut list = List::default();
    faults(header, &mut list);
    ground(&scenario.world.floor, &mut list);
    bodies(scenario, &mut list);
    sensors(scenario, &mut list);
    if !scenario.motors.wheels.is_empty() {
        list.add("motors.wheels", "motors that differ", |scenario, _| {
            scenario.motors.wheels.clear();
        });
    }
    if let Some(belief) = &header.belief {
        list.add(
            "controller.robot",
            format!("what the controller believes of the robot ({belief})"),
            |scenario, _| scenario.controller.robot = None,
        );
    }
    list.0
}

/// All that can make a difference: what [`named`] gives, and what every robot has.
pub(super) fn all(scenario: &Scenario, robot: &Robot, header: &Header) -> Vec<(Cause, Null)> {
    let mut list = List(named(scenario, header));
    of_rollers(scenario, robot, &mut list);
    of_drive(scenario, robot, &mut list);
    list.0
}

#[derive(Default)]
struct List(Vec<(Cause, Null)>);

impl List {
    fn add(
        &mut self,
        key: impl Into<String>,
        words: impl Into<String>,
        null: impl Fn(&mut Scenario, &mut Robot) + Send + Sync + 'static,
    ) {
        let cause = Cause {
            key: key.into(),
            words: words.into(),
        };
        self.0.push((cause, Box::new(null)));
    }

    /// Each thing of a list of the scenario by itself; of many all together, called by `many`.
    fn each<T>(
        &mut self,
        key: &str,
        things: &[T],
        of: fn(&mut Scenario) -> &mut Vec<T>,
        many: &str,
        words: impl Fn(&T) -> String,
    ) where
        T: 'static,
    {
        let count = things.len();
        if count > MOST_OF_A_KIND {
            return self.add(key, format!("the {count} {many}"), move |scenario, _| {
                of(scenario).clear();
            });
        }
        for (index, thing) in things.iter().enumerate() {
            self.add(
                format!("{key}.{index}"),
                words(thing),
                move |scenario, _| {
                    of(scenario).remove(index);
                },
            );
        }
    }
}

/// Each fault by itself. The header's faults stand in the scenario's order.
fn faults(header: &Header, list: &mut List) {
    let name_of = |wheel: usize| header.wheels.get(wheel).map(|wheel| wheel.name.as_str());
    for (index, fault) in header.faults.iter().flatten().enumerate() {
        list.add(
            format!("faults.{index}"),
            fault.words(name_of),
            move |scenario, _| {
                scenario.faults.remove(index);
            },
        );
    }
}

/// What lies on the floor, what is in its place, and how it slopes.
fn ground(floor: &Floor, list: &mut List) {
    let at = |x_m: f64, y_m: f64| format!("at ({x_m}, {y_m}) m");
    list.each(
        "world.floor.patches",
        &floor.patches,
        |scenario| &mut scenario.world.floor.patches,
        "patches of floor",
        |patch| {
            format!(
                "the patch of {} {}",
                of_patch(patch),
                at(patch.x_m, patch.y_m)
            )
        },
    );
    list.each(
        "world.floor.boxes",
        &floor.boxes,
        |scenario| &mut scenario.world.floor.boxes,
        "boxes on the floor",
        |one| {
            let high_mm = 1e3 * one.height_m;
            format!("the box {high_mm:.1} mm high {}", at(one.x_m, one.y_m))
        },
    );
    if !floor.ramps.is_empty() {
        list.add("world.floor.ramps", "the ramps", |scenario, _| {
            scenario.world.floor.ramps.clear();
        });
    }
    if !floor.stairs.is_empty() {
        list.add("world.floor.stairs", "the stairs", |scenario, _| {
            scenario.world.floor.stairs.clear();
        });
    }
    if floor.rough.is_some() {
        list.add("world.floor.rough", "the rough ground", |scenario, _| {
            scenario.world.floor.rough = None;
        });
    }
    if floor.height_map.is_some() {
        list.add(
            "world.floor.height_map",
            "the map of heights",
            |scenario, _| {
                scenario.world.floor.height_map = None;
            },
        );
    }
    if floor.slope_deg != 0.0 {
        list.add(
            "world.floor.slope_deg",
            format!("the slope of {}°", floor.slope_deg.abs()),
            |scenario, _| scenario.world.floor.slope_deg = 0.0,
        );
    }
}

/// All that a patch of floor has otherwise, in words.
fn of_patch(patch: &FloorPatch) -> String {
    let mut parts = Vec::new();
    if let Some(material) = &patch.material {
        parts.push(material.clone());
    }
    let numbers = [
        ("friction", patch.friction),
        ("rolling resistance", patch.rolling_resistance),
        ("creep", patch.creep),
    ];
    let given = numbers
        .iter()
        .filter_map(|(name, number)| Some((name, (*number)?)));
    parts.extend(given.map(|(name, number)| format!("{name} {number}")));
    if patch.nap_deg.is_some() {
        parts.push("a nap".to_owned());
    }
    match parts.is_empty() {
        true => "floor".to_owned(),
        false => parts.join(" and "),
    }
}

/// Free bodies one by one. Those that may lie on one another go together.
fn bodies(scenario: &Scenario, list: &mut List) {
    let bodies = &scenario.world.bodies;
    if bodies.iter().filter(|body| body.z_m.is_some()).count() > 1 {
        let words = format!("the {} bodies that lie about", bodies.len());
        return list.add("world.bodies", words, |scenario, _| {
            scenario.world.bodies.clear();
        });
    }
    list.each(
        "world.bodies",
        bodies,
        |scenario| &mut scenario.world.bodies,
        "bodies that lie about",
        |body| format!("the body `{}`", body.name),
    );
}

/// What the robot sees late, seldom or with noise.
fn sensors(scenario: &Scenario, list: &mut List) {
    let sensors = &scenario.sensors;
    let pose = &sensors.pose;
    if pose.position_noise_m > 0.0 || pose.heading_noise_deg > 0.0 {
        list.add(
            "sensors.pose.noise",
            "the noise of the pose sensor",
            |scenario, _| {
                let pose = &mut scenario.sensors.pose;
                (pose.position_noise_m, pose.heading_noise_deg) = (0.0, 0.0);
            },
        );
    }
    if pose.latency_s > 0.0 {
        list.add(
            "sensors.pose.latency_s",
            format!("the pose sensor's delay of {:.0} ms", 1e3 * pose.latency_s),
            |scenario, _| scenario.sensors.pose.latency_s = 0.0,
        );
    }
    if let Some(rate_hz) = pose.rate_hz {
        list.add(
            "sensors.pose.rate_hz",
            format!("the pose sensor's rate of {rate_hz} Hz"),
            |scenario, _| {
                scenario.sensors.pose = PoseSensor {
                    rate_hz: None,
                    ..scenario.sensors.pose.clone()
                };
            },
        );
    }
    if sensors.encoders != Encoders::default() {
        list.add(
            "sensors.encoders",
            "the noise and the steps of the encoders",
            |scenario, _| {
                scenario.sensors.encoders = Encoders::default();
            },
        );
    }
    let exact = ImuNoise::default();
    let is_noisy = |imu: &Imu| imu.accelerometer != exact || imu.gyroscope != exact;
    if sensors.imu.as_ref().is_some_and(is_noisy) {
        list.add(
            "sensors.imu",
            "the errors of the inertial unit",
            |scenario, _| {
                if let Some(imu) = &mut scenario.sensors.imu {
                    (imu.accelerometer, imu.gyroscope) = (ImuNoise::default(), ImuNoise::default());
                }
            },
        );
    }
}

/// Sliding, and what rollers and their bearings are.
fn of_rollers(scenario: &Scenario, robot: &Robot, list: &mut List) {
    list.add(
        "sliding",
        "sliding (grip that never ends in its place)",
        |scenario, _| {
            never_slides(scenario);
        },
    );
    if scenario.guidance.kinematics == Kinematics::Ideal {
        list.add(
            "geometry",
            "the rollers' geometry (commands by the rollers that touch in its place)",
            |scenario, _| scenario.guidance.kinematics = Kinematics::Contact,
        );
    }
    let any = |is: fn(&ilon_robot::Wheel) -> bool| robot.wheels.iter().any(is);
    if any(|wheel| wheel.made != RollersAsMade::default()) {
        list.add(
            "rollers.made",
            "the shape that its rollers are made with",
            |_, robot| {
                for wheel in &mut robot.wheels {
                    // Modelled rollers stay as they are.
                    let _ = wheel.make_rollers(RollersAsMade::default(), Some(1.0));
                }
            },
        );
    }
    if any(|wheel| wheel.surface.tread.is_some()) {
        list.add("rollers.tread", "the give of its treads", |_, robot| {
            for wheel in &mut robot.wheels {
                wheel.surface.tread = None;
            }
        });
    }
    if any(|wheel| wheel.surface.axial_play_m > 0.0) {
        list.add(
            "rollers.axial_play_m",
            "the play of its rollers",
            |_, robot| {
                for wheel in &mut robot.wheels {
                    wheel.surface.axial_play_m = 0.0;
                }
            },
        );
    }
    list.add("bearings", "the drag of its bearings", |_, robot| {
        for wheel in &mut robot.wheels {
            wheel.joint = Joint::default();
            wheel.surface.axle_friction = 0.0;
            for roller in &mut wheel.rollers {
                roller.joint = Joint::default();
            }
        }
    });
    let resists = any(|wheel| wheel.surface.rolling_resistance > 0.0);
    if resists || of_floor_resists(scenario) {
        list.add(
            "rolling_resistance",
            "rolling resistance",
            |scenario, robot| {
                for wheel in &mut robot.wheels {
                    wheel.surface.rolling_resistance = 0.0;
                }
                rolls_freely(scenario);
            },
        );
    }
}

/// Grip that never ends, and no creep, everywhere.
fn never_slides(scenario: &mut Scenario) {
    let floor = &mut scenario.world.floor;
    for patch in &mut floor.patches {
        (patch.friction, patch.creep) = (patch.friction.map(|_| HOLDS), None);
        (patch.sliding, patch.across) = (None, None);
    }
    floor.friction = floor.friction.map(|_| HOLDS);
    (floor.creep, floor.sliding, floor.across) = (None, None, None);
    for pair in scenario
        .materials
        .values_mut()
        .flat_map(|of| of.values_mut())
    {
        (pair.friction, pair.creep) = (HOLDS, 0.0);
        (pair.sliding, pair.across) = (None, None);
    }
    scenario
        .faults
        .retain(|fault| !matches!(fault, crate::scenario::Fault::FrictionChanged { .. }));
}

fn of_floor_resists(scenario: &Scenario) -> bool {
    let floor = &scenario.world.floor;
    let mut patches = floor
        .patches
        .iter()
        .filter_map(|patch| patch.rolling_resistance);
    let mut pairs = scenario.materials.values().flat_map(|of| of.values());
    floor.rolling_resistance.is_some_and(|it| it > 0.0)
        || patches.any(|it| it > 0.0)
        || pairs.any(|pair| pair.rolling_resistance > 0.0)
}

/// No rolling resistance anywhere.
fn rolls_freely(scenario: &mut Scenario) {
    let floor = &mut scenario.world.floor;
    floor.rolling_resistance = None;
    floor.against = None;
    for patch in &mut floor.patches {
        (patch.rolling_resistance, patch.against) = (None, None);
    }
    for pair in scenario
        .materials
        .values_mut()
        .flat_map(|of| of.values_mut())
    {
        (pair.rolling_resistance, pair.against) = (0.0, None);
    }
}

/// What holds the wheels from doing what is asked.
fn of_drive(scenario: &Scenario, robot: &Robot, list: &mut List) {
    let guidance = &scenario.guidance;
    let is_limited =
        guidance.wheel_rate_limit_rad_s.is_some() || !guidance.wheel_rate_limits_rad_s.is_empty();
    if is_limited && guidance.saturation != Saturation::None {
        list.add(
            "guidance.saturation",
            "the limit on commanded wheel rates",
            |scenario, _| {
                scenario.guidance.saturation = Saturation::None;
            },
        );
    }
    let is_bounded = |wheel: &ilon_robot::Wheel| wheel.motor != MotorLimits::default();
    if scenario.motors.dc.is_some() || robot.wheels.iter().any(is_bounded) {
        list.add("motors", "the limits of its motors", |scenario, robot| {
            scenario.motors.dc = None;
            scenario.motors.wheels.clear();
            for wheel in &mut robot.wheels {
                wheel.motor = MotorLimits::default();
            }
        });
    }
    let loses = |wheel: &ilon_robot::Wheel| {
        wheel.drive.gear_efficiency < 1.0 || wheel.drive.gear_friction_n_m > 0.0
    };
    if robot.wheels.iter().any(loses) {
        list.add("gears", "the losses of its gears", |_, robot| {
            for wheel in &mut robot.wheels {
                wheel.drive.gear_efficiency = 1.0;
                wheel.drive.gear_friction_n_m = 0.0;
            }
        });
    }
    if scenario.wheel_loop.law == WheelLaw::Pid {
        list.add(
            "wheel_loop",
            "the give of the wheel loops (wheels that follow at once in its place)",
            |scenario, _| {
                let section = &mut scenario.wheel_loop;
                section.timing = LoopTiming::Continuous;
                section.proportional_n_m_s = section.proportional_n_m_s.map(|gain| AT_ONCE * gain);
            },
        );
    }
}
