use crate::Engine;
use crate::test_home::TestHome;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

const PUMP: &str = "FUNCTION_BLOCK \"Pump\"
VAR_INPUT
  level : Real;   // of the tank; unit: m, min 0, max 10
  limit { S7_SetPoint := 'True'} : Real := 3.0;
END_VAR
VAR_OUTPUT on : Bool; calls : Int; END_VAR
VAR t : TON_TIME; END_VAR
VAR_TEMP far : Bool; END_VAR
BEGIN
  #far := #level > #limit;
  #t(IN := #far, PT := T#1s);
  IF #t.Q THEN
    #on := TRUE;
  END_IF;
  #calls += 1;
END_FUNCTION_BLOCK
";

fn ask(engine: &mut Engine<TestHome>, request: Value) -> Value {
    let answer: Value = serde_json::from_str(&engine.message(&request.to_string())).unwrap();
    assert!(answer["error"].is_null(), "{request} -> {answer}");
    answer["ok"].clone()
}

fn files(sources: &[(&str, &str)]) -> Value {
    sources.iter().map(|(file, text)| json!({"file": file, "content": STANDARD.encode(text)})).collect()
}

fn compile(engine: &mut Engine<TestHome>, sources: &[(&str, &str)], options: Value) -> Value {
    let mut request = json!({"do": "compile", "files": files(sources)});
    request.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
    ask(engine, request)
}

fn engine() -> Engine<TestHome> {
    Engine::new(TestHome::default())
}

#[test]
fn a_program_runs_as_a_member_of_a_loop_and_is_watched() {
    let mut engine = engine();
    let compiled = compile(&mut engine, &[("pump.scl", PUMP)], json!({"cycle": 0.5}));
    assert_eq!(
        (&compiled["fmu"], &compiled["block"], &compiled["cycle"]),
        (&json!("Pump"), &json!("Pump"), &json!(0.5))
    );
    assert_eq!(compiled["problems"], json!([]));
    let described = ask(&mut engine, json!({"do": "describe", "fmu": "Pump"}));
    let level = described["variables"].as_array().unwrap().iter().find(|of| of["name"] == "level").unwrap();
    assert_eq!((&level["unit"], &level["max"], &level["role"]), (&json!("m"), &json!(10.0), &json!("input")));
    assert_eq!(described["cycle"], "CYCLE");

    ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": "Pump"}], "connections": []}));
    let lines = |engine: &mut Engine<TestHome>| ask(engine, json!({"do": "monitor", "member": "P1"}));
    ask(&mut engine, json!({"do": "run", "calls": 1}));
    let low = lines(&mut engine);
    assert_eq!((&low["temps"], &low["lines"]), (&json!({"far": false}), &json!([[0, 10], [0, 11], [0, 12], [0, 15]])));
    ask(&mut engine, json!({"do": "send", "values": {"P1.level": 4.0}}));
    // The timer begins with this call; after 1 s, two calls later, it is over.
    let state = ask(&mut engine, json!({"do": "run", "calls": 2}));
    assert_eq!((&state["values"]["P1.on"], &state["values"]["P1.t.ET"]), (&json!(false), &json!(0.5)));
    let state = ask(&mut engine, json!({"do": "run", "calls": 1}));
    assert_eq!((&state["values"]["P1.on"], &state["values"]["P1.calls"]), (&json!(true), &json!(4.0)));
    let high = lines(&mut engine);
    assert_eq!((&high["temps"]["far"], &high["lines"][3]), (&json!(true), &json!([0, 13])));
}

#[test]
fn the_texts_of_a_program_are_told_at_the_end_of_a_call() {
    let source = "FUNCTION_BLOCK Line VAR n : Int; name : String := 'pump'; message : WString[20]; END_VAR BEGIN\n\
                  n := n + 1; IF n > 1 THEN name := CONCAT(IN1 := 'call ', IN2 := 'two'); END_IF; message := WSTRING#'läuft'; END_FUNCTION_BLOCK";
    let mut engine = engine();
    compile(&mut engine, &[("line.scl", source)], json!({"cycle": 0.5}));
    ask(&mut engine, json!({"do": "start", "members": [{"name": "L1", "fmu": "Line"}], "connections": []}));
    let texts = |engine: &mut Engine<TestHome>, calls: usize| {
        ask(engine, json!({"do": "run", "calls": calls}));
        ask(engine, json!({"do": "monitor", "member": "L1"}))["texts"].clone()
    };
    assert_eq!(texts(&mut engine, 1), json!({"name": "pump", "message": "läuft"}));
    assert_eq!(texts(&mut engine, 1), json!({"name": "call two", "message": "läuft"}));
}

