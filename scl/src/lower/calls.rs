//! Function and instance calls.

use super::Lowerer;
use super::paths::{Path, Variable};
use crate::check::compiler::{BlockId, Operand, Parameter, Slot, Symbol};
use crate::check::declare::is_copied;
use crate::check::types::{Elementary, Type, text_name};
use crate::check::undeclared::{Formal, Missing, UndeclaredStep, What as Kind};
use crate::front::lexer::Span;
use crate::front::syntax::{Argument, BlockKind, ExpressionId, ExpressionKind, Scope, SectionKind, key};
use crate::ir::{self, Call, Expr, Place, What};
use crate::ladder::Way;
use manifest::Cpu;
use parameters::problem::{nearest, with_article};

/// The maximum number of names listed in a message.
const MOST_NAMES: usize = 12;

/// The target of a call.
enum Callee {
    Function(usize),
    /// An instance: its block and its place.
    Instance(usize, Place),
    /// An undeclared name.
    Missing(Missing),
    /// An error already reported.
    Wrong,
}

impl Lowerer<'_, '_> {
    /// Lowers a call that is a statement.
    pub(crate) fn call_statement(&mut self, id: ExpressionId) {
        let expressions = self.expressions();
        let ExpressionKind::Call(callee, arguments) = &expressions[id].kind else { return };
        let span = expressions[id].span;
        if let Some(name) = self.function_name(*callee)
            && self.statement_function(&name, arguments, span)
        {
            return;
        }
        match self.callee(*callee, arguments) {
            Callee::Instance(block, place) => self.call_instance(block, place, arguments, span),
            Callee::Function(block) => {
                self.call_function(block, arguments, span);
            }
            Callee::Missing(missing) => self.call_of_missing(&missing, arguments),
            Callee::Wrong => self.arguments_of_wrong(arguments),
        }
    }

    /// Lowers a call in an expression; returns its value.
    pub(crate) fn call_value(
        &mut self,
        callee: ExpressionId,
        arguments: &[Argument],
        expected: Option<Elementary>,
        span: Span,
    ) -> Operand {
        if let Some(name) = self.function_name(callee)
            && let Some(operand) = self.function(&name, arguments, expected, span)
        {
            return operand;
        }
        match self.callee(callee, arguments) {
            Callee::Function(block) => self.value_of_function(block, arguments, span),
            Callee::Instance(block, _) => {
                let name = self.compiler.blocks[block].name.clone();
                let help = "call it as a statement and read its outputs";
                self.error(span, format!("an instance of {name} has no value"), Some(help))
            }
            Callee::Missing(missing) => {
                self.call_of_missing(&missing, arguments);
                let value = missing.part(UndeclaredStep::Value);
                self.compiler.use_missing(&value);
                Operand::Wrong(Some(value))
            }
            Callee::Wrong => {
                self.arguments_of_wrong(arguments);
                Operand::Wrong(None)
            }
        }
    }

    /// Lowers a call to a function written in SCL; returns its value.
    pub(crate) fn value_of_function(&mut self, block: usize, arguments: &[Argument], span: Span) -> Operand {
        if self.compiler.blocks[block].result == Type::Void {
            let name = self.compiler.blocks[block].name.clone();
            return self.error(span, format!("{name} has no value"), Some("call it as a statement"));
        }
        let (code, result) = self.aside(|lowerer| lowerer.call_function(block, arguments, span));
        match result {
            Some((Type::Elementary(of), place)) => {
                let value = Expr::Load(of.scalar(), place);
                Operand::Value(of, Expr::After(code, Box::new(value)))
            }
            Some((of, place)) => {
                self.code.extend(code);
                Operand::Variable(of, place)
            }
            None => Operand::Wrong(None),
        }
    }

    /// The arguments of an unknown callee, lowered only to report their errors.
    fn arguments_of_wrong(&mut self, arguments: &[Argument]) {
        for argument in arguments {
            if argument.is_output {
                self.declare_for(argument.value, &Type::Elementary(Elementary::Bool));
                self.target(argument.value);
            } else {
                self.operand(argument.value, None);
            }
        }
    }

