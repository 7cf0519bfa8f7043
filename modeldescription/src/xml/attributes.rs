//! The macros that expand each line of the tables in `description.rs`, common and per version, to a struct field and
//! the code that reads and writes it.
//!
//! [`elements!`] creates a struct for each element, or for a group of attributes shared by elements:
//!
//! ```text
//! Name "Element" {                                  a group has no "Element"
//!     field "attribute": Type;                      required
//!     field "attribute": Option<Type>;              may be absent
//!     field "attribute": Type = default;            may be absent, always written
//!     field "attribute": Type = default, omitted;   may be absent, written if it differs from the default
//!     field: Group;                                 the attributes of a group
//! }, children except "Annotations" {                 `except`: an element that is skipped
//!     field: Element;                               exactly one
//!     field: Option<Element>;                       at most one
//!     field: Vec<Element>;                          any number
//!     field in "List": Vec<Element>;                inside a list, which is left out if it is empty
//!     field in "List", required: Vec<Element>;      inside a list that is required, and written if empty
//! }
//! ```
//!
//! Attributes and children are written in the order of the lines, which is the schema's, and read in any order. The
//! struct's [`Default`] uses the defaults in the lines.
//!
//! [`choices!`] creates an enum from mutually exclusive elements, [`words!`] from the permitted values of an attribute.

use super::lexical::Value;
use super::read::{Attribute, Document, Tag};
use super::write::Xml;
use crate::error::Error;

/// A callback that receives the name and value of each attribute to be written.
pub(crate) type Sink<'a> = &'a mut dyn FnMut(&'static str, &str);

/// A struct with attributes.
pub(crate) trait Attributes: Sized {
    /// The names of the attributes, in the order of the schema.
    const NAMES: &'static [&'static str];

    /// Reads the attributes, which must be in the order of `NAMES`.
    fn read<'e>(tag: &Tag<'_>, attributes: &mut impl Iterator<Item = Option<Attribute<'e>>>) -> Result<Self, Error>;

    fn write(&self, sink: Sink<'_>);
}

/// An element of the schema, or a choice of several.
pub(crate) trait Element: Sized {
    /// The name of the element, or the names to choose from.
    const NAMES: &'static [&'static str];
    /// The message for a duplicate element.
    const TWICE: &'static str = TWICE;

    /// The message for a missing element.
    fn missing() -> String {
        missing(Self::NAMES[0])
    }

    /// Reads the element from its start tag to its end.
    fn read(document: &mut Document<'_>, tag: &Tag<'_>) -> Result<Self, Error>;

    fn write(&self, xml: &mut Xml);
}

/// The field for a child element: `T` once, `Option<T>` at most once, `Vec<T>` any number of times.
pub(crate) trait Child: Sized {
    /// Reads a child into the field; returns false if it belongs to another field.
    fn read(field: &mut Option<Self>, document: &mut Document<'_>, child: &Tag<'_>) -> Result<bool, Error>;

    /// Completes the field after all children of `parent` have been read.
    fn complete(field: Option<Self>, parent: &Tag<'_>) -> Result<Self, Error>;

    fn write(&self, xml: &mut Xml);
}

impl<T: Element> Child for T {
    fn read(field: &mut Option<T>, document: &mut Document<'_>, child: &Tag<'_>) -> Result<bool, Error> {
        if !T::NAMES.contains(&child.name()) {
            return Ok(false);
        }
        if field.is_some() {
            return Err(child.refused(T::TWICE));
        }
        *field = Some(Element::read(document, child)?);
        Ok(true)
    }

    fn complete(field: Option<T>, parent: &Tag<'_>) -> Result<T, Error> {
        field.ok_or_else(|| parent.refused(&T::missing()))
    }

    fn write(&self, xml: &mut Xml) {
        Element::write(self, xml);
    }
}

impl<T: Element> Child for Option<T> {
    fn read(field: &mut Option<Option<T>>, document: &mut Document<'_>, child: &Tag<'_>) -> Result<bool, Error> {
        Child::read(field.get_or_insert_default(), document, child)
    }

