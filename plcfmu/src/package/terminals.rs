//! The FMI 3.0 folder `terminalsAndIcons`: the model's icon, and its terminals, groups of variables wired together.
//!
//! A terminal has a member for each of its variables. The terminals of controllers and plants have the same names and
//! members, by which a tool connects them: the setpoint, the process value, the manipulated value, the pulses. A
//! program's terminals are the structures in its interface.

use crate::package::merge::Files;
use anyhow::Result;
use blocks::table::arrays::grouped;
use blocks::{Role, Types};
use draw::escape::Text;
use draw::{diagram, picture};
use modeldescription::{Names, Table};
use run::dialog;
use std::fmt::Write;

const FOLDER: &str = "terminalsAndIcons";

/// The icon of each terminal: an arrow.
const PORT: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" width="16" height="16" viewBox="0 0 16 16"><path d="M2 2L14 8L2 14Z" fill="#2b5f8a"/></svg>"##;

/// Half the width and height of the icon, in its coordinate units.
const HALF: f64 = 100.0;

/// Half the size of a terminal in these units.
const SIDE: f64 = 10.0;

/// Variables that are wired together.
#[derive(Debug, PartialEq)]
struct Terminal {
    name: String,
    /// The variables, each with its member name in the terminal.
    members: Vec<(String, String)>,
    /// Whether the first variable is an output, which puts the terminal on the right.
    is_output: bool,
}

/// All files of the folder, by path in the FMU.
///
/// # Errors
/// The diagram or the dialog in the block's documentation is faulty.
pub(super) fn files(table: &Table, types: Types, names: Names) -> Result<Files> {
    let icon = diagram::icon::svg(table)?;
    let terminals = terminals(table, types)?;
    let mut files = Files::from([
        (format!("{FOLDER}/icon.png"), picture::png(&icon)?),
        (format!("{FOLDER}/icon.svg"), icon.into_bytes()),
        (format!("{FOLDER}/terminalsAndIcons.xml"), xml(&terminals, names).into_bytes()),
    ]);
    if !terminals.is_empty() {
        files.insert(format!("{FOLDER}/port.png"), picture::png(PORT)?);
        files.insert(format!("{FOLDER}/port.svg"), PORT.as_bytes().to_vec());
    }
    Ok(files)
}

fn terminals(table: &Table, types: Types) -> Result<Vec<Terminal>> {
    let (roles, _) = dialog::read(table)?;
    let role = |name: &str| table.find(name).map(|row| table.rows[row].role);
    let mut terminals: Vec<Terminal> = Vec::new();
    let mut add = |name: &str, member: &str, variable: &str, role: Option<Role>| {
        let Some(role @ (Role::Input | Role::Output)) = role else { return };
        let member = (variable.to_string(), member.to_string());
        match terminals.iter_mut().find(|terminal| terminal.name == name) {
            Some(terminal) => terminal.members.push(member),
            None => {
                let is_output = role == Role::Output;
                terminals.push(Terminal { name: name.into(), members: vec![member], is_output });
            }
        }
    };
    let values = [("SP", &roles.setpoint), ("PV", &roles.process_value), ("LMN", &roles.manipulated_value)];
    for (name, variable) in values {
        variable.iter().for_each(|variable| add(name, name, variable, role(variable)));
    }
    for (member, variable) in ["UP", "DOWN"].iter().zip(&roles.pulses) {
        add("PULSES", member, variable, role(variable));
    }
    let rows = table.rows.iter().map(|row| (row.name.as_str(), (row.kind, row.role)));
    // An array is a single variable, if the types include arrays.
    for group in grouped(rows, types.has_arrays()) {
        // A terminal's name cannot hold the index of an array of structures.
        if let Some((structure, member)) = group.name.split_once('.').filter(|(structure, _)| !structure.contains('['))
        {
            add(structure, member, &group.name, Some(table.rows[group.rows[0]].role));
        }
    }
    Ok(terminals)
}

