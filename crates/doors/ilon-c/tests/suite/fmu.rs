//! The functions of FMI: an FMU with this library gives the command's trace bit for bit, also in
//! FMPy, and refuses invalid calls.

use std::ffi::{CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr;

use ilon_c::fmi3::refused::*;
use ilon_c::fmi3::*;
use ilon_sim::files::FileAccess;
use ilon_sim::{Scenario, Simulation};

use crate::support::{library, root, scenario};

/// An FMU of a scenario in a folder, with its resources unpacked beside it.
fn fmu(name: &str, folder: &Path) -> PathBuf {
    let path = folder.join("robot.fmu");
    let bytes = ilon_fmi::package(&scenario(name), &[], &FileAccess::anywhere(), &library());
    std::fs::write(&path, bytes.unwrap()).unwrap();
    path
}

/// The names of the standard's functions for an FMU, without those for its callbacks.
const NAMES: &str = "fmi3GetVersion fmi3SetDebugLogging fmi3InstantiateModelExchange fmi3InstantiateCoSimulation \
    fmi3InstantiateScheduledExecution fmi3FreeInstance fmi3EnterInitializationMode fmi3ExitInitializationMode fmi3EnterEventMode \
    fmi3Terminate fmi3Reset fmi3GetFloat32 fmi3GetFloat64 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 \
    fmi3GetInt64 fmi3GetUInt64 fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock fmi3SetFloat32 fmi3SetFloat64 fmi3SetInt8 \
    fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64 fmi3SetBoolean fmi3SetString \
    fmi3SetBinary fmi3SetClock fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies fmi3GetFMUState fmi3SetFMUState \
    fmi3FreeFMUState fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState fmi3GetDirectionalDerivative \
    fmi3GetAdjointDerivative fmi3EnterConfigurationMode fmi3ExitConfigurationMode fmi3GetIntervalDecimal fmi3GetIntervalFraction \
    fmi3GetShiftDecimal fmi3GetShiftFraction fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction \
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime \
    fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates \
    fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates fmi3EnterStepMode \
    fmi3GetOutputDerivatives fmi3DoStep fmi3ActivateModelPartition";

#[test]
fn every_function_of_the_standard_is_in_the_library() {
    let bytes = std::fs::read(library()).unwrap();
    let holds = |name: &str| {
        let whole = [&[0], name.as_bytes(), &[0]].concat();
        bytes.windows(whole.len()).any(|window| window == whole)
    };
    let lacking: Vec<&str> = NAMES
        .split_whitespace()
        .filter(|name| !holds(name))
        .collect();
    assert!(lacking.is_empty(), "{lacking:?}");
}

/// Collects the messages sent to the importer.
unsafe extern "C" fn listen(
    heard: *mut c_void,
    _: Fmi3Status,
    _: *const c_char,
    words: *const c_char,
) {
    // SAFETY: the environment is the list that was passed with it, and the message is a text.
    unsafe {
        let words = std::ffi::CStr::from_ptr(words)
            .to_string_lossy()
            .into_owned();
        (*heard.cast::<Vec<String>>()).push(words);
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let resources = unpacked(&fmu("mecanum4_lateral.toml", folder.path()), folder.path());
    let mut heard: Vec<String> = Vec::new();
    let log: *mut c_void = (&raw mut heard).cast();
    let make = |token: &str, resources: &Path| {
        let (token, resources) = (
            CString::new(token).unwrap(),
            CString::new(resources.to_str().unwrap()).unwrap(),
        );
        // SAFETY: texts and list live until the instance ends.
        unsafe {
            fmi3InstantiateCoSimulation(
                c"robot".as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                false,
                false,
                false,
                ptr::null(),
                0,
                log,
                Some(listen),
                ptr::null(),
            )
        }
    };
    let token = token(folder.path());
    assert!(make("{0}", &resources).is_null());
    assert!(make(&token, folder.path()).is_null());
    let robot = make(&token, &resources);
    assert!(!robot.is_null());
    let (mut value, mut state) = (0.0, ptr::null_mut());
    // SAFETY: arrays and pointers are locals.
    unsafe {
        let step = |at_s, step_s| {
            let none = ptr::null_mut();
            fmi3DoStep(
                robot,
                at_s,
                step_s,
                false,
                none,
                none,
                none,
                ptr::null_mut(),
            )
        };
        assert_eq!(
            step(0.0, 0.01),
            Fmi3Status::Error,
            "before it is initialised"
        );
        assert_eq!(
            fmi3EnterInitializationMode(robot, false, 0.0, 0.0, false, 0.0),
            Fmi3Status::Ok
        );
        assert_eq!(fmi3ExitInitializationMode(robot), Fmi3Status::Ok);
        assert_eq!(step(0.0, f64::NAN), Fmi3Status::Error);
        assert_eq!(step(0.0, -0.01), Fmi3Status::Error);
        let get = |reference: &u32, values: *mut f64, count| {
            fmi3GetFloat64(robot, reference, 1, values, count)
        };
        assert_eq!(get(&9999, &raw mut value, 1), Fmi3Status::Error);
        assert_eq!(get(&0, &raw mut value, 2), Fmi3Status::Error);
        assert_eq!(get(&0, ptr::null_mut(), 1), Fmi3Status::Error);
        let mut whole = 0_i64;
        assert_eq!(
            fmi3GetInt64(robot, &0, 1, &raw mut whole, 1),
            Fmi3Status::Error,
            "of another type"
        );
        assert_eq!(
            fmi3GetFloat32(robot, ptr::null(), 0, ptr::null_mut(), 0),
            Fmi3Status::Ok,
            "none"
        );
        assert_eq!(
            fmi3GetNumberOfContinuousStates(robot, ptr::null_mut()),
            Fmi3Status::Error
        );
        assert_eq!(fmi3GetFMUState(robot, &raw mut state), Fmi3Status::Ok);
        let mut freed = state;
        assert_eq!(fmi3FreeFMUState(robot, &raw mut freed), Fmi3Status::Ok);
        assert!(freed.is_null());
    }
    assert_eq!(
        fmi3SetFMUState(robot, state),
        Fmi3Status::Error,
        "it was freed"
    );
    assert_eq!(
        fmi3SetFMUState(robot, robot),
        Fmi3Status::Error,
        "it is an instance"
    );
    fmi3FreeInstance(robot);
    fmi3FreeInstance(robot);
    assert_eq!(fmi3Reset(robot), Fmi3Status::Error);
    assert_eq!(fmi3Terminate(ptr::null_mut()), Fmi3Status::Error);
    assert!(
        heard.len() >= 12 && heard.iter().all(|words| !words.is_empty()),
        "{heard:?}"
    );
}

fn unpacked(fmu: &Path, folder: &Path) -> PathBuf {
    let there = folder.join("unpacked");
    zip::ZipArchive::new(std::fs::File::open(fmu).unwrap())
        .unwrap()
        .extract(&there)
        .unwrap();
    there.join("resources")
}

fn token(folder: &Path) -> String {
    let xml = std::fs::read_to_string(folder.join("unpacked/modelDescription.xml")).unwrap();
    let rest = xml.split("instantiationToken=\"").nth(1).unwrap();
    rest.split('"').next().unwrap().to_owned()
}

/// A Python with FMPy: that of `ILON_PYTHON`, or `python3`.
fn python() -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python).args(["-c", "import fmpy"]).output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, lacks what tests/requirements.txt lists"
    );
    println!("skipped: {python} lacks what tests/requirements.txt lists");
    None
}

