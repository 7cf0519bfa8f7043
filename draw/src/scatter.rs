//! Scatter plots: values as functions of one or two other quantities, drawn as coloured points or cells.

use crate::field::{Axis, Field, LEFT, Label, RIGHT, Shape, Style, WIDTH, pitch};
use crate::palette;
use crate::scale::{Scale, is_drawn};
use crate::svg::Pixels;
use modeldescription::digits::short;
use modeldescription::units;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

// Lengths in pixels.
const TOP: f64 = 54.0;
const HEIGHT: f64 = 360.0;
/// The vertical position of the colour scale.
const KEY_Y: f64 = 36.0;
/// The width of a colour in the colour scale.
const KEY: f64 = 26.0;

/// The maximum number of points; more are merged into cells.
const MOST_POINTS: usize = 4000;
/// The width and height of a cell of merged points.
const CELL: f64 = 6.0;
/// The maximum number of crosses for points without a value; more are merged, one per cell of [`CROSS_CELL`].
const MOST_CROSSES: usize = 500;
/// The width and height of a cell of merged crosses: one cross and a gap.
const CROSS_CELL: f64 = 10.0;
/// The width and height, in pixels, of an area within which points count as one.
const POINT: f64 = 0.01;
/// A grid uses its values along an axis as ticks if there are at most this many.
const MOST_TICKS: usize = 8;

/// The colours from best to worst, from blue to vermilion, distinguishable with colour vision deficiency.
const LEVELS: [&str; 7] = [
    palette::PROCESS_VALUE,
    palette::color("level-2"),
    palette::color("level-3"),
    palette::color("level-4"),
    palette::color("level-5"),
    palette::color("level-6"),
    palette::MANIPULATED_VALUE,
];

