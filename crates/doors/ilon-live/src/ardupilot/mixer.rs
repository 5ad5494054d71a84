//! Assigns the robot's wheels to ArduPilot's motors.
//!
//! ArduPilot mixes throttle, steering and lateral into motors by the factors of a frame type
//! (`libraries/AR_Motors`). The robot's kinematics gives the rate of each wheel for each of the
//! three. The wheels are assigned to the motors with the best agreement, each with its sign: so the
//! user need not number wheels or reverse servos.

use ilon_control::Kinematics;
use ilon_robot::Twist;

/// Part of a wheel or motor in throttle (ahead), steering (to the right) and lateral (to the
/// right).
type Factors = [f64; 3];

/// A frame type of ArduPilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Its name.
    pub name: &'static str,
    /// The value of `FRAME_TYPE`.
    pub frame_type: u8,
    /// Factors of each motor.
    motors: &'static [Factors],
}

const FRAMES: [Frame; 3] = [
    Frame {
        name: "Omni3",
        frame_type: 1,
        motors: &[[1.0, -1.0, -1.0], [0.0, -1.0, 1.0], [1.0, 1.0, 1.0]],
    },
    Frame {
        name: "OmniX",
        frame_type: 2,
        motors: &[
            [1.0, -1.0, -1.0],
            [1.0, -1.0, 1.0],
            [1.0, 1.0, -1.0],
            [1.0, 1.0, 1.0],
        ],
    },
    Frame {
        name: "Omni3Mecanum",
        frame_type: 4,
        motors: &[
            [-1.0, 1.0, -0.26795],
            [0.73205, 1.0, -0.73205],
            [0.26795, 1.0, 1.0],
        ],
    },
];

/// The wheel of each motor of a frame, with its sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixer {
    /// The frame.
    pub frame: Frame,
    /// For each motor the index of its wheel, and 1 or -1.
    pub wheels: Vec<(usize, f64)>,
}

impl Mixer {
    /// Returns the frame that fits a robot best; `None` if none fits: another number of wheels,
    /// wheels that turn against the mix, or a mix that drives the robot elsewhere.
    pub fn of(kinematics: &Kinematics) -> Option<Self> {
        let wheels = parts(kinematics);
        let fits = FRAMES
            .iter()
            .filter(|frame| frame.motors.len() == wheels.len());
        let found = fits.filter_map(|frame| {
            let (cost, wheels) = assigned(frame.motors, &wheels, &mut Vec::new())?;
            let frame = *frame;
            let mixer = Self { frame, wheels };
            mixer.drives(kinematics).then_some((cost, mixer))
        });
        let best = found.min_by(|(a, _), (b, _)| a.total_cmp(b));
        best.map(|(_, mixer)| mixer)
    }

    /// Whether throttle and lateral move a robot along their axes, and steering turns it to the
    /// right. Lateral may turn it too: in Omni3 it does, and Rover steers against it.
    fn drives(&self, kinematics: &Kinematics) -> bool {
        /// Of the motion, across the axis: 6 degrees. Chosen.
        const ASIDE: f64 = 0.1;
        let mut rates = vec![0.0; self.wheels.len()];
        // At their present angles tyres cannot roll in every direction, and casters in none.
        let is_rolled = ways().into_iter().all(|way| {
            kinematics.wheel_rates(way, &mut rates);
            let rolled = kinematics.twist(&rates);
            let short = [
                rolled.vx_m_s - way.vx_m_s,
                rolled.vy_m_s - way.vy_m_s,
                rolled.omega_rad_s - way.omega_rad_s,
            ];
            short.iter().all(|short| short.abs() < ASIDE)
        });
        let [throttle, steering, lateral] = [0, 1, 2].map(|way| {
            for (motor, (wheel, sign)) in self.frame.motors.iter().zip(&self.wheels) {
                rates[*wheel] = sign * motor[way];
            }
            kinematics.twist(&rates)
        });
        is_rolled
            && throttle.vy_m_s.abs() < ASIDE * throttle.vx_m_s
            && lateral.vx_m_s.abs() < -ASIDE * lateral.vy_m_s
            && steering.omega_rad_s < 0.0
    }
}

/// Returns unit twists of throttle, steering and lateral. To the right means -y, and clockwise seen
/// from above.
fn ways() -> [Twist; 3] {
    [
        Twist::new(1.0, 0.0, 0.0),
        Twist::new(0.0, 0.0, -1.0),
        Twist::new(0.0, -1.0, 0.0),
    ]
}

/// Returns each wheel's part in throttle, steering and lateral; the largest part in each is 1.
fn parts(kinematics: &Kinematics) -> Vec<Factors> {
    let count = kinematics.wheel_count();
    let mut parts = vec![[0.0; 3]; count];
    for (way, twist) in ways().into_iter().enumerate() {
        let mut rates = vec![0.0; count];
        kinematics.wheel_rates(twist, &mut rates);
        let most = rates
            .iter()
            .fold(f64::MIN_POSITIVE, |most: f64, rate| most.max(rate.abs()));
        for (part, rate) in parts.iter_mut().zip(rates) {
            part[way] = rate / most;
        }
    }
    parts
}

/// Returns the difference between a wheel with a sign and a motor; `None` if it turns against it.
fn differs(motor: &Factors, wheel: &Factors, sign: f64) -> Option<f64> {
    /// Smaller parts are rounding of the robot's file.
    const NONE: f64 = 0.05;
    let mut sum = 0.0;
    for (wanted, part) in motor.iter().zip(wheel.map(|part| sign * part)) {
        if wanted * part < 0.0 && wanted.abs().min(part.abs()) > NONE {
            return None;
        }
        sum += (wanted - part) * (wanted - part);
    }
    Some(sum)
}

/// Returns the best assignment of the remaining wheels to motors, one each.
fn assigned(
    motors: &[Factors],
    wheels: &[Factors],
    taken: &mut Vec<usize>,
) -> Option<(f64, Vec<(usize, f64)>)> {
    let Some((motor, rest)) = motors.split_first() else {
        return Some((0.0, Vec::new()));
    };
    let mut best: Option<(f64, Vec<(usize, f64)>)> = None;
    for wheel in 0..wheels.len() {
        if taken.contains(&wheel) {
            continue;
        }
        for sign in [1.0, -1.0] {
            let Some(own) = differs(motor, &wheels[wheel], sign) else {
                continue;
            };
            taken.push(wheel);
            let others = assigned(rest, wheels, taken);
            taken.pop();
            if let Some((cost, mut order)) = others
                && best.as_ref().is_none_or(|(least, _)| own + cost < *least)
            {
                order.insert(0, (wheel, sign));
                best = Some((own + cost, order));
            }
        }
    }
    best
}
