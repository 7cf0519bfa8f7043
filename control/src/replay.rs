//! Runs the block with the inputs recorded at a plant: does it compute the same outputs as the plant's block?
//!
//! Each row of the file is a call: the recorded inputs and parameters of the block are set before it, and the recorded
//! outputs are compared after it. Values are equal if they have the same bits as a REAL. Otherwise, they may differ by
//! half of the column's last digit (0.0005 in a column with three decimals), because further digits are unknown, or by
//! 16 times the resolution of REAL at the largest value, because each call rounds, whichever is larger. The inputs in
//! the file are rounded in the same way, and the block amplifies and integrates these errors. Therefore, the effect of
//! changing the measured inputs by half of their last digit, computed by the block itself, is allowed as well. A
//! tolerance in the request replaces all of this.
//!
//! If the outputs differ, the cause is searched for in this order: the mode, if it was not recorded; the time between
//! two calls, if it disagrees with the recorded times (if these leave no alternative, the time they imply is used for
//! the rest of the search); one setting, then two, with values estimated by means of the block itself; and a setting
//! that was changed during the recording. An explanation is certain if it is the only one and its values are
//! unambiguous; otherwise, the conclusion is that the recording does not reveal the cause.
//!
//! The block's history before the first row is in its memory and not in the file. If the file begins with a restart
//! (COM_RST is TRUE), that is row 0. Otherwise, the block either is brought to the recorded manipulated value in manual
//! mode or begins with a restart, whichever fits better.

mod change;
mod columns;
mod compare;
mod estimate;
mod instance;
mod midway;
mod suspects;

use crate::csv::CsvTable as Csv;
use crate::identify::noise;
use anyhow::{Context, Result, bail};
pub use change::{Change, Doubt, Moving, Since, Why};
use columns::Recording;
use compare::Comparison;
use instance::{Beginning, Block, Variant};
use midway::Midway;
use modeldescription::digits::short;
use run::fmus::{Fmus, Member, Values, number_of};
use serde::{Deserialize, Serialize};

/// The maximum number of output values compared, rows times columns.
const MOST_VALUES: usize = 8 << 20;

/// If a different setting reduces the number of differing pulses by this factor, the last digits alone do not explain
/// the differences.
const CLEARER: usize = 4;

/// An explanation that leaves a deviation above this multiple of half the last digit is accepted only if no change to a
/// setting during the recording leaves a smaller one.
const FAR: f64 = 4.0;

/// The rounding of measured values may look like a setting that differs by up to this fraction.
const LARGE: f64 = 0.05;

/// The maximum number of rows per curve in the result.
const MOST_POINTS: usize = 8_000;

/// The recording to replay, and the block.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct ReplayRequest {
    /// The block with its settings in the loop.
    pub controller: Member,
    /// The text of the CSV file.
    pub text: String,
    /// The assignment of columns to variables of the block, or to `time`. By default, columns are matched by name.
    #[serde(default)]
    pub columns: Vec<(String, String)>,
    /// The deviation up to which a value counts as equal; by default, it depends on the digits in the recording.
    #[serde(default)]
    pub tolerance: Option<f64>,
    /// Whether to search for the cause if the outputs differ.
    #[serde(default)]
    pub try_suspects: bool,
}

