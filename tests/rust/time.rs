//! The time rule: the block is called at `t_k = startTime + k * CYCLE`, and a step makes every call with
//! `tc <= t_k < tc + h`, whatever the host's arithmetic makes of tc and h.
//!
//! The reference is a model in whole numbers: a host means the time `start + p / q` CYCLEs, with p and q whole, so that
//! the calls before it are exactly `ceil(p / q)`. What it hands over are the doubles that hosts compute for that time.

use blocks::Time;
use fmu::clock::{Calls, Clock};
use host::instance::Start;
use host::library::Opened;
use tests::{Instance, Random, Status, fmu_of, setting};

/// How a host comes by the doubles that it hands over.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Host {
    /// tc is computed anew for every point, h is the wanted step.
    Multiplies,
    /// tc += h.
    Adds,
    /// It adds up the time since the start, and tc is the start and that.
    AddsSinceTheStart,
    /// h is the difference of two points.
    Subtracts,
    /// Points are off by up to 3e-12 s.
    Noisy,
    /// Between two steps it makes one of 1e-16 s.
    WithResidualSteps,
    /// Between two steps it makes one of 0 s.
    WithStepsOfZero,
    /// h is rounded to 32 bits, as far as that is less than a quarter of a millionth of CYCLE.
    RoundsSteps,
}

const HOSTS: [Host; 8] = [
    Host::Multiplies,
    Host::Adds,
    Host::AddsSinceTheStart,
    Host::Subtracts,
    Host::Noisy,
    Host::WithResidualSteps,
    Host::WithStepsOfZero,
    Host::RoundsSteps,
];

const STARTS: [f64; 5] = [0.0, 1234.5, 1e5, 1e7, 1e9];

/// A time that a host means: p / q CYCLEs after the start.
#[derive(Clone, Copy, Debug)]
struct Point {
    p: i64,
    q: i64,
}

impl Point {
    /// How many calls lie before it.
    fn calls_before(self) -> i64 {
        -(-self.p).div_euclid(self.q)
    }

    /// In seconds from the start.
    fn seconds(self, cycle_ms: i64) -> f64 {
        (i128::from(self.p) * i128::from(cycle_ms)) as f64 / (1000 * self.q) as f64
    }
}

/// Walks along points and hands over what a host would: each step goes to `step`, with its number of calls. The points
/// have a common q.
fn walk(
    host: Host,
    start: f64,
    cycle_ms: i64,
    points: impl IntoIterator<Item = Point>,
    random: &mut Random,
    mut step: impl FnMut(f64, f64, i64),
) {
    let mut here = Point { p: 0, q: 1 };
    let (mut tc, mut since) = (start, 0.0);
    for there in points {
        let calls = there.calls_before() - here.calls_before();
        let next = start + there.seconds(cycle_ms);
        let wanted = Point { p: there.p - here.p * (there.q / here.q), q: there.q }.seconds(cycle_ms);
        let (point, h) = match host {
            Host::RoundsSteps if wanted * 1000.0 <= 8.0 * cycle_ms as f64 => (tc, f64::from(wanted as f32)),
            Host::RoundsSteps
            | Host::Multiplies
            | Host::Adds
            | Host::AddsSinceTheStart
            | Host::WithResidualSteps
            | Host::WithStepsOfZero => (tc, wanted),
            Host::Subtracts => (tc, next - tc),
            Host::Noisy => (tc + random.between(-3e-12, 3e-12), wanted),
        };
        step(point, h, calls);
        if host == Host::WithResidualSteps {
            step(point + h, 1e-16, 0);
        }
        if host == Host::WithStepsOfZero {
            step(next, 0.0, 0);
        }
        since += h;
        tc = match host {
            Host::Adds => tc + h,
            Host::AddsSinceTheStart => start + since,
            _ => next,
        };
        here = there;
    }
}

