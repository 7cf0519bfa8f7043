//! The page of the parameter tool as one self-contained HTML file: `web/index.html` with everything that it refers to.
//!
//! Modules import each other as `tool/NAME.js`. The page contains them as one packed script, where each module is a
//! block after its imports: on a slow machine, a browser takes a second to load them one by one. `web/boot.js` turns
//! the script into a blob URL, so that the page also works from a file. A content security policy allows only that
//! script and the scripts it creates.

use anyhow::{Context, Result, bail, ensure};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use lzma_rust2::{EncodeMode, LzmaOptions, LzmaWriter, MfType};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::num::NonZeroU64;
use std::path::Path;

/// The files of `web`, as path and text.
pub type Sources = BTreeMap<String, String>;

/// The files with which this program was built.
const EMBEDDED: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/web.rs"));

/// The colours of curves, which the page shares with all charts.
const PALETTE: (&str, &str) = ("palette.css", draw::palette::STYLE);

/// The base in which packed data is written: the number of different characters in it.
const BASE: usize = 93;

/// The id of the element with the page's WebAssembly, which makes up most of the page's size.
const ENGINE: &str = "engine";

/// The number of bits of the preceding byte that predict the next one in [`compact`] data; `boot.js` uses the same
/// number.
const CONTEXT: u32 = 4;

/// The number of compressor passes over the data: more would gain less than 0.01 %.
const ITERATIONS: u64 = 5;

/// The location of the page's engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// In the page itself, as WebAssembly.
    Page,
    /// In the server that delivers the page.
    Server,
}

/// The contents of the page.
#[derive(Clone, Debug)]
pub struct Content<'a> {
    /// Where its engine is.
    pub home: Home,
    /// The contents of the elements `<script type="text/plain" id="...">` by id: `assets`, `engine` (WebAssembly). They
    /// are packed and written in base 93. Elements that are not listed stay empty.
    pub data: &'a [(&'a str, &'a [u8])],
}

/// The files of `web` with which this program was built.
pub fn embedded() -> Sources {
    EMBEDDED.iter().chain([&PALETTE]).map(|(path, text)| (path.to_string(), text.to_string())).collect()
}

/// The files of a folder `web`.
///
/// # Errors
/// One of them cannot be read.
pub fn read(folder: &Path) -> Result<Sources> {
    let mut sources = Sources::from([(PALETTE.0.to_string(), PALETTE.1.to_string())]);
    for part in ["", "src", "vendor"] {
        let folder = folder.join(part);
        for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_file() && is_source(&name) {
                let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
                sources.insert(if part.is_empty() { name } else { format!("{part}/{name}") }, text);
            }
        }
    }
    Ok(sources)
}

/// Whether a file is part of the page. `build.rs` uses the same rule.
fn is_source(name: &str) -> bool {
    [".html", ".css", ".js"].iter().any(|end| name.ends_with(end)) || name == "LICENSE"
}

