//! Which samples the distributions have: a function of the seed, the axis and the number of the sample alone.
