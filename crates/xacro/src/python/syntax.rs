//! The tree of operations that an expression is.
//!
//! Operations of one precedence are kept as a chain, so that a sum of thousands of terms is as deep as a sum of two.

use std::rc::Rc;

use super::value::{Size, Value};

/// An operation on values.
#[derive(Clone, Debug)]
pub(super) enum Expr {
    Literal(Value),
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
    /// What follows a value: calls, indices, attributes.
    Postfix(Box<Expr>, Vec<Trailer>),
    Lambda(Rc<Lambda>),
}

/// An element of a list, tuple or call, with `*` before it or not.
pub(super) type Item = (bool, Expr);

/// `for names in source if condition if condition`.
#[derive(Clone, Debug)]
pub(super) struct Clause {
    pub(super) names: Vec<Rc<str>>,
    pub(super) source: Expr,
    pub(super) conditions: Vec<Expr>,
}

/// What follows a value.
#[derive(Clone, Debug)]
pub(super) enum Trailer {
    Call(Vec<Item>, Vec<(Rc<str>, Expr)>),
    Index(Expr),
    Slice([Option<Expr>; 3]),
    Attribute(Rc<str>),
}

/// A function without a name. What it finds of the names around it is kept with it.
#[derive(Clone, Debug)]
pub(in super::super) struct Lambda {
    pub(super) parameters: Rc<[Rc<str>]>,
    pub(super) body: Rc<Expr>,
    pub(super) bound: Vec<(Rc<str>, Value)>,
    /// Levels of values within values, of those that are bound.
    pub(super) depth: usize,
}

impl Lambda {
    /// As text it is short, whatever it holds.
    pub(super) fn size(&self) -> Size {
        Size::of_function(self.depth)
    }
}
