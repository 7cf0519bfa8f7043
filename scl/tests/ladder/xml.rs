//! A writer of SimaticML for tests: networks as parts and wires, as TIA Openness exports them.

use std::fmt::Write;

/// The source of a wire.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum From {
    Rail,
    /// A variable of the block, such as `a` or `t.Q`.
    Local(String),
    /// A global variable, such as `Data.a`.
    Global(String),
    /// A constant: its type, empty for a typed literal such as `T#1s`, and its value.
    Constant(&'static str, String),
    /// A pin of a part, by its UId.
    Pin(u32, &'static str),
}

/// A variable of the block.
pub(crate) fn local(name: &str) -> From {
    From::Local(name.to_string())
}

/// A constant without a separate type.
pub(crate) fn typed(value: &str) -> From {
    From::Constant("", value.to_string())
}

/// An INT.
pub(crate) fn int(value: i64) -> From {
    From::Constant("Int", value.to_string())
}

/// A network.
#[derive(Clone, Debug, Default)]
pub(crate) struct Net {
    title: String,
    uid: u32,
    accesses: String,
    parts: String,
    labels: String,
    wires: Vec<(From, Vec<String>)>,
    scl: Option<String>,
}

impl Net {
    pub(crate) fn new(title: &str) -> Net {
        Net { title: title.to_string(), uid: 20, ..Net::default() }
    }

    /// Creates a network in another language from the content of its source.
    pub(crate) fn of_source(title: &str, source: &str) -> Net {
        Net { scl: Some(source.to_string()), ..Net::new(title) }
    }

    pub(crate) fn next(&mut self) -> u32 {
        self.uid += 1;
        self.uid
    }

    pub(crate) fn label(&mut self, name: &str) {
        let uid = self.next();
        write!(self.labels, "<LabelDeclaration UId=\"{uid}\"><Label Name=\"{name}\" /></LabelDeclaration>").unwrap();
    }

    /// Adds a part with its content and the sources of its pins.
    pub(crate) fn part(&mut self, name: &str, inner: &str, inputs: &[(&str, From)]) -> u32 {
        let uid = self.next();
        self.part_at(uid, name, inner, inputs);
        uid
    }

    /// Adds a part with a reserved UId.
    pub(crate) fn part_at(&mut self, uid: u32, name: &str, inner: &str, inputs: &[(&str, From)]) {
        let (name, attributes) = name.split_once(' ').unwrap_or((name, ""));
        writeln!(self.parts, "<Part Name=\"{name}\" UId=\"{uid}\" {attributes}>{inner}</Part>").unwrap();
        for (pin, from) in inputs {
            self.wire(from.clone(), &format!("<NameCon UId=\"{uid}\" Name=\"{pin}\" />"));
        }
    }

    /// Adds a call: BlockType, name and the content of CallInfo.
    pub(crate) fn call(&mut self, of: &str, name: &str, inner: &str, inputs: &[(&str, From)]) -> u32 {
        let uid = self.next();
        self.call_at(uid, of, name, inner, inputs);
        uid
    }

    /// Adds a call with a reserved UId.
    pub(crate) fn call_at(&mut self, uid: u32, of: &str, name: &str, inner: &str, inputs: &[(&str, From)]) {
        writeln!(
            self.parts,
            "<Call UId=\"{uid}\"><CallInfo Name=\"{name}\" BlockType=\"{of}\">{inner}</CallInfo></Call>"
        )
        .unwrap();
        for (pin, from) in inputs {
            self.wire(from.clone(), &format!("<NameCon UId=\"{uid}\" Name=\"{pin}\" />"));
        }
    }

    pub(crate) fn wire(&mut self, from: From, to: &str) {
        // Operands have an access for each use; pins and the power rail have one wire for all.
        let is_shared = matches!(from, From::Rail | From::Pin(..));
        match self.wires.iter_mut().find(|(own, _)| is_shared && *own == from) {
            Some((_, targets)) => targets.push(to.to_string()),
            None => self.wires.push((from, vec![to.to_string()])),
        }
    }

    /// Connects an output pin to a variable.
    pub(crate) fn write(&mut self, uid: u32, pin: &'static str, target: From) {
        let access = self.access(&target);
        self.wire(From::Pin(uid, pin), &format!("<IdentCon UId=\"{access}\" />"));
    }

    /// Sets the label that a jump leads to.
    pub(crate) fn jump_to(&mut self, uid: u32, label: &str) {
        let access = self.next();
        writeln!(self.accesses, "<Access Scope=\"Label\" UId=\"{access}\"><Label Name=\"{label}\" /></Access>")
            .unwrap();
        let wire = format!("<IdentCon UId=\"{access}\" /><NameCon UId=\"{uid}\" Name=\"label\" />");
        self.wires.push((From::Local(String::new()), vec![wire]));
    }

    fn access(&mut self, of: &From) -> u32 {
        let uid = self.next();
        let text = access(of, &format!(" UId=\"{uid}\""));
        writeln!(self.accesses, "{text}").unwrap();
        uid
    }

    fn finish(mut self, number: usize, language: &str) -> String {
        let mut wires = String::new();
        for (from, targets) in std::mem::take(&mut self.wires) {
            let source = match &from {
                From::Rail => "<Powerrail />".to_string(),
                From::Pin(uid, pin) => format!("<NameCon UId=\"{uid}\" Name=\"{pin}\" />"),
                From::Local(name) if name.is_empty() => String::new(),
                operand => format!("<IdentCon UId=\"{}\" />", self.access(operand)),
            };
            let uid = self.next();
            writeln!(wires, "<Wire UId=\"{uid}\">{source}{}</Wire>", targets.concat()).unwrap();
        }
        let Net { title, accesses, parts, labels, scl, .. } = self;
        let labels = if labels.is_empty() { labels } else { format!("<Labels>{labels}</Labels>") };
        let (source, language) = match scl {
            Some(scl) => (scl, "SCL"),
            None => {
                let xmlns = "http://www.siemens.com/automation/Openness/SW/NetworkSource/FlgNet/v4";
                let parts = format!("<Parts>\n{accesses}{parts}</Parts>\n{labels}<Wires>\n{wires}</Wires>");
                (format!("<FlgNet xmlns=\"{xmlns}\">{parts}</FlgNet>"), language)
            }
        };
        format!(
            "<SW.Blocks.CompileUnit ID=\"{number}\" CompositionName=\"CompileUnits\">\n<AttributeList>\n<NetworkSource>\
             {source}</NetworkSource>\n<ProgrammingLanguage>{language}</ProgrammingLanguage>\n</AttributeList>\n\
             <ObjectList>{}</ObjectList>\n</SW.Blocks.CompileUnit>\n",
            multilingual("Title", &title)
        )
    }
}

fn multilingual(name: &str, text: &str) -> String {
    format!(
        "<MultilingualText CompositionName=\"{name}\"><ObjectList><MultilingualTextItem CompositionName=\"Items\">\
         <AttributeList><Culture>de-DE</Culture><Text /></AttributeList></MultilingualTextItem><MultilingualTextItem \
         CompositionName=\"Items\"><AttributeList><Culture>en-US</Culture><Text>{text}</Text></AttributeList>\
         </MultilingualTextItem></ObjectList></MultilingualText>"
    )
}

fn access(of: &From, uid: &str) -> String {
    let path = |scope: &str, name: &str| {
        let components: String = name.split('.').map(component).collect();
        format!("<Access Scope=\"{scope}\"{uid}><Symbol>{components}</Symbol></Access>")
    };
    match of {
        From::Local(name) => path("LocalVariable", name),
        From::Global(name) => path("GlobalVariable", name),
        From::Constant("", value) => {
            format!(
                "<Access Scope=\"TypedConstant\"{uid}><Constant><ConstantValue>{value}</ConstantValue></Constant></Access>"
            )
        }
        From::Constant(of, value) => format!(
            "<Access Scope=\"LiteralConstant\"{uid}><Constant><ConstantType>{of}</ConstantType><ConstantValue>{value}\
             </ConstantValue></Constant></Access>"
        ),
        From::Rail | From::Pin(..) => unreachable!("no operand"),
    }
}

/// Writes a component: `a`, `a[3]`, `a[i]`, `a[b[i]]`, `a%X3`.
fn component(name: &str) -> String {
    if let Some((name, slice)) = name.split_once('%') {
        return format!("<Component Name=\"{name}\" SliceAccessModifier=\"{}\" />", slice.to_lowercase());
    }
    match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
        Some((name, index)) => {
            let index = match index.parse::<i64>() {
                Ok(_) => access(&From::Constant("DInt", index.to_string()), ""),
                Err(_) => access(&From::Local(index.to_string()), ""),
            };
            format!("<Component Name=\"{name}\" AccessModifier=\"Array\">{index}</Component>")
        }
        None => format!("<Component Name=\"{name}\" />"),
    }
}

