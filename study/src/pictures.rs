//! The pictures of a study: the distribution of a figure, its dependence on coordinates, and curves of individual runs.
//! Each title states what the picture shows. The same results yield the same bytes.

use crate::envelope::Envelope;
use crate::expect::runs_text;
use crate::results::{Loops, Quantity, Results};
use crate::summary::{Distribution, Summary, mean, percentile};
use crate::{Signals, Window};
use anyhow::{Context, Result};
use control::figures;
use draw::bars::{self, Bar};
use draw::histogram::{self, Mark};
use draw::plot::{self, Band, Chart, Curve, Panel};
use draw::scale::is_drawn;
use draw::scatter::{self, Scatter};
use modeldescription::digits::within;
use run::master::Recording;

/// The palette index for setpoints: black.
const SETPOINT: usize = 6;
/// The palette index for the runs of an envelope: blue.
const ENVELOPE: usize = 0;
/// The palette index for the band in which a loop counts as settled: green.
const SETTLED: usize = 2;

/// The minimum number of runs for which a title names percentiles, and for which a tornado chart is drawn.
const FEW_RUNS: usize = 20;

/// The maximum number of bars in a tornado chart.
const MOST_BARS: usize = 16;

/// The minimum magnitude of a correlation that a title mentions.
const WEAK: f64 = 0.2;

/// A quantity as an axis label: `settling in s`.
pub fn axis(of: &Quantity) -> String {
    match &of.unit {
        Some(unit) => format!("{} in {unit}", of.name),
        None => of.name.clone(),
    }
}

/// A value of a figure, with its unit and as many digits as the spread justifies.
fn told(of: &Distribution, value: f64) -> String {
    let text = told_bare(of, value);
    of.figure.unit.as_ref().map_or_else(|| text.clone(), |unit| format!("{text} {unit}").replace("degC", "°C"))
}

/// Like [`told`], but without the unit.
pub(crate) fn told_bare(of: &Distribution, value: f64) -> String {
    let at = |percent: f64| of.percentiles.iter().find(|(other, _)| *other == percent).map(|(_, value)| *value);
    let spread = at(95.0).zip(at(5.0)).map_or(0.0, |(high, low)| high - low);
    let spread = if spread > 0.0 { spread } else { of.max.zip(of.min).map_or(0.0, |(max, min)| max - min) };
    // A spread this small relative to the value is rounding.
    within(value, if spread < value.abs() * 1e-7 { 0.0 } else { spread })
}

/// A sentence stating that a figure is the same in all runs that have it; `None` if it varies, or if no run has it.
pub fn constant(of: &Distribution) -> Option<String> {
    let value = of.min.filter(|min| Some(*min) == of.max)?;
    Some(format!("{} is {} in every run", of.figure.name, told(of, value)))
}

/// A histogram of a figure, with the percentiles 5, 50 and 95 and `limits` marked; `None` if no run has the figure.
///
/// # Errors
/// It cannot be drawn.
pub fn histogram(summary: &Summary, figure: usize, values: &[f64], limits: &[Mark]) -> Result<Option<String>> {
    let of = &summary.figures[figure];
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| is_drawn(*value)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let is_constant = sorted.first() == sorted.last();
    let mark = |percent: f64| {
        let at = percentile(&sorted, percent)?;
        let name = if percent == 50.0 { "median".into() } else { format!("{percent} %") };
        Some(Mark { at, text: format!("{name}: {}", told(of, at)), is_limit: false })
    };
    let marks = [5.0, 50.0, 95.0].into_iter().filter(|_| !is_constant).filter_map(mark);
    let marks: Vec<Mark> = marks.chain(limits.iter().cloned()).collect();
    histogram::svg(&distributed(summary, of, values, &sorted), &axis(&of.figure), &sorted, &marks)
}

