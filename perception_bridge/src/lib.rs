//! Process 1: sources in, commands out.
