//! The gains of a PID controller in the forms used by textbooks and tools, and as the settings of a PLC block.
//!
//! All forms are ways of writing one transfer function from the error to the manipulated value, with `s` in 1/s:
//!
//! ```text
//! C(s) = Kp + Ki / s + Kd s / (1 + Tf s)                                                            (1)
//! ```
//!
//! `Tf` is the time constant of the lag that filters the derivative action, in seconds. [`Controller`] holds these four
//! numbers; each [`Form`] expresses them by its own parameters. In the PLC, P, I and D act on the error times GAIN:
//!
//! ```text
//! C(s) = GAIN (1 + 1 / (TI s) + TD s / (1 + TM_LAG s))                                              (2)
//! ```
//!
//! Both are the same function if the coefficients of each term are equal:
//!
//! ```text
//! GAIN = Kp,  GAIN / TI = Ki,  GAIN TD = Kd,  TM_LAG = Tf   so that   TI = Kp / Ki,  TD = Kd / Kp
//! ```
//!
//! **N.** Two definitions of the filter go by the same letter:
//!
//! - Relative to the derivative time, `Td s / (1 + (Td / N) s)`: the step response of the D action is N times that of
//!   the P action, and N has no unit. `Tf = Td / N`, thus `TM_LAG = TD / N`, with `TD = Kd / Kp` for parallel gains as
//!   well.
//! - Simulink's filter coefficient, `D N / (1 + N / s)`. Multiplied by `s / s`, this is `D N s / (s + N)`, or
//!   `D s / (1 + s / N)`: a lag of 1 / N seconds, regardless of the gains. N is in 1/s, and `TM_LAG = 1 / N`.
//!
//! **Series form.** `C(s) = Kc (1 + 1 / (Ti s)) (1 + Td s / (1 + Tf s))`, with `Tf = Td / N`. Multiplied out, it has
//! the term `(Td / Ti) / (1 + Tf s)`, and `1 / (1 + Tf s) = 1 - Tf s / (1 + Tf s)`. Sorted as in (1):
//!
//! ```text
//! Kp = Kc (1 + Td / Ti),  Ki = Kc / Ti,  Kd = Kc Td (1 - Tf / Ti)
//! TI = Ti + Td,  TD = Td (Ti - Tf) / (Ti + Td),  TM_LAG = Tf
//! ```
//!
//! In the other direction, substituting `Td = TI - Ti` into the equation for TD yields a quadratic equation for Ti:
//!
//! ```text
//! Ti^2 - (TI + TM_LAG) Ti + TI (TD + TM_LAG) = 0
//! Ti   = (TI + TM_LAG + sqrt((TI - TM_LAG)^2 - 4 TI TD)) / 2
//! ```
//!
//! The other root exchanges the roles of Ti and Td. Without a filter there is a solution if TI >= 4 TD: a series form
//! has two real zeros, and below that bound the zeros of (2) are complex.
//!
//! **P off.** A controller with Kp = 0 has no times TI and TD. The block then has P_SEL = FALSE, GAIN = 1 (or -1),
//! TI = 1 / |Ki| and TD = |Kd|.

use blocks::table::number::{number, to_value};
use blocks::{Kind, Time, Value};

/// A PID controller: `Kp + Ki / s + Kd s / (1 + Tf s)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Kp; 0 if the P action is off.
    pub proportional: f64,
    /// Ki in 1/s; 0 if the I action is off.
    pub integral: f64,
    /// Kd in s; 0 if the D action is off.
    pub derivative: f64,
    /// Tf, the time constant of the lag of the D action, in s; 0 without a filter.
    pub lag: f64,
}

