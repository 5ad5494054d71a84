//! A fingerprint of texts.

use std::io::{BufRead, BufReader, Read};

/// The offset basis of the 128-bit FNV-1a hash.
const FNV_OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
/// The prime of the 128-bit FNV-1a hash.
const FNV_PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

/// The 128-bit FNV-1a hash of texts, each followed by a byte that no text contains.
#[derive(Clone, Debug)]
pub(crate) struct Hash(u128);

impl Hash {
    /// Returns the hash of texts, as text.
    pub fn of(texts: &[&str]) -> String {
        let mut hash = Self::new();
        texts.iter().for_each(|text| hash.feed(text));
        hash.to_string()
    }

    pub fn new() -> Self {
        Self(FNV_OFFSET)
    }

    pub fn feed(&mut self, text: &str) {
        self.add(text.as_bytes());
        self.add(&[0xff]);
    }

    /// Feeds all bytes of a reader as one piece; a read error ends it.
    pub fn feed_reader(&mut self, reader: impl Read) {
        let mut reader = BufReader::with_capacity(1 << 16, reader);
        while let Ok(bytes) = reader.fill_buf()
            && !bytes.is_empty()
        {
            let count = bytes.len();
            self.add(bytes);
            reader.consume(count);
        }
        self.add(&[0xff]);
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(FNV_PRIME);
        }
    }
}

impl std::fmt::Display for Hash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_told_apart_where_they_are_divided_otherwise() {
        let of = |texts: &[&str]| {
            let mut hash = Hash::new();
            texts.iter().for_each(|text| hash.feed(text));
            hash.to_string()
        };
        assert_eq!(of(&["a", "b"]).len(), 32);
        assert_ne!(of(&["ab"]), of(&["a", "b"]));
        assert_ne!(of(&["a", ""]), of(&["a"]));
    }

    #[test]
    fn a_file_that_is_read_piece_by_piece_has_the_hash_of_its_text() {
        let text = "0123456789".repeat(20_000);
        let (mut whole, mut pieces) = (Hash::new(), Hash::new());
        whole.feed(&text);
        pieces.feed_reader(text.as_bytes());
        assert_eq!(whole.to_string(), pieces.to_string());
    }
}
