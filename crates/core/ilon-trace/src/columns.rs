//! The table of all recorded signals. It alone defines their names, order and types in files and
//! hashes.

use ilon_robot::Pose;

use crate::header::Header;
use crate::ledger::{Integral, NAMES};
use crate::record::{
    BodySample, Desired, ImuSample, JointSample, MAX_BODIES, MAX_JOINTS, MAX_TASKS, Record,
    Storage, Support, TaskShare, WheelSample,
};
use crate::trace::{RowMut, Trace};

/// The type of a signal in a file. In memory all signals are f64, which represents each of them
/// exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnType {
    /// A real number.
    Real,
    /// A whole number >= 0.
    Count,
    /// True or false.
    Flag,
}

/// One signal of a `T`, by name.
#[derive(Debug)]
pub(crate) struct Column<T: 'static> {
    name: &'static str,
    kind: ColumnType,
    get: fn(&T) -> f64,
    set: fn(&mut T, f64),
}

impl<T> Column<T> {
    /// Writes a value where there is a place for it.
    fn put<'t>(&self, target: impl Into<Option<&'t mut T>>, value: f64) {
        if let Some(target) = target.into() {
            (self.set)(target, value);
        }
    }
}

macro_rules! reals {
    ($t:ty; $($name:literal => $($path:ident).+ $([$at:literal])?,)*) => {
        [$(Column::<$t> {
            name: $name,
            kind: ColumnType::Real,
            get: |source| source.$($path).+$([$at])?,
            set: |target, value| target.$($path).+$([$at])? = value,
        }),*]
    };
}

static RECORD: [Column<Record>; 48] = reals! { Record;
    "t_s" => t_s,
    "truth_x_m" => truth.pose.x_m,
    "truth_y_m" => truth.pose.y_m,
    "truth_heading_rad" => truth.pose.heading_rad,
    "truth_height_m" => truth.height_m,
    "truth_roll_rad" => truth.roll_rad,
    "truth_pitch_rad" => truth.pitch_rad,
    "truth_vx_m_s" => truth.twist_in_body.vx_m_s,
    "truth_vy_m_s" => truth.twist_in_body.vy_m_s,
    "truth_omega_rad_s" => truth.twist_in_body.omega_rad_s,
    "ideal_vx_m_s" => twist_ideal.vx_m_s,
    "ideal_vy_m_s" => twist_ideal.vy_m_s,
    "ideal_omega_rad_s" => twist_ideal.omega_rad_s,
    "contact_vx_m_s" => twist_contact.vx_m_s,
    "contact_vy_m_s" => twist_contact.vy_m_s,
    "contact_omega_rad_s" => twist_contact.omega_rad_s,
    "seen_x_m" => seen_pose.x_m,
    "seen_y_m" => seen_pose.y_m,
    "seen_heading_rad" => seen_pose.heading_rad,
    "odometry_ideal_x_m" => odometry_ideal.x_m,
    "odometry_ideal_y_m" => odometry_ideal.y_m,
    "odometry_ideal_heading_rad" => odometry_ideal.heading_rad,
    "odometry_contact_x_m" => odometry_contact.x_m,
    "odometry_contact_y_m" => odometry_contact.y_m,
    "odometry_contact_heading_rad" => odometry_contact.heading_rad,
    "command_vx_m_s" => command_twist_in_body.vx_m_s,
    "command_vy_m_s" => command_twist_in_body.vy_m_s,
    "command_omega_rad_s" => command_twist_in_body.omega_rad_s,
    "granted_vx_m_s" => granted_twist_in_body.vx_m_s,
    "granted_vy_m_s" => granted_twist_in_body.vy_m_s,
    "granted_omega_rad_s" => granted_twist_in_body.omega_rad_s,
    "target_ideal_vx_m_s" => twist_target_ideal.vx_m_s,
    "target_ideal_vy_m_s" => twist_target_ideal.vy_m_s,
    "target_ideal_omega_rad_s" => twist_target_ideal.omega_rad_s,
    "saturated_share" => saturated_share,
    "torque_weight_position" => torque_weight_position,
    "torque_weight_heading" => torque_weight_heading,
    "slip_energy_j" => slip_energy_j,
    "spin_up_energy_j" => spin_up_energy_j,
    "motor_energy_j" => motor_energy_j,
    "motor_positive_energy_j" => motor_positive_energy_j,
    "bearing_energy_j" => bearing_energy_j,
    "impact_energy_j" => impact_energy_j,
    "outside_energy_j" => outside_energy_j,
    "kinetic_energy_j" => kinetic_energy_j,
    "potential_energy_j" => potential_energy_j,
    "contact_residual_m_s" => contact_residual_m_s,
    "rate_conflict_share" => rate_conflict_share,
};

