//! The result of a proof: a data block of fixed layout.

use super::tape::Tape;
use blocks::Kind;

/// The bytes of the result in the PLC.
pub const RESULT_BYTES: usize = 36;

/// `PLCF`, by which a result is known.
const MAGIC: u32 = 0x504C_4346;

/// The layout that is written and read.
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

/// The members, each at a multiple of 2 bytes.
pub(super) const FIELDS: [Field; 11] = [
    field("magic", "DWORD", "PLCF"),
    field("layout", "INT", "layout of this data block"),
    field("state", "INT", "0: running, 1: all calls done without a difference, 2: stopped at a difference"),
    field("seed", "DWORD", "what the tape was made with"),
    field("tape", "DWORD", "fingerprint of the tape"),
    field("calls", "DINT", "calls of the tape"),
    field("done", "DINT", "calls that were made"),
    field("output", "INT", "number of the output that differs, from 1"),
    field("spare", "INT", "not used"),
    field("expected", "DWORD", "its bits by the tape"),
    field("found", "DWORD", "its bits by the block of this PLC"),
];

/// The start values of the result.
pub(super) fn starts(tape: &Tape) -> Vec<(&'static str, String)> {
    vec![
        ("magic", format!("DW#16#{MAGIC:X}")),
        ("layout", FORMAT.to_string()),
        ("seed", format!("DW#16#{:X}", tape.seed)),
        ("tape", format!("DW#16#{:X}", tape.fingerprint())),
        ("calls", tape.calls.to_string()),
    ]
}

/// What a PLC found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Whether it goes on, and what was found.
    pub state: State,
    /// The calls of the tape.
    pub calls: u32,
    /// The calls that were made.
    pub done: u32,
    /// What the tape was made with.
    pub seed: u32,
    /// The fingerprint of the tape.
    pub tape: u32,
}

/// Whether a proof goes on, and what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Calls are still to be made.
    Running,
    /// All calls were made, and all bits were the same.
    Complete,
    /// The last call gave other bits.
    Differs {
        /// The output, from 0, of [`Tape::outputs`].
        output: usize,
        /// Its bits by the tape.
        expected: u32,
        /// Its bits in the PLC.
        found: u32,
    },
}

impl Outcome {
    /// Reads the bytes of the result's data block, as the PLC has them.
    ///
    /// # Errors
    /// They are no result of a proof.
    pub fn read(bytes: &[u8]) -> Result<Outcome, String> {
        if bytes.len() < RESULT_BYTES {
            return Err(format!("it has {} bytes; the result of a proof has {RESULT_BYTES}", bytes.len()));
        }
        let short = |at: usize| u16::from_be_bytes([bytes[at], bytes[at + 1]]);
        let long = |at: usize| u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        if long(0) != MAGIC {
            return Err(
                "it is no result of a proof: its first bytes are not PLCF; read the data block ..._RESULT".into()
            );
        }
        if short(4) != FORMAT {
            return Err(format!(
                "its layout is {}, and {FORMAT} is known here; use the plcfmu that made the source",
                short(4)
            ));
        }
        let state = match short(6) {
            RUNNING => State::Running,
            COMPLETE => State::Complete,
            DIFFERS => {
                let output = usize::from(short(24)).checked_sub(1).ok_or("it names no output that differs")?;
                State::Differs { output, expected: long(28), found: long(32) }
            }
            other => return Err(format!("its state is {other}, which no proof writes")),
        };
        Ok(Outcome { state, calls: long(16), done: long(20), seed: long(8), tape: long(12) })
    }

    /// The tape that was run; `None` if this version makes another one, or it is a tape for no block here.
    pub fn tape(&self) -> Option<Tape> {
        let calls = usize::try_from(self.calls).ok().filter(|calls| *calls <= super::MOST_CALLS)?;
        crate::library::natives()
            .into_iter()
            .filter_map(|name| Tape::of(name, calls, self.seed))
            .find(|tape| tape.fingerprint() == self.tape)
    }

    /// What was found, in words.
    pub fn text(&self, tape: Option<&Tape>) -> String {
        let block = tape.map_or(String::new(), |tape| format!("{}: ", tape.table.name));
        let calls = grouped(self.calls);
        match self.state {
            State::Running => {
                format!("{block}{} of {calls} calls, 0 differ so far; the PLC goes on", grouped(self.done))
            }
            State::Complete => format!("{block}{calls} calls, 0 differ"),
            State::Differs { output, expected, found } => {
                let row = tape.and_then(|tape| tape.outputs.get(output).map(|row| &tape.table.rows[*row]));
                let (name, kind) =
                    row.map_or((format!("output {}", output + 1), None), |row| (row.full_name(), Some(row.kind)));
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

/// 5000 as `5,000`.
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

/// Bits as a value of their type.
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

/// A value in words, from its bits on a tape.
pub fn value_text(kind: Kind, bits: u32) -> String {
    shown(Some(kind), bits)
}