/// The title of a histogram; `sorted` are the values of the runs that have the figure.
fn distributed(summary: &Summary, of: &Distribution, values: &[f64], sorted: &[f64]) -> String {
    let (name, runs) = (&of.figure.name, runs_text(sorted.len() as u64));
    let at = |percent: f64| percentile(sorted, percent).unwrap_or(f64::NAN);
    let mut title = match (sorted.first(), sorted.last()) {
        (Some(min), Some(max)) if min == max => {
            let all = if sorted.len() as u64 == summary.runs && summary.runs > 1 { "all " } else { "" };
            format!("{name} is {} in {all}{runs}", told(of, *min))
        }
        (Some(min), Some(max)) if sorted.len() < FEW_RUNS => {
            format!("{name} of {runs}: {} to {}", told_bare(of, *min), told(of, *max))
        }
        _ => {
            // The percentile itself, not the share of runs beyond it: many runs may have exactly this value.
            let (rank, tail) = if of.figure.is_lower_better() { ("95th", at(95.0)) } else { ("5th", at(5.0)) };
            format!("{name} of {runs}: median {}, {rank} percentile {}", told_bare(of, at(50.0)), told(of, tail))
        }
    };
    let infinite = values.iter().filter(|value| value.is_infinite()).count() as u64;
    for (count, what) in [(summary.runs - summary.failed - of.count - infinite, "none"), (infinite, "an infinite one")]
    {
        if count > 0 {
            title += &format!("; {} {what}", have(count));
        }
    }
    title
}

/// `1 run has`, `2 runs have`
fn have(count: u64) -> String {
    format!("{} {}", runs_text(count), if count == 1 { "has" } else { "have" })
}

/// How a coordinate is drawn as an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coordinate {
    /// Whether its axis is logarithmic: its values are spaced geometrically or have a log-normal distribution.
    pub is_logarithmic: bool,
    /// Whether it has a list or a range of values, not samples of a distribution.
    pub is_listed: bool,
}

/// A scatter plot of the runs over the two coordinates that a figure depends on most, coloured by the figure; over one
/// coordinate if there is only one, with the figure as the height. `None` if nothing varies or no run has the figure.
/// The colours evenly divide the range between the 5th and the 95th percentile.
///
/// # Errors
/// It cannot be drawn.
pub fn scatter(
    results: &Results,
    summary: &Summary,
    figure: usize,
    coordinates: &[Coordinate],
) -> Result<Option<String>> {
    let of = &summary.figures[figure];
    let strongest = summary.strongest(figure);
    let Some(&first) = strongest.first() else { return Ok(None) };
    let second = strongest.get(1).copied();
    let values = results.figure(figure)?;
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| is_drawn(*value)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(low), Some(high)) = (percentile(&sorted, 5.0), percentile(&sorted, 95.0)) else { return Ok(None) };
    if sorted.len() < 2 {
        return Ok(None);
    }
    drop(sorted);
    // Only one column is in memory at a time, since each has a value for every run.
    let mut points: Vec<(f64, f64, f64)> = values.iter().map(|value| (0.0, *value, *value)).collect();
    drop(values);
    points.iter_mut().zip(&*results.coordinate(first)?).for_each(|(point, x)| point.0 = *x);
    if let Some(second) = second {
        points.iter_mut().zip(&*results.coordinate(second)?).for_each(|(point, y)| point.1 = *y);
    }
    let of_coordinate = |number: usize| coordinates.get(number).copied().unwrap_or_default();
    let is_map = strongest.iter().all(|number| of_coordinate(*number).is_listed);
    let best = if is_map { best_place(results, figure, &strongest, &points) } else { None };
    let title = best.unwrap_or_else(|| dependence(results, of, &strongest));
    let [across, up] = [Some(first), second].map(|number| match number {
        Some(number) => (axis(&results.coordinates[number]), of_coordinate(number).is_logarithmic),
        None => (axis(&of.figure), false),
    });
    scatter::svg(&Scatter {
        title: &title,
        points: &points,
        horizontal: (&across.0, across.1),
        vertical: (&up.0, up.1),
        is_curve: second.is_none(),
        range: (low, high),
        ends: if of.figure.is_lower_better() {
            (told_bare(of, low), told(of, high))
        } else {
            (told(of, low), told_bare(of, high))
        },
        is_lower_better: of.figure.is_lower_better(),
        absent: format!("without {}", of.figure.name),
    })
    .map(Some)
}