/// For one term of the ledger, or for their sum.
static TERM: [Column<Integral>; 5] = reals! { Integral;
    "x_m" => x_m,
    "y_m" => y_m,
    "heading_rad" => heading_rad,
    "path_m" => path_m,
    "turned_rad" => turned_rad,
};

static DESIRED: [Column<Desired>; 8] = reals! { Desired;
    "desired_x_m" => pose.x_m,
    "desired_y_m" => pose.y_m,
    "desired_heading_rad" => pose.heading_rad,
    "desired_vx_in_world_m_s" => velocity_in_world.vx_m_s,
    "desired_vy_in_world_m_s" => velocity_in_world.vy_m_s,
    "desired_omega_rad_s" => velocity_in_world.omega_rad_s,
    "position_error_max_m" => position_error_max_m,
    "heading_error_max_rad" => heading_error_max_rad,
};

static SUPPORT: [Column<Support>; 4] = reals! { Support;
    "wheels_load_n" => wheels_n,
    "chassis_load_n" => chassis_n,
    "obstacle_force_x_n" => obstacles_x_n,
    "obstacle_force_y_n" => obstacles_y_n,
};

static MEASURED: [Column<Pose>; 3] = reals! { Pose;
    "measured_x_m" => x_m,
    "measured_y_m" => y_m,
    "measured_heading_rad" => heading_rad,
};

static POSED: [Column<Pose>; 3] = reals! { Pose;
    "odometry_posed_x_m" => x_m,
    "odometry_posed_y_m" => y_m,
    "odometry_posed_heading_rad" => heading_rad,
};

static IMU: [Column<ImuSample>; 8] = reals! { ImuSample;
    "imu_rate_x_rad_s" => rate_rad_s.x,
    "imu_rate_y_rad_s" => rate_rad_s.y,
    "imu_rate_z_rad_s" => rate_rad_s.z,
    "imu_specific_force_x_m_s2" => specific_force_m_s2.x,
    "imu_specific_force_y_m_s2" => specific_force_m_s2.y,
    "imu_specific_force_z_m_s2" => specific_force_m_s2.z,
    "imu_roll_rad" => roll_rad,
    "imu_pitch_rad" => pitch_rad,
};

static STORAGE: [Column<Storage>; 3] = reals! { Storage;
    "storage_j" => stored_j,
    "storage_supplied_j" => supplied_j,
    "storage_rise_j" => rise_j,
};

static TASK: [Column<TaskShare>; 6] = reals! { TaskShare;
    "asked_rad_s" => asked_rad_s,
    "capacity_rad_s" => capacity_rad_s,
    "weight" => weight,
    "asked_vx_m_s" => asked_twist_in_body.vx_m_s,
    "asked_vy_m_s" => asked_twist_in_body.vy_m_s,
    "asked_omega_rad_s" => asked_twist_in_body.omega_rad_s,
};

/// For a revolute joint, and for a prismatic one.
static JOINT: [[Column<JointSample>; 7]; 2] = [
    reals! { JointSample;
        "position_rad" => position,
        "position_min_rad" => position_min,
        "position_max_rad" => position_max,
        "rate_rad_s" => rate,
        "force_n_m" => force,
        "force_min_n_m" => force_min,
        "force_max_n_m" => force_max,
    },
    reals! { JointSample;
        "position_m" => position,
        "position_min_m" => position_min,
        "position_max_m" => position_max,
        "rate_m_s" => rate,
        "force_n" => force,
        "force_min_n" => force_min,
        "force_max_n" => force_max,
    },
];

static BODY: [Column<BodySample>; 12] = reals! { BodySample;
    "x_m" => place_m [0],
    "y_m" => place_m [1],
    "z_m" => place_m [2],
    "roll_rad" => roll_rad,
    "pitch_rad" => pitch_rad,
    "heading_rad" => heading_rad,
    "vx_m_s" => velocity_m_s [0],
    "vy_m_s" => velocity_m_s [1],
    "vz_m_s" => velocity_m_s [2],
    "push_n" => push_n,
    "push_max_n" => push_max_n,
    "work_j" => work_j,
};

