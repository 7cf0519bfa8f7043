//! `plcfmu gains`: converts gains from other tools to the settings of a PLC block, and back.

use super::print;
use crate::tell;
use anyhow::{Context, Result, anyhow, ensure};
use blocks::Value;
use blocks::table::number::number;
use clap::ArgGroup;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use control::gains::{Controller, Form, Settings, shown};
use std::fmt::Write as _;
use std::str::FromStr;

/// Convert the gains of a PID controller to GAIN, TI, TD and TM_LAG, and back
///
/// Times are in seconds. An action whose numbers are left out, or whose gain is 0, is switched off. Tf is the time
/// constant of the filter of the D action; N can be given instead. Without a filter, TM_LAG is 0, and the block
/// computes with half its CYCLE.
#[derive(clap::Args, Debug)]
#[command(
    override_usage = "plcfmu gains --parallel|--ideal|--series|--simulink|--simulink-ideal|--twincat|--codesys|--from \
                      NAME=NUMBER,... [--to FORM] [--cycle SECONDS] [--json]",
    group(ArgGroup::new("source").required(true))
)]
pub struct Options {
    /// Three gains: Kp=2,Ki=0.1,Kd=4,N=10
    ///
    /// Kp + Ki / s + Kd s / (1 + Tf s); N is relative: Tf = Kd / (Kp N). Tf may be given instead of N.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    parallel: Vec<Given>,
    /// A gain and two times, the standard form: Kp=2,Ti=20,Td=2,N=10
    ///
    /// Kp (1 + 1 / (Ti s) + Td s / (1 + Tf s)); N is relative: Tf = Td / N. Tf may be given instead of N.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    ideal: Vec<Given>,
    /// A PI and a PD controller in series: Kp=2,Ti=10,Td=1,N=10
    ///
    /// Kp (1 + 1 / (Ti s)) (1 + Td s / (1 + Tf s)); N is relative: Tf = Td / N. Tf may be given instead of N.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    series: Vec<Given>,
    /// Simulink's PID Controller in parallel form: P=2,I=0.1,D=4,N=5
    ///
    /// P + I / s + D N / (1 + N / s); N is the filter coefficient in 1/s: TM_LAG = 1 / N.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    simulink: Vec<Given>,
    /// Simulink's PID Controller in ideal form: P=2,I=0.05,D=2,N=5
    ///
    /// P (1 + I / s + D N / (1 + N / s)); N is the filter coefficient in 1/s: TM_LAG = 1 / N.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    simulink_ideal: Vec<Given>,
    /// TwinCAT's FB_CTRL_PID or FB_BasicPID: fKp=2,tTn=20,tTv=2,tTd=0.2
    ///
    /// fKp (1 + 1 / (tTn s) + tTv s / (1 + tTd s)); all times are in seconds.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    twincat: Vec<Given>,
    /// CODESYS's PID or PID_FIXCYCLE: KP=2,TN=20,TV=2
    ///
    /// KP (1 + 1 / (TN s) + TV s); the D action has no filter.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    codesys: Vec<Given>,
    /// Settings of the block: GAIN=2,TI=20,TD=2,TM_LAG=0.2
    ///
    /// GAIN (1 + 1 / (TI s) + TD s / (1 + TM_LAG s)); P_SEL, I_SEL and D_SEL may be FALSE or TRUE. By default, an
    /// action is on if its time is given.
    #[arg(long, value_name = NUMBERS, value_delimiter = ',', group = "source")]
    from: Vec<Given>,
    /// The form to convert to
    #[arg(long, value_name = "FORM", value_parser = forms(), default_value = "plc")]
    to: Form,
    /// CYCLE of the block in seconds
    ///
    /// The block raises TI to at least CYCLE / 2, TD to CYCLE and TM_LAG to CYCLE / 2; remarks state which it raised.
    /// If --to selects another form, the numbers are the block's effective values, including rounding.
    #[arg(long, value_name = "SECONDS")]
    cycle: Option<f64>,
    /// Print a JSON object; remarks go to standard error
    #[arg(long)]
    json: bool,
}

/// The placeholder for a form's numbers in the help.
const NUMBERS: &str = "NAME=NUMBER,...";

/// A number given on the command line with its name, such as `Kp=2`.
#[derive(Clone, Debug)]
struct Given {
    name: String,
    value: f64,
}

