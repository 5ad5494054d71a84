//! ilon-world