static WHEEL_REALS: [Column<WheelSample>; 30] = reals! { WheelSample;
    "target_rad_s" => target_rad_s,
    "target_peak_rad_s" => target_peak_rad_s,
    "rate_rad_s" => rate_rad_s,
    "rate_error_rms_rad_s" => rate_error_rms_rad_s,
    "angle_rad" => angle_rad,
    "torque_n_m" => torque_n_m,
    "torque_min_n_m" => torque_min_n_m,
    "torque_max_n_m" => torque_max_n_m,
    "hub_height_m" => hub_height_m,
    "hub_height_min_m" => hub_height_min_m,
    "hub_height_max_m" => hub_height_max_m,
    "load_share" => load_share,
    "touching_share" => touching_share,
    "contact_x_m" => contact_x_m,
    "contact_y_m" => contact_y_m,
    "normal_force_n" => normal_force_n,
    "normal_force_min_n" => normal_force_min_n,
    "normal_force_max_n" => normal_force_max_n,
    "force_x_n" => force_x_n,
    "force_y_n" => force_y_n,
    "friction" => friction,
    "friction_used_max" => friction_used_max,
    "slip_x_m_s" => slip_x_m_s,
    "slip_y_m_s" => slip_y_m_s,
    "slip_speed_rms_m_s" => slip_speed_rms_m_s,
    "slip_speed_max_m_s" => slip_speed_max_m_s,
    "slip_energy_j" => slip_energy_j,
    "spin_up_energy_j" => spin_up_energy_j,
    "roller_spin_rad_s" => roller_spin_rad_s,
    "roller_spin_ideal_rad_s" => roller_spin_ideal_rad_s,
};

static WHEEL_OTHERS: [Column<WheelSample>; 2] = [
    Column {
        name: "roller",
        kind: ColumnType::Count,
        get: |wheel| f64::from(wheel.roller),
        set: |wheel, value| wheel.roller = value as u32,
    },
    Column {
        name: "touching",
        kind: ColumnType::Flag,
        get: |wheel| f64::from(u8::from(wheel.touching)),
        set: |wheel, value| wheel.touching = value != 0.0,
    },
];

