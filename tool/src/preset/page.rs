//! The documentation page of a preset: the block's page, with a section on the start values at the top.

use anyhow::Context;
use blocks::table::number::number;
use blocks::{Row, Value};
use draw::escape::Text;
use modeldescription::digits;
use parameters::{Loop, Origin};
use std::fmt::{self, Write};

/// The comments that enclose the section on a preset's start values.
pub const PRESET: (&str, &str) = ("<!-- preset -->", "<!-- end of preset -->");

/// The comments that enclose the text on recorded results.
pub const RECORDING: (&str, &str) = ("<!-- recorded -->", "<!-- end of recorded -->");

/// The comments that enclose the text on the FMU's C source.
pub const SOURCE: (&str, &str) = ("<!-- source -->", "<!-- end of source -->");

/// The page of a preset called `name`, derived from the page of its block or of another preset of it. `library` is the
/// GUID of the block's own FMU.
///
/// # Errors
/// The page lacks the comments that enclose one of the replaced texts.
pub fn html(page: &str, name: &str, library: &str, values: &Loop) -> anyhow::Result<String> {
    let section = section(name, library, values)?;
    let page = replaced(page, PRESET, &section)?;
    let page = replaced(&page, RECORDING, "Recorded with the block's start values, not with this preset's.")?;
    if !page.contains(SOURCE.0) {
        // This FMU was packed before FMUs contained C sources.
        return Ok(page);
    }
    replaced(&page, SOURCE, "This preset has no C source; the block's C source has the block's own start values.")
}

/// The section on the start values.
fn section(name: &str, library: &str, values: &Loop) -> Result<String, fmt::Error> {
    let (name, library, block) = (Text(name), Text(library), Text(&values.block.name));
    let mut html = String::new();
    writeln!(html, "<section id=\"preset\">\n<h2>Preset {name}</h2>")?;
    writeln!(
        html,
        "<p>This FMU is {block} with the start values below. It contains the library of {block},\n\
         <code>{library}</code>; all other sections of this page describe {block} with its own start values.</p>"
    )?;
    writeln!(
        html,
        "<div class=\"wide\">\n<table>\n<thead><tr><th>Name</th><th class=\"number\">Value</th><th>Unit</th>\
         <th class=\"number\">{block}</th><th>From</th><th>Meaning</th></tr></thead>\n<tbody>"
    )?;
    for setting in &values.settings {
        let member = &values.block.members[setting.member];
        let value = shown(member, setting.value);
        let value = if setting.value == member.start { value } else { format!("<strong>{value}</strong>") };
        writeln!(
            html,
            "<tr><td class=\"name\">{}</td><td class=\"number\">{value}</td><td>{}</td><td class=\"number\">{}</td>\
             <td>{}</td><td>{}</td></tr>",
            Text(&member.name),
            Text(member.shown_unit().unwrap_or_default()),
            shown(member, member.start),
            Text(&origin(&setting.origin)),
            Text(&member.description)
        )?;
    }
    write!(html, "</tbody>\n</table>\n</div>\n</section>")?;
    Ok(html)
}

/// Returns the page with `text` in place of what is between two marks.
fn replaced(page: &str, (begin, end): (&str, &str), text: &str) -> anyhow::Result<String> {
    let parts = || {
        let (before, rest) = page.split_once(begin)?;
        let (_, after) = rest.split_once(end)?;
        Some(format!("{before}{begin}{text}{end}{after}"))
    };
    parts().with_context(|| format!("it does not contain {begin:?} and {end:?}"))
}

fn shown(member: &Row, value: Value) -> String {
    digits::number(member.kind, number(value))
}

/// The origin of a value, with the file name but without its folders.
fn origin(origin: &Origin) -> String {
    let name = |file: &String| file.rsplit(['/', '\\']).next().unwrap_or(file).to_string();
    let mut origin = origin.clone();
    match &mut origin {
        Origin::Default => {}
        Origin::Text { file, .. } | Origin::File { file } | Origin::Data { file, .. } => *file = name(file),
    }
    origin.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::Role;
    use parameters::BlockType;
    use std::sync::Arc;

    fn values() -> Loop {
        let member = |name: &str, start| Row {
            description: "Flow & more".into(),
            unit: Some("l/min".into()),
            ..Row::new(name, Role::Parameter, start)
        };
        let members = vec![member("FLOW", Value::Real(1.5)), member("ON", Value::Bool(false))];
        let mut values = Loop::new("P1", Arc::new(BlockType::new("PUMP".into(), Vec::new(), members)));
        let origin = Origin::Text { file: "/home/a/plant <1>.awl".into(), line: 7, column: 3, span: 0..0 };
        values.set(0, Value::Real(0.1), origin);
        values
    }

    fn page() -> String {
        format!("<h1>A</h1>{}{}<p>{}x{}</p>", PRESET.0, PRESET.1, RECORDING.0, RECORDING.1)
    }

    #[test]
    fn the_section_has_each_value_beside_the_blocks_own_with_its_origin() {
        let page = html(&page(), "P1", "{1}", &values()).unwrap();
        assert!(page.contains(
            r#"<td class="number"><strong>0.1</strong></td><td>l/min</td><td class="number">1.5</td><td>plant &lt;1&gt;.awl:7:3</td><td>Flow &amp; more</td>"#
        ), "{page}");
        assert!(
            page.contains(
                r#"<td class="number">FALSE</td><td>l/min</td><td class="number">FALSE</td><td>default</td>"#
            )
        );
        assert!(page.contains("<h2>Preset P1</h2>") && page.contains("<code>{1}</code>"));
        assert!(!page.contains("<!-- recorded -->x"));
    }

    #[test]
    fn the_section_of_a_preset_of_a_preset_takes_the_place_of_the_first() {
        let first = html(&page(), "P1", "{1}", &values()).unwrap();
        assert_eq!(html(&first, "P2", "{1}", &values()).unwrap(), html(&page(), "P2", "{1}", &values()).unwrap());
    }

    #[test]
    fn a_page_without_a_place_for_the_section_is_told() {
        assert!(
            html("<html>", "P1", "{1}", &values())
                .unwrap_err()
                .to_string()
                .starts_with("it does not contain \"<!-- preset")
        );
    }
}
