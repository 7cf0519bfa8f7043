//! Margins, step response and load response of the settings in force with a plant model, computed as for the rules.

use crate::bode;
use crate::margins::{self, Plant};
use crate::predict;
use crate::tune::{Controller, TuneRequest, Tuned, unknown};
use anyhow::Result;
use run::fmus::{Fmus, Values};
use run::system::Value;

/// Computes the effects of the settings in force. The rule, structure and speed of the request are ignored, and there
/// are no remarks.
///
/// # Errors
/// The FMU is not a controller, its P action is off, the model is not a valid plant, or the block cannot be simulated
/// with it.
pub fn in_force(home: &dyn Fmus, request: &TuneRequest) -> Result<Tuned> {
    request.model.check()?;
    let controller = Controller::new(home, &request.controller)?;
    let plant = Plant::of_model(&request.model, controller.sampling());
    let margins = margins::compute(&plant, &bode::law(home, &controller)?, controller.delay_of_pulses());
    let (predicted, told) = predict::predict(home, &controller, request, &Values::new())?;
    let mut absent = unknown(&margins);
    absent.extend(told.absent);
    let values = controller.roles.controller.iter().map(|name| (name.clone(), Value::Number(controller.value(name))));
    Ok(Tuned {
        values: values.collect(),
        dead_time: request.model.dead_time + controller.delay_of_calls(),
        closed_loop: None,
        pace: None,
        sensitivity: margins.sensitivity,
        gain_margin: margins.gain_margin,
        phase_margin: margins.phase_margin,
        predicted,
        absent,
        remarks: Vec::new(),
    })
}
