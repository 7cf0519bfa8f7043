//! The layout of variables, and their start values.

use super::{Base, Function, Member, Place, Program, Record, Scalar, Step, Type};
use crate::front::syntax::key;
use blocks::{Block, EachBlock, Kind, Time, Value, Word, for_each_block};

/// The smallest multiple of `align`, a power of 2, that is not below `offset`.
pub fn align(offset: usize, align: usize) -> usize {
    offset.next_multiple_of(align.max(1))
}

impl Program {
    /// Adds a record with its members in order, each aligned, and the start values of their types.
    pub fn add_record(&mut self, name: impl Into<String>, members: impl IntoIterator<Item = (String, Type)>) -> usize {
        let mut record = Record { name: name.into(), align: 1, ..Record::default() };
        for (name, ty) in members {
            self.add_member(&mut record, name, ty);
        }
        record.start.resize(align(record.start.len(), record.align), 0);
        self.records.push(record);
        self.records.len() - 1
    }

    fn add_member(&self, record: &mut Record, name: String, ty: Type) {
        let alignment = self.align(&ty);
        let offset = align(record.start.len(), alignment);
        record.align = record.align.max(alignment);
        record.start.resize(offset, 0);
        record.start.extend(self.start(&ty));
        record.members.push(Member { name, ty, offset });
    }

    /// Appends a member to an existing record and returns its index. Records that contain this one must be added
    /// afterwards.
    pub fn extend_record(&mut self, record: usize, name: impl Into<String>, ty: Type) -> usize {
        let mut extended = std::mem::take(&mut self.records[record]);
        // The padding after the last member is available to the next one, as in C.
        let end = extended.members.last().map_or(0, |last| last.offset + self.size(&last.ty));
        extended.start.truncate(end);
        self.add_member(&mut extended, name.into(), ty);
        extended.start.resize(align(extended.start.len(), extended.align), 0);
        self.records[record] = extended;
        self.records[record].members.len() - 1
    }

    /// Adds the record of an instance of a block in [`blocks`]: the bytes are the block's stored state, the members are
    /// its rows. `None` if no block has that name.
    pub fn add_native(&mut self, name: &str) -> Option<usize> {
        struct Find<'a>(&'a str, Option<Record>);
        impl EachBlock for Find<'_> {
            fn block<B: Block>(&mut self) {
                if B::TABLE.name != self.0 {
                    return;
                }
                let mut block = B::default();
                let start = stored(&block);
                let members = B::TABLE.rows.iter().enumerate().map(|(index, row)| {
                    // A row's offset is that of the first stored byte that changes between two values with no byte in
                    // common.
                    let mut with = |value| {
                        block.set(index, value);
                        stored(&block)
                    };
                    let (zero, ones) = (with(Value::zero(row.kind)), with(ones(row.kind)));
                    let offset = zero.iter().zip(&ones).take_while(|(zero, one)| zero == one).count();
                    Member { name: row.name.to_string(), ty: Type::Scalar(scalar(row.kind)), offset }
                });
                let members = members.collect();
                self.1 = Some(Record { name: B::TABLE.name.to_string(), members, start, align: 1 });
            }
        }
        let mut find = Find(name, None);
        for_each_block(&mut find);
        self.records.push(find.1?);
        Some(self.records.len() - 1)
    }

    /// The size of a variable in bytes.
    pub fn size(&self, ty: &Type) -> usize {
        match ty {
            Type::Scalar(scalar) => scalar.size(),
            // An even size, as in C.
            Type::Text { capacity, wide } => align(2 + usize::from(*capacity) * (1 + usize::from(*wide)), 2),
            Type::Array { of, bounds } => {
                bounds.iter().fold(self.size(of), |size, (low, high)| size.saturating_mul(extent(*low, *high)))
            }
            Type::Open { .. } => 0,
            Type::Record(record) => self.records[*record].start.len(),
        }
    }

    /// The alignment of a variable, a power of 2.
    pub fn align(&self, ty: &Type) -> usize {
        match ty {
            Type::Scalar(scalar) => scalar.size(),
            Type::Text { .. } => 2,
            Type::Array { of, .. } => self.align(of),
            Type::Open { .. } => 1,
            Type::Record(record) => self.records[*record].align,
        }
    }

    /// The start values of a variable of this type, as bytes.
    pub fn start(&self, ty: &Type) -> Vec<u8> {
        match ty {
            Type::Record(record) => self.records[*record].start.clone(),
            Type::Array { of, .. } => {
                let one = self.start(of);
                let count = self.size(ty) / one.len().max(1);
                one.repeat(count)
            }
            _ => vec![0; self.size(ty)],
        }
    }

    /// The type of a place in a function; `None` if the place does not exist.
    pub fn type_of<'a>(&'a self, function: &'a Function, place: &Place) -> Option<Type> {
        let mut ty = match place.base {
            Base::Memory => Type::Record(self.memory),
            Base::Constants => Type::Record(self.constants),
            Base::Instance => Type::Record(function.instance?),
            Base::Local(local) => function.locals.get(local)?.ty.clone(),
        };
        for step in &place.steps {
            ty = match (step, ty) {
                (Step::Member(number), Type::Record(record)) => {
                    self.records.get(record)?.members.get(*number)?.ty.clone()
                }
                (Step::Index(indices, _), Type::Array { of, bounds }) if indices.len() == bounds.len() => *of,
                (Step::Index(indices, _), Type::Open { of, dimensions }) if indices.len() == dimensions => *of,
                (Step::Index(indices, _), Type::Text { wide, .. }) if indices.len() == 1 => {
                    Type::Scalar(if wide { Scalar::U16 } else { Scalar::U8 })
                }
                (Step::Length, Type::Text { .. }) => Type::Scalar(Scalar::U16),
                _ => return None,
            };
        }
        Some(ty)
    }

    /// The offset and type of a variable in memory, by its path (`motors[2].run`, `a[1,2]`; case-insensitive). Names
    /// that contain dots or brackets may be quoted; without quotes, the longest matching name is used.
    pub fn find(&self, path: &str) -> Option<(usize, Type)> {
        let mut ty = Type::Record(self.memory);
        let mut offset = 0;
        let mut rest = path;
        loop {
            let Type::Record(record) = ty else { return None };
            let (member, after) = self.records[record].named(rest)?;
            (offset, ty, rest) = (offset + member.offset, member.ty.clone(), after);
            if let Some(indices) = rest.strip_prefix('[') {
                let (indices, after) = indices.split_once(']')?;
                let Type::Array { of, bounds } = ty else { return None };
                let indices =
                    indices.split(',').map(|index| index.trim().parse().ok()).collect::<Option<Vec<i32>>>()?;
                offset += element(&indices, &bounds)? * self.size(&of);
                (ty, rest) = (*of, after);
            }
            match rest.strip_prefix('.') {
                Some(next) => rest = next,
                None => return rest.is_empty().then_some((offset, ty)),
            }
        }
    }
}

