//! Parses tokens to a syntax tree, with Python's precedence.

use std::rc::Rc;

use super::lex::{Token, tokens};
use super::syntax::{Clause, Expr, Literal, Trailer};
use super::value::Error;

/// Longest expression, in bytes.
const LONGEST: usize = 16 << 10;
/// Deepest nesting of brackets, signs, powers and conditionals.
const DEEPEST: usize = 100;

/// Parses an expression.
pub(super) fn parse(text: &str) -> Result<Expr, Error> {
    if text.len() > LONGEST {
        return Err(Error::new(format!(
            "the expression is longer than {} kB",
            LONGEST >> 10
        )));
    }
    let mut parser = Parser {
        tokens: tokens(text)?,
        at: 0,
        depth: 0,
    };
    let first = parser.expression()?;
    let expr = if parser.sees(",") {
        parser.tuple_after(first)?
    } else {
        first
    };
    match parser.peek() {
        None => Ok(expr),
        Some(token) => Err(unexpected(Some(token))),
    }
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
}

const WORDS: [&str; 11] = [
    "and", "or", "not", "in", "is", "if", "else", "for", "lambda", "None", "await",
];

fn unexpected(token: Option<&Token>) -> Error {
    Error::new(match token {
        None => "invalid syntax: the expression ends too early".to_owned(),
        Some(Token::Sign(sign)) => format!("invalid syntax at `{sign}`"),
        Some(Token::Word(word)) => format!("invalid syntax at `{word}`"),
        Some(Token::Int(i)) => format!("invalid syntax at `{i}`"),
        Some(Token::Float(x)) => format!("invalid syntax at `{x}`"),
        Some(Token::Text(text)) => format!("invalid syntax at `'{text}'`"),
    })
}

impl Parser {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn next(&mut self) -> Option<Token> {
        let token = self.tokens.get(self.at).cloned();
        self.at += 1;
        token
    }

    fn sees(&self, sign: &str) -> bool {
        matches!(self.peek(), Some(Token::Sign(s)) if *s == sign)
    }

    fn sees_word(&self, word: &str) -> bool {
        matches!(self.peek(), Some(Token::Word(w)) if &**w == word)
    }

    fn takes(&mut self, sign: &str) -> bool {
        let seen = self.sees(sign);
        self.at += usize::from(seen);
        seen
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let seen = self.sees_word(word);
        self.at += usize::from(seen);
        seen
    }

    fn expects(&mut self, sign: &str) -> Result<(), Error> {
        if self.takes(sign) {
            return Ok(());
        }
        Err(unexpected(self.peek()))
    }

    /// Takes a comma, unless the end follows.
    fn separates(&mut self, end: &str) -> Result<(), Error> {
        match self.takes(",") || self.sees(end) {
            true => Ok(()),
            false => Err(unexpected(self.peek())),
        }
    }

