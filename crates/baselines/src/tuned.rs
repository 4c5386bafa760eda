//! What a grid search found for each method. Not here: the search and its table (crate `evaluation`: example `tune`, folder
//! `tuning/`, and the test that holds these values against the table).

use crate::setup::{MethodKind, MethodParameters};

impl MethodParameters {
    /// The method with the winner of a grid search that gives every method, CN-CBF included, equally many settings, the
    /// same scenarios and one criterion: most successes among the settings that are fast enough. What is not named here is
    /// as [published](Self::published).
    pub fn tuned(kind: MethodKind) -> Self {
        let mut tuned = Self::published(kind);
        match &mut tuned {
            Self::SdfMpc(planner) => planner.sight.margin_m = 0.3,
            Self::DcbfMpc(dcbf) => {
                dcbf.planner.sight.margin_m = 0.3;
                dcbf.gamma = 0.5;
            }
            Self::VoMpc(planner) => {
                planner.sight.margin_m = 0.3;
                planner.horizon_steps = 10;
            }
            Self::RntcMpc(rntc) => {
                rntc.planner.sight.margin_m = 0.3;
                rntc.terminal_margin_m = 0.1;
            }
            Self::C3bf(c3bf) => {
                c3bf.filter.sight.margin_m = 0.2;
                c3bf.k_per_s = 12.0;
            }
            Self::HoCbf(ho_cbf) => {
                ho_cbf.filter.sight.margin_m = 0.2;
                ho_cbf.k1_per_s = 5.0;
                ho_cbf.k2_per_s = 4.0;
            }
        }
        tuned
    }
}
