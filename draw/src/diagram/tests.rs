use super::*;
use std::collections::BTreeSet;

/// A pump with a controller, with every kind of element.
const PUMP: &str = r#"icon "P"
frame 0,0 68,14 "every call"
input SP 1,5
input FLOW 1,11
sum DIFF 12,5 left + bottom -
box GAIN 20,5 multiply with GAIN
box DI_A 32,5 in U out Y
switch ON 50,6 TRUE upper constant FALSE 0.0
value DI_A.LMN 36,5
output LMN 58,6
output RUNS 58,20
box RUN 46,20 "LMN > 0" with CYCLE
// the flow back
SP > DIFF
FLOW > DIFF.bottom
DIFF > GAIN > DI_A.U
DI_A.LMN: DI_A.Y > ON.TRUE
ON > LMN
55,6 > y14.5 > x40 > y20 > RUN
RUN > RUNS
text 15,4 "e"
"#;

/// Returns the table of the pump with this documentation.
fn table(docs: &str) -> Table {
    let row = |name: &str, kind: &str, role: &str, start: f64| {
        format!(
            r#"{{"name":"{name}","description":"About {name} & <more>","kind":"{kind}","role":"{role}","start":{start:?},
            "min":null,"max":null,"unit":null}}"#
        )
    };
    let rows = [
        row("SP", "REAL", "input", 0.0),
        row("FLOW", "REAL", "input", 0.0),
        row("ON", "BOOL", "parameter", 1.0),
        row("GAIN", "REAL", "parameter", 2.5),
        row("CYCLE", "TIME", "cycle", 0.1),
        row("LMN", "REAL", "output", 0.0),
        row("RUNS", "BOOL", "output", 0.0),
        row("DI_A.LMN", "REAL", "local", 0.0),
    ];
    let docs = serde_json::to_string(docs).unwrap();
    let json = format!(
        r#"{{"name":"PUMP","docs":{docs},"cycle":4,"mean":null,"variables":[{}],
        "responses":[{{"title":"It runs.","calls":2,"set":[],"show":[]}}]}}"#,
        rows.join(",")
    );
    modeldescription::read_table(&json).unwrap()
}

fn documented(diagram: &str) -> Table {
    table(&format!(" Pumps.\n\n # Diagram\n\n ```diagram\n{diagram} ```\n\n # Algorithm\n\n It pumps.\n"))
}

fn drawing() -> String {
    svg(&documented(PUMP)).unwrap()
}

/// Returns the error in the pump's diagram with one line replaced.
fn refusal(line: &str, other: &str) -> String {
    assert!(PUMP.contains(&format!("{line}\n")), "{line}");
    let table = documented(&PUMP.replacen(&format!("{line}\n"), &format!("{other}\n"), 1));
    format!("{:#}", svg(&table).unwrap_err())
}

