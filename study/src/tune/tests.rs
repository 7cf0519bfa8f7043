use super::*;
use crate::expect::Comparison;

fn problem(axes: &[(f64, f64)]) -> Problem {
    let search = |(number, (min, max)): (usize, &(f64, f64))| Search {
        variable: format!("C.V{number}"),
        min: *min,
        max: *max,
        linear: false,
        grid: Grid::Digits,
    };
    Problem {
        minimize: 0,
        over: Over::Worst,
        constraints: Vec::new(),
        front: None,
        evaluations: 300,
        seed: 0,
        search: axes.iter().enumerate().map(search).collect(),
    }
}

fn upper(figure: usize, bound: f64) -> Constraint {
    let text = format!("f{figure} < {bound}");
    Constraint(Expectation { text, figure, of: Of::Each, comparison: Comparison::Less, bound })
}

fn row(figures: &[f64]) -> RunResult {
    RunResult { figures: figures.to_vec(), error: None }
}

/// Searches with figures that depend on the values and on the number of one of three plants.
fn searched(problem: &Problem, figures: impl Fn(&[f64], f64) -> Vec<f64>) -> Outcome {
    let plants = |values: &Vec<f64>| [-1.0, 0.0, 1.0].map(|plant| row(&figures(values, plant))).to_vec();
    let evaluate = |batch: &[Vec<f64>]| Ok(Some(batch.iter().map(plants).collect()));
    search(problem, None, evaluate, |_, _| {}).unwrap()
}

fn assert_near(is: &[f64], expected: &[f64], relative: f64) {
    for (is, expected) in is.iter().zip(expected) {
        assert!((is / expected - 1.0).abs() < relative, "{is} instead of {expected}");
    }
}

#[test]
fn the_lowest_value_of_a_curved_valley_is_found_in_logarithmic_ranges() {
    let problem = problem(&[(0.1, 100.0), (1.0, 1000.0)]);
    let outcome = searched(&problem, |values, _| {
        let (x, y) = ((values[0] / 2.5).ln(), (values[1] / 40.0).ln());
        vec![1.0 + x * x + 5.0 * (y - x * x).powi(2)]
    });
    assert_near(&outcome.candidates[outcome.best].values, &[2.5, 40.0], 0.02);
    assert!(outcome.candidates.len() <= 300);
}

#[test]
fn the_best_settings_are_those_of_the_worst_plant() {
    // Each plant has a different optimum: the worst of all is lowest in the middle between the outer ones.
    let problem =
        Problem { search: vec![Search { linear: true, ..problem(&[(0.5, 9.0)]).search.remove(0) }], ..problem(&[]) };
    let outcome = searched(&problem, |values, plant| vec![(values[0] - 4.0 - 2.0 * plant).powi(2)]);
    let best = &outcome.candidates[outcome.best];
    assert_near(&best.values, &[4.0], 0.005);
    assert!((best.objective.unwrap() - 4.0).abs() < 0.05, "{best:?}");
}

#[test]
fn the_optimum_on_a_constraint_keeps_it_and_says_that_it_is_active() {
    // The maximum product of two numbers whose sum is below 10 for the worst plant: 4.5 and 4.5.
    let constraint = upper(1, 10.0);
    let problem =
        Problem { constraints: vec![constraint.clone(), upper(2, 100.0)], ..problem(&[(0.1, 50.0), (0.1, 50.0)]) };
    let outcome = searched(&problem, |values, plant| {
        vec![1.0 / (values[0] * values[1]), values[0] + values[1] + plant, values[0]]
    });
    let best = &outcome.candidates[outcome.best];
    assert!(best.is_feasible());
    assert_near(&best.values, &[4.5, 4.5], 0.05);
    assert!(best.values.iter().sum::<f64>() + 1.0 < 10.0);
    let active: Vec<bool> = problem.constraints.iter().map(|of| of.is_active(&best.rows)).collect();
    assert_eq!(active, [true, false]);
    assert!((constraint.value(&best.rows) - 10.0).abs() < 0.1);
}

#[test]
fn an_optimum_at_the_end_of_a_range_is_found_there() {
    let problem = problem(&[(0.1, 10.0), (2.0, 50.0)]);
    let outcome = searched(&problem, |values, _| vec![values[0] + 100.0 / values[1]]);
    let best = &outcome.candidates[outcome.best];
    assert_near(&best.values, &[0.1, 50.0], 0.01);
    let ends: Vec<_> = problem.search.iter().zip(&best.values).map(|(search, value)| search.end(*value)).collect();
    assert_eq!(ends, [Some("min"), Some("max")]);
}

