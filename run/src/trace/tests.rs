use super::*;

/// A trace of a sawtooth, a constant, a flag and a number that needs 64 bits.
fn trace(calls: usize) -> Trace {
    let mut trace = Trace::new(4);
    for call in 0..calls {
        trace.push(&row(call));
    }
    trace
}

fn row(call: usize) -> [f64; 4] {
    [(call % 777) as f64, -0.0, f64::from(u8::from(call.is_multiple_of(3))), call as f64 * 0.1]
}

#[test]
fn the_last_calls_are_there_with_all_bits() {
    for calls in [0, 1, 1023, 1024, 1025, 70_000, 200_000] {
        let trace = trace(calls);
        let exact = trace.exact();
        assert_eq!((trace.calls(), exact.end), (calls, calls));
        assert!(exact.len() >= calls.min(EXACT) && exact.len() <= EXACT + 2 * CHUNK, "{exact:?}");
        for call in exact.clone() {
            for (column, value) in row(call).into_iter().enumerate() {
                assert_eq!(trace.get(column, call).to_bits(), value.to_bits(), "{column} in call {call} of {calls}");
            }
        }
        assert!(trace.get(0, calls).is_nan());
        assert!(exact.start == 0 || trace.get(0, exact.start - 1).is_nan());
    }
}

#[test]
fn values_that_are_not_numbers_and_both_zeros_come_back() {
    let mut trace = Trace::new(1);
    let values = [0.0, -0.0, f64::NAN, f64::INFINITY, 1.0, 1e300, 0.1f32.into()];
    for call in 0..2 * CHUNK {
        trace.push(&[values[call % values.len()]]);
    }
    for call in 0..2 * CHUNK {
        assert_eq!(trace.get(0, call).to_bits(), values[call % values.len()].to_bits());
    }
}

#[test]
fn few_calls_are_shown_one_by_one() {
    let curves = trace(100).curves(&[0, 2], 10..13, 3);
    let expected =
        Curves { calls: vec![10, 11, 12], values: vec![vec![10.0, 11.0, 12.0], vec![0.0, 0.0, 1.0]], is_exact: true };
    assert_eq!(curves, expected);
}

#[test]
fn of_many_calls_each_group_has_its_lowest_and_its_highest_value_in_the_order_of_time() {
    let mut trace = Trace::new(1);
    for value in [3.0, 9.0, 1.0, 2.0, 5.0, 8.0, 4.0, f64::NAN] {
        trace.push(&[value]);
    }
    let curves = trace.curves(&[0], 0..8, 4);
    assert_eq!(curves.calls, [0, 3, 4, 7]);
    assert_eq!(curves.values, [[9.0, 1.0, 4.0, 8.0].map(|value| value)].map(|_| vec![9.0, 1.0, 8.0, 4.0]));
    assert!(!curves.is_exact);
}

/// Returns the minimum and maximum of what a trace has recorded.
fn expected(calls: Range<usize>) -> (f64, f64) {
    let values = calls.map(|call| row(call)[0]);
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

#[test]
fn a_peak_long_ago_is_still_seen() {
    let mut trace = Trace::new(1);
    for call in 0..500_000 {
        trace.push(&[if call == 1234 { 50.0 } else { 0.0 }]);
    }
    let curves = trace.curves(&[0], 0..500_000, 1000);
    assert_eq!(curves.values[0].iter().filter(|value| **value == 50.0).count(), 1);
    let place = curves.values[0].iter().position(|value| *value == 50.0).unwrap();
    assert!((curves.calls[place] as i64 - 1234).abs() <= 1000, "{}", curves.calls[place]);
    assert!(curves.calls.len() <= 1000 && curves.calls.is_sorted());
}

#[test]
fn an_overview_and_what_is_exact_make_one_curve() {
    let trace = trace(300_000);
    for (calls, points) in [
        (0..300_000, 40),
        (0..300_000, 1000),
        (200_000..300_000, 600),
        (0..10_000, 50),
        (5..6, 2),
        (299_000..300_000, 10),
    ] {
        let curves = trace.curves(&[0], calls.clone(), points);
        assert!(curves.calls.len() <= points && !curves.calls.is_empty() && curves.calls.is_sorted(), "{calls:?}");
        assert!(curves.calls.iter().all(|call| calls.contains(call)), "{calls:?}");
        assert!(curves.values[0].iter().all(|value| value.is_finite()), "{calls:?} {points}");
        let of = |better: fn(f64, f64) -> f64| curves.values[0].iter().copied().reduce(better).unwrap();
        let (low, high) = expected(calls.clone());
        // A bucket of the overview may begin before the first call.
        if calls.len() > 777 {
            assert_eq!((of(f64::min), of(f64::max)), (low, high), "{calls:?}");
        }
    }
}

#[test]
fn more_points_than_the_overview_has_leave_no_gaps() {
    let trace = trace(1_000_000);
    let curves = trace.curves(&[0], 0..100_000, 50_000);
    assert!(curves.values[0].iter().all(|value| value.is_finite()));
    assert!(curves.calls.is_sorted() && curves.calls.len() < 2 * BUCKETS);
    assert_eq!(*curves.calls.last().unwrap(), 99_999);
}

#[test]
fn variables_that_come_later_were_not_a_number_before() {
    let mut trace = trace(100_000);
    trace.widen(1);
    for call in 100_000..180_000 {
        let [a, b, c, d] = row(call);
        trace.push(&[a, b, c, d, call as f64]);
    }
    assert_eq!(trace.get(0, 179_999), row(179_999)[0]);
    assert_eq!((trace.get(4, 120_000), trace.exact().start < 120_000), (120_000.0, true));
    let curves = trace.curves(&[4, 0], 0..180_000, 180);
    assert!(curves.values[0][..90].iter().all(|value| value.is_nan()));
    assert!(curves.values[0][110..].iter().all(|value| value.is_finite()));
    assert!(curves.values[1].iter().all(|value| value.is_finite()));
}

#[test]
fn nothing_is_no_curve() {
    for trace in [trace(0), trace(100), trace(100_000)] {
        for calls in [0..0, 50..50, 200_000..300_000] {
            let curves = trace.curves(&[1], calls, 10);
            assert_eq!((curves.calls.len(), curves.values[0].len()), (0, 0));
        }
    }
}

#[test]
fn its_capacity_does_not_grow() {
    let mut trace = trace(150_000);
    let before = trace.capacity();
    for call in 150_000..1_000_000 {
        trace.push(&row(call));
    }
    assert!(trace.capacity() <= before + 16 * CHUNK, "{before} {}", trace.capacity());
}
