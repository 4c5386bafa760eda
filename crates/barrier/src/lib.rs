//! Model file, network and gradient, composite CBF and CBF-QP.
