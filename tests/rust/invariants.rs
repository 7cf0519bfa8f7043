//! The invariants in docs/architecture.md, checked by reading the sources. Comments and strings count as code does
//! (except for the word unsafe): what a file must not know it does not mention either.
//!
//! Each finding is one line, `file:line contains "what"`; below the findings follows what to do.

#![allow(clippy::unwrap_used)]

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The product; `tests` and `examples` use it.
const PRODUCT: &[&str] = &[
    "blocks",
    "control",
    "draw",
    "fmu",
    "host",
    "laws",
    "manifest",
    "modeldescription",
    "parameters",
    "plants",
    "plcfmu",
    "run",
    "scl",
    "study",
    "tool",
    "xtask",
];

const MOST_LINES_OF_A_FILE: usize = 900;
const MOST_LINES_OF_A_FUNCTION: usize = 150;

/// This file says what must not occur elsewhere.
const THIS_FILE: &str = "tests/rust/invariants.rs";

#[test]
fn blocks_know_nothing_of_fmi_xml_files_or_logging() {
    let foreign = ["fmi", "xml", "std::fs", "std::io", "std::net", "std::env", "println!", "dbg!", "log::", "tracing"];
    assert_none(
        &find(&source_files("blocks/src"), |line| first_of(&foreign, &line.to_lowercase())),
        "any Rust program can use a block: what belongs to FMUs goes to fmu/, XML to modeldescription/",
    );
}

#[test]
fn crates_depend_on_each_other_one_way() {
    let metadata =
        MetadataCommand::new().current_dir(root()).no_deps().exec().unwrap_or_else(|error| panic!("{error}"));
    let packages = metadata.workspace_packages();
    let folder = |manifest: &Path| {
        manifest.parent().unwrap().strip_prefix(root()).unwrap().display().to_string().replace('\\', "/")
    };
    let folders: BTreeMap<&str, String> =
        packages.iter().map(|package| (package.name.as_str(), folder(package.manifest_path.as_std_path()))).collect();
    let below = rooms_below();
    let mut findings = Vec::new();
    for package in &packages {
        let folder = &folders[package.name.as_str()];
        // The page's program links everything, and nothing depends on it or on a test.
        if folder == "tool/wasm" || folder.starts_with("tests") {
            continue;
        }
        let parents = Path::new(folder).ancestors();
        let allowed = parents.filter_map(|room| below.get(room.to_str()?)).next().cloned().unwrap_or_default();
        for dependency in &package.dependencies {
            let is_test = dependency.kind == DependencyKind::Development;
            let dependency = dependency.name.as_str();
            let is_alone = folder == "blocks" || folder == "plants" && !["blocks", "libm"].contains(&dependency);
            let is_itself = dependency == package.name.as_str();
            let is_allowed = |room: &String| allowed.contains(room) || is_test && room == "tests/doubles";
            if is_alone || !is_itself && folders.get(dependency).is_some_and(|room| !is_allowed(room)) {
                findings.push(format!("{folder}/Cargo.toml depends on {dependency}"));
            }
        }
    }
    assert_none(&findings, "dependencies run as the arrows of docs/architecture.md, and blocks has none at all");
}

/// What each room may depend on by the arrows of docs/architecture.md, directly or through others.
fn rooms_below() -> BTreeMap<String, BTreeSet<String>> {
    let page = read("docs/architecture.md");
    let arrows = page.split("## Arrows").nth(1).and_then(|text| text.split("```").nth(1)).expect("there are arrows");
    let mut below: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in arrows.lines().filter(|line| line.contains("<-")) {
        let groups: Vec<Vec<&str>> = line.split("<-").map(|group| group.split(',').map(str::trim).collect()).collect();
        for pair in groups.windows(2) {
            for room in &pair[1] {
                below.entry((*room).into()).or_default().extend(pair[0].iter().map(ToString::to_string));
            }
        }
    }
    for _ in 0..below.len() {
        let direct = below.clone();
        for rooms in below.values_mut() {
            let further: Vec<String> = rooms.iter().filter_map(|room| direct.get(room)).flatten().cloned().collect();
            rooms.extend(further);
        }
    }
    for (room, others) in &below {
        assert!(!others.contains(room), "the arrows of docs/architecture.md lead from {room} back to it");
    }
    below
}

