//! The FMI 3.0 elements for variables and for types: one for each data type, with different names and attributes.

use super::description::{
    Alias, BinaryAttributes, Boolean, Causality, ClockAttributes, Common, Dimension, Float, FloatAttributes, Initial,
    Integer, IntegerAttributes, Item, Start, Variability,
};
use crate::error::Error;
use crate::xml::attributes::{Attributes, Child, Element, value, write};
use crate::xml::read::{Attribute, Document, Tag};
use crate::xml::write::Xml;

/// A variable.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variable {
    /// The attributes common to variables of all types.
    pub common: Common,
    /// Its type and the attributes of that type.
    pub typed: Typed,
    /// The size of each dimension of an array; empty for a scalar.
    pub dimensions: Vec<Dimension>,
    /// The values of a String or a Binary before initialization.
    pub starts: Vec<Start>,
    /// Its other names.
    pub aliases: Vec<Alias>,
}

/// The type of a variable, and the attributes of that type.
#[derive(Clone, Debug, PartialEq)]
pub enum Typed {
    /// A 32-bit floating-point number.
    Float32(Float),
    /// A 64-bit floating-point number.
    Float64(Float),
    /// A signed 8-bit integer.
    Int8(Integer),
    /// An unsigned 8-bit integer.
    UInt8(Integer),
    /// A signed 16-bit integer.
    Int16(Integer),
    /// An unsigned 16-bit integer.
    UInt16(Integer),
    /// A signed 32-bit integer.
    Int32(Integer),
    /// An unsigned 32-bit integer.
    UInt32(Integer),
    /// A signed 64-bit integer.
    Int64(Integer),
    /// An unsigned 64-bit integer.
    UInt64(Integer),
    /// True or false.
    Boolean(Boolean),
    /// A string.
    String,
    /// A byte string.
    Binary(BinaryAttributes),
    /// One of several named numbers.
    Enumeration(Integer),
    /// A clock, whose ticks trigger events.
    Clock(ClockAttributes),
}

/// A type that variables refer to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TypeDefinition {
    /// Its name, by which variables refer to it.
    pub name: String,
    /// A short description.
    pub description: Option<String>,
    /// The type and its attributes.
    pub attributes: TypeAttributes,
    /// The names and numbers of an enumeration.
    pub items: Vec<Item>,
}

/// The type of a [`TypeDefinition`], and the attributes of that type.
#[derive(Clone, Debug, PartialEq)]
pub enum TypeAttributes {
    /// A 32-bit floating-point number.
    Float32(FloatAttributes),
    /// A 64-bit floating-point number.
    Float64(FloatAttributes),
    /// A signed 8-bit integer.
    Int8(IntegerAttributes),
    /// An unsigned 8-bit integer.
    UInt8(IntegerAttributes),
    /// A signed 16-bit integer.
    Int16(IntegerAttributes),
    /// An unsigned 16-bit integer.
    UInt16(IntegerAttributes),
    /// A signed 32-bit integer.
    Int32(IntegerAttributes),
    /// An unsigned 32-bit integer.
    UInt32(IntegerAttributes),
    /// A signed 64-bit integer.
    Int64(IntegerAttributes),
    /// An unsigned 64-bit integer.
    UInt64(IntegerAttributes),
    /// True or false.
    Boolean,
    /// A string.
    String,
    /// A byte string.
    Binary(BinaryAttributes),
    /// One of several named numbers.
    Enumeration(IntegerAttributes),
    /// A clock, whose ticks trigger events.
    Clock(ClockAttributes),
}

/// Defines the elements of one kind: for each variant, its XML name and its attributes, if any.
macro_rules! typed {
    ($Enum:ident by default $default:expr, ending in $end:literal: $($Variant:ident $(($Content:ty))?),*) => {
        impl $Enum {
            /// The names of the elements.
            pub(crate) const NAMES: &'static [&'static str] = &[$(concat!(stringify!($Variant), $end)),*];

            /// The name of the element.
            fn element(&self) -> &'static str {
                match self { $( typed!(@pattern $Enum $Variant $(content $Content)?) => concat!(stringify!($Variant), $end), )* }
            }

            /// The standard's name for the type.
            pub fn name(&self) -> &'static str {
                match self { $( typed!(@pattern $Enum $Variant $(content $Content)?) => stringify!($Variant), )* }
            }

            /// The names of the attributes of an element.
            fn attributes(element: &str) -> &'static [&'static str] {
                $( if element == concat!(stringify!($Variant), $end) { return typed!(@names $($Content)?); } )*
                &[]
            }

            fn read<'e>(
                tag: &Tag<'_>,
                attributes: &mut impl Iterator<Item = Option<Attribute<'e>>>,
            ) -> Result<$Enum, Error> {
                $( if tag.name() == concat!(stringify!($Variant), $end) {
                    return Ok(typed!(@read $Enum $Variant tag attributes $($Content)?));
                } )*
                Err(tag.refused("it has no such type"))
            }

            fn write(&self, sink: &mut dyn FnMut(&'static str, &str)) {
                match self { $( typed!(@pattern $Enum $Variant $(of own $Content)?) => typed!(@write sink $(of own $Content)?), )* }
            }
        }

        impl Default for $Enum {
            fn default() -> $Enum {
                $default
            }
        }
    };
    (@pattern $Enum:ident $Variant:ident) => { $Enum::$Variant };
    (@pattern $Enum:ident $Variant:ident content $Content:ty) => { $Enum::$Variant(_) };
    (@pattern $Enum:ident $Variant:ident of $own:ident $Content:ty) => { $Enum::$Variant($own) };
    (@names) => { &[] };
    (@names $Content:ty) => { <$Content as Attributes>::NAMES };
    (@read $Enum:ident $Variant:ident $tag:ident $attributes:ident) => { $Enum::$Variant };
    (@read $Enum:ident $Variant:ident $tag:ident $attributes:ident $Content:ty) => {
        $Enum::$Variant(<$Content as Attributes>::read($tag, $attributes)?)
    };
    (@write $sink:ident) => { {} };
    (@write $sink:ident of $own:ident $Content:ty) => { <$Content as Attributes>::write($own, $sink) };
}

