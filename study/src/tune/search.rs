//! The search: a space-filling initial design; then the Nelder-Mead method from the best candidates, continued after a
//! while with only the best simplex; then, if a front is requested, the same method for the other end of the front, and
//! for bounds on the second figure between the ends.
//!
//! Several simplices work in parallel, each requesting one candidate at a time; these are evaluated together. A simplex
//! does not wait: it is replayed from its start, with all known candidates, up to the first unknown one. The search
//! therefore needs no threads, and the candidates it tries depend only on the problem and the figures.

use crate::Sampling;
use crate::results::RunResult;
use crate::sampling::Sampler;
use crate::tune::{Candidate, Problem, bounded};
use anyhow::{Result, anyhow, ensure};
use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use std::cell::{Cell, RefCell};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The number of candidates of the initial design evaluated together.
const BATCH: usize = 64;
/// The standard deviation of the costs at its vertices below which a simplex has converged; feasible costs are between
/// -1 and 1.
const TOLERANCE: f64 = 1e-5;
/// The maximum number of iterations of a simplex.
const ITERATIONS: u64 = 300;
/// The initial edge of a simplex, as a share of each variable's range.
const EDGE: f64 = 0.1;
/// The maximum number of simplices that start the search for the best settings.
const STARTS: usize = 3;
/// The maximum number of times that new, smaller simplices are started from the best settings so far.
const RESTARTS: usize = 3;
/// The number of bounds on the second figure, for each of which a simplex searches for a point of the front.
const LEVELS: usize = 14;

/// The outcome of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// All candidates tried, in order.
    pub candidates: Vec<Candidate>,
    /// The best candidate by Deb's rule; it is feasible if any is.
    pub best: usize,
    /// The Pareto-optimal candidates, ordered by the first figure; empty if there is only one figure.
    pub front: Vec<usize>,
}

/// Searches for the best settings. `evaluate` returns, for each candidate of a batch, a row for each plant, or `None`
/// to end the search with the results so far. `progress` receives the number of evaluated candidates and the best one
/// after each batch.
///
/// `first` are the settings to try first, the loop's current ones; ignored if they are outside the ranges.
///
/// # Errors
/// `evaluate` fails, or it ends the search before any candidate is known.
pub fn search(
    problem: &Problem,
    first: Option<&[f64]>,
    evaluate: impl FnMut(&[Vec<f64>]) -> Result<Option<Vec<Vec<RunResult>>>>,
    progress: impl FnMut(usize, &Candidate),
) -> Result<Outcome> {
    let mut archive = Archive {
        problem,
        candidates: Vec::new(),
        known: BTreeMap::new(),
        scales: (1.0, 1.0),
        has_ended: false,
        evaluate,
        progress,
    };
    archive.explore(first)?;
    ensure!(!archive.candidates.is_empty(), "the search ended before any candidate was evaluated");
    if problem.front.is_none() {
        archive.descend(problem.evaluations)?;
    } else {
        archive.descend(problem.evaluations * 5 / 10)?;
        archive.descend_to_end(problem.evaluations * 6 / 10)?;
        archive.fill_front()?;
    }
    let best = archive.best(&Aim::Objective, &[]);
    let front = front(&archive.candidates);
    Ok(Outcome { candidates: archive.candidates, best, front })
}

/// The aim of a simplex.
#[derive(Clone, Debug, PartialEq)]
enum Aim {
    /// The lowest objective.
    Objective,
    /// The lowest second figure.
    Second,
    /// The lowest objective with a second figure not exceeding this bound.
    Within(f64),
}

/// A run of the Nelder-Mead method.
#[derive(Clone, Debug, PartialEq)]
struct Simplex {
    aim: Aim,
    /// Its initial vertices, with coordinates from 0 to 1.
    vertices: Vec<Vec<f64>>,
}

impl Simplex {
    /// A simplex of one vertex and a neighbour along each axis, towards the middle.
    fn at(place: Vec<f64>, edge: f64, aim: Aim) -> Simplex {
        let beside = |axis: usize| {
            let mut vertex = place.clone();
            vertex[axis] += if vertex[axis] > 0.5 { -edge } else { edge };
            vertex
        };
        let vertices = std::iter::once(place.clone()).chain((0..place.len()).map(beside)).collect();
        Simplex { aim, vertices }
    }
}

/// All known candidates, and the means to evaluate others.
struct Archive<'a, E, P> {
    problem: &'a Problem,
    candidates: Vec<Candidate>,
    /// The index of each candidate, by the bits of its values.
    known: BTreeMap<Vec<u64>, usize>,
    /// The scales of the objective and of the second figure, as in [`Archive::cost`]: the median magnitude in the
    /// initial design.
    scales: (f64, f64),
    /// Whether `evaluate` has ended the search.
    has_ended: bool,
    evaluate: E,
    progress: P,
}

