//! Function blocks of ABB.

mod hlg;

vendor!(hlg::Hlg);
