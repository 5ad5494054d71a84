//! Shipped files, a simulator with them loaded, and the playground.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use ilon_web::door::Door;
use serde_json::Value;

/// The folder of shipped files.
pub fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets")
}

/// A shipped file.
pub fn shipped(name: &str) -> String {
    std::fs::read_to_string(assets().join(name)).expect("a shipped file")
}

/// The names of the shipped scenarios.
pub fn scenarios() -> Vec<String> {
    let entries = std::fs::read_dir(assets().join("scenarios")).expect("scenarios");
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names
        .filter_map(|name| Some(name.strip_suffix(".toml")?.to_owned()))
        .collect();
    names.sort();
    names
}

/// The trace hashes of the shipped scenarios, computed here, by name.
pub fn hashes() -> &'static BTreeMap<String, String> {
    static HASHES: OnceLock<BTreeMap<String, String>> = OnceLock::new();
    HASHES.get_or_init(|| {
        let hash = |name: String| {
            let path = assets().join(format!("scenarios/{name}.toml"));
            let scenario = ilon_sim::Scenario::load(path).expect("a scenario");
            let run = ilon_sim::run(&scenario).expect("a run");
            (name, run.summary.trace_hash)
        };
        scenarios().into_iter().map(hash).collect()
    })
}

/// A simulator with the shipped files, at their paths in the playground.
pub fn door() -> Door {
    let mut door = Door::default();
    for folder in ["robots", "scenarios"] {
        for entry in std::fs::read_dir(assets().join(folder)).expect("shipped files") {
            let path = entry.expect("a file").path();
            let name = path.file_name().expect("a name").to_string_lossy();
            door.put(
                format!("/{folder}/{name}"),
                std::fs::read(&path).expect("a file"),
            );
        }
    }
    door
}

/// Sends a request: the JSON reply, and the bytes after it.
pub fn ask(door: &mut Door, request: &Value) -> (Value, Vec<u8>) {
    let reply = door.ask(request.to_string().as_bytes());
    let end = reply.iter().position(|byte| *byte == b'\n');
    let (said, bytes) = reply.split_at(end.unwrap_or(reply.len()));
    let said = serde_json::from_slice(said).expect("JSON");
    (said, bytes.get(1..).unwrap_or_default().to_vec())
}

/// The folder of a playground, if one was made.
pub fn playground() -> Option<PathBuf> {
    let folder = std::env::var_os("ILON_WEB").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: ILON_WEB names no playground; `.ci/web` makes one");
    }
    folder
}

/// Serves the files of a folder on this machine, as a static web server does; returns the URL.
pub fn serve(folder: PathBuf) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let place = listener.local_addr().expect("its own address");
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let folder = folder.clone();
            std::thread::spawn(move || hand_out(&stream, &folder));
        }
    });
    format!("http://{place}")
}

fn hand_out(mut stream: &TcpStream, folder: &Path) {
    let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
    let Some(asked) = lines.next() else { return };
    lines.take_while(|line| !line.is_empty()).for_each(drop);
    let name = asked.split(' ').nth(1).unwrap_or("/");
    let name = name.split(['?', '#']).next().unwrap_or("/");
    let name = if name == "/" { "/index.html" } else { name };
    let types = BTreeMap::from([
        ("html", "text/html"),
        ("js", "text/javascript"),
        ("wasm", "application/wasm"),
    ]);
    let ending = name.rsplit('.').next().unwrap_or_default();
    let kind = types.get(ending).unwrap_or(&"application/octet-stream");
    let file = std::fs::read(folder.join(&name[1..]));
    let (status, body) = file.map_or(("404 Not Found", Vec::new()), |body| ("200 OK", body));
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    );
    // A closed connection is no fault of the page.
    let _ = stream.write_all(head.as_bytes());
    let _ = stream.write_all(&body);
}
