//! Executes instructions.

use super::code::{Bounds, Op, Part, Register};
use super::{Cause, Code, Kept, Machine, Stop, Warning};
use crate::ir::{At, Binary, Scalar, Value};
use std::cmp::Ordering;
use std::collections::BTreeSet;

impl Machine {
    /// Runs the function that starts at the instruction `entry`, until it returns.
    pub(super) fn run(&mut self, entry: u32, now: i64) -> Result<(), Stop> {
        let Machine { code, memory, registers, returns, room, covered, warned, warnings, kept, .. } = self;
        // Slices in local variables are faster to access than fields of the machine.
        let (code, memory, registers) = (&**code, &mut memory[..], &mut registers[..]);
        let ops = &code.ops[..];
        let mut budget = i64::from(self.budget);
        let mut next = entry;
        returns.clear();
        macro_rules! reg {
            ($register:expr) => {
                registers[$register as usize]
            };
        }
        macro_rules! f32_of {
            ($register:expr) => {
                f32::from_bits(reg!($register) as u32)
            };
        }
        macro_rules! address {
            ($register:expr) => {
                reg!($register) as usize
            };
        }
        loop {
            let op = next;
            next += 1;
            match ops[op as usize] {
                Op::Const { to, bits } => reg!(to) = bits,
                Op::Move { to, from } => reg!(to) = reg!(from),
                Op::Clear { from, count } => {
                    registers[usize::from(from)..][..usize::from(count)].fill(0);
                }
                Op::Load { ty, to, base, offset } => {
                    reg!(to) = load(ty, &memory[address!(base) + offset as usize..]);
                }
                Op::Store { ty, from, base, offset } => {
                    let bits = reg!(from);
                    store(ty, bits, &mut memory[address!(base) + offset as usize..]);
                }
                Op::LoadBool { to, base, offset } => {
                    reg!(to) = u64::from(memory[address!(base) + offset as usize] != 0);
                }
                Op::Load32 { to, base, offset } => {
                    reg!(to) = u64::from(four(&memory[address!(base) + offset as usize..]));
                }
                Op::Store8 { from, base, offset } => memory[address!(base) + offset as usize] = reg!(from) as u8,
                Op::Store32 { from, base, offset } => {
                    let bytes = (reg!(from) as u32).to_le_bytes();
                    memory[address!(base) + offset as usize..][..4].copy_from_slice(&bytes);
                }
                Op::One { to, a, function } => reg!(to) = function(reg!(a)),
                Op::OneChecked { to, a, function } => {
                    let (result, warns) = function(reg!(a));
                    reg!(to) = result;
                    if warns {
                        warn(code, warned, warnings, op);
                    }
                }
                Op::Two { to, a, b, function } => reg!(to) = function(reg!(a), reg!(b)),
                Op::TwoChecked { to, a, b, function } => {
                    let (result, warns) = function(reg!(a), reg!(b));
                    reg!(to) = result;
                    if warns {
                        warn(code, warned, warnings, op);
                    }
                }
                Op::AddF32 { to, a, b } => reg!(to) = u64::from((f32_of!(a) + f32_of!(b)).to_bits()),
                Op::SubF32 { to, a, b } => reg!(to) = u64::from((f32_of!(a) - f32_of!(b)).to_bits()),
                Op::MulF32 { to, a, b } => reg!(to) = u64::from((f32_of!(a) * f32_of!(b)).to_bits()),
                Op::Three { to, first, function } => {
                    reg!(to) = function(reg!(first), reg!(first + 1), reg!(first + 2));
                }
                Op::Select { to, first } => {
                    reg!(to) = if reg!(first) != 0 { reg!(first + 1) } else { reg!(first + 2) };
                }
                Op::Address { to, base, offset } => reg!(to) = reg!(base) + u64::from(offset),
                Op::Index { to, base, index, bounds } => {
                    let Bounds { low, high, stride } = code.bounds[bounds as usize];
                    let index = code.inside(op, reg!(index) as i64, low, high)?;
                    reg!(to) = reg!(base) + index * stride;
                }
                Op::IndexOpen { number, index, bounds } => {
                    let (low, high) = (reg!(bounds) as i64, reg!(bounds + 1) as i64);
                    let index = code.inside(op, reg!(index) as i64, low, high)?;
                    reg!(number) = reg!(number) * (high - low + 1) as u64 + index;
                }
                Op::Scale { to, base, number, size } => reg!(to) = reg!(base) + reg!(number) * u64::from(size),
                Op::Copy { .. } | Op::Image { .. } | Op::CopyText { .. } | Op::CompareText { .. } | Op::Same { .. } => {
                    whole(ops[op as usize], code, memory, registers);
                }
                Op::Now { to } => reg!(to) = now as u64,
                Op::Jump { to } => next = to,
                Op::Back { to } => {
                    budget -= 1;
                    if budget < 0 {
                        return Err(code.stop(op, Cause::Budget(self.budget)));
                    }
                    next = to;
                }
                Op::JumpIf { condition, to } => next = if reg!(condition) != 0 { to } else { next },
                Op::JumpUnless { condition, to } => next = if reg!(condition) == 0 { to } else { next },
                Op::JumpInside { value, range, to } => {
                    let (low, high) = code.ranges[range as usize];
                    if (low..=high).contains(&(reg!(value) as i64)) {
                        next = to;
                    }
                }
                Op::ForTest { ty, value, last, to } => {
                    if reg!(last + 1) == 0 {
                        return Err(code.stop(op, Cause::Step));
                    }
                    if has_ended(ty, reg!(value), reg!(last), reg!(last + 1)) {
                        next = to;
                    }
                }
                Op::ForStep { ty, value, step } => {
                    (reg!(value), reg!(value + 1)) = stepped(ty, reg!(value), reg!(step));
                }
                Op::Mark { run, count } => {
                    covered[run as usize] = true;
                    budget -= i64::from(count);
                }
                Op::Call { to } => {
                    if budget < 0 {
                        return Err(code.stop(op, Cause::Budget(self.budget)));
                    }
                    returns.push(next);
                    next = to;
                }
                Op::Return => {
                    if let Some(kept) = kept {
                        keep(code, registers, op, kept);
                    }
                    match returns.pop() {
                        Some(caller) => next = caller,
                        None => return Ok(()),
                    }
                }
                Op::Native { law, instance } => {
                    let (law, size) = code.natives[usize::from(law)];
                    let instance = &mut memory[address!(instance)..][..size];
                    if !law(instance, room) {
                        return Err(code.stop(op, Cause::Instance));
                    }
                }
            }
        }
    }
}