/// Points that end at `calls` calls: some steps shorter than a CYCLE, some of a few, some long.
fn random_points(random: &mut Random, q: i64, longest: i64, calls: i64) -> Vec<Point> {
    let mut points = Vec::new();
    let mut p = 0;
    while p < calls * q {
        p += match random.below(4) {
            0 => 1 + random.below(q as usize) as i64,
            1 => q * (1 + random.below(20) as i64),
            _ => 1 + random.below((longest * q) as usize) as i64,
        };
        points.push(Point { p: p.min(calls * q), q });
    }
    points
}

fn clock(start: f64, cycle_ms: i64) -> Clock {
    Clock::new(start, f64::INFINITY, Time::ms(cycle_ms as i32))
}

fn advance(clock: &mut Clock, tc: f64, h: f64) -> Calls {
    clock.advance(tc, h).unwrap_or_else(|refusal| panic!("{tc:?}, {h:?}: {}", refusal.reason()))
}

/// A counter that runs with this CYCLE.
fn counter(start: f64, stop: Option<f64>, cycle_ms: i64) -> Instance {
    let instance = Instance::new(fmu_of("counter"));
    instance.set("CYCLE", cycle_ms as f64 / 1000.0);
    instance.initialize(start, stop);
    instance
}

fn step(instance: &Instance, tc: f64, h: f64) {
    let status = instance.step(tc, h);
    assert!(status == Status::Ok, "doStep({tc:?}, {h:?}): {:?}", instance.log.take());
}

#[test]
fn a_hundred_million_calls_at_1_ms_in_random_steps_are_made_once_each_from_any_start_time() {
    let calls = setting("PLCFMU_TIME_CALLS", 100_000_000) as i64;
    let runs = [
        (Host::Multiplies, 0.0),
        (Host::Adds, 1234.5),
        (Host::AddsSinceTheStart, 1e7),
        (Host::Subtracts, 1e5),
        (Host::Noisy, 1e7),
        (Host::WithResidualSteps, 1e9),
        (Host::WithStepsOfZero, 1e7),
        // A 32-bit step is promised up to |t| / CYCLE = 1e8.
        (Host::RoundsSteps, 0.0),
    ];
    for (seed, (host, start)) in (0..).zip(runs) {
        let calls = if host == Host::RoundsSteps { calls.min(100_000_000) } else { calls };
        let mut random = Random::new(seed);
        let counter = counter(start, None, 1);
        let made = counter.fmu.reference("CALLS");
        let mut expected = 0;
        let points = random_points(&mut random.clone(), 64, 4000, calls);
        walk(host, start, 1, points, &mut random, |tc, h, calls| {
            step(&counter, tc, h);
            expected += calls;
            let made = counter.value(made);
            assert!(made == expected as f64, "{host:?} from {start:?}: {made} for {expected} calls at {tc:?}, {h:?}");
        });
        assert_eq!(expected, calls);
    }
}

#[test]
fn ten_million_steps_of_1_ms_make_one_call_each() {
    let steps = setting("PLCFMU_TIME_STEPS", 10_000_000);
    for start in [0.0, 1e9] {
        let counter = counter(start, None, 1);
        let made = counter.fmu.reference("CALLS");
        for k in 0..steps {
            let tc = start + k as f64 * 0.001;
            step(&counter, tc, 0.001);
            let calls = counter.value(made);
            assert!(calls == (k + 1) as f64, "from {start:?}: {calls} calls after step {k} at {tc:?}");
        }
    }
}

#[test]
fn ten_million_steps_of_1_ms_by_a_host_that_adds_up_its_time_make_one_call_each() {
    // The sum is 1.6e-6 s off in the end: 1600 times the tolerance.
    let counter = counter(0.0, None, 1);
    let made = counter.fmu.reference("CALLS");
    let mut tc = 0.0;
    for k in 0..10_000_000 {
        step(&counter, tc, 0.001);
        tc += 0.001;
        let calls = counter.value(made);
        assert!(calls == f64::from(k + 1), "{calls} calls after step {k} at {tc:?}");
    }
    assert_eq!(tc, 10_000.000001578517);
}

