//! Determines which operands decided a truth value, strictly from the values recorded during a call.

use super::{Named, Reader};
use crate::check::constant::{self, Literal};
use crate::front::syntax::{
    Binary, ExpressionId, ExpressionKind, Expressions, Scope, Statement, StatementKind, Tree, Unary,
};

/// A condition or an assigned truth value, as a formula over its terms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logic {
    formula: Formula,
    terms: Vec<Term>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Formula {
    Term(usize),
    Not(Box<Formula>),
    And(Vec<Formula>),
    Or(Vec<Formula>),
    Xor(Vec<Formula>),
}

/// An operand of AND, OR, XOR and NOT: a variable, a comparison, a call. Operands with equal text are the same term.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Term {
    text: String,
    /// The value, if it is a literal.
    fixed: Option<bool>,
    /// The numbers under which its value is recorded.
    wires: Vec<u32>,
    /// The variables in it, as indices into the list of all variables read.
    reads: Vec<usize>,
    /// Whether it is a whole variable, not a comparison, call or bit of a word.
    is_variable: bool,
}

/// The role of a variable in a truth value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Influence {
    /// Not a reason for the truth value.
    Idle,
    /// A reason, but not the only one: another operand yields the same truth value.
    Shared,
    /// Decisive: with the opposite value, the truth value would be the opposite.
    Decided,
}

/// The explanation of a truth value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The truth value.
    pub truth: bool,
    /// The role of each variable read.
    pub parts: Vec<Influence>,
    /// The value of each variable when it was evaluated; `None` if it is not Boolean.
    pub values: Vec<Option<bool>>,
    /// The numbers under which the values of the decisive terms and the shared reasons are recorded.
    pub wires: Vec<u32>,
}

impl Logic {
    /// The logic of whether one of these CASE arms is selected; arms are recorded under the number of their first
    /// label. All variables of the selector are reasons.
    pub(super) fn of_arms(arms: &[ExpressionId], reads: usize) -> Logic {
        let term = |id: &ExpressionId| Term {
            text: String::new(),
            fixed: None,
            wires: vec![id.0],
            reads: (0..reads).collect(),
            is_variable: false,
        };
        Logic {
            formula: Formula::Or((0..arms.len()).map(Formula::Term).collect()),
            terms: arms.iter().map(term).collect(),
        }
    }

    /// Explains the truth value from the recorded values; `None` if they do not determine it.
    pub fn decided(&self, reads: usize, noted: &dyn Fn(u32) -> Option<bool>) -> Option<Decision> {
        let value = |term: &Term| {
            let mut values = term.wires.iter().map(|wire| noted(*wire));
            // A term that occurs more than once counts only if its values agree.
            let first = values.next()??;
            values.flatten().all(|other| other == first).then_some(first)
        };
        let values: Vec<Option<bool>> = self.terms.iter().map(|term| term.fixed.or_else(|| value(term))).collect();
        let truth = self.formula.truth(&values)?;
        let mut reasons = vec![false; values.len()];
        self.formula.reasons(&values, &mut reasons);
        let (mut parts, mut wires, mut own) = (vec![Influence::Idle; reads], Vec::new(), vec![None; reads]);
        for (number, term) in self.terms.iter().enumerate().filter(|(_, term)| term.fixed.is_none()) {
            let mut opposite = values.clone();
            opposite[number] = values[number].map(|value| !value);
            let part = match reasons[number] {
                true if self.formula.truth(&opposite) != Some(truth) => Influence::Decided,
                true => Influence::Shared,
                false => Influence::Idle,
            };
            if part > Influence::Idle {
                wires.extend(&term.wires);
            }
            for read in &term.reads {
                parts[*read] = parts[*read].max(part);
                if term.is_variable {
                    own[*read] = values[number];
                }
            }
        }
        Some(Decision { truth, parts, wires, values: own })
    }
}

impl Formula {
    /// The truth value; unknown terms leave it undetermined unless the others suffice.
    fn truth(&self, values: &[Option<bool>]) -> Option<bool> {
        let any = |all: &[Formula], wanted: bool| {
            let mut truths = all.iter().map(|of| of.truth(values));
            let is_one = truths.clone().any(|truth| truth == Some(wanted));
            if is_one { Some(wanted) } else { truths.all(|truth| truth.is_some()).then_some(!wanted) }
        };
        match self {
            Formula::Term(number) => values[*number],
            Formula::Not(of) => of.truth(values).map(|truth| !truth),
            Formula::And(all) => any(all, false),
            Formula::Or(all) => any(all, true),
            Formula::Xor(all) => all.iter().try_fold(false, |odd, of| Some(odd != of.truth(values)?)),
        }
    }

