use super::*;
use doubles::TestHome;
use run::fmus::number_of;
use run::system::Value;
use std::fmt::Write;

/// SP, PV and OUT of the test's PI controller with GAIN 2, TI 20 s and CYCLE 0.5 s, computed here: `(time, sp, pv, out)`.
fn recorded(calls: usize) -> Vec<(f64, f32, f32, f32)> {
    recorded_with(calls, |_| (2.0, 20.0))
}

/// The same with a GAIN and a TI for each call.
fn recorded_with(calls: usize, settings: impl Fn(usize) -> (f32, f32)) -> Vec<(f64, f32, f32, f32)> {
    let mut integral = 0.0f32;
    let row = |call: usize| {
        let (sp, pv) = (if call < 4 { 10.0f32 } else { 30.0 }, 0.25 * (call % 7) as f32);
        let (e, (gain, ti)) = (sp - pv, settings(call));
        integral += e * (0.5 / ti) * gain;
        (call as f64 * 0.5, sp, pv, (gain * e + integral).clamp(0.0, 100.0))
    };
    (0..calls).map(row).collect()
}

fn text(header: &str, rows: &[(f64, f32, f32, f32)]) -> String {
    let mut text = format!("{header}\n");
    for (time, sp, pv, out) in rows {
        writeln!(text, "{time},{sp},{pv},{out}").unwrap();
    }
    text
}

fn member(values: &[(&str, f64)]) -> Member {
    let value = |(name, value): &(&str, f64)| (name.to_string(), Value::Number(*value));
    Member { name: "TIC101".into(), fmu: "PID".into(), values: values.iter().map(value).collect() }
}

fn request(text: String) -> ReplayRequest {
    ReplayRequest { controller: member(&[]), text, columns: Vec::new(), tolerance: None, try_suspects: true }
}

fn run(request: &ReplayRequest) -> Replayed {
    replay(&TestHome::default(), request).unwrap_or_else(|error| panic!("{error:#}"))
}

fn error(request: &ReplayRequest) -> String {
    format!("{:#}", replay(&TestHome::default(), request).unwrap_err())
}

/// Whether all calls are equal, bit for bit.
fn is_exact(replayed: &Replayed) -> bool {
    replayed.conclusion == Conclusion::Equal && replayed.outputs.iter().all(|of| of.largest == 0.0)
}

fn says(replayed: &Replayed, words: &str) -> bool {
    replayed.remarks.iter().any(|remark| remark.contains(words))
}

#[test]
fn columns_are_found_by_names_in_any_case_with_prefixes_and_by_roles() {
    let rows = recorded(30);
    for header in [
        "time,SP,PV,OUT",
        "t [s],sp,pv_in,out",
        "Zeit,Sollwert,Istwert,LMN",
        "time,TIC101.SP,TIC101.PV_IN,TIC101.OUT",
        "time,\"PLC_1/TIC101.in_SP\",PLC_1/TIC101.in_PV_IN,PLC_1/TIC101.out_OUT",
        "time,TIC101_SP,tic101_pv,TIC101_OUT",
        "time,SP [degC],PV [degC],OUT [%]",
    ] {
        let replayed = run(&request(text(header, &rows)));
        assert!(is_exact(&replayed) && replayed.calls == 30, "{header}: {replayed:?}");
        let variables: Vec<_> = replayed.columns.iter().map(|(_, variable)| variable.as_str()).collect();
        assert!(["SP", "PV_IN", "OUT"].iter().all(|name| variables.contains(name)), "{header}: {variables:?}");
        assert_eq!(replayed.outputs.len(), 1, "what is set is not compared with itself");
        assert_eq!(replayed.outputs[0].recorded.len(), 30);
    }
}