#[test]
fn the_front_of_two_figures_is_filled_and_lies_where_it_is_known_to_be() {
    // Schaffer's problem: on the front, the roots of both figures add up to 2.
    let mut problem = Problem { front: Some(1), ..problem(&[(0.01, 10.0), (0.01, 10.0)]) };
    problem.search.iter_mut().for_each(|search| search.linear = true);
    let outcome = searched(&problem, |values, _| {
        let off = (values[1] - 5.0).powi(2);
        vec![(values[0] - 3.0).powi(2) + off, (values[0] - 5.0).powi(2) + off]
    });
    let figures: Vec<(f64, f64)> = outcome
        .front
        .iter()
        .map(|number| &outcome.candidates[*number])
        .map(|candidate| (candidate.objective.unwrap(), candidate.second.unwrap()))
        .collect();
    assert!(figures.len() >= 10, "{figures:?}");
    for (first, second) in &figures {
        let sum = first.sqrt() + second.sqrt();
        assert!((2.0 - 1e-9..2.1).contains(&sum), "{sum} at {first}, {second}");
    }
    assert!(figures.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 > pair[1].1), "{figures:?}");
    let largest_gap = figures.windows(2).map(|pair| pair[0].1 - pair[1].1).fold(0.0, f64::max);
    assert!(largest_gap < 1.0, "{figures:?}");
}

#[test]
fn candidates_of_the_front_keep_the_constraints() {
    let problem = Problem {
        front: Some(1),
        constraints: vec![upper(2, 4.0)],
        evaluations: 400,
        ..problem(&[(0.1, 10.0), (0.1, 10.0)])
    };
    let outcome = searched(&problem, |values, plant| {
        vec![10.0 / values[0] + values[1], values[0] + (values[1] - 1.0).powi(2), values[0] + 0.5 * plant]
    });
    assert!(outcome.front.len() >= 10, "{}", outcome.front.len());
    for candidate in outcome.front.iter().map(|number| &outcome.candidates[*number]) {
        assert!(candidate.is_feasible() && candidate.values[0] < 3.5, "{candidate:?}");
    }
}

#[test]
fn without_a_feasible_candidate_the_best_is_the_one_with_the_least_violation() {
    let problem = Problem { constraints: vec![upper(1, 1.0)], ..problem(&[(0.1, 10.0)]) };
    let outcome = searched(&problem, |values, _| vec![values[0], 2.0 + (values[0] / 3.0).ln().powi(2)]);
    let best = &outcome.candidates[outcome.best];
    assert!(!best.is_feasible() && !problem.constraints[0].holds(&best.rows));
    assert_near(&best.values, &[3.0], 0.02);
}

#[test]
fn a_figure_that_is_not_known_for_one_plant_makes_a_candidate_infeasible() {
    let problem = problem(&[(0.1, 10.0)]);
    let outcome =
        searched(&problem, |values, plant| vec![if values[0] < 2.0 && plant > 0.0 { f64::NAN } else { values[0] }]);
    let best = &outcome.candidates[outcome.best];
    assert!(best.is_feasible());
    assert_near(&best.values, &[2.0], 0.02);
    assert!(outcome.candidates.iter().any(|candidate| candidate.objective.is_none() && !candidate.is_feasible()));
}

#[test]
fn what_is_tried_does_not_depend_on_anything_but_the_problem() {
    let problem = Problem { front: Some(1), ..problem(&[(0.1, 10.0), (0.1, 10.0), (1.0, 2.0)]) };
    let figures = |values: &[f64], plant: f64| vec![values[0] + plant / values[1], values[2] / values[0]];
    assert_eq!(searched(&problem, figures), searched(&problem, figures));
    let other = Problem { seed: 1, ..problem.clone() };
    assert_ne!(searched(&problem, figures).candidates[1].values, searched(&other, figures).candidates[1].values);
}

#[test]
fn a_search_that_is_ended_gives_what_is_known() {
    let problem = problem(&[(0.1, 10.0)]);
    let mut batches = 0;
    let evaluate = |batch: &[Vec<f64>]| {
        batches += 1;
        Ok((batches < 3).then(|| batch.iter().map(|values| vec![row(&[values[0]])]).collect()))
    };
    let mut seen = Vec::new();
    let outcome = search(&problem, Some(&[5.0]), evaluate, |count, best| seen.push((count, best.objective))).unwrap();
    assert_eq!(outcome.candidates[0].values, [5.0], "the present settings come first");
    assert_eq!((seen.len(), seen[1].0), (2, outcome.candidates.len()));
    let none = search(&problem, None, |_| Ok(None), |_, _| {}).unwrap_err();
    assert_eq!(none.to_string(), "the search ended before any candidate was evaluated");
}

