//! Converts the blocks of a text to loops.

use super::instance::{Instance, find, fit, lost_name};
use super::parser::{DataBlock, FunctionBlock, Item, Name, items};
use super::values::{Assignment, SyntaxErrors, assignments};
use crate::block::BlockType;
use crate::loops::Loop;
use crate::problem::{Problems, Remedy, nearest, quoted};
use crate::reading::{Options, Reading};
use crate::report::{MOST_LOOPS, Report, elements};
use crate::source::Source;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// The maximum nesting depth of function blocks. An S7-300 allows eight, an S7-1500 more.
const DEPTH: usize = 32;

/// The number of member names that is enough to recognize a block.
const ENOUGH_NAMES: usize = 3;

/// Reads the loops of a source text. [`Options::block`] applies to data blocks of unknown types if they have its
/// members.
///
/// # Errors
/// The errors in the text; of more than about 50, only the first ones and the number of the others.
pub fn read(source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading, Problems> {
    let mut report = Report::new(source, options);
    let Ok(chosen) = report.chosen(blocks, options) else { return report.finish(Vec::new()) };
    let items = items(&source.text, &mut report);
    let functions = functions(&items, blocks);
    let mut reader = Reader {
        text: &source.text,
        blocks,
        chosen,
        functions: &functions,
        report,
        found: Vec::new(),
        skipped: Skipped::default(),
        unknown: Vec::new(),
        refused: HashSet::new(),
        seven_digits: None,
    };
    // After a syntax error, the end of a block is uncertain.
    let is_broken = reader.report.is_wrong();
    for item in &items {
        if reader.found.len() > MOST_LOOPS {
            let message = format!("the file has more than {MOST_LOOPS} loops");
            reader.report.wrong_file(message, Some("split it".into()));
            break;
        }
        match item {
            Item::DataBlock(block) => reader.data_block(block),
            Item::FunctionBlock(function) if functions[&key(&function.name)].leads.is_empty() => {
                reader.skipped.add(function.name.text.clone());
            }
            Item::FunctionBlock(_) => {}
            Item::Other(name) => reader.skipped.add(name.text.clone()),
        }
    }
    reader.finish(is_broken)
}

/// A function block declared in the text.
struct Function<'a> {
    block: &'a FunctionBlock,
    /// The indices of members that are instances of known blocks, or of function blocks that contain some.
    leads: Vec<usize>,
    /// The names of all members, in upper case.
    names: HashSet<String>,
}

type Functions<'a> = HashMap<String, Function<'a>>;

fn key(name: &Name) -> String {
    name.text.to_uppercase()
}

fn known(blocks: &[Arc<BlockType>], name: &Name) -> Option<Arc<BlockType>> {
    blocks.iter().find(|block| block.is_called(&name.text)).cloned()
}

/// The function blocks of the text, by name.
fn functions<'a>(items: &'a [Item], blocks: &[Arc<BlockType>]) -> Functions<'a> {
    let mut functions = Functions::new();
    for item in items {
        if let Item::FunctionBlock(block) = item {
            let names = block.members.iter().map(|member| key(&member.name)).collect();
            functions.insert(key(&block.name), Function { block, leads: Vec::new(), names });
        }
    }
    // Each pass adds the function blocks that contain an instance of one found in the previous pass.
    let mut leading: HashSet<String> = HashSet::new();
    for _ in 0..DEPTH {
        let mut found = HashSet::new();
        for (name, function) in &mut functions {
            let members = function.block.members.iter().enumerate();
            let leads = members.filter_map(|(index, member)| {
                let kind = member.kind.as_ref()?;
                (known(blocks, kind).is_some() || leading.contains(&key(kind))).then_some(index)
            });
            function.leads = leads.collect();
            if !function.leads.is_empty() {
                found.insert(name.clone());
            }
        }
        if found == leading {
            break;
        }
        leading = found;
    }
    functions
}

/// The names of blocks that are not loops: the first ten, and the number of the others.
#[derive(Default)]
struct Skipped {
    first: Vec<String>,
    others: usize,
}

