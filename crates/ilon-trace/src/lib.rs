//! ilon-trace