#[test]
fn values_are_what_the_block_can_hold_and_each_is_tried_once() {
    let mut problem = problem(&[(0.1, 10.0), (0.5, 20.0), (1.0, 6.0)]);
    problem.search[1].grid = Grid::Milliseconds;
    problem.search[2].grid = Grid::Whole;
    let outcome = searched(&problem, |values, _| vec![values.iter().sum()]);
    let digits = |value: f64| format!("{value:.4e}").parse::<f64>().unwrap();
    for (number, candidate) in outcome.candidates.iter().enumerate() {
        let values = &candidate.values;
        assert_eq!(values[0], digits(values[0]));
        assert_eq!(values[1], (values[1] * 1000.0).round() / 1000.0);
        assert_eq!(values[2], values[2].round());
        assert!(outcome.candidates[..number].iter().all(|other| other.values != *values));
    }
    assert_near(&outcome.candidates[outcome.best].values, &[0.1, 0.5, 1.0], 0.01);
}

#[test]
fn figures_are_taken_over_the_plants_as_asked_for() {
    let values: Vec<f64> = (1..=20).map(f64::from).collect();
    assert_eq!(
        [Over::Worst, Over::Mean, Over::P95].map(|over| over.combine(&values)),
        [Some(20.0), Some(10.5), Some(19.05)]
    );
    assert_eq!(Over::Mean.combine(&[1.0, f64::NAN]), None);
}

#[test]
fn a_table_that_cannot_be_searched_is_refused_with_what_is_possible() {
    let tune = |text: &str| toml::from_str::<Tune>(text);
    let error = |text: &str| tune(text).unwrap().check().unwrap_err().to_string();
    let search = "[[search]]\nvariable = \"C.GAIN\"\nmin = 1.0\nmax = 5.0\n";
    assert!(tune(&format!("minimize = \"iae\"\n{search}")).unwrap().check().is_ok());
    assert_eq!(
        error(&format!("minimize = \"iae\"\n{search}{search}")),
        "C.GAIN is searched twice: remove one of the [[tune.search]] tables"
    );
    assert_eq!(
        error(&format!("minimize = \"iae\"\n{}", search.replace("5.0", "0.5"))),
        "C.GAIN is searched from 1 to 0.5: min must be below max"
    );
    assert_eq!(
        error(&format!("minimize = \"iae\"\nevaluations = 5\n{search}")),
        "evaluations = 5: it must be between 10 and 100000"
    );
    assert_eq!(
        error(&format!("minimize = \"iae\"\nfront = \"iae\"\n{search}")),
        "front and minimize are both iae: a front needs two figures"
    );
    assert!(error("minimize = \"iae\"\nsearch = []").contains("[[tune.search]]"));
}

#[test]
fn a_constraint_is_of_each_plant_or_of_all_together() {
    let rows = [8.0, 9.0, 13.0].map(|value| row(&[value]));
    let of = |of: Of, comparison: Comparison| {
        let constraint = Constraint(Expectation { text: String::new(), figure: 0, of, comparison, bound: 10.0 });
        (constraint.value(&rows), constraint.holds(&rows), constraint.violation(&rows))
    };
    // Only the last plant satisfies the bound, with a margin of 0.3.
    assert_eq!(of(Of::Each, Comparison::AtMost), (13.0, false, 0.3 / 1.3 / 3.0));
    assert_eq!(of(Of::Each, Comparison::AtLeast), (8.0, false, (0.2 / 1.2 + 0.1 / 1.1) / 3.0));
    assert_eq!(of(Of::Percentile(50.0), Comparison::Less), (9.0, true, 0.0));
    assert!(!of(Of::Mean, Comparison::Less).1, "the mean is the bound itself");
    assert_eq!(of(Of::Mean, Comparison::AtMost), (10.0, true, 0.0));
}

#[test]
fn a_run_that_failed_violates_a_constraint_as_much_as_can_be() {
    let rows = [row(&[8.0]), row(&[f64::NAN])];
    let constraint = upper(0, 10.0);
    assert!(constraint.value(&rows).is_nan() && !constraint.is_active(&rows));
    assert_eq!(constraint.violation(&rows), 0.5);
}
