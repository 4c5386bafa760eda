//! The page's tables and tiles.

use core::fmt::Write as _;

use latency::{
    Change, Comparison, Conditions, Hop, Judged, Latencies, LoopFigures, Outcome, ProfileFigures,
    RepeatFigures, Statistic,
};

use super::rows::{framed, megabytes, microseconds, table, time};
use super::shown;
use crate::display::UNKNOWN;
use crate::html::{escaped, latency_row};

pub(super) fn tiles(figures: &ProfileFigures) -> String {
    let summary = figures.summary();
    let counts = &figures.pooled.counts;
    let of = |hop: Hop| {
        let latency = summary.hop(hop);
        if latency.count == 0 {
            (UNKNOWN.to_owned(), String::new())
        } else {
            let note = format!("p50 {}, largest {}", time(latency.p50_ns), time(latency.max_ns));
            (time(latency.p99_ns), note)
        }
    };
    let loops = &figures.pooled.loops;
    let sum = |pick: fn(&LoopFigures) -> u64| loops.iter().map(pick).sum::<u64>();
    let interruptions = if loops.is_empty() {
        (UNKNOWN.to_owned(), "no cycle records".to_owned())
    } else {
        let faults = sum(|of| of.minor_faults) + sum(|of| of.major_faults);
        let text = format!("{} / {faults}", sum(|of| of.involuntary_switches));
        (text, format!("of {} cycles of all processes", sum(|of| of.cycles)))
    };
    let kept =
        counts.deadlines_kept().map_or_else(|| UNKNOWN.to_owned(), |share| format!("{:.3} %", 100.0 * share));
    let memory =
        figures.resident_bytes().map_or_else(|| UNKNOWN.to_owned(), |bytes| megabytes(bytes) + " MB");
    let tiles = [
        ("Detection to command, p99", of(Hop::EndToEnd)),
        ("Filter compute, p99", of(Hop::FilterCompute)),
        ("Filter lateness, p99", of(Hop::FilterLateness)),
        ("Deadlines kept", (kept, format!("{} missed of {} cycles", counts.deadline_misses, counts.cycles))),
        (
            "Commands lost",
            (
                counts.lost_commands.to_string(),
                format!("{} cycle records lost, {} restarts", sum(|of| of.lost_records), counts.restarts),
            ),
        ),
        ("Pushed off / page faults", interruptions),
        ("Resident memory", (memory, "of all processes together".to_owned())),
        ("Cycles begun by an input", (counts.event_cycles.to_string(), "of the filter".to_owned())),
    ];
    tiles.iter().fold(String::new(), |mut text, (name, (value, note))| {
        let note = if note.is_empty() { "&nbsp;" } else { note };
        let _ = write!(text, "<div class=\"tile\"><dt>{name}</dt><dd>{value}</dd><p>{note}</p></div>");
        text
    })
}

/// What a reader has to know before the figures; nothing where there is nothing to say.
pub(super) fn remarks(warnings: &[String], notes: &[String]) -> String {
    let all = warnings.iter().map(|text| ("worse", text)).chain(notes.iter().map(|text| ("", text)));
    let items = all.fold(String::new(), |mut items, (class, text)| {
        let _ = write!(items, "<li class=\"{class}\">{}</li>", escaped(text));
        items
    });
    if items.is_empty() {
        items
    } else {
        format!("<section class=\"remarks\" aria-label=\"Remarks\"><ul>{items}</ul></section>")
    }
}

pub(super) fn budgets(judged: &[Judged]) -> String {
    if judged.is_empty() {
        return String::new();
    }
    let body = judged.iter().fold(String::new(), |mut text, judged| {
        let (class, word) = match judged.outcome {
            Outcome::Kept => ("better", "kept"),
            Outcome::Unclear => ("", "unclear: beyond the limit, but within what differs between repeats"),
            Outcome::Broken => ("worse", "broken"),
            Outcome::Unmeasured => ("worse", "broken: nothing of it was measured"),
        };
        let (budget, measured) = (escaped(&judged.budget), escaped(&judged.measured));
        let _ = write!(
            text,
            "<tr><th scope=\"row\">{budget}</th><td>{measured}</td><td class=\"{class}\">{word}</td></tr>"
        );
        text
    });
    let head = "<th scope=\"col\">Budget</th><th scope=\"col\">measured</th><th scope=\"col\">outcome</th>";
    format!("<section><h2>Budgets</h2>{}</section>", framed(head, &body))
}

