//! Boxes for texts, memory blocks and times.

use super::{Sections, both, coil, of_type, tape};
use crate::xml::{From, Net, int, local, typed};

/// "LEN", "LEFT", "RIGHT", "MID", "CONCAT", "FIND", "DELETE", "INSERT", "REPLACE": ENO is FALSE if a text is truncated,
/// or if a position or a number of characters is outside the text.
#[test]
fn functions_of_texts() {
    let sections: Sections = &[
        ("Input", "n : Int"),
        ("Output", "len : Int; at : Int; same : Bool; ok : Bool; left : Bool; mid : Bool"),
        ("Static", "s : String[10] := 'abcdef'; t : String[8]; u : String[8]; v : String[20]"),
    ];
    let string = of_type("SrcType", "String");
    let text = |text: &str| From::Constant("String", format!("'{text}'"));
    let mut net = Net::new("");
    let mut boxed = |part: &str, pins: &[(&str, From)], output: &str, flow: Option<&str>| {
        let pins: Vec<(&str, From)> = [("en", From::Rail)].into_iter().chain(pins.iter().cloned()).collect();
        let uid = net.part(part, &string, &pins);
        net.write(uid, "OUT", local(output));
        if let Some(name) = flow {
            coil(&mut net, name, From::Pin(uid, "eno"));
        }
    };
    boxed("LEFT", &[("IN", local("s")), ("L", local("n"))], "t", Some("left"));
    boxed("MID", &[("IN", local("s")), ("L", int(2)), ("P", local("n"))], "u", Some("mid"));
    boxed("CONCAT", &[("IN1", local("t")), ("IN2", text("xyz")), ("IN3", local("u"))], "t", Some("ok"));
    boxed("LEN", &[("IN", local("t"))], "len", None);
    boxed("FIND", &[("IN1", local("t")), ("IN2", text("y"))], "at", None);
    boxed("REPLACE", &[("IN1", local("s")), ("IN2", text("-")), ("L", int(3)), ("P", int(2))], "v", None);
    boxed("DELETE", &[("IN", local("v")), ("L", int(1)), ("P", int(1))], "v", None);
    boxed("INSERT", &[("IN1", local("v")), ("IN2", text("Z")), ("P", int(3))], "v", None);
    let equal = net.part("Eq", &string, &[("pre", From::Rail), ("in1", local("v")), ("in2", text("-efZ"))]);
    coil(&mut net, "same", From::Pin(equal, "out"));
    let with_eno = "{ S7_GenerateENO := \"TRUE\" }";
    let rungs = format!(
        "RUNG wire#powerrail {with_eno} LEFT( in := #s, l := #n, out => #t ) Coil( #left ) END_RUNG
         RUNG wire#powerrail {with_eno} MID( in := #s, l := 2, p := #n, out => #u ) Coil( #mid ) END_RUNG
         RUNG wire#powerrail {with_eno} CONCAT( in1 := #t, in2 := 'xyz', in3 := #u, out => #t ) Coil( #ok ) END_RUNG
         RUNG wire#powerrail LEN( in := #t, out => #len ) FIND( in1 := #t, in2 := 'y', out => #at ) END_RUNG
         RUNG wire#powerrail REPLACE( in1 := #s, in2 := '-', l := 3, p := 2, out => #v ) DELETE( in := #v, l := 1, p := 1, out => #v )
         INSERT( in1 := #v, in2 := 'Z', p := 3, out => #v ) END_RUNG
         RUNG wire#powerrail {{ S7_Templates := \"SrcType := String\" }} Eq_Contact( in1 := #v, in2 := '-efZ' ) Coil( #same ) END_RUNG"
    );
    // `abc` + `xyz` + `cd` has 8 characters, `abcd` + `xyz` + `de` has 9.
    tape(
        both(sections, vec![net], &[&rungs], ""),
        ["n"],
        ["left", "mid", "ok", "len", "at", "same"],
        &[([3], [1, 1, 1, 8, 5, 1]), ([4], [1, 1, 0, 8, 6, 1]), ([-1], [0, 0, 1, 3, 2, 1])],
    );
}

/// "MOVE_BLK: Move block", "FILL_BLK: Fill block", and the uninterruptible "UMOVE_BLK" and "UFILL_BLK".
#[test]
fn blocks_of_memory() {
    let sections: Sections = &[
        ("Input", "f : Bool"),
        ("Output", "y : Int; z : Int; done : Bool"),
        ("Static", "from : Array[0..4] of Int; to : Array[0..4] of Int"),
    ];
    for (fill_part, copy_part, fill_blk, move_blk) in
        [("FillBlockI", "MoveBlockI", "Fill_Blk", "Move_Blk"), ("FillBlockU", "MoveBlockU", "UFill_Blk", "UMove_Blk")]
    {
        let mut net = Net::new("");
        let flow = super::contact(&mut net, "f");
        let fill = net.part(fill_part, "", &[("en", flow), ("in", int(7)), ("count", int(2))]);
        net.write(fill, "out", local("from[1]"));
        let copied = [("en", From::Pin(fill, "eno")), ("in", local("from[0]")), ("count", int(3))];
        let copy = net.part(copy_part, "", &copied);
        net.write(copy, "out", local("to[2]"));
        coil(&mut net, "done", From::Pin(copy, "eno"));
        for (from, to) in [("to[2]", "y"), ("to[3]", "z")] {
            let copy = net.part("Move", "", &[("en", From::Rail), ("in", local(from))]);
            net.write(copy, "out1", local(to));
        }
        let rungs = format!(
            "RUNG wire#powerrail Contact( #f ) {fill_blk}( in := 7, count := 2, out => #from[1] )
             {move_blk}( in := #from[0], count := 3, out => #to[2] ) Coil( #done ) END_RUNG
             RUNG wire#powerrail Move( in := #to[2], out1 => #y ) Move( in := #to[3], out1 => #z ) END_RUNG"
        );
        let rows = [([0], [0, 0, 0]), ([1], [0, 7, 1])];
        tape(both(sections, vec![net], &[&rungs], ""), ["f"], ["y", "z", "done"], &rows);
    }
}

/// "MAX_LEN", "LOWER_BOUND", "UPPER_BOUND", "T_DIFF: Time difference", "T_COMBINE: Combine times", "TIME_TCK: Read system time",
/// "RUNTIME: Measure program runtime": calls every 100 ms.
#[test]
fn what_variables_and_the_clock_tell() {
    let sections: Sections = &[
        ("Output", "most : Int; low : DInt; high : DInt; since : Time; year : UInt; tick : Time; run : LReal"),
        (
            "Static",
            "s : String[10]; list : Array[2..6] of Int; now : DTL := DTL#2026-01-02-01:00:00; \
             then : DTL := DTL#2026-01-02-00:59:58; both : DTL; day : Date := D#2031-03-04; hour : Time_Of_Day; memory : LReal",
        ),
    ];
    let mut net = Net::new("");
    let mut boxed = |part: &str, pins: &[(&str, &str)], pin: &'static str, output: &str| {
        let pins = pins.iter().map(|(pin, name)| (*pin, if *name == "1" { int(1) } else { local(name) }));
        let pins: Vec<(&str, From)> = [("en", From::Rail)].into_iter().chain(pins).collect();
        let uid = net.part(part, "", &pins);
        net.write(uid, pin, local(output));
    };
    boxed("MAX_LEN", &[("IN", "s")], "OUT", "most");
    boxed("LOWER_BOUND", &[("ARR", "list"), ("DIM", "1")], "OUT", "low");
    boxed("UPPER_BOUND", &[("ARR", "list"), ("DIM", "1")], "OUT", "high");
    boxed("T_DIFF", &[("IN1", "now"), ("IN2", "then")], "OUT", "since");
    boxed("T_COMBINE", &[("IN1", "day"), ("IN2", "hour")], "OUT", "both");
    boxed("Move", &[("in", "both.YEAR")], "out1", "year");
    boxed("TIME_TCK", &[], "RET_VAL", "tick");
    boxed("RUNTIME", &[("MEM", "memory")], "RET_VAL", "run");
    let rungs =
        "RUNG wire#powerrail MAX_LEN( in := #s, out => #most ) LOWER_BOUND( arr := #list, dim := 1, out => #low )
        UPPER_BOUND( arr := #list, dim := 1, out => #high ) T_DIFF( in1 := #now, in2 := #then, out => #since ) END_RUNG
        RUNG wire#powerrail T_COMBINE( in1 := #day, in2 := #hour, out => #both ) Move( in := #both.YEAR, out1 => #year )
        TIME_TCK( ret_val => #tick ) RUNTIME( mem := #memory, ret_val => #run ) END_RUNG";
    for (format, mut ran) in both(sections, vec![net], &[rungs], "") {
        ran.call().call();
        let found = ["most", "low", "high", "since", "year", "tick"].map(|name| ran.get(name));
        assert_eq!(found, [10, 2, 6, 2000, 2031, 100], "{format}");
        assert_eq!(f64::from_bits(ran.bits("run") as u64), 0.1, "{format}");
    }
}

/// "S_MOVE: Move character string", "T_CONV: Convert times and extract": the names of the part's types differ from
/// those of CONVERT.
#[test]
fn moves_and_conversions_of_texts_and_times() {
    let sections: Sections = &[
        ("Input", "t : Time"),
        ("Output", "ms : DInt; hour : Bool; len : Int"),
        ("Static", "s : String[10] := 'abc'; u : String[10]; now : DTL := DTL#2026-01-02-01:00:00; day : Time_Of_Day"),
    ];
    let types = |from: &str, to: &str| of_type("src_type", from) + &of_type("dest_type", to);
    let mut net = Net::new("");
    let copy = net.part("S_Move", "", &[("en", From::Rail), ("in", local("s"))]);
    net.write(copy, "out", local("u"));
    let len = net.part("LEN", "", &[("en", From::Pin(copy, "eno")), ("IN", local("u"))]);
    net.write(len, "OUT", local("len"));
    let ms = net.part("T_CONV", &types("Time", "DInt"), &[("en", From::Rail), ("IN", local("t"))]);
    net.write(ms, "OUT", local("ms"));
    let day = net.part("T_CONV", &types("DTL", "Time_Of_Day"), &[("en", From::Pin(ms, "eno")), ("IN", local("now"))]);
    net.write(day, "OUT", local("day"));
    let one = net.part(
        "Eq",
        &of_type("SrcType", "Time_Of_Day"),
        &[("pre", From::Rail), ("in1", local("day")), ("in2", typed("TOD#1:00:00"))],
    );
    coil(&mut net, "hour", From::Pin(one, "out"));
    let rungs = "RUNG wire#powerrail S_Move( in := #s, out => #u ) LEN( in := #u, out => #len ) END_RUNG
        RUNG wire#powerrail { S7_Templates := \"[src_type := Time, dest_type := DInt]\" } T_CONV( in := #t, out => #ms )
        { S7_Templates := \"[src_type := DTL, dest_type := Time_Of_Day]\" } T_CONV( in := #now, out => #day ) END_RUNG
        RUNG wire#powerrail { S7_Templates := \"SrcType := Time_Of_Day\" } Eq_Contact( in1 := #day, in2 := TOD#1:00:00 ) Coil( #hour ) END_RUNG";
    tape(both(sections, vec![net], &[rungs], ""), ["t"], ["ms", "hour", "len"], &[([1500], [1500, 1, 3])]);
}

/// "T_ADD: Add times", "T_SUB: Subtract times": ENO is FALSE if the sum exceeds a TIME.
#[test]
fn times() {
    let sections: Sections = &[("Input", "t : Time"), ("Output", "y : Time; ok : Bool; z : Time")];
    let types = of_type("SrcType", "Time");
    let mut net = Net::new("");
    let add = net.part("T_ADD", &types, &[("en", From::Rail), ("IN1", local("t")), ("IN2", typed("T#1s"))]);
    net.write(add, "OUT", local("y"));
    coil(&mut net, "ok", From::Pin(add, "eno"));
    let sub = net.part("T_SUB", &types, &[("en", From::Rail), ("IN1", local("t")), ("IN2", typed("T#1s"))]);
    net.write(sub, "OUT", local("z"));
    let rungs = "RUNG wire#powerrail { S7_GenerateENO := \"TRUE\" } T_ADD( in1 := #t, in2 := T#1s, out => #y ) Coil( #ok ) END_RUNG
        RUNG wire#powerrail T_SUB( in1 := #t, in2 := T#1s, out => #z ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["t"],
        ["y", "ok", "z"],
        &[([500], [1500, 1, -500]), ([2147483647], [-2147482649, 0, 2147482647])],
    );
}

/// "RD_LOC_T: Read local time", "BITSUM": a function that is not a box in a formula returns its value at RET_VAL.
#[test]
fn functions_with_a_value() {
    let sections: Sections =
        &[("Input", "w : Word"), ("Output", "error : Int := 5; year : UInt; bits : Int"), ("Static", "now : DTL")];
    let mut net = Net::new("");
    let read = net.part("RD_LOC_T", &of_type("date_type", "DTL"), &[("en", From::Rail)]);
    net.write(read, "RET_VAL", local("error"));
    net.write(read, "OUT", local("now"));
    let year = net.part("Move", "", &[("en", From::Pin(read, "eno")), ("in", local("now.YEAR"))]);
    net.write(year, "out1", local("year"));
    let sum = net.part("BITSUM", "", &[("en", From::Rail), ("IN", local("w"))]);
    net.write(sum, "RET_VAL", local("bits"));
    let rungs = "RUNG wire#powerrail RD_LOC_T( Ret_Val => #error, OUT => #now ) Move( in := #now.YEAR, out1 => #year )
        BITSUM( in := #w, ret_val => #bits ) END_RUNG";
    tape(
        both(sections, vec![net], &[rungs], ""),
        ["w"],
        ["error", "year", "bits"],
        &[([7], [0, 2000, 3]), ([0x8100], [0, 2000, 2])],
    );
}
