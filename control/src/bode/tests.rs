use super::*;
use doubles::TestHome;
use run::system::Value;

fn plotted(values: &[(&str, Value)]) -> Result<Bode> {
    let values = values.iter().map(|(name, value)| ((*name).to_string(), *value)).collect();
    let controller = Member { name: "TIC101".into(), fmu: "PID".into(), values };
    let model = Model { gain: 1.0, time_constant: 10.0, dead_time: 1.0, ..Model::default() };
    bode(&TestHome::default(), &BodeRequest { model, controller, others: vec![Values::new()] })
}

#[test]
fn a_loop_without_a_gain_is_refused_by_name() {
    let error = format!("{:#}", plotted(&[("GAIN", Value::Number(0.0))]).unwrap_err());
    assert_eq!(error, "GAIN is 0, so the loop has no Bode plot: choose a different GAIN");
}

#[test]
fn settings_that_change_nothing_have_the_same_curve_and_margins() {
    let Bode { frequencies, loops } = plotted(&[]).unwrap();
    assert_eq!(loops[0], loops[1]);
    assert!(frequencies.is_sorted() && frequencies.len() > 100);
    assert!(loops[0].amplitude.len() == frequencies.len() && loops[0].phase.len() == frequencies.len());
}
