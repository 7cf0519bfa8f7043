//! The crate `fmi-rs`.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2False, fmi2Status, fmi2True};
use fmi_rs::fmi3::builder::FMU3Builder;
use fmi_rs::fmi3::types::fmi3Status;
use importers::{INTEGRAL, packed, packed_fmi3};

fn ok(status: fmi2Status) {
    assert!(status == fmi2Status::Ok, "{status:?}");
}

#[test]
fn cont_c_is_imported_without_a_finding_and_steps() {
    let builder = FMU2Builder::new(&packed("CONT_C")).unwrap();
    let description = &builder.model_description;
    let findings = format!("{:?}", description.validate());
    assert_eq!(findings, "[]", "problems in modelDescription.xml");
    let [man_on, sp_int, lmn_i, lmn_per, lmn] = ["MAN_ON", "SP_INT", "LMN_I", "LMN_PER", "LMN"]
        .map(|name| description.variable_by_name(name).unwrap().valueReference);

    let fmu = builder.loggingOn(true);
    let slave = fmu.instantiate_cs("controller").unwrap();
    ok(slave.setupExperiment(None, 0.0, None));
    ok(slave.enterInitializationMode());
    ok(slave.setBoolean(&[man_on], &[fmi2False]));
    ok(slave.setReal(&[sp_int], &[1.0]));
    ok(slave.exitInitializationMode());
    for (k, expected) in INTEGRAL.into_iter().enumerate() {
        ok(slave.doStep(k as f64, 1.0, fmi2True));
        let mut values = [0.0; 2];
        ok(slave.getReal(&[lmn_i, lmn], &mut values));
        assert_eq!(values, [f64::from(expected), f64::from(2.0 + expected)], "call {k}");
    }
    let mut word = [0];
    ok(slave.getInteger(&[lmn_per], &mut word));
    assert_eq!(word, [677], "2.45 * 276.48");
    ok(slave.terminate());
}

fn ok_3(status: fmi3Status) {
    assert!(status == fmi3Status::Ok, "{status:?}");
}

#[test]
fn cont_c_of_fmi_3_is_imported_without_a_finding_and_makes_its_calls_as_events() {
    let builder = FMU3Builder::new(&packed_fmi3("CONT_C")).unwrap();
    let description = &builder.model_description;
    let findings = format!("{:?}", description.validate());
    assert_eq!(findings, "[]", "problems in modelDescription.xml");
    let [man_on, sp_int, lmn_i, lmn_per, lmn] = ["MAN_ON", "SP_INT", "LMN_I", "LMN_PER", "LMN"]
        .map(|name| description.variable_by_name(name).unwrap().valueReference);

    let slave = builder.instantiate_cs("controller").unwrap();
    ok_3(slave.enterInitializationMode(None, 0.0, None));
    ok_3(slave.setBoolean(&[man_on], &[false]));
    ok_3(slave.setFloat32(&[sp_int], &[1.0]));
    ok_3(slave.exitInitializationMode());
    for (k, expected) in INTEGRAL.into_iter().enumerate() {
        let [mut again, mut end, mut nominals, mut states] = [true; 4];
        let mut next = None;
        ok_3(slave.updateDiscreteStates(&mut again, &mut end, &mut nominals, &mut states, &mut next));
        assert_eq!((again, end, next), (false, false, Some((k + 1) as f64)), "call {k}");
        let mut values = [0.0; 2];
        ok_3(slave.getFloat32(&[lmn_i, lmn], &mut values));
        assert_eq!(values, [expected, 2.0 + expected], "call {k}");
        ok_3(slave.enterStepMode());
        let ([mut event, mut early], mut last) = ([false; 2], 0.0);
        ok_3(slave.doStep(k as f64, 1.0, true, &mut event, &mut end, &mut early, &mut last));
        assert_eq!((event, early, last), (true, false, (k + 1) as f64), "call {k}");
        ok_3(slave.enterEventMode());
    }
    let mut word = [0];
    ok_3(slave.getInt16(&[lmn_per], &mut word));
    assert_eq!(word, [677], "2.45 * 276.48");
    ok_3(slave.terminate());
}
