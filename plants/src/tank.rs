//! TANK: a level with a nonlinear outflow, a plant for CONT_C.

use crate::dynamics::{analog, exp, exp_m1, limited, seconds};
use blocks::{Law, Response};

blocks::block! {
    /// Open tank whose outflow is proportional to the square root of the level: inflow valve in, level out.
    ///
    /// # Purpose
    ///
    /// A tank with an inflow valve and an outflow valve, for level loops: an integrating plant with slight
    /// self-regulation from its outflow. Its gain depends on the level, and it can overflow or run empty. The outflow
    /// valve, set by the consumers, is the disturbance.
    ///
    /// # Quick start
    ///
    /// 1. Connect LMN of the controller to VALVE and LEVEL to PV_IN, in m, or L_PER to PV_PER with PVPER_ON = TRUE and
    ///    PV_FAC = 0.02.
    /// 2. CYCLE: the same as the controller's. Step the controller first, then the tank.
    /// 3. Set DRAIN during the run to create a disturbance.
    ///
    /// For CONT_C: with m for setpoint and process value and CYCLE 1 s, GAIN 400, TI 100 s bring the level from 0.5 m
    /// to within 1 cm of 1 m in 140 s; opening DRAIN from 50 to 100 % then lowers it by 5.4 cm.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon level
    /// input VALVE 0,10
    /// input DRAIN 0,26
    /// box LIMIT_V 12,10 limit
    /// box LIMIT_D 12,26 limit
    /// text 12,13 "0 ... 100 %" middle
    /// text 12,29 "0 ... 100 %" middle
    /// box INLET 24,10 multiply with FLOW_MAX
    /// sum NET 38,10 left + bottom -
    /// box TANK 48,10 integrate with AREA L_START HEIGHT
    /// box OUTLET 38,26 root with CD A_OUT
    /// box ANALOG 67,18 "0 ... 27648" with L_PER_0 L_PER_100
    /// output INFLOW 35,4
    /// output OUTFLOW 40,19
    /// output FULL 50,3
    /// output LEVEL 62,10
    /// output L_PER 76,18
    /// box CALL 67,30 "every CYCLE" with CYCLE
    /// VALVE > LIMIT_V > INLET > NET > TANK > LEVEL
    /// 33,10 > y4 > INFLOW
    /// TANK.top > y3 > FULL
    /// 57,10 > y26 > OUTLET.right
    /// 59,10 > y18 > ANALOG > L_PER
    /// DRAIN > LIMIT_D > OUTLET
    /// OUTLET.top > NET.bottom
    /// 38,19 > OUTFLOW
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: LEVEL
    /// manipulated value: VALVE
    /// disturbances: DRAIN
    /// signal process value peripheral: L_PER
    ///
    /// [Manipulated value]
    /// VALVE
    /// [Disturbance]
    /// DRAIN
    /// [Tank]
    /// AREA, HEIGHT, FLOW_MAX, A_OUT, CD
    /// [Start]
    /// L_START
    /// [Peripheral process value]
    /// L_PER_0, L_PER_100
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```math
    /// \begin{aligned}
    /// \text{AREA}\,\dfrac{d\,\text{LEVEL}}{dt} &= \text{FLOW_MAX}\,\dfrac{\text{VALVE}}{100\,\%} \\
    /// &\quad - \text{CD}\,\text{A_OUT}\,\dfrac{\text{DRAIN}}{100\,\%}\,\sqrt{2\,g\,\text{LEVEL}}
    /// \end{aligned}
    /// ```
    ///
    /// The level, with VALVE and DRAIN within 0 ... 100 %:
    ///
    /// ```text
    /// INFLOW  = FLOW_MAX (VALVE / 100 %)
    /// OUTFLOW = CD A_OUT (DRAIN / 100 %) sqrt(2 g LEVEL)        g = 9.81 m/s2
    /// AREA dLEVEL/dt = INFLOW - OUTFLOW                         0 <= LEVEL <= HEIGHT
    /// L_PER = 27648 (LEVEL - L_PER_0) / (L_PER_100 - L_PER_0), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE.
    /// 2. Start: LEVEL is L_START. INFLOW and OUTFLOW are 0 until the first call: they depend on inputs.
    /// 3. Steady state: LEVEL = (INFLOW / (CD A_OUT (DRAIN / 100 %)))^2 / 2g. With the defaults, holding 1 m takes 31.9
    ///    l/min.
    /// 4. An empty tank has no outflow; a tank without inflow empties in finite time, not asymptotically.
    /// 5. Full: the excess of INFLOW over OUTFLOW spills over the edge, and FULL is TRUE. The tank stays full until
    ///    OUTFLOW exceeds INFLOW.
    /// 6. DRAIN, the opening of the outflow valve, is the disturbance. VALVE and DRAIN are limited to 0 ... 100 %.
    /// 7. L_PER is LEVEL as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range.
    ///
    /// # Limits of use
    ///
    /// Solved exactly for held inputs. The equation for the square root of the level has a closed-form solution for the
    /// time at which a level is reached; Newton's iteration inverts it to the last bits. So the result depends on CYCLE
    /// only through rounding (a few parts in 10^13). The results are the same to the last bit on every platform.
    ///
    /// The walls are vertical, and the flow does not affect the level above the opening.
    ///
    /// Bad input: with AREA not above 0 the tank has no volume and is always in steady state; FLOW_MAX, CD, A_OUT or
    /// HEIGHT below 0 count as 0.
    pub struct Tank as "TANK" {
        input {
            /// Opening of the inflow valve
            ///
            /// Connect LMN of the controller, limited to 0 ... 100 %. With the start values 35 % is 35 l/min, which
            /// holds 1.2 m with DRAIN = 50 %.
            valve: LReal = 0.0, min 0.0, max 100.0, unit "%";
            /// Disturbance: opening of the outflow valve
            ///
            /// The consumers' demand: a step from 50 to 100 % doubles the outflow at the same level.
            drain: LReal = 50.0, min 0.0, max 100.0, unit "%";
        }
        parameter {
            /// Level at the start
            ///
            /// Level before the first call, at most HEIGHT.
            l_start: LReal = 0.5, min 0.0, unit "m";
            /// Height of the wall, at which the tank overflows
            ///
            /// Anything above this spills over the edge, and FULL is TRUE. The controller does not notice: its process
            /// value stays at HEIGHT.
            height: LReal = 2.0, min 0.0, unit "m";
            /// Base area
            ///
            /// A wider tank is slower: the level rises by inflow minus outflow, divided by AREA. With 0.2 m2, an excess
            /// of 10 l/min is 5 cm per minute.
            area: LReal = 0.2, min 0.0, unit "m2";
            /// Inflow with the inflow valve open
            ///
            /// The gain of the inflow: 1 l/min per percent of VALVE with the start value.
            flow_max: LReal = 100.0, min 0.0, unit "l/min";
            /// Cross section of the outflow valve when open
            ///
            /// Together with CD it determines how fast the tank empties. The outflow is proportional to the square root
            /// of the level, so the gain of the plant is larger at a high level.
            a_out: LReal = 0.0004, min 0.0, unit "m2";
            /// Discharge coefficient of the outflow
            ///
            /// The jet is narrower than the opening: 0.6 for a sharp edge, up to 1 for a rounded one.
            cd: LReal = 0.6, min 0.0, max 1.0;
            /// Level at which L_PER is 0
            ///
            /// One end of the analog input's range: at this level and below, L_PER is 0. Set PV_OFF of the controller
            /// to the same value.
            l_per_0: LReal = 0.0, unit "m";
            /// Level at which L_PER is 27648
            ///
            /// The other end of the range: at this level and above, L_PER is 27648. Set PV_FAC of the controller to a
            /// hundredth of the span, 0.02 with the start values.
            l_per_100: LReal = 2.0, unit "m";
        }
        cycle {
            /// Time by which a call advances the tank
            ///
            /// The plant is solved exactly between two calls, so this time affects the result only through rounding.
            /// Set it to the controller's CYCLE or a fraction of it, and use a communication step of this time or a
            /// multiple of it.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Level, for PV_IN
            ///
            /// Connect it to PV_IN of the controller for a process value in m. Its range is 0 ... HEIGHT.
            level: LReal, from l_start height, unit "m";
            /// Level as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE. It saturates at the ends of its range.
            l_per: Word, from l_start height l_per_0 l_per_100;
            /// Flow into the tank
            ///
            /// FLOW_MAX times VALVE; 0 until the first call, because it depends on an input.
            inflow: LReal, unit "l/min";
            /// Flow out of the tank through the outflow valve
            ///
            /// Proportional to the square root of the level: four times the level gives twice the outflow. 0 until the
            /// first call.
            outflow: LReal, unit "l/min";
            /// The tank overflows
            ///
            /// TRUE while the tank is full and the inflow exceeds the outflow. Use it for an interlock that closes
            /// VALVE.
            full: Bool;
        }
    }
    memory Memory {
        /// The square root of the level.
        root: f64;
    }
}

