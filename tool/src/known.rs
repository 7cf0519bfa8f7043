//! Loops that are known to work: those of `examples/loops`.

use crate::message::KnownLoop;

/// Those whose FMUs there are.
pub fn loops(is_there: impl Fn(&str) -> bool) -> Vec<KnownLoop> {
    let mut loops: Vec<KnownLoop> =
        serde_json::from_str(include_str!(concat!(env!("OUT_DIR"), "/loops.json"))).unwrap_or_default();
    loops.retain(|known| known.setup.members.iter().all(|member| is_there(&member.fmu)));
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use run::system::{Exchange, Value};

    #[test]
    fn a_loop_has_its_members_with_their_values_in_the_order_of_the_file() {
        let loops = loops(|_| true);
        let furnace = loops.iter().find(|known| known.title.contains("furnace")).unwrap();
        let [controller, plant] = furnace.setup.members.as_slice() else { panic!("{furnace:?}") };
        assert_eq!(controller.values["GAIN"], Value::Number(1.4));
        assert_eq!(controller.values["PVPER_ON"], Value::Boolean(true));
        assert_eq!(plant.values["CYCLE"], Value::Number(1.0));
        assert_eq!((furnace.setup.step, furnace.setup.exchange), (Some(1.0), Exchange::Parallel));
        let to = |known: &KnownLoop| known.setup.connections.iter().map(|(_, to)| to.clone()).collect::<Vec<_>>();
        assert_eq!(to(furnace), [format!("{}.POWER", plant.name), format!("{}.PV_PER", controller.name)]);
        assert!(loops.iter().any(|known| known.setup.members[0].values.contains_key("DI_PULSEGEN.P_B_TM")));
    }

    #[test]
    fn every_file_is_a_loop_and_one_whose_fmus_are_missing_is_left_out() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/loops");
        assert_eq!(loops(|_| true).len(), std::fs::read_dir(folder).unwrap().count());
        assert!(loops(|fmu| fmu == "NONE").is_empty());
    }
}
