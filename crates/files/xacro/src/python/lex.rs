//! Tokenizes expressions.

use std::rc::Rc;

use super::value::Error;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Int(i128),
    Float(f64),
    Text(Rc<str>),
    /// A name or a keyword.
    Word(Rc<str>),
    /// An operator or a bracket.
    Sign(&'static str),
}

/// Longest first, so that `**` is not two `*`.
const SIGNS: [&str; 32] = [
    "**", "//", "<<", ">>", "<=", ">=", "==", "!=", "+", "-", "*", "/", "%", "@", "&", "|", "^",
    "~", "<", ">", "(", ")", "[", "]", "{", "}", ",", ":", ".", "=", ";", "!",
];

/// Splits an expression into tokens.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, Error> {
    let mut tokens = Vec::new();
    let mut rest = text.trim();
    while let Some(first) = rest.chars().next() {
        let bytes = rest.as_bytes();
        let second_is_digit = bytes.get(1).is_some_and(u8::is_ascii_digit);
        if first.is_whitespace() {
            rest = &rest[first.len_utf8()..];
        } else if first.is_ascii_digit() || (first == '.' && second_is_digit) {
            let (token, length) = number(rest)?;
            tokens.push(token);
            rest = &rest[length..];
        } else if let Some((quote_at, raw)) = string_start(rest) {
            let (token, length) = string(rest, quote_at, raw)?;
            tokens.push(token);
            rest = &rest[length..];
        } else if first.is_alphabetic() || first == '_' {
            let end = rest
                .find(|c: char| !c.is_alphanumeric() && c != '_')
                .unwrap_or(rest.len());
            tokens.push(Token::Word(rest[..end].into()));
            rest = &rest[end..];
        } else {
            let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
            let Some(sign) = sign else {
                return Err(Error::new(format!("invalid syntax at `{first}`")));
            };
            tokens.push(Token::Sign(sign));
            rest = &rest[sign.len()..];
        }
    }
    Ok(tokens)
}

/// Parses a number; returns it with its size in bytes.
fn number(text: &str) -> Result<(Token, usize), Error> {
    let bytes = text.as_bytes();
    let fault = |end: usize| Error::new(format!("`{}` is not a number", &text[..end]));
    let digits_from = |start: usize, radix: u32| {
        let digit = |b: &u8| char::from(*b).is_digit(radix) || *b == b'_';
        start + bytes[start..].iter().take_while(|b| digit(b)).count()
    };
    for (letter, radix) in [(b'x', 16), (b'o', 8), (b'b', 2)] {
        if bytes[0] == b'0'
            && bytes
                .get(1)
                .is_some_and(|b| b.to_ascii_lowercase() == letter)
        {
            let end = digits_from(2, radix);
            let value = i128::from_str_radix(&text[2..end].replace('_', ""), radix);
            return Ok((Token::Int(value.map_err(|_| fault(end))?), end));
        }
    }
    let mut end = digits_from(0, 10);
    let mut float = false;
    if bytes.get(end) == Some(&b'.') {
        float = true;
        end = digits_from(end + 1, 10);
    }
    if bytes
        .get(end)
        .is_some_and(|b| b.eq_ignore_ascii_case(&b'e'))
    {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent_end = digits_from(end + 1 + sign, 10);
        if exponent_end > end + 1 + sign {
            float = true;
            end = exponent_end;
        }
    }
    let follows_letter = bytes
        .get(end)
        .is_some_and(|b| b.is_ascii_alphabetic() && !keyword_follows(&text[end..]));
    if follows_letter {
        return Err(fault(end + 1));
    }
    let plain = text[..end].replace('_', "");
    let token = if float {
        Token::Float(plain.parse().map_err(|_| fault(end))?)
    } else if plain.len() > 1 && plain.starts_with('0') && plain.bytes().any(|b| b != b'0') {
        // Python has no octal numbers of this form, and rejects them.
        return Err(fault(end));
    } else {
        Token::Int(
            plain
                .parse()
                .map_err(|_| Error::new("a whole number of more than 38 digits"))?,
        )
    };
    Ok((token, end))
}

/// `1if x else 2` is unusual, but valid Python.
fn keyword_follows(text: &str) -> bool {
    ["if", "else", "and", "or", "in", "is", "not", "for"]
        .iter()
        .any(|word| {
            text.strip_prefix(word)
                .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
        })
}

/// Returns the position of a string's quote, and whether it is raw; `None` if no string starts.
fn string_start(text: &str) -> Option<(usize, bool)> {
    let bytes = text.as_bytes();
    let is_quote = |at: usize| matches!(bytes.get(at), Some(b'\'' | b'"'));
    match bytes.first()? {
        b'\'' | b'"' => Some((0, false)),
        b'u' | b'U' if is_quote(1) => Some((1, false)),
        b'r' | b'R' if is_quote(1) => Some((1, true)),
        _ => None,
    }
}

fn string(text: &str, quote_at: usize, raw: bool) -> Result<(Token, usize), Error> {
    let body = &text[quote_at..];
    let quote = &body[..1];
    let triple = quote.repeat(3);
    let fence = if body.starts_with(&triple) {
        triple.as_str()
    } else {
        quote
    };
    let mut value = String::new();
    let mut at = fence.len();
    loop {
        let rest = &body[at..];
        if rest.starts_with(fence) {
            return Ok((Token::Text(value.into()), quote_at + at + fence.len()));
        }
        let Some(c) = rest.chars().next() else {
            return Err(Error::new("a string is not closed"));
        };
        at += c.len_utf8();
        if c != '\\' {
            value.push(c);
            continue;
        }
        let Some(escaped) = rest[1..].chars().next() else {
            return Err(Error::new("a string is not closed"));
        };
        at += escaped.len_utf8();
        if raw {
            value.push(c);
            value.push(escaped);
            continue;
        }
        match escaped {
            'n' => value.push('\n'),
            't' => value.push('\t'),
            'r' => value.push('\r'),
            '\\' | '\'' | '"' => value.push(escaped),
            '\n' => {}
            'x' | 'u' => {
                let count = if escaped == 'x' { 2 } else { 4 };
                let code = body.get(at..at + count);
                let decoded = code
                    .and_then(|code| u32::from_str_radix(code, 16).ok())
                    .and_then(char::from_u32)
                    .ok_or_else(|| Error::new("a string holds an escape that is cut short"))?;
                value.push(decoded);
                at += count;
            }
            other => {
                value.push('\\');
                value.push(other);
            }
        }
    }
}