/// Conversion factor from l/min to m3/s.
const LITRE_PER_MINUTE: f64 = 1.0 / 60_000.0;

/// Gravitational acceleration, in m/s2.
const G: f64 = 9.81;

impl Law for Tank {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[
        Response {
            title: "The inflow valve opens to 35 % and closes again; then the tank runs empty",
            calls: 1500,
            set: &[(0, "CYCLE", 2.0), (30, "VALVE", 35.0), (1000, "VALVE", 0.0)],
            show: &["VALVE", "LEVEL", "INFLOW", "OUTFLOW"],
        },
        Response {
            title: "DRAIN from 50 to 100 %: the outflow doubles at once, and the level falls to a quarter, from 1.2 m to 0.3 m",
            calls: 600,
            set: &[(0, "CYCLE", 2.0), (0, "VALVE", 35.0), (0, "L_START", 1.2044), (60, "DRAIN", 100.0)],
            show: &["DRAIN", "LEVEL", "INFLOW", "OUTFLOW"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
        self.memory.root = limited(self.l_start, 0.0, self.height.max(0.0)).sqrt();
        self.show();
    }

    fn call(&mut self) {
        let inflow = self.flow_max.max(0.0) * LITRE_PER_MINUTE * limited(self.valve, 0.0, 100.0) / 100.0;
        let opening = self.cd.max(0.0) * self.a_out.max(0.0) * limited(self.drain, 0.0, 100.0) / 100.0;
        let outflow_per_root = opening * (2.0 * G).sqrt();
        let brim = self.height.max(0.0).sqrt();

        // The level is monotonic while the inputs are held: a tank that fills up within the cycle stays full.
        let root = root_after(self.memory.root, inflow, outflow_per_root, self.area, seconds(self.cycle)).min(brim);
        self.memory.root = root;
        self.full = root >= brim && inflow > outflow_per_root * root;
        self.inflow = inflow / LITRE_PER_MINUTE;
        self.outflow = outflow_per_root * root / LITRE_PER_MINUTE;
        self.show();
    }
}

impl Tank {
    fn show(&mut self) {
        self.level = self.memory.root * self.memory.root;
        self.l_per = analog(self.level, self.l_per_0, self.l_per_100);
    }
}

/// Returns the root r of the level after `seconds`: `area d(r^2)/dt = inflow - outflow_per_root r`, from the root
/// `start`.
///
/// With the root `steady = inflow / outflow_per_root` at which inflow and outflow are equal, r approaches it as `r =
/// steady + (start - steady) exp(-p)`, where p grows with time by `steady p + (start - steady) (1 - exp(-p)) =
/// outflow_per_root seconds / (2 area)`.
fn root_after(start: f64, inflow: f64, outflow_per_root: f64, area: f64, seconds: f64) -> f64 {
    if area <= 0.0 || area.is_nan() {
        return if inflow > 0.0 || outflow_per_root > 0.0 { inflow / outflow_per_root } else { start };
    }
    let time = outflow_per_root * seconds / (2.0 * area);
    if inflow == 0.0 {
        return (start - time).max(0.0);
    }
    let steady = inflow / outflow_per_root;

    // The time for p, without a difference of nearly equal terms for small p. Its slope is the root itself; it curves
    // upwards while the tank fills and downwards while it empties. Newton's method therefore converges from one side,
    // without overshoot, if it starts above the solution while the tank fills and below it while the tank empties; it
    // ends when rounding stops it.
    let time_for = |p: f64| steady * bend(p) + start * -exp_m1(-p);
    let root_for = |p: f64| steady * -exp_m1(-p) + start * exp(-p);
    let fills = start < steady;
    let asymptote = (time + (steady - start)) / steady;
    let mut p = if fills {
        // For p up to 1, p + exp(-p) - 1 is above p^2 / 3, and 1 - exp(-p) above 0.6 p.
        let for_small_p = (3.0 * time / steady).sqrt().min(time / (0.6 * start));
        if for_small_p < f64::EPSILON {
            // With no or negligible outflow, the square of the root grows linearly.
            return (start * start + inflow * seconds / area).sqrt();
        }
        if for_small_p < 1.0 { asymptote.min(for_small_p) } else { asymptote }
    } else {
        asymptote.max(time / start)
    };
    for _ in 0..100 {
        let next = p - (time_for(p) - time) / root_for(p);
        let closer = if fills { next < p } else { next > p };
        if !closer {
            break;
        }
        p = next;
    }
    root_for(p)
}

/// Returns p + exp(-p) - 1 without cancellation for small p.
fn bend(p: f64) -> f64 {
    if p > 0.5 {
        return p + exp_m1(-p);
    }
    // p^2 / 2! - p^3 / 3! + ...: terms beyond the 16th power are negligible.
    let (mut sum, mut term) = (0.0, -p);
    for n in 2..=16 {
        term *= -p / f64::from(n);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, ContC, Stored, Time};

    fn started(tank: Tank) -> Tank {
        let mut tank = tank;
        tank.restart();
        tank
    }

    fn run(tank: &mut Tank, seconds: f64) {
        let calls = (seconds / crate::dynamics::seconds(tank.cycle)).round() as u32;
        (0..calls).for_each(|_| tank.call());
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    /// A tank in which the outflow at a root of 1 (a level of 1 m) lowers the root by 1 a second, with an area of 2 m2.
    fn unit_tank() -> Tank {
        Tank { area: 0.5, a_out: 1.0 / (2.0 * G).sqrt(), cd: 1.0, drain: 100.0, height: 1e6, ..Tank::default() }
    }

    #[test]
    fn it_starts_with_its_start_level_whatever_the_inputs_are() {
        let tank = started(Tank { valve: 100.0, drain: 100.0, l_start: 0.64, ..Tank::default() });
        assert_close(tank.level, 0.64, 1e-15);
        assert_eq!((tank.l_per.value(), tank.inflow, tank.outflow, tank.full), (8847, 0.0, 0.0, false));
        assert_eq!(started(Tank { l_start: 1e9, height: 4.0, ..Tank::default() }).level, 4.0);
        assert_eq!(started(Tank { l_start: -1.0, ..Tank::default() }).level, 0.0);
    }

    #[test]
    fn a_closed_or_empty_tank_stays_as_it_is_to_the_last_bit() {
        let mut tank = started(Tank { drain: 0.0, l_start: 0.7, ..Tank::default() });
        let level = tank.level;
        run(&mut tank, 1000.0);
        assert_eq!((tank.level, tank.outflow), (level, 0.0));
        let mut tank = started(Tank { l_start: 0.0, ..Tank::default() });
        run(&mut tank, 1000.0);
        assert_eq!((tank.level, tank.outflow), (0.0, 0.0));
    }

    #[test]
    fn the_steady_level_is_the_square_of_the_flow() {
        // 31.892 l/min: 0.6 * 0.0004 m2 * 50 % * sqrt(2 * 9.81 m/s2 * 1 m) * 60000.
        let mut tank = started(Tank { valve: 31.892, ..Tank::default() });
        run(&mut tank, 30_000.0);
        assert_close(tank.level, 1.0, 1e-5);
        assert_close(tank.outflow, tank.inflow, 1e-6);
        tank.valve /= 2.0;
        run(&mut tank, 30_000.0);
        assert_close(tank.level, 0.25, 1e-5);
        assert_eq!(tank.l_per.value(), 3456);
        let level = tank.level;
        run(&mut tank, 30_000.0);
        assert_close(tank.level, level, 1e-12);
    }

    #[test]
    fn without_inflow_the_root_of_the_level_falls_evenly_until_the_tank_is_empty() {
        let mut tank = started(Tank { l_start: 4.0, ..unit_tank() });
        for tenth in 1..=20 {
            tank.call();
            assert_close(tank.level, (2.0 - f64::from(tenth) / 10.0).powi(2), 1e-13);
        }
        run(&mut tank, 1.0);
        assert_eq!((tank.level, tank.outflow), (0.0, 0.0));
    }

    #[test]
    fn without_outflow_the_level_rises_evenly() {
        // 60 l/min into 0.2 m2: 5 mm/s.
        let mut tank = started(Tank { valve: 60.0, drain: 0.0, ..Tank::default() });
        run(&mut tank, 100.0);
        assert_close(tank.level, 1.0, 1e-13);
        // A negligible opening makes no difference.
        for a_out in [1e-12, 1e-300, 1e-320] {
            let mut leaking = started(Tank { valve: 60.0, a_out, ..Tank::default() });
            run(&mut leaking, 100.0);
            assert_close(leaking.level, 1.0, 1e-9);
        }
    }

    #[test]
    fn filling_and_emptying_follow_the_implicit_solution() {
        // dr/dt = (w - r) / r with the steady root w, so t = r0 - r + w ln((w - r0) / (w - r)).
        for (steady, start) in [(2.0, 0.0), (2.0, 1.9), (2.0, 2.1), (0.3, 3.0), (50.0, 0.001), (1e-6, 1.0)] {
            let mut tank = started(Tank { l_start: start * start, flow_max: 60_000.0 * steady, ..unit_tank() });
            tank.valve = 100.0;
            for call in 1..=20 {
                tank.call();
                let (root, t) = (tank.level.sqrt(), f64::from(call) / 10.0);
                if steady < 1e-3 && t > 0.9 {
                    assert!((0.9 * steady..0.11).contains(&root), "{root}");
                    continue;
                }
                let solution = start - root + steady * ((steady - start) / (steady - root)).ln();
                assert_close(solution, t, 1e-11);
            }
        }
    }

    #[test]
    fn it_agrees_with_an_integration_in_small_steps() {
        let mut tank = started(Tank { valve: 80.0, drain: 70.0, ..Tank::default() });
        let slope = |level: f64| (80.0 / 60_000.0 - 0.6 * 0.0004 * 0.7 * (2.0 * 9.81 * level).sqrt()) / 0.2;
        let mut level = 0.5;
        for _ in 0..50 {
            tank.call();
            for _ in 0..100 {
                let h = 0.001;
                let k1 = slope(level);
                let k2 = slope(level + h / 2.0 * k1);
                let k3 = slope(level + h / 2.0 * k2);
                let k4 = slope(level + h * k3);
                level += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            }
            assert_close(tank.level, level, 1e-13);
        }
    }

    #[test]
    fn it_overflows_at_its_height_until_more_flows_out_than_in() {
        let mut tank = started(Tank { valve: 100.0, l_start: 1.99, ..Tank::default() });
        tank.call();
        assert!(!tank.full && tank.level < 2.0);
        run(&mut tank, 100.0);
        assert!(tank.full);
        assert_close(tank.level, 2.0, 1e-15);
        assert_eq!(tank.l_per.value(), 27648);
        assert_close(tank.outflow, 31.892 * 2.0_f64.sqrt(), 1e-3);
        (tank.valve, tank.drain) = (0.0, 0.0);
        tank.call();
        assert!(!tank.full, "full to the brim, but nothing flows over it");
        tank.drain = 50.0;
        tank.call();
        assert!(!tank.full && tank.level < 2.0);
    }

    #[test]
    fn valve_and_drain_are_limited_to_0_and_100_percent() {
        let end = |valve, drain| {
            let mut tank = started(Tank { valve, drain, ..Tank::default() });
            run(&mut tank, 10.0);
            tank.level.to_bits()
        };
        assert_eq!(end(1e9, 1e9), end(100.0, 100.0));
        assert_eq!(end(-1e9, -1e9), end(0.0, 0.0));
        assert_eq!(end(f64::NAN, f64::NAN), end(0.0, 0.0));
    }

    #[test]
    fn the_result_does_not_depend_on_the_cycle() {
        let end = |cycle| {
            let mut tank = started(Tank { cycle: Time::ms(cycle), area: 0.01, height: 1.5, ..Tank::default() });
            let mut levels = vec![];
            for second in 0..1800 {
                if second % 60 == 0 {
                    tank.valve = f64::from(second / 60 * 37 % 101 - 20);
                    tank.drain = f64::from(second / 60 * 53 % 101);
                }
                run(&mut tank, 1.0);
                levels.push((tank.level, tank.full));
            }
            levels
        };
        let (coarse, fine) = (end(1000), end(10));
        assert!(coarse.iter().any(|level| level.1) && coarse.iter().any(|level| level.0 == 0.0));
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert_close(coarse.0, fine.0, 1e-10);
            assert_eq!(coarse.1, fine.1);
        }
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let mut tank = started(Tank { valve: 31.892, area: bad, ..Tank::default() });
            tank.call();
            assert_close(tank.level, 1.0, 1e-5);
            let (valve, level) = (tank.valve, tank.level);
            (tank.valve, tank.drain) = (0.0, 0.0);
            tank.call();
            assert_eq!(tank.level, level, "no flow at all");
            tank.valve = valve;
            tank.call();
            assert_close(tank.level, 2.0, 1e-15);
            assert!(tank.full);

            let mut tank = started(Tank { valve: 50.0, height: bad, ..Tank::default() });
            tank.call();
            assert_eq!((tank.level, tank.outflow, tank.full), (0.0, 0.0, true));

            let tank = Tank {
                valve: 50.0,
                flow_max: bad,
                cd: bad,
                a_out: bad,
                l_per_0: bad,
                l_per_100: bad,
                ..Tank::default()
            };
            let mut tank = started(tank);
            tank.call();
            assert_close(tank.level, 0.5, 1e-15);
            assert_eq!((tank.inflow, tank.outflow, tank.l_per.value()), (0.0, 0.0, 0));
            for tank in [Tank { cd: bad, ..Tank::default() }, Tank { a_out: bad, ..Tank::default() }] {
                let mut tank = started(tank);
                tank.call();
                assert_eq!(tank.outflow, 0.0);
            }
        }
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut tank = started(Tank { valve: 77.0, ..Tank::default() });
        run(&mut tank, 4.0);
        let mut bytes = vec![];
        tank.write(&mut bytes);
        let mut again = Tank::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            tank.call();
            again.call();
            for row in 0..Tank::TABLE.rows.len() {
                assert_eq!(tank.get(row), again.get(row));
            }
        }
    }

    #[test]
    fn cont_c_with_the_settings_of_the_documentation_does_what_it_says() {
        let mut tank = started(Tank::default());
        let mut controller =
            ContC { man_on: false, sp_int: 1.0, gain: 400.0, ti: Time::ms(100_000), ..ContC::default() };
        controller.restart();
        let (mut settled, mut above, mut below) = ([0; 2], f64::MIN, f64::MIN);
        for second in 0..1200 {
            let part = second / 600;
            tank.drain = [50.0, 100.0][part];
            controller.pv_in = tank.level as f32;
            controller.call();
            tank.valve = f64::from(controller.lmn);
            run(&mut tank, 1.0);
            if (tank.level - 1.0).abs() > 0.01 {
                settled[part] = second % 600 + 1;
            }
            if part == 0 {
                above = above.max(tank.level - 1.0);
            } else {
                below = below.max(1.0 - tank.level);
            }
        }
        assert!(settled[0] < 150 && settled[1] < 240, "settled after {settled:?} s");
        assert!(above < 0.01 && (below - 0.054).abs() < 0.0005, "{above} m above, {below} m below");
    }
}
