//! The instructions at work.

use super::code::{Bounds, Op, Part, Register};
use super::{Cause, Machine, Stop};
use crate::program::{Binary, Scalar, Value};
use std::cmp::Ordering;
use std::sync::Arc;

impl Machine {
    /// Runs from an instruction to the end of its function.
    pub(super) fn run(&mut self, entry: u32, now: i64) -> Result<(), Stop> {
        let code = Arc::clone(&self.code);
        let ops = &code.ops[..];
        let mut budget = i64::from(self.budget);
        let mut next = entry;
        self.returns.clear();
        macro_rules! reg {
            ($register:expr) => {
                self.registers[$register as usize]
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
                    self.registers[usize::from(from)..][..usize::from(count)].fill(0);
                }
                Op::Load { ty, to, base, offset } => {
                    reg!(to) = load(ty, &self.memory[address!(base) + offset as usize..]);
                }
                Op::Store { ty, from, base, offset } => {
                    let bits = reg!(from);
                    store(ty, bits, &mut self.memory[address!(base) + offset as usize..]);
                }
                Op::One { to, a, function } => reg!(to) = function(reg!(a)),
                Op::OneChecked { to, a, function } => {
                    let (result, warns) = function(reg!(a));
                    reg!(to) = result;
                    if warns {
                        self.warn(op);
                    }
                }
                Op::Two { to, a, b, function } => reg!(to) = function(reg!(a), reg!(b)),
                Op::TwoChecked { to, a, b, function } => {
                    let (result, warns) = function(reg!(a), reg!(b));
                    reg!(to) = result;
                    if warns {
                        self.warn(op);
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
                    let index = reg!(index) as i64;
                    if index < low || index > high {
                        return Err(self.stop(op, Cause::Index { index, low, high }));
                    }
                    reg!(to) = reg!(base) + (index - low) as u64 * stride;
                }
                Op::IndexOpen { number, index, bounds } => {
                    let (low, high) = (reg!(bounds) as i64, reg!(bounds + 1) as i64);
                    let index = reg!(index) as i64;
                    if index < low || index > high {
                        return Err(self.stop(op, Cause::Index { index, low, high }));
                    }
                    reg!(number) = reg!(number) * (high - low + 1) as u64 + (index - low) as u64;
                }
                Op::Scale { to, base, number, size } => reg!(to) = reg!(base) + reg!(number) * u64::from(size),
                Op::Copy { to, from, size } => {
                    let (to, from, size) = (address!(to), address!(from), size as usize);
                    self.memory.copy_within(from..from + size, to);
                }
                Op::Image { to, from, size } => {
                    let image = &code.images[from as usize..][..size as usize];
                    self.memory[to as usize..][..size as usize].copy_from_slice(image);
                }
                Op::CopyText { to, from, to_capacity, from_capacity, wide } => {
                    let (to, from) = (address!(to), address!(from));
                    let length = length(&self.memory[from..], from_capacity).min(usize::from(to_capacity));
                    let size = length << u32::from(wide);
                    self.memory.copy_within(from + 2..from + 2 + size, to + 2);
                    self.memory[to..to + 2].copy_from_slice(&(length as u16).to_le_bytes());
                }
                Op::CompareText { op, to, a, b, capacities, wide } => {
                    let a = characters(&self.memory[address!(a)..], capacities.0, wide);
                    let b = characters(&self.memory[address!(b)..], capacities.1, wide);
                    reg!(to) = u64::from(holds(op, a.cmp(b)));
                }
                Op::Same { to, a, b, parts } => {
                    let (a, b) = (&self.memory[address!(a)..], &self.memory[address!(b)..]);
                    reg!(to) = u64::from(code.parts[parts as usize].iter().all(|part| same(*part, a, b)));
                }
                Op::Now { to } => reg!(to) = now as u64,
                Op::Jump { to } => next = to,
                Op::Back { to } => {
                    budget -= 1;
                    if budget < 0 {
                        return Err(self.stop(op, Cause::Budget(self.budget)));
                    }
                    next = to;
                }
                Op::JumpIf { condition, to } => {
                    if reg!(condition) != 0 {
                        next = to;
                    }
                }
                Op::JumpUnless { condition, to } => {
                    if reg!(condition) == 0 {
                        next = to;
                    }
                }
                Op::JumpInside { value, range, to } => {
                    let (low, high) = code.ranges[range as usize];
                    if (low..=high).contains(&(reg!(value) as i64)) {
                        next = to;
                    }
                }
                Op::ForTest { ty, value, last, to } => {
                    if reg!(last + 1) == 0 {
                        return Err(self.stop(op, Cause::Step));
                    }
                    if has_ended(ty, reg!(value), reg!(last), reg!(last + 1)) {
                        next = to;
                    }
                }
                Op::ForStep { ty, value, step } => {
                    let sum = Binary::Add.of(Value::new(ty, reg!(value)), Value::new(ty, reg!(step)));
                    if let Some((sum, beyond)) = sum {
                        reg!(value) = sum.bits();
                        reg!(value + 1) = u64::from(beyond);
                    }
                }
                Op::Mark { run, count } => {
                    self.covered[run as usize] = true;
                    budget -= i64::from(count);
                }
                Op::Call { to } => {
                    if budget < 0 {
                        return Err(self.stop(op, Cause::Budget(self.budget)));
                    }
                    self.returns.push(next);
                    next = to;
                }
                Op::Return => match self.returns.pop() {
                    Some(caller) => next = caller,
                    None => return Ok(()),
                },
                Op::Native { law, instance } => {
                    let (law, size) = code.natives[usize::from(law)];
                    let instance = &mut self.memory[address!(instance)..][..size];
                    if !law(instance, &mut self.room) {
                        return Err(self.stop(op, Cause::Instance));
                    }
                }
            }
        }
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

/// Reads a number.
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
    let &[a, b, c, d] = bytes.first_chunk().expect("a number lies within the memory");
    u32::from_le_bytes([a, b, c, d])
}

/// Writes a number.
#[inline(always)]
fn store(ty: Scalar, bits: u64, bytes: &mut [u8]) {
    match ty.size() {
        1 => bytes[0] = bits as u8,
        2 => bytes[..2].copy_from_slice(&(bits as u16).to_le_bytes()),
        4 => bytes[..4].copy_from_slice(&(bits as u32).to_le_bytes()),
        _ => bytes[..8].copy_from_slice(&bits.to_le_bytes()),
    }
}

/// The length of a text in characters.
fn length(text: &[u8], capacity: u16) -> usize {
    usize::from(u16::from_le_bytes([text[0], text[1]]).min(capacity))
}

/// The codes of the characters of a text, as numbers that can be compared.
fn characters(text: &[u8], capacity: u16, wide: bool) -> impl Iterator<Item = u16> {
    let length = length(text, capacity);
    let characters = &text[2..];
    (0..length).map(move |index| match wide {
        true => u16::from_le_bytes([characters[2 * index], characters[2 * index + 1]]),
        false => u16::from(characters[index]),
    })
}

/// Whether a comparison holds for this order.
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

/// Whether a part of two variables is equal.
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
