//! A model description as XML.

use crate::description::{
    BaseUnit, CoSimulation, DefaultExperiment, DisplayUnit, FMI_VERSION, IntegerAttributes, Item, LogCategory,
    ModelDescription, ModelExchange, ModelStructure, RealAttributes, SimpleType, TypeAttributes, Typed, Unit, Unknown,
    Variable,
};
use crate::lexical::{is_xml, real_text};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::borrow::Cow;

/// A modelDescription.xml: elements and attributes in the order of the standard's schema, no empty lists, no namespace,
/// no date but a given one. The same description gives the same bytes.
///
/// Attributes whose value is the standard's default are left out, but for the capability flags and for causality and
/// variability: what they say should be seen. Characters that XML cannot hold (most control characters) become U+FFFD;
/// [`check`](crate::check()) reports them.
pub fn write(description: &ModelDescription) -> Vec<u8> {
    let mut xml = Xml(Writer::new_with_indent(Vec::new(), b' ', 2));
    xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    let root = Tag::new("fmiModelDescription")
        .text("fmiVersion", FMI_VERSION)
        .text("modelName", &description.model_name)
        .text("guid", &description.guid)
        .optional_text("description", &description.description)
        .optional_text("author", &description.author)
        .optional_text("version", &description.version)
        .optional_text("copyright", &description.copyright)
        .optional_text("license", &description.license)
        .optional_text("generationTool", &description.generation_tool)
        .optional_text("generationDateAndTime", &description.generation_date_and_time)
        .text("variableNamingConvention", description.variable_naming_convention.word())
        .optional("numberOfEventIndicators", description.number_of_event_indicators);
    xml.element(root, |xml| {
        if let Some(model_exchange) = &description.model_exchange {
            xml.model_exchange(model_exchange);
        }
        if let Some(co_simulation) = &description.co_simulation {
            xml.co_simulation(co_simulation);
        }
        xml.list("UnitDefinitions", &description.unit_definitions, Xml::unit);
        xml.list("TypeDefinitions", &description.type_definitions, Xml::simple_type);
        xml.list("LogCategories", &description.log_categories, Xml::log_category);
        if let Some(experiment) = &description.default_experiment {
            xml.default_experiment(experiment);
        }
        xml.element(Tag::new("ModelVariables"), |xml| {
            description.model_variables.iter().for_each(|variable| xml.variable(variable));
        });
        xml.model_structure(&description.model_structure);
    });
    let mut bytes = xml.0.into_inner();
    bytes.push(b'\n');
    bytes
}