#[test]
fn a_program_that_has_changed_stands_beside_the_earlier_one() {
    let mut engine = engine();
    let first = compile(&mut engine, &[("pump.scl", PUMP)], json!({"cycle": 0.5}));
    let again = compile(&mut engine, &[("pump.scl", PUMP)], json!({"cycle": 0.5}));
    let changed = compile(&mut engine, &[("pump.scl", &PUMP.replace("+= 1", "+= 2"))], json!({"cycle": 0.5}));
    assert_eq!((&first["fmu"], &again["fmu"], &changed["fmu"]), (&json!("Pump"), &json!("Pump"), &json!("Pump_2")));
    for (fmu, calls) in [("Pump", 1.0), ("Pump_2", 2.0)] {
        ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": fmu}], "connections": []}));
        assert_eq!(ask(&mut engine, json!({"do": "run", "calls": 1}))["values"]["P1.calls"], calls);
    }
}

#[test]
fn all_errors_come_with_their_lines() {
    let mut engine = engine();
    let wrong = PUMP.replace("#far :=", "#fra :=").replace("#calls += 1", "#calls += TRUE");
    let compiled = compile(&mut engine, &[("pump.scl", &wrong)], json!({}));
    assert_eq!(compiled["fmu"], Value::Null);
    let problems = compiled["problems"].as_array().unwrap();
    let places: Vec<&Value> = problems.iter().filter(|of| of["is_error"] == true).map(|of| &of["place"][0]).collect();
    assert_eq!(places, [&json!(10), &json!(15)], "{problems:?}");
    assert_eq!((&problems[0]["file"], &problems[0]["length"]), (&json!("pump.scl"), &json!(4)));
    // The text is there to be shown with them.
    assert_eq!(compiled["sources"][0]["text"], wrong);
}

#[test]
fn one_of_several_blocks_is_chosen() {
    let mut engine = engine();
    let two = format!("{PUMP}{}", PUMP.replace("\"Pump\"", "\"Other\""));
    let compiled = compile(&mut engine, &[("pump.scl", &two)], json!({}));
    assert_eq!((&compiled["fmu"], &compiled["candidates"]), (&Value::Null, &json!(["Pump", "Other"])));
    let compiled = compile(&mut engine, &[("pump.scl", &two)], json!({"run": "Other"}));
    assert_eq!(compiled["fmu"], "Other");
    let main = format!(
        "{PUMP}DATA_BLOCK \"Pump_DB\" \"Pump\" BEGIN END_DATA_BLOCK
        ORGANIZATION_BLOCK \"Main\" BEGIN \"Pump_DB\"(); END_ORGANIZATION_BLOCK"
    );
    let compiled = compile(&mut engine, &[("pump.scl", &main)], json!({"run": "Main"}));
    assert_eq!((&compiled["fmu"], &compiled["parts"][1]["path"]), (&json!("Main"), &json!("Pump_DB")));
}

#[test]
fn the_cycle_is_that_of_a_comment_or_a_constant() {
    let cycle = |source: String| {
        let compiled = compile(&mut engine(), &[("pump.scl", &source)], json!({}));
        (compiled["cycle"].clone(), compiled["cycle_from"].as_str().unwrap().to_string())
    };
    let (none, why) = cycle(PUMP.into());
    assert!(none == 0.1 && why.starts_with("no source specifies one"), "{why}");
    let constant = PUMP.replace("BEGIN", "VAR CONSTANT CYCLE : Time := T#2s; END_VAR\nBEGIN");
    assert_eq!(cycle(constant), (json!(2.0), "the constant CYCLE in Pump".into()));
    let main = format!(
        "{PUMP}DATA_BLOCK \"D\" \"Pump\" BEGIN END_DATA_BLOCK\nORGANIZATION_BLOCK \"Cyclic\"\n// called every 20 ms\n\
         VAR_TEMP x : Int; END_VAR\nBEGIN \"D\"(); END_ORGANIZATION_BLOCK"
    );
    assert_eq!(cycle(main), (json!(0.02), "the comment on Cyclic".into()));
    // A controller computes with the period that it is told.
    let sub = "FUNCTION_BLOCK \"Sub\" VAR_INPUT CYCLE : Time; END_VAR BEGIN ; END_FUNCTION_BLOCK\n";
    let calls =
        PUMP.replace("VAR t ", "VAR pid : \"Sub\"; t ").replace("#calls += 1", "#pid(CYCLE := T#500ms); #calls += 1");
    let told = format!("{sub}{calls}");
    assert_eq!(cycle(told), (json!(0.5), "the CYCLE that Pump passes to pid".into()));
}

