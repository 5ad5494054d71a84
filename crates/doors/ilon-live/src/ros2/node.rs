//! The node's thread, which publishes rows, receives commands and answers requests.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use futures::channel::mpsc;
use futures::future::{self, FutureExt, LocalBoxFuture};
use futures::stream::StreamExt;
use ilon_messages::bag::Qos;
use ilon_messages::geometry_msgs::{Twist, TwistStamped};
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::Float64MultiArray;
use ilon_messages::topics::RunTopics;
use ilon_trace::{Record, WheelSample};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::{
    Context, Name, NodeName, NodeOptions, QosProfile, RmwRequestId, Server, ServiceMapping,
    ServiceTypeName, Subscription,
};
use serde::de::DeserializeOwned;

use super::others::Others;
use super::outlet::{Topics, profile};
use super::parameters::{Answers, Servers};
use super::services::{self, Answer, Features, IsState, Nothing, Outcome};
use super::{Network, Options, Ros2Error};
use crate::commands::{self, Commanded, Received};
use crate::mailbox::Mailbox;
use crate::observer::{Observer, Status};
use crate::parameters::Parameters;
use crate::session::{Row, Session};
use crate::throttle::Throttle;
use crate::topics::live_topics;

/// Queue length of rows to publish; further ones are lost, with a note.
const MOST_ROWS: usize = 256;
/// The ROS package of services that control simulators.
const SIMULATION: &str = "simulation_interfaces";
/// Time for the middleware to announce the end of the node.
const LEAVING: Duration = Duration::from_millis(200);
/// Polling period of other nodes in the domain.
const LOOK: Duration = Duration::from_secs(1);

/// A ROS 2 node that shows a session and accepts commands for it. It ends when it is dropped.
pub struct Ros2 {
    events: Option<mpsc::Sender<Event>>,
    thread: Option<JoinHandle<()>>,
    desk: Mailbox,
    lost_rows: u64,
    look_due: Instant,
    controllers: bool,
}

/// An event from the simulation to the thread.
enum Event {
    Row(Box<OwnedRow>),
    Restarted(Box<RunTopics>),
    Say(String),
    Look,
    Stepped(RmwRequestId, Outcome),
}

struct OwnedRow {
    record: Record,
    wheels: Vec<WheelSample>,
    rollers_rad: Vec<Option<f64>>,
}

impl Ros2 {
    /// Joins the network and starts.
    ///
    /// # Errors
    /// [`Ros2Error`].
    pub fn start(
        session: &Session,
        desk: &Mailbox,
        network: Network,
        options: Options,
    ) -> Result<Self, Ros2Error> {
        let topics = live_topics(session, options.controllers);
        let ends = Ends::new(session, &topics, &network, &options)?;
        let (sender, receiver) = mpsc::channel(MOST_ROWS);
        let heart = Heart {
            ends,
            desk: desk.clone(),
            robot: Commanded::of(session.robot()),
            parameters: Parameters::of(session, desk),
            now_s: Cell::new(session.time_s()),
            stepped: sender.clone(),
        };
        let thread = std::thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || {
                let participant = heart.ends.context.domain_participant();
                heart.beat(receiver, topics);
                // The end of node and topics is announced by a thread of the middleware, which ends
                // with the participant.
                std::thread::sleep(LEAVING);
                drop(participant);
            })
            .map_err(|reason| Ros2Error::topic("a thread", reason))?;
        network.remarks.iter().for_each(|remark| desk.say(remark));
        Ok(Self {
            events: Some(sender),
            thread: Some(thread),
            desk: desk.clone(),
            lost_rows: 0,
            look_due: Instant::now(),
            controllers: options.controllers,
        })
    }

    /// Sends an event; returns whether there was room.
    fn pass(&mut self, event: Event) -> bool {
        self.events
            .as_mut()
            .is_some_and(|events| events.try_send(event).is_ok())
    }
}

