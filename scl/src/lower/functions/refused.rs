//! Built-in functions that are rejected by name, with reasons.

/// Functions on VARIANT, which is not supported.
const VARIANTS: &[&str] = &["VARIANTGET", "VARIANTPUT", "TYPEOF", "TYPEOFELEMENTS", "IS_ARRAY"];

const NOT_SUPPORTED: &str = "is not supported";

/// Rejected functions: names (a trailing `*` matches any ending), reason, remedy. The first match wins.
const REFUSED: [(&[&str], &str, &str); 9] = [
    (VARIANTS, NOT_SUPPORTED, "write the block once for each type it is called with, or use ARRAY[*]"),
    (
        &["SERIALIZE", "DESERIALIZE"],
        NOT_SUPPORTED,
        "assign the variables themselves, or access their bytes as slices .%B0, .%B1 or through AT",
    ),
    (&["DEMUX"], NOT_SUPPORTED, "use CASE to write the output selected by K"),
    (&["FILL"], NOT_SUPPORTED, "use FILL_BLK with the first element of the array"),
    (
        &["GET_ERROR", "GET_ERR_ID", "GET_ERROR_ID"],
        NOT_SUPPORTED,
        "remove the call, and check indices before using them: an error such as an index outside an array \
         stops the FMU, which reports file and line",
    ),
    // Memory addresses and pointers.
    (
        &[
            "REF",
            "PEEK",
            "PEEK_BOOL",
            "PEEK_WORD",
            "PEEK_DWORD",
            "POKE",
            "POKE_BLK",
            "POKE_BOOL",
            "READ_DBL",
            "WRIT_DBL",
            "CREATE_DB",
            "READ_BIG",
            "READ_LITTLE",
            "WRITE_BIG",
            "WRITE_LITTLE",
        ],
        NOT_SUPPORTED,
        "assign the variables themselves",
    ),
    // Not implemented yet.
    (
        &[
            "T_COMP",
            "FILTER_PT1",
            "FILTER_PT2",
            "FILTER_DT1",
            "FILTER_UNIVERSAL",
            "LEAD_LAG",
            "QRY_CINT",
            "S_COMP",
            "JOIN",
            "SPLIT",
            "ATH",
            "HTA",
            "WR_SYS_T",
            "WR_LOC_T",
            "SET_TIMEZONE",
            "SCATTER_BLK",
            "GATHER_BLK",
            "PARITY",
            "SEG",
            "LTD",
            "CALCULATE",
            "RD_SINFO",
            "TIME_TO_S5TIME",
        ],
        NOT_SUPPORTED,
        "compute it outside the program and pass it in through an input",
    ),
    (
        &[
            "T_CONFIG*",
            "TSEND*",
            "TRCV*",
            "TCON*",
            "TDISCON*",
            "TURCV*",
            "TUSEND*",
            "T_RESET*",
            "T_DIAG*",
            "TMAIL*",
            "MB_*",
            "MODBUS*",
            "PUT",
            "GET",
            "MC_*",
            "RDREC*",
            "WRREC*",
            "DPRD_DAT*",
            "DPWR_DAT*",
            "STP",
            "GETIO*",
            "SETIO*",
            "RALRM*",
            "D_ACT_DP*",
            "LED",
            "MODULESTATES*",
            "DEVICE*",
            "SET_CINT*",
            "ATTACH*",
            "DETACH*",
            "DATALOG*",
            "FILE*",
            "PROGRAM_ALARM*",
            "GEN_*",
            "CTRL_HSC*",
            "CTRL_PWM*",
            "P2P",
            "SEND_P2P*",
            "RECEIVE_P2P*",
            "P_SND_RK*",
            "P_RCV_RK*",
            "P_SEND*",
            "P_RCV*",
            "OPC_UA_*",
            "RECIPEEXPORT*",
            "RECIPEIMPORT*",
            "GET_ALARM*",
            "ACK_ALARMS*",
            "WAIT*",
            "INIT_RD*",
            "ATTR_DB*",
            "DELETE_DB*",
            "GETBLOCKNAME*",
            "GETSYMBOL*",
            "GETINSTANCE*",
            "SI_CLASSIC*",
        ],
        "accesses the PLC's hardware or system",
        "supply its values through inputs",
    ),
    (
        &["S_ODT", "S_ODTS", "S_OFFDT", "S_PULSE", "S_PEXT", "S_CU", "S_CD", "S_CUD"],
        NOT_SUPPORTED,
        "instead of S5 timers, use TON, TOF or TP; instead of S5 counters, CTU, CTD or CTUD",
    ),
];

/// Prefixes that are also common in the names of users' own blocks.
const ORDINARY: [&str; 13] =
    ["CALCULATE", "DEVICE", "FILE", "FILL", "GEN_", "GET", "JOIN", "LED", "PUT", "SEG", "SPLIT", "STP", "WAIT"];

/// Whether a quoted name is more likely a user's block than a built-in function.
pub(crate) fn is_ordinary(name: &str) -> bool {
    ORDINARY.iter().any(|word| name.starts_with(word))
}

/// Whether this is a VARIANT function. No stub can replace it: its value depends on the type of its argument.
pub(crate) fn is_of_variants(name: &str) -> bool {
    VARIANTS.contains(&name)
}

/// The reason a function or type is rejected, and the remedy; `None` if the name is not listed.
pub(crate) fn refused(name: &str) -> Option<(String, String)> {
    if name.starts_with("PID_") {
        let available = crate::library::natives().join(", ");
        let help = format!("its control law is not published; use one of {available}");
        return Some((format!("{name} {NOT_SUPPORTED}"), help));
    }
    let is_it = |pattern: &&str| match pattern.strip_suffix('*') {
        Some(beginning) => name.starts_with(beginning),
        None => name == *pattern,
    };
    let (_, reason, help) = REFUSED.iter().find(|(names, ..)| names.iter().any(is_it))?;
    Some((format!("{name} {reason}"), help.to_string()))
}