#[test]
fn every_host_gets_every_call_in_its_step_whatever_the_cycle_and_the_step() {
    let rounds = setting("PLCFMU_TIME_ROUNDS", 40);
    let cycles = [1, 2, 3, 7, 10, 33, 100, 999, 1000, 1001, 1009, 60_000, 86_400_000, i64::from(i32::MAX)];
    let starts = [0.0, 1234.5, 1e5, 1e7, 1e9, 0.1, -0.7, -1e6, -1234.5];
    for seed in 0..rounds {
        let random = &mut Random::new(seed);
        for cycle_ms in cycles {
            let (start, q) = (random.pick(&starts), random.pick(&[1, 2, 3, 7, 10, 64]));
            let (host, longest) = (random.pick(&HOSTS), random.pick(&[1, 3, 50, 100_000]));
            // A 32-bit step is promised up to |t| / CYCLE = 1e8.
            let start = if host == Host::RoundsSteps { start % 1e4 } else { start };
            let mut clock = clock(start, cycle_ms);
            let points = random_points(random, q, longest, longest * 300);
            let what = format!("seed {seed}: {host:?}, CYCLE {cycle_ms} ms, from {start:?}, q = {q}");
            let (mut next, mut here) = (0, start);
            walk(host, start, cycle_ms, points, random, |tc, h, calls| {
                let answer = advance(&mut clock, tc, h);
                assert!(answer.count as i64 == calls, "{what}: {answer:?} for {calls} calls at {tc:?}, {h:?}");
                if !matches!(host, Host::Adds | Host::AddsSinceTheStart) && calls > 0 {
                    // The first call lies that far from the start of the step.
                    let lead = start + (next * cycle_ms) as f64 / 1000.0 - tc;
                    let rounding = 2e-9 * cycle_ms as f64 + 8.0 * f64::EPSILON * (tc.abs() + start.abs());
                    assert!((answer.lead - lead).abs() <= rounding, "{what}: {answer:?}, not {lead:?} at {tc:?}");
                }
                next += calls;
                here = tc + h;
            });
            assert!(here >= start);
        }
    }
}

#[test]
fn one_step_of_up_to_four_billion_calls_makes_them_all() {
    let mut random = Random::new(1);
    for cycle_ms in [1, 3, 7, 100, 999, 1001, 1009, 1_000_003] {
        for start in [0.0, 1234.5, 1e9, -1e6] {
            for _ in 0..200 {
                let bits = 1 + random.below(32);
                let calls = 1 + random.below(1 << bits) as i64;
                let h = Point { p: calls, q: 1 }.seconds(cycle_ms);
                let count = advance(&mut clock(start, cycle_ms), start, h).count;
                assert_eq!(count as i64, calls, "CYCLE {cycle_ms} ms, from {start:?}, h = {h:?}");
            }
        }
    }
}

#[test]
fn two_hundred_billion_calls_drift_nowhere() {
    // In steps of a million: the error of h times 1000 adds up in every step.
    let steps = setting("PLCFMU_TIME_ROUNDS", 40) as i64 * 5_000;
    for cycle_ms in [1, 7, 999, 1001, 1009] {
        for host in HOSTS {
            let (mut clock, mut random) = (clock(0.0, cycle_ms), Random::new(cycle_ms as u64));
            let points = (1..=steps).map(|step| Point { p: step * 1_000_000, q: 1 });
            walk(host, 0.0, cycle_ms, points, &mut random, |tc, h, calls| {
                let made = advance(&mut clock, tc, h).count as i64;
                assert!(made == calls, "CYCLE {cycle_ms} ms, {host:?}: {made} for {calls} calls at {tc:?}, {h:?}");
            });
        }
    }
}

