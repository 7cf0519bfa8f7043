//! From a probability to the value of a distribution, with the same bits on every platform.
