//! Who commanded the robot, and when.

use messages::{Controller, NominalCommand};
use serde::{Deserialize, Serialize};

/// An unbroken row of nominal commands of one controller.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// Code on the wire: a [`Controller`]'s, or the number that a program of somebody else's chose for itself.
    pub controller: u32,
    /// Its name, see [`controller_name`].
    pub name: String,
    /// When its first command was sent, stack clock, ns.
    pub start_ns: u64,
    /// When its last command was sent, stack clock, ns.
    pub end_ns: u64,
    /// How many there were.
    pub commands: u64,
    /// Time without any command between the previous segment and this one, ns; 0 for the first.
    pub gap_ns: u64,
}

/// The controllers that spoke, one after the other. A controller that was started anew, so that its sequence fell, begins a new
/// segment.
///
/// `commands` are in the order in which they were sent.
pub fn commanders(commands: &[NominalCommand]) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    let mut sequence = 0;
    for command in commands {
        let sent_ns = command.stamp.published_ns;
        match segments.last_mut() {
            Some(last) if last.controller == command.controller && command.stamp.sequence > sequence => {
                last.end_ns = sent_ns;
                last.commands += 1;
            }
            previous => {
                let gap_ns = previous.map_or(0, |previous| sent_ns.saturating_sub(previous.end_ns));
                segments.push(Segment {
                    controller: command.controller,
                    name: controller_name(command.controller),
                    start_ns: sent_ns,
                    end_ns: sent_ns,
                    commands: 1,
                    gap_ns,
                });
            }
        }
        sequence = command.stamp.sequence;
    }
    segments
}

/// The name of a controller of ours, or `external 1000` for the number that somebody else's chose.
pub fn controller_name(code: u32) -> String {
    Controller::try_from(code).map_or_else(|_| format!("external {code}"), |known| known.label().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn row(controller: u32, sequences: core::ops::RangeInclusive<u64>, from_ns: u64) -> Vec<NominalCommand> {
        let first = *sequences.start();
        sequences
            .map(|sequence| {
                let mut command = NominalCommand { controller, ..NominalCommand::zeroed() };
                command.stamp.sequence = sequence;
                command.stamp.published_ns = from_ns + (sequence - first) * 50;
                command
            })
            .collect()
    }

    #[test]
    fn each_controller_and_each_start_has_a_segment_of_its_own() {
        let commands = [row(2, 1..=3, 100), row(1000, 1..=2, 500), row(1000, 1..=1, 900)].concat();
        let segments = commanders(&commands);
        let told: Vec<_> =
            segments.iter().map(|s| (s.name.as_str(), s.start_ns, s.end_ns, s.commands, s.gap_ns)).collect();
        assert_eq!(
            told,
            [
                ("mpc", 100, 200, 3, 0),
                ("external 1000", 500, 550, 2, 300),
                ("external 1000", 900, 900, 1, 350)
            ]
        );
        assert_eq!(commanders(&[]), []);
    }
}