#[test]
fn a_setting_of_another_member_is_none_of_the_loop_and_one_that_changes_counts_as_recorded() {
    let mut text = String::from("time,TIC101.SP,TIC101.PV_IN,TIC101.OUT,TIC101.HIGH,PLANT.GAIN\n");
    for (at, (time, sp, pv, out)) in recorded(30).into_iter().enumerate() {
        let (high, out) = if at < 20 { (100, out) } else { (10, out.min(10.0)) };
        writeln!(text, "{time},{sp},{pv},{out},{high},7").unwrap();
    }
    let replayed = run(&request(text.clone()));
    assert!(is_exact(&replayed) && replayed.settings.is_empty(), "{replayed:?}");
    assert!(says(&replayed, "HIGH changes in the recording: the recorded values are used."), "{:?}", replayed.remarks);
    // It ends with another value than the loop has: equal is what the recording's values give, not those in force.
    let moving = |high: f64| {
        let [first, last, before] = [100.0, 10.0, high].map(Value::Number);
        Moving { name: "HIGH".into(), first, last, before }
    };
    assert_eq!(replayed.moving, [moving(100.0)]);
    let mut in_force = request(text);
    in_force.controller = member(&[("HIGH", 10.0)]);
    assert_eq!(run(&in_force).moving, []);
    assert!(says(&replayed, "PLANT.GAIN is not a variable of PID: ignored."), "{:?}", replayed.remarks);
}

#[test]
fn a_recording_that_says_nothing_about_the_settings_is_not_taken_for_a_proof() {
    let manual = run(&request("time,SP,PV,MAN_ON,OUT\n0,10,0,1,30\n0.5,10,1,1,30\n1,10,2,1,30\n".into()));
    assert!(is_exact(&manual) && manual.doubt == Some(Doubt::Manual), "{manual:?}");

    let mut in_loop = request("time,SP,PV,OUT\n0,10,0,30\n0.5,10,1,30\n1,10,2,30\n".into());
    in_loop.controller = member(&[("MAN", 30.0)]);
    in_loop.controller.values.insert("MAN_ON".into(), Value::Boolean(true));
    assert_eq!(run(&in_loop).doubt, Some(Doubt::ManualInLoop("MAN_ON".into())));

    let no_output = run(&request("time,SP,PV_IN,PV\n0,10,1,1\n0.5,10,2,2\n1,10,3,3\n".into()));
    assert_eq!(no_output.doubt, Some(Doubt::NotRecorded(["OUT", "UP", "DOWN"].map(String::from).into())));

    assert_eq!(run(&request(text("time,SP,PV,OUT", &recorded(30)))).doubt, None);
}

#[test]
fn the_user_may_choose_the_columns() {
    let rows = recorded(20);
    let mut request = request(text("a,b,c,d", &rows));
    let message = error(&request);
    assert!(message.contains("none of the columns (a, b, c, d) is an output of PID (OUT"), "{message}");
    let pair = |column: &str, variable: &str| (column.to_string(), variable.to_string());
    request.columns = vec![pair("a", "time"), pair("b", "SP"), pair("c", "PV_IN"), pair("d", "OUT")];
    let replayed = run(&request);
    assert!(is_exact(&replayed), "{replayed:?}");
    assert_eq!(replayed.outputs[0].times[3], 1.5);
    request.columns[1].1 = "SQ".into();
    assert!(error(&request).contains("PID has no variable SQ; did you mean SP?"));
    request.columns[1] = pair("x", "SP");
    assert!(error(&request).contains("the file has no column x"));
}

#[test]
fn a_difference_is_told_with_call_time_and_size() {
    let mut rows = recorded(40);
    rows[12].3 += 1.5;
    let replayed = run(&request(text("time,SP,PV,OUT", &rows)));
    let out = &replayed.outputs[0];
    assert_eq!((out.first, out.different), (Some((12, 6.0)), 1));
    assert!((out.largest - 1.5).abs() < 1e-5);
    assert_eq!(replayed.calls, 40);
}

