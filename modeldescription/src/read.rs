//! XML as a model description.

use crate::check::contradictions;
use crate::description::{
    BaseUnit, Boolean, CoSimulation, DefaultExperiment, DisplayUnit, Enumeration, FMI_VERSION, Integer,
    IntegerAttributes, Item, LogCategory, ModelDescription, ModelExchange, ModelStructure, Real, RealAttributes,
    SimpleType, Text, TypeAttributes, Typed, Unit, Unknown, Variable, Words,
};
use crate::error::{Error, shortened};
use crate::lexical;
use quick_xml::events::{BytesDecl, BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::borrow::Cow;

/// How much is read at most. What is within these limits takes at most about ten times the bytes of the file as memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The size of the file in bytes.
    pub bytes: usize,
    /// The number of variables.
    pub variables: usize,
    /// The number of elements of all kinds together.
    pub elements: usize,
    /// How deep elements may stand inside an annotation. Everything else has a depth of its own.
    pub depth: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { bytes: 64 << 20, variables: 1_000_000, elements: 4_000_000, depth: 64 }
    }
}

/// Reads a modelDescription.xml of FMI 2.0, made by whatever tool.
///
/// Everything that the schema of FMI 2.0 has is read, in any order, but for annotations, which are passed over.
/// Attributes of other namespaces are passed over too.
///
/// Memory is bounded: the default [`Limits`] are checked on the way, and nothing is ever expanded: a document type
/// declaration is refused. Time grows with the size of the file alone.
///
/// # Errors
/// One sentence with the line, the element, the attribute, its value and what would be right, for a file that
/// - is no XML, no UTF-8, no model description, or one of another version of FMI;
/// - has elements, attributes or words that FMI 2.0 has not, lacks some that it has to have, or has some twice;
/// - contradicts itself: a name or a unit twice, two inputs or parameters with one value reference, a unit, a type or
///   a variable referred to that does not exist, a range that is empty or that the start value lies outside of.
pub fn read(bytes: &[u8]) -> Result<ModelDescription, Error> {
    read_within(bytes, Limits::default())
}

/// Reads a modelDescription.xml within limits of one's own; otherwise as [`read()`].
///
/// # Errors
/// As [`read()`].
pub fn read_within(bytes: &[u8], limits: Limits) -> Result<ModelDescription, Error> {
    if bytes.len() > limits.bytes {
        let (size, most) = (bytes.len(), limits.bytes);
        return Err(Error::new(format!("the model description has {size} bytes: at most {most} are read")));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let place = error.valid_up_to();
        at_line(bytes, place, &format!("byte 0x{:02x} is no UTF-8: save the file in UTF-8", bytes[place]))
    })?;
    let mut document = Document::new(text.strip_prefix('\u{feff}').unwrap_or(text), limits);
    let root = document.root()?;
    let (description, places) = document.model_description(&root)?;
    document.end()?;

    let mut first = None;
    contradictions(&description, &mut |variable, sentence| {
        first.get_or_insert((variable, sentence));
    });
    match first {
        None => Ok(description),
        Some((None, sentence)) => Err(Error::new(sentence)),
        Some((Some(variable), sentence)) => Err(at_line(document.text.as_bytes(), places[variable], &sentence)),
    }
}

/// What the XML reader found, which may quote a name of any length.
fn no_xml(error: &impl std::fmt::Display) -> String {
    format!("this is no XML: {:.300}", error.to_string())
}

/// A sentence with the number of the line in front.
fn at_line(bytes: &[u8], place: usize, sentence: &str) -> Error {
    let line = 1 + bytes.iter().take(place).filter(|byte| **byte == b'\n').count();
    Error::new(format!("line {line}: {sentence}"))
}

/// What XML takes for white space.
const SPACES: [char; 4] = [' ', '\t', '\n', '\r'];

/// A start tag.
struct Element<'a> {
    tag: BytesStart<'a>,
    /// Closed already: `<a/>`.
    is_empty: bool,
    /// The whole document, and where in it the tag begins.
    text: &'a str,
    place: usize,
}