/// Writes the members of a section, given as `a : Bool := TRUE`, separated by `;`.
fn members(text: &str) -> String {
    let mut all = String::new();
    for member in text.split(';').map(str::trim).filter(|member| !member.is_empty()) {
        let (name, of) = member.split_once(':').unwrap();
        let (of, start) = of.split_once(":=").unwrap_or((of, ""));
        let of = of.trim().replace('"', "&quot;");
        let start = start.trim();
        let start = if start.is_empty() { String::new() } else { format!("<StartValue>{start}</StartValue>") };
        writeln!(all, "<Member Name=\"{}\" Datatype=\"{of}\">{start}</Member>", name.trim()).unwrap();
    }
    all
}

/// Writes a block: `FB`, `FC` or `OB`, its name, its sections and its networks in a language.
pub(crate) fn block(of: &str, name: &str, sections: &[(&str, &str)], networks: Vec<Net>, language: &str) -> String {
    let section = |(name, text): &(&str, &str)| format!("<Section Name=\"{name}\">\n{}</Section>\n", members(text));
    let sections: String = sections.iter().map(section).collect();
    let units: String =
        networks.into_iter().enumerate().map(|(number, network)| network.finish(number + 3, language)).collect();
    format!(
        "\u{feff}<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Document>\n<Engineering version=\"V18\" />\n<SW.Blocks.{of} ID=\"0\">\n\
         <AttributeList>\n<Interface><Sections xmlns=\"http://www.siemens.com/automation/Openness/SW/Interface/v5\">\n\
         {sections}</Sections></Interface>\n<MemoryLayout>Optimized</MemoryLayout>\n<Name>{name}</Name>\n<Number>1</Number>\n\
         <ProgrammingLanguage>{language}</ProgrammingLanguage>\n</AttributeList>\n<ObjectList>\n{units}</ObjectList>\n\
         </SW.Blocks.{of}>\n</Document>\n"
    )
}