#[test]
fn rows_with_the_outputs_of_the_call_before_are_found_though_the_end_of_the_recording_differs() {
    let mut rows = recorded(60);
    // PV is an output of the block, too.
    for row in (1..60).rev() {
        (rows[row].2, rows[row].3) = (rows[row - 1].2, rows[row - 1].3);
    }
    // From call 39 on, in row 40, something is different that the recording does not have; the last row has the output of call 58.
    rows[40..].iter_mut().for_each(|row| row.3 += 5.0);
    let replayed = run(&request(text("time,SP,PV,OUT", &rows)));
    assert!(says(&replayed, "Each row holds the outputs of the previous call"), "{:?}", replayed.remarks);
    let out = &replayed.outputs[0];
    assert_eq!((out.first, out.different), (Some((39, 19.5)), 20));
    assert!((out.largest - 5.0).abs() < 1e-5, "{}", out.largest);
}

#[test]
fn the_tolerance_of_the_user_is_all_that_is_allowed() {
    let mut rows = recorded(40);
    rows[12].3 += 1.5;
    let mut request = request(text("time,SP,PV,OUT", &rows));
    request.tolerance = Some(1.6);
    assert_eq!(run(&request).conclusion, Conclusion::Equal);
    request.tolerance = Some(1.4);
    request.try_suspects = false;
    assert_eq!(run(&request).conclusion, Conclusion::Differs);
    request.tolerance = Some(f64::NAN);
    assert!(error(&request).contains("the tolerance is NaN"));
}

#[test]
fn a_rounded_output_is_compared_to_half_of_its_last_digit() {
    let rows = recorded(40);
    let mut text = String::from("time;SP;PV;OUT\n");
    for (time, sp, pv, out) in &rows {
        writeln!(text, "{time:.1};{sp:.1};{pv:.2};{out:.1}").unwrap();
    }
    let mut request = request(text.replace('.', ","));
    let replayed = run(&request);
    assert!(replayed.conclusion == Conclusion::Equal && !is_exact(&replayed), "{replayed:?}");
    // A difference of a whole last digit is one.
    request.text = request.text.replacen("OUT\n0,0;10,0;0,00;20,5", "OUT\n0,0;10,0;0,00;20,7", 1);
    assert!(request.text.contains("20,7"), "{}", request.text);
    assert_eq!(run(&request).outputs[0].first.map(|first| first.0), Some(0));
}

#[test]
fn a_setpoint_whose_digits_were_cut_off_explains_what_the_integral_makes_of_them() {
    // A setpoint of 30.01346 that the file has as 30.013: 0.00046 * GAIN * CYCLE / TI in each of 400 calls is 0.0092, and 0.0009 is P.
    let (sp, mut integral) = (30.01346f32, 0.0f32);
    let mut text = String::from("time,SP,PV,OUT\n");
    for call in 0..400 {
        let pv = 30.0 + 0.25 * ((call % 7) as f32 - 3.0);
        integral += (sp - pv) * (0.5 / 20.0) * 2.0;
        let out = (2.0 * (sp - pv) + integral).clamp(0.0, 100.0);
        writeln!(text, "{:.1},{sp:.3},{pv:.3},{out:.3}", call as f64 * 0.5).unwrap();
    }
    let replayed = run(&request(text.clone()));
    assert_eq!(replayed.conclusion, Conclusion::Equal, "{replayed:?}");
    assert!((0.0096..0.0107).contains(&replayed.outputs[0].largest), "{}", replayed.outputs[0].largest);
    // One that was typed has no more digits than the file.
    assert_ne!(run(&request(text.replace(",30.013,", ",30.010,"))).conclusion, Conclusion::Equal);
}

