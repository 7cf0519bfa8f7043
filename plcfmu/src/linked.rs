//! The blocks and plants linked into this program, which a study runs instead of their FMUs.

use blocks::table::abreast::{Abreast, EachInLanes, InLanes, Lanes};
use blocks::{Block, EachBlock};
use fmu::table::{Code, Guid};
use modeldescription::Description;
use run::component::Reset;
use study::worker::Linked;
use tool::linked::Instance;

/// Finds the block of an FMU, if it is linked into this program: an equal GUID means that the variables and start
/// values are the same. Only the library reveals whether the law is also the same, see [`Linked::code`]. A preset has a
/// different GUID.
pub fn find(description: &Description) -> Option<Linked> {
    let mut search = Search { guid: &description.guid, found: None };
    blocks::for_each_block(&mut search);
    plants::for_each_plant(&mut search);
    blocks::for_each_in_lanes(&mut search);
    plants::for_each_in_lanes(&mut search);
    search.found
}

struct Search<'a> {
    guid: &'a str,
    found: Option<Linked>,
}

impl EachBlock for Search<'_> {
    fn block<B: Block>(&mut self) {
        self.look_at::<B, Vec<B>>();
    }
}

impl EachInLanes for Search<'_> {
    fn block<B: InLanes>(&mut self) {
        self.look_at::<B, Lanes<B>>();
    }
}

impl Search<'_> {
    /// Stores `B` as the result if it has the GUID. Runs in parallel store the states of this block in a `G`.
    fn look_at<B: Block, G: Abreast<B>>(&mut self) {
        if Guid::<B>::TEXT == self.guid {
            let instantiate = |name: &str| Ok(Box::new(Instance::<B>::abreast::<G>(name)?) as Box<dyn Reset>);
            let interface = fmu::describe(B::TABLE, self.guid);
            self.found = Some(Linked { table: B::TABLE.into(), interface, code: Code::<B>::TEXT, instantiate });
        }
    }
}
