//! The result of a proof: a data block of fixed layout.

use super::tape::Tape;
use blocks::Kind;

/// The size of the result in the PLC, in bytes.
pub const RESULT_BYTES: usize = 36;

/// `PLCF`, the magic number of a result.
const MAGIC: u32 = 0x504C_4346;

/// The version of the layout.
const FORMAT: u16 = 1;

pub(super) const RUNNING: u16 = 0;
pub(super) const COMPLETE: u16 = 1;
pub(super) const DIFFERS: u16 = 2;

pub(super) struct Field {
    pub name: &'static str,
    pub ty: &'static str,
    pub docs: &'static str,
}

const fn field(name: &'static str, ty: &'static str, docs: &'static str) -> Field {
    Field { name, ty, docs }
}

/// The members of the result, each at an even offset.
pub(super) const FIELDS: [Field; 11] = [
    field("magic", "DWORD", "PLCF"),
    field("layout", "INT", "version of the layout of this data block"),
    field("state", "INT", "0: running, 1: all calls done without a difference, 2: stopped at a difference"),
    field("seed", "DWORD", "seed of the tape"),
    field("tape", "DWORD", "fingerprint of the tape"),
    field("calls", "DINT", "calls on the tape"),
    field("done", "DINT", "calls made"),
    field("output", "INT", "number of the differing output, counted from 1"),
    field("spare", "INT", "not used"),
    field("expected", "DWORD", "expected bits of this output"),
    field("found", "DWORD", "actual bits of this output"),
];

/// The start values of the result's members.
pub(super) fn starts(tape: &Tape) -> Vec<(&'static str, String)> {
    vec![
        ("magic", format!("DW#16#{MAGIC:X}")),
        ("layout", FORMAT.to_string()),
        ("seed", format!("DW#16#{:X}", tape.seed)),
        ("tape", format!("DW#16#{:X}", tape.fingerprint())),
        ("calls", tape.calls.to_string()),
    ]
}

/// The outcome of a proof on a PLC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The state of the proof.
    pub state: State,
    /// The number of calls on the tape.
    pub calls: u32,
    /// The number of calls made.
    pub done: u32,
    /// The seed from which the tape was generated.
    pub seed: u32,
    /// The fingerprint of the tape.
    pub tape: u32,
}

/// The state of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Calls remain to be made.
    Running,
    /// All calls were made, and all bits agreed.
    Complete,
    /// The last call produced different bits.
    Differs {
        /// The output, as a zero-based index into [`Tape::outputs`].
        output: usize,
        /// The bits on the tape.
        expected: u32,
        /// The bits in the PLC.
        found: u32,
    },
}

impl Outcome {
    /// Parses the bytes of the result's data block, which are big-endian as in the PLC.
    ///
    /// # Errors
    /// The bytes are not the result of a proof.
    pub fn read(bytes: &[u8]) -> Result<Outcome, String> {
        if bytes.len() < RESULT_BYTES {
            return Err(format!("it has {} bytes; a proof result has {RESULT_BYTES}", bytes.len()));
        }
        let short = |at: usize| u16::from_be_bytes([bytes[at], bytes[at + 1]]);
        let long = |at: usize| u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        if long(0) != MAGIC {
            return Err(
                "it is not a proof result: it does not begin with PLCF; read the data block named in the source".into(),
            );
        }
        if short(4) != FORMAT {
            return Err(format!(
                "its layout version is {}, but this plcfmu reads {FORMAT}; use the version that wrote the source",
                short(4)
            ));
        }
        let state = match short(6) {
            RUNNING => State::Running,
            COMPLETE => State::Complete,
            DIFFERS => {
                let output = usize::from(short(24))
                    .checked_sub(1)
                    .ok_or("it reports a difference, but the number of the output is invalid")?;
                State::Differs { output, expected: long(28), found: long(32) }
            }
            other => return Err(format!("its state {other} is invalid")),
        };
        Ok(Outcome { state, calls: long(16), done: long(20), seed: long(8), tape: long(12) })
    }

    /// Generates the tape that was run; `None` if this version generates a different one or lacks the block.
    pub fn tape(&self) -> Option<Tape> {
        let calls = usize::try_from(self.calls).ok().filter(|calls| *calls <= super::MOST_CALLS)?;
        crate::library::natives()
            .into_iter()
            .filter_map(|name| Tape::new(name, calls, self.seed))
            .find(|tape| tape.fingerprint() == self.tape)
    }

    /// The outcome in one line; the tape, if known, supplies the names and types.
    pub fn text(&self, tape: Option<&Tape>) -> String {
        let block = tape.map_or(String::new(), |tape| format!("{}: ", tape.table.name));
        let calls = grouped(self.calls);
        match self.state {
            State::Running => {
                format!("{block}{} of {calls} calls, 0 differ so far; the proof is still running", grouped(self.done))
            }
            State::Complete => format!("{block}{calls} calls, 0 differ"),
            State::Differs { output, expected, found } => {
                let row = tape.and_then(|tape| tape.outputs.get(output).map(|row| &tape.table.rows[*row]));
                let (name, kind) =
                    row.map_or((format!("output {}", output + 1), None), |row| (row.name.to_string(), Some(row.kind)));
                format!(
                    "{block}call {} of {calls} differs: {name} is {}, expected {}",
                    grouped(self.done),
                    shown(kind, found),
                    shown(kind, expected)
                )
            }
        }
    }
}

/// Formats 5000 as `5,000`.
fn grouped(number: u32) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The bits as a value of this type, or in hexadecimal if the type is unknown.
fn shown(kind: Option<Kind>, bits: u32) -> String {
    match kind {
        Some(Kind::Real) => format!("{:?} (16#{bits:08X})", f32::from_bits(bits)),
        Some(Kind::Bool) => if bits == 0 { "FALSE" } else { "TRUE" }.to_string(),
        Some(Kind::Int) => (bits as i16).to_string(),
        Some(Kind::Time) => format!("{} ms", bits as i32),
        Some(Kind::Word) => format!("{} (16#{:04X})", bits as i16, bits as u16),
        _ => format!("16#{bits:08X}"),
    }
}

/// A value as text, from its bits on a tape.
pub(super) fn value_text(kind: Kind, bits: u32) -> String {
    shown(Some(kind), bits)
}