#[test]
fn cargo_xtask_and_cargo_test_compile_the_same() {
    let tested = compiled(&["--workspace", "--edges=normal,build,dev"]);
    let findings: Vec<_> =
        compiled(&["--package=xtask", "--edges=normal,build"]).difference(&tested).cloned().collect();
    assert_none(
        &findings,
        "tests compile this with other features, and all that depends on it twice: name the features in xtask/Cargo.toml",
    );
}

/// The packages that cargo compiles, each with its features.
fn compiled(selection: &[&str]) -> BTreeSet<String> {
    let mut tree = Command::new(env!("CARGO"));
    tree.args(["tree", "--offline", "--prefix=none", "--format={p} {f}"]).args(selection).current_dir(root());
    let output = tree.output().unwrap_or_else(|error| panic!("{error}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    text.lines().map(|line| line.trim_end_matches("(*)").trim().to_string()).collect()
}

#[test]
fn no_code_but_that_of_the_blocks_names_a_block() {
    let names: BTreeSet<String> =
        declared("blocks").into_iter().flat_map(|(block, name)| [block, name.to_lowercase(), name]).collect();
    let mut files = Vec::new();
    for folder in [
        "control/src",
        "draw/src",
        "fmu/src",
        "host/src",
        "laws/src",
        "modeldescription",
        "parameters",
        "plcfmu",
        "run/src",
        "scl/src",
        "study/src",
        "tool/src",
        "xtask",
    ] {
        // The Python package is documented with blocks.
        files.extend(source_files(folder).into_iter().filter(|file| !file.starts_with("plcfmu/python/")));
    }
    assert_none(
        &find(&files, |line| words(line).find(|word| names.contains(*word)).map(str::to_string)),
        "all but blocks works for any block: say it without a block's name, PUMP for example",
    );
}

#[test]
fn only_the_code_for_fmi_2_0_names_fmi2() {
    let allowed = [
        "fmu/src/v2/",
        "modeldescription/src/v2/",
        "modeldescription/tests/",
        // The host: of libraries, in Python, and of what the tool runs without one.
        "host/src/",
        "plcfmu/python/",
        "tool/src/linked.rs",
        // They choose a version.
        "fmu/src/lib.rs",
        "modeldescription/src/lib.rs",
        "modeldescription/src/model_description.rs",
    ];
    let is_named = |line: &str| words(line).any(|word| word == "v2") || line.to_lowercase().contains("fmi2");
    assert_none(
        &find_before_tests(&outside(&allowed, &rust_and_python(product_files())), |line| {
            is_named(line).then(|| line.trim().to_string())
        }),
        "what holds for FMI 2.0 only goes to fmu/src/v2, modeldescription/src/v2 or host; what an FMU is, whatever the version, \
         is a modeldescription::Description",
    );
}

#[test]
fn the_core_of_fmu_knows_no_fmi() {
    let is_core = |file: &String| file.matches('/').count() == 2 && file != "fmu/src/lib.rs";
    let core: Vec<String> = source_files("fmu/src").into_iter().filter(is_core).collect();
    assert_none(
        &find_before_tests(&core, |line| first_of(&["fmi", "v2"], &line.to_lowercase())),
        "the core does what a PLC does and what any host may ask of it, and knows no FMI version: move it to fmu/src/v2, which \
         uses the core",
    );
}

#[test]
fn only_the_client_of_a_plc_and_the_server_of_the_tool_use_the_network() {
    let allowed =
        ["plcfmu/src/plc.rs", "plcfmu/src/plc/", "plcfmu/src/tool/server.rs", "plcfmu/src/tool/connections.rs"];
    assert_none(
        &find(&outside(&allowed, &product_files()), |line| {
            first_of(&["std::net", "tokio::net", "TcpStream", "UdpSocket"], line)
        }),
        "an FMU and the commands work without a network; what reads a PLC goes to plcfmu/src/plc.rs, what a page asks of this \
         machine to plcfmu/src/tool/server.rs",
    );
}

#[test]
fn what_computes_opens_no_files_and_reads_no_clock() {
    let foreign = ["std::fs", "std::net", "std::env", "std::process", "std::thread", "Instant::now", "SystemTime"];
    let rooms = ["control/src", "draw/src", "laws/src", "scl/src", "tool/src"];
    let files: Vec<String> = rooms.iter().flat_map(|room| source_files(room)).collect();
    let files = files.into_iter().filter(|file| !file.ends_with("tests.rs") && !file.contains("/tests/"));
    assert_none(
        &find_before_tests(&files.collect::<Vec<_>>(), |line| first_of(&foreign, line)),
        "take the content and give the result: files, sockets, processes and clocks belong to plcfmu, host and run/src/file.rs",
    );
}

#[test]
fn no_message_of_the_page_names_an_option_of_the_command() {
    let rooms = [
        "blocks",
        "control",
        "draw",
        "fmu",
        "manifest",
        "modeldescription",
        "parameters",
        "plants",
        "run",
        "scl",
        "tool",
    ];
    let files: Vec<String> = rooms.iter().flat_map(|room| source_files(&format!("{room}/src"))).collect();
    // Words of the command, reading of files, and the source of a proof.
    let commands = ["parameters/src/problem.rs", "run/src/file.rs", "scl/src/prove/"];
    let files =
        outside(&commands, &files).into_iter().filter(|file| file.ends_with(".rs") && !file.ends_with("tests.rs"));
    let files: Vec<String> = files.chain(source_files("fmu/program/src")).collect();
    let option = |line: &str| {
        let code = if line.trim_start().starts_with("//") { "" } else { line };
        let words = code.split(|c: char| !c.is_ascii_alphanumeric() && c != '-');
        let is_option = |word: &&str| word.starts_with("--") && word[2..].starts_with(|c: char| c.is_ascii_lowercase());
        words.filter(is_option).map(str::to_string).next()
    };
    assert_none(
        &find_before_tests(&files, option),
        "say what is missing in words that hold in the command and on the page, or make it a Remedy, which each words for itself",
    );
}

/// How unsafe code begins, and what allows it.
const UNSAFE: [&str; 7] =
    ["unsafe {", "unsafe fn", "unsafe extern", "unsafe impl", "unsafe trait", "unsafe(", "allow(unsafe_code"];

#[test]
fn unsafe_code_stands_only_at_the_c_interface() {
    // In tool/wasm the names of the exported functions, no more.
    let allowed = ["fmu/src/pointers.rs", "host/src/", "tool/wasm/src/lib.rs", "tests/"];
    let is_table = |file: &String| file.starts_with("fmu/src/v") && file.ends_with("/ffi.rs");
    let rust: Vec<String> = all_files().into_iter().filter(|file| file.ends_with(".rs") && !is_table(file)).collect();
    assert_none(
        &find(&outside(&allowed, &rust), |line| first_of(&UNSAFE, line.split("//").next().unwrap_or(""))),
        "unsafe code goes to ffi.rs of the version on the side of the FMU, what every version needs to fmu/src/pointers.rs; to \
         host on the side of the host",
    );
}

/// What `fmu/libraries/plant.rs` has: the library of every plant, which finds it by the name of its package.
const LIBRARY_OF_PLANTS: &str = r#"fmu::export!(plants::Plant<{ plants::place(env!("CARGO_PKG_NAME")) }>);"#;

#[test]
fn the_library_of_an_fmu_is_one_line() {
    let mut findings = Vec::new();
    for file in source_files("fmu/libraries").iter().filter(|file| file.ends_with(".rs")) {
        let text = read(file);
        let code: Vec<&str> = text.lines().filter(|line| !line.is_empty() && !line.starts_with("//!")).collect();
        let exports = |line: &str| line.starts_with("fmu::export!(blocks::") && line.ends_with(");");
        let is_shared =
            [["fmu::export!(functions program::Program);"], [LIBRARY_OF_PLANTS]].iter().any(|of| code == of);
        if !is_shared && !matches!(code.as_slice(), [line] if exports(line)) {
            findings.push(format!("{file}:1 has other code than one line fmu::export!(blocks::NAME);"));
        }
    }
    assert_none(
        &findings,
        "a block's code goes to blocks/src, a plant's to plants/src, what all FMUs share to fmu/src",
    );
}

#[test]
fn every_block_and_every_plant_has_a_library() {
    let files = source_files("fmu/libraries");
    let sources: String = files.iter().filter(|file| file.ends_with(".rs")).map(|file| read(file)).collect();
    let has_line = |(block, _): &(String, String)| sources.contains(&format!("fmu::export!(blocks::{block});"));
    let has_package = |(_, name): &(String, String)| {
        let manifest = format!("fmu/libraries/{}/Cargo.toml", name.to_lowercase());
        files.contains(&manifest) && read(&manifest).contains("path = \"../plant.rs\"")
    };
    let blocks = declared("blocks").into_iter().filter(|block| !has_line(block));
    let missing = blocks.chain(declared("plants").into_iter().filter(|plant| !has_package(plant)));
    let findings: Vec<String> = missing.map(|(block, name)| format!("{block}, which makes {name}")).collect();
    assert_none(&findings, "add a crate to fmu/libraries, see docs/architecture.md");
}

#[test]
fn no_product_is_built_from_examples_or_tests() {
    let rust = |file: &&String| file.ends_with(".rs") && !file.contains("/tests");
    let product: Vec<String> = product_files().iter().filter(rust).cloned().collect();
    let reads = |line: &str| first_of(&["include!(", "include_str!(", "include_bytes!(", "CARGO_MANIFEST_DIR"], line);
    assert_none(
        &find(&product, |line| first_of(&["examples/", "tests/"], line).filter(|_| reads(line).is_some())),
        "the product stands without its examples and tests: move what it needs into a product crate",
    );
    let scripts: Vec<String> = product_files().into_iter().filter(|file| file.ends_with("build.rs")).collect();
    assert_none(
        &find(&scripts, |line| first_of(&["examples", "tests"], line)),
        "a build script reads neither examples nor tests",
    );
}

#[test]
fn exported_names_are_all_that_is_unsafe_in_the_tool_of_the_page() {
    let files = source_files("tool/wasm/src");
    let unsafe_lines = find(&files, |line| first_of(&["unsafe"], line.split("//").next().unwrap_or("")));
    let allowed = ["unsafe(no_mangle)", "allow(unsafe_code)"];
    let is_allowed = |finding: &&String| {
        let (file, rest) = finding.split_once(':').unwrap();
        let number: usize = rest.split(' ').next().unwrap().parse().unwrap();
        first_of(&allowed, read(file).lines().nth(number - 1).unwrap()).is_some()
    };
    let findings: Vec<String> = unsafe_lines.iter().filter(|finding| !is_allowed(finding)).cloned().collect();
    assert_none(&findings, "the page reads and writes the memory; Rust gives addresses only");
}

#[test]
fn files_and_functions_are_short() {
    let mut findings = Vec::new();
    for file in all_files().iter().filter(|file| file.ends_with(".rs") || file.ends_with(".py")) {
        let text = read(file);
        let lines: Vec<&str> = text.lines().collect();
        if lines.len() > MOST_LINES_OF_A_FILE {
            findings.push(format!("{file}:{} is beyond {MOST_LINES_OF_A_FILE} lines", lines.len()));
        }
        for (start, line) in lines.iter().enumerate().filter(|(_, line)| file.ends_with(".rs") && begins_function(line))
        {
            // rustfmt closes a function where it began.
            let close = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            let length = lines[start..].iter().position(|line| *line == close).map_or(0, |end| end + 1);
            if length > MOST_LINES_OF_A_FUNCTION && !line.ends_with(';') && !line.ends_with('}') {
                findings.push(format!("{file}:{} begins a function of {length} lines", start + 1));
            }
        }
    }
    assert_none(
        &findings,
        &format!("split it: files have at most {MOST_LINES_OF_A_FILE} lines, functions {MOST_LINES_OF_A_FUNCTION}"),
    );
}

#[test]
fn imports_form_no_circle_of_more_than_two_files() {
    let mut findings = Vec::new();
    for package in PRODUCT.iter().chain(&["fmu/program"]) {
        let imports = imports_within(package);
        for (file, imported) in &imports {
            // The shortest way back from a file that it imports, other than by a direct import.
            let circle = imported.iter().find_map(|first| way(&imports, first, file));
            findings
                .extend(circle.map(|circle| format!("{package}: {} imports {}", circle.join(" imports "), circle[0])));
        }
    }
    assert_none(&findings, "move what they share into a file below them; two files that know each other may stay");
}

#[test]
fn a_general_word_is_the_name_of_one_public_type_that_the_architecture_page_explains() {
    let general = ["Block", "Given", "Part", "Place", "Request", "Row", "Setting", "Table"];
    let page = read("docs/architecture.md");
    let explained = page.split("\n## ").find(|section| section.starts_with("Words\n")).expect("a section of words");
    let mut seen = BTreeSet::new();
    let twice_or_unexplained = |line: &str| {
        let kind = ["struct", "enum", "trait", "type"];
        let mut all = line.trim_start().strip_prefix("pub ")?.split_whitespace();
        let name = words(all.next().filter(|word| kind.contains(word)).and(all.next())?).next()?;
        // In a macro, `$Block` stands for any name.
        let name = Some(name).filter(|name| !line.contains(&format!("${name}")))?;
        let is_first = seen.insert(name.to_string());
        let is_fine = !general.contains(&name) || is_first && explained.contains(&format!("`{name}`"));
        (!is_fine).then(|| name.to_string())
    };
    let files: Vec<String> = product_files().into_iter().filter(|file| file.ends_with(".rs")).collect();
    assert_none(
        &find(&files, twice_or_unexplained),
        "a second type gets a word of its own, as CsvTable; the first one is explained under Words in docs/architecture.md",
    );
}

#[test]
fn a_function_is_named_after_what_it_does() {
    let is_product = |file: &String| file.ends_with(".rs") && !file.ends_with("/tests.rs") && !file.contains("/tests/");
    let files: Vec<String> = product_files().into_iter().filter(is_product).collect();
    assert_none(
        &find_before_tests(&files, |line| {
            words(line)
                .zip(words(line).skip(1))
                .any(|(word, name)| word == "fn" && name == "of")
                .then(|| "fn of".into())
        }),
        "a constructor is `new`, `from_...` or a verb; any other function has a verb or what it returns as its name",
    );
}

#[test]
fn modules_are_found_by_their_place_and_nothing_outside_the_repository_is_named() {
    let all: Vec<String> = all_files();
    assert_none(
        &find(&all, |line| first_of(&["#[path", "../shared"], line)),
        "use a crate instead of a #[path] attribute; and copy what is needed into the repository",
    );
}

#[test]
fn examples_are_made_with_what_any_user_has() {
    let in_examples: BTreeSet<String> = python_modules("examples");
    let ours: BTreeSet<String> = python_modules("tests").difference(&in_examples).cloned().collect();
    let examples: Vec<String> = source_files("examples").into_iter().filter(|file| file.ends_with(".py")).collect();
    assert_none(
        &find(&examples, |line| {
            let import = line.trim_start().strip_prefix("import ").or(line.trim_start().strip_prefix("from "))?;
            words(import).next().filter(|module| *module == "tests" || ours.contains(*module)).map(str::to_string)
        }),
        "an example imports packages that a user can install, and its neighbours in examples/; not the tests",
    );
}

#[test]
fn the_architecture_page_names_every_room_and_every_test_of_this_file() {
    let page = read("docs/architecture.md");
    let tests = read(THIS_FILE);
    let tests = tests.split("#[test]\nfn ").skip(1).map(|rest| format!("`{}`", rest.split('(').next().unwrap()));
    let rooms = PRODUCT.iter().map(|folder| format!("| `{folder}/` |"));
    let findings: Vec<String> = tests.chain(rooms).filter(|name| !page.contains(name.as_str())).collect();
    assert_none(&findings, "add it to docs/architecture.md, which is where a reader looks first");
}

// How the sources are read

/// Fails with all findings, and what to do about them.
#[track_caller]
fn assert_none(findings: &[String], remedy: &str) {
    assert!(findings.is_empty(), "\n{}\n{remedy}\n", findings.join("\n"));
}

/// `file:line contains "what"` for each line for which `what` returns something.
fn find(files: &[String], mut what: impl FnMut(&str) -> Option<String>) -> Vec<String> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| *file != THIS_FILE) {
        for (number, line) in read(file).lines().enumerate() {
            if let Some(what) = what(line) {
                findings.push(format!("{file}:{} contains {what:?}", number + 1));
            }
        }
    }
    findings
}

