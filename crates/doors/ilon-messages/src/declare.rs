//! Macros that declare messages.

/// Declares the messages of one ROS package. Each declaration gives a struct, its defaults, its
/// encoding and its description.
///
/// A field is `name: Type`; `u8 as byte` is a `byte`, which differs from `uint8` only in the
/// definition. `= value` after it is its default, if different from the type's. Constants are in a
/// separate block.
macro_rules! messages {
    ($package:ident; $(
        $(#[$attribute:meta])*
        $name:ident $hash:literal $( const {
            $( $(#[$constant_attribute:meta])* $constant:ident: $constant_type:ty $(as $constant_kind:ident)? = $value:literal, )*
        } )? {
            $( $(#[$field_attribute:meta])* $field:ident: $field_type:ty $(as $field_kind:ident)? $(= $default:literal)?, )*
        }
    )*) => {
        $(
            $(#[$attribute])*
            #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
            // Of JSON, in which viewers leave zeros out.
            #[serde(default)]
            pub struct $name {
                $( $(#[$field_attribute])* pub $field: $field_type, )*
            }

            impl $name {
                $( $( $(#[$constant_attribute])* pub const $constant: $constant_type = $value; )* )?
            }

            impl Default for $name {
                fn default() -> Self {
                    Self { $( $field: $crate::declare::or_default!($($default)?), )* }
                }
            }

            impl $crate::Field for $name {
                const TYPE: $crate::FieldType = $crate::FieldType::one($crate::ValueType::Message(<Self as $crate::Message>::DESCRIPTION));
                const MIN_SIZE: usize = 0 $( + <$field_type as $crate::Field>::MIN_SIZE )*;

                fn write(&self, writer: &mut $crate::CdrWriter) -> Result<(), $crate::CdrError> {
                    $( self.$field.write(writer)?; )*
                    Ok(())
                }

                fn read(reader: &mut $crate::CdrReader) -> Result<Self, $crate::CdrError> {
                    Ok(Self { $( $field: $crate::Field::read(reader)?, )* })
                }
            }

            impl $crate::Message for $name {
                const DESCRIPTION: &'static $crate::Description = &$crate::Description {
                    package: stringify!($package),
                    name: stringify!($name),
                    type_name: concat!(stringify!($package), "/msg/", stringify!($name)),
                    type_hash: concat!("RIHS01_", $hash),
                    constants: &[ $($( $crate::Constant {
                        name: stringify!($constant),
                        kind: $crate::declare::type_of!($constant_type $(as $constant_kind)?).kind,
                        value: stringify!($value),
                    } ),*)? ],
                    fields: &[ $( $crate::FieldDescription {
                        name: $crate::declare::plain_name(stringify!($field)),
                        field_type: $crate::declare::type_of!($field_type $(as $field_kind)?),
                    } ),* ],
                };
            }
        )*

        /// The messages of this package.
        pub(super) const ALL: &[&$crate::Description] = &[ $( <$name as $crate::Message>::DESCRIPTION ),* ];
    };
}

/// The given value, or the type's default.
macro_rules! or_default {
    () => {
        Default::default()
    };
    ($value:literal) => {
        $value
    };
}

/// The type of a field or constant in a definition.
macro_rules! type_of {
    ($type:ty as byte) => {
        $crate::FieldType::one($crate::ValueType::Byte)
    };
    ($type:ty) => {
        <$type as $crate::Field>::TYPE
    };
}

pub(crate) use {messages, or_default, type_of};

/// Returns the name of a field without the mark that separates it from a Rust keyword.
pub(crate) const fn plain_name(name: &'static str) -> &'static str {
    match name.as_bytes() {
        [b'r', b'#', ..] => name.split_at(2).1,
        _ => name,
    }
}