#[test]
fn a_step_of_a_tenth_of_cycle_calls_in_one_of_ten() {
    for start in STARTS {
        let counter = counter(start, None, 100);
        for i in 0..1000 {
            step(&counter, start + f64::from(i) * 0.01, 0.01);
            assert_eq!(counter.get("CALLS"), f64::from(i / 10 + 1), "from {start:?}, step {i}");
        }
    }
}

#[test]
fn two_points_a_millionth_of_cycle_apart_are_one() {
    for (cycle, start) in [(0.001, 0.0), (1.0, 0.0), (1.0, 1234.5), (100.0, 1e5), (2_147_483.0, 1e9)] {
        let calls_of = |h: f64| {
            let counter = counter(start, None, (cycle * 1000.0) as i64);
            step(&counter, start, h);
            counter.get("CALLS")
        };
        assert_eq!(calls_of(cycle * (1.0 + 0.5e-6)), 1.0, "CYCLE {cycle} s from {start:?}");
        assert_eq!(calls_of(cycle * (1.0 + 2e-6)), 2.0, "CYCLE {cycle} s from {start:?}");
        assert_eq!(calls_of(cycle * (1.0 - 2e-6)), 1.0, "CYCLE {cycle} s from {start:?}");
        assert_eq!(calls_of(cycle * 0.5e-6), 0.0, "CYCLE {cycle} s from {start:?}: not begun yet");
    }
}

#[test]
fn residual_steps_make_no_call_and_lose_none() {
    let counter = counter(1e5, None, 100);
    for k in 0..1000 {
        let tc = 1e5 + f64::from(k) * 0.1;
        for residual in [1e-16, 1e-17, 5e-324] {
            step(&counter, tc, residual);
            assert_eq!(counter.get("CALLS"), f64::from(k));
        }
        step(&counter, tc, 0.1);
        assert_eq!(counter.get("CALLS"), f64::from(k + 1));
    }
}

#[test]
fn a_step_of_0_makes_no_call_loses_none_and_shows_none_of_the_inputs() {
    let counter = counter(0.0, Some(5.0), 1000);
    for k in 0..5 {
        let tc = f64::from(k);
        counter.set("U", 7.0);
        step(&counter, tc, 0.0);
        assert_eq!(counter.get("CALLS"), f64::from(k), "no call yet at {tc}");
        counter.set("U", 1.0);
        step(&counter, tc, 1.0);
        assert_eq!((counter.get("CALLS"), counter.get("SUM")), (f64::from(k + 1), f64::from(k + 1)));
    }
    step(&counter, 5.0, 0.0);
    assert_eq!((counter.get("CALLS"), counter.get("SUM")), (5.0, 5.0), "at the stop time");
    for (tc, h) in [(4.5, 0.0), (5.5, 0.0), (5.0, -1e-9), (5.0, f64::NAN)] {
        assert_eq!(counter.step(tc, h), Status::Error, "{tc:?}, {h:?}");
    }
}

#[test]
fn a_host_whose_additions_all_round_up_is_followed_as_it_says() {
    // At 1e9 s a double has steps of 1.19e-7 s: 0.001 added is 0.00100004673 added, 47 cycles more in a million.
    let (start, steps) = (1e9, setting("PLCFMU_TIME_STEPS", 10_000_000) as i64 / 5);
    let counter = counter(start, None, 1);
    let made = counter.fmu.reference("CALLS");
    let mut tc = start;
    let mut before = 0.0;
    for k in 0..steps {
        step(&counter, tc, 0.001);
        tc += 0.001;
        let calls = counter.value(made);
        let cycles = (tc - start) * 1000.0;
        assert!((0.0..=2.0).contains(&(calls - before)), "{} calls in step {k} at {tc:?}", calls - before);
        assert!((calls - cycles).abs() <= 1.3, "{calls} calls within {cycles} cycles");
        before = calls;
    }
    let more = (tc - start - steps as f64 * 0.001) * 1000.0;
    assert!((more / steps as f64 - 46.7e-6).abs() < 1e-6, "{more} cycles more than steps");
}