/// A tornado chart: how far the mean of a figure moves between the runs in the lowest fifth and those in the highest
/// fifth of each coordinate, largest effect first. `None` if nothing varies, no coordinate has an effect, or there are
/// fewer than twenty runs.
///
/// # Errors
/// It cannot be drawn.
pub fn tornado(results: &Results, summary: &Summary, figure: usize) -> Result<Option<String>> {
    let of = &summary.figures[figure];
    let values = results.figure(figure)?;
    let count = values.iter().filter(|value| is_drawn(**value)).count();
    let Some(middle) = of.mean.filter(|_| count >= FEW_RUNS) else { return Ok(None) };
    let ends = |places: &[f64]| {
        // The coordinate and the figure of each run that has the figure.
        let runs = || places.iter().copied().zip(values.iter().copied()).filter(|(_, value)| is_drawn(*value));
        let mut sorted: Vec<f64> = runs().map(|(at, _)| at).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (low, high) = (percentile(&sorted, 20.0)?, percentile(&sorted, 80.0)?);
        let mean_of = |is_in: &dyn Fn(f64) -> bool| {
            let values: Vec<f64> = runs().filter(|(at, _)| is_in(*at)).map(|(_, value)| value).collect();
            mean(&values)
        };
        let ends = [mean_of(&|at| at <= low)?, mean_of(&|at| at >= high)?];
        (sorted.first() < sorted.last()).then_some(ends)
    };
    let mut bars: Vec<Bar> = Vec::new();
    for (number, coordinate) in results.coordinates.iter().enumerate() {
        let ends = ends(&results.coordinate(number)?);
        bars.extend(ends.map(|ends| Bar { name: coordinate.name.clone(), ends }));
    }
    let width = |bar: &Bar| (bar.ends[1] - bar.ends[0]).abs();
    bars.sort_by(|one, other| width(other).total_cmp(&width(one)));
    bars.truncate(MOST_BARS);
    let Some(Bar { name, ends }) = bars.first().filter(|bar| width(bar) > 0.0) else { return Ok(None) };
    let title =
        format!("{} moves most with {name}: {} to {}", of.figure.name, told_bare(of, ends[0]), told(of, ends[1]));
    let halves = ["lowest fifth of the setting", "highest fifth"];
    bars::tornado(&title, &format!("mean of {}", axis(&of.figure)), middle, &bars, halves)
}

/// A phrase that names the coordinates with which a figure rises or falls.
fn dependence(results: &Results, of: &Distribution, coordinates: &[usize]) -> String {
    let name = &of.figure.name;
    if let Some(constant) = constant(of) {
        return constant;
    }
    let known = coordinates.iter().filter_map(|number| Some((*number, of.correlations[*number]?)));
    let strong: Vec<(usize, f64)> = known.filter(|(_, correlation)| correlation.abs() >= WEAK).collect();
    let word = |correlation: f64| if correlation > 0.0 { "rises" } else { "falls" };
    let mut text = String::new();
    for (place, (number, correlation)) in strong.iter().enumerate() {
        let verb = match place {
            0 => format!("{name} {} with", word(*correlation)),
            _ if word(*correlation) == word(strong[0].1) => " and".into(),
            _ => format!(" and {} with", word(*correlation)),
        };
        text += &format!("{verb} {} ({correlation:.2})", results.coordinates[*number].name);
    }
    if text.is_empty() { format!("{name} neither rises nor falls with one setting alone") } else { text }
}

