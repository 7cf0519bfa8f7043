//! From syntax tree to program: lowers a block's statements and expressions, using the declarations from
//! [`check`](crate::check), to the body of its function in the typed program ([`ir`](crate::ir)), where every
//! conversion is explicit.

mod calls;
mod convert;
mod expressions;
mod functions;
mod operators;
mod paths;
mod statements;
mod views;

use crate::check::compiler::{Compiler, Operand, Slot, Symbol, View};
use crate::check::types::{Elementary, Type};
use crate::check::undeclared::Missing;
use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, Expressions, key};
use crate::ir::{self, At, Base, Body, Expr, Local, Place, Statement, Value, What};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

pub(crate) use convert::zero;
pub(crate) use expressions::DTL_BYTES;
pub(crate) use functions::{is_of_variants, is_ordinary, refused};
pub(crate) use paths::placed;

/// An enclosing loop.
struct Loop {
    /// Its counter, if it is a FOR loop.
    variable: Option<Place>,
}

/// A label and the jumps to it.
struct LabelOf {
    number: usize,
    /// The loops around it; `None` while only jumps to it have been seen.
    loops: Option<Vec<usize>>,
    /// The position of each jump to it, and the loops around the jump.
    jumps: Vec<(Span, Vec<usize>)>,
}

/// The lowering of one block.
pub(crate) struct Lowerer<'c, 'a> {
    compiler: &'c mut Compiler<'a>,
    file: usize,
    block: Option<usize>,
    symbols: Rc<HashMap<String, Symbol>>,
    /// Network temporaries whose type is not yet known.
    untyped: HashSet<String>,
    locals: Vec<Local>,
    code: Vec<Statement>,
    loops: Vec<(usize, Loop)>,
    loop_count: usize,
    labels: HashMap<String, LabelOf>,
    eno: Option<usize>,
    /// The AT views of the block.
    views: Vec<View>,
    /// The views used by the current statement, and whether it writes them.
    used: Vec<(usize, bool)>,
}

impl<'a> Compiler<'a> {
    /// Lowers the statements of a block.
    pub fn translate(&mut self, block: usize) {
        let Some(id) = self.blocks[block].source.filter(|_| !self.blocks[block].is_stub) else { return };
        let function = self.blocks[block].function;
        let symbols = self.blocks[block].symbols.clone();
        let views = self.blocks[block].views.clone();
        let locals = std::mem::take(&mut self.program.functions[function].locals);
        let temps = locals.len();
        let body = &self.block(id).body;
        let mut lowerer = Lowerer::new(self, id.0, symbols);
        lowerer.block = Some(block);
        lowerer.views = views;
        lowerer.locals = locals;
        lowerer.check_views();
        lowerer.statements(body);
        lowerer.check_labels();
        let Lowerer { locals, mut code, eno, .. } = lowerer;
        let eno = eno.or(self.blocks[block].eno);
        if let Some(eno) = eno {
            let value = Expr::Const(Value::from(true));
            code.insert(0, Statement { at: At::default(), what: What::Assign(Place::new(Base::Local(eno)), value) });
        }
        // A variable written through a view counts as written.
        let is_seen = |name: &str| self.blocks[block].views.iter().any(|view| view.behind == key(name));
        let mut names: Vec<(usize, String)> = self.temps(block, temps);
        names.retain(|(_, name)| !is_seen(name));
        crate::check::lint::unwritten(self, id, &names, &code);
        let function = &mut self.program.functions[function];
        function.locals = locals;
        function.body = Body::Code(code);
    }

    /// The declared temporaries of elementary type in a block: the index of the local, and the name.
    fn temps(&self, block: usize, count: usize) -> Vec<(usize, String)> {
        let temps = self.blocks[block]
            .members
            .iter()
            .filter(|member| member.section == crate::front::syntax::SectionKind::Temp && member.of.is_elementary());
        temps
            .filter_map(|member| match member.slot {
                Slot::Local(number) if number < count => Some((number, member.name.clone())),
                _ => None,
            })
            .collect()
    }

    /// The value of a constant integer, such as an array bound; `None` after an error, which is reported.
    pub fn constant_whole(
        &mut self,
        id: ExpressionId,
        file: usize,
        symbols: &Rc<HashMap<String, Symbol>>,
    ) -> Option<i128> {
        let mut lowerer = Lowerer::new(self, file, symbols.clone());
        lowerer.whole(id)
    }
}

