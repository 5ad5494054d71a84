//! A checksum over the bytes of a trace file. It reveals damage before anything is read: Parquet's
//! writer puts no checksum into its pages, and its reader assumes that they are intact.
//!
//! It comes right after the four bytes with which every Parquet file begins. No Parquet reader
//! looks there, because the content of a file is found from its end. In the sum these bytes count
//! as zeros.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// The first and last bytes of every Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";
/// Offset of the checksum, in bytes from the start of the file.
const AT: usize = MAGIC.len();
/// The text before its digits.
const LABEL: &[u8; 16] = b"ilon checksum 1:";
/// Number of its hexadecimal digits.
const DIGITS: usize = 32;

/// The placeholder while the file is written.
pub(super) fn empty() -> Vec<u8> {
    let mut place = LABEL.to_vec();
    place.resize(LABEL.len() + DIGITS, b'0');
    place
}

/// A file whose bytes are summed as they are written, in order.
#[derive(Debug)]
pub(super) struct Summed<W> {
    file: W,
    sum: Sum,
}

impl<W: Write + Seek> Summed<W> {
    pub fn new(file: W) -> Self {
        let sum = Sum::new();
        Self { file, sum }
    }

    /// Writes the checksum into its place after everything else is written.
    pub fn finish(mut self) -> io::Result<W> {
        let place = AT + LABEL.len();
        self.file.seek(SeekFrom::Start(place as u64))?;
        write!(self.file, "{}", self.sum.digits())?;
        Ok(self.file)
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.add(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The result of checking a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Integrity {
    /// The bytes are as written.
    Whole,
    /// The bytes have changed.
    Damaged,
    /// The file has no checksum, but begins and ends like Parquet.
    Parquet,
    /// It is another kind of file.
    Other,
}

/// Whether a file begins like a trace.
pub(super) fn is_labelled(file: &mut File) -> io::Result<bool> {
    let mut head = Vec::new();
    file.take((AT + LABEL.len()) as u64)
        .read_to_end(&mut head)?;
    Ok(head.get(AT..) == Some(LABEL.as_slice()))
}

/// Reads a whole file and compares it with its checksum.
pub(super) fn check(file: &mut File) -> io::Result<Integrity> {
    file.seek(SeekFrom::Start(0))?;
    let mut head = Vec::new();
    let head_length = AT + LABEL.len() + DIGITS;
    file.take(head_length as u64).read_to_end(&mut head)?;
    if head.len() < head_length || head[AT..AT + LABEL.len()] != LABEL[..] {
        let mut end = [0; MAGIC.len()];
        file.seek(SeekFrom::End(0))?;
        let length = file.stream_position()?;
        file.seek(SeekFrom::Start(length.saturating_sub(end.len() as u64)))?;
        let is_parquet =
            head.starts_with(MAGIC) && file.read_exact(&mut end).is_ok() && end == *MAGIC;
        return Ok(if is_parquet {
            Integrity::Parquet
        } else {
            Integrity::Other
        });
    }
    let digits = head.split_off(AT + LABEL.len());
    let mut sum = Sum::new();
    sum.add(&head);
    sum.add(&[b'0'; DIGITS]);
    let mut bytes = vec![0; 1 << 16];
    loop {
        match file.read(&mut bytes) {
            Ok(0) => break,
            Ok(count) => sum.add(&bytes[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(if sum.digits().as_bytes() == digits {
        Integrity::Whole
    } else {
        Integrity::Damaged
    })
}

/// FNV-1a of 128 bits, over 64-bit words, the last one padded with zeros, and over the number of
/// bytes.
///
/// Each step is a bijection of the sum and of the word, so that a single changed word is always
/// detected; several changed words escape with a probability of 2^-128.
#[derive(Clone, Debug)]
struct Sum {
    sum: u128,
    length: u64,
    /// Bytes that do not fill a word yet.
    rest: Vec<u8>,
}

/// The offset basis of the 128-bit FNV-1a hash.
const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
/// The prime of the 128-bit FNV-1a hash.
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

impl Sum {
    fn new() -> Self {
        Self {
            sum: OFFSET,
            length: 0,
            rest: Vec::with_capacity(8),
        }
    }

    fn add(&mut self, mut bytes: &[u8]) {
        self.length += bytes.len() as u64;
        if !self.rest.is_empty() {
            let missing = (8 - self.rest.len()).min(bytes.len());
            self.rest.extend(&bytes[..missing]);
            bytes = &bytes[missing..];
            if self.rest.len() < 8 {
                return;
            }
            self.sum = with_word(self.sum, &self.rest);
            self.rest.clear();
        }
        let mut words = bytes.chunks_exact(8);
        for word in &mut words {
            self.sum = with_word(self.sum, word);
        }
        self.rest.extend(words.remainder());
    }

    fn digits(&self) -> String {
        let sum = with_word(self.sum, &self.rest);
        let sum = with_word(sum, &self.length.to_le_bytes());
        format!("{sum:032x}")
    }
}

/// The sum extended by one word of at most 8 bytes.
fn with_word(sum: u128, bytes: &[u8]) -> u128 {
    let mut word = [0; 8];
    word[..bytes.len()].copy_from_slice(bytes);
    (sum ^ u128::from(u64::from_le_bytes(word))).wrapping_mul(PRIME)
}

/// Writes a fitting checksum into bytes, as an attacker could.
#[cfg(test)]
pub(super) fn seal(bytes: &mut [u8]) {
    let place = AT + LABEL.len()..AT + LABEL.len() + DIGITS;
    bytes[AT..AT + LABEL.len()].copy_from_slice(LABEL);
    bytes[place.clone()].fill(b'0');
    let mut sum = Sum::new();
    sum.add(bytes);
    bytes[place].copy_from_slice(sum.digits().as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_does_not_depend_on_how_the_bytes_come_and_does_on_each_of_them() {
        let bytes: Vec<u8> = (0..100u8).collect();
        let of = |pieces: &[&[u8]]| {
            let mut sum = Sum::new();
            pieces.iter().for_each(|piece| sum.add(piece));
            sum.digits()
        };
        let whole = of(&[&bytes]);
        for cut in 0..bytes.len() {
            assert_eq!(whole, of(&[&bytes[..cut], &[], &bytes[cut..]]));
            assert_ne!(whole, of(&[&bytes[..cut]]));
            let mut changed = bytes.clone();
            changed[cut] ^= 1;
            assert_ne!(whole, of(&[&changed]));
        }
        let ones: Vec<&[u8]> = bytes.chunks(1).collect();
        assert_eq!(whole, of(&ones));
        assert_ne!(of(&[&bytes, &[0]]), whole);
    }

    #[test]
    fn a_file_that_was_finished_is_whole_and_damaged_after_any_change() {
        let mut file = Summed::new(tempfile::tempfile().unwrap());
        file.write_all(b"PAR1").unwrap();
        file.write_all(&empty()).unwrap();
        file.write_all(b"what it holds").unwrap();
        let mut file = file.finish().unwrap();
        assert_eq!(check(&mut file).unwrap(), Integrity::Whole);
        let length = file.metadata().unwrap().len();
        for at in 0..length {
            let mut flip = || {
                let mut byte = [0];
                file.seek(SeekFrom::Start(at)).unwrap();
                file.read_exact(&mut byte).unwrap();
                file.seek(SeekFrom::Start(at)).unwrap();
                file.write_all(&[byte[0] ^ 4]).unwrap();
                check(&mut file).unwrap()
            };
            assert_ne!(flip(), Integrity::Whole, "{at}");
            assert_eq!(flip(), Integrity::Whole, "{at}");
        }
        file.set_len(length - 1).unwrap();
        assert_eq!(check(&mut file).unwrap(), Integrity::Damaged);
        file.set_len(10).unwrap();
        assert_eq!(check(&mut file).unwrap(), Integrity::Other);
    }
}
