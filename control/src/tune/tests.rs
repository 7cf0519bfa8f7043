use super::*;
use doubles::{FOREIGN, TestHome};

fn lag(gain: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain, time_constant, dead_time, ..Model::default() }
}

#[test]
fn the_ratio_of_heating_and_cooling_makes_both_equally_strong() {
    // Cooling is twice as strong: its pulses are half as long.
    let strong = ratio(&lag(1.0, 60.0, 5.0), &lag(2.0, 40.0, 4.0)).unwrap();
    assert_eq!((strong.ratio, strong.model), (0.5, lag(1.0, 60.0, 5.0)));
    assert_eq!(strong.remarks, [""; 0]);
    // Cooling is weaker: the pulses of heating are shorter. A cooling output of its own falls.
    let weak = ratio(&lag(1.5, 60.0, 2.0), &lag(-0.5, 40.0, 8.0)).unwrap();
    assert_eq!((weak.ratio, weak.model), (3.0, lag(0.5, 40.0, 8.0)));
    assert!(weak.remarks[0].starts_with("The dead times differ, 2 and 8 s"));
    assert!(
        ratio(&lag(20.0, 60.0, 5.0), &lag(1.0, 60.0, 5.0)).unwrap().remarks[0]
            .contains("RATIOFAC = 20 is outside 0.1 ... 10")
    );
    let integrating = Model { is_integrating: true, time_constant: 0.0, ..lag(1.0, 0.0, 5.0) };
    assert!(ratio(&lag(1.0, 60.0, 5.0), &integrating).is_err());
    assert!(
        format!("{:#}", ratio(&lag(0.0, 1.0, 1.0), &integrating).unwrap_err())
            .starts_with("heating: the plant's gain is 0")
    );
}

#[test]
fn a_number_is_rounded_to_its_significant_digits() {
    assert_eq!(
        [rounded(2.823_549, 5), rounded(-0.000_123_456, 5), rounded(98_765.4, 5), rounded(0.0, 5)],
        [2.8235, -0.000_123_46, 98_765.0, 0.0]
    );
}

#[test]
fn a_foreign_fmu_and_a_plant_have_no_settings_to_find() {
    let request = |fmu: &str| TuneRequest {
        model: lag(1.0, 10.0, 1.0),
        rule: Rule::Simc,
        structure: Structure::Pi,
        controller: Member { name: "TIC101".into(), fmu: fmu.into(), values: Values::default() },
        closed_loop: None,
        pace: None,
        step: Step::default(),
        band: None,
        ultimate: None,
        exchange: Exchange::default(),
    };
    let error = |fmu: &str| format!("{:#}", tune(&TestHome::default(), &request(fmu)).unwrap_err());
    assert!(error(FOREIGN).starts_with("FOREIGN is a foreign FMU"));
    assert!(error("LAG").starts_with("LAG is not a controller with a GAIN"));
}
