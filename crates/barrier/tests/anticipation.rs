//! The anticipation: it leaves a free way alone, goes round people who go on as they go, and costs no memory.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

use allocation_counter::measure;
use barrier::{AnticipatingRobot, Anticipation, AnticipationHorizon, BarrierObstacle};
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const PERIOD_S: f64 = 0.02;
const RADIUS_M: f64 = 0.7;
const GOAL: [f64; 2] = [12.0, 0.0];

fn horizon(cruise_speed_mps: f64) -> AnticipationHorizon {
    AnticipationHorizon {
        horizon_s: 4.0,
        moments: 32,
        clearance_m: 0.5,
        clearance_growth_mps: 0.15,
        risk_weight: 20.0,
        turn_share: 0.05,
        trust_s: 2.0,
        negligible_risk_s: 0.02,
        cruise_speed_mps,
    }
}

fn ground_robot() -> AnticipatingRobot {
    AnticipatingRobot::Unicycle { control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap() }
}

fn quadrotor() -> AnticipatingRobot {
    let control = InputBox::new([-2.0; 2], [2.0; 2]).unwrap();
    AnticipatingRobot::DoubleIntegrator { control, max_speed_mps: 2.0 }
}

const ROBOTS: [(fn() -> AnticipatingRobot, f64); 2] = [(ground_robot, 1.0), (quadrotor, 1.8)];

fn person([x, y]: [f64; 2], [vx, vy]: [f64; 2]) -> BarrierObstacle {
    BarrierObstacle { state: [x, y, vx, vy], rate: [vx, vy, 0.0, 0.0], radius_m: RADIUS_M, model: 0 }
}

/// As fast as everybody walks now.
fn paces(people: &[BarrierObstacle]) -> Vec<f64> {
    people.iter().map(|person| person.rate[0].hypot(person.rate[1])).collect()
}

/// What makes for the goal where nothing is wished.
fn nominal(robot: &AnticipatingRobot, x: &[f64; 4]) -> [f64; 2] {
    let [dx, dy] = [GOAL[0] - x[0], GOAL[1] - x[1]];
    match robot {
        AnticipatingRobot::Unicycle { .. } => {
            let off = dynamics::wrap_angle(dy.atan2(dx) - x[2]);
            // Slow where the goal is aside: a turn at full speed is wider than the goal.
            [off.cos().max(0.25), (2.0 * off).clamp(-0.8, 0.8)]
        }
        AnticipatingRobot::DoubleIntegrator { .. } => {
            let left_m = dx.hypot(dy);
            [0, 1].map(|axis| (2.0 * (1.8 * [dx, dy][axis] / left_m - x[axis + 2])).clamp(-2.0, 2.0))
        }
    }
}

fn drive(robot: &AnticipatingRobot, x: &mut [f64; 4], u: &[f64; 2]) {
    match robot {
        AnticipatingRobot::Unicycle { .. } => {
            x[0] += u[0] * PERIOD_S * x[2].cos();
            x[1] += u[0] * PERIOD_S * x[2].sin();
            x[2] += u[1] * PERIOD_S;
        }
        AnticipatingRobot::DoubleIntegrator { .. } => {
            for axis in 0..2 {
                x[axis] += x[axis + 2] * PERIOD_S + 0.5 * u[axis] * PERIOD_S * PERIOD_S;
                x[axis + 2] = (x[axis + 2] + u[axis] * PERIOD_S).clamp(-2.0, 2.0);
            }
        }
    }
}

/// Drives to the goal among people who walk straight on: the smallest gap ever, m, and the time taken, s.
fn trip(
    robot: AnticipatingRobot,
    mut ahead: Option<Anticipation>,
    mut people: Vec<BarrierObstacle>,
) -> (f64, f64) {
    let (mut x, mut least_m, mut time_s) = ([0.0; 4], f64::INFINITY, 0.0);
    while (GOAL[0] - x[0]).hypot(GOAL[1] - x[1]) > 0.3 && time_s < 40.0 {
        let wish =
            ahead.as_mut().and_then(|ahead| ahead.choose(&x, GOAL, &people, &paces(&people), PERIOD_S));
        let u = wish.unwrap_or_else(|| nominal(&robot, &x));
        assert!(u.iter().all(|value| value.abs() <= 2.0), "{u:?}");
        drive(&robot, &mut x, &u);
        for person in &mut people {
            person.state[0] += person.rate[0] * PERIOD_S;
            person.state[1] += person.rate[1] * PERIOD_S;
            let gap_m = (person.state[0] - x[0]).hypot(person.state[1] - x[1]) - person.radius_m;
            least_m = least_m.min(gap_m);
        }
        time_s += PERIOD_S;
    }
    (least_m, time_s)
}

/// Eight people in the way who walk straight on across it.
fn crossing(rng: &mut Pcg64) -> Vec<BarrierObstacle> {
    let walker = |rng: &mut Pcg64| {
        let place = [rng.random_range(2.5..11.0), rng.random_range(-4.0..4.0)];
        let (way, speed) = (rng.random_range(-3.1..3.1_f64), rng.random_range(0.4..1.2));
        person(place, [speed * way.cos(), speed * way.sin()])
    };
    (0..8).map(|_| walker(rng)).collect()
}

