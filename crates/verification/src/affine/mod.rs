//! The deterministic ε-certificate: affine arithmetic with branch and bound on a named box.
