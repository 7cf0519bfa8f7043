use super::*;
use crate::test_home::TestHome;
use serde_json::{Value, json};

fn engine() -> Engine<TestHome> {
    Engine::new(TestHome::default())
}

fn ask(engine: &mut Engine<TestHome>, request: Value) -> Value {
    let answer: Value = serde_json::from_str(&engine.message(&request.to_string())).unwrap();
    match answer.get("ok") {
        Some(content) => content.clone(),
        None => panic!("{request}: {answer}"),
    }
}

fn refused(engine: &mut Engine<TestHome>, request: &str) -> String {
    let answer: Value = serde_json::from_str(&engine.message(request)).unwrap();
    answer["error"]["message"].as_str().unwrap_or_else(|| panic!("{request}: {answer}")).to_string()
}

fn start() -> Value {
    json!({"do": "start", "members": [
        {"name": "TIC101", "fmu": "PID", "values": {"SP": 40, "P_SEL": true}},
        {"name": "P", "fmu": "LAG", "values": {"CYCLE": 0.5}}],
        "connections": [["TIC101.OUT", "P.POWER"], ["P.TEMP", "TIC101.PV_IN"]]})
}

#[test]
fn a_loop_is_found_connected_run_and_shown_by_messages_alone() {
    let mut engine = engine();
    let catalogue = ask(&mut engine, json!({"do": "catalogue"}));
    assert_eq!(catalogue["fmus"][0]["part"], "controller");
    let description = ask(&mut engine, json!({"do": "describe", "fmu": "PID"}));
    assert_eq!(description["roles"]["manual"], json!(["MAN_ON", "MAN"]));
    assert_eq!(
        description["groups"][1]["fields"][4],
        json!({"name": "GAIN", "used_if": [[["P_SEL", true]], [["I_SEL", true]]]})
    );
    let (controller, plant) = (json!({"name": "C", "fmu": "PID"}), json!({"name": "P", "fmu": "LAG"}));
    let proposal = ask(&mut engine, json!({"do": "propose", "controller": controller, "plant": plant}));
    assert_eq!(proposal["connections"][2]["to"], "C.PV_IN");

    assert_eq!(ask(&mut engine, start())["values"]["TIC101.SP"], 40.0);
    ask(&mut engine, json!({"do": "run", "calls": 10}));
    ask(&mut engine, json!({"do": "send", "values": {"TIC101.SP": 50, "TIC101.MAN_ON": false}}));
    ask(&mut engine, json!({"do": "ramp", "variable": "P.LOAD", "to": 5, "seconds": 1}));
    let state = ask(&mut engine, json!({"do": "run", "calls": 10}));
    assert_eq!((&state["calls"], &state["time"], &state["failure"]), (&json!(20), &json!(9.5), &Value::Null));
    assert_eq!(ask(&mut engine, json!({"do": "state"})), state);
    let events = ask(&mut engine, json!({"do": "events"}));
    assert_eq!(events["events"][1], json!({"call": 10, "time": 5.0, "variable": "TIC101.SP", "value": 50.0}));
    let view = json!({"do": "view", "variables": ["TIC101.SP", "TIC101.MAN_ON"], "points": 100, "from": 4.5, "to": 5});
    let curves = ask(&mut engine, view);
    let expected =
        json!({"times": [4.5, 5.0], "values": [[40.0, 50.0], [0.0, 0.0]], "units": ["degC", null], "is_exact": true});
    assert_eq!(curves, expected);
    let again = ask(&mut engine, json!({"do": "same_bits"}));
    assert_eq!((&again["run"], &again["values"]), (&json!(1), &state["values"]));
    let characteristics = ask(&mut engine, json!({"do": "characteristic", "member": {"name": "C", "fmu": "PID"}}));
    assert_eq!(characteristics["sweeps"][0]["variable"], "MAN");
    let checked = ask(&mut engine, json!({"do": "check", "fmu": "PID", "values": {"TI": "inf"}}));
    assert_eq!(checked["remarks"][0]["is_error"], true);
}

