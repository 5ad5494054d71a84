//! What is set beside the file.

use std::collections::BTreeMap;

/// What is set beside the file.
#[derive(Clone, Default)]
pub struct Settings<'a> {
    /// Values of the file's arguments, `<xacro:arg name="...">`, by name; those left out have their defaults.
    pub arguments: BTreeMap<String, String>,
    /// Whether files that cannot be found are left out, with what they would define.
    pub leave_out_missing: bool,
    /// Whether elements without the prefix `xacro:` are read as until 2014: `<property>`, `<macro>`, `<include>`, `<if>`, `<unless>`,
    /// `<insert_block>` and calls of macros that are defined. The first is noted.
    pub before_2014: bool,
    /// Of which names of parameters, properties and arguments the numbers are reported in [`Expanded::watched`](crate::Expanded::watched). A macro's
    /// parameter is asked for with the macro's name before it: `wheel radius`.
    pub watch: Option<&'a (dyn Fn(&str) -> bool + Sync)>,
}