/// A way of writing a PID controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The settings of a PLC block: GAIN, TI, TD, TM_LAG and the switches of the actions.
    Plc,
    /// Three gains in parallel: Kp, Ki and Kd.
    Parallel,
    /// A gain and two times: the ISA or standard form.
    Ideal,
    /// A PI and a PD controller in series: the interacting form.
    Series,
    /// Simulink's PID Controller block in its Parallel form.
    ///
    /// <https://www.mathworks.com/help/simulink/slref/pidcontroller.html>
    Simulink,
    /// Simulink's PID Controller block in its Ideal form.
    SimulinkIdeal,
    /// FB_CTRL_PID of TwinCAT's controller toolbox, and FB_BasicPID. Their documentation defines Tn as the integral
    /// action time, Tv as the derivative action time and Td as the damping time of the derivative (a D-T1 element) of a
    /// PID controller in additive form; the transfer function itself is shown only as an image. The parameters of
    /// FB_CTRL_PID are TIMEs, given in seconds here.
    ///
    /// <https://infosys.beckhoff.com/content/1033/tcplclib_tc2_utilities/34976395.html>,
    /// <https://infosys.beckhoff.com/content/1033/tcplclibcontrollertoolbox/11282668683.html>
    TwinCat,
    /// PID and PID_FIXCYCLE of the CODESYS library Util: proportional gain, reset time and rate time in seconds, no
    /// filter.
    ///
    /// <https://content.helpme-codesys.com/en/libs/Util/3.5.21.0/Controller/PID_FIXCYCLE.html>
    Codesys,
}

impl Form {
    /// All forms.
    pub const ALL: &'static [Form] = &[
        Form::Plc,
        Form::Parallel,
        Form::Ideal,
        Form::Series,
        Form::Simulink,
        Form::SimulinkIdeal,
        Form::TwinCat,
        Form::Codesys,
    ];

    /// Returns the name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Form::Plc => "plc",
            Form::Parallel => "parallel",
            Form::Ideal => "ideal",
            Form::Series => "series",
            Form::Simulink => "simulink",
            Form::SimulinkIdeal => "simulink-ideal",
            Form::TwinCat => "twincat",
            Form::Codesys => "codesys",
        }
    }

    /// Returns the transfer function as text.
    pub const fn formula(self) -> &'static str {
        match self {
            Form::Plc => "GAIN (1 + 1 / (TI s) + TD s / (1 + TM_LAG s))",
            Form::Parallel => "Kp + Ki / s + Kd s / (1 + Tf s), Tf = Kd / (Kp N)",
            Form::Ideal => "Kp (1 + 1 / (Ti s) + Td s / (1 + Tf s)), Tf = Td / N",
            Form::Series => "Kp (1 + 1 / (Ti s)) (1 + Td s / (1 + Tf s)), Tf = Td / N",
            Form::Simulink => "P + I / s + D N / (1 + N / s)",
            Form::SimulinkIdeal => "P (1 + I / s + D N / (1 + N / s))",
            Form::TwinCat => "fKp (1 + 1 / (tTn s) + tTv s / (1 + tTd s))",
            Form::Codesys => "KP (1 + 1 / (TN s) + TV s)",
        }
    }

    /// Returns the names of the form's parameters, in the order in which they are printed. Times are in seconds. N and
    /// Tf are alternatives; a controller without I or D action lacks the respective parameters.
    pub const fn names(self) -> &'static [&'static str] {
        match self {
            Form::Plc => &["GAIN", "TI", "TD", "TM_LAG", "P_SEL", "I_SEL", "D_SEL"],
            Form::Parallel => &["Kp", "Ki", "Kd", "N", "Tf"],
            Form::Ideal | Form::Series => &["Kp", "Ti", "Td", "N", "Tf"],
            Form::Simulink | Form::SimulinkIdeal => &["P", "I", "D", "N"],
            Form::TwinCat => &["fKp", "tTn", "tTv", "tTd"],
            Form::Codesys => &["KP", "TN", "TV"],
        }
    }
}

/// The numbers given by the user, with their names.
struct Given<'a> {
    form: Form,
    values: &'a [(String, f64)],
}

