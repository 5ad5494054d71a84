//! Dead reckoning by the robot's controller, once a control period, for the robot that it believes
//! in.

use std::borrow::Cow;

use ilon_control::{ContactKinematics, Kinematics, Odometry, OdometryCovariance, WayErrors};
use ilon_robot::{Pose, Robot, Twist};
use ilon_trace::Reckoned;

use crate::sensing::hubs::{self, Hubs};
use crate::sensing::posed_odometry::PosedOdometry;

/// The share of slip in a wheel's travel that a controller assumes without better knowledge: the
/// loss of steel and rubber rollers by creep and hand-overs. Chosen.
const SLIP_SHARE: f64 = 0.005;

/// The robot's pose by dead reckoning from its wheels' rotation.
pub(crate) struct Reckoning {
    kinematics: Kinematics,
    ideal: Pose,
    contact: Odometry,
    /// With all joints between bodies at their true positions, if `measured` differs.
    posed: Option<PosedOdometry>,
    /// With the measured joints at their positions, if they move wheels.
    measured: Option<PosedOdometry>,
    /// Which joints the robot measures, and their last positions, in rad or m, with zero for the
    /// others. Empty before the first.
    known: Vec<bool>,
    positions: Vec<f64>,
    /// Of `ideal`; for a robot whose rollers define its errors.
    covariance: Option<OdometryCovariance>,
    control_dt_s: f64,
    last_angles_rad: Vec<f64>,
    turned_rad: Vec<f64>,
}

impl Reckoning {
    /// For a robot that starts at a pose with all wheel angles zero, with encoder noise in rad/s
    /// and a control period in seconds.
    pub fn new(
        robot: &Robot,
        (kinematics, contact): (Kinematics, ContactKinematics),
        start: Pose,
        (rate_noise_rad_s, control_dt_s): (f64, f64),
    ) -> Self {
        let errors = WayErrors::of_rollers(robot, SLIP_SHARE).map(|errors| WayErrors {
            rate_noise_rad_s,
            ..errors
        });
        let wheels = robot.wheels.len();
        let moves = Hubs::that_move(robot).is_some();
        let known = hubs::measured(robot);
        let all_measured = moves && !known.contains(&false);
        Self {
            covariance: errors
                .and_then(|errors| OdometryCovariance::new(kinematics.clone(), errors))
                .ok(),
            kinematics,
            ideal: start,
            contact: Odometry::new(contact, start, &[]),
            posed: (!robot.joints.is_empty() && !all_measured)
                .then(|| PosedOdometry::new(robot, start)),
            measured: moves.then(|| PosedOdometry::new(robot, start)),
            known,
            positions: Vec::new(),
            control_dt_s,
            last_angles_rad: vec![0.0; wheels],
            turned_rad: vec![0.0; wheels],
        }
    }

    /// By Indiveri 2009, eq. (7).
    pub fn ideal(&self) -> Pose {
        self.ideal
    }

    /// By contact kinematics.
    pub fn contact(&self) -> Pose {
        self.contact.pose()
    }

    /// By eq. (7) with all joints between bodies at their true positions, if it has any.
    pub fn posed(&self) -> Option<Pose> {
        let posed = self.posed.as_ref().or(self.measured.as_ref());
        posed.map(PosedOdometry::pose)
    }

    /// The twist of wheel rates in rad/s by eq. (7), and of active casters.
    pub fn twist(&self, rates_rad_s: &[f64]) -> Twist {
        let casters = self.hubs().map_or(Twist::default(), Hubs::moved_by_pairs);
        self.kinematics.twist(rates_rad_s) + casters.scaled(1.0 / self.control_dt_s)
    }

    /// Counts the wheels' rotation since the last call, by the encoders' angles, with the joints
    /// between bodies at these positions, in rad or m; none are known at the start. Returns whether
    /// measured joints have moved wheels since then.
    pub fn reckon(&mut self, angles_rad: &[f64], positions: &[f64]) -> bool {
        let joints = positions.iter().zip(&self.known);
        let measured = joints.map(|(position, known)| if *known { *position } else { 0.0 });
        self.positions.clear();
        self.positions.extend(measured);
        let increments = self.turned_rad.iter_mut().zip(&mut self.last_angles_rad);
        for ((turned, last), now) in increments.zip(angles_rad) {
            *turned = now - *last;
            *last = *now;
        }
        if let Some(posed) = &mut self.posed {
            posed.reckon(&self.turned_rad, positions);
        }
        let before = self.ideal;
        let Some(measured) = &mut self.measured else {
            if let Some(covariance) = &mut self.covariance {
                covariance.count(&before, &self.turned_rad);
            }
            self.contact.update(angles_rad);
            // The kinematics is linear in the rates: wheel angles give the displacement.
            let displacement = self.kinematics.twist(&self.turned_rad);
            self.ideal = self.ideal.moved(displacement);
            return false;
        };
        let moved = measured.reckon(&self.turned_rad, &self.positions);
        self.ideal = measured.pose();
        let hubs = measured.hubs();
        if let Some(kinematics) = hubs.kinematics().filter(|_| moved) {
            self.kinematics.clone_from(kinematics);
            self.contact.stand(kinematics);
            if let Some(covariance) = &mut self.covariance {
                covariance.stand(kinematics);
            }
        }
        if let Some(covariance) = &mut self.covariance {
            covariance.count(&before, measured.rolled_rad());
        }
        (self.contact).update_carried(angles_rad, hubs.carried_rad(), hubs.along_axles());
        moved
    }

    /// The wheels where the measured joints stand, if joints move wheels.
    pub fn hubs(&self) -> Option<&Hubs> {
        self.measured.as_ref().map(PosedOdometry::hubs)
    }

    /// The last positions of the measured joints, with zero for the others.
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// The kinematics of the believed robot where it stands.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Twist and covariances for measured rates in rad/s, and rows `row_period_s` seconds apart.
    pub fn reckoned(&self, seen_rad_s: &[f64], row_period_s: f64) -> Option<Reckoned> {
        let covariance = self.covariance.as_ref()?;
        let rolling_rad_s = match &self.measured {
            None => Cow::Borrowed(seen_rad_s),
            Some(measured) => {
                let carried = measured.hubs().carried_rad();
                let rates = seen_rad_s.iter().zip(carried);
                rates
                    .map(|(seen, carried)| seen + carried / self.control_dt_s)
                    .collect()
            }
        };
        let along_axles = (self.measured.as_ref())
            .map_or(Twist::default(), |measured| measured.hubs().along_axles())
            .scaled(1.0 / self.control_dt_s);
        let pose = covariance.covariance(self.ideal.heading_rad);
        let twist = covariance.twist_covariance(&rolling_rad_s, row_period_s);
        Some(Reckoned {
            twist: self.kinematics.twist(&rolling_rad_s) + along_axles,
            pose_covariance: pose.into(),
            twist_covariance: twist.into(),
        })
    }
}