/// Keeps the numeric locals of the function that `op` returns from.
#[cold]
fn keep(code: &Code, registers: &[u64], op: u32, kept: &mut Kept) {
    let owner = code.owners.partition_point(|(first, _)| *first <= op).checked_sub(1);
    let Some((_, function)) = owner.and_then(|owner| code.owners.get(owner)) else { return };
    let value = |register: Option<Register>| register.map_or(0, |register| registers[usize::from(register)]);
    let values = kept.entry((*function, value(code.instances[*function]))).or_default();
    values.clear();
    values.extend(code.locals[*function].iter().map(|register| value(*register)));
}

/// Executes an instruction that copies or compares whole variables.
fn whole(op: Op, code: &Code, memory: &mut [u8], registers: &mut [u64]) {
    let address = |register: Register| registers[usize::from(register)] as usize;
    match op {
        Op::Copy { to, from, size } => {
            let (to, from, size) = (address(to), address(from), size as usize);
            memory.copy_within(from..from + size, to);
        }
        Op::Image { to, from, size } => {
            let image = &code.images[from as usize..][..size as usize];
            memory[to as usize..][..size as usize].copy_from_slice(image);
        }
        Op::CopyText { to, from, to_capacity, from_capacity, wide } => {
            let (to, from) = (address(to), address(from));
            let length = length(&memory[from..], from_capacity).min(usize::from(to_capacity));
            let size = length << u32::from(wide);
            memory.copy_within(from + 2..from + 2 + size, to + 2);
            memory[to..to + 2].copy_from_slice(&(length as u16).to_le_bytes());
        }
        Op::CompareText { op, to, a, b, capacities, wide } => {
            let a = characters(&memory[address(a)..], capacities.0, wide);
            let b = characters(&memory[address(b)..], capacities.1, wide);
            registers[usize::from(to)] = u64::from(holds(op, a.cmp(b)));
        }
        Op::Same { to, a, b, parts } => {
            let (a, b) = (&memory[address(a)..], &memory[address(b)..]);
            registers[usize::from(to)] = u64::from(code.parts[parts as usize].iter().all(|part| same(*part, a, b)));
        }
        _ => {}
    }
}

impl Code {
    /// The distance of an index from its lower bound.
    ///
    /// # Errors
    /// The index is out of bounds.
    #[inline(always)]
    fn inside(&self, op: u32, index: i64, low: i64, high: i64) -> Result<u64, Stop> {
        if index < low || index > high {
            return Err(self.stop(op, Cause::Index { index, low, high }));
        }
        Ok((index - low) as u64)
    }

    /// Locates a cause at the source line of an instruction.
    #[cold]
    fn stop(&self, op: u32, cause: Cause) -> Stop {
        let (file, line) = self.line(op);
        Stop { file, line, cause }
    }