/// A start tag with its attributes.
struct Tag(BytesStart<'static>);

impl Tag {
    fn new(name: &'static str) -> Tag {
        Tag(BytesStart::new(name))
    }

    fn text(mut self, name: &str, value: &str) -> Tag {
        let value = if value.chars().all(is_xml) {
            Cow::Borrowed(value)
        } else {
            Cow::Owned(value.chars().map(|character| if is_xml(character) { character } else { '\u{fffd}' }).collect())
        };
        // Escapes line breaks and tabs too, which a reader would take for spaces.
        self.0.push_attribute((name, value.as_ref()));
        self
    }

    fn optional_text(self, name: &str, value: &Option<String>) -> Tag {
        match value {
            Some(value) => self.text(name, value),
            None => self,
        }
    }

    fn value(self, name: &str, value: impl ToString) -> Tag {
        self.text(name, &value.to_string())
    }

    fn optional(self, name: &str, value: Option<impl ToString>) -> Tag {
        match value {
            Some(value) => self.value(name, value),
            None => self,
        }
    }

    fn real(self, name: &str, value: Option<f64>) -> Tag {
        self.optional(name, value.map(real_text))
    }

    fn not_default<T: ToString + PartialEq>(self, name: &str, value: T, default: T) -> Tag {
        if value == default { self } else { self.value(name, value) }
    }

    fn real_not_default(self, name: &str, value: f64, default: f64) -> Tag {
        self.real(name, (value.to_bits() != default.to_bits()).then_some(value))
    }

    fn real_attributes(self, attributes: &RealAttributes) -> Tag {
        self.optional_text("quantity", &attributes.quantity)
            .optional_text("unit", &attributes.unit)
            .optional_text("displayUnit", &attributes.display_unit)
            .optional("relativeQuantity", attributes.relative_quantity)
            .real("min", attributes.min)
            .real("max", attributes.max)
            .real("nominal", attributes.nominal)
            .optional("unbounded", attributes.unbounded)
    }

    fn integer_attributes(self, attributes: &IntegerAttributes) -> Tag {
        self.optional_text("quantity", &attributes.quantity)
            .optional("min", attributes.min)
            .optional("max", attributes.max)
    }
}

struct Xml(Writer<Vec<u8>>);

impl Xml {
    fn event(&mut self, event: Event<'_>) {
        self.0.write_event(event).expect("a Vec takes all bytes");
    }

    fn empty(&mut self, tag: Tag) {
        self.event(Event::Empty(tag.0));
    }

    fn element(&mut self, tag: Tag, children: impl FnOnce(&mut Xml)) {
        let end = BytesEnd::new(tag.0.name().0.to_owned());
        self.event(Event::Start(tag.0));
        children(self);
        self.event(Event::End(end));
    }

    /// An element around all items; nothing if there are none.
    fn list<T>(&mut self, name: &'static str, items: &[T], mut item: impl FnMut(&mut Xml, &T)) {
        if !items.is_empty() {
            self.element(Tag::new(name), |xml| items.iter().for_each(|each| item(xml, each)));
        }
    }

    /// An element that is empty if there are no items.
    fn parent<T>(&mut self, tag: Tag, items: &[T], mut item: impl FnMut(&mut Xml, &T)) {
        if items.is_empty() {
            self.empty(tag);
        } else {
            self.element(tag, |xml| items.iter().for_each(|each| item(xml, each)));
        }
    }

    fn model_exchange(&mut self, flags: &ModelExchange) {
        let tag = Tag::new("ModelExchange")
            .text("modelIdentifier", &flags.model_identifier)
            .value("needsExecutionTool", flags.needs_execution_tool)
            .value("completedIntegratorStepNotNeeded", flags.completed_integrator_step_not_needed)
            .value("canBeInstantiatedOnlyOncePerProcess", flags.can_be_instantiated_only_once_per_process)
            .value("canNotUseMemoryManagementFunctions", flags.can_not_use_memory_management_functions)
            .value("canGetAndSetFMUstate", flags.can_get_and_set_fmu_state)
            .value("canSerializeFMUstate", flags.can_serialize_fmu_state)
            .value("providesDirectionalDerivative", flags.provides_directional_derivative);
        self.source_files(tag, &flags.source_files);
    }

    fn co_simulation(&mut self, flags: &CoSimulation) {
        let tag = Tag::new("CoSimulation")
            .text("modelIdentifier", &flags.model_identifier)
            .value("needsExecutionTool", flags.needs_execution_tool)
            .value("canHandleVariableCommunicationStepSize", flags.can_handle_variable_communication_step_size)
            .value("canInterpolateInputs", flags.can_interpolate_inputs)
            .value("maxOutputDerivativeOrder", flags.max_output_derivative_order)
            .value("canRunAsynchronuously", flags.can_run_asynchronuously)
            .value("canBeInstantiatedOnlyOncePerProcess", flags.can_be_instantiated_only_once_per_process)
            .value("canNotUseMemoryManagementFunctions", flags.can_not_use_memory_management_functions)
            .value("canGetAndSetFMUstate", flags.can_get_and_set_fmu_state)
            .value("canSerializeFMUstate", flags.can_serialize_fmu_state)
            .value("providesDirectionalDerivative", flags.provides_directional_derivative);
        self.source_files(tag, &flags.source_files);
    }

    fn source_files(&mut self, tag: Tag, files: &[String]) {
        if files.is_empty() {
            self.empty(tag);
        } else {
            self.element(tag, |xml| {
                xml.list("SourceFiles", files, |xml, file| xml.empty(Tag::new("File").text("name", file)));
            });
        }
    }

    fn unit(&mut self, unit: &Unit) {
        let tag = Tag::new("Unit").text("name", &unit.name);
        if unit.base_unit.is_none() && unit.display_units.is_empty() {
            return self.empty(tag);
        }
        self.element(tag, |xml| {
            if let Some(base) = &unit.base_unit {
                xml.base_unit(base);
            }
            unit.display_units.iter().for_each(|display_unit| xml.display_unit(display_unit));
        });
    }

    fn base_unit(&mut self, base: &BaseUnit) {
        let tag = Tag::new("BaseUnit")
            .not_default("kg", base.kg, 0)
            .not_default("m", base.m, 0)
            .not_default("s", base.s, 0)
            .not_default("A", base.A, 0)
            .not_default("K", base.K, 0)
            .not_default("mol", base.mol, 0)
            .not_default("cd", base.cd, 0)
            .not_default("rad", base.rad, 0)
            .real_not_default("factor", base.factor, 1.0)
            .real_not_default("offset", base.offset, 0.0);
        self.empty(tag);
    }

    fn display_unit(&mut self, display_unit: &DisplayUnit) {
        let tag = Tag::new("DisplayUnit")
            .text("name", &display_unit.name)
            .real_not_default("factor", display_unit.factor, 1.0)
            .real_not_default("offset", display_unit.offset, 0.0);
        self.empty(tag);
    }

    fn simple_type(&mut self, simple_type: &SimpleType) {
        let tag = Tag::new("SimpleType")
            .text("name", &simple_type.name)
            .optional_text("description", &simple_type.description);
        self.element(tag, |xml| match &simple_type.attributes {
            TypeAttributes::Real(attributes) => xml.empty(Tag::new("Real").real_attributes(attributes)),
            TypeAttributes::Integer(attributes) => xml.empty(Tag::new("Integer").integer_attributes(attributes)),
            TypeAttributes::Boolean => xml.empty(Tag::new("Boolean")),
            TypeAttributes::String => xml.empty(Tag::new("String")),
            TypeAttributes::Enumeration { quantity, items } => {
                xml.parent(Tag::new("Enumeration").optional_text("quantity", quantity), items, Xml::item);
            }
        });
    }

    fn item(&mut self, item: &Item) {
        let tag = Tag::new("Item")
            .text("name", &item.name)
            .value("value", item.value)
            .optional_text("description", &item.description);
        self.empty(tag);
    }

    fn log_category(&mut self, category: &LogCategory) {
        let tag = Tag::new("Category").text("name", &category.name).optional_text("description", &category.description);
        self.empty(tag);
    }

    fn default_experiment(&mut self, experiment: &DefaultExperiment) {
        let tag = Tag::new("DefaultExperiment")
            .real("startTime", experiment.start_time)
            .real("stopTime", experiment.stop_time)
            .real("tolerance", experiment.tolerance)
            .real("stepSize", experiment.step_size);
        self.empty(tag);
    }

    fn variable(&mut self, variable: &Variable) {
        let tag = Tag::new("ScalarVariable")
            .text("name", &variable.name)
            .value("valueReference", variable.value_reference)
            .optional_text("description", &variable.description)
            .value("causality", variable.causality)
            .value("variability", variable.variability)
            .optional("initial", variable.initial)
            .optional("canHandleMultipleSetPerTimeInstant", variable.can_handle_multiple_set_per_time_instant);
        let typed = Tag::new(variable.typed.name());
        let typed = match &variable.typed {
            Typed::Real(real) => typed
                .optional_text("declaredType", &real.declared_type)
                .real_attributes(&real.attributes)
                .real("start", real.start)
                .optional("derivative", real.derivative)
                .not_default("reinit", real.reinit, false),
            Typed::Integer(integer) => typed
                .optional_text("declaredType", &integer.declared_type)
                .integer_attributes(&integer.attributes)
                .optional("start", integer.start),
            Typed::Boolean(boolean) => {
                typed.optional_text("declaredType", &boolean.declared_type).optional("start", boolean.start)
            }
            Typed::String(text) => {
                typed.optional_text("declaredType", &text.declared_type).optional_text("start", &text.start)
            }
            Typed::Enumeration(enumeration) => typed
                .text("declaredType", &enumeration.declared_type)
                .integer_attributes(&enumeration.attributes)
                .optional("start", enumeration.start),
        };
        self.element(tag, |xml| xml.empty(typed));
    }

    fn model_structure(&mut self, structure: &ModelStructure) {
        let lists = [
            ("Outputs", &structure.outputs),
            ("Derivatives", &structure.derivatives),
            ("InitialUnknowns", &structure.initial_unknowns),
        ];
        let lists: Vec<_> = lists.into_iter().filter(|(_, unknowns)| !unknowns.is_empty()).collect();
        self.parent(Tag::new("ModelStructure"), &lists, |xml, (name, unknowns)| xml.list(name, unknowns, Xml::unknown));
    }

    fn unknown(&mut self, unknown: &Unknown) {
        let tag = Tag::new("Unknown")
            .value("index", unknown.index)
            .optional("dependencies", unknown.dependencies.as_ref().map(|indices| joined(indices)))
            .optional("dependenciesKind", unknown.dependencies_kind.as_ref().map(|kinds| joined(kinds)));
        self.empty(tag);
    }
}

/// A list as XML Schema writes it.
fn joined<T: ToString>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}
