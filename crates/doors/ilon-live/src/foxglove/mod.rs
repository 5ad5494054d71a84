//! A server for Foxglove and Lichtblick, with their WebSocket protocol `foxglove.sdk.v1`.
//!
//! The topics are those of a bag ([`ilon_messages::topics`]), in the same encoding, so that layouts
//! work for both. The Teleop panel drives: `geometry_msgs/Twist` or `TwistStamped` on `/cmd_vel`,
//! as JSON or CDR; `std_msgs/Float64MultiArray` on `/wheel_commands` drives the wheels. Parameters,
//! such as the floor's friction, can be changed while the robot drives.
//!
//! Times restart with every return to the start, unlike those of the ROS 2 node, because the
//! protocol can announce this; the viewer's playback controls play, pause, set the speed, and put
//! the robot back to its start.
//!
//! The server is bound to the loopback interface. It does not check origins, because the viewers'
//! page is not of this machine.

mod parameters;
mod playback;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use foxglove::websocket::{
    Capability, ChannelView, Client, ClientChannel, PlaybackControlRequest, PlaybackState,
    ServerListener, Status as Said,
};
use foxglove::{
    ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServerHandle,
};
use ilon_messages::bag::{Durability, Qos};
use ilon_messages::geometry_msgs::{Twist, TwistStamped};
use ilon_messages::topics::{Outlet, RunTopics};
use ilon_messages::{CdrError, Message};
use serde::Deserialize;

use crate::commands::{self, Commanded, Received};
use crate::mailbox::{Mailbox, locked};
use crate::observer::{Observer, Status};
use crate::parameters::Parameters;
use crate::session::{Row, Session};
use crate::throttle::Throttle;
use crate::topics::live_topics;
use parameters::Panel;
use playback::Playback;

/// Queue length of a client, in messages; when it is full, the oldest are dropped. Except for
/// markers a message is a few hundred bytes.
const BACKLOG: usize = 512;
/// Polling period of parameters and time.
const LOOK: Duration = Duration::from_millis(50);

/// Reasons why the server cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FoxgloveError {
    /// It cannot listen on its port.
    #[error("cannot listen on 127.0.0.1:{port}: {reason}")]
    Listen {
        /// The port.
        port: u16,
        /// The server's error.
        reason: String,
    },
    /// A topic cannot be advertised.
    #[error("cannot offer {topic}: {reason}")]
    Topic {
        /// The topic.
        topic: String,
        /// The reason.
        reason: String,
    },
}

/// A server that shows a session and accepts commands for it. It ends when it is dropped.
#[derive(Debug)]
pub struct Foxglove {
    handle: Option<WebSocketServerHandle>,
    channels: Channels,
    topics: RunTopics,
    panel: Arc<Panel>,
    playback: Arc<Playback>,
    desk: Mailbox,
    /// Start of this drive, in the session's time; `None` before its first row.
    began_s: Option<f64>,
    look_due: Instant,
}

impl Foxglove {
    /// Listens on a port of the loopback interface, 0 for any that is free.
    ///
    /// # Errors
    /// [`FoxgloveError`].
    pub fn start(port: u16, session: &Session, desk: &Mailbox) -> Result<Self, FoxgloveError> {
        let topics = live_topics(session, false);
        let latched = Arc::new(Latched::default());
        let mut channels = Channels {
            context: Context::new(),
            by_topic: HashMap::new(),
            latched: Arc::clone(&latched),
            bytes: Vec::new(),
        };
        topics.declare(&mut channels)?;
        topics.latched(&mut channels, 0.0)?;
        let playback = Arc::new(Playback::new(desk.clone()));
        let panel = Arc::new(Panel::new(desk.clone(), Parameters::of(session, desk)));
        let listener = Listener {
            desk: desk.clone(),
            robot: Commanded::of(session.robot()),
            latched,
            playback: Arc::clone(&playback),
            throttle: Mutex::default(),
        };
        let handle = channels
            .context
            .websocket_server()
            .name(session.name())
            .bind("127.0.0.1", port)
            .capabilities([
                Capability::ClientPublish,
                Capability::Parameters,
                Capability::Time,
            ])
            .playback_time_range(0, (session.duration_s() * 1e9) as u64)
            .supported_encodings(["json", "cdr"])
            .message_backlog_size(BACKLOG)
            .listener(Arc::new(listener))
            .parameter_handler(Arc::clone(&panel) as _)
            .start_blocking()
            .map_err(|reason| FoxgloveError::Listen {
                port,
                reason: reason.to_string(),
            })?;
        Ok(Self {
            handle: Some(handle),
            channels,
            topics,
            panel,
            playback,
            desk: desk.clone(),
            began_s: None,
            look_due: Instant::now(),
        })
    }

