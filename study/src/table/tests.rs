use super::*;
use run::system::Member;

fn rows(text: &str) -> Result<Rows> {
    of_csv("loops.csv", text)?.rows("loops.csv")
}

fn error(text: &str) -> String {
    format!("{:#}", rows(text).unwrap_err())
}

#[test]
fn a_csv_file_has_a_row_for_each_loop_with_its_name() {
    let of = rows("loop;P.GAIN;P.ON;note\nTIC1;0,5;TRUE;a\nTIC2;2;FALSE;b\n").unwrap();
    assert_eq!(of.axis.names, ["TIC1", "TIC2"]);
    assert_eq!(of.axis.variables, ["P.GAIN", "P.ON"]);
    assert_eq!(of.remarks, ["Column note contains text and is ignored."]);
    let row = |gain, on| vec![Value::Number(gain), Value::Boolean(on)];
    assert_eq!(of.axis.along, Along::Rows(vec![row(0.5, true), row(2.0, false)]));
    assert!(rows("P.GAIN,P.TI\n1,2\n3,4\n").unwrap().axis.names.is_empty());
}

#[test]
fn a_table_without_variables_or_with_a_gap_is_refused() {
    assert_eq!(
        error("GAIN,TI\n1,2\n"),
        "loops.csv: no column contains a variable: use column names FMU.VARIABLE, such as PUMP.SPEED"
    );
    assert_eq!(
        error("P.GAIN,P.TI\n1,2\n,4\n"),
        "loops.csv:3:1: P.GAIN: missing number: complete the row, or remove it"
    );
    assert_eq!(
        error("P.GAIN,P.TI,P.GAIN\n1,2,3\n"),
        "loops.csv: the columns 1 and 3 are both P.GAIN: remove one of them"
    );
}

#[test]
fn a_variable_whose_values_have_units_is_refused_and_not_left_out() {
    assert_eq!(
        error("loop,HEATER.RISE,HEATER.FURN_TM\nA,300 K,60\nB,310 K,70\n"),
        "loops.csv:2:2: HEATER.RISE: \"300 K\" is not a number, TRUE or FALSE: write a number without a unit, or remove the row"
    );
}

#[test]
fn two_loops_have_two_names() {
    assert_eq!(
        error("loop,P.GAIN\nTIC1,1\nTIC2,2\nTIC1,3\n"),
        "loops.csv:4:1: \"TIC1\" is also the name of the loop at loops.csv:2:1: give each loop a unique name"
    );
}

const SOURCE: &str = "DATA_BLOCK \"TIC1\"\n FB 41\nBEGIN\n GAIN := 1.5;\nEND_DATA_BLOCK\n\
                      DATA_BLOCK \"VALVE1\"\n FB 42\nBEGIN\n GAIN := 2.5;\nEND_DATA_BLOCK\n";

/// Returns the rows of a STEP 7 source for the FMU of a loop.
fn of_source(text: &str, file: &str, fmu: Option<&str>) -> Result<Rows> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.awl");
    fs::write(&path, text).unwrap();
    let members = vec![Member { name: "PID".into(), path: file.into() }];
    let parameters: ReadParameters = |name, options| {
        let source = parameters::Source::read(Path::new(name), None).map_err(Error::msg)?;
        Ok(parameters::read(Format::of_file(name).unwrap(), &source, &BlockType::all(), options)?)
    };
    read(&path, fmu, &System { members, ..System::default() }, &[], parameters)
}