/// The result of a replay.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Replayed {
    /// The assignment of columns to variables of the block.
    pub columns: Vec<(String, String)>,
    /// The number of calls made.
    pub calls: usize,
    /// One for each output in the file.
    pub outputs: Vec<Compared>,
    /// The settings whose recorded values differ from the loop's: the recorded ones were used.
    pub settings: Vec<Change>,
    /// The settings that change during the recording and end with a value other than the loop's: the recorded values
    /// were used.
    pub moving: Vec<Moving>,
    /// The explanations that reduce the differences, best first.
    pub suspects: Vec<Suspect>,
    /// The conclusion.
    pub conclusion: Conclusion,
    /// The reason why equal outputs prove nothing about the controller's settings; `None` if the recording depends on
    /// them.
    pub doubt: Option<Doubt>,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// The conclusion from a recording about a block.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Conclusion {
    /// The block computes the recorded outputs.
    #[default]
    Equal,
    /// The pulses differ in no more rows than rounding of the measured values explains: nothing indicates a different
    /// setting.
    Rounded,
    /// The outputs differ, and no cause was searched for.
    Differs,
    /// The first suspect is the cause: it explains everything, and nothing else does.
    Cause,
    /// The first suspect is the likeliest cause: it is the only full explanation that changes only controller settings.
    LikelyCause,
    /// A change explains everything, but so do other changes or other values: the recording does not distinguish them.
    Ambiguous,
    /// The block was called between the rows: the recording reveals nothing about the settings.
    Coarse,
    /// No change that was tried explains everything.
    Unexplained,
}

/// An output, recorded and computed.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Compared {
    /// The name of the output.
    pub variable: String,
    /// The 0-based index of the first call that differs, with its time in seconds.
    pub first: Option<(usize, f64)>,
    /// The number of calls in which it differs.
    pub different: usize,
    /// The largest difference between a recorded and a computed value.
    pub largest: f64,
    /// The largest deviation that counts as equal.
    pub allowed: f64,
    /// The noise of the recorded or the computed values, whichever is larger: the standard deviation of the changes
    /// from row to row without a trend. 0 for a switch.
    pub noise: f64,
    /// The times of the curves to draw, in seconds.
    pub times: Vec<f64>,
    /// The recorded values at these times.
    pub recorded: Vec<f64>,
    /// The values computed by the block at these times.
    pub computed: Vec<f64>,
}

/// An explanation that was tried: one or more changes.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Suspect {
    /// The changes that apply from the start.
    pub changes: Vec<Change>,
    /// The change made during the recording, if any.
    pub since: Option<Since>,
    /// The range of values that explain the recording equally well, if a single numeric setting was changed, from the
    /// start or during the recording; `None` if the range is too narrow to report.
    pub range: Option<(f64, f64)>,
    /// Other settings that may be wrong instead or as well: changed together with another value of the suspect's
    /// setting, they explain the recording equally well.
    pub confused: Vec<String>,
    /// The changed settings with their values; for one that changed during the recording, its value at the end.
    pub values: Values,
    /// The number of calls that still differ.
    pub different: usize,
    /// The largest difference that remains.
    pub largest: f64,
    /// Whether no difference remains.
    pub fits: bool,
    /// Whether it is certain: it is the only full explanation, and its values are unambiguous.
    pub is_sure: bool,
    /// Whether it fits only if the last row, which repeats all outputs, is not a call.
    pub ends_without_call: bool,
}