#[test]
fn a_host_that_creeps_within_the_tolerance_is_followed_too() {
    // Each point lies half a millionth of a CYCLE before or behind the last step's end: after 2 million steps of CYCLE
    // the host has gone 1 cycle less or more than it stepped.
    let steps = setting("PLCFMU_TIME_STEPS", 10_000_000) * 2 / 5;
    for creep in [-0.5e-6, 0.5e-6] {
        let mut clock = clock(0.0, 1000);
        let (mut tc, mut calls) = (0.0, 0);
        for step in 0..steps {
            let made = advance(&mut clock, tc, 1.0).count;
            assert!(made <= 2, "{made} calls in step {step} at {tc:?}");
            calls += made;
            assert!((calls as f64 - (tc + 1.0)).abs() <= 1.1, "{calls} calls before {:?}", tc + 1.0);
            tc += 1.0 + creep;
        }
        let expected = steps as f64 * (1.0 + creep);
        assert!((calls as f64 - expected).abs() <= 1.1, "{calls} calls in {steps} steps that went {expected} cycles");
    }
}

#[test]
fn a_host_that_jumps_ahead_is_followed_and_the_calls_in_between_are_made() {
    let counter = counter(0.0, None, 1000);
    step(&counter, 0.0, 1.0);
    step(&counter, 10.0, 1.0);
    assert_eq!(counter.get("CALLS"), 11.0);
    step(&counter, 1e6, 0.5);
    assert_eq!(counter.get("CALLS"), 1_000_001.0);
}

#[test]
fn a_small_jump_is_followed_even_after_a_long_run_far_from_0() {
    // Two thousand additions at 1e9 s may have drifted by a quarter of a CYCLE. A point that is no sum of the last
    // point and step is not part of this drift.
    let mut clock = clock(1e9, 1);
    let mut tc = 1e9;
    for _ in 0..2000 {
        advance(&mut clock, tc, 0.001);
        tc += 0.001;
    }
    let position = |tc: f64| (tc - 1e9) * 1000.0;
    let mut calls = 2000;
    tc += 0.0001;
    for _ in 0..100 {
        calls += advance(&mut clock, tc, 0.0001).count as i64;
        tc += 0.0001;
        let expected = position(tc).ceil() as i64;
        // Within the resolution of a double there.
        let near = (position(tc) - position(tc).round()).abs() < 0.01;
        assert!(calls == expected || near && calls == expected - 1, "{calls} calls before {}", position(tc));
    }
}

#[test]
fn whatever_a_host_mixes_every_call_is_made_once_at_most_a_quarter_of_cycle_beside_its_step() {
    let cycles = [1, 2, 7, 10, 999, 1009, 60_000, i64::from(i32::MAX)];
    for seed in 0..setting("PLCFMU_TIME_ROUNDS", 40) {
        let random = &mut Random::new(seed);
        let (cycle_ms, start) = (random.pick(&cycles), random.pick(&[0.0, 1234.5, 1e5, 1e9, -0.7, -1e6, 3e10]));
        let cycle = cycle_ms as f64 / 1000.0;
        let mut clock = clock(start, cycle_ms);
        // Of all steps so far: where the host says the furthest ends, and how many calls they made.
        let (mut end, mut calls) = (start, 0);
        let mut habit = 0;
        for step in 0..20_000 {
            if random.once_in(50) {
                habit = random.below(6);
            }
            let h = match habit {
                0 => cycle,
                1 => cycle / 10.0,
                2 => cycle / 3.0,
                3 => cycle * 17.0,
                4 => cycle * random.between(0.001, 3.0),
                _ => random.pick(&[cycle, 1e-16, cycle * 0.9e-6]),
            };
            let tc = match random.below(200) {
                0 => end + cycle * random.between(0.0, 3.0),
                1..20 => end + cycle * random.between(-0.9e-6, 0.9e-6),
                20..40 => start + ((end - start) / cycle).ceil().max(0.0) * cycle,
                _ => end,
            };
            let made = advance(&mut clock, tc, h).count;
            end = end.max(tc + h);
            calls += made;
            let position = (end - start) / cycle;
            let near = 0.26 + 1e-15 * end.abs().max(start.abs()) / cycle;
            assert!(
                (calls as f64 - 1.0) < position + near && position - near <= calls as f64,
                "seed {seed}, CYCLE {cycle} s from {start:?}, step {step} at {tc:?}, {h:?}: {calls} calls within \
                 {position} cycles"
            );
        }
    }
}

