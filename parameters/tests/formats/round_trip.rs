//! Written files read back bit for bit, for all values of all types.

use super::*;
use blocks::table::number::number;
use proptest::prelude::*;

/// Any value of a type; for floating-point numbers, all finite bit patterns.
fn value(kind: Kind) -> BoxedStrategy<Value> {
    match kind {
        Kind::Bool => any::<bool>().prop_map(Value::Bool).boxed(),
        Kind::Real => any::<u32>()
            .prop_map(f32::from_bits)
            .prop_filter("finite", |real| real.is_finite())
            .prop_map(Value::Real)
            .boxed(),
        Kind::LReal => any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("finite", |real| real.is_finite())
            .prop_map(Value::LReal)
            .boxed(),
        Kind::Time => prop_oneof![any::<i32>(), Just(i32::MIN), Just(i32::MAX), -2..2]
            .prop_map(|time| Value::Time(Time::ms(time)))
            .boxed(),
        Kind::Word => any::<i16>().prop_map(|word| Value::Word(Word::new(word))).boxed(),
        Kind::Int => any::<i16>().prop_map(Value::Int).boxed(),
        _ => unreachable!("no block has such a type"),
    }
}

fn instance(name: &str, block: Arc<BlockType>) -> BoxedStrategy<Loop> {
    let name = name.to_string();
    let empty = Loop::new(name, block.clone());
    let kinds: Vec<_> = empty.settings.iter().map(|setting| value(block.members[setting.member].kind)).collect();
    kinds
        .prop_map(move |values| {
            let mut one = empty.clone();
            for (setting, value) in one.settings.iter_mut().zip(values) {
                setting.value = value;
            }
            one
        })
        .boxed()
}

#[track_caller]
fn check(format: Format, loops: &[Loop], options: &Options) {
    let text = parameters::write(format, loops, "a test").unwrap();
    let back = reading(format, &text, options).unwrap_or_else(|problems| panic!("{problems}")).loops;
    assert_eq!(back.len(), loops.len());
    for (one, back) in loops.iter().zip(&back) {
        assert_eq!((&one.name, &one.block.name), (&back.name, &back.block.name));
        for (was, is) in one.settings.iter().zip(&back.settings) {
            assert_eq!(was.value.kind(), is.value.kind());
            assert_eq!(number(was.value).to_bits(), number(is.value).to_bits(), "{format:?} {was:?} {is:?}");
            assert_ne!(is.origin, Origin::Default);
        }
    }
}

proptest! {
    #[test]
    fn two_loops_read_back_from_every_text(one in instance("TIC <101>", pump()), other in instance("DB2.B \"&\"", valve())) {
        let loops = [one, other];
        for format in [Format::Json, Format::Ssv, Format::Openness] {
            check(format, &loops, &Options::default());
            check(format, &loops[..1], &Options::default());
        }
    }

    #[test]
    fn a_loop_with_settings_of_inner_blocks_reads_back(one in instance("S", station())) {
        check(Format::Json, std::slice::from_ref(&one), &Options::default());
        check(Format::Ssv, &[one.clone(), Loop::new("T", station())], &Options::default());
    }

    /// The multi-instances of a station that is a block of the PLC project, not a built-in one.
    #[test]
    fn loops_called_as_an_instance_inside_a_block_read_back(one in instance("DI_PUMP", pump()), other in instance("L.DI_PUMP", valve())) {
        check(Format::Ssv, &[one, other], &Options::default());
    }

    #[test]
    fn a_dump_reads_back(one in instance("plant", pump()), bits in any::<u32>()) {
        let mut one = one;
        // Including NaN: a dump may contain any bit pattern.
        one.set(5, Value::Real(f32::from_bits(bits)), Origin::Default);
        let bytes = parameters::write(Format::Dump, std::slice::from_ref(&one), "").unwrap();
        let back = &reading(Format::Dump, &bytes, &of_block("PUMP")).unwrap().loops[0];
        let Some(Value::Real(real)) = back.get("GAIN") else { panic!() };
        prop_assert_eq!(real.to_bits(), bits);
        prop_assert_eq!(parameters::write(Format::Dump, std::slice::from_ref(back), "").unwrap(), bytes);
        if f32::from_bits(bits).is_finite() {
            check(Format::Dump, &[one], &of_block("PUMP"));
        }
    }
}

/// All exponents of a REAL with boundary mantissas, which have the longest decimals.
#[test]
fn a_real_of_every_exponent_reads_back_from_its_decimal() {
    for exponent in 0..255u32 {
        for mantissa in [0, 1, 2, 0x3F_FFFF, 0x40_0000, 0x55_5555, 0x7F_FFFE, 0x7F_FFFF] {
            for sign in [0, 1 << 31] {
                let real = f32::from_bits(sign | exponent << 23 | mantissa);
                let text = parameters::decimal(Value::Real(real));
                assert_eq!((text.parse::<f64>().unwrap() as f32).to_bits(), real.to_bits(), "{text}");
                assert_eq!(text.parse::<f32>().unwrap().to_bits(), real.to_bits(), "{text}");
            }
        }
    }
}
