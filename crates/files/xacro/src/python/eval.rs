//! Evaluation of a syntax tree.

use std::rc::Rc;

use super::builtins;
use super::methods;
use super::operators;
use super::parse::parse;
use super::surroundings::{Arguments, Caller, Surroundings, elements};
use super::syntax::{Clause, Expr, Item, Trailer};
use super::value::{Error, Lambda, Value, check_nesting};

/// Returns the value of an expression.
pub(in super::super) fn evaluate(text: &str, around: &dyn Surroundings) -> Result<Value, Error> {
    around.budget().spend_bytes(text.len())?;
    let expr = parse(text)?;
    Evaluator {
        around,
        locals: Vec::new(),
    }
    .value(&expr)
}

struct Evaluator<'a> {
    around: &'a dyn Surroundings,
    /// Names of comprehensions and lambdas, the innermost last.
    locals: Vec<(Rc<str>, Value)>,
}

impl Evaluator<'_> {
    fn value(&mut self, expr: &Expr) -> Result<Value, Error> {
        let value = self.unchecked(expr)?;
        check_nesting(&value)?;
        Ok(value)
    }

    fn unchecked(&mut self, expr: &Expr) -> Result<Value, Error> {
        let around = self.around;
        let _level = around.budget().enter(1)?;
        around.budget().spend(1)?;
        match expr {
            Expr::Literal(literal) => Ok(literal.into()),
            Expr::Name(name) => self.name(name),
            Expr::List(items) => Ok(Value::list(self.items(items)?)),
            Expr::Tuple(items) => Ok(Value::tuple(self.items(items)?)),
            Expr::Comprehension(element, clauses) => {
                let mut items = Vec::new();
                let depth = self.locals.len();
                let done = self.comprehension(element, clauses, &mut items);
                self.locals.truncate(depth);
                done?;
                Ok(Value::list(items))
            }
            Expr::Unary(sign, operand) => operators::unary(sign, &self.value(operand)?),
            Expr::Chain(first, rest) => {
                let mut sum = self.value(first)?;
                for (sign, operand) in rest {
                    let operand = self.value(operand)?;
                    sum = operators::binary(sign, &sum, &operand, around)?;
                }
                Ok(sum)
            }
            Expr::Power(base, exponent) => {
                operators::power(&self.value(base)?, &self.value(exponent)?)
            }
            Expr::Compare(first, rest) => {
                let mut left = self.value(first)?;
                for (operator, operand) in rest {
                    let right = self.value(operand)?;
                    if !operators::compare(operator, &left, &right, around)? {
                        return Ok(Value::Bool(false));
                    }
                    left = right;
                }
                Ok(Value::Bool(true))
            }
            Expr::Logic(word, operands) => self.logic(word, operands),
            Expr::If(parts) => {
                let [condition, then, other] = &**parts;
                let chosen = if self.value(condition)?.truth() {
                    then
                } else {
                    other
                };
                self.value(chosen)
            }
            Expr::Postfix(base, trailers) => self.postfix(base, trailers),
            Expr::Lambda(parameters, body) => {
                around.budget().spend(self.locals.len() as u64)?;
                let depths = self.locals.iter().map(|(_, value)| value.size().depth);
                Ok(Value::Lambda(Rc::new(Lambda {
                    parameters: Rc::clone(parameters),
                    body: Rc::clone(body),
                    depth: depths.max().unwrap_or(0),
                    bound: self.locals.clone(),
                })))
            }
        }
    }

    fn name(&self, name: &str) -> Result<Value, Error> {
        self.around.budget().spend(self.locals.len() as u64 / 16)?;
        if let Some((_, value)) = self.locals.iter().rev().find(|(n, _)| &**n == name) {
            return Ok(value.clone());
        }
        if name.starts_with("__") {
            return Err(Error::new(format!("the name {name} is not allowed")));
        }
        if let Some(value) = self.around.look_up(name)? {
            return Ok(value);
        }
        builtins::global(name).ok_or_else(|| Error::Name(name.to_owned()))
    }

    fn items(&mut self, items: &[Item]) -> Result<Vec<Value>, Error> {
        let mut values = Vec::with_capacity(items.len());
        for (starred, item) in items {
            let value = self.value(item)?;
            if *starred {
                values.extend(elements(&value, self.around)?);
            } else {
                values.push(value);
            }
        }
        Ok(values)
    }

    fn comprehension(
        &mut self,
        element: &Expr,
        clauses: &[Clause],
        into: &mut Vec<Value>,
    ) -> Result<(), Error> {
        let Some((clause, inner)) = clauses.split_first() else {
            into.push(self.value(element)?);
            return Ok(());
        };
        let source = self.value(&clause.source)?;
        for item in elements(&source, self.around)? {
            let depth = self.locals.len();
            self.bind(&clause.names, item)?;
            let mut holds = true;
            for condition in &clause.conditions {
                holds = holds && self.value(condition)?.truth();
            }
            if holds {
                self.comprehension(element, inner, into)?;
            }
            self.locals.truncate(depth);
        }
        Ok(())
    }

    fn bind(&mut self, names: &[Rc<str>], value: Value) -> Result<(), Error> {
        if let [name] = names {
            self.locals.push((Rc::clone(name), value));
            return Ok(());
        }
        let values = elements(&value, self.around)?;
        if values.len() != names.len() {
            return Err(Error::new(format!(
                "{} values to unpack, {} expected",
                values.len(),
                names.len()
            )));
        }
        self.locals.extend(names.iter().cloned().zip(values));
        Ok(())
    }

    fn logic(&mut self, word: &str, operands: &[Expr]) -> Result<Value, Error> {
        let mut last = Value::None;
        for operand in operands {
            last = self.value(operand)?;
            if last.truth() == (word == "or") {
                break;
            }
        }
        Ok(last)
    }

    fn postfix(&mut self, base: &Expr, trailers: &[Trailer]) -> Result<Value, Error> {
        let mut value = self.value(base)?;
        for trailer in trailers {
            value = match trailer {
                Trailer::Attribute(name) => self.attribute(&value, name)?,
                Trailer::Index(index) => {
                    let index = self.value(index)?;
                    self.index(&value, &index)?
                }
                Trailer::Slice(parts) => {
                    let mut bounds = [None, None, None];
                    for (bound, part) in bounds.iter_mut().zip(parts) {
                        if let Some(part) = part {
                            *bound = Some(self.value(part)?);
                        }
                    }
                    self.slice(&value, bounds)?
                }
                Trailer::Call(items, named) => {
                    let items = self.items(items)?;
                    let mut arguments = Arguments {
                        items,
                        named: Vec::new(),
                    };
                    for (name, expr) in named {
                        let value = self.value(expr)?;
                        arguments.named.push((Rc::clone(name), value));
                    }
                    self.call(&value, arguments)?
                }
            };
        }
        Ok(value)
    }

    fn attribute(&self, value: &Value, name: &str) -> Result<Value, Error> {
        let missing = || {
            Error::new(format!(
                "'{}' object has no attribute '{name}'",
                value.kind()
            ))
        };
        if name.starts_with("__") {
            return Err(Error::new(format!("the name {name} is not allowed")));
        }
        match value {
            Value::Module(module) => {
                builtins::of_module(*module, name).ok_or_else(|| Error::Name(name.to_owned()))
            }
            Value::Namespace(names) => self
                .around
                .look_up_in(names, name)?
                .ok_or_else(|| Error::Name(name.to_owned())),
            Value::Dict(dict) => {
                // The keys of a dictionary from YAML are also attributes.
                if let Some(method) = methods::of_dict(name) {
                    return Ok(Value::Method(Rc::new((value.clone(), method))));
                }
                dict.get_text(name)
                    .cloned()
                    .ok_or_else(|| Error::new(format!("the dictionary has no key '{name}'")))
            }
            _ => {
                let method = methods::of(value, name).ok_or_else(missing)?;
                Ok(Value::Method(Rc::new((value.clone(), method))))
            }
        }
    }

    fn index(&self, value: &Value, index: &Value) -> Result<Value, Error> {
        let place = |length: usize| {
            let i = index.as_int().ok_or_else(|| {
                Error::new(format!(
                    "{} indices must be integers, not {}",
                    value.kind(),
                    index.kind()
                ))
            })?;
            let from_start = if i < 0 { i + length as i128 } else { i };
            usize::try_from(from_start)
                .ok()
                .filter(|i| *i < length)
                .ok_or_else(|| Error::new(format!("{} index out of range", value.kind())))
        };
        match value {
            Value::List(items) | Value::Tuple(items) => Ok(items[place(items.len())?].clone()),
            Value::Text(text) => {
                self.around.budget().spend_bytes(text.len())?;
                let i = place(text.chars().count())?;
                Ok(Value::text(
                    text.chars().nth(i).map_or(String::new(), String::from),
                ))
            }
            Value::Dict(dict) => {
                self.around.budget().spend_on(index)?;
                let found = dict.get(index)?.cloned();
                found.ok_or_else(|| Error::new(format!("no key {}", super::brief(index))))
            }
            Value::Namespace(names) => match index {
                Value::Text(name) => self
                    .around
                    .look_up_in(names, name)?
                    .ok_or_else(|| Error::Name(name.to_string())),
                _ => Err(Error::new("a namespace is indexed by name")),
            },
            other => Err(Error::is_not(other, "subscriptable")),
        }
    }

    fn slice(&self, value: &Value, bounds: [Option<Value>; 3]) -> Result<Value, Error> {
        let bound = |bound: &Option<Value>| match bound {
            None | Some(Value::None) => Ok(None),
            Some(value) => value
                .as_int()
                .map(Some)
                .ok_or_else(|| Error::new("slice indices must be integers or None")),
        };
        let [start, stop, step] = [bound(&bounds[0])?, bound(&bounds[1])?, bound(&bounds[2])?];
        let step = step.unwrap_or(1);
        if step == 0 {
            return Err(Error::new("slice step cannot be zero"));
        }
        let chosen = |length: usize| -> Vec<usize> {
            let length = length as i128;
            let clamp = |bound: Option<i128>, default: i128, low: i128, high: i128| match bound {
                None => default,
                Some(i) if i < 0 => (i + length).clamp(low, high),
                Some(i) => i.clamp(low, high),
            };
            let (mut i, end) = if step > 0 {
                (clamp(start, 0, 0, length), clamp(stop, length, 0, length))
            } else {
                (
                    clamp(start, length - 1, -1, length - 1),
                    clamp(stop, -1, -1, length - 1),
                )
            };
            let mut places = Vec::new();
            while (step > 0 && i < end) || (step < 0 && i > end) {
                places.push(i as usize);
                i = i.saturating_add(step);
            }
            places
        };
        match value {
            Value::List(items) | Value::Tuple(items) => {
                self.around.budget().spend(items.len() as u64)?;
                let part: Vec<Value> = chosen(items.len())
                    .into_iter()
                    .map(|i| items[i].clone())
                    .collect();
                Ok(match value {
                    Value::List(_) => Value::list(part),
                    _ => Value::tuple(part),
                })
            }
            Value::Text(text) => {
                self.around.budget().spend_bytes(text.len())?;
                let chars: Vec<char> = text.chars().collect();
                let part: String = chosen(chars.len()).into_iter().map(|i| chars[i]).collect();
                Ok(Value::text(part))
            }
            other => Err(Error::is_not(other, "subscriptable")),
        }
    }

    fn call_lambda(&mut self, lambda: &Lambda, arguments: Arguments) -> Result<Value, Error> {
        if arguments.items.len() != lambda.parameters.len() || !arguments.named.is_empty() {
            return Err(Error::new(format!(
                "a lambda takes {} arguments, {} given",
                lambda.parameters.len(),
                arguments.items.len() + arguments.named.len()
            )));
        }
        let _level = self.around.budget().enter(1)?;
        self.around.budget().spend(lambda.bound.len() as u64)?;
        let bound = lambda.parameters.iter().cloned().zip(arguments.items);
        let inner = lambda.bound.iter().cloned().chain(bound).collect();
        let outer = std::mem::replace(&mut self.locals, inner);
        let value = self.value(&lambda.body);
        self.locals = outer;
        value
    }
}

impl Caller for Evaluator<'_> {
    fn around(&self) -> &dyn Surroundings {
        self.around
    }

    fn call(&mut self, function: &Value, arguments: Arguments) -> Result<Value, Error> {
        self.around.budget().spend(1)?;
        match function {
            Value::Function(name) => builtins::call(self, name, arguments),
            Value::Xacro(function) => self.around.call(*function, arguments),
            Value::Method(bound) => methods::call(self.around, &bound.0, bound.1, arguments),
            Value::Lambda(lambda) => self.call_lambda(lambda, arguments),
            other => Err(Error::is_not(other, "callable")),
        }
    }
}
