//! Plants to try controllers on: a furnace, a valve, a tank and others, each a [block](blocks::Block) that stands in for a
//! process, a file each. [`dynamics`] has what they are made of; [`LOOPS`] are the loops that they are known in.

pub mod dynamics;

mod drive;
mod heater;
mod process;
mod sensor;
mod tank;
mod thermo;
mod valve;

macro_rules! plants {
    ($($module:ident::$plant:ident),* $(,)?) => {
        $(pub use $module::$plant;)*

        /// Does something with every plant of this crate, as [`blocks::for_each_block`] does with blocks.
        pub fn for_each_plant(what: &mut impl blocks::EachBlock) {
            $(what.block::<$plant>();)*
        }
    };
}

// Every plant of this crate, in the order in which the parameter tool shows them.
plants!(process::Process, heater::Heater, valve::Valve, thermo::Thermo, tank::Tank, drive::Drive, sensor::Sensor,);

macro_rules! loops {
    ($($name:literal),* $(,)?) => {
        /// Loops that are known to work, each a description as `plcfmu run` reads it: the name of its file in `plants/loops`,
        /// and the text, whose first line says what the loop shows.
        pub const LOOPS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../loops/", $name)))),*];
    };
}

// Every file of `plants/loops`.
loops!(
    "chamber.toml",
    "chamber_mean.toml",
    "furnace.toml",
    "furnace_pulses.toml",
    "level.toml",
    "level_pulses.toml",
    "positioner.toml",
    "process.toml",
    "process_integrating.toml",
    "process_pulses.toml",
    "sensor.toml",
    "speed.toml",
    "valve.toml",
    "valve_mean.toml",
    "zone.toml",
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_loops_is_in_the_list() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/loops");
        let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, LOOPS.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}