/// Assembles the page.
///
/// # Errors
/// A file that the page refers to is missing, or cannot be embedded in HTML.
pub fn assemble(sources: &Sources, content: &Content) -> Result<String> {
    let html = source(sources, "index.html")?;
    let mut page = Page { html: html.clone(), scripts: Vec::new() };
    let mut styles = String::new();
    page.embed(r#"<link rel="stylesheet" href=""#, r#"">"#, |_, file| {
        styles += &style(sources, file)?;
        Ok(String::new())
    })?;
    page.embed(r#"<script type="module" async src=""#, r#""></script>"#, |scripts, file| {
        let text = without_comments(source(sources, file)?);
        ensure_inside("script", file, &text)?;
        let element = format!("<script type=\"module\" async>{text}</script>");
        scripts.push(text);
        Ok(element)
    })?;
    ensure!(!page.scripts.is_empty(), "index.html has no module script");
    let script = styled(&styles)? + &script(&modules(sources)?)?;
    for (id, bytes) in content.data.iter().chain([&("modules", script.as_bytes())]) {
        let empty = format!(r#"<script type="text/plain" id="{id}"></script>"#);
        let text = if *id == ENGINE { base93(&compact(bytes)?) } else { packed(bytes, content.home)? };
        let full = empty.replace("><", &format!(">{text}<"));
        page.replace(&empty, &full)?;
    }
    if content.home == Home::Server {
        let home = |home: &str| format!(r#"<meta name="plcfmu-home" content="{home}">"#);
        page.replace(&home("page"), &home("server"))?;
    }
    page.replace("</body>", &format!("{}</body>", licences(sources)?))?;
    let charset = r#"<meta charset="utf-8">"#;
    let policy = policy(&page.scripts, content.home);
    page.replace(charset, &format!("{charset}\n<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">"))?;
    Ok(page.html)
}

struct Page {
    html: String,
    /// The inline scripts of the page, for its policy.
    scripts: Vec<String>,
}

impl Page {
    /// Replaces each element that refers to a file, in the form `begin FILE end`, with the result of `element` for it.
    fn embed(
        &mut self,
        begin: &str,
        end: &str,
        mut element: impl FnMut(&mut Vec<String>, &str) -> Result<String>,
    ) -> Result<()> {
        let mut html = String::new();
        let mut rest = self.html.as_str();
        while let Some((before, after)) = rest.split_once(begin) {
            let (file, after) = after.split_once(end).with_context(|| format!("index.html: {begin} is not closed"))?;
            html.push_str(before);
            html.push_str(&element(&mut self.scripts, file)?);
            rest = after;
        }
        html.push_str(rest);
        self.html = html;
        Ok(())
    }

    /// Replaces text that occurs exactly once in the page.
    fn replace(&mut self, from: &str, to: &str) -> Result<()> {
        let count = self.html.matches(from).count();
        ensure!(count == 1, "index.html contains {from} {count} times: it must occur once");
        self.html = self.html.replacen(from, to, 1);
        Ok(())
    }
}

fn source<'a>(sources: &'a Sources, file: &str) -> Result<&'a String> {
    sources.get(file).with_context(|| format!("no file {file} for the page"))
}

/// A stylesheet without comments and without whitespace around separators.
fn style(sources: &Sources, file: &str) -> Result<String> {
    let text = without_comments(source(sources, file)?);
    let text = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n");
    // In selectors, whitespace before a colon is significant.
    let separators = [(" {", "{"), ("{ ", "{"), (" }", "}"), (": ", ":"), ("; ", ";"), (", ", ",")];
    Ok(separators.iter().fold(text, |text, (from, to)| text.replace(from, to)))
}

/// The statement that sets the page's style. Packing the style with the scripts shrinks it to a quarter of its size.
fn styled(style: &str) -> Result<String> {
    let text = serde_json::to_string(style)?;
    Ok(format!("document.head.append(Object.assign(document.createElement(\"style\"), {{ textContent: {text} }}));\n"))
}

fn ensure_inside(name: &str, file: &str, text: &str) -> Result<()> {
    if text.to_ascii_lowercase().contains(&format!("</{name}")) || text.contains("<!--") {
        bail!("{file} contains </{name} or <!--, which ends an HTML element");
    }
    Ok(())
}

/// Names and texts of all modules, each after those it imports: third-party modules, then the page's own, with
/// `tool/main.js` last.
fn modules(sources: &Sources) -> Result<Vec<(String, String)>> {
    let vendor = sources.iter().filter(|(path, _)| path.starts_with("vendor/") && path.ends_with(".js"));
    // A third-party script defines a variable that would be global in a browser, but is local to a module: it is made
    // global again.
    let global =
        |path: &str| path.rsplit('/').next().and_then(|file| file.split('.').next()).unwrap_or_default().to_string();
    let script = |(path, text): (&String, &String)| {
        let name = global(path);
        (path.clone(), format!("{text}\nglobalThis.{name} = {name};\n"))
    };
    let mut modules: Vec<_> = vendor.map(script).collect();
    let first = modules.len();
    let mut rest: Vec<(String, &String)> = sources
        .iter()
        .filter_map(|(path, text)| Some((format!("tool/{}", path.strip_prefix("src/")?), text)))
        .collect();
    while !rest.is_empty() {
        let is_waiting = |text: &str| imports(text).any(|name| rest.iter().any(|(other, _)| other == name));
        let (waiting, ready): (Vec<_>, Vec<_>) = rest.iter().cloned().partition(|(_, text)| is_waiting(text));
        if ready.is_empty() {
            let names: Vec<_> = waiting.iter().map(|(name, _)| name.as_str()).collect();
            bail!("page modules have circular imports: {}", names.join(", "));
        }
        for (name, text) in ready {
            if let Some(missing) = imports(text).find(|of| !modules.iter().any(|(name, _)| name == of)) {
                bail!("{name} imports {missing}, which does not exist");
            }
            modules.push((name.clone(), without_comments(text)));
        }
        rest = waiting;
    }
    ensure!(modules.len() > first, "the page has no modules");
    Ok(modules)
}

/// The modules as one script: each module stores its exports in `modules`, where the others find them.
fn script(modules: &[(String, String)]) -> Result<String> {
    // For tests and for the console: `await moduleOf("tool/store.js")`.
    let mut script = "const modules = {};\nglobalThis.moduleOf = async (name) => modules[name];\n".to_string();
    for (name, text) in modules {
        let (mut code, mut exported) = (String::new(), Vec::new());
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if line.starts_with("import ") {
                let mut import = line.to_string();
                while !import.ends_with(';') {
                    import += lines.next().with_context(|| format!("{name}: {line} is not terminated"))?;
                }
                code +=
                    &taken(&import).with_context(|| format!("{name}: {import} is not import {{ A }} from \"B\";"))?;
            } else if let Some(declaration) = line.strip_prefix("export ") {
                let is_declared = |kind: &&str| declaration.starts_with(kind);
                let kind = ["async function ", "function ", "class ", "const "].into_iter().find(is_declared);
                let kind = kind.with_context(|| format!("{name}: {line}: export functions, classes and constants"))?;
                let is_of_name = |sign: char| sign.is_alphanumeric() || sign == '_' || sign == '$';
                let rest = &declaration[kind.len()..];
                exported.push(&rest[..rest.find(|sign| !is_of_name(sign)).unwrap_or(rest.len())]);
                code += declaration;
            } else {
                code += line;
            }
            code.push('\n');
        }
        script += &match name.starts_with("vendor/") {
            true => code,
            false => format!("{{\n{code}modules[\"{name}\"] = {{ {} }};\n}}\n", exported.join(", ")),
        };
    }
    Ok(script)
}