#[test]
fn a_first_step_behind_the_start_time_makes_up_for_the_calls_since() {
    let counter = counter(100.0, None, 1000);
    step(&counter, 103.0, 1.0);
    assert_eq!(counter.get("CALLS"), 4.0);
}

/// Asks for a step that is to be refused: with a message that holds the words, and without any change.
fn refused(instance: &Instance, tc: f64, h: f64, words: &[&str]) {
    let before = instance.bytes();
    assert_eq!(instance.step(tc, h), Status::Error, "doStep({tc:?}, {h:?})");
    let log = instance.log.take();
    assert_eq!(log.len(), 1, "{log:?}");
    assert_eq!((log[0].status, log[0].category.as_str()), (Status::Error, "logStatusError"));
    for word in words.iter().chain(&["fmi2DoStep: "]) {
        assert!(log[0].text.contains(word), "{:?} does not say {word:?}", log[0].text);
    }
    assert_eq!(instance.bytes(), before, "doStep({tc:?}, {h:?}) was refused but changed something");
}

#[test]
fn a_point_behind_the_last_step_is_refused_with_both_numbers() {
    let counter = counter(0.0, None, 1000);
    refused(&counter, -1.0, 1.0, &["-1.0", "0.0"]);
    step(&counter, 0.0, 1.0);
    refused(&counter, 0.0, 1.0, &["= 0.0", "1.0"]);
    refused(&counter, 0.75, 1.0, &["0.75", "1.0"]);
    refused(&counter, 1.0 - 2e-6, 1.0, &["0.999998", "1.0"]);
    step(&counter, 1.0 - 0.5e-6, 1.0);
    assert_eq!(counter.get("CALLS"), 2.0);
}

#[test]
fn steps_that_are_no_time_are_refused_and_the_next_good_one_is_made() {
    let counter = counter(0.0, None, 1000);
    for h in [-5e-324, -1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&counter, 0.0, h, &["communicationStepSize", &format!("{h:?}")]);
    }
    for tc in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&counter, tc, 1.0, &["currentCommunicationPoint", &format!("{tc:?}")]);
    }
    step(&counter, 0.0, 1.0);
    assert_eq!(counter.get("CALLS"), 1.0);
}

#[test]
fn a_step_longer_than_a_day_makes_every_call() {
    let counter = counter(0.0, None, 1);
    step(&counter, 0.0, 100_000.5);
    assert_eq!(counter.get("CALLS"), 100_000_500.0);
}

#[test]
fn more_calls_than_a_step_may_hold_are_refused_whether_the_step_is_long_or_the_point_far_ahead() {
    let counter = counter(0.0, None, 1);
    refused(&counter, 0.0, 4_294_968.0, &["4294967296", "4294968.0"]);
    refused(&counter, 0.0, 1e300, &["4294967296", "1e300"]);
    // A host that is 1e9 s ahead by mistake would wait for 10^12 calls.
    refused(&counter, 1e9, 1.0, &["4294967296", "1000000000.0"]);
    refused(&counter, 4_294_967.0, 1.0, &["4294967296", "4294967.0"]);
    step(&counter, 0.0, 1.0);
    assert_eq!(counter.get("CALLS"), 1000.0);
}

