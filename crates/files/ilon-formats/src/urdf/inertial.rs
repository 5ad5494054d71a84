//! Checks of `<inertial>`: a mass, and an inertia possible for it.

use nalgebra::Matrix3;
use roxmltree::Node;

use super::faults::Faults;
use super::numbers::{check_numbers, number, remark_repeated};
use super::source::{Source, child, describe};
use crate::error::Fault;
use crate::model::Remark;
use crate::model::mass::principal_moments;

/// Checks the inertial of a link.
pub(super) fn check_inertial(
    source: &Source,
    inertial: Node,
    remarks: &mut Vec<Remark>,
    faults: &mut Faults,
) {
    remark_repeated(source, inertial, remarks);
    if let Some(origin) = child(inertial, "origin") {
        check_numbers(source, origin, faults);
    }
    let missing = |tag| source.error(inertial, Fault::MissingElement { child: tag });
    let Some(mass) = child(inertial, "mass") else {
        faults.push(missing("mass"));
        return;
    };
    let mass_is_good = check_numbers(source, mass, faults);
    let massless = mass_is_good && number(mass, "value") == 0.0;
    let Some(inertia) = child(inertial, "inertia") else {
        // A massless placeholder; the remark on it comes when bodies are merged.
        if !massless {
            faults.push(missing("inertia"));
        }
        return;
    };
    if !check_numbers(source, inertia, faults) {
        return;
    }
    let tensor = tensor(inertia);
    if massless {
        if tensor != Matrix3::zeros() {
            let fault = Fault::OutOfRange {
                key: "value".to_owned(),
                value: "0".to_owned(),
                range: "above 0",
            };
            faults.push(source.attribute_error(mass, "value", fault));
        }
        return;
    }
    let products = ["ixy", "ixz", "iyz"];
    let left_out: Vec<&str> = products
        .into_iter()
        .filter(|product| inertia.attribute(*product).is_none())
        .collect();
    if !left_out.is_empty() {
        let words = format!("{} left out: taken as 0", left_out.join(", "));
        let mut remark = Remark::new(describe(inertia), words);
        source.place_at(&mut remark, inertia);
        remarks.push(remark);
    }
    if mass_is_good && let Some(fault) = impossible(tensor) {
        faults.push(source.error(inertia, fault));
    }
}

/// Returns the tensor of an `<inertia>`.
fn tensor(inertia: Node) -> Matrix3<f64> {
    let i = |attribute| number(inertia, attribute);
    Matrix3::new(
        i("ixx"),
        i("ixy"),
        i("ixz"),
        i("ixy"),
        i("iyy"),
        i("iyz"),
        i("ixz"),
        i("iyz"),
        i("izz"),
    )
}

/// Returns why no body with mass has such an inertia, if that is so.
fn impossible(tensor: Matrix3<f64>) -> Option<Fault> {
    let [least, middle, most] = principal_moments(tensor);
    if least <= 0.0 {
        return Some(Fault::InertiaNotPositive { least });
    }
    // A tolerance of a thousandth accepts numbers rounded to three digits.
    (least + middle < most * (1.0 - 1e-3)).then_some(Fault::InertiaImpossible {
        least,
        middle,
        most,
    })
}
