//! `ilon live`: drives a robot while it is simulated, from a page in the browser, from ROS 2, from
//! Foxglove or from ArduPilot.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use ilon_live::{LiveError, Mailbox, Observer, Pace, Server, Session};

use super::kind::{Kind, kind, wants};
use super::options::{Sandbox, Settings};
use super::outcome::Outcome;
use super::robot::robot_alone;
use super::{console, interrupt};
use crate::Scenario;
use crate::cli::failure::Failure;

/// Arguments of `ilon live`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario file: robot, world and, to follow on request, its reference; or a robot's file,
    /// on a level floor.
    scenario: PathBuf,
    /// Port of the page, on this machine only; 0 for any free port.
    #[arg(long, default_value_t = 8765)]
    port: u16,
    /// Simulated seconds a second, from 0.05 to 20.
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = speed, allow_negative_numbers = true)]
    speed: f64,
    /// Start paused.
    #[arg(long)]
    paused: bool,
    /// Be the ROS 2 node `/ilon`, which takes `/cmd_vel` and wheel commands. With `=controllers`,
    /// ros2_control drives the wheels and publishes `/joint_states`, `/odom` and `odom ->
    /// base_link`.
    #[cfg(feature = "ros2")]
    #[arg(long, value_name = "WHO", num_args = 0..=1, require_equals = true, default_missing_value = "body")]
    ros2: Option<Drives>,
    /// Take `/cmd_vel` as `geometry_msgs/Twist` instead of `TwistStamped`.
    #[cfg(feature = "ros2")]
    #[arg(long, requires = "ros2")]
    unstamped: bool,
    /// Namespace of the node, its topics and its services, `/tf` and `/clock` too, for several
    /// robots in a domain.
    #[cfg(feature = "ros2")]
    #[arg(long, value_name = "NAME", requires = "ros2", value_parser = namespace, default_value = "", hide_default_value = true)]
    namespace: String,
    /// Be a ROS 2 node: not in this build.
    #[cfg(not(feature = "ros2"))]
    #[arg(long, hide = true, num_args = 0..=1, require_equals = true, default_missing_value = "")]
    ros2: Option<String>,
    /// Serve Foxglove: not in this build.
    #[cfg(not(feature = "foxglove"))]
    #[arg(long, hide = true, num_args = 0..=1, require_equals = true, default_missing_value = "")]
    foxglove: Option<String>,
    /// Serve Foxglove and Lichtblick too, on this machine only; port 0 for any free port.
    #[cfg(feature = "foxglove")]
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "8766")]
    foxglove: Option<u16>,
    /// Simulate for ArduPilot's SITL, `sim_vehicle.py -v Rover -f rover --model JSON:127.0.0.1`, in
    /// lock step, without a page. Writes `SCENARIO.parm` into the current folder: the parameters
    /// that Rover needs.
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "9002", conflicts_with_all = ["speed", "paused"])]
    ardupilot: Option<u16>,
    /// End after this many seconds [default: when interrupted].
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// What is driven over ROS 2.
#[cfg(feature = "ros2")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Drives {
    /// The body, by `/cmd_vel`; the wheels too, for those who want to.
    Body,
    /// The wheels, by controllers of ros2_control.
    Controllers,
}

/// Prints status messages for the user.
struct Terminal;

impl Observer for Terminal {
    fn say(&mut self, note: &str) {
        console::note(note);
    }
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if Pace::SPEEDS.contains(&speed) => Ok(speed),
        _ => {
            let (least, most) = (Pace::SPEEDS.start(), Pace::SPEEDS.end());
            Err(format!("give a number from {least} to {most}"))
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1e6 => Ok(number),
        _ => Err("give a number above 0, up to 1e6".to_owned()),
    }
}

