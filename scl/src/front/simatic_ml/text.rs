//! Writes variables, constants and statements as SCL fragments at the offsets of their elements in the document.

use super::Reader;
use crate::check::types::Elementary;
use crate::front::lexer::{Span, is_word};
use crate::front::syntax::key;
use parameters::problem::quoted;
use parameters::xml::Element;
use std::ops::Range;

/// The scopes of operands that need no special notation.
const SCOPES: [&str; 8] = [
    "",
    "Undef",
    "LocalVariable",
    "GlobalVariable",
    "LocalConstant",
    "GlobalConstant",
    "LiteralConstant",
    "TypedConstant",
];

/// Elements that are not written: comments, editor notes, and blanks, since the text is blank anyway.
const IDLE: [&str; 9] = [
    "Address",
    "Blank",
    "BooleanAttribute",
    "Comment",
    "DateAttribute",
    "IntegerAttribute",
    "LineComment",
    "NewLine",
    "StringAttribute",
];

/// A string as long as the document, blank except for SCL fragments, each at the offset of its element. Spans in it are
/// therefore spans in the document.
pub(super) struct Written {
    text: String,
    /// The end of the last fragment.
    end: usize,
    /// Whether a fragment did not fit since the last check.
    is_full: bool,
}

impl Written {
    /// Creates a blank text.
    pub(super) fn new(length: usize) -> Written {
        Written { text: " ".repeat(length), end: 0, is_full: false }
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// The end of the last fragment.
    pub(super) fn end(&self) -> usize {
        self.end
    }

    /// Writes a fragment at an offset, or after the last fragment if that ends later.
    pub(super) fn put(&mut self, at: usize, fragment: &str) {
        let start = at.max(self.end);
        let end = start + fragment.len();
        if end > self.text.len() {
            self.is_full = true;
            return;
        }
        self.text.replace_range(start..end, fragment);
        self.end = end;
    }

    /// The range from an offset to the end of the last fragment; empty if the fragment ends before the offset.
    pub(super) fn since(&self, from: usize) -> Range<usize> {
        from.min(self.end)..self.end
    }
}

/// A name as written in a path, in quotation marks if it needs them.
fn quoted_name(name: &str) -> String {
    let is_plain = name.chars().all(is_word) && !name.starts_with(|first: char| first.is_ascii_digit());
    if is_plain { name.to_string() } else { format!("\"{name}\"") }
}

impl Reader<'_> {
    /// Writes a separate fragment; returns its byte range.
    pub(super) fn fragment(&mut self, at: usize, fragment: &str) -> Range<usize> {
        let from = at.max(self.written.end());
        self.written.put(from, fragment);
        self.check_written(at);
        self.written.since(from)
    }

    /// Reports a fragment that did not fit. A complete document is longer than its contents in SCL, so this one is
    /// presumably truncated.
    fn check_written(&mut self, at: usize) {
        if self.written.is_full {
            self.written.is_full = false;
            let span = Span { file: self.file, start: at as u32, end: at as u32 };
            self.report.error(span, "the document ends inside this element", Some("export it again"));
        }
    }

    /// Writes a variable, constant or label as SCL; returns its byte range.
    pub(super) fn access(&mut self, access: Element) -> Range<usize> {
        let from = access.span().start.max(self.written.end());
        self.write_access(access);
        self.check_written(access.span().start);
        self.written.since(from)
    }

    fn write_access(&mut self, access: Element) {
        let at = access.span().start;
        let scope = access.attribute("Scope").unwrap_or_default();
        match scope {
            "Call" | "Expression" => return self.write_children(access),
            "PredefinedVariable" => {
                let name = access.child("PredefinedVariable").and_then(|own| own.attribute("Name"));
                return self.written.put(at, name.unwrap_or_default());
            }
            "Address" | "AbsoluteAddress" => return self.write_address(access),
            _ if !SCOPES.contains(&scope) => {
                let message = format!("an operand of scope {scope} is not supported");
                self.report.error(self.span(access), message, Some("use a variable or a constant"));
                return self.written.put(at, "0");
            }
            _ => {}
        }
        if let Some(constant) = access.child("Constant") {
            return self.write_constant(scope, constant);
        }
        match access.child("Symbol") {
            Some(symbol) => self.write_path(symbol, scope == "LocalVariable"),
            None => {
                let what = if scope.is_empty() {
                    "an operand without a scope".into()
                } else {
                    format!("an operand of scope {scope}")
                };
                let message = format!("{what} is not supported");
                self.report.error(self.span(access), message, Some("use a variable or a constant"));
                self.written.put(at, "0");
            }
        }
    }

