//! `AT` views: variables that show the bytes of another variable as a different type.
//!
//! A CPU stores variables as bytes, numbers in big-endian order and truth values as bits, whereas the machine stores
//! each in its own layout. A view is therefore a separate variable: it is computed before each statement that uses it
//! and, if the statement writes it, copied back to the viewed variable.

use super::Lowerer;
use super::convert::{binary, convert};
use super::paths::Variable;
use crate::check::compiler::{Compiler, Slot, Symbol, View};
use crate::check::types::{Class, Elementary, Type};
use crate::front::lexer::Span;
use crate::ir::{At, Base, Binary, Convert, Expr, Place, Scalar, Step, What};

/// The maximum number of parts in a view: each costs an operation in every statement that uses the view.
const MOST_PARTS: usize = 4096;

/// A number at its position in the CPU's memory.
struct Part {
    place: Place,
    of: Elementary,
    /// The offset of its first bit: 8 times the byte plus, for a truth value, the bit within it.
    bit: usize,
    holds: Holds,
}

/// The meaning of a part.
#[derive(Clone, Copy, PartialEq)]
enum Holds {
    Number,
    /// The length of a string: 16 bits in the machine, one byte in a CPU.
    Length,
    /// The capacity of a string, which cannot be changed.
    Capacity(u8),
}

impl Part {
    fn bits(&self) -> usize {
        self.of.bits() as usize
    }

    fn end(&self) -> usize {
        self.bit + self.bits()
    }

    /// The bits of the part as a `U64`.
    fn load(&self, at: At) -> Expr {
        match self.holds {
            Holds::Number => bits_of(Expr::Load(self.of.scalar(), self.place.clone()), self.of, at),
            Holds::Length => {
                convert(Expr::Load(Scalar::U16, self.place.clone()), Scalar::U16, Scalar::U64, Convert::Value, at)
            }
            Holds::Capacity(capacity) => Expr::Const(u64::from(capacity).into()),
        }
    }

    /// The assignment of a value of its type; `None` if the part cannot be changed.
    fn assigned(&self, value: Expr, capacity: u8, at: At) -> Option<What> {
        let value = match self.holds {
            Holds::Number => value,
            Holds::Length => {
                // A string's length never exceeds its capacity.
                let most = Expr::Const(u16::from(capacity).into());
                let length = convert(value, self.of.scalar(), Scalar::U16, Convert::Value, at);
                binary(Binary::Min, Scalar::U16, length, most, at)
            }
            Holds::Capacity(_) => return None,
        };
        Some(What::Assign(self.place.clone(), value))
    }
}

/// The parts of a variable in byte order.
struct Image {
    parts: Vec<Part>,
    /// The size in bits so far.
    end: usize,
    at: At,
    /// Whether this is the viewed variable, not the view.
    is_behind: bool,
}

impl Image {
    /// The image of a variable; the error is a noun phrase for the part of it that has none.
    fn new(place: Place, of: &Type, at: At, is_behind: bool) -> Result<Image, String> {
        let mut image = Image { parts: Vec::new(), end: 0, at, is_behind };
        image.add(place, of)?;
        Ok(image)
    }

    fn bytes(&self) -> usize {
        self.end.div_ceil(8)
    }

    fn push(&mut self, place: Place, of: Elementary, holds: Holds) {
        self.parts.push(Part { place, of, bit: self.end, holds });
        self.end += of.bits() as usize;
    }