/// The contents of a scatter plot.
#[derive(Clone, Debug)]
pub struct Scatter<'a> {
    /// The title above it.
    pub title: &'a str,
    /// The points: horizontal and vertical position, and value. A point with NaN as its value is drawn as a cross.
    pub points: &'a [(f64, f64, f64)],
    /// The label of the horizontal axis, and whether it is logarithmic.
    pub horizontal: (&'a str, bool),
    /// The label of the vertical axis, and whether it is logarithmic.
    pub vertical: (&'a str, bool),
    /// Whether the vertical position is the value itself, so that the points cannot form a grid.
    pub is_curve: bool,
    /// The range of values that is divided evenly among the colours.
    pub range: (f64, f64),
    /// The labels of the range's ends.
    pub ends: (String, String),
    /// Whether low values are better.
    pub is_lower_better: bool,
    /// The text that follows the number of points without a value, such as `without settling`.
    pub absent: String,
}

/// Draws a scatter plot. Points at the same position are drawn once, with their mean; an even grid is drawn as cells,
/// and more than 4000 points are merged into cells.
///
/// # Errors
/// The plot cannot be drawn.
pub fn svg(scatter: &Scatter) -> anyhow::Result<String> {
    let drawable = scatter.points.iter().filter(|(x, y, _)| is_drawn(*x) && is_drawn(*y));
    let axis = |(label, is_logarithmic): (&str, bool), at: fn(&(f64, f64, f64)) -> f64| {
        Axis::around(label, drawable.clone().map(at), is_logarithmic)
    };
    let [horizontal, vertical] = [axis(scatter.horizontal, |point| point.0), axis(scatter.vertical, |point| point.1)];
    let mut field = Field { title: scatter.title, horizontal, vertical, left: LEFT, top: TOP, height: HEIGHT };
    let grid = if scatter.is_curve { None } else { grid(&mut field, drawable.clone()) };
    let of_value = drawable.clone().filter(|(_, _, value)| is_drawn(*value));
    let points = of_value.map(|(x, y, value)| (field.x(*x), field.y(*y), *value));
    let are_many = grid.is_none() && fill_more(points.clone(), POINT, MOST_POINTS);
    let size = if are_many { Some((CELL, CELL)) } else { grid };
    let mut drawn = cells(points.clone(), if are_many { CELL } else { POINT });
    if are_many {
        drawn.iter_mut().for_each(|(x, y, _)| (*x, *y) = (*x + CELL / 2.0, *y + CELL / 2.0));
    }
    let level = |value: f64| {
        let (low, high) = scatter.range;
        let part = if high > low { (value - low) / (high - low) } else { 0.5 };
        let part = if scatter.is_lower_better { part } else { 1.0 - part };
        ((part * LEVELS.len() as f64) as usize).min(LEVELS.len() - 1)
    };
    let mut paths = vec![String::new(); LEVELS.len()];
    for (x, y, value) in &drawn {
        let path = &mut paths[level(*value)];
        match size {
            // Clip to the plot area.
            Some((width, height)) => {
                let (left, right) = ((x - width / 2.0).max(LEFT), (x + width / 2.0).min(WIDTH - RIGHT));
                let (top, bottom) = ((y - height / 2.0).max(TOP), (y + height / 2.0).min(TOP + HEIGHT));
                write!(
                    path,
                    "M{} {}H{}V{}H{}z",
                    Pixels(left),
                    Pixels(top),
                    Pixels(right),
                    Pixels(bottom),
                    Pixels(left)
                )?;
            }
            None => write!(path, "M{} {}h0", Pixels(*x), Pixels(*y))?,
        }
    }
    let style = match size {
        Some(_) => Style::Area(1.0),
        None => Style::Dots(if drawn.len() > 500 { 5.0 } else { 8.0 }),
    };
    let class = |(level, path): (usize, String)| shape(level, path, style);
    let mut shapes: Vec<Shape> =
        paths.into_iter().enumerate().filter(|(_, path)| !path.is_empty()).map(class).collect();
    let without = drawable.filter(|(_, _, value)| !is_drawn(*value));
    let without = without.map(|(x, y, _)| (field.x(*x), field.y(*y), 0.0));
    let are_many = fill_more(without.clone(), POINT, MOST_CROSSES);
    let mut marked = cells(without.clone(), if are_many { CROSS_CELL } else { POINT });
    if are_many {
        marked.iter_mut().for_each(|(x, y, _)| (*x, *y) = (*x + CROSS_CELL / 2.0, *y + CROSS_CELL / 2.0));
    }
    let mut crosses = String::new();
    for (x, y, _) in &marked {
        write!(crosses, "M{} {}l6 6m0-6l-6 6", Pixels(x - 3.0), Pixels(y - 3.0))?;
    }
    if !crosses.is_empty() {
        shapes.push(Shape { class: "curve-7".into(), color: "#000000", path: crosses, style: Style::Line(1.2) });
    }
    let mean_of = (drawn.len() < points.count()).then_some(if size.is_some() { "a cell" } else { "a point" });
    let labels = keys(scatter, mean_of, (without.count(), marked.len()), &mut shapes);
    field.svg(&shapes, &labels)
}

fn shape(level: usize, path: String, style: Style) -> Shape {
    Shape { class: format!("level-{}", level + 1), color: LEVELS[level], path, style }
}

/// The cell size of an even grid with a point at each position; `None` if the points do not form one or are too close.
/// Gives the plot area a margin of half a cell on each side and, if there are few values, uses them as ticks.
fn grid<'a>(field: &mut Field, points: impl Iterator<Item = &'a (f64, f64, f64)> + Clone) -> Option<(f64, f64)> {
    let (horizontal, vertical) = (&field.horizontal, &field.vertical);
    let (width, columns) = pitch(points.clone().map(|point| horizontal.place(point.0)))?;
    let (height, rows) = pitch(points.clone().map(|point| vertical.place(point.1)))?;
    let [wide, high] = [(WIDTH - LEFT - RIGHT) / columns as f64, HEIGHT / rows as f64];
    if wide < CELL || high < CELL {
        return None;
    }
    let number = |axis: &Axis, value: f64, pitch: f64| ((axis.place(value) - axis.scale.from) / pitch).round() as i64;
    let place = |(x, y, _): &(f64, f64, f64)| (number(horizontal, *x, width), number(vertical, *y, height));
    let places: BTreeSet<(i64, i64)> = points.clone().map(place).collect();
    if places.len() != columns * rows {
        return None;
    }
    for (axis, is_across, pitch, count) in
        [(&mut field.horizontal, true, width, columns), (&mut field.vertical, false, height, rows)]
    {
        let mut values: Vec<f64> = points.clone().map(|(x, y, _)| if is_across { *x } else { *y }).collect();
        values.sort_unstable_by(f64::total_cmp);
        let (from, to) = (axis.place(values[0]), axis.place(values[values.len() - 1]));
        axis.scale = Scale { from: from - pitch / 2.0, to: to + pitch / 2.0 };
        if count <= MOST_TICKS {
            values.dedup_by(|a, b| a.to_bits() == b.to_bits());
            let mut ticks: Vec<(f64, String)> = values.into_iter().map(|value| (value, short(value))).collect();
            ticks.dedup_by(|a, b| a.1 == b.1);
            axis.ticks = Some(ticks);
        }
    }
    Some((wide, high))
}

