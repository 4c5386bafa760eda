//! Hamilton-Jacobi-Isaacs variational inequality on grids.
