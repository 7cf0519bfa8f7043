//! ABB function blocks.

mod hlg;

vendor!(hlg::Hlg);
