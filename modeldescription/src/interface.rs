//! A library's description of itself: its block's table and its FMI support.

use crate::description::{Capabilities, LogCategory};
use crate::error::{Error, shortened};
use crate::model_description::VERSIONS;
use crate::names::Names;
use crate::table::{self, TableGrammar};
use blocks::{Table, Types};
use serde::Deserialize;

/// A library's description of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// The block's table.
    pub table: Table,
    /// The FMI version, one of [`VERSIONS`].
    pub version: String,
    /// Which FMI types represent the PLC types, if the FMI version offers a choice.
    pub types: Types,
    /// How variables are named.
    pub names: Names,
    /// A hash of the table, compiled into the library.
    pub guid: String,
    /// The library's capabilities for co-simulation.
    pub capabilities: Capabilities,
    /// The categories of its messages.
    pub log_categories: Vec<LogCategory>,
}

impl Interface {
    /// The interface for a table that was not obtained from a library: without capabilities or log categories.
    ///
    /// # Errors
    /// The table is inconsistent.
    pub fn linked(table: Table, guid: &str) -> Result<Interface, Error> {
        table::check(&table)?;
        Ok(Interface {
            table,
            version: VERSIONS[0].into(),
            types: Types::Native,
            names: Names::default(),
            guid: guid.into(),
            capabilities: Capabilities::default(),
            log_categories: Vec::new(),
        })
    }

    /// Parses the JSON that a library returns, which describes it as FMI 2.0. To obtain a model description of another
    /// form, change [`Interface::version`], [`Interface::types`] and [`Interface::names`] of the result.
    ///
    /// # Errors
    /// The JSON is malformed or belongs to a different FMI version, the cycle row does not contain the cycle, or a
    /// response has variables that do not exist; the message states the location.
    pub fn parse(json: &str) -> Result<Interface, Error> {
        // The version is read first because other versions have different keys.
        if let Ok(library) = serde_json::from_str::<serde_json::Value>(json)
            && let Some(version) = library["interface"]["version"].as_str().filter(|version| *version != VERSIONS[0])
        {
            let version = shortened(version);
            return Err(Error::new(format!(
                "the library implements FMI {version}: only FMI {} is supported",
                VERSIONS[0]
            )));
        }
        let Library { table, interface } = table::from_json(json)?;
        let table = table.table()?;
        table::check(&table)?;
        let Facts { version, guid, capabilities, log_categories } = interface;
        let (types, names) = (Types::Native, Names::default());
        Ok(Interface { table, version, types, names, guid, capabilities, log_categories })
    }
}