impl Record {
    /// The member at the start of a path, and the rest of the path.
    fn named<'r, 'p>(&'r self, path: &'p str) -> Option<(&'r Member, &'p str)> {
        if let Some(quote) = path.chars().next().filter(|first| matches!(first, '"' | '\'')) {
            let (name, rest) = path[1..].split_once(quote)?;
            let name = key(name);
            return Some((self.members.iter().find(|member| key(&member.name) == name)?, rest));
        }
        let fits = |member: &'r Member| {
            let (name, rest) = path.split_at_checked(member.name.len())?;
            (key(name) == key(&member.name) && (rest.is_empty() || rest.starts_with(['.', '['])))
                .then_some((member, rest))
        };
        let members = self.members.iter().filter_map(fits);
        members.max_by_key(|(member, _)| member.name.len())
    }
}

/// The flat index of an array element; `None` if out of bounds.
fn element(indices: &[i32], bounds: &[(i32, i32)]) -> Option<usize> {
    if indices.len() != bounds.len() {
        return None;
    }
    let mut number = 0;
    for (index, (low, high)) in indices.iter().zip(bounds) {
        if !(*low..=*high).contains(index) {
            return None;
        }
        number = number * extent(*low, *high) + extent(*low, *index) - 1;
    }
    Some(number)
}

/// The number of indices from `low` to `high`.
pub(crate) fn extent(low: i32, high: i32) -> usize {
    usize::try_from(i64::from(high) - i64::from(low) + 1).unwrap_or(0)
}

/// The scalar type of a block's row.
pub const fn scalar(kind: Kind) -> Scalar {
    match kind {
        Kind::Real => Scalar::F32,
        Kind::LReal => Scalar::F64,
        Kind::Bool => Scalar::Bool,
        Kind::SInt => Scalar::I8,
        Kind::USInt | Kind::Byte => Scalar::U8,
        Kind::Int => Scalar::I16,
        Kind::UInt | Kind::Word => Scalar::U16,
        Kind::DInt | Kind::Time => Scalar::I32,
        Kind::UDInt | Kind::DWord => Scalar::U32,
        Kind::LInt | Kind::LTime => Scalar::I64,
        Kind::ULInt | Kind::LWord => Scalar::U64,
    }
}

/// The value of this type with all bits set, or TRUE.
fn ones(kind: Kind) -> Value {
    match kind {
        Kind::Real => Value::Real(f32::from_bits(u32::MAX)),
        Kind::LReal => Value::LReal(f64::from_bits(u64::MAX)),
        Kind::Time => Value::Time(Time::ms(-1)),
        Kind::Word => Value::Word(Word::new(-1)),
        Kind::Int => Value::Int(-1),
        Kind::Bool => Value::Bool(true),
        _ => Value::Whole(kind, -1),
    }
}

/// The stored bytes of a block.
fn stored(block: &impl Block) -> Vec<u8> {
    let mut bytes = Vec::new();
    block.write(&mut bytes);
    bytes
}