    /// The source file and line of an instruction.
    fn line(&self, op: u32) -> (String, u32) {
        let At { file, line } = self.lines[op as usize];
        (self.files.get(usize::from(file)).cloned().unwrap_or_default(), line)
    }
}

/// Issues the warning of an instruction unless it has already been issued.
#[cold]
fn warn(code: &Code, warned: &mut BTreeSet<u32>, warnings: &mut Vec<Warning>, op: u32) {
    if warned.insert(op) {
        let (file, line) = code.line(op);
        let message = code.warnings.get(&op).cloned().unwrap_or_default();
        warnings.push(Warning { file, line, message });
    }
}

/// Whether a loop has passed its last value.
fn has_ended(ty: Scalar, value: u64, last: u64, step: u64) -> bool {
    if ty == Scalar::U64 {
        value > last
    } else if (step as i64) < 0 {
        (value as i64) < last as i64
    } else {
        value as i64 > last as i64
    }
}

/// The next value of a loop counter, and 1 if it overflows its type, else 0.
fn stepped(ty: Scalar, value: u64, step: u64) -> (u64, u64) {
    let sum = Binary::Add.fold(Value::new(ty, value), Value::new(ty, step));
    sum.map_or((value, 1), |(sum, beyond)| (sum.bits(), u64::from(beyond)))
}

/// Reads a number from the start of `bytes`.
#[inline(always)]
fn load(ty: Scalar, bytes: &[u8]) -> u64 {
    match ty {
        Scalar::Bool => u64::from(bytes[0] != 0),
        Scalar::I8 => bytes[0] as i8 as u64,
        Scalar::U8 => u64::from(bytes[0]),
        Scalar::I16 => i16::from_le_bytes([bytes[0], bytes[1]]) as u64,
        Scalar::U16 => u64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        Scalar::I32 => four(bytes) as i32 as u64,
        Scalar::U32 | Scalar::F32 => u64::from(four(bytes)),
        Scalar::I64 | Scalar::U64 | Scalar::F64 => Value::read(Scalar::U64, bytes).bits(),
    }
}

#[inline(always)]
fn four(bytes: &[u8]) -> u32 {
    let &[a, b, c, d] = bytes.first_chunk().expect("a number lies within memory");
    u32::from_le_bytes([a, b, c, d])
}

/// Writes a number to the start of `bytes`.
#[inline(always)]
fn store(ty: Scalar, bits: u64, bytes: &mut [u8]) {
    match ty.size() {
        1 => bytes[0] = bits as u8,
        2 => bytes[..2].copy_from_slice(&(bits as u16).to_le_bytes()),
        4 => bytes[..4].copy_from_slice(&(bits as u32).to_le_bytes()),
        _ => bytes[..8].copy_from_slice(&bits.to_le_bytes()),
    }
}

/// The length of a string in characters, limited to its capacity.
fn length(text: &[u8], capacity: u16) -> usize {
    usize::from(u16::from_le_bytes([text[0], text[1]]).min(capacity))
}

/// The character codes of a string.
fn characters(text: &[u8], capacity: u16, wide: bool) -> impl Iterator<Item = u16> {
    let length = length(text, capacity);
    let characters = &text[2..];
    (0..length).map(move |index| match wide {
        true => u16::from_le_bytes([characters[2 * index], characters[2 * index + 1]]),
        false => u16::from(characters[index]),
    })
}

/// Whether a comparison is true for this ordering of its operands.
fn holds(op: Binary, order: Ordering) -> bool {
    match op {
        Binary::Eq => order.is_eq(),
        Binary::Ne => order.is_ne(),
        Binary::Lt => order.is_lt(),
        Binary::Le => order.is_le(),
        Binary::Gt => order.is_gt(),
        _ => order.is_ge(),
    }
}

/// Whether two variables are equal in this part.
fn same(part: Part, a: &[u8], b: &[u8]) -> bool {
    match part {
        Part::Text { offset, capacity, wide } => {
            let (a, b) = (&a[offset as usize..], &b[offset as usize..]);
            characters(a, capacity, wide).eq(characters(b, capacity, wide))
        }
        Part::Numbers { ty, offset, count } => (0..count as usize).all(|index| {
            let at = offset as usize + index * ty.size();
            let (a, b) = (load(ty, &a[at..]), load(ty, &b[at..]));
            match ty {
                Scalar::F32 => f32::from_bits(a as u32) == f32::from_bits(b as u32),
                Scalar::F64 => f64::from_bits(a) == f64::from_bits(b),
                _ => a == b,
            }
        }),
    }
}

const _: () = assert!(size_of::<Op>() == 16 && size_of::<Register>() == 2);
