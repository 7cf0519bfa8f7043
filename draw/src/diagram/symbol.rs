//! The symbols inside boxes: a curve or sign that identifies the function.

/// A symbol, drawn around the origin within 20 pixels to each side and 13 pixels up and down.
#[derive(Debug, PartialEq)]
pub struct Symbol {
    /// Its name in the description.
    pub name: &'static str,
    /// A description of the function for readers.
    pub meaning: &'static str,
    /// The axes, as the data of an SVG path; may be empty.
    pub axes: &'static str,
    /// The lines, as the data of an SVG path.
    pub lines: &'static str,
    /// Short texts, each with the x and y of its middle.
    pub texts: &'static [(f64, f64, &'static str)],
}

/// Axes through the origin, for the output as a function of the input.
const CROSS: &str = "M-20 0H20M0 -14V14";
/// Axes from the lower left corner, for the output as a function of time.
const CORNER: &str = "M-18 -14V11H20";

const fn curve(name: &'static str, meaning: &'static str, axes: &'static str, lines: &'static str) -> Symbol {
    Symbol { name, meaning, axes, lines, texts: &[] }
}

/// All symbols that a diagram can use.
pub const SYMBOLS: &[Symbol] = &[
    Symbol {
        name: "analog_input",
        meaning: "conversion of an analog input word to percent",
        axes: "",
        lines: "M-20 13L20 -13",
        texts: &[(-11.0, -5.0, "W"), (12.0, 7.0, "%")],
    },
    Symbol {
        name: "analog_output",
        meaning: "conversion of percent to an analog output word",
        axes: "",
        lines: "M-20 13L20 -13",
        texts: &[(-11.0, -5.0, "%"), (12.0, 7.0, "W")],
    },
    curve("normalize", "times a factor, plus an offset", CROSS, "M-17 9L17 -13"),
    curve("dead_band", "dead band", CROSS, "M-18 12L-7 0H7L18 -12"),
    curve("limit", "limits", CROSS, "M-19 10H-9L9 -10H19"),
    curve("multiply", "product", "", "M-8 -8L8 8M-8 8L8 -8"),
    curve("proportional", "proportional action", CORNER, "M-18 11V-5H17"),
    curve("integrate", "integral over time", CORNER, "M-18 11L17 -10"),
    curve("differentiate", "derivative with a time lag", CORNER, "M-18 11V-11C-14 3 -6 9 17 10"),
    curve("lag", "time lag", CORNER, "M-18 11C-13 -4 -4 -9 17 -9"),
    curve("delay", "delay", CORNER, "M-18 11H-4V-7H17"),
    curve("ramp", "ramp", CORNER, "M-18 11L2 -8H17"),
    curve(
        "three_step",
        "three-step element with hysteresis",
        CROSS,
        "M-19 11H-12V0H-6V11M-6 0H6M6 -11V0H12V-11H19M-12 11H-6M6 -11H12",
    ),
    curve("two_step", "two-step element with hysteresis", CROSS, "M-18 10H7V-10H18M-7 10V-10H7"),
    curve("characteristic", "characteristic", CROSS, "M-19 12H-14V8L-5 3V0H5V-3L14 -8V-12H19"),
    curve("pulses", "pulses", "", "M-19 9H-15V-9H-4V9H3V-9H14V9H19"),
    curve(
        "mean",
        "mean over time",
        "M-19 0H-16M-13 0H-10M-7 0H-4M-1 0H2M5 0H8M11 0H14M17 0H19",
        "M-19 9H-15V-9H-4V9H3V-9H14V9H19",
    ),
    curve("edge", "rising edge", "", "M-14 9H0V-9H14M-4 3L0 -2L4 3"),
    curve("root", "square root", CORNER, "M-18 11C-18 0 -2 -8 17 -10"),
    curve("curve", "nonlinear characteristic", CORNER, "M-18 11C2 9 14 2 17 -11"),
    curve("furnace", "electric furnace", "M-18 -13H18V13H-18Z", "M-14 0H-11L-8 -6L-4 6L0 -6L4 6L8 -6L11 0H14"),
    curve("level", "vessel with a level", "M-16 -13V13H16V-13", "M-16 -4C-11 -8 -5 0 0 -4C5 -8 11 0 16 -4M-16 4H16"),
    Symbol {
        name: "pid_pulses",
        meaning: "PID controller with pulses",
        axes: "",
        lines: "M-19 13H-13V4H-3V13H4V4H13V13H19",
        texts: &[(0.0, -7.0, "PID")],
    },
];

/// The symbol with this name.
pub fn named(name: &str) -> Option<&'static Symbol> {
    SYMBOLS.iter().find(|symbol| symbol.name == name)
}
