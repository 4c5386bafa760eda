//! What `/diagnostics` says of made-up facts.

use std::sync::Arc;

use bytemuck::Zeroable;
use ros2_client::dds::rustdds::QosPolicies;

use super::*;

const S: u64 = 1_000_000_000;

fn record(topic: &str, direction: Direction) -> Arc<TopicRecord> {
    Arc::new(TopicRecord::new(topic, "nav_msgs/Odometry", direction, QosPolicies::default()))
}

fn said(diagnostics: &mut Diagnostics, facts: &Facts<'_>, part: &str) -> (u8, String) {
    let name = format!("robot/filter: {part}");
    let statuses = diagnostics.statuses(facts);
    let status = statuses.iter().find(|status| status.name == name);
    let status = status.unwrap_or_else(|| panic!("{name} is not among {statuses:?}"));
    assert_eq!(status.hardware_id, "stack7");
    (status.level.0, status.message.clone())
}

fn value(diagnostics: &mut Diagnostics, facts: &Facts<'_>, part: &str, key: &str) -> String {
    let name = format!("robot/filter: {part}");
    let statuses = diagnostics.statuses(facts);
    let values = statuses.into_iter().find(|status| status.name == name).expect(part).values;
    values.into_iter().find(|value| value.key == key).expect(key).value
}

#[test]
fn an_input_is_told_by_its_gravest_fault() {
    let odometry = record("/odom", Direction::In);
    let mut diagnostics = Diagnostics::new("/robot/filter", "stack7");
    let (health, expected) = (BTreeMap::new(), []);
    let mut look = |others: Others, now_ns: u64| {
        let topics = [Watched { record: Arc::clone(&odometry), others }];
        let facts = Facts {
            now_ns,
            command: None,
            sink: None,
            lost: 0,
            replaced: 0,
            topics: &topics,
            command_topic: "/cmd_vel",
            health: &health,
            expected: &expected,
        };
        said(&mut diagnostics, &facts, "input /odom")
    };
    assert_eq!(look(Others::default(), 0), (0, "nothing heard yet".to_owned()));
    odometry.set_silent(true);
    assert_eq!(look(Others::default(), S), (3, "silent: no publisher".to_owned()));
    let bool_only = Others { wrong_types: vec!["std_msgs/Bool".to_owned()], ..Others::default() };
    let expected = "a publisher speaks std_msgs/Bool, not nav_msgs/Odometry".to_owned();
    assert_eq!(look(bool_only.clone(), S), (2, expected.clone()));
    assert_eq!(look(Others { matched: 1, ..bool_only }, S), (1, expected));
    odometry.set_silent(false);
    odometry.passed(S);
    odometry.refused(Reason::FutureStamp);
    let matched = Others { matched: 1, ..Others::default() };
    look(matched.clone(), S);
    assert_eq!(look(matched.clone(), 2 * S), (2, "messages are refused: future_stamp".to_owned()));
    assert_eq!(look(matched, 3 * S), (0, "heard".to_owned()), "a window without refusals");
}

#[test]
fn the_filter_is_told_by_its_rung_and_by_its_silence() {
    let command = |status: SafetyStatus, reason: Reason, published_ns: u64| {
        let mut command =
            SafeCommand { status: status.code(), reason: reason.code(), ..SafeCommand::zeroed() };
        command.ledger.filter_published_ns = published_ns;
        command.sequence = published_ns / 4_000_000;
        command
    };
    let mut diagnostics = Diagnostics::new("/robot/filter", "stack7");
    let (health, expected) = (BTreeMap::new(), [ProcessId::Filter]);
    let facts = |command: &'static SafeCommand, now_ns: u64| Facts {
        now_ns,
        command: Some(command),
        sink: Some(SinkState::Braking(Reason::SilentFilter)),
        lost: 0,
        replaced: 0,
        topics: &[],
        command_topic: "/cmd_vel",
        // Leaked below: a test's few bytes.
        health: Box::leak(Box::new(health.clone())),
        expected: Box::leak(Box::new(expected)),
    };
    let leaked = |status, reason, ns| &*Box::leak(Box::new(command(status, reason, ns)));
    for (status, reason, expected) in [
        (SafetyStatus::Filtered, Reason::None, (0, "filtered".to_owned())),
        (SafetyStatus::Relaxed, Reason::SlackNeeded, (1, "relaxed: slack_needed".to_owned())),
        (SafetyStatus::Braking, Reason::StaleRobotState, (2, "braking: stale_robot_state".to_owned())),
        (SafetyStatus::Stopped, Reason::StopRequested, (0, "stopped: stop_requested".to_owned())),
        (SafetyStatus::Stopped, Reason::NoGoal, (1, "stopped: no_goal".to_owned())),
    ] {
        let facts = facts(leaked(status, reason, S), S);
        assert_eq!(said(&mut diagnostics, &facts, "filter"), expected);
    }
    // A second later it has counted 250 cycles more.
    let moving = facts(leaked(SafetyStatus::Filtered, Reason::None, 2 * S), 2 * S);
    diagnostics.statuses(&moving);
    let later = facts(leaked(SafetyStatus::Filtered, Reason::None, 3 * S), 3 * S);
    diagnostics.statuses(&later);
    let later = facts(leaked(SafetyStatus::Filtered, Reason::None, 4 * S), 4 * S);
    assert_eq!(value(&mut diagnostics, &later, "filter", "rate_hz"), "250");
    let silent = facts(leaked(SafetyStatus::Filtered, Reason::None, 4 * S), 5 * S);
    assert_eq!(said(&mut diagnostics, &silent, "filter").0, 3);
    assert_eq!(
        said(&mut diagnostics, &silent, "command sink"),
        (2, "brakes by itself: silent_filter".to_owned())
    );
    assert_eq!(said(&mut diagnostics, &silent, "process filter"), (3, "nothing heard of it yet".to_owned()));
}