    /// Infers the parameters of an undeclared callee from the arguments of a call.
    fn call_of_missing(&mut self, missing: &Missing, arguments: &[Argument]) {
        let mut formals = Vec::new();
        for argument in arguments {
            let name = argument.name.as_ref().map(|name| name.text.clone());
            let is_enabling = name.as_ref().is_some_and(|name| matches!(key(name).as_str(), "EN" | "ENO"));
            let actual = self.actual(argument, is_enabling);
            // A single argument may be passed without a name; it is assumed to be IN.
            let name = name.or_else(|| (arguments.len() == 1).then(|| "IN".to_string()));
            if let (Some(name), Some(of)) = (name.filter(|_| !is_enabling), actual) {
                let way = if argument.is_output { Way::Output } else { Way::Input };
                formals.push(Formal { name, way, of });
            }
        }
        self.compiler.call_missing(&missing.name, formals);
    }

    /// The parameter type that an argument implies, `Some(None)` if it is unknown. `None` for an instance or an unnamed
    /// structure, for which a stub has no parameter.
    fn actual(&mut self, argument: &Argument, is_enabling: bool) -> Option<Option<String>> {
        if argument.is_output {
            self.declare_for(argument.value, &Type::Elementary(Elementary::Bool));
            return match self.path(argument.value) {
                Path::Variable(variable) => {
                    self.use_view(&variable, true);
                    match variable.slice {
                        Some(slice) => Some(Some(slice.of.name().to_string())),
                        None => self.type_of_argument(&variable.of),
                    }
                }
                Path::Missing(missing) => {
                    self.compiler.write_missing(&missing);
                    Some(None)
                }
                _ => Some(None),
            };
        }
        let of = match self.operand(argument.value, is_enabling.then_some(Elementary::Bool)) {
            Operand::Whole(whole) if i16::try_from(whole).is_ok() => Some("INT".to_string()),
            Operand::Whole(whole) => Some(self.widest(whole).name().to_string()),
            Operand::Fraction(..) => Some("REAL".to_string()),
            Operand::Text(_, wide) => Some(text_name(wide == Some(true)).to_string()),
            Operand::Value(of, _) => Some(of.name().to_string()),
            Operand::Variable(of, _) => return self.type_of_argument(&of),
            Operand::Wrong(_) => None,
        };
        Some(of)
    }

    fn type_of_argument(&self, of: &Type) -> Option<Option<String>> {
        let written = self.compiler.written(of).filter(|_| !matches!(of, Type::Instance(_)));
        match of {
            Type::Instance(_) | Type::Structure(_) | Type::Array(_) => written.map(Some),
            _ => Some(written),
        }
    }

    /// Whether a callee denotes an instance, rather than a function or a block.
    pub(crate) fn is_instance(&self, callee: ExpressionId) -> bool {
        match &self.expressions()[callee].kind {
            ExpressionKind::Name(Scope::Global, name) => {
                let block = self.compiler.names.get(&name.key());
                block.is_none_or(|id| self.compiler.block(*id).kind == BlockKind::DataBlock)
            }
            ExpressionKind::Name(_, name) => self.symbol(&name.text).is_some(),
            ExpressionKind::Member(..) => true,
            ExpressionKind::Index(base, indices) => {
                let is_constant =
                    |index: &ExpressionId| matches!(self.expressions()[*index].kind, ExpressionKind::Literal(_));
                indices.iter().all(is_constant) && self.is_instance(*base)
            }
            _ => false,
        }
    }

    /// The name of a built-in function: a bare name not shadowed by a declaration. A variable that cannot be called,
    /// such as a parameter `limit`, does not shadow it.
    fn function_name(&self, callee: ExpressionId) -> Option<String> {
        let ExpressionKind::Name(scope, name) = &self.expressions()[callee].kind else { return None };
        let capitals = name.key();
        let is_declared = self.compiler.names.contains_key(&capitals) && self.file != self.compiler.library_file();
        let is_function = match scope {
            Scope::Bare => !matches!(
                self.symbol(&name.text),
                Some(Symbol::Variable(_, Type::Instance(_) | Type::Wrong | Type::Missing(_), _))
            ),
            // STEP 7 calls its library functions by their symbols.
            Scope::Global => crate::library::is_block(&capitals),
            Scope::Local => false,
        };
        (is_function && !is_declared).then_some(capitals)
    }

