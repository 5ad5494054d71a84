//! Settings of an expansion.

use std::collections::BTreeMap;

/// Settings of an expansion.
#[derive(Clone, Default)]
pub struct Settings<'a> {
    /// Values of the file's arguments, `<xacro:arg name="...">`, by name; by default the file's
    /// own.
    pub arguments: BTreeMap<String, String>,
    /// Whether missing files are left out, with their definitions.
    pub leave_out_missing: bool,
    /// Whether elements without the prefix `xacro:` are accepted, as until 2014: `<property>`,
    /// `<macro>`, `<include>`, `<if>`, `<unless>`, `<insert_block>` and calls of defined macros.
    /// The first is noted.
    pub before_2014: bool,
    /// Selects the parameters, properties and arguments whose numbers are reported in
    /// [`Expanded::watched`](crate::Expanded::watched). A macro's parameter is passed with the
    /// macro's name before it: `wheel radius`.
    pub watch: Option<&'a (dyn Fn(&str) -> bool + Sync)>,
}