impl Given<'_> {
    fn find(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(given, _)| given.eq_ignore_ascii_case(name)).map(|(_, value)| *value)
    }

    fn gain(&self, name: &str) -> Result<f64, String> {
        match self.find(name) {
            None => Err(format!("{name} is missing: the form {} requires it", self.form.name())),
            Some(0.0) => Err(format!("{name} = 0 switches off P, I and D together: specify another gain")),
            Some(gain) => Ok(gain),
        }
    }

    /// Returns the reset time, which must be above 0 s; `None` if it is not given, so that the I action is off.
    fn reset_time(&self, name: &str) -> Result<Option<f64>, String> {
        match self.find(name) {
            Some(time) if time <= 0.0 => {
                Err(format!("{name} = {time} is not above 0 s: omit {name} if there is no I action"))
            }
            time => Ok(time),
        }
    }

    /// Returns a time of 0 s or longer; 0 s if it is not given.
    fn time(&self, name: &str) -> Result<f64, String> {
        match self.find(name) {
            Some(time) if time < 0.0 => Err(format!("{name} = {time} is negative: a time must be 0 s or longer")),
            time => Ok(time.unwrap_or(0.0)),
        }
    }

    /// Returns N, which must be above 0; `None` if it is not given.
    fn divisor(&self, name: &str) -> Result<Option<f64>, String> {
        match self.find(name) {
            Some(divisor) if divisor <= 0.0 => Err(format!("{name} = {divisor}: it must be above 0")),
            divisor => Ok(divisor),
        }
    }

    /// Returns the lag given by Tf, or by N relative to the derivative time.
    fn relative_lag(&self, derivative_time: f64) -> Result<f64, String> {
        match (self.divisor("N")?, self.find("Tf")) {
            (Some(_), Some(_)) => Err("N and Tf are alternatives: specify only one of them".into()),
            (Some(n), None) if derivative_time.is_finite() => Ok(derivative_time / n),
            (Some(_), None) => Err("N is relative to Kd / Kp, but Kp is 0: specify Tf instead".into()),
            (None, _) => self.time("Tf"),
        }
    }

    /// Returns the lag given by Simulink's filter coefficient.
    fn coefficient_lag(&self, derivative: f64) -> Result<f64, String> {
        match self.divisor("N")? {
            Some(n) => Ok(1.0 / n),
            None if derivative == 0.0 => Ok(0.0),
            None => Err("N is missing: specify the filter coefficient in 1/s; Simulink's default is 100".into()),
        }
    }

    fn switch(&self, name: &str, default: bool) -> Result<bool, String> {
        match self.find(name) {
            None => Ok(default),
            Some(value) if value == 0.0 || value == 1.0 => Ok(value == 1.0),
            Some(value) => Err(format!("{name} = {value} is neither FALSE nor TRUE")),
        }
    }
}