    fn callee(&mut self, id: ExpressionId, arguments: &[Argument]) -> Callee {
        let expressions = self.expressions();
        let span = expressions[id].span;
        match &expressions[id].kind {
            ExpressionKind::Name(scope, name) => {
                let is_own = *scope != Scope::Global && self.symbol(&name.text).is_some();
                // Inside a function, its name also denotes its return value.
                let declared = self.compiler.names.get(&name.key()).copied();
                if let Some(declared) = declared
                    && (!is_own || self.compiler.block(declared).kind == BlockKind::Function)
                {
                    match self.compiler.block(declared).kind {
                        BlockKind::Function => {
                            return self.compiler.interface(declared, span).map_or(Callee::Wrong, Callee::Function);
                        }
                        BlockKind::FunctionBlock => {
                            let help = "declare an instance: in VAR, or as a data block";
                            self.error(span, format!("{} is called without an instance", name.text), Some(help));
                            return Callee::Wrong;
                        }
                        BlockKind::Type | BlockKind::OrganizationBlock => {
                            self.error(span, format!("{} cannot be called", name.text), None);
                            return Callee::Wrong;
                        }
                        BlockKind::DataBlock => {}
                    }
                }
                if declared.is_none() && !is_own && self.compiler.global(&name.key()).is_none() {
                    return self.undeclared_callee(*scope, &name.text, arguments, span);
                }
                self.instance_at(id, None)
            }
            ExpressionKind::Member(base, method) => {
                // STEP 7: `FB10.DB20(...)`.
                if let ExpressionKind::Name(_, block) = &expressions[*base].kind
                    && self.symbol(&block.text).is_none()
                    && let Some(declared) = self.compiler.names.get(&block.key()).copied()
                    && self.compiler.block(declared).kind == BlockKind::FunctionBlock
                {
                    return self.of_data_block(declared, &method.text, method.span);
                }
                let capitals = method.key();
                if let ExpressionKind::Name(Scope::Bare, block) = &expressions[*base].kind
                    && self.symbol(&block.text).is_none()
                    && super::paths::is_numbered_block(&capitals)
                    && self.compiler.global(&block.key()).is_none()
                    && self.compiler.system_block(&block.key()).is_none()
                {
                    return Callee::Missing(self.compiler.miss(&block.text, block.span, Kind::Block));
                }
                if crate::library::is_method(&capitals) {
                    if let ExpressionKind::Name(Scope::Global, name) = &expressions[*base].kind
                        && self.compiler.global(&name.key()).is_none()
                        && let Some(of) = self.compiler.system_block(&capitals)
                    {
                        let global = self.compiler.implied(&name.text, of);
                        return Callee::Instance(of, global.place());
                    }
                    return self.instance_at(*base, Some(&capitals));
                }
                if matches!(&expressions[*base].kind, ExpressionKind::Name(Scope::Bare, name)
                    if self.symbol(&name.text).is_none() && self.compiler.system_block(&name.key()).is_some())
                {
                    // STEP 7: `TON.DB10(...)`.
                    let ExpressionKind::Name(_, name) = &expressions[*base].kind else { return Callee::Wrong };
                    let Some(of) = self.compiler.system_block(&name.key()) else { return Callee::Wrong };
                    if self.compiler.global(&capitals).is_none() {
                        let global = self.compiler.implied(&method.text, of);
                        return Callee::Instance(of, global.place());
                    }
                }
                self.instance_at(id, None)
            }
            ExpressionKind::Index(..) => self.instance_at(id, None),
            _ => {
                self.error(span, "this cannot be called", None);
                Callee::Wrong
            }
        }
    }

    /// The instance of the block `declared` in the data block `name`, which need not be in the sources.
    fn of_data_block(&mut self, declared: BlockId, name: &str, span: Span) -> Callee {
        let Some(block) = self.compiler.interface(declared, span) else { return Callee::Wrong };
        let global = match self.compiler.global(&key(name)) {
            Some(global) => global,
            None => self.compiler.implied(name, block),
        };
        if global.of != Type::Instance(block) {
            let of = self.compiler.blocks[block].name.clone();
            self.error(span, format!("{name} is not an instance of {of}"), None);
            return Callee::Wrong;
        }
        Callee::Instance(block, global.place())
    }