/// The grammar of a library's JSON.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Library {
    table: TableGrammar,
    interface: Facts,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Facts {
    version: String,
    guid: String,
    capabilities: Capabilities,
    log_categories: Vec<LogCategory>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Kind, Role};

    const COUNTER: &str = r#"{"table":{"name":"COUNTER","docs":" Counts.\n On two lines.\n\n More.\n","cycle":1,
        "variables":[
        {"name":"ENABLE","description":"Counts","kind":"BOOL","role":"input","start":1.0,"min":null,"max":null,"unit":null},
        {"name":"CYCLE","description":"Cycle","kind":"TIME","role":"cycle","start":0.1,"min":0.001,"max":null,"unit":null},
        {"name":"COUNT","description":"","kind":"INT","role":"output","start":0.0,"min":null,"max":null,"unit":null}],
        "responses":[{"title":"t","calls":60,"set":[[3,"ENABLE",0.0]],"show":["COUNT"]}]},
        "interface":{"version":"2.0","guid":"{1}","capabilities":{"canInterpolateInputs":true},
        "log_categories":[{"name":"logAll","description":"All of it"}]}}"#;

    fn refused(from: &str, to: &str) -> String {
        assert!(COUNTER.contains(from));
        Interface::parse(&COUNTER.replace(from, to)).unwrap_err().to_string()
    }

    #[test]
    fn the_mean_is_an_output() {
        let with = |row: &str| COUNTER.replace(r#""cycle":1,"#, &format!(r#""cycle":1,"mean":{row},"#));
        assert_eq!(Interface::parse(&with("2")).unwrap().table.mean, Some(2));
        assert_eq!(Interface::parse(&with("null")).unwrap().table.mean, None);
        for row in ["0", "3"] {
            let error = Interface::parse(&with(row)).unwrap_err().to_string();
            assert!(error.ends_with(&format!("the mean of the pulse is row {row}, which is not an output")), "{error}");
        }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let interface = Interface::parse(COUNTER).unwrap();
        assert_eq!((interface.version.as_str(), interface.guid.as_str()), ("2.0", "{1}"));
        let capabilities = Capabilities { can_interpolate_inputs: true, ..Capabilities::default() };
        assert_eq!(interface.capabilities, capabilities);
        let category = LogCategory { name: "logAll".into(), description: Some("All of it".into()) };
        assert_eq!(interface.log_categories, [category]);
        let table = interface.table;
        assert_eq!((table.name.as_str(), table.cycle), ("COUNTER", 1));
        assert_eq!(table.find("COUNT"), Some(2));
        let row = &table.rows[1];
        assert_eq!(
            (row.kind, row.role, row.start(), row.least(), row.greatest()),
            (Kind::Time, Role::Cycle, 0.1, Some(0.001), None)
        );
        assert_eq!(table.responses[0].set, [(3, "ENABLE".to_string(), 0.0)]);
    }

    #[test]
    fn numbers_come_out_of_the_table_bit_by_bit() {
        // A number whose 17 digits serde_json's fast algorithm rounds to a neighbour.
        let row = r#""kind":"INT","role":"output","start":0.0"#;
        let json = COUNTER.replace(row, r#""kind":"LREAL","role":"output","start":423.20917087271323"#);
        let start = Interface::parse(&json).unwrap().table.rows[2].start();
        assert_eq!(start.to_bits(), 423.209_170_872_713_23_f64.to_bits());
    }

    #[test]
    fn the_summary_is_the_first_paragraph_on_one_line() {
        assert_eq!(Interface::parse(COUNTER).unwrap().table.summary(), "Counts. On two lines.");
    }

    #[test]
    fn a_number_that_json_has_not_is_named_with_its_variable() {
        let error = refused(r#""start":0.1"#, r#""start":NaN"#);
        assert!(error.contains(r#"\"start\":N"#) && error.contains("make every start, min and max finite"), "{error}");
    }

    #[test]
    fn a_type_a_role_or_a_key_that_the_packer_does_not_know_is_named() {
        assert!(refused("\"INT\"", "\"S5TIME\"").contains("unknown kind `S5TIME`, expected one of REAL, LREAL, TIME"));
        assert!(
            refused("\"output\"", "\"Output\"").contains("unknown role `Output`, expected one of input, parameter")
        );
        assert!(refused("\"table\":", "\"fmi\":3,\"table\":").contains("unknown field `fmi`"));
        assert!(refused("\"guid\":", "\"uuid\":").contains("unknown field `uuid`"));
        assert!(refused("\"calls\":60", "\"calls\":60,\"steps\":1").contains("unknown field `steps`"));
    }

    #[test]
    fn damage_within_a_long_line_of_any_alphabet_is_an_error_and_no_panic() {
        let json = COUNTER.replace("\"Counts\"", "\"Zählt 数える\"").replace('\n', "");
        for end in (0..json.len()).filter(|end| json.is_char_boundary(*end)) {
            assert!(Interface::parse(&json[..end]).is_err());
        }
    }

    #[test]
    fn the_text_before_an_error_is_cut_between_characters() {
        // The parser stops at the first of the two bytes of ä: the text ends before it.
        let error = refused(r#""start":0.1"#, r#""start":ä"#);
        assert!(error.contains(r#"\"start\":"; build"#), "{error}");
        // An x instead of a comma. The 60 bytes before it start with a whole ä or, with a b after the last ä, inside
        // one, which is then shown whole.
        for end in ["", "b"] {
            let name = "ä".repeat(50) + end;
            let error = Interface::parse(&format!("{{\"table\":{{\"name\":\"{name}\"x")).unwrap_err().to_string();
            assert_eq!(error.matches('ä').count(), 29, "{error}");
        }
    }

    #[test]
    fn the_cycle_row_has_to_be_there_and_to_be_a_time_of_a_millisecond_or_more() {
        assert!(
            refused("\"cycle\":1", "\"cycle\":3")
                .contains("the cycle is row 3 (counted from 0), but the number of rows is 3")
        );
        assert!(refused("\"cycle\":1", "\"cycle\":2").contains("the cycle row COUNT has type INT and role output"));
        assert!(refused(r#""start":0.1"#, r#""start":0.0"#).contains("CYCLE starts at 0.0 s"));
    }

    #[test]
    fn a_response_of_variables_that_do_not_exist_is_refused() {
        assert!(refused("[3,\"ENABLE\"", "[3,\"ENABEL\"").contains("\"ENABEL\""));
        assert!(refused("\"show\":[\"COUNT\"]", "\"show\":[\"COUTN\"]").contains("\"COUTN\""));
    }

    #[test]
    fn a_capability_has_the_standards_default_unless_it_is_told_and_an_unknown_one_is_refused() {
        let told = |capabilities: &str| COUNTER.replace(r#""canInterpolateInputs":true"#, capabilities);
        let parsed = |capabilities: &str| Interface::parse(&told(capabilities)).unwrap().capabilities;
        assert_eq!(parsed(""), Capabilities::default());
        let orders = Capabilities { max_output_derivative_order: 1, ..Capabilities::default() };
        assert_eq!(parsed(r#""maxOutputDerivativeOrder":1,"canSerializeFMUstate":false"#), orders);
        for (wrong, words) in [
            (r#""canFly":true"#, "unknown field `canFly`, expected one of `needsExecutionTool`"),
            (r#""modelIdentifier":"A""#, "unknown field `modelIdentifier`"),
            (r#""canInterpolateInputs":1"#, "invalid type: integer `1`, expected a boolean"),
            (r#""canInterpolateInputs":true,"canInterpolateInputs":true"#, "duplicate field `canInterpolateInputs`"),
        ] {
            let error = Interface::parse(&told(wrong)).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn capabilities_are_listed_with_the_names_and_values_of_the_xml() {
        let list = Interface::parse(COUNTER).unwrap().capabilities.list();
        assert_eq!(list.len(), 10);
        assert_eq!(list[0], ("needsExecutionTool", "false".to_string()));
        assert!(list.contains(&("canInterpolateInputs", "true".to_string())), "{list:?}");
        assert_eq!(list[3], ("maxOutputDerivativeOrder", "0".to_string()));
    }

    #[test]
    fn another_version_of_fmi_is_refused_by_name_whatever_else_it_tells() {
        let error = refused(r#""version":"2.0","guid""#, r#""version":"3.0","instantiationToken""#);
        assert_eq!(error, "the library implements FMI 3.0: only FMI 2.0 is supported");
    }
}
