//! `cncbf compare`: two nominal controllers in the same world behind the same filter.

use std::time::Duration;

use anyhow::Context;
use controller_kit::Candidate;
use node_runtime::{Clock, Domain, RealClock};
use perception_bridge::{Obedience, Playback, SourceChoice};
use report::{Comparison, Contender};
use settings::{ControllerKind, Settings};

use crate::cli::{CompareArgs, Contestant, Source, World};
use crate::common::settings;
use crate::lockstep::{Play, play};
use crate::outcome::print_figures;
use crate::run::Live;

/// How long a program may take to end after its run.
const FAREWELL: Duration = Duration::from_secs(3);
/// How long a program is given to open its ports before the stack starts.
const HEAD_START: Duration = Duration::from_millis(500);

/// Compares. Success means: both were driven.
pub(crate) fn compare(args: &CompareArgs) -> anyhow::Result<bool> {
    let mut settings = settings(&args.process)?;
    if let World::Simulation(Some(seed)) = args.on {
        settings.simulation.seed = seed;
    }
    let has_program = [&args.first, &args.second].iter().any(|one| matches!(one, Contestant::Command(_)));
    let drive = |one: &Contestant| {
        let settings = settings_for(one, &settings)?;
        if has_program { in_real_time(one, args, &settings) } else { in_lockstep(one, args, &settings) }
    };
    let mode = if has_program { "real time" } else { "lockstep" };
    // Programs first: one that cannot start shall not be found out only after the other's drive.
    let (first, second) =
        if matches!((&args.first, &args.second), (Contestant::Own(_), Contestant::Command(_))) {
            let second = drive(&args.second)?;
            (drive(&args.first)?, second)
        } else {
            (drive(&args.first)?, drive(&args.second)?)
        };
    let comparison = Comparison::new(args.on.to_string(), mode, first, second);
    print_figures(&comparison, args.json)?;
    Ok(true)
}

/// The same settings with another nominal controller.
fn settings_for(one: &Contestant, settings: &Settings) -> anyhow::Result<Settings> {
    let mut settings = settings.clone();
    settings.use_controller(match one {
        Contestant::Own(controller) => controller.kind(),
        Contestant::Command(_) => ControllerKind::External,
    })?;
    Ok(settings)
}

fn in_lockstep(one: &Contestant, args: &CompareArgs, settings: &Settings) -> anyhow::Result<Contender> {
    let plan = Play {
        source: match &args.on {
            World::Recording(file) => {
                SourceChoice::Mcap { file: file.clone(), closed_loop: true, playback: Playback::AS_RECORDED }
            }
            World::Simulation(_) => SourceChoice::Simulation { obeys: Obedience::Filter },
        },
        title: format!("cncbf compare: {one} on {}", args.on),
        record: None,
        rate: None,
        ends_at_goal: true,
        duration_s: args.duration,
    };
    let played = play(&plan, settings)?;
    Ok(Contender {
        commands_sha256: Some(played.commands_sha256),
        ..Contender::of(one.to_string(), &played.record)
    })
}

fn in_real_time(one: &Contestant, args: &CompareArgs, settings: &Settings) -> anyhow::Result<Contender> {
    let mut program = match one {
        Contestant::Own(_) => None,
        Contestant::Command(command) => {
            // The shell makes way for the program, so that a signal reaches it.
            let words = ["sh".into(), "-c".into(), format!("exec {command}").into()];
            let domain = Domain::from_env()?;
            let mut program = Candidate::start(&words, &[(Domain::VARIABLE, domain.prefix().as_ref())])?;
            std::thread::sleep(HEAD_START);
            if let Some(status) = program.ended() {
                let output = program.output();
                let output = output.trim_end();
                anyhow::bail!(
                    "`{one}` ended by itself before the drive ({status}); `cncbf check-controller` says what it lacks{}{output}",
                    if output.is_empty() { "" } else { ". It printed:\n" },
                );
            }
            Some(program)
        }
    };
    let source = match &args.on {
        World::Recording(file) => Source::Mcap(file.clone()),
        World::Simulation(_) => Source::Sim,
    };
    let folder = crate::run_folder::create(None)?;
    eprintln!("driving with {one}");
    let began_ns = RealClock.now_ns();
    let live = Live {
        settings,
        instance: &args.process.instance,
        closed_loop: matches!(source, Source::Mcap(_)),
        source: &source,
        shadow: false,
        duration_s: args.duration,
        record: None,
        report: Some(&folder),
        title: format!("cncbf compare: {one} on {}", args.on),
    };
    let (record, end) = live.drive()?;
    if let Some(program) = &mut program {
        let ended_early = program.ended();
        program.end(FAREWELL);
        let log = folder.join("nominal.log");
        std::fs::write(&log, program.output()).with_context(|| format!("cannot write {}", log.display()))?;
        anyhow::ensure!(
            !record.nominal_commands.is_empty(),
            "`{one}` gave no command in {:.0} s{}; {} holds what it printed, and `cncbf check-controller` says what it lacks",
            (RealClock.now_ns() - began_ns) as f64 * 1e-9,
            ended_early.map_or_else(String::new, |status| format!(" and ended by itself ({status})")),
            log.display()
        );
    }
    anyhow::ensure!(!end.interrupted, "interrupted; there is nothing to compare");
    Ok(Contender::of(one.to_string(), &record))
}
