//! Sliding of the contacts: per wheel and over all wheels.

use ilon_robot::Twist;

use crate::fold::{Extent, Largest, Mean, Rms};
use crate::header::{Header, WheelHeader};
pub use crate::metrics::WheelSlip;
use crate::record::{Record, WheelSample};

/// Residual of Indiveri 2009, eq. (5), for one wheel: -m . (v, omega) + rho q' cos gamma, with m
/// the wheel's row of M, eq. (8); in m/s. Zero if the lowest roller, level and in the middle of the
/// wheel, rolls without sliding. `None` for a wheel whose direction its header does not know,
/// because it is steered.
pub fn constraint_residual_m_s(
    wheel: &WheelHeader,
    twist_in_body: Twist,
    rate_rad_s: f64,
) -> Option<f64> {
    if wheel.is_steered {
        return None;
    }
    let [m_x, m_y, m_a] = wheel.m_row();
    let v = twist_in_body;
    let rolled = wheel.radius_m * rate_rad_s * libm::cos(wheel.gamma_rad);
    Some(rolled - (m_x * v.vx_m_s + m_y * v.vy_m_s + m_a * v.omega_rad_s))
}

/// Root mean square; `None` without values.
pub fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut rms = Rms::default();
    values.for_each(|x| rms.add(x));
    rms.get()
}

/// A utilisation of the friction cone; values above 1 by rounding become 1.
fn without_rounding(used: f64) -> f64 {
    /// Rounding of forces that are sums over many contacts and steps. Chosen.
    const ROUNDING: f64 = 1e-12;
    match used <= 1.0 + ROUNDING {
        true => used.min(1.0),
        false => used,
    }
}

/// Largest minus smallest; `None` without values.
pub fn peak_to_peak(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut extent = Extent::default();
    values.for_each(|x| extent.add(x));
    extent.get()
}

/// Sums over one wheel's contacts so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct WheelAccumulator {
    index: usize,
    speed_m_s: Rms,
    speed_largest_m_s: Largest,
    rim_m_s: Rms,
    energy_j: f64,
    spin_up_energy_j: f64,
    residual_m_s: Rms,
    /// The time of the previous row, in seconds.
    before_s: f64,
    normal_force_n: Mean,
    friction_used: Largest,
    carrying: Option<u32>,
    hand_overs: u64,
    spin_error_rad_s: Rms,
    lost: Mean,
    shared: Mean,
    hub_height_m: Extent,
}

impl WheelAccumulator {
    /// One accumulator for each wheel.
    pub fn of_each(header: &Header) -> Vec<Self> {
        let accumulator = |index| Self {
            index,
            ..Self::default()
        };
        (0..header.wheels.len()).map(accumulator).collect()
    }

    /// Adds the wheel's sample of one row.
    pub fn add(&mut self, header: &Header, record: &Record, sample: &WheelSample) {
        let wheel = &header.wheels[self.index];
        let flag = |is_so: bool| f64::from(u8::from(is_so));
        let twist = record.truth.twist_in_body;
        if let Some(residual_m_s) = constraint_residual_m_s(wheel, twist, sample.rate_rad_s) {
            self.residual_m_s.add(residual_m_s);
        }
        self.energy_j = sample.slip_energy_j;
        self.spin_up_energy_j = sample.spin_up_energy_j;
        let period_s = record.t_s - std::mem::replace(&mut self.before_s, record.t_s);
        if record.has_contacts() {
            self.normal_force_n
                .add_weighted(sample.normal_force_n, period_s);
            self.lost
                .add_weighted(1.0 - sample.touching_share, period_s);
            self.shared
                .add(flag(sample.touching && sample.load_share < 1.0));
        }
        if header.is_measured(record.t_s) {
            self.hub_height_m.add(sample.hub_height_min_m);
            self.hub_height_m.add(sample.hub_height_max_m);
        }
        if sample.touched() {
            self.speed_m_s
                .add_weighted(sample.slip_speed_rms_m_s, period_s * sample.touching_share);
            self.speed_largest_m_s.add(sample.slip_speed_max_m_s);
            self.rim_m_s
                .add_weighted(wheel.radius_m * sample.rate_rad_s, period_s);
        }
        if let Some(used) = sample.friction_used() {
            self.friction_used.add(used);
        }
        if !sample.touching {
            return;
        }
        let before = self.carrying.replace(sample.roller);
        if before.is_some_and(|before| before != sample.roller) {
            self.hand_overs += 1;
        }
        self.spin_error_rad_s
            .add(sample.roller_spin_rad_s - sample.roller_spin_ideal_rad_s);
    }

