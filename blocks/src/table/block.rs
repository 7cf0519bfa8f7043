//! The macro that defines a block from its table.

/// Defines a block from its table: the struct, its start values, the table as data, and access by row number.
///
/// ```text
/// block! {
///     /// What it does. The law. Clauses. Sources.
///     pub struct Name as "NAME" | "FB 1" {
///         input | parameter | fixed | cycle | output | local {
///             /// Short text, on one line
///             ///
///             /// Help: what it acts on, what happens at the edges, how to choose it.
///             name: Real | LReal | Time | Word | Int | Bool = start, from p q, min a, max b, unit "u";
///         }
///     }
///     mean { /// Short text
///            q_mean; }
///     instances { /// Short text
///                 di_name: Name { wired: a b; start: c = Bool(true); } }
///     memory Memory { /// Text
///                     name: Type; }
/// }
/// ```
///
/// Long documentation is kept in a separate file: `#[doc = include_str!("page.md")]` below the first sentence.
///
/// `NAME` may be followed by alternative names of the block in a PLC project, each after a `|`. Sections of variables
/// may be repeated, in any order, so that the rows can keep the order of an instance data block; start, `from`, `min`,
/// `max` and `unit` are optional. `from` names the block's own settings on which the value of an output after a restart
/// depends; if it is omitted, that value is constant. A table has exactly one `cycle` row. `mean`, `instances` and
/// `memory` are optional. In an instance, `wired` names the terminals that the law connects, which become locals;
/// settings and unconnected inputs become tunable parameters, and outputs become locals.
#[macro_export]
macro_rules! block {
    (
        $(#[doc = $docs:expr])*
        pub struct $Block:ident as $NAME:literal $(| $alias:literal)* {
            $( $section:ident {
                $(
                    $(#[doc = $doc:literal])*
                    $name:ident: $kind:ident $(= $start:expr)? $(, from $($from:ident)+)? $(, min $min:expr)? $(, max $max:expr)? $(, unit $unit:literal)?;
                )*
            } )*
        }
        $( mean {
            $(#[doc = $mean_doc:literal])*
            $mean:ident;
        } )?
        $( instances { $(
            $(#[doc = $instance_doc:literal])*
            $instance:ident: $Instance:ty {
                wired: $($wired:ident)*;
                $( start: $($started:ident = $started_kind:ident($started_value:expr)),+; )?
            }
        )* } )?
        $( memory $Memory:ident { $(
            $(#[doc = $memory_doc:literal])*
            $memory:ident: $memory_type:ty;
        )* } )?
    ) => {
        $(#[doc = $docs])*
        #[derive(Clone, Debug)]
        // A test may define a block in a private module.
        #[allow(unreachable_pub)]
        pub struct $Block {
            $($(
                $(#[doc = $doc])*
                pub $name: $crate::$kind,
            )*)*
            $($(
                $(#[doc = $instance_doc])*
                pub $instance: $Instance,
            )*)?
            $(
                $(#[doc = $mean_doc])*
                pub $mean: $crate::LReal,
            )?
            $(
                /// The block's memory between calls.
                pub memory: $Memory,
            )?
        }

        $(
            #[doc = concat!("The values that `", $NAME, "` keeps between calls.")]
            #[derive(Clone, Debug, Default)]
            #[allow(unreachable_pub)]
            pub struct $Memory { $(
                $(#[doc = $memory_doc])*
                pub $memory: $memory_type,
            )* }
        )?

        impl Default for $Block {
            fn default() -> Self {
                #[allow(unused_imports)]
                use $crate::{Time, Word};
                $Block {
                    $($( $name: $crate::block!(@start $kind $($start)?), )*)*
                    $($(
                        $instance: {
                            #[allow(unused_mut)]
                            let mut instance = <$Instance>::default();
                            $($( instance.$started = $started_value; )+)?
                            instance
                        },
                    )*)?
                    $( $mean: 0.0, )?
                    $( memory: $Memory::default(), )?
                }
            }
        }

        impl $Block {
            /// Sets the block's own outputs, locals and memory to 0 or FALSE, but not those of the inner blocks.
            #[inline(always)]
            #[allow(unreachable_pub)]
            pub fn clear(&mut self) {
                $($( $crate::block!(@clear $section self.$name); )*)*
                $( self.$mean = 0.0; )?
                $( self.memory = $Memory::default(); )?
            }
        }

        $( $crate::lane!($Memory where [$($memory_type),*] { $($memory: $memory_type,)* }); )?
        $crate::lane!($Block where [$($Memory,)? $($($Instance,)*)?] {
            $($([$section] $name: $crate::$kind,)*)*
            $($( $instance: $Instance, )*)?
            $([output] $mean: $crate::LReal,)?
            $(memory: $Memory,)?
        });

        const _: () = {
            #[allow(unused_imports)]
            use $crate::{Time, Word};
            use $crate::table::abreast::{InLanes, ReadLanes, WriteLanes};
            use $crate::table::{Block, Kind, Law, Role, StaticRow, StaticTable, Value, number};

            const OWN: &[StaticRow] = &[ $($( StaticRow {
                name: $crate::block!(@upper $name),
                description: $crate::table::short_text(concat!($($doc, "\n"),*)),
                help: $crate::table::help(concat!($($doc, "\n"),*)),
                kind: Kind::$kind,
                is_analog: matches!(Kind::$kind, Kind::Word),
                role: $crate::block!(@role $section),
                start: $crate::block!(@value $kind $($start)?),
                min: $crate::block!(@limit $kind $($min)?),
                max: $crate::block!(@limit $kind $($max)?),
                unit: $crate::block!(@unit $($unit)?),
                from: &[$($( At::$from ),+)?],
            }, )*)* ];

            const MEAN: &[StaticRow] = &[ $( StaticRow {
                name: $crate::block!(@upper $mean),
                description: $crate::table::short_text(concat!($($mean_doc, "\n"),*)),
                help: $crate::table::help(concat!($($mean_doc, "\n"),*)),
                kind: Kind::LReal,
                role: Role::Output,
                start: Value::LReal(0.0),
                ..StaticRow::EMPTY
            }, )? ];

            const INSTANCES: &[&StaticTable] = &[ $($( <$Instance as Block>::TABLE, )*)? ];

            const COUNT: usize = OWN.len() + $crate::table::inner_rows(INSTANCES) + MEAN.len();

            #[allow(unused_assignments, unused_mut)]
            const ROWS: [StaticRow; COUNT] = {
                let mut rows = [StaticRow::EMPTY; COUNT];
                let mut next = $crate::table::copy(OWN, &mut rows, 0);
                $($(
                    next = {
                        const INNER: &StaticTable = <$Instance as Block>::TABLE;
                        const NAMES: [u8; $crate::table::length(stringify!($instance), INNER)] =
                            $crate::table::inner_names($crate::block!(@upper $instance), INNER);
                        $crate::table::nest(
                            $crate::block!(@upper $instance),
                            $crate::table::text(&NAMES),
                            INNER,
                            &[$( stringify!($wired) ),*],
                            &[$($( (stringify!($started), Value::$started_kind($started_value)) ),+)?],
                            &mut rows,
                            next,
                        )
                    };
                )*)?
                $crate::table::copy(MEAN, &mut rows, next);
                $crate::table::check_restart_values(&rows);
                rows
            };

            const CYCLE: usize = $crate::table::cycle_row(&ROWS);

            /// The field names as an enum, whose values are the row numbers.
            #[allow(non_camel_case_types)]
            enum Number { $($( $name, )*)* }
            struct At;
            #[allow(non_upper_case_globals)]
            impl At { $($( const $name: usize = Number::$name as usize; )*)* }

            const DOCS: &str = {
                const ALL: &str = concat!($($docs, "\n"),*);
                const LENGTH: usize = $crate::table::docs::length(ALL, $crate::table::docs::IS_SHORT);
                const KEPT: [u8; LENGTH] = $crate::table::docs::kept(ALL);
                match ::std::str::from_utf8(&KEPT) {
                    Ok(docs) => docs,
                    Err(_) => ALL,
                }
            };

            impl Block for $Block {
                // The code hash of the crate being compiled.
                const CODE: Option<&'static str> = option_env!("PLCFMU_CODE");

                const TABLE: &'static StaticTable = &StaticTable {
                    name: $NAME,
                    aliases: &[$($alias),*],
                    docs: DOCS,
                    rows: &ROWS,
                    texts: &[],
                    tunable_reals: &$crate::table::tunable(&ROWS, Kind::Real),
                    tunable_lreals: &$crate::table::tunable(&ROWS, Kind::LReal),
                    cycle: CYCLE,
                    mean: if MEAN.is_empty() { None } else { Some(COUNT - 1) },
                    memory: &[ $($( (stringify!($memory), stringify!($memory_type)), )*)? ],
                    instances: INSTANCES,
                    responses: <$Block as Law>::RESPONSES,
                    characteristics: <$Block as Law>::CHARACTERISTICS,
                    drawn_unit: <$Block as Law>::DRAWN_UNIT,
                };

                #[inline]
                fn cycle(&self) -> $crate::Time {
                    match self.get(CYCLE) {
                        Some(Value::Time(cycle)) => cycle,
                        _ => $crate::Time::ZERO,
                    }
                }

                #[inline]
                #[allow(unused_assignments)]
                fn get(&self, index: usize) -> Option<Value> {
                    match index {
                        $($( At::$name => Some(Value::$kind(self.$name)), )*)*
                        _ => {
                            #[allow(unused_mut, unused_variables)]
                            let mut index = index - OWN.len();
                            $($(
                                let rows = <$Instance as Block>::TABLE.inner();
                                if index < rows {
                                    return self.$instance.get(index);
                                }
                                index -= rows;
                            )*)?
                            $( if index == 0 {
                                return Some(Value::LReal(self.$mean));
                            } )?
                            None
                        }
                    }
                }

                #[inline(always)]
                #[allow(unused_assignments)]
                fn set(&mut self, index: usize, value: Value) -> bool {
                    match (index, value) {
                        $($( (At::$name, Value::$kind(value)) => self.$name = value, )*)*
                        _ => {
                            if index < OWN.len() {
                                return false;
                            }
                            #[allow(unused_mut, unused_variables)]
                            let mut index = index - OWN.len();
                            $($(
                                let rows = <$Instance as Block>::TABLE.inner();
                                if index < rows {
                                    return self.$instance.set(index, value);
                                }
                                index -= rows;
                            )*)?
                            $( if let (0, Value::LReal(value)) = (index, value) {
                                self.$mean = value;
                                return true;
                            } )?
                            return false;
                        }
                    }
                    true
                }

                $crate::block!(@number self.real(&self) -> $crate::Real;
                    [$($($name $kind)*)*] [$($($instance $Instance)*)?] [$($mean)?]);
                $crate::block!(@number self.real_mut(&mut self) -> &mut $crate::Real;
                    [$($($name $kind)*)*] [$($($instance $Instance)*)?] [$($mean)?]);
                $crate::block!(@number self.lreal(&self) -> $crate::LReal;
                    [$($($name $kind)*)*] [$($($instance $Instance)*)?] [$($mean)?]);
                $crate::block!(@number self.lreal_mut(&mut self) -> &mut $crate::LReal;
                    [$($($name $kind)*)*] [$($($instance $Instance)*)?] [$($mean)?]);

                #[inline]
                fn set_mean(&mut self, percent: $crate::LReal) {
                    let _ = percent;
                    $( self.$mean = percent; )?
                }
            }

            impl InLanes for $Block
            where
                $( for<'always> $Memory: $crate::table::abreast::Lane, )?
                $($( for<'always> $Instance: $crate::table::abreast::Lane, )*)?
            {
                fn reader(index: usize) -> Option<ReadLanes<Self>> {
                    match index {
                        $($( At::$name => Some(|blocks, numbers| {
                            blocks.read(numbers, |of| &of.$name, |value: $crate::$kind| number::number(Value::$kind(value)));
                        }), )*)*
                        $( index if index == COUNT - 1 => Some(|blocks, numbers| {
                            blocks.read(numbers, |of| &of.$mean, |value: $crate::LReal| value);
                        }), )?
                        _ => None,
                    }
                }

                fn writer(index: usize) -> Option<WriteLanes<Self>> {
                    match index {
                        $($( At::$name => Some(|blocks, numbers| {
                            blocks.write(numbers, |of| &mut of.$name, |number| match number::to_value(number, Kind::$kind) {
                                Ok(Value::$kind(value)) => Some(value),
                                _ => None,
                            })
                        }), )*)*
                        _ => None,
                    }
                }
            }

            impl $crate::Stored for $Block {
                fn write(&self, bytes: &mut Vec<u8>) {
                    $($( self.$name.write(bytes); )*)*
                    $($( self.$instance.write(bytes); )*)?
                    $( self.$mean.write(bytes); )?
                    $($( self.memory.$memory.write(bytes); )*)?
                }

                fn read(bytes: &mut &[u8]) -> Option<Self> {
                    // The fields are in the order of `write`: struct fields are evaluated in the order in which they
                    // are written.
                    Some($Block {
                        $($( $name: $crate::Stored::read(bytes)?, )*)*
                        $($( $instance: $crate::Stored::read(bytes)?, )*)?
                        $( $mean: $crate::Stored::read(bytes)?, )?
                        $( memory: $Memory { $( $memory: $crate::Stored::read(bytes)?, )* }, )?
                    })
                }
            }
        };
    };

    (@start $kind:ident) => { <$crate::$kind>::default() };
    (@start $kind:ident $start:expr) => { $start };
    (@value $kind:ident) => { Value::zero(Kind::$kind) };
    (@value $kind:ident $start:expr) => { Value::$kind($start) };
    (@limit $kind:ident) => { None };
    (@limit $kind:ident $limit:expr) => { Some(Value::$kind($limit)) };
    (@unit) => { None };
    (@unit $unit:literal) => { Some($unit) };
    (@role input) => { Role::Input };
    (@role parameter) => { Role::Parameter };
    (@role fixed) => { Role::Fixed };
    (@role cycle) => { Role::Cycle };
    (@role output) => { Role::Output };
    (@role local) => { Role::Local };
    (@role $other:ident) => {
        compile_error!(concat!(
            "unknown section `", stringify!($other), "`: use input, parameter, fixed, cycle, output or local"
        ))
    };
    // Generates one of the four functions that access the numbers of one type, in the block's own rows and those of
    // inner blocks.
    (
        @number $this:ident.$function:ident($($receiver:tt)+) -> $Number:ty;
        [$($name:ident $kind:ident)*] [$($instance:ident $Instance:ty)*] [$($mean:ident)?]
    ) => {
        #[inline(always)]
        #[allow(unused_assignments)]
        fn $function($($receiver)+, index: usize) -> Option<$Number> {
            match index {
                $( At::$name => $crate::block!(@$function $kind $this.$name), )*
                _ => {
                    #[allow(unused_mut, unused_variables)]
                    let mut index = index - OWN.len();
                    $(
                        let rows = <$Instance as Block>::TABLE.inner();
                        if index < rows {
                            return $this.$instance.$function(index);
                        }
                        index -= rows;
                    )*
                    $( if index == 0 {
                        return $crate::block!(@$function LReal $this.$mean);
                    } )?
                    None
                }
            }
        }
    };
    (@real Real $field:expr) => { Some($field) };
    (@real $other:ident $field:expr) => { None };
    (@real_mut Real $field:expr) => { Some(&mut $field) };
    (@real_mut $other:ident $field:expr) => { None };
    (@lreal LReal $field:expr) => { Some($field) };
    (@lreal $other:ident $field:expr) => { None };
    (@lreal_mut LReal $field:expr) => { Some(&mut $field) };
    (@lreal_mut $other:ident $field:expr) => { None };
    (@clear output $field:expr) => { $field = Default::default() };
    (@clear local $field:expr) => { $field = Default::default() };
    (@clear $other:ident $field:expr) => {};
    (@upper $name:ident) => { {
        const UPPER: [u8; stringify!($name).len()] = $crate::table::upper(stringify!($name));
        $crate::table::text(&UPPER)
    } };
}
