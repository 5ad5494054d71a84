//! Packets of ArduPilot's SITL: frames of servo outputs, little-endian.
//!
//! `libraries/SITL/examples/JSON/readme.md` of ArduPilot: `uint16 magic, uint16 frame_rate, uint32
//! frame_count, uint16 pwm[16]`, or `pwm[32]` with another magic number.

/// The magic numbers, with the number of outputs.
const KINDS: [(u16, usize); 2] = [(18458, 16), (29569, 32)];

/// One frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Requested number of frames per second.
    pub rate_hz: u16,
    /// Frame counter since the start of SITL.
    pub frame: u32,
    /// Pulse lengths in microseconds, 0 for none.
    pub pwm_us: Vec<u16>,
}

impl Packet {
    /// Parses a datagram; `None` if it is no frame.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (head, outputs) = bytes.split_at_checked(8)?;
        let short = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
        let (_, count) = KINDS.into_iter().find(|(magic, _)| *magic == short(0))?;
        let (outputs, rest) = outputs.as_chunks::<2>();
        if outputs.len() != count || !rest.is_empty() {
            return None;
        }
        Some(Self {
            rate_hz: short(2),
            frame: u32::from_le_bytes([head[4], head[5], head[6], head[7]]),
            pwm_us: outputs
                .iter()
                .map(|bytes| u16::from_le_bytes(*bytes))
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_frame_is_not_taken() {
        let mut bytes = vec![0x1a, 0x48, 0x90, 0x01, 0x04, 0x03, 0x02, 0x01];
        bytes.extend([0xdc, 0x05].repeat(16));
        let packet = Packet::read(&bytes).expect("a frame");
        assert_eq!((packet.rate_hz, packet.frame), (400, 0x0102_0304));
        assert_eq!(packet.pwm_us, [1500; 16]);
        for length in 0..bytes.len() {
            assert_eq!(Packet::read(&bytes[..length]), None, "{length} bytes");
        }
        bytes.push(0);
        assert_eq!(Packet::read(&bytes), None);
        bytes[0] ^= 1;
        assert_eq!(Packet::read(&bytes[..40]), None);
    }
}