impl Skipped {
    fn add(&mut self, name: String) {
        const MOST: usize = 10;
        if self.first.len() < MOST {
            self.first.push(name.chars().filter(|c| !c.is_control()).take(60).collect());
        } else {
            self.others += 1;
        }
    }

    /// A sentence on the skipped blocks.
    fn sentence(&self) -> Option<String> {
        if self.first.is_empty() {
            return None;
        }
        let others = if self.others > 0 { format!(" and {} more", self.others) } else { String::new() };
        Some(format!("skipped {}{others}: not instances of known blocks", self.first.join(", ")))
    }
}

/// A loop that has been read.
struct Found {
    one: Loop,
    /// For a multi-instance, its name qualified by the names of the data block and the outer instances.
    qualified: Option<String>,
    span: Range<usize>,
}

struct Reader<'a> {
    text: &'a str,
    blocks: &'a [Arc<BlockType>],
    chosen: Option<Arc<BlockType>>,
    functions: &'a Functions<'a>,
    report: Report<'a>,
    found: Vec<Found>,
    skipped: Skipped,
    /// The first data blocks of unknown types: name and type.
    unknown: Vec<(String, Name)>,
    /// The byte positions of declarations already rejected, so that each is reported once.
    refused: HashSet<usize>,
    seven_digits: Option<Range<usize>>,
}

