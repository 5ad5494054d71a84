//! The header is what cbindgen generates from the crate.

use std::path::Path;

/// After a change: `ILON_WRITE_HEADER=1 cargo test -p ilon-c header`, and commit the header.
#[test]
fn the_header_is_what_cbindgen_makes() {
    let crate_dir = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(crate_dir.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in ["status", "state", "plant"] {
        builder = builder.with_src(crate_dir.join(format!("src/{file}.rs")));
    }
    let mut made = Vec::new();
    builder.generate().expect("it can be read").write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = crate_dir.join("include/ilon.h");
    if std::env::var_os("ILON_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == made,
        "include/ilon.h is out of date: ILON_WRITE_HEADER=1 writes it again"
    );
}
