//! A profile as tables for the terminal.

use core::fmt::{self, Write as _};

use crate::summary::{write_heading, write_row};
use crate::{Hop, Latencies, LoopFigures, ProfileFigures, Statistic};

/// One of a loop's distributions.
type Pick = fn(&LoopFigures) -> &Latencies;

impl fmt::Display for ProfileFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_conditions(f)?;
        writeln!(f)?;
        write!(f, "{}", self.summary())?;
        self.write_reading_aid(f)?;
        self.write_start_up(f)?;
        if self.pooled.loops.is_empty() {
            return write!(f, "\n\nNo cycle records: loops, faults and switches are unknown.");
        }
        self.write_loops(f)?;
        self.write_memory(f)
    }
}

impl ProfileFigures {
    /// How many repeats there are.
    pub fn repeats_in_words(&self) -> String {
        let count = self.repeats.len();
        if count == 1 { "1 repeat".to_owned() } else { format!("{count} repeats") }
    }

    fn write_conditions(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let conditions = &self.conditions;
        let (recording, machine) = (&conditions.recording, &conditions.machine);
        writeln!(
            f,
            "{}, {:.1} s, {} detections, at rate {}, {}, load {}, trigger {}, wait {}, transport {}",
            recording.file_name,
            recording.duration_s,
            recording.detections,
            conditions.rate,
            self.repeats_in_words(),
            conditions.load,
            conditions.trigger,
            conditions.wait,
            conditions.transport
        )?;
        let (governor, clock) = (machine.governor.as_deref(), machine.clock_source.as_deref());
        writeln!(
            f,
            "{}, {} cores, {}{}, governor {}, clock source {}, {:.1} GB",
            machine.cpu_model,
            machine.cores,
            machine.kernel,
            if machine.preempt_rt { " PREEMPT_RT" } else { "" },
            governor.unwrap_or("none"),
            clock.unwrap_or("unknown"),
            machine.memory_bytes as f64 / 1e9
        )?;
        let mut refused = false;
        for rights in self.repeats.last().map_or(&[][..], |repeat| &repeat.rights) {
            let missing = rights.missing();
            if !missing.is_empty() {
                refused = true;
                writeln!(f, "note: {} was not granted {}", rights.process, missing.join(", "))?;
            }
        }
        if refused { writeln!(f, "note: `cncbf doctor` tells how to get these rights") } else { Ok(()) }
    }

    /// What may look wrong and is not.
    fn write_reading_aid(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "\na percentile that asks for more values than there are is the maximum; p99.99 needs 10000",
        )?;
        if self.pooled.hops.iter().any(|of| of.latencies.summary().negative > 0) {
            f.write_str(
                "\nnegative: the later stamp lies before the earlier one, which no sound record has; counted apart",
            )?;
        }
        Ok(())
    }

    /// What is not in the figures is told beside them.
    fn write_start_up(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, repeat) in self.repeats.iter().enumerate() {
            let start_up = &repeat.start_up;
            if start_up.counts.cycles > 0 {
                write!(
                    f,
                    "\nnot in these figures, start-up of repeat {}: {:.2} s, {} filter cycles, {} deadline misses, \
                     largest lateness {:.1} µs, longest computation {:.1} µs, {} page faults",
                    index + 1,
                    start_up.duration_ns as f64 / 1e9,
                    start_up.counts.cycles,
                    start_up.counts.deadline_misses,
                    start_up.max_lateness_ns as f64 / 1e3,
                    start_up.max_compute_ns as f64 / 1e3,
                    start_up.minor_faults + start_up.major_faults
                )?;
            }
        }
        Ok(())
    }

    fn write_loops(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tables: [(&str, Pick); 2] =
            [("timer lateness, µs", |of| &of.lateness), ("cycle duration, µs", |of| &of.duration)];
        for (title, pick) in tables {
            f.write_str("\n\n")?;
            write_heading(f, title)?;
            for figures in &self.pooled.loops {
                writeln!(f)?;
                write_row(f, figures.process.label(), &pick(figures).summary())?;
            }
        }
        write!(f, "\n\n{:<22}{:>9}", "loop", "cycles")?;
        let columns = [
            "by input",
            "skipped",
            "lost",
            "restarts",
            "cpu, s",
            "cpu/cyc, µs",
            "faults",
            "from disk",
            "voluntary",
            "involuntary",
        ];
        columns.iter().try_for_each(|name| write!(f, "{name:>12}"))?;
        for figures in &self.pooled.loops {
            write!(f, "\n{:<22}{:>9}", figures.process, figures.cycles)?;
            for count in [figures.event_cycles, figures.skipped, figures.lost_records, figures.restarts] {
                write!(f, "{count:>12}")?;
            }
            let (cpu_s, per_cycle_us) = (figures.cpu_ns as f64 / 1e9, figures.cpu_per_cycle_ns() / 1e3);
            write!(f, "{cpu_s:>12.3}{per_cycle_us:>12.1}")?;
            for count in [
                figures.minor_faults,
                figures.major_faults,
                figures.voluntary_switches,
                figures.involuntary_switches,
            ] {
                write!(f, "{count:>12}")?;
            }
        }
        Ok(())
    }

    fn write_memory(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(total_bytes) = self.resident_bytes() else { return Ok(()) };
        write!(f, "\n\nresident memory {:.1} MB in all", total_bytes as f64 / 1e6)?;
        let worst = self.repeats.iter().max_by_key(|repeat| repeat.resident_bytes());
        let resident = worst.map_or(&[][..], |repeat| &repeat.resident);
        if resident.iter().all(|resident| resident.proportional_bytes > 0) {
            f.write_str(", shared pages counted once; each with everything it maps")?;
        }
        // Locked is what would stay if it were touched, hence it may be more than what is there.
        f.write_str(" (in brackets the address space it locked):")?;
        for (index, resident) in resident.iter().enumerate() {
            write!(
                f,
                "{} {} {:.1} ({:.1})",
                if index == 0 { "" } else { "," },
                resident.process,
                resident.resident_bytes as f64 / 1e6,
                resident.locked_bytes as f64 / 1e6
            )?;
        }
        Ok(())
    }
}

impl ProfileFigures {
    /// The repeats side by side, for the terminal: every figure end to end, µs, and deadline misses. Whether repeats agree
    /// says more than any pooled figure.
    pub fn repeats_table(&self) -> String {
        let mut text = format!("{:<22}{:>9}", "end to end, µs", "count");
        for statistic in Statistic::ALL {
            let _ = write!(text, "{:>11}", statistic.label());
        }
        let _ = write!(text, "{:>11}", "misses");
        for (index, repeat) in self.repeats.iter().enumerate() {
            let measured = repeat.hops.iter().find(|of| of.hop == Hop::EndToEnd);
            let Some(latencies) = measured.map(|of| &of.latencies) else { continue };
            let _ = write!(text, "\n{:<22}{:>9}", format!("repeat {}", index + 1), latencies.count());
            for statistic in Statistic::ALL {
                let _ = match latencies.statistic_ns(statistic) {
                    Some(value_ns) => write!(text, "{:>11.1}", value_ns as f64 / 1e3),
                    None => write!(text, "{:>11}", "-"),
                };
            }
            let _ = write!(text, "{:>11}", repeat.counts.deadline_misses);
        }
        text
    }
}
