//! Bounds of the simulator's memory, where it is built for a page.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_FAMILY").as_deref() == Ok("wasm") {
        // As much stack as the command's own has: files of others are nested deeply. It lies first, so that overflowing it is a trap.
        println!("cargo:rustc-link-arg=-zstack-size=8388608");
        // A gibibyte at most, of the four that there could be: a page shares its machine.
        println!("cargo:rustc-link-arg=--max-memory=1073741824");
    }
}