    /// The server's URL.
    pub fn url(&self) -> String {
        let port = self.handle.as_ref().map_or(0, WebSocketServerHandle::port);
        format!("ws://127.0.0.1:{port}")
    }

    /// The number of clients.
    pub fn client_count(&self) -> usize {
        self.handle
            .as_ref()
            .map_or(0, WebSocketServerHandle::client_count)
    }
}

impl Observer for Foxglove {
    fn row(&mut self, row: Row<'_>) {
        let began_s = *self.began_s.get_or_insert(row.record.t_s);
        if self.client_count() == 0 {
            return;
        }
        let mut record = *row.record;
        record.t_s -= began_s;
        let outlet = &mut self.channels;
        let sent = (self.topics).row(&record, row.wheels, row.rollers_rad, outlet);
        if let Err(fault) = sent {
            self.desk.say(fault.to_string());
        }
    }

    fn look(&mut self, session: &Session, status: Status<'_>) {
        let Some(handle) = self
            .handle
            .as_ref()
            .filter(|_| Instant::now() >= self.look_due)
        else {
            return;
        };
        self.look_due = Instant::now() + LOOK;
        let now_ns = self.playback.set_time(session.drive_time_s());
        if let Some(state) = self.playback.changed(status.controls) {
            handle.broadcast_playback_state(state);
        }
        handle.broadcast_time(now_ns.max(1));
        let changed = self.panel.changed(status.controls);
        if !changed.is_empty() {
            handle.publish_parameter_values(changed);
        }
    }

    fn restarted(&mut self, session: &Session) {
        self.topics = live_topics(session, false);
        self.began_s = None;
        self.playback.restarted();
        self.look_due = Instant::now();
    }

    fn say(&mut self, note: &str) {
        if let Some(handle) = &self.handle {
            handle.publish_status(Said::warning(note));
        }
    }
}

impl Drop for Foxglove {
    fn drop(&mut self) {
        if let Some(handle) = self.handle.take() {
            handle.stop().detach_all();
        }
    }
}

/// Latched messages, for clients that connect later.
#[derive(Debug, Default)]
struct Latched(Mutex<HashMap<String, Kept>>);

#[derive(Clone, Debug)]
struct Kept {
    channel: Arc<RawChannel>,
    bytes: Arc<[u8]>,
    time_ns: u64,
}

/// Channels by topic.
struct Channels {
    context: Arc<Context>,
    by_topic: HashMap<String, (Arc<RawChannel>, Durability)>,
    latched: Arc<Latched>,
    bytes: Vec<u8>,
}

impl std::fmt::Debug for Channels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.by_topic.keys()).finish()
    }
}

