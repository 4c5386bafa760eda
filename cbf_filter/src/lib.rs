//! Process 4: the composite neural CBF filter.
