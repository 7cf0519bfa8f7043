//! Generates the page's message types, `tool/web/src/messages.d.ts`, from the Rust types.

use super::{Request, each_answer};
use run::system::Value;
use std::collections::BTreeMap;
use std::{env, fs};
use ts_rs::{Config, TS, TypeVisitor};

/// The declarations collected for the file.
pub(super) struct Types {
    config: Config,
    declarations: BTreeMap<String, String>,
    answers: String,
}

impl TypeVisitor for Types {
    fn visit<T: TS + 'static + ?Sized>(&mut self) {
        let is_declared = T::output_path().is_some();
        if is_declared && !self.declarations.contains_key(&T::ident(&self.config)) {
            let declaration = format!("{}export {}\n", T::docs().unwrap_or_default(), T::decl(&self.config));
            self.declarations.insert(T::ident(&self.config), declaration);
            T::visit_dependencies(self);
        }
        T::visit_generics(self);
    }
}

impl Types {
    /// Adds a request's answer and the types that it uses.
    pub(super) fn answer<T: TS + 'static>(&mut self, request: &str) {
        // The name in JSON: SameTest becomes same_test.
        let mut name = String::new();
        for (at, letter) in request.char_indices() {
            if at > 0 && letter.is_uppercase() {
                name.push('_');
            }
            name.extend(letter.to_lowercase());
        }
        let answer = T::name(&self.config);
        self.answers +=
            &format!("  {name}: {{ request: Extract<Request, {{ do: \"{name}\" }}>; answer: {answer} }};\n");
        self.visit::<T>();
    }
}

fn types() -> String {
    let config = Config::new().with_large_int("number");
    let mut types = Types { config, declarations: BTreeMap::new(), answers: String::new() };
    types.visit::<Request>();
    each_answer(&mut types);
    let all: Vec<_> = types.declarations.into_values().collect();
    let values = format!("{{ [key in string]: {} }}", Value::ident(&types.config));
    let text = format!(
        "// Generated from tool/src/request.rs and the modules beside it by `UPDATE_EXPECT=1 cargo test -p tool typescript`.\n\n\
         /**\n * Values by the variable's name.\n */\nexport type Values = Record<string, Value>;\n\n{}\n\
         /**\n * Each request with its answer.\n */\nexport interface Dialogue {{\n{}}}\n",
        all.join("\n").replace(&values, "Values"),
        types.answers
    );
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines().map(str::trim_end) {
        // A comment of one line.
        if line == " */" && lines.len() > 1 && lines[lines.len() - 2] == "/**" {
            let comment = lines.pop().unwrap_or_default();
            lines.pop();
            lines.push(format!("/**{} */", comment.trim_start_matches(" *")));
        } else {
            lines.push(line.into());
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_types_of_the_page_are_those_of_the_engine() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/web/src/messages.d.ts");
    let types = types();
    if env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(path, &types).unwrap();
    }
    let is_current = fs::read_to_string(path).unwrap() == types;
    assert!(is_current, "{path} is not current: run UPDATE_EXPECT=1 cargo test -p tool typescript");
}
