//! `documentation/index.html`: a single-file guide for users of the FMU.

mod markdown;

use crate::package::reference::{self, Recordings};
use anyhow::Context;
use askama::Template;
use blocks::{Characteristic, Kind, Response, Role, Text};
use draw::response::{self, Colors, Recording, Sweep};
use draw::{diagram, plot, text};
use markdown::Sections;
use modeldescription::{Description, Row, Table, v3};

/// The data for the template. `askama` checks templates at compile time, so rendering cannot fail on a user's machine.
#[derive(Template)]
#[template(path = "index.html")]
struct Page<'a> {
    name: &'a str,
    summary: String,
    /// The FMI version, the standard's name for the string by which a host identifies the FMU, and that string.
    version: &'a str,
    identifier: &'static str,
    guid: &'a str,
    /// The block diagram or the drawing of the terminals, as SVG.
    diagram: String,
    /// Whether `diagram` is a block diagram.
    has_diagram: bool,
    has_boolean_terminals: bool,
    /// Whether the block has WORD variables; likewise for INT, REAL and LREAL below. The page explains only these types.
    has_words: bool,
    has_integers: bool,
    has_singles: bool,
    has_doubles: bool,
    /// The number of variables of inner blocks, which the diagram omits.
    nested: usize,
    cycle_name: &'a str,
    cycle_start: String,
    /// The variable that holds the mean of the block's pulses.
    mean: Option<&'a str>,
    /// Sections of the block's documentation as HTML, under their titles on the page.
    before_use: Vec<Section>,
    about_diagram: String,
    sampling: String,
    law: Vec<Section>,
    after_responses: Vec<Section>,
    /// The origins of rules cited in the block's documentation: the word used there, and the explanation.
    origins: Vec<(&'static str, &'static str)>,
    responses: Vec<Drawing>,
    /// Whether any response shows inputs, which are drawn as dashed lines.
    has_dashed_lines: bool,
    /// Seconds between two calls of the first response.
    response_cycle: f64,
    characteristics: Vec<Drawing>,
    /// Links and labels of the files with the recorded responses.
    recordings: [(String, &'static str); 2],
    groups: Vec<Group<'a>>,
    license: &'a str,
    /// The name of the FMU's C file, if it has one.
    source: Option<&'a str>,
    /// The comments before and after each of the three parts of the page that a preset replaces.
    preset_place: (&'a str, &'a str),
    recording_place: (&'a str, &'a str),
    source_place: (&'a str, &'a str),
}

/// A section of the documentation.
struct Section {
    /// The id of its heading, to which the contents link.
    id: String,
    title: String,
    /// The text as HTML.
    text: String,
}

/// A response or a characteristic.
struct Drawing {
    title: String,
    /// The plot as SVG.
    plot: String,
    has_dashed_lines: bool,
    /// Seconds between two calls, if different from the first response.
    cycle: Option<f64>,
}

/// Variables with the same use.
struct Group<'a> {
    title: &'static str,
    variables: Vec<Variable<'a>>,
}

/// A row of the table of variables.
struct Variable<'a> {
    name: &'a str,
    kind: String,
    unit: String,
    /// The recommended range; empty if the variable declares none.
    range: String,
    start: String,
    description: String,
    /// HTML; empty if there is no help text.
    help: String,
    reference: usize,
}

