//! A text that is put together of several files, which knows where each of its bytes came from.

use std::ops::Range;
use std::sync::Arc;

use crate::error::{Fault, RobotError};
use crate::urdf::{Edit, Origin, in_order};

/// A text of pieces of files.
#[derive(Clone, Debug, Default)]
pub(super) struct Assembled {
    pub(super) text: String,
    pieces: Vec<Piece>,
}

#[derive(Debug)]
struct File {
    name: Arc<str>,
    text: Arc<str>,
    line_breaks: Vec<usize>,
}

/// Bytes from a place of the text on, up to the next piece.
#[derive(Clone, Debug)]
struct Piece {
    at: usize,
    file: Arc<File>,
    /// Where they stand in the file's text.
    from: usize,
    /// Whether they stand there as they are, and not in the place of what does.
    is_copy: bool,
}

impl Assembled {
    /// A file's own text.
    pub(super) fn of_file(file: &str, text: &str) -> Self {
        let piece = Piece {
            at: 0,
            file: Arc::new(File {
                name: file.into(),
                text: text.into(),
                line_breaks: text.match_indices('\n').map(|(at, _)| at).collect(),
            }),
            from: 0,
            is_copy: true,
        };
        Self {
            text: text.to_owned(),
            pieces: vec![piece],
        }
    }

    /// The piece that holds a byte, and how far into it that is.
    fn piece(&self, byte: usize) -> Option<(&Piece, usize)> {
        let after = self.pieces.partition_point(|piece| piece.at <= byte);
        let piece = self.pieces.get(after.checked_sub(1)?)?;
        Some((piece, if piece.is_copy { byte - piece.at } else { 0 }))
    }

    /// Adds a part of another text.
    pub(super) fn append(&mut self, other: &Self, part: Range<usize>) {
        if part.is_empty() {
            return;
        }
        let start = self.text.len();
        if let Some((piece, into)) = other.piece(part.start) {
            self.pieces.push(Piece {
                at: start,
                from: piece.from + into,
                ..piece.clone()
            });
        }
        let first = other.pieces.partition_point(|piece| piece.at <= part.start);
        let inside = other.pieces[first..].iter();
        let inside = inside.take_while(|piece| piece.at < part.end);
        self.pieces.extend(inside.map(|piece| Piece {
            at: start + piece.at - part.start,
            ..piece.clone()
        }));
        self.text.push_str(&other.text[part]);
    }

    /// Adds what was made of something that stands in another text.
    pub(super) fn made(&mut self, text: &str, other: &Self, byte: usize) {
        if let Some((piece, into)) = other.piece(byte).filter(|_| !text.is_empty()) {
            self.pieces.push(Piece {
                at: self.text.len(),
                from: piece.from + into,
                is_copy: false,
                ..piece.clone()
            });
        }
        self.text.push_str(text);
    }

    /// Adds a part of another text with changes within it made.
    pub(super) fn append_edited(&mut self, other: &Self, part: Range<usize>, edits: Vec<Edit>) {
        let mut done = part.start;
        for (range, written) in in_order(edits) {
            self.append(other, done..range.start);
            self.made(&written, other, range.start);
            done = range.end;
        }
        self.append(other, done..part.end);
    }

    /// Where bytes came from: they end with their piece.
    pub(super) fn origin(&self, bytes: Range<usize>) -> Option<Origin> {
        let (piece, into) = self.piece(bytes.start)?;
        let file = &piece.file;
        let start = (piece.from + into).min(file.text.len());
        let length = if piece.is_copy { bytes.len() } else { 1 };
        let end = (start + length).min(file.text.len());
        Some(Origin {
            line: 1 + file.line_breaks.partition_point(|at| *at < start),
            bytes: start..end,
            file: Arc::clone(&file.name),
            text: Arc::clone(&file.text),
        })
    }

    /// A fault of some bytes, where they stand in their file.
    pub(super) fn error(&self, file: &str, bytes: Range<usize>, reason: String) -> RobotError {
        let fault = Fault::Format { reason };
        match self.origin(bytes) {
            Some(origin) => RobotError::new(&origin.file, fault).at(&origin.text, origin.bytes),
            None => RobotError::new(file, fault),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_found_in_the_files_that_they_came_from() {
        let outer = Assembled::of_file("outer", "a\n<i/>\nb");
        let inner = Assembled::of_file("inner", "x\ny\nz");
        let mut whole = Assembled::default();
        whole.append(&outer, 0..2);
        whole.append(&inner, 2..5);
        whole.made("made", &outer, 2);
        whole.append(&outer, 6..8);
        assert_eq!(whole.text, "a\ny\nzmade\nb");
        let at = |byte: usize| {
            let origin = whole.origin(byte..byte + 1).expect("a piece");
            (origin.file.to_string(), origin.line)
        };
        assert_eq!(at(0), ("outer".to_owned(), 1));
        assert_eq!(at(2), ("inner".to_owned(), 2));
        assert_eq!(at(4), ("inner".to_owned(), 3));
        // What was made stands where that stood of which it was made.
        assert_eq!(at(7), ("outer".to_owned(), 2));
        assert_eq!(at(10), ("outer".to_owned(), 3));
    }
}
