//! A short stretch of the hour's worth of messages that `tests/judges/ros2_hour.py` sends: no process of the stack may go on growing.
//!
//! A busy machine may drop some of them, which is counted and not judged here. The whole six minutes are too long for every run of the tests. What is kept for eleven seconds, transforms, has filled up by half time.

#[path = "stack/command.rs"]
#[expect(dead_code, reason = "the judge starts the stack by itself")]
mod command;
#[path = "stack/peer.rs"]
mod peer;

use std::path::Path;
use std::process::Command;

use command::{Said, at, scratch};

#[test]
fn a_flood_of_messages_leaves_memory_as_it_was() {
    let Some(python) = peer::python_or_say() else { return };
    let folder = scratch("ros2_memory");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/judges/ros2_hour.py");
    let mut judge = Command::new(python);
    judge.arg(script).arg(env!("CARGO_BIN_EXE_cncbf")).arg(folder);
    judge.args(["--seconds", "50", "--settled", "0.5", "--domain", &peer::domain_id(7).to_string()]);
    let said = Said::by(judge, &[]);
    println!("{}", said.out);
    assert_eq!(said.code, 0, "{said:?}");
    for process in ["bridge", "estimator", "nominal", "filter", "record"] {
        assert!(at(&said.json(), &format!("/memory/{process}/end_mb")).as_f64().is_some_and(|mb| mb > 1.0));
    }
}
