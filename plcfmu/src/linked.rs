//! The blocks and plants that are linked into this program, as what a study runs in place of their FMUs.

use blocks::{Block, EachBlock};
use fmu::table::{Code, Guid};
use modeldescription::Description;
use run::component::Reset;
use study::worker::Linked;
use tool::linked::Instance;

/// Finds the block of an FMU, if it is one of this program: the GUID says that the variables and start values are the same. Whether
/// the law is, only the library says, see [`Linked::code`]. A preset has another GUID.
pub fn find(description: &Description) -> Option<Linked> {
    let mut search = Search { guid: &description.guid, found: None };
    blocks::for_each_block(&mut search);
    plants::for_each_plant(&mut search);
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
            let interface = fmu::describe(B::TABLE, self.guid);
            self.found = Some(Linked { interface, code: Code::<B>::TEXT, instantiate });
        }
    }
}
