//! The runs and characteristics shown in the documentation of PULS_CTR.

use crate::table::Response;

pub(super) const RESPONSES: &[Response] = &[
    Response {
        title: "The setpoint rises to 10: the controller responds every 20 calls, and LMN sets the length of each \
                    period's pulse",
        calls: 160,
        set: &[(0, "RED_FAC", 20.0), (0, "DI_PULSEGEN.P_B_TM", 0.01), (0, "DI_CONT_C.TI", 0.5), (10, "SP_INT", 10.0)],
        show: &["SP_INT", "DI_CONT_C.LMN", "QPOS_P"],
    },
    Response {
        title: "The setpoint goes from 30 to -60, P action with GAIN 1 and LMN_LLM = -100: the pulses change from QPOS_P \
                    to QNEG_P when the controller has run",
        calls: 160,
        set: &[
            (0, "RED_FAC", 20.0),
            (0, "DI_PULSEGEN.P_B_TM", 0.01),
            (0, "DI_CONT_C.I_SEL", 0.0),
            (0, "DI_CONT_C.GAIN", 1.0),
            (0, "DI_CONT_C.LMN_LLM", -100.0),
            (0, "SP_INT", 30.0),
            (70, "SP_INT", -60.0),
        ],
        show: &["SP_INT", "DI_CONT_C.LMN", "QPOS_P", "DI_PULSEGEN.QNEG_P"],
    },
    Response {
        title: "Periods of 0.2 s with P_B_TM = 0.04 s: LMN below 20 % gives no pulse, LMN above 80 % no break",
        calls: 140,
        set: &[
            (0, "RED_FAC", 20.0),
            (0, "DI_PULSEGEN.P_B_TM", 0.04),
            (0, "DI_CONT_C.MAN_ON", 1.0),
            (0, "DI_CONT_C.MAN", 50.0),
            (30, "DI_CONT_C.MAN", 25.0),
            (50, "DI_CONT_C.MAN", 15.0),
            (70, "DI_CONT_C.MAN", 75.0),
            (90, "DI_CONT_C.MAN", 85.0),
            (110, "DI_CONT_C.MAN", 50.0),
        ],
        show: &["DI_CONT_C.LMN", "QPOS_P"],
    },
];
