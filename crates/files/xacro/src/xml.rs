//! XML with limits, checked before the parser runs.

use std::ops::Range;

use roxmltree::{Document, Node, ParsingOptions};

/// Longest text, in bytes: a robot with ten thousand rollers stays below.
pub const MAX_BYTES: u64 = 64 << 20;
/// Largest number of XML nodes.
const MAX_NODES: u32 = 4_000_000;
/// Deepest nesting of elements; plug-in settings nest a dozen deep.
pub const MAX_DEPTH: usize = 100;
/// Largest number of attributes of one element: the parser compares each with all others.
const MAX_ATTRIBUTES: usize = 200;
/// Largest number of namespaces declared around an element: the parser copies all of them for each
/// inner element. Robots declare a handful.
const MAX_NAMESPACES: usize = 200;

/// The reason why a text is not read as XML, with its place.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// Not well formed, with the parser's message.
    Malformed(String, Range<usize>),
    /// A size beyond its limit: what, and the limit.
    TooMuch(String, String, Range<usize>),
}

/// Parses a text.
pub fn parse(text: &str) -> Result<Document<'_>, Fault> {
    if text.len() as u64 > MAX_BYTES {
        return Err(Fault::TooMuch(
            format!("more than {} MB of text", MAX_BYTES >> 20),
            format!("{} MB", MAX_BYTES >> 20),
            0..0,
        ));
    }
    check_tags(text)?;
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|e| {
        let at = byte_of(text, e.pos());
        let rest = text.get(at..).unwrap_or_default();
        let end = at + rest.find('\n').unwrap_or(rest.len());
        Fault::Malformed(without_position(&e.to_string()), at..end)
    })
}

/// The numbers of a text, between blanks; `None` if one is none or is not finite.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace()
        .map(|word| word.parse::<f64>().ok().filter(|x| x.is_finite()))
        .collect()
}

/// Returns the bytes of an element's opening tag.
pub fn opening_tag(text: &str, node: Node) -> Range<usize> {
    let Range { start, end } = node.range();
    let length = end_of_tag(&text[start..end]).map_or(end - start, |i| i + 1);
    start..start + length
}

/// Rejects elements that nest so deep, or have so many attributes or namespaces, that parsing could
/// exhaust the stack or the time.
fn check_tags(text: &str) -> Result<(), Fault> {
    // For each open element the number of namespaces declared up to it.
    let mut open_elements: Vec<usize> = Vec::new();
    let mut rest = text;
    while let Some(open) = rest.find('<') {
        rest = &rest[open + 1..];
        // Skips comments and CDATA, which may contain any text.
        for (begin, end) in [("!--", "-->"), ("![CDATA[", "]]>")] {
            if let Some(inside) = rest.strip_prefix(begin) {
                rest = inside.find(end).map_or("", |i| &inside[i..]);
            }
        }
        let Some(close) = end_of_tag(rest) else {
            return Ok(());
        };
        let at = text.len() - rest.len() - 1;
        let tag = &rest[..close];
        if tag.starts_with('/') {
            open_elements.pop();
        } else if !tag.starts_with(['?', '!', '-', ']']) {
            if tag.len() > 4 * MAX_ATTRIBUTES && attributes_of(tag) > MAX_ATTRIBUTES {
                return Err(Fault::TooMuch(
                    format!("an element with more than {MAX_ATTRIBUTES} attributes"),
                    MAX_ATTRIBUTES.to_string(),
                    at..at + 1,
                ));
            }
            let around = open_elements.last().copied().unwrap_or(0);
            let namespaces = around + tag.matches("xmlns").count();
            if namespaces > MAX_NAMESPACES {
                return Err(Fault::TooMuch(
                    format!("more than {MAX_NAMESPACES} namespaces around an element"),
                    MAX_NAMESPACES.to_string(),
                    at..at + 1,
                ));
            }
            if !tag.ends_with('/') {
                open_elements.push(namespaces);
            }
        }
        if open_elements.len() > MAX_DEPTH {
            return Err(Fault::TooMuch(
                format!("elements nested more than {MAX_DEPTH} deep"),
                format!("{MAX_DEPTH} levels"),
                at..at + close + 2,
            ));
        }
    }
    Ok(())
}

/// Returns the number of attributes of a tag: its equals signs outside quotes.
fn attributes_of(tag: &str) -> usize {
    let mut quote = None;
    tag.bytes()
        .filter(|&b| {
            match quote {
                Some(q) if b == q => quote = None,
                None if b == b'"' || b == b'\'' => quote = Some(b),
                _ => {}
            }
            quote.is_none() && b == b'='
        })
        .count()
}

/// Returns the end of a tag: its first `>` outside quotes.
fn end_of_tag(text: &str) -> Option<usize> {
    let mut quote = None;
    text.bytes().position(|b| match quote {
        Some(q) => {
            if b == q {
                quote = None;
            }
            false
        }
        None => {
            if b == b'"' || b == b'\'' {
                quote = Some(b);
            }
            b == b'>'
        }
    })
}

fn byte_of(text: &str, pos: roxmltree::TextPos) -> usize {
    let row = (pos.row as usize).saturating_sub(1);
    let line_start: usize = text.split_inclusive('\n').take(row).map(str::len).sum();
    let line = text.get(line_start..).unwrap_or_default();
    let column = (pos.col as usize).saturating_sub(1);
    let within = line.char_indices().nth(column).map_or(0, |(i, _)| i);
    line_start + within
}

/// Removes the trailing "at line:column" from roxmltree's message; the fault has its own place.
fn without_position(message: &str) -> String {
    match message.rfind(" at ") {
        Some(i)
            if message[i + 4..]
                .chars()
                .all(|c| c.is_ascii_digit() || c == ':') =>
        {
            message[..i].to_owned()
        }
        _ => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_with_a_million_attributes_is_refused_at_once() {
        let attributes: String = (0..100_000).map(|i| format!(" a{i}='>'")).collect();
        let text = format!("<robot>\n<link{attributes}/></robot>");
        let Err(Fault::TooMuch(what, _, place)) = parse(&text) else {
            panic!("it was read");
        };
        assert!(what.contains("attributes"));
        assert_eq!(place.start, 8);
        // Equals signs in values do not count.
        let value = "=".repeat(100_000);
        assert!(parse(&format!("<robot a='{value}'/>")).is_ok());
    }

    /// Each of 90 nested elements declares 100 namespaces: the parser would copy 4,500 of them for
    /// the average element.
    #[test]
    fn namespaces_that_pile_up_are_refused() {
        let nested = |elements: usize, each: usize| {
            let open = |element: usize| {
                let names = (0..each).map(|i| format!(" xmlns:n{element}_{i}='u'"));
                format!("<a{}>", names.collect::<String>())
            };
            let open: String = (0..elements).map(open).collect();
            format!("{open}{}", "</a>".repeat(elements))
        };
        let Err(Fault::TooMuch(what, ..)) = parse(&nested(90, 100)) else {
            panic!("it was read");
        };
        assert!(what.contains("namespaces"), "{what}");
        assert!(parse(&nested(20, 10)).is_ok());
        // Those of adjacent elements are not in scope together.
        let beside = format!("<r>{}</r>", "<a xmlns:x='u'></a>".repeat(1000));
        assert!(parse(&beside).is_ok());
    }
}
