//! The table itself: one line per quantity, with its accuracy and its limits.

use super::quantity::{Accuracy, Group, Limits, Measure, Quantity, Unit};
use crate::ledger::Integral;
use crate::metrics::Summary;

const fn unit(symbol: &'static str, per_si: f64) -> Unit {
    Unit { symbol, per_si }
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const METRE: Unit = unit("m", 1.0);
const MILLIMETRE: Unit = unit("mm", 1e3);
const MILLIMETRE_A_METRE: Unit = unit("mm per m", 1e3);
const MILLIMETRE_A_SECOND: Unit = unit("mm/s", 1e3);
const METRE_A_SECOND: Unit = unit("m/s", 1.0);
const METRE_A_SECOND_SQUARED: Unit = unit("m/s^2", 1.0);
const RADIAN_A_SECOND: Unit = unit("rad/s", 1.0);
const DEGREE: Unit = unit("deg", DEGREES);
const DEGREE_A_METRE: Unit = unit("deg per m", DEGREES);
const DEGREE_A_TURN: Unit = unit("deg per turn", DEGREES);
const SECOND: Unit = unit("s", 1.0);
const MILLISECOND: Unit = unit("ms", 1e3);
const NEWTON_METRE: Unit = unit("N m", 1.0);
const JOULE: Unit = unit("J", 1.0);
const PERCENT: Unit = unit("%", 1e2);
const NUMBER: Unit = unit("", 1.0);
const TIMES_REAL: Unit = unit("times real time, one core", 1.0);

const fn of(of: Measure, share: f64) -> Accuracy {
    Accuracy { of, share }
}

const WAY: Accuracy = of(Measure::Way, 1e-3);
const TURN: Accuracy = of(Measure::Turn, 1e-3);
const RATIO: Accuracy = of(Measure::Itself, 1e-3);
const WORK: Accuracy = of(Measure::Itself, 0.01);
const PEAK: Accuracy = of(Measure::Itself, 0.1);

/// A field of a summary as a number.
trait Figure {
    fn figure(self) -> Option<f64>;
}

impl Figure for f64 {
    fn figure(self) -> Option<f64> {
        Some(self)
    }
}

impl Figure for Option<f64> {
    fn figure(self) -> Option<f64> {
        self
    }
}

impl Figure for u64 {
    fn figure(self) -> Option<f64> {
        Some(self as f64)
    }
}

/// One line of the table: the field, which is also the key; `?` marks a part that may be absent,
/// and `if` a condition for its presence.
macro_rules! quantity {
    ($is_main:literal, $($field:ident).+, $label:literal, $unit:ident, $decimals:literal) => {
        quantity!(@ $is_main, [$($field).+], |s: &Summary| Figure::figure(s.$($field).+), $label, $unit, $decimals)
    };
    ($is_main:literal, $part:ident ? . $field:ident, $label:literal, $unit:ident, $decimals:literal) => {
        quantity!(@ $is_main, [$part.$field], |s: &Summary| s.$part.map(|part| part.$field), $label, $unit, $decimals)
    };
    ($is_main:literal, $($field:ident).+ if $present:expr, $label:literal, $unit:ident, $decimals:literal) => {
        quantity!(@ $is_main, [$($field).+], |s: &Summary| $present(s).then_some(s.$($field).+), $label, $unit, $decimals)
    };
    (@ $is_main:literal, [$first:ident $(. $rest:ident)*], $get:expr, $label:literal, $unit:ident, $decimals:literal) => {
        Quantity {
            key: concat!(stringify!($first) $(, ".", stringify!($rest))*),
            label: $label,
            unit: $unit,
            decimals: $decimals,
            is_main: $is_main,
            accuracy: None,
            is_compared: false,
            limits: None,
            get: $get,
        }
    };
}

macro_rules! main { ($($line:tt)+) => { quantity!(true, $($line)+) }; }
macro_rules! detail { ($($line:tt)+) => { quantity!(false, $($line)+) }; }

fn has_belief(summary: &Summary) -> bool {
    summary.ledger.belief != Integral::default()
}

fn has_incline(summary: &Summary) -> bool {
    summary.ledger.incline != Integral::default()
}

/// The terms of the error budget; each group shows one component, of which the brackets hold what
/// is known of every term, and of their total alone.
#[rustfmt::skip]
macro_rules! budget {
    ($heading:literal, $line:ident, $component:ident, $unit:ident, $decimals:literal, [$($each:tt)*], [$($total:tt)*]) => {
        Group {
            heading: $heading,
            open_loop_only: false,
            quantities: &[
                $line!(ledger.guidance.$component, "guidance", $unit, $decimals) $($each)*,
                $line!(ledger.compensation.$component, "compensation", $unit, $decimals) $($each)*,
                $line!(ledger.belief.$component if has_belief, "belief", $unit, $decimals) $($each)*,
                $line!(ledger.servo.$component, "servo", $unit, $decimals) $($each)*,
                $line!(ledger.geometry.$component, "roller geometry", $unit, $decimals) $($each)*,
                $line!(ledger.lift_off.$component, "lift-off", $unit, $decimals) $($each)*,
                $line!(ledger.conflict.$component, "conflict", $unit, $decimals) $($each)*,
                $line!(ledger.slip.$component, "slip", $unit, $decimals) $($each)*,
                $line!(ledger.incline.$component if has_incline, "incline", $unit, $decimals) $($each)*,
                $line!(ledger.total.$component, "total", $unit, $decimals) $($each)* $($total)*,
            ],
        }
    };
}

/// The drift of dead reckoning; the brackets hold what is known of its drift in heading.
#[rustfmt::skip]
macro_rules! drift {
    ($heading:literal, $way:ident, [$($heading_said:tt)*]) => {
        Group {
            heading: $heading,
            open_loop_only: false,
            quantities: &[
                main!($way.m_per_m, "distance, per metre travelled", MILLIMETRE_A_METRE, 2).compared().within(Limits::SIZE_IF_ANY),
                main!($way.rad_per_m, "heading, per metre travelled", DEGREE_A_METRE, 3) $($heading_said)*,
                detail!($way.final_m, "distance, at the end", MILLIMETRE, 2).within(Limits::SIZE_IF_ANY),
                detail!($way.final_rad, "heading, at the end", DEGREE, 3),
                detail!($way.worst_m, "distance, largest", MILLIMETRE, 2).within(Limits::SIZE_IF_ANY),
                detail!($way.rad_per_turn, "heading, per turn", DEGREE_A_TURN, 3),
            ],
        }
    };
}

/// The components of a mean twist; the brackets hold what is known of each.
macro_rules! twist {
    ($heading:literal, $twist:ident, [$($each:tt)*]) => {
        Group {
            heading: $heading,
            open_loop_only: true,
            quantities: &[
                detail!($twist?.vx_m_s, "vx", METRE_A_SECOND, 5) $($each)*,
                detail!($twist?.vy_m_s, "vy", METRE_A_SECOND, 5) $($each)*,
                detail!($twist?.omega_rad_s, "omega", RADIAN_A_SECOND, 5) $($each)*,
            ],
        }
    };
}

/// The components of a ratio of twists; the brackets hold what is known of each.
macro_rules! ratio {
    ($heading:literal, $ratio:ident, [$($each:tt)*]) => {
        Group {
            heading: $heading,
            open_loop_only: true,
            quantities: &[
                main!($ratio.vx, "vx", PERCENT, 3) $($each)*,
                main!($ratio.vy, "vy", PERCENT, 3) $($each)*,
                main!($ratio.omega, "omega", PERCENT, 3) $($each)*,
            ],
        }
    };
}

/// Every number of a summary except those of single wheels, in display order.
#[rustfmt::skip]
pub static GROUPS: &[Group] = &[
    Group {
        heading: "run",
        open_loop_only: false,
        quantities: &[
            detail!(duration_s, "simulated", SECOND, 2).within(Limits::SIZE),
            detail!(steps, "physics steps", NUMBER, 0).within(Limits::SIZE),
            detail!(physics_dt_s, "physics step", MILLISECOND, 3).within(Limits::SIZE),
            detail!(control_dt_s, "control period", MILLISECOND, 3).within(Limits::SIZE),
            detail!(sim_seconds_per_cpu_second, "speed", TIMES_REAL, 1).within(Limits::SIZE),
        ],
    },
    Group {
        heading: "tracking",
        open_loop_only: false,
        quantities: &[
            main!(position_error_rms_m, "position error, rms", MILLIMETRE, 2).known_to(WAY).within(Limits::SIZE_IF_ANY),
            main!(position_error_max_m, "position error, largest", MILLIMETRE, 2).known_to(WAY).within(Limits::SIZE_IF_ANY),
            main!(position_error_max_at_s, "position error, largest at", SECOND, 2).within(Limits::SIZE_IF_ANY),
            main!(position_error_final_m, "position error, at the end", MILLIMETRE, 3).known_to(WAY).within(Limits::SIZE_IF_ANY),
            main!(position_converged_s, "position under 5 cm from", SECOND, 2).compared().within(Limits::SIZE_IF_ANY),
            main!(heading_error_rms_rad, "heading error, rms", DEGREE, 3).known_to(TURN).within(Limits::SIZE_IF_ANY),
            main!(heading_error_max_rad, "heading error, largest", DEGREE, 3).known_to(TURN).within(Limits::SIZE_IF_ANY),
            detail!(heading_error_max_at_s, "heading error, largest at", SECOND, 2).within(Limits::SIZE_IF_ANY),
            main!(heading_error_final_rad, "heading error, at the end", DEGREE, 4).known_to(TURN).within(Limits::SIZE_IF_ANY),
            main!(heading_converged_s, "heading under 3 deg from", SECOND, 2).compared().within(Limits::SIZE_IF_ANY),
            main!(saturated_share, "saturated", PERCENT, 1).known_to(PEAK).within(Limits::SHARE_IF_ANY),
            detail!(seen_position_error_rms_m, "estimated position off by, rms", MILLIMETRE, 2).compared().within(Limits::SIZE_IF_ANY),
            detail!(seen_heading_error_rms_rad, "estimated heading off by, rms", DEGREE, 3).within(Limits::SIZE_IF_ANY),
        ],
    },
    twist!("commanded twist, mean", twist_asked_mean, []),
    twist!("real twist, mean", twist_mean, [.compared()]),
    twist!("real twist, rms about its mean", twist_ripple, [.within(Limits::SIZE_IF_ANY)]),
    twist!("twist by the ideal kinematics, mean", twist_ideal_mean, []),
    twist!("twist by the contact kinematics, mean", twist_contact_mean, []),
    ratio!("real over commanded", twist_ratio_asked, []),
    ratio!("real over ideal kinematics", twist_ratio_ideal, [.known_to(RATIO)]),
    ratio!("real over contact kinematics", twist_ratio_contact, [.known_to(RATIO)]),
    Group {
        heading: "wheels",
        open_loop_only: false,
        quantities: &[
            main!(wheel_rate_command_max_rad_s, "largest commanded rate", RADIAN_A_SECOND, 3).within(Limits::SIZE),
            main!(wheel_rate_error_rms_rad_s, "rate error, rms", RADIAN_A_SECOND, 3).within(Limits::SIZE),
            main!(wheel_torque_max_n_m, "largest torque", NEWTON_METRE, 3).known_to(PEAK).within(Limits::SIZE),
            main!(rate_conflict_share, "conflict of the wheels' rates", PERCENT, 2).within(Limits::SHARE_IF_ANY),
            main!(hub_ripple_m, "hub ripple", MILLIMETRE, 4).compared().within(Limits::SIZE),
            detail!(airborne_share, "in the air", PERCENT, 2).known_to(PEAK).within(Limits::SHARE),
            detail!(chassis_load_share, "weight on the chassis", PERCENT, 2).known_to(PEAK).within(Limits::SHARE_IF_ANY),
        ],
    },
    Group {
        heading: "slip",
        open_loop_only: false,
        quantities: &[
            main!(slip_speed_rms_m_s, "sliding speed, rms", MILLIMETRE_A_SECOND, 2).within(Limits::SIZE),
            main!(slip_speed_max_m_s, "sliding speed, largest", MILLIMETRE_A_SECOND, 2).known_to(PEAK).within(Limits::SIZE),
            main!(slip_energy_j, "lost to sliding", JOULE, 4).known_to(PEAK).within(Limits::LOSS),
            main!(wheel_slip_energy_j, "lost to sliding under the robot's wheels", JOULE, 4).within(Limits::LOSS),
            main!(energy.spin_up_j, "roller spin-up", JOULE, 4).known_to(PEAK).within(Limits::LOSS),
            main!(friction_used_max, "most grip used by a wheel", PERCENT, 1).known_to(PEAK).within(Limits::SHARE),
            detail!(contact_residual_max_m_s, "largest residual of the contacts", MILLIMETRE_A_SECOND, 6).within(Limits::SIZE),
        ],
    },
    Group {
        heading: "energy",
        open_loop_only: false,
        quantities: &[
            main!(energy.motor_j, "net work of the motors", JOULE, 3).known_to(WORK),
            detail!(energy.motor_positive_j, "work of the motors while they drove", JOULE, 3).compared().within(Limits::SIZE),
            detail!(energy.outside_j, "brought from outside", JOULE, 3),
            detail!(energy.outside_positive_j, "brought from outside, inwards only", JOULE, 3).within(Limits::SIZE),
            detail!(energy.fall_j, "given by the deepest fall", JOULE, 3).within(Limits::SIZE),
            detail!(energy.put_in_j, "put in by motors, pushes and gravity", JOULE, 3).within(Limits::SIZE),
            detail!(energy.stored_j, "gain of kinetic and potential energy", JOULE, 3),
            detail!(energy.slip_j, "lost to sliding", JOULE, 4).within(Limits::LOSS),
            main!(energy.bearing_j, "lost in bearings", JOULE, 4).known_to(WORK).within(Limits::LOSS),
            detail!(energy.impact_j, "lost in impacts", JOULE, 4).known_to(PEAK).within(Limits::LOSS),
            main!(storage_rise_j, "rise of the passive law's storage beyond its supply", JOULE, 6),
            detail!(energy.unexplained_j, "unexplained", JOULE, 4),
            detail!(energy.unexplained_share, "unexplained share", PERCENT, 3),
        ],
    },
    Group {
        heading: "way",
        open_loop_only: false,
        quantities: &[
            detail!(end_x_m, "x at the end", METRE, 4).known_to(WAY),
            detail!(end_y_m, "y at the end", METRE, 4).known_to(WAY),
            detail!(end_heading_rad, "heading at the end", DEGREE, 3).known_to(TURN),
            detail!(travelled_m, "length of the path", METRE, 3).known_to(WAY).within(Limits::SIZE),
            detail!(turned_rad, "total turning", DEGREE, 1).known_to(TURN).within(Limits::SIZE),
            detail!(odometry_drift_m_per_m, "odometry drift", MILLIMETRE_A_METRE, 2).within(Limits::SIZE_IF_ANY),
            detail!(odometry_drift_rad_per_m, "odometry drift, heading", DEGREE_A_METRE, 3),
            detail!(odometry_joints_m, "odometry error by hub motion", MILLIMETRE, 2).within(Limits::SIZE_IF_ANY),
        ],
    },
    drift!("odometry by the ideal kinematics", odometry_ideal, [.compared()]),
    drift!("odometry by the contact kinematics", odometry_contact, []),
    budget!("error budget: path length of each term", main, path_m, MILLIMETRE, 2, [.within(Limits::SIZE)], [.compared()]),
    budget!("error budget: turned by each term, back and forth", detail, turned_rad, DEGREE, 3, [.within(Limits::SIZE)], [.compared()]),
    budget!("error budget: along the world's x axis", detail, x_m, MILLIMETRE, 2, [], [.compared()]),
    budget!("error budget: along the world's y axis", detail, y_m, MILLIMETRE, 2, [], [.compared()]),
    budget!("error budget: heading", detail, heading_rad, DEGREE, 3, [], []),
    Group {
        heading: "design, without a run",
        open_loop_only: false,
        quantities: &[
            main!(design.rank, "rank of M, with the rows of tyres", NUMBER, 0),
            main!(design.condition, "condition of M", NUMBER, 2),
            main!(design.speed_least_m_s, "top speed, slowest direction", METRE_A_SECOND, 3),
            main!(design.speed_most_m_s, "top speed, fastest direction", METRE_A_SECOND, 3),
            main!(design.yaw_rate_rad_s, "top yaw rate", RADIAN_A_SECOND, 3),
            main!(design.acceleration_least_m_s2, "acceleration without slip, least direction", METRE_A_SECOND_SQUARED, 3),
            main!(design.acceleration_most_m_s2, "acceleration without slip, most direction", METRE_A_SECOND_SQUARED, 3),
        ],
    },
];