    /// The figures of the wheel.
    pub fn finish(self, wheel: &WheelHeader) -> WheelSlip {
        let speed_rms_m_s = self.speed_m_s.get();
        // Below a millimetre per second the wheel counts as standing, because the ratio would be
        // noise over noise.
        let rim_rms_m_s = self.rim_m_s.get().filter(|&rim| rim > 1e-3);
        WheelSlip {
            name: wheel.name.clone(),
            speed_rms_m_s,
            speed_max_m_s: self.speed_largest_m_s.get(),
            ratio: speed_rms_m_s.zip(rim_rms_m_s).map(|(slip, rim)| slip / rim),
            energy_j: self.energy_j,
            spin_up_energy_j: self.spin_up_energy_j,
            constraint_residual_rms_m_s: self.residual_m_s.get(),
            normal_force_mean_n: self.normal_force_n.get(),
            friction_used_max: self.friction_used.get().map(without_rounding),
            hand_overs: self.hand_overs,
            roller_spin_error_rms_rad_s: self.spin_error_rad_s.get(),
            lost_contact: self.lost.get(),
            shared_contact: self.shared.get(),
            hub_ripple_m: self.hub_height_m.get(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Trace;

    fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut mean = Mean::default();
        values.for_each(|x| mean.add(x));
        mean.get()
    }

    /// The figures of each wheel's contacts over the run.
    fn per_wheel(trace: &Trace) -> Vec<WheelSlip> {
        let mut wheels = WheelAccumulator::of_each(&trace.header);
        for (record, samples) in trace.steps() {
            for (wheel, sample) in wheels.iter_mut().zip(samples) {
                wheel.add(&trace.header, record, sample);
            }
        }
        let slips = trace.header.wheels.iter().zip(wheels);
        slips
            .map(|(wheel, accumulator)| accumulator.finish(wheel))
            .collect()
    }

    fn one_wheel(samples: &[WheelSample]) -> Trace {
        let header = Header {
            wheels: vec![WheelHeader {
                radius_m: 0.05,
                axis: [0.0, 1.0],
                gamma_rad: std::f64::consts::FRAC_PI_4,
                ..WheelHeader::default()
            }],
            control_dt_s: 0.01,
            measure_to_s: 1.0,
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, samples.len());
        for sample in samples {
            let t_s = 0.01 * (trace.records().len() + 1) as f64;
            let record = Record {
                t_s,
                ..Record::default()
            };
            trace.push(record, &[*sample]);
        }
        trace
    }

    #[test]
    fn slip_is_measured_only_where_the_wheel_touches() {
        let slides = |rms_m_s, max_m_s, touching_share| WheelSample {
            slip_speed_rms_m_s: rms_m_s,
            slip_speed_max_m_s: max_m_s,
            touching: touching_share > 0.0,
            touching_share,
            load_share: if rms_m_s == 0.0 { 0.7 } else { 1.0 },
            rate_rad_s: 10.0,
            ..WheelSample::default()
        };
        let trace = one_wheel(&[
            slides(0.05, 0.07, 1.0),
            slides(9.0, 9.0, 0.0),
            slides(0.0, 0.0, 1.0),
            slides(0.05, 0.08, 0.5),
        ]);
        let slip = &per_wheel(&trace)[0];
        assert_eq!(slip.speed_max_m_s, Some(0.08));
        // One and a half of the two and a half periods in contact.
        let rms = (1.5 * 0.05_f64.powi(2) / 2.5).sqrt();
        assert!((slip.speed_rms_m_s.unwrap() - rms).abs() < 1e-15);
        // The rim runs at 0.5 m/s.
        assert!((slip.ratio.unwrap() - rms / 0.5).abs() < 1e-14);
        // All of one period and half of another of four; periods are differences of decimals.
        assert!((slip.lost_contact.unwrap() - 0.375).abs() < 1e-14);
        // One of the four touches and carries only a part.
        assert_eq!(slip.shared_contact, Some(0.25));
    }

    #[test]
    fn a_wheels_energies_are_those_of_its_last_row() {
        // Both are counted from the start, also in the air.
        let after = |slip_energy_j, spin_up_energy_j, touching| WheelSample {
            slip_energy_j,
            spin_up_energy_j,
            touching,
            ..WheelSample::default()
        };
        let trace = one_wheel(&[
            after(0.25, 0.125, true),
            after(0.5, 0.125, false),
            after(0.75, 0.375, false),
            after(0.75, 0.375, false),
        ]);
        let slip = &per_wheel(&trace)[0];
        assert_eq!((slip.energy_j, slip.spin_up_energy_j), (0.75, 0.375));
    }

    #[test]
    fn each_wheel_is_measured_by_its_own_radius_and_samples() {
        let wheel = |radius_m| WheelHeader {
            radius_m,
            ..WheelHeader::default()
        };
        let header = Header {
            wheels: vec![wheel(0.05), wheel(0.1)],
            ..Header::default()
        };
        let slides = |slip_speed_rms_m_s| WheelSample {
            slip_speed_rms_m_s,
            touching: true,
            touching_share: 1.0,
            rate_rad_s: -10.0,
            ..WheelSample::default()
        };
        let mut trace = Trace::with_capacity(header, 1);
        let record = Record {
            t_s: 0.01,
            ..Record::default()
        };
        trace.push(record, &[slides(0.01), slides(0.04)]);
        let ratios: Vec<_> = per_wheel(&trace).iter().map(|slip| slip.ratio).collect();
        // 1 cm/s of 0.5 m/s, and 4 cm/s of 1 m/s; one square root of a square each.
        assert!((ratios[0].unwrap() - 0.02).abs() < 1e-16);
        assert!((ratios[1].unwrap() - 0.04).abs() < 1e-16);
    }

    #[test]
    fn means_are_what_their_names_say_and_none_of_nothing() {
        let values = || [3.0, -4.0, 1.0, -4.0].into_iter();
        assert_eq!(mean(values()), Some(-1.0));
        assert_eq!(rms(values()), Some(10.5_f64.sqrt()));
        assert_eq!(peak_to_peak(values()), Some(7.0));
        let none = std::iter::empty::<f64>;
        assert_eq!(
            (mean(none()), rms(none()), peak_to_peak(none())),
            (None, None, None)
        );
    }

    #[test]
    fn a_hand_over_is_another_roller_and_not_the_same_one_come_back() {
        let carries = |roller, touching, roller_spin_rad_s| WheelSample {
            roller,
            touching,
            roller_spin_rad_s,
            roller_spin_ideal_rad_s: 10.0,
            ..WheelSample::default()
        };
        let trace = one_wheel(&[
            carries(8, true, 10.0),
            carries(0, true, 13.0), // once round
            carries(5, false, 99.0),
            carries(0, true, 10.0), // lost, and found again on the same roller
            carries(1, true, 14.0),
        ]);
        let slip = &per_wheel(&trace)[0];
        assert_eq!(slip.hand_overs, 2);
        // Off by 0, 3, 0, 4.
        assert_eq!(slip.roller_spin_error_rms_rad_s, Some(2.5));
    }

    /// A wheel without load and a wheel on ice have no utilisation of a limit.
    #[test]
    fn grip_is_used_only_where_there_is_some() {
        let sample = WheelSample {
            touching_share: 1.0,
            friction: 0.5,
            normal_force_n: 20.0,
            friction_used_max: 0.75,
            ..WheelSample::default()
        };
        assert_eq!(sample.friction_used(), Some(0.75));
        let (lifted, on_ice) = (
            WheelSample {
                normal_force_n: 0.0,
                ..sample
            },
            WheelSample {
                friction: 0.0,
                ..sample
            },
        );
        assert_eq!(
            (lifted.friction_used(), on_ice.friction_used()),
            (None, None)
        );
    }

    #[test]
    fn a_forward_drive_at_rim_speed_leaves_no_residual_whatever_the_handedness() {
        // Axis +y: u = n x k = +x, so that a wheel at 10 rad/s and rho = 5 cm drives forward at 0.5
        // m/s.
        for gamma_rad in [-0.25, 0.25].map(|x| x * std::f64::consts::PI) {
            let wheel = WheelHeader {
                position_m: [0.3, -0.2],
                radius_m: 0.05,
                gamma_rad,
                axis: [0.0, 1.0],
                ..WheelHeader::default()
            };
            let forward = Twist::new(0.5, 0.0, 0.0);
            assert!(
                constraint_residual_m_s(&wheel, forward, 10.0)
                    .expect("not steered")
                    .abs()
                    < 1e-15
            );
            // Standing wheel, dragged forward: it slides across its roller's axis at v cos gamma.
            let dragged = constraint_residual_m_s(&wheel, forward, 0.0).expect("not steered");
            assert!((dragged + 0.5 * gamma_rad.cos()).abs() < 1e-15);
            let steered = WheelHeader {
                is_steered: true,
                ..wheel
            };
            assert_eq!(constraint_residual_m_s(&steered, forward, 10.0), None);
        }
    }

    #[test]
    fn the_residual_is_what_is_left_along_the_rollers_axis_of_hub_and_rim() {
        // The hub moves with the body, (v_x - w b_y, v_y + w b_x); the rim takes the contact back
        // at rho q' along x. The roller gives way along u = (-sin gamma, cos gamma) and grips along
        // its axis, (cos gamma, sin gamma).
        let wheel = WheelHeader {
            position_m: [0.3, -0.2],
            radius_m: 0.05,
            gamma_rad: 0.6,
            axis: [0.0, 1.0],
            ..WheelHeader::default()
        };
        let (v_x, v_y, w, rate_rad_s) = (0.5, -0.3, 0.8, 7.0);
        let hub = [v_x - w * -0.2, v_y + w * 0.3];
        let along_axis = |[x, y]: [f64; 2]| x * 0.6_f64.cos() + y * 0.6_f64.sin();
        let expected = along_axis([0.05 * rate_rad_s, 0.0]) - along_axis(hub);
        let residual = constraint_residual_m_s(&wheel, Twist::new(v_x, v_y, w), rate_rad_s)
            .expect("not steered");
        // A dozen roundings of numbers below 1.
        assert!((residual - expected).abs() < 1e-15, "{residual} {expected}");
    }
}
