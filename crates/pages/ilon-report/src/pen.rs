//! Line styles of curves.
//!
//! Colours are from the palette of Okabe and Ito for the colour-blind. Curves that share a panel
//! also differ in their dashes.

/// Line style of a curve.
#[derive(Clone, Copy, Debug)]
pub struct Pen {
    /// The colour's name, such as `@real`.
    pub color: &'static str,
    /// Solid, dashed, ...
    pub dash: DashKind,
    /// Width in CSS pixels.
    pub width_px: f64,
}

/// The dashes in use.
#[derive(Clone, Copy, Debug)]
pub enum DashKind {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dash,
    /// Dots.
    Dot,
    /// Dashes and dots.
    DashDot,
}

const fn pen(color: &'static str, dash: DashKind, width_px: f64) -> Pen {
    Pen {
        color,
        dash,
        width_px,
    }
}

/// A solid line.
pub const fn solid(color: &'static str) -> Pen {
    pen(color, DashKind::Solid, 1.8)
}

/// A dashed line.
pub const fn dashed(color: &'static str) -> Pen {
    pen(color, DashKind::Dash, 1.6)
}

/// A dotted line.
pub const fn dotted(color: &'static str) -> Pen {
    pen(color, DashKind::Dot, 1.6)
}

/// The pen of a wheel: colours repeat after eight wheels, dashes change with each.
pub fn wheel_pen(index: usize) -> Pen {
    const COLORS: [&str; 8] = ["@w0", "@w1", "@w2", "@w3", "@w4", "@w5", "@w6", "@w7"];
    let dash = match index % 4 {
        0 => DashKind::Solid,
        1 => DashKind::Dash,
        2 => DashKind::Dot,
        _ => DashKind::DashDot,
    };
    pen(COLORS[index % COLORS.len()], dash, 1.6)
}

impl Pen {
    /// Returns the pen with another width.
    pub const fn width(self, width_px: f64) -> Self {
        Self { width_px, ..self }
    }
}

impl DashKind {
    /// Its name in the page; `None` for a solid line.
    pub(crate) const fn name(self) -> Option<&'static str> {
        match self {
            Self::Solid => None,
            Self::Dash => Some("dash"),
            Self::Dot => Some("dot"),
            Self::DashDot => Some("dashdot"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wheels_next_to_each_other_differ_in_colour_and_dash() {
        for first in 0..9 {
            let pens: Vec<Pen> = (first..first + 4).map(wheel_pen).collect();
            for (index, pen) in pens.iter().enumerate() {
                for other in &pens[..index] {
                    assert_ne!(pen.color, other.color);
                    let dashes = [pen, other].map(|pen| std::mem::discriminant(&pen.dash));
                    assert_ne!(dashes[0], dashes[1], "{pen:?} beside {other:?}");
                }
            }
        }
    }
}
