//! `modelDescription.xml` of FMI 3.0.

use std::fmt::Write;

use ilon_sim::Plant;

use crate::value::Value;
use crate::variable::{Causality, Variable};
use crate::{MARK, MODEL};

/// The units, with their factors and exponents of SI base units.
const UNITS: [(&str, &str); 23] = [
    ("1", ""),
    ("s", "s=\"1\""),
    ("m", "m=\"1\""),
    ("rad", "rad=\"1\""),
    ("deg", "rad=\"1\" factor=\"0.017453292519943295\""),
    ("kg", "kg=\"1\""),
    ("Hz", "s=\"-1\""),
    ("m/s", "m=\"1\" s=\"-1\""),
    ("m/s2", "m=\"1\" s=\"-2\""),
    ("rad/s", "rad=\"1\" s=\"-1\""),
    (
        "deg/s",
        "rad=\"1\" s=\"-1\" factor=\"0.017453292519943295\"",
    ),
    ("N", "kg=\"1\" m=\"1\" s=\"-2\""),
    ("N.s", "kg=\"1\" m=\"1\" s=\"-1\""),
    ("N/m", "kg=\"1\" s=\"-2\""),
    ("N.s/m", "kg=\"1\" s=\"-1\""),
    ("N.m", "kg=\"1\" m=\"2\" s=\"-2\""),
    ("N.m.s", "kg=\"1\" m=\"2\" s=\"-1\""),
    ("N.m.s2", "kg=\"1\" m=\"2\""),
    ("N.m/rad", "kg=\"1\" m=\"2\" s=\"-2\" rad=\"-1\""),
    ("N.m.s/rad", "kg=\"1\" m=\"2\" s=\"-1\" rad=\"-1\""),
    ("kg.m2", "kg=\"1\" m=\"2\""),
    ("kg/m3", "kg=\"1\" m=\"-3\""),
    ("J", "kg=\"1\" m=\"2\" s=\"-2\""),
];

/// Ties an instance to its description: another version of ilon, other variables or other start
/// values give another token.
pub fn token(variables: &[Variable]) -> String {
    // FNV-1a: short, and no attack has to be resisted here.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut take = |text: &str| {
        for byte in text.bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    take(MARK);
    for variable in variables {
        take(&format!(
            "{} {:?} {:?}\n",
            variable.name, variable.causality, variable.start
        ));
    }
    format!("{{{hash:016x}}}")
}

/// The description of an FMU of a plant with these variables.
pub fn description(name: &str, plant: &Plant, variables: &[Variable]) -> String {
    let (resolved, run) = (plant.resolved(), &plant.resolved().scenario().run);
    let mut xml = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="{token}"
    description="the robot {robot}, simulated down to its rollers" generationTool="ilon {version}" variableNamingConvention="structured">
  <CoSimulation modelIdentifier="{MODEL}" canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="{dt:?}"
      canGetAndSetFMUState="true" canSerializeFMUState="false"/>
  <UnitDefinitions>
"#,
        name = escaped(name),
        token = token(variables),
        robot = escaped(&plant.robot().name),
        version = env!("CARGO_PKG_VERSION"),
        dt = resolved.physics_dt_s(),
    );
    // Writing to a `String` cannot fail.
    for (unit, base) in UNITS {
        let _ = writeln!(xml, "    <Unit name=\"{unit}\"><BaseUnit {base}/></Unit>");
    }
    let _ = write!(
        xml,
        "  </UnitDefinitions>\n  <LogCategories>\n    <Category name=\"logStatusError\" description=\"why a call failed\"/>\n  </LogCategories>\n  <DefaultExperiment startTime=\"0\" stopTime=\"{:?}\" stepSize=\"{:?}\"/>\n  <ModelVariables>\n",
        run.duration_s, run.control_dt_s
    );
    for (reference, variable) in variables.iter().enumerate() {
        write_variable(&mut xml, reference, variable);
    }
    xml.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    for element in ["Output", "InitialUnknown"] {
        let all = variables.iter().enumerate();
        for (reference, _) in all.filter(|(_, of)| of.causality == Causality::Output) {
            let _ = writeln!(xml, "    <{element} valueReference=\"{reference}\"/>");
        }
    }
    xml.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    xml
}

fn write_variable(xml: &mut String, reference: usize, variable: &Variable) {
    let (element, start) = match variable.start {
        Value::Real(start) => ("Float64", format!("{start:?}")),
        Value::Whole(start) => ("Int64", start.to_string()),
        Value::Flag(start) => ("Boolean", start.to_string()),
    };
    let (causality, variability, start) = match variable.causality {
        Causality::Independent => ("independent", "continuous", String::new()),
        Causality::Input => ("input", "continuous", format!(" start=\"{start}\"")),
        Causality::Parameter => ("parameter", "fixed", format!(" start=\"{start}\"")),
        Causality::Output => ("output", "continuous", " initial=\"calculated\"".to_owned()),
    };
    let unit = variable.unit.map(|unit| format!(" unit=\"{unit}\""));
    let _ = writeln!(
        xml,
        "    <{element} name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" variability=\"{variability}\"{}{start} description=\"{}\"/>",
        escaped(&variable.name),
        unit.unwrap_or_default(),
        escaped(&variable.about),
    );
}

/// Escapes a text for an XML attribute. Control characters, which XML cannot hold, become spaces.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
