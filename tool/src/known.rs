//! Descriptions of loops: those in the crate `plants`, which are known to work, and files for `plcfmu run`.

use crate::message::{KnownLoop, MadeOf, Member, Program, Setup};
use anyhow::{Context, Result, bail};
use manifest::Manifest;
use run::file;
use run::system::own_name;
use std::path::PathBuf;

/// The loops for which all FMUs are available.
pub fn loops(is_there: impl Fn(&str) -> bool) -> Vec<KnownLoop> {
    let mut loops: Vec<KnownLoop> = plants::LOOPS.iter().flat_map(|(name, text)| known(name, text)).collect();
    loops.retain(|known| known.setup.members.iter().all(|member| is_there(&member.fmu)));
    loops
}

fn known(name: &str, text: &str) -> Result<KnownLoop> {
    let title = text.lines().next().and_then(|line| line.strip_prefix("# ")).context("no title in the first line")?;
    let about = text.lines().nth(1).and_then(|line| line.strip_prefix("# ")).unwrap_or_default();
    Ok(KnownLoop { title: title.into(), about: about.into(), ..described(name, text)? })
}

/// Reads a description of a loop from `text`; errors refer to it as `name`. Its FMUs are named after their files, and
/// its times are shifted to begin at 0.
///
/// # Errors
/// The description is faulty (with line and column), has no FMU, or needs a parameter file.
pub fn described(name: &str, text: &str) -> Result<KnownLoop> {
    let system = file::parse(name, text)?;
    if system.members.is_empty() {
        bail!("{name} has no FMU: a loop needs [fmus] with at least one");
    }
    let start = system.start.unwrap_or(0.0);
    let at_the_start: Vec<_> = system.settings.iter().filter(|setting| setting.time.is_none()).collect();
    let member = |member: &run::system::Member| {
        let own = at_the_start.iter().filter_map(|of| Some((own_name(&of.variable, &member.name)?.into(), of.value)));
        let fmu = member.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Member { name: member.name.clone(), fmu, values: own.collect() }
    };
    let events =
        system.settings.iter().filter_map(|of| Some((of.time? - start, of.variable.clone(), of.value))).collect();
    let programs = system.programs.into_iter().map(|(member, program)| made_of(member, program)).collect();
    let setup = Setup {
        members: system.members.iter().map(member).collect(),
        connections: system.connections.into_iter().map(|connection| (connection.from, connection.to)).collect(),
        step: system.step,
        exchange: system.exchange,
    };
    let name: String = name.strip_suffix(".toml").unwrap_or(name).into();
    let stop = system.stop.map(|stop| stop - start);
    Ok(KnownLoop { title: name.clone(), name, about: String::new(), setup, stop, events, programs })
}

/// A member that is a program, with its sources listed by file name only: the page does not know their folders.
fn made_of(member: String, mut program: Manifest) -> MadeOf {
    let own = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let sources = program.sources.iter().map(own).collect();
    program.sources.clear();
    MadeOf { member, sources, program: Program { files: Vec::new(), manifest: program } }
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
        assert_eq!((level.stop, level.about.as_str()), (Some(1200.0), "Later, consumption doubles."));
        assert_eq!(level.events, [(600.0, "TANK.DRAIN".into(), Value::Number(100.0))]);
        let to = |known: &KnownLoop| known.setup.connections.iter().map(|(_, to)| to.clone()).collect::<Vec<_>>();
        assert_eq!(to(furnace), [format!("{}.POWER", plant.name), format!("{}.PV_PER", controller.name)]);
        assert!(loops.iter().any(|known| known.setup.members[0].values.contains_key("DI_PULSEGEN.P_B_TM")));
    }

    #[test]
    fn a_description_begins_at_0_and_names_the_sources_of_its_programs() {
        let text = "start = 10.0\nstop = 30.0\nstep = 0.5\n[fmus]\nTIC = \"PUMP.fmu\"\n[settings]\nTIC.SP_INT = 60.0\n\
                    [[events]]\ntime = 12.0\nset.TIC.SP_INT = 70.0\n";
        let known = described("mine.toml", text).unwrap();
        assert_eq!((known.name.as_str(), known.stop, known.setup.step), ("mine", Some(20.0), Some(0.5)));
        assert_eq!(known.events, [(2.0, "TIC.SP_INT".into(), Value::Number(70.0))]);
        assert_eq!(known.setup.members[0].values["SP_INT"], Value::Number(60.0));
        let tank = "[fmus]\nA = { sources = [\"plc/tank.scl\", \"types.udt\"], cycle = \"500ms\" }\n[settings]\nA = { start = true }\n";
        let known = described("tank.toml", tank).unwrap();
        let [program] = known.programs.as_slice() else { panic!("{known:?}") };
        assert_eq!(
            (program.member.as_str(), program.sources.as_slice()),
            ("A", ["tank.scl", "types.udt"].map(String::from).as_slice())
        );
        assert_eq!((program.program.manifest.cycle, program.program.files.len()), (Some(500), 0));
        assert_eq!(known.setup.members[0].values["start"], Value::Boolean(true));
        let refused = |text: &str| described("mine.toml", text).unwrap_err().to_string();
        assert!(refused("step = ?").contains("mine.toml"), "{}", refused("step = ?"));
    }

    #[test]
    fn every_description_is_a_loop_and_one_whose_fmus_are_missing_is_left_out() {
        assert_eq!(loops(|_| true).len(), plants::LOOPS.len());
        assert!(loops(|fmu| fmu == "NONE").is_empty());
    }
}