#[test]
fn times_of_the_block_may_be_in_milliseconds() {
    let mut text = String::from("time,SP,PV,OUT,TI,CYCLE\n");
    for (time, sp, pv, out) in recorded(20) {
        writeln!(text, "{},{sp},{pv},{out},20000,500", time * 1000.0).unwrap();
    }
    let replayed = run(&request(text.clone()));
    assert!(is_exact(&replayed), "{replayed:?}");
    assert_eq!(replayed.outputs[0].times[2], 1.0);
    // Of the loop and the recording, the recording counts, and the user is told.
    let mut other = request(text);
    other.controller = member(&[("TI", 30.0)]);
    let replayed = run(&other);
    assert!(is_exact(&replayed), "{replayed:?}");
    let (value, before) = (Value::Number(20.0), Value::Number(30.0));
    assert_eq!(replayed.settings, [Change::Setting { name: "TI".into(), value, before, why: None }]);
}

#[test]
fn a_wrong_setting_is_named_and_its_value_given() {
    let rows = recorded(60);
    let mut request = request(text("time,SP,PV,OUT", &rows));
    request.controller = member(&[("TI", 1200.0)]);
    let replayed = run(&request);
    let (value, before) = (Value::Number(20.0), Value::Number(1200.0));
    let expected = Change::Setting { name: "TI".into(), value, before, why: Some(Why::NoMinutes) };
    assert_eq!(replayed.suspects[0].changes, [expected]);
    assert_eq!(replayed.conclusion, Conclusion::Cause);
    assert_eq!(replayed.suspects[0].values, Values::from([("TI".to_string(), Value::Number(20.0))]));
    assert!(replayed.suspects[0].fits && replayed.suspects[0].different == 0);
    request.try_suspects = false;
    assert!(run(&request).suspects.is_empty());
}

#[test]
fn a_last_row_that_repeats_the_outputs_is_a_call_if_the_block_repeats_them_too() {
    // At the limit the output repeats itself, also where the loop's own TI moves it still.
    let limited = recorded(60);
    assert!(limited[57..].iter().all(|row| row.3 == 100.0));
    // The end of a run has the inputs of then and the outputs of the last call.
    let mut ended = recorded(20);
    ended.push((10.0, 30.0, 1.5, ended[19].3));
    for ti in [20.0, 1200.0] {
        let replayed_of = |rows: &[(f64, f32, f32, f32)]| {
            let mut request = request(text("time,SP,PV,OUT", rows));
            request.controller = member(&[("TI", ti)]);
            run(&request)
        };
        let (limited, ended) = (replayed_of(&limited), replayed_of(&ended));
        assert_eq!((limited.calls, says(&limited, "The last row")), (60, false), "{ti}: {limited:?}");
        assert_eq!((ended.calls, says(&ended, "The last row (line 22) repeats")), (20, true), "{ti}: {ended:?}");
    }
}

/// What is said of a setting that was changed: its name, its value before and after, and its first call with its time.
fn since(replayed: &Replayed) -> Option<(&str, f64, f64, (usize, f64))> {
    let Since { change: Change::Setting { name, value, before, .. }, at, .. } = replayed.suspects[0].since.as_ref()?
    else {
        panic!("{replayed:?}");
    };
    Some((name, number_of(*before), number_of(*value), *at))
}

#[test]
fn a_setting_that_was_changed_by_hand_is_named_with_its_time_and_both_values() {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-6 * b;
    // The loop has the value before the change, that after it, or neither.
    for own in [2.0, 0.75, 1.5] {
        let rows = recorded_with(120, |call| (if call < 70 { 2.0 } else { 0.75 }, 200.0));
        let mut request = request(text("time,SP,PV,OUT", &rows));
        request.controller = member(&[("GAIN", own), ("TI", 200.0)]);
        let replayed = run(&request);
        assert_eq!(replayed.conclusion, Conclusion::Cause, "{own}: {:?}", replayed.suspects);
        let (name, before, value, at) = since(&replayed).expect("it was changed");
        assert!(name == "GAIN" && close(before, 2.0) && close(value, 0.75), "{own}: {:?}", replayed.suspects);
        assert_eq!(at, (70, 35.0), "{own}");
        // What is used then is what the block had at the end.
        let used = Values::from([("GAIN".to_string(), Value::Number(0.75))]);
        assert_eq!(replayed.suspects[0].values, if own == 0.75 { Values::new() } else { used }, "{own}");
        assert_eq!(replayed.suspects[0].changes.len(), usize::from(own != 2.0), "{own}");
    }
}