/// The same without the unit tests at the end of a file: they use what they test.
fn find_before_tests(files: &[String], what: impl Fn(&str) -> Option<String>) -> Vec<String> {
    let begins_tests = |file: &str| {
        let text = read(file);
        text.lines().position(|line| line.starts_with("mod tests {")).unwrap_or(usize::MAX)
    };
    let is_before = |finding: &String| {
        let (file, rest) = finding.split_once(':').unwrap();
        rest.split(' ').next().unwrap().parse::<usize>().unwrap() <= begins_tests(file)
    };
    find(files, what).into_iter().filter(is_before).collect()
}

fn rust_and_python(files: Vec<String>) -> Vec<String> {
    files.into_iter().filter(|file| file.ends_with(".rs") || file.ends_with(".py")).collect()
}

fn first_of(texts: &[&str], line: &str) -> Option<String> {
    texts.iter().find(|text| line.contains(**text)).map(ToString::to_string)
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// `fn` after nothing but `pub`, `const` and the like.
fn begins_function(line: &str) -> bool {
    let qualifies = |word: &str| word.starts_with("pub") || ["const", "unsafe", "extern", "\"C\""].contains(&word);
    line.split_once("fn ").is_some_and(|(before, _)| before.split_whitespace().all(qualifies))
}

/// What the blocks of a crate are called in Rust and by their vendors: `ContC` and `CONT_C`.
fn declared(from: &str) -> Vec<(String, String)> {
    let mut names = Vec::new();
    for file in outside(&["blocks/src/table/"], &source_files(&format!("{from}/src"))) {
        for line in read(&file).lines() {
            let block = line.trim().strip_prefix("pub struct ").and_then(|line| line.split_once(" as \""));
            names.extend(block.map(|(block, rest)| (block.to_string(), rest.split('"').next().unwrap().to_string())));
        }
    }
    assert!(names.len() >= 5, "{from}/src has no blocks, or they are declared in another way: {names:?}");
    names
}

/// Each module of a crate, such as `package::check`, with those that it imports.
fn imports_within(package: &str) -> BTreeMap<String, BTreeSet<String>> {
    let source = format!("{package}/src/");
    let module = |file: &str| {
        let path = file.strip_prefix(&source)?.strip_suffix(".rs")?;
        Some(path.strip_suffix("/mod").unwrap_or(path).replace('/', "::"))
            .filter(|name| !["lib", "main"].contains(&&**name))
    };
    let files = source_files(&source);
    let modules: BTreeMap<String, &String> = files.iter().filter_map(|file| Some((module(file)?, file))).collect();
    let of = |(name, file): (&String, &&String)| {
        let text = read(file);
        let code = text.split("\nmod tests {").next().unwrap().lines().map(|line| line.split("//").next().unwrap());
        let code = code.collect::<Vec<_>>().join("\n");
        let parent = name.rsplit_once("::").map_or("", |(parent, _)| parent);
        let imported = [("crate::", ""), ("super::", parent)].into_iter().flat_map(|(from, base)| {
            code.split(from).skip(1).flat_map(paths).map(move |path| format!("{base}::{path}"))
        });
        // The module that a path leads through: its longest beginning that is one.
        let owner = |path: String| {
            let path = path.trim_start_matches("::");
            let ends = path.match_indices("::").map(|(end, _)| end).chain([path.len()]).collect::<Vec<_>>();
            ends.into_iter().rev().map(|end| path[..end].to_string()).find(|name| modules.contains_key(name))
        };
        (name.clone(), imported.filter_map(owner).filter(|imported| imported != name).collect())
    };
    modules.iter().map(of).collect()
}

/// The paths with which a text begins: `a::B` of `a::B;`, `a::B` and `a::C` of `a::{B, C};`.
fn paths(text: &str) -> Vec<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(text.len());
    match text[end..].strip_prefix('{') {
        Some(rest) => {
            words(rest.split(['{', '}']).next().unwrap()).map(|word| format!("{}{word}", &text[..end])).collect()
        }
        None => vec![text[..end].to_string()],
    }
}

