//! The tests of `xacro-expand` from outside, one module per subject, in one program.

mod xacro;
