//! The library's description of itself, for the packer.

use super::{CAPABILITIES, Fmi2};
use crate::host_type::Version;
use crate::log::Category;
use crate::table::{self, quoted};
use blocks::{Table, TableText};

/// The description of a library as a JSON object: its table (see [`table::json`]) and the interface, consisting of the
/// version, the GUID, the capabilities and the log categories.
pub fn describe<S: TableText>(table: &Table<S>, guid: &str) -> String {
    let capabilities: Vec<String> =
        CAPABILITIES.iter().map(|(name, value)| format!("{}:{value}", quoted(name))).collect();
    let categories: Vec<String> = Category::ALL
        .iter()
        .map(|category| {
            let name = quoted(&category.name.to_string_lossy());
            format!(r#"{{"name":{name},"description":{}}}"#, quoted(category.description))
        })
        .collect();
    format!(
        r#"{{"table":{},"interface":{{"version":{},"guid":{},"capabilities":{{{}}},"log_categories":[{}]}}}}"#,
        table::json(table),
        quoted(Fmi2::NUMBER),
        quoted(guid),
        capabilities.join(","),
        categories.join(","),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Guid;
    use crate::test_block::Sum;
    use blocks::Block;

    #[test]
    fn the_description_has_the_table_and_the_interface_with_capabilities_and_categories() {
        let json = describe(Sum::TABLE, Guid::<Sum>::TEXT);
        assert!(json.starts_with(r#"{"table":{"name":"SUM","#), "{json}");
        let interface = json.find(r#"},"interface":{"version":"2.0","guid":"{"#).unwrap();
        let interface = &json[interface..];
        for (name, value) in CAPABILITIES {
            assert!(interface.contains(&format!(r#""{name}":{value}"#)), "{name} is missing in {interface}");
        }
        assert!(interface.contains(r#""log_categories":[{"name":"logStatusError","#));
        assert!(interface.contains(r#""description":"Internal errors of the FMU: the instance can only be freed"},"#));
        assert!(interface.contains(r#"{"name":"logAdvice","description":"#) && interface.ends_with(r#""}]}}"#));
    }
}
