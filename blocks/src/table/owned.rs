//! Converts a compiled table into one with owned strings.

use crate::table::{Characteristic, Response, Row, StaticRow, StaticTable, Table, Text};

fn texts(texts: &[&str]) -> Vec<String> {
    texts.iter().map(ToString::to_string).collect()
}

impl From<&StaticTable> for Table {
    fn from(of: &StaticTable) -> Table {
        Table {
            name: of.name.into(),
            aliases: texts(of.aliases),
            docs: of.docs.into(),
            rows: of.rows.iter().map(Row::from).collect(),
            texts: of.texts.iter().map(Text::from).collect(),
            tunable_reals: of.tunable_reals.to_vec(),
            tunable_lreals: of.tunable_lreals.to_vec(),
            cycle: of.cycle,
            mean: of.mean,
            memory: of.memory.iter().map(|(name, ty)| (name.to_string(), ty.to_string())).collect(),
            instances: of.instances,
            responses: of.responses.iter().map(Response::from).collect(),
            characteristics: of.characteristics.iter().map(Characteristic::from).collect(),
            drawn_unit: of.drawn_unit.map(str::to_string),
        }
    }
}

impl From<&StaticRow> for Row {
    fn from(of: &StaticRow) -> Row {
        Row {
            name: of.name.into(),
            description: of.description.into(),
            help: of.help.into(),
            kind: of.kind,
            is_analog: of.is_analog,
            role: of.role,
            start: of.start,
            min: of.min,
            max: of.max,
            unit: of.unit.map(str::to_string),
            from: of.from.to_vec(),
        }
    }
}

impl From<&Text<&'static str>> for Text {
    fn from(of: &Text<&'static str>) -> Text {
        Text {
            name: of.name.into(),
            description: of.description.into(),
            role: of.role,
            start: of.start.into(),
            ty: of.ty,
        }
    }
}

impl From<&Response> for Response<String> {
    fn from(of: &Response) -> Response<String> {
        let set = of.set.iter().map(|(call, name, value)| (*call, name.to_string(), *value)).collect();
        Response { title: of.title.into(), calls: of.calls, set, show: texts(of.show) }
    }
}

impl From<&Characteristic> for Characteristic<String> {
    fn from(of: &Characteristic) -> Characteristic<String> {
        Characteristic {
            title: of.title.into(),
            variable: of.variable.into(),
            range: of.range,
            points: of.points,
            calls: of.calls,
            set: of.set.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
            show: texts(of.show),
        }
    }
}
