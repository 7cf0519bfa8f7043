//! The known loops of the catalogue run as their files say: as `plcfmu run` runs them.

#![allow(clippy::unwrap_used)]

use run::component::Component;
use run::fmus::Fmus;
use run::plan::Plan;
use run::{file, master};
use std::fs;
use std::path::{Path, PathBuf};
use tool::home::Home;
use tool::session::Session;
use tool_wasm::home::Linked;

/// The file of each loop with its title, which is the first line.
fn files() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plants/loops");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let title = |path: &PathBuf| fs::read_to_string(path).unwrap().lines().next().unwrap()[2..].to_string();
    files.into_iter().map(|path| (title(&path), path)).collect()
}

#[test]
fn each_known_loop_runs_as_its_file() {
    let home = Linked::new();
    let fmus = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for entry in home.entries() {
        fs::write(fmus.join(format!("{}.fmu", entry.name)), "").unwrap();
    }
    let (known, files) = (home.known_loops(), files());
    assert_eq!(known.len(), files.len());
    for (title, path) in files {
        let mut system = file::read(&path, Some(fmus), |_, _| unreachable!("it has no parameter file")).unwrap();
        // What happens later in the file is up to the user in the tool.
        system.settings.retain(|setting| setting.time.is_none());
        let fmu = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
        let members = || system.members.iter().map(|member| (fmu(&member.path), &member.name));
        let descriptions: Vec<_> = members().map(|(fmu, _)| home.description(&fmu).unwrap()).collect();
        let plan = Plan::new(&system, &descriptions.iter().map(|one| &**one).collect::<Vec<_>>()).unwrap();
        let mut components: Vec<Box<dyn Component>> =
            members().map(|(fmu, name)| home.instantiate(&fmu, name).unwrap()).collect();
        let recorded = master::run(&plan, &mut components, |_| ()).unwrap();

        let mut session = Session::default();
        let loop_of_title = known.iter().find(|known| known.title == title);
        session.start(&home, loop_of_title.unwrap_or_else(|| panic!("{title} is not known")).setup.clone()).unwrap();
        // The last row is that of the end, before which the last call is made. The trace holds the last calls one by one.
        let calls = recorded.times.len() - 1;
        session.run(calls).unwrap();
        let record = session.record(None).unwrap();
        for (place, column) in recorded.columns.iter().enumerate() {
            let own = record.column(&column.name).unwrap();
            for (call, value) in recorded.column(place).enumerate().take(calls).skip(record.trace().exact().start) {
                let shown = record.trace().get(own, call);
                let name = &column.name;
                assert_eq!(shown.to_bits(), value.to_bits(), "{title}: {name} in call {call}: {shown} and {value}");
            }
        }
    }
}
