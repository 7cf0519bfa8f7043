//! Recordings through the blocks that are linked in.

use engine::home::Home;
use engine::message::{Member, Values};
use engine::replay::{Replayed, Request, replay};
use engine::system::Value;
use engine_wasm::home::Linked;
use std::path::Path;

fn member(fmu: &str, values: &[(&str, f64)]) -> Member {
    let value = |(name, value): &(&str, f64)| (name.to_string(), Value::Number(*value));
    Member { name: "TIC101".into(), fmu: fmu.into(), values: values.iter().map(value).collect() }
}

fn request(controller: Member, text: String) -> Request {
    Request { controller, text, columns: Vec::new(), tolerance: None, try_suspects: true }
}

fn run(request: &Request) -> Replayed {
    replay(&Linked::new(), request).unwrap_or_else(|error| panic!("{error:#}"))
}

#[test]
fn the_measured_recordings_are_equal_from_the_first_call_on_bit_for_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/traces");
    let mut count = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_none_or(|extension| extension != "csv") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with('#')).count() - 1;
        let replayed = run(&request(member(&name[..6], &[]), text));
        assert!(replayed.verdict.contains("equal from the first call on, bit for bit"), "{name}: {}", replayed.verdict);
        assert_eq!(replayed.calls, rows, "{name}");
        assert!(replayed.outputs.len() >= 3 && replayed.outputs.iter().all(|of| of.first.is_none()), "{name}");
        count += 1;
    }
    assert!(count > 20);
}