#[test]
fn a_loop_without_end_stops_the_program_and_not_the_engine() {
    let mut engine = engine();
    let endless = PUMP.replace("  #calls += 1;", "  WHILE #level > 0.0 DO\n    #calls += 1;\n  END_WHILE;");
    compile(&mut engine, &[("pump.scl", &endless)], json!({"cycle": 0.5, "budget": 1000}));
    ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": "Pump"}], "connections": []}));
    ask(&mut engine, json!({"do": "send", "values": {"P1.level": 1.0}}));
    let state = ask(&mut engine, json!({"do": "run", "calls": 5}));
    let failure = state["failure"].as_str().unwrap();
    assert!(failure.contains("pump.scl:15: the call was stopped after 1000 statements"), "{failure}");
    ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": "Pump"}], "connections": []}));
    assert_eq!(ask(&mut engine, json!({"do": "run", "calls": 1}))["values"]["P1.calls"], 0.0);
}

#[test]
fn a_run_of_a_program_is_taken_away_with_its_options() {
    let mut engine = engine();
    compile(&mut engine, &[("pump.scl", PUMP)], json!({"cycle": 0.5, "run": "Pump", "parameters": ["level"]}));
    ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": "Pump"}], "connections": []}));
    ask(&mut engine, json!({"do": "run", "calls": 2}));
    let exported = ask(&mut engine, json!({"do": "export", "what": "description"}));
    let text = String::from_utf8(STANDARD.decode(exported["content"].as_str().unwrap()).unwrap()).unwrap();
    for line in ["sources = [\"pump.scl\"]", "cycle = \"500ms\"", "run = \"Pump\"", "parameters = [\"level\"]"] {
        assert!(text.contains(&format!("P1.{line}")), "{text}");
    }
    let wrong = engine.message(&json!({"do": "compile", "files": [], "cycel": 0.5}).to_string());
    assert!(wrong.contains("unknown field `cycel`"), "{wrong}");
    assert_eq!(exported["remarks"], json!(["Put the program's sources in the same folder: pump.scl."]));
}

const TANK: &str = "FUNCTION_BLOCK \"Tank\"
VAR_INPUT on : Bool; END_VAR
VAR_OUTPUT level : Real := 1.0; END_VAR
BEGIN
  level := level + 1.0;
END_FUNCTION_BLOCK
";

/// A pump and its tank, whose level rises by 1 m in each call, from 2 m on.
fn pump_and_tank(engine: &mut Engine<TestHome>) {
    for (file, source) in [("pump.scl", PUMP), ("tank.scl", TANK)] {
        compile(engine, &[(file, source)], json!({"cycle": 0.5}));
    }
    let members = json!([{"name": "P1", "fmu": "Pump"}, {"name": "T1", "fmu": "Tank"}]);
    let wires = json!([["T1.level", "P1.level"], ["P1.on", "T1.on"]]);
    ask(engine, json!({"do": "start", "members": members, "connections": wires}));
}