impl Observer for Ros2 {
    fn row(&mut self, row: Row<'_>) {
        let passed = self.pass(Event::Row(Box::new(OwnedRow {
            record: *row.record,
            wheels: row.wheels.to_vec(),
            rollers_rad: row.rollers_rad.to_vec(),
        })));
        if !passed {
            self.lost_rows += 1;
        } else if self.lost_rows > 0 {
            let lost = std::mem::take(&mut self.lost_rows);
            self.desk.say(format!(
                "{lost} control periods were not published: the machine is too slow"
            ));
        }
    }

    fn look(&mut self, _session: &Session, _status: Status<'_>) {
        if Instant::now() >= self.look_due {
            self.look_due = Instant::now() + LOOK;
            self.pass(Event::Look);
        }
    }

    fn restarted(&mut self, session: &Session) {
        let topics = live_topics(session, self.controllers);
        self.pass(Event::Restarted(Box::new(topics)));
    }

    fn say(&mut self, note: &str) {
        self.pass(Event::Say(note.to_owned()));
    }
}

impl fmt::Debug for Ros2 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ros2")
            .field("lost_rows", &self.lost_rows)
            .finish_non_exhaustive()
    }
}

impl Drop for Ros2 {
    fn drop(&mut self) {
        if let Some(mut events) = self.events.take() {
            events.close_channel();
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The node's endpoints.
struct Ends {
    context: Context,
    topics: Topics,
    twist_stamped: Option<Subscription<TwistStamped>>,
    twist: Option<Subscription<Twist>>,
    wheels: Subscription<JointState>,
    joints: Subscription<JointState>,
    rates: Subscription<Float64MultiArray>,
    step: Server<services::Step, Answer>,
    reset: Server<services::Reset, Answer>,
    set_state: Server<services::SetState, Answer>,
    is_state: Server<Nothing, IsState>,
    features: Server<Nothing, Features>,
    parameters: Servers,
}

impl Ends {
    fn new(
        session: &Session,
        topics: &RunTopics,
        network: &Network,
        options: &Options,
    ) -> Result<Self, Ros2Error> {
        let join = |reason: String| Ros2Error::Join {
            domain: network.domain,
            reason,
        };
        let mut builder = DomainParticipantBuilder::new(network.domain);
        if let Some(only) = network.only() {
            builder = builder.with_only_networks(only);
        }
        let participant = builder.build().map_err(|fault| join(fault.to_string()))?;
        let context = Context::from_domain_participant(participant)
            .map_err(|fault| join(fault.to_string()))?;
        let namespace = options.namespace.as_str();
        let within = if namespace.is_empty() { "/" } else { namespace };
        let name = NodeName::new(within, "ilon").map_err(|fault| join(fault.to_string()))?;
        let node = context
            .new_node(name, NodeOptions::new().start_parameter_services(false))
            .map_err(|fault| join(fault.to_string()))?;
        let left: &[&str] = match options.controllers {
            true => &["/joint_states", "/odom"],
            false => &[],
        };
        let mut outlet = Topics::new(context.clone(), node, namespace, left);
        topics.declare(&mut outlet)?;
        topics.latched(&mut outlet, session.time_s())?;
        let unstamped = options.unstamped;
        Ok(Self {
            twist_stamped: (!unstamped).then(|| outlet.hear("/cmd_vel")).transpose()?,
            twist: unstamped.then(|| outlet.hear("/cmd_vel")).transpose()?,
            wheels: outlet.hear("/robot_joint_commands")?,
            joints: outlet.hear("/joint_commands")?,
            rates: outlet.hear("/wheel_commands")?,
            step: outlet.serve("step_simulation", SIMULATION, "StepSimulation")?,
            reset: outlet.serve("reset_simulation", SIMULATION, "ResetSimulation")?,
            set_state: outlet.serve("set_simulation_state", SIMULATION, "SetSimulationState")?,
            is_state: outlet.serve("get_simulation_state", SIMULATION, "GetSimulationState")?,
            features: outlet.serve("get_simulator_features", SIMULATION, "GetSimulatorFeatures")?,
            parameters: Servers::new(&mut outlet)?,
            topics: outlet,
            context,
        })
    }
}

impl Topics {
    fn hear<M: ilon_messages::Message + DeserializeOwned + 'static>(
        &mut self,
        name: &str,
    ) -> Result<Subscription<M>, Ros2Error> {
        let profile = profile(Qos::reliable(10));
        let topic = self.topic::<M>(name, &profile)?;
        self.node()
            .create_subscription(&topic, Some(profile))
            .map_err(|reason| Ros2Error::topic(name, reason))
    }

    /// A service with a type of a package, in the node's namespace.
    pub(super) fn serve<Q, A>(
        &mut self,
        name: &str,
        package: &str,
        type_name: &str,
    ) -> Result<Server<Q, A>, Ros2Error>
    where
        Q: ros2_client::Message + Clone + 'static,
        A: ros2_client::Message + 'static,
    {
        let fault = |reason: String| Ros2Error::topic(name, reason);
        let node = format!("{}/ilon", self.namespace);
        let place = Name::new(&node, name).map_err(|reason| fault(reason.to_string()))?;
        let (type_name, mapping) = (
            ServiceTypeName::new(package, type_name),
            ServiceMapping::Enhanced,
        );
        let qos = QosProfile::publisher_default();
        let qos = qos.history(ros2_client::qos::History::KeepLast { depth: 10 });
        self.node()
            .create_server(mapping, &place, &type_name, qos.clone(), qos)
            .map_err(|reason| fault(reason.to_string()))
    }
}

/// State of the thread.
struct Heart {
    ends: Ends,
    desk: Mailbox,
    robot: Commanded,
    parameters: Parameters,
    /// The simulated time, in seconds.
    now_s: Cell<f64>,
    stepped: mpsc::Sender<Event>,
}

impl Heart {
    /// Runs until no further event can arrive.
    fn beat(self, mut events: mpsc::Receiver<Event>, mut rows: RunTopics) {
        let Self {
            ends,
            desk,
            robot,
            parameters,
            now_s,
            stepped,
        } = self;
        let Ends {
            context,
            mut topics,
            twist_stamped,
            twist,
            wheels,
            joints,
            rates,
            step,
            reset,
            set_state,
            is_state,
            features,
            parameters: asked_for,
        } = ends;
        let mut voice = Voice {
            context: &context,
            topics: &mut topics,
            others: Others::default(),
            hears_twist: twist.is_some(),
            step: &step,
            desk: &desk,
            now_s: &now_s,
        };
        let publish = async {
            while let Some(event) = events.next().await {
                if let Err(fault) = voice.tell(event, &mut rows) {
                    desk.say(fault.to_string());
                }
            }
        };
        let stepped = RefCell::new(stepped);
        let ears = Ears {
            desk: &desk,
            throttle: RefCell::default(),
        };
        let mut served: Vec<LocalBoxFuture<'_, ()>> = Vec::new();
        if let Some(stamped) = &twist_stamped {
            let heard = |message: &_| commands::twist_stamped(message, now_s.get());
            served.push(ears.listen(stamped, "/cmd_vel", heard));
        }
        if let Some(twist) = &twist {
            served.push(ears.listen(twist, "/cmd_vel", commands::twist));
        }
        let heard = |message: &_| commands::joint_state(message, &robot);
        served.push(ears.listen(&wheels, "/robot_joint_commands", heard));
        let heard = |message: &_| commands::joint_commands(message, &robot);
        served.push(ears.listen(&joints, "/joint_commands", heard));
        let heard = |message: &_| commands::rates(message, &robot);
        served.push(ears.listen(&rates, "/wheel_commands", heard));
        let asked = step.receive_request_stream().for_each(|request| {
            if let Ok((id, request)) = request {
                let mut stepped = stepped.borrow().clone();
                desk.step(request.steps, move |done| {
                    let outcome =
                        done.map_or_else(|why| Outcome::incorrect_state(&why), |()| Outcome::ok());
                    // In the queue after the rows of these steps, which are published first.
                    let _ = stepped.try_send(Event::Stepped(id, outcome));
                });
            }
            future::ready(())
        });
        served.push(asked.boxed_local());
        let change = |change: Result<crate::control::Change, Outcome>| Answer {
            result: change.map_or_else(
                |refused| refused,
                |change| {
                    desk.change(&change)
                        .map_or_else(Outcome::ok, |why| Outcome::failed(&why))
                },
            ),
        };
        served.push(answer(&reset, |request| change(request.change())));
        served.push(answer(&set_state, |request| {
            change(request.change(&desk.controls()))
        }));
        served.push(answer(&is_state, |_| IsState::of(&desk.controls())));
        served.push(answer(&features, |_| Features::own()));
        let answers = Answers {
            parameters: &parameters,
            desk: &desk,
        };
        served.extend(answers.serve(&asked_for));
        let serve = future::join_all(served);
        let both = future::select(Box::pin(publish), serve);
        futures::executor::block_on(both);
    }
}

/// The publishing half.
struct Voice<'a> {
    context: &'a Context,
    topics: &'a mut Topics,
    others: Others,
    hears_twist: bool,
    step: &'a Server<services::Step, Answer>,
    desk: &'a Mailbox,
    now_s: &'a Cell<f64>,
}

impl Voice<'_> {
    /// Publishes an event.
    fn tell(&mut self, event: Event, rows: &mut RunTopics) -> Result<(), Ros2Error> {
        match event {
            Event::Row(row) => {
                self.now_s.set(row.record.t_s);
                let (wheels, rollers_rad) = (&row.wheels, &row.rollers_rad);
                return rows.row(&row.record, wheels, rollers_rad, self.topics);
            }
            Event::Restarted(fresh) => *rows = *fresh,
            Event::Say(note) => self.topics.say(&note),
            Event::Look => {
                let namespace = &self.topics.namespace;
                (self.others).look(self.context, namespace, self.hears_twist, self.desk);
                let lost = std::mem::take(&mut self.topics.lost);
                if lost > 0 {
                    let note = "messages were lost: a reliable reader does not keep up";
                    self.desk.say(format!("{lost} {note}"));
                }
            }
            Event::Stepped(request, result) => {
                let _ = self.step.send_response(request, Answer { result });
            }
        }
        Ok(())
    }
}

