//! The tests of `xacro-expand` from outside, one module for each subject, in one program.

mod xacro;
