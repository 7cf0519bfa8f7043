//! Compiles access to variables.

use super::{Compiler, Home, LARGEST_MEMORY, Scope, wrong_type};
use crate::ir::{At, Base, Expr, Place, Scalar, Step, Type};
use crate::machine::code::{Bounds, Op, Register, ZERO};

/// The location of a variable at run time.
#[derive(Clone, Copy)]
pub(super) enum Location {
    Register(Register),
    Memory { base: Register, offset: usize },
}

impl Compiler<'_> {
    /// Compiles access to a variable: its location and type. The registers with its address remain allocated.
    pub(super) fn place(&mut self, scope: &mut Scope, place: &Place) -> Result<(Location, Type), String> {
        let program = self.program;
        let (mut location, mut ty) = match place.base {
            Base::Memory => (Location::Memory { base: ZERO, offset: 0 }, Type::Record(program.memory)),
            Base::Constants => {
                (Location::Memory { base: ZERO, offset: self.constants }, Type::Record(program.constants))
            }
            Base::Instance => {
                let record = scope.function.instance.ok_or("the function has no instance")?;
                (Location::Memory { base: scope.instance, offset: 0 }, Type::Record(record))
            }
            Base::Local(number) => {
                let local = scope.function.locals.get(number).ok_or("a local does not exist")?;
                let location = match scope.homes[number] {
                    Home::Register(register) => Location::Register(register),
                    Home::Reference(base) => Location::Memory { base, offset: 0 },
                    Home::Memory(offset) => Location::Memory { base: ZERO, offset },
                };
                (location, local.ty.clone())
            }
        };
        for step in &place.steps {
            let Location::Memory { base, offset } = location else { return Err("a number has no parts".to_string()) };
            (location, ty) = match (step, ty) {
                (Step::Member(number), Type::Record(record)) => {
                    let record = program.records.get(record).ok_or("a record does not exist")?;
                    let member = record.members.get(*number).ok_or("a member does not exist")?;
                    (Location::Memory { base, offset: offset + member.offset }, member.ty.clone())
                }
                (Step::Length, Type::Text { .. }) => (Location::Memory { base, offset }, Type::Scalar(Scalar::U16)),
                (Step::Index(indices, at), ty) => self.element(scope, place, (base, offset), ty, indices, *at)?,
                _ => return Err("only a record has members, and only a string has a length".to_string()),
            };
        }
        Ok((location, ty))
    }

    /// Compiles access to an array element or to a character of a string.
    fn element(
        &mut self,
        scope: &mut Scope,
        place: &Place,
        (mut base, mut offset): (Register, usize),
        ty: Type,
        indices: &[Expr],
        at: At,
    ) -> Result<(Location, Type), String> {
        if let Type::Open { of, dimensions } = ty {
            return self.element_of_open(scope, place, of, dimensions, indices, at);
        }
        let (of, bounds) = match ty {
            Type::Array { of, bounds } => (*of, bounds),
            Type::Text { capacity, wide } => {
                offset += 2;
                (Type::Scalar(if wide { Scalar::U16 } else { Scalar::U8 }), vec![(1, i32::from(capacity))])
            }
            _ => return Err("only an array has elements".to_string()),
        };
        if indices.len() != bounds.len() {
            return Err(format!("the array must have as many indices as dimensions ({})", bounds.len()));
        }
        let mut stride = self.program.size(&of);
        // The last index varies fastest, so strides are computed from the last; indices are evaluated from the first.
        let mut strides = Vec::new();
        for (low, high) in bounds.iter().rev() {
            strides.push(stride);
            stride = stride.saturating_mul((i64::from(*high) - i64::from(*low) + 1).max(0) as usize);
        }
        for ((index, bounds), stride) in indices.iter().zip(bounds).zip(strides.into_iter().rev()) {
            let (low, high) = (i64::from(bounds.0), i64::from(bounds.1));
            if let Some(number) = index.constant_within(bounds) {
                offset += (number - low) as usize * stride;
                continue;
            }
            let index = self.integer(scope, index)?;
            let to = scope.take()?;
            self.code.bounds.push(Bounds { low, high, stride: stride as u64 });
            let line = std::mem::replace(&mut scope.at, at);
            self.emit(scope, Op::Index { to, base, index, bounds: (self.code.bounds.len() - 1) as u32 });
            scope.at = line;
            base = to;
        }
        Ok((Location::Memory { base, offset }, of))
    }

    fn element_of_open(
        &mut self,
        scope: &mut Scope,
        place: &Place,
        of: Box<Type>,
        dimensions: usize,
        indices: &[Expr],
        at: At,
    ) -> Result<(Location, Type), String> {
        let Base::Local(local) = place.base else { return Err("an open array must be a parameter".to_string()) };
        let Home::Reference(home) = scope.homes[local] else { return Err("open arrays are by reference".to_string()) };
        if indices.len() != dimensions {
            return Err(format!("the array must have as many indices as dimensions ({dimensions})"));
        }
        let number = scope.take()?;
        self.emit(scope, Op::Const { to: number, bits: 0 });
        for (dimension, index) in indices.iter().enumerate() {
            let index = self.integer(scope, index)?;
            let line = std::mem::replace(&mut scope.at, at);
            self.emit(scope, Op::IndexOpen { number, index, bounds: home + 1 + 2 * dimension as Register });
            scope.at = line;
        }
        let size = self.program.size(&of) as u32;
        self.emit(scope, Op::Scale { to: number, base: home, number, size });
        Ok((Location::Memory { base: number, offset: 0 }, *of))
    }

    /// The base register, offset and type of a variable, which must be in memory.
    pub(super) fn in_memory(&mut self, scope: &mut Scope, place: &Place) -> Result<((Register, usize), Type), String> {
        match self.place(scope, place)? {
            (Location::Memory { base, offset }, ty) => Ok(((base, offset), ty)),
            (Location::Register(_), _) => Err("a number cannot be passed by reference or copied".to_string()),
        }
    }

    /// The register with the address of a variable in memory, and the variable's type.
    pub(super) fn address(&mut self, scope: &mut Scope, place: &Place) -> Result<(Register, Type), String> {
        let (at, ty) = self.in_memory(scope, place)?;
        Ok((self.address_of(scope, at)?, ty))
    }

    /// The register with an address: the base register if the offset is 0, else a new one.
    pub(super) fn address_of(&mut self, scope: &mut Scope, at: (Register, usize)) -> Result<Register, String> {
        if at.1 == 0 {
            return Ok(at.0);
        }
        let to = scope.take()?;
        self.address_to(scope, at, to);
        Ok(to)
    }

    /// Emits an instruction that computes an address in the register `to`.
    pub(super) fn address_to(&mut self, scope: &Scope, (base, offset): (Register, usize), to: Register) {
        self.emit(scope, Op::Address { to, base, offset: offset as u32 });
    }

    /// Emits an instruction that stores a number in a variable.
    pub(super) fn store(&mut self, scope: &mut Scope, to: Location, ty: Scalar, from: Register) {
        match to {
            Location::Register(to) if to == from => {}
            Location::Register(to) => self.emit(scope, Op::Move { to, from }),
            Location::Memory { base, offset } => {
                self.emit(scope, Op::store(ty, from, base, offset as u32));
            }
        }
    }

    /// Emits an instruction that copies a variable from one address to another.
    pub(super) fn copy(
        &mut self,
        scope: &Scope,
        (to, to_type): (Register, &Type),
        (from, from_type): (Register, &Type),
    ) -> Result<(), String> {
        match (to_type, from_type) {
            (Type::Text { capacity: to_capacity, wide }, Type::Text { capacity: from_capacity, wide: same })
                if wide == same =>
            {
                let (to_capacity, from_capacity, wide) = (*to_capacity, *from_capacity, *wide);
                self.emit(scope, Op::CopyText { to, from, to_capacity, from_capacity, wide });
            }
            (Type::Text { .. } | Type::Open { .. }, _) | (_, Type::Text { .. } | Type::Open { .. }) => {
                return Err("a string can only be copied to a string of the same type; open arrays cannot be copied"
                    .to_string());
            }
            _ => {
                let (size, found) = (self.program.size(to_type), self.program.size(from_type));
                if size != found {
                    return Err(wrong_type(format!("{size} bytes"), format!("{found} bytes")));
                }
                self.emit(scope, Op::Copy { to, from, size: size as u32 });
            }
        }
        Ok(())
    }
}

impl Scope<'_> {
    /// Allocates a register.
    pub(super) fn take(&mut self) -> Result<Register, String> {
        let register = Register::try_from(self.next)
            .map_err(|_| "an expression is too large: split it into several statements".to_string())?;
        self.next += 1;
        self.most = self.most.max(self.next);
        Ok(register)
    }
}

const _: () = assert!(LARGEST_MEMORY <= u32::MAX as usize);
