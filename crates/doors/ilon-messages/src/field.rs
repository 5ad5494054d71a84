//! Encoding, decoding and description of the values in messages.

use crate::cdr::{CdrError, CdrReader, CdrWriter};
use crate::description::{FieldType, ValueType};

/// A value that a message can contain.
pub trait Field: Sized {
    /// Its type in a definition.
    const TYPE: FieldType;
    /// Smallest number of bytes of one value, without padding. It bounds the number of values in a
    /// message of a given size.
    const MIN_SIZE: usize;

    /// Encodes it at the writer's position.
    ///
    /// # Errors
    ///
    /// A string or sequence cannot be encoded; see [`CdrError`].
    fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError>;

    /// Decodes it from the reader's position.
    ///
    /// # Errors
    ///
    /// The bytes are not such a value; see [`CdrError`].
    fn read(reader: &mut CdrReader) -> Result<Self, CdrError>;
}

macro_rules! numbers {
    ($($number:ty => $kind:ident,)*) => {$(
        impl Field for $number {
            const TYPE: FieldType = FieldType::one(ValueType::$kind);
            const MIN_SIZE: usize = size_of::<Self>();

            fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError> {
                writer.number(self.to_le_bytes());
                Ok(())
            }

            fn read(reader: &mut CdrReader) -> Result<Self, CdrError> {
                reader.number().map(Self::from_le_bytes)
            }
        }
    )*};
}

numbers! {
    u8 => U8,
    i32 => I32,
    u32 => U32,
    f32 => F32,
    f64 => F64,
}

impl Field for bool {
    const TYPE: FieldType = FieldType::one(ValueType::Bool);
    const MIN_SIZE: usize = 1;

    fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError> {
        u8::from(*self).write(writer)
    }

    fn read(reader: &mut CdrReader) -> Result<Self, CdrError> {
        reader.boolean()
    }
}

impl Field for String {
    const TYPE: FieldType = FieldType::one(ValueType::String);
    const MIN_SIZE: usize = size_of::<u32>();

    fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError> {
        writer.string(self)
    }

    fn read(reader: &mut CdrReader) -> Result<Self, CdrError> {
        reader.string().map(Self::from)
    }
}

impl<T: Field> Field for Vec<T> {
    const TYPE: FieldType = T::TYPE.sequence();
    const MIN_SIZE: usize = size_of::<u32>();

    fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError> {
        writer.length(self.len())?;
        self.iter().try_for_each(|element| element.write(writer))
    }

    fn read(reader: &mut CdrReader) -> Result<Self, CdrError> {
        let length = reader.length(T::MIN_SIZE)?;
        // Allocates once: that many do fit into the remaining bytes.
        let mut elements = Self::with_capacity(length);
        for _ in 0..length {
            elements.push(T::read(reader)?);
        }
        Ok(elements)
    }
}

impl<T: Field + Default + Copy, const N: usize> Field for [T; N] {
    const TYPE: FieldType = T::TYPE.array(N);
    const MIN_SIZE: usize = N * T::MIN_SIZE;

    fn write(&self, writer: &mut CdrWriter) -> Result<(), CdrError> {
        self.iter().try_for_each(|element| element.write(writer))
    }

    fn read(reader: &mut CdrReader) -> Result<Self, CdrError> {
        let mut elements = [T::default(); N];
        for element in &mut elements {
            *element = T::read(reader)?;
        }
        Ok(elements)
    }
}
