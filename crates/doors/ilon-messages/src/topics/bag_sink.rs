//! Writes a run into a bag while it is simulated.

use std::path::{Path, PathBuf};

use ilon_robot::{Robot, RobotDescription};
use ilon_trace::{Header, Sink, Trace, TraceError};

use super::run::RunTopics;
use crate::bag::{BagError, BagWriter};

/// Writes the rows of a run into a bag one by one. If the run is stopped in any way, the bag lacks
/// at most its last second.
#[derive(Debug)]
pub struct BagSink {
    robot: Robot,
    described: RobotDescription,
    folder: PathBuf,
    bag: Option<BagWriter>,
    topics: Option<RunTopics>,
    last_s: f64,
}

impl BagSink {
    /// Starts a bag in a folder, for a run of this robot with this description. An existing bag is
    /// replaced.
    ///
    /// # Errors
    /// Those of [`BagWriter::create`].
    pub fn create(
        folder: &Path,
        robot: &Robot,
        described: RobotDescription,
    ) -> Result<Self, BagError> {
        Ok(Self {
            robot: robot.clone(),
            described,
            folder: folder.to_owned(),
            bag: Some(BagWriter::create(folder)?),
            topics: None,
            last_s: 0.0,
        })
    }

    fn fault(&self) -> impl Fn(BagError) -> TraceError + use<> {
        let bag = format!("the bag {}", self.folder.display());
        move |error| match error {
            BagError::Io { path, source } => TraceError::Io {
                doing: "write",
                path,
                source,
            },
            other => TraceError::sink(bag.clone(), other),
        }
    }
}

impl Sink for BagSink {
    fn begin(&mut self, header: &Header) -> Result<(), TraceError> {
        let fault = self.fault();
        let topics = RunTopics::new(&self.robot, std::mem::take(&mut self.described), header);
        if let Some(bag) = &mut self.bag {
            topics.declare(bag).map_err(&fault)?;
            topics.latched(bag, 0.0).map_err(&fault)?;
        }
        self.topics = Some(topics);
        Ok(())
    }

    fn take(&mut self, rows: &Trace) -> Result<(), TraceError> {
        let fault = self.fault();
        let (Some(bag), Some(topics)) = (&mut self.bag, &mut self.topics) else {
            return Ok(());
        };
        for (row, (record, wheels)) in rows.steps().enumerate() {
            let rollers = rows.roller_angles_at(row);
            topics.row(record, wheels, rollers, bag).map_err(&fault)?;
            self.last_s = record.t_s;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), TraceError> {
        let fault = self.fault();
        let (Some(mut bag), Some(topics)) = (self.bag.take(), &mut self.topics) else {
            return Ok(());
        };
        topics.end(self.last_s, &mut bag).map_err(&fault)?;
        bag.finish().map_err(fault)
    }
}
