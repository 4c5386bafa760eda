//! `cncbf check-controller`: a nominal controller of somebody else's on the test bench.

use controller_kit::Plan;
use node_runtime::RealClock;

use crate::cli::CheckControllerArgs;
use crate::common::{settings_from, someone_watches};
use crate::outcome::print_figures;
use crate::progress::Bar;

/// Checks a candidate. Success means: it keeps every rule.
pub(crate) fn check_controller(args: &CheckControllerArgs) -> anyhow::Result<bool> {
    let settings = settings_from(args.config.as_deref())?;
    let plan = Plan {
        command: &args.command,
        settings: &settings,
        instance: &args.instance,
        patience_s: args.patience,
    };
    let bar = Bar::status();
    let began_ns = node_runtime::Clock::now_ns(&RealClock);
    let findings = controller_kit::check(&plan, &mut |what| {
        let elapsed_s = (node_runtime::Clock::now_ns(&RealClock) - began_ns) as f64 * 1e-9;
        let line = format!("{elapsed_s:5.1} s  {what}");
        if someone_watches() {
            bar.set(0, || line);
        } else {
            eprintln!("{line}");
        }
    })?;
    bar.finish();
    print_figures(&findings, args.json)?;
    Ok(findings.passed)
}