    /// Adds a variable: single bytes and truth values are packed, everything else starts at an even byte.
    fn add(&mut self, place: Place, of: &Type) -> Result<(), String> {
        match of {
            Type::Elementary(Elementary::Dt) => Err("a DATE_AND_TIME, which a CPU stores in BCD,".to_string()),
            Type::Elementary(of) => {
                match of.bits() {
                    1 => {}
                    8 => self.end = self.end.next_multiple_of(8),
                    _ => self.end = self.end.next_multiple_of(16),
                }
                if self.parts.len() == MOST_PARTS {
                    return Err(format!("a variable with more than {MOST_PARTS} numbers"));
                }
                self.push(place, *of, Holds::Number);
                Ok(())
            }
            Type::Array(array) => {
                let is_small = array.of.elementary().is_some_and(|of| of.bits() <= 8);
                if is_small && array.bounds.len() > 1 {
                    return Err("a multidimensional array with byte or bit elements".to_string());
                }
                self.end = self.end.next_multiple_of(16);
                for indices in indices(&array.bounds) {
                    let mut element = place.clone();
                    let indices = indices.into_iter().map(|index| Expr::Const(index.into())).collect();
                    element.steps.push(Step::Index(indices, self.at));
                    self.add(element, &array.of)?;
                }
                self.end = self.end.next_multiple_of(16);
                Ok(())
            }
            Type::Structure(structure) => {
                self.end = self.end.next_multiple_of(16);
                for (number, field) in structure.fields.iter().enumerate() {
                    self.add(place.clone().member(number), &field.of)?;
                }
                self.end = self.end.next_multiple_of(16);
                Ok(())
            }
            Type::Text { capacity, wide: false } if self.is_behind => {
                let capacity = (*capacity).min(254) as u8;
                if self.parts.len() + usize::from(capacity) + 2 > MOST_PARTS {
                    return Err(format!("a variable with more than {MOST_PARTS} numbers"));
                }
                self.end = self.end.next_multiple_of(16);
                let with = |step| {
                    let mut place = place.clone();
                    place.steps.push(step);
                    place
                };
                self.push(place.clone(), Elementary::Byte, Holds::Capacity(capacity));
                self.push(with(Step::Length), Elementary::Byte, Holds::Length);
                for index in 1..=i32::from(capacity) {
                    let character = with(Step::Index(vec![Expr::Const(index.into())], self.at));
                    self.push(character, Elementary::Char, Holds::Number);
                }
                self.end = self.end.next_multiple_of(16);
                Ok(())
            }
            Type::Text { wide: true, .. } => Err("a WSTRING".to_string()),
            Type::Text { .. } => Err("a STRING, because a view has no length field,".to_string()),
            Type::Open(..) => Err("an array whose bounds are set by the caller".to_string()),
            Type::Instance(_) | Type::Void | Type::Wrong | Type::Missing(_) => Err("an instance".to_string()),
        }
    }

    /// A byte as a `U64`; 0 between parts.
    fn byte(&self, number: usize) -> Expr {
        let at = self.at;
        let first = self.parts.partition_point(|part| part.end() <= number * 8);
        let within = self.parts[first..].iter().take_while(|part| part.bit < number * 8 + 8);
        let mut sum: Option<Expr> = None;
        for part in within {
            let value = part.load(at);
            let value = if part.bits() == 1 {
                shifted(Binary::Shl, value, part.bit % 8, at)
            } else {
                // Big-endian: the highest byte comes first.
                let high = shifted(Binary::Shr, value, part.end() - (number * 8 + 8), at);
                binary(Binary::And, Scalar::U64, high, Expr::Const(0xff_u64.into()), at)
            };
            sum = Some(match sum {
                Some(sum) => binary(Binary::Or, Scalar::U64, sum, value, at),
                None => value,
            });
        }
        sum.unwrap_or(Expr::Const(0_u64.into()))
    }

    /// A mask of the bits of another image's part that this image does not cover because of gaps or its end.
    fn missing(&self, part: &Part) -> u64 {
        let has = |bit: usize| {
            let first = self.parts.partition_point(|own| own.end() <= bit);
            self.parts.get(first).is_some_and(|own| own.bit <= bit)
        };
        let bits = (0..part.bits()).filter(|bit| !has(part.bit + bit));
        // The highest byte comes first; within a byte, the lowest bit.
        let number = |bit: usize| if part.bits() == 1 { 0 } else { part.bits() - 8 - bit / 8 * 8 + bit % 8 };
        bits.map(number).fold(0, |mask, bit| mask | 1 << bit)
    }

