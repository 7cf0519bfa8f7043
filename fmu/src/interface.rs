//! The library's description of itself, for the packer.

use crate::host_type::Version;
use crate::log::Category;
use crate::table::{self, Guid, quoted};
use blocks::{Block, Table, TableText};

/// The description of the library as a JSON object: the block's table (see [`table::json`]) and the interface, which is
/// the version, the GUID, the capabilities and the log categories.
pub fn json<V: Version, B: Block>() -> String {
    json_of::<V, _>(B::TABLE, Guid::<B>::TEXT)
}

/// The same of a table and a GUID that are known at run time only.
pub fn json_of<V: Version, S: TableText>(table: &Table<S>, guid: &str) -> String {
    let capabilities: Vec<String> =
        V::CAPABILITIES.iter().map(|(name, value)| format!("{}:{value}", quoted(name))).collect();
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
        quoted(V::NUMBER),
        quoted(guid),
        capabilities.join(","),
        categories.join(","),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::Sum;

    #[test]
    fn the_description_has_the_table_and_the_interface_with_capabilities_and_categories() {
        let json = json::<crate::v2::Fmi2, Sum>();
        assert!(json.starts_with(r#"{"table":{"name":"SUM","#), "{json}");
        let interface = json.find(r#"},"interface":{"version":"2.0","guid":"{"#).unwrap();
        let interface = &json[interface..];
        let capabilities = <crate::v2::Fmi2 as Version>::CAPABILITIES;
        for (name, value) in capabilities {
            assert!(interface.contains(&format!(r#""{name}":{value}"#)), "{name} is missing in {interface}");
        }
        assert!(!capabilities.is_empty() && interface.contains(r#""log_categories":[{"name":"logStatusError","#));
        assert!(interface.contains(r#""description":"A defect of the FMU: the instance can only be freed"},"#));
        assert!(interface.contains(r#"{"name":"logAdvice","description":"#) && interface.ends_with(r#""}]}}"#));
    }
}