typed! {
    Typed by default Typed::Float64(Float::default()), ending in "":
    Float32(Float), Float64(Float), Int8(Integer), UInt8(Integer), Int16(Integer), UInt16(Integer), Int32(Integer),
    UInt32(Integer), Int64(Integer), UInt64(Integer), Boolean(Boolean), String, Binary(BinaryAttributes),
    Enumeration(Integer), Clock(ClockAttributes)
}

typed! {
    TypeAttributes by default TypeAttributes::Float64(FloatAttributes::default()), ending in "Type":
    Float32(FloatAttributes), Float64(FloatAttributes), Int8(IntegerAttributes), UInt8(IntegerAttributes),
    Int16(IntegerAttributes), UInt16(IntegerAttributes), Int32(IntegerAttributes), UInt32(IntegerAttributes),
    Int64(IntegerAttributes), UInt64(IntegerAttributes), Boolean, String, Binary(BinaryAttributes),
    Enumeration(IntegerAttributes), Clock(ClockAttributes)
}

/// The attributes of a tag: the common ones, and those of its type.
fn attributes<'e>(
    tag: &'e Tag<'_>,
    common: &[&'static str],
    own: &[&'static str],
) -> Result<impl Iterator<Item = Option<Attribute<'e>>>, Error> {
    let names = [common, own].concat();
    let mut found: Vec<Option<Attribute<'e>>> = (0..names.len()).map(|_| None).collect();
    tag.read_attributes(&names, &mut found)?;
    Ok(found.into_iter())
}

/// Reads a child element that may occur any number of times.
fn read_child<T: Element>(items: &mut Vec<T>, document: &mut Document<'_>, child: &Tag<'_>) -> Result<bool, Error> {
    if !T::NAMES.contains(&child.name()) {
        return Ok(false);
    }
    items.push(T::read(document, child)?);
    Ok(true)
}

impl Element for Variable {
    const NAMES: &'static [&'static str] = Typed::NAMES;

    fn read(document: &mut Document<'_>, tag: &Tag<'_>) -> Result<Variable, Error> {
        let mut attributes = attributes(tag, <Common as Attributes>::NAMES, Typed::attributes(tag.name()))?;
        let common = <Common as Attributes>::read(tag, &mut attributes)?;
        let mut variable = Variable { common, typed: Typed::read(tag, &mut attributes)?, ..Variable::default() };
        let has_starts = matches!(variable.typed, Typed::String | Typed::Binary(_));
        document.children(tag, |document, child| {
            Ok(read_child(&mut variable.dimensions, document, child)?
                || has_starts && read_child(&mut variable.starts, document, child)?
                || read_child(&mut variable.aliases, document, child)?)
        })?;
        Ok(variable)
    }

    fn write(&self, xml: &mut Xml) {
        xml.element(self.typed.element(), |xml| {
            Attributes::write(&self.common, &mut |name, value| xml.attribute(name, value));
            self.typed.write(&mut |name, value| xml.attribute(name, value));
            Child::write(&self.dimensions, xml);
            Child::write(&self.starts, xml);
            Child::write(&self.aliases, xml);
        });
    }
}