pub(super) fn comparison(comparison: &Comparison) -> String {
    let warning = if comparison.differences.is_empty() {
        String::new()
    } else {
        let items = comparison.differences.iter().fold(String::new(), |mut text, difference| {
            let _ = write!(text, "<li>{}</li>", escaped(&difference.to_string()));
            text
        });
        format!(
            "<p class=\"worse\">Measured under other conditions, so that a change need not be the code's:</p><ul>{items}</ul>"
        )
    };
    let head = shown().fold("<th scope=\"col\">Quantity, µs</th>".to_owned(), |mut text, label| {
        let _ = write!(text, "<th scope=\"col\">{label}</th>");
        text
    });
    let body = comparison.quantities.iter().fold(String::new(), |mut text, of| {
        let _ = write!(text, "<tr><th scope=\"row\">{}</th>", of.quantity);
        for change in of.changes.iter().filter(|change| latency::SHOWN.contains(&change.statistic)) {
            text.push_str(&change_cell(change));
        }
        text.push_str("</tr>");
        text
    });
    let hint = if comparison.has_intervals() {
        format!(
            "Then → now, the change in percent, and in brackets its {:.0} % interval by bootstrap over {} and {} repeats; coloured \
             where the interval excludes zero. From few repeats intervals are too narrow rather than too wide, and what changed on the \
             machine between the two profiles is not in them.",
            100.0 * latency::CONFIDENCE,
            comparison.old_repeats,
            comparison.new_repeats
        )
    } else {
        format!(
            "Then → now and the change in percent. No intervals can be given: {} and {} repeats, at least {} of each are needed.",
            comparison.old_repeats,
            comparison.new_repeats,
            latency::FEWEST_REPEATS
        )
    };
    format!(
        "<section><h2>Against the baseline</h2>{warning}{}<p class=\"hint\">{hint}</p></section>",
        framed(&head, &body)
    )
}

fn change_cell(change: &Change) -> String {
    let class = match change.difference_ns {
        Some([low, _]) if low > 0.0 => "worse",
        Some([_, high]) if high < 0.0 => "better",
        Some(_) | None => "",
    };
    let mut note = change.share().map_or_else(String::new, |share| format!("{:+.1} %", 100.0 * share));
    if let Some([low, high]) = change.ratio {
        let _ = write!(note, " [{:+.0}, {:+.0}]", 100.0 * low, 100.0 * high);
    }
    let (old, new) = (microseconds(change.old_ns), microseconds(change.new_ns));
    format!("<td class=\"{class}\">{old} → {new}<span>{note}</span></td>")
}

pub(super) fn hops(figures: &ProfileFigures) -> String {
    let summary = figures.summary();
    let rows = summary.hops.iter();
    let body: String =
        rows.map(|hop| latency_row(hop.hop.label(), hop.hop.meaning(), &hop.latency)).collect();
    framed(&latency_head("Hop, µs"), &body)
}

fn latency_head(first: &str) -> String {
    let labels = ["count"].into_iter().chain(Statistic::ALL.map(Statistic::label));
    labels.fold(format!("<th scope=\"col\">{first}</th>"), |mut text, label| {
        let _ = write!(text, "<th scope=\"col\">{label}</th>");
        text
    })
}

/// What a count of negative lengths means, where there are any.
pub(super) fn negative(figures: &ProfileFigures) -> String {
    let negative: u64 = figures.summary().hops.iter().map(|of| of.latency.negative).sum();
    if negative == 0 {
        return String::new();
    }
    "Negative is where the later stamp lies before the earlier one, which no sound record has; it is counted apart. "
        .to_owned()
}

/// What is not in the figures.
pub(super) fn start_up(figures: &ProfileFigures) -> String {
    let with = |repeat: &&RepeatFigures| repeat.start_up.counts.cycles > 0;
    let starts: Vec<_> = figures.repeats.iter().filter(with).map(|repeat| repeat.start_up).collect();
    let Some(worst) = starts.iter().max_by_key(|start| start.max_lateness_ns) else {
        return String::new();
    };
    let cycles: u64 = starts.iter().map(|start| start.counts.cycles).sum();
    format!(
        "Not in these figures: the start-up before the first cycle that used detections, {cycles} filter cycles of all repeats, \
         largest lateness {}, longest computation {}.",
        time(worst.max_lateness_ns),
        time(starts.iter().map(|start| start.max_compute_ns).max().unwrap_or(0))
    )
}

pub(super) fn repeats(figures: &ProfileFigures) -> String {
    let headings = [
        "Repeat",
        "duration, s",
        "end to end p50, µs",
        "p99",
        "p99.9",
        "max",
        "compute p99",
        "misses",
        "lost",
    ];
    let rows = figures.repeats.iter().enumerate().map(|(index, repeat)| {
        let figure = |hop: Hop, statistic: Statistic| {
            let of = repeat.hops.iter().find(|of| of.hop == hop);
            of.and_then(|of| of.latencies.statistic_ns(statistic))
                .map_or_else(|| "–".to_owned(), microseconds)
        };
        vec![
            format!("{}", index + 1),
            format!("{:.1}", repeat.duration_ns as f64 / 1e9),
            figure(Hop::EndToEnd, Statistic::P50),
            figure(Hop::EndToEnd, Statistic::P99),
            figure(Hop::EndToEnd, Statistic::P99_9),
            figure(Hop::EndToEnd, Statistic::Max),
            figure(Hop::FilterCompute, Statistic::P99),
            repeat.counts.deadline_misses.to_string(),
            repeat.counts.lost_commands.to_string(),
        ]
    });
    table(headings, rows)
}

