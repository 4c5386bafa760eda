//! Process 3: the nominal controller, blind to obstacles.
