//! Python values as properties return them, with their types in the stubs: pyo3 derives the types of
//! Rust's values alone. The names are those that `.ci/stubs` declares.

use std::convert::Infallible;

use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::type_hint_identifier;

macro_rules! typed {
    ($($(#[$about:meta])* $class:ident is $name:literal;)*) => {
        $(
            $(#[$about])*
            pub struct $class<'py>(Bound<'py, PyAny>);

            impl<'py, T> From<Bound<'py, T>> for $class<'py> {
                fn from(value: Bound<'py, T>) -> Self {
                    Self(value.into_any())
                }
            }

            impl<'py> IntoPyObject<'py> for $class<'py> {
                type Target = PyAny;
                type Output = Bound<'py, PyAny>;
                type Error = Infallible;
                const OUTPUT_TYPE: PyStaticExpr = type_hint_identifier!("builtins", $name);

                fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Infallible> {
                    Ok(self.0)
                }
            }
        )*
    };
}

typed! {
    /// A numpy array of `f64`.
    Floats is "_Floats";
    /// A numpy array of `f32`.
    Singles is "_Singles";
    /// A column of a study: an array of numbers, or a list of texts.
    Column is "_Column";
    /// What JSON holds as an object.
    Dict is "_Dict";
}
