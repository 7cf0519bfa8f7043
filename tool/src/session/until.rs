//! Breakpoints: a run that ends when a condition becomes true.

use super::{Present, Session};
use crate::message::State;
use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};

/// A condition on a variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Until {
    /// `MEMBER.VARIABLE`
    pub variable: String,
    /// The comparison: `=`, `<>`, `>`, `>=`, `<`, `<=`.
    #[cfg_attr(test, ts(type = "\"=\" | \"<>\" | \">\" | \">=\" | \"<\" | \"<=\""))]
    pub sign: String,
    /// The value to compare with; TRUE is 1.
    pub value: f64,
}

impl Session {
    /// Makes calls up to the one in which the condition becomes true, but at most `calls`. A condition that is already
    /// true must first become false.
    ///
    /// # Errors
    /// No run, or it has failed; too many calls; the condition names an unknown variable.
    pub fn run_until(&mut self, calls: usize, until: Option<&Until>) -> Result<State> {
        let Some(until) = until else { return self.run(calls) };
        Session::check_calls(calls)?;
        let is_met = self.present()?.run_until(calls, until)?;
        Ok(State { is_met, ..self.state()? })
    }
}

impl Present {
    fn run_until(&mut self, calls: usize, until: &Until) -> Result<bool> {
        let (column, wanted) = (self.record.column(&until.variable)?, until.value);
        let compare: fn(f64, f64) -> bool = match until.sign.as_str() {
            "=" => |now, wanted| now == wanted,
            "<>" => |now, wanted| now != wanted,
            ">" => |now, wanted| now > wanted,
            ">=" => |now, wanted| now >= wanted,
            "<" => |now, wanted| now < wanted,
            "<=" => |now, wanted| now <= wanted,
            sign => bail!("{sign:?} is not a comparison: use =, <>, >, >=, < or <="),
        };
        self.is_running()?;
        let mut held = self.run.steps() > 0 && compare(self.row[column], wanted);
        for _ in 0..calls {
            self.call();
            let holds = compare(self.row[column], wanted);
            if self.record.failure.is_some() {
                break;
            }
            if holds && !held {
                return Ok(true);
            }
            held = holds;
        }
        Ok(false)
    }
}
