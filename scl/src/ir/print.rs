//! Prints typed programs as text, for comparing blocks, testing and debugging.

use super::{
    Argument, Base, Binary, Body, Call, Convert, Expr, Function, Member, Place, Program, Statement, Step, Type, What,
};
use std::fmt::{self, Write};

impl Program {
    /// A function as text: operations carry their types as suffixes, and indentation shows nesting.
    pub fn text(&self, function: usize) -> String {
        let function = &self.functions[function];
        let mut print = Print { program: self, function, text: String::new(), indent: 1 };
        // Writing to a `String` never fails.
        let _ = print.function();
        print.text
    }

    fn type_name(&self, ty: &Type) -> String {
        match ty {
            Type::Scalar(ty) => ty.to_string(),
            Type::Text { capacity, wide } => format!("{}[{capacity}]", if *wide { "wide text" } else { "text" }),
            Type::Array { of, bounds } => {
                let bounds: Vec<String> = bounds.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                format!("[{}] of {}", bounds.join(", "), self.type_name(of))
            }
            Type::Open { of, dimensions } => {
                format!("[{}] of {}", vec!["*"; *dimensions].join(", "), self.type_name(of))
            }
            Type::Record(record) => self.records[*record].name.clone(),
        }
    }
}

struct Print<'a> {
    program: &'a Program,
    function: &'a Function,
    text: String,
    indent: usize,
}