/// The statement that reads the names of an import from `modules`.
fn taken(import: &str) -> Option<String> {
    let (names, from) = import.strip_prefix("import ")?.strip_suffix(';')?.rsplit_once(" from ")?;
    Some(format!("const {} = modules[{from}];", names.replace(" as ", ": ")))
}

/// The names of the page's modules that a module imports. The formatter leaves the name of each on a separate line.
fn imports(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let from = line.strip_prefix("import ").or_else(|| line.split_once(" from ").map(|(_, from)| from))?;
        let quoted = from.rsplit_once(" from ").map_or(from, |(_, from)| from);
        quoted.strip_prefix("\"tool/")?.strip_suffix("\";").map(|_| &quoted[1..quoted.len() - 2])
    })
}

/// A module without comment-only lines and indentation. Template literals are left unchanged.
fn without_comments(text: &str) -> String {
    let (mut code, mut is_comment, mut is_quoted) = (String::new(), false, false);
    for line in text.lines() {
        let begin = line.trim_start();
        // Code may follow: `/** @type {number} */ (x)`.
        is_comment |=
            !is_quoted && begin.starts_with("/*") && begin.find("*/").is_none_or(|end| end + 2 == begin.len());
        let is_left_out = is_comment || !is_quoted && begin.starts_with("//");
        is_comment &= !line.trim_end().ends_with("*/");
        if !is_left_out {
            let text = if is_quoted { line } else { begin };
            if is_quoted || !text.is_empty() {
                code.push_str(text);
                code.push('\n');
            }
            is_quoted ^= line.matches('`').count() % 2 == 1;
        }
    }
    code
}