    /// Writes an absolute address in SCL notation.
    fn write_address(&mut self, access: Element) {
        let of = |name: &str| access.child("Address").and_then(|address| address.attribute(name)).unwrap_or_default();
        let area = match of("Area") {
            "Input" | "PeripheryInput" => "I",
            "Output" | "PeripheryOutput" => "Q",
            "Memory" => "M",
            other => {
                let message = format!("an operand in the area {} is not supported", quoted(other));
                self.report.error(self.span(access), message, Some("use a variable"));
                return self.written.put(access.span().start, "0");
            }
        };
        let offset = of("BitOffset").parse::<u32>().unwrap_or(0);
        let width = match Elementary::named(&of("Type").to_uppercase()).map(Elementary::bits) {
            Some(1) => return self.written.put(access.span().start, &format!("%{area}{}.{}", offset / 8, offset % 8)),
            Some(8) => "B",
            Some(16) => "W",
            _ => "D",
        };
        self.written.put(access.span().start, &format!("%{area}{width}{}", offset / 8));
    }

    fn write_constant(&mut self, scope: &str, constant: Element) {
        let at = constant.span().start;
        if let Some(name) = constant.attribute("Name") {
            if scope == "GlobalConstant" {
                self.tree.constants.insert(key(name));
            }
            let name = if scope == "LocalConstant" { format!("#{}", quoted_name(name)) } else { format!("\"{name}\"") };
            return self.written.put(at, &name);
        }
        let of = constant.child("ConstantType").map_or("", |of| of.text().0);
        let Some(value) = constant.child("ConstantValue") else {
            let message = "a constant has no value";
            self.report.error(self.span(constant), message, Some("enter a value"));
            return self.written.put(at, "0");
        };
        let (text, range) = value.text();
        let is_text = matches!(of.to_ascii_uppercase().as_str(), "STRING" | "WSTRING" | "CHAR" | "WCHAR");
        let text = match of.to_ascii_uppercase().as_str() {
            _ if is_text && !text.contains('\'') => format!("'{text}'"),
            "BOOL" if matches!(text, "0" | "1") => format!("BOOL#{text}"),
            "REAL" | "LREAL" if text.trim_start_matches('-').bytes().all(|digit| digit.is_ascii_digit()) => {
                format!("{text}.0")
            }
            _ => text.to_string(),
        };
        self.written.put(range.start.min(value.span().start), &text);
    }

    /// Writes the path of a variable: the components of a symbol or an instance.
    pub(super) fn write_path(&mut self, parent: Element, is_local: bool) {
        let mut is_first = true;
        for component in parent.elements() {
            let at = component.span().start;
            match component.name() {
                "Component" => {}
                // In statements, slices and dots are tokens. Dots are skipped: they are written with the components.
                "Token" => {
                    let text = component.attribute("Text").unwrap_or_default();
                    if text.starts_with('%') {
                        self.written.put(at, &format!(".{}", text.to_ascii_uppercase()));
                    } else if text != "." {
                        self.refuse(component);
                    }
                    continue;
                }
                name if IDLE.contains(&name) => continue,
                _ => {
                    self.refuse(component);
                    continue;
                }
            }
            let name = component.attribute("Name").unwrap_or_default();
            let text = match (is_first, is_local) {
                (true, true) => format!("#{}", quoted_name(name)),
                (true, false) => format!("\"{name}\""),
                (false, _) => format!(".{}", quoted_name(name)),
            };
            self.written.put(at, &text);
            is_first = false;
            // TIA Portal V17 also writes indices without `AccessModifier`.
            let is_array = component.attribute("AccessModifier").is_some_and(|how| how == "Array")
                || component.children("Access").next().is_some();
            if let Some(how) = component.attribute("AccessModifier").filter(|how| how.starts_with("Reference")) {
                let message = format!("{} is accessed through a reference ({how})", quoted(name));
                self.report.error(self.span(component), message, Some("use the variable itself"));
            }
            if is_array && component.children("Token").any(|token| token.attribute("Text") == Some("[")) {
                // In statements, the brackets and their contents are tokens.
                component.elements().for_each(|child| self.write_token(child));
            } else if is_array {
                self.written.put(at, "[");
                for (number, index) in component.children("Access").enumerate() {
                    if number > 0 {
                        self.written.put(at, ",");
                    }
                    self.write_access(index);
                }
                self.written.put(at, "]");
            }
            if let Some(slice) =
                component.attribute("SliceAccessModifier").filter(|slice| !matches!(*slice, "None" | "undef"))
            {
                self.written.put(at, &format!(".%{}", slice.to_ascii_uppercase()));
            }
        }
        if is_first {
            let at = parent.elements().next().map_or(self.written.end(), |first| first.span().start);
            self.written.put(at, "0");
        }
    }