    fn instance_at(&mut self, id: ExpressionId, method: Option<&str>) -> Callee {
        let span = self.span(id);
        match self.path(id) {
            Path::Variable(Variable { of: Type::Instance(block), place, .. }) => {
                let name = crate::library::last_name(&self.compiler.trees[self.file], id).map(|(name, _)| name);
                let kind = name.and_then(|name| self.compiler.kinds.get(&name).cloned());
                let method = method.map(str::to_string).or(kind.filter(|_| method.is_none()));
                let called = match &method {
                    Some(method) => self.compiler.as_method(block, method),
                    None => Some(block),
                };
                match (called, method) {
                    (Some(called), _) => Callee::Instance(called, place),
                    (None, Some(method)) => {
                        let of = self.compiler.blocks[block].name.clone();
                        self.error(span, format!("{} cannot be called as {method}", with_article(of)), None);
                        Callee::Wrong
                    }
                    (None, None) => Callee::Wrong,
                }
            }
            Path::Variable(Variable { of: Type::Missing(name), .. }) => Callee::Missing(Missing::whole(&*name)),
            Path::Variable(variable) => {
                if variable.of != Type::Wrong {
                    self.error(span, format!("{} cannot be called", variable.of), None);
                }
                Callee::Wrong
            }
            Path::Constant(_) => {
                self.error(span, "a constant cannot be called", None);
                Callee::Wrong
            }
            Path::Missing(missing) if missing.path.is_empty() => Callee::Missing(missing),
            Path::Missing(..) | Path::Wrong => Callee::Wrong,
        }
    }

    /// The callee for an undeclared name, inferred from its use.
    fn undeclared_callee(&mut self, scope: Scope, name: &str, arguments: &[Argument], span: Span) -> Callee {
        let capitals = key(name);
        if scope == Scope::Local {
            self.error(span, format!("#{name} is not declared in this block"), None);
            return Callee::Wrong;
        }
        for kind in ["R_TRIG", "F_TRIG"] {
            if capitals.starts_with(kind)
                && capitals != kind
                && let Some(of) = self.compiler.system_block(kind)
            {
                let global = self.compiler.implied(name, of);
                return Callee::Instance(of, global.place());
            }
        }
        let formal: Vec<String> =
            arguments.iter().filter_map(|argument| argument.name.as_ref().map(|name| name.key())).collect();
        let blocks: Vec<usize> = (0..self.compiler.blocks.len())
            .filter(|block| {
                let interface = &self.compiler.blocks[*block];
                interface.kind == BlockKind::FunctionBlock
                    && self.block != Some(*block)
                    && interface.source.is_some_and(|(file, _)| file != self.compiler.library_file())
                    && formal.iter().all(|name| {
                        name == "EN"
                            || name == "ENO"
                            || interface.members.iter().any(|member| {
                                member.key == *name
                                    && !matches!(member.section, SectionKind::Static | SectionKind::Temp)
                            })
                    })
            })
            .collect();
        let named: Vec<usize> = blocks
            .iter()
            .copied()
            .filter(|block| capitals.contains(&key(&self.compiler.blocks[*block].name)))
            .collect();
        let found = match (blocks.as_slice(), named.as_slice()) {
            ([only], _) if !formal.is_empty() => Some(*only),
            (_, [only]) => Some(*only),
            _ => None,
        };
        if let Some(block) = found {
            let global = self.compiler.implied(name, block);
            let of = self.compiler.blocks[block].name.clone();
            let message = format!("no source declares \"{name}\": it is assumed to be an instance of {of}");
            self.warn(span, message, None);
            return Callee::Instance(block, global.place());
        }
        // Quoted names are the author's own blocks, such as "Fill", or instance data blocks of system blocks.
        let is_own = scope == Scope::Global && super::is_ordinary(&capitals) && !capitals.contains("_DB");
        if let Some((message, help)) = super::refused(&capitals)
            .filter(|_| !is_own && (!self.compiler.assumes || super::is_of_variants(&capitals)))
        {
            self.error(span, message, Some(&help));
            return Callee::Wrong;
        }
        // An unquoted system name is never an instance: ATTR_DB is a function.
        let is_instance = capitals.ends_with("_DB") && (scope == Scope::Global || super::refused(&capitals).is_none())
            || capitals.starts_with("DB")
            || blocks.len() > 1 && !formal.is_empty()
            || capitals.starts_with('I')
                && name.chars().nth(1).is_some_and(char::is_uppercase)
                && name.starts_with('i');
        Callee::Missing(self.compiler.miss(name, span, if is_instance { Kind::Instance } else { Kind::Function }))
    }

    fn told_by_position(&mut self, block: usize, span: Span) {
        let message = format!("the parameters of {} must be passed by name", self.compiler.blocks[block].name);
        self.error(span, message, Some("write name := value"));
    }