/// Replays a recording.
///
/// # Errors
/// The block does not exist or rejects a value, or the file cannot be read or has no column for the block.
pub fn replay(home: &dyn Fmus, request: &ReplayRequest) -> Result<Replayed> {
    let fmu = &request.controller.fmu;
    let table = home.table(fmu)?;
    let table = table.with_context(|| format!("{fmu} is a foreign FMU: only FMUs built by plcfmu can be replayed"))?;
    let dialog = home.dialog(fmu, &table).with_context(|| fmu.clone())?;
    if request.tolerance.is_some_and(|tolerance| !(tolerance >= 0.0 && tolerance.is_finite())) {
        bail!("the tolerance is {:?}: it must be 0 or more", request.tolerance.unwrap_or_default());
    }
    let csv = Csv::read(&request.text)?;
    let block = Block::new(home, &request.controller, &dialog)?;
    let mut remarks = csv.remarks.clone();
    let recording = Recording::new(&block, &csv, &request.columns, &mut remarks)?;
    let values = recording.rows.saturating_mul(recording.outputs.len());
    if values > MOST_VALUES {
        bail!(
            "the recording has {} rows with {} outputs; at most {MOST_VALUES} values are compared: cut out the part of interest, or \
             omit columns",
            recording.rows,
            recording.outputs.len()
        );
    }
    let tolerance = request.tolerance;
    let (base, suspects) = explained(&Comparison::new(&block, &recording, tolerance), request.try_suspects)?;
    let mut reading = Reading { recording, base, suspects, is_late: false, is_rounded: false };
    if reading.base.different() > 0 && reading.recording.rows > 2 {
        reading = read_otherwise(&block, &csv, request, reading, &mut remarks)?;
    }
    let Reading { recording, base, suspects, is_late, is_rounded } = reading;
    if is_late {
        remarks.push(
            "Each row holds the outputs of the previous call, as in a loop with parallel exchange: they are compared \
             with that call."
                .into(),
        );
    }
    let comparison = Comparison::new(&block, &recording, tolerance);
    remarks.extend(beginning(&block, &recording, &base.variant));
    remarks.extend(unknown_stops(&block, &recording).filter(|_| base.different() > 0));
    if !suspects.iter().any(|suspect| suspect.fits) {
        remarks.extend(base.spread_remarks(&comparison));
    }
    let ends_without_call = match suspects.iter().find(|suspect| suspect.fits) {
        _ if base.different() == 0 => comparison.ends_without_call(&base)?,
        Some(explained) => explained.ends_without_call,
        // If the outputs still changed in the row before, they had not settled, and another call would not have
        // repeated them.
        None => recording.end.is_some_and(|end| recording.changes(end - 1)),
    };
    let end = recording.end.filter(|_| ends_without_call);
    if let Some(end) = end {
        remarks.push(format!(
            "The last row (line {}) repeats the outputs of the row before it: it marks the end of the run and is not a \
             call.",
            recording.lines[end]
        ));
    }
    let calls = recording.rows - recording.between.len() - usize::from(end.is_some());
    let doubt = doubt(&block, &recording);
    let conclusion = match is_rounded {
        true => Conclusion::Rounded,
        false => conclusion(&block, &recording, &base, &suspects, request.try_suspects),
    };
    let outputs = (0..recording.outputs.len()).map(|output| compared(&recording, &base, output, tolerance)).collect();
    let Recording { matched: columns, settings, moving, .. } = recording;
    Ok(Replayed { columns, calls, outputs, settings, moving, conclusion, doubt, suspects, remarks })
}

/// One interpretation of a recording, with its conclusion.
struct Reading {
    recording: Recording,
    base: compare::Outcome,
    suspects: Vec<Suspect>,
    /// Whether its rows are taken to hold the outputs of the previous call.
    is_late: bool,
    /// Whether the rounding of the recorded inputs explains the differences.
    is_rounded: bool,
}

impl Reading {
    /// Whether nothing differs or settings explain the differences.
    fn is_explained(&self) -> bool {
        self.base.different() == 0 || self.suspects.iter().any(is_of_settings)
    }

    fn is_within_rounding(&self, block: &Block, tolerance: Option<f64>) -> Result<bool> {
        Ok(self.base.different() > 0
            && Comparison::new(block, &self.recording, tolerance).is_within_rounding(&self.base)?)
    }
}

