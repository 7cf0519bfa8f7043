//! Adds the laws of blocks to a program.

use super::walk::change::{self, Change};
use super::{Body, Call, Program, Type};

/// A run of bytes that is contiguous in both layouts of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// Its offset in the law's record, which has padding between members.
    pub at: usize,
    /// Its offset in the program's packed instance.
    pub packed: usize,
    /// Its length in bytes.
    pub size: usize,
}

/// Adds an offset to the index of each called function.
struct Moves(usize);

impl Change for Moves {
    fn call(&mut self, call: &mut Call) {
        call.function += self.0;
    }
}

impl Program {
    /// Adds the law of a block, itself a program, so that this program can be printed as C: `native` is the function
    /// with this law as its body ([`Body::Native`]), `call` the function of `law` that calls the block. The machine is
    /// not affected.
    ///
    /// # Errors
    /// The law and the function belong to different blocks.
    pub fn add_law(&mut self, native: usize, law: &Program, call: usize) -> Result<(), String> {
        let (records, functions) = (self.records.len(), self.functions.len());
        let Body::Native(name) = self.functions[native].body else {
            return Err(format!("{} is not a block of this project", self.functions[native].name));
        };
        let ty = |ty: &mut Type| {
            let mut of = ty;
            while let Type::Array { of: inner, .. } | Type::Open { of: inner, .. } = of {
                of = inner;
            }
            if let Type::Record(record) = of {
                *record += records;
            }
        };
        for record in &law.records {
            let mut record = record.clone();
            record.members.iter_mut().for_each(|member| ty(&mut member.ty));
            self.records.push(record);
        }
        for function in &law.functions {
            let mut function = function.clone();
            function.instance.iter_mut().for_each(|record| *record += records);
            function.locals.iter_mut().for_each(|local| ty(&mut local.ty));
            if let Body::Code(body) = &mut function.body {
                // Entry functions of the law work on its own memory and are not called here.
                if function.instance.is_none() && function.parameters == 0 {
                    body.clear();
                    function.instance = law.functions[call].instance.map(|record| records + record);
                }
                change::statements(body, &mut Moves(functions));
            }
            self.functions.push(function);
        }
        let docs = &law.docs;
        self.docs.records.extend(docs.records.iter().map(|(record, text)| (record + records, text.clone())));
        let members = docs.members.iter().map(|((record, member), text)| ((record + records, *member), text.clone()));
        self.docs.members.extend(members);
        self.docs.functions.extend(docs.functions.iter().map(|(number, text)| (number + functions, text.clone())));
        if !docs.head.is_empty() {
            let between = if self.docs.head.is_empty() { "" } else { "\n\n" };
            self.docs.head += &format!("{between}{}", docs.head.trim_end());
        }
        self.docs.natives.insert(native);
        self.docs.natives.extend(functions..self.functions.len());
        self.docs.laws.insert(native, functions + call);
        if let Some(record) = self.functions[native].instance {
            self.records[record].name = format!("{name}_packed");
        }
        let size: usize = self.runs(native).iter().map(|run| run.size).sum();
        let found = self.functions[native].instance.map(|record| self.records[record].start.len());
        if found == Some(size) { Ok(()) } else { Err(format!("the law for {name} belongs to a different block")) }
    }

    /// The runs of bytes that map a native function's instance to the record of its law; empty if no law was added.
    pub(crate) fn runs(&self, native: usize) -> Vec<Run> {
        fn add(program: &Program, ty: &Type, at: usize, packed: &mut usize, runs: &mut Vec<Run>) {
            match ty {
                Type::Record(record) => {
                    for member in &program.records[*record].members {
                        add(program, &member.ty, at + member.offset, packed, runs);
                    }
                }
                ty => {
                    let size = program.size(ty);
                    match runs.last_mut() {
                        Some(last) if last.at + last.size == at => last.size += size,
                        _ => runs.push(Run { at, packed: *packed, size }),
                    }
                    *packed += size;
                }
            }
        }
        let mut runs = Vec::new();
        let law = self.docs.laws.get(&native).and_then(|law| self.functions[*law].instance);
        if let Some(record) = law {
            add(self, &Type::Record(record), 0, &mut 0, &mut runs);
        }
        runs
    }

    /// Whether a record is the instance of a native function, whose members are stored without padding.
    pub(crate) fn is_packed(&self, record: usize) -> bool {
        self.functions.iter().any(|it| it.instance == Some(record) && matches!(it.body, Body::Native(_)))
    }
}