/// Renders the page. `license` is the licence of the block's package, as given in its `Cargo.toml`; `source` is the
/// name of the FMU's C file, if it has one.
///
/// # Errors
/// A drawing, a formula or the page cannot be rendered.
pub fn html(
    table: &Table,
    description: &Description,
    recordings: &Recordings,
    license: Option<&str>,
    source: Option<&str>,
) -> anyhow::Result<String> {
    let rows = &table.rows;
    let cycle = &rows[table.cycle];
    let terminals =
        diagram::terminals_of(table, &[Role::Input, Role::Parameter, Role::Fixed, Role::Cycle, Role::Output]);
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    let docs = table.docs.trim_start().split_once("\n\n").map_or("", |(_, rest)| rest);
    let mut sections = Sections::new(docs);
    let mut take = |titles: &[(&str, &str)]| -> anyhow::Result<Vec<Section>> {
        let taken = titles.iter().filter_map(|(heading, title)| Some((*title, sections.take(heading)?)));
        taken.map(|(title, text)| section(title, text, &names)).collect()
    };
    let before_use = take(&[("Purpose", "Purpose"), ("Quick start", "Quick start")])?;
    let mut text =
        |heading| anyhow::Ok(take(&[(heading, heading)])?.pop().map_or(String::new(), |section| section.text));
    // The text next to the diagram.
    let (about_diagram, sampling) = (text("Diagram")?, text("Sampling")?);
    // Documentation without a heading describes the algorithm.
    let law = take(&[("Algorithm", "Algorithm"), ("", "Algorithm"), ("Clauses", "Clauses")])?;
    let mut after_responses = take(&[("Limits of use", "Limits of use"), ("Sources", "Sources")])?;
    let colors = crate::colors::assign(table)?;
    sections.take("Dialog");
    for (title, text) in sections.take_all() {
        after_responses.push(section(title, text, &names)?);
    }
    let response_cycle = recordings.responses.first().map_or(0.0, |first| first.time(1));
    let responses: Vec<Drawing> = table
        .responses
        .iter()
        .zip(&recordings.responses)
        .map(|(response, recording)| drawing(table, response, recording, response_cycle, &colors))
        .collect::<anyhow::Result<_>>()?;
    let page = Page {
        name: &table.name,
        response_cycle,
        summary: table.summary(),
        version: description.fmi_version,
        identifier: if description.fmi_version == v3::FMI_VERSION { "Instantiation token" } else { "GUID" },
        guid: &description.guid,
        diagram: diagram::linked(table).context("the diagram of the block")?,
        has_diagram: diagram::find(&table.docs).is_some(),
        has_boolean_terminals: terminals.iter().any(|row| row.kind == Kind::Bool),
        has_words: rows.iter().any(|row| row.kind == Kind::Word),
        has_integers: rows.iter().any(|row| row.kind == Kind::Int),
        has_singles: rows.iter().any(|row| row.kind == Kind::Real),
        has_doubles: rows.iter().any(|row| row.kind == Kind::LReal),
        nested: rows.iter().filter(|row| row.name.contains('.')).count(),
        cycle_name: &cycle.name,
        cycle_start: text::value(cycle, cycle.start()),
        mean: table.mean.map(|mean| rows[mean].name.as_str()),
        before_use,
        about_diagram,
        sampling,
        law,
        after_responses,
        origins: origins(table),
        has_dashed_lines: responses.iter().any(|response| response.has_dashed_lines),
        responses,
        characteristics: table
            .characteristics
            .iter()
            .zip(&recordings.characteristics)
            .map(|(characteristic, sweep)| characteristic_drawing(table, characteristic, sweep, &colors))
            .collect::<anyhow::Result<_>>()?,
        recordings: reference::links(&table.name),
        groups: groups(table)?,
        license: license.unwrap_or("its package specifies no licence"),
        source,
        preset_place: tool::preset::page::PRESET,
        recording_place: tool::preset::page::RECORDING,
        source_place: tool::preset::page::SOURCE,
    };
    page.render().context("the documentation page")
}

/// The help text of a variable as HTML, in which the names of other variables are links.
///
/// # Errors
/// A formula cannot be rendered.
pub fn help(table: &Table, row: &Row) -> anyhow::Result<String> {
    if row.help.is_empty() {
        return Ok(String::new());
    }
    // A variable does not link to itself.
    let others: Vec<&str> = table.rows.iter().map(|of| of.name.as_str()).filter(|name| *name != row.name).collect();
    markdown::html(&row.help, &others).with_context(|| format!("the help of {}", row.name))
}

