//! `cncbf inspect`: what a model, a value function or a recording contains.

use anyhow::Context;
use barrier::Model;
use messages::{NominalCommand, SafeCommand};
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
    if args.json {
        println!("{}", serde_json::to_string_pretty(&contents)?);
        return Ok(true);
    }
    println!("{name}: {kind}");
    match kind {
        "recording" => recorded(&contents).iter().for_each(|line| println!("{line}")),
        _ => println!("{}", serde_json::to_string_pretty(&contents)?),
    }
    Ok(true)
}

/// What a recording holds, in lines of text.
fn recorded(contents: &serde_json::Value) -> Vec<String> {
    let text = |value: &serde_json::Value| value.as_str().unwrap_or("?").to_owned();
    let rows = |key: &str| contents[key].as_array().map_or(&[][..], Vec::as_slice);
    let seconds = contents["duration_s"].as_f64().unwrap_or(0.0);
    let mut lines = vec![format!("{} messages in {seconds:.1} s", contents["messages"])];
    lines.extend(rows("channels").iter().map(|channel| {
        let unreadable = if channel["is_readable"] == true { "" } else { ", which nothing here reads" };
        format!(
            "{:>9}  {}  {} ({}){unreadable}",
            channel["messages"].as_u64().unwrap_or(0),
            text(&channel["topic"]),
            text(&channel["type"]),
            text(&channel["encoding"])
        )
    }));
    lines.extend(who_commanded(contents));
    lines.extend(rows("damage").iter().map(|damage| format!("damage: {}", text(damage))));
    lines
}

/// One line for each entry of `commanded_by`, if the contents have any.
fn who_commanded(contents: &serde_json::Value) -> Vec<String> {
    let entries = contents.get("commanded_by").and_then(serde_json::Value::as_array);
    let number = |entry: &serde_json::Value, key: &str| entry[key].as_f64().unwrap_or(f64::NAN);
    let line = |entry: &serde_json::Value| {
        let gap_ms = number(entry, "nobody_before_s") * 1e3;
        let gap =
            if gap_ms > 0.0 { format!(", after {gap_ms:.0} ms without a command") } else { String::new() };
        format!(
            "commanded by {} from {:.2} to {:.2} s, {} commands{gap}",
            entry["controller"].as_str().unwrap_or("?"),
            number(entry, "from_s"),
            number(entry, "to_s"),
            entry["commands"]
        )
    };
    entries.into_iter().flatten().map(line).collect()
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
    // The same beginning as that of verdicts and reports.
    let first_command = read_wire::<SafeCommand>(&args.file).unwrap_or_default().into_iter().next();
    let began_ns = first_command.map(|(_, command)| command.ledger.filter_woke_ns);
    let first_ns = began_ns.or(summary.log_span_ns.map(|(first_ns, _)| first_ns)).unwrap_or(0);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_commanded_is_a_line_each_with_the_gap_before() {
        let contents = serde_json::json!({ "commanded_by": [
            { "controller": "mpc", "from_s": 0.5, "to_s": 3.25, "commands": 56, "nobody_before_s": 0.0 },
            { "controller": "external 1000", "from_s": 3.31, "to_s": 9.0, "commands": 114, "nobody_before_s": 0.0604 },
        ] });
        assert_eq!(
            who_commanded(&contents),
            [
                "commanded by mpc from 0.50 to 3.25 s, 56 commands",
                "commanded by external 1000 from 3.31 to 9.00 s, 114 commands, after 60 ms without a command",
            ]
        );
        assert!(who_commanded(&serde_json::json!({ "hash": 7 })).is_empty());
    }

    #[test]
    fn a_recording_is_told_in_lines_of_text() {
        let channel = |topic: &str, is_readable: bool| serde_json::json!({ "topic": topic, "type": "a/B", "encoding": "cdr", "messages": 7, "is_readable": is_readable });
        let contents = serde_json::json!({
            "messages": 14, "duration_s": 2.04, "channels": [channel("/odom", true), channel("/scan", false)],
            "commanded_by": [], "damage": ["one chunk is missing"],
        });
        assert_eq!(
            recorded(&contents),
            [
                "14 messages in 2.0 s",
                "        7  /odom  a/B (cdr)",
                "        7  /scan  a/B (cdr), which nothing here reads",
                "damage: one chunk is missing",
            ]
        );
    }
}