/// The column and row of the cell of the given size that contains a point.
fn cell(x: f64, y: f64, size: f64) -> (i64, i64) {
    (((x - LEFT) / size).floor() as i64, ((y - TOP) / size).floor() as i64)
}

/// Whether points occupy more than `most` cells of this size.
fn fill_more(mut points: impl Iterator<Item = (f64, f64, f64)>, size: f64, most: usize) -> bool {
    let mut cells = BTreeSet::new();
    points.any(|(x, y, _)| {
        cells.insert(cell(x, y, size));
        cells.len() > most
    })
}

/// The occupied cells of this size, column by column: left edge, top edge, and the mean of the values in the cell.
fn cells(points: impl Iterator<Item = (f64, f64, f64)>, size: f64) -> Vec<(f64, f64, f64)> {
    let mut cells = BTreeMap::<(i64, i64), (f64, f64)>::new();
    for (x, y, value) in points {
        let (sum, count) = cells.entry(cell(x, y, size)).or_default();
        (*sum, *count) = (*sum + value, *count + 1.0);
    }
    let place = |((column, row), (sum, count)): ((i64, i64), (f64, f64))| {
        (LEFT + column as f64 * size, TOP + row as f64 * size, sum / count)
    };
    cells.into_iter().map(place).collect()
}

