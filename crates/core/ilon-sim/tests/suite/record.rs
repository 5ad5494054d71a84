//! The content of a trace, and the receivers of its rows while it grows.

use std::path::Path;

use ilon_formats::{LoadOptions, LoadRobot};
use ilon_sim::robot::Robot;
use ilon_sim::simulate::{
    Commanded, Controller, Decided, Driver, Moment, Plant, Recorder, WheelCommand, load,
    relief_heights_m, resolve_for,
};
use ilon_sim::trace::{Header, Recording, Rows, Sink, Trace, TraceError, trace_hash};
use ilon_sim::{Scenario, Simulation};

const SCENARIO: &str = r#"
robot.file = "mecanum4.urdf"

[twist]
vx_m_s = 0.3
rest_s = 0.0

[world.floor]
friction = 0.7
slope_deg = 2
boxes = [{ x_m = 1, y_m = 0.5, heading_deg = 30, length_x_m = 0.2, length_y_m = 0.4, height_m = 0.01 }]
patches = [{ x_m = 2, y_m = 0, length_x_m = 1, length_y_m = 2, friction = 0.2, until_s = 5 }]

[run]
duration_s = 0.5
"#;

fn simulation(further: &str) -> Simulation {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("{SCENARIO}{further}\n");
    let scenario = Scenario::from_toml(&text, "recorded", folder).expect("a scenario");
    Simulation::new(&scenario).expect("it can be run")
}

#[test]
fn without_the_key_no_roller_is_recorded_and_the_columns_are_those_of_before() {
    let run = simulation("").run();
    assert!(run.trace.roller_angles_at(0).is_empty());
    let names = run.trace.header.signal_names();
    assert!(!names.iter().any(|name| name.contains("_roller0_angle_rad")));
}

#[test]
fn roller_angles_come_as_often_as_asked_and_change_nothing_else() {
    let without = simulation("").run().trace;
    // A row every 10 ms: 100/s and more is every row, 25/s every fourth.
    for (rate_hz, every) in [(1000.0, 1), (100.0, 1), (25.0, 4)] {
        let trace = simulation(&format!("roller_angles_hz = {rate_hz}"))
            .run()
            .trace;
        for (row, record) in trace.records().iter().enumerate() {
            assert_eq!(record, &without.records()[row]);
            let angles = trace.roller_angles_at(row);
            assert_eq!(angles.len(), 36, "four wheels of nine rollers");
            let is_due = row % every == 0;
            assert!(
                angles.iter().all(|angle| angle.is_some() == is_due),
                "row {row}"
            );
        }
        assert!(
            trace
                .roller_angles_at(0)
                .iter()
                .all(|angle| *angle == Some(0.0))
        );
    }
    // Rates that do not divide the rows' are met on average: 30/s over 0.5 s is 15 samples and that
    // of the end.
    let trace = simulation("roller_angles_hz = 30").run().trace;
    let taken = trace.signal("wheel0_roller0_angle_rad").expect("a column");
    assert_eq!(taken.iter().flatten().count(), 16);
}

#[test]
fn a_roller_that_touches_has_turned_by_its_spin() {
    // Sideways, where rollers spin: 0.3 m/s over rollers of some 1 cm.
    let text = SCENARIO.replace("vx_m_s = 0.3", "vy_m_s = 0.3");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("{text}roller_angles_hz = 1000\nphysics_dt_s = 0.0005\n");
    let scenario = Scenario::from_toml(&text, "sideways", folder).expect("a scenario");
    let trace = Simulation::new(&scenario)
        .expect("it can be run")
        .run()
        .trace;
    let mut compared = 0;
    let rows = 20..trace.records().len() - 1;
    for (row, wheel) in rows.flat_map(|row| (0..4).map(move |wheel| (row, wheel))) {
        let (now, next) = (trace.wheels_at(row)[wheel], trace.wheels_at(row + 1)[wheel]);
        let settled = now.touching && next.touching && now.roller == next.roller;
        // Near a hand-over the spin changes within the row.
        if !settled || (now.roller_spin_rad_s - next.roller_spin_rad_s).abs() > 0.5 {
            continue;
        }
        let place = 9 * wheel + now.roller as usize;
        let at = |row: usize| trace.roller_angles_at(row)[place].expect("taken");
        let turned_rad = at(row + 1) - at(row);
        let by_spin_rad = 0.01 * 0.5 * (now.roller_spin_rad_s + next.roller_spin_rad_s);
        // The spins are those of the steps that ended at the rows; half a rad/s over 10 ms between
        // them.
        assert!(
            (turned_rad - by_spin_rad).abs() < 0.005,
            "wheel {wheel}, row {row}: {turned_rad} against {by_spin_rad}"
        );
        compared += 1;
    }
    // A quarter of all rows of all wheels at least.
    assert!(compared > 4 * 29 / 4, "{compared}");
}

