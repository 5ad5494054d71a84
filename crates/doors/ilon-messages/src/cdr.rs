//! CDR, the encoding of messages in ROS 2: OMG CORBA 3.3, part 2, section 9.3, after the header of
//! four bytes of RTPS 2.5, section 10.2. ROS 2 uses only the plain form, here called CDR 1.

/// Reasons why a message could not be encoded or decoded. Positions are bytes from the start of the
/// encoded message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CdrError {
    /// The message ends before its fields do.
    #[error("the message ends at byte {end}, where {wanted} more bytes were due")]
    Short {
        /// End of the message.
        end: usize,
        /// Missing bytes of the next value.
        wanted: usize,
    },
    /// The header names an encoding other than plain CDR.
    #[error(
        "the header names the encoding 0x{0:04x}; only plain CDR (0x0000 and 0x0001) can be read"
    )]
    Encoding(u16),
    /// A string or sequence is longer than the rest of the message.
    #[error("the length {length} at byte {at} does not fit into the {left} bytes that are left")]
    Length {
        /// Position of the length.
        at: usize,
        /// The stated number of elements or bytes.
        length: u32,
        /// Number of bytes that follow.
        left: usize,
    },
    /// The bytes of a string are not UTF-8.
    #[error("the string at byte {at} is not UTF-8")]
    Utf8 {
        /// Start of the string.
        at: usize,
    },
    /// A string without its final NUL, or with one before it.
    #[error("the string at byte {at} does not have its one NUL at its end")]
    Nul {
        /// Start of the string.
        at: usize,
    },
    /// A boolean is neither 0 nor 1.
    #[error("the boolean at byte {at} is {value}; it can only be 0 or 1")]
    Bool {
        /// Position of the boolean.
        at: usize,
        /// Its byte.
        value: u8,
    },
    /// More bytes follow the last field than any padding.
    #[error("{count} bytes follow the last field, which ends at byte {at}")]
    Trailing {
        /// End of the last field.
        at: usize,
        /// Number of bytes that follow.
        count: usize,
    },
    /// A string or sequence with more elements than 32 bits can count.
    #[error("{length} elements are too many for one message; CDR counts them in 32 bits")]
    TooLong {
        /// Number of its elements.
        length: usize,
    },
}

/// Size of the header in bytes; the alignment of fields is counted after it.
const HEADER: usize = 4;
/// Largest padding of a message to a multiple of four bytes.
const PADDING: usize = 3;
/// Largest excess length of a message from `rclpy`, for each empty sequence, in bytes: it counts
/// the alignment of missing elements, which may also move the alignment of later fields.
const PADDING_PER_EMPTY_SEQUENCE: usize = 8;

/// Writes the fields of a message in sequence, little-endian.
#[derive(Debug)]
pub struct CdrWriter<'a> {
    bytes: &'a mut Vec<u8>,
}

impl<'a> CdrWriter<'a> {
    /// Clears `bytes` and starts a message in it.
    pub(crate) fn begin(bytes: &'a mut Vec<u8>) -> Self {
        bytes.clear();
        bytes.extend_from_slice(&[0, 1, 0, 0]);
        Self { bytes }
    }

    /// Writes a number of N bytes, in little-endian order, at the next multiple of N.
    pub fn number<const N: usize>(&mut self, little_endian: [u8; N]) {
        let gap = gap::<N>(self.bytes.len());
        self.bytes.resize(self.bytes.len() + gap, 0);
        self.bytes.extend_from_slice(&little_endian);
    }

    /// Writes a string with its length before it and a NUL after it.
    ///
    /// # Errors
    ///
    /// It contains a NUL, which other readers would interpret as its end, or is too long.
    pub fn string(&mut self, text: &str) -> Result<(), CdrError> {
        if text.contains('\0') {
            let at = self.bytes.len();
            return Err(CdrError::Nul { at });
        }
        self.length(text.len() + 1)?;
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
        Ok(())
    }

