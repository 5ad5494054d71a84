//! ilon