#[test]
fn what_is_no_request_is_an_error_and_the_engine_goes_on() {
    let mut engine = engine();
    ask(&mut engine, start());
    let deep = "[".repeat(100_000);
    let requests = [
        "",
        "null",
        "[]",
        "\u{0}",
        "{\"do\": \"nonsense\"}",
        "{\"do\": \"run\"}",
        "{\"do\": \"run\", \"calls\": -1}",
        "{\"do\": \"run\", \"calls\": 1e30}",
        "{\"do\": \"run\", \"calls\": 1, \"more\": 2}",
        "{\"do\": \"send\", \"values\": {\"TIC101.SP\": \"x\"}}",
        "{\"do\": \"send\", \"values\": {\"TIC101.SP\": \"NaN\"}}",
        "{\"do\": \"view\", \"variables\": [], \"points\": 0}",
        "{\"do\": \"start\", \"members\": [], \"connections\": []}",
        "{\"do\": \"describe\", \"fmu\": \"<script>alert(1)</script>\"}",
        &deep,
    ];
    for request in requests {
        assert!(!refused(&mut engine, request).is_empty(), "{request}");
    }
    assert_eq!(ask(&mut engine, json!({"do": "run", "calls": 1}))["calls"], 1);
}

#[test]
fn numbers_go_through_the_messages_with_all_bits() {
    let mut engine = engine();
    ask(&mut engine, start());
    for value in [0.1, 423.209_170_872_713_23, 5e-324, -0.0, 2.0_f64.powi(60), 1.7e308] {
        ask(&mut engine, json!({"do": "send", "values": {"P.LOAD": value}}));
        let state = ask(&mut engine, json!({"do": "run", "calls": 1}));
        assert_eq!(state["values"]["P.LOAD"].as_f64().unwrap().to_bits(), f64::to_bits(value), "{value}");
    }
}

#[test]
fn each_request_is_answered_by_the_part_that_computes_it() {
    let mut engine = engine();
    let controller = json!({"name": "C", "fmu": "PID", "values": {"MAN_ON": true, "CYCLE": 0.1}});
    let plant = json!({"name": "P", "fmu": "LAG", "values": {"CYCLE": 0.1}});
    let wires = json!([["C.OUT", "P.POWER"], ["P.TEMP", "C.PV_IN"]]);
    ask(&mut engine, json!({"do": "start", "members": [controller, plant], "connections": wires}));
    ask(&mut engine, json!({"do": "run", "calls": 50}));
    ask(&mut engine, json!({"do": "send", "values": {"C.MAN": 40, "C.SP": 60}}));
    ask(&mut engine, json!({"do": "run", "calls": 1000}));

    // In manual mode a setpoint is no step: the figures are those of the whole run.
    assert_eq!(ask(&mut engine, json!({"do": "figures"}))["from"], 0.0);
    let identified = ask(&mut engine, json!({"do": "identify", "data": {"run": {}}, "method": "least_squares"}));
    assert!(identified["fit"].as_f64().unwrap() > 99.0, "{identified}");
    let mut model = identified["model"].clone();
    // A plant without dead time has no finite gain by the rules.
    model["dead_time"] = json!(1.0);
    let tune = json!({"do": "tune", "model": model, "rule": "simc", "structure": "pi", "controller": controller});
    let tuned = ask(&mut engine, tune);
    assert!(tuned["values"]["GAIN"].as_f64().unwrap() > 0.0, "{tuned}");
    assert!(!tuned["predicted"]["times"].as_array().unwrap().is_empty());
    let ratio = ask(&mut engine, json!({"do": "ratio", "heating": model, "cooling": model}));
    assert_eq!(ratio["ratio"], 1.0);

    let file = |engine: &mut Engine<TestHome>, request: Value| {
        use base64::Engine as _;
        let content = ask(engine, request)["content"].as_str().unwrap().to_string();
        String::from_utf8(base64::engine::general_purpose::STANDARD.decode(content).unwrap()).unwrap()
    };
    let description = file(&mut engine, json!({"do": "export", "what": "description"}));
    assert!(description.contains("[[events]]"), "{description}");
    let csv = file(
        &mut engine,
        json!({"do": "export", "what": "csv", "variables": ["C.SP", "C.PV_IN", "C.MAN_ON", "C.MAN", "C.OUT"]}),
    );
    assert_eq!(csv.lines().count(), 1051);
    let replayed = ask(&mut engine, json!({"do": "replay", "controller": controller, "text": csv}));
    assert_eq!((&replayed["outputs"][0]["different"], &replayed["conclusion"]), (&json!(0), &json!("equal")));
}
