//! The time law of a reference: the path's own time as a function of time.

/// A time law by nodes; between two of them the flow (the reference's speed) is linear in time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pace {
    nodes: Vec<Node>,
    /// First node of the lap that repeats; without it the reference rests at its end.
    again_from: Option<usize>,
    /// The arm by which rotation counts as movement, in metres.
    arm_m: f64,
}

/// State of the reference at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// Time, in seconds.
    pub t_s: f64,
    /// Place on the path, in the path's own time, in seconds.
    pub own_s: f64,
    /// Own time reached at the next node, in seconds; the gap up to that node's `own_s` is a stop.
    pub own_until_s: f64,
    /// Speed of the reference, in m/s.
    pub flow_m_s: f64,
    /// Acceleration up to the next node, in m/s^2.
    pub gain_m_s2: f64,
}

impl Pace {
    /// Builds a pace from at least two nodes with non-decreasing times.
    pub fn new(nodes: Vec<Node>, again_from: Option<usize>, arm_m: f64) -> Self {
        Self {
            nodes,
            again_from,
            arm_m,
        }
    }

    pub fn arm_m(&self) -> f64 {
        self.arm_m
    }

    /// Time of the last node, in seconds.
    pub fn end_s(&self) -> f64 {
        self.nodes[self.nodes.len() - 1].t_s
    }

    /// Returns the path's own time in seconds at a time in seconds, and its rate, given the
    /// reference's speed in its own time, in m/s.
    pub fn at(&self, t_s: f64, flow: impl Fn(f64) -> f64) -> (f64, f64) {
        let last = self.nodes.len() - 1;
        let end = self.nodes[last];
        let (mut t_s, mut laps_s) = (t_s.max(0.0), 0.0);
        if t_s >= end.t_s {
            let Some(from) = self.again_from.map(|from| self.nodes[from]) else {
                return (end.own_s, 0.0);
            };
            let laps = ((t_s - from.t_s) / (end.t_s - from.t_s)).floor();
            t_s -= laps * (end.t_s - from.t_s);
            laps_s = laps * (end.own_s - from.own_s);
        }
        let i = self.nodes.partition_point(|node| node.t_s <= t_s).max(1) - 1;
        let here = self.nodes[i];
        let after_s = t_s - here.t_s;
        let flow_m_s = (here.flow_m_s + here.gain_m_s2 * after_s).max(0.0);
        let gone_m = 0.5 * (here.flow_m_s + flow_m_s) * after_s;
        let own_s = place_after(gone_m, here.own_s, here.own_until_s, &flow);
        let own_flow_m_s = flow(own_s);
        let passes = if own_flow_m_s > 0.0 && flow_m_s > 0.0 {
            flow_m_s / own_flow_m_s
        } else {
            0.0
        };
        (own_s + laps_s, passes)
    }
}

/// Returns the distance moved between two times at a given flow, in metres, by five-point Gauss
/// quadrature.
pub(super) fn length_m(from_s: f64, to_s: f64, flow: &impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let half_s = 0.5 * (to_s - from_s);
    let at = |(x, weight): &(f64, f64)| weight * flow(from_s + half_s * (1.0 + x));
    half_s * NODES.iter().map(at).sum::<f64>()
}

/// Returns the time at which `gone_m` is covered from `from_s` on, before `to_s`: regula falsi,
/// with a safeguard against stagnation.
fn place_after(gone_m: f64, from_s: f64, to_s: f64, flow: &impl Fn(f64) -> f64) -> f64 {
    let missing = |at_s: f64| length_m(from_s, at_s, flow) - gone_m;
    let (mut low, mut high) = (from_s, to_s);
    let (mut below, mut above) = (-gone_m, missing(to_s));
    if below >= 0.0 {
        return low;
    }
    if above <= 0.0 {
        return high;
    }
    let close_m = 1e-13 * (above - below);
    let mut side = 0;
    for _ in 0..60 {
        let at_s = (low * above - high * below) / (above - below);
        let misses = missing(at_s);
        if misses.abs() <= close_m {
            return at_s;
        }
        if misses < 0.0 {
            (low, below) = (at_s, misses);
            above *= if side < 0 { 0.5 } else { 1.0 };
            side = -1;
        } else {
            (high, above) = (at_s, misses);
            below *= if side > 0 { 0.5 } else { 1.0 };
            side = 1;
        }
    }
    0.5 * (low + high)
}
