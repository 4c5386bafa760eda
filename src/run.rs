//! `cncbf run`: the whole stack on this machine, to its goal, then a verdict and a report.

use std::path::Path;

use anyhow::Context;
use perception_bridge::{Playback, RosSource, simulated_scenario};
use report::{Outcome, RunRecord, Verdict};
use settings::{ControllerKind, Ros2Settings, ScenarioSettings, Settings};

use crate::cli::{RunArgs, Source};
use crate::common::settings;
use crate::outcome::{print_figures, read_record, write_report};
use crate::run_folder;
use crate::session::{SessionEnd, SessionPlan, run_stack};
use crate::silence::unheard;

/// Runs the stack. Success means: the goal was reached and nobody was touched; for a recording, and where the filter only
/// watches, that it was played.
pub(crate) fn run(args: &RunArgs) -> anyhow::Result<bool> {
    let mut settings = settings(&args.process)?;
    if let Some(seed) = args.seed {
        settings.simulation.seed = seed;
    }
    if let Some(controller) = args.controller {
        settings.use_controller(controller.kind())?;
    }
    if let Some(people) = args.people {
        settings.simulation.people = people;
    }
    if let Some(choice) = &args.scenario {
        settings.simulation.scenario = Some(named_scenario(choice)?);
    }
    if args.shadow {
        hear_the_robots_own_commands(&mut settings, args)?;
    }
    let mut title = match &args.source {
        // A scenario that cannot be had is refused here, before five processes refuse it one by one.
        Source::Sim if settings.simulation.scenario.is_some() => {
            let scenario = simulated_scenario(&settings)?;
            format!("cncbf run: {} people, scenario {}", scenario.people.len(), scenario.name)
        }
        Source::Sim => {
            format!("cncbf run: {} people, seed {}", settings.simulation.people, settings.simulation.seed)
        }
        Source::Mcap(_) | Source::Ros2 if args.scenario.is_some() => {
            anyhow::bail!(
                "--scenario says who is simulated, and --source {} has people of its own",
                args.source
            )
        }
        Source::Mcap(file) => format!("cncbf run: {}", file.display()),
        Source::Ros2 => "cncbf run: live ROS 2 graph".to_owned(),
    };
    if args.shadow {
        title.push_str(" (shadow)");
    }
    let live = Live {
        settings: &settings,
        instance: &args.process.instance,
        source: &args.source,
        closed_loop: false,
        shadow: args.shadow,
        duration_s: args.duration,
        record: args.record.as_deref(),
        report: args.report.as_deref(),
        title,
    };
    let (verdict, end) = live.run()?;
    print_figures(&verdict, args.json)?;
    if end.interrupted {
        eprintln!("interrupted; the figures are of what was driven until then");
    }
    Ok(match args.source {
        // A live graph has no end of its own, and a robot with a controller of its own tells no goal.
        Source::Ros2 if args.shadow || has_upstream(&settings) => true,
        Source::Sim | Source::Ros2 if !args.shadow => verdict.outcome == Outcome::Reached,
        Source::Sim | Source::Ros2 | Source::Mcap(_) => !end.interrupted,
    })
}

/// `FILE`, or `FILE:NAME` unless there is a file of that whole name.
fn named_scenario(choice: &Path) -> anyhow::Result<ScenarioSettings> {
    let text = choice.to_string_lossy();
    let (file, name) = match text.rsplit_once(':') {
        Some((file, name)) if !file.is_empty() && !name.is_empty() && !choice.exists() => {
            (Path::new(file), Some(name.to_owned()))
        }
        Some(_) | None => (choice, None),
    };
    let file = std::path::absolute(file).with_context(|| format!("cannot find {}", file.display()))?;
    Ok(ScenarioSettings { file, name })
}

/// Whether the robot's own commands are the nominal ones.
fn has_upstream(settings: &Settings) -> bool {
    settings.source.ros2.as_ref().is_some_and(|ros2| ros2.nominal_topic.is_some())
}

/// Where a live robot drives itself, its commands are the nominal ones, unless the settings name others or the arguments a
/// controller.
fn hear_the_robots_own_commands(settings: &mut Settings, args: &RunArgs) -> anyhow::Result<()> {
    match args.source {
        Source::Sim | Source::Mcap(_) => return Ok(()),
        Source::Ros2 => {}
    }
    let ros2 = settings.source.ros2.get_or_insert_with(Ros2Settings::customary);
    if args.controller.is_some_and(|controller| controller.kind() != ControllerKind::External) {
        ros2.nominal_topic = None;
        return Ok(());
    }
    if ros2.nominal_topic.is_none() && args.controller.is_none() {
        ros2.nominal_topic = Some(ros2.command_topic.clone());
        ros2.nominal = Some(ros2.command);
        settings.use_controller(ControllerKind::External)?;
    }
    Ok(())
}

/// A live stack with everything that comes after it.
pub(crate) struct Live<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) instance: &'a str,
    pub(crate) source: &'a Source,
    pub(crate) closed_loop: bool,
    pub(crate) shadow: bool,
    pub(crate) duration_s: Option<f64>,
    pub(crate) record: Option<&'a std::path::Path>,
    pub(crate) report: Option<&'a std::path::Path>,
    pub(crate) title: String,
}

impl Live<'_> {
    /// Runs the stack to its end, judges it, writes the report.
    pub(crate) fn run(&self) -> anyhow::Result<(Verdict, SessionEnd)> {
        let (record, end) = self.drive()?;
        Ok((Verdict::of(&record), end))
    }

    /// Runs the stack to its end and writes the report; what flowed is read back from the recording.
    pub(crate) fn drive(&self) -> anyhow::Result<(RunRecord, SessionEnd)> {
        // A model that does not fit is refused here, before five processes refuse it one by one.
        let model = cbf_filter::load_model(&self.settings.filter.model)?;
        cbf_filter::SafetyFilter::new(self.settings, &model)?;
        match self.source {
            Source::Sim => {}
            Source::Mcap(file) => {
                recording::McapReader::open(file)?;
            }
            Source::Ros2 => RosSource::check(self.settings, self.shadow)?,
        }
        let folder = run_folder::create(self.report)?;
        let recording = self.record.map_or_else(|| folder.join("run.mcap"), std::path::Path::to_owned);
        let plan = SessionPlan {
            settings: self.settings,
            instance: self.instance,
            source: self.source,
            closed_loop: self.closed_loop,
            shadow: self.shadow,
            playback: Playback::AS_RECORDED,
            env: Vec::new(),
            heading: String::new(),
            recording: recording.clone(),
            folder: &folder,
            duration_s: self.duration_s,
        };
        let end = run_stack(&plan, &mut |_, _| Ok(()))?;
        let record = read_record(&recording, self.settings, self.title.clone());
        let record = if *self.source == Source::Ros2 {
            record.map_err(|error| unheard(error, &recording, self.settings, &folder))?
        } else {
            record?
        };
        write_report(&record, self.settings, &folder)?;
        if end.crashes > 0 {
            eprintln!("{} processes ended unexpectedly; see the logs in {}", end.crashes, folder.display());
        }
        eprintln!("recording  {}", recording.display());
        eprintln!("report     {}", folder.join("report.html").display());
        Ok((record, end))
    }
}
