//! A study makes runs of linked blocks side by side: each has the bits of a run alone.

#![allow(clippy::unwrap_used)]

use blocks::{Block, ContC};
use fmu::table::Guid;
use modeldescription::{Description, Interface, ModelDescription};
use plants::Heater;
use plcfmu::linked::find;
use run::system::{Exchange, Member, System, Value};
use study::experiment::{Detail, Executor, Gives};
use study::results::RunResult;
use study::{Along, Axis, Job, Study, worker};

fn description<B: Block>() -> Description {
    let interface = Interface::linked(B::TABLE.into(), Guid::<B>::TEXT).unwrap();
    ModelDescription::from_interface(&interface).unwrap().description()
}

/// A furnace with two events that are less than 16 s apart, and 25 values for its rise, one of which no REAL can hold.
fn job(exchange: Exchange) -> Job {
    let settings = ["C.MAN_ON=0", "C.GAIN=0.7", "C.TI=130", "C.SP_INT=60@40", "C.SP_INT=80@50", "H.CYCLE=1"];
    let system = System {
        members: ["C", "H"].map(|name| Member { name: name.into(), path: format!("{name}.fmu").into() }).into(),
        connections: ["C.LMN=H.POWER", "H.TEMP=C.PV_IN"].map(|text| text.parse().unwrap()).into(),
        settings: settings.map(|text| text.parse().unwrap()).into(),
        exchange,
        step: Some(1.0),
        stop: Some(200.0),
        ..System::default()
    };
    let mut rises: Vec<f64> = (20..44).map(|tens| 10.0 * f64::from(tens)).collect();
    rises.insert(4, 1e300);
    let along = Along::Values(rises.into_iter().map(Value::Number).collect());
    let axes = vec![Axis { variables: vec!["H.RISE".into()], along, ..Axis::default() }];
    Job { system, study: Study { axes, ..Study::default() } }
}

#[test]
fn runs_side_by_side_give_the_bits_of_runs_alone_and_one_that_fails_costs_itself_only() {
    let descriptions = [description::<ContC>(), description::<Heater>()];
    let linked = descriptions.each_ref().map(|description| find(description).unwrap());
    let bits = |figures: &[f64]| figures.iter().map(|figure| figure.to_bits()).collect::<Vec<_>>();
    for exchange in [Exchange::Sequential, Exchange::Parallel] {
        let experiment = worker::experiment(&job(exchange), &descriptions.each_ref(), Some(&linked[0].table)).unwrap();
        let points: Vec<_> = (0..experiment.count()).map(|run| experiment.point(run)).collect();
        let mut executor = Executor::new(experiment);
        let mut instantiate = |member: usize| (linked[member].instantiate)("F");
        let rows: Vec<RunResult> = points
            .chunks(worker::ABREAST)
            .flat_map(|points| executor.rows(points, Gives::Figures, &mut instantiate))
            .collect();
        for (point, row) in points.iter().zip(&rows) {
            match executor.recording(point, Detail::All, &mut instantiate, |_| Ok(())) {
                Ok(figures) => assert_eq!(bits(&figures.unwrap()), bits(&row.figures), "{point:?}"),
                Err(error) => assert_eq!(format!("{error:#}"), row.error.clone().unwrap()),
            }
        }
        let failed: Vec<_> = (0..rows.len()).filter(|run| rows[*run].error.is_some()).collect();
        assert_eq!(failed, [4]);
        assert!(rows[4].error.as_ref().unwrap().contains("PV_IN = "), "{:?}", rows[4].error);
        // The more the furnace rises, the less of the integral of the error there is.
        let integrals: Vec<f64> = rows.iter().map(|row| row.figures[3]).filter(|figure| figure.is_finite()).collect();
        assert!(integrals.len() == 24 && integrals.is_sorted_by(|one, next| one > next), "{integrals:?}");
    }
}