    /// Marks the terms that are reasons for the truth value. If an AND is FALSE, they are in its FALSE operands, and if
    /// it is TRUE, in all of them; for an OR, it is the reverse. All operands of an XOR are reasons.
    fn reasons(&self, values: &[Option<bool>], reasons: &mut [bool]) {
        let truth = self.truth(values);
        match self {
            Formula::Term(number) => reasons[*number] = true,
            Formula::Not(of) => of.reasons(values, reasons),
            Formula::And(all) | Formula::Or(all) => {
                let is_and = matches!(self, Formula::And(_));
                let counts = |of: &&Formula| truth == Some(is_and) || of.truth(values) == truth;
                all.iter().filter(counts).for_each(|of| of.reasons(values, reasons));
            }
            Formula::Xor(all) => all.iter().for_each(|of| of.reasons(values, reasons)),
        }
    }
}

impl Reader<'_> {
    /// A condition or value as a formula; `None` if it is nested too deeply. Whether the value is a truth value is
    /// known only once it has been recorded.
    pub(super) fn logic(&mut self, of: ExpressionId, reads: &[Named]) -> Option<Logic> {
        let mut terms = Vec::new();
        let formula = self.formula(of, reads, &mut terms)?;
        Some(Logic { formula, terms })
    }

    fn formula(&mut self, id: ExpressionId, reads: &[Named], terms: &mut Vec<Term>) -> Option<Formula> {
        let expressions = self.expressions;
        match &expressions[id].kind {
            ExpressionKind::Unary(Unary::Not, inner) => {
                Some(Formula::Not(Box::new(self.formula(*inner, reads, terms)?)))
            }
            ExpressionKind::Binary(operator @ (Binary::And | Binary::Or | Binary::Xor), ..) => {
                let parts = chain(expressions, id, *operator).into_iter();
                let all = parts.map(|part| self.formula(part, reads, terms)).collect::<Option<Vec<_>>>()?;
                Some(match operator {
                    Binary::And => Formula::And(all),
                    Binary::Or => Formula::Or(all),
                    _ => Formula::Xor(all),
                })
            }
            ExpressionKind::Name(Scope::Local, name) if self.temporaries.contains_key(&name.text) => {
                let of = self.temporaries[&name.text];
                if self.depth == super::DEEPEST {
                    return None;
                }
                self.depth += 1;
                let found = self.formula(of, reads, terms);
                self.depth -= 1;
                found
            }
            kind => {
                let text = super::written(expressions, &self.temporaries, id);
                let number = terms.iter().position(|term| term.text == text).unwrap_or_else(|| {
                    let own = self.reads([id]);
                    let reads = own.iter().filter_map(|own| reads.iter().position(|read| read == own)).collect();
                    let is_variable = super::path(expressions, id).is_some() && !text.contains(".%");
                    terms.push(Term { text, fixed: fixed(kind), wires: Vec::new(), reads, is_variable });
                    terms.len() - 1
                });
                terms[number].wires.push(id.0);
                Some(Formula::Term(number))
            }
        }
    }
}

/// The value of a Boolean literal; in SCL, `TRUE` and `FALSE` are names.
fn fixed(kind: &ExpressionKind) -> Option<bool> {
    let text = match kind {
        ExpressionKind::Literal(text) => text,
        ExpressionKind::Name(Scope::Bare, name) => &name.text,
        _ => return None,
    };
    match constant::read(text) {
        Ok(Literal::Truth(truth)) => Some(truth),
        _ if text.eq_ignore_ascii_case("TRUE") => Some(true),
        _ if text.eq_ignore_ascii_case("FALSE") => Some(false),
        _ => None,
    }
}

/// The operands of a chain such as `a AND b AND c`, from left to right. A chain nests to the left and may be long.
fn chain(expressions: &Expressions, id: ExpressionId, of: Binary) -> Vec<ExpressionId> {
    let (mut parts, mut first) = (Vec::new(), id);
    while let ExpressionKind::Binary(operator, left, right) = &expressions[first].kind
        && *operator == of
    {
        parts.push(*right);
        first = *left;
    }
    parts.push(first);
    parts.reverse();
    parts
}

/// The terms to record: those in all conditions and values of a source, and the first label of each CASE arm. A loop
/// condition is evaluated repeatedly; its last value is kept.
pub(crate) fn terms(tree: &Tree) -> Vec<ExpressionId> {
    let mut found = Vec::new();
    tree.blocks.iter().for_each(|block| terms_of(&block.body, &tree.expressions, &mut found));
    found
}