pub(super) fn loops(figures: &ProfileFigures) -> String {
    let loops = &figures.pooled.loops;
    if loops.is_empty() {
        return "<p class=\"hint\">No cycle records: loops, faults and switches are unknown.</p>".to_owned();
    }
    let latencies = |first: &str, pick: fn(&LoopFigures) -> &Latencies| {
        let rows = loops.iter().map(|of| latency_row(of.process.label(), "", &pick(of).summary()));
        framed(&latency_head(first), &rows.collect::<String>())
    };
    let headings = [
        "Process",
        "cycles",
        "by input",
        "skipped",
        "records lost",
        "restarts",
        "CPU, s",
        "CPU per cycle, µs",
        "faults",
        "from disk",
        "gave up",
        "pushed off",
    ];
    let rows = loops.iter().map(|of| {
        let mut cells = vec![of.process.label().to_owned()];
        let counts = [of.cycles, of.event_cycles, of.skipped, of.lost_records, of.restarts];
        cells.extend(counts.map(|count| count.to_string()));
        cells.push(format!("{:.3}", of.cpu_ns as f64 / 1e9));
        cells.push(format!("{:.1}", of.cpu_per_cycle_ns() / 1e3));
        let kernel = [of.minor_faults, of.major_faults, of.voluntary_switches, of.involuntary_switches];
        cells.extend(kernel.map(|count| count.to_string()));
        cells
    });
    [
        latencies("Lateness of the timer: due to begun, µs", |of| &of.lateness),
        latencies("Duration of cycles: begun to handed over, µs", |of| &of.duration),
        format!("<div class=\"dense\">{}</div>", table(headings, rows)),
    ]
    .concat()
}

pub(super) fn memory(figures: &ProfileFigures) -> String {
    let Some(repeat) = figures.repeats.iter().max_by_key(|repeat| repeat.resident_bytes()) else {
        return String::new();
    };
    if repeat.resident.is_empty() {
        return "<p class=\"hint\">Memory was not sampled.</p>".to_owned();
    }
    let rows = repeat.resident.iter().map(|of| {
        let sizes = [of.resident_bytes, of.proportional_bytes, of.locked_bytes];
        [vec![of.process.label().to_owned()], sizes.map(megabytes).to_vec()].concat()
    });
    table(["Largest, MB", "resident", "its share", "locked address space"], rows)
}

pub(super) fn machine(conditions: &Conditions) -> String {
    let machine = &conditions.machine;
    let or = |text: &Option<String>, otherwise: &str| text.clone().unwrap_or_else(|| otherwise.to_owned());
    let kernel = if machine.preempt_rt { " with PREEMPT_RT" } else { " without PREEMPT_RT" };
    let recording = &conditions.recording;
    let rows = [
        ("Processor", format!("{}, {} cores", machine.cpu_model, machine.cores)),
        ("Kernel", format!("{}{kernel}", machine.kernel)),
        ("Governor", or(&machine.governor, "none")),
        ("Clock source", or(&machine.clock_source, UNKNOWN)),
        ("Memory", format!("{:.1} GB", machine.memory_bytes as f64 / 1e9)),
        (
            "Recording",
            format!(
                "{:.1} s, {} detections, {} robot states",
                recording.duration_s, recording.detections, recording.robot_states
            ),
        ),
        ("Recording, SHA-256", recording.sha256.chars().take(16).collect()),
        ("Settings, SHA-256", conditions.settings_sha256.chars().take(16).collect()),
    ];
    table(["Machine", ""], rows.map(|(name, value)| vec![name.to_owned(), value]))
}

pub(super) fn rights(figures: &ProfileFigures) -> String {
    let rights = figures.repeats.last().map_or(&[][..], |repeat| &repeat.rights);
    if rights.is_empty() {
        return "<p class=\"hint\">No process told its rights.</p>".to_owned();
    }
    let none_or = |names: &[String]| if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
    let rows = rights.iter().map(|of| {
        let missing = of.missing();
        let missing = if missing.is_empty() { "–".to_owned() } else { missing.join(", ") };
        vec![of.process.label().to_owned(), none_or(&of.asked), none_or(&of.granted), missing]
    });
    table(["Process", "asked for", "granted", "refused"], rows)
}
