//! The types of the Rust source, and the values of its expressions.

use scl::ir::{Convert, Expr, Place, Scalar};
use std::fmt;

/// A type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Ty {
    /// An integer literal whose type is not determined yet.
    Integer,
    /// A floating-point literal whose type is not determined yet.
    Float,
    Scalar(Scalar),
    /// A newtype of a number.
    New {
        name: String,
        /// The type in which a variable stores it.
        kept: Scalar,
        /// The type of its field in Rust.
        inner: Scalar,
    },
    /// A block or its memory, as a record index.
    Struct(usize),
    /// A tuple; without elements, it is `()`.
    Tuple(Vec<Ty>),
    Option(Box<Ty>),
    /// The type of an expression that never returns, such as `return`.
    Never,
}

impl Ty {
    pub(crate) const BOOL: Ty = Ty::Scalar(Scalar::Bool);

    pub(crate) fn unit() -> Ty {
        Ty::Tuple(Vec::new())
    }

    /// The scalar in which a variable of this type is stored; `None` if the type is not that of a single number.
    pub(crate) fn kept(&self) -> Option<Scalar> {
        match self {
            Ty::Scalar(scalar) => Some(*scalar),
            Ty::New { kept, .. } => Some(*kept),
            _ => None,
        }
    }

    /// The common type of two expressions, such as the branches of an `if`; `None` if they have none.
    pub(crate) fn unified(&self, other: &Ty) -> Option<Ty> {
        Some(match (self, other) {
            (Ty::Never, ty) | (ty, Ty::Never) => ty.clone(),
            (Ty::Integer, Ty::Scalar(scalar)) | (Ty::Scalar(scalar), Ty::Integer) if scalar.is_integer() => {
                Ty::Scalar(*scalar)
            }
            (Ty::Float, Ty::Scalar(scalar)) | (Ty::Scalar(scalar), Ty::Float) if scalar.is_float() => {
                Ty::Scalar(*scalar)
            }
            (Ty::Tuple(a), Ty::Tuple(b)) if a.len() == b.len() => {
                Ty::Tuple(a.iter().zip(b).map(|(a, b)| a.unified(b)).collect::<Option<_>>()?)
            }
            (Ty::Option(a), Ty::Option(b)) => Ty::Option(Box::new(a.unified(b)?)),
            (a, b) if a == b => a.clone(),
            _ => return None,
        })
    }

    /// Whether the type is fully determined.
    pub(crate) fn is_known(&self) -> bool {
        match self {
            Ty::Integer | Ty::Float | Ty::Never => false,
            Ty::Tuple(parts) => parts.iter().all(Ty::is_known),
            Ty::Option(of) => of.is_known(),
            _ => true,
        }
    }
}

impl fmt::Display for Ty {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Ty::Integer => formatter.write_str("an integer"),
            Ty::Float => formatter.write_str("a floating-point number"),
            Ty::Scalar(scalar) => write!(formatter, "{scalar}"),
            Ty::New { name, .. } => formatter.write_str(name),
            Ty::Struct(_) => formatter.write_str("a struct"),
            Ty::Tuple(parts) => {
                let parts: Vec<String> = parts.iter().map(Ty::to_string).collect();
                write!(formatter, "({})", parts.join(", "))
            }
            Ty::Option(of) => write!(formatter, "Option<{of}>"),
            Ty::Never => formatter.write_str("nothing"),
        }
    }
}

/// The value of an expression.
#[derive(Clone, Debug)]
pub(crate) enum Val {
    /// A computed number.
    Number(Expr, Ty),
    /// A variable that is not a single number.
    Var(Var),
    Tuple(Vec<Val>),
    /// `Some`, or `None`.
    Option(Option<Box<Val>>),
    /// A rounded floating-point number, which can only be converted to an integer: rounding mode, number and type.
    Rounded(Convert, Expr, Scalar),
    /// The ordering of two numbers of this type.
    Compared(Expr, Expr, Scalar),
    /// A range: start, end, whether the end is inclusive, and the type.
    Range(Expr, Expr, bool, Scalar),
}

/// A variable.
#[derive(Clone, Debug)]
pub(crate) enum Var {
    /// A number or a struct.
    Place(Place, Ty),
    Tuple(Vec<Var>),
    /// The place of a flag that is true for `Some`, and the variable that holds the value in that case.
    Option(Place, Box<Var>),
}

impl Var {
    pub(crate) fn ty(&self) -> Ty {
        match self {
            Var::Place(_, ty) => ty.clone(),
            Var::Tuple(parts) => Ty::Tuple(parts.iter().map(Var::ty).collect()),
            Var::Option(_, value) => Ty::Option(Box::new(value.ty())),
        }
    }

    /// The places of its numbers, in order.
    pub(crate) fn places(&self) -> Vec<Place> {
        match self {
            Var::Place(place, _) => vec![place.clone()],
            Var::Tuple(parts) => parts.iter().flat_map(Var::places).collect(),
            Var::Option(some, value) => {
                let mut places = vec![some.clone()];
                places.extend(value.places());
                places
            }
        }
    }

    /// Returns the variable's value.
    pub(crate) fn load(&self) -> Val {
        match self {
            Var::Place(place, ty) => match ty.kept() {
                Some(kept) => Val::Number(Expr::Load(kept, place.clone()), ty.clone()),
                None => Val::Var(self.clone()),
            },
            Var::Tuple(parts) => Val::Tuple(parts.iter().map(Var::load).collect()),
            Var::Option(..) => Val::Var(self.clone()),
        }
    }
}
