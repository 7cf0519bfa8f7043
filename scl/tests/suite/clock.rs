//! The clock of a program: it begins at 2000-01-01 00:00:00, a Saturday.

use super::{Ran, compiled};

const PROGRAM: &str = r#"
FUNCTION_BLOCK "Clock"
   VAR
      now : DTL;
      local : DTL;
      result : Int;
   END_VAR
BEGIN
   #result := RD_SYS_T(#now);
   RD_LOC_T(OUT => #local);
END_FUNCTION_BLOCK
"#;

#[test]
fn the_clock_counts_days_months_and_leap_years() {
    let mut ran = Ran::new(compiled(PROGRAM).unwrap());
    let days = [
        (0, [2000, 1, 1, 7]),
        (59, [2000, 2, 29, 3]),
        (60, [2000, 3, 1, 4]),
        (366, [2001, 1, 1, 2]),
        (36584, [2100, 3, 1, 2]),
    ];
    for (day, date) in days {
        ran.call((day * 86_400 + 3_723) * 1_000_000_000 + 5).unwrap();
        for variable in ["now", "local"] {
            let get = |name: &str| ran.get(&format!("{variable}.{name}")).bits();
            assert_eq!(["YEAR", "MONTH", "DAY", "WEEKDAY"].map(get), date, "day {day}");
            assert_eq!(["HOUR", "MINUTE", "SECOND", "NANOSECOND"].map(get), [1, 2, 3, 5]);
        }
    }
}

#[test]
fn the_functions_of_step_7_take_a_date_and_time_apart() {
    let source = "FUNCTION_BLOCK Clock VAR now : DATE_AND_TIME; day : INT; date : DATE; time : TOD; result : INT; END_VAR
        BEGIN result := READ_CLK(CDT := now); day := DT_DAY(IN := now); date := DT_DATE(IN := now); time := DT_TOD(IN := now);
        END_FUNCTION_BLOCK";
    let mut ran = Ran::new(compiled(source).unwrap());
    // Days since 1990-01-01, the epoch of a DATE: 2000-01-01 is the 3652nd and a Saturday.
    for (day, weekday) in [(0, 7), (1, 1), (59, 3)] {
        ran.call((day * 86_400 + 3_723) * 1_000_000_000 + 5_000_000).unwrap();
        let get = |name: &str| ran.get(name).bits();
        assert_eq!(["day", "date", "time"].map(get), [weekday, 3652 + day as u64, 3_723_005]);
    }
}