#[test]
fn loops_of_another_block_than_the_fmus_are_left_out_with_a_remark_or_refused() {
    let named = |number: &str| BlockType::all().iter().find(|block| block.is_called(number)).unwrap().name.clone();
    let (own, other) = (named("FB 41"), named("FB 42"));
    let of = of_source(SOURCE, &format!("fmus/{own}.fmu"), None).unwrap();
    assert_eq!((of.axis.names, of.axis.variables), (vec!["TIC1".to_string()], vec!["PID.GAIN".to_string()]));
    let remark = of.remarks.last().unwrap();
    let expected = format!("plant.awl: 1 loop of {other} is left out: the FMU PID contains the block {own}");
    assert!(remark.ends_with(&expected), "{remark}");
    let alone = &SOURCE[SOURCE.find("DATA_BLOCK \"VALVE1\"").unwrap()..];
    let error = format!("{:#}", of_source(alone, &format!("{own}.fmu"), Some("PID")).unwrap_err());
    let expected = format!(
        "plant.awl has loops of {other}, but none for the FMU PID: specify the FMU of these loops with fmu = \"NAME\", or \
         use another file"
    );
    assert!(error.ends_with(&expected), "{error}");
    assert_eq!(of_source(alone, &format!("{other}.fmu"), None).unwrap().axis.names, ["VALVE1"]);
}

/// Writes a Parquet file with one column of each kind; values are null where `is_there` is 0.
fn parquet_file(path: &Path, names: &[&str], is_there: &[i16]) {
    use ::parquet::basic::Compression;
    use ::parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
    use ::parquet::file::properties::WriterProperties;
    use ::parquet::file::writer::SerializedFileWriter;
    use ::parquet::schema::parser::parse_message_type;
    let schema = "message loops { REQUIRED BYTE_ARRAY tag (UTF8); OPTIONAL DOUBLE P.GAIN; REQUIRED FLOAT P.TI; REQUIRED INT32 P.N; \
                  REQUIRED INT64 P.M; REQUIRED BOOLEAN P.ON; REQUIRED DOUBLE price; }";
    let schema = std::sync::Arc::new(parse_message_type(schema).unwrap());
    let properties = std::sync::Arc::new(WriterProperties::builder().set_compression(Compression::SNAPPY).build());
    let mut writer = SerializedFileWriter::new(fs::File::create(path).unwrap(), schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for place in 0..7 {
        let mut column = group.next_column().unwrap().unwrap();
        match place {
            0 => {
                let names: Vec<ByteArray> = names.iter().map(|name| ByteArray::from(*name)).collect();
                column.typed::<ByteArrayType>().write_batch(&names, None, None)
            }
            1 => {
                let values: Vec<f64> =
                    [0.1, 2.5].into_iter().zip(is_there).filter(|(_, is)| **is == 1).map(|of| of.0).collect();
                column.typed::<DoubleType>().write_batch(&values, Some(is_there), None)
            }
            2 => column.typed::<FloatType>().write_batch(&[20.5, 30.0], None, None),
            3 => column.typed::<Int32Type>().write_batch(&[-3, 4], None, None),
            4 => column.typed::<Int64Type>().write_batch(&[5, 6], None, None),
            5 => column.typed::<BoolType>().write_batch(&[true, false], None, None),
            _ => column.typed::<DoubleType>().write_batch(&[9.0, 9.0], None, None),
        }
        .unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn a_parquet_file_has_the_rows_of_the_csv() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loops.parquet");
    let of = || {
        let read = read(&path, None, &System::default(), &[], |_, _| unreachable!());
        read.map_err(|error| format!("{error:#}").split_once("loops.parquet").unwrap().1.to_string())
    };
    parquet_file(&path, &["TIC1", "TIC2"], &[1, 1]);
    let csv = "tag,P.GAIN,P.TI,P.N,P.M,P.ON,price\nTIC1,0.1,20.5,-3,5,TRUE,9\nTIC2,2.5,30,4,6,FALSE,9\n";
    assert_eq!(of().unwrap().axis, rows(csv).unwrap().axis);
    parquet_file(&path, &["TIC1", "TIC2"], &[1, 0]);
    assert_eq!(of().unwrap_err(), ": row 2, column P.GAIN: missing number: complete the row, or remove it");
    parquet_file(&path, &["TIC1", "TIC1"], &[1, 1]);
    let twice = of().unwrap_err();
    assert!(twice.starts_with(": row 2: \"TIC1\" is also the name of the loop at "), "{twice}");
    fs::write(&path, "tag,P.GAIN\nTIC1,1\n").unwrap();
    assert!(of().unwrap_err().starts_with(" is not a Parquet file: "));
}
