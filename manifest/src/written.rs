//! Reads and writes a manifest with serde: `{ sources = ["machine.scl"], cycle = "100ms", tags = ["Start : Bool"] }`.
//! An entry that may be repeated is one value or a list; its key is plural or, like the command's option, singular.

use crate::{Cpu, Manifest, constant, declaration, milliseconds, tag, unquoted};
use serde::de::{self, Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;
use std::path::PathBuf;

/// A manifest in its written form.
#[derive(Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
struct Written {
    #[serde(skip_serializing_if = "Many::is_empty", serialize_with = "short")]
    name: Many<String>,
    #[serde(skip_serializing_if = "Many::is_empty")]
    sources: Many<PathBuf>,
    /// One for all calls, or one for each.
    #[serde(skip_serializing_if = "Many::is_empty", serialize_with = "short")]
    cycle: Many<Cycle>,
    #[serde(alias = "call", skip_serializing_if = "Many::is_empty")]
    calls: Many<String>,
    #[serde(alias = "fb", skip_serializing_if = "Many::is_empty", serialize_with = "short")]
    run: Many<String>,
    #[serde(skip_serializing_if = "Many::is_empty", serialize_with = "short")]
    cpu: Many<Cpu>,
    #[serde(skip_serializing_if = "Many::is_empty", serialize_with = "short")]
    budget: Many<Budget>,
    #[serde(alias = "parameter", skip_serializing_if = "Many::is_empty")]
    parameters: Many<String>,
    #[serde(alias = "input", skip_serializing_if = "Many::is_empty")]
    inputs: Many<String>,
    #[serde(alias = "output", skip_serializing_if = "Many::is_empty")]
    outputs: Many<String>,
    #[serde(alias = "tag", skip_serializing_if = "Many::is_empty")]
    tags: Many<Tag>,
    /// An entry that is only a name is the block to run.
    #[serde(alias = "instance", skip_serializing)]
    instances: Many<Instance>,
    #[serde(alias = "constant", skip_serializing_if = "Many::is_empty")]
    constants: Many<Constant>,
    #[serde(alias = "stub", skip_serializing_if = "Many::is_empty")]
    stubs: Many<String>,
}

impl<'de> Deserialize<'de> for Manifest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Manifest, D::Error> {
        let written = Written::deserialize(deserializer)?;
        let (whole, named): (Vec<_>, Vec<_>) = written.instances.0.into_iter().partition(|of| of.block.is_some());
        let instances = whole.into_iter().filter_map(|of| Some(parameters::tags::Tag::new(of.name, of.block?)));
        let run = written.run.only("run").map_err(de::Error::custom)?;
        let mut manifest = Manifest {
            name: written.name.only("name").map_err(de::Error::custom)?,
            sources: written.sources.0,
            block: run.or(named.into_iter().next().map(|of| of.name)),
            cpu: written.cpu.only("cpu").map_err(de::Error::custom)?,
            budget: written.budget.only("budget").map_err(de::Error::custom)?.map(|Budget(count)| count),
            parameters: written.parameters.0,
            inputs: written.inputs.0,
            outputs: written.outputs.0,
            declared: written.tags.0.into_iter().map(|Tag(tag)| tag).chain(instances).collect(),
            constants: written.constants.0.into_iter().map(|Constant(pair)| pair).collect(),
            stubs: written.stubs.0,
            ..Manifest::default()
        };
        let cycles: Vec<u32> = written.cycle.0.into_iter().map(|Cycle(cycle)| cycle).collect();
        manifest.set_calls(written.calls.0, &cycles).map_err(de::Error::custom)?;
        Ok(manifest)
    }
}

impl Serialize for Manifest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let cycle = self.cycle.unwrap_or_default();
        let mut cycles: Vec<u32> =
            self.calls.iter().map(|task| if task.period == 0 { cycle } else { task.period }).collect();
        // One is enough if all calls run in every cycle.
        if cycles.iter().all(|period| *period == cycle) {
            cycles = self.cycle.into_iter().collect();
        }
        let written = Written {
            name: Many(self.name.iter().cloned().collect()),
            sources: Many(self.sources.clone()),
            cycle: Many(cycles.into_iter().map(Cycle).collect()),
            calls: Many(self.calls.iter().map(|task| task.name.clone()).collect()),
            run: Many(self.block.iter().cloned().collect()),
            cpu: Many(self.cpu.into_iter().collect()),
            budget: Many(self.budget.into_iter().map(Budget).collect()),
            parameters: Many(self.parameters.clone()),
            inputs: Many(self.inputs.clone()),
            outputs: Many(self.outputs.clone()),
            tags: Many(self.declared.iter().cloned().map(Tag).collect()),
            instances: Many::default(),
            constants: Many(self.constants.iter().cloned().map(Constant).collect()),
            stubs: Many(self.stubs.clone()),
        };
        written.serialize(serializer)
    }
}

