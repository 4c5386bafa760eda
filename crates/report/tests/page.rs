//! The page and the picture: self-contained, complete, small, and whole with nothing to show.

mod synthetic;

use report::{BarrierGrid, GridError, Moment, RunRecord, ZeroLevel, birds_eye_svg, html, trace_zero_levels};
use serde_json::Value;

const LARGEST_PAGE_BYTES: usize = 3_000_000;

fn levels(record: &RunRecord, people: usize) -> Vec<ZeroLevel> {
    trace_zero_levels(record, &mut |moment: &Moment<'_>| {
        let time_s = record.seconds(moment.time_ns);
        let velocity = moment.robot_state?.velocity_in_odom_mps();
        let h_m = |position| synthetic::h_m(position, velocity, people, time_s).0;
        BarrierGrid::around(moment.robot_state?.position_in_odom_m, 6.0, 41, h_m).ok()
    })
}

/// The data that the page's script reads.
fn embedded(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("a data element");
    let (json, _) = rest.split_once("</script>").expect("its end");
    serde_json::from_str(json).expect("valid JSON")
}

fn assert_self_contained(page: &str) {
    let without_namespaces = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http://", "https://", "src=", "@import", "url(", "<link", "fetch("] {
        assert!(!without_namespaces.contains(outside), "{outside} reaches out of the page");
    }
}

#[test]
fn a_minute_at_250_hz_among_ten_people_fits_in_three_megabytes() {
    let record = synthetic::run(60.0, 10);
    assert_eq!(record.safe_commands.len(), 15_000);
    let page = html(&record, &levels(&record, 10)).expect("drawn");
    assert!(page.len() < LARGEST_PAGE_BYTES, "{} bytes", page.len());
    assert_self_contained(&page);
    assert_eq!(page.matches("<svg class=\"plot\"").count(), 6);
    assert!(!page.contains("NaN") && !page.contains("{{script}}"));

    let data = embedded(&page);
    let frames = data["frames"].as_array().expect("frames");
    assert!((600..=901).contains(&frames.len()), "{}", frames.len());
    let last = record.safe_commands.last().expect("commands");
    assert!(frames.iter().all(|frame| frame["people"].as_array().is_some_and(|people| people.len() == 60)));
    assert!(frames.iter().any(|frame| !frame["zero"].as_array().expect("rings").is_empty()));
    assert_eq!(data["duration_s"], (record.seconds(last.ledger.filter_woke_ns) * 1e3).round() / 1e3);
}

#[test]
fn text_from_outside_cannot_break_the_page() {
    let mut record = synthetic::run(1.0, 2);
    record.title = "<script>alert(1)</script> {{data}}".to_owned();
    let page = html(&record, &[]).expect("drawn");
    assert_eq!(page.matches("</script>").count(), 2, "the page's own two scripts");
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt; {{data}}"));
    assert!(embedded(&page)["frames"].is_array());
}

#[test]
fn nobody_near_nothing_recorded_and_one_command_all_make_a_page() {
    let alone = synthetic::run(5.0, 0);
    let page = html(&alone, &levels(&alone, 0)).expect("drawn");
    assert!(embedded(&page)["frames"][10]["h"].is_null(), "h is infinite with nobody near");
    assert!(birds_eye_svg(&alone, 2.0, None).starts_with("<svg"));

    let mut empty = synthetic::run(0.0, 0);
    assert!(html(&empty, &[]).expect("drawn").contains("Outcome unknown"));
    empty.goals.clear();
    assert!(!birds_eye_svg(&empty, 2.0, None).contains("NaN"));

    let one = synthetic::run(0.004, 1);
    assert_eq!(one.safe_commands.len(), 1);
    assert_eq!(embedded(&html(&one, &[]).expect("drawn"))["frames"].as_array().map(Vec::len), Some(1));
}

#[test]
fn the_zero_level_of_a_disc_is_its_circle_and_the_grids_border_is_none_of_it() {
    let (centre, radius) = ([1.0, -2.0], 1.5);
    let h_m = |[x, y]: [f64; 2]| (x - centre[0]).hypot(y - centre[1]) - radius;
    let whole = ZeroLevel::of(0, &BarrierGrid::around([0.0, 0.0], 6.0, 121, h_m).expect("sound grid"));
    assert_eq!((whole.rings_m.len(), whole.curves_m().len()), (1, 1));
    for &point in &whole.curves_m()[0] {
        assert!(h_m(point).abs() < 0.005, "{point:?} lies {} m off", h_m(point));
    }

    // The grid's border at x = 1 cuts the disc in two: half the circle is left, and no straight edge.
    let cut = ZeroLevel::of(0, &BarrierGrid::around([-5.0, 0.0], 6.0, 121, h_m).expect("sound grid"));
    assert_eq!(cut.max_m, [1.0, 6.0]);
    let curves = cut.curves_m();
    let points: Vec<_> = curves.concat();
    assert!(points.len() > 20 && points.iter().all(|&point| h_m(point).abs() < 0.03), "{curves:?}");
    let filled: Vec<_> = cut.rings_m.concat();
    assert!(filled.len() > points.len(), "the ring itself is closed along the border");
}

#[test]
fn far_from_everybody_there_is_no_zero_level_and_a_bad_grid_is_refused() {
    let far = BarrierGrid::around([0.0, 0.0], 6.0, 11, |_| f64::INFINITY).expect("sound grid");
    assert!(ZeroLevel::of(0, &far).rings_m.is_empty());
    let inside = BarrierGrid::around([0.0, 0.0], 6.0, 11, |_| -1.0).expect("sound grid");
    assert!(ZeroLevel::of(0, &inside).curves_m().is_empty(), "everything is unsafe, nothing is the boundary");
    for (side, half_width_m) in [(1, 6.0), (11, 0.0), (11, f64::NAN)] {
        let refused = BarrierGrid::around([0.0, 0.0], half_width_m, side, |_| 0.0);
        assert!(matches!(refused, Err(GridError { .. })));
    }
}

#[test]
fn the_picture_shows_everybody_the_goal_and_the_level() {
    let record = synthetic::run(5.0, 10);
    let levels = levels(&record, 10);
    let picture = birds_eye_svg(&record, 4.0, levels.get(80));
    assert_eq!(picture.matches("<circle").count(), 12, "ten people, the robot, the goal");
    assert!(picture.contains("evenodd") && picture.contains("h = "));
}
