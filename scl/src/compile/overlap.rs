//! Tags with overlapping addresses: they share memory on a CPU, but are separate variables here.

use crate::check::compiler::Compiler;
use crate::check::undeclared::MOST_NAMES;
use parameters::tags;

impl Compiler<'_> {
    /// Warns about tags in use that share memory.
    pub fn tell_overlaps(&mut self) {
        let is_used = |name: &&String| self.globals.contains_key(*name);
        let names = self.global_members.keys().chain(self.declared.keys()).filter(is_used);
        let place = |name: &String| {
            let (area, bits) = tags::bits(&self.address(name)?)?;
            Some((area, bits.start, bits.end, name.clone()))
        };
        let mut tags: Vec<_> = names.filter_map(place).collect();
        tags.sort_unstable();
        tags.dedup();
        let mut pairs = Vec::new();
        for (at, (area, _, end, name)) in tags.iter().enumerate() {
            let after = tags[at + 1..].iter().take_while(|(of, start, ..)| of == area && start < end);
            // Pairs of tags that the CPU itself writes, such as a clock bit and its byte, are consistent.
            let is_system = |name: &String| crate::compile::system_memory::proposed(name).is_some();
            pairs
                .extend(after.map(|(.., other)| (name, other)).filter(|(one, two)| !is_system(one) || !is_system(two)));
        }
        if pairs.is_empty() {
            return;
        }
        let shown = |name: &String| format!("{} ({})", self.spelling(name), self.address(name).unwrap_or_default());
        let mut listed: Vec<String> =
            pairs.iter().take(MOST_NAMES).map(|(one, two)| format!("{} and {}", shown(one), shown(two))).collect();
        if let Some(more) = pairs.len().checked_sub(MOST_NAMES).filter(|more| *more > 0) {
            listed.push(format!("and {more} more"));
        }
        let message =
            format!("tags that share memory on a CPU are separate variables in the FMU: {}", listed.join("; "));
        let declared = self.global_members.get(pairs[0].1);
        let span = declared.and_then(|(.., member)| Some(member.names.first()?.span)).unwrap_or_default();
        self.warn(span, message, Some("use one tag of each pair, or a slice of it such as Tag.%X0"));
    }

    /// A tag's name as spelled in its declaration.
    fn spelling(&self, name: &str) -> String {
        let member = self
            .global_members
            .get(name)
            .and_then(|(_, _, member)| member.names.iter().find(|of| of.key() == name).map(|of| of.text.clone()));
        member.or_else(|| Some(self.declared.get(name)?.name.clone())).unwrap_or_else(|| name.into())
    }
}
