//! The program itself, over shared memory: frames in, obstacles out, signs of life in between, an orderly end.

mod support;

use std::process::{Child, Command, ExitStatus};
use std::time::Duration;

use messages::{Detections, Obstacles, ProcessId};
use node_runtime::{Clock, Domain, Node, RealClock, Subscriber};
use rustix::process::{Pid, Signal, kill_process};
use support::{MS, frame, seen};

/// Far beyond what anything here takes; only a hang reaches it.
const PATIENCE_NS: u64 = 30_000_000_000;

/// The running program, killed if a test fails half-way.
struct Estimator(Child);

impl Estimator {
    fn start(domain: &Domain) -> Self {
        // Its backward differences are exact, so the test can say what the velocity is.
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/ground_robot_paper.toml");
        let child = Command::new(env!("CARGO_BIN_EXE_obstacle_estimator"))
            .args(["--config", config, "--instance", "test"])
            .env(Domain::VARIABLE, domain.prefix())
            .spawn()
            .expect("the program starts");
        Self(child)
    }

    fn terminate(mut self) -> ExitStatus {
        let pid = Pid::from_child(&self.0);
        kill_process(pid, Signal::TERM).expect("the program still runs");
        self.0.wait().expect("the program ends")
    }
}

impl Drop for Estimator {
    fn drop(&mut self) {
        // After an orderly end there is nothing left to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The first answer from now on that satisfies `wanted`.
fn await_answer(answers: &mut Subscriber<Obstacles>, wanted: impl Fn(&Obstacles) -> bool) -> Obstacles {
    let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
    loop {
        let mut found = None;
        answers.drain(|answer| {
            if found.is_none() && wanted(answer) {
                found = Some(*answer);
            }
        });
        if let Some(answer) = found {
            return answer;
        }
        assert!(RealClock.now_ns() < give_up_ns, "no such answer");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn frames_and_silence_are_answered_until_the_end() {
    let domain = Domain::isolated();
    let node = Node::open_in(&domain, "test", ProcessId::Bridge).expect("shared memory works");
    let frames = node.publisher::<Detections>().expect("the only writer");
    let waker = node.waker(ProcessId::Estimator).expect("a free place");
    let mut answers = node.subscriber::<Obstacles>().expect("a free place");
    let estimator = Estimator::start(&domain);

    let silence = await_answer(&mut answers, |_| true);
    assert_eq!((silence.count, silence.stamp.valid_at_ns), (0, 0), "it lives before anything was perceived");

    // Measured in the recent past, so that the machine's load has no say in the intervals.
    let begin_ns = RealClock.now_ns() - 250 * MS;
    let mut last = silence;
    for k in 1..=5_u64 {
        let now_ns = begin_ns + 50 * k * MS;
        let mut walk = frame(0, &[seen(6, [0.05 * k as f64, 0.0])]);
        walk.stamp.valid_at_ns = now_ns;
        walk.stamp.published_ns = now_ns;
        frames.send(&walk).expect("room in shared memory");
        waker.wake();
        let answer = await_answer(&mut answers, |answer| answer.stamp.valid_at_ns == now_ns);
        assert_eq!((answer.count, answer.items[0].track_id), (1, 6));
        assert_eq!(answer.bridge_published_ns, now_ns);
        assert!(answer.received_ns >= now_ns && answer.stamp.published_ns >= answer.received_ns);
        assert!(answer.stamp.sequence > last.stamp.sequence);
        last = answer;
    }
    assert!((last.items[0].velocity_in_odom_mps[0] - 1.0).abs() < 1e-6, "{:?}", last.items[0]);

    let beat =
        await_answer(&mut answers, |answer| answer.items[0].valid_at_ns > answer.items[0].measured_at_ns);
    assert_eq!(beat.stamp.valid_at_ns, last.stamp.valid_at_ns, "perception has not spoken since");
    assert!(beat.items[0].position_in_odom_m[0] > last.items[0].position_in_odom_m[0]);
    assert!(estimator.terminate().success());
}

#[test]
fn a_settings_file_that_is_not_there_ends_in_one_clear_line() {
    let output = Command::new(env!("CARGO_BIN_EXE_obstacle_estimator"))
        .args(["--config", "nowhere.toml"])
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("nowhere.toml"), "{message}");
}
