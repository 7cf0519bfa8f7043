use super::*;

fn read(text: &str) -> CsvTable {
    CsvTable::read(text).unwrap_or_else(|error| panic!("{error:#}\n{text}"))
}

fn error(text: &str) -> String {
    format!("{:#}", CsvTable::read(text).unwrap_err())
}

fn values<'a>(table: &'a CsvTable, name: &str) -> &'a [f64] {
    &table.column(name).unwrap().values
}

fn seconds(table: &CsvTable) -> Vec<f64> {
    table.times(table.time().unwrap()).unwrap().seconds
}

#[test]
fn comma_semicolon_and_tab_separate_and_the_decimal_sign_is_point_or_comma() {
    for text in [
        "time,SP,PV\n0,60.5,20\n0.1,61,20.25\n",
        "time;SP;PV\r\n0;60,5;20\r\n0,1;61;20,25\r\n",
        "time\tSP\tPV\n0\t60,5\t20\n0,1\t61\t20,25",
        "sep=;\ntime;SP;PV\n0;60.5;20\n0.1;61;20.25\n",
        "\u{feff}\"time\",\"SP\",\"PV\"\n\"0\",\"60,5\",\"20\"\n\"0,1\",\"61\",\"20,25\"\n",
        "# exported by a recorder\n# on line 3\ntime|SP|PV\n0|60.5|20\n\n0.1|61|20.25\n",
    ] {
        let table = read(text);
        assert_eq!(values(&table, "sp"), [60.5, 61.0], "{text}");
        assert_eq!(values(&table, "PV"), [20.0, 20.25], "{text}");
        assert_eq!(seconds(&table), [0.0, 0.1], "{text}");
    }
}

#[test]
fn thousands_are_told_from_decimals_by_the_rest_of_the_file() {
    assert_eq!(values(&read("a;b\n1.234,5;1.234\n2,5;7\n"), "b"), [1234.0, 7.0]);
    assert_eq!(values(&read("a;b\n1.234;0.5\n"), "a"), [1.234]);
    assert_eq!(values(&read("a,b\n\"1,234.5\",\"1,234\"\n"), "b"), [1234.0]);
    assert_eq!(values(&read("a;b\n1,234;5\n"), "a"), [1.234]);
    assert_eq!(values(&read("a;b\n1 234,5;5\n"), "a"), [1234.5]);
    assert_eq!(values(&read("a,b\n-1e-3,+2.5E+1\n"), "b"), [25.0]);
    let mixed = error("a;b\n1,5;2\n3;2.5\n");
    assert!(mixed.contains("line 3, column 2 (b) has \"2.5\"") && mixed.contains("line 2, column 1 (a)"), "{mixed}");
}

#[test]
fn words_are_true_and_false_and_cells_may_be_missing() {
    let table = read("time,MAN_ON,PV\n0,TRUE,1.5\n1,off,\n2,1,NaN\n3,0,#N/A\n");
    assert_eq!(values(&table, "MAN_ON"), [1.0, 0.0, 1.0, 0.0]);
    assert!(table.column("MAN_ON").unwrap().is_boolean);
    assert!(values(&table, "PV")[1..].iter().all(|value| value.is_nan()));
    assert_eq!(values(&read("LMN,x\ninf,1\n-inf,2\n"), "LMN"), [f64::INFINITY, f64::NEG_INFINITY]);
}