/// A value, or a list of values.
struct Many<T>(Vec<T>);

impl<T> Default for Many<T> {
    fn default() -> Many<T> {
        Many(Vec::new())
    }
}

impl<T> Many<T> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value, if any; several values are an error.
    fn only(self, key: &str) -> Result<Option<T>, String> {
        match self.0.len() {
            0 | 1 => Ok(self.0.into_iter().next()),
            count => Err(format!("{key} has {count} values: specify only one")),
        }
    }
}

/// A value of a manifest.
trait Item: Sized {
    /// Parses a string, or a number written as a string.
    fn from_text(text: &str) -> Result<Self, String>;

    /// Converts a number.
    fn from_number(number: f64) -> Result<Self, String> {
        Self::from_text(&number.to_string())
    }

    /// Converts a pair, written as a list of a name and a value; `None` if this type has no pairs.
    fn from_pair(_name: String, _of: String) -> Option<Self> {
        None
    }

    /// The string from which [`Item::from_text`] restores the value.
    fn text(&self) -> String;
}

struct Cycle(u32);
struct Budget(u32);
struct Tag(parameters::tags::Tag);
struct Constant((String, String));
struct Instance {
    name: String,
    block: Option<String>,
}

impl Item for String {
    fn from_text(text: &str) -> Result<String, String> {
        Ok(text.into())
    }

    fn text(&self) -> String {
        self.clone()
    }
}

impl Item for PathBuf {
    fn from_text(text: &str) -> Result<PathBuf, String> {
        Ok(text.into())
    }

    fn text(&self) -> String {
        self.display().to_string()
    }
}

impl Item for Cpu {
    fn from_text(text: &str) -> Result<Cpu, String> {
        text.parse()
    }

    fn text(&self) -> String {
        self.name().into()
    }
}

impl Item for Cycle {
    fn from_text(text: &str) -> Result<Cycle, String> {
        milliseconds(text).map(Cycle)
    }

    /// Converts a number of seconds.
    fn from_number(seconds: f64) -> Result<Cycle, String> {
        let milliseconds = (seconds * 1000.0).round();
        if !(1.0..=f64::from(i32::MAX)).contains(&milliseconds) || (milliseconds / 1000.0 - seconds).abs() >= 1e-9 {
            return Err(format!(
                "the time between two calls is {seconds:?} s: write a whole number of milliseconds, at least 0.001 s"
            ));
        }
        Ok(Cycle(milliseconds as u32))
    }

    fn text(&self) -> String {
        format!("{}ms", self.0)
    }
}

impl Item for Budget {
    fn from_text(text: &str) -> Result<Budget, String> {
        text.parse().map(Budget).map_err(|_| format!("the budget must be a number of statements, not {text:?}"))
    }

    fn text(&self) -> String {
        self.0.to_string()
    }
}

impl Item for Tag {
    fn from_text(text: &str) -> Result<Tag, String> {
        tag(text).map(Tag)
    }

    fn from_pair(name: String, of: String) -> Option<Tag> {
        Some(Tag(parameters::tags::Tag::new(name, of)))
    }

    fn text(&self) -> String {
        self.0.to_string()
    }
}

impl Item for Constant {
    fn from_text(text: &str) -> Result<Constant, String> {
        constant(text).map(Constant)
    }

    fn from_pair(name: String, of: String) -> Option<Constant> {
        Some(Constant((name, of)))
    }

    fn text(&self) -> String {
        format!("{}={}", self.0.0, self.0.1)
    }
}

impl Item for Instance {
    fn from_text(text: &str) -> Result<Instance, String> {
        if !text.contains(':') {
            return Ok(Instance { name: unquoted(text).into(), block: None });
        }
        declaration(text).map(|(name, block)| Instance { name, block: Some(block) })
    }

    fn text(&self) -> String {
        self.block.iter().fold(self.name.clone(), |name, block| format!("{name} : {block}"))
    }
}

impl<T: Item> Serialize for Many<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(Item::text))
    }
}

/// Writes a single value as a string, several values as a list.
fn short<T: Item, S: Serializer>(values: &Many<T>, serializer: S) -> Result<S::Ok, S::Error> {
    match values.0.as_slice() {
        [only] => serializer.serialize_str(&only.text()),
        _ => values.serialize(serializer),
    }
}

/// Reads a value of a manifest; a list of values yields several.
struct Read<T> {
    /// Whether it is inside a list, where a nested list is a pair.
    is_item: bool,
    of: PhantomData<T>,
}