impl Controller {
    /// Creates a controller from numbers with the names of the form, ignoring case.
    ///
    /// # Errors
    /// One sentence: a name that the form does not have, a missing or impossible number, or a controller that no block
    /// can compute.
    pub fn new(form: Form, values: &[(String, f64)]) -> Result<Controller, String> {
        for (place, (name, value)) in values.iter().enumerate() {
            if !form.names().iter().any(|own| own.eq_ignore_ascii_case(name)) {
                return Err(format!(
                    "the form {} has no {name}: its parameters are {}",
                    form.name(),
                    form.names().join(", ")
                ));
            }
            if values[..place].iter().any(|(other, _)| other.eq_ignore_ascii_case(name)) {
                return Err(format!("{name} is given twice: remove one of the values"));
            }
            if !value.is_finite() {
                return Err(format!("{name} = {value} is not a finite number"));
            }
        }
        let given = Given { form, values };
        let controller = match form {
            Form::Plc => plc(&given)?,
            Form::Parallel => {
                let (proportional, integral) = (given.find("Kp").unwrap_or(0.0), given.find("Ki").unwrap_or(0.0));
                let derivative = given.find("Kd").unwrap_or(0.0);
                let lag = if derivative == 0.0 { 0.0 } else { given.relative_lag(derivative / proportional)? };
                Controller { proportional, integral, derivative, lag }
            }
            Form::Ideal => {
                let derivative_time = given.time("Td")?;
                let lag = given.relative_lag(derivative_time)?;
                ideal(given.gain("Kp")?, given.reset_time("Ti")?, derivative_time, lag)
            }
            Form::Series => series(&given)?,
            Form::Simulink => {
                let derivative = given.find("D").unwrap_or(0.0);
                let (proportional, integral) = (given.find("P").unwrap_or(0.0), given.find("I").unwrap_or(0.0));
                Controller { proportional, integral, derivative, lag: given.coefficient_lag(derivative)? }
            }
            Form::SimulinkIdeal => {
                let (gain, derivative) = (given.gain("P")?, given.find("D").unwrap_or(0.0));
                Controller {
                    proportional: gain,
                    integral: gain * given.find("I").unwrap_or(0.0),
                    derivative: gain * derivative,
                    lag: given.coefficient_lag(derivative)?,
                }
            }
            Form::TwinCat => {
                ideal(given.gain("fKp")?, given.reset_time("tTn")?, given.time("tTv")?, given.time("tTd")?)
            }
            Form::Codesys => ideal(given.gain("KP")?, given.reset_time("TN")?, given.time("TV")?, 0.0),
        };
        controller.check()
    }

