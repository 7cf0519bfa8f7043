//! The commands that a client may call, and the options that it may set.

use super::folder::Folder;
use crate::commands::{build, check, run, show, test};
use anyhow::{Context, Result, bail, ensure};
use clap::{Arg, ArgAction, Args, Command};
use rmcp::model::JsonObject;
use serde_json::{Value, json};
use std::any::TypeId;

/// A command offered as a tool.
pub(super) struct Offer {
    pub name: &'static str,
    /// The description by which an agent chooses the tool.
    pub about: &'static str,
    /// Adds the command's options to a clap command.
    options: fn(Command) -> Command,
    /// The required arguments of a request.
    needed: &'static [&'static str],
    pub is_json: bool,
}

pub(super) const OFFERS: [Offer; 5] = [
    Offer {
        name: "check",
        about: "Reports the errors and warnings of a program with file, line, column and remedy, and the block that its FMU runs; or the \
                problems of FMUs. JSON",
        options: check::Options::augment_args,
        needed: &["files"],
        is_json: true,
    },
    Offer {
        name: "show",
        about: "Prints a program as plcfmu understands it, in SCL, including blocks in LAD and FBD",
        options: show::Options::augment_args,
        needed: &["files"],
        is_json: false,
    },
    Offer {
        name: "build",
        about: "Builds an FMU from a program, without a compiler; returns the path of the FMU",
        options: build::Options::augment_args,
        // Requiring `cycle` restricts the tool to programs: a crate, whose build scripts would run, is rejected.
        needed: &["files", "cycle"],
        is_json: false,
    },
    Offer {
        name: "test",
        about: "Runs the test cases of a program (a .toml, or a folder with several): returns what failed, when and where, and how many \
                statement lines were run. JSON",
        options: test::Options::augment_args,
        needed: &["file"],
        is_json: true,
    },
    Offer {
        name: "run",
        about: "Runs FMUs and a program together, with stimuli (set, signals): returns the last values, figures and events; out writes \
                a CSV with a row for each step. JSON",
        options: run::Options::augment_args,
        needed: &["files"],
        is_json: true,
    },
];

/// The options that a client may set, for each command that has them. Options that compile, load libraries or search
/// for files elsewhere are excluded.
const OFFERED: &str = "assume budget call connect constant coverage cpu cycle every fb fmi input instance junit no-events out output \
                       parallel parameter plot record save set signals start step stop stub tag";

impl Offer {
    /// The tool's arguments: the name used by a client, and the command's clap argument.
    fn takes(&self) -> Vec<(String, Arg)> {
        let name = |arg: &Arg| match arg.get_long() {
            Some(long) => OFFERED.split(' ').any(|of| of == long).then(|| long.to_string()),
            None => Some(if is_list(arg) { "files" } else { "file" }.to_string()),
        };
        let command = (self.options)(Command::new(self.name));
        command.get_arguments().filter_map(|arg| Some((name(arg)?, arg.clone()))).collect()
    }

    /// The schema of a request.
    pub(super) fn schema(&self) -> JsonObject {
        let property = |(name, arg): (String, Arg)| {
            let forms = arg.get_value_names().unwrap_or_default().join(" ");
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            let is_number =
                [TypeId::of::<f64>(), TypeId::of::<u32>()].iter().any(|of| arg.get_value_parser().type_id() == *of);
            let schema = match () {
                () if is_flag(&arg) => json!({ "type": "boolean", "description": help }),
                () if is_list(&arg) => {
                    let items = json!({ "type": "string" });
                    json!({ "type": "array", "items": items, "description": format!("{forms}: {help}") })
                }
                () if is_number => json!({ "type": "number", "description": help }),
                () => json!({ "type": "string", "description": format!("{forms}: {help}") }),
            };
            (name, schema)
        };
        let properties: JsonObject = self.takes().into_iter().map(property).collect();
        let schema = [
            ("type", json!("object")),
            ("properties", json!(properties)),
            ("required", json!(self.needed)),
            ("additionalProperties", json!(false)),
        ];
        schema.map(|(name, value)| (name.to_string(), value)).into_iter().collect()
    }

    /// The arguments of the command for a request.
    ///
    /// # Errors
    /// The request has an unknown argument or lacks a required one, or a path leads out of the folder.
    pub(super) fn arguments(&self, request: &JsonObject, folder: &Folder) -> Result<Vec<String>> {
        let takes = self.takes();
        let (mut options, mut files) = (Vec::new(), Vec::new());
        let mut needed = self.needed.to_vec();
        for (name, value) in request {
            let unknown = || {
                let names: Vec<&str> = takes.iter().map(|(name, _)| name.as_str()).collect();
                format!("{} has no argument {name:?}; available: {}", self.name, names.join(", "))
            };
            let (_, arg) = takes.iter().find(|(taken, _)| taken == name).with_context(unknown)?;
            for text in texts(value).with_context(|| format!("{name}: {value}"))? {
                folder.ensure_inside(&text)?;
                match (is_flag(arg), text.as_str()) {
                    (true, "true") => options.push(format!("--{name}")),
                    (true, "false") => {}
                    (true, _) => bail!("{name}: expected true or false, found {value}"),
                    (false, _) if arg.is_positional() => files.push(text),
                    (false, _) => options.push(format!("--{name}={text}")),
                }
                needed.retain(|of| of != name);
            }
        }
        ensure!(needed.is_empty(), "{} needs {}", self.name, needed.join(" and "));
        files.iter().try_for_each(|file| folder.ensure_descriptions_inside(file))?;
        options.extend(self.is_json.then(|| "--json".to_string()));
        // `--`, so that no file is mistaken for an option.
        Ok(options.into_iter().chain(["--".to_string()]).chain(files).collect())
    }
}

fn is_list(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append)
}

fn is_flag(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// The values of an argument in a request: one or several.
fn texts(value: &Value) -> Result<Vec<String>> {
    match value {
        Value::Null => Ok(Vec::new()),
        Value::Bool(_) | Value::Number(_) => Ok(vec![value.to_string()]),
        Value::String(text) => Ok(vec![text.clone()]),
        Value::Array(values) => Ok(values.iter().map(texts).collect::<Result<Vec<_>>>()?.concat()),
        Value::Object(_) => bail!("expected a value or a list of values"),
    }
}