/// Adds the colour scale to `shapes` and returns its labels, with the key to the marks. `crosses` crosses represent
/// `absent` points without a value.
fn keys(of: &Scatter, mean_of: Option<&str>, (absent, crosses): (usize, usize), shapes: &mut Vec<Shape>) -> Vec<Label> {
    let label =
        |x: f64, text: String| Label { x, y: KEY_Y + 4.0, anchor: "start", text: units::shown(&text), of: None };
    let (low, high) = &of.ends;
    let (best, mut end) = if of.is_lower_better {
        (format!("≤ {low}"), format!("≥ {high}"))
    } else {
        (format!("≥ {high}"), format!("≤ {low}"))
    };
    let begin = LEFT + best.chars().count() as f64 * 7.0 + 8.0;
    for level in 0..LEVELS.len() {
        let path = format!("M{} {}h{}", Pixels(begin + level as f64 * KEY), Pixels(KEY_Y), Pixels(KEY));
        shapes.push(shape(level, path, Style::Line(9.0)));
    }
    if let Some(mark) = mean_of {
        end += &format!("; {mark} shows the mean of its runs");
    }
    if absent > 0 {
        let runs = match absent {
            1 => "1 run".to_string(),
            _ if crosses < absent => format!("positions of {absent} runs"),
            _ => format!("{absent} runs"),
        };
        end += &format!("; ×: {runs} {}", of.absent);
    }
    vec![label(LEFT, best), label(begin + LEVELS.len() as f64 * KEY + 8.0, end)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[(f64, f64, f64)], logarithmic: bool) -> String {
        svg(&Scatter {
            title: "T",
            points,
            horizontal: ("GAIN", logarithmic),
            vertical: ("TI in s", false),
            is_curve: false,
            range: (0.0, 10.0),
            ends: ("0".into(), "10 s".into()),
            is_lower_better: true,
            absent: "without settling".into(),
        })
        .unwrap()
    }

    /// The corners of all cells.
    fn corners(drawing: &str) -> Vec<[f64; 4]> {
        let paths = drawing.split(" d=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let cells = paths.flat_map(|path| path.split('M')).filter(|cell| cell.ends_with('z'));
        cells
            .map(|cell| {
                let numbers = cell.split([' ', 'H', 'V', 'z']).filter_map(|number| number.parse().ok());
                let numbers: Vec<f64> = numbers.collect();
                [numbers[0], numbers[1], numbers[2], numbers[3]]
            })
            .collect()
    }

    #[test]
    fn an_even_grid_fills_the_field_with_its_cells_and_no_cell_reaches_beyond() {
        for (columns, rows) in [(2, 2), (3, 4), (2, 9)] {
            let points: Vec<_> = (0..columns * rows)
                .map(|run| (f64::from(run % columns), f64::from(run / columns), f64::from(run)))
                .collect();
            let cells = corners(&of(&points, false));
            assert_eq!(cells.len(), points.len());
            let area: f64 = cells.iter().map(|[left, top, right, bottom]| (right - left) * (bottom - top)).sum();
            assert!((area / (660.0 * 360.0) - 1.0).abs() < 1e-3, "{columns} x {rows}: {area}");
            assert!(cells.iter().all(|[left, top, right, bottom]| {
                *left >= LEFT && *top >= TOP && *right <= WIDTH - RIGHT && *bottom <= TOP + HEIGHT
            }));
        }
    }

    #[test]
    fn an_uneven_grid_and_one_with_gaps_are_points() {
        let uneven = [1.0, 2.0, 5.0].map(|x| [1.0, 2.0].map(|y| (x, y, x))).concat();
        assert_eq!((corners(&of(&uneven, false)).len(), of(&uneven, false).matches("h0").count()), (0, 6));
        // Equal ratios are even on a logarithmic axis.
        let ratios = [1.0, 10.0, 100.0].map(|x| [1.0, 2.0].map(|y| (x, y, x))).concat();
        assert_eq!(corners(&of(&ratios, true)).len(), 6);
        let gap = &[(1.0, 1.0, 1.0), (2.0, 1.0, 2.0), (1.0, 2.0, 3.0)];
        assert_eq!(of(gap, false).matches("h0").count(), 3);
    }

    #[test]
    fn points_at_the_same_place_are_one_with_their_mean_and_a_grid_names_its_few_values() {
        let samples: Vec<_> =
            (0..18).map(|run| (f64::from(run % 3) + 0.25, f64::from(run / 3 % 3), f64::from(run))).collect();
        let drawing = of(&samples, false);
        assert_eq!(corners(&drawing).len(), 9);
        assert!(drawing.contains("a cell shows the mean of its runs"));
        for tick in ["0.25", "1.25", "2.25"] {
            assert!(drawing.contains(&format!("text-anchor=\"middle\">{tick}</text>")), "{tick}");
        }
    }

    #[test]
    fn many_points_are_cells_of_a_small_file_within_the_field_and_few_are_points() {
        let spiral = |count: u32| {
            let point = |run: u32| {
                let (along, angle) = (f64::from(run) / f64::from(count), f64::from(run) * 2.4);
                (along * angle.cos(), along * angle.sin(), along * 10.0)
            };
            of(&(0..count).map(point).collect::<Vec<_>>(), false)
        };
        assert_eq!(spiral(1000).matches("h0").count(), 1000);
        let many = spiral(100_000);
        assert!(many.len() < 400_000, "{}", many.len());
        assert!(corners(&many).iter().all(|[left, top, ..]| *left >= LEFT && *top >= TOP));
    }

    #[test]
    fn points_without_a_value_are_crosses() {
        let drawing = of(&[(1.0, 1.0, f64::NAN), (2.0, 5.0, 2.0), (3.0, 1.0, 3.0)], false);
        assert!(drawing.contains("×: 1 run without settling"), "{drawing}");
    }

    #[test]
    fn crosses_are_wherever_runs_have_no_value_however_many_there_are() {
        // Nine rows of 100 points from the bottom to the top; the lowest row alone has values.
        let points: Vec<_> = (0..900)
            .map(|run| (f64::from(run % 100), f64::from(run / 100), if run < 100 { 1.0 } else { f64::NAN }))
            .collect();
        let drawing = of(&points, false);
        let crosses = drawing.split(" d=\"").find(|path| path.contains("l6 6m0-6l-6 6")).unwrap();
        let places = crosses.split('M').filter_map(|cross| cross.split_once("l6 6m0-6")?.0.split_once(' '));
        let places = places.map(|(x, y)| (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap().round() as i64));
        let mut heights = BTreeMap::<i64, Vec<f64>>::new();
        places.for_each(|(x, y)| heights.entry(y).or_default().push(x));
        // Each of the eight rows without values is marked from the left to the right: 653 pixels in cells of 10.
        assert_eq!(heights.len(), 8, "{heights:?}");
        for row in heights.values() {
            let (first, last) = (row[0], row[row.len() - 1]);
            assert!((60..=67).contains(&row.len()) && first < LEFT + 10.0 && last > WIDTH - RIGHT - 20.0, "{row:?}");
        }
        assert!(drawing.contains("×: positions of 800 runs without settling"));
    }
}