#[test]
fn a_column_of_a_variable_has_a_number_for_each_loop() {
    let fault = |text: &str| {
        let error = CsvTable::of_loops(text).unwrap_err();
        error.downcast_ref::<Fault>().unwrap_or_else(|| panic!("{error:#}")).in_file("loops.csv")
    };
    let table =
        CsvTable::of_loops("tag;P.RISE [K];P.ON;Descr. 1\nTIC1;300;TRUE;left\nTIC2;310,5;FALSE;right\n").unwrap();
    assert_eq!((values(&table, "P.RISE"), values(&table, "P.ON")), (&[300.0, 310.5][..], &[1.0, 0.0][..]));
    assert_eq!(table.columns.iter().map(|column| column.number).collect::<Vec<_>>(), [2, 3]);
    let table = CsvTable::of_loops("tag;P.RISE;P.TI\n;K;s\nTIC1;300;20\n").unwrap();
    assert_eq!((table.lines.as_slice(), table.columns[0].unit.as_deref()), (&[3][..], Some("K")));
    // All cells are texts, only the second is a text, the file is empty.
    for (text, expected) in [
        (
            "tag,P.RISE\nTIC1,300 K\nTIC2,310 K\n",
            "loops.csv:2:2: P.RISE: \"300 K\" is not a number, TRUE or FALSE: write a number without a unit, or remove the \
             row",
        ),
        (
            "tag,P.RISE\nTIC1,300\nTIC2,x\n",
            "loops.csv:3:2: P.RISE: \"x\" is not a number, TRUE or FALSE: write a number without a unit, or remove the row",
        ),
        ("tag,P.RISE\nTIC1,\nTIC2,\n", "loops.csv:2:2: P.RISE: missing number: complete the row, or remove it"),
        ("P.GAIN,P.TI\n1,2\n,4\n", "loops.csv:3:1: P.GAIN: missing number: complete the row, or remove it"),
        (
            "tag,P.RISE\nTIC1,x\nTIC2,300\n",
            "loops.csv:2:2: P.RISE: \"x\" is not a number, TRUE or FALSE: write a number without a unit, or remove the row",
        ),
        (
            "tag,P.RISE\nTIC1,12:30\n",
            "loops.csv:2:2: P.RISE: a date or a time of day is not a number: write a number, or remove the row",
        ),
        (
            "tag,P.RISE\nTIC1,1\nTIC2\n",
            "loops.csv:3:1: the line has 1 values, but the header has 2 columns: complete the row, or remove it",
        ),
    ] {
        assert_eq!(fault(text), expected, "{text}");
    }
    assert_eq!(
        format!("{:#}", CsvTable::of_loops("P.GAIN\n").unwrap_err()),
        "the file has a header but no data rows: add a row for each loop"
    );
}

#[test]
fn units_are_taken_from_the_header_or_a_line_below() {
    let table = read("t [ms];PV [degC];LMN (%);F / m3/h;AI[3];Zeit in s\n0;1;2;3;4;5\n10;1;2;3;4;5\n");
    let units: Vec<_> = table.columns.iter().map(|column| (column.name.as_str(), column.unit.as_deref())).collect();
    assert_eq!(
        units,
        [
            ("t", Some("ms")),
            ("PV", Some("degC")),
            ("LMN", Some("%")),
            ("F", Some("m3/h")),
            ("AI[3]", None),
            ("Zeit in s", None)
        ]
    );
    assert_eq!(seconds(&table), [0.0, 0.01]);
    let table = read("time,PV\ns,[degC]\n0,20\n1,21\n");
    assert_eq!(table.columns[1].unit.as_deref(), Some("degC"));
    assert_eq!(values(&table, "PV"), [20.0, 21.0]);
    assert_eq!(table.lines, [3, 4]);
}

#[test]
fn a_time_is_in_seconds_or_milliseconds_or_what_its_header_says() {
    assert_eq!(seconds(&read("time,x\n0,1\n0.1,1\n0.3,1\n")), [0.0, 0.1, 0.3]);
    assert_eq!(seconds(&read("Time_ms,x\n0,1\n100,1\n300,1\n")), [0.0, 0.1, 0.3]);
    assert_eq!(seconds(&read("t [min],x\n0,1\n2,1\n")), [0.0, 120.0]);
    let guessed = read("time,x\n0,1\n100,1\n300,1\n");
    let times = guessed.times(0).unwrap();
    assert_eq!(times.seconds, [0.0, 0.1, 0.3]);
    assert!(!times.is_unit_known && times.remark.unwrap().contains("milliseconds"));
    assert_eq!(seconds(&read("time,x\n0,1\n60,1\n120,1\n")), [0.0, 60.0, 120.0]);
    assert_eq!(seconds(&read("timestamp,x\n1795342530100,1\n1795342530200,1\n")), [0.0, 0.1]);
    assert_eq!(seconds(&read("x [s],y\n0,1\n5,1\n")), [0.0, 5.0]);
    assert_eq!(read("x,y\n0,1\n5,1\n").time(), None);
}