    /// Writes the number of elements of a sequence.
    ///
    /// # Errors
    ///
    /// It does not fit into 32 bits.
    pub fn length(&mut self, length: usize) -> Result<(), CdrError> {
        let counted = u32::try_from(length).map_err(|_| CdrError::TooLong { length })?;
        self.number(counted.to_le_bytes());
        Ok(())
    }
}

/// Reads the fields of a message in sequence, in the byte order of its header.
#[derive(Debug)]
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Largest number of bytes after the last field.
    padding: usize,
}

impl<'a> CdrReader<'a> {
    /// Starts at the header of an encoded message.
    pub(crate) fn begin(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let mut reader = Self {
            bytes,
            at: 0,
            big_endian: true,
            padding: PADDING,
        };
        let [high, low, _, _] = *reader.take::<HEADER>()?;
        reader.big_endian = match u16::from_be_bytes([high, low]) {
            0 => true,
            1 => false,
            other => return Err(CdrError::Encoding(other)),
        };
        Ok(reader)
    }

    /// Checks that only padding is left.
    pub(crate) fn end(self) -> Result<(), CdrError> {
        let count = self.left();
        if count <= self.padding {
            Ok(())
        } else {
            Err(CdrError::Trailing { at: self.at, count })
        }
    }

    /// Reads a number of N bytes from the next multiple of N; returns it in little-endian order.
    ///
    /// # Errors
    ///
    /// The message ends before.
    pub fn number<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.at += gap::<N>(self.at);
        let mut number = *self.take::<N>()?;
        if self.big_endian {
            number.reverse();
        }
        Ok(number)
    }

    /// Reads a boolean.
    ///
    /// # Errors
    ///
    /// The message ends before, or the byte is neither 0 nor 1.
    pub fn boolean(&mut self) -> Result<bool, CdrError> {
        let at = self.at;
        match self.number()? {
            [0] => Ok(false),
            [1] => Ok(true),
            [value] => Err(CdrError::Bool { at, value }),
        }
    }

    /// Reads a string. A length of 0, without even a NUL, is also an empty string: some writers
    /// send it.
    ///
    /// # Errors
    ///
    /// It is longer than the message, is not UTF-8, or does not have exactly one NUL, at its end.
    pub fn string(&mut self) -> Result<&'a str, CdrError> {
        let length = self.length(1)?;
        let at = self.at;
        let (text, rest) = self.bytes[at..].split_at(length);
        self.at = self.bytes.len() - rest.len();
        let text = match text.split_last() {
            None => return Ok(""),
            Some((0, text)) if !text.contains(&0) => text,
            Some(_) => return Err(CdrError::Nul { at }),
        };
        std::str::from_utf8(text).map_err(|_| CdrError::Utf8 { at })
    }

    /// Reads the number of elements of a sequence, each of which has at least `element` bytes.
    ///
    /// # Errors
    ///
    /// That many elements do not fit into the rest of the message.
    pub fn length(&mut self, element: usize) -> Result<usize, CdrError> {
        let length = u32::from_le_bytes(self.number()?);
        let left = self.left();
        if length == 0 {
            self.padding += PADDING_PER_EMPTY_SEQUENCE;
        }
        match usize::try_from(length).ok().filter(|count| {
            count
                .checked_mul(element)
                .is_some_and(|bytes| bytes <= left)
        }) {
            Some(count) => Ok(count),
            None => Err(CdrError::Length {
                at: self.at - size_of::<u32>(),
                length,
                left,
            }),
        }
    }

    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn take<const N: usize>(&mut self) -> Result<&'a [u8; N], CdrError> {
        let end = self.bytes.len();
        let taken = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk);
        self.at += N;
        taken.ok_or_else(|| CdrError::Short {
            end,
            wanted: self.at - end,
        })
    }
}

/// Returns the number of bytes between `at` and the next multiple of N after the header.
fn gap<const N: usize>(at: usize) -> usize {
    const { assert!(N.is_power_of_two(), "numbers take 1, 2, 4 or 8 bytes") };
    (at - HEADER).next_multiple_of(N) - (at - HEADER)
}
