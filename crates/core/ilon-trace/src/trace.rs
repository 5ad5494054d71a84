//! The whole run: its header and the records of its control steps.

use crate::header::Header;
use crate::record::{Record, WheelSample};

/// A recorded run.
///
/// The samples of the wheels are in one flat list, step by step, so that recording does not
/// allocate once memory is reserved.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The description of the run.
    pub header: Header,
    records: Vec<Record>,
    wheels: Vec<WheelSample>,
    /// Angles of all rollers, wheel by wheel, row by row; empty if they are not recorded.
    rollers: Vec<Option<f64>>,
}

impl Trace {
    /// An empty trace with memory for `steps` records, or for the first part of a long run.
    pub fn with_capacity(header: Header, steps: usize) -> Self {
        const MOST_AT_ONCE: usize = 100_000;
        let steps = steps.min(MOST_AT_ONCE);
        let wheel_count = header.wheels.len();
        let roller_count = header.rollers_recorded();
        Self {
            header,
            records: Vec::with_capacity(steps),
            wheels: Vec::with_capacity(steps * wheel_count),
            rollers: Vec::with_capacity(steps * roller_count),
        }
    }

    /// Adds the record of one control step. `wheels` are its samples in the order of the header's
    /// wheels; missing ones are recorded as zero, and surplus ones dropped.
    pub fn push(&mut self, record: Record, wheels: &[WheelSample]) {
        let wheel_count = self.header.wheels.len();
        self.records.push(record);
        self.wheels.extend(wheels.iter().take(wheel_count));
        self.wheels
            .resize(self.records.len() * wheel_count, WheelSample::default());
        let roller_count = self.header.rollers_recorded();
        self.rollers.resize(self.records.len() * roller_count, None);
    }

    /// Writes the angles of all rollers, in radians, wheel by wheel, into the last row. Surplus
    /// ones are dropped, and all of them if the header records none.
    pub fn push_roller_angles(&mut self, angles_rad: impl IntoIterator<Item = f64>) {
        self.put_roller_angles(angles_rad.into_iter().map(Some));
    }

    /// The angles of all rollers at a row, in radians, wheel by wheel: `None` if not sampled. Empty
    /// beyond the end, and if the run records none.
    pub fn roller_angles_at(&self, row: usize) -> &[Option<f64>] {
        let n = self.header.rollers_recorded();
        self.rollers.get(row * n..(row + 1) * n).unwrap_or(&[])
    }

    /// A trace of some of the rows; rows beyond the end are ignored.
    pub fn rows(&self, rows: std::ops::Range<usize>) -> Self {
        let end = rows.end.min(self.records.len());
        let start = rows.start.min(end);
        let wheel_count = self.wheel_count();
        let roller_count = self.header.rollers_recorded();
        Self {
            header: self.header.clone(),
            records: self.records[start..end].to_vec(),
            wheels: self.wheels[start * wheel_count..end * wheel_count].to_vec(),
            rollers: self.rollers[start * roller_count..end * roller_count].to_vec(),
        }
    }

    /// Adds the rows of another trace of the same run, and the figures that its header has.
    pub fn append(&mut self, other: &Self) {
        if other.header.figures.is_some() {
            self.header.figures.clone_from(&other.header.figures);
        }
        for (row, (record, wheels)) in other.steps().enumerate() {
            self.push(*record, wheels);
            self.put_roller_angles(other.roller_angles_at(row).iter().copied());
        }
    }

    /// Writes roller angles, which may be absent, into the last row.
    pub(crate) fn put_roller_angles(&mut self, angles_rad: impl IntoIterator<Item = Option<f64>>) {
        let own = self
            .rollers
            .len()
            .saturating_sub(self.header.rollers_recorded());
        for (slot, angle_rad) in self.rollers[own..].iter_mut().zip(angles_rad) {
            *slot = angle_rad;
        }
    }

    /// The records, one per control step.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The samples of all wheels at one step, in the header's order; empty beyond the end.
    pub fn wheels_at(&self, step: usize) -> &[WheelSample] {
        if step >= self.records.len() {
            return &[];
        }
        let n = self.header.wheels.len();
        self.wheels.get(step * n..(step + 1) * n).unwrap_or(&[])
    }

    /// The samples of one wheel over the run; empty for an unknown wheel.
    pub fn wheel(&self, index: usize) -> impl ExactSizeIterator<Item = &WheelSample> {
        let n = self.header.wheels.len();
        let own = self.wheels.get(index..).filter(|_| index < n);
        own.unwrap_or(&[]).iter().step_by(n.max(1))
    }

    /// Records with the samples of their wheels.
    pub fn steps(&self) -> impl ExactSizeIterator<Item = (&Record, &[WheelSample])> {
        self.records
            .iter()
            .enumerate()
            .map(|(step, record)| (record, self.wheels_at(step)))
    }

    /// The number of wheels per record.
    pub fn wheel_count(&self) -> usize {
        self.header.wheels.len()
    }

    /// The time of the last row, in seconds; 0 without rows.
    pub fn duration_s(&self) -> f64 {
        let last = self.records.last();
        last.map_or(0.0, |last| self.header.row_end_s(last.t_s))
    }

    /// Removes all rows, and keeps their memory.
    pub fn clear(&mut self) {
        self.records.clear();
        self.wheels.clear();
        self.rollers.clear();
    }

    /// Removes the first `rows` rows, or all if there are fewer.
    pub(crate) fn forget(&mut self, rows: usize) {
        let rows = rows.min(self.records.len());
        self.records.drain(..rows);
        self.wheels.drain(..rows * self.header.wheels.len());
        self.rollers.drain(..rows * self.header.rollers_recorded());
    }

    /// Replaces all rows by zero rows, to be filled column by column.
    pub(crate) fn begin_columns(&mut self, rows: usize) {
        self.clear();
        self.records.resize(rows, Record::default());
        self.wheels
            .resize(rows * self.wheel_count(), WheelSample::default());
        self.rollers
            .resize(rows * self.header.rollers_recorded(), None);
    }

    /// A row to be filled.
    pub(crate) fn row_mut(&mut self, row: usize) -> RowMut<'_> {
        let (n, m) = (self.header.wheels.len(), self.header.rollers_recorded());
        RowMut {
            record: &mut self.records[row],
            wheels: &mut self.wheels[row * n..(row + 1) * n],
            rollers: &mut self.rollers[row * m..(row + 1) * m],
        }
    }
}

/// A row to be filled.
pub(crate) struct RowMut<'t> {
    pub record: &'t mut Record,
    pub wheels: &'t mut [WheelSample],
    pub rollers: &'t mut [Option<f64>],
}

#[cfg(test)]
mod tests;