#[test]
fn the_stop_time_is_reached_by_adding_up_and_not_passed() {
    for (start, h, cycle_ms) in [(0.0, 0.1, 100), (0.0, 0.01, 1), (1234.5, 0.1, 1000), (1e5, 0.001, 1), (1e7, 0.05, 10)]
    {
        let steps = 20_000;
        let stop = start + f64::from(steps) * h;
        let counter = counter(start, Some(stop), cycle_ms);
        let mut tc = start;
        for _ in 0..steps {
            step(&counter, tc, h);
            tc += h;
        }
        let expected = (f64::from(steps) * h * 1000.0 / cycle_ms as f64).round();
        assert_eq!(counter.get("CALLS"), expected, "from {start:?} to {stop:?} by {h:?}");
        refused(&counter, tc, h, &["stopTime", &format!("{stop:?}")]);
    }
}

#[test]
fn a_step_over_the_stop_time_is_refused_and_a_shorter_one_still_reaches_it() {
    let counter = counter(0.0, Some(10.0), 1000);
    step(&counter, 0.0, 9.5);
    refused(&counter, 9.5, 0.6, &["stopTime = 10.0"]);
    refused(&counter, 9.5, 0.5 + 2e-6, &["stopTime = 10.0"]);
    refused(&counter, 11.0, 0.1, &["stopTime = 10.0"]);
    step(&counter, 9.5, 0.5 + 0.5e-6);
    assert_eq!(counter.get("CALLS"), 10.0);
    refused(&counter, 10.0, 1.0, &["stopTime = 10.0"]);
}

#[test]
fn the_promise_holds_up_to_2_to_the_47_cycles_and_beyond_steps_are_refused() {
    for cycle_ms in [1, 10, 1000, i64::from(i32::MAX)] {
        let bound = 2f64.powi(47) * cycle_ms as f64 / 1000.0;
        for sign in [1.0, -1.0] {
            let start = sign * bound * 0.999;
            let mut clock = clock(start, cycle_ms);
            for k in 0..100_000 {
                let tc = start + Point { p: k, q: 1 }.seconds(cycle_ms);
                let h = start + Point { p: k + 1, q: 1 }.seconds(cycle_ms) - tc;
                assert_eq!(advance(&mut clock, tc, h).count, 1, "step {k} at {tc:?}");
            }
        }
        let start = bound * 1.001;
        let refusal = clock(start, cycle_ms).advance(start, cycle_ms as f64 / 1000.0).unwrap_err();
        assert!(refusal.reason().contains(&format!("{start:?}")), "{}", refusal.reason());
    }
}

#[test]
fn the_restart_is_made_once_when_initialization_ends_and_the_first_call_at_the_start_time() {
    let counter = Instance::new(fmu_of("counter"));
    counter.set("U", 5.0);
    assert_eq!(counter.get("RESTARTS"), 0.0);
    counter.initialize(7.0, None);
    assert_eq!((counter.get("RESTARTS"), counter.get("CALLS"), counter.get("SUM")), (1.0, 0.0, 0.0));
    step(&counter, 7.0, 1e-5);
    assert_eq!((counter.get("RESTARTS"), counter.get("CALLS"), counter.get("SUM")), (1.0, 1.0, 5.0));
}

#[test]
fn all_calls_of_a_step_see_the_input_that_was_set_before_it() {
    let counter = counter(0.0, None, 1000);
    counter.set("U", 3.0);
    step(&counter, 0.0, 4.0);
    counter.set("U", -1.0);
    step(&counter, 4.0, 0.5);
    step(&counter, 4.5, 1.5);
    // Calls 1 to 4 saw 3, calls 5 and 6 saw -1.
    assert_eq!(counter.get("SUM"), 4.0 * 3.0 - 2.0);
    assert_eq!(counter.get("WEIGHTED"), (1.0 + 2.0 + 3.0 + 4.0) * 3.0 - 5.0 - 6.0);
}