/// A phrase that names the coordinate values at which a figure is best, averaged over the runs with these values.
/// `points` are the points of the scatter plot: the values of the first and, if there is one, the second coordinate,
/// and the figure. `None` if the figure has the same mean everywhere.
fn best_place(results: &Results, figure: usize, coordinates: &[usize], points: &[(f64, f64, f64)]) -> Option<String> {
    let place = |run: u32| {
        let (x, y, _) = points[run as usize];
        (x, if coordinates.len() > 1 { y } else { 0.0 })
    };
    let mut order: Vec<u32> = (0..).take(points.len()).collect();
    order.sort_by(|one, other| place(*one).partial_cmp(&place(*other)).unwrap_or(std::cmp::Ordering::Equal));
    let figure = &results.figures[figure];
    let mean = |runs: &[u32]| runs.iter().map(|run| points[*run as usize].2).sum::<f64>() / runs.len() as f64;
    let means = order.chunk_by(|one, other| place(*one) == place(*other)).map(|runs| (place(runs[0]), mean(runs)));
    let means: Vec<((f64, f64), f64)> = means.filter(|(_, mean)| mean.is_finite()).collect();
    let by_value = |one: &&((f64, f64), f64), other: &&((f64, f64), f64)| one.1.total_cmp(&other.1);
    let (least, greatest) = (means.iter().min_by(by_value)?, means.iter().max_by(by_value)?);
    let (word, (best, _)) = if figure.is_lower_better() { ("lowest", least) } else { ("highest", greatest) };
    (least.1 < greatest.1).then_some(())?;
    let at = coordinates.iter().zip([best.0, best.1]).map(|(number, value)| {
        let Quantity { name, unit, .. } = &results.coordinates[*number];
        let unit = unit.as_ref().map_or_else(String::new, |unit| format!(" {unit}"));
        format!("{name} = {}{unit}", within(value, value.abs()))
    });
    Some(format!("{} is {word} at {}", figure.name, at.collect::<Vec<_>>().join(" and ")))
}

