//! Starts each measuring chain with the value it measures: the controller is called first, and must see the plant's
//! value rather than 0.

use crate::describe::describe;
use crate::home::Home;
use crate::message::Member;
use crate::session::start_values;
use run::system::own_name;

/// The dialog's names for a measuring chain's input and for the start value of its output.
const INPUT: &str = "input";
const START: &str = "start";

/// Returns the members with the start values for a run: a measuring chain starts at the value of the output that it
/// measures, unless the user has set its start value. If the measured member cannot be started, the chain is left
/// unchanged, and the run reports the reason.
pub(crate) fn begin_at_the_plant(home: &dyn Home, members: &[Member], connections: &[(String, String)]) -> Vec<Member> {
    let mut begun = members.to_vec();
    for place in 0..begun.len() {
        let Ok(description) = describe(home, &begun[place].fmu) else { continue };
        let signal = |meaning: &str| description.roles.signals.iter().find(|(of, _)| of == meaning);
        let (Some((_, input)), Some((_, start))) = (signal(INPUT), signal(START)) else { continue };
        if members[place].values.contains_key(start) {
            continue;
        }
        let input = format!("{}.{input}", begun[place].name);
        let Some((output, _)) = connections.iter().find(|(_, to)| *to == input) else { continue };
        let owns = |of: &&Member| own_name(output, &of.name).is_some();
        let value = begun.iter().find(owns).and_then(|plant| start_values(home, plant).ok()?.remove(output));
        if let Some(value) = value {
            begun[place].values.insert(start.clone(), value);
        }
    }
    begun
}