#[test]
fn what_is_forced_has_its_value_in_every_call_until_it_is_released() {
    let mut engine = engine();
    pump_and_tank(&mut engine);
    ask(&mut engine, json!({"do": "run", "calls": 2}));
    // An output, which reaches the tank, a local of an instance, a connected input and a counter of the program itself.
    let values = json!({"P1.on": true, "P1.t.ET": 0.25, "P1.level": 0.5, "P1.calls": 10});
    let state = ask(&mut engine, json!({"do": "force", "act": "force", "values": values}));
    assert_eq!(state["forced"], json!({"P1.on": true, "P1.t.ET": 0.25, "P1.level": 0.5, "P1.calls": 10.0}));
    let state = ask(&mut engine, json!({"do": "run", "calls": 3}));
    let now = |state: &Value, names: &[&str]| names.iter().map(|name| state["values"][name].clone()).collect::<Value>();
    let names = ["P1.on", "T1.on", "P1.t.ET", "P1.level", "P1.calls", "T1.level"];
    // The tank's row has the level that the call found.
    assert_eq!(now(&state, &names), json!([true, true, 0.25, 0.5, 10.0, 5.0]));
    ask(&mut engine, json!({"do": "force", "act": "release", "values": values}));
    let state = ask(&mut engine, json!({"do": "run", "calls": 1}));
    // The program goes on from there: its counter has 10, its level is that of the tank before the call.
    assert_eq!(now(&state, &["P1.level", "P1.calls"]), json!([6.0, 11.0]));
    assert_eq!(state["forced"], json!({}));
    let events = ask(&mut engine, json!({"do": "events"}))["events"].clone();
    let acts: Vec<_> = events.as_array().unwrap().iter().map(|of| (of["call"].as_u64(), of["act"].as_str())).collect();
    assert_eq!(acts, [[(Some(2), Some("force")); 4], [(Some(5), Some("release")); 4]].concat());
    // It is repeated to the same bits, and the same test forces the same.
    let view = |engine: &mut Engine<TestHome>, run| {
        ask(engine, json!({"do": "view", "run": run, "variables": names, "points": 100}))["values"].clone()
    };
    ask(&mut engine, json!({"do": "same_bits"}));
    ask(&mut engine, json!({"do": "same_test", "values": {}}));
    let first = view(&mut engine, 0);
    assert_eq!(first[3], json!([1.0, 2.0, 0.5, 0.5, 0.5, 6.0]));
    assert_eq!((&first, &first), (&view(&mut engine, 1), &view(&mut engine, 2)));
}

#[test]
fn a_release_and_a_value_before_the_same_call_are_both_done_again() {
    let mut engine = engine();
    pump_and_tank(&mut engine);
    ask(&mut engine, json!({"do": "force", "act": "force", "values": {"P1.calls": 5.0}}));
    ask(&mut engine, json!({"do": "run", "calls": 2}));
    for (act, value) in [("release", 5.0), ("write", 20.0)] {
        ask(&mut engine, json!({"do": "force", "act": act, "values": {"P1.calls": value}}));
    }
    let state = ask(&mut engine, json!({"do": "run", "calls": 1}));
    assert_eq!(state["values"]["P1.calls"], 21.0);
    let again = ask(&mut engine, json!({"do": "same_bits"}));
    assert_eq!((&again["values"]["P1.calls"], &again["forced"]), (&json!(21.0), &json!({})));
}

#[test]
fn what_is_written_once_is_what_the_next_call_goes_on_from() {
    let mut engine = engine();
    pump_and_tank(&mut engine);
    ask(&mut engine, json!({"do": "run", "calls": 1}));
    let wrong = |engine: &mut Engine<TestHome>, act: &str, values: Value| {
        let answer = engine.message(&json!({"do": "force", "act": act, "values": values}).to_string());
        serde_json::from_str::<Value>(&answer).unwrap()["error"]["message"].as_str().unwrap().to_string()
    };
    let connected = wrong(&mut engine, "write", json!({"P1.level": 1.0}));
    assert!(
        connected.contains("P1.level is connected to T1.level, which sets it in each call: force it"),
        "{connected}"
    );
    assert!(wrong(&mut engine, "force", json!({"P1.calls": 1.5})).contains("P1.calls"));
    ask(&mut engine, json!({"do": "force", "act": "write", "values": {"P1.calls": 100}}));
    assert_eq!(ask(&mut engine, json!({"do": "run", "calls": 1}))["values"]["P1.calls"], 101.0);
    ask(&mut engine, json!({"do": "force", "act": "force", "values": {"P1.calls": 5}}));
    assert!(wrong(&mut engine, "write", json!({"P1.calls": 1})).contains("P1.calls is forced: release it first"));
    // A description of the run ends before the first call that it cannot describe.
    let taken = ask(&mut engine, json!({"do": "export", "what": "description"}));
    assert_eq!(
        taken["remarks"][0],
        "The description ends at call 1 (0.5 s), when P1.calls was written: it can set only inputs and parameters."
    );
}