impl FromStr for Given {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Given> {
        let (name, value) =
            text.split_once('=').with_context(|| format!("{text:?} is not NAME=NUMBER, such as Kp=2"))?;
        let value = match value.trim() {
            value if value.eq_ignore_ascii_case("true") => 1.0,
            value if value.eq_ignore_ascii_case("false") => 0.0,
            value => value.parse().map_err(|_| anyhow!("{value:?} is not a number, such as 2 or 1.5e-3"))?,
        };
        Ok(Given { name: name.trim().to_string(), value })
    }
}

/// Parses the form to convert to. The help shows the formula of each form.
fn forms() -> impl TypedValueParser<Value = Form> {
    let value = |form: &Form| PossibleValue::new(form.name()).help(form.formula());
    let form = |name: String| Form::ALL.iter().copied().find(|form| form.name() == name).unwrap_or(Form::Plc);
    PossibleValuesParser::new(Form::ALL.iter().map(value)).map(form)
}

/// Converts the gains given on the command line, and prints the result and remarks on it.
///
/// # Errors
/// Numbers are missing or invalid, or the form cannot express the controller.
pub fn run(options: &Options) -> Result<()> {
    let (form, given) = options.source();
    let given: Vec<_> = given.iter().map(|given| (given.name.clone(), given.value)).collect();
    let controller = Controller::new(form, &given).map_err(anyhow::Error::msg)?;
    if let Some(cycle) = options.cycle {
        ensure!(cycle > 0.0 && cycle.is_finite(), "--cycle {cycle}: CYCLE must be greater than 0 s");
    }
    let (values, remarks) = match (options.to, options.cycle) {
        (Form::Plc, cycle) => {
            let (settings, mut remarks) = controller.settings().map_err(anyhow::Error::msg)?;
            remarks.extend(cycle.map(|cycle| settings.computed(cycle).1).into_iter().flatten());
            (of_block(&settings), remarks)
        }
        (form, None) => (of_form(&controller, form)?, Vec::new()),
        (form, Some(cycle)) => {
            let (settings, mut remarks) = controller.settings().map_err(anyhow::Error::msg)?;
            let (computed, raised) = settings.computed(cycle);
            remarks.extend(raised);
            (of_form(&computed, form)?, remarks)
        }
    };
    if options.json {
        for remark in &remarks {
            tell::remark(remark);
        }
        let members: Vec<_> =
            values.iter().map(|line| format!("{}: {}", serde_json::json!(line.name), line.json)).collect();
        return print(&format!("{{{}}}\n", members.join(", ")));
    }
    let width = values.iter().map(|line| line.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for line in &values {
        writeln!(text, "{:width$}  {}", line.name, line.text)?;
    }
    for remark in &remarks {
        writeln!(text, "remark: {remark}")?;
    }
    print(&text)
}

/// A line of the output: a name, and its value as text and as JSON.
struct Line {
    name: &'static str,
    text: String,
    json: serde_json::Value,
}

fn of_block(settings: &Settings) -> Vec<Line> {
    let line = |(name, value)| match value {
        Value::Bool(is_on) => Line { name, text: if is_on { "TRUE" } else { "FALSE" }.into(), json: is_on.into() },
        // The shortest decimal that reads back as this REAL.
        Value::Real(real) => {
            let text = real.to_string();
            Line { name, json: text.parse().map_or(serde_json::Value::Null, |number: f64| number.into()), text }
        }
        value => Line { name, text: format!("{} s", number(value)), json: number(value).into() },
    };
    settings.values().into_iter().map(line).collect()
}

fn of_form(controller: &Controller, form: Form) -> Result<Vec<Line>> {
    let numbers = controller.numbers(form).map_err(anyhow::Error::msg)?;
    let line = |(name, number)| Line { name, text: shown(number).to_string(), json: shown(number).into() };
    Ok(numbers.into_iter().map(line).collect())
}

impl Options {
    /// The form given by the user, and its numbers.
    fn source(&self) -> (Form, &[Given]) {
        let sources = [
            (Form::Parallel, &self.parallel),
            (Form::Ideal, &self.ideal),
            (Form::Series, &self.series),
            (Form::Simulink, &self.simulink),
            (Form::SimulinkIdeal, &self.simulink_ideal),
            (Form::TwinCat, &self.twincat),
            (Form::Codesys, &self.codesys),
        ];
        let given = sources.into_iter().find(|(_, numbers)| !numbers.is_empty());
        given.map_or((Form::Plc, &self.from), |(form, numbers)| (form, numbers))
    }
}
