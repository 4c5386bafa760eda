//! Robot, obstacle and relative dynamics.