impl Element<'_> {
    fn name(&self) -> &str {
        self.tag.name().0
    }

    fn refused(&self, sentence: &str) -> Error {
        at_line(self.text.as_bytes(), self.place, &format!("{}: {sentence}", shortened(self.name())))
    }

    /// The values of the attributes of these names. Those of other namespaces are passed over, others refused.
    fn attributes<const N: usize>(&self, names: [&'static str; N]) -> Result<[Option<Attribute<'_>>; N], Error> {
        let mut attributes = [const { None }; N];
        // That names are there twice is found below, without comparing each with each.
        for attribute in self.tag.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.refused(&format!("{error}: repair the tag")))?;
            let name = attribute.key.0;
            let Some(place) = names.iter().position(|known| *known == name) else {
                if name == "xmlns" || name.contains(':') {
                    continue;
                }
                let known = if N == 0 { "none".into() } else { names.join(", ") };
                return Err(self.refused(&format!("attribute {:?} is unknown: FMI 2.0 has {known}", shortened(name))));
            };
            let refused =
                |reason: &str| self.refused(&format!("{} = {:?}: {reason}", names[place], shortened(&attribute.value)));
            if attributes[place].is_some() {
                return Err(refused("the attribute is there twice: remove one"));
            }
            if attribute.value.contains('<') {
                return Err(refused("a < has to be written &lt;"));
            }
            let value = attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|_| {
                refused("after an & only lt; gt; amp; quot; apos; and numbers such as #10; are read: write &amp; for itself")
            })?;
            if let Some(character) = value.chars().find(|character| !lexical::is_xml(*character)) {
                return Err(refused(&format!("XML cannot hold the character {character:?}: remove it")));
            }
            attributes[place] = Some(Attribute { element: self, name: names[place], value });
        }
        Ok(attributes)
    }

    fn required<'e>(&self, name: &str, attribute: Option<Attribute<'e>>) -> Result<Attribute<'e>, Error> {
        attribute.ok_or_else(|| self.refused(&format!("attribute {name} is missing: add it")))
    }
}

/// An attribute, its entities resolved and its line breaks made spaces.
struct Attribute<'e> {
    element: &'e Element<'e>,
    name: &'static str,
    value: Cow<'e, str>,
}

impl Attribute<'_> {
    fn refused(&self, reason: &str) -> Error {
        self.element.refused(&format!("{} = {:?}: {reason}", self.name, shortened(&self.value)))
    }

    /// The value without the spaces around it, that XML Schema ignores in numbers and words.
    fn trimmed(&self) -> &str {
        self.value.trim_matches(SPACES)
    }

    fn text(self) -> Result<String, Error> {
        Ok(self.value.into_owned())
    }

    fn real(self) -> Result<f64, Error> {
        lexical::real(self.trimmed()).ok_or_else(|| self.refused("this is no number, such as 0.5, 1e-3 or INF"))
    }

    fn integer(self) -> Result<i32, Error> {
        self.trimmed().parse().map_err(|_| self.refused("this is no whole number of 32 bits"))
    }

    fn unsigned(self) -> Result<u32, Error> {
        self.trimmed().parse().map_err(|_| self.refused("this is no whole number of 0 ... 4294967295"))
    }

    fn boolean(self) -> Result<bool, Error> {
        lexical::boolean(self.trimmed()).ok_or_else(|| self.refused("this is neither true nor false"))
    }

    fn word<T: Words>(self) -> Result<T, Error> {
        word(self.trimmed()).ok_or_else(|| self.refused(&format!("take one of {}", words::<T>())))
    }

    fn indices(self) -> Result<Vec<u32>, Error> {
        let items = self.value.split(SPACES).filter(|item| !item.is_empty());
        let indices: Result<Vec<u32>, _> = items.map(str::parse).collect();
        indices.map_err(|_| self.refused("these are no indices with spaces between"))
    }

    fn words<T: Words>(self) -> Result<Vec<T>, Error> {
        let items = self.value.split(SPACES).filter(|item| !item.is_empty());
        let list: Option<Vec<T>> = items.map(word).collect();
        list.ok_or_else(|| self.refused(&format!("take some of {}", words::<T>())))
    }
}

fn word<T: Words>(text: &str) -> Option<T> {
    T::WORDS.iter().find(|(word, _)| *word == text).map(|(_, value)| *value)
}

fn words<T: Words>() -> String {
    T::WORDS.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ")
}

/// The value of an attribute that may be absent.
fn optional<'e, T>(
    attribute: Option<Attribute<'e>>,
    value: impl FnOnce(Attribute<'e>) -> Result<T, Error>,
) -> Result<Option<T>, Error> {
    attribute.map(value).transpose()
}

/// The children that an element may have once, and has had.
#[derive(Default)]
struct Once(Vec<String>);

impl Once {
    fn add(&mut self, child: &Element<'_>) -> Result<(), Error> {
        if self.0.iter().any(|name| name == child.name()) {
            return Err(child.refused("the element is there twice: remove one"));
        }
        self.0.push(child.name().to_owned());
        Ok(())
    }
}

