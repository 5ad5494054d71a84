//! A text that is ready to be read as URDF, whatever it was made from.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::model::{DriveTrain, JointSpring, Remark};

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Origin {
    /// What messages call the file.
    pub(crate) file: Arc<str>,
    pub(crate) text: Arc<str>,
    pub(crate) bytes: Range<usize>,
    /// Its line, from 1.
    pub(crate) line: usize,
}

/// The text of a URDF, and where it came from.
#[derive(Clone, Debug)]
pub(crate) struct UrdfText {
    /// What messages call the file.
    pub(crate) file: String,
    pub(crate) text: Arc<str>,
    /// Where the text's elements came from, by their first bytes, in order; empty where the text is
    /// the file's own.
    pub(crate) origins: Vec<(usize, Origin)>,
    /// What is to be said of how the text was made.
    pub(crate) remarks: Vec<Remark>,
    /// What is known of the drives beyond what URDF can say, by their joints.
    pub(crate) drives: BTreeMap<String, DriveTrain>,
    /// Springs, of which URDF knows nothing, by their joints.
    pub(crate) springs: BTreeMap<String, JointSpring>,
    /// Macros that were defined and not called.
    pub(crate) uncalled_macros: Vec<String>,
    /// Files beside it that include it.
    pub(crate) callers: Vec<String>,
    /// What is called a size in its xacro source, with its value.
    pub(crate) sizes: Vec<(String, f64)>,
    /// Values that its xacro source knows of its arguments, other than those that they have.
    pub(crate) choices: Vec<(String, Vec<String>)>,
    /// What the files of settings say that the file names for controllers, as of ros2_control: keys
    /// and values, line by line.
    pub(crate) settings: Vec<(String, String)>,
}

/// A change of a text: a range of its bytes, and what stands there instead.
pub(crate) type Edit = (Range<usize>, String);

/// Sorts changes of a text, and leaves out those that begin within another: of those that overlap,
/// the one that begins first is made.
pub(crate) fn in_order(mut edits: Vec<Edit>) -> impl Iterator<Item = Edit> {
    edits.sort_by_key(|(range, _)| (range.start, range.end));
    let mut done = 0;
    edits.into_iter().filter(move |(range, _)| {
        let is_made = range.start >= done;
        done = if is_made { range.end } else { done };
        is_made
    })
}

impl UrdfText {
    /// A file's own text.
    pub(crate) fn as_it_is(file: &str, text: &str) -> Self {
        Self {
            file: file.to_owned(),
            text: text.into(),
            origins: Vec::new(),
            remarks: Vec::new(),
            drives: BTreeMap::new(),
            springs: BTreeMap::new(),
            uncalled_macros: Vec::new(),
            callers: Vec::new(),
            sizes: Vec::new(),
            choices: Vec::new(),
            settings: Vec::new(),
        }
    }

    /// Where a byte of the text came from, where the text is not the file's own.
    pub(super) fn origin(&self, byte: usize) -> Option<&Origin> {
        let after = self.origins.partition_point(|(start, _)| *start <= byte);
        Some(&self.origins.get(after.checked_sub(1)?)?.1)
    }

    /// The same with changes made. Of those that overlap, the one that begins first is made.
    pub(crate) fn edited(&self, edits: Vec<Edit>) -> Self {
        let mut text = String::with_capacity(self.text.len());
        let mut done = 0;
        // By how much each place moves: from a byte of the old text on.
        let mut shifts: Vec<(usize, isize)> = Vec::new();
        for (range, replacement) in in_order(edits) {
            text.push_str(&self.text[done..range.start]);
            text.push_str(&replacement);
            done = range.end;
            shifts.push((range.end, text.len() as isize - range.end as isize));
        }
        text.push_str(&self.text[done..]);
        let shifted = |byte: usize| {
            let before = shifts.partition_point(|(from, _)| *from <= byte);
            let shift = before.checked_sub(1).map_or(0, |i| shifts[i].1);
            byte.saturating_add_signed(shift)
        };
        Self {
            text: text.into(),
            origins: self
                .origins
                .iter()
                .map(|(start, origin)| (shifted(*start), origin.clone()))
                .collect(),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_move_with_the_text() {
        let place = |bytes: Range<usize>| Origin {
            file: "f".into(),
            text: "t".into(),
            bytes,
            line: 1,
        };
        let mut prepared = UrdfText::as_it_is("f", "<a><b/><c/></a>");
        prepared.origins = vec![(0, place(0..1)), (3, place(1..2)), (7, place(2..3))];
        let edited = prepared.edited(vec![
            (3..7, "<bb/>".to_owned()),
            (11..11, "<d/>".to_owned()),
        ]);
        assert_eq!(&*edited.text, "<a><bb/><c/><d/></a>");
        assert_eq!(edited.origin(3).unwrap().bytes, 1..2);
        assert_eq!(edited.origin(8).unwrap().bytes, 2..3);
        // What was put in came from where it was put.
        assert_eq!(edited.origin(12).unwrap().bytes, 2..3);
        assert_eq!(edited.origin(0).unwrap().bytes, 0..1);
    }
}
