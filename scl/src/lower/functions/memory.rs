//! Functions on arrays, bit strings and timers, and RUNTIME.

use super::super::Lowerer;
use super::super::convert::{binary, convert, zero};
use super::super::paths::{Slice, Variable};
use super::Given;
use crate::check::compiler::{Operand, Parameter, Slot};
use crate::check::types::{Class, Elementary, Type};
use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, ExpressionKind};
use crate::ir::{self, Binary, Convert, Expr, For, Scalar, Statement, Step, What};

impl Lowerer<'_, '_> {
    pub(super) fn bound(&mut self, given: &Given) -> Operand {
        let array = self.argument(given, "ARR", 0);
        let dimension = given.find("DIM", 1).and_then(|id| self.whole(id));
        let is_upper = given.name == "UPPER_BOUND";
        let number =
            dimension.and_then(|dimension| usize::try_from(dimension).ok()).filter(|dimension| *dimension >= 1);
        match (array, number) {
            (Operand::Variable(Type::Array(array), _), Some(number)) if number <= array.bounds.len() => {
                let (low, high) = array.bounds[number - 1];
                Operand::Value(Elementary::DInt, Expr::Const(if is_upper { high } else { low }.into()))
            }
            (Operand::Variable(Type::Open(_, dimensions), place), Some(number)) if number <= dimensions => {
                let ir::Base::Local(local) = place.base else { return Operand::Wrong(None) };
                let bound = Expr::Bound { local, dimension: number - 1, upper: is_upper };
                Operand::Value(Elementary::DInt, bound)
            }
            (Operand::Wrong(_), _) | (_, None) => Operand::Wrong(None),
            (_, Some(_)) => self.error(given.span, format!("{} needs an array with that dimension", given.name), None),
        }
    }