impl Element for TypeDefinition {
    const NAMES: &'static [&'static str] = TypeAttributes::NAMES;

    fn read(document: &mut Document<'_>, tag: &Tag<'_>) -> Result<TypeDefinition, Error> {
        let mut attributes = attributes(tag, &["name", "description"], TypeAttributes::attributes(tag.name()))?;
        let mut definition = TypeDefinition {
            name: value(tag, "name", attributes.next().flatten(), None)?,
            description: value(tag, "description", attributes.next().flatten(), None)?,
            attributes: TypeAttributes::read(tag, &mut attributes)?,
            items: Vec::new(),
        };
        let has_items = matches!(definition.attributes, TypeAttributes::Enumeration(_));
        document
            .children(tag, |document, child| Ok(has_items && read_child(&mut definition.items, document, child)?))?;
        Ok(definition)
    }

    fn write(&self, xml: &mut Xml) {
        xml.element(self.attributes.element(), |xml| {
            write("name", &self.name, None, &mut |name, value| xml.attribute(name, value));
            write("description", &self.description, None, &mut |name, value| xml.attribute(name, value));
            self.attributes.write(&mut |name, value| xml.attribute(name, value));
            Child::write(&self.items, xml);
        });
    }
}

impl Variable {
    /// Its variability: as stated in the file, or the standard's default for its causality and type.
    pub fn variability(&self) -> Variability {
        use Causality::{CalculatedParameter, Parameter, StructuralParameter};
        self.common.variability.unwrap_or(match (self.common.causality, &self.typed) {
            (Parameter | CalculatedParameter | StructuralParameter, _) => Variability::Fixed,
            (_, Typed::Float32(_) | Typed::Float64(_)) => Variability::Continuous,
            _ => Variability::Discrete,
        })
    }

    /// How its initial value is determined: `initial` or, if that is absent, the standard's default for its causality
    /// and variability. `None` for a clock and for the independent variable.
    pub fn initial_or_default(&self) -> Option<Initial> {
        use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter, StructuralParameter};
        self.common.initial.or(match (self.common.causality, self.variability()) {
            _ if matches!(self.typed, Typed::Clock(_)) => None,
            (Independent, _) => None,
            (Input | Parameter | StructuralParameter, _) | (Output | Local, Variability::Constant) => {
                Some(Initial::Exact)
            }
            (CalculatedParameter | Output | Local, _) => Some(Initial::Calculated),
        })
    }

    /// Whether there is a start value.
    pub fn has_start(&self) -> bool {
        match &self.typed {
            Typed::Float32(own) | Typed::Float64(own) => own.start.is_some(),
            Typed::Boolean(own) => own.start.is_some(),
            Typed::String | Typed::Binary(_) => !self.starts.is_empty(),
            Typed::Clock(_) => false,
            other => other.integer().is_some_and(|(own, _)| own.start.is_some()),
        }
    }

    /// Its value reference.
    pub fn value_reference(&self) -> u32 {
        self.common.value_reference
    }
}

impl Typed {
    /// The contents of an integer or enumeration, with the range of its type.
    pub fn integer(&self) -> Option<(&Integer, (i128, i128))> {
        Some(match self {
            Typed::Int8(own) => (own, (i8::MIN.into(), i8::MAX.into())),
            Typed::UInt8(own) => (own, (0, u8::MAX.into())),
            Typed::Int16(own) => (own, (i16::MIN.into(), i16::MAX.into())),
            Typed::UInt16(own) => (own, (0, u16::MAX.into())),
            Typed::Int32(own) => (own, (i32::MIN.into(), i32::MAX.into())),
            Typed::UInt32(own) => (own, (0, u32::MAX.into())),
            Typed::Int64(own) | Typed::Enumeration(own) => (own, (i64::MIN.into(), i64::MAX.into())),
            Typed::UInt64(own) => (own, (0, u64::MAX.into())),
            _ => return None,
        })
    }

    /// Mutable access to the contents of an integer or enumeration.
    pub(super) fn integer_mut(&mut self) -> Option<&mut Integer> {
        match self {
            Typed::Int8(own)
            | Typed::UInt8(own)
            | Typed::Int16(own)
            | Typed::UInt16(own)
            | Typed::Int32(own)
            | Typed::UInt32(own)
            | Typed::Int64(own)
            | Typed::UInt64(own)
            | Typed::Enumeration(own) => Some(own),
            _ => None,
        }
    }

    /// The contents of a floating-point number.
    pub fn float(&self) -> Option<&Float> {
        match self {
            Typed::Float32(own) | Typed::Float64(own) => Some(own),
            _ => None,
        }
    }
}

impl TypeAttributes {
    /// The attributes of an integer or enumeration.
    pub fn integer(&self) -> Option<&IntegerAttributes> {
        use TypeAttributes::{Enumeration, Int8, Int16, Int32, Int64, UInt8, UInt16, UInt32, UInt64};
        match self {
            Int8(own) | UInt8(own) | Int16(own) | UInt16(own) | Int32(own) | UInt32(own) | Int64(own) | UInt64(own)
            | Enumeration(own) => Some(own),
            _ => None,
        }
    }

    /// The attributes of a floating-point number.
    pub fn float(&self) -> Option<&FloatAttributes> {
        match self {
            TypeAttributes::Float32(own) | TypeAttributes::Float64(own) => Some(own),
            _ => None,
        }
    }
}
