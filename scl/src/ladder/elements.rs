//! LAD and FBD elements, by their names in SimaticML and SIMATIC SD.

use crate::front::syntax::{Binary, Unary};

/// An instruction.
#[derive(Debug)]
pub(crate) struct Instruction {
    /// Its names in SimaticML, SIMATIC SD and other sources; letter case is ignored.
    pub names: &'static [&'static str],
    /// Its behaviour.
    pub law: Law,
}

/// The behaviour of an element. `f` is the incoming power flow.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    /// f AND operand; f AND NOT operand if `true`.
    Contact(bool),
    /// f AND an edge of the operand, whose last value is stored at the pin BIT; the edge is rising if `true`.
    EdgeContact(bool),
    /// An edge of f, whose last value is stored at the pin BIT; the edge is rising if `true`.
    EdgeOfFlow(bool),
    /// f AND (in1 op in2).
    Compare(Binary),
    /// f AND the value is within the limits if `true`, outside them if `false`.
    Range(bool),
    /// f AND the operand is a valid floating-point number if `true`, an invalid one if `false`.
    Valid(bool),
    /// An FBD gate or a LAD junction.
    Gate(Binary),
    /// NOT f.
    Not,
    /// operand := f; operand := NOT f if `true`.
    Coil(bool),
    /// IF f THEN operand := TRUE if `true`, operand := FALSE if `false`.
    Set(bool),
    /// IF f THEN N consecutive bits, starting at the operand, := TRUE if `true`, := FALSE if `false`.
    SetField(bool),
    /// operand := an edge of f, which is rising if `true`; f itself is passed on.
    EdgeCoil(bool),
    /// A flip-flop; `true` if SET is dominant.
    FlipFlop(bool),
    /// A timer or counter of this kind, with an instance.
    Instance(&'static str),
    /// A system block with an instance.
    System,
    /// A coil that starts a timer of this kind.
    TimerCoil(&'static str),
    /// IF f THEN this function is called with the timer.
    TimerFunction(&'static str),
    /// IF f (`true`) or IF NOT f (`false`) THEN GOTO the label.
    Jump(bool),
    /// The position of a label.
    Label,
    /// IF f THEN RETURN, which sets the block's ENO as specified.
    Return(Returned),
    /// A box that runs if EN is TRUE.
    Box(Formula, Failure),
    /// IF f THEN output number K := IN, or ELSE := IN if there is no such output.
    Demultiplex,
    /// A box that runs if EN is TRUE: a function with outputs, called as a statement.
    Statement(&'static str),
    /// Not supported; the string suggests an alternative.
    Refused(&'static str),
}

/// The value that a Return element assigns to the block's ENO.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)]
pub(crate) enum Returned {
    Unchanged,
    True,
    False,
    Operand,
}

/// The value that a box computes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Formula {
    /// IN.
    Same,
    /// IN1 op IN2 op IN3 ...
    Fold(Binary),
    /// op IN.
    Unary(Unary),
    /// The operand plus or minus 1, stored in the operand.
    Step(Binary),
    /// A function of these pins, `IN*` meaning IN1, IN2 and so on. The last list holds the pins converted to the type
    /// of the box.
    Call(&'static str, &'static [&'static str], &'static [&'static str]),
    /// Like `Call`, with the result type appended to the function's name.
    Typed(&'static str, &'static [&'static str], &'static [&'static str]),
    /// A conversion of IN from the source type to the destination type of the box.
    Convert,
    /// The expression written in the box.
    Equation,
}

/// The condition under which ENO is FALSE although EN is TRUE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// Never.
    Never,
    /// A number overflows its type or is not a valid floating-point number in this kind of calculation.
    Calculation(&'static str),
    /// The named condition on the pins of the box is TRUE.
    Condition(&'static str),
}

use Failure::{Calculation, Condition, Never};
use Formula::{Call, Convert, Equation, Fold, Same, Step, Typed};

const fn row(names: &'static [&'static str], law: Law) -> Instruction {
    Instruction { names, law }
}

/// The row of a box with one result.
const fn function(names: &'static [&'static str], formula: Formula, failure: Failure) -> Instruction {
    Instruction { names, law: Law::Box(formula, failure) }
}

/// The row of a box that applies a function to a floating-point IN.
const fn real(names: &'static [&'static str]) -> Instruction {
    function(names, Call(names[0], &[], &["IN"]), Calculation("CALL"))
}

/// The table of all elements.
pub(crate) const ROWS: &[Instruction] = &[
    row(&["Contact"], Law::Contact(false)),
    row(&["I_Contact"], Law::Contact(true)),
    row(&["PContact", "P_Contact"], Law::EdgeContact(true)),
    row(&["NContact", "N_Contact"], Law::EdgeContact(false)),
    row(&["PBox", "P_Trig"], Law::EdgeOfFlow(true)),
    row(&["NBox", "N_Trig"], Law::EdgeOfFlow(false)),
    row(&["Eq", "Eq_Contact"], Law::Compare(Binary::Equal)),
    row(&["Ne", "Ne_Contact"], Law::Compare(Binary::NotEqual)),
    row(&["Gt", "Gt_Contact"], Law::Compare(Binary::Greater)),
    row(&["Ge", "Ge_Contact"], Law::Compare(Binary::GreaterOrEqual)),
    row(&["Lt", "Lt_Contact"], Law::Compare(Binary::Less)),
    row(&["Le", "Le_Contact"], Law::Compare(Binary::LessOrEqual)),
    row(&["InRange", "In_Range", "InRange_Contact"], Law::Range(true)),
    row(&["OutRange", "Out_Range", "OutRange_Contact"], Law::Range(false)),
    row(&["OK", "OK_Contact", "IsValidContact"], Law::Valid(true)),
    row(&["NotOK", "Not_OK", "NotOK_Contact", "NOK", "IsNotValidContact"], Law::Valid(false)),
    row(&["A"], Law::Gate(Binary::And)),
    row(&["O"], Law::Gate(Binary::Or)),
    row(&["X"], Law::Gate(Binary::Xor)),
    row(&["Not"], Law::Not),
    row(&["Coil"], Law::Coil(false)),
    row(&["I_Coil"], Law::Coil(true)),
    row(&["SCoil", "S_Coil"], Law::Set(true)),
    row(&["RCoil", "R_Coil"], Law::Set(false)),
    row(&["SBitfield", "SBitfieldCoil", "S_BitfieldCoil", "Set_BF", "Set_BF_Coil", "SetBitField"], Law::SetField(true)),
    row(
        &["RBitfield", "RBitfieldCoil", "R_BitfieldCoil", "Reset_BF", "Reset_BF_Coil", "ResetBitField"],
        Law::SetField(false),
    ),
    row(&["PCoil", "P_Coil"], Law::EdgeCoil(true)),
    row(&["NCoil", "N_Coil"], Law::EdgeCoil(false)),
    row(&["Sr", "S_SR"], Law::FlipFlop(false)),
    row(&["Rs", "S_RS"], Law::FlipFlop(true)),
    row(&["TON"], Law::Instance("TON")),
    row(&["TOF"], Law::Instance("TOF")),
    row(&["TP"], Law::Instance("TP")),
    row(&["TONR"], Law::Instance("TONR")),
    row(&["CTU"], Law::Instance("CTU")),
    row(&["CTD"], Law::Instance("CTD")),
    row(&["CTUD"], Law::Instance("CTUD")),
    row(&["R_TRIG"], Law::System),
    row(&["F_TRIG"], Law::System),
    row(&["TonCoil", "TOn_Coil"], Law::TimerCoil("TON")),
    row(&["TofCoil", "TOf_Coil"], Law::TimerCoil("TOF")),
    row(&["TpCoil", "TP_Coil"], Law::TimerCoil("TP")),
    row(&["TonrCoil", "TOnR_Coil"], Law::TimerCoil("TONR")),
    row(&["ResetIECTimerCoil", "RtCoil", "RT_Coil", "Reset_Timer_Coil"], Law::TimerFunction("RESET_TIMER")),
    row(&["PresetTimerCoil", "PtCoil", "PT_Coil", "Preset_Timer_Coil"], Law::TimerFunction("PRESET_TIMER")),
    row(&["Reset_Timer"], Law::TimerFunction("RESET_TIMER")),
    row(&["Preset_Timer"], Law::TimerFunction("PRESET_TIMER")),
    row(&["Jump", "JumpCoil"], Law::Jump(true)),
    row(&["JumpNot", "I_JumpCoil", "JumpNotCoil"], Law::Jump(false)),
    row(&["Label"], Law::Label),
    row(&["Return", "ReturnCoil"], Law::Return(Returned::Unchanged)),
    row(&["ReturnTrue"], Law::Return(Returned::True)),
    row(&["ReturnFalse"], Law::Return(Returned::False)),
    row(&["ReturnValue"], Law::Return(Returned::Operand)),
    function(&["Move", "S_Move"], Same, Never),
    function(&["Add"], Fold(Binary::Add), Calculation("ADD")),
    function(&["Sub"], Fold(Binary::Subtract), Calculation("SUB")),
    function(&["Mul"], Fold(Binary::Multiply), Calculation("MUL")),
    function(&["Div"], Fold(Binary::Divide), Calculation("DIV")),
    function(&["Mod"], Fold(Binary::Modulo), Calculation("MOD")),
    function(&["Expt"], Fold(Binary::Power), Calculation("CALL")),
    function(&["And"], Fold(Binary::And), Never),
    function(&["Or"], Fold(Binary::Or), Never),
    function(&["Xor"], Fold(Binary::Xor), Never),
    function(&["Inv", "Invert"], Formula::Unary(Unary::Not), Never),
    function(&["Neg"], Formula::Unary(Unary::Minus), Calculation("NEG")),
    function(&["Abs"], Call("ABS", &[], &["IN"]), Calculation("ABS")),
    function(&["Inc"], Step(Binary::Add), Calculation("ADD")),
    function(&["Dec"], Step(Binary::Subtract), Calculation("SUB")),
    function(&["Calculate", "Calc"], Equation, Calculation("CALL")),
    function(&["Convert", "T_Conv"], Convert, Calculation("CONVERT")),
    function(&["Round"], Typed("ROUND", &[], &["IN"]), Calculation("ROUND")),
    function(&["Trunc"], Typed("TRUNC", &[], &["IN"]), Calculation("TRUNC")),
    function(&["Ceil"], Typed("CEIL", &[], &["IN"]), Calculation("CEIL")),
    function(&["Floor"], Typed("FLOOR", &[], &["IN"]), Calculation("FLOOR")),
    function(&["Norm_X", "Normalize"], Typed("NORM_X", &[], &["MIN", "VALUE", "MAX"]), Condition("NORM_X")),
    function(&["Scale_X", "Scale"], Typed("SCALE_X", &["MIN", "MAX"], &["VALUE"]), Condition("SCALE_X")),
    function(&["Min"], Call("MIN", &[], &["IN*"]), Never),
    function(&["Max"], Call("MAX", &[], &["IN*"]), Never),
    function(&["Limit"], Call("LIMIT", &[], &["MN", "IN", "MX"]), Condition("LIMIT")),
    function(&["Sel"], Call("SEL", &["G"], &["IN0", "IN1"]), Never),
    function(&["Mux"], Call("MUX", &["K"], &["IN*", "INELSE"]), Condition("MUX")),
    row(&["Demux"], Law::Demultiplex),
    function(&["Shl"], Call("SHL", &["N"], &["IN"]), Never),
    function(&["Shr"], Call("SHR", &["N"], &["IN"]), Never),
    function(&["Rol"], Call("ROL", &["N"], &["IN"]), Never),
    function(&["Ror"], Call("ROR", &["N"], &["IN"]), Never),
    function(&["Swap"], Call("SWAP", &[], &["IN"]), Never),
    function(&["Deco"], Typed("DECO", &["IN"], &[]), Never),
    function(&["Enco"], Call("ENCO", &["IN"], &[]), Never),
    real(&["Sqr"]),
    real(&["Sqrt"]),
    real(&["Exp"]),
    real(&["Ln"]),
    real(&["Sin"]),
    real(&["Cos"]),
    real(&["Tan"]),
    real(&["Asin"]),
    real(&["Acos"]),
    real(&["Atan"]),
    real(&["Frac"]),
    function(&["T_Add"], Call("T_ADD", &["IN1", "IN2"], &[]), Calculation("ADD")),
    function(&["T_Sub"], Call("T_SUB", &["IN1", "IN2"], &[]), Calculation("SUB")),
    function(&["T_Diff"], Call("T_DIFF", &["IN1", "IN2"], &[]), Never),
    function(&["T_Combine"], Call("T_COMBINE", &["IN1", "IN2"], &[]), Never),
    function(&["Max_Len"], Call("MAX_LEN", &["IN"], &[]), Never),
    function(&["Time_Tck"], Call("TIME_TCK", &[], &[]), Never),
    function(&["Runtime"], Call("RUNTIME", &["MEM"], &[]), Never),
    function(&["Lower_Bound"], Call("LOWER_BOUND", &["ARR", "DIM"], &[]), Never),
    function(&["Upper_Bound"], Call("UPPER_BOUND", &["ARR", "DIM"], &[]), Never),
    function(&["Len"], Call("LEN", &["IN"], &[]), Never),
    function(&["Left"], Call("LEFT", &["IN", "L"], &[]), Condition("TEXT")),
    function(&["Right"], Call("RIGHT", &["IN", "L"], &[]), Condition("TEXT")),
    function(&["Mid"], Call("MID", &["IN", "L", "P"], &[]), Condition("TEXT")),
    function(&["Concat"], Call("CONCAT", &["IN*"], &[]), Condition("TEXT")),
    function(&["Find"], Call("FIND", &["IN1", "IN2"], &[]), Never),
    function(&["Delete"], Call("DELETE", &["IN", "L", "P"], &[]), Condition("TEXT")),
    function(&["Insert"], Call("INSERT", &["IN1", "IN2", "P"], &[]), Condition("TEXT")),
    function(&["Replace"], Call("REPLACE", &["IN1", "IN2", "L", "P"], &[]), Condition("TEXT")),
    row(&["MoveBlockI", "Move_Blk"], Law::Statement("MOVE_BLK")),
    row(&["MoveBlockU", "UMove_Blk"], Law::Statement("UMOVE_BLK")),
    row(&["FillBlockI", "Fill_Blk"], Law::Statement("FILL_BLK")),
    row(&["FillBlockU", "UFill_Blk"], Law::Statement("UFILL_BLK")),
    row(&["JumpList", "Jmp_List", "Switch"], Law::Refused("use contacts to compare and jump coils to jump")),
    row(
        &[
            "SpCoil", "SP_Coil", "SeCoil", "SE_Coil", "SdCoil", "SD_Coil", "SsCoil", "SS_Coil", "SfCoil", "SF_Coil",
            "S_Pulse", "S_Pext", "S_ODT", "S_ODTS", "S_OffDT",
        ],
        Law::Refused("use an IEC timer: TP, TON, TONR or TOF"),
    ),
    row(
        &["ScCoil", "SC_Coil", "CuCoil", "CU_Coil", "CdCoil", "CD_Coil", "S_CU", "S_CD", "S_CUD"],
        Law::Refused("use an IEC counter: CTU, CTD or CTUD"),
    ),
    row(&["McrA", "McrD", "Mcr", "McrClose", "Opn", "Opni", "Save"], Law::Refused("draw it with contacts and coils")),
];

/// The instruction with this name.
pub(crate) fn named(name: &str) -> Option<&'static Instruction> {
    ROWS.iter().find(|row| row.names.iter().any(|own| own.eq_ignore_ascii_case(name)))
}

/// The name that an element's law uses for a pin with this name in a document.
pub(crate) fn pin_of(law: Option<Law>, pin: &str) -> &str {
    match (law, pin) {
        (Some(Law::Box(Formula::Call("LIMIT", ..), _)), "MIN") => "MN",
        (Some(Law::Box(Formula::Call("LIMIT", ..), _)), "MAX") => "MX",
        (Some(Law::Demultiplex), "OUTELSE") => "ELSE",
        (Some(Law::FlipFlop(true)), "R1") => "R",
        (Some(Law::FlipFlop(false)), "S1") => "S",
        (Some(Law::Contact(_) | Law::Coil(_) | Law::Set(_)), "IN_OUT") => "OPERAND",
        (Some(Law::Box(Formula::Step(_), _)), "IN_OUT" | "IN") => "OPERAND",
        _ => pin,
    }
}