fn xml(terminals: &[Terminal], names: Names) -> String {
    let mut xml =
        String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n");
    let square = format!(r#"x1="-{HALF}" y1="-{HALF}" x2="{HALF}" y2="{HALF}""#);
    let _ = write!(
        xml,
        "  <GraphicalRepresentation>\n    <CoordinateSystem {square} suggestedScalingFactorTo_mm=\"0.1\"/>\n    <Icon {square}/>\n  \
         </GraphicalRepresentation>\n"
    );
    if !terminals.is_empty() {
        xml.push_str("  <Terminals>\n");
    }
    for terminal in terminals {
        let _ = writeln!(xml, "    <Terminal name=\"{}\" matchingRule=\"bus\">", Text(&terminal.name));
        for (variable, member) in &terminal.members {
            let _ = writeln!(
                xml,
                "      <TerminalMemberVariable variableName=\"{}\" memberName=\"{}\" variableKind=\"signal\"/>",
                Text(&names.convert(variable)),
                Text(member)
            );
        }
        let (x, y) = place(terminal, terminals);
        let _ = writeln!(
            xml,
            "      <TerminalGraphicalRepresentation x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" iconBaseName=\"port\"/>\n    </Terminal>",
            x - SIDE,
            y - SIDE,
            x + SIDE,
            y + SIDE
        );
    }
    if !terminals.is_empty() {
        xml.push_str("  </Terminals>\n");
    }
    xml.push_str("</fmiTerminalsAndIcons>\n");
    xml
}

/// The centre of a terminal on the icon, in its coordinate units. Terminals that begin with an input are on the left,
/// the others on the right, from top to bottom.
fn place(terminal: &Terminal, all: &[Terminal]) -> (f64, f64) {
    let side = || all.iter().filter(|other| other.is_output == terminal.is_output);
    let number = side().position(|other| other == terminal).unwrap_or_default() as f64;
    let x = if terminal.is_output { HALF } else { -HALF };
    (x, HALF - 2.0 * HALF * (number + 1.0) / (side().count() as f64 + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use modeldescription::Interface;

    fn table(docs: &str, rows: &[(&str, &str)]) -> Table {
        let row = |(name, role): &(&str, &str)| {
            format!(
                r#"{{"name":"{name}","description":"","kind":"REAL","role":"{role}","start":0.0,"min":null,"max":null,"unit":null}}"#
            )
        };
        let rows: Vec<String> = rows.iter().map(row).collect();
        let json = format!(
            r#"{{"table":{{"name":"X","docs":"{docs}","cycle":0,"variables":[
            {{"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null}},{}],
            "responses":[{{"title":"x","calls":3,"set":[],"show":[]}}]}},
            "interface":{{"version":"2.0","guid":"{{1}}","capabilities":{{}},"log_categories":[]}}}}"#,
            rows.join(",")
        );
        Interface::parse(&json).unwrap().table
    }

    /// A terminal's name, its variables with their members, and whether it is an output.
    type Shown<'a> = (&'a str, Vec<(&'a str, &'a str)>, bool);

    fn names(terminals: &[Terminal]) -> Vec<Shown<'_>> {
        terminals
            .iter()
            .map(|of| {
                let members =
                    of.members.iter().map(|(variable, member)| (variable.as_str(), member.as_str())).collect();
                (of.name.as_str(), members, of.is_output)
            })
            .collect()
    }

    #[test]
    fn a_controller_and_a_plant_have_the_same_terminals() {
        let controller = table(
            "Controls.\\n\\n```dialog\\nsetpoint: SP\\nprocess value: PV_IN, PV_IN\\nmanipulated value: OUT\\n\\n[All]\\nSP, PV_IN, CYCLE\\n```\\n",
            &[("SP", "input"), ("PV_IN", "input"), ("OUT", "output")],
        );
        let expected = [
            ("SP", vec![("SP", "SP")], false),
            ("PV", vec![("PV_IN", "PV")], false),
            ("LMN", vec![("OUT", "LMN")], true),
        ];
        assert_eq!(names(&terminals(&controller, Types::Native).unwrap()), expected);
        let xml = xml(&terminals(&controller, Types::Native).unwrap(), Names::Structured);
        // Two on the left, a third and two thirds from the top; one on the right, in the middle.
        assert!(
            xml.contains(r#"<TerminalGraphicalRepresentation x1="90" y1="-10" x2="110" y2="10" iconBaseName="port"/>"#),
            "{xml}"
        );
        assert!(xml.contains(r#"x1="-110" y1="23.3333"#), "{xml}");
    }

    #[test]
    fn a_structure_in_the_interface_of_a_program_is_a_terminal() {
        let rows = [
            ("in.a", "input"),
            ("in.b.c", "input"),
            ("in.v[0]", "input"),
            ("in.v[1]", "input"),
            ("in.limit", "parameter"),
            ("p[1].q", "input"),
            ("x", "output"),
        ];
        let program = table("Runs.", &rows);
        assert_eq!(
            names(&terminals(&program, Types::Native).unwrap()),
            [("in", vec![("in.a", "a"), ("in.b.c", "b.c"), ("in.v", "v")], false)]
        );
        assert!(xml(&[], Names::Structured).ends_with("</GraphicalRepresentation>\n</fmiTerminalsAndIcons>\n"));
    }
}
