//! What a library says of itself: its block's table, as the `fmu` crate writes it.

use crate::error::Error;
use serde::Deserialize;

/// A block's table as its library tells it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// The block's name, and with it that of the model, of the library and of the FMU.
    pub name: String,
    /// The block's documentation (Markdown); its first paragraph says what the block does.
    pub docs: String,
    /// A hash of the table, compiled into the library.
    pub guid: String,
    /// The row that holds the time between two calls.
    pub cycle: usize,
    /// The row that holds the mean of the block's pulse over a communication step, if it has one.
    pub mean: Option<usize>,
    /// All variables; the number of the row is the value reference.
    pub variables: Vec<Row>,
    /// What the documentation shows of the block.
    pub response: Response,
}

/// One variable. Numbers are as FMI has them: a TIME in seconds, FALSE and TRUE as 0 and 1.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its name with the instances that lead to it: `GAIN`, `DI_CONT_C.GAIN`.
    pub name: String,
    /// A short text.
    pub description: String,
    /// Its PLC type.
    pub kind: Kind,
    /// Who sets it, and when.
    pub role: Role,
    /// Its value in a new block.
    pub start: f64,
    /// The lowest value that makes sense.
    pub min: Option<f64>,
    /// The highest value that makes sense.
    pub max: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
}

/// The PLC type of a variable.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub enum Kind {
    /// 32-bit floating point.
    Real,
    /// 64-bit floating point.
    LReal,
    /// Milliseconds.
    Time,
    /// An analog value: 16 bits, two's complement.
    Word,
    /// A 16-bit integer.
    Int,
    /// One bit.
    Bool,
}

impl Kind {
    /// The type as PLC programs write it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Real => "REAL",
            Kind::LReal => "LREAL",
            Kind::Time => "TIME",
            Kind::Word => "WORD",
            Kind::Int => "INT",
            Kind::Bool => "BOOL",
        }
    }
}

/// Who sets a variable, and when.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub enum Role {
    /// A signal: what a process, an operator or another block changes while the loop runs.
    Input,
    /// A setting that may be tuned while the loop runs.
    Parameter,
    /// A setting that is fixed once the block runs.
    Fixed,
    /// The time between two calls: fixed too.
    Cycle,
    /// A result.
    Output,
    /// A signal inside the block.
    Local,
}

/// A short run of the block that shows what it does.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// What is to be seen, in one sentence.
    pub title: String,
    /// How many calls it lasts.
    pub calls: u32,
    /// What is set: the number of the call before which (0 is before the restart), the variable, its value.
    pub set: Vec<(u32, String, f64)>,
    /// The variables that are drawn and recorded; none means all inputs and outputs.
    pub show: Vec<String>,
}

impl Interface {
    /// Reads the table from the JSON that a library gives.
    ///
    /// # Errors
    /// What is wrong with it, and where: no such JSON, a cycle row that is none, a response of variables that do not
    /// exist.
    pub fn parse(json: &str) -> Result<Interface, Error> {
        let interface: Interface = serde_json::from_str(json).map_err(|error| not_a_table(json, &error))?;
        interface.check()?;
        Ok(interface)
    }

    /// The row of the variable with this full name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|row| row.name == name)
    }

    /// What the block does, in one sentence: the first paragraph of its documentation, on one line.
    pub fn summary(&self) -> String {
        let lines = self.docs.lines().map(str::trim).skip_while(|line| line.is_empty());
        lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }

    fn check(&self) -> Result<(), Error> {
        let wrong = |what: String| Err(Error::new(format!("the library's table of {}: {what}", self.name)));
        match self.variables.get(self.cycle) {
            Some(Row { kind: Kind::Time, role: Role::Cycle, start, .. }) if *start >= 0.001 => {}
            Some(Row { kind: Kind::Time, role: Role::Cycle, name, start, .. }) => {
                return wrong(format!("{name} starts with {start:?} s: a block is called every millisecond at most"));
            }
            Some(row) => {
                let (name, kind, role) = (&row.name, row.kind.name(), row.role);
                return wrong(format!("row {name} is to be the cycle: it is {kind} and {role:?}, not TIME and Cycle"));
            }
            None => {
                let rows = self.variables.len();
                return wrong(format!("row {} is to be the cycle, and there are {rows} rows", self.cycle));
            }
        }
        if let Some(mean) = self.mean
            && self.variables.get(mean).is_none_or(|row| row.role != Role::Output)
        {
            return wrong(format!("row {mean} is to be the mean of its pulse, and is no output"));
        }
        let set = self.response.set.iter().map(|(_, name, _)| name);
        if let Some(unknown) = set.chain(&self.response.show).find(|name| self.find(name).is_none()) {
            return wrong(format!("its response names {unknown:?}: the table has no such variable"));
        }
        Ok(())
    }
}

