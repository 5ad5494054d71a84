//! The playground: a folder of static files that any web server can serve, and that also opens from
//! disk.
//!
//! | file | is |
//! |---|---|
//! | `index.html` | the page with its style and scripts: those of the report, and additions of the playground |
//! | `examples.js` | the shipped robots and scenarios as text, and the first replies of the simulator |
//! | `ilon.wasm` | the simulator |
//! | `ilon.wasm.js` | the same for a page opened from disk, which may load only scripts |

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use ilon_report::page::{Head, Parts, Section, json_in_script, page};
use ilon_scene::embed;
use serde_json::json;

use crate::door::Door;

const STYLE: &str = include_str!("../web/playground.css");
const SCRIPT: [&str; 6] = [
    include_str!("../web/simulator.js"),
    include_str!("../web/settings.js"),
    include_str!("../web/link.js"),
    include_str!("../web/outcome.js"),
    include_str!("../web/drive.js"),
    include_str!("../web/playground.js"),
];
const WORKER: &str = include_str!("../web/worker.js");

/// Extensions of the files that are shipped as examples.
const ENDINGS: [&str; 3] = ["toml", "urdf", "csv"];

/// Writes the playground into a folder, which is created if missing. `assets` holds the shipped
/// `robots` and `scenarios`, and `wasm` is the simulator's file.
///
/// # Errors
/// If a file cannot be read or written.
pub fn write(folder: &Path, assets: &Path, wasm: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let wasm = fs::read(wasm)?;
    fs::write(folder.join("index.html"), html())?;
    fs::write(folder.join("examples.js"), examples(assets)?)?;
    let carried = format!("window.ilonWasm = '{}';\n", BASE64_STANDARD.encode(&wasm));
    fs::write(folder.join("ilon.wasm.js"), carried)?;
    fs::write(folder.join("ilon.wasm"), wasm)
}

/// The page.
pub fn html() -> String {
    let head = Head {
        kind: "playground",
        title: "What does this robot really do?".to_owned(),
        facts: Vec::new(),
        lead: "<p class=\"lead\">Mecanum and omni robots, simulated down to every roller, on this page alone: no server, no account.</p>"
            .to_owned(),
    };
    let section = |id, title, body: &str| Section {
        id,
        title,
        lead: String::new(),
        body: body.to_owned(),
    };
    let result = include_str!("../web/result.html").replace("{{how}}", embed::HOW_TO_DRIVE);
    let sections = [
        section("choose", "Choose", include_str!("../web/setup.html")),
        section("result", "Result", &result),
    ];
    // A JSON string is also a JavaScript string. The examples are a separate script, which runs
    // once the page is parsed.
    let worker = json_in_script(&serde_json::Value::from(WORKER).to_string());
    let script = format!(
        "addEventListener('DOMContentLoaded', () => {{\n'use strict';\nconst WORKER = {worker};\n{}}});\n",
        SCRIPT.concat()
    );
    let footer = "<p>ilon is free software. The command, in the archives of its releases and by <code>cargo install --path crates/doors/ilon</code> from \
                  its sources, runs the same scenarios to the same bits.</p>";
    let parts = Parts {
        styles: &[embed::STYLE, embed::DRIVE_STYLE, STYLE],
        before: &[&embed::driving_script(), &script],
    };
    let page = page(&head, &sections, footer, &parts);
    // The browser loads them while it shows the page.
    page.replace(
        "</head>",
        "<meta name=\"description\" content=\"Simulate omnidirectional robots down to their rollers, in the browser\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<script src=\"examples.js\" defer></script>\n</head>",
    )
}

/// The scenario that is shown first.
const FIRST: &str = "/scenarios/mecanum4_lateral.toml";

/// The shipped files as a script. It sets `ilonExamples`, a text for each path, and `ilonFirst`,
/// the replies for schemas and the first scenario, so that a page is usable before the simulator
/// has loaded.
fn examples(assets: &Path) -> io::Result<String> {
    let mut files = BTreeMap::new();
    for folder in ["robots", "scenarios"] {
        for entry in fs::read_dir(assets.join(folder))? {
            let path: PathBuf = entry?.path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            let name = path.file_name().and_then(|name| name.to_str());
            if let (Some(name), Some(ending)) = (name, ending)
                && ENDINGS.contains(&ending)
            {
                files.insert(format!("/{folder}/{name}"), fs::read_to_string(&path)?);
            }
        }
    }
    let mut door = Door::default();
    for (path, text) in &files {
        door.put(path.clone(), text.clone().into_bytes());
    }
    let mut ask = |request: serde_json::Value| {
        let said = door.ask(request.to_string().as_bytes());
        let said: serde_json::Value = serde_json::from_slice(&said)?;
        let ok = said.get("ok").filter(|ok| !ok.is_null()).cloned();
        ok.ok_or_else(|| io::Error::other(said["fault"]["message"].to_string()))
    };
    let schemas = ask(json!({ "do": "schemas" }))?;
    let opened = ask(json!({ "do": "open", "scenario": FIRST, "settings": [] }))?;
    let first = json!({ "schemas": schemas, "opened": opened });
    Ok(format!(
        "window.ilonExamples = {};\nwindow.ilonFirst = {};\n",
        json_in_script(&serde_json::to_string(&files)?),
        json_in_script(&first.to_string())
    ))
}
