//! Descriptions of messages, for their definition text and type hash.

use std::fmt::Write;

/// A message: its name, its constants and its fields.
#[derive(Debug)]
pub struct Description {
    /// Its ROS package, such as `geometry_msgs`.
    pub package: &'static str,
    /// Its name within the package, such as `Twist`.
    pub name: &'static str,
    /// Package and name in ROS 2's form, such as `geometry_msgs/msg/Twist`.
    pub type_name: &'static str,
    /// The hash of its fields and those of nested messages (REP-2016), such as `RIHS01_9c45...`.
    pub type_hash: &'static str,
    /// Its constants, in order.
    pub constants: &'static [Constant],
    /// Its fields, in encoding order.
    pub fields: &'static [FieldDescription],
}

/// A constant of a message.
#[derive(Debug)]
pub struct Constant {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: ValueType,
    /// Its value, as written in the definition.
    pub value: &'static str,
}

/// A field of a message.
#[derive(Debug)]
pub struct FieldDescription {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub field_type: FieldType,
}

/// Type of a field: one or several values of one kind.
#[derive(Clone, Copy, Debug)]
pub struct FieldType {
    /// The kind of each value.
    pub kind: ValueType,
    /// Their number.
    pub shape: Shape,
}

/// Number of values in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One.
    One,
    /// A fixed number.
    Array(usize),
    /// Any number, encoded before the values.
    Sequence,
}

/// The kind of a value.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum ValueType {
    /// `bool`
    Bool,
    /// `byte`: eight bits that are not a number.
    Byte,
    /// `uint8`
    U8,
    /// `int32`
    I32,
    /// `uint32`
    U32,
    /// `float32`
    F32,
    /// `float64`
    F64,
    /// `string`
    String,
    /// Another message.
    Message(&'static Description),
}

impl FieldType {
    /// One value of a kind.
    pub const fn one(kind: ValueType) -> Self {
        Self {
            kind,
            shape: Shape::One,
        }
    }

    /// An array of `count` of these. An array of arrays is one long array: ROS 2 has no others, and
    /// the encoding is the same.
    pub(crate) const fn array(self, count: usize) -> Self {
        let shape = match self.shape {
            Shape::One => Shape::Array(count),
            Shape::Array(inner) => Shape::Array(inner * count),
            Shape::Sequence => panic!("ROS 2 has no arrays of sequences"),
        };
        Self { shape, ..self }
    }

    /// A sequence of these.
    pub(crate) const fn sequence(self) -> Self {
        assert!(
            matches!(self.shape, Shape::One),
            "ROS 2 has no sequences of arrays or sequences"
        );
        Self {
            shape: Shape::Sequence,
            ..self
        }
    }
}

impl Description {
    /// Returns the text of the definition in bags: the message's own, then those of nested
    /// messages, each once, after a line of 80 `=` and its name.
    pub fn definition(&self) -> String {
        let mut text = self.own_definition();
        for message in self.messages_within() {
            let Self { package, name, .. } = message;
            let _ = write!(
                text,
                "{:=<80}\nMSG: {package}/{name}\n{}",
                "",
                message.own_definition()
            );
        }
        text
    }

    /// Returns all nested messages, each once, in the order of the fields.
    pub fn messages_within(&self) -> Vec<&'static Description> {
        let mut found = Vec::new();
        self.collect_within(&mut found);
        found
    }

    fn collect_within(&self, found: &mut Vec<&'static Description>) {
        for field in self.fields {
            if let ValueType::Message(message) = field.field_type.kind
                && !found
                    .iter()
                    .any(|known| known.type_name == message.type_name)
            {
                found.push(message);
                message.collect_within(found);
            }
        }
    }

    fn own_definition(&self) -> String {
        let mut text = String::new();
        for Constant { name, kind, value } in self.constants {
            let _ = writeln!(text, "{} {name}={value}", kind.name());
        }
        for FieldDescription {
            name,
            field_type: FieldType { kind, shape },
        } in self.fields
        {
            let kind = kind.name();
            let _ = match shape {
                Shape::One => writeln!(text, "{kind} {name}"),
                Shape::Array(count) => writeln!(text, "{kind}[{count}] {name}"),
                Shape::Sequence => writeln!(text, "{kind}[] {name}"),
            };
        }
        text
    }
}

impl ValueType {
    /// Returns the name in the text of a definition.
    fn name(self) -> String {
        match self {
            Self::Bool => "bool".into(),
            Self::Byte => "byte".into(),
            Self::U8 => "uint8".into(),
            Self::I32 => "int32".into(),
            Self::U32 => "uint32".into(),
            Self::F32 => "float32".into(),
            Self::F64 => "float64".into(),
            Self::String => "string".into(),
            Self::Message(Description { package, name, .. }) => format!("{package}/{name}"),
        }
    }
}
