//! System blocks that need PLC hardware and have documented parameters.

use crate::check::undeclared::Formal;
use crate::front::syntax::key;
use crate::ladder::Way;

/// A system block. A parameter without a type takes the type of its argument. Source: TIA Portal help for each block.
pub(super) struct SystemBlock {
    /// Its name in upper case.
    pub name: &'static str,
    /// Whether it is a function block.
    pub has_instances: bool,
    /// Its inputs: `REQ:Bool DATA`.
    pub inputs: &'static str,
    /// Its outputs, in the same notation.
    pub outputs: &'static str,
    /// The type of its return value; empty if it has none.
    pub value: &'static str,
}

const fn block(name: &'static str, inputs: &'static str, outputs: &'static str) -> SystemBlock {
    SystemBlock { name, has_instances: true, inputs, outputs, value: "" }
}

const fn function(name: &'static str, inputs: &'static str, outputs: &'static str) -> SystemBlock {
    SystemBlock { name, has_instances: false, inputs, outputs, value: "INT" }
}

/// The outputs that most communication blocks have.
const DONE: &str = "DONE:Bool BUSY:Bool ERROR:Bool STATUS:Word";

/// The outputs that most motion control blocks have.
const MOVED: &str = "Done:Bool Busy:Bool CommandAborted:Bool Error:Bool ErrorID:Word";

/// All known system blocks.
pub(super) const BLOCKS: &[SystemBlock] = &[
    // Communication.
    block("TCON", "REQ:Bool ID:Word CONNECT", DONE),
    block("TDISCON", "REQ:Bool ID:Word", DONE),
    block("TSEND", "REQ:Bool ID:Word LEN:UDInt DATA ADDR", DONE),
    block(
        "TRCV",
        "EN_R:Bool ID:Word LEN:UDInt ADHOC:Bool DATA ADDR",
        "NDR:Bool BUSY:Bool ERROR:Bool STATUS:Word RCVD_LEN:UDInt",
    ),
    block("TSEND_C", "REQ:Bool CONT:Bool LEN:UDInt CONNECT DATA ADDR COM_RST:Bool", DONE),
    block(
        "TRCV_C",
        "EN_R:Bool CONT:Bool LEN:UDInt ADHOC:Bool CONNECT DATA ADDR COM_RST:Bool",
        "DONE:Bool BUSY:Bool ERROR:Bool STATUS:Word RCVD_LEN:UDInt",
    ),
    block("TUSEND", "REQ:Bool ID:Word LEN:UDInt DATA ADDR", DONE),
    block("TURCV", "EN_R:Bool ID:Word LEN:UDInt DATA ADDR", "NDR:Bool BUSY:Bool ERROR:Bool STATUS:Word RCVD_LEN:UDInt"),
    block(
        "PUT",
        "REQ:Bool ID:Word ADDR_1 ADDR_2 ADDR_3 ADDR_4 SD_1 SD_2 SD_3 SD_4",
        "DONE:Bool ERROR:Bool STATUS:Word",
    ),
    block("GET", "REQ:Bool ID:Word ADDR_1 ADDR_2 ADDR_3 ADDR_4 RD_1 RD_2 RD_3 RD_4", "NDR:Bool ERROR:Bool STATUS:Word"),
    block(
        "MB_CLIENT",
        "REQ:Bool DISCONNECT:Bool MB_MODE:USInt MB_DATA_ADDR:UDInt MB_DATA_LEN:UInt MB_DATA_PTR CONNECT",
        DONE,
    ),
    block("MB_SERVER", "DISCONNECT:Bool MB_HOLD_REG CONNECT", "NDR:Bool DR:Bool ERROR:Bool STATUS:Word"),
    block("MB_MASTER", "REQ:Bool MB_ADDR:UInt MODE:USInt DATA_ADDR:UDInt DATA_LEN:UInt DATA_PTR", DONE),
    block("MB_COMM_LOAD", "REQ:Bool PORT:UInt BAUD:UDInt PARITY:UInt MB_DB", "DONE:Bool ERROR:Bool STATUS:Word"),
    // Distributed I/O and diagnostics.
    block(
        "RDREC",
        "REQ:Bool ID:Word INDEX:DInt MLEN:UInt RECORD",
        "VALID:Bool BUSY:Bool ERROR:Bool STATUS:DWord LEN:UInt",
    ),
    block("WRREC", "REQ:Bool ID:Word INDEX:DInt LEN:UInt RECORD", "DONE:Bool BUSY:Bool ERROR:Bool STATUS:DWord"),
    function("DPRD_DAT", "LADDR:Word", "RECORD"),
    function("DPWR_DAT", "LADDR:Word RECORD", ""),
    function("LED", "LADDR:Word LED:UInt", ""),
    function("DEVICESTATES", "LADDR:Word MODE:UInt STATE", ""),
    function("MODULESTATES", "LADDR:Word MODE:UInt STATE", ""),
    function("GET_DIAG", "MODE:UInt LADDR:Word DIAG DETAIL", "CNT_DIAG:UInt"),
    function("D_ACT_DP", "REQ:Bool MODE:USInt LADDR:Word", "BUSY:Bool"),
    // Alarms.
    block(
        "PROGRAM_ALARM",
        "SIG:Bool TIMESTAMP SD_1 SD_2 SD_3 SD_4 SD_5 SD_6 SD_7 SD_8 SD_9 SD_10",
        "ERROR:Bool STATUS:Word",
    ),
    // Motion control.
    block(
        "MC_POWER",
        "Axis Enable:Bool StartMode:Int StopMode:Int",
        "Status:Bool Busy:Bool Error:Bool ErrorID:Word ErrorInfo:Word",
    ),
    block("MC_RESET", "Axis Execute:Bool Restart:Bool", MOVED),
    block("MC_HOME", "Axis Execute:Bool Position:LReal Mode:Int", MOVED),
    block("MC_HALT", "Axis Execute:Bool Deceleration:LReal Jerk:LReal AbortAcceleration:Bool", MOVED),
    block(
        "MC_MOVEABSOLUTE",
        "Axis Execute:Bool Position:LReal Velocity:LReal Acceleration:LReal Deceleration:LReal Jerk:LReal Direction:Int",
        MOVED,
    ),
    block(
        "MC_MOVERELATIVE",
        "Axis Execute:Bool Distance:LReal Velocity:LReal Acceleration:LReal Deceleration:LReal Jerk:LReal",
        MOVED,
    ),
    block(
        "MC_MOVEVELOCITY",
        "Axis Execute:Bool Velocity:LReal Acceleration:LReal Deceleration:LReal Jerk:LReal Direction:Int Current:Bool",
        "InVelocity:Bool Busy:Bool CommandAborted:Bool Error:Bool ErrorID:Word",
    ),
    block(
        "MC_MOVEJOG",
        "Axis JogForward:Bool JogBackward:Bool Velocity:LReal Acceleration:LReal Deceleration:LReal Jerk:LReal",
        "InVelocity:Bool Busy:Bool CommandAborted:Bool Error:Bool ErrorID:Word",
    ),
    // Safety: parameters only.
    block("ESTOP1", "E_STOP:Bool ACK_NEC:Bool ACK:Bool TIME_DEL:Time", "Q:Bool Q_DELAY:Bool ACK_REQ:Bool DIAG:Byte"),
    block(
        "SFDOOR",
        "IN1:Bool IN2:Bool QBAD_IN1:Bool QBAD_IN2:Bool OPEN_NEC:Bool ACK_NEC:Bool ACK:Bool",
        "Q:Bool ACK_REQ:Bool DIAG:Byte",
    ),
    block(
        "FDBACK",
        "ON:Bool FEEDBACK:Bool QBAD_FIO:Bool ACK_NEC:Bool ACK:Bool FDB_TIME:Time",
        "Q:Bool ERROR:Bool ACK_REQ:Bool DIAG:Byte",
    ),
    block("ACK_GL", "ACK_GLOB:Bool", ""),
    block(
        "EV1OO2DI",
        "IN1:Bool IN2:Bool DISCTIME:Time ACK_NEC:Bool ACK:Bool",
        "Q:Bool ACK_REQ:Bool DISC_FLT:Bool DIAG:Byte",
    ),
];

