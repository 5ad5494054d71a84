//! A plant behind the C interface, and paths.

use std::ffi::{CStr, CString};
use std::path::{Path, PathBuf};
use std::ptr;

use ilon_c::plant::*;
use ilon_c::state::{IlonAbout, IlonState};
use ilon_c::status::{IlonStatus, ilon_last_error};

/// The root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// A shipped scenario.
pub fn scenario(name: &str) -> PathBuf {
    root().join("assets/scenarios").join(name)
}

/// The shared library of this build, in the folder of the tests.
pub fn library() -> PathBuf {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    std::env::current_exe()
        .unwrap()
        .with_file_name(format!("{DLL_PREFIX}ilon_c{DLL_SUFFIX}"))
}

/// The message of the last failed call of this thread.
pub fn last_error() -> String {
    // SAFETY: it is never null, and valid until the next failure of this thread.
    unsafe { CStr::from_ptr(ilon_last_error()) }
        .to_string_lossy()
        .into_owned()
}

pub fn must(status: IlonStatus) {
    assert_eq!(status, IlonStatus::Ok, "{}", last_error());
}

/// A plant that is freed on drop.
pub struct Owned(pub IlonPlant);

impl Owned {
    pub fn load(path: &Path) -> Self {
        let path = CString::new(path.to_str().unwrap()).unwrap();
        let mut plant = 0;
        // SAFETY: the text and the handle are locals.
        must(unsafe { ilon_plant_load(path.as_ptr(), &raw mut plant) });
        Self(plant)
    }

    pub fn about(&self) -> IlonAbout {
        let mut about = IlonAbout::default();
        // SAFETY: the struct is a local.
        must(unsafe { ilon_plant_about(self.0, &raw mut about) });
        about
    }

    pub fn state(&self) -> IlonState {
        let mut state = IlonState::default();
        // SAFETY: the struct is a local.
        must(unsafe { ilon_plant_state(self.0, &raw mut state) });
        state
    }

    pub fn advance(&self, rates_rad_s: &[f64], period_s: f64) -> IlonStatus {
        let (at, count) = (rates_rad_s.as_ptr(), rates_rad_s.len());
        // SAFETY: the array is a local.
        unsafe { ilon_plant_advance_rates(self.0, at, count, period_s) }
    }

    pub fn wrench(&self, force_n: [f64; 3], moment_n_m: [f64; 3]) -> IlonStatus {
        // SAFETY: the arrays are locals.
        unsafe { ilon_plant_set_wrench(self.0, force_n.as_ptr(), moment_n_m.as_ptr(), ptr::null()) }
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        must(ilon_plant_free(self.0));
    }
}