/// Tries other interpretations of the recording and returns the one that explains most: outputs that are one call late,
/// times in manual mode, a setting that was changed during the recording.
fn read_otherwise(
    block: &Block,
    csv: &Csv,
    request: &ReplayRequest,
    mut reading: Reading,
    remarks: &mut Vec<String>,
) -> Result<Reading> {
    let tolerance = request.tolerance;
    // When the setpoint steps, outputs that are one call late look like a row that is not a call. If only switches are
    // recorded, both interpretations may fit, with different values of a setting.
    let has_switches_only = reading.recording.outputs.iter().all(|of| of.is_boolean);
    let is_told = reading.suspects.iter().any(is_of_settings);
    let mut late = late(block, csv, request, request.try_suspects && (!is_told || has_switches_only))?;
    let is_plainer = plainer(&mut reading.suspects, &mut late.suspects);
    let fits = reading.suspects.iter().any(|suspect| suspect.fits);
    reading.is_rounded = reading.is_within_rounding(block, tolerance)?;
    late.is_rounded = !reading.is_rounded && late.is_within_rounding(block, tolerance)?;
    let is_taken = match late.is_explained() {
        true => late.base.different() == 0 || is_plainer,
        false => {
            let is_better = late.suspects.iter().any(|of| of.fits) || late.is_rounded;
            let rows = reading.recording.rows;
            !fits && !reading.is_rounded && (is_better || late.base.agrees_longer_than(&reading.base, rows))
        }
    };
    if is_taken {
        reading = late;
    }
    let is_clearer = |suspect: &Suspect| {
        !suspect.values.is_empty() && !suspect.fits && suspect.different * CLEARER <= reading.base.different()
    };
    reading.is_rounded &= !reading.suspects.iter().any(|suspect| is_large(suspect) || is_clearer(suspect));
    if reading.is_rounded {
        reading.suspects.clear();
        return Ok(reading);
    }
    // A difference in a switch is always a whole call, and the last digit of an input may cause it: its size says
    // nothing.
    let is_any_near = tolerance.is_some() || has_switches_only;
    let allowed = if is_any_near { f64::INFINITY } else { FAR * reading.recording.resolution() };
    // A call without a row cannot be judged by closeness, because its inputs were not recorded.
    let is_near = |suspect: &Suspect| suspect.fits && (suspect.largest <= allowed || !is_of_settings(suspect));
    let is_open = request.try_suspects && !reading.recording.is_coarse && reading.base.different() > 0;
    if !is_open || reading.suspects.iter().any(is_near) {
        return Ok(reading);
    }
    let inputs = reading.recording.inputs.len();
    let manual = reading.recording.take_for_manual(block, &reading.base.outputs, |output| reading.base.spread(output));
    if !manual.is_empty() {
        let (base, suspects) = explained(&Comparison::new(block, &reading.recording, tolerance), true)?;
        if base.different() == 0 || suspects.iter().any(is_near) {
            let constant = constant_from(block, &reading.recording, &manual);
            // A limit that was changed during the recording looks like manual mode while it is active.
            let is_like_limit = manual.iter().any(|(from, _)| reading.recording.stays_on_one_side(block, *from));
            let as_manual = Reading { base, suspects, ..reading };
            if is_like_limit && let Some(mut by_hand) = by_hand(block, csv, request, f64::INFINITY)? {
                by_hand.suspects.iter_mut().for_each(|suspect| suspect.is_sure = false);
                remarks.push(format!("{constant}: manual mode there would also explain the recording."));
                return Ok(by_hand);
            }
            remarks.push(format!("{constant}: the controller is assumed to be in manual mode there."));
            return Ok(as_manual);
        }
        reading.recording.inputs.truncate(inputs);
    }
    let fitting = reading.suspects.iter().filter(|suspect| suspect.fits).map(|suspect| suspect.largest);
    let largest = fitting.fold(f64::INFINITY, f64::min);
    if let Some(mut by_hand) = by_hand(block, csv, request, largest / 2.0)? {
        reading.suspects.retain(|suspect| !suspect.fits);
        by_hand.suspects.append(&mut reading.suspects);
        return Ok(by_hand);
    }
    Ok(reading)
}

/// Explains the recording by a setting that was changed while it was made; `None` if the largest remaining difference
/// is not below `largest`.
fn by_hand(block: &Block, csv: &Csv, request: &ReplayRequest, largest: f64) -> Result<Option<Reading>> {
    let mut readings = readings(block, csv, request)?;
    let of = |recording| Comparison::new(block, recording, request.tolerance);
    let comparisons: Vec<Comparison> = readings.iter().map(of).collect();
    let is_nearer = |midway: &Midway| midway.suspects[0].largest < largest;
    Ok(midway::midway(&comparisons)?.filter(is_nearer).map(|Midway { reading, base, suspects }| {
        let recording = readings.swap_remove(reading);
        Reading { recording, base, suspects, is_late: reading > 0, is_rounded: false }
    }))
}