    /// The number of elements in an array.
    pub(super) fn count(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Variable(Type::Array(array), _) => {
                let count = array.bounds.iter().map(|(low, high)| ir::extent(*low, *high)).product::<usize>();
                Operand::Value(Elementary::UDInt, Expr::Const((count as u32).into()))
            }
            Operand::Variable(Type::Open(_, 1), ir::Place { base: ir::Base::Local(local), .. }) => {
                let at = self.at(given.span);
                let [low, high] = [false, true].map(|upper| Expr::Bound { local, dimension: 0, upper });
                let last = binary(Binary::Sub, Scalar::I32, high, low, at);
                let count = binary(Binary::Add, Scalar::I32, last, Expr::Const(1_i32.into()), at);
                Operand::Value(Elementary::UDInt, convert(count, Scalar::I32, Scalar::U32, Convert::Value, at))
            }
            Operand::Wrong(name) => Operand::Wrong(name),
            _ => self.error(given.span, format!("{} needs an array or a one-dimensional ARRAY[*]", given.name), None),
        }
    }

    pub(super) fn runtime(&mut self, given: &Given) -> Operand {
        let Some(block) = self.compiler.system_block("RUNTIME") else { return Operand::Wrong(None) };
        let Some(id) = given.find("MEM", 0) else {
            return self.error(given.span, "RUNTIME is called without MEM", None);
        };
        let Some(memory) = self.target(id) else { return Operand::Wrong(None) };
        if memory.of != Type::Elementary(Elementary::LReal) {
            return self.error(self.span(id), "MEM of RUNTIME must be an LREAL", None);
        }
        let function = self.compiler.blocks[block].function;
        let result = self.temp(ir::Type::Scalar(Scalar::F64));
        let value = Expr::Load(Scalar::F64, memory.place.clone());
        let call = ir::Call {
            function,
            instance: None,
            arguments: vec![ir::Argument::Value(value)],
            outputs: vec![(0, memory.place), (self.value_local(function), result.clone())],
        };
        let (code, ()) = self.aside(|lowerer| lowerer.push(given.span, What::Call(call)));
        Operand::Value(Elementary::LReal, Expr::After(code, Box::new(Expr::Load(Scalar::F64, result))))
    }

    pub(super) fn timer_function(&mut self, given: &Given) {
        let Some(id) = given.find("TIMER", if given.name == "RESET_TIMER" { 0 } else { 1 }) else {
            self.error(given.span, format!("{} is called without TIMER", given.name), None);
            return;
        };
        let Some(Variable { of: Type::Instance(block), place, .. }) = self.target(id) else { return };
        if !self.compiler.is_timer(block) {
            self.error(self.span(id), "this is not a timer", None);
            return;
        }
        let members = self.compiler.blocks[block].members.clone();
        let slot = |member: &Parameter| match member.slot {
            Slot::Member(number) => number,
            Slot::Local(_) => 0,
        };
        if given.name == "RESET_TIMER" {
            for member in &members {
                if let Type::Elementary(of) = member.of {
                    self.push(given.span, What::Assign(place.clone().member(slot(member)), zero(of)));
                }
            }
            return;
        }
        let time = self.argument(given, "PT", 0);
        let of = |key: &str| members.iter().find(|member| member.key == key);
        let (Some(pt), Some(held)) = (of("PT"), of("HELD")) else { return };
        let Type::Elementary(elementary) = pt.of else { return };
        let value = self.converted(time, elementary, given.span);
        let at = self.at(given.span);
        let pt = place.clone().member(slot(pt));
        self.push(given.span, What::Assign(pt.clone(), value));
        let wide = convert(Expr::Load(elementary.scalar(), pt), elementary.scalar(), Scalar::I64, Convert::Value, at);
        let value = binary(Binary::Max, Scalar::I64, wide, Expr::Const(0i64.into()), at);
        self.push(given.span, What::Assign(place.member(slot(held)), value));
    }

    /// MOVE_BLK, FILL_BLK: copy or fill element by element.
    pub(super) fn block_of_elements(&mut self, given: &Given) {
        let is_fill = given.name.contains("FILL");
        let (Some(input), Some(count), Some(output)) =
            (given.find("IN", 0), given.find("COUNT", 1), given.find("OUT", 2))
        else {
            self.error(given.span, format!("{} is called without IN, COUNT or OUT", given.name), None);
            return;
        };
        let is_element =
            |lowerer: &Self, id: ExpressionId| matches!(lowerer.expressions()[id].kind, ExpressionKind::Index(..));
        if !is_element(self, output) || !is_fill && !is_element(self, input) {
            let help = "pass the first element, such as #a[0]";
            self.error(given.span, format!("{} copies between array elements", given.name), Some(help));
            return;
        }
        let operand = self.operand(count, Some(Elementary::DInt));
        let count = self.quietly(operand, Elementary::DInt, given.span);
        let Some(mut to) = self.target(output) else { return };
        to.place = self.frozen(to.place, given.span);
        let from = if is_fill { None } else { self.target(input) };
        let from = from.map(|from| Variable { place: self.frozen(from.place.clone(), given.span), ..from });
        if !is_fill && from.is_none() {
            return;
        }
        let fill = if is_fill { Some(self.operand(input, to.of.elementary())) } else { None };
        self.elements(from.as_ref(), fill, count, &to, given.span);
    }

    /// MOVE_BLK_VARIANT on arrays: like MOVE_BLK, but the elements are counted from 0.
    pub(super) fn elements_of_arrays(&mut self, given: &Given) -> Operand {
        let named = ["SRC", "COUNT", "SRC_INDEX", "DEST_INDEX", "DEST"];
        let found: Vec<ExpressionId> = (0..).zip(named).filter_map(|(at, name)| given.find(name, at)).collect();
        let Ok([source, count, first, first_to, destination]) = <[ExpressionId; 5]>::try_from(found) else {
            let message = format!("{} needs {}", given.name, named.join(", "));
            return self.error(given.span, message, None);
        };
        let (code, is_done) = self.aside(|lowerer| {
            let operand = lowerer.operand(count, Some(Elementary::DInt));
            let count = lowerer.quietly(operand, Elementary::DInt, given.span);
            let from = lowerer.element_of(source, first, given)?;
            let to = lowerer.element_of(destination, first_to, given)?;
            if !from.of.is_like(&to.of) {
                let message =
                    format!("{} needs elements of the same type, found {} and {}", given.name, from.of, to.of);
                lowerer.error(given.span, message, Some("copy them in a loop"));
                return None;
            }
            lowerer.use_view(&to, true);
            lowerer.elements(Some(&from), None, count, &to, given.span);
            Some(())
        });
        is_done.map_or(Operand::Wrong(None), |()| no_error(code))
    }

    /// The element of an array at a zero-based index.
    fn element_of(&mut self, array: ExpressionId, number: ExpressionId, given: &Given) -> Option<Variable> {
        let variable = self.target(array)?;
        let at = self.at(given.span);
        let (of, low) = match (&variable.of, variable.place.base) {
            (Type::Array(array), _) if array.bounds.len() == 1 => {
                (array.of.clone(), Expr::Const(array.bounds[0].0.into()))
            }
            (Type::Open(of, 1), ir::Base::Local(local)) => {
                ((**of).clone(), Expr::Bound { local, dimension: 0, upper: false })
            }
            (Type::Wrong | Type::Missing(_), _) => return None,
            (other, _) => {
                let message = format!("{} copies between one-dimensional arrays, found {other}", given.name);
                self.error(self.span(array), message, Some("assign the variable itself"));
                return None;
            }
        };
        let operand = self.operand(number, Some(Elementary::DInt));
        let number = self.quietly(operand, Elementary::DInt, self.span(number));
        let mut place = variable.place;
        place.steps.push(Step::Index(vec![binary(Binary::Add, Scalar::I32, low, number, at)], at));
        Some(Variable::whole(of, self.frozen(place, given.span)))
    }

    /// BLKMOV between variables of the same type: an assignment.
    pub(super) fn copied_block(&mut self, given: &Given) -> Operand {
        let (Some(from), Some(to)) = (given.find("SRCBLK", 0), given.find("DSTBLK", 1)) else {
            return self.error(given.span, format!("{} needs SRCBLK and DSTBLK", given.name), None);
        };
        let (code, is_done) = self.aside(|lowerer| {
            let (from, to) = (lowerer.target(from)?, lowerer.target(to)?);
            if !from.of.is_like(&to.of) && !from.of.is_wrong() && !to.of.is_wrong() {
                let message = format!(
                    "{} copies between variables of the same type, found {} and {}",
                    given.name, from.of, to.of
                );
                lowerer.error(given.span, message, Some("assign their members, or view one as the other with AT"));
                return None;
            }
            let value = lowerer.value_of(&from, given.span);
            lowerer.assign(&to, value, given.span);
            Some(())
        });
        is_done.map_or(Operand::Wrong(None), |()| no_error(code))
    }

    /// Copies consecutive elements one by one, or fills them with a value.
    fn elements(&mut self, from: Option<&Variable>, fill: Option<Operand>, count: Expr, to: &Variable, span: Span) {
        let number = self.temp(ir::Type::Scalar(Scalar::I32));
        let at = self.at(span);
        let moved = |variable: &Variable| {
            let mut variable = variable.clone();
            if let Some(Step::Index(indices, _)) = variable.place.steps.last_mut()
                && let Some(index) = indices.last_mut()
            {
                let of = index.ty();
                let number = convert(Expr::Load(Scalar::I32, number.clone()), Scalar::I32, of, Convert::Value, at);
                let first = std::mem::replace(index, Expr::Const(0i32.into()));
                *index = binary(Binary::Add, of, first, number, at);
            }
            variable
        };
        let (body, ()) = self.aside(|lowerer| {
            let target = moved(to);
            let value = match (from, fill) {
                (Some(from), _) => lowerer.value_of(&moved(from), span),
                (None, Some(fill)) => fill,
                (None, None) => return,
            };
            lowerer.assign(&target, value, span);
        });
        let last = binary(Binary::Sub, Scalar::I32, count, Expr::Const(1i32.into()), at);
        let first = Expr::Const(0i32.into());
        let step = Expr::Const(1i32.into());
        self.push(span, What::For(Box::new(For { variable: number, first, last, step, body })));
    }

    /// SCATTER, GATHER: copy between the bits of a bit string and an array or structure with one BOOL per bit.
    pub(super) fn bits_of_elements(&mut self, given: &Given) {
        let (Some(input), Some(output)) = (given.find("IN", 0), given.find("OUT", 1)) else {
            self.error(given.span, format!("{} is called without IN or OUT", given.name), None);
            return;
        };
        let (Some(from), Some(to)) = (self.target(input), self.target(output)) else { return };
        let (from, to) = [from, to]
            .map(|variable| Variable { place: self.frozen(variable.place.clone(), given.span), ..variable })
            .into();
        let (bits, elements) = if given.name == "SCATTER" { (&from, &to) } else { (&to, &from) };
        let places = self.booleans(elements, given.span);
        let of = bits.of.elementary().filter(|of| of.class() == Class::Bits);
        let Some(of) = of.filter(|of| of.bits() as usize == places.len()) else {
            let message =
                format!("{} needs a bit string and one BOOL per bit, found {} and {}", given.name, from.of, to.of);
            self.error(given.span, message, None);
            return;
        };
        for (place, shift) in places.into_iter().zip(0..of.bits()) {
            let element = Variable::whole(Type::Elementary(Elementary::Bool), place);
            let bit = Variable { slice: Some(Slice { of: Elementary::Bool, shift }), ..bits.clone() };
            let (from, to) = if given.name == "SCATTER" { (bit, element) } else { (element, bit) };
            let value = self.value_of(&from, given.span);
            self.assign(&to, value, given.span);
        }
    }

    /// The places of the BOOLs in an array or structure; empty if it contains anything else.
    fn booleans(&self, variable: &Variable, span: Span) -> Vec<ir::Place> {
        let boolean = Type::Elementary(Elementary::Bool);
        match &variable.of {
            Type::Array(array) if array.of == boolean && array.bounds.len() == 1 => {
                let at = self.at(span);
                let (low, high) = array.bounds[0];
                let element = |index: i32| {
                    let mut place = variable.place.clone();
                    place.steps.push(Step::Index(vec![Expr::Const(index.into())], at));
                    place
                };
                // No bit string is longer than 64 bits.
                (low..=high).take(65).map(element).collect()
            }
            Type::Structure(structure) if structure.fields.iter().all(|field| field.of == boolean) => {
                (0..structure.fields.len()).map(|number| variable.place.clone().member(number)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// DECO: a bit string with one bit set, DWORD if the context does not determine a type.
    pub(super) fn decoded(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let of = expected.filter(|of| of.class() == Class::Bits).unwrap_or(Elementary::DWord);
        let number = self.argument(given, "IN", 0);
        if matches!(number, Operand::Wrong(_)) {
            return number;
        }
        let number = self.converted(number, Elementary::UDInt, given.span);
        let at = self.at(given.span);
        let bit = binary(Binary::And, Scalar::U32, number, Expr::Const((of.bits() - 1).into()), at);
        let one = Expr::Const(ir::Value::new(of.scalar(), 1));
        Operand::Value(of, binary(Binary::Shl, of.scalar(), one, bit, at))
    }
}

/// The return value of a function that returns an error code, after these statements. It is always 0: errors are
/// reported at compile time or stop the program.
fn no_error(code: Vec<Statement>) -> Operand {
    Operand::Value(Elementary::Int, Expr::After(code, Box::new(Expr::Const(0_i16.into()))))
}
