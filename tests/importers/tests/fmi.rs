//! The crate `fmi` (rust-fmi).

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::traits::{FmiImport, FmiStatus};
use importers::{INTEGRAL, packed, packed_fmi3};

fn reference(fmu: &Fmi2Import, name: &str) -> u32 {
    let variables = &fmu.model_description().model_variables.variables;
    let variable = variables.iter().find(|variable| variable.name == name);
    variable.unwrap_or_else(|| panic!("{name} is not there")).value_reference
}

#[test]
fn cont_c_is_imported_and_steps() {
    let fmu: Fmi2Import = fmi::import::from_path(packed("CONT_C")).unwrap();
    let description = fmu.model_description();
    assert_eq!((description.model_name.as_str(), description.fmi_version.as_str()), ("CONT_C", "2.0"));
    let [man_on, sp_int, lmn_i, lmn_per, lmn] =
        ["MAN_ON", "SP_INT", "LMN_I", "LMN_PER", "LMN"].map(|name| reference(&fmu, name));

    let mut slave = fmu.instantiate_cs("controller", false, true).unwrap();
    assert_eq!((slave.get_version(), slave.get_types_platform()), ("2.0", "default"));
    slave.setup_experiment(None, 0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave.set_boolean(&[man_on], &[0]).unwrap();
    slave.set_real(&[sp_int], &[1.0]).unwrap();
    slave.exit_initialization_mode().unwrap();
    for (k, expected) in INTEGRAL.into_iter().enumerate() {
        slave.do_step(k as f64, 1.0, true).unwrap();
        let mut values = [0.0; 2];
        slave.get_real(&[lmn_i, lmn], &mut values).unwrap();
        assert_eq!(values, [f64::from(expected), f64::from(2.0 + expected)], "call {k}");
    }
    let mut word = [0];
    slave.get_integer(&[lmn_per], &mut word).unwrap();
    assert_eq!(word, [677], "2.45 * 276.48");
    slave.terminate().unwrap();
}

#[test]
fn a_state_of_cont_c_is_saved_serialized_and_restored() {
    let fmu: Fmi2Import = fmi::import::from_path(packed("CONT_C")).unwrap();
    let [man_on, sp_int, lmn_i] = ["MAN_ON", "SP_INT", "LMN_I"].map(|name| reference(&fmu, name));
    let mut slave = fmu.instantiate_cs("controller", false, true).unwrap();
    slave.set_boolean(&[man_on], &[0]).unwrap();
    slave.set_real(&[sp_int], &[1.0]).unwrap();
    slave.setup_experiment(None, 0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave.exit_initialization_mode().unwrap();
    slave.do_step(0.0, 1.0, true).unwrap();
    let state = slave.get_fmu_state().unwrap();
    let bytes = slave.serialize_fmu_state(&state).unwrap();

    let mut after_five_calls = || {
        for k in 1..5 {
            slave.do_step(f64::from(k), 1.0, false).unwrap();
        }
        let mut value = [0.0];
        slave.get_real(&[lmn_i], &mut value).unwrap();
        value[0]
    };
    assert_eq!(after_five_calls(), f64::from(INTEGRAL[4]));

    let mut other = fmu.instantiate_cs("other", false, true).unwrap();
    let restored = other.deserialize_fmu_state(&bytes).unwrap();
    other.set_fmu_state(&restored).ok().unwrap();
    for k in 1..5 {
        other.do_step(f64::from(k), 1.0, false).unwrap();
    }
    let mut value = [0.0];
    other.get_real(&[lmn_i], &mut value).unwrap();
    assert_eq!(value[0], f64::from(INTEGRAL[4]));
}

#[test]
fn cont_c_of_fmi_3_is_imported_and_makes_its_calls_as_events() {
    use fmi::EventFlags;
    use fmi::fmi3::import::Fmi3Import;
    use fmi::fmi3::{CoSimulation, Common, Fmi3Model, GetSet};

    let fmu: Fmi3Import = fmi::import::from_path(packed_fmi3("CONT_C")).unwrap();
    let [man_on, sp_int, lmn_i, lmn_per, lmn] = ["MAN_ON", "SP_INT", "LMN_I", "LMN_PER", "LMN"].map(|name| {
        let variable = fmu.model_description().model_variables.find_by_name(name);
        variable.unwrap_or_else(|| panic!("{name} is not there")).value_reference()
    });
    let mut slave = fmu.instantiate_cs("controller", false, true, true, false, &[]).unwrap();
    slave.enter_initialization_mode(None, 0.0, None).unwrap();
    slave.set_boolean(&[man_on], &[false]).unwrap();
    slave.set_float32(&[sp_int], &[1.0]).unwrap();
    slave.exit_initialization_mode().unwrap();
    for (k, expected) in INTEGRAL.into_iter().enumerate() {
        let mut flags = EventFlags::default();
        slave.update_discrete_states(&mut flags).unwrap();
        assert_eq!(flags, EventFlags { next_event_time: Some((k + 1) as f64), ..EventFlags::default() }, "call {k}");
        let mut values = [0.0; 2];
        slave.get_float32(&[lmn_i, lmn], &mut values).unwrap();
        assert_eq!(values, [expected, 2.0 + expected], "call {k}");
        slave.enter_step_mode().unwrap();
        let ([mut event, mut end, mut early], mut last) = ([false; 3], 0.0);
        slave.do_step(k as f64, 1.0, true, &mut event, &mut end, &mut early, &mut last).unwrap();
        assert_eq!((event, early, last), (true, false, (k + 1) as f64), "call {k}");
        slave.enter_event_mode().unwrap();
    }
    let mut word = [0];
    slave.get_int16(&[lmn_per], &mut word).unwrap();
    assert_eq!(word, [677], "2.45 * 276.48");
    slave.terminate().unwrap();
}
