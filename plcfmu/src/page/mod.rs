//! `documentation/index.html`: all that a user of the FMU has to know, in one file.

pub mod diagram;
pub mod picture;
pub mod plot;
pub mod svg;
pub mod text;

use crate::package::reference::{self, Recording};
use modeldescription::Interface;
use modeldescription::interface::{Role, Row};
use pulldown_cmark::{Options, Parser, html};
use std::fmt::Write;
use svg::escape;

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, 'Segoe UI', Helvetica, Arial, sans-serif; color: #1f2937; background: #fff;
       max-width: 66rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { margin-bottom: 0; color: #1f3a5f; }
h2 { margin-top: 2.4rem; padding-bottom: .2rem; border-bottom: 1px solid #d1d5db; color: #1f3a5f; }
.summary { font-size: 1.15rem; margin-top: .4rem; }
figure { margin: 1.5rem 0; overflow-x: auto; }
figcaption { color: #4b5563; }
svg { max-width: 100%; height: auto; }
pre { background: #f4f7fb; border: 1px solid #e5e7eb; border-radius: 4px; padding: .8rem 1rem; overflow-x: auto;
      line-height: 1.35; }
pre code { font-size: .8rem; }
code, pre, td.name, td.number { font-family: ui-monospace, 'DejaVu Sans Mono', Consolas, monospace; font-size: .87rem; }
dt { font-weight: 600; float: left; clear: left; width: 12rem; }
dd { margin: 0 0 .3rem 12.5rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .93rem; }
th, td { text-align: left; vertical-align: top; padding: .25rem .7rem .25rem 0; border-bottom: 1px solid #e5e7eb; }
td.number { white-space: nowrap; text-align: right; padding-left: .4rem; }
td.name { white-space: nowrap; }
th.number { text-align: right; }
table { width: 100%; }
th.group { padding-top: 1.1rem; color: #1f3a5f; }
@media print { body { margin: 0; max-width: none; } }
";

/// The page. `license` is that of the block's package, as its `Cargo.toml` has it.
pub fn html(interface: &Interface, recording: &Recording, license: Option<&str>) -> String {
    let name = escape(&interface.name);
    let summary = escape(&interface.summary());
    let [input, output] =
        reference::links(&interface.name).map(|(link, text)| format!(r#"<a href="{}">{text}</a>"#, escape(&link)));
    format!(
        r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}</title>
<style>{STYLE}</style>
</head>
<body>
<h1>{name}</h1>
<p class="summary">{summary}</p>
<figure>
{diagram}<figcaption>Terminals: signals with their type, settings with their start value. Thin wires are Booleans.{nested}</figcaption>
</figure>
<h2>Use</h2>
{usage}
<h2>Law</h2>
{law}{sources}
<h2>Response</h2>
<figure>
{plot}<figcaption>{title}. One call every {cycle} s; dashed lines are inputs. Recorded from the library of this FMU: {input}, {output}.</figcaption>
</figure>
<h2>Variables</h2>
<div class="wide">
{variables}</div>
<p>Start values are what a block has that nobody has set. Ranges are what makes sense; unless the law says otherwise, the
block computes with what it gets.</p>
<h2>Licence</h2>
<p>The block: {license}. What every FMU of this kind shares: MIT or Apache 2.0, at your choice
(<a href="licenses/LICENSE-MIT">LICENSE-MIT</a>, <a href="licenses/LICENSE-APACHE">LICENSE-APACHE</a>). What else is in the
library: <a href="licenses/NOTICE">NOTICE</a>.</p>
</body>
</html>
"#,
        license = escape(license.unwrap_or("its package names no licence")),
        diagram = diagram::svg(interface),
        nested = nested(interface),
        usage = usage(interface),
        law = law(interface),
        sources = sources(interface),
        plot = plot::svg(interface, recording),
        title = escape(interface.response.title.trim_end_matches('.')),
        cycle = recording.time(1),
        variables = variables(interface),
    )
}

/// A sentence on the variables that the diagram leaves out.
fn nested(interface: &Interface) -> String {
    match interface.variables.iter().filter(|row| row.name.contains('.')).count() {
        0 => String::new(),
        count => format!(" The {count} variables of the blocks inside are in the table below."),
    }
}

/// What every FMU of this kind promises, in a few lines.
fn usage(interface: &Interface) -> String {
    let cycle = &interface.variables[interface.cycle];
    let (cycle_name, start) = (escape(&cycle.name), escape(&text::value(cycle, cycle.start)));
    let mean = interface.mean.map_or(String::new(), |mean| {
        format!(
            "\n<dt>Pulses</dt><dd>A pulse output shows the state of the last call. Where a communication step holds more \
             than one, <code>{}</code> is the mean over the step in percent.</dd>",
            escape(&interface.variables[mean].name)
        )
    });
    format!(
        r#"<dl>
<dt>Kind</dt><dd>FMI 2.0, co-simulation</dd>
<dt>GUID</dt><dd><code>{guid}</code></dd>
<dt>When it is called</dt><dd>At the start time and then every <code>{cycle_name}</code> (start value {start}), as by the
cyclic interrupt of a PLC, whatever the communication step is: a step that holds several calls makes them all, one that
holds none makes none. The calls are counted in whole milliseconds and do not drift.</dd>
<dt>What a step does</dt><dd>Every call from the start of the step up to, but not at, its end sees the inputs as set at the
start (extrapolated to the call if the host gives derivatives of them); the outputs are those of the last call. No output
depends on an input of the same instant.</dd>
<dt>Restart</dt><dd>Once, when the initialization ends (OB 100 of a PLC). From then until the first call the outputs have
their restart values; before it they read 0.</dd>
<dt>Numbers</dt><dd>REAL is a 32-bit floating point number, rounded when it is set, LREAL one of 64 bits; TIME is in
seconds, rounded to a millisecond; WORD and INT are integers of 16 bits.</dd>{mean}
<dt>Also</dt><dd>The state can be saved, restored and serialized; any number of instances, on any threads.</dd>
</dl>"#,
        guid = escape(&interface.guid),
    )
}

/// The block's documentation after its first paragraph, which stands at the top of the page.
fn law(interface: &Interface) -> String {
    let docs = interface.docs.trim_start();
    let rest = docs.split_once("\n\n").map_or("", |(_, rest)| rest);
    let mut law = String::new();
    html::push_html(&mut law, Parser::new_ext(rest, Options::ENABLE_TABLES));
    law
}

/// What the words behind the clauses of a law mean, if there are such.
fn sources(interface: &Interface) -> &'static str {
    let words = ["(manual", "(vendor", "(measured", "(observed", "(decided"];
    if !words.iter().any(|word| interface.docs.contains(word)) {
        return "";
    }
    "<p>In brackets stands where a rule comes from. <em>manual</em>: the vendor's published manual; <em>vendor</em>: later \
     texts of the vendor on the same blocks or their sisters; <em>measured</em>: recorded at the terminals of a real block; \
     <em>observed</em>: published descriptions of how the blocks behave; <em>decided</em>: by us, where all of these are \
     silent.</p>"
}

fn variables(interface: &Interface) -> String {
    let mut table = String::from(
        "<table>\n<thead><tr><th>Name</th><th>Type</th><th>Unit</th><th class=\"number\">Range</th>\
         <th class=\"number\">Start</th><th>Meaning</th><th class=\"number\">Reference</th></tr></thead>\n",
    );
    let groups: [(&str, &[Role]); 5] = [
        ("Inputs", &[Role::Input]),
        ("Outputs", &[Role::Output]),
        ("Settings: tunable while it runs", &[Role::Parameter]),
        ("Settings: fixed once it runs", &[Role::Fixed, Role::Cycle]),
        ("Signals inside: read only", &[Role::Local]),
    ];
    for (title, roles) in groups {
        let rows = interface.variables.iter().enumerate();
        let rows: Vec<(usize, &Row)> = rows.filter(|(_, row)| roles.contains(&row.role)).collect();
        if rows.is_empty() {
            continue;
        }
        let _ = writeln!(table, "<tbody>\n<tr><th class=\"group\" colspan=\"7\">{title}</th></tr>");
        for (reference, row) in rows {
            variable(&mut table, reference, row);
        }
        table.push_str("</tbody>\n");
    }
    table.push_str("</table>\n");
    table
}

fn variable(table: &mut String, reference: usize, row: &Row) {
    let is_set = !matches!(row.role, Role::Output | Role::Local);
    let start = if is_set { text::number(row.kind, row.start) } else { String::new() };
    let _ = writeln!(
        table,
        r#"<tr><td class="name">{name}</td><td>{kind}</td><td>{unit}</td><td class="number">{range}</td><td class="number">{start}</td><td>{description}</td><td class="number">{reference}</td></tr>"#,
        name = escape(&row.name),
        kind = row.kind.name(),
        unit = escape(text::unit(row).unwrap_or_default()),
        range = escape(&text::range(row)),
        description = escape(&row.description),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interface() -> Interface {
        let row = |name: &str, kind: &str, role: &str, rest: &str| {
            format!(
                r#"{{"name":"{name}","description":"About {name} & <more>","kind":"{kind}","role":"{role}",{rest}}}"#
            )
        };
        let plain = r#""start":0.0,"min":null,"max":null,"unit":null"#;
        let rows = [
            row("FLOW", "LReal", "Input", r#""start":1.5,"min":0.0,"max":9.0,"unit":"l/min""#),
            row("CYCLE", "Time", "Cycle", r#""start":0.1,"min":0.001,"max":null,"unit":null"#),
            row("DI_A.GAIN", "Real", "Parameter", r#""start":2.0,"min":null,"max":null,"unit":null"#),
            row("ON", "Bool", "Output", plain),
            row("DUTY", "LReal", "Output", r#""start":0.0,"min":null,"max":null,"unit":"%""#),
            row("DI_A.LMN", "Real", "Local", plain),
        ];
        let docs = r"Pumps & more.\n\nThe *law*:\n\n| a | b |\n|---|---|\n| 1 | 2 |";
        let json = format!(
            r#"{{"name":"PUMP","docs":"{docs}","guid":"{{1}}","cycle":1,"mean":4,"variables":[{}],
            "response":{{"title":"It runs.","calls":2,"set":[],"show":["FLOW","ON"]}}}}"#,
            rows.join(",")
        );
        Interface::parse(&json).unwrap()
    }

    fn page() -> String {
        let recording = Recording {
            cycle: 100,
            shown: vec![0, 3],
            restart: vec![0.0, 0.0],
            calls: vec![vec![1.0, 0.0], vec![2.0, 1.0]],
        };
        html(&interface(), &recording, Some("LicenseRef-<House>"))
    }

    #[test]
    fn every_variable_is_on_the_page_with_all_that_is_known_of_it() {
        let page = page();
        assert!(page.contains(
            r#"<td class="name">FLOW</td><td>LREAL</td><td>l/min</td><td class="number">0 ... 9</td><td class="number">1.5</td><td>About FLOW &amp; &lt;more&gt;</td><td class="number">0</td>"#
        ));
        assert!(page.contains(
            r#"<td class="name">CYCLE</td><td>TIME</td><td>s</td><td class="number">≥ 0.001</td><td class="number">0.1</td>"#
        ));
        for row in &interface().variables {
            assert!(page.contains(&format!(r#"<td class="name">{}</td>"#, row.name)), "{}", row.name);
        }
    }

    #[test]
    fn the_page_has_the_law_both_drawings_and_the_time_rule() {
        let page = page();
        assert!(page.contains("<p class=\"summary\">Pumps &amp; more.</p>"));
        assert!(page.contains("The <em>law</em>:") && page.contains("<td>1</td><td>2</td>"));
        assert!(page.contains("aria-label=\"Terminals of PUMP\"") && page.contains("aria-label=\"Response of PUMP\""));
        assert!(page.contains("<code>CYCLE</code> (start value 0.1 s)"));
        assert!(page.contains("<code>DUTY</code> is the mean"));
        assert!(page.contains("The 2 variables of the blocks inside"));
    }

    #[test]
    fn the_page_names_the_licence_of_the_block_and_that_of_the_rest() {
        let page = page();
        assert!(
            page.contains("The block: LicenseRef-&lt;House&gt;. What every FMU of this kind shares: MIT or Apache 2.0")
        );
    }

    #[test]
    fn the_page_stands_alone() {
        let page = page();
        // But for names of XML's own.
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("http"));
        assert!(!page.contains("<script") && !page.contains("<link"));
    }

    #[test]
    fn the_drawing_of_the_terminals_leaves_out_what_is_inside() {
        let drawing = diagram::svg(&interface());
        assert!(
            drawing.contains(">FLOW</text>") && drawing.contains(">ON</text>") && drawing.contains(">CYCLE</text>")
        );
        assert!(!drawing.contains("DI_A"));
        assert!(drawing.contains("LREAL l/min"));
    }
}
