//! The crate `fmi-rs`.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2False, fmi2Status, fmi2True};
use importers::{INTEGRAL, packed};

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