fn key(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

impl<E, P> Archive<'_, E, P>
where
    E: FnMut(&[Vec<f64>]) -> Result<Option<Vec<Vec<RunResult>>>>,
    P: FnMut(usize, &Candidate),
{
    /// The values at a position with coordinates from 0 to 1.
    fn values(&self, place: &[f64]) -> Vec<f64> {
        self.problem.search.iter().zip(place).map(|(search, place)| search.value(*place)).collect()
    }

    fn place(&self, candidate: usize) -> Vec<f64> {
        let values = &self.candidates[candidate].values;
        self.problem.search.iter().zip(values).map(|(search, value)| search.place(*value)).collect()
    }

    fn find(&self, place: &[f64]) -> Option<&Candidate> {
        self.known.get(&key(&self.values(place))).map(|number| &self.candidates[*number])
    }

    /// Evaluates the `wanted` candidates that are not yet known, up to a total of `limit` known candidates.
    fn add(&mut self, wanted: Vec<Vec<f64>>, limit: usize) -> Result<()> {
        let mut batch: Vec<Vec<f64>> = Vec::new();
        for values in wanted {
            let is_new = !self.known.contains_key(&key(&values)) && !batch.contains(&values);
            if is_new && self.candidates.len() + batch.len() < limit {
                batch.push(values);
            }
        }
        if batch.is_empty() || self.has_ended {
            return Ok(());
        }
        let Some(rows) = (self.evaluate)(&batch)? else {
            self.has_ended = true;
            return Ok(());
        };
        ensure!(rows.len() == batch.len(), "{} candidates were evaluated instead of {}", rows.len(), batch.len());
        for (values, rows) in batch.into_iter().zip(rows) {
            self.known.insert(key(&values), self.candidates.len());
            self.candidates.push(Candidate::new(self.problem, values, rows));
        }
        let best = self.best(&Aim::Objective, &[]);
        (self.progress)(self.candidates.len(), &self.candidates[best]);
        Ok(())
    }

    /// Evaluates the initial design.
    fn explore(&mut self, first: Option<&[f64]>) -> Result<()> {
        let (axes, limit) = (self.problem.search.len(), self.problem.evaluations);
        let count = (limit / 6).max(4 * axes + 1).min(limit / 2);
        let is_within = |values: &&[f64]| {
            self.problem.search.iter().zip(*values).all(|(search, value)| (search.min..=search.max).contains(value))
        };
        let mut wanted: Vec<Vec<f64>> = first.filter(is_within).map(<[f64]>::to_vec).into_iter().collect();
        wanted.extend(design(count, axes, self.problem.seed).iter().map(|place| self.values(place)));
        for batch in wanted.chunks(BATCH) {
            self.add(batch.to_vec(), limit)?;
        }
        let middle = |figure: fn(&Candidate) -> Option<f64>| {
            let mut known: Vec<f64> = self.candidates.iter().filter_map(figure).map(f64::abs).collect();
            known.sort_by(f64::total_cmp);
            known.get(known.len() / 2).copied().filter(|middle| *middle > 0.0).unwrap_or(1.0)
        };
        self.scales = (middle(|of| of.objective), middle(|of| of.second));
        Ok(())
    }

    /// Searches for the lowest objective until `limit` candidates are known.
    fn descend(&mut self, limit: usize) -> Result<()> {
        let mut starts: Vec<Vec<f64>> = Vec::new();
        let mut taken = Vec::new();
        while starts.len() < STARTS && taken.len() < self.candidates.len() {
            let next = self.best(&Aim::Objective, &taken);
            taken.push(next);
            let place = self.place(next);
            let is_far = |other: &Vec<f64>| place.iter().zip(other).any(|(a, b)| (a - b).abs() > 2.0 * EDGE);
            if starts.iter().all(is_far) {
                starts.push(place);
            }
        }
        let mut simplices: Vec<Simplex> =
            starts.into_iter().map(|place| Simplex::at(place, EDGE, Aim::Objective)).collect();
        // After a third of the remaining evaluations, only the best simplex continues.
        let known = self.candidates.len();
        self.polish(&simplices, known + limit.saturating_sub(known) / 3)?;
        let costs = simplices.iter().map(|simplex| Ok(self.replay(simplex)?.1)).collect::<Result<Vec<f64>>>()?;
        let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
        self.polish(&simplices.split_off(best)[..1], limit)?;
        let mut edge = EDGE;
        for _ in 0..RESTARTS {
            edge /= 2.0;
            let best = self.best(&Aim::Objective, &[]);
            self.polish(&[Simplex::at(self.place(best), edge, Aim::Objective)], limit)?;
            if self.best(&Aim::Objective, &[]) == best {
                break;
            }
        }
        Ok(())
    }

    /// Searches for the end of the front with the lowest second figure, until `limit` candidates are known.
    fn descend_to_end(&mut self, limit: usize) -> Result<()> {
        let end = self.best(&Aim::Second, &[]);
        self.polish(&[Simplex::at(self.place(end), EDGE, Aim::Second)], limit)
    }

    /// Fills the front between its ends, using bounds on the second figure.
    fn fill_front(&mut self) -> Result<()> {
        let ends = [Aim::Objective, Aim::Second].map(|aim| &self.candidates[self.best(&aim, &[])]);
        let [(Some(high), true), (Some(low), true)] = ends.map(|end| (end.second, end.is_feasible())) else {
            return Ok(());
        };
        if low >= high {
            return Ok(());
        }
        let mut edge = EDGE / 2.0;
        for _ in 0..RESTARTS {
            let simplex = |level: usize| {
                let aim = Aim::Within(low + (high - low) * level as f64 / (LEVELS + 1) as f64);
                Simplex::at(self.place(self.best(&aim, &[])), edge, aim)
            };
            let simplices: Vec<Simplex> = (1..=LEVELS).map(simplex).collect();
            self.polish(&simplices, self.problem.evaluations)?;
            edge /= 2.0;
        }
        Ok(())
    }

    /// Advances simplices until they have converged or `limit` candidates are known.
    fn polish(&mut self, simplices: &[Simplex], limit: usize) -> Result<()> {
        loop {
            let mut wanted = Vec::new();
            for simplex in simplices {
                wanted.extend(self.replay(simplex)?.0.iter().map(|place| self.values(place)));
            }
            if wanted.is_empty() || self.candidates.len() >= limit || self.has_ended {
                return Ok(());
            }
            self.add(wanted, limit)?;
        }
    }

    /// The positions that a simplex needs to continue, empty if it has converged, and its lowest cost so far.
    fn replay(&self, simplex: &Simplex) -> Result<(Vec<Vec<f64>>, f64)> {
        let unknown: Vec<Vec<f64>> =
            simplex.vertices.iter().filter(|place| self.find(place).is_none()).cloned().collect();
        if !unknown.is_empty() {
            return Ok((unknown, f64::INFINITY));
        }
        let (wanted, lowest) = (RefCell::new(Vec::new()), Cell::new(f64::INFINITY));
        let cost = |place: &Vec<f64>| match self.find(place) {
            Some(candidate) => {
                let cost = self.cost(&simplex.aim, candidate);
                lowest.set(lowest.get().min(cost));
                Ok(cost)
            }
            None => {
                wanted.borrow_mut().push(place.clone());
                Err(anyhow!("the candidate is not known yet"))
            }
        };
        let solver = NelderMead::new(simplex.vertices.clone()).with_sd_tolerance(TOLERANCE)?;
        let executor = Executor::new(Cost(&cost), solver).configure(|state| state.max_iters(ITERATIONS)).timer(false);
        match executor.run() {
            Err(error) if wanted.borrow().is_empty() => Err(error),
            _ => Ok((wanted.take(), lowest.get())),
        }
    }

    /// The cost to minimize: between -1 and 1 for feasible candidates, at least 1 for others.
    fn cost(&self, aim: &Aim, candidate: &Candidate) -> f64 {
        let (value, scale) = match aim {
            Aim::Second => (candidate.second, self.scales.1),
            _ => (candidate.objective, self.scales.0),
        };
        let mut violation = candidate.violation;
        if let (Aim::Within(bound), Some(second)) = (aim, candidate.second) {
            violation += bounded(((second - bound) / self.scales.1).max(0.0));
        }
        match value {
            Some(value) if violation == 0.0 => value / (value.abs() + scale),
            _ => 1.0 + violation,
        }
    }

    /// The index of the candidate with the lowest cost, except those in `but`; among equals, the first.
    fn best(&self, aim: &Aim, but: &[usize]) -> usize {
        let costs = self.candidates.iter().enumerate().filter(|(number, _)| !but.contains(number));
        let costs = costs.map(|(number, candidate)| (number, self.cost(aim, candidate)));
        costs.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(number, _)| number)
    }
}

