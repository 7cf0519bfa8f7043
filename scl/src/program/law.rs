//! Laws of blocks as parts of a program.

use super::{Body, Program, Type, walk};

/// Bytes that lie together in both forms of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// Where they lie in the record of the law, whose members have gaps between them.
    pub at: usize,
    /// Where they lie in an instance of the program, which has none.
    pub packed: usize,
    /// How many they are.
    pub size: usize,
}

impl Program {
    /// Adds the law of a block, which is another program, so that this one can be printed as C: `native` is the function that is this
    /// law ([`Body::Native`]), and `call` the one that calls the block in the other program. Nothing changes for the machine.
    ///
    /// # Errors
    /// The block of the law is not that of the function.
    pub fn add_law(&mut self, native: usize, law: &Program, call: usize) -> Result<(), String> {
        let (records, functions) = (self.records.len(), self.functions.len());
        let Body::Native(name) = self.functions[native].body else {
            return Err(format!("{} is no block of this project", self.functions[native].name));
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
                // What can be called from outside works on the memory of the other program: nobody calls it here.
                if function.instance.is_none() && function.parameters == 0 {
                    body.clear();
                    function.instance = law.functions[call].instance.map(|record| records + record);
                }
                walk::change_calls(body, &mut |call| call.function += functions);
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
        if found == Some(size) { Ok(()) } else { Err(format!("the law of {name} is that of another block")) }
    }

    /// How the instance of a native function lies in the record of its law; nothing if it has none.
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

    /// Whether a record is that of a block whose members lie without gaps.
    pub(crate) fn is_packed(&self, record: usize) -> bool {
        self.functions.iter().any(|it| it.instance == Some(record) && matches!(it.body, Body::Native(_)))
    }
}
