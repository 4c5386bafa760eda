//! One validated settings file for every process and offline tool.
