//! Values of keys that a file leaves out, for `#[serde(default = "...")]`.

/// `true`.
pub fn yes() -> bool {
    true
}

/// The number `N`.
pub fn number<const N: u16, T: From<u16>>() -> T {
    N.into()
}

/// `N` thousandths.
pub fn thousandths<const N: u16>() -> f64 {
    f64::from(N) / 1e3
}
