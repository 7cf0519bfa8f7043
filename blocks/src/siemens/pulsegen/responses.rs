//! The runs and characteristics shown in the documentation of PULSEGEN.

use crate::table::{Characteristic, Response};

/// The share of a period of 100 calls in which the outputs are TRUE, in steps of 1 %.
const SHARE_OVER_INV: Characteristic = Characteristic {
    title: "",
    variable: "INV",
    range: (-100.0, 100.0),
    points: 201,
    calls: 100,
    set: &[],
    show: &["QPOS_P", "QNEG_P"],
};

pub(super) const RESPONSES: &[Response] = &[
    Response {
        title: "Periods of 20 calls: 30 %, then 75 % and -50 %, which change in mid-period and start a new one, \
                then 4 %, too little for a pulse",
        calls: 160,
        set: &[
            (0, "PER_TM", 0.2),
            (0, "P_B_TM", 0.01),
            (0, "INV", 30.0),
            (50, "INV", 75.0),
            (95, "INV", -50.0),
            (136, "INV", 4.0),
        ],
        show: &["INV", "QPOS_P", "QNEG_P"],
    },
    Response {
        title: "Two-step control, bipolar: at 0 % on for half of the period, at -60 % for a fifth, at 100 % throughout; QNEG_P is \
                the opposite",
        calls: 120,
        set: &[
            (0, "STEP3_ON", 0.0),
            (0, "ST2BI_ON", 1.0),
            (0, "PER_TM", 0.2),
            (0, "P_B_TM", 0.01),
            (40, "INV", -60.0),
            (80, "INV", 100.0),
        ],
        show: &["INV", "QPOS_P", "QNEG_P"],
    },
    Response {
        title: "RATIOFAC = 0.5: 50 % is 10 of 20 calls on QPOS_P, -50 % only 5 on QNEG_P",
        calls: 80,
        set: &[(0, "RATIOFAC", 0.5), (0, "PER_TM", 0.2), (0, "P_B_TM", 0.01), (0, "INV", 50.0), (40, "INV", -50.0)],
        show: &["INV", "QPOS_P", "QNEG_P"],
    },
    Response {
        title: "P_B_TM = 40 ms, 4 calls: 15 % of 20 calls would be 3 and is omitted, 25 % is 5, 85 % would leave a break of 3 \
                and is on throughout",
        calls: 120,
        set: &[(0, "PER_TM", 0.2), (0, "P_B_TM", 0.04), (0, "INV", 15.0), (40, "INV", 25.0), (80, "INV", 85.0)],
        show: &["INV", "QPOS_P", "QNEG_P"],
    },
    Response {
        title: "MAN_ON: the outputs follow POS_P_ON and NEG_P_ON in each call; afterwards a period starts with INV = 30 %",
        calls: 80,
        set: &[
            (0, "PER_TM", 0.2),
            (0, "P_B_TM", 0.01),
            (0, "INV", 30.0),
            (10, "MAN_ON", 1.0),
            (15, "POS_P_ON", 1.0),
            (17, "POS_P_ON", 0.0),
            (25, "NEG_P_ON", 1.0),
            (30, "POS_P_ON", 1.0),
            (35, "POS_P_ON", 0.0),
            (40, "NEG_P_ON", 0.0),
            (45, "MAN_ON", 0.0),
        ],
        show: &["MAN_ON", "POS_P_ON", "NEG_P_ON", "QPOS_P", "QNEG_P"],
    },
];

pub(super) const CHARACTERISTICS: &[Characteristic] = &[
    Characteristic {
        title: "Three-step control: no pulse below P_B_TM, 5 % of the period; no break above 95 %",
        set: &[],
        ..SHARE_OVER_INV
    },
    Characteristic {
        title: "Three-step control, RATIOFAC = 0.5: negative pulses, including the shortest and the longest, are half as long",
        set: &[("RATIOFAC", 0.5)],
        ..SHARE_OVER_INV
    },
    Characteristic {
        title: "Two-step control, bipolar: on for half of the period at 0 %; QNEG_P is the opposite",
        set: &[("STEP3_ON", 0.0), ("ST2BI_ON", 1.0)],
        ..SHARE_OVER_INV
    },
    Characteristic {
        title: "Two-step control, monopolar: off below 0 %; QNEG_P is the opposite",
        set: &[("STEP3_ON", 0.0)],
        ..SHARE_OVER_INV
    },
];