/// What a document is made of.
enum Piece<'a> {
    Tag(Element<'a>),
    EndTag,
    /// A text that is more than white space, and where it begins.
    Text(usize),
    End,
}

/// The document, read once, from its start to its end.
struct Document<'a> {
    reader: Reader<&'a [u8]>,
    text: &'a str,
    limits: Limits,
    elements: usize,
}

impl<'a> Document<'a> {
    fn new(text: &'a str, limits: Limits) -> Document<'a> {
        Document { reader: Reader::from_str(text), text, limits, elements: 0 }
    }

    fn refused(&self, place: usize, sentence: &str) -> Error {
        at_line(self.text.as_bytes(), place, sentence)
    }

    /// The next tag or text. White space, comments and processing instructions are passed over.
    fn next(&mut self) -> Result<Piece<'a>, Error> {
        loop {
            let place = usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX);
            let event = self.reader.read_event().map_err(|error| {
                let place = usize::try_from(self.reader.error_position()).unwrap_or(usize::MAX);
                self.refused(place, &no_xml(&error))
            })?;
            return Ok(match event {
                Event::Start(tag) => Piece::Tag(self.element(place, tag, false)?),
                Event::Empty(tag) => Piece::Tag(self.element(place, tag, true)?),
                Event::End(_) => Piece::EndTag,
                Event::Text(text) => match text.find(|character| !SPACES.contains(&character)) {
                    None => continue,
                    Some(spaces) => Piece::Text(place + spaces),
                },
                Event::CData(_) => Piece::Text(place),
                Event::GeneralRef(entity) => {
                    let is_known = matches!(&*entity, "lt" | "gt" | "amp" | "quot" | "apos");
                    if !is_known && !matches!(entity.resolve_char_ref(), Ok(Some(_))) {
                        let sentence = format!("entity &{}; is not read: write what it stands for", shortened(&entity));
                        return Err(self.refused(place, &sentence));
                    }
                    Piece::Text(place)
                }
                Event::Comment(_) | Event::PI(_) => continue,
                Event::Decl(declaration) if place == 0 => {
                    self.check_declaration(&declaration)?;
                    continue;
                }
                Event::Decl(_) => {
                    let sentence = "the XML declaration is not at the start of the file: move it there";
                    return Err(self.refused(place, sentence));
                }
                Event::DocType(_) => {
                    let sentence = "a document type declaration (<!DOCTYPE) is not read: remove it";
                    return Err(self.refused(place, sentence));
                }
                Event::Eof => Piece::End,
            });
        }
    }

    fn element(&mut self, place: usize, tag: BytesStart<'a>, is_empty: bool) -> Result<Element<'a>, Error> {
        self.elements += 1;
        let most = self.limits.elements;
        if self.elements > most {
            return Err(self.refused(place, &format!("there are too many elements: at most {most} are read")));
        }
        Ok(Element { tag, is_empty, text: self.text, place })
    }

    fn check_declaration(&self, declaration: &BytesDecl<'_>) -> Result<(), Error> {
        let version = declaration.version().map_err(|error| self.refused(0, &no_xml(&error)))?;
        if version != "1.0" {
            return Err(self.refused(0, &format!("XML {:?} is not read: FMI 2.0 uses 1.0", shortened(&version))));
        }
        let encoding = declaration.encoding().transpose();
        let encoding = encoding.map_err(|error| self.refused(0, &no_xml(&error)))?;
        // Other encodings than UTF-8 look the same as long as there are no other characters than those of ASCII.
        if let Some(encoding) = encoding.filter(|encoding| !encoding.eq_ignore_ascii_case("utf-8"))
            && !self.text.is_ascii()
        {
            let encoding = shortened(&encoding).into_owned();
            return Err(self.refused(0, &format!("encoding = {encoding:?}: save the file in UTF-8")));
        }
        Ok(())
    }

    /// The tag that the document begins with.
    fn root(&mut self) -> Result<Element<'a>, Error> {
        match self.next()? {
            Piece::Tag(root) if root.name() == "fmiModelDescription" => Ok(root),
            Piece::Tag(root) => {
                Err(root.refused("this is no model description: that begins with <fmiModelDescription"))
            }
            _ => Err(self.refused(0, "this is no XML: a model description begins with <fmiModelDescription")),
        }
    }

    /// Nothing may follow the root.
    fn end(&mut self) -> Result<(), Error> {
        match self.next()? {
            Piece::Tag(Element { place, .. }) | Piece::Text(place) => {
                Err(self.refused(place, "something follows </fmiModelDescription>: remove it"))
            }
            // An end tag without a start tag is no XML.
            Piece::EndTag | Piece::End => Ok(()),
        }
    }

    /// The next child of an element; none at its end. The child has to be read to its end before the next.
    fn child(&mut self, parent: &Element<'_>) -> Result<Option<Element<'a>>, Error> {
        if parent.is_empty {
            return Ok(None);
        }
        match self.next()? {
            Piece::Tag(child) => Ok(Some(child)),
            Piece::EndTag => Ok(None),
            Piece::Text(place) => {
                let sentence = format!("there is text inside {}: FMI 2.0 has none, remove it", parent.name());
                Err(self.refused(place, &sentence))
            }
            Piece::End => Err(cut_off(parent)),
        }
    }

    /// The end of an element that has no children.
    fn leaf(&mut self, element: &Element<'_>) -> Result<(), Error> {
        match self.child(element)? {
            None => Ok(()),
            Some(child) => Err(unknown(&child, element)),
        }
    }

    /// Reads on to the end of an annotation, whatever is in it.
    fn skip(&mut self, element: &Element<'_>) -> Result<(), Error> {
        let most = self.limits.depth;
        let mut depth = usize::from(!element.is_empty);
        while depth > 0 {
            match self.next()? {
                Piece::Tag(_) if depth > most => {
                    return Err(element.refused(&format!("the elements inside are too deep: at most {most} are read")));
                }
                Piece::Tag(child) => depth += usize::from(!child.is_empty),
                Piece::EndTag => depth -= 1,
                Piece::Text(_) => {}
                Piece::End => return Err(cut_off(element)),
            }
        }
        Ok(())
    }

    /// The description, and where each variable begins.
    fn model_description(&mut self, root: &Element<'_>) -> Result<(ModelDescription, Vec<usize>), Error> {
        check_version(root)?;
        let [
            _,
            model_name,
            guid,
            description,
            author,
            version,
            copyright,
            license,
            generation_tool,
            generation_date_and_time,
            variable_naming_convention,
            number_of_event_indicators,
        ] = root.attributes([
            "fmiVersion",
            "modelName",
            "guid",
            "description",
            "author",
            "version",
            "copyright",
            "license",
            "generationTool",
            "generationDateAndTime",
            "variableNamingConvention",
            "numberOfEventIndicators",
        ])?;
        let mut model = ModelDescription {
            model_name: root.required("modelName", model_name)?.text()?,
            guid: root.required("guid", guid)?.text()?,
            description: optional(description, Attribute::text)?,
            author: optional(author, Attribute::text)?,
            version: optional(version, Attribute::text)?,
            copyright: optional(copyright, Attribute::text)?,
            license: optional(license, Attribute::text)?,
            generation_tool: optional(generation_tool, Attribute::text)?,
            generation_date_and_time: optional(generation_date_and_time, Attribute::text)?,
            variable_naming_convention: optional(variable_naming_convention, Attribute::word)?.unwrap_or_default(),
            number_of_event_indicators: optional(number_of_event_indicators, Attribute::unsigned)?,
            ..ModelDescription::default()
        };
        let mut places = Vec::new();
        let mut once = Once::default();
        while let Some(child) = self.child(root)? {
            match child.name() {
                "ModelExchange" => model.model_exchange = Some(self.model_exchange(&child)?),
                "CoSimulation" => model.co_simulation = Some(self.co_simulation(&child)?),
                "UnitDefinitions" => model.unit_definitions = self.list(&child, "Unit", Self::unit)?,
                "TypeDefinitions" => model.type_definitions = self.list(&child, "SimpleType", Self::simple_type)?,
                "LogCategories" => model.log_categories = self.list(&child, "Category", Self::log_category)?,
                "DefaultExperiment" => model.default_experiment = Some(self.default_experiment(&child)?),
                "VendorAnnotations" => self.skip(&child)?,
                "ModelVariables" => {
                    model.model_variables = self.list(&child, "ScalarVariable", |document, element| {
                        let most = document.limits.variables;
                        if places.len() >= most {
                            return Err(
                                element.refused(&format!("there are too many variables: at most {most} are read"))
                            );
                        }
                        places.push(element.place);
                        document.variable(element)
                    })?;
                }
                "ModelStructure" => model.model_structure = self.model_structure(&child)?,
                _ => return Err(unknown(&child, root)),
            }
            once.add(&child)?;
        }
        for needed in ["ModelVariables", "ModelStructure"] {
            if !once.0.iter().any(|name| name == needed) {
                return Err(root.refused(&format!("element {needed} is missing: add it")));
            }
        }
        Ok((model, places))
    }

    /// The items of a list of elements of one name.
    fn list<T>(
        &mut self,
        list: &Element<'_>,
        name: &str,
        mut item: impl FnMut(&mut Self, &Element<'_>) -> Result<T, Error>,
    ) -> Result<Vec<T>, Error> {
        list.attributes([])?;
        let mut items = Vec::new();
        while let Some(child) = self.child(list)? {
            if child.name() != name {
                return Err(unknown(&child, list));
            }
            items.push(item(self, &child)?);
        }
        Ok(items)
    }

    fn model_exchange(&mut self, element: &Element<'_>) -> Result<ModelExchange, Error> {
        let [
            model_identifier,
            needs_execution_tool,
            completed_integrator_step_not_needed,
            can_be_instantiated_only_once_per_process,
            can_not_use_memory_management_functions,
            can_get_and_set_fmu_state,
            can_serialize_fmu_state,
            provides_directional_derivative,
        ] = element.attributes([
            "modelIdentifier",
            "needsExecutionTool",
            "completedIntegratorStepNotNeeded",
            "canBeInstantiatedOnlyOncePerProcess",
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
            "providesDirectionalDerivative",
        ])?;
        Ok(ModelExchange {
            model_identifier: element.required("modelIdentifier", model_identifier)?.text()?,
            needs_execution_tool: flag(needs_execution_tool)?,
            completed_integrator_step_not_needed: flag(completed_integrator_step_not_needed)?,
            can_be_instantiated_only_once_per_process: flag(can_be_instantiated_only_once_per_process)?,
            can_not_use_memory_management_functions: flag(can_not_use_memory_management_functions)?,
            can_get_and_set_fmu_state: flag(can_get_and_set_fmu_state)?,
            can_serialize_fmu_state: flag(can_serialize_fmu_state)?,
            provides_directional_derivative: flag(provides_directional_derivative)?,
            source_files: self.source_files(element)?,
        })
    }

    fn co_simulation(&mut self, element: &Element<'_>) -> Result<CoSimulation, Error> {
        let [
            model_identifier,
            needs_execution_tool,
            can_handle_variable_communication_step_size,
            can_interpolate_inputs,
            max_output_derivative_order,
            can_run_asynchronuously,
            can_be_instantiated_only_once_per_process,
            can_not_use_memory_management_functions,
            can_get_and_set_fmu_state,
            can_serialize_fmu_state,
            provides_directional_derivative,
        ] = element.attributes([
            "modelIdentifier",
            "needsExecutionTool",
            "canHandleVariableCommunicationStepSize",
            "canInterpolateInputs",
            "maxOutputDerivativeOrder",
            "canRunAsynchronuously",
            "canBeInstantiatedOnlyOncePerProcess",
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
            "providesDirectionalDerivative",
        ])?;
        Ok(CoSimulation {
            model_identifier: element.required("modelIdentifier", model_identifier)?.text()?,
            needs_execution_tool: flag(needs_execution_tool)?,
            can_handle_variable_communication_step_size: flag(can_handle_variable_communication_step_size)?,
            can_interpolate_inputs: flag(can_interpolate_inputs)?,
            max_output_derivative_order: optional(max_output_derivative_order, Attribute::unsigned)?.unwrap_or(0),
            can_run_asynchronuously: flag(can_run_asynchronuously)?,
            can_be_instantiated_only_once_per_process: flag(can_be_instantiated_only_once_per_process)?,
            can_not_use_memory_management_functions: flag(can_not_use_memory_management_functions)?,
            can_get_and_set_fmu_state: flag(can_get_and_set_fmu_state)?,
            can_serialize_fmu_state: flag(can_serialize_fmu_state)?,
            provides_directional_derivative: flag(provides_directional_derivative)?,
            source_files: self.source_files(element)?,
        })
    }

    fn source_files(&mut self, flags: &Element<'_>) -> Result<Vec<String>, Error> {
        let mut files = Vec::new();
        let mut once = Once::default();
        while let Some(child) = self.child(flags)? {
            if child.name() != "SourceFiles" {
                return Err(unknown(&child, flags));
            }
            once.add(&child)?;
            files = self.list(&child, "File", |document, file| {
                let [name] = file.attributes(["name"])?;
                document.leaf(file)?;
                file.required("name", name)?.text()
            })?;
        }
        Ok(files)
    }

    fn unit(&mut self, element: &Element<'_>) -> Result<Unit, Error> {
        let [name] = element.attributes(["name"])?;
        let mut unit = Unit { name: element.required("name", name)?.text()?, ..Unit::default() };
        let mut once = Once::default();
        while let Some(child) = self.child(element)? {
            match child.name() {
                "BaseUnit" => {
                    once.add(&child)?;
                    unit.base_unit = Some(self.base_unit(&child)?);
                }
                "DisplayUnit" => unit.display_units.push(self.display_unit(&child)?),
                _ => return Err(unknown(&child, element)),
            }
        }
        Ok(unit)
    }

    #[allow(non_snake_case)] // as in BaseUnit
    fn base_unit(&mut self, element: &Element<'_>) -> Result<BaseUnit, Error> {
        let [kg, m, s, A, K, mol, cd, rad, factor, offset] =
            element.attributes(["kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset"])?;
        self.leaf(element)?;
        let exponent = |attribute| Ok(optional(attribute, Attribute::integer)?.unwrap_or(0));
        Ok(BaseUnit {
            kg: exponent(kg)?,
            m: exponent(m)?,
            s: exponent(s)?,
            A: exponent(A)?,
            K: exponent(K)?,
            mol: exponent(mol)?,
            cd: exponent(cd)?,
            rad: exponent(rad)?,
            factor: optional(factor, Attribute::real)?.unwrap_or(1.0),
            offset: optional(offset, Attribute::real)?.unwrap_or(0.0),
        })
    }

    fn display_unit(&mut self, element: &Element<'_>) -> Result<DisplayUnit, Error> {
        let [name, factor, offset] = element.attributes(["name", "factor", "offset"])?;
        self.leaf(element)?;
        Ok(DisplayUnit {
            name: element.required("name", name)?.text()?,
            factor: optional(factor, Attribute::real)?.unwrap_or(1.0),
            offset: optional(offset, Attribute::real)?.unwrap_or(0.0),
        })
    }

    fn simple_type(&mut self, element: &Element<'_>) -> Result<SimpleType, Error> {
        let [name, description] = element.attributes(["name", "description"])?;
        let mut attributes = None;
        while let Some(child) = self.child(element)? {
            let is_second = attributes.is_some();
            attributes = Some(match child.name() {
                _ if is_second => return Err(child.refused("a SimpleType is of one type: remove this element")),
                "Real" => self.real_type(&child)?,
                "Integer" => self.integer_type(&child)?,
                "Boolean" => {
                    child.attributes([])?;
                    self.leaf(&child)?;
                    TypeAttributes::Boolean
                }
                "String" => {
                    child.attributes([])?;
                    self.leaf(&child)?;
                    TypeAttributes::String
                }
                "Enumeration" => self.enumeration_type(&child)?,
                _ => return Err(unknown(&child, element)),
            });
        }
        Ok(SimpleType {
            name: element.required("name", name)?.text()?,
            description: optional(description, Attribute::text)?,
            attributes: attributes.ok_or_else(|| element.refused(NO_TYPE))?,
        })
    }

    fn real_type(&mut self, element: &Element<'_>) -> Result<TypeAttributes, Error> {
        let [quantity, unit, display_unit, relative_quantity, min, max, nominal, unbounded] = element.attributes([
            "quantity",
            "unit",
            "displayUnit",
            "relativeQuantity",
            "min",
            "max",
            "nominal",
            "unbounded",
        ])?;
        self.leaf(element)?;
        Ok(TypeAttributes::Real(RealAttributes {
            quantity: optional(quantity, Attribute::text)?,
            unit: optional(unit, Attribute::text)?,
            display_unit: optional(display_unit, Attribute::text)?,
            relative_quantity: optional(relative_quantity, Attribute::boolean)?,
            min: optional(min, Attribute::real)?,
            max: optional(max, Attribute::real)?,
            nominal: optional(nominal, Attribute::real)?,
            unbounded: optional(unbounded, Attribute::boolean)?,
        }))
    }

    fn integer_type(&mut self, element: &Element<'_>) -> Result<TypeAttributes, Error> {
        let [quantity, min, max] = element.attributes(["quantity", "min", "max"])?;
        self.leaf(element)?;
        Ok(TypeAttributes::Integer(IntegerAttributes {
            quantity: optional(quantity, Attribute::text)?,
            min: optional(min, Attribute::integer)?,
            max: optional(max, Attribute::integer)?,
        }))
    }

    fn enumeration_type(&mut self, element: &Element<'_>) -> Result<TypeAttributes, Error> {
        let [quantity] = element.attributes(["quantity"])?;
        let mut items = Vec::new();
        while let Some(child) = self.child(element)? {
            if child.name() != "Item" {
                return Err(unknown(&child, element));
            }
            let [name, value, description] = child.attributes(["name", "value", "description"])?;
            items.push(Item {
                name: child.required("name", name)?.text()?,
                value: child.required("value", value)?.integer()?,
                description: optional(description, Attribute::text)?,
            });
            self.leaf(&child)?;
        }
        Ok(TypeAttributes::Enumeration { quantity: optional(quantity, Attribute::text)?, items })
    }

    fn log_category(&mut self, element: &Element<'_>) -> Result<LogCategory, Error> {
        let [name, description] = element.attributes(["name", "description"])?;
        self.leaf(element)?;
        Ok(LogCategory {
            name: element.required("name", name)?.text()?,
            description: optional(description, Attribute::text)?,
        })
    }

    fn default_experiment(&mut self, element: &Element<'_>) -> Result<DefaultExperiment, Error> {
        let [start_time, stop_time, tolerance, step_size] =
            element.attributes(["startTime", "stopTime", "tolerance", "stepSize"])?;
        self.leaf(element)?;
        Ok(DefaultExperiment {
            start_time: optional(start_time, Attribute::real)?,
            stop_time: optional(stop_time, Attribute::real)?,
            tolerance: optional(tolerance, Attribute::real)?,
            step_size: optional(step_size, Attribute::real)?,
        })
    }

    fn variable(&mut self, element: &Element<'_>) -> Result<Variable, Error> {
        let [name, value_reference, description, causality, variability, initial, can_handle_multiple_set] = element
            .attributes([
                "name",
                "valueReference",
                "description",
                "causality",
                "variability",
                "initial",
                "canHandleMultipleSetPerTimeInstant",
            ])?;
        let mut typed = None;
        let mut once = Once::default();
        while let Some(child) = self.child(element)? {
            if child.name() == "Annotations" {
                once.add(&child)?;
                self.skip(&child)?;
                continue;
            }
            let is_second = typed.is_some();
            typed = Some(match child.name() {
                _ if is_second => return Err(child.refused("a variable is of one type: remove this element")),
                "Real" => Typed::Real(self.real(&child)?),
                "Integer" => Typed::Integer(self.integer(&child)?),
                "Boolean" => Typed::Boolean(self.boolean(&child)?),
                "String" => Typed::String(self.text(&child)?),
                "Enumeration" => Typed::Enumeration(self.enumeration(&child)?),
                _ => return Err(unknown(&child, element)),
            });
        }
        Ok(Variable {
            name: element.required("name", name)?.text()?,
            value_reference: element.required("valueReference", value_reference)?.unsigned()?,
            description: optional(description, Attribute::text)?,
            causality: optional(causality, Attribute::word)?.unwrap_or_default(),
            variability: optional(variability, Attribute::word)?.unwrap_or_default(),
            initial: optional(initial, Attribute::word)?,
            can_handle_multiple_set_per_time_instant: optional(can_handle_multiple_set, Attribute::boolean)?,
            typed: typed.ok_or_else(|| element.refused(NO_TYPE))?,
        })
    }

    fn real(&mut self, element: &Element<'_>) -> Result<Real, Error> {
        let [
            declared_type,
            quantity,
            unit,
            display_unit,
            relative_quantity,
            min,
            max,
            nominal,
            unbounded,
            start,
            derivative,
            reinit,
        ] = element.attributes([
            "declaredType",
            "quantity",
            "unit",
            "displayUnit",
            "relativeQuantity",
            "min",
            "max",
            "nominal",
            "unbounded",
            "start",
            "derivative",
            "reinit",
        ])?;
        self.leaf(element)?;
        Ok(Real {
            declared_type: optional(declared_type, Attribute::text)?,
            attributes: RealAttributes {
                quantity: optional(quantity, Attribute::text)?,
                unit: optional(unit, Attribute::text)?,
                display_unit: optional(display_unit, Attribute::text)?,
                relative_quantity: optional(relative_quantity, Attribute::boolean)?,
                min: optional(min, Attribute::real)?,
                max: optional(max, Attribute::real)?,
                nominal: optional(nominal, Attribute::real)?,
                unbounded: optional(unbounded, Attribute::boolean)?,
            },
            start: optional(start, Attribute::real)?,
            derivative: optional(derivative, Attribute::unsigned)?,
            reinit: flag(reinit)?,
        })
    }

    fn integer(&mut self, element: &Element<'_>) -> Result<Integer, Error> {
        let [declared_type, quantity, min, max, start] =
            element.attributes(["declaredType", "quantity", "min", "max", "start"])?;
        self.leaf(element)?;
        Ok(Integer {
            declared_type: optional(declared_type, Attribute::text)?,
            attributes: IntegerAttributes {
                quantity: optional(quantity, Attribute::text)?,
                min: optional(min, Attribute::integer)?,
                max: optional(max, Attribute::integer)?,
            },
            start: optional(start, Attribute::integer)?,
        })
    }

    fn boolean(&mut self, element: &Element<'_>) -> Result<Boolean, Error> {
        let [declared_type, start] = element.attributes(["declaredType", "start"])?;
        self.leaf(element)?;
        Ok(Boolean {
            declared_type: optional(declared_type, Attribute::text)?,
            start: optional(start, Attribute::boolean)?,
        })
    }

    fn text(&mut self, element: &Element<'_>) -> Result<Text, Error> {
        let [declared_type, start] = element.attributes(["declaredType", "start"])?;
        self.leaf(element)?;
        Ok(Text { declared_type: optional(declared_type, Attribute::text)?, start: optional(start, Attribute::text)? })
    }

    fn enumeration(&mut self, element: &Element<'_>) -> Result<Enumeration, Error> {
        let [declared_type, quantity, min, max, start] =
            element.attributes(["declaredType", "quantity", "min", "max", "start"])?;
        self.leaf(element)?;
        Ok(Enumeration {
            declared_type: element.required("declaredType", declared_type)?.text()?,
            attributes: IntegerAttributes {
                quantity: optional(quantity, Attribute::text)?,
                min: optional(min, Attribute::integer)?,
                max: optional(max, Attribute::integer)?,
            },
            start: optional(start, Attribute::integer)?,
        })
    }

    fn model_structure(&mut self, element: &Element<'_>) -> Result<ModelStructure, Error> {
        element.attributes([])?;
        let mut structure = ModelStructure::default();
        let mut once = Once::default();
        while let Some(child) = self.child(element)? {
            let list = match child.name() {
                "Outputs" => &mut structure.outputs,
                "Derivatives" => &mut structure.derivatives,
                "InitialUnknowns" => &mut structure.initial_unknowns,
                _ => return Err(unknown(&child, element)),
            };
            once.add(&child)?;
            *list = self.list(&child, "Unknown", Self::unknown)?;
        }
        Ok(structure)
    }

    fn unknown(&mut self, element: &Element<'_>) -> Result<Unknown, Error> {
        let [index, dependencies, dependencies_kind] =
            element.attributes(["index", "dependencies", "dependenciesKind"])?;
        self.leaf(element)?;
        Ok(Unknown {
            index: element.required("index", index)?.unsigned()?,
            dependencies: optional(dependencies, Attribute::indices)?,
            dependencies_kind: optional(dependencies_kind, Attribute::words)?,
        })
    }
}

const NO_TYPE: &str = "the type is missing: put Real, Integer, Boolean, String or Enumeration inside";

fn cut_off(element: &Element<'_>) -> Error {
    element.refused("the file ends before the element does: it is cut off")
}

fn unknown(child: &Element<'_>, parent: &Element<'_>) -> Error {
    child.refused(&format!("FMI 2.0 has no such element inside {}: remove it", parent.name()))
}

/// A flag that is false if it is absent.
fn flag(attribute: Option<Attribute<'_>>) -> Result<bool, Error> {
    Ok(optional(attribute, Attribute::boolean)?.unwrap_or(false))
}

/// Before anything else, for other versions of FMI have other attributes.
fn check_version(root: &Element<'_>) -> Result<(), Error> {
    let mut attributes = root.tag.attributes();
    let attributes = attributes.with_checks(false).filter_map(Result::ok);
    let Some(version) = attributes.into_iter().find(|attribute| attribute.key.0 == "fmiVersion") else {
        return Err(root.refused("attribute fmiVersion is missing: add fmiVersion=\"2.0\" if it is FMI 2.0"));
    };
    if version.value != FMI_VERSION {
        let version = shortened(&version.value);
        return Err(root.refused(&format!("fmiVersion = {version:?}: only FMI {FMI_VERSION} is read")));
    }
    Ok(())
}