#[test]
fn a_subscriber_that_expects_stamped_commands_is_named() {
    let commands = record("/cmd_vel", Direction::Out);
    let others = Others { wrong_types: vec!["geometry_msgs/TwistStamped".to_owned()], ..Others::default() };
    let topics = [Watched { record: commands, others }];
    let facts = Facts {
        now_ns: S,
        command: None,
        sink: None,
        lost: 0,
        replaced: 0,
        topics: &topics,
        command_topic: "/cmd_vel",
        health: &BTreeMap::new(),
        expected: &[],
    };
    let (level, message) = said(&mut Diagnostics::new("/robot/filter", "stack7"), &facts, "output /cmd_vel");
    assert_eq!(level, 2);
    assert_eq!(message, "a subscriber expects geometry_msgs/TwistStamped, not nav_msgs/Odometry");
}

#[test]
fn commands_that_newer_ones_replace_are_a_warning_once_they_are_most() {
    let commands = record("/cmd_vel", Direction::Out);
    let mut diagnostics = Diagnostics::new("/robot/filter", "stack7");
    let mut look = |seconds: u64, sent: u64, lost: u64, replaced: u64| {
        (0..sent).for_each(|_| commands.passed(seconds * S));
        let facts = Facts {
            now_ns: seconds * S,
            command: None,
            sink: Some(SinkState::Following),
            lost,
            replaced,
            topics: &[Watched { record: Arc::clone(&commands), others: Others::default() }],
            command_topic: "/cmd_vel",
            health: &BTreeMap::new(),
            expected: &[],
        };
        assert_eq!(
            value(&mut diagnostics, &facts, "command sink", "replaced_commands"),
            replaced.to_string()
        );
        said(&mut diagnostics, &facts, "command sink")
    };
    let fine = (0, "follows the filter".to_owned());
    assert_eq!(look(1, 90, 0, 10), fine);
    assert_eq!(look(2, 40, 0, 70), fine, "ten a second beside ninety");
    let late = "follows the filter; most commands are late and replaced by newer ones";
    assert_eq!(look(3, 100, 1, 70), (1, late.to_owned()), "sixty beside forty");
    assert_eq!(look(4, 100, 1, 70), (1, "follows the filter; messages are refused or lost".to_owned()));
    assert_eq!(look(5, 100, 1, 70), fine);
}

#[test]
fn who_commands_past_the_filter_is_an_error() {
    let others = Others { matched: 1, rivals: 1, ..Others::default() };
    let topics = ["/cmd_vel", "/diagnostics"].map(|topic| {
        let others = Others { wrong_types: vec!["std_msgs/Bool".to_owned()], ..others.clone() };
        Watched { record: record(topic, Direction::Out), others }
    });
    let facts = Facts {
        now_ns: S,
        command: None,
        sink: None,
        lost: 0,
        replaced: 0,
        topics: &topics,
        command_topic: "/cmd_vel",
        health: &BTreeMap::new(),
        expected: &[],
    };
    let mut diagnostics = Diagnostics::new("/robot/filter", "stack7");
    let expected = (2, "somebody else commands the robot, too, past the filter".to_owned());
    assert_eq!(said(&mut diagnostics, &facts, "output /cmd_vel"), expected);
    assert_eq!(value(&mut diagnostics, &facts, "output /cmd_vel", "other_publishers"), "1");
    assert_ne!(said(&mut diagnostics, &facts, "output /diagnostics"), expected, "everybody may");
}

#[test]
fn a_nominal_controller_that_waits_is_told_from_one_that_runs() {
    let nominal = ProcessId::Nominal;
    let mut report = Health { process: nominal.code(), published_ns: S, ..Health::zeroed() };
    let mut diagnostics = Diagnostics::new("/robot/filter", "stack7");
    let mut look = |report: &Health| {
        let facts = Facts {
            now_ns: S,
            command: None,
            sink: None,
            lost: 0,
            replaced: 0,
            topics: &[],
            command_topic: "/cmd_vel",
            health: &BTreeMap::from([(nominal.code(), *report)]),
            expected: &[],
        };
        said(&mut diagnostics, &facts, "process nominal")
    };
    assert_eq!(look(&report), (1, "waits: another program has its place".to_owned()));
    report.cycles = 1;
    assert_eq!(look(&report), (0, "runs".to_owned()));
}
