//! The engine's home in the page: the FMUs linked into the WebAssembly.

use anyhow::{Context, Result, bail};
use blocks::EachBlock;
use fmu::table::Guid;
use modeldescription::{Description, Interface, ModelDescription, Table, shortened};
use parameters::{BlockType, Loop};
use run::component::Component;
use run::dialog;
use run::fmus::Fmus;
use std::sync::Arc;
use tool::home::Home;
use tool::known;
use tool::linked::Instance;
use tool::message::{Entry, KnownLoop, LoopRole};

/// All linked FMUs.
pub struct Linked {
    fmus: Vec<Fmu>,
    blocks: Vec<Arc<BlockType>>,
}

/// A linked FMU.
struct Fmu {
    part: LoopRole,
    table: Arc<Table>,
    description: Arc<Description>,
    instantiate: fn(&str) -> Result<Box<dyn Component>>,
}

impl Fmu {
    /// The FMU, with the same interface as the packer reads from its library.
    fn new<B: blocks::Block>() -> Result<Fmu> {
        let interface = Interface::linked(Table::from(B::TABLE), Guid::<B>::TEXT)?;
        let description = Arc::new(ModelDescription::from_interface(&interface)?.description());
        let instantiate = |name: &str| Ok(Box::new(Instance::<B>::new(name)?) as Box<dyn Component>);
        let (roles, _) = dialog::read(&interface.table)?;
        Ok(Fmu { part: roles.part(&interface.table), table: Arc::new(interface.table), description, instantiate })
    }
}

impl Linked {
    /// All linked FMUs: the blocks, then the plants.
    ///
    /// # Panics
    /// The table of a block is faulty, so that no FMU can be built for it either.
    pub fn new() -> Linked {
        let mut linked = Linked { fmus: Vec::new(), blocks: Vec::new() };
        blocks::for_each_block(&mut linked);
        plants::for_each_plant(&mut linked);
        linked
    }

    fn find(&self, name: &str) -> Result<&Fmu> {
        let found = self.fmus.iter().find(|fmu| fmu.table.name == name);
        found.with_context(|| format!("no FMU {:?}", shortened(name)))
    }
}

impl EachBlock for Linked {
    fn block<B: blocks::Block>(&mut self) {
        self.fmus.push(Fmu::new::<B>().expect("the packer accepts the table"));
        self.blocks.push(Arc::new(BlockType::for_block::<B>()));
    }
}

impl Default for Linked {
    fn default() -> Linked {
        Linked::new()
    }
}

impl Fmus for Linked {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        Ok(self.find(fmu)?.description.clone())
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        Ok(Some(self.find(fmu)?.table.clone()))
    }

    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>> {
        (self.find(fmu)?.instantiate)(name)
    }
}

impl Home for Linked {
    fn entries(&self) -> Vec<Entry> {
        let entry = |fmu: &Fmu| Entry {
            name: fmu.table.name.clone(),
            summary: fmu.table.summary(),
            part: fmu.part,
            is_foreign: false,
        };
        self.fmus.iter().map(entry).collect()
    }

    fn known_loops(&self) -> Vec<KnownLoop> {
        known::loops(|name| self.find(name).is_ok())
    }

    fn blocks(&self) -> Vec<Arc<BlockType>> {
        self.blocks.clone()
    }

    fn preset(&self, of: &Loop) -> Result<Vec<u8>> {
        bail!("{}: the page has no FMU for {}; open one", of.name, of.block.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use run::component::Type;

    #[test]
    fn every_fmu_makes_a_call_and_gives_all_its_values() {
        let home = Linked::new();
        assert!(home.entries().len() >= 5);
        for entry in home.entries() {
            let description = home.description(&entry.name).unwrap();
            assert_eq!(description.model_name, entry.name);
            assert_ne!(entry.part, LoopRole::Other, "{}", entry.name);
            let mut instance = home.instantiate(&entry.name, "x").unwrap();
            instance.setup(0.0, None).unwrap();
            instance.enter_initialization().unwrap();
            instance.exit_initialization().unwrap();
            instance.step(0.0, description.default_experiment.unwrap().step_size.unwrap()).unwrap();
            for (variable, row) in description.variables.iter().zip(&home.table(&entry.name).unwrap().unwrap().rows) {
                let kind = match row.kind {
                    blocks::Kind::Bool => Type::Boolean,
                    blocks::Kind::Int | blocks::Kind::Word => Type::Integer,
                    _ => Type::Real,
                };
                let mut value = [f64::NAN];
                instance.read(kind, &[variable.value_reference], &mut value).unwrap();
                assert!(value[0].is_finite(), "{}.{}", entry.name, variable.name);
            }
            instance.terminate().unwrap();
        }
    }

    #[test]
    fn an_instance_refuses_in_the_words_of_a_host() {
        let home = Linked::new();
        let name = &home.entries()[0].name;
        let mut instance = home.instantiate(name, "x").unwrap();
        let refusal = |result: Result<()>| format!("{:#}", result.unwrap_err());
        let early = refusal(instance.step(0.0, 1.0));
        assert!(early.starts_with("at 0.0 s, step 1.0 s: ") && early.contains("DoStep returned "), "{early}");
        assert!(early.contains("Error: not allowed in state instantiated"), "{early}");
        assert_eq!(refusal(instance.write(Type::Integer, &[0], &[0.5])), "0.5 is not a 32-bit integer");
        assert!(home.instantiate(name, "").is_err() && home.instantiate(name, "a\0").is_err());
    }

    #[test]
    fn what_is_missing_is_named_with_what_to_do() {
        let home = Linked::new();
        assert_eq!(home.table("PUMP").unwrap_err().to_string(), "no FMU \"PUMP\"");
        let block = home.blocks().remove(0);
        let refusal = home.preset(&Loop::new("TIC101", block)).unwrap_err().to_string();
        assert_eq!(refusal, "TIC101: the page has no FMU for CONT_C; open one");
    }
}