    /// The value of another image's part, computed from the bytes of this one.
    fn value(&self, part: &Part) -> Expr {
        let at = self.at;
        // A number at the same position and of the same size is loaded directly.
        let same = self.parts.binary_search_by_key(&part.bit, |own| own.bit).ok().map(|own| &self.parts[own]);
        if let Some(own) = same.filter(|own| own.bits() == part.bits()) {
            return number_of(own.load(at), part.of, at);
        }
        let first = part.bit / 8;
        let bits = if part.bits() == 1 {
            let shifted = shifted(Binary::Shr, self.byte(first), part.bit % 8, at);
            binary(Binary::And, Scalar::U64, shifted, Expr::Const(1_u64.into()), at)
        } else {
            let bytes = part.bits() / 8;
            (0..bytes)
                .map(|byte| shifted(Binary::Shl, self.byte(first + byte), 8 * (bytes - 1 - byte), at))
                .reduce(|sum, byte| binary(Binary::Or, Scalar::U64, sum, byte, at))
                .unwrap_or(Expr::Const(0_u64.into()))
        };
        number_of(bits, part.of, at)
    }
}

/// All indices of an array in row-major order, but at most one more than a view may have parts.
fn indices(bounds: &[(i32, i32)]) -> Vec<Vec<i32>> {
    let mut all = vec![Vec::new()];
    for (low, high) in bounds {
        let longer = |indices: &Vec<i32>| {
            let indices = indices.clone();
            (*low..=*high).take(MOST_PARTS + 1).map(move |index| [indices.clone(), vec![index]].concat())
        };
        all = all.iter().flat_map(longer).take(MOST_PARTS + 1).collect();
    }
    all
}

/// The bits of a number as a `U64`.
fn bits_of(value: Expr, of: Elementary, at: At) -> Expr {
    let unsigned = unsigned(of);
    let how = if of.class() == Class::Real { Convert::Bits } else { Convert::Value };
    convert(convert(value, of.scalar(), unsigned, how, at), unsigned, Scalar::U64, Convert::Value, at)
}

/// The number with these bits.
fn number_of(bits: Expr, of: Elementary, at: At) -> Expr {
    let unsigned = unsigned(of);
    let how = if of.class() == Class::Real { Convert::Bits } else { Convert::Value };
    convert(convert(bits, Scalar::U64, unsigned, Convert::Value, at), unsigned, of.scalar(), how, at)
}

fn unsigned(of: Elementary) -> Scalar {
    match of.bits() {
        1 => Scalar::Bool,
        8 => Scalar::U8,
        16 => Scalar::U16,
        32 => Scalar::U32,
        _ => Scalar::U64,
    }
}

fn ones(bits: usize) -> u64 {
    u64::MAX >> (64 - bits)
}

fn shifted(operation: Binary, value: Expr, by: usize, at: At) -> Expr {
    if by == 0 {
        return value;
    }
    binary(operation, Scalar::U64, value, Expr::Const((by as u32).into()), at)
}

impl Compiler<'_> {
    /// The images of the viewed variable and the view; the error is a message.
    fn images(&self, behind: (Place, &Type), view: &View) -> Result<(Image, Image), String> {
        let at = self.at(view.span);
        let under =
            Image::new(behind.0, behind.1, at, true).map_err(|what| format!("{what} cannot be viewed through AT"))?;
        let over = Image::new(Place::new(Base::Local(view.local)), &view.of, at, false)
            .map_err(|what| format!("{what} cannot be a view"))?;
        if over.bytes() > under.bytes() {
            return Err(format!("the view has {} bytes, but its variable has only {}", over.bytes(), under.bytes()));
        }
        Ok((under, over))
    }
}

impl Lowerer<'_, '_> {
    /// Whether a variable is a view or a part of one.
    pub(crate) fn is_view(&self, variable: &Variable) -> bool {
        self.views.iter().any(|view| variable.place.base == Base::Local(view.local))
    }