#[test]
fn the_header_holds_the_robot_and_its_ground() {
    let header = simulation("").trace().header.clone();
    let again = Robot::from_urdf_str_with(&header.urdf, "trace", &LoadOptions::default());
    let again = again.expect("the URDF of a trace").robot;
    assert_eq!(Header::of_robot(&again).wheels, header.wheels);
    let ground = header.ground.expect("a run knows its ground");
    assert_eq!(
        (ground.friction, ground.slope_rad),
        (0.7, 2.0_f64.to_radians())
    );
    let solid = ground.boxes[0];
    assert_eq!(solid.center_m, [1.0, 0.5]);
    assert_eq!(solid.sides_m, [0.2, 0.4, 0.01]);
    assert_eq!(solid.heading_rad, 30.0_f64.to_radians());
    let patch = &ground.patches[0];
    assert_eq!((patch.friction, patch.until_s), (0.2, Some(5.0)));
    assert_eq!((patch.center_m, patch.sides_m), ([2.0, 0.0], [1.0, 2.0]));
    assert!(ground.relief.is_none());
}

#[test]
fn a_bumpy_ground_is_drawn_again_from_the_header() {
    let rough = "[world.floor.rough]\nheight_m = 0.002\ncell_m = 0.05\nside_m = 2\nseed = 11\n";
    let text = SCENARIO
        .replace("slope_deg = 2\n", "")
        .replace("[run]", &format!("{rough}\n[run]"));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let scenario = Scenario::from_toml(&text, "rough", folder).expect("a scenario");
    let simulation = Simulation::new(&scenario).expect("it can be run");
    let ground = simulation.trace().header.ground.clone().expect("known");
    let relief = ground.relief.expect("it is bumpy");
    let heights = relief_heights_m(&relief);
    assert_eq!((heights.len(), heights[0].len()), (41, 41));
    let all = || heights.iter().flatten();
    assert!(all().all(|height| (0.0..=0.002).contains(height)));
    // 1681 even draws: the largest misses the bound by a per mille of it with a probability of
    // e^-1.7.
    assert!(all().any(|height| *height > 0.0019) && all().any(|height| *height < 0.0001));
}

/// Counts its rows, and fails after some.
#[derive(Default)]
struct Counting {
    begun: usize,
    rows: usize,
    finished: usize,
    gives_up_at: Option<usize>,
}

impl Sink for Counting {
    fn begin(&mut self, _: &Header) -> Result<(), TraceError> {
        self.begun += 1;
        Ok(())
    }

