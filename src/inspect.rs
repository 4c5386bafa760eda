//! `cncbf inspect`: what a model, a value function or a recording contains.

use anyhow::Context;
use barrier::Model;
use messages::NominalCommand;
use reachability::ValueFunction;
use recording::{McapReader, read_wire};
use report::commanders;

use crate::cli::InspectArgs;

/// Shows the contents. The kind is told by the file itself, not by its name.
pub(crate) fn inspect(args: &InspectArgs) -> anyhow::Result<bool> {
    let name = args.file.display();
    let mut magic = [0; 8];
    let mut file = std::fs::File::open(&args.file).with_context(|| format!("cannot open {name}"))?;
    let is_recording = std::io::Read::read_exact(&mut file, &mut magic).is_ok() && magic[1..5] == *b"MCAP";
    let (kind, contents) = if is_recording {
        ("recording", recording(args)?)
    } else {
        match Model::load(&args.file) {
            Ok(model) => {
                if let Some(output) = &args.plot {
                    crate::inspect_plot::plot(args, &model, output)?;
                    println!("wrote {}", output.display());
                    return Ok(true);
                }
                ("model", serde_json::to_value(model.metadata())?)
            }
            Err(model_error) => match ValueFunction::<4>::load(&args.file) {
                Ok(value) => ("value function", serde_json::to_value(value.metadata())?),
                Err(value_error) => anyhow::bail!(
                    "{name} is no recording, no model ({model_error}) and no value function ({value_error})"
                ),
            },
        }
    };
    anyhow::ensure!(args.plot.is_none(), "{name} is a {kind}; --plot draws models");
    if !args.json {
        println!("{name}: {kind}");
    }
    println!("{}", serde_json::to_string_pretty(&contents)?);
    Ok(true)
}

fn recording(args: &InspectArgs) -> anyhow::Result<serde_json::Value> {
    let reader = McapReader::open(&args.file)?;
    let summary = reader.summary();
    let channels: Vec<_> = summary
        .channels
        .iter()
        .map(|channel| {
            serde_json::json!({
                "topic": channel.topic,
                "type": channel.type_name,
                "encoding": channel.encoding,
                "messages": channel.messages,
                "readable": channel.is_readable,
            })
        })
        .collect();
    // A recording of another robot's ROS 2 graph has none.
    let nominal = read_wire::<NominalCommand>(&args.file).unwrap_or_default();
    let nominal: Vec<_> = nominal.into_iter().map(|(_, command)| command).collect();
    let first_ns = summary.log_span_ns.map_or(0, |(first_ns, _)| first_ns);
    let seconds = |time_ns: u64| time_ns.saturating_sub(first_ns) as f64 * 1e-9;
    let commanded_by: Vec<_> = commanders(&nominal)
        .iter()
        .map(|segment| {
            serde_json::json!({
                "controller": segment.name,
                "from_s": seconds(segment.start_ns),
                "to_s": seconds(segment.end_ns),
                "commands": segment.commands,
                "nobody_before_s": segment.gap_ns as f64 * 1e-9,
            })
        })
        .collect();
    let damage: Vec<_> = summary.damage.iter().map(ToString::to_string).collect();
    Ok(serde_json::json!({
        "profile": summary.profile,
        "written_by": summary.library,
        "duration_s": summary.log_span_ns.map(|(first, last)| (last - first) as f64 * 1e-9),
        "messages": summary.messages,
        "channels": channels,
        "commanded_by": commanded_by,
        "damage": damage,
    }))
}