/// The licences of the page's components, for readers of its source.
fn licences(sources: &Sources) -> Result<String> {
    let text = format!(
        "plcfmu: MIT OR Apache-2.0\n\n{}\nuPlot: MIT\n\n{}",
        include_str!("../../../LICENSE-MIT"),
        source(sources, "vendor/LICENSE")?
    );
    Ok(format!("<script type=\"text/plain\" id=\"licences\">\n{text}</script>\n"))
}

/// Packs bytes with gzip and encodes them in base 93, which takes 23 % more characters than there are bytes. The same
/// bytes always yield the same text.
///
/// # Errors
/// None in practice: the output is written to memory.
pub fn packed(bytes: &[u8], home: Home) -> Result<String> {
    let mut gzip = Vec::new();
    match home {
        // The page is packed once, but every user downloads every byte.
        Home::Page => {
            let iteration_count = NonZeroU64::new(ITERATIONS).context("at least one")?;
            let options = zopfli::Options { iteration_count, ..zopfli::Options::default() };
            zopfli::compress(options, zopfli::Format::Gzip, bytes, &mut gzip)?;
        }
        Home::Server => {
            let mut encoder = GzEncoder::new(&mut gzip, Compression::best());
            encoder.write_all(bytes)?;
            encoder.finish()?;
        }
    }
    Ok(base93(&gzip))
}

/// Packs bytes with LZMA, which is a quarter smaller than gzip: the length in 4 bytes, little-endian, then the stream
/// without a header. Browsers can unpack gzip natively; for LZMA, the page runs a script in a worker.
///
/// # Errors
/// The data is 4 GiB or longer.
fn compact(bytes: &[u8]) -> Result<Vec<u8>> {
    let length = u32::try_from(bytes.len()).context("the engine is too large")?;
    let options = LzmaOptions {
        dict_size: length.max(1 << 16),
        lc: CONTEXT,
        lp: 0,
        pb: 0,
        mode: EncodeMode::Normal,
        nice_len: LzmaOptions::NICE_LEN_MAX,
        mf: MfType::Bt4,
        depth_limit: 512,
        preset_dict: None,
    };
    let mut writer = LzmaWriter::new_no_header(length.to_le_bytes().to_vec(), &options, false)?;
    writer.write_all(bytes)?;
    Ok(writer.finish()?)
}

/// Encodes 13 bits as two digits, or 14 bits where they fit into 93 squared; low digits and low bits come first. The
/// digits are the characters from ! to ~ except <, which has a meaning in HTML scripts.
fn base93(bytes: &[u8]) -> String {
    let digits: Vec<char> = ('!'..='~').filter(|digit| *digit != '<').collect();
    let mut text = String::with_capacity(bytes.len() / 13 * 16 + 16);
    let (mut bits, mut count) = (0_usize, 0);
    let mut put = |value: usize, is_long: bool| {
        text.push(digits[value % BASE]);
        if is_long {
            text.push(digits[value / BASE]);
        }
    };
    for byte in bytes {
        bits |= usize::from(*byte) << count;
        count += 8;
        if count > 13 {
            let size = if bits & 0x1fff < BASE * BASE - 0x2000 { 14 } else { 13 };
            put(bits & ((1 << size) - 1), true);
            bits >>= size;
            count -= size;
        }
    }
    if count > 0 {
        put(bits, count > 7 || bits >= BASE);
    }
    text
}

