//! Memory limits of the simulator in a page.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_FAMILY").as_deref() == Ok("wasm") {
        // As much stack as the command's, for deeply nested files. The stack is placed first in
        // memory, so that its overflow traps.
        println!("cargo:rustc-link-arg=-zstack-size=8388608");
        // At most 1 GiB of the possible four, as a page shares its machine; chosen.
        println!("cargo:rustc-link-arg=--max-memory=1073741824");
    }
}