/// The sections of a block's documentation with these titles, as HTML.
///
/// # Errors
/// A formula cannot be rendered.
pub fn sections(table: &Table, titles: &[&str]) -> anyhow::Result<String> {
    let names: Vec<&str> = table.rows.iter().map(|row| row.name.as_str()).collect();
    let mut sections = Sections::new(&table.docs);
    let mut html = String::new();
    for title in titles {
        if let Some(text) = sections.take(title) {
            let Section { title, text, .. } = section(title, text, &names)?;
            html.push_str(&format!("<h3>{title}</h3>\n{text}"));
        }
    }
    Ok(html)
}

fn section(title: &str, text: &str, names: &[&str]) -> anyhow::Result<Section> {
    let text = markdown::html(text, names).with_context(|| format!("the section {title:?} of the documentation"))?;
    Ok(Section { id: title.to_lowercase().replace(' ', "-"), title: title.to_string(), text })
}

fn drawing(
    table: &Table,
    response: &Response<String>,
    recording: &Recording,
    usual: f64,
    colors: &Colors,
) -> anyhow::Result<Drawing> {
    let chart = response::of_recording(table, recording, colors);
    let title = response.title.trim_end_matches('.');
    let curves = chart.panels.iter().flat_map(|panel| &panel.curves).chain(&chart.lanes);
    Ok(Drawing {
        title: markdown::shown(title),
        has_dashed_lines: curves.into_iter().any(|curve| curve.is_input),
        plot: plot::svg_named(&chart, title).context("the plot of a response")?,
        cycle: Some(recording.time(1)).filter(|cycle| *cycle != usual),
    })
}

fn characteristic_drawing(
    table: &Table,
    characteristic: &Characteristic<String>,
    sweep: &Sweep,
    colors: &Colors,
) -> anyhow::Result<Drawing> {
    let chart = response::of_sweep(table, characteristic, sweep, colors);
    let title = characteristic.title.trim_end_matches('.');
    Ok(Drawing {
        title: markdown::shown(title),
        has_dashed_lines: false,
        plot: plot::svg_named(&chart, title).context("the plot of a characteristic")?,
        cycle: None,
    })
}

/// The origins of rules cited in the block's documentation: the word used there, and the explanation.
fn origins(table: &Table) -> Vec<(&'static str, &'static str)> {
    let is_named = |word: &str| table.docs.contains(&format!("({word}")) || table.docs.contains(&format!(", {word})"));
    laws::ORIGINS.into_iter().filter(|(word, _)| is_named(word)).collect()
}

/// The variables grouped by use; unused groups are omitted.
fn groups<'a>(table: &'a Table) -> anyhow::Result<Vec<Group<'a>>> {
    let titles: [(&str, &[Role]); 5] = [
        ("Inputs", &[Role::Input]),
        ("Outputs", &[Role::Output]),
        ("Settings: tunable at run time", &[Role::Parameter]),
        ("Settings: fixed at run time", &[Role::Fixed, Role::Cycle]),
        ("Internal signals: read-only", &[Role::Local]),
    ];
    let mut groups = Vec::new();
    for (title, roles) in titles {
        let rows = table.rows.iter().enumerate().filter(|(_, row)| roles.contains(&row.role));
        let mut variables =
            rows.map(|(reference, row)| variable(table, reference, row)).collect::<anyhow::Result<Vec<_>>>()?;
        let texts = (table.rows.len()..).zip(&table.texts).filter(|(_, text)| roles.contains(&text.role));
        variables.extend(texts.map(|(reference, text)| text_variable(reference, text)));
        if !variables.is_empty() {
            groups.push(Group { title, variables });
        }
    }
    Ok(groups)
}

