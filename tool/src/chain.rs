//! Measuring chains start with the value they measure: the controller is called first, and must see the plant's value
//! rather than 0.

use crate::describe::describe;
use crate::home::Home;
use crate::message::Member;
use crate::session::start_values;
use run::system::own_name;

/// The dialog's names for a chain's input and for its value until the first call.
const INPUT: &str = "input";
const START: &str = "start";

/// The members with which a run begins: until its first call, a measuring chain has the value of the measured output,
/// unless the user set another one. If a member cannot be started, the chain is left unchanged: the run reports the
/// reason.
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