#[test]
fn an_earlier_call_is_looked_at_and_the_run_goes_on() {
    let mut engine = engine();
    pump_and_tank(&mut engine);
    // The level is above 3 m from call 3 on, the pump on from call 5 on, a second later.
    ask(&mut engine, json!({"do": "run", "calls": 8}));
    let lines = |engine: &mut Engine<TestHome>, call: Value| {
        let told = ask(engine, json!({"do": "monitor", "member": "P1", "call": call}));
        (told["temps"]["far"].clone(), told["lines"].as_array().unwrap().contains(&json!([0, 13])))
    };
    let calls = [2, 3, 4, 5].map(|call| lines(&mut engine, json!(call)));
    assert_eq!(calls, [(json!(false), false), (json!(true), false), (json!(true), false), (json!(true), true)]);
    assert_eq!(lines(&mut engine, Value::Null), (json!(true), true));
    let answer = engine.message(&json!({"do": "monitor", "member": "P1", "call": 8}).to_string());
    assert!(answer.contains("the run has 8 calls, numbered from 0: call 8 does not exist"), "{answer}");
    assert_eq!(ask(&mut engine, json!({"do": "run", "calls": 1}))["values"]["P1.calls"], 9.0);
    assert_eq!(lines(&mut engine, Value::Null), (json!(true), true));
}

