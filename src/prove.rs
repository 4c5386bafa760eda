//! `cncbf verify MODEL --prove BOX`: the deterministic certificate of the CBF condition on a box.

use std::ops::ControlFlow;

use barrier::{Kernel, Model};
use node_runtime::{Clock, RealClock, Shutdown};
use verification::affine::{AffineRecord, AffineSettings, Outcome, certify};

use crate::cli::VerifyArgs;
use crate::progress::Bar;

/// Searches for `--minutes`, and goes on with what an earlier search of the same question left.
pub(crate) fn prove(args: &VerifyArgs, model: &Model) -> anyhow::Result<Option<AffineRecord>> {
    let Some(region) = args.prove else { return Ok(None) };
    let settings = AffineSettings::new(region, args.alpha, args.epsilon);
    let checkpoint = crate::common::beside(&args.model, "proof");
    let shutdown = Shutdown::install()?;
    let start_ns = RealClock.now_ns();
    let bar = Bar::new("proof", 10_000);
    let record = certify(model, Kernel::detect(), &settings, Some(&checkpoint), &mut |progress| {
        let elapsed_s = (RealClock.now_ns() - start_ns) as f64 * 1e-9;
        bar.set((progress.settled_share * 1e4) as u64, || {
            format!(
                "{} boxes, {} open, C >= -{:.3} m/s so far, {:.1} of {:.1} min",
                progress.boxes,
                progress.open_boxes,
                progress.provable_epsilon_mps,
                elapsed_s / 60.0,
                args.minutes
            )
        });
        if shutdown.requested() || elapsed_s > args.minutes * 60.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })?;
    bar.finish();
    match record.outcome {
        Outcome::Undecided => eprintln!("the same command goes on from {}", checkpoint.display()),
        Outcome::Proven | Outcome::Refuted => crate::common::remove_if_there(&checkpoint)?,
    }
    Ok(Some(record))
}