#[test]
fn every_terminal_of_the_table_is_drawn_with_its_description() {
    let drawing = drawing();
    for name in ["SP", "FLOW", "ON", "GAIN", "CYCLE", "LMN", "RUNS"] {
        let terminal = format!(
            r#"<g id="terminal-{name}" data-variable="{name}"><title>{name}: About {name} &amp; &lt;more&gt;</title>"#
        );
        assert!(drawing.contains(&terminal), "{name}");
    }
    assert!(drawing.contains(r#"aria-label="Block diagram of PUMP""#));
}

#[test]
fn a_program_finds_wires_switches_and_values_by_the_names_of_their_variables() {
    let drawing = drawing();
    for id in ["wire-SP", "wire-LMN", "wire-RUNS", "wire-DI_A.LMN", "switch-ON"] {
        let name = id.split_once('-').unwrap().1;
        assert!(drawing.contains(&format!(r#"id="{id}" data-variable="{name}""#)), "{id}");
    }
    assert!(drawing.contains(r#"<g id="wire-from-DIFF"><path"#));
    for name in ["SP", "LMN", "GAIN", "DI_A.LMN"] {
        assert!(drawing.contains(&format!(r#"id="value-{name}""#)), "{name}");
    }
}

#[test]
fn settings_show_their_start_value_and_signals_leave_room_for_theirs() {
    let value = |name: &str| {
        let drawing = drawing();
        let text = drawing.split_once(&format!(r#"id="value-{name}""#)).unwrap().1;
        text.split_once('>').unwrap().1.split_once('<').unwrap().0.to_string()
    };
    assert_eq!([value("GAIN"), value("CYCLE"), value("SP"), value("LMN")], ["2.5", "0.1 s", "", ""]);
    let mut table = documented(PUMP);
    table.rows[0].role = Role::Parameter;
    assert!(svg(&table).unwrap().contains(r##"fill="#0b5394">0</text>"##));
}

#[test]
fn a_switch_stands_as_its_variable_starts() {
    let shown = |drawing: &str| {
        let is_hidden = |value: &str| {
            let blade = drawing.split_once(&format!(r#"data-value="{value}""#)).unwrap().1;
            blade.split_once("/>").unwrap().0.contains(r#"visibility="hidden""#)
        };
        (is_hidden("FALSE"), is_hidden("TRUE"))
    };
    assert_eq!(shown(&drawing()), (true, false));
    let mut table = documented(PUMP);
    table.rows[2].start = blocks::Value::Bool(false);
    assert_eq!(shown(&svg(&table).unwrap()), (false, true));
}

#[test]
fn booleans_are_thin_wires_on_both_sides_of_a_switch() {
    let pump = PUMP.replace("box RUN 46,20", "switch AUX 50,21 TRUE lower by ON\nbox RUN 30,20").replace(
        "55,6 > y14.5 > x40 > y20 > RUN\nRUN > RUNS",
        "55,6 > y14.5 > x22 > y20 > RUN\nRUN > AUX.FALSE\nAUX > x55 > RUNS",
    );
    let drawing = svg(&documented(&pump)).unwrap();
    let width = |id: &str| {
        let wire = drawing.split_once(&format!(r#"id="wire-{id}""#)).unwrap().1;
        wire.split_once("stroke-width=\"").unwrap().1.split_once('"').unwrap().0.to_string()
    };
    assert_eq!([width("SP"), width("LMN"), width("RUNS"), width("from-RUN")], ["1.8", "1.8", "1", "1"]);
    // The second switch for the variable has its own id.
    assert!(drawing.contains(r#"id="switch-AUX" data-variable="ON""#));
}

#[test]
fn a_dashed_wire_is_drawn_so_beside_the_others_of_its_signal() {
    let drawing = svg(&documented(&PUMP.replace("55,6 > y14.5", "dashed 55,6 > y14.5"))).unwrap();
    let wire = drawing.split_once("id=\"wire-LMN\"").unwrap().1.split_once("</g>").unwrap().0;
    let (plain, dashed) = wire.split_once("stroke-width").unwrap();
    assert!(!plain.contains("M550 60") && dashed.contains("M550 60"), "{wire}");
    assert!(dashed.contains("stroke-dasharray"), "{wire}");
}

#[test]
fn ids_are_unique_in_a_page_with_several_diagrams() {
    let page = drawing() + &svg_with(&documented(PUMP), "second-").unwrap();
    let ids: Vec<&str> = page.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(ids.len() > 30 && ids.contains(&"second-wire-SP"));
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len());
}

#[test]
fn a_block_without_a_diagram_is_drawn_as_a_box_with_its_pins() {
    let pins = svg(&table("Pumps.")).unwrap();
    assert!(pins.contains(r#"aria-label="Terminals of PUMP""#) && pins.contains(">FLOW</text>"));
}

#[test]
fn the_stylesheet_knows_every_colour_of_the_diagram_for_the_dark() {
    let style = include_str!("../templates/style.css");
    for tag in drawing().split('<').filter(|tag| tag.contains("color=\"") || tag.contains("fill=\"#")) {
        let class = tag.split("class=\"").nth(1).and_then(|rest| rest.split('"').next());
        let class = class.unwrap_or_else(|| panic!("{tag}"));
        assert!(style.contains(&format!("svg .{class} {{")), "{class}");
    }
}

#[test]
fn the_icon_has_the_sign_and_the_name() {
    let drawn = icon::svg(&documented(PUMP)).unwrap();
    assert!(drawn.contains(">P</text>") && drawn.contains(">PUMP</text>"));
    let symbol = icon::svg(&documented(&PUMP.replace(r#"icon "P""#, "icon pulses"))).unwrap();
    assert!(symbol.contains(symbol::named("pulses").unwrap().lines) && !symbol.contains(">P</text>"));
    assert!(icon::svg(&table("Pumps.")).unwrap().contains(">PUM</text>"));
}

#[test]
fn a_faulty_line_is_refused_with_its_number_its_text_and_a_remedy() {
    let is = |line, other, expected: &str| assert_eq!(refusal(line, other), format!("PUMP: {expected}"));
    is(
        "SP > DIFF",
        "pump 3,4",
        "line 14 of the diagram, `pump 3,4`, begins with \"pump\": a line is a wire such as SP > SUM, or begins with icon, \
         input, output, box, sum, switch, text, value, frame",
    );
    is("input SP 1,5", "input SP", "line 3 of the diagram, `input SP`, ends too early: add the position, such as 12,7");
    is(
        "input SP 1,5",
        "input SP left",
        "line 3 of the diagram, `input SP left`, has \"left\" instead of a position: write x,y, such as 12,7",
    );
    is(
        "sum DIFF 12,5 left + bottom -",
        "sum DIFF 12,5 left + bottom",
        "line 5 of the diagram, `sum DIFF 12,5 left + bottom`, ends too early: add the sign, + or -",
    );
    is(
        "switch ON 50,6 TRUE upper constant FALSE 0.0",
        "switch ON 50,6",
        "line 8 of the diagram, `switch ON 50,6`, ends too early: add TRUE upper or TRUE lower: the contact for TRUE",
    );
    is(
        "SP > DIFF",
        "SP > SUM",
        "line 14 of the diagram, `SP > SUM`, names \"SUM\", which no line describes; available: SP, FLOW, DIFF, \
         GAIN, DI_A, ON, LMN, RUNS, RUN",
    );
    is(
        "FLOW > DIFF.bottom",
        "FLOW > DIFF",
        "line 15 of the diagram, `FLOW > DIFF`, does not arrive horizontally at 11.1,5 from 6,11: add a corner such \
         as x9",
    );
    is(
        "55,6 > y14.5 > x40 > y20 > RUN",
        "55,7 > y14.5 > x40 > y20 > RUN",
        "line 19 of the diagram, `55,7 > y14.5 > x40 > y20 > RUN`, begins at 55,7, where no wire from a line above \
         passes: correct the point, or move the line down",
    );
    assert!(refusal("box GAIN 20,5 multiply with GAIN", "box GAIN 20,5 times with GAIN").contains(
        "uses the unknown symbol \"times\": choose one of analog_input, analog_output, normalize, dead_band, limit, \
         multiply,"
    ));
    for (other, expected) in [
        ("SP > DIFF.above", "uses DIFF.above, which does not exist"),
        ("SP > ON", "ends at the switch ON: specify the contact, ON.FALSE or ON.TRUE"),
        ("SP > x9", "is not a wire from one element to another"),
        ("SP >", "names \"\", which no line describes"),
        ("SP.left > DIFF", "does not connect to the right side of SP"),
        ("text 1,1 \"e", "has an unclosed quote"),
        ("input SP 1,20", "reuses the name SP from line 3"),
    ] {
        let refusal = refusal("SP > DIFF", other);
        assert!(refusal.contains(expected) && refusal.contains("line 14"), "{refusal}");
    }
}

#[test]
fn a_diagram_that_does_not_fit_its_table_is_refused() {
    for (line, other, expected) in [
        (
            "output RUNS 58,20",
            "output RUNS 58,20\ninput SPEED 1,20\nSPEED > x30 > RUN",
            "shows SPEED, which PUMP does not have",
        ),
        (
            "box GAIN 20,5 multiply with GAIN",
            "box GAIN 20,5 multiply",
            "the diagram of PUMP does not show GAIN: add each",
        ),
        (
            "box GAIN 20,5 multiply with GAIN",
            "box GAIN 20,5 multiply with GAIN CYCLE",
            "shows CYCLE, which line 6 already shows: remove one",
        ),
        (
            "box GAIN 20,5 multiply with GAIN",
            "box GAIN 20,5 multiply with GAIN LMN",
            "shows LMN, which is output in the table",
        ),
        ("RUN > RUNS", "", "`output RUNS 58,20`, has no wire: add one"),
        ("text 15,4 \"e\"", "text 20,5 \"e\"", "`text 20,5 \"e\"`, overlaps GAIN on line 6: move one of them"),
        ("FLOW > DIFF.bottom", "FLOW > x20 > y7 > DIFF.bottom", "passes through GAIN on line 6: add corners around it"),
        ("FLOW > DIFF.bottom", "FLOW > x10 > y5 > DIFF.bottom", "touches the wire on line 15 at 10,5"),
    ] {
        let refusal = refusal(line, other);
        assert!(refusal.contains(expected), "{refusal}");
    }
}

#[test]
fn in_a_linked_drawing_each_variable_leads_to_the_anchor_of_its_name() {
    let table = documented(PUMP);
    let (plain, linked) = (drawing(), super::linked(&table).unwrap());
    assert!(!plain.contains("<a ") && plain.contains("role=\"img\""));
    let shown = linked.matches("id=\"terminal-").count();
    assert!(shown > 3 && linked.matches("<a href=\"#").count() >= shown && !linked.contains("role=\"img\""));
    for row in table.rows.iter().filter(|row| linked.contains(&format!("terminal-{}\"", row.name))) {
        assert!(linked.contains(&format!("<a href=\"#{0}\"><g id=\"terminal-{0}\"", row.name)), "{}", row.name);
    }
}

#[test]
fn the_links_say_where_each_signal_comes_from_and_with_which_sign_it_is_taken() {
    let links = net::links(&documented(PUMP)).unwrap();
    let found = |from: &str, to: &str| {
        links.iter().find(|link| link.from == from && link.to == to).unwrap_or_else(|| panic!("{links:?}"))
    };
    assert!(!found("SP", "DIFF").is_negative && found("FLOW", "DIFF").is_negative);
    assert_eq!((found("FLOW", "DIFF").enters, found("SP", "DIFF").enters), (Some("bottom"), Some("left")));
    // It branches off the wire from ON to LMN.
    assert_eq!(found("ON", "RUN").leaves, Some("right"));
    assert_eq!(links.len(), 8);
}
