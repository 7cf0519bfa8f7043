//! Plants for testing controllers: a furnace, a valve, a tank and others, each a [block](blocks::Block) in its own file
//! that simulates a process. [`dynamics`] contains their common building blocks; [`LOOPS`] lists ready-made loops that
//! use them.

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

        /// Calls `what` for every plant of this crate, as [`blocks::for_each_block`] does for blocks.
        pub fn for_each_plant(what: &mut impl blocks::EachBlock) {
            $(what.block::<$plant>();)*
        }

        const MODULES: &[&str] = &[$(stringify!($module)),*];

        $(impl PlantAt<{ place(stringify!($module)) }> for () {
            type Plant = $plant;
        })*
    };
}

// All plants of this crate, in the order in which the parameter tool shows them.
plants!(process::Process, heater::Heater, valve::Valve, thermo::Thermo, tank::Tank, drive::Drive, sensor::Sensor,);

/// Calls `what` for every plant of this crate that runs faster in lanes, as [`blocks::for_each_in_lanes`] does for
/// blocks.
pub fn for_each_in_lanes(what: &mut impl blocks::table::abreast::EachInLanes) {
    what.block::<Heater>();
    what.block::<Process>();
}

/// The plant at a [place]. The library of a plant's FMU derives the place from its package name, so that one source
/// file serves all plants.
pub type Plant<const PLACE: usize> = <() as PlantAt<PLACE>>::Plant;

/// Maps a place to its plant.
pub trait PlantAt<const PLACE: usize> {
    /// The plant at this place.
    type Plant: blocks::Block;
}

/// Returns the position in `plants!` of the plant in this module, for example `heater`.
///
/// # Panics
/// No plant has this name. In a constant, this is a compile-time error.
#[must_use]
pub const fn place(module: &str) -> usize {
    let mut place = 0;
    while place < MODULES.len() {
        if is_equal(MODULES[place].as_bytes(), module.as_bytes()) {
            return place;
        }
        place += 1;
    }
    panic!(
        "no plant in plants/src/lib.rs has this name: name the package after the plant's file, and add the plant to `plants!`"
    )
}

/// Compares slices for equality; `==` is unavailable in constants.
const fn is_equal(mut one: &[u8], mut other: &[u8]) -> bool {
    while let ([first, rest @ ..], [second, others @ ..]) = (one, other) {
        if *first != *second {
            return false;
        }
        (one, other) = (rest, others);
    }
    one.is_empty() && other.is_empty()
}

macro_rules! loops {
    ($($name:literal),* $(,)?) => {
        /// Working example loops as `plcfmu run` reads them: the name of each file in `plants/loops`, and its text,
        /// whose first line states what the loop demonstrates.
        pub const LOOPS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../loops/", $name)))),*];
    };
}

// All files of `plants/loops`.
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
    use blocks::{Block, EachBlock};

    #[test]
    fn a_plant_is_at_the_place_of_its_file() {
        struct Names(Vec<&'static str>);
        impl EachBlock for Names {
            fn block<B: Block>(&mut self) {
                self.0.push(B::TABLE.name);
            }
        }
        let mut names = Names(Vec::new());
        for_each_plant(&mut names);
        // A package cannot find a plant in a file with a different name.
        assert_eq!(MODULES.iter().map(|module| module.to_uppercase()).collect::<Vec<_>>(), names.0);
        assert_eq!(Plant::<{ place("tank") }>::TABLE.name, "TANK");
        let refused = |name: &'static str| std::panic::catch_unwind(|| place(name)).is_err();
        assert!(refused("tan") && refused("tanks") && refused("TANK") && refused(""));
    }

    #[test]
    fn every_file_of_loops_is_in_the_list() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/loops");
        let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, LOOPS.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}
