//! Typed ports over iceoryx2, clocks, the cyclic loop and health.
