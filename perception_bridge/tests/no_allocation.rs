//! Playing any source allocates nothing once it is open.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::Path;

use allocation_counter::measure;
use perception_bridge::{Obedience, Playback, SourceChoice, open_source};
use settings::Settings;

const MS: u64 = 1_000_000;

#[test]
fn playing_allocates_nothing() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let settings = Settings::load(&repository.join("config/ground_robot.toml")).unwrap();
    let file = repository.join("tests/data/mcap_rosbags_reference.mcap");
    let playback = Playback::new(2.0, 2).unwrap();
    let mcap = |closed_loop| SourceChoice::Mcap { file: file.clone(), closed_loop, playback };
    for choice in [SourceChoice::Simulation { obeys: Obedience::Filter }, mcap(false), mcap(true)] {
        let mut source = open_source(&settings, &choice).unwrap();
        let mut events = 0;
        let of_playing = measure(|| {
            for tick in 0..2_000 {
                let now_ns = 1_000 * MS + tick * MS;
                while source.poll(now_ns).is_some() {
                    events += 1;
                }
                source.status(now_ns);
            }
        });
        assert_eq!(of_playing.count_total, 0, "{choice:?}");
        assert!(events > 20, "{choice:?}");
    }
}