#[test]
fn dates_and_times_of_day_are_seconds_after_the_first_row() {
    for text in [
        "time,x\n2026-11-22 23:59:59.900,1\n2026-11-23 00:00:00.400,2\n",
        "time,x\n2026-11-22T23:59:59.9Z,1\n2026-11-23T01:00:00.400+01:00,2\n",
        "Zeit;x\n22.11.2026 23:59:59,9;1\n23.11.2026 00:00:00,4;2\n",
        "Zeit;x\n22.11.26 23:59:59:900;1\n23.11.26 0:00:00:400;2\n",
        "when;x\n23:59:59.900;1\n00:00:00.400;2\n",
        "date;clock;x\n22.11.2026;23:59:59,9;1\n23.11.2026;00:00:00,4;2\n",
        "date,x\n11/22/2026 11:59:59.900 PM,1\n11/23/2026 12:00:00.400 AM,2\n",
    ] {
        let table = read(text);
        assert_eq!(seconds(&table), [0.0, 0.5], "{text}");
        assert_eq!(values(&table, "x"), [1.0, 2.0], "{text}");
        assert_eq!(table.columns.len(), 2, "{text}");
    }
    // 2024 is a leap year, 2100 is not.
    assert_eq!(seconds(&read("time,x\n2024-02-28,1\n2024-03-01,2\n")), [0.0, 172_800.0]);
    assert_eq!(seconds(&read("time,x\n2100-02-28,1\n2100-03-01,2\n")), [0.0, 86_400.0]);
    // This day does not exist, so the column is a text column.
    assert_eq!(read("time,x\n2026-02-30 10:00:00,1\n").time(), None);
}

#[test]
fn the_resolution_is_half_of_the_last_written_digit() {
    let table = read("fixed,any,words\n0.125,0.00123456,TRUE\n101.5,123.456,FALSE\n");
    let resolution = |name: &str, value: f64| table.column(name).unwrap().resolution(value);
    assert_eq!(resolution("fixed", 7.0), 0.0005);
    assert_eq!(resolution("any", 123.456), 0.0005);
    assert!((resolution("any", 0.001_234_56) - 5e-9).abs() < 1e-20);
    assert_eq!(resolution("words", 1.0), 0.0);
    assert_eq!(read("x\n1.5e-3\n").columns[0].resolution(0.0), 0.5e-4);
}

#[test]
fn errors_name_line_and_column() {
    assert_eq!(
        error("time,PV\n0,1\n1,2\n2,12a\n"),
        "line 4, column 2 (PV): \"12a\" is not a number, TRUE, FALSE or a date; correct it, or leave the cell empty"
    );
    assert!(error("time,PV\n0,1\n1,2,5\n2,3\n").starts_with("line 3 has 3 values, but the header has 2 columns"));
    assert!(error("time,PV,SP\n0,1,2\n1,2\n2,3,4\n").starts_with("line 3 has 2 values, but the header has 3 columns"));
    assert_eq!(
        error("PK\u{3}\u{4}\u{14}time,PV\n0,1\n"),
        "the file is not text: it contains the character '\\u{3}'; export the recording as CSV"
    );
    assert_eq!(read("time,PV\n0,1\n1,2\n\u{1a}").rows(), 2);
    assert!(error("").contains("empty"));
    assert!(error("# only a comment").contains("no rows"));
    assert!(error("time,PV\n").contains("no data rows"));
    let back = read("time,PV\n0,1\n2,1\n1,1\n");
    assert!(format!("{:#}", back.times(0).unwrap_err()).starts_with("line 4, column time: the time decreases"));
    let unknown = |table: &CsvTable, name| format!("{:#}", table.column(name).unwrap_err());
    assert!(unknown(&back, "PW").starts_with("the file has no column PW; available: time, PV"));
    assert!(unknown(&back, "PW").contains("did you mean PV?"));
    let names: Vec<_> = (1..=21).map(|number| format!("C{number}")).collect();
    let wide = read(&format!("{}\n{}\n", names.join(","), ["1"; 21].join(",")));
    assert!(unknown(&wide, "x").contains("C19, C20, ..."), "{}", unknown(&wide, "x"));
}