    /// Whether several arguments include a positional one, which is reported as an error.
    fn is_list(&mut self, block: usize, arguments: &[Argument]) -> bool {
        let position = arguments.iter().find(|argument| argument.name.is_none()).filter(|_| arguments.len() > 1);
        if let Some(argument) = position {
            self.told_by_position(block, argument.span);
        }
        position.is_some()
    }

    /// The parameter to which an argument is passed; `None` after an error, which is reported.
    fn parameter(&mut self, block: usize, argument: &Argument, arguments: usize) -> Option<Parameter> {
        let interface = &self.compiler.blocks[block];
        let is_parameter = |member: &&Parameter| {
            matches!(member.section, SectionKind::Input | SectionKind::Output | SectionKind::InOut)
        };
        let Some(name) = &argument.name else {
            let inputs: Vec<&Parameter> = interface.members.iter().filter(is_parameter).collect();
            if let ([only], 1) = (inputs.as_slice(), arguments) {
                return Some((*only).clone());
            }
            self.told_by_position(block, argument.span);
            return None;
        };
        let found = interface.members.iter().filter(is_parameter).find(|member| member.key == name.key()).cloned();
        if found.is_none() && self.is_stub(block) {
            self.tell_left_out(block, &name.text, name.span);
        } else if found.is_none() {
            let names: Vec<&str> = interface.members.iter().filter(is_parameter).map(|of| of.name.as_str()).collect();
            let help = match nearest(&name.text, names.iter().copied()) {
                Some(like) => Some(format!("it has {like}")),
                None if names.is_empty() => None,
                None if names.len() <= MOST_NAMES => Some(format!("it has {}", names.join(", "))),
                None => Some(format!("it has {} and others", names[..MOST_NAMES].join(", "))),
            };
            let message = format!("{} has no parameter {}", interface.name, name.text);
            self.error(name.span, message, help.as_deref());
        }
        let found = found?;
        let is_wrong_way = argument.name.is_some() && argument.is_output != (found.section == SectionKind::Output);
        if is_wrong_way {
            let arrow = if argument.is_output { ":=" } else { "=>" };
            self.error(argument.span, format!("{} must be passed with {arrow}", found.name), None);
            return None;
        }
        Some(found)
    }

    fn is_stub(&self, block: usize) -> bool {
        let source = self.compiler.blocks[block].source;
        source.is_some_and(|id| self.compiler.block(id).is_stub())
    }

    fn tell_left_out(&mut self, block: usize, parameter: &str, span: Span) {
        let stub = &self.compiler.blocks[block].name;
        self.warn(span, format!("{parameter} of the stub {stub} is omitted: its type is not supported"), None);
    }

