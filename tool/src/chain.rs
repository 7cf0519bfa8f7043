//! Measuring chains begin with what they measure: the controller, which is called first, sees the plant and not a 0 in its first call.

use crate::describe::describe;
use crate::home::Home;
use crate::message::Member;
use crate::session::start_values;
use run::system::own_name;

/// What a chain's input and its value until the first call mean in its dialog.
const INPUT: &str = "input";
const START: &str = "start";

/// The members with which a run begins: a measuring chain has, until its first call, the value of the output that it measures,
/// unless the user has set another one. A member that cannot be started leaves it as it is: the run says why.
pub fn begin_at_the_plant(home: &dyn Home, members: &[Member], connections: &[(String, String)]) -> Vec<Member> {
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
