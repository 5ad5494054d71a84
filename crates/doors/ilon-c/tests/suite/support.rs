//! A plant behind the border.

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

/// A scenario that is shipped.
pub fn scenario(name: &str) -> PathBuf {
    root().join("assets/scenarios").join(name)
}

/// The shared library of this build, which lies beside the tests.
pub fn library() -> PathBuf {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    std::env::current_exe()
        .unwrap()
        .with_file_name(format!("{DLL_PREFIX}ilon_c{DLL_SUFFIX}"))
}

/// What the last call of this thread that failed said.
pub fn last_error() -> String {
    // SAFETY: it is never null, and stays until the next failure of this thread.
    unsafe { CStr::from_ptr(ilon_last_error()) }
        .to_string_lossy()
        .into_owned()
}

pub fn must(status: IlonStatus) {
    assert_eq!(status, IlonStatus::Ok, "{}", last_error());
}

/// A plant that ends with its owner.
pub struct Owned(pub IlonPlant);

impl Owned {
    pub fn load(path: &Path) -> Self {
        let path = CString::new(path.to_str().unwrap()).unwrap();
        let mut plant = 0;
        // SAFETY: text and handle live here.
        must(unsafe { ilon_plant_load(path.as_ptr(), &raw mut plant) });
        Self(plant)
    }

    pub fn about(&self) -> IlonAbout {
        let mut about = IlonAbout::default();
        // SAFETY: it lives here.
        must(unsafe { ilon_plant_about(self.0, &raw mut about) });
        about
    }

    pub fn state(&self) -> IlonState {
        let mut state = IlonState::default();
        // SAFETY: it lives here.
        must(unsafe { ilon_plant_state(self.0, &raw mut state) });
        state
    }

    pub fn advance(&self, rates_rad_s: &[f64], period_s: f64) -> IlonStatus {
        let (at, count) = (rates_rad_s.as_ptr(), rates_rad_s.len());
        // SAFETY: the array lives here.
        unsafe { ilon_plant_advance_rates(self.0, at, count, period_s) }
    }

    pub fn wrench(&self, force_n: [f64; 3], moment_n_m: [f64; 3]) -> IlonStatus {
        // SAFETY: the arrays live here.
        unsafe { ilon_plant_set_wrench(self.0, force_n.as_ptr(), moment_n_m.as_ptr(), ptr::null()) }
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        must(ilon_plant_free(self.0));
    }
}