/// The receiving half, with throttled notes on invalid commands.
struct Ears<'d> {
    desk: &'d Mailbox,
    throttle: RefCell<Throttle>,
}

impl Ears<'_> {
    /// Receives messages of a topic, while polled.
    fn listen<'a, M: DeserializeOwned + 'static>(
        &'a self,
        subscription: &'a Subscription<M>,
        topic: &'a str,
        heard: impl Fn(&M) -> Received + 'a,
    ) -> LocalBoxFuture<'a, ()> {
        let each = move |message: Result<(M, ros2_client::MessageInfo), ros2_client::ReadError>| {
            let note = match message {
                Ok((message, _)) => heard(&message).taken(self.desk),
                Err(fault) => Some(format!("a message on {topic} cannot be read: {fault}")),
            };
            let note = note.and_then(|note| self.throttle.borrow_mut().pass(note, Instant::now()));
            if let Some(note) = note {
                self.desk.say(note);
            }
            future::ready(())
        };
        subscription.async_stream().for_each(each).boxed_local()
    }
}

impl<'a> Answers<'a> {
    /// Answers requests about parameters.
    fn serve(&'a self, servers: &'a Servers) -> [LocalBoxFuture<'a, ()>; 6] {
        [
            answer(&servers.get, |request| self.get(&request)),
            answer(&servers.types, |request| self.types(&request)),
            answer(&servers.list, |request| self.list(&request)),
            answer(&servers.describe, |request| self.describe(&request)),
            answer(&servers.set, |request| self.set(&request)),
            answer(&servers.set_atomically, |request| {
                self.set_atomically(&request)
            }),
        ]
    }
}

/// Answers requests, while polled.
fn answer<'a, Q, A>(server: &'a Server<Q, A>, by: impl Fn(Q) -> A + 'a) -> LocalBoxFuture<'a, ()>
where
    Q: ros2_client::Message + 'static,
    A: ros2_client::Message + 'static,
{
    let each = move |request: Result<(RmwRequestId, Q), ros2_client::ReadError>| {
        if let Ok((id, request)) = request {
            let _ = server.send_response(id, by(request));
        }
        future::ready(())
    };
    server.receive_request_stream().for_each(each).boxed_local()
}
