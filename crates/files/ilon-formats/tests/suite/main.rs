//! The tests of `ilon-formats` from outside, one module per subject, in one program.

mod as_built;
mod asked;
mod assets;
mod assets_load;
mod clues;
mod collection;
mod common;
mod described;
mod faults;
mod formats;
mod inertias;
mod joints_of_people;
mod level;
mod linkage;
mod links;
mod one_answer;
mod rollers_as_made;
mod round_trip;
mod scale;
mod sides;
mod standing;
mod strangers;
mod traits;
mod tyres;
mod tyres_in_short;
mod visual_meshes;