/// Reads the recording with each output moved to the row of its call. The recorded process value may be the block's
/// input or its output: the choice that explains more is used.
fn late(block: &Block, csv: &Csv, request: &ReplayRequest, has_to_explain: bool) -> Result<Reading> {
    let of = |has_late_process_value: bool, has_to_explain: bool| -> Result<Option<Reading>> {
        let recording = Recording::new(block, csv, &request.columns, &mut Vec::new())?;
        if has_late_process_value && !recording.has_unclear_process_value(block) {
            return Ok(None);
        }
        let recording = recording.with_earlier_outputs(block, has_late_process_value);
        let comparison = Comparison::new(block, &recording, request.tolerance);
        let (base, suspects) = explained(&comparison, has_to_explain)?;
        Ok(Some(Reading { recording, base, suspects, is_late: true, is_rounded: false }))
    };
    // If everything is already equal, no cause is needed.
    let plain = of(false, false)?.context("the input is always there")?;
    let shifted = of(true, false)?;
    if plain.is_explained() {
        return Ok(plain);
    }
    let Some(shifted) = shifted else { return Ok(of(false, has_to_explain)?.unwrap_or(plain)) };
    if shifted.is_explained() {
        return Ok(shifted);
    }
    // The first row that differs usually decides between the two; if not, both are tried.
    let rows = plain.recording.rows;
    let is_shifted = shifted.base.agrees_longer_than(&plain.base, rows);
    let is_plain = plain.base.agrees_longer_than(&shifted.base, rows);
    let best = of(is_shifted, has_to_explain)?.unwrap_or(plain);
    if best.is_explained() || is_shifted || is_plain {
        return Ok(best);
    }
    Ok(of(true, has_to_explain)?.filter(Reading::is_explained).unwrap_or(best))
}

/// Returns the recording unchanged, and with each output moved to the row of its call.
fn readings(block: &Block, csv: &Csv, request: &ReplayRequest) -> Result<Vec<Recording>> {
    let plain = || Recording::new(block, csv, &request.columns, &mut Vec::new());
    let has_unclear = plain()?.has_unclear_process_value(block);
    let late = [false, true].into_iter().filter(|is_late| !is_late || has_unclear);
    let late = late.map(|is_late| Ok(plain()?.with_earlier_outputs(block, is_late)));
    std::iter::once(plain()).chain(late).collect()
}

/// Whether settings explain the second of two readings of a recording, and explain the first not at all or only with
/// more settings or digits. If they explain both, neither explanation is certain, unless both change the same setting
/// to almost the same value.
fn plainer(first: &mut [Suspect], second: &mut [Suspect]) -> bool {
    let told = |of: &mut [Suspect]| of.iter().position(is_of_settings);
    let (Some(own), Some(other)) = (told(first), told(second)) else { return told(second).is_some() };
    let (own, other) = (&mut first[own], &mut second[other]);
    match (single(own), single(other)) {
        (Some((name, value)), Some((same, another))) if name == same => {
            let known = [Some((value, value)), Some((another, another)), own.range, other.range];
            let (low, high) = known.into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).expect("of two");
            for (of, value) in [(&mut *own, value), (&mut *other, another)] {
                of.range = suspects::range_to_tell(low, high, value);
                of.is_sure &= !suspects::is_wide(low, high, value);
            }
        }
        _ => (own.is_sure, other.is_sure) = (false, false),
    }
    let digits =
        |of: &Suspect| of.changes.iter().filter_map(value_of).map(|(_, value)| short(value).len()).sum::<usize>();
    (other.changes.len(), digits(other)) < (own.changes.len(), digits(own))
}

/// Returns the setting that a change modifies, and its number.
fn value_of(change: &Change) -> Option<(&str, f64)> {
    match change {
        Change::Setting { name, value, .. } => Some((name, number_of(*value))),
        _ => None,
    }
}

