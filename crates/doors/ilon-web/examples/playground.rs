//! Writes the playground: `cargo run -p ilon-web --example playground -- ilon_web.wasm FOLDER`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [wasm, folder] = arguments.as_slice() else {
        let usage = "name the simulator's file and the folder to write to";
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, usage));
    };
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets");
    ilon_web::playground::write(Path::new(folder), &assets, Path::new(wasm))
}