/// The curves of some runs in one chart: the controlled signals above the controller's outputs, in front of the
/// `envelope` of many runs. `values` are the figures of the `runs`, each with a word such as `worst`, and the name of
/// its loop if there are `loops`; `absent` of all `count` runs lack the figure. Times outside the figures' window are
/// shaded, and the band in which the first run counts as settled is marked. `None` if no signal of the loop is
/// recorded.
///
/// # Errors
/// It cannot be drawn.
pub fn curves(
    signals: &Signals,
    (window, disturbances): (Window, &[figures::Set]),
    (of, values, [absent, count]): (&Distribution, &[f64], [u64; 2]),
    runs: &[(&str, u64, &Recording)],
    loops: Option<&Loops>,
    envelope: Option<&Envelope>,
) -> Result<Option<String>> {
    let Some((_, _, first)) = runs.first() else { return Ok(None) };
    let rows = runs.iter().map(|(_, _, recording)| recording.times.len()).min().unwrap_or(0);
    let column = |name: &str| first.columns.iter().position(|column| column.name == name);
    let values_of = |recording: &Recording, name: &str| -> Option<Vec<f64>> {
        let column = recording.columns.iter().position(|column| column.name == name)?;
        Some(recording.column(column).take(rows).collect())
    };
    let of_each = |name: &str| -> Vec<Curve> {
        let curve = |(place, (word, run, recording)): (usize, &(&str, u64, &Recording))| {
            let name_of_loop = loops.map_or_else(String::new, |loops| format!(" ({})", loops.name(*run)));
            let name_of_run = format!("{word}: run {run}{name_of_loop}");
            // Each run has a fixed colour: vermilion, blue, green.
            let color = Some([1, 0, 2].get(place).copied().unwrap_or(place));
            Some(Curve { name: name_of_run, values: values_of(recording, name)?, is_input: false, color })
        };
        runs.iter().enumerate().filter_map(curve).collect()
    };
    let label = |name: &str| match column(name).and_then(|column| first.columns[column].unit.as_ref()) {
        Some(unit) => format!("{name} in {unit}"),
        None => name.to_string(),
    };
    let times = &first.times[..rows];
    let mut panels = Vec::new();
    let mut shown_window = None;
    if let Some(name) = &signals.process_value {
        let mut panel = Panel { label: label(name), curves: of_each(name), ..Panel::default() };
        if let Some(setpoint) = &signals.setpoint {
            let all: Vec<_> = runs.iter().filter_map(|(_, _, recording)| values_of(recording, setpoint)).collect();
            if let (Some(setpoint), Some(process_value)) = (all.first(), values_of(first, name)) {
                let signals = figures::Signals {
                    times,
                    setpoint,
                    process_value: &process_value,
                    disturbances,
                    ..Default::default()
                };
                let span = figures::Span { from: window.from, to: window.to, ..figures::Span::default() };
                let of_figures = figures::Window::measure(signals, &span);
                shown_window = of_figures.times();
                panel.bands.extend(of_figures.band().map(|band| Band {
                    name: "settled".into(),
                    times: vec![band.times.0, band.times.1],
                    low: vec![band.low; 2],
                    high: vec![band.high; 2],
                    color: SETTLED,
                }));
            }
            let are_equal = all.windows(2).all(|pair| pair[0] == pair[1]);
            let shown = if are_equal { 1 } else { all.len() };
            for (values, (word, ..)) in all.into_iter().zip(runs).take(shown) {
                let name = if are_equal { "setpoint".into() } else { format!("setpoint ({word})") };
                panel.curves.push(Curve { name, values, is_input: true, color: Some(SETPOINT) });
            }
        }
        panel.bands.extend(envelope.filter(|_| !panel.curves.is_empty()).map(|envelope| Band {
            name: format!("5 to 95 % of {}", runs_text(envelope.runs)),
            times: envelope.times.clone(),
            low: envelope.low.clone(),
            high: envelope.high.clone(),
            color: ENVELOPE,
        }));
        panels.push(panel);
    }
    let own = of.figure.of.as_ref().map(|(variable, _)| variable.as_str());
    let shown = |name: &&str| {
        Some(*name) != signals.process_value.as_deref() && Some(*name) != signals.manipulated_value.as_deref()
    };
    for name in own.filter(shown).into_iter().chain(signals.manipulated_value.as_deref()) {
        panels.push(Panel { label: label(name), curves: of_each(name), ..Panel::default() });
    }
    panels.retain(|panel| !panel.curves.is_empty());
    let is_pulsed = signals.manipulated_value.is_none();
    let pulses = signals.pulses.iter().flatten().filter(|_| is_pulsed);
    let lanes = pulses.flat_map(|name| {
        of_each(name).into_iter().map(move |curve| Curve { name: format!("{name}, {}", curve.name), ..curve })
    });
    let lanes: Vec<Curve> = lanes.collect();
    if panels.is_empty() && lanes.is_empty() {
        return Ok(None);
    }
    let value = |((word, ..), value): (&(&str, u64, &Recording), &f64)| {
        let value = told(of, *value);
        match runs.len() {
            1 => value,
            _ if absent > 0 => format!("{value} ({word})"),
            _ => format!("{value} in the {word} run"),
        }
    };
    let mut title =
        format!("{} is {}", of.figure.name, runs.iter().zip(values).map(value).collect::<Vec<_>>().join(", "));
    if absent > 0 {
        // Runs without the figure are worse than the worst run with it.
        title += &format!("; {absent} of {} none", have(count));
    }
    let window = shown_window.filter(|(from, to)| Some(from) != times.first() || Some(to) != times.last());
    let over = window.map(|_| "time in s; the figures refer to the unshaded part".to_string());
    // Use `time_label` rather than `over`, which would draw straight lines instead of stairs.
    let chart = Chart { title, time: times.to_vec(), time_label: over, panels, lanes, window, ..Chart::default() };
    plot::svg(&chart).context("the curves cannot be drawn").map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Take;
    use crate::report::tests::recording;
    use crate::results::{Aspect, RunResult};

    fn quantity(name: &str) -> Quantity {
        let of = name.strip_suffix(".max").map(|variable| (variable.into(), Aspect::Taken(Take::Max)));
        Quantity { of, ..Quantity::new(name, Some("s")) }
    }

    /// Results of a figure over `width` coordinates.
    fn results(points: &[[f64; 2]], width: usize, figure: &str, values: &[f64]) -> Results {
        let mut results = Results::new(["P.A", "P.B"].map(quantity)[..width].to_vec(), vec![quantity(figure)]);
        for (point, value) in points.iter().zip(values) {
            results.push(&point[..width], &RunResult { figures: vec![*value], error: None }).unwrap();
        }
        results
    }

    fn of(values: &[f64]) -> Option<String> {
        let results = results(&vec![[0.0; 2]; values.len()], 0, "settling", values);
        histogram(&Summary::new(&results, 1).unwrap(), 0, values, &[]).unwrap()
    }

    fn over(points: &[[f64; 2]], width: usize, values: &[f64], is_listed: bool) -> Option<String> {
        let results = results(points, width, "settling", values);
        let coordinates = [Coordinate { is_logarithmic: false, is_listed }; 2];
        scatter(&results, &Summary::new(&results, 1).unwrap(), 0, &coordinates).unwrap()
    }

    fn has(drawing: &str, text: &str) -> bool {
        drawing.contains(&format!(">{text}</text>"))
    }

    #[test]
    fn a_histogram_says_what_it_shows_with_the_digits_that_the_spread_tells() {
        let drawing = of(&(0..=100).map(|run| 100.0 + f64::from(run) / 10.0 + 0.0123).collect::<Vec<_>>()).unwrap();
        for text in ["settling of 101 runs: median 105, 95th percentile 109.5 s", "5 %: 100.5 s", "settling in s"] {
            assert!(has(&drawing, text), "{text}");
        }
        assert!(has(&of(&[2.0, f64::NAN, 4.0]).unwrap(), "settling of 2 runs: 2 to 4 s; 1 run has none"));
        let constant = of(&[100.0; 30]).unwrap();
        assert!(has(&constant, "settling is 100 s in all 30 runs") && !constant.contains("median"), "{constant}");
        assert_eq!(of(&[f64::NAN]), None);
        // A tenth of the runs are at the 95th percentile, and none are above it.
        let tied: Vec<f64> = (0..100).map(|run| if run < 10 { 100.0 } else { 63.0 }).collect();
        assert!(has(&of(&tied).unwrap(), "settling of 100 runs: median 63, 95th percentile 100 s"));
        let infinite = of(&[2.0, f64::INFINITY, f64::NAN, 4.0]).unwrap();
        assert!(
            has(&infinite, "settling of 2 runs: 2 to 4 s; 1 run has none; 1 run has an infinite one"),
            "{infinite}"
        );
    }

    #[test]
    fn a_tornado_chart_has_the_means_of_the_lowest_and_the_highest_fifth() {
        let points: Vec<[f64; 2]> = (0..25).map(|run| [f64::from(run % 5), f64::from(run / 5)]).collect();
        let values: Vec<f64> = points.iter().map(|[a, b]| 10.0 * b - a).collect();
        let results = results(&points, 2, "settling", &values);
        let drawing = tornado(&results, &Summary::new(&results, 1).unwrap(), 0).unwrap().unwrap();
        // b = 0 and 4, each with the mean of a: -2 and 38.
        assert!(has(&drawing, "settling moves most with P.B: -2 to 38 s"), "{drawing}");
        assert!(drawing.find(">P.B<") < drawing.find(">P.A<") && has(&drawing, "mean of settling in s"));
        let few = super::tests::results(&points[..19], 2, "settling", &values);
        assert_eq!(tornado(&few, &Summary::new(&few, 1).unwrap(), 0).unwrap(), None);
        let constant = super::tests::results(&points, 2, "settling", &[3.0; 25]);
        let summary = Summary::new(&constant, 1).unwrap();
        assert_eq!(tornado(&constant, &summary, 0).unwrap(), None);
        assert_eq!(super::constant(&summary.figures[0]).unwrap(), "settling is 3 s in every run");
    }

    #[test]
    fn a_scatter_plot_says_with_what_the_figure_rises_and_falls() {
        let points: Vec<[f64; 2]> = (0..40).map(|run| [f64::from(run), f64::from(run * 17 % 40)]).collect();
        let draw = |value: fn(&[f64; 2]) -> f64| {
            over(&points, 2, &points.iter().map(value).collect::<Vec<_>>(), false).unwrap()
        };
        let rising = draw(|point| point[0]);
        assert!(has(&rising, "settling rises with P.A (1.00)"), "{rising}");
        assert!(draw(|point| point[0] - 2.0 * point[1]).contains("settling falls with P.B (-0."));
        assert!(has(&draw(|_| 3.0), "settling is 3 s in every run"));
        assert!(has(&draw(|point| (point[0] - 19.5).abs()), "settling neither rises nor falls with one setting alone"));
    }

    #[test]
    fn a_grid_says_where_the_figure_is_the_best() {
        let points: Vec<[f64; 2]> = (0..12).map(|run| [f64::from(run / 4), f64::from(run % 4)]).collect();
        let values: Vec<f64> = points.iter().map(|[a, b]| (a - 1.0).powi(2) + (b - 3.0).powi(2)).collect();
        let drawing = over(&points, 2, &values, true).unwrap();
        assert!(has(&drawing, "settling is lowest at P.B = 3 s and P.A = 1 s"), "{drawing}");
    }

    #[test]
    fn over_one_coordinate_the_figure_is_the_height_and_no_grid() {
        let points = [[1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 0.0]];
        let one = over(&points, 1, &[1.0, 2.0, 1.0, 2.0], true).unwrap();
        assert!(has(&one, "P.A in s") && has(&one, "settling in s") && one.matches("h0").count() == 4);
        assert_eq!(over(&points, 0, &[1.0, 2.0, 4.0, 3.0], false), None);
    }

    #[test]
    fn the_curves_of_runs_share_axes_before_the_envelope_and_the_setpoint_is_drawn_once() {
        let signals = Signals {
            setpoint: Some("PID.SP".into()),
            process_value: Some("HEATER.TEMP".into()),
            manipulated_value: Some("PID.LMN".into()),
            pulses: None,
        };
        let (worst, best) = (recording(80.0), recording(60.0));
        let runs = [("worst", 1, &worst), ("best", 0, &best)];
        let values = [1.0, 3.0];
        let of_runs = [values[1], values[0]];
        let draw = |signals: &Signals, figure: &str, loops: Option<&Loops>, envelope: Option<&Envelope>| {
            let results = results(&[[0.0; 2]; 2], 0, figure, &values);
            let summary = Summary::new(&results, 1).unwrap();
            curves(signals, Default::default(), (&summary.figures[0], &of_runs, [0, 2]), &runs, loops, envelope)
                .unwrap()
        };
        let times = vec![0.0, 2.0];
        let envelope = Envelope { runs: 200, times, low: vec![20.0; 2], high: vec![70.0; 2] };
        let drawing = draw(&signals, "iae", None, Some(&envelope)).unwrap();
        for (text, count) in [
            ("worst: run 1", 2),
            ("best: run 0", 2),
            ("setpoint", 1),
            ("5 to 95 % of 200 runs", 1),
            ("HEATER.TEMP in °C", 1),
            ("PID.LMN in %", 1),
            ("iae is 3 s in the worst run, 1 s in the best run", 1),
        ] {
            assert_eq!(drawing.matches(&format!(">{text}</text>")).count(), count, "{text}");
        }
        // Each run has one colour: twice a line in the legend and one in the panel.
        assert_eq!(drawing.matches("class=\"curve-2\"").count(), 4);
        assert_eq!(draw(&Signals::default(), "iae", None, None), None);
        assert!(has(&draw(&Signals::default(), "HEATER.TEMP.max", None, None).unwrap(), "HEATER.TEMP in °C"));
        let absent = {
            let values = [1.0, 3.0, f64::NAN];
            let results = results(&[[0.0; 2]; 3], 0, "settling", &values);
            let summary = Summary::new(&results, 1).unwrap();
            curves(&signals, Default::default(), (&summary.figures[0], &[3.0, 1.0], [1, 3]), &runs, None, None)
                .unwrap()
                .unwrap()
        };
        assert!(has(&absent, "settling is 3 s (worst), 1 s (best); 1 of 3 runs have none"));
        let loops = Loops { names: vec!["TIC101".into(), "TIC102".into()], runs: 1 };
        let drawing = draw(&signals, "iae", Some(&loops), None).unwrap();
        assert!(has(&drawing, "worst: run 1 (TIC102)") && has(&drawing, "best: run 0 (TIC101)"));
    }
}
