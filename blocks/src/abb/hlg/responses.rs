//! The runs and characteristics shown in the documentation of HLG.

use crate::table::Response;

pub(super) const RESPONSES: &[Response] = &[
    Response {
        title: "Up to 1000 in 40 calls, with a stop of 10 calls; down to -500 at 500 per 20 calls; reset",
        calls: 140,
        set: &[
            (0, "TH_TZ", 40.0),
            (0, "TR_TZ", 20.0),
            (0, "S1", -500.0),
            (5, "S0", 1000.0),
            (25, "STOP", 1.0),
            (35, "STOP", 0.0),
            (60, "E01", 1.0),
            (130, "R", 1.0),
        ],
        show: &["HLG", "STOP", "E01", "R"],
    },
    Response {
        title: "SET to 600, then down to setpoint 500 in 2 steps of 50; setpoint 0 holds the output",
        calls: 60,
        set: &[
            (0, "S0", 500.0),
            (0, "TH_TZ", 20.0),
            (0, "TR_TZ", 10.0),
            (0, "INIT", 600.0),
            (15, "SET", 1.0),
            (25, "SET", 0.0),
            (40, "S0", 0.0),
        ],
        show: &["HLG", "SET"],
    },
    Response {
        title: "10 in 4 calls: 2, 5, 7, 10, because the remainder of the division is carried over; with TR_TZ = 0 it jumps \
                back",
        calls: 60,
        set: &[(0, "TH_TZ", 4.0), (0, "S0", 10.0), (0, "S1", -10.0), (20, "E01", 1.0)],
        show: &["HLG", "E01"],
    },
];