#[cfg(feature = "ros2")]
fn namespace(text: &str) -> Result<String, String> {
    let parts = text.trim_start_matches('/').split('/');
    let is_name = |part: &str| {
        !part.starts_with(|letter: char| letter.is_ascii_digit())
            && !part.is_empty()
            && !part.contains("__")
            && (part.chars()).all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    match parts.clone().all(is_name) {
        true => Ok(parts.map(|part| format!("/{part}")).collect()),
        false if text.is_empty() => Ok(String::new()),
        false => Err("give letters, digits and _, such as robot1".to_owned()),
    }
}

/// Simulates until it is interrupted.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    #[cfg(not(feature = "ros2"))]
    if arguments.ros2.is_some() {
        return Err(left_out("ROS 2", "ros2"));
    }
    #[cfg(not(feature = "foxglove"))]
    if arguments.foxglove.is_some() {
        return Err(left_out("Foxglove", "foxglove"));
    }
    let files = arguments.sandbox.files()?;
    let (path, settings) = (&arguments.scenario, &arguments.settings.settings);
    wants(path, &[Kind::Scenario, Kind::Robot], &files)?;
    let scenario = match kind(path, &files) == Some(Kind::Robot) {
        true => robot_alone(
            path,
            "twist = {}\nrun.duration_s = 1.0\n",
            settings,
            &arguments.sandbox,
        )?,
        false => Scenario::load_within(path, settings, &files)?,
    };
    // Until then, or until the command is interrupted or terminated. Connections are then closed; a
    // second interruption ends the command at once.
    let end = arguments
        .seconds
        .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let is_interrupted = interrupt::awaited();
    let goes_on = move || !is_interrupted() && end.is_none_or(|end| Instant::now() < end);
    if let Some(port) = arguments.ardupilot {
        return ardupilot(port, &scenario, goes_on);
    }
    let mut session = Session::new(&scenario).map_err(failure)?;
    let desk = Mailbox::default();
    let mut page = Server::start(arguments.port, &session, &desk).map_err(failure)?;
    #[cfg(feature = "ros2")]
    let mut node = ros2(arguments, &session, &desk)?;
    #[cfg(feature = "foxglove")]
    let mut viewers = foxglove(arguments, &session, &desk)?;
    console::lines(&format!("drive at {}  (end with Ctrl-C)\n", page.url()))?;
    let pace = Pace {
        speed: arguments.speed,
        paused: arguments.paused,
    };
    let mut terminal = Terminal;
    let mut watchers: Vec<&mut dyn Observer> = vec![&mut terminal, &mut page];
    #[cfg(feature = "ros2")]
    watchers.extend(node.iter_mut().map(|node| node as &mut dyn Observer));
    #[cfg(feature = "foxglove")]
    watchers.extend(
        viewers
            .iter_mut()
            .map(|viewers| viewers as &mut dyn Observer),
    );
    ilon_live::run(&mut session, &desk, &mut watchers, pace, goes_on).map_err(failure)?;
    Ok(Outcome::Done)
}

/// Serves ArduPilot until the end, or until it is interrupted.
fn ardupilot(
    port: u16,
    scenario: &Scenario,
    goes_on: impl Fn() -> bool,
) -> Result<Outcome, Failure> {
    use ilon_live::ardupilot::{ArduPilot, Vehicle};
    let mut vehicle = Vehicle::new(scenario).map_err(failure)?;
    let server = ArduPilot::start(port).map_err(|fault| {
        let remedy = "choose another port with --ardupilot=PORT, or 0 for any that is free";
        Failure::usage(fault.to_string(), remedy)
    })?;
    let parameters = write_parameters(&scenario.name, &vehicle)?;
    let frame = vehicle.mixer().frame;
    let motors = vehicle.wheels().zip(1..);
    let motors: Vec<String> = motors
        .map(|(wheel, motor)| format!("{motor} {wheel}"))
        .collect();
    console::lines(&format!(
        "ArduPilot: frames at 127.0.0.1:{}  (end with Ctrl-C)\nframe {} ({}); its motors are {}\n\
         sim_vehicle.py -v Rover -f rover --model JSON:127.0.0.1 --add-param-file={}\n",
        server.port(),
        frame.frame_type,
        frame.name,
        motors.join(", "),
        parameters.display()
    ))?;
    let served = server.serve(&mut vehicle, goes_on, console::note);
    served.map_err(failure)?;
    Ok(Outcome::Done)
}

