//! One closed loop from start to goal, contact or timeout, and what came of it.

use cbf_filter::FilterSetupError;
use crowd_sim::WorldError;
use node_runtime::UsageMeter;
use perception_bridge::{SimulatedCrowd, SimulationError};

use crate::baseline::BaselineError;
use crate::cause::{Cause, Investigator};
use crate::row::Row;
use crate::scenario::Scenario;
use crate::tally::Tally;
use crate::variant::{Mind, Variant};
use crate::virtual_stack::{SetupError, VirtualStack};
use crate::watched::Watched;

/// Why a run could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The world cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The scenario cannot be simulated.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A process refuses its settings.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The filter that causes are told by refuses its settings.
    #[error(transparent)]
    Filter(#[from] FilterSetupError),
    /// A method refuses its settings.
    #[error(transparent)]
    Baseline(#[from] BaselineError),
}

/// Runs `variant` in `scenario`; `None` if `stop` came true on the way. `build_hash` tells the program's build.
///
/// The run ends when the goal is reached, when the discs of robot and a person overlap by 5 cm, or at the settings'
/// timeout. Apart from the last columns ([`Row::without_times`]) the row depends on nothing but the arguments.
///
/// # Errors
/// [`RunError`] if world, stack or method cannot be set up.
pub fn run(
    scenario: &Scenario,
    variant: &Variant,
    build_hash: &str,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Row>, RunError> {
    let mut usage = UsageMeter::new();
    let settings = scenario.applied_to(&variant.settings);
    let world = scenario.world(&settings)?;
    let crowd = SimulatedCrowd::in_scenario(&settings, &world, variant.obedience())?;
    let source = Box::new(Watched::new(&settings, &world, crowd));
    let mut stack = match &variant.mind {
        Mind::Filter | Mind::Nobody => VirtualStack::new(&settings, &variant.model, source)?,
        Mind::Baseline(baseline) => {
            VirtualStack::with_method(&settings, source, baseline.seat(&settings, &variant.model)?)?
        }
    };
    stack.start_timing();
    let mut tally = Tally::new(&settings.robot);
    let mut investigator = Investigator::new(&settings, &variant.model, variant.mind != Mind::Nobody);
    let mut causes: [Option<Cause>; 2] = [None; 2];
    while let Some(command) = stack.cycle(&mut |_, _| {}) {
        let now_ns = command.ledger.filter_woke_ns;
        tally.note(&command, now_ns);
        investigator.note(&command, stack.robot_state(), stack.obstacles(), now_ns);
        for (cause, contact) in causes.iter_mut().zip(stack.source().contacts()) {
            if let (None, Some(contact)) = (*cause, contact) {
                *cause = Some(investigator.cause(contact, stack.source())?);
            }
        }
        if causes[1].is_some() || stack.source().world().reached() {
            break;
        }
        if tally.cycles.is_multiple_of(256) && stop() {
            return Ok(None);
        }
    }
    let cpu_s = usage.since_last().cpu_ns as f64 * 1e-9;
    Ok(Some(row(scenario, variant, build_hash, &stack, &tally, causes, cpu_s)))
}

fn row(
    scenario: &Scenario,
    variant: &Variant,
    build_hash: &str,
    stack: &VirtualStack<Watched>,
    tally: &Tally,
    causes: [Option<Cause>; 2],
    cpu_s: f64,
) -> Row {
    let watched = stack.source();
    let (world, ledger) = (watched.world(), watched.world().ledger());
    let reached_ns = ledger.reached_at_ns();
    // Contact in the very step that reaches the goal still counts.
    let contact_s = watched
        .contacts()
        .map(|contact| contact.map(|contact| contact.time_ns))
        .map(|time_ns| time_ns.map(|time_ns| time_ns as f64 * 1e-9));
    let [collision, collision_smaller] = contact_s.map(|time_s| time_s.is_some());
    let name = |cause: Option<Cause>| cause.map_or_else(String::new, |cause| cause.name().to_owned());
    let [turn_rate_exceeded_share, acceleration_exceeded_share, bounds_exceeded_share] =
        watched.shares().shares();
    let (tick_us, nominal_us) = (stack.stopwatch().tick_us(), stack.stopwatch().nominal_us());
    let share = |cycles: u64| cycles as f64 / tally.cycles.max(1) as f64;
    let filtered = variant.mind != Mind::Nobody;
    Row {
        robot: variant.robot.name().to_owned(),
        people: scenario.people,
        scenario: scenario.name.clone(),
        method: variant.name.clone(),
        seed: scenario.seed,
        settings_hash: variant.settings_hash.clone(),
        scenario_hash: scenario.hash(),
        build_hash: build_hash.to_owned(),
        kernel: stack.kernel().name().to_owned(),
        success: reached_ns.is_some() && !collision,
        success_smaller: reached_ns.is_some() && !collision_smaller,
        collision,
        collision_smaller,
        timeout: reached_ns.is_none() && !collision_smaller,
        contact_s: contact_s[0],
        contact_smaller_s: contact_s[1],
        cause: name(causes[0]),
        cause_smaller: name(causes[1]),
        min_distance_m: Some(ledger.min_clearance_m()).filter(|distance_m| distance_m.is_finite()),
        path_length_m: ledger.path_length_m(),
        time_s: reached_ns.unwrap_or(world.time_ns()) as f64 * 1e-9,
        cycles: tally.cycles,
        // What a filter that nobody obeys would have done is no figure of the method.
        interventions: if filtered { tally.interventions } else { 0 },
        intervention_share: if filtered { share(tally.intervening_cycles) } else { 0.0 },
        slack_cycles: if filtered { tally.slack_cycles } else { 0 },
        max_slack: if filtered { tally.max_slack } else { 0.0 },
        min_hard_margin: tally.min_hard_margin().filter(|_| filtered),
        braking_cycles: tally.braking_cycles,
        turn_rate_exceeded_share,
        acceleration_exceeded_share,
        bounds_exceeded_share,
        tick_median_us: tick_us.map(|us| us[0]),
        tick_p99_us: tick_us.map(|us| us[1]),
        nominal_median_us: nominal_us.map(|us| us[0]),
        nominal_p99_us: nominal_us.map(|us| us[1]),
        cpu_s: Some(cpu_s),
    }
}