impl<'de, T: Item> Deserialize<'de> for Many<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Many<T>, D::Error> {
        deserializer.deserialize_any(Read { is_item: false, of: PhantomData }).map(Many)
    }
}

impl<'de, T: Item> de::DeserializeSeed<'de> for Read<T> {
    type Value = Vec<T>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<T>, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, T: Item> Visitor<'de> for Read<T> {
    type Value = Vec<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a string or a number")
    }

    fn visit_unit<E>(self) -> Result<Vec<T>, E> {
        Ok(Vec::new())
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Vec<T>, E> {
        T::from_text(text).map(|item| vec![item]).map_err(E::custom)
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Vec<T>, E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Vec<T>, E> {
        self.visit_f64(number as f64)
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Vec<T>, E> {
        T::from_number(number).map(|item| vec![item]).map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
        if !self.is_item {
            let mut items = Vec::new();
            while let Some(found) = list.next_element_seed(Read { is_item: true, of: PhantomData })? {
                items.extend(found);
            }
            return Ok(items);
        }
        let wrong = || de::Error::custom("expected a string or a number; found a list");
        let (name, of) = (list.next_element()?, list.next_element()?);
        let pair = name.zip(of).and_then(|(name, of)| T::from_pair(name, of));
        pair.map(|item| vec![item]).ok_or_else(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Task;

    fn read(text: &str) -> Result<Manifest, String> {
        toml::from_str(text).map_err(|error| error.message().to_string())
    }

    #[test]
    fn what_is_written_reads_back_and_the_options_of_the_command_are_keys() {
        let manifest = Manifest {
            name: Some("PUMP".into()),
            sources: vec!["pump.scl".into(), "types.udt".into()],
            cycle: Some(100),
            block: Some("Pump".into()),
            cpu: Some(Cpu::S71200),
            budget: Some(5000),
            parameters: vec!["limit".into()],
            inputs: vec!["setpoint".into()],
            outputs: vec!["Plant.level".into(), "on".into()],
            calls: [("Main", 0), ("Cyclic", 500)].map(|(name, period)| Task { name: name.into(), period }).into(),
            declared: vec![parameters::tags::Tag::new("Start", "Bool")],
            constants: vec![("MAX".into(), "5".into())],
            stubs: vec!["TSEND_C".into(), "Valve".into()],
        };
        let text = toml::to_string(&manifest).unwrap();
        assert!(
            text.contains("cycle = [\"100ms\", \"500ms\"]\ncalls = [\"Main\", \"Cyclic\"]\nrun = \"Pump\""),
            "{text}"
        );
        assert_eq!(read(&text).as_ref(), Ok(&manifest));
        let options = "name = \"PUMP\"\nsources = [\"pump.scl\", \"types.udt\"]\ncall = [\"Main\", \"Cyclic\"]\ncycle = [0.1, 0.5]\n\
            fb = [\"Pump\"]\ncpu = 1200\nbudget = 5000\nparameter = \"limit\"\ninput = \"setpoint\"\n\
            output = [\"Plant.level\", \"on\"]\ninstance = [\"Start : Bool\"]\nconstant = [[\"MAX\", \"5\"]]\nstub = [\"TSEND_C\", \"Valve\"]\n";
        assert_eq!(read(options), Ok(manifest));
        assert_eq!(read("instance = \"Pump_DB\"").unwrap().block.as_deref(), Some("Pump_DB"));
        assert!(read("").unwrap().is_bare() && read("sources = \"a.scl\"").unwrap().is_bare());
    }

    #[test]
    fn what_does_not_belong_there_is_refused() {
        for (text, wrong) in [
            ("cycle = \"1\"", "\"1\" is not a duration: write 2s, 100ms or 1m30s"),
            (
                "cycle = 0.0001",
                "the time between two calls is 0.0001 s: write a whole number of milliseconds, at least 0.001 s",
            ),
            ("cpu = \"1100\"", "the CPU must be 300, 400, 1200 or 1500, not \"1100\""),
            ("fb = [\"A\", \"B\"]", "run has 2 values: specify only one"),
            ("tag = [\"Start\"]", "\"Start\": write a name, a colon and a type, such as Start : Bool"),
            ("input = [[\"a\", \"b\"]]", "expected a string or a number; found a list"),
            ("budget = -1", "the budget must be a number of statements, not \"-1\""),
        ] {
            assert_eq!(read(text), Err(wrong.to_string()), "{text}");
        }
        assert!(read("tas = 1").unwrap_err().starts_with("unknown field `tas`"));
    }
}