/// Holds itself until it is stopped; the third network is jumped over while it does not run.
const HOLD: &str = "FUNCTION_BLOCK \"Hold\"
VAR_INPUT start : Bool; stop : Bool; END_VAR
VAR_OUTPUT run : Bool; count : Int; END_VAR
    { S7_Language := \"LAD\"; }
    NETWORK
        RUNG wire#powerrail
            Contact( #start )
            wire#w1
            I_Contact( #stop )
            Coil(
                #run
            )
        END_RUNG
        RUNG wire#powerrail
            Contact( #run )
        END_RUNG wire#w1
    END_NETWORK
    { S7_Language := \"LAD\"; }
    NETWORK
        RUNG wire#powerrail
            I_Contact( #run )
            JumpCoil( end )
        END_RUNG
    END_NETWORK
    { S7_Language := \"LAD\"; }
    NETWORK
        RUNG wire#powerrail
            Contact( #start )
            { S7_Templates := \"DestType := Int\" }
            Inc( #count )
        END_RUNG
    END_NETWORK
    { S7_Language := \"LAD\"; }
    NETWORK
        Label( end )
        RUNG wire#powerrail
            Contact( #stop )
            Coil( #run )
        END_RUNG
    END_NETWORK
END_FUNCTION_BLOCK
";

#[test]
fn a_wire_carries_what_it_did_when_the_call_calculated_it() {
    let mut engine = engine();
    let compiled = compile(&mut engine, &[("hold.s7dcl", HOLD)], json!({"cycle": 0.1}));
    assert_eq!(compiled["problems"], json!([]));
    let networks = compiled["blocks"][0]["networks"].clone();
    assert_eq!((&networks[0]["has_rail"], networks.as_array().unwrap().len()), (&json!(true), 4));
    let first = &networks[0]["elements"];
    let shapes: Vec<_> = first.as_array().unwrap().iter().map(|of| (of["shape"].clone(), of["sign"].clone())).collect();
    assert_eq!(shapes[..3], [("contact", ""), ("contact", "/"), ("coil", "")].map(|(a, b)| (json!(a), json!(b))));
    let junction = &first[4];
    assert_eq!(
        (&junction["shape"], junction["inputs"][0]["sources"].as_array().unwrap().len()),
        (&json!("junction"), 2)
    );
    ask(&mut engine, json!({"do": "start", "members": [{"name": "H", "fmu": "Hold"}], "connections": []}));
    let write = &compiled["blocks"][0]["writes"][0];
    let (reads, mut decided) = (write["reads"].clone(), Vec::new());
    let mut call = |start: bool, stop: bool| {
        ask(&mut engine, json!({"do": "send", "values": {"H.start": start, "H.stop": stop}}));
        ask(&mut engine, json!({"do": "run", "calls": 1}));
        let looked = json!({"do": "monitor", "member": "H", "networks": ["Hold", ""], "why": [["Hold", ""]]});
        let told = ask(&mut engine, looked);
        // Whatever line its operand is in, a coil is told to have run.
        assert!(told["lines"].as_array().unwrap().contains(&json!([0, write["line"]])), "{told}");
        let run = &told["decided"][0][0]["value"];
        let parts = reads.as_array().unwrap().iter().zip(run["parts"].as_array().unwrap());
        let parts: Vec<_> = parts.map(|(read, part)| format!("{} {}", read["path"], part).replace('"', "")).collect();
        decided.push((run["truth"].clone(), parts.join(", "), run["values"].clone()));
        let wires = told["wires"].as_array().unwrap().clone();
        move |wire: &Value| wires.iter().find(|one| one[0] == *wire).map(|one| one[1] == json!(true))
    };
    let operand = |element: &Value| element["above"]["wire"].clone();
    let out = |element: &Value| element["outputs"][0]["wire"].clone();
    // At its beginning the contact of run is still open; at the end of the call run is TRUE.
    let at = call(true, false);
    let seen = [operand(&first[0]), operand(&first[3]), out(&first[1])].map(|wire| at(&wire));
    assert_eq!(seen, [Some(true), Some(false), Some(true)]);
    assert_eq!(at(&operand(&networks[2]["elements"][0])), Some(true));
    let at = call(false, true);
    let seen = [operand(&first[0]), operand(&first[3]), out(&first[1])].map(|wire| at(&wire));
    assert_eq!(seen, [Some(false), Some(false), Some(false)]);
    // The jump leads over the third network, of which nothing can be told.
    assert_eq!(at(&operand(&networks[2]["elements"][0])), None);
    assert_eq!(at(&operand(&networks[3]["elements"][0])), Some(true));
    // The contact of run was open, and did not matter; then both ways were open, and the stop would have been enough.
    let expected = ["start decided, run idle, stop decided", "start shared, run shared, stop shared"];
    let told = |truth: bool, at: usize, values: [bool; 3]| (json!(truth), expected[at].to_string(), json!(values));
    assert_eq!(decided, [told(true, 0, [true, false, false]), told(false, 1, [false, false, true])]);
}

const LOOPS: &str = "FUNCTION_BLOCK \"Loops\"
VAR_INPUT step : Int; most : Int; on : Bool; END_VAR
VAR_OUTPUT mode : Int; n : Int; m : Int; END_VAR
BEGIN
  CASE #step OF
    1: #mode := 10;
    2, 5..7: #mode := 20;
  ELSE
    #mode := 30;
  END_CASE;
  #n := 0;
  WHILE #on AND #n < #most DO
    #n := #n + 1;
  END_WHILE;
  #m := 0;
  REPEAT
    #m := #m + 2;
  UNTIL #m >= 3 OR NOT #on
  END_REPEAT;
END_FUNCTION_BLOCK
";

#[test]
fn the_arm_of_a_case_and_the_end_of_a_loop_are_decided_like_a_condition() {
    let mut engine = engine();
    let compiled = compile(&mut engine, &[("loops.scl", LOOPS)], json!({"cycle": 0.1}));
    let writes = compiled["blocks"][0]["writes"].as_array().unwrap();
    ask(&mut engine, json!({"do": "start", "members": [{"name": "L", "fmu": "Loops"}], "connections": []}));
    let mut call = |step: u8, on: bool| {
        ask(&mut engine, json!({"do": "send", "values": {"L.step": step, "L.most": 2, "L.on": on}}));
        ask(&mut engine, json!({"do": "run", "calls": 1}));
        let told = ask(&mut engine, json!({"do": "monitor", "member": "L", "why": [["Loops", ""]]}));
        let each = writes.iter().zip(told["decided"][0].as_array().unwrap());
        let told = each.filter_map(|(write, of)| {
            let (guard, decision) = (write["guards"].get(0)?, &of["guards"][0]);
            let parts = guard["reads"].as_array().unwrap().iter().zip(decision["parts"].as_array().unwrap());
            let parts: Vec<_> = parts.map(|(read, part)| format!("{} {part}", read["path"])).collect();
            let (kind, truth) = (&guard["of"], &decision["truth"]);
            Some(format!("{} {kind} {truth}: {}", write["line"], parts.join(", ")).replace('"', ""))
        });
        told.collect::<Vec<_>>()
    };
    // 6 is in 5..7; n has reached 2; m is 4 in the second pass.
    assert_eq!(
        call(6, true),
        [
            "6 case false: step decided",
            "7 case true: step decided",
            "9 case true: step decided",
            "13 while false: on idle, n decided, most decided",
            "17 until true: m decided, on idle",
        ]
    );
    // No arm has a 3; the WHILE does not begin, 0 < 2 notwithstanding; one pass, in which m is 2.
    assert_eq!(
        call(3, false),
        [
            "6 case false: step decided",
            "7 case false: step decided",
            "9 case false: step decided",
            "13 while false: on decided, n idle, most idle",
            "17 until true: m idle, on decided",
        ]
    );
}

#[test]
fn a_project_has_its_tags_and_a_list_of_what_is_assumed() {
    let mut engine = engine();
    let main = "ORGANIZATION_BLOCK \"Main\"\nBEGIN\n  \"Lamp\" := \"Start\" AND \"Ready\";\nEND_ORGANIZATION_BLOCK\n";
    let tags = "\"Start\",\"%I0.0\",\"Bool\",\"\",\"\",\"\",\"\",\"\",\"\"\n\"Lamp\",\"%Q0.0\",\"Bool\",\"\",\"\",\"\",\"\",\"\",\"\"\n";
    let refused = compile(&mut engine, &[("Main.scl", main), ("tags.sdf", tags)], json!({}));
    assert_eq!(refused["fmu"], Value::Null);
    let survey = json!([
        ["SCL", "1 organization block"],
        ["tags", "2 tags, 2 in use, from 1 table"],
        ["missing", "1 tags: \"Ready\""],
    ]);
    assert_eq!(refused["survey"].as_array().map(Vec::len), survey.as_array().map(Vec::len), "{}", refused["survey"]);
    assert_eq!((&refused["survey"][0], &refused["survey"][1]), (&survey[0], &survey[1]));
    let assumptions = refused["assumptions"].as_array().unwrap();
    assert_eq!((assumptions.len(), &assumptions[0]["name"]), (1, &json!("Ready")));
    assert_eq!(assumptions[0]["place"], json!(["Main.scl", 3]));
    let assumed = assumptions[0]["text"].as_str().unwrap();
    let files = [("Main.scl", main), ("tags.sdf", tags), ("assumed.scl", assumed)];
    let accepted = compile(&mut engine, &files, json!({}));
    assert_eq!((&accepted["fmu"], accepted["assumptions"].as_array().map(Vec::len)), (&json!("Main"), Some(0)));
    let described = ask(&mut engine, json!({"do": "describe", "fmu": "Main"}));
    let roles: Vec<_> =
        described["variables"].as_array().unwrap().iter().map(|of| (&of["name"], &of["role"])).collect();
    for expected in [("Start", "input"), ("Ready", "input"), ("Lamp", "output")] {
        assert!(roles.contains(&(&json!(expected.0), &json!(expected.1))), "{roles:?}");
    }
}

#[test]
fn a_run_ends_in_the_call_in_which_a_condition_begins_to_hold() {
    let mut engine = engine();
    compile(&mut engine, &[("pump.scl", PUMP)], json!({"cycle": 0.5}));
    ask(&mut engine, json!({"do": "start", "members": [{"name": "P1", "fmu": "Pump"}], "connections": []}));
    let until = json!({"variable": "P1.calls", "sign": ">=", "value": 7.0});
    let mut run = |calls: usize| ask(&mut engine, json!({"do": "run", "calls": calls, "until": until}));
    let state = run(100);
    assert_eq!((&state["calls"], &state["is_met"]), (&json!(7), &json!(true)));
    // It holds already, and does not begin to hold again.
    let state = run(5);
    assert_eq!((&state["calls"], &state["is_met"]), (&json!(12), &json!(false)));
    let wrong = json!({"do": "run", "calls": 1, "until": {"variable": "P1.calls", "sign": "!=", "value": 0.0}});
    let answer = engine.message(&wrong.to_string());
    assert!(answer.contains("is not a comparison: use =, <>, >, >=, < or <="), "{answer}");
}