    /// Returns the controller if a block can compute it.
    fn check(self) -> Result<Controller, String> {
        let Controller { proportional, integral, derivative, lag } = self;
        if [proportional, integral, derivative, lag].iter().any(|number| !number.is_finite()) {
            return Err("the gains are too large to compute with".into());
        }
        let signs: Vec<f64> =
            [proportional, integral, derivative].into_iter().filter(|gain| *gain != 0.0).map(f64::signum).collect();
        if signs.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(format!(
                "the gains {}, {} and {} of P, I and D have different signs: times are positive, so one GAIN cannot \
                 produce both signs",
                shown(proportional),
                shown(integral),
                shown(derivative)
            ));
        }
        Ok(self)
    }

    /// Returns GAIN, TI and TD; a time is `None` if the action is off.
    fn times(&self) -> (f64, Option<f64>, Option<f64>) {
        let gain = match self.proportional {
            // Without a P action, GAIN can be chosen freely; only its sign is given.
            0.0 if self.integral < 0.0 || self.derivative < 0.0 => -1.0,
            0.0 if self.integral > 0.0 || self.derivative > 0.0 => 1.0,
            gain => gain,
        };
        let reset_time = (self.integral != 0.0).then(|| gain / self.integral);
        let derivative_time = (self.derivative != 0.0).then(|| self.derivative / gain);
        (gain, reset_time, derivative_time)
    }

    /// Returns the controller's numbers in a form, with their names. Those of an action that is off are left out. A
    /// filter is specified by N if the form has it.
    ///
    /// # Errors
    /// One sentence: the reason why the form cannot express the controller.
    pub fn numbers(&self, form: Form) -> Result<Vec<(&'static str, f64)>, String> {
        let Controller { proportional, integral, derivative, lag } = *self;
        let (gain, reset_time, derivative_time) = self.times();
        let needs_gain = !matches!(form, Form::Plc | Form::Parallel | Form::Simulink);
        if needs_gain && proportional == 0.0 {
            return Err(format!(
                "there is no P action: the form {} has one gain for P, I and D, and 0 would switch all of them off",
                form.name()
            ));
        }
        let is_filtered = derivative != 0.0 && lag > 0.0;
        if derivative != 0.0 && lag == 0.0 && matches!(form, Form::Simulink | Form::SimulinkIdeal) {
            return Err(
                "the D action has no filter, but Simulink's always has one: specify a filter time above 0 s".into()
            );
        }
        // Leave out the numbers of an action that is off.
        let some = |name: &'static str, value: Option<f64>| value.map(|value| (name, value));
        let filter = |n: Option<f64>| is_filtered.then_some(n).flatten();
        let relative = filter(derivative_time.filter(|_| proportional != 0.0).map(|time| time / lag));
        let lag_alone = filter(relative.is_none().then_some(lag));
        let numbers = match form {
            Form::Plc => {
                let switch = |is_on: bool| Some(f64::from(u8::from(is_on)));
                vec![
                    some("GAIN", Some(gain)),
                    some("TI", reset_time),
                    some("TD", derivative_time),
                    some("TM_LAG", derivative_time.map(|_| lag)),
                    some("P_SEL", switch(proportional != 0.0 || reset_time.or(derivative_time).is_none())),
                    some("I_SEL", switch(reset_time.is_some())),
                    some("D_SEL", switch(derivative_time.is_some())),
                ]
            }
            Form::Parallel => vec![
                some("Kp", Some(proportional)),
                some("Ki", Some(integral)),
                some("Kd", Some(derivative)),
                some("N", relative),
                some("Tf", lag_alone),
            ],
            Form::Ideal => vec![
                some("Kp", Some(gain)),
                some("Ti", reset_time),
                some("Td", derivative_time),
                some("N", relative),
                some("Tf", lag_alone),
            ],
            Form::Series => {
                let (gain, reset_time, derivative_time) = self.series()?;
                let n = filter(derivative_time.map(|time| time / lag));
                vec![some("Kp", Some(gain)), some("Ti", reset_time), some("Td", derivative_time), some("N", n)]
            }
            Form::Simulink => vec![
                some("P", Some(proportional)),
                some("I", Some(integral)),
                some("D", Some(derivative)),
                some("N", filter(Some(1.0 / lag))),
            ],
            Form::SimulinkIdeal => vec![
                some("P", Some(gain)),
                some("I", Some(integral / gain)),
                some("D", Some(derivative / gain)),
                some("N", filter(Some(1.0 / lag))),
            ],
            Form::TwinCat => vec![
                some("fKp", Some(gain)),
                some("tTn", reset_time),
                some("tTv", derivative_time),
                some("tTd", derivative_time.map(|_| lag)),
            ],
            Form::Codesys => {
                if is_filtered {
                    return Err(format!(
                        "the D action has a filter of {} s, but the CODESYS PID has none: remove the filter",
                        shown(lag)
                    ));
                }
                vec![some("KP", Some(gain)), some("TN", reset_time), some("TV", derivative_time)]
            }
        };
        let numbers: Vec<_> = numbers.into_iter().flatten().collect();
        match numbers.iter().find(|(_, value)| !value.is_finite()) {
            Some((name, _)) => Err(format!("{name} cannot be represented: the gains differ too much")),
            None => Ok(numbers),
        }
    }

    /// Returns the gain, reset time and derivative time of the series form.
    fn series(&self) -> Result<(f64, Option<f64>, Option<f64>), String> {
        let (gain, reset_time, derivative_time) = self.times();
        let (Some(ti), Some(td)) = (reset_time, derivative_time) else {
            // Without I or D action, one factor is 1, so the forms are identical.
            return Ok((gain, reset_time, derivative_time));
        };
        let discriminant = (ti - self.lag).powi(2) - 4.0 * ti * td;
        // Round-off may make two equal zeros appear complex.
        let discriminant = if discriminant > -1e-12 * ti * ti { discriminant.max(0.0) } else { discriminant };
        if discriminant < 0.0 || self.lag >= ti {
            let bound = match self.lag {
                0.0 => "TI >= 4 TD".to_string(),
                lag => format!("(TI - TM_LAG)^2 >= 4 TI TD with TM_LAG = {} s below TI", shown(lag)),
            };
            return Err(format!(
                "no series form has this response: it would need {bound}, but TI = {} s and TD = {} s; a series form \
                 has real zeros only",
                shown(ti),
                shown(td)
            ));
        }
        let series_ti = ((ti + self.lag) + discriminant.sqrt()) / 2.0;
        // Use the equation for TD, because TI - Ti would lose the digits of a much shorter Td.
        let series_td = ti * td / (series_ti - self.lag);
        Ok((gain * series_ti / ti, Some(series_ti), Some(series_td)))
    }

    /// Returns the settings that a block in a PLC can hold: GAIN as a REAL, times in whole milliseconds. The second
    /// result states, in one sentence each, how the settings differ from the controller and what the user must set.
    ///
    /// # Errors
    /// One sentence: a number that the PLC cannot represent.
    pub fn settings(&self) -> Result<(Settings, Vec<String>), String> {
        let (gain, reset_time, derivative_time) = self.times();
        let mut remarks = Vec::new();
        let settings = Settings {
            gain: real("GAIN", gain, &mut remarks)?,
            ti: reset_time.map(|time| whole_milliseconds("TI", time, &mut remarks)).transpose()?,
            derivative: match derivative_time {
                Some(td) => Some((
                    whole_milliseconds("TD", td, &mut remarks)?,
                    whole_milliseconds("TM_LAG", self.lag, &mut remarks)?,
                )),
                None => None,
            },
            p_sel: self.proportional != 0.0 || reset_time.or(derivative_time).is_none(),
        };
        if reset_time.is_none() {
            remarks.push("there is no I action: I_SEL = FALSE switches it off; no value of TI does".into());
        }
        if derivative_time.is_none() {
            remarks.push("there is no D action: D_SEL = FALSE switches it off; TD = 0 does not".into());
        }
        if settings.derivative.is_some_and(|(_, tm_lag)| tm_lag == Time::ZERO) {
            remarks.push(
                "the D action has no filter: TM_LAG = 0 s is below CYCLE / 2, so the block uses CYCLE / 2".into(),
            );
        }
        if !settings.p_sel {
            remarks.push(format!(
                "there is no P action: P_SEL = FALSE switches it off, and GAIN = {} is chosen so that TI and TD yield \
                 the gains of I and D",
                settings.gain
            ));
        }
        Ok((settings, remarks))
    }
}

