//! A fingerprint of texts.

/// The offset basis of the 128-bit FNV-1a hash.
const FNV_OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
/// The prime of the 128-bit FNV-1a hash.
const FNV_PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

/// The 128-bit FNV-1a hash of texts, each followed by a byte that no text holds.
#[derive(Clone, Debug)]
pub(super) struct Hash(u128);

impl Hash {
    pub fn new() -> Self {
        Self(FNV_OFFSET)
    }

    pub fn feed(&mut self, text: &str) {
        self.feed_bytes(text.as_bytes());
    }

    pub fn feed_bytes(&mut self, bytes: &[u8]) {
        for byte in bytes.iter().chain([&0xff]) {
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
}