/// Returns the setting and value of a suspect that changes a single setting from the start.
fn single(suspect: &Suspect) -> Option<(String, f64)> {
    let [change] = suspect.changes.as_slice() else { return None };
    value_of(change).filter(|_| suspect.since.is_none()).map(|(name, value)| (name.to_string(), value))
}

/// Whether a suspect explains everything by settings, without added calls or rows left out.
fn is_of_settings(suspect: &Suspect) -> bool {
    let is_of_rows = |change: &Change| matches!(change, Change::LeftOut { .. } | Change::Added { .. });
    suspect.fits && !suspect.changes.iter().any(is_of_rows)
}

/// Whether a suspect explains everything by settings that all differ by more than rounding could account for.
fn is_large(suspect: &Suspect) -> bool {
    let is_far = |change: &Change| match change {
        Change::Setting { value, before, .. } => {
            let (value, before) = (number_of(*value), number_of(*before));
            (value - before).abs() > LARGE * before.abs()
        }
        _ => false,
    };
    is_of_settings(suspect) && suspect.since.is_none() && suspect.changes.iter().all(is_far)
}

/// Runs the unchanged block and, if its outputs differ, searches for explanations.
fn explained(comparison: &Comparison, has_to_explain: bool) -> Result<(compare::Outcome, Vec<Suspect>)> {
    let recording = comparison.recording;
    let variant = Variant { skipped: recording.between.clone(), ..Variant::default() };
    let base = comparison.best(&variant, recording.rows)?;
    let suspects = match has_to_explain && base.different() > 0 {
        true => suspects::tried(comparison, &base)?,
        false => Vec::new(),
    };
    Ok((base, suspects))
}

/// Returns a remark on how the block is assumed to have reached the first row.
fn beginning(block: &Block, recording: &Recording, variant: &Variant) -> Option<String> {
    match variant.beginning {
        Beginning::Restart if recording.says_restart => None,
        Beginning::Restart => Some("The first row is assumed to be the restart: the other rows then fit best.".into()),
        Beginning::Fresh => {
            Some("The first row is assumed to be the first call after a restart: the other rows then fit best.".into())
        }
        Beginning::Held => {
            let manipulated = block.roles.manipulated_value.as_deref().unwrap_or("the manipulated value");
            Some(format!(
                "The earlier state is unknown, so the replay starts in manual mode at the recorded {manipulated} and \
                 switches to automatic mode at row 2: a constant contribution to {manipulated}, such as an offset or a \
                 disturbance, goes unnoticed."
            ))
        }
    }
}

/// Returns a remark if the actuator's stops, which a step controller takes into account, are not recorded.
fn unknown_stops(block: &Block, recording: &Recording) -> Option<String> {
    let is_recorded = |name: &&String| recording.inputs.iter().any(|input| block.table.rows[input.row].name == **name);
    let unknown: Vec<&str> = block.roles.stops().filter(|name| !is_recorded(name)).map(String::as_str).collect();
    let (are, them) = if unknown.len() == 1 { ("is", "it") } else { ("are", "them") };
    (!unknown.is_empty()).then(|| {
        format!(
            "{} {are} not in the recording and {are} replayed as set in the loop. If the actuator was at a stop, \
             record {them}.",
            unknown.join(" and ")
        )
    })
}

/// Returns the beginning of a remark: the manipulated value, and the times at which it is constant.
fn constant_from(block: &Block, recording: &Recording, times: &[(f64, f64)]) -> String {
    let output = block.manipulated(recording).map_or("", |output| recording.outputs[output].name.as_str());
    let times: Vec<String> = times.iter().map(|(from, to)| format!("{} s to {} s", short(*from), short(*to))).collect();
    let times = times.join(", ");
    format!("{output} is constant from {times}")
}

