//! The worst admissible motion of a pair, whatever the numbers of its inputs.

use dynamics::RelativeDynamics;

/// A game of which only the worst-case motion matters; what [`crate::game`] makes of a pair of `dynamics`.
pub trait WorstCase: Send + Sync {
    /// `ζ(z, u*, d*)` with the inputs of `max_u min_d p·ζ`, in state units per second.
    fn flow(&self, z: &[f64; 4], p: &[f64; 4]) -> [f64; 4];
}

/// [`WorstCase`] of relative dynamics with `NU` controls and `ND` disturbances.
struct Game<D, const NU: usize, const ND: usize>(D);

impl<D: RelativeDynamics<4, NU, ND>, const NU: usize, const ND: usize> WorstCase for Game<D, NU, ND> {
    fn flow(&self, z: &[f64; 4], p: &[f64; 4]) -> [f64; 4] {
        let (u, d) = (self.0.optimal_control(z, p), self.0.optimal_disturbance(z, p));
        self.0.flow(z, &u, &d)
    }
}

/// The game of a pair.
pub fn game<const NU: usize, const ND: usize>(
    pair: impl RelativeDynamics<4, NU, ND> + 'static,
) -> Box<dyn WorstCase> {
    Box::new(Game(pair))
}