/// The parser's error, and the text that it stopped at.
fn not_a_table(json: &str, error: &serde_json::Error) -> Error {
    let line = json.lines().nth(error.line().saturating_sub(1)).unwrap_or("");
    let mut end = error.column().min(line.len());
    while !line.is_char_boundary(end) {
        end -= 1;
    }
    let mut begin = end.saturating_sub(60);
    while !line.is_char_boundary(begin) {
        begin -= 1;
    }
    Error::new(format!(
        "the library's table cannot be read: {error}, after {:?}; build library and packer from the same sources, and \
         give every start, min and max a finite number",
        &line[begin..end]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTER: &str = r#"{"name":"COUNTER","docs":" Counts.\n On two lines.\n\n More.\n","guid":"{1}","cycle":1,
        "variables":[
        {"name":"ENABLE","description":"Counts","kind":"Bool","role":"Input","start":1.0,"min":null,"max":null,"unit":null},
        {"name":"CYCLE","description":"Cycle","kind":"Time","role":"Cycle","start":0.1,"min":0.001,"max":null,"unit":null},
        {"name":"COUNT","description":"","kind":"Int","role":"Output","start":0.0,"min":null,"max":null,"unit":null}],
        "response":{"title":"t","calls":60,"set":[[3,"ENABLE",0.0]],"show":["COUNT"]}}"#;

    fn refused(from: &str, to: &str) -> String {
        assert!(COUNTER.contains(from));
        Interface::parse(&COUNTER.replace(from, to)).unwrap_err().to_string()
    }

    #[test]
    fn the_mean_is_an_output() {
        let with = |row: &str| COUNTER.replace(r#""cycle":1,"#, &format!(r#""cycle":1,"mean":{row},"#));
        assert_eq!(Interface::parse(&with("2")).unwrap().mean, Some(2));
        assert_eq!(Interface::parse(&with("null")).unwrap().mean, None);
        for row in ["0", "3"] {
            let error = Interface::parse(&with(row)).unwrap_err().to_string();
            assert!(error.ends_with(&format!("row {row} is to be the mean of its pulse, and is no output")), "{error}");
        }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let interface = Interface::parse(COUNTER).unwrap();
        assert_eq!((interface.name.as_str(), interface.guid.as_str(), interface.cycle), ("COUNTER", "{1}", 1));
        assert_eq!(interface.find("COUNT"), Some(2));
        let row = &interface.variables[1];
        assert_eq!(
            (row.kind, row.role, row.start, row.min, row.max),
            (Kind::Time, Role::Cycle, 0.1, Some(0.001), None)
        );
        assert_eq!(interface.response.set, [(3, "ENABLE".to_string(), 0.0)]);
    }

    #[test]
    fn numbers_come_out_of_the_table_bit_by_bit() {
        // A number whose 17 digits serde_json's fast algorithm rounds to a neighbour.
        let json = COUNTER.replace(r#""start":0.1"#, r#""start":423.20917087271323"#);
        let start = Interface::parse(&json).unwrap().variables[1].start;
        assert_eq!(start.to_bits(), 423.209_170_872_713_23_f64.to_bits());
    }

    #[test]
    fn the_summary_is_the_first_paragraph_on_one_line() {
        assert_eq!(Interface::parse(COUNTER).unwrap().summary(), "Counts. On two lines.");
    }

    #[test]
    fn a_number_that_json_has_not_is_named_with_its_variable() {
        let error = refused(r#""start":0.1"#, r#""start":NaN"#);
        assert!(error.contains(r#"\"start\":N"#) && error.contains("finite number"), "{error}");
    }

    #[test]
    fn a_type_or_a_key_that_the_packer_does_not_know_is_named() {
        assert!(refused("\"Int\"", "\"DInt\"").contains("unknown variant `DInt`"));
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
        // An x where a comma belongs. The 60 bytes up to it begin with an ä, and, with a b after the last ä, in the middle
        // of one, which is then shown whole.
        for end in ["", "b"] {
            let name = "ä".repeat(50) + end;
            let error = Interface::parse(&format!("{{\"name\":\"{name}\"x")).unwrap_err().to_string();
            assert_eq!(error.matches('ä').count(), 29, "{error}");
        }
    }

    #[test]
    fn the_cycle_row_has_to_be_there_and_to_be_a_time_of_a_millisecond_or_more() {
        assert!(refused("\"cycle\":1", "\"cycle\":3").contains("row 3 is to be the cycle, and there are 3 rows"));
        assert!(refused("\"cycle\":1", "\"cycle\":2").contains("row COUNT is to be the cycle: it is INT and Output"));
        assert!(refused(r#""start":0.1"#, r#""start":0.0005"#).contains("CYCLE starts with 0.0005 s"));
    }

    #[test]
    fn a_response_of_variables_that_do_not_exist_is_refused() {
        assert!(refused("[3,\"ENABLE\"", "[3,\"ENABEL\"").contains("\"ENABEL\""));
        assert!(refused("\"show\":[\"COUNT\"]", "\"show\":[\"COUTN\"]").contains("\"COUTN\""));
    }
}