/// The settings of a block in a PLC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// GAIN, which applies to P, I and D.
    pub gain: f32,
    /// P_SEL: whether the P action is on.
    pub p_sel: bool,
    /// TI; `None` if I_SEL is FALSE.
    pub ti: Option<Time>,
    /// TD and TM_LAG; `None` if D_SEL is FALSE.
    pub derivative: Option<(Time, Time)>,
}

impl Settings {
    /// Returns the values with the names of the block's settings. Settings of an action that is off are left out.
    pub fn values(&self) -> Vec<(&'static str, Value)> {
        let mut values = vec![("GAIN", Value::Real(self.gain))];
        values.extend(self.ti.map(|ti| ("TI", Value::Time(ti))));
        if let Some((td, tm_lag)) = self.derivative {
            values.extend([("TD", Value::Time(td)), ("TM_LAG", Value::Time(tm_lag))]);
        }
        values.extend([
            ("P_SEL", Value::Bool(self.p_sel)),
            ("I_SEL", Value::Bool(self.ti.is_some())),
            ("D_SEL", Value::Bool(self.derivative.is_some())),
        ]);
        values
    }

    /// Returns the controller that the block computes with these settings if it is called every `cycle` seconds: it
    /// raises TI to at least half the cycle, TD to a cycle and TM_LAG to half a cycle. The second result states, in one
    /// sentence each, which times are raised.
    pub fn computed(&self, cycle: f64) -> (Controller, Vec<String>) {
        let mut remarks = Vec::new();
        let mut raised = |name: &str, time: Time, bound: &str, lowest: f64| {
            let time = number(Value::Time(time));
            if time >= lowest {
                return time;
            }
            remarks.push(format!("{name} = {} s is below {bound}: the block uses {} s", shown(time), shown(lowest)));
            lowest
        };
        let gain = f64::from(self.gain);
        let ti = self.ti.map(|ti| raised("TI", ti, "CYCLE / 2", cycle / 2.0));
        let (td, lag) = self.derivative.map_or((0.0, 0.0), |(td, tm_lag)| {
            (raised("TD", td, "CYCLE", cycle), raised("TM_LAG", tm_lag, "CYCLE / 2", cycle / 2.0))
        });
        let controller = ideal(gain, ti, td, lag);
        let proportional = if self.p_sel { gain } else { 0.0 };
        (Controller { proportional, ..controller }, remarks)
    }
}