/// The content security policy: allows these scripts, the scripts they create, and WebAssembly; nothing from elsewhere.
fn policy(scripts: &[String], home: Home) -> String {
    let hash = |script: &String| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script)));
    let hashes: Vec<String> = scripts.iter().map(hash).collect();
    let connect = if home == Home::Server { "'self'" } else { "'none'" };
    format!(
        "default-src 'none'; script-src {} blob: 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:; \
         connect-src {connect}; base-uri 'none'; form-action 'none'",
        hashes.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources() -> Sources {
        let html = r#"<!DOCTYPE html><head><meta charset="utf-8"><meta name="plcfmu-home" content="page">
            <link rel="stylesheet" href="style.css"></head><body><script type="text/plain" id="assets"></script>
            <script type="text/plain" id="engine"></script><script type="text/plain" id="modules"></script>
            <script type="module" async src="boot.js"></script></body>"#;
        [
            ("index.html", html),
            ("style.css", "/* Ink */\np :hover, i { color: red; top: 0 }\n"),
            ("vendor/plot.js", "var plot = 1;"),
            ("vendor/LICENSE", "As is."),
            ("boot.js", "begin();\n"),
            (
                "src/main.js",
                "import { a as one } from \"tool/é.js\";\nimport {\n  b,\n} from \"tool/b.js\";\nb(one);\n",
            ),
            ("src/b.js", "import { a } from \"tool/é.js\";\n\nexport function b() {\n  return a;\n}\n"),
            ("src/é.js", "export const a = 1;\n"),
        ]
        .map(|(path, text)| (path.to_string(), text.to_string()))
        .into()
    }

    fn page(home: Home, data: &[(&str, &[u8])]) -> Result<String> {
        assemble(&sources(), &Content { home, data })
    }

    #[test]
    fn the_page_has_all_files_and_names_none() {
        let page = page(Home::Page, &[("assets", b"{}")]).unwrap();
        assert!(!page.contains("stylesheet") && !page.contains("color:red"), "{page}");
        let style = styled(&style(&sources(), "style.css").unwrap()).unwrap();
        assert!(style.contains(r#"{ textContent: "p :hover,i{color:red;top:0}" }"#), "{style}");
        assert!(
            page.contains("<script type=\"module\" async>begin();\n</script>")
                && page.contains(&format!("id=\"modules\">{}", &base93(&[0x1f, 0x8b, 8, 0])[..4]))
        );
        assert!(page.contains("As is.") && page.contains("Permission is hereby granted"));
        assert!(!page.contains(" src=") && !page.contains(" href="), "{page}");
        assert!(
            page.contains(&format!("id=\"assets\">{}", &base93(&[0x1f, 0x8b, 8, 0])[..4]))
                && page.contains(r#"id="engine"></script>"#)
        );
    }

    #[test]
    fn the_policy_allows_what_is_written_in_the_page_and_nothing_else() {
        let page = page(Home::Page, &[]).unwrap();
        let policy = page.split("Content-Security-Policy\" content=\"").nth(1).unwrap().split('"').next().unwrap();
        assert!(policy.contains(&STANDARD.encode(Sha256::digest("begin();\n"))));
        assert!(policy.starts_with("default-src 'none'; ") && policy.contains("connect-src 'none'"));
        assert_eq!((policy.matches("sha256-").count(), policy.contains("data:; connect")), (1, false), "{policy}");
    }

    #[test]
    fn each_module_comes_after_those_that_it_imports() {
        let modules = modules(&sources()).unwrap();
        let names: Vec<&str> = modules.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["vendor/plot.js", "tool/é.js", "tool/b.js", "tool/main.js"]);
        assert_eq!(modules[0].1, "var plot = 1;\nglobalThis.plot = plot;\n");
        let refusal = |text: &str| {
            let mut sources = sources();
            sources.insert("src/é.js".into(), text.into());
            super::modules(&sources).unwrap_err().to_string()
        };
        let circle = "page modules have circular imports: tool/b.js, tool/main.js, tool/é.js";
        assert_eq!(refusal("import { b } from \"tool/b.js\";\n"), circle);
        assert_eq!(refusal("import \"tool/c.js\";\n"), "tool/é.js imports tool/c.js, which does not exist");
    }

    #[test]
    fn modules_are_one_script_in_which_each_is_a_block() {
        let script = script(&modules(&sources()).unwrap()).unwrap();
        let blocks = [
            "const modules = {};\nglobalThis.moduleOf = async (name) => modules[name];\n",
            "var plot = 1;\nglobalThis.plot = plot;\n",
            "{\nconst a = 1;\nmodules[\"tool/é.js\"] = { a };\n}\n",
            "{\nconst { a } = modules[\"tool/é.js\"];\nfunction b() {\nreturn a;\n}\nmodules[\"tool/b.js\"] = { b };\n}\n",
            "{\nconst { a: one } = modules[\"tool/é.js\"];\nconst {b,} = modules[\"tool/b.js\"];\nb(one);\n",
            "modules[\"tool/main.js\"] = {  };\n}\n",
        ];
        assert_eq!(script, blocks.concat());
        let refusal = |text: &str| super::script(&[("tool/a.js".into(), text.into())]).unwrap_err().to_string();
        assert_eq!(refusal("export let a;\n"), "tool/a.js: export let a;: export functions, classes and constants");
        assert_eq!(
            refusal("import \"tool/b.js\";\n"),
            "tool/a.js: import \"tool/b.js\"; is not import { A } from \"B\";"
        );
    }

    #[test]
    fn thirteen_bits_are_two_digits_and_fourteen_where_there_is_room() {
        let digits: Vec<char> = ('!'..='~').filter(|digit| *digit != '<').collect();
        assert_eq!(digits.len(), BASE);
        let text = |values: &[usize]| values.iter().map(|value| digits[*value]).collect::<String>();
        // 13 bits of ones are 8191 = 88 93 + 7, the three that are left 7.
        assert_eq!(base93(&[0xff, 0xff]), text(&[7, 88, 7]));
        // 456, the last that has room, with a 1 as its 14th bit: 8648 = 92 93 + 92; then two bits.
        assert_eq!(base93(&[0xc8, 0x21]), text(&[92, 92, 0]));
        assert_eq!((base93(&[]), base93(&[92]), base93(&[93])), (String::new(), text(&[92, 0]), text(&[0, 1])));
    }

    #[test]
    fn the_engine_is_packed_with_its_length_first_and_gets_smaller() {
        let code: Vec<u8> = (0..60_000_u32).map(|at| ((at * at) >> 7) as u8).collect();
        let packed = compact(&code).unwrap();
        assert_eq!(packed[..5], [0x60, 0xea, 0, 0, 0]);
        assert!(packed.len() < code.len() / 2, "{}", packed.len());
    }

    #[test]
    fn comments_of_modules_stay_out_of_the_page() {
        let module = "/**\n * About a.\n */\nconst a = 1; // one\n  // more\n  /* of it */\n/** @type {B} */ (c);\nconst b = `\n// ${a}\n/*\n`;\n";
        assert_eq!(
            without_comments(module),
            "const a = 1; // one\n/** @type {B} */ (c);\nconst b = `\n// ${a}\n/*\n`;\n"
        );
    }

    #[test]
    fn the_page_of_a_server_asks_the_server() {
        let page = page(Home::Server, &[]).unwrap();
        assert!(page.contains(r#"<meta name="plcfmu-home" content="server">"#) && page.contains("connect-src 'self'"));
    }

    #[test]
    fn a_file_that_is_missing_or_would_end_its_element_is_named() {
        let refusal = |change: &dyn Fn(&mut Sources)| {
            let mut sources = sources();
            change(&mut sources);
            assemble(&sources, &Content { home: Home::Page, data: &[] }).unwrap_err().to_string()
        };
        assert_eq!(refusal(&|of| drop(of.remove("style.css"))), "no file style.css for the page");
        let ends = refusal(&|of| drop(of.insert("boot.js".into(), "'</SCRIPT>'".into())));
        assert_eq!(ends, "boot.js contains </script or <!--, which ends an HTML element");
        let other = |html: &str| refusal(&|of| drop(of.insert("index.html".into(), html.into())));
        assert!(other("<body></body>").contains("index.html has no module script"));
    }

    #[test]
    fn the_sources_of_this_program_make_a_page() {
        let page = assemble(&embedded(), &Content { home: Home::Server, data: &[("assets", b"{}")] }).unwrap();
        assert!(page.starts_with("<!DOCTYPE html>"));
    }
}