/// The shortest way from a module to another over a third.
fn way(imports: &BTreeMap<String, BTreeSet<String>>, from: &str, to: &str) -> Option<Vec<String>> {
    let mut ways = VecDeque::from([vec![from.to_string()]]);
    let mut seen = BTreeSet::from([from.to_string()]);
    while let Some(way) = ways.pop_front() {
        for next in &imports[way.last()?] {
            if next == to && way.len() > 1 {
                return Some([vec![to.to_string()], way].concat());
            }
            if next != to && seen.insert(next.clone()) {
                ways.push_back([way.as_slice(), std::slice::from_ref(next)].concat());
            }
        }
    }
    None
}

fn python_modules(folder: &str) -> BTreeSet<String> {
    let files = source_files(folder);
    let modules = files.iter().filter_map(|file| file.strip_prefix(folder)?.strip_prefix('/')?.strip_suffix(".py"));
    modules.filter(|module| !module.contains('/')).map(str::to_string).collect()
}

fn outside(folders: &[&str], files: &[String]) -> Vec<String> {
    files.iter().filter(|file| !folders.iter().any(|folder| file.starts_with(folder))).cloned().collect()
}

fn product_files() -> Vec<String> {
    PRODUCT.iter().flat_map(|folder| source_files(folder)).collect()
}

/// All text files of the repository that are written by hand.
fn all_files() -> Vec<String> {
    source_files("")
}

/// The text files below one folder, as paths from the root of the repository, with `/`.
fn source_files(folder: &str) -> Vec<String> {
    let mut files = Vec::new();
    collect(&root().join(folder), &mut files);
    assert!(!files.is_empty(), "{folder} has no source files: has it moved? Then {THIS_FILE} has to know where");
    files.sort();
    files
}

fn collect(folder: &Path, files: &mut Vec<String>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            // Not what is built or kept by tools: target, .git, __pycache__, node_modules, the fuzzer's corpus.
            if !matches!(&*name, "target" | "__pycache__" | "corpus" | "node_modules")
                && (!name.starts_with('.') || matches!(&*name, ".cargo" | ".ci"))
            {
                collect(&path, files);
            }
        } else if matches!(
            &*extension,
            "rs" | "py" | "toml" | "md" | "html" | "css" | "js" | "svg" | "txt" | "jinja" | "j2" | ""
        ) {
            files.push(path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/"));
        }
    }
}

fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}
