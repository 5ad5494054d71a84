//! A headless Chromium that a test controls, by its DevTools protocol.
//!
//! Needs Chromium, named by `ILON_CHROMIUM` or found as `chromium`; accessibility is judged by
//! axe-core, whose script `ILON_AXE` names. Without one of them the tests print what they skipped.

#![allow(dead_code)] // Each test binary uses a part.

use base64::prelude::{BASE64_STANDARD, Engine};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Timeout of the slowest answer, with a build on the same machine; chosen.
const PATIENCE: Duration = Duration::from_secs(120);

/// Chromium's own messages without graphics hardware.
const OF_THE_BROWSER: [&str; 2] = ["GL Driver Message", "software WebGL"];

/// A browser with one empty page; it ends on drop.
pub struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: String,
    calls: u64,
    /// The console messages so far.
    pub console: Vec<String>,
    loaded: bool,
    folder: tempfile::TempDir,
}

impl Browser {
    /// Starts a browser; `None` without Chromium.
    pub fn start() -> Option<Self> {
        let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
        let folder = tempfile::tempdir().expect("a folder");
        let child = Command::new(&named)
            .args([
                "--headless",
                "--no-sandbox",
                "--no-first-run",
                "--disable-quic",
            ])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ])
            .args([
                "--enable-unsafe-swiftshader",
                "--hide-scrollbars",
                "--remote-debugging-port=0",
            ])
            .arg(format!("--user-data-dir={}", folder.path().display()))
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut child) = child else {
            eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
            return None;
        };
        let Some(socket) = connected(folder.path(), &mut child) else {
            eprintln!("skipped: `{named}` does not start");
            let _ = child.kill();
            return None;
        };
        let mut browser = Self {
            child,
            socket,
            session: String::new(),
            calls: 0,
            console: Vec::new(),
            loaded: false,
            folder,
        };
        let targets = browser.call("Target.getTargets", json!({}));
        let infos = targets["targetInfos"].as_array().expect("targets");
        let page = infos.iter().find(|info| info["type"] == "page");
        let id = page.expect("a page")["targetId"].clone();
        let attached = browser.call(
            "Target.attachToTarget",
            json!({ "targetId": id, "flatten": true }),
        );
        browser.session = attached["sessionId"]
            .as_str()
            .expect("a session")
            .to_owned();
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Calls a method of the protocol and returns its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let id = self.calls;
        let mut message = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = self.session.clone().into();
        }
        self.socket
            .send(Message::text(message.to_string()))
            .expect("the browser listens");
        loop {
            let answer = self.next();
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    /// The next message; console messages are kept.
    fn next(&mut self) -> Value {
        let text = match self.socket.read().expect("the browser answers in time") {
            Message::Text(text) => text.to_string(),
            _ => return Value::Null,
        };
        let message: Value = serde_json::from_str(&text).expect("JSON");
        let parameters = &message["params"];
        let said = match message["method"].as_str() {
            Some("Page.loadEventFired") => {
                self.loaded = true;
                None
            }
            Some("Runtime.consoleAPICalled") => Some(&parameters["args"]),
            Some("Runtime.exceptionThrown") => Some(&parameters["exceptionDetails"]),
            Some("Log.entryAdded") => Some(&parameters["entry"]),
            _ => None,
        };
        if let Some(said) = said.map(Value::to_string)
            && !OF_THE_BROWSER.iter().any(|own| said.contains(own))
        {
            self.console.push(said);
        }
        message
    }

    /// Sets the window's inner size, in pixels.
    pub fn size(&mut self, width: u32, height: u32) {
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// Sets the emulated medium: `print` or `screen`.
    pub fn media(&mut self, media: &str) {
        self.call("Emulation.setEmulatedMedia", json!({ "media": media }));
    }

    /// Opens a page and waits until it is loaded.
    pub fn open(&mut self, page: &Path) {
        self.loaded = false;
        let page = page.canonicalize().expect("a page");
        let url = format!("file://{}", page.display());
        self.call("Page.navigate", json!({ "url": url }));
        while !self.loaded {
            self.next();
        }
    }

    /// The value of a JavaScript expression; promises are awaited.
    pub fn eval(&mut self, expression: &str) -> Value {
        let asked =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let answer = self.call("Runtime.evaluate", asked);
        let fault = &answer["exceptionDetails"];
        assert!(fault.is_null(), "{fault:#}");
        answer["result"]["value"].clone()
    }

    /// Prints the page with print events. Returns the PDF.
    pub fn print(&mut self) -> Vec<u8> {
        let asked = json!({ "preferCSSPageSize": true, "paperWidth": 8.27, "paperHeight": 11.69 });
        let pdf = self.call("Page.printToPDF", asked);
        let data = pdf["data"].as_str().expect("a PDF");
        BASE64_STANDARD.decode(data).expect("base64")
    }

    /// The serious and critical faults that axe-core finds; `None` without axe-core.
    pub fn axe(&mut self) -> Option<Vec<String>> {
        let Some(script) = std::env::var_os("ILON_AXE") else {
            eprintln!("skipped: ILON_AXE names no axe.min.js");
            return None;
        };
        let script = std::fs::read_to_string(script).expect("ILON_AXE names a file");
        self.eval(&format!("{script}; null"));
        let found = self.eval(
            "axe.run(document, { resultTypes: ['violations'] }).then(({ violations }) => violations
               .filter(({ impact }) => impact === 'serious' || impact === 'critical')
               .map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 3).map((n) => n.html.slice(0, 160)).join(' | ')}`))",
        );
        let faults = found.as_array().expect("a list");
        Some(
            faults
                .iter()
                .map(|fault| fault.as_str().unwrap_or_default().to_owned())
                .collect(),
        )
    }

    /// A folder for files of the test.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A connection to a browser that was just started: its output contains the address.
fn connected(folder: &Path, child: &mut Child) -> Option<WebSocket<TcpStream>> {
    let until = Instant::now() + PATIENCE;
    loop {
        let written =
            std::fs::read_to_string(folder.join("DevToolsActivePort")).unwrap_or_default();
        if let Some((port, path)) = written.trim().split_once('\n') {
            let stream = TcpStream::connect(format!("127.0.0.1:{port}")).ok()?;
            stream.set_read_timeout(Some(PATIENCE)).ok()?;
            let url = format!("ws://127.0.0.1:{port}{path}");
            let (mut socket, _) = tungstenite::client(url, stream).ok()?;
            // A page's pixels and a PDF are messages of several megabytes.
            socket.set_config(|config| config.max_message_size = None);
            return Some(socket);
        }
        if Instant::now() > until || child.try_wait().ok()?.is_some() {
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
