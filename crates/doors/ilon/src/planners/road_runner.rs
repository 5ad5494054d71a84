//! Feedforward and limits for Road Runner's mecanum drive.

use ilon_control::{ControlError, DynamicModel};
use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::RowVector3;

use crate::ros2_control::{Controller, DriveParameters};
use crate::scenario::{DcMotor, World};
use crate::simulate::Limits;

pub(super) const INCH_M: f64 = 0.0254;

/// The battery voltage at which a motor's stall torque and no-load rate hold, in V; Road Runner
/// divides by the measured voltage.
pub(super) const BATTERY_V: f64 = 12.0;

/// The motor voltage of a motion: k_S sign(v) + k_V v + k_A v', with v the speed of a wheel's rim.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Feedforward {
    /// k_S, for dry friction, in V.
    pub ks_v: f64,
    /// k_V, per speed, in V s/m.
    pub kv_v_s_m: f64,
    /// k_A, per acceleration, in V s^2/m.
    pub ka_v_s2_m: f64,
    /// The part of k_V from viscous friction, in V s/m; the rest is the motor's back-EMF.
    pub drag_v_s_m: f64,
}

impl Feedforward {
    /// The feedforward of a straight motion in a direction, as the mean of the wheels. Of the
    /// world, gravity and the floor's rolling resistance count. The model is [`DynamicModel`], with
    /// the friction of rollers on their axles and rolling resistance, under equal wheel loads.
    ///
    /// # Errors
    /// As [`DynamicModel::new`].
    pub fn of(
        robot: &Robot,
        dc: &DcMotor,
        direction: Twist,
        world: &World,
    ) -> Result<Self, ControlError> {
        let model = DynamicModel::new(robot)?;
        let n = robot.wheels.len();
        let mut rates = vec![0.0; n];
        model.kinematics().wheel_rates(direction, &mut rates);
        // The mean drive torque at a multiple of the direction's speed, or of its acceleration.
        let driving_n_m = |speed: f64, acceleration: f64| -> f64 {
            let times = |by: f64| -> Vec<f64> { rates.iter().map(|rate| by * rate).collect() };
            let mut torques_n_m = vec![0.0; n];
            model.torques(&times(speed), &times(acceleration), &mut torques_n_m);
            let along = torques_n_m.iter().zip(&rates);
            along
                .map(|(torque, rate)| torque * sign(*rate))
                .sum::<f64>()
                / n as f64
        };
        let (once_n_m, twice_n_m) = (driving_n_m(1.0, 0.0), driving_n_m(2.0, 0.0));
        let rate_sum = rates.iter().map(|rate| rate.abs()).sum::<f64>();
        let load_n = robot.mass_kg() * world.gravity_m_s2 / n as f64;
        let on_axles_w: f64 = robot
            .wheels
            .iter()
            .map(|wheel| axle_w(wheel, direction, load_n))
            .sum();
        // The drag is resistance times load, in every direction.
        let floor_resistance = world.floor.rolling_resistance.unwrap_or(0.0);
        let resistance = |wheel: &Wheel| floor_resistance + wheel.surface.rolling_resistance;
        let drag_n = load_n * robot.wheels.iter().map(resistance).sum::<f64>();
        let rolling_w = drag_n * direction.linear_m_s().norm();
        let dry_n_m = 2.0 * once_n_m - twice_n_m + (on_axles_w + rolling_w) / rate_sum;
        // As shares of the voltage.
        let efficiency = robot
            .wheels
            .iter()
            .map(|w| w.drive.gear_efficiency)
            .sum::<f64>()
            / n as f64;
        let of_torque = |torque_n_m: f64| torque_n_m / (efficiency * dc.stall_torque_n_m);
        let radius_m = robot.mean_wheel_radius_m();
        // Rim speed of a wheel while the robot moves at the direction's speed.
        let rim_m_s = radius_m * rate_sum / n as f64;
        let drag_v_s_m = BATTERY_V * of_torque(twice_n_m - once_n_m) / rim_m_s;
        Ok(Self {
            ks_v: BATTERY_V * of_torque(dry_n_m),
            kv_v_s_m: drag_v_s_m + BATTERY_V / (radius_m * dc.no_load_rate_rad_s),
            drag_v_s_m,
            ka_v_s2_m: BATTERY_V * of_torque(driving_n_m(0.0, 1.0)) / rim_m_s,
        })
    }
}