    /// Enters a level, for recursive constructs.
    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<T, Error> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Error::new(format!(
                "the expression nests more than {DEEPEST} levels deep"
            )));
        }
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn expression(&mut self) -> Result<Expr, Error> {
        self.deeper(|p| {
            if p.takes_word("lambda") {
                return p.lambda();
            }
            let then = p.or()?;
            if !p.takes_word("if") {
                return Ok(then);
            }
            let condition = p.or()?;
            if !p.takes_word("else") {
                return Err(unexpected(p.peek()));
            }
            let other = p.expression()?;
            Ok(Expr::If(Box::new([condition, then, other])))
        })
    }

    fn lambda(&mut self) -> Result<Expr, Error> {
        let mut parameters = Vec::new();
        while !self.takes(":") {
            parameters.push(self.name()?);
            self.separates(":")?;
        }
        let body = self.expression()?;
        Ok(Expr::Lambda(parameters.into(), Rc::new(body)))
    }

    fn name(&mut self) -> Result<Rc<str>, Error> {
        match self.next() {
            Some(Token::Word(word)) if !WORDS.contains(&&*word) => Ok(word),
            other => Err(unexpected(other.as_ref())),
        }
    }

    fn or(&mut self) -> Result<Expr, Error> {
        self.logic("or", Self::and)
    }

    fn and(&mut self) -> Result<Expr, Error> {
        self.logic("and", Self::not)
    }

    fn logic(
        &mut self,
        word: &'static str,
        operand: fn(&mut Self) -> Result<Expr, Error>,
    ) -> Result<Expr, Error> {
        let first = operand(self)?;
        if !self.sees_word(word) {
            return Ok(first);
        }
        let mut operands = vec![first];
        while self.takes_word(word) {
            operands.push(operand(self)?);
        }
        Ok(Expr::Logic(word, operands))
    }

    fn not(&mut self) -> Result<Expr, Error> {
        if self.takes_word("not") {
            let operand = self.deeper(Self::not)?;
            return Ok(Expr::Unary("not", Box::new(operand)));
        }
        self.comparison()
    }

    fn comparison(&mut self) -> Result<Expr, Error> {
        let first = self.bits(0)?;
        let mut rest = Vec::new();
        while let Some(operator) = self.comparison_operator() {
            rest.push((operator, self.bits(0)?));
        }
        Ok(if rest.is_empty() {
            first
        } else {
            Expr::Compare(Box::new(first), rest)
        })
    }

    fn comparison_operator(&mut self) -> Option<&'static str> {
        for sign in ["==", "!=", "<=", ">=", "<", ">"] {
            if self.takes(sign) {
                return Some(sign);
            }
        }
        if self.takes_word("in") {
            return Some("in");
        }
        if self.takes_word("is") {
            return Some(if self.takes_word("not") {
                "is not"
            } else {
                "is"
            });
        }
        let not_in = self.sees_word("not")
            && matches!(self.tokens.get(self.at + 1), Some(Token::Word(w)) if &**w == "in");
        if not_in {
            self.at += 2;
            return Some("not in");
        }
        None
    }

    /// The operators from `|` to `*`, left-associative at each level of precedence.
    fn bits(&mut self, level: usize) -> Result<Expr, Error> {
        const LEVELS: [&[&str]; 6] = [
            &["|"],
            &["^"],
            &["&"],
            &["<<", ">>"],
            &["+", "-"],
            &["*", "/", "//", "%", "@"],
        ];
        let Some(signs) = LEVELS.get(level) else {
            return self.unary();
        };
        let first = self.bits(level + 1)?;
        let mut rest = Vec::new();
        while let Some(sign) = signs.iter().find(|sign| self.sees(sign)) {
            self.at += 1;
            rest.push((*sign, self.bits(level + 1)?));
        }
        Ok(if rest.is_empty() {
            first
        } else {
            Expr::Chain(Box::new(first), rest)
        })
    }

    fn unary(&mut self) -> Result<Expr, Error> {
        for sign in ["-", "+", "~"] {
            if self.takes(sign) {
                let operand = self.deeper(Self::unary)?;
                return Ok(Expr::Unary(sign, Box::new(operand)));
            }
        }
        self.power()
    }

    /// `**` binds more tightly than a sign on its left, and less tightly than one on its right:
    /// -3**2 is -9, 2**-1 is 0.5.
    fn power(&mut self) -> Result<Expr, Error> {
        let base = self.postfix()?;
        if !self.takes("**") {
            return Ok(base);
        }
        let exponent = self.deeper(Self::unary)?;
        Ok(Expr::Power(Box::new(base), Box::new(exponent)))
    }

    fn postfix(&mut self) -> Result<Expr, Error> {
        let base = self.atom()?;
        let mut trailers = Vec::new();
        loop {
            if self.takes("(") {
                trailers.push(self.call()?);
            } else if self.takes("[") {
                trailers.push(self.index()?);
            } else if self.takes(".") {
                trailers.push(Trailer::Attribute(self.name()?));
            } else {
                break;
            }
        }
        Ok(if trailers.is_empty() {
            base
        } else {
            Expr::Postfix(Box::new(base), trailers)
        })
    }

    fn call(&mut self) -> Result<Trailer, Error> {
        let (mut items, mut named) = (Vec::new(), Vec::new());
        while !self.takes(")") {
            let is_named = matches!(self.peek(), Some(Token::Word(_)))
                && matches!(self.tokens.get(self.at + 1), Some(Token::Sign("=")));
            if is_named {
                let name = self.name()?;
                self.at += 1;
                named.push((name, self.expression()?));
            } else {
                let starred = self.takes("*");
                let item = self.expression()?;
                if self.sees_word("for") {
                    items.push((starred, self.comprehension(item)?));
                } else {
                    items.push((starred, item));
                }
            }
            self.separates(")")?;
        }
        Ok(Trailer::Call(items, named))
    }

    fn index(&mut self) -> Result<Trailer, Error> {
        let mut parts = [None, None, None];
        let mut part = 0;
        loop {
            if self.takes("]") {
                break;
            }
            if self.takes(":") {
                part += 1;
                if part > 2 {
                    return Err(unexpected(Some(&Token::Sign(":"))));
                }
                continue;
            }
            if parts[part].is_some() {
                return Err(unexpected(self.peek()));
            }
            parts[part] = Some(self.expression()?);
        }
        if part > 0 {
            return Ok(Trailer::Slice(parts));
        }
        match parts {
            [Some(index), ..] => Ok(Trailer::Index(index)),
            _ => Err(unexpected(Some(&Token::Sign("]")))),
        }
    }

    fn atom(&mut self) -> Result<Expr, Error> {
        match self.next() {
            Some(Token::Int(i)) => Ok(Expr::Literal(Literal::Int(i))),
            Some(Token::Float(x)) => Ok(Expr::Literal(Literal::Float(x))),
            Some(Token::Text(text)) => Ok(Expr::Literal(Literal::Text(self.joined(text)))),
            Some(Token::Word(word)) => match &*word {
                "None" => Ok(Expr::Literal(Literal::None)),
                "True" => Ok(Expr::Literal(Literal::Bool(true))),
                "False" => Ok(Expr::Literal(Literal::Bool(false))),
                word if WORDS.contains(&word) => {
                    Err(Error::new(format!("invalid syntax at `{word}`")))
                }
                _ => Ok(Expr::Name(word)),
            },
            Some(Token::Sign("(")) => self.deeper(Self::in_round_brackets),
            Some(Token::Sign("[")) => self.deeper(Self::in_square_brackets),
            other => Err(unexpected(other.as_ref())),
        }
    }

    /// Adjacent strings are concatenated.
    fn joined(&mut self, first: Rc<str>) -> Rc<str> {
        let mut all = first;
        while let Some(Token::Text(more)) = self.peek() {
            all = format!("{all}{more}").into();
            self.at += 1;
        }
        all
    }

    fn in_round_brackets(&mut self) -> Result<Expr, Error> {
        if self.takes(")") {
            return Ok(Expr::Tuple(Vec::new()));
        }
        let first = self.expression()?;
        if self.sees_word("for") {
            let all = self.comprehension(first)?;
            self.expects(")")?;
            return Ok(all);
        }
        let inner = if self.sees(",") {
            self.tuple_after(first)?
        } else {
            first
        };
        self.expects(")")?;
        Ok(inner)
    }

    fn tuple_after(&mut self, first: Expr) -> Result<Expr, Error> {
        let mut items = vec![(false, first)];
        while self.takes(",") {
            if self.sees(")") || self.peek().is_none() {
                break;
            }
            items.push((self.takes("*"), self.expression()?));
        }
        Ok(Expr::Tuple(items))
    }

    fn in_square_brackets(&mut self) -> Result<Expr, Error> {
        let mut items = Vec::new();
        while !self.takes("]") {
            let starred = self.takes("*");
            let item = self.expression()?;
            if items.is_empty() && !starred && self.sees_word("for") {
                let all = self.comprehension(item)?;
                self.expects("]")?;
                return Ok(all);
            }
            items.push((starred, item));
            self.separates("]")?;
        }
        Ok(Expr::List(items))
    }

    fn comprehension(&mut self, element: Expr) -> Result<Expr, Error> {
        let mut clauses = Vec::new();
        while self.takes_word("for") {
            let bracketed = self.takes("(");
            let mut names = vec![self.name()?];
            while self.takes(",") {
                if self.sees_word("in") || self.sees(")") {
                    break;
                }
                names.push(self.name()?);
            }
            if bracketed {
                self.expects(")")?;
            }
            if !self.takes_word("in") {
                return Err(unexpected(self.peek()));
            }
            let source = self.or()?;
            let mut conditions = Vec::new();
            while self.takes_word("if") {
                conditions.push(self.or()?);
            }
            clauses.push(Clause {
                names,
                source,
                conditions,
            });
        }
        Ok(Expr::Comprehension(Box::new(element), clauses))
    }
}