#[test]
fn a_change_that_two_settings_explain_is_named_with_both_and_one_that_few_rows_follow_is_not() {
    // Without the P action, a third of GAIN is three times TI.
    let integrals = |calls: usize| {
        let mut integral = 0.0f32;
        let rows = recorded(calls).into_iter().enumerate().map(move |(call, (time, sp, pv, _))| {
            integral += (sp - pv) * (0.5 / 200.0) * if call < 70 { 3.0 } else { 1.0 };
            (time, sp, pv, integral)
        });
        rows.collect::<Vec<_>>()
    };
    let changed = |calls| recorded_with(calls, |call| (if call < 70 { 2.0 } else { 0.75 }, 200.0));
    for (rows, values, conclusion) in [
        (integrals(120), [("GAIN", 3.0), ("TI", 200.0), ("P_SEL", 0.0)].as_slice(), Conclusion::Ambiguous),
        (changed(72), &[("GAIN", 2.0), ("TI", 200.0)], Conclusion::Unexplained),
    ] {
        let mut request = request(text("time,SP,PV,OUT", &rows));
        request.controller = member(values);
        if let Some(switch) = request.controller.values.get_mut("P_SEL") {
            *switch = Value::Boolean(false);
        }
        let replayed = run(&request);
        assert_eq!(replayed.outputs[0].first.map(|first| first.0), Some(70), "{values:?}");
        assert_eq!(replayed.conclusion, conclusion, "{values:?}: {:?}", replayed.suspects);
        let told: Vec<_> =
            replayed.suspects.iter().filter(|suspect| suspect.fits).map(|of| of.values.clone()).collect();
        let both =
            [("GAIN", 1.0), ("TI", 600.0)].map(|(name, value)| Values::from([(name.into(), Value::Number(value))]));
        assert_eq!(told, if conclusion == Conclusion::Ambiguous { both.into() } else { Vec::new() });
    }
}

/// Of ten calls one is in a row. With a call for each row, a TI of less than 2 s would come nearest, and be false: it is 20 s.
#[test]
fn a_recorder_slower_than_the_block_tells_no_setting() {
    let mut integral = 0.0f32;
    let row = |call: usize| {
        let (sp, pv) = (if call < 300 { 10.0f32 } else { 11.0 }, 9.0);
        integral += (sp - pv) * (0.5 / 20.0) * 2.0;
        (call as f64 * 0.5, sp, pv, 2.0 * (sp - pv) + integral)
    };
    let rows: Vec<_> = (0..600).map(row).collect();
    let each = run(&request(text("time,SP,PV,OUT", &rows)));
    assert_eq!(each.conclusion, Conclusion::Equal);
    let tenth: Vec<_> = rows.into_iter().step_by(10).collect();
    let replayed = run(&request(text("time,SP,PV,OUT", &tenth)));
    assert_eq!(replayed.conclusion, Conclusion::Coarse, "{:?}", replayed.suspects);
    assert!(replayed.suspects.iter().all(|suspect| !suspect.fits));
}

#[test]
fn what_no_suspect_explains_is_said() {
    let mut rows = recorded(60);
    for (number, row) in rows.iter_mut().enumerate() {
        row.3 = (number * number % 97) as f32;
    }
    let replayed = run(&request(text("time,SP,PV,OUT", &rows)));
    assert!(replayed.suspects.iter().all(|suspect| !suspect.fits));
    assert_eq!(replayed.conclusion, Conclusion::Unexplained);
}