impl Print<'_> {
    fn function(&mut self) -> fmt::Result {
        let function = self.function;
        write!(self.text, "function {}", function.name)?;
        if let Some(record) = function.instance {
            write!(self.text, " on {}", self.program.records[record].name)?;
        }
        self.text.push('\n');
        for (number, local) in function.locals.iter().enumerate() {
            let kind = match (number < function.parameters, local.by_reference) {
                (true, true) => "reference",
                (true, false) => "parameter",
                (false, _) => "local",
            };
            writeln!(self.text, "  {kind} {}: {}", local.name, self.program.type_name(&local.ty))?;
        }
        match &function.body {
            Body::Code(body) => self.statements(body),
            Body::Native(name) => writeln!(self.text, "  native {name}"),
        }
    }

    fn line(&mut self, text: &str) -> fmt::Result {
        writeln!(self.text, "{:width$}{text}", "", width = 2 * self.indent)
    }

    fn block(&mut self, list: &[Statement]) -> fmt::Result {
        self.indent += 1;
        self.statements(list)?;
        self.indent -= 1;
        Ok(())
    }

    fn statements(&mut self, list: &[Statement]) -> fmt::Result {
        list.iter().try_for_each(|statement| self.statement(&statement.what))
    }

    fn statement(&mut self, what: &What) -> fmt::Result {
        match what {
            What::Assign(to, value) => self.line(&format!("{} := {}", self.place(to), self.expr(value))),
            What::Copy(to, from) => self.line(&format!("copy {} := {}", self.place(to), self.place(from))),
            What::Call(call) => self.line(&self.call(call)),
            What::If(condition, then, otherwise) => {
                self.line(&format!("if {}", self.expr(condition)))?;
                self.block(then)?;
                if !otherwise.is_empty() {
                    self.line("else")?;
                    self.block(otherwise)?;
                }
                Ok(())
            }
            What::Case(selector, arms, otherwise) => {
                self.line(&format!("case {}", self.expr(selector)))?;
                for arm in arms {
                    let values: Vec<String> = arm.values.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                    self.line(&values.join(", "))?;
                    self.block(&arm.body)?;
                }
                self.line("else")?;
                self.block(otherwise)
            }
            What::While(condition, body) => {
                self.line(&format!("while {}", self.expr(condition)))?;
                self.block(body)
            }
            What::Repeat(body, condition) => {
                self.line("repeat")?;
                self.block(body)?;
                self.line(&format!("until {}", self.expr(condition)))
            }
            What::For(it) => {
                let (first, last, step) = (self.expr(&it.first), self.expr(&it.last), self.expr(&it.step));
                self.line(&format!("for {} := {first} to {last} by {step}", self.place(&it.variable)))?;
                self.block(&it.body)
            }
            What::Break => self.line("break"),
            What::Continue => self.line("continue"),
            What::Return => self.line("return"),
            What::Label(label) => self.line(&format!("label {label}")),
            What::Goto(label) => self.line(&format!("goto {label}")),
            What::Comment(text) => self.line(&format!("// {text}")),
        }
    }

    fn call(&self, call: &Call) -> String {
        let callee = &self.program.functions[call.function];
        let mut parts: Vec<String> = call
            .arguments
            .iter()
            .zip(&callee.locals)
            .filter_map(|(argument, local)| {
                let value = match argument {
                    Argument::Value(value) => self.expr(value),
                    Argument::Copy(from) => format!("copy {}", self.place(from)),
                    Argument::Reference(to) => format!("reference {}", self.place(to)),
                    Argument::Start => return None,
                };
                Some(format!("{} := {value}", local.name))
            })
            .collect();
        parts.extend(
            call.outputs.iter().map(|(local, to)| format!("{} => {}", callee.locals[*local].name, self.place(to))),
        );
        let instance =
            call.instance.as_ref().map(|instance| format!(" on {}", self.place(instance))).unwrap_or_default();
        format!("call {}{instance}({})", callee.name, parts.join(", "))
    }

    fn place(&self, place: &Place) -> String {
        let mut text = match place.base {
            Base::Memory => "memory".to_string(),
            Base::Constants => "constants".to_string(),
            Base::Instance => "self".to_string(),
            Base::Local(local) => self.function.locals[local].name.clone(),
        };
        for (index, step) in place.steps.iter().enumerate() {
            match step {
                // A constant is identified by its bytes: its name is only a number.
                Step::Member(member) if index == 0 && place.base == Base::Constants => {
                    let constants = &self.program.records[self.program.constants];
                    let Member { offset, ty, .. } = &constants.members[*member];
                    let bytes = &constants.start[*offset..offset + self.program.size(ty)];
                    text += &bytes.iter().map(|byte| format!(" {byte:02x}")).collect::<String>();
                }
                Step::Member(member) => {
                    let before = Place { base: place.base, steps: place.steps[..index].to_vec() };
                    let name = match self.program.type_of(self.function, &before) {
                        Some(Type::Record(record)) => &*self.program.records[record].members[*member].name,
                        _ => "?",
                    };
                    text += &format!(".{name}");
                }
                Step::Index(indices, _) => {
                    let indices: Vec<String> = indices.iter().map(|index| self.expr(index)).collect();
                    text += &format!("[{}]", indices.join(", "));
                }
                Step::Length => text += ".length",
            }
        }
        text
    }

    fn expr(&self, expr: &Expr) -> String {
        let three = |parts: &[Expr; 3]| parts.each_ref().map(|part| self.expr(part)).join(", ");
        match expr {
            Expr::Const(value) => format!("{value}"),
            Expr::Load(_, place) => self.place(place),
            Expr::Unary(op, ty, a) => format!("{}.{ty}({})", format!("{op:?}").to_lowercase(), self.expr(a)),
            Expr::Binary(op, ty, a, b, _) => match symbol(*op) {
                Some(symbol) => format!("({} {symbol}.{ty} {})", self.expr(a), self.expr(b)),
                None => format!("{}.{ty}({}, {})", format!("{op:?}").to_lowercase(), self.expr(a), self.expr(b)),
            },
            Expr::Convert(Convert::Value, _, to, a, _) => format!("{to}({})", self.expr(a)),
            Expr::Convert(how, _, to, a, _) => format!("{to}.{}({})", format!("{how:?}").to_lowercase(), self.expr(a)),
            Expr::Select(ty, parts) => format!("select.{ty}({})", three(parts)),
            Expr::Limit(ty, parts) => format!("limit.{ty}({})", three(parts)),
            Expr::Texts(op, a, b) => {
                format!("({} {} {})", self.place(a), symbol(*op).unwrap_or("?"), self.place(b))
            }
            Expr::Same(a, b) => format!("same({}, {})", self.place(a), self.place(b)),
            Expr::Bound { local, dimension, upper } => {
                let bound = if *upper { "high" } else { "low" };
                format!("{bound}({}, {dimension})", self.function.locals[*local].name)
            }
            Expr::Now => "now".to_string(),
            Expr::After(before, value) => {
                let mut inner = Print { text: String::new(), indent: 0, ..*self };
                let _ = inner.statements(before);
                format!("({}; {})", inner.text.trim_end().replace('\n', "; "), self.expr(value))
            }
        }
    }
}

/// The symbol of an operation, if it has one.
fn symbol(op: Binary) -> Option<&'static str> {
    Some(match op {
        Binary::Add => "+",
        Binary::Sub => "-",
        Binary::Mul => "*",
        Binary::Div => "/",
        Binary::Rem => "%",
        Binary::And => "&",
        Binary::Or => "|",
        Binary::Xor => "^",
        Binary::Shl => "<<",
        Binary::Shr => ">>",
        Binary::Eq => "=",
        Binary::Ne => "<>",
        Binary::Lt => "<",
        Binary::Le => "<=",
        Binary::Gt => ">",
        Binary::Ge => ">=",
        Binary::Pow | Binary::Rol | Binary::Ror | Binary::Min | Binary::Max => return None,
    })
}