/// Creates a controller from a gain that is common to all actions.
fn ideal(gain: f64, reset_time: Option<f64>, derivative_time: f64, lag: f64) -> Controller {
    Controller {
        proportional: gain,
        integral: reset_time.map_or(0.0, |time| gain / time),
        derivative: gain * derivative_time,
        lag: if derivative_time == 0.0 { 0.0 } else { lag },
    }
}

fn plc(given: &Given) -> Result<Controller, String> {
    let mut reset_time = given.reset_time("TI")?;
    if !given.switch("I_SEL", reset_time.is_some())? {
        reset_time = None;
    } else if reset_time.is_none() {
        return Err("I_SEL is TRUE, but TI is missing".into());
    }
    let mut derivative_time = given.time("TD")?;
    if !given.switch("D_SEL", derivative_time > 0.0)? {
        derivative_time = 0.0;
    } else if derivative_time == 0.0 {
        return Err("D_SEL is TRUE, but TD is missing or 0".into());
    }
    let controller = ideal(given.gain("GAIN")?, reset_time, derivative_time, given.time("TM_LAG")?);
    let proportional = if given.switch("P_SEL", true)? { controller.proportional } else { 0.0 };
    Ok(Controller { proportional, ..controller })
}

fn series(given: &Given) -> Result<Controller, String> {
    let (gain, derivative_time) = (given.gain("Kp")?, given.time("Td")?);
    let lag = if derivative_time == 0.0 { 0.0 } else { given.relative_lag(derivative_time)? };
    let Some(reset_time) = given.reset_time("Ti")? else {
        return Ok(ideal(gain, None, derivative_time, lag));
    };
    if lag >= reset_time && derivative_time > 0.0 {
        return Err(format!(
            "the filter of {} s is not faster than Ti = {} s: multiplied out, this series form has no positive D \
             action, so no settings of a block reproduce its response",
            shown(lag),
            shown(reset_time)
        ));
    }
    Ok(Controller {
        proportional: gain * (1.0 + derivative_time / reset_time),
        integral: gain / reset_time,
        derivative: gain * derivative_time * (1.0 - lag / reset_time),
        lag,
    })
}

fn real(name: &str, number: f64, remarks: &mut Vec<String>) -> Result<f32, String> {
    to_value(number, Kind::Real).map_err(|range| format!("{name} = {}: {range}", shown(number)))?;
    let real = number as f32;
    if number != 0.0 && real == 0.0 {
        return Err(format!("{name} = {number:e} is too small for a REAL: it would become 0"));
    }
    // The REAL nearest to 0.1 prints as 0.1, as a user expects.
    if real.to_string().parse() != Ok(shown(number)) {
        remarks.push(format!("{name} = {} becomes the REAL {real}", shown(number)));
    }
    Ok(real)
}

fn whole_milliseconds(name: &str, seconds: f64, remarks: &mut Vec<String>) -> Result<Time, String> {
    to_value(seconds, Kind::Time).map_err(|range| format!("{name} = {} s: {range}", shown(seconds)))?;
    let time = Time::ms((seconds * 1000.0).round() as i32);
    let whole = number(Value::Time(time));
    if whole != shown(seconds) {
        remarks
            .push(format!("{name} = {} s becomes {whole} s: a TIME is a whole number of milliseconds", shown(seconds)));
    }
    Ok(time)
}

/// Rounds a number to at most twelve digits, which removes the round-off of the computation.
pub fn shown(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests;