#[test]
fn missing_values_are_held_and_not_compared_and_it_is_said_where_they_are() {
    let mut text = String::from("time,SP,PV,OUT\n");
    for (number, (time, sp, pv, out)) in recorded(40).into_iter().enumerate() {
        let sp = if number % 3 == 1 && number != 4 { String::new() } else { sp.to_string() };
        let out = if number == 20 { "NaN".into() } else { out.to_string() };
        writeln!(text, "{time},{sp},{pv},{out}").unwrap();
    }
    let replayed = run(&request(text));
    assert!(is_exact(&replayed), "{replayed:?}");
    // Of 40 rows behind the header, 1, 7, 10 ... 37 have no setpoint.
    for remark in [
        "Line 3, column SP: no value (nor in 11 later rows); the previous value is used. Complete the file, or \
         remove the rows.",
        "Line 22, column OUT: no value; nothing is compared there. Complete the file, or remove the rows.",
    ] {
        assert!(says(&replayed, remark), "{:?}", replayed.remarks);
    }
}

#[test]
fn what_the_recording_lacks_is_said() {
    let rows = recorded(20);
    let replayed = run(&request(text("x,SP,quality,OUT", &rows)));
    assert!(says(&replayed, "The recording has no PV_IN: a constant 0 is used."), "{:?}", replayed.remarks);
    assert!(says(&replayed, "x, quality are not variables of PID"), "{:?}", replayed.remarks);
    assert!(
        says(&replayed, "The recording has no time column: each row counts as one call."),
        "{:?}",
        replayed.remarks
    );
    let slow: Vec<_> = rows.iter().map(|row| (row.0 * 20.0, row.1, row.2, row.3)).collect();
    let replayed = run(&request(text("time [s],SP,PV,OUT", &slow)));
    assert!(says(&replayed, "Most rows are 10 s apart, but the block is called every 0.5 s"), "{:?}", replayed.remarks);
}

#[test]
fn values_that_the_block_does_not_take_are_refused_with_their_line() {
    let mut rows = recorded(5);
    rows[2].1 = f32::INFINITY;
    let message = error(&request(text("time,SP,PV,OUT", &rows)));
    assert!(message.starts_with("line 4, column SP: inf is not a valid value for SP"), "{message}");
    let message = error(&request("time,MAN_ON,OUT\n0,1,1\n1,2,1\n".into()));
    assert!(message.starts_with("line 3, column MAN_ON: 2.0 is not a valid value for MAN_ON"), "{message}");
    assert!(error(&request("time,OUT\n0,1\n1,1\n".into())).contains("is an input of PID"));
    let mut request = request("time,SP,OUT\n0,1,1\n".into());
    request.controller = member(&[("GIAN", 1.0)]);
    assert!(error(&request).contains("no setting GIAN; did you mean GAIN?"));
    request.controller.fmu = "FOREIGN".into();
    assert!(error(&request).contains("foreign") || error(&request).contains("no FMU"));
}

#[test]
fn a_long_recording_is_thinned_for_drawing_and_keeps_its_first_difference() {
    let mut rows = recorded(30_000);
    rows[17_777].3 += 0.5;
    let mut request = request(text("time,SP,PV,OUT", &rows));
    request.try_suspects = false;
    let out = &run(&request).outputs[0];
    assert!(out.times.len() <= MOST_POINTS && out.times.len() > MOST_POINTS / 4);
    assert_eq!(out.first, Some((17_777, 8888.5)));
    assert!(out.times.contains(&8888.5));
}

#[test]
fn two_rows_and_one_row_are_enough() {
    for calls in [1, 2] {
        let replayed = run(&request(text("time,SP,PV,OUT", &recorded(calls))));
        assert_eq!(replayed.calls, calls);
        assert_eq!(replayed.conclusion, Conclusion::Equal, "{replayed:?}");
    }
}