fn terms_of(statements: &[Statement], expressions: &Expressions, found: &mut Vec<ExpressionId>) {
    let mut of = |id: ExpressionId| {
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            match &expressions[id].kind {
                ExpressionKind::Unary(Unary::Not, inner) => open.push(*inner),
                ExpressionKind::Binary(Binary::And | Binary::Or | Binary::Xor, left, right) => {
                    open.extend([left, right])
                }
                kind if fixed(kind).is_some() || matches!(kind, ExpressionKind::Literal(_)) => {}
                _ => found.push(id),
            }
        }
    };
    for statement in statements {
        match &statement.kind {
            StatementKind::Assign(_, value) | StatementKind::Let(.., Some(value)) => of(*value),
            StatementKind::If(arms, _) => arms.iter().for_each(|(condition, _)| of(*condition)),
            StatementKind::While(condition, _) | StatementKind::Repeat(_, condition) => of(*condition),
            _ => {}
        }
    }
    for statement in statements {
        match &statement.kind {
            StatementKind::If(arms, rest) => {
                arms.iter().for_each(|(_, body)| terms_of(body, expressions, found));
                terms_of(rest, expressions, found);
            }
            StatementKind::Case(_, arms, rest) => {
                found.extend(arms.iter().filter_map(|(labels, _)| Some(labels.first()?.low)));
                arms.iter().for_each(|(_, body)| terms_of(body, expressions, found));
                terms_of(rest, expressions, found);
            }
            StatementKind::For { body, .. } | StatementKind::While(_, body) | StatementKind::Repeat(body, _) => {
                terms_of(body, expressions, found);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::watched;
    use super::*;
    use parameters::Source;

    /// What decided `#x := FORMULA`, a letter for each variable: D decided, S shares it, - had no part. `values` are those of the terms
    /// in the order of the text; `?` was not calculated.
    fn decided(formula: &str, values: &str) -> String {
        let Some(Decision { truth, parts, .. }) = decision(formula, values) else { return "?".into() };
        let letters = parts.iter().map(|part| match part {
            Influence::Decided => 'D',
            Influence::Shared => 'S',
            Influence::Idle => '-',
        });
        format!("{} {}", u8::from(truth), letters.collect::<String>())
    }

    fn decision(formula: &str, values: &str) -> Option<Decision> {
        let text = format!(
            "FUNCTION_BLOCK \"F\" VAR_INPUT a : Bool; b : Bool; c : Bool; n : Int; m : Int; END_VAR \
             VAR_OUTPUT x : Bool; END_VAR BEGIN #x := {formula}; END_FUNCTION_BLOCK"
        );
        let block = watched(&[Source::new("f.scl", text.into())]).remove(0);
        let write = &block.writes[0];
        let logic = write.logic.as_ref().unwrap();
        let mut wires: Vec<u32> =
            logic.terms.iter().filter(|of| of.fixed.is_none()).flat_map(|of| of.wires.clone()).collect();
        wires.sort_unstable();
        let noted = |wire: u32| match values.as_bytes()[wires.iter().position(|of| *of == wire)?] {
            b'1' => Some(true),
            b'0' => Some(false),
            _ => None,
        };
        logic.decided(write.reads.len(), &noted)
    }

    #[test]
    fn what_decided_is_what_changes_the_result_and_several_reasons_are_told_apart() {
        let table = |formula: &str| ["00", "01", "10", "11"].map(|values| decided(formula, values));
        assert_eq!(table("#a AND #b"), ["0 SS", "0 D-", "0 -D", "1 DD"]);
        assert_eq!(table("#a OR #b"), ["0 DD", "1 -D", "1 D-", "1 SS"]);
        assert_eq!(table("#a XOR #b"), ["0 DD", "1 DD", "1 DD", "0 DD"]);
        assert_eq!(table("#a AND NOT #b"), ["0 D-", "0 SS", "1 DD", "0 -D"]);
        // A comparison is what its operands are.
        assert_eq!(table("#a AND #n < #m"), ["0 SSS", "0 D--", "0 -DD", "1 DDD"]);
        assert_eq!(decided("(#a OR #b) AND #c", "110"), "0 --D");
        assert_eq!(decided("(#a OR #b) AND #c", "111"), "1 SSD");
        assert_eq!(decided("(#a OR #b) AND #c", "000"), "0 SSS");
        // FALSE is read as a name, and decides nothing.
        assert_eq!(decided("#a OR FALSE OR #b AND #c", "010"), "0 D--D");
    }

    #[test]
    fn a_variable_that_stands_there_twice_is_one_and_what_was_not_calculated_is_open() {
        // TRUE whatever a is: it does not decide alone.
        assert_eq!(decided("#a OR NOT #a", "11"), "1 S");
        // Without a, b would be the reason.
        assert_eq!(decided("#a AND #b OR NOT #a AND #c", "0101"), "1 S-D");
        assert_eq!(decided("#a AND #b", "0?"), "0 D-");
        assert_eq!(decided("#a AND #b", "1?"), "?");
        // Of a comparison it is not known what its operands were.
        assert_eq!(decision("#n < #m OR NOT #a", "00").unwrap().values, [None, None, Some(false)]);
        // Two values of one term contradict each other.
        assert_eq!(decided("#a OR NOT #a", "10"), "?");
    }
}