    fn complete(field: Option<Option<T>>, _: &Tag<'_>) -> Result<Option<T>, Error> {
        Ok(field.flatten())
    }

    fn write(&self, xml: &mut Xml) {
        self.iter().for_each(|element| Element::write(element, xml));
    }
}

impl<T: Element> Child for Vec<T> {
    fn read(field: &mut Option<Vec<T>>, document: &mut Document<'_>, child: &Tag<'_>) -> Result<bool, Error> {
        if !T::NAMES.contains(&child.name()) {
            return Ok(false);
        }
        field.get_or_insert_default().push(Element::read(document, child)?);
        Ok(true)
    }

    fn complete(field: Option<Vec<T>>, _: &Tag<'_>) -> Result<Vec<T>, Error> {
        Ok(field.unwrap_or_default())
    }

    fn write(&self, xml: &mut Xml) {
        self.iter().for_each(|element| Element::write(element, xml));
    }
}

pub(crate) const TWICE: &str = "the element occurs twice: remove one";

pub(crate) fn missing(element: &str) -> String {
    format!("element {element} is missing: add it")
}

/// The value of an attribute. If the attribute is absent, its value is `default` or, without one, [`Value::absent`].
pub(crate) fn value<T: Value>(
    tag: &Tag<'_>,
    name: &'static str,
    attribute: Option<Attribute<'_>>,
    default: Option<T>,
) -> Result<T, Error> {
    match attribute {
        Some(attribute) => attribute.value(),
        None => default.or_else(T::absent).ok_or_else(|| tag.refused(&format!("attribute {name} is missing: add it"))),
    }
}

/// Writes an attribute unless its value equals `omitted`.
pub(crate) fn write<T: Value>(name: &'static str, value: &T, omitted: Option<T>, sink: Sink<'_>) {
    // The strings are compared because they distinguish -0.0 from 0.0.
    if let Some(text) = value.text()
        && omitted.is_none_or(|omitted| omitted.text().as_ref() != Some(&text))
    {
        sink(name, &text);
    }
}

/// Reads a child into a field that holds the items of a list; returns false if it is not that list.
pub(crate) fn read_list<T: Element>(
    list: &str,
    field: &mut Option<Vec<T>>,
    document: &mut Document<'_>,
    child: &Tag<'_>,
) -> Result<bool, Error> {
    if child.name() != list {
        return Ok(false);
    }
    if field.is_some() {
        return Err(child.refused(TWICE));
    }
    child.attributes::<0>(&[])?;
    let mut items = None;
    document.children(child, |document, item| Child::read(&mut items, document, item))?;
    *field = Some(items.unwrap_or_default());
    Ok(true)
}

/// The total number of names in these parts.
pub(crate) const fn length(parts: &[&[&str]]) -> usize {
    let (mut length, mut part) = (0, 0);
    while part < parts.len() {
        length += parts[part].len();
        part += 1;
    }
    length
}

/// The names of all parts concatenated. `COUNT` is their [`length`].
pub(crate) const fn joined<const COUNT: usize>(parts: &[&[&'static str]]) -> [&'static str; COUNT] {
    let mut names = [""; COUNT];
    let (mut place, mut part) = (0, 0);
    while part < parts.len() {
        let mut name = 0;
        while name < parts[part].len() {
            names[place] = parts[part][name];
            (place, name) = (place + 1, name + 1);
        }
        part += 1;
    }
    names
}

macro_rules! elements {
    // `with` adds an attribute without a field, because its value is always the same; `and json` makes the struct
    // readable from JSON, where the attributes' names are the keys.
    ($(
        $(#[$meta:meta])*
        $Name:ident $($element:literal)? $(with $constant:literal = $fixed:ident)? $(and $json:ident)? {
            $($attributes:tt)*
        } $(, children $(except $skipped:literal)? { $($children:tt)* })?
    )*) => { $(
        elements!(@json ($($json)?) $Name [$(#[$meta])*] ($($element)?) ($($constant $fixed)?) ($($($skipped)?)?)
            { $($attributes)* } { $($($children)*)? });
    )* };

    // cfg(all()) is always true, cfg(any()) never.
    (@json () $($rest:tt)*) => { elements!(@struct any $($rest)*); };
    (@json (json) $($rest:tt)*) => { elements!(@struct all $($rest)*); };

    (@struct $json:ident $Name:ident [$($meta:tt)*]
        ($($element:literal)?) ($($constant:literal $fixed:ident)?) ($($skipped:literal)?)
        { $(
            $(#[$doc:meta])*
            $field:ident $($attribute:literal)? : $Type:ty $(= $default:expr $(, $omitted:ident)?)? ;
        )* }
        { $(
            $(#[$child_doc:meta])*
            $child:ident $(in $list:literal $(, $required:ident)?)? : $Child:ty ;
        )* }
    ) => {
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr($json(), derive(serde::Deserialize), serde(deny_unknown_fields))]
        $($meta)*
        pub struct $Name {
            $(
                $(#[$doc])*
                $(
                    #[doc = concat!("\n\nAttribute `", $attribute, "`")]
                    #[cfg_attr($json(), serde(rename = $attribute))]
                )?
                pub $field: $Type,
            )*
            $( $(#[$child_doc])* pub $child: $Child, )*
        }

        impl Default for $Name {
            fn default() -> $Name {
                $Name {
                    $( $field: elements!(@default $($default)?), )*
                    $( $child: Default::default(), )*
                }
            }
        }

        impl Attributes for $Name {
            const NAMES: &'static [&'static str] = {
                const PARTS: &[&[&str]] = &[$(&[$constant],)? $(elements!(@names $Type, ($($attribute)?))),*];
                &joined::<{ length(PARTS) }>(PARTS)
            };

            #[allow(unused_variables)]
            fn read<'e>(
                tag: &Tag<'_>,
                attributes: &mut impl Iterator<Item = Option<Attribute<'e>>>,
            ) -> Result<$Name, Error> {
                $( elements!(@constant $constant attributes); )?
                Ok($Name {
                    $( $field: elements!(@read tag attributes $Type, ($($attribute)?) ($($default)?)), )*
                    $( $child: Default::default(), )*
                })
            }

            #[allow(unused_variables)]
            fn write(&self, sink: Sink<'_>) {
                $( sink($constant, $fixed); )?
                $( elements!(@write (&self.$field) sink ($($attribute)?) ($($default $(, $omitted)?)?)); )*
            }
        }

        impl Element for $Name {
            const NAMES: &'static [&'static str] = &[concat!($($element)?)];

            #[allow(unused_mut, unused_variables)]
            fn read(document: &mut Document<'_>, tag: &Tag<'_>) -> Result<$Name, Error> {
                const COUNT: usize = <$Name as Attributes>::NAMES.len();
                let attributes = tag.attributes::<COUNT>(<$Name as Attributes>::NAMES)?;
                let mut element: $Name = Attributes::read(tag, &mut attributes.into_iter())?;
                $( let mut $child: Option<$Child> = None; )*
                let mut skipped = false;
                document.children(tag, |document, child| {
                    $( if elements!(@read_child $child document child $($list)?)? { return Ok(true); } )*
                    $( if child.name() == $skipped { return document.skip(child, &mut skipped); } )?
                    Ok(false)
                })?;
                $( element.$child = elements!(@complete $child tag $($list $(, $required)?)?); )*
                Ok(element)
            }

            fn write(&self, xml: &mut Xml) {
                xml.element(concat!($($element)?), |xml| {
                    Attributes::write(self, &mut |name, value| xml.attribute(name, value));
                    $( elements!(@write_child (&self.$child) xml $($list $(, $required)?)?); )*
                });
            }
        }
    };

    // The reader has already checked the value of this attribute.
    (@constant $name:literal $attributes:ident) => { $attributes.next() };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
    (@names $Group:ty, ()) => { <$Group as Attributes>::NAMES };
    (@names $Type:ty, ($name:literal)) => { &[$name] };
    (@read $tag:ident $attributes:ident $Group:ty, () ()) => { <$Group as Attributes>::read($tag, $attributes)? };
    (@read $tag:ident $attributes:ident $Type:ty, ($name:literal) ()) => {
        value::<$Type>($tag, $name, $attributes.next().flatten(), None)?
    };
    (@read $tag:ident $attributes:ident $Type:ty, ($name:literal) ($default:expr)) => {
        value::<$Type>($tag, $name, $attributes.next().flatten(), Some($default))?
    };
    (@write ($group:expr) $sink:ident () ()) => { Attributes::write($group, $sink) };
    (@write ($value:expr) $sink:ident ($name:literal) ($default:expr, omitted)) => {
        write($name, $value, Some($default), $sink)
    };
    (@write ($value:expr) $sink:ident ($name:literal) ($($default:expr)?)) => { write($name, $value, None, $sink) };
    (@read_child $field:ident $document:ident $child:ident) => { Child::read(&mut $field, $document, $child) };
    (@read_child $field:ident $document:ident $child:ident $list:literal) => {
        read_list($list, &mut $field, $document, $child)
    };
    (@complete $field:ident $tag:ident) => { Child::complete($field, $tag)? };
    (@complete $field:ident $tag:ident $list:literal) => { $field.unwrap_or_default() };
    (@complete $field:ident $tag:ident $list:literal, required) => {
        $field.ok_or_else(|| $tag.refused(&missing($list)))?
    };
    (@write_child ($child:expr) $xml:ident) => { Child::write($child, $xml) };
    (@write_child ($items:expr) $xml:ident $list:literal) => {
        if !$items.is_empty() {
            $xml.element($list, |xml| Child::write($items, xml));
        }
    };
    (@write_child ($items:expr) $xml:ident $list:literal, required) => {
        $xml.list($list, |xml| Child::write($items, xml))
    };
}
pub(crate) use elements;

macro_rules! choices {
    ($(
        $(#[$meta:meta])*
        $Name:ident of $owner:literal, by default $Default:ident {
            $( $(#[$doc:meta])* $Variant:ident($Content:ty); )*
        }
    )*) => { $(
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $Name { $( $(#[$doc])* $Variant($Content), )* }

        impl $Name {
            /// The standard's name for the type.
            pub fn name(&self) -> &'static str {
                match self { $( $Name::$Variant(_) => stringify!($Variant), )* }
            }
        }

        impl Default for $Name {
            fn default() -> $Name {
                $Name::$Default(Default::default())
            }
        }

        impl Element for $Name {
            const NAMES: &'static [&'static str] = &[$(stringify!($Variant)),*];
            const TWICE: &'static str = concat!($owner, " can have only one type: remove this element");

            fn missing() -> String {
                format!("the type is missing: add one of {}", Self::NAMES.join(", "))
            }

            fn read(document: &mut Document<'_>, tag: &Tag<'_>) -> Result<$Name, Error> {
                match tag.name() {
                    $( stringify!($Variant) => Element::read(document, tag).map($Name::$Variant), )*
                    _ => Err(tag.refused(&Self::missing())),
                }
            }

            fn write(&self, xml: &mut Xml) {
                match self { $( $Name::$Variant(content) => Element::write(content, xml), )* }
            }
        }
    )* };
}
pub(crate) use choices;

macro_rules! words {
    ($( $(#[$meta:meta])* $Name:ident { $( $(#[$value_meta:meta])* $Value:ident $word:literal, )* } )*) => { $(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $Name { $( $(#[$value_meta])* #[doc = concat!("`", $word, "`")] $Value, )* }

        impl $Name {
            /// The standard's word for it.
            pub fn word(self) -> &'static str {
                match self { $( $Name::$Value => $word, )* }
            }
        }

        impl Value for $Name {
            fn parse(text: &str) -> Option<$Name> {
                match text.trim_matches(SPACES) {
                    $( $word => Some($Name::$Value), )*
                    _ => None,
                }
            }

            fn expected() -> Cow<'static, str> {
                format!("one of {}", [$($word),*].join(", ")).into()
            }

            fn text(&self) -> Option<Cow<'_, str>> {
                Some(self.word().into())
            }
        }

        impl fmt::Display for $Name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(self.word())
            }
        }
    )* };
}
pub(crate) use words;