    /// Records that the statement uses a view.
    pub(crate) fn use_view(&mut self, variable: &Variable, is_written: bool) {
        let Base::Local(local) = variable.place.base else { return };
        let Some(number) = self.views.iter().position(|view| view.local == local) else { return };
        match self.used.iter_mut().find(|(used, _)| *used == number) {
            Some((_, written)) => *written |= is_written,
            None => self.used.push((number, is_written)),
        }
    }

    /// The variable underlying a view; `None` if that is itself a view or not a variable of this block.
    fn behind(&self, view: &View) -> Option<(Place, Type)> {
        match self.symbols.get(&view.behind)? {
            Symbol::Variable(_, of, slot) => {
                let place = match slot {
                    Slot::Member(number) => Place::new(Base::Instance).member(*number),
                    Slot::Local(number) => Place::new(Base::Local(*number)),
                };
                (!self.views.iter().any(|view| place == Place::new(Base::Local(view.local))))
                    .then(|| (place, of.clone()))
            }
            Symbol::Constant(_) => None,
        }
    }

    /// Reports errors in the views of a block.
    pub(crate) fn check_views(&mut self) {
        for view in self.views.clone() {
            if view.of.is_wrong() {
                continue;
            }
            let problem = match self.behind(&view) {
                None => Some("AT needs a variable of this block that is not itself a view".to_string()),
                Some((_, Type::Wrong | Type::Missing(_))) => None,
                Some((place, of)) => self.compiler.images((place, &of), &view).err(),
            };
            if let Some(problem) = problem {
                let help = "use slices such as .%X0, Strg_TO_Chars and Chars_TO_Strg, or copy the members one by one";
                self.error(view.span, problem, Some(help));
            }
        }
    }

    /// Lowers `part`: first loads the views it uses and afterwards writes back those it changes. Views used only in the
    /// conditions of nested statements are handled there.
    pub(crate) fn with_views<T>(&mut self, span: Span, part: impl FnOnce(&mut Self) -> T) -> T {
        if self.views.is_empty() {
            return part(self);
        }
        let outer = std::mem::take(&mut self.used);
        let (code, result) = self.aside(part);
        let used = std::mem::replace(&mut self.used, outer);
        for (number, _) in &used {
            self.show(*number, span);
        }
        self.code.extend(code);
        for (number, _) in used.iter().filter(|(_, written)| *written) {
            self.write_back(*number, span);
        }
        result
    }

    fn images_of(&self, number: usize) -> Option<(Image, Image)> {
        let view = &self.views[number];
        let (place, of) = self.behind(view)?;
        self.compiler.images((place, &of), view).ok()
    }

    fn show(&mut self, number: usize, span: Span) {
        let Some((under, over)) = self.images_of(number) else { return };
        for part in &over.parts {
            self.push(span, What::Assign(part.place.clone(), under.value(part)));
        }
    }

    /// Writes a view back. Bits that it does not cover keep their values.
    fn write_back(&mut self, number: usize, span: Span) {
        let Some((under, over)) = self.images_of(number) else { return };
        let at = self.at(span);
        let mut capacity = 0;
        for part in &under.parts {
            if let Holds::Capacity(most) = part.holds {
                capacity = most;
            }
            let (all, kept) = (ones(part.bits()), over.missing(part));
            if kept == all {
                continue;
            }
            let mut value = over.value(part);
            if kept != 0 {
                let [new, old] = [(bits_of(value, part.of, at), !kept), (part.load(at), kept)]
                    .map(|(bits, mask)| binary(Binary::And, Scalar::U64, bits, Expr::Const(mask.into()), at));
                value = number_of(binary(Binary::Or, Scalar::U64, new, old, at), part.of, at);
            }
            if let Some(assigned) = part.assigned(value, capacity, at) {
                self.push(span, assigned);
            }
        }
    }
}
