//! Texts of foreign files in messages.

/// The most of a name or value that a message quotes, in characters.
const QUOTED: usize = 40;

/// The beginning of a text, which may be of any length, on one line.
pub(super) fn quoted(text: &str) -> String {
    let mut letters = text.chars().filter(|letter| !letter.is_control());
    let beginning: String = letters.by_ref().take(QUOTED).collect();
    match letters.next() {
        Some(_) => beginning + "...",
        None => beginning,
    }
}
