//! The local server: the page, and one WebSocket per open page.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use tungstenite::handshake::server::NoCallback;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket};

use crate::LiveError;
use crate::mailbox::{Mailbox, locked};
use crate::observer::{Observer, Status};
use crate::page;
use crate::session::Session;

/// Period of frames in real time, whatever the pace of the simulation: the refresh rate of a
/// screen.
const FRAMES: Duration = Duration::from_nanos(16_666_667);
/// Period of figures, slow enough to read.
const FIGURES: Duration = Duration::from_millis(100);

/// Largest number of connections.
const MOST_CLIENTS: usize = 64;
/// Longest head of a request, in bytes, and its timeout.
const HEAD_BYTES: usize = 8 << 10;
const HEAD_TIME: Duration = Duration::from_secs(5);
/// Longest message of a page, in bytes.
const MESSAGE_BYTES: usize = 4 << 10;
/// Messages accepted from a page before it is updated.
const AT_ONCE: usize = 64;
/// Time to wait for a client's message before checking for updates.
const LOOK: Duration = Duration::from_millis(5);
/// A client that does not read for this long is disconnected.
const PATIENCE: Duration = Duration::from_secs(2);
/// Smallest time between notes to a page.
const SAY_EVERY: Duration = Duration::from_millis(200);

/// Shows a session to pages, and receives their commands. It ends with the last of its owners.
#[derive(Debug)]
pub struct Server {
    port: u16,
    shared: Arc<Shared>,
    frame_due: Instant,
    figures_due: Instant,
}

/// State shared by all connections: only the newest of each kind.
#[derive(Debug, Default)]
struct Shared {
    desk: Mailbox,
    shown: Mutex<Outgoing>,
    clients: AtomicUsize,
    watching: AtomicUsize,
    ended: AtomicBool,
}

#[derive(Debug, Default)]
struct Outgoing {
    frame: Newest,
    figures: Newest,
    note: Newest,
}

/// A value sent once to each client, unless replaced by a newer one before.
#[derive(Clone, Debug, Default)]
struct Newest {
    number: u64,
    bytes: Arc<Vec<u8>>,
}

impl Newest {
    fn put(&mut self, bytes: Vec<u8>) {
        self.number += 1;
        self.bytes = Arc::new(bytes);
    }
}

impl Server {
    /// Listens on a port of the loopback interface, 0 for any that is free.
    ///
    /// # Errors
    /// [`LiveError::Listen`], [`LiveError::Page`].
    pub fn start(port: u16, session: &Session, desk: &Mailbox) -> Result<Self, LiveError> {
        let fault = |reason| LiveError::Listen { port, reason };
        let page: Arc<str> = page::html(session)?.into();
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        let port = listener.local_addr().map_err(fault)?.port();
        let shared = Arc::new(Shared {
            desk: desk.clone(),
            ..Shared::default()
        });
        let of_thread = Arc::clone(&shared);
        std::thread::spawn(move || listen(&listener, port, &page, &of_thread));
        Ok(Self {
            port,
            shared,
            frame_due: Instant::now(),
            figures_due: Instant::now(),
        })
    }

    /// The page's URL.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Whether any client is connected.
    pub fn has_clients(&self) -> bool {
        self.shared.watching.load(Ordering::Relaxed) > 0
    }
}

impl Observer for Server {
    fn look(&mut self, session: &Session, status: Status<'_>) {
        let now = Instant::now();
        if now >= self.frame_due && self.has_clients() {
            self.frame_due = now + FRAMES;
            let frame = session.frame().bytes();
            locked(&self.shared.shown).frame.put(frame);
        }
        if now >= self.figures_due {
            self.figures_due = now + FIGURES;
            let mut json = serde_json::json!({ "figures": session.figures(status.controls) });
            json["figures"]["real_time_factor"] = status.real_time_factor.into();
            let bytes = json.to_string().into_bytes();
            locked(&self.shared.shown).figures.put(bytes);
        }
    }

    fn say(&mut self, note: &str) {
        let json = serde_json::json!({ "note": note });
        let bytes = json.to_string().into_bytes();
        locked(&self.shared.shown).note.put(bytes);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Relaxed);
        // Wakes the listening thread.
        let _ = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port));
    }
}

