//! The content of the parameter tool's page for an FMU: its block's diagram, the help of its variables, and its
//! purpose.

use crate::page;
use anyhow::{Context, Result};
use draw::diagram;
use modeldescription::Table;
use serde::Serialize;
use std::collections::BTreeMap;

/// The prefix of the ids in a diagram, so that they differ from those of the page.
pub const PREFIX: &str = "diagram-";

/// The sections of a block's documentation that a user should read before first use.
const ABOUT: [&str; 3] = ["Purpose", "Quick start", "Limits of use"];

/// The content for an FMU.
#[derive(Debug, Serialize)]
struct Asset<'a> {
    /// The block diagram as SVG.
    diagram: String,
    /// HTML by the name of the variable; variables without help are left out.
    help: BTreeMap<&'a str, String>,
    /// The sections [`ABOUT`] as HTML.
    about: String,
}

/// The assets of these blocks as a JSON object with their names as keys.
///
/// # Errors
/// A diagram or a formula cannot be rendered.
pub fn json<'a>(tables: impl IntoIterator<Item = &'a Table>) -> Result<Vec<u8>> {
    let assets = tables.into_iter().map(|table| {
        let asset = asset(table).with_context(|| table.name.clone())?;
        Ok((table.name.as_str(), asset))
    });
    Ok(serde_json::to_vec(&assets.collect::<Result<BTreeMap<_, _>>>()?)?)
}

fn asset(table: &Table) -> Result<Asset<'_>> {
    let help = table.rows.iter().filter(|row| !row.help.is_empty());
    Ok(Asset {
        diagram: diagram::svg_with(table, PREFIX).context("the diagram of the block")?,
        help: help.map(|row| Ok((row.name.as_str(), page::help(table, row)?))).collect::<Result<_>>()?,
        about: page::sections(table, &ABOUT)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn an_fmu_has_its_diagram_the_help_of_its_variables_and_its_purpose() {
        let row = |name: &str, help: &str, kind: &str, role: &str| {
            format!(
                r#"{{"name":"{name}","description":"x","help":"{help}","kind":"{kind}","role":"{role}","start":0.1,"min":null,
                "max":null,"unit":null}}"#
            )
        };
        let rows = [row("FLOW", "See CYCLE & *more*.", "REAL", "input"), row("CYCLE", "", "TIME", "cycle")];
        let docs = r"Pumps.\n\n# Purpose\n\nIt pumps.\n\n# Algorithm\n\nNone.\n\n# Limits of use\n\nFLOW < 9.";
        let json = format!(
            r#"{{"name":"PUMP","docs":"{docs}","cycle":1,"mean":null,"variables":[{}],"responses":[]}}"#,
            rows.join(",")
        );
        let table: Table = modeldescription::read_table(&json).unwrap();
        let assets: Value = serde_json::from_slice(&super::json([&table]).unwrap()).unwrap();
        let pump = &assets["PUMP"];
        assert!(pump["diagram"].as_str().unwrap().starts_with("<svg"));
        assert_eq!(
            pump["help"]["FLOW"],
            "<p>See <a class=\"variable\" href=\"#CYCLE\">CYCLE</a> &amp; <em>more</em>.</p>\n"
        );
        assert_eq!(pump["help"].get("CYCLE"), None);
        let about = pump["about"].as_str().unwrap();
        assert_eq!(
            about,
            "<h3>Purpose</h3>\n<p>It pumps.</p>\n<h3>Limits of use</h3>\n<p><a class=\"variable\" \
             href=\"#FLOW\">FLOW</a> &lt; 9.</p>\n"
        );
    }
}
