//! What a run is judged by: its verdict, its report, its picture, and the reasons behind one moment.
//!
//! Nearly everything here is a pure function of a [`RunRecord`], the messages of one run in memory:
//!
//! * [`Verdict::of`] – did it arrive, did it touch anybody, how often did the filter step in; JSON and terminal text.
//! * [`html`] – one self-contained page with figures, plots and a playback seen from above.
//! * [`birds_eye_svg`] – one moment seen from above, as a picture.
//! * [`commanders`] – which nominal controller commanded when.
//! * [`Comparison`] – two runs of the same world side by side; JSON and terminal text.
//! * [`explain`] – what the filter did at one time, and because of which obstacle; JSON and terminal text.
//! * [`trace_zero_levels`] – the set h = 0 in the world frame, from barrier values that the caller computes.
//! * [`profile_html`] – one self-contained page about where time goes, from the figures of crate `latency`.
//! * [`evaluation_html`] – one self-contained page about many runs, from tables and figures that the caller makes; [`density_svg`]
//!   draws one such figure.
//! * [`model_figure_svg`] – slices of a value function and of the barrier that learned it, from values the caller samples.
//!
//! What is deliberately absent: the barrier itself (its values come in through a callback), files, ports, clocks.
//!
//! # Time
//! Messages carry the stack clock, ns. Here `…_s` counts seconds since the run began, see [`RunRecord::start_ns`].

mod birds_eye;
mod commanders;
mod comparison;
mod density;
mod display;
mod evaluation;
mod explain;
mod explain_display;
mod finite;
mod html;
mod intervention;
mod level_set;
mod model_figure;
mod playback;
mod plot;
mod profile;
mod record;
mod shadow;
mod spans;
mod theme;
mod verdict;
mod verdict_display;
mod words;
mod zero_level;

pub use birds_eye::birds_eye_svg;
pub use commanders::{Segment, commanders, controller_name};
pub use comparison::{Comparison, Contender};
pub use density::{Bounded, DensityFigure, DensitySeries, density_svg};
pub use evaluation::{EvaluationPage, EvaluationTable, evaluation_html};
pub use explain::{
    BarrierTerms, Constraint, CriticalObstacle, ExplainError, Explanation, InputAges, Neighbour, explain,
};
pub use html::{HtmlError, html};
pub use intervention::{INTERVENTION_TOLERANCE, Interventions};
pub use model_figure::{ModelFigure, ModelSlice, model_figure_svg};
pub use plot::PlotError;
pub use profile::{ProfilePage, profile_html};
pub use record::{Moment, RunRecord};
pub use shadow::Shadow;
pub use spans::{Rung, Span};
pub use verdict::{Outcome, TimeShares, Verdict};
pub use zero_level::{BarrierGrid, GridError, ZeroLevel, trace_zero_levels};