impl Reader<'_> {
    fn data_block(&mut self, db: &DataBlock) {
        let Some(kind) = &db.block else {
            self.skipped.add(db.name.text.clone());
            return;
        };
        let functions = self.functions;
        if let Some(block) = known(self.blocks, kind) {
            let values = assignments(self.text, db.body.clone());
            // A project may use the number of a known block, such as FB 41, for a block of its own: then no member
            // belongs to the known block.
            let is_number = !kind.text.eq_ignore_ascii_case(&block.name);
            if is_number && !values.0.is_empty() && values.0.iter().take(20).all(|value| is_strange(&block, value)) {
                self.skip(db, kind);
            } else {
                self.instance(db, block, values);
            }
        } else if let Some(function) = functions.get(&key(kind)) {
            self.multi_instance(db, function);
        } else {
            self.unknown(db, kind);
        }
    }

    /// Reads a data block that is an instance of a known block.
    fn instance(&mut self, db: &DataBlock, block: Arc<BlockType>, (values, errors): (Vec<Assignment>, SyntaxErrors)) {
        let before = self.report.count();
        self.wrong(errors);
        let name = &db.name;
        let mut instance = Instance::new(&name.text, block.clone());
        instance.one.title = db.title.clone();
        let is_lost = |name: &str| find(&block, name).is_none() && lost_name(name).is_some();
        if values.first().is_some_and(|first| first.path.len() == 1 && is_lost(&first.path[0])) {
            instance.assign_by_position(name, &values, &mut self.report);
        } else {
            for assignment in &values {
                instance.assign(&assignment.path, assignment, &mut self.report);
            }
        }
        if self.report.count() == before {
            self.add(instance, None, name.span.clone());
        }
    }

    fn wrong(&mut self, errors: SyntaxErrors) {
        self.report.omit(errors.others);
        for error in errors.first {
            self.report.wrong(error.span, error.message, error.help);
        }
    }

    fn add(&mut self, instance: Instance, qualified: Option<String>, span: Range<usize>) {
        self.seven_digits = self.seven_digits.take().or(instance.seven_digits);
        self.found.push(Found { one: instance.one, qualified, span });
    }

    /// Reads the instances of known blocks in a data block whose function block is declared in the text.
    fn multi_instance(&mut self, db: &DataBlock, function: &Function) {
        let mut instances = Vec::new();
        if !self.expand(function, &mut Vec::new(), &mut instances) {
            return;
        }
        if instances.is_empty() {
            self.skipped.add(db.name.text.clone());
            return;
        }
        let (values, errors) = assignments(self.text, db.body.clone());
        if !errors.first.is_empty() {
            return self.wrong(errors);
        }
        let by_path: HashMap<String, usize> =
            instances.iter().enumerate().map(|(index, (path, _))| (path_key(path), index)).collect();
        let mut read: Vec<Instance> = instances
            .iter()
            .map(|(path, block)| Instance::new(path.last().map_or("", String::as_str), block.clone()))
            .collect();
        let mut is_right = vec![true; read.len()];
        for assignment in &values {
            let path = &assignment.path;
            let owner =
                (1..path.len()).rev().find_map(|length| Some((*by_path.get(&path_key(&path[..length]))?, length)));
            match owner {
                Some((index, length)) => {
                    let before = self.report.count();
                    read[index].assign(&path[length..], assignment, &mut self.report);
                    is_right[index] &= self.report.count() == before;
                }
                None if function.names.contains(&without_index(&path[0]).to_uppercase()) => {}
                None => {
                    let message = format!("{} has no member {}", function.block.name.text, quoted(&path[0]));
                    let names = function.names.iter().map(String::as_str);
                    let help = if self.report.has_room() && function.names.len() < 1000 {
                        nearest(&path[0], names)
                    } else {
                        None
                    };
                    let help = help.map(|name| format!("did you mean {name}?"));
                    self.report.wrong(assignment.path_span.clone(), message, help);
                }
            }
        }
        for (instance, (path, _)) in
            read.into_iter().zip(&instances).zip(is_right).filter_map(|(of, is)| is.then_some(of))
        {
            let qualified = format!("{}.{}", db.name.text, path.join("."));
            self.add(instance, Some(qualified), db.name.span.clone());
        }
    }

    /// Lists the instances of known blocks in a function block, with their paths. Returns false if a member is
    /// rejected, which is reported.
    fn expand(
        &mut self,
        function: &Function,
        path: &mut Vec<String>,
        instances: &mut Vec<(Vec<String>, Arc<BlockType>)>,
    ) -> bool {
        for index in &function.leads {
            let member = &function.block.members[*index];
            let Some(kind) = &member.kind else { continue };
            let name = &member.name;
            let elements = member.array.as_deref().map_or(Some(vec![String::new()]), elements);
            let count = elements.as_ref().map_or(0, Vec::len);
            let refusal = if elements.is_none() {
                let most = "whose bounds are not numbers, or that has too many elements";
                Some(format!("is an array of instances {most}; declare each instance separately"))
            } else if member.has_initial_value {
                Some("is an instance with values in the declaration; write them in the data block".to_string())
            } else if path.len() == DEPTH && known(self.blocks, kind).is_none() {
                Some(format!("is nested more than {DEPTH} levels deep, or contains itself"))
            } else if self.found.len() + instances.len() + count > MOST_LOOPS {
                Some(format!("exceeds the {MOST_LOOPS} loops allowed in a file; split the file"))
            } else {
                None
            };
            if let Some(refusal) = refusal {
                if self.refused.insert(name.span.start) {
                    self.report.wrong(name.span.clone(), format!("{} {refusal}", quoted(&name.text)), None);
                }
                return false;
            }
            let functions = self.functions;
            for element in elements.unwrap_or_default() {
                path.push(format!("{}{element}", name.text));
                if let Some(block) = known(self.blocks, kind) {
                    instances.push((path.clone(), block));
                } else if let Some(inner) = functions.get(&key(kind))
                    && !self.expand(inner, path, instances)
                {
                    return false;
                }
                path.pop();
            }
        }
        true
    }

    /// Reads a data block of an unknown type, recognizing the block by its members.
    fn unknown(&mut self, db: &DataBlock, kind: &Name) {
        let (values, errors) = assignments(self.text, db.body.clone());
        let remark =
            |block: &BlockType| format!("{}: {} is treated as {}", db.name.text, quoted(&kind.text), block.name);
        if let Some(block) = without_number(&kind.text).and_then(|name| self.blocks.iter().find(|b| b.is_called(name)))
        {
            self.report.remark(Some(kind.span.clone()), remark(block));
            self.instance(db, block.clone(), (values, errors));
            return;
        }
        let names = || values.iter().map(|value| value.path.as_slice());
        let is_chosen = |block: &&Arc<BlockType>| !values.is_empty() && fit(block, names()).is_some();
        let block = self.chosen.as_ref().filter(is_chosen).cloned().or_else(|| self.recognized(names(), all_settings));
        if let Some(block) = block.filter(|_| errors.first.is_empty()) {
            self.report.remark(Some(kind.span.clone()), remark(&block));
            self.instance(db, block, (values, errors));
            return;
        }
        if errors.first.is_empty() && self.groups(db, &values) {
            return;
        }
        // A typo in a type name or a value must not lose a loop. Nor must another block that shares some names be
        // mistaken for a known one: its other values would be assigned to the wrong block.
        let is_member = |block: &&Arc<BlockType>| {
            values.iter().filter(|value| find(block, &value.path.join(".")).is_some()).count()
        };
        let is_likely = |block: &&Arc<BlockType>| !values.is_empty() && 2 * is_member(block) >= values.len();
        let meant = nearest(&kind.text, self.blocks.iter().map(|block| block.name.as_str()));
        let meant = meant.and_then(|name| self.blocks.iter().find(|block| block.name == name)).filter(is_likely);
        let alike = self.blocks.iter().filter(is_likely).max_by_key(is_member);
        let alike = alike.filter(|block| is_member(block) >= ENOUGH_NAMES);
        let help = match (meant, alike) {
            (Some(block), _) => format!("did you mean {}?", block.name).into(),
            (None, Some(block)) => Remedy::ChooseThisBlock(block.name.clone()),
            (None, None) => return self.skip(db, kind),
        };
        self.wrong(errors);
        let message = format!("{} is not a known block", quoted(&kind.text));
        self.report.wrong_with(kind.span.clone(), message, Some(help));
    }

    /// Skips a data block that is not an instance of a known block.
    fn skip(&mut self, db: &DataBlock, kind: &Name) {
        const MOST: usize = 20;
        if self.unknown.len() < MOST {
            self.unknown.push((db.name.text.clone(), kind.clone()));
        }
        self.skipped.add(format!("{} ({})", db.name.text, kind.text));
    }

    /// The only block that has all these members, provided that at least the required number of them are inputs and
    /// parameters.
    fn recognized<'n>(
        &self,
        names: impl Iterator<Item = &'n [String]> + Clone,
        wanted: fn(&BlockType) -> usize,
    ) -> Option<Arc<BlockType>> {
        let fits = |block: &&Arc<BlockType>| fit(block, names.clone()).is_some_and(|count| count >= wanted(block));
        let mut fitting = self.blocks.iter().filter(fits);
        fitting.next().filter(|_| fitting.next().is_none()).cloned()
    }

    /// Reads the multi-instances in a data block whose function block is not in the text, recognizing them by their
    /// members. Returns whether any were found.
    fn groups(&mut self, db: &DataBlock, values: &[Assignment]) -> bool {
        let mut groups: HashMap<String, Vec<usize>> = HashMap::new();
        let mut order = Vec::new();
        for (index, value) in values.iter().enumerate() {
            for length in 1..value.path.len() {
                let group = groups.entry(path_key(&value.path[..length])).or_default();
                if group.is_empty() {
                    order.push((index, length));
                }
                group.push(index);
            }
        }
        // Members of a recognized block are not examined: inner blocks belong to it.
        let mut taken: Vec<String> = Vec::new();
        for (first, length) in order {
            let path = &values[first].path[..length];
            if (1..length).any(|outer| taken.contains(&path_key(&path[..outer]))) {
                continue;
            }
            let members = &groups[&path_key(path)];
            let Some(block) =
                self.recognized(members.iter().map(|index| &values[*index].path[length..]), |_| ENOUGH_NAMES)
            else {
                continue;
            };
            let mut instance = Instance::new(&path[length - 1], block.clone());
            for index in members {
                instance.assign(&values[*index].path[length..], &values[*index], &mut self.report);
            }
            let name = path.join(".");
            let message = format!("{}: {} is recognized as {} by its members", db.name.text, quoted(&name), block.name);
            self.report.remark(Some(db.name.span.clone()), message);
            self.add(instance, Some(format!("{}.{name}", db.name.text)), db.name.span.clone());
            taken.push(path_key(path));
        }
        !taken.is_empty()
    }

    fn finish(mut self, is_broken: bool) -> Result<Reading, Problems> {
        if self.found.is_empty() && !self.report.is_wrong() {
            let described: Vec<String> = self.blocks.iter().map(|block| names(block)).collect();
            let help = format!("known blocks: {}", described.join(", "));
            for (name, kind) in std::mem::take(&mut self.unknown) {
                let what = match known(self.blocks, &kind) {
                    Some(block) => format!("but has no member of {}", block.name),
                    None => "which is not a known block".to_string(),
                };
                let message = format!("{name} is an instance of {}, {what}", quoted(&kind.text));
                self.report.wrong(kind.span, message, Some(help.clone()));
            }
        }
        if self.text.trim().is_empty() {
            self.report.wrong_file("the file is empty", None);
        }
        if self.found.is_empty() && !self.report.is_wrong() {
            let help = "expected DATA_BLOCK ... END_DATA_BLOCK with the name of a block before BEGIN";
            self.report.wrong_file("the file contains no instance data block", Some(help.into()));
        }
        if let Some(sentence) = self.skipped.sentence() {
            self.report.remark(None, sentence);
        }
        if let Some(span) = self.seven_digits.take() {
            let message = "REALs with seven digits, as here, may differ from the PLC's values by one bit; a dump of the data \
                           block is exact";
            self.report.remark(Some(span), message);
        }
        let loops = self.named();
        self.report.finish(if is_broken { Vec::new() } else { loops })
    }

    /// Returns the loops, each with a unique name.
    fn named(&mut self) -> Vec<Loop> {
        let mut found = std::mem::take(&mut self.found);
        let mut count: HashMap<String, usize> = HashMap::new();
        for Found { one, .. } in &found {
            *count.entry(one.name.to_uppercase()).or_default() += 1;
        }
        for Found { one, qualified, .. } in &mut found {
            if let Some(qualified) = qualified.take().filter(|_| count[&one.name.to_uppercase()] > 1) {
                one.name = qualified;
            }
        }
        let mut first: HashMap<String, Range<usize>> = HashMap::new();
        found.retain(|Found { one, span, .. }| {
            let Some(first) = first.insert(one.name.to_uppercase(), span.clone()) else { return true };
            let message =
                format!("{} occurs twice; the first is on line {}", quoted(&one.name), self.report.line(first));
            self.report.wrong(span.clone(), message, None);
            false
        });
        found.into_iter().map(|found| found.one).collect()
    }
}

/// The number of inputs and parameters that an instance has in the PLC, excluding those of inner blocks.
fn all_settings(block: &BlockType) -> usize {
    block.members.iter().filter(|member| !member.is_inner() && member.role.is_settable()).count()
}

/// Whether a name is not even similar to a member of the block.
fn is_strange(block: &BlockType, value: &Assignment) -> bool {
    let name = value.path.join(".");
    let members = block.members.iter().map(|member| member.name.as_str());
    find(block, &name).is_none() && lost_name(&name).is_none() && nearest(&name, members).is_none()
}

/// A name without its index.
fn without_index(name: &str) -> &str {
    name.split('[').next().unwrap_or(name)
}

/// A case-insensitive key for a path.
fn path_key(path: &[String]) -> String {
    path.join("\n").to_uppercase()
}

/// The name of a type without the number that a migration to TIA Portal appends: `PUMP_1`.
fn without_number(name: &str) -> Option<&str> {
    let (name, number) = name.rsplit_once('_')?;
    (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(name)
}

/// The name of a block, with its aliases.
fn names(block: &BlockType) -> String {
    match block.aliases.as_slice() {
        [] => block.name.clone(),
        aliases => format!("{} ({})", block.name, aliases.join(", ")),
    }
}
