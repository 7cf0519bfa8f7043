//! Loops that are known to work: those of the crate `plants`.

use crate::message::{KnownLoop, Member, Setup};
use anyhow::{Context, Result};
use run::file;
use run::system::own_name;

/// Those whose FMUs there are.
pub fn loops(is_there: impl Fn(&str) -> bool) -> Vec<KnownLoop> {
    let mut loops: Vec<KnownLoop> = plants::LOOPS.iter().flat_map(|(name, text)| known(name, text)).collect();
    loops.retain(|known| known.setup.members.iter().all(|member| is_there(&member.fmu)));
    loops
}

fn known(name: &str, text: &str) -> Result<KnownLoop> {
    let title = text.lines().next().and_then(|line| line.strip_prefix("# ")).context("no title in the first line")?;
    let about = text.lines().nth(1).and_then(|line| line.strip_prefix("# ")).unwrap_or_default();
    let system = file::parse(name, text)?;
    let at_the_start: Vec<_> = system.settings.iter().filter(|setting| setting.time.is_none()).collect();
    let member = |member: &run::system::Member| {
        let own = at_the_start.iter().filter_map(|of| Some((own_name(&of.variable, &member.name)?.into(), of.value)));
        let fmu = member.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Member { name: member.name.clone(), fmu, values: own.collect() }
    };
    let events = system.settings.iter().filter_map(|of| Some((of.time?, of.variable.clone(), of.value))).collect();
    let setup = Setup {
        members: system.members.iter().map(member).collect(),
        connections: system.connections.into_iter().map(|connection| (connection.from, connection.to)).collect(),
        step: system.step,
        exchange: system.exchange,
    };
    let name = name.strip_suffix(".toml").unwrap_or(name).into();
    Ok(KnownLoop { name, title: title.into(), about: about.into(), setup, stop: system.stop, events })
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
        assert_eq!(controller.values["GAIN"], Value::Number(0.7));
        assert_eq!(controller.values["PVPER_ON"], Value::Boolean(true));
        assert_eq!(plant.values["CYCLE"], Value::Number(1.0));
        assert_eq!((furnace.setup.step, furnace.setup.exchange), (Some(1.0), Exchange::Parallel));
        let level = loops.iter().find(|known| known.name == "level").unwrap();
        assert_eq!((level.stop, level.about.as_str()), (Some(1200.0), "Then the consumers take twice as much."));
        assert_eq!(level.events, [(600.0, "TANK.DRAIN".into(), Value::Number(100.0))]);
        let to = |known: &KnownLoop| known.setup.connections.iter().map(|(_, to)| to.clone()).collect::<Vec<_>>();
        assert_eq!(to(furnace), [format!("{}.POWER", plant.name), format!("{}.PV_PER", controller.name)]);
        assert!(loops.iter().any(|known| known.setup.members[0].values.contains_key("DI_PULSEGEN.P_B_TM")));
    }

    #[test]
    fn every_description_is_a_loop_and_one_whose_fmus_are_missing_is_left_out() {
        assert_eq!(loops(|_| true).len(), plants::LOOPS.len());
        assert!(loops(|fmu| fmu == "NONE").is_empty());
    }
}
