//! Programs with a controller inside: their loop has the mode that the program gives the controller.

#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};
use tool::Engine;
use tool_wasm::home::Linked;

/// A controller at level 80 with setpoint 50, in manual mode until `on`.
const SOURCE: &str = "FUNCTION_BLOCK \"Tank\"
VAR_INPUT on : Bool; level : Real := 80.0; levelSp : Real := 50.0; END_VAR
VAR_OUTPUT outlet : Real; END_VAR
VAR pid : CONT_C; END_VAR
BEGIN
  #pid(MAN_ON := NOT #on, SP_INT := #levelSp, PV_IN := #level, MAN := 0.0, CYCLE := T#1s);
  #outlet := #pid.LMN;
END_FUNCTION_BLOCK
";

fn ask(engine: &mut Engine<Linked>, request: Value) -> Value {
    let answer: Value = serde_json::from_str(&engine.message(&request.to_string())).unwrap();
    assert!(answer["error"].is_null(), "{request} -> {answer}");
    answer["ok"].clone()
}

#[test]
fn a_step_counts_from_the_call_in_which_the_program_leaves_manual_mode() {
    let mut engine = Engine::new(Linked::new());
    let content = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, SOURCE);
    ask(&mut engine, json!({"do": "compile", "files": [{"file": "tank.scl", "content": content}]}));
    ask(&mut engine, json!({"do": "start", "members": [{"name": "T", "fmu": "Tank"}], "connections": []}));
    ask(&mut engine, json!({"do": "run", "calls": 10}));
    assert_eq!(ask(&mut engine, json!({"do": "figures"}))["step"], Value::Null);
    ask(&mut engine, json!({"do": "send", "values": {"T.on": true}}));
    ask(&mut engine, json!({"do": "run", "calls": 10}));
    let step = &ask(&mut engine, json!({"do": "figures"}))["step"];
    assert_eq!(
        (&step["cause"], &step["from"], &step["to"], &step["start"]),
        (&json!("automatic"), &json!(80.0), &json!(50.0), &json!(10.0))
    );
}
