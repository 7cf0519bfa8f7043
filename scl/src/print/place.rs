//! Prints variables and their parts.

use super::{Printer, declared, number};
use crate::check::types::Elementary;
use crate::ir::{Base, Kind, Place, Step, Type};

/// The printed root of a place: text, type, declared type, and the remaining steps.
type Begun<'p> = (String, Type, Option<Kind>, &'p [Step]);

impl Printer<'_> {
    /// A place as text, and its type if it is elementary.
    pub(super) fn place(&mut self, place: &Place) -> Result<(String, Option<Elementary>), String> {
        let program = self.program;
        let (mut text, mut ty, mut kind, rest) = self.base(place)?;
        for step in rest {
            match (step, ty) {
                (Step::Member(number), Type::Record(record)) => {
                    let member = &program.records[record].members[*number];
                    text = format!("{text}.{}", self.member(&member.name)?);
                    kind = program.docs.declared.get(&(record, *number)).and_then(|declared| declared.of);
                    ty = member.ty.clone();
                }
                (Step::Index(indices, _), Type::Array { of, .. } | Type::Open { of, .. }) => {
                    let indices: Result<Vec<String>, String> = indices.iter().map(|index| self.index(index)).collect();
                    text = format!("{text}[{}]", indices?.join(", "));
                    ty = *of;
                }
                (Step::Index(indices, _), Type::Text { wide, .. }) => {
                    text = format!("{text}[{}]", self.index(&indices[0])?);
                    let of = if wide { Elementary::WChar } else { Elementary::Char };
                    return Ok((text, Some(self.dialect.check(of)?)));
                }
                (Step::Length, _) => return Err(format!("SCL has no variable for the length of {text}")),
                _ => return Err(format!("SCL cannot express the part of {text} that is used here")),
            }
        }
        match ty {
            Type::Scalar(ty) => Ok((text, Some(self.dialect.check(declared(ty, kind))?))),
            _ => Ok((text, None)),
        }
    }

    fn index(&mut self, index: &crate::ir::Expr) -> Result<String, String> {
        if self.hoists(index) {
            return Err("an index computed by statements cannot be written in SCL".to_string());
        }
        self.argument(index, number(index.ty()))
    }

    fn base<'p>(&mut self, place: &'p Place) -> Result<Begun<'p>, String> {
        let program = self.program;
        let first = match place.steps.first() {
            Some(Step::Member(number)) => Some(*number),
            _ => None,
        };
        let rest = place.steps.get(1..).unwrap_or_default();
        match (place.base, first) {
            (Base::Local(local), _) => {
                self.scope.used.insert(local);
                Ok((self.own(&self.scope.interface.locals[local]), self.local_type(local).clone(), None, &place.steps))
            }
            (Base::Instance, Some(_)) => {
                let record = self.scope.function.and_then(|function| function.instance).unwrap_or_default();
                let number = |step: &Step| match step {
                    Step::Member(number) => Some(*number),
                    _ => None,
                };
                let mut path: Vec<usize> = place.steps.iter().map_while(number).collect();
                while !self.scope.interface.members.contains_key(&path) {
                    if path.pop().is_none() {
                        return Err("the function does not receive a part of the instance that it uses".to_string());
                    }
                }
                let (ty, kind) = self.part(record, &path);
                Ok((self.own(&self.scope.interface.members[&path]), ty, kind, &place.steps[path.len()..]))
            }
            (Base::Memory, Some(number)) => {
                let member = &program.records[program.memory].members[number];
                let text = match member.ty {
                    Type::Record(_) => format!("\"{}\"", self.globals[number]),
                    _ => format!("\"{}\".{}", self.loose, self.member(&member.name)?),
                };
                Ok((text, member.ty.clone(), None, rest))
            }
            _ => Err("a constant that is not a string cannot be written in SCL".to_string()),
        }
    }

    /// The literal of the constant string at a place, if there is one.
    pub(super) fn constant_text(&self, place: &Place) -> Option<String> {
        let (Base::Constants, [Step::Member(number)]) = (place.base, place.steps.as_slice()) else { return None };
        let record = &self.program.records[self.program.constants];
        let member = &record.members[*number];
        let Type::Text { wide, .. } = member.ty else { return None };
        let bytes = &record.start[member.offset..];
        let length = usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
        let width = 1 + usize::from(wide);
        let units: Vec<u16> = bytes[2..2 + width * length]
            .chunks(width)
            .map(|unit| u16::from(unit[0]) | unit.get(1).map_or(0, |high| u16::from(*high) << 8))
            .collect();
        let text: String = if wide {
            String::from_utf16_lossy(&units)
        } else {
            units.iter().filter_map(|unit| char::from_u32((*unit).into())).collect()
        };
        let escaped: String = text
            .chars()
            .map(|c| match c {
                '\'' | '$' => format!("${c}"),
                c if u32::from(c) < 0x20 => format!("${:02X}", u32::from(c)),
                c => c.to_string(),
            })
            .collect();
        Some(format!("{}'{escaped}'", if wide { "WSTRING#" } else { "" }))
    }
}