    /// The EN or ENO argument of a call, unless the block declares a parameter of that name.
    fn enabling<'e>(&self, block: usize, arguments: &'e [Argument], name: &str) -> Option<&'e Argument> {
        let members = &self.compiler.blocks[block].members;
        let is_own = members.iter().any(|member| member.key == name);
        let is_it = |argument: &&Argument| argument.name.as_ref().is_some_and(|given| given.key() == name);
        arguments.iter().find(is_it).filter(|_| !is_own)
    }

    /// Lowers a call with EN and ENO: it runs only if EN is TRUE. ENO is FALSE if it did not run, otherwise the block's
    /// ENO.
    fn enabled(
        &mut self,
        block: usize,
        arguments: &[Argument],
        span: Span,
        call: impl FnOnce(&mut Self, &[Argument], Option<&Place>) -> Option<(Type, Place)>,
    ) -> Option<(Type, Place)> {
        let [en, eno] = ["EN", "ENO"].map(|name| self.enabling(block, arguments, name));
        if en.is_none() && eno.is_none() {
            return call(self, arguments, None);
        }
        let is_other = |argument: &&Argument| ![en, eno].iter().flatten().any(|other| std::ptr::eq(*other, *argument));
        let others: Vec<Argument> = arguments.iter().filter(is_other).cloned().collect();
        let condition = en.map(|en| {
            let operand = self.operand(en.value, Some(Elementary::Bool));
            self.condition(operand, self.span(en.value))
        });
        let of = Type::Elementary(Elementary::Bool);
        let told = eno.map(|_| self.temp(ir::Type::Scalar(ir::Scalar::Bool)));
        let (code, value) = self.aside(|lowerer| call(lowerer, &others, told.as_ref()));
        let no = ir::Value::from(false);
        let mut otherwise = Vec::new();
        let at = self.at(span);
        if let Some(told) = &told {
            let what = What::Assign(told.clone(), Expr::Const(no));
            otherwise.push(ir::Statement { at, what });
        }
        if let Some((Type::Elementary(of), place)) = &value {
            otherwise.push(ir::Statement { at, what: What::Assign(place.clone(), super::convert::zero(*of)) });
        }
        match condition {
            Some(condition) => self.push(span, What::If(condition, code, otherwise)),
            None => self.code.extend(code),
        }
        if let (Some(told), Some(eno)) = (told, eno) {
            self.store_output(Variable::whole(of, told), eno);
        }
        value
    }

    /// The output that copies the block's ENO to `told`; for a block without ENO, sets `told` to TRUE instead.
    fn told(&mut self, block: usize, told: Option<&Place>, span: Span) -> Option<(usize, Place)> {
        let told = told?.clone();
        match self.compiler.blocks[block].eno {
            Some(eno) => Some((eno, told)),
            None => {
                self.push(span, What::Assign(told, Expr::Const(true.into())));
                None
            }
        }
    }

    fn called(&mut self, block: usize, span: Span) {
        if let Some(caller) = self.block {
            self.compiler.calls.push((caller, block, span));
        }
    }

    fn call_instance(&mut self, block: usize, place: Place, arguments: &[Argument], span: Span) {
        self.enabled(block, arguments, span, |lowerer, arguments, eno| {
            lowerer.call_enabled_instance(block, place, arguments, eno, span);
            None
        });
    }

    fn call_enabled_instance(
        &mut self,
        block: usize,
        place: Place,
        arguments: &[Argument],
        eno: Option<&Place>,
        span: Span,
    ) {
        self.called(block, span);
        if self.is_list(block, arguments) {
            return;
        }
        let place = self.frozen(place, span);
        let mut supplied: Vec<String> = Vec::new();
        let mut in_outs = Vec::new();
        let mut references: Vec<(usize, Place)> = Vec::new();
        let mut outputs = Vec::new();
        for argument in arguments {
            let Some(parameter) = self.parameter(block, argument, arguments.len()) else {
                self.arguments_of_wrong(std::slice::from_ref(argument));
                continue;
            };
            if supplied.contains(&parameter.key) {
                self.error(argument.span, format!("{} is passed twice", parameter.name), None);
            }
            supplied.push(parameter.key.clone());
            match (parameter.section, parameter.slot) {
                (SectionKind::Input, Slot::Member(number)) => {
                    let value_span = self.span(argument.value);
                    let operand = self.operand(argument.value, parameter.of.elementary());
                    let formal = Variable::whole(parameter.of, place.clone().member(number));
                    self.assign(&formal, operand, value_span);
                }
                (SectionKind::InOut, Slot::Member(number)) => {
                    let Some(mut actual) = self.target(argument.value) else { continue };
                    actual.place = self.frozen(actual.place, span);
                    in_outs.push((Variable::whole(parameter.of, place.clone().member(number)), actual, argument.span));
                }
                (SectionKind::InOut, Slot::Local(number)) => {
                    if let Some(actual) = self.reference(block, &parameter, argument) {
                        references.push((number, actual));
                    }
                }
                (_, Slot::Member(number)) => {
                    let formal = Variable::whole(parameter.of, place.clone().member(number));
                    outputs.push((formal, argument));
                }
                _ => {}
            }
        }
        for (formal, actual, span) in &in_outs {
            let value = self.value_of(actual, *span);
            self.assign(formal, value, *span);
        }
        let function = self.compiler.blocks[block].function;
        let passed = self.passed_references(block, references, span);
        let outputs_of_call = self.told(block, eno, span).into_iter().collect();
        let call = Call { function, instance: Some(place), arguments: passed, outputs: outputs_of_call };
        self.push(span, What::Call(call));
        for (formal, actual, span) in &in_outs {
            let value = self.value_of(formal, *span);
            self.check_argument(actual, *span);
            self.assign(actual, value, *span);
        }
        for (formal, argument) in outputs {
            self.store_output(formal, argument);
        }
    }

    fn check_argument(&mut self, actual: &Variable, span: Span) {
        let counted = self.loops.iter().any(|(_, one)| one.variable.as_ref() == Some(&actual.place));
        if counted && self.compiler.cpu != Cpu::S7300 {
            self.error(span, "the loop variable must not be written inside its loop", None);
        }
    }

    fn store_output(&mut self, formal: Variable, argument: &Argument) {
        let span = argument.span;
        self.declare_for(argument.value, &formal.of);
        let value = self.value_of(&formal, span);
        match self.target(argument.value) {
            Some(target) => {
                self.check_argument(&target, span);
                self.assign(&target, value, span);
            }
            None => {
                self.guess_target(argument.value, &value);
            }
        }
    }

    /// The place passed by reference for an argument; `None` if the types differ, which is reported.
    fn reference(&mut self, block: usize, parameter: &Parameter, argument: &Argument) -> Option<Place> {
        let span = self.span(argument.value);
        let expected = || with_article(&parameter.of);
        let operand = self.operand(argument.value, None);
        let (of, place) = match operand {
            Operand::Variable(of, place) => (of, place),
            Operand::Wrong(_) => return None,
            other => {
                let found = self.type_name(&other);
                self.error(span, format!("{} is {}, not {found}", parameter.name, expected()), None);
                return None;
            }
        };
        let fits = match (&parameter.of, &of) {
            (Type::Open(formal, dimensions), Type::Array(actual)) => {
                actual.bounds.len() == *dimensions && formal.is_like(&actual.of)
            }
            (Type::Open(formal, dimensions), Type::Open(actual, others)) => {
                dimensions == others && formal.is_like(actual)
            }
            (Type::Instance(formal), Type::Instance(actual)) => {
                self.compiler.blocks[*formal].record == self.compiler.blocks[*actual].record
            }
            (formal, actual) if formal.is_wrong() || actual.is_wrong() => return None,
            (formal, actual) => formal.is_like(actual),
        };
        if !fits && self.is_stub(block) && !matches!(parameter.of, Type::Open(..)) {
            self.tell_left_out(block, &parameter.name, span);
            let ty = self.compiler.lowered(&parameter.of);
            return Some(self.temp(ty));
        }
        if !fits {
            let found = match &of {
                Type::Instance(_) => self.type_name(&Operand::Variable(of, place)),
                of => with_article(of),
            };
            self.error(span, format!("{} is {}, not {found}", parameter.name, expected()), None);
            return None;
        }
        Some(self.referred(place, &of, span))
    }

    /// A place to pass by reference: indices are evaluated once, and a constant is copied first.
    pub(super) fn referred(&mut self, place: Place, of: &Type, span: Span) -> Place {
        if place.base != ir::Base::Constants {
            return self.frozen(place, span);
        }
        let copy = self.temp(self.compiler.lowered(of));
        self.push(span, What::Copy(copy.clone(), place));
        copy
    }

    fn passed_references(&mut self, block: usize, references: Vec<(usize, Place)>, span: Span) -> Vec<ir::Argument> {
        let function = self.compiler.blocks[block].function;
        let parameters = self.compiler.program.functions[function].parameters;
        let mut passed = Vec::new();
        for number in 0..parameters {
            match references.iter().find(|(local, _)| *local == number) {
                Some((_, place)) => passed.push(ir::Argument::Reference(place.clone())),
                // A stub ignores its in-out parameters, so any variable of the right type will do.
                None if self.is_stub(block) => {
                    let ty = self.compiler.program.functions[function].locals[number].ty.clone();
                    passed.push(ir::Argument::Reference(self.temp(ty)));
                }
                None => {
                    let member =
                        self.compiler.blocks[block].members.iter().find(|member| member.slot == Slot::Local(number));
                    let name = member.map(|member| member.name.clone()).unwrap_or_default();
                    if !self.compiler.report.has_errors() {
                        let message = format!("the in-out parameter {name} is missing");
                        self.error(span, message, Some("every call must pass a structured in-out parameter"));
                    }
                    passed.push(ir::Argument::Start);
                }
            }
        }
        passed
    }

    /// Calls a function; returns the type and place of its value.
    pub(crate) fn call_function(&mut self, block: usize, arguments: &[Argument], span: Span) -> Option<(Type, Place)> {
        self.enabled(block, arguments, span, |lowerer, arguments, eno| {
            lowerer.call_enabled_function(block, arguments, eno, span)
        })
    }

    fn call_enabled_function(
        &mut self,
        block: usize,
        arguments: &[Argument],
        eno: Option<&Place>,
        span: Span,
    ) -> Option<(Type, Place)> {
        self.called(block, span);
        if self.is_list(block, arguments) {
            return None;
        }
        let members = self.compiler.blocks[block].members.clone();
        let function = self.compiler.blocks[block].function;
        let count = self.compiler.program.functions[function].parameters;
        let mut passed: Vec<Option<ir::Argument>> = vec![None; count];
        let mut copied = Vec::new();
        let mut behind: Vec<(Variable, Variable, Span)> = Vec::new();
        let mut stored = Vec::new();
        let mut supplied: Vec<String> = Vec::new();
        for argument in arguments {
            let Some(parameter) = self.parameter(block, argument, arguments.len()) else {
                self.arguments_of_wrong(std::slice::from_ref(argument));
                continue;
            };
            supplied.push(parameter.key.clone());
            let Slot::Local(number) = parameter.slot else { continue };
            if number < count && !is_copied(&parameter.of) {
                passed[number] = self.reference(block, &parameter, argument).map(ir::Argument::Reference);
                continue;
            }
            match parameter.section {
                SectionKind::Input => passed[number] = self.input(&parameter, argument),
                SectionKind::InOut => {
                    let Some(mut actual) = self.target(argument.value) else { continue };
                    actual.place = self.frozen(actual.place, argument.span);
                    self.check_argument(&actual, argument.span);
                    let value = self.value_of(&actual, argument.span);
                    passed[number] = self.by_copy(&parameter.of, value, argument.span);
                    let temp = self.temp(self.compiler.lowered(&parameter.of));
                    copied.push((number, temp.clone()));
                    behind.push((actual, Variable::whole(parameter.of, temp), argument.span));
                }
                _ => {
                    let temp = self.temp(self.compiler.lowered(&parameter.of));
                    copied.push((number, temp.clone()));
                    stored.push((Variable::whole(parameter.of, temp), argument));
                }
            }
        }
        self.check_supplied(block, &members, &supplied, span);
        let result = self.compiler.blocks[block].result.clone();
        let mut value = None;
        if result != Type::Void {
            let name = key(&self.compiler.blocks[block].name);
            let symbol = self.compiler.blocks[block].symbols.get(&name).cloned();
            if let Some(Symbol::Variable(_, of, Slot::Local(number))) = symbol {
                let temp = self.temp(self.compiler.lowered(&of));
                copied.push((number, temp.clone()));
                value = Some((of, temp));
            }
        }
        copied.extend(self.told(block, eno, span));
        let passed = passed.into_iter().map(|argument| argument.unwrap_or(ir::Argument::Start)).collect();
        self.push(span, What::Call(Call { function, instance: None, arguments: passed, outputs: copied }));
        for (actual, formal, span) in behind {
            let value = self.value_of(&formal, span);
            self.assign(&actual, value, span);
        }
        for (formal, argument) in stored {
            self.store_output(formal, argument);
        }
        value
    }

    fn check_supplied(&mut self, block: usize, members: &[Parameter], supplied: &[String], span: Span) {
        let missing: Vec<&str> = members
            .iter()
            .filter(|member| matches!(member.section, SectionKind::Input | SectionKind::InOut | SectionKind::Output))
            .filter(|member| !supplied.contains(&member.key))
            .map(|member| member.name.as_str())
            .collect();
        if !missing.is_empty() {
            let name = self.compiler.blocks[block].name.clone();
            let message = format!("{name} is called without {}", missing.join(", "));
            self.error(span, message, Some("every parameter of a function must be passed"));
        }
    }

    fn input(&mut self, parameter: &Parameter, argument: &Argument) -> Option<ir::Argument> {
        let operand = self.operand(argument.value, parameter.of.elementary());
        self.by_copy(&parameter.of, operand, self.span(argument.value))
    }

    pub(super) fn by_copy(&mut self, of: &Type, operand: Operand, span: Span) -> Option<ir::Argument> {
        match of {
            Type::Elementary(of) => Some(ir::Argument::Value(self.converted(operand, *of, span))),
            Type::Text { wide, .. } => self.text_as(operand, *wide, span).map(ir::Argument::Copy),
            _ => None,
        }
    }
}

impl Variable {
    /// A whole variable, not a slice of it.
    pub(crate) fn whole(of: Type, place: Place) -> Variable {
        Variable { of, place, slice: None, section: None, timer: None }
    }
}
