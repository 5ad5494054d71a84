//! What a message consists of, as its text and its type hash say it.

use std::fmt::Write;

/// A message: its name, its constants and its fields.
#[derive(Debug)]
pub struct Description {
    /// The ROS package that defines it, as in `geometry_msgs`.
    pub package: &'static str,
    /// Its name within the package, as in `Twist`.
    pub name: &'static str,
    /// Package and name as ROS 2 writes them, as in `geometry_msgs/msg/Twist`.
    pub type_name: &'static str,
    /// The hash of its fields and those of the messages within them (REP-2016), as in `RIHS01_9c45...`.
    pub type_hash: &'static str,
    /// Its constants, in order.
    pub constants: &'static [Constant],
    /// Its fields, in the order in which they are encoded.
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
    /// What it holds.
    pub field_type: FieldType,
}

/// What a field holds: values of one kind, one or several.
#[derive(Clone, Copy, Debug)]
pub struct FieldType {
    /// The kind of each value.
    pub kind: ValueType,
    /// How many there are.
    pub shape: Shape,
}

/// How many values a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One.
    One,
    /// Always as many.
    Array(usize),
    /// Any number, encoded before them.
    Sequence,
}

/// The kind of a value.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum ValueType {
    /// `bool`
    Bool,
    /// `byte`: eight bits without a meaning as a number.
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

    /// `count` of these. An array of arrays is one long array: ROS 2 has no others, and on the wire they are the same.
    pub(crate) const fn array(self, count: usize) -> Self {
        let shape = match self.shape {
            Shape::One => Shape::Array(count),
            Shape::Array(inner) => Shape::Array(inner * count),
            Shape::Sequence => panic!("ROS 2 has no arrays of sequences"),
        };
        Self { shape, ..self }
    }

    /// Any number of these.
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
    /// The text of the definition as bags hold it: the message's own, then those of the messages within it, each once, after a
    /// line of 80 `=` and its name.
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

    /// The messages within this one and within those, each once, in the order in which its fields lead to them.
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
    /// The name in the text of a definition.
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