#[test]
fn times_as_a_plc_program_writes_them_are_in_seconds() {
    let table = read("time;TI\nT#0ms;T#1M20S\nT#100MS;T#20S\n");
    assert_eq!(values(&table, "TI"), [80.0, 20.0]);
    assert_eq!(table.columns[1].unit.as_deref(), Some("s"));
    assert_eq!(seconds(&table), [0.0, 0.1]);
}

#[test]
fn a_last_row_that_was_cut_off_is_left_out_with_a_remark() {
    let table = read("time,PV,SP\n0,1,2\n1,2,3\n2,");
    assert_eq!(table.rows(), 2);
    assert!(table.remarks[0].contains("Line 4"));
}

#[test]
fn a_line_has_its_number_whatever_ends_it_and_after_empty_ones() {
    for end in ["\n", "\r\n"] {
        let lines = ["time;PV", "0;1", "", "1;2", "2;3", "3;x"].join(end);
        let error = CsvTable::read(&lines).unwrap_err().to_string();
        assert!(error.starts_with("line 6, column 2 (PV)"), "{end:?} {error}");
        let table = CsvTable::read(&["time;PV", "0;1", "", "1;2", "2;3"].join(end)).unwrap();
        assert_eq!(table.lines, [2, 4, 5], "{end:?}");
    }
}

#[test]
fn columns_of_texts_and_lines_above_the_header_are_left_out() {
    let table = read("Trend export\nLine 3\ntime;PV;quality;\n0;1;Good;\n1;2;Good;\n2;2;Bad;\n");
    let names: Vec<_> = table.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["time", "PV"]);
    assert_eq!(table.remarks, ["Column quality contains text and is ignored."]);
    assert_eq!(table.lines, [4, 5, 6]);
    assert_eq!(
        error("Trend export\n0;1\n1;2\n"),
        "line 2 has values but no header line above it: add one, such as time;SP;PV;LMN"
    );
    let table = read("# time,PV\n0,1\n1,2\n");
    assert_eq!(table.columns[1].name, "PV");
}

#[test]
fn hostile_texts_are_refused_or_read_and_never_panic() {
    for text in [
        "\"",
        "\"\n\n",
        ",,,\n,,,\n",
        "a\n\u{0}\n",
        "é;\u{1f980}\n1;ü:::\n",
        "a,b\n--,1e999\n",
        "a\n1/2/3/4\n99:99\n",
        "T\n1T\n",
        "a\n2026-\n1234\u{a0}\n",
    ] {
        let _ = CsvTable::read(text);
    }
    assert!(error(&"x".repeat(LARGEST + 1)).contains("at most"));
    let wide = format!("{}\n{}\n", "a,".repeat(10_000), "1,".repeat(10_000));
    assert!(CsvTable::read(&wide).is_ok());
    assert!(error(&"a,".repeat(30_000)).contains("at most 20000"));
    assert!(error(&"a,".repeat(600_000)).contains("line 1 has more than 1048576 bytes"));
}

#[test]
fn many_rows_take_one_pass_each() {
    let mut text = String::from("time;PV\n");
    for row in 0..50_000 {
        text.push_str(&format!("{row};20,5\n"));
    }
    assert_eq!(read(&text).rows(), 50_000);
}
