//! Blocks of `blocks` as instances in a program.

use blocks::{Law, Pulsegen};
use parameters::Source;
use scl::ir::Scalar;
use scl::machine::{Cause, Code, Machine};
use scl::{Options, compile};
use std::sync::Arc;

const SOURCE: &str = "FUNCTION_BLOCK Heater VAR_INPUT inv : Real; END_VAR VAR p : PULSEGEN; END_VAR
    BEGIN #p(INV := #inv); END_FUNCTION_BLOCK";

#[test]
fn a_block_as_an_instance_is_the_block_itself_also_in_a_saved_state() {
    let compiled = compile(&[Source::new("heater.scl", SOURCE.into())], &Options::default()).unwrap();
    let root = compiled.root.unwrap();
    let code = Arc::new(Code::compile(&compiled.program).unwrap());
    let offset = |name: &str| compiled.program.find(&format!("{}.{name}", root.instance)).unwrap().0;
    let mut machine = Machine::new(Arc::clone(&code));
    let mut block = Pulsegen::default();
    let mut pulses = 0;
    for call in 0..500 {
        let saved = machine.state().to_vec();
        machine = Machine::new(Arc::clone(&code));
        machine.state_mut().copy_from_slice(&saved);

        block.inv = call as f32 / 5.0;
        machine.set(block.inv.into(), offset("inv"));
        block.call();
        machine.call(root.cycle, 0).unwrap();
        pulses += usize::from(block.qpos_p);
        assert_eq!(machine.get(Scalar::Bool, offset("p.QPOS_P")), block.qpos_p.into(), "{call}");
    }
    assert!(pulses > 50, "{pulses}");

    // A BOOL that is neither 0 nor 1 is not a valid state of a block.
    machine.state_mut()[offset("p.QPOS_P")] = 2;
    assert_eq!(machine.call(root.cycle, 0).unwrap_err().cause, Cause::Instance);
}
