//! The blocks and plants that are linked into this program, as what a study runs in place of their FMUs.

use blocks::{Block, EachBlock};
use fmu::table::Guid;
use modeldescription::{Description, GENERATION_TOOL};
use run::component::Reset;
use study::worker::Linked;
use tool::linked::Instance;

/// Finds the block of an FMU, if it is one of this program: the GUID says that the variables and start values are the same, and the
/// version that the law is. A preset has another GUID.
pub fn find(description: &Description) -> Option<Linked> {
    let is_of_this_version = description.generation_tool.as_deref() == Some(GENERATION_TOOL);
    let mut search = Search { guid: &description.guid, found: None };
    if is_of_this_version {
        blocks::for_each_block(&mut search);
        plants::for_each_plant(&mut search);
    }
    search.found
}

struct Search<'a> {
    guid: &'a str,
    found: Option<Linked>,
}

impl EachBlock for Search<'_> {
    fn block<B: Block>(&mut self) {
        if Guid::<B>::TEXT == self.guid {
            let instantiate = |name: &str| Ok(Box::new(Instance::<B>::new(name)?) as Box<dyn Reset>);
            self.found = Some(Linked { interface: fmu::describe(B::TABLE, self.guid), instantiate });
        }
    }
}