/// Returns the comparison of an output. Its curves contain all rows or, if there are too many, one row of each group:
/// that of the first difference, or else that of the largest difference.
fn compared(recording: &Recording, run: &compare::Outcome, output: usize, tolerance: Option<f64>) -> Compared {
    let of = &recording.outputs[output];
    let (recorded, computed) = (&of.values, &run.outputs[output]);
    let rows = recorded.len().min(computed.len());
    let difference = |row: usize| {
        let difference = (recorded[row] - computed[row]).abs();
        if difference.is_nan() { -1.0 } else { difference }
    };
    let group = rows.div_ceil(MOST_POINTS).max(1);
    let first = run.compared[output].first;
    let shown: Vec<usize> = (0..rows)
        .step_by(group)
        .map(|start| {
            let group = start..(start + group).min(rows);
            match first {
                Some(first) if group.contains(&first) => first,
                _ => group.max_by(|a, b| difference(*a).total_cmp(&difference(*b))).unwrap_or(start),
            }
        })
        .collect();
    Compared {
        variable: of.name.clone(),
        first: first.map(|row| (row - recording.between.range(..row).count(), recording.times[row])),
        different: run.compared[output].different,
        largest: run.compared[output].largest,
        allowed: tolerance.unwrap_or_else(|| of.coarsest() + run.spread(output)),
        noise: if of.is_boolean { 0.0 } else { noise_of(recorded).max(noise_of(&computed[..rows])) },
        times: shown.iter().map(|row| recording.times[*row]).collect(),
        recorded: shown.iter().map(|row| recorded[*row]).collect(),
        computed: shown.iter().map(|row| computed[*row]).collect(),
    }
}

/// Returns the noise of values; a smooth curve has none, however strongly it bends.
fn noise_of(values: &[f64]) -> f64 {
    let bends: Vec<f64> = values.windows(3).map(|three| three[0] - 2.0 * three[1] + three[2]).collect();
    let products = || bends.windows(2).map(|pair| pair[0] * pair[1]);
    let [same, other] = [products().filter(|one| *one > 0.0).count(), products().filter(|one| *one < 0.0).count()];
    if same > other { 0.0 } else { noise(values) }
}

/// Returns the reason why equal outputs prove nothing about a controller's settings.
fn doubt(block: &Block, recording: &Recording) -> Option<Doubt> {
    let roles = block.roles;
    if roles.controller.is_empty() {
        return None;
    }
    let is_compared = |name: &String| recording.outputs.iter().any(|output| output.name == *name);
    if !roles.driving().any(is_compared) {
        return Some(Doubt::NotRecorded(roles.driving().cloned().collect()));
    }
    let switch = block.row(roles.manual_switch()).filter(|_| block.is_always_manual(recording))?;
    Some(match recording.inputs.iter().any(|input| input.row == switch) {
        true => Doubt::Manual,
        false => Doubt::ManualInLoop(block.table.rows[switch].name.clone()),
    })
}

/// Draws the conclusion from the explanations tried.
fn conclusion(
    block: &Block,
    recording: &Recording,
    base: &compare::Outcome,
    suspects: &[Suspect],
    has_tried: bool,
) -> Conclusion {
    match suspects {
        _ if base.different() == 0 => Conclusion::Equal,
        _ if !has_tried => Conclusion::Differs,
        [first, ..] if first.fits && first.is_sure => Conclusion::Cause,
        [first, others @ ..] if is_likeliest(block, first, others) => Conclusion::LikelyCause,
        _ if suspects.iter().any(|suspect| suspect.fits) => Conclusion::Ambiguous,
        _ if recording.is_coarse => Conclusion::Coarse,
        _ => Conclusion::Unexplained,
    }
}

/// Whether the first suspect is the only explanation that changes only controller settings.
fn is_likeliest(block: &Block, first: &Suspect, others: &[Suspect]) -> bool {
    let is_usual = |suspect: &Suspect| suspect.fits && suspects::is_usual(block, suspect);
    is_usual(first) && !others.iter().any(is_usual)
}

#[cfg(test)]
mod tests;