fn listen(listener: &TcpListener, port: u16, page: &Arc<str>, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        if shared.ended.load(Ordering::Relaxed) {
            return;
        }
        let Ok(stream) = stream else { continue };
        if shared.clients.fetch_add(1, Ordering::Relaxed) >= MOST_CLIENTS {
            shared.clients.fetch_sub(1, Ordering::Relaxed);
            let _ = refuse(stream, "503 Service Unavailable", "too many pages look on");
            continue;
        }
        let (page, of_thread) = (Arc::clone(page), Arc::clone(shared));
        let spawned = std::thread::Builder::new().spawn(move || {
            // An error of one client only ends its connection.
            let _ = serve(stream, port, &page, &of_thread);
            of_thread.clients.fetch_sub(1, Ordering::Relaxed);
        });
        if spawned.is_err() {
            shared.clients.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

/// The head of a request.
struct Head {
    method: String,
    path: String,
    host: Option<String>,
    origin: Option<String>,
    upgrade: bool,
}

fn serve(stream: TcpStream, port: u16, page: &str, shared: &Shared) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let Some(head) = head(&stream)? else {
        return refuse(stream, "400 Bad Request", "not understood");
    };
    let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}"));
    // A page of another site whose name resolves to this address would use that name as the host.
    if !head.host.is_some_and(|host| names.contains(&host)) {
        let why = "this server answers to its own address alone";
        return refuse(stream, "403 Forbidden", why);
    }
    let own = |origin: &str| names.iter().any(|name| origin == format!("http://{name}"));
    if head.origin.as_deref().is_some_and(|origin| !own(origin)) {
        return refuse(
            stream,
            "403 Forbidden",
            "pages of other origins may not drive",
        );
    }
    match (head.method.as_str(), head.path.as_str(), head.upgrade) {
        ("GET", "/live", true) => {
            let config = WebSocketConfig::default()
                .max_message_size(Some(MESSAGE_BYTES))
                .max_frame_size(Some(MESSAGE_BYTES))
                .max_write_buffer_size(1 << 20);
            stream.set_read_timeout(Some(HEAD_TIME))?;
            let Ok(socket) = tungstenite::accept_hdr_with_config(stream, NoCallback, Some(config))
            else {
                return Ok(());
            };
            shared.watching.fetch_add(1, Ordering::Relaxed);
            let ended = converse(socket, shared);
            shared.watching.fetch_sub(1, Ordering::Relaxed);
            ended
        }
        ("GET", "/", false) => answer(stream, "200 OK", "text/html; charset=utf-8", page),
        _ => refuse(stream, "404 Not Found", "there is nothing here"),
    }
}

/// Peeks at the head of a request: the WebSocket's handshake reads it again. `None` if invalid.
fn head(stream: &TcpStream) -> std::io::Result<Option<Head>> {
    let deadline = Instant::now() + HEAD_TIME;
    let mut bytes = vec![0; HEAD_BYTES];
    stream.set_read_timeout(Some(HEAD_TIME))?;
    let mut seen = 0;
    let text = loop {
        let read = stream.peek(&mut bytes)?;
        let text = String::from_utf8_lossy(&bytes[..read]);
        if let Some((head, _)) = text.split_once("\r\n\r\n") {
            break head.to_owned();
        }
        if read == 0 || read == HEAD_BYTES || Instant::now() > deadline {
            return Ok(None);
        }
        // Peeking returns the same bytes immediately, so wait for the rest.
        if read == seen {
            std::thread::sleep(LOOK);
        }
        seen = read;
    };
    let mut lines = text.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (Some(method), Some(path)) = (words.next(), words.next()) else {
        return Ok(None);
    };
    let mut head = Head {
        method: method.to_owned(),
        path: path.to_owned(),
        host: None,
        origin: None,
        upgrade: false,
    };
    for (name, value) in lines.filter_map(|line| line.split_once(':')) {
        let value = value.trim().to_ascii_lowercase();
        // Of two that say where a request comes from, one is not true.
        let before = match name.to_ascii_lowercase().as_str() {
            "host" => head.host.replace(value),
            "origin" => head.origin.replace(value),
            "upgrade" => {
                head.upgrade = value == "websocket";
                None
            }
            _ => None,
        };
        if before.is_some() {
            return Ok(None);
        }
    }
    Ok(Some(head))
}

fn refuse(stream: TcpStream, status: &str, why: &str) -> std::io::Result<()> {
    answer(stream, status, "text/plain", why)
}

fn answer(mut stream: TcpStream, status: &str, kind: &str, body: &str) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nX-Frame-Options: DENY\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    // Closing with bytes unread resets the connection, and the client may lose the answer.
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(LOOK))?;
    let mut unread = vec![0; HEAD_BYTES];
    // A client that goes on sending is not waited for.
    for _ in 0..4 {
        if stream.read(&mut unread).unwrap_or(0) == 0 {
            break;
        }
    }
    Ok(())
}

/// Receives and sends until the client disconnects.
fn converse(mut socket: WebSocket<TcpStream>, shared: &Shared) -> std::io::Result<()> {
    socket.get_ref().set_read_timeout(Some(LOOK))?;
    // The numbers of this page's newest frame, figures and note.
    let mut has = [0; 3];
    let mut said: Option<String> = None;
    let mut may_say = Instant::now();
    loop {
        for _ in 0..AT_ONCE {
            match socket.read() {
                Ok(Message::Text(text)) => {
                    // Only the last note is sent, so that many commands do not cause many notes.
                    said = shared.desk.take(&text).or(said);
                }
                Ok(Message::Close(_)) => return Ok(()),
                Ok(_) => {}
                Err(tungstenite::Error::Io(error))
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    break;
                }
                Err(_) => return Ok(()),
            }
        }
        if shared.ended.load(Ordering::Relaxed) {
            let _ = socket.close(None);
            return Ok(());
        }
        let newest = {
            let shown = locked(&shared.shown);
            [&shown.frame, &shown.figures, &shown.note].map(Newest::clone)
        };
        let mut messages = Vec::new();
        for (part, (newest, has)) in newest.iter().zip(&mut has).enumerate() {
            if std::mem::replace(has, newest.number) != newest.number {
                messages.push(match part {
                    0 => Message::binary(newest.bytes.as_ref().clone()),
                    _ => Message::text(String::from_utf8_lossy(&newest.bytes).into_owned()),
                });
            }
        }
        if Instant::now() >= may_say
            && let Some(said) = said.take()
        {
            may_say = Instant::now() + SAY_EVERY;
            messages.push(Message::text(
                serde_json::json!({ "note": said }).to_string(),
            ));
        }
        for message in messages {
            if socket.send(message).is_err() {
                return Ok(());
            }
        }
    }
}
