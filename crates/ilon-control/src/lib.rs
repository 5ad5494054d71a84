//! ilon-control