/// A cost function for argmin.
struct Cost<F>(F);

impl<F: Fn(&Vec<f64>) -> Result<f64>> CostFunction for Cost<F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, place: &Vec<f64>) -> Result<f64> {
        self.0(place)
    }
}

/// `count` positions that evenly fill the unit cube with this many axes.
fn design(count: usize, axes: usize, seed: u64) -> Vec<Vec<f64>> {
    let sampler = Sampler::new(Sampling::Sobol, seed, count as u64, axes);
    (0..count as u64).map(|sample| (0..axes).map(|axis| sampler.probability(axis, sample)).collect()).collect()
}

/// The Pareto-optimal feasible candidates, ordered by the first figure.
fn front(candidates: &[Candidate]) -> Vec<usize> {
    let figures = |candidate: &Candidate| Some((candidate.objective?, candidate.second?));
    let mut feasible: Vec<(usize, (f64, f64))> = candidates
        .iter()
        .enumerate()
        .filter(|(_, candidate)| candidate.is_feasible())
        .filter_map(|(number, candidate)| Some((number, figures(candidate)?)))
        .collect();
    let order = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    feasible.sort_by(|(a, of), (b, other)| match order(of, other) {
        Ordering::Equal => a.cmp(b),
        unequal => unequal,
    });
    let mut lowest = f64::INFINITY;
    feasible.retain(|(_, (_, second))| {
        let is_better = *second < lowest;
        lowest = lowest.min(*second);
        is_better
    });
    feasible.into_iter().map(|(number, _)| number).collect()
}
