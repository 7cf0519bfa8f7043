//! The runs and characteristics shown in the documentation of CONT_C.

use crate::table::{Characteristic, Response};

pub(super) const RESPONSES: &[Response] = &[
    Response {
        title: "P, I and D action after a setpoint step to 5, TD = 1 s",
        calls: 60,
        set: &[(0, "MAN_ON", 0.0), (0, "D_SEL", 1.0), (0, "TD", 1.0), (5, "SP_INT", 5.0), (40, "SP_INT", 0.0)],
        show: &["SP_INT", "LMN", "LMN_P", "LMN_I", "LMN_D"],
    },
    Response {
        title: "P action alone: LMN is GAIN times the error",
        calls: 60,
        set: &[(0, "MAN_ON", 0.0), (0, "I_SEL", 0.0), (5, "SP_INT", 10.0), (25, "SP_INT", 20.0), (45, "SP_INT", 0.0)],
        show: &["SP_INT", "LMN"],
    },
    Response {
        title: "P and I action: LMN_I grows by LMN_P in every TI, and holds when the error is gone",
        calls: 60,
        set: &[(0, "MAN_ON", 0.0), (5, "SP_INT", 10.0), (45, "SP_INT", 0.0)],
        show: &["SP_INT", "LMN", "LMN_P", "LMN_I"],
    },
    Response {
        title: "GAIN rises from 1 to 2: LMN_P doubles at once, LMN_I grows twice as fast, LMN_D kicks once",
        calls: 60,
        set: &[
            (0, "MAN_ON", 0.0),
            (0, "D_SEL", 1.0),
            (0, "TD", 5.0),
            (0, "GAIN", 1.0),
            (5, "SP_INT", 10.0),
            (30, "GAIN", 2.0),
        ],
        show: &["GAIN", "LMN_P", "LMN_I", "LMN_D"],
    },
    Response {
        title: "At a limit, LMN_I stops; LMN leaves the limit in the call in which the error changes sign",
        calls: 80,
        set: &[(0, "MAN_ON", 0.0), (0, "D_SEL", 1.0), (0, "TD", 1.0), (5, "SP_INT", 40.0), (40, "SP_INT", -5.0)],
        show: &["SP_INT", "LMN", "LMN_P", "LMN_I", "LMN_D", "QLMN_HLM", "QLMN_LLM"],
    },
    Response {
        title: "MAN_ON falls: LMN continues without a jump, because LMN_I is already MAN - LMN_P",
        calls: 60,
        set: &[(0, "MAN", 40.0), (0, "SP_INT", 5.0), (20, "MAN_ON", 0.0)],
        show: &["LMN", "LMN_P", "LMN_I", "MAN_ON"],
    },
    Response {
        title: "MAN jumps in the last manual call: LMN returns to 40; when MAN_ON rises, it jumps to MAN",
        calls: 60,
        set: &[(0, "MAN", 40.0), (0, "SP_INT", 5.0), (19, "MAN", 60.0), (20, "MAN_ON", 0.0), (40, "MAN_ON", 1.0)],
        show: &["MAN", "LMN", "LMN_I", "MAN_ON"],
    },
    Response {
        title: "INT_HOLD stops LMN_I, I_ITL_ON sets it to I_ITLVAL = 40",
        calls: 60,
        set: &[
            (0, "MAN_ON", 0.0),
            (0, "SP_INT", 5.0),
            (0, "I_ITLVAL", 40.0),
            (15, "INT_HOLD", 1.0),
            (30, "INT_HOLD", 0.0),
            (45, "I_ITL_ON", 1.0),
            (50, "I_ITL_ON", 0.0),
        ],
        show: &["LMN", "LMN_I", "INT_HOLD", "I_ITL_ON"],
    },
    Response {
        title: "DEADB_W = 2: a difference of 2 gives an error of 0, one of 5 an error of 3",
        calls: 60,
        set: &[
            (0, "DEADB_W", 2.0),
            (5, "SP_INT", 1.0),
            (15, "SP_INT", 2.0),
            (25, "SP_INT", 5.0),
            (40, "SP_INT", -5.0),
            (50, "SP_INT", 0.0),
        ],
        show: &["SP_INT", "ER"],
    },
    Response {
        title: "LMN_PER is 27648 at 100 % and wraps beyond 118.5 %",
        calls: 60,
        set: &[
            (0, "LMN_HLM", 200.0),
            (0, "LMN_LLM", -200.0),
            (0, "MAN", 50.0),
            (10, "MAN", 100.0),
            (20, "MAN", 118.0),
            (30, "MAN", 120.0),
            (40, "MAN", 150.0),
            (50, "MAN", -120.0),
        ],
        show: &["LMN", "LMN_PER"],
    },
];

pub(super) const CHARACTERISTICS: &[Characteristic] = &[
    Characteristic {
        title: "DEADB_W = 10: ER is 0 up to a difference of 10 and rises from 0 beyond it",
        variable: "SP_INT",
        range: (-50.0, 50.0),
        points: 101,
        calls: 1,
        set: &[("DEADB_W", 10.0)],
        show: &["ER"],
    },
    Characteristic {
        title: "Limits of 0 and 80 act before LMN_FAC = 0.5 and LMN_OFF = 10: LMN goes from 10 to 50",
        variable: "MAN",
        range: (-50.0, 150.0),
        points: 201,
        calls: 1,
        set: &[("LMN_HLM", 80.0), ("LMN_FAC", 0.5), ("LMN_OFF", 10.0)],
        show: &["LMN"],
    },
    Characteristic {
        title: "LMN_PER wraps to the other sign beyond 118.5 %",
        variable: "MAN",
        range: (-150.0, 150.0),
        points: 601,
        calls: 1,
        set: &[("LMN_HLM", 200.0), ("LMN_LLM", -200.0)],
        show: &["LMN_PER"],
    },
];
