//! The syntax tree of an expression.
//!
//! Operations of one precedence are stored as a chain, so that a sum of thousands of terms is as
//! deep as a sum of two.

use std::rc::Rc;

/// A literal.
#[derive(Clone, Debug)]
pub(super) enum Literal {
    None,
    Bool(bool),
    Int(i128),
    Float(f64),
    Text(Rc<str>),
}

/// An operation on values.
#[derive(Clone, Debug)]
pub(super) enum Expr {
    Literal(Literal),
    Name(Rc<str>),
    List(Vec<Item>),
    Tuple(Vec<Item>),
    /// `[element for ...]`, or the same in round brackets.
    Comprehension(Box<Expr>, Vec<Clause>),
    /// `not x`, `-x`, `+x`, `~x`.
    Unary(&'static str, Box<Expr>),
    /// Operations of one precedence, from left to right.
    Chain(Box<Expr>, Vec<(&'static str, Expr)>),
    /// `a ** b`.
    Power(Box<Expr>, Box<Expr>),
    /// `a < b <= c`.
    Compare(Box<Expr>, Vec<(&'static str, Expr)>),
    /// `a and b and c`, or the same with `or`.
    Logic(&'static str, Vec<Expr>),
    /// `then if condition else other`.
    If(Box<[Expr; 3]>),
    /// Postfix operations on a value: calls, indices, attributes.
    Postfix(Box<Expr>, Vec<Trailer>),
    /// `lambda parameters: body`.
    Lambda(Rc<[Rc<str>]>, Rc<Expr>),
}

/// An element of a list, tuple or call, with or without a leading `*`.
pub(super) type Item = (bool, Expr);

/// `for names in source if condition if condition`.
#[derive(Clone, Debug)]
pub(super) struct Clause {
    pub(super) names: Vec<Rc<str>>,
    pub(super) source: Expr,
    pub(super) conditions: Vec<Expr>,
}

/// A postfix operation.
#[derive(Clone, Debug)]
pub(super) enum Trailer {
    Call(Vec<Item>, Vec<(Rc<str>, Expr)>),
    Index(Expr),
    Slice([Option<Expr>; 3]),
    Attribute(Rc<str>),
}
