//! The runs and characteristics shown in the documentation of CONT_S.

use crate::table::Response;

pub(super) const RESPONSES: &[Response] = &[
    Response {
        title: "Setpoint 11: a long pulse for the P action, then short ones for the I action; back at 0 the travel of the \
                P action is reversed and that of the I action remains; at -6 the I action moves down",
        calls: 140,
        set: &[(5, "SP_INT", 11.0), (48, "SP_INT", 0.0), (70, "SP_INT", -6.0)],
        show: &["SP_INT", "ER", "QLMNUP", "QLMNDN"],
    },
    Response {
        title: "P action alone (TI = 0, no dead band): an error of 10 opens the valve by 20 %, 6 calls at 3.3 %; half of the \
                error closes it by half of that",
        calls: 60,
        set: &[(0, "TI", 0.0), (0, "DEADB_W", 0.0), (5, "SP_INT", 10.0), (30, "SP_INT", 5.0)],
        show: &["SP_INT", "ER", "QLMNUP", "QLMNDN"],
    },
    Response {
        title: "Manual: LMNUP for 6 calls gives a pulse of 6 calls, LMNDN for one call a pulse of PULSE_TM = 3 s; both \
                together give none",
        calls: 60,
        set: &[
            (0, "LMNS_ON", 1.0),
            (5, "LMNUP", 1.0),
            (11, "LMNUP", 0.0),
            (25, "LMNDN", 1.0),
            (26, "LMNDN", 0.0),
            (40, "LMNUP", 1.0),
            (40, "LMNDN", 1.0),
            (50, "LMNUP", 0.0),
            (50, "LMNDN", 0.0),
        ],
        show: &["LMNUP", "LMNDN", "QLMNUP", "QLMNDN"],
    },
    Response {
        title: "The upper stop ends a pulse at once; moving down remains possible",
        calls: 60,
        set: &[(5, "SP_INT", 40.0), (15, "LMNR_HS", 1.0), (30, "SP_INT", -40.0), (34, "LMNR_HS", 0.0)],
        show: &["ER", "LMNR_HS", "QLMNUP", "QLMNDN"],
    },
];