impl<'c, 'a> Lowerer<'c, 'a> {
    fn new(compiler: &'c mut Compiler<'a>, file: usize, symbols: Rc<HashMap<String, Symbol>>) -> Lowerer<'c, 'a> {
        Lowerer {
            compiler,
            file,
            block: None,
            symbols,
            untyped: HashSet::new(),
            locals: Vec::new(),
            code: Vec::new(),
            loops: Vec::new(),
            loop_count: 0,
            labels: HashMap::new(),
            eno: None,
            views: Vec::new(),
            used: Vec::new(),
        }
    }

    /// A lowerer for constant expressions.
    pub(crate) fn of_constants(
        compiler: &'c mut Compiler<'a>,
        file: usize,
        symbols: Rc<HashMap<String, Symbol>>,
    ) -> Lowerer<'c, 'a> {
        Lowerer::new(compiler, file, symbols)
    }

    fn expressions(&self) -> &'a Expressions {
        self.compiler.expressions(self.file)
    }

    fn span(&self, id: ExpressionId) -> Span {
        self.expressions()[id].span
    }

    fn at(&self, span: Span) -> At {
        self.compiler.at(span)
    }

    fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) -> Operand {
        self.compiler.error(span, message, help);
        Operand::Wrong(None)
    }

    fn warn(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.compiler.warn(span, message, help);
    }

    fn push(&mut self, span: Span, what: What) {
        let at = self.at(span);
        self.code.push(Statement { at, what });
    }

    /// Returns the code generated by `part` instead of adding it to the block.
    fn aside<T>(&mut self, part: impl FnOnce(&mut Self) -> T) -> (Vec<Statement>, T) {
        let outer = std::mem::take(&mut self.code);
        let result = part(self);
        (std::mem::replace(&mut self.code, outer), result)
    }

    /// Adds an unnamed temporary to the locals.
    fn temp(&mut self, ty: ir::Type) -> Place {
        let name = format!("_{}", self.locals.len());
        self.locals.push(Local { name, ty, by_reference: false });
        Place::new(Base::Local(self.locals.len() - 1))
    }

    /// Lowers a constant expression to the given type, or to its own type if none is given.
    pub(crate) fn constant(&mut self, id: ExpressionId, of: Option<&Type>) -> Operand {
        let span = self.span(id);
        let operand = self.operand(id, of.and_then(Type::elementary));
        match (operand, of) {
            (Operand::Wrong(missing), _) => {
                missing.iter().for_each(|name| self.compiler.is_constant(name));
                Operand::Wrong(missing)
            }
            (Operand::Text(text, wide), None | Some(Type::Text { .. })) => Operand::Text(text, wide),
            (operand, Some(Type::Elementary(of))) => {
                let value = self.converted(operand, *of, span);
                match value {
                    Expr::Const(_) => Operand::Value(*of, value),
                    _ => self.error(span, "this is not a constant", None),
                }
            }
            (_, Some(Type::Wrong | Type::Missing(_))) => Operand::Wrong(None),
            (operand @ Operand::Variable(..), Some(Type::Structure(_))) => operand,
            (_, Some(of)) => self.error(span, format!("this is not a valid start value for {of}"), None),
            // STEP 7: the notation determines the type.
            (Operand::Whole(whole), None) => {
                let of = if i16::try_from(whole).is_ok() { Elementary::Int } else { Elementary::DInt };
                let value = self.converted(Operand::Whole(whole), of, span);
                Operand::Value(of, value)
            }
            (Operand::Fraction(_, narrow), None) => Operand::Value(Elementary::Real, Expr::Const(narrow.into())),
            (operand @ Operand::Value(_, Expr::Const(_)), None) => operand,
            (_, None) => self.error(span, "this is not a constant", None),
        }
    }

    /// The value of a constant integer or a single character; `None` after an error, which is reported.
    fn whole(&mut self, id: ExpressionId) -> Option<i128> {
        let span = self.span(id);
        match self.operand(id, None) {
            Operand::Whole(whole) => Some(whole),
            Operand::Value(of, Expr::Const(value)) if of.is_whole() || of == Elementary::Char => {
                let bits = value.bits();
                Some(if of == Elementary::ULInt || of == Elementary::LWord {
                    bits.into()
                } else {
                    i128::from(bits as i64)
                })
            }
            Operand::Wrong(name) => {
                name.iter().for_each(|name| self.compiler.is_constant(name));
                None
            }
            Operand::Text(text, _) if text.len() == 1 => Some(text[0].into()),
            _ => {
                self.error(span, "expected a constant integer", None);
                None
            }
        }
    }

    /// Records the type that the context implies for an undeclared name.
    fn guess(&mut self, missing: &Missing, of: Elementary) {
        self.compiler.guess_missing(missing, of.name().to_string());
    }

    fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(&key(name)).cloned()
    }
}