#[test]
fn fmpy_takes_it_and_gets_the_commands_trace_to_the_bit() {
    let Some(python) = python() else { return };
    const PERIODS: usize = 120;
    let folder = tempfile::tempdir().unwrap();
    let name = "mecanum4_lateral.toml";
    let fmu = fmu(name, folder.path());
    let run = Simulation::new(&Scenario::load(scenario(name)).unwrap())
        .unwrap()
        .run();
    let mut commands = String::new();
    for (_, wheels) in run.trace.steps().take(PERIODS) {
        let rates = wheels
            .iter()
            .map(|wheel| format!("{:?}", wheel.target_rad_s));
        commands += &(rates.collect::<Vec<_>>().join(" ") + "\n");
    }
    let file = folder.path().join("commands.txt");
    std::fs::write(&file, commands).unwrap();
    let judged = Command::new(python)
        .arg(root().join("crates/doors/ilon-c/tests/fmu_witness.py"))
        .args([&fmu, &file])
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&judged.stderr);
    assert!(judged.status.success(), "{words}");
    let said = String::from_utf8(judged.stdout).unwrap();
    let json: serde_json::Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    assert_eq!(json["problems"], serde_json::json!([]));
    let rows = json["rows"].as_array().unwrap();
    let wanted = run.trace.steps().skip(1).take(PERIODS).map(|(record, _)| {
        let (pose, twist) = (record.truth.pose, record.truth.twist_in_body);
        [
            pose.x_m,
            pose.y_m,
            pose.heading_rad,
            twist.vx_m_s,
            twist.vy_m_s,
            twist.omega_rad_s,
        ]
    });
    assert_eq!(rows.len(), PERIODS);
    for (row, wanted) in rows.iter().zip(wanted) {
        let row: Vec<f64> = row
            .as_array()
            .unwrap()
            .iter()
            .map(|x| hexadecimal(x.as_str().unwrap()))
            .collect();
        assert_eq!(row, wanted);
    }
    let from = json["from"].as_u64().unwrap() as usize;
    assert_eq!(json["again"].as_array().unwrap()[..], rows[from..]);
    // The robot drags the mass along, which lags by the stretch of its spring.
    let number = |of: &serde_json::Value| of.as_f64().unwrap();
    let coupled = &json["coupled"];
    assert!(
        number(&coupled["robot_y"]) > 0.05 && number(&coupled["mass_y"]) > 0.0,
        "{coupled}"
    );
    assert!(number(&coupled["most_force"]) > 0.1, "{coupled}");
    assert_eq!(json["simulated"]["floor.friction"], 0.3);
    assert!(
        number(&json["simulated"]["wheel[1].rate"]) > 1.0,
        "{}",
        json["simulated"]
    );
}

/// A float as Python's `hex` writes it: sign, leading digit, 13 digits, exponent.
fn hexadecimal(text: &str) -> f64 {
    let (negative, rest) = text
        .strip_prefix('-')
        .map_or((false, text), |rest| (true, rest));
    let (mantissa, exponent) = rest.strip_prefix("0x").unwrap().split_once('p').unwrap();
    let (lead, digits) = mantissa.split_once('.').unwrap_or((mantissa, "0"));
    let fraction =
        u64::from_str_radix(digits, 16).unwrap() as f64 / 16_f64.powi(digits.len() as i32);
    let value = (u64::from_str_radix(lead, 16).unwrap() as f64 + fraction)
        * 2_f64.powi(exponent.parse().unwrap());
    if negative { -value } else { value }
}