    fn take(&mut self, rows: &Trace) -> Result<(), TraceError> {
        assert_eq!((self.begun, self.finished), (1, 0));
        assert!(rows.row_count() > 0);
        self.rows += rows.row_count();
        match self.gives_up_at {
            Some(most) if self.rows >= most => Err(TraceError::sink("a counter", "it is full")),
            _ => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<(), TraceError> {
        self.finished += 1;
        Ok(())
    }
}

/// A tyre half on ice and half off it, and tyres on a floor that holds three times as much across
/// its nap: a wheel never uses more than the grip that its places have together.
#[test]
fn no_wheel_uses_more_grip_than_there_is() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    for floor in [
        "friction = 0.6, patches = [{ x_m = 0.6, y_m = 0, length_x_m = 0.5, length_y_m = 9, friction = 0.1 }]",
        "friction = 0.2, across = { friction = 0.6 }",
    ] {
        let text = format!(
            "robot.file = \"skid4.urdf\"\nworld.floor = {{ {floor} }}\ntwist = {{ vx_m_s = 0.5, omega_rad_s = 0.5, rest_s = 0 }}\nrun.duration_s = 2.0\n"
        );
        let scenario = Scenario::from_toml(&text, "held", &folder).expect("a scenario");
        let summary = Simulation::new(&scenario).expect("it stands").run().summary;
        let used = summary.friction_used_max.expect("it touches");
        // It slides, and so uses all of it, to the rounding of a sum.
        assert!((0.99..=1.0 + 1e-9).contains(&used), "{floor}: {used}");
    }
}

#[test]
fn a_thinned_record_is_of_the_same_run() {
    let all = simulation("").run();
    let last = |run: &ilon_sim::Run| *run.trace.records().last().expect("rows");
    // 50 control periods, and more of them between rows than the run has.
    for every in [2, 7, 49, 50, 4000] {
        let thin = simulation(&format!("record_every = {every}")).run();
        let (found, expected) = (&thin.summary, &all.summary);
        assert_eq!(found.duration_s, expected.duration_s, "{every}");
        assert_eq!(found.steps, expected.steps, "{every}");
        assert_eq!(found.control_dt_s, expected.control_dt_s, "{every}");
        assert_eq!(found.energy, expected.energy, "{every}");
        let (ours, theirs) = (last(&thin), last(&all));
        assert_eq!(
            (ours.t_s, ours.truth),
            (theirs.t_s, theirs.truth),
            "{every}"
        );
        let row_count = thin.scenario.run.row_count();
        assert_eq!(thin.trace.row_count() as u64, row_count, "{every}");
        assert_eq!(thin.scenario.run.last_row_s(), ours.t_s, "{every}");
    }
}

#[test]
fn every_sink_takes_every_row() {
    let simulation = simulation("roller_angles_hz = 25");
    let header = simulation.trace().header.clone();
    let mut memory = Trace::with_capacity(Header::default(), 0);
    let mut counting = Counting::default();
    let run = simulation
        .run_recorded_beside(
            Recording::temporary(header),
            &mut [&mut memory, &mut counting],
            |_, _| Ok::<(), TraceError>(()),
        )
        .expect("it can be recorded");
    assert_eq!((counting.rows, counting.finished), (51, 1));
    assert_eq!(trace_hash(&memory), run.summary.trace_hash);
    assert_eq!(&memory.header, run.trace.header());
}

#[test]
fn a_sink_that_gives_up_ends_the_run_and_says_why() {
    let simulation = simulation("");
    let header = simulation.trace().header.clone();
    let mut counting = Counting {
        gives_up_at: Some(7),
        ..Counting::default()
    };
    let ended = simulation.run_recorded_beside(
        Recording::temporary(header),
        &mut [&mut counting],
        |_, _| Ok::<(), TraceError>(()),
    );
    let fault = ended.expect_err("the sink is full").to_string();
    assert_eq!(
        fault,
        "the rows could not be handed to a counter: it is full"
    );
    assert_eq!((counting.rows, counting.finished), (7, 0));
}

/// Rates of the wheels, in rad/s.
const RATES_RAD_S: [f64; 4] = [4.0, 3.0, 2.0, 5.0];

struct Steady;

impl Controller for Steady {
    fn command(&mut self, _now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        wheels.copy_from_slice(&RATES_RAD_S);
        Commanded::Rates
    }
}

#[test]
fn a_loop_of_ones_own_is_recorded_as_a_run_is() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("{SCENARIO}roller_angles_hz = 50\n");
    let scenario = Scenario::from_toml(&text, "recorded", folder).expect("a scenario");
    let run = Simulation::with_controller(&scenario, Steady)
        .expect("it can be run")
        .run();

    let loaded = load(&scenario).expect("a robot");
    let resolved = resolve_for(&scenario, &loaded.robot, Driver::Own).expect("it is resolved");
    let mut plant = Plant::new(&resolved, &loaded.robot).expect("a plant");
    let mut recorder = Recorder::of_plant(&plant, &loaded.urdf).expect("a recorder");
    let twist = plant.kinematics().twist(&RATES_RAD_S);
    let decided = Decided {
        command_twist_in_body: twist,
        granted_twist_in_body: twist,
        wheel_rates_rad_s: &RATES_RAD_S,
        ..Decided::default()
    };
    for _ in run.trace.records() {
        let seen = plant.observe();
        recorder.reckon(&seen.wheel_angles_rad);
        recorder.record(plant.time_s(), &plant, &decided);
        let command = WheelCommand::Rates(&RATES_RAD_S);
        plant
            .advance_watched(command, resolved.control_dt_s(), |world, dt_s| {
                recorder.count(world, dt_s);
            })
            .expect("a step");
    }
    // A caller's loop has no known end.
    let endless = Header {
        control_periods: 0,
        ..run.trace.header.clone()
    };
    assert_eq!(recorder.trace().header, endless);
    // To the bit: the same steps, and the same sums.
    for (row, (own, of_run)) in recorder.trace().steps().zip(run.trace.steps()).enumerate() {
        assert_eq!(own, of_run, "row {row}");
        let angles = [recorder.trace(), &run.trace].map(|trace| trace.roller_angles_at(row));
        assert_eq!(angles[0], angles[1], "row {row}");
    }
    assert_eq!(recorder.trace().records().len(), run.trace.records().len());
}