#[test]
fn among_people_who_go_on_as_they_go_it_comes_through_untouched_where_the_nominal_way_does_not() {
    for (robot, cruise_speed_mps) in ROBOTS {
        let mut rng = Pcg64::seed_from_u64(7);
        let (mut touched, mut touched_nominally) = (0, 0);
        for _ in 0..60 {
            let people = crossing(&mut rng);
            let ahead = Anticipation::new(robot(), horizon(cruise_speed_mps));
            let (least_m, time_s) = trip(robot(), Some(ahead), people.clone());
            assert!(time_s < 30.0, "it dithers: {time_s} s");
            touched += usize::from(least_m <= 0.0);
            touched_nominally += usize::from(trip(robot(), None, people).0 <= 0.0);
        }
        assert!(touched_nominally > 20, "the scenes are too easy: {touched_nominally}");
        assert!(touched <= 1, "{touched} of 60 touched, {touched_nominally} nominally");
    }
}

#[test]
fn a_free_way_is_left_to_the_nominal_controller() {
    for (robot, cruise_speed_mps) in ROBOTS {
        let mut ahead = Anticipation::new(robot(), horizon(cruise_speed_mps));
        for people in [
            vec![],
            vec![person([-3.0, 0.0], [-1.0, 0.0])],
            vec![person([4.0, 6.0], [0.0, 1.0]), person([30.0, 0.0], [0.0; 2])],
        ] {
            assert_eq!(ahead.choose(&[0.0; 4], GOAL, &people, &paces(&people), PERIOD_S), None, "{people:?}");
        }
        let in_the_way = [person([2.0, 0.1], [0.0; 2])];
        assert!(ahead.choose(&[0.0; 4], GOAL, &in_the_way, &[0.0], PERIOD_S).is_some());
    }
}

#[test]
fn a_person_in_the_way_is_passed_on_the_free_side() {
    // Somebody stands a little to the left, so the way is free on the right: a turn to the right is negative.
    let mut ground = Anticipation::new(ground_robot(), horizon(1.0));
    let left = [person([2.0, 0.3], [0.0; 2])];
    let right = [person([2.0, -0.3], [0.0; 2])];
    assert!(ground.choose(&[0.0; 4], GOAL, &left, &[0.0], PERIOD_S).unwrap()[1] < 0.0);
    let mut ground = Anticipation::new(ground_robot(), horizon(1.0));
    assert!(ground.choose(&[0.0; 4], GOAL, &right, &[0.0], PERIOD_S).unwrap()[1] > 0.0);
    let mut quadrotor = Anticipation::new(quadrotor(), horizon(1.8));
    assert!(quadrotor.choose(&[0.0, 0.0, 1.5, 0.0], GOAL, &left, &[0.0], PERIOD_S).unwrap()[1] < 0.0);
}

#[test]
fn what_it_says_depends_on_where_the_world_is_turned_to_by_that_turn_alone() {
    let mut rng = Pcg64::seed_from_u64(9);
    let (sin, cos) = 0.7_f64.sin_cos();
    let turned = |[x, y]: [f64; 2]| [cos * x - sin * y + 3.0, sin * x + cos * y - 1.0];
    for _ in 0..50 {
        let people = crossing(&mut rng);
        let elsewhere: Vec<_> = people
            .iter()
            .map(|p| {
                let [vx, vy] = [p.rate[0], p.rate[1]];
                person(turned([p.state[0], p.state[1]]), [cos * vx - sin * vy, sin * vx + cos * vy])
            })
            .collect();
        let here = Anticipation::new(ground_robot(), horizon(1.0)).choose(
            &[0.0; 4],
            GOAL,
            &people,
            &paces(&people),
            PERIOD_S,
        );
        let there = Anticipation::new(ground_robot(), horizon(1.0)).choose(
            &[3.0, -1.0, 0.7, 0.0],
            turned(GOAL),
            &elsewhere,
            &paces(&elsewhere),
            PERIOD_S,
        );
        assert_eq!(here, there);
    }
}

#[test]
fn who_slowed_down_to_turn_is_expected_at_the_old_pace() {
    // Coming across at 0.1 m/s somebody would let the robot pass; at a pace of 1.4 m/s they meet.
    let robot_at_cruise = [0.0; 4];
    let people = [person([2.2, 2.6], [0.0, -0.1])];
    let mut ahead =
        Anticipation::new(ground_robot(), AnticipationHorizon { turn_share: 0.0, ..horizon(1.0) });
    assert_eq!(ahead.choose(&robot_at_cruise, GOAL, &people, &[0.1], PERIOD_S), None);
    assert!(ahead.choose(&robot_at_cruise, GOAL, &people, &[1.4], PERIOD_S).is_some());
}

#[test]
fn nobody_is_followed_closely_who_could_turn_round() {
    let people = [person([1.6, 0.0], [1.0, 0.0])];
    let follows = |turn_share: f64| {
        let horizon = AnticipationHorizon { turn_share, ..horizon(1.0) };
        Anticipation::new(ground_robot(), horizon)
            .choose(&[0.0; 4], GOAL, &people, &[1.0], PERIOD_S)
            .is_none()
    };
    assert!(follows(0.0) && !follows(0.5));
}

#[test]
fn no_search_allocates_however_many_people_there_are() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let crowd: Vec<_> = (0..64).map(|k| person([1.0 + 0.1 * f64::from(k), 0.5], [-0.5, 0.1])).collect();
    let walking = paces(&crowd);
    for (robot, cruise_speed_mps) in ROBOTS {
        let mut ahead = Anticipation::new(robot(), horizon(cruise_speed_mps));
        let mut chosen = 0;
        let allocations = measure(|| {
            for count in [0, 3, 64, 64] {
                let choice = ahead.choose(&[0.0; 4], GOAL, &crowd[..count], &walking[..count], PERIOD_S);
                chosen += usize::from(choice.is_some());
            }
        });
        assert_eq!((allocations.count_total, chosen), (0, 3));
    }
}