fn find(name: &str) -> Option<&'static SystemBlock> {
    let name = key(name);
    BLOCKS.iter().find(|block| block.name == name)
}

/// Whether a name denotes one of these function blocks.
pub(super) fn is_block(name: &str) -> bool {
    find(name).is_some_and(|block| block.has_instances)
}

/// The parameters of a system block; empty if it is unknown.
pub(super) fn formals(name: &str) -> Vec<Formal> {
    let Some(block) = find(name) else { return Vec::new() };
    let list = |texts: &'static str, way| {
        texts.split_whitespace().map(move |text| {
            let (name, of) = text.split_once(':').map_or((text, None), |(name, of)| (name, Some(of.to_string())));
            Formal { name: name.to_string(), way, of }
        })
    };
    list(block.inputs, Way::Input).chain(list(block.outputs, Way::Output)).collect()
}

/// The return type of a system function; `None` if it is unknown or has none.
pub(super) fn value(name: &str) -> Option<&'static str> {
    find(name).map(|block| block.value).filter(|value| !value.is_empty())
}

/// The block name within an instance name that follows TIA Portal's scheme, `TSEND_C` for `TSEND_C_DB_1`; otherwise the
/// name itself.
pub(super) fn without_instance(name: &str) -> String {
    let digits = name.trim_end_matches(|last: char| last.is_ascii_digit());
    let plain = digits.strip_suffix('_').filter(|_| digits.len() < name.len()).unwrap_or(name);
    let endings = ["_DB", "_Instance", "_INSTANCE"];
    let block = endings.iter().find_map(|ending| plain.strip_suffix(ending));
    block.filter(|block| !block.is_empty()).unwrap_or(name).to_string()
}
