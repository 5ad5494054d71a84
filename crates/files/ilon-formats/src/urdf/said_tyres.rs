//! The tyres that a file of ilon's own names: `<ilon_tyres>`.

use super::numbers::number;
use super::source::Source;
use crate::options::TyreOptions;

/// Returns the tyres that the file says its wheels roll on.
pub(super) fn of(source: &Source) -> Option<TyreOptions> {
    let mut elements = source.robot().children();
    let node = elements.find(|n| n.has_tag_name("ilon_tyres"))?;
    // Numbers were checked with all others; names are looked up as those of options.
    let said = |name: &str| node.attribute(name).map(|_| number(node, name));
    let wheels = node.children().filter(|n| n.has_tag_name("wheel"));
    let named = wheels.filter_map(|n| Some((n.attribute("joint")?, n.attribute("driven"))));
    let (driven, free): (Vec<_>, Vec<_>) = named.partition(|(_, driven)| *driven != Some("false"));
    let names =
        |of: Vec<(&str, Option<&str>)>| of.iter().map(|(name, _)| (*name).to_owned()).collect();
    Some(TyreOptions {
        joints: names(driven),
        free: names(free),
        width_m: said("width"),
        shoulder_radius_m: said("shoulder_radius"),
    })
}