/// Where a signal is stored in a trace.
#[derive(Debug)]
enum Source {
    Record(&'static Column<Record>),
    /// The total of the ledger, and then its terms.
    Term(usize, &'static Column<Integral>),
    Support(&'static Column<Support>),
    Desired(&'static Column<Desired>),
    Measured(&'static Column<Pose>),
    Posed(&'static Column<Pose>),
    Imu(&'static Column<ImuSample>),
    Storage(&'static Column<Storage>),
    Task(usize, &'static Column<TaskShare>),
    Joint(usize, &'static Column<JointSample>),
    Body(usize, &'static Column<BodySample>),
    Wheel(usize, &'static Column<WheelSample>),
    /// The angle of a roller, by its number among those of all wheels.
    Roller(usize),
}

impl Source {
    /// Whether a row may lack it.
    fn is_nullable(&self) -> bool {
        !matches!(
            self,
            Self::Record(_)
                | Self::Term(..)
                | Self::Task(..)
                | Self::Joint(..)
                | Self::Body(..)
                | Self::Wheel(..)
        )
    }
}

/// One recorded signal of a particular trace.
#[derive(Debug)]
pub struct Signal {
    /// Its name with the unit: `truth_x_m`, `wheel0_rate_rad_s`.
    pub name: String,
    /// How it is stored.
    pub kind: ColumnType,
    /// Whether it can be absent.
    pub nullable: bool,
    source: Source,
}

impl Signal {
    /// The signal at one step; `None` if it is absent.
    pub fn get(&self, trace: &Trace, step: usize) -> Option<f64> {
        let record = trace.records().get(step)?;
        match &self.source {
            Source::Record(column) => Some((column.get)(record)),
            Source::Term(term, column) => record.ledger.all().get(*term).map(column.get),
            Source::Support(column) => record.support.as_ref().map(column.get),
            Source::Desired(column) => record.desired.as_ref().map(column.get),
            Source::Measured(column) => record.measured.as_ref().map(column.get),
            Source::Posed(column) => record.odometry_posed.as_ref().map(column.get),
            Source::Imu(column) => record.imu.as_ref().map(column.get),
            Source::Storage(column) => record.storage.as_ref().map(column.get),
            Source::Task(task, column) => record.tasks.get(*task).map(column.get),
            Source::Joint(joint, column) => record.joints.get(*joint).map(column.get),
            Source::Body(body, column) => record.bodies.get(*body).map(column.get),
            Source::Wheel(wheel, column) => trace.wheels_at(step).get(*wheel).map(column.get),
            Source::Roller(roller) => *trace.roller_angles_at(step).get(*roller)?,
        }
    }

    /// Writes a value from a file into a row.
    pub(crate) fn set(&self, row: &mut RowMut<'_>, value: Option<f64>) {
        let RowMut {
            record,
            wheels,
            rollers,
        } = row;
        let Some(value) = value else { return };
        match &self.source {
            Source::Record(column) => (column.set)(record, value),
            Source::Term(term, column) => {
                column.put(record.ledger.all_mut().into_iter().nth(*term), value);
            }
            Source::Support(column) => column.put(record.support.get_or_insert_default(), value),
            Source::Desired(column) => column.put(record.desired.get_or_insert_default(), value),
            Source::Measured(column) => column.put(record.measured.get_or_insert_default(), value),
            Source::Posed(column) => {
                column.put(record.odometry_posed.get_or_insert_default(), value);
            }
            Source::Imu(column) => column.put(record.imu.get_or_insert_default(), value),
            Source::Storage(column) => column.put(record.storage.get_or_insert_default(), value),
            Source::Task(task, column) => column.put(record.tasks.get_mut(*task), value),
            Source::Joint(joint, column) => column.put(record.joints.get_mut(*joint), value),
            Source::Body(body, column) => column.put(record.bodies.get_mut(*body), value),
            Source::Wheel(wheel, column) => column.put(wheels.get_mut(*wheel), value),
            Source::Roller(roller) => {
                if let Some(angle_rad) = rollers.get_mut(*roller) {
                    *angle_rad = Some(value);
                }
            }
        }
    }
}

/// The signals of columns whose names have a common prefix.
fn of_columns<T: 'static>(
    columns: impl IntoIterator<Item = &'static Column<T>>,
    begins: &str,
    source: impl Fn(&'static Column<T>) -> Source,
) -> Vec<Signal> {
    let signal = |column: &'static Column<T>| {
        let source = source(column);
        Signal {
            name: format!("{begins}{}", column.name),
            kind: column.kind,
            nullable: source.is_nullable(),
            source,
        }
    };
    columns.into_iter().map(signal).collect()
}

/// All signals of a trace with this header, in the order of the file's columns.
pub(crate) fn signals(header: &Header) -> Vec<Signal> {
    let mut all = of_columns(&RECORD, "", Source::Record);
    for (place, term) in std::iter::once("total").chain(NAMES).enumerate() {
        if !header.has_term(term) {
            continue;
        }
        let begins = format!("budget_{}_", term.replace('-', "_"));
        all.extend(of_columns(&TERM, &begins, |of| Source::Term(place, of)));
    }
    all.extend(of_columns(&SUPPORT, "", Source::Support));
    all.extend(of_columns(&DESIRED, "", Source::Desired));
    if header.measured {
        all.extend(of_columns(&MEASURED, "", Source::Measured));
    }
    if !header.joints.is_empty() {
        all.extend(of_columns(&POSED, "", Source::Posed));
    }
    if header.imu {
        all.extend(of_columns(&IMU, "", Source::Imu));
    }
    if header.storage {
        all.extend(of_columns(&STORAGE, "", Source::Storage));
    }
    for task in 0..header.task_names.len().min(MAX_TASKS) {
        let begins = format!("task{task}_");
        all.extend(of_columns(&TASK, &begins, |of| Source::Task(task, of)));
    }
    for (joint, of) in header.joints.iter().enumerate().take(MAX_JOINTS) {
        let (columns, begins) = (
            &JOINT[usize::from(of.slides)],
            format!("joint_{}_", of.name),
        );
        all.extend(of_columns(columns, &begins, |of| Source::Joint(joint, of)));
    }
    for (body, of) in header.bodies.iter().enumerate().take(MAX_BODIES) {
        let begins = format!("body_{}_", of.name);
        all.extend(of_columns(&BODY, &begins, |of| Source::Body(body, of)));
    }
    for wheel in 0..header.wheels.len() {
        let columns = WHEEL_REALS.iter().chain(&WHEEL_OTHERS);
        let begins = format!("wheel{wheel}_");
        all.extend(of_columns(columns, &begins, |of| Source::Wheel(wheel, of)));
    }
    if header.roller_angles {
        let wheels = header.wheels.iter().enumerate();
        let rollers = wheels
            .flat_map(|(wheel, of)| (0..of.roller_count).map(move |roller| (wheel, roller)))
            .enumerate();
        all.extend(rollers.map(|(place, (wheel, roller))| Signal {
            name: format!("wheel{wheel}_roller{roller}_angle_rad"),
            kind: ColumnType::Real,
            nullable: true,
            source: Source::Roller(place),
        }));
    }
    all
}