    /// Writes the instance of a timer, counter or call; returns its byte range.
    pub(super) fn instance(&mut self, instance: Element) -> Range<usize> {
        let from = instance.span().start.max(self.written.end());
        self.write_path(instance, instance.attribute("Scope") == Some("LocalVariable"));
        self.check_written(instance.span().start);
        self.written.since(from)
    }

    /// Writes statements given as tokens; returns their byte range.
    pub(super) fn structured(&mut self, root: Element) -> Range<usize> {
        let from = root.span().start.max(self.written.end());
        let (text, range) = root.text();
        if root.elements().next().is_none() && !text.is_empty() {
            self.written.put(range.start, text);
        }
        self.write_children(root);
        self.check_written(root.span().start);
        self.written.since(from)
    }

    fn write_children(&mut self, parent: Element) {
        for child in parent.elements() {
            self.write_token(child);
        }
    }

    fn write_token(&mut self, token: Element) {
        let at = token.span().start;
        match token.name() {
            "Token" => self.written.put(at, token.attribute("Text").unwrap_or_default()),
            "NewLine" => self.written.put(at, "\n"),
            "Access" => self.write_access(token),
            "CallInfo" => {
                match token.child("Instance") {
                    Some(instance) => {
                        self.write_path(instance, instance.attribute("Scope") == Some("LocalVariable"));
                    }
                    None => self.written.put(at, &format!("\"{}\"", token.attribute("Name").unwrap_or_default())),
                }
                let others = token.elements().filter(|child| child.name() != "Instance");
                let has_bracket = token.children("Token").next().is_some();
                if !has_bracket {
                    self.written.put(at, "(");
                }
                for (number, child) in others.enumerate() {
                    if !has_bracket && number > 0 {
                        self.written.put(child.span().start, ",");
                    }
                    self.write_token(child);
                }
                if !has_bracket {
                    self.written.put(at, ")");
                }
            }
            "Instruction" => {
                match token.child("Instance") {
                    Some(instance) => {
                        self.write_path(instance, instance.attribute("Scope") == Some("LocalVariable"));
                    }
                    None => self.written.put(at, token.attribute("Name").unwrap_or_default()),
                }
                token.elements().filter(|child| child.name() != "Instance").for_each(|child| self.write_token(child));
            }
            "Parameter" | "NamelessParameter" => {
                if let Some(name) = token.attribute("Name") {
                    self.written.put(at, &quoted_name(name));
                }
                self.write_children(token);
            }
            "Text" => {
                let (text, range) = token.text();
                self.written.put(range.start, text);
            }
            name if IDLE.contains(&name) => {}
            "Label" | "Symbol" | "Component" | "Constant" => self.write_children(token),
            _ => self.refuse(token),
        }
    }

    /// Reports an unknown element, since it may change what the statement does.
    fn refuse(&mut self, element: Element) {
        let name = element.attribute("Text").unwrap_or(element.name());
        let message = format!("{} is not supported in a statement", quoted(name));
        self.report.error(self.span(element), message, Some("generate a source from the block and use that instead"));
    }
}
