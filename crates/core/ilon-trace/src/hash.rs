//! A fingerprint of all recorded signals.

use crate::rows::Rows;
use crate::trace::Trace;

/// The offset basis of the 128-bit FNV-1a hash.
const FNV_OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
/// The prime of the 128-bit FNV-1a hash.
const FNV_PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

/// The fingerprint of a trace: 32 hexadecimal digits, equal exactly if every recorded signal is
/// equal bit for bit.
///
/// It is the 128-bit FNV-1a hash over, for each signal in the order of the file's columns: its name
/// in UTF-8, a zero byte, and for each step one byte 1 with the eight bytes of the value as f64,
/// little-endian, or one byte 0 if the signal is absent. All NaN count as equal. Of the header only
/// what appears in column names is included, so that neither the duration of the computation nor
/// the program version matters.
pub fn trace_hash(trace: &Trace) -> String {
    let Ok(hash) = hash_of_rows(trace);
    hash
}

/// The fingerprint of a trace whose rows need not be in memory, see [`trace_hash`].
///
/// # Errors
/// If the rows cannot be read.
pub fn hash_of_rows<R: Rows>(rows: &R) -> Result<String, R::Error> {
    let mut hash = FNV_OFFSET;
    let mut feed = |bytes: &[u8]| {
        for &byte in bytes {
            hash = (hash ^ u128::from(byte)).wrapping_mul(FNV_PRIME);
        }
    };
    for name in rows.header().signal_names() {
        feed(name.as_bytes());
        feed(&[0]);
        rows.each_value(&name, &mut |value| match value {
            None => feed(&[0]),
            Some(value) => {
                let value = if value.is_nan() { f64::NAN } else { value };
                feed(&[1]);
                feed(&value.to_bits().to_le_bytes());
            }
        })?;
    }
    Ok(format!("{hash:032x}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::signals;
    use crate::header::Header;
    use crate::record::{Desired, Record};
    use crate::sample::made_up_trace;
    use crate::trace::RowMut;

    #[test]
    fn the_hash_is_fnv_1a_as_published() {
        // An independent computation over a trace of no steps: only names and zero bytes.
        let trace = Trace::with_capacity(Header::default(), 0);
        let bytes: Vec<u8> = signals(&trace.header)
            .iter()
            .flat_map(|s| s.name.bytes().chain([0]))
            .collect();
        // 2^88 + 0x13b and the basis, from the definition of FNV.
        let prime = (1u128 << 88) + 0x13b;
        let hash = bytes.iter().fold(
            144_066_263_297_769_815_596_495_629_667_062_367_629u128,
            |h, b| (h ^ u128::from(*b)).wrapping_mul(prime),
        );
        assert_eq!(trace_hash(&trace), format!("{hash:032x}"));
    }

    #[test]
    fn one_changed_bit_of_any_signal_changes_the_hash() {
        let trace = made_up_trace(3, 4, true);
        let before = trace_hash(&trace);
        assert_eq!(before, trace_hash(&trace.clone()));
        for signal in signals(&trace.header) {
            let mut changed = Trace::with_capacity(trace.header.clone(), 4);
            for (step, (record, wheels)) in trace.steps().enumerate() {
                let (mut record, mut wheels) = (*record, wheels.to_vec());
                let mut rollers = trace.roller_angles_at(step).to_vec();
                if step == 2 {
                    let value = signal.get(&trace, step).map(|v| match signal.kind {
                        crate::columns::ColumnType::Real => f64::from_bits(v.to_bits() ^ 1),
                        crate::columns::ColumnType::Count => v + 1.0,
                        crate::columns::ColumnType::Flag => 1.0 - v,
                    });
                    let mut row = RowMut {
                        record: &mut record,
                        wheels: &mut wheels,
                        rollers: &mut rollers,
                    };
                    signal.set(&mut row, value);
                }
                changed.push(record, &wheels);
                changed.put_roller_angles(rollers);
            }
            assert_ne!(before, trace_hash(&changed), "{}", signal.name);
        }
    }

    #[test]
    fn an_absent_desired_pose_differs_from_one_at_the_origin() {
        let with = |desired| {
            let mut trace = Trace::with_capacity(Header::default(), 1);
            trace.push(
                Record {
                    desired,
                    ..Record::default()
                },
                &[],
            );
            trace_hash(&trace)
        };
        assert_ne!(with(None), with(Some(Desired::default())));
    }
}