/// The friction power on the axle of a wheel's touching roller, in W, while the robot moves with a
/// twist.
fn axle_w(wheel: &Wheel, twist: Twist, load_n: f64) -> f64 {
    let Some(roller) = wheel.rollers.first() else {
        return 0.0;
    };
    let (n, b) = (wheel.axis(), wheel.position_m().xy());
    let along = RowVector3::new(n.x, n.y, b.x * n.y - b.y * n.x);
    let m_s = along.x * twist.vx_m_s + along.y * twist.vy_m_s + along.z * twist.omega_rad_s;
    let spin_rad_s = m_s / (roller.radius_m * libm::cos(wheel.gamma_rad));
    wheel.surface.axle_drag_n_m(load_n) * spin_rad_s.abs()
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// The fields of `MecanumDrive.Params` of Road Runner's quickstart, as Java; `None` unless `drive`
/// has mecanum wheels. The ratio of sideways to forward distance is `measured`, or otherwise that
/// of the rollers' geometry.
///
/// # Errors
/// As [`Feedforward::of`].
pub fn road_runner(
    robot: &Robot,
    drive: &DriveParameters,
    (dc, world): (&DcMotor, &World),
    limits: &Limits,
    measured: Option<f64>,
) -> Result<Option<String>, ControlError> {
    let Controller::Mecanum { center_sum_m, .. } = &drive.controller else {
        return Ok(None);
    };
    let [ahead, left] = [Twist::new(1.0, 0.0, 0.0), Twist::new(0.0, 1.0, 0.0)]
        .map(|way| Feedforward::of(robot, dc, way, world));
    let (ahead, left) = (ahead?, left?);
    let least = drive
        .rate_limits_rad_s
        .iter()
        .copied()
        .fold(dc.no_load_rate_rad_s, f64::min);
    let [x, y, yaw] = limits.acceleration_box.map(|side| side.max(0.0));
    let along = x.min(y) / INCH_M;
    let name: String = robot.name.chars().filter(|c| !c.is_control()).collect();
    Ok(Some(format!(
        "// Road Runner's MecanumDrive.Params for the robot \"{name}\", made by ilon {version}. Set inPerTick to what yours measures.\n\
         // Sideways over ahead {from}.\n\
         public double lateralInPerTick = {lateral:.5} * inPerTick;\n\
         public double trackWidthTicks = {track:.4} / inPerTick;\n\n\
         // Volts of a motor on {BATTERY_V} V per speed of a wheel's rim, ahead. To the left the same robot has kS = {ks_left:.4},\n\
         // kV = {kv_left:.6} * inPerTick and kA = {ka_left:.6} * inPerTick: Road Runner has one set for both.\n\
         public double kS = {ks:.4};\npublic double kV = {kv:.6} * inPerTick;\npublic double kA = {ka:.6} * inPerTick;\n\n\
         // In inches: nine tenths of what the wheels' rates allow, and of what neither grip
         // (friction {friction}) nor motors forbid.\n\
         public double maxWheelVel = {wheel:.2};\npublic double minProfileAccel = {down:.2};\npublic double maxProfileAccel = {up:.2};\n\
         public double maxAngVel = {yaw_rate:.4};\npublic double maxAngAccel = {yaw:.4};\n",
        version = env!("CARGO_PKG_VERSION"),
        from = match measured {
            Some(_) => "as it was measured",
            None => "as its rollers make it",
        },
        lateral = measured.unwrap_or(drive.real_over_asked[1]),
        track = center_sum_m / INCH_M,
        ks_left = left.ks_v,
        kv_left = left.kv_v_s_m * INCH_M,
        ka_left = left.ka_v_s2_m * INCH_M,
        ks = ahead.ks_v,
        kv = ahead.kv_v_s_m * INCH_M,
        ka = ahead.ka_v_s2_m * INCH_M,
        friction = limits.friction,
        wheel = 0.9 * least * drive.radius_m / INCH_M,
        down = -along,
        up = along,
        yaw_rate = 0.9 * least * drive.radius_m / center_sum_m,
    )))
}