/// Writes the parameters of a vehicle into the working directory; returns the file's path.
fn write_parameters(
    name: &str,
    vehicle: &ilon_live::ardupilot::Vehicle,
) -> Result<PathBuf, Failure> {
    let path = std::path::absolute(format!("{name}.parm"));
    let path =
        path.map_err(|error| Failure::usage(error.to_string(), "go to a folder that exists"))?;
    let text = vehicle.parameters();
    let first = text.lines().next().unwrap_or_default();
    let there = std::fs::read(&path).unwrap_or_default();
    if !there.is_empty() && !there.starts_with(first.as_bytes()) {
        return Err(Failure::usage(
            format!(
                "`{}` is there already, and was not written for this robot",
                path.display()
            ),
            "move it elsewhere, or go to another folder",
        ));
    }
    ilon_trace::file::write_text(&path, &text)?;
    Ok(path)
}

/// The error for an interface that this build does not include.
#[cfg(not(all(feature = "ros2", feature = "foxglove")))]
fn left_out(name: &str, feature: &str) -> Failure {
    Failure::usage(
        format!("this ilon was built without {name}, which takes minutes to build"),
        format!(
            "take a released command or wheel, which have it, or build it: `cargo build --release -p ilon --features {feature}`"
        ),
    )
}

/// Starts the ROS 2 node, if requested.
#[cfg(feature = "ros2")]
fn ros2(
    arguments: &Arguments,
    session: &Session,
    desk: &Mailbox,
) -> Result<Option<ilon_live::ros2::Ros2>, Failure> {
    use ilon_live::ros2::{Network, Options, Ros2, Ros2Error};
    let Some(drives) = arguments.ros2 else {
        return Ok(None);
    };
    let fault = |fault: Ros2Error| {
        let remedy = match fault {
            Ros2Error::Variable(_) => "set it otherwise, or unset it",
            _ => "see whether the network lets a node be: the loopback interface has to be up",
        };
        Failure::usage(fault.to_string(), remedy)
    };
    let network = Network::from_variables(|name| std::env::var(name).ok())
        .map_err(|bad| fault(bad.into()))?;
    let mut options = Options::default();
    options.namespace.clone_from(&arguments.namespace);
    options.unstamped = arguments.unstamped;
    options.controllers = drives == Drives::Controllers;
    let namespace = &arguments.namespace;
    let (domain, where_from) = match network.only_this_machine {
        true => (network.domain, "on this machine alone"),
        false => (network.domain, "on all networks of this machine"),
    };
    let node = Ros2::start(session, desk, network, options).map_err(fault)?;
    console::lines(&format!(
        "ROS 2: node {namespace}/ilon in domain {domain}, {where_from}\n"
    ))?;
    Ok(Some(node))
}

/// Starts the Foxglove server, if requested.
#[cfg(feature = "foxglove")]
fn foxglove(
    arguments: &Arguments,
    session: &Session,
    desk: &Mailbox,
) -> Result<Option<ilon_live::foxglove::Foxglove>, Failure> {
    use ilon_live::foxglove::Foxglove;
    let Some(port) = arguments.foxglove else {
        return Ok(None);
    };
    let server = Foxglove::start(port, session, desk).map_err(|fault| {
        Failure::usage(
            fault.to_string(),
            "choose another port with --foxglove=PORT, or 0 for any that is free",
        )
    })?;
    console::lines(&format!("Foxglove: open the connection {}\n", server.url()))?;
    Ok(Some(server))
}

fn failure(error: LiveError) -> Failure {
    match error {
        LiveError::Simulation(error) => error.into(),
        LiveError::Listen { .. } => Failure::usage(
            error.to_string(),
            "choose another port with --port, or 0 for any that is free",
        ),
        other => Failure::encode("the page", &other),
    }
}