impl Outlet for Channels {
    type Error = FoxgloveError;

    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), FoxgloveError> {
        let schema = Schema::new(M::TYPE_NAME, "ros2msg", M::definition().into_bytes());
        let channel = ChannelBuilder::new(topic)
            .context(&self.context)
            .message_encoding("cdr")
            .schema(schema)
            .build_raw()
            .map_err(|reason| FoxgloveError::Topic {
                topic: topic.to_owned(),
                reason: reason.to_string(),
            })?;
        self.by_topic
            .insert(topic.to_owned(), (channel, qos.durability));
        Ok(())
    }

    fn send<M: Message>(
        &mut self,
        topic: &str,
        message: &M,
        time_ns: u64,
    ) -> Result<(), FoxgloveError> {
        let Some((channel, durability)) = self.by_topic.get(topic) else {
            return Ok(());
        };
        let is_latched = *durability == Durability::TransientLocal;
        if !is_latched && !channel.has_sinks() {
            return Ok(());
        }
        message
            .encode_into(&mut self.bytes)
            .map_err(|reason: CdrError| FoxgloveError::Topic {
                topic: topic.to_owned(),
                reason: reason.to_string(),
            })?;
        let meta = PartialMetadata {
            log_time: Some(time_ns),
        };
        channel.log_with_meta(&self.bytes, meta);
        if is_latched {
            let kept = Kept {
                channel: Arc::clone(channel),
                bytes: self.bytes.as_slice().into(),
                time_ns,
            };
            locked(&self.latched.0).insert(topic.to_owned(), kept);
        }
        Ok(())
    }
}

/// Receives messages of clients.
struct Listener {
    desk: Mailbox,
    robot: Commanded,
    latched: Arc<Latched>,
    playback: Arc<Playback>,
    throttle: Mutex<Throttle>,
}

impl ServerListener for Listener {
    fn on_client_connect(&self) {
        self.playback.forget_told();
    }

    fn on_playback_control_request(
        &self,
        request: PlaybackControlRequest,
    ) -> Option<PlaybackState> {
        let (state, note) = self.playback.take(&request);
        if let Some(note) = note {
            self.desk.say(note);
        }
        Some(state)
    }

    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let kept = locked(&self.latched.0).get(channel.topic()).cloned();
        if let Some(kept) = kept {
            let meta = PartialMetadata {
                log_time: Some(kept.time_ns),
            };
            kept.channel
                .log_with_meta_to_sink(&kept.bytes, meta, client.sink_id());
        }
    }

    fn on_message_data(&self, client: Client, channel: &ClientChannel, payload: &[u8]) {
        let heard = heard(channel, payload, &self.robot);
        let note = heard.taken(&self.desk);
        let Some(note) = note else { return };
        // The sender receives each note, others a throttled selection.
        client.send_status(Said::warning(note.clone()));
        if let Some(note) = locked(&self.throttle).pass(note, Instant::now()) {
            self.desk.say(note);
        }
    }
}

/// Converts a client's message to a command.
fn heard(channel: &ClientChannel, payload: &[u8], robot: &Commanded) -> Received {
    let refused = |why: String| {
        Received::refused(format!(
            "a message on {} is not taken: {why}",
            channel.topic
        ))
    };
    let kind = channel.schema_name.replace("/msg/", "/");
    let topic = channel.topic.as_str();
    let topic = topic.strip_prefix('/').unwrap_or(topic);
    let encoding = channel.encoding.as_str();
    let taken = match (topic, kind.as_str(), encoding) {
        ("cmd_vel", "geometry_msgs/Twist", "cdr" | "json") => {
            read::<Twist>(payload, encoding).map(|message| commands::twist(&message))
        }
        // Its stamp is from the viewer's clock.
        ("cmd_vel", "geometry_msgs/TwistStamped", "cdr" | "json") => {
            read::<TwistStamped>(payload, encoding).map(|message| commands::twist(&message.twist))
        }
        ("wheel_commands", "std_msgs/Float64MultiArray", "cdr" | "json") => {
            read(payload, encoding).map(|message| commands::rates(&message, robot))
        }
        (_, kind, encoding) => Err(format!(
            "{kind} as {encoding} drives nothing: publish geometry_msgs/Twist or TwistStamped on /cmd_vel, as json or cdr"
        )),
    };
    taken.unwrap_or_else(refused)
}

fn read<M: Message + for<'de> Deserialize<'de>>(
    payload: &[u8],
    encoding: &str,
) -> Result<M, String> {
    match encoding {
        "json" => serde_json::from_slice(payload).map_err(|fault| fault.to_string()),
        _ => M::decode(payload).map_err(|fault| fault.to_string()),
    }
}