#[test]
fn an_input_with_a_derivative_is_extrapolated_to_each_call_and_is_afterwards_what_was_set() {
    let counter = counter(0.0, None, 1000);
    counter.set("U", 1.0);
    counter.set("R", 0.5);
    assert_eq!(counter.set_derivative("U", 1, 2.0), Status::Ok);
    assert_eq!(counter.set_derivative("R", 1, -0.25), Status::Ok);
    step(&counter, 0.0, 10.0);
    // 1, 3, 5, ... 19
    assert_eq!((counter.get("SUM"), counter.get("LAST"), counter.get("LAST_R")), (100.0, 19.0, 0.5 - 9.0 * 0.25));
    assert_eq!((counter.get("U"), counter.get("R")), (1.0, 0.5));
    assert_eq!(counter.get("WEIGHTED"), f64::from((1..=10).map(|k| k * (2 * k - 1)).sum::<i32>()));
}

#[test]
fn the_extrapolation_begins_at_the_step_not_at_the_call() {
    let counter = counter(0.0, None, 1000);
    step(&counter, 0.0, 0.25);
    counter.set("U", 10.0);
    counter.set_derivative("U", 1, 4.0);
    step(&counter, 0.25, 1.0);
    // The call at 1.0 lies 0.75 s behind the start of its step.
    assert_eq!((counter.get("CALLS"), counter.get("LAST")), (2.0, 13.0));
}

#[test]
fn derivatives_of_order_2_to_4_are_those_of_a_taylor_series() {
    for (order, expected) in [(2, 7.0 * 9.0 / 2.0), (3, 7.0 * 27.0 / 6.0), (4, 7.0 * 81.0 / 24.0)] {
        let counter = counter(0.0, None, 1000);
        counter.set("U", 1.0);
        counter.set_derivative("U", order, 7.0);
        step(&counter, 0.0, 4.0);
        assert_eq!(counter.get("LAST"), 1.0 + expected, "order {order}, 3 s after the start");
    }
}

#[test]
fn a_derivative_holds_until_it_is_taken_back() {
    let counter = counter(0.0, None, 1000);
    counter.set_derivative("U", 1, 1.0);
    step(&counter, 0.0, 2.0);
    assert_eq!(counter.get("LAST"), 1.0);
    step(&counter, 2.0, 2.0);
    assert_eq!(counter.get("LAST"), 1.0);
    counter.set_derivative("U", 1, 0.0);
    step(&counter, 4.0, 2.0);
    assert_eq!(counter.get("LAST"), 0.0);
}

#[test]
fn calls_that_are_made_up_for_see_the_input_as_it_is_at_the_begin_of_the_step() {
    let counter = counter(0.0, None, 1000);
    counter.set("U", 1.0);
    counter.set_derivative("U", 1, 2.0);
    step(&counter, 3.0, 2.0);
    // Calls at 0, 1, 2 are late, those at 3 and 4 in time.
    assert_eq!((counter.get("CALLS"), counter.get("SUM")), (5.0, 1.0 + 1.0 + 1.0 + 1.0 + 3.0));
}

#[test]
fn an_extrapolation_that_may_leave_the_inputs_range_is_refused_and_changes_nothing() {
    let counter = counter(0.0, None, 1000);
    counter.set("R", 1e38);
    counter.set_derivative("R", 1, 1e38);
    refused(&counter, 0.0, 100.0, &["R", "may leave its range"]);
    step(&counter, 0.0, 1.0);
    assert_eq!(counter.get("LAST_R"), f64::from(1e38f32));
    counter.set_derivative("R", 1, 0.0);
    counter.set_derivative("U", 4, 1e300);
    refused(&counter, 1.0, 1e3, &["U", "may leave its range"]);
}

#[test]
fn calls_are_no_events_in_fmi_2() {
    let fmu = fmu_of("counter");
    let start = Start { name: "x", guid: fmu.guid.to_str().unwrap(), has_events: true, ..Start::default() };
    let refused = host::instance::Instance::start(&Opened::V2(fmu.library.clone()), &start).unwrap_err();
    assert_eq!(refused.to_string(), "it is an FMI 2.0 FMU, which has no Event Mode");
}