fn text_variable(reference: usize, text: &Text) -> Variable<'_> {
    Variable {
        name: &text.name,
        kind: text.ty.name(),
        unit: String::new(),
        range: String::new(),
        start: if text.role.is_settable() { format!("'{}'", text.start) } else { String::new() },
        description: markdown::shown(&text.description),
        help: String::new(),
        reference,
    }
}

fn variable<'a>(table: &Table, reference: usize, row: &'a Row) -> anyhow::Result<Variable<'a>> {
    let is_set = !matches!(row.role, Role::Output | Role::Local);
    let (range, description) = match text::range_in_words(row) {
        Some((description, range)) => (range.replace(">=", "≥"), description),
        None => (text::range(row), row.description.as_str()),
    };
    Ok(Variable {
        name: &row.name,
        kind: row.kind.name().into(),
        unit: markdown::shown(row.shown_unit().unwrap_or_default()),
        range,
        start: if is_set { text::number(row.kind, row.start()) } else { String::new() },
        description: markdown::shown(description),
        // Variables of an inner block are explained in that block's own documentation.
        help: if row.name.contains('.') { String::new() } else { help(table, row)? },
        reference,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use modeldescription::v2;

    fn table() -> Table {
        let row = |name: &str, kind: &str, role: &str, rest: &str| {
            format!(
                r#"{{"name":"{name}","description":"About {name} & <more>","kind":"{kind}","role":"{role}",{rest}}}"#
            )
        };
        let plain = r#""start":0.0,"min":null,"max":null,"unit":null"#;
        let rows = [
            row("FLOW", "LREAL", "input", r#""start":1.5,"min":0.0,"max":9.0,"unit":"l/min""#),
            row("CYCLE", "TIME", "cycle", r#""start":0.1,"min":0.001,"max":null,"unit":null"#),
            row("DI_A.GAIN", "REAL", "parameter", r#""start":2.0,"min":null,"max":null,"unit":null"#),
            row("ON", "BOOL", "output", plain),
            row("DUTY", "LREAL", "output", r#""start":0.0,"min":null,"max":null,"unit":"%""#),
            row("DI_A.LMN", "REAL", "local", plain),
        ];
        let docs = r"Pumps & more.\n\nThe *law*:\n\n| a | b |\n|---|---|\n| 1 | 2 |";
        let json = format!(
            r#"{{"name":"PUMP","docs":"{docs}","cycle":1,"mean":4,"variables":[{}],
            "responses":[{{"title":"It runs.","calls":2,"set":[],"show":["FLOW","ON"]}}]}}"#,
            rows.join(",")
        );
        modeldescription::read_table(&json).unwrap()
    }

    fn recordings(recording: Recording) -> Recordings {
        Recordings { responses: vec![recording], characteristics: Vec::new() }
    }

    fn description(fmi_version: &'static str) -> Description {
        Description { fmi_version, guid: "{1}".into(), ..Description::default() }
    }

    fn page() -> String {
        page_for(v2::FMI_VERSION)
    }

    fn page_for(fmi_version: &'static str) -> String {
        let recording = Recording {
            cycle: 100,
            shown: vec![0, 3],
            restart: vec![0.0, 0.0],
            calls: vec![vec![1.0, 0.0], vec![2.0, 1.0]],
        };
        let (description, recordings) = (description(fmi_version), recordings(recording));
        html(&table(), &description, &recordings, Some("LicenseRef-<House>"), Some("PUMP.c")).unwrap()
    }

    #[test]
    fn the_page_states_the_fmi_version_and_the_identifier_in_its_terms() {
        assert!(page().contains("FMI 2.0, co-simulation. GUID <code>{1}</code>"));
        assert!(page_for(v3::FMI_VERSION).contains("FMI 3.0, co-simulation. Instantiation token <code>{1}</code>"));
    }

    #[test]
    fn every_variable_is_on_the_page_with_all_that_is_known_of_it() {
        let page = page();
        assert!(page.contains(
            r##"<td class="name"><a href="#FLOW">FLOW</a></td><td>LREAL in&nbsp;l/min</td><td class="number">1.5</td><td><span class="short">About FLOW &amp; &lt;more&gt;</span> <span class="range">Range 0 ... 9</span></td><td class="number">0</td>"##
        ));
        assert!(page.contains(
            r##"<td class="name"><a href="#CYCLE">CYCLE</a></td><td>TIME in&nbsp;s</td><td class="number">0.1</td><td><span class="short">About CYCLE &amp; &lt;more&gt;</span> <span class="range">Range ≥ 0.001</span>"##
        ));
        for row in &table().rows {
            assert!(page.contains(&format!(r#"<tr id="{}">"#, row.name)), "{}", row.name);
        }
    }

    #[test]
    fn the_page_has_the_law_both_drawings_and_the_time_rule() {
        let page = page();
        assert!(page.contains("<p class=\"summary\">Pumps &amp; more.</p>"));
        assert!(page.contains("The <em>law</em>:") && page.contains("<td>1</td><td>2</td>"));
        assert!(page.contains("aria-label=\"Terminals of PUMP\"") && page.contains("aria-label=\"It runs\""));
        assert!(page.contains("<code>CYCLE</code> (start value 0.1 s)"));
        assert!(page.contains("<code>DUTY</code> is the mean"));
        assert!(page.contains("The 2 variables of inner blocks"));
    }

    #[test]
    fn the_page_names_the_licence_of_the_block_and_that_of_the_rest() {
        let page = page();
        assert!(page.contains(
            "The block: LicenseRef-&lt;House&gt;. The parts common to all FMUs of this kind: MIT or Apache 2.0"
        ));
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
        let drawing = diagram::svg(&table()).unwrap();
        assert!(
            drawing.contains(">FLOW</text>") && drawing.contains(">ON</text>") && drawing.contains(">CYCLE</text>")
        );
        assert!(!drawing.contains("DI_A"));
        assert!(drawing.contains("LREAL l/min"));
    }

    /// The page of the table, with a recorded response that shows only these rows.
    fn page_of(table: &Table, shown: &[usize]) -> String {
        let calls = vec![vec![0.0; shown.len()]; 2];
        let recording = Recording { cycle: 100, shown: shown.to_vec(), restart: calls[0].clone(), calls };
        html(table, &description(v2::FMI_VERSION), &recordings(recording), None, None).unwrap()
    }

    #[test]
    fn the_page_says_before_all_else_that_ranges_are_not_enforced() {
        let page = page();
        let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(place("class=\"summary\"") < place("Ranges are not enforced"));
        assert!(place("Ranges are not enforced") < place("aria-label=\"Terminals of PUMP\""));
    }

    #[test]
    fn a_range_that_is_only_in_the_description_stands_where_ranges_do() {
        let mut table = table();
        table.rows[2].description = "Gain; range: GAIN >= FLOW".into();
        let page = page_of(&table, &[0]);
        assert!(page.contains(
            r#"<td class="number">2</td><td><span class="short">Gain</span> <span class="range">Range GAIN ≥ FLOW</span></td>"#
        ));
    }

    #[test]
    fn a_block_without_a_law_has_no_heading_for_one() {
        assert!(page().contains("<h2 id=\"algorithm\">Algorithm</h2>"));
        let mut table = table();
        table.docs = "Pumps.".into();
        assert!(!page_of(&table, &[0]).contains("Algorithm</h2>"));
    }

    #[test]
    fn sections_of_the_documentation_stand_where_a_reader_looks_for_them() {
        let mut table = table();
        table.docs = "Pumps.\n\n# Sources\n\nA book.\n\n# Algorithm\n\n```math\nq = n\n```\n\n# Our own\n\nMore.\n\n\
                      # Purpose\n\nIt pumps, see FLOW.\n\n# Sampling\n\nOften."
            .into();
        let page = page_of(&table, &[0]);
        let places: Vec<usize> = [
            "<h2 id=\"purpose\">Purpose</h2>\n<p>It pumps, see <a class=\"variable\" href=\"#FLOW\">FLOW</a>.</p>",
            "<h2 id=\"diagram\">",
            "<p>Often.</p>",
            "<h2 id=\"variables\">",
            "<h2 id=\"algorithm\">Algorithm</h2>\n<div class=\"formula\"",
            "<h2 id=\"responses\">",
            "<h2 id=\"sources\">Sources</h2>\n<p>A book.</p>",
            "<h2 id=\"our-own\">Our own</h2>\n<p>More.</p>",
            "<h2 id=\"host\">",
        ]
        .map(|text| page.find(text).unwrap_or_else(|| panic!("{text}")))
        .to_vec();
        assert!(places.is_sorted(), "{places:?}");
        // The contents lead to every heading.
        for link in page.split("<li><a href=\"#").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            assert!(page.contains(&format!("<h2 id=\"{link}\">")), "{link}");
        }
    }

    #[test]
    fn the_page_does_not_show_what_the_documentation_says_of_the_dialog() {
        let mut table = table();
        let page = |docs: &str, table: &mut Table| {
            table.docs = docs.into();
            page_of(table, &[0])
        };
        let without = page("Pumps.\n\n# Purpose\n\nIt pumps.", &mut table);
        let fence = "```dialog\n[Process value]\nFLOW, DI_A.GAIN, CYCLE\n```";
        for docs in [
            format!("Pumps.\n\n# Purpose\n\nIt pumps.\n\n# Dialog\n\n{fence}"),
            format!("Pumps.\n\n# Purpose\n\nIt pumps.\n\n{fence}"),
        ] {
            assert_eq!(page(&docs, &mut table), without);
        }
    }

    #[test]
    fn a_dialog_that_does_not_fit_the_table_is_refused_with_the_remedy() {
        let refusal = |lines: &str| {
            let table = Table { docs: format!("Pumps.\n\n```dialog\n{lines}\n```"), ..table() };
            let recordings = Recordings { responses: Vec::new(), characteristics: Vec::new() };
            format!("{:#}", html(&table, &description(v2::FMI_VERSION), &recordings, None, None).unwrap_err())
        };
        assert_eq!(
            refusal("[Process value]\nFLOW\nCYCLE"),
            "the dialog of the block: PUMP: DI_A.GAIN is not in any group of its dialog: add it to one"
        );
        assert_eq!(
            refusal("setpoint: FLOWS"),
            "the dialog of the block: PUMP: the dialog line \"setpoint: FLOWS\": no variable \"FLOWS\"; did \
             you mean FLOW?"
        );
    }

    #[test]
    fn the_page_explains_dashed_lines_where_there_are_any() {
        let of = |shown: &[usize]| {
            let page = page_of(&table(), shown);
            (page.contains("dashed lines are inputs"), page.contains("stroke-dasharray"))
        };
        assert_eq!(of(&[0, 3]), (true, true));
        assert_eq!(of(&[3, 4]), (false, false));
    }

    #[test]
    fn the_stylesheet_knows_every_colour_of_the_drawings_for_the_dark() {
        let page = page();
        let (style, drawings) = page.split_once("</style>").unwrap();
        let classes: Vec<&str> = drawings
            .split("<")
            .filter(|tag| tag.contains("color=\"") || tag.contains("fill=\"#"))
            .map(|tag| {
                tag.split("class=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_else(|| panic!("{tag}"))
            })
            .collect();
        assert!(classes.contains(&"paper") && classes.iter().any(|class| class.starts_with("curve-")));
        let curves = (1..=plot::COLOR_COUNT).map(|number| format!("curve-{number}"));
        for class in classes.iter().map(|class| class.to_string()).chain(curves) {
            assert!(style.contains(&format!("svg .{class} {{")), "{class}");
        }
    }
}
