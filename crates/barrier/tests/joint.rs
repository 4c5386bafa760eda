//! The joint look-ahead: what it promises holds against people who do their worst, and in a pair it is the game's own value.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

use allocation_counter::measure;
use barrier::{BarrierObstacle, JointEscape, JointHorizon, JointRobot};
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const PERIOD_S: f64 = 0.01;
const RADIUS_M: f64 = 0.7;

fn horizon() -> JointHorizon {
    JointHorizon {
        horizon_s: 2.4,
        moments: 48,
        levels: 9,
        disturbance_share: 1.0,
        max_person_speed_mps: 1.5,
        max_robot_speed_mps: f64::INFINITY,
        switch_s: 0.6,
    }
}

fn quadrotor() -> JointRobot {
    JointRobot::DoubleIntegrator {
        control: InputBox::new([-2.0; 2], [2.0; 2]).unwrap(),
        disturbance: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(),
    }
}

fn ground_robot() -> JointRobot {
    JointRobot::Unicycle { control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(), turn_rate_radps: 0.35 }
}

fn person(position: [f64; 2], velocity: [f64; 2]) -> BarrierObstacle {
    let [x, y] = position;
    let [vx, vy] = velocity;
    BarrierObstacle { state: [x, y, vx, vy], rate: [vx, vy, 0.0, 0.0], radius_m: RADIUS_M, model: 0 }
}

/// Four people around the origin on their way somewhere; those of the unicycle's pair differ in the state alone, which is not read.
fn people(rng: &mut Pcg64) -> Vec<BarrierObstacle> {
    let walker = |rng: &mut Pcg64| {
        let (angle, far) = (rng.random_range(-3.1..3.1_f64), rng.random_range(1.6..4.0));
        let (way, speed) = (rng.random_range(-3.1..3.1_f64), rng.random_range(0.2..1.2));
        person([far * angle.cos(), far * angle.sin()], [speed * way.cos(), speed * way.sin()])
    };
    (0..4).map(|_| walker(rng)).collect()
}

fn gap(x: &[f64; 4], person: &BarrierObstacle) -> f64 {
    (person.state[0] - x[0]).hypot(person.state[1] - x[1]) - person.radius_m
}

/// A person of the quadrotor's pair accelerates towards `target` as hard as the model lets it, on each axis.
fn chase_with_acceleration(person: &mut BarrierObstacle, target: &[f64; 4]) {
    for axis in 0..2 {
        let a = if target[axis] > person.state[axis] { 1.0 } else { -1.0 };
        let v = (person.rate[axis] + a * PERIOD_S).clamp(-1.5, 1.5);
        person.state[axis] += 0.5 * (person.rate[axis] + v) * PERIOD_S;
        person.rate[axis] = v;
    }
}

/// A person of the ground robot's pair turns towards `target` as fast as the model lets it.
fn chase_by_turning(person: &mut BarrierObstacle, target: &[f64; 4]) {
    let [vx, vy] = [person.rate[0], person.rate[1]];
    let side = vx * (target[1] - person.state[1]) - vy * (target[0] - person.state[0]);
    let (sin, cos) = (0.35 * PERIOD_S * side.signum()).sin_cos();
    person.rate[0] = cos * vx - sin * vy;
    person.rate[1] = sin * vx + cos * vy;
    person.state[0] += person.rate[0] * PERIOD_S;
    person.state[1] += person.rate[1] * PERIOD_S;
}

fn drive(robot: &JointRobot, x: &mut [f64; 4], u: &[f64; 2]) {
    match robot {
        JointRobot::Unicycle { .. } => {
            x[0] += u[0] * PERIOD_S * x[2].cos();
            x[1] += u[0] * PERIOD_S * x[2].sin();
            x[2] += u[1] * PERIOD_S;
        }
        JointRobot::DoubleIntegrator { .. } => {
            for axis in 0..2 {
                x[axis] += x[axis + 2] * PERIOD_S + 0.5 * u[axis] * PERIOD_S * PERIOD_S;
                x[axis + 2] += u[axis] * PERIOD_S;
            }
        }
    }
}

/// Runs scenes whose first look found a way out, and returns how many there were and the smallest gap that ever was.
fn hunted(robot: JointRobot, x: [f64; 4], chase: fn(&mut BarrierObstacle, &[f64; 4])) -> (usize, f64) {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut joint = JointEscape::new(robot, horizon());
    let (mut scenes, mut least) = (0, f64::INFINITY);
    for _ in 0..400 {
        let (mut x, mut people) = (x, people(&mut rng));
        if joint.escape(&x, &[0.0; 2], &people, 0.05).clearance_m < 0.05 {
            continue;
        }
        scenes += 1;
        for _ in 0..200 {
            let u = joint.escape(&x, &[0.0; 2], &people, 0.05).u;
            for person in &mut people {
                chase(person, &x);
            }
            drive(&robot, &mut x, &u);
            least = people.iter().map(|person| gap(&x, person)).fold(least, f64::min);
        }
    }
    (scenes, least)
}

#[test]
fn a_quadrotor_with_a_way_out_is_never_touched_by_people_who_chase_it_within_bounds() {
    let (scenes, least_m) = hunted(quadrotor(), [0.0, 0.0, 0.8, 0.0], chase_with_acceleration);
    assert!(scenes > 40, "{scenes}");
    assert!(least_m > 0.0, "{least_m} m in {scenes} scenes");
}

#[test]
fn a_ground_robot_with_a_way_out_is_never_touched_by_people_who_turn_towards_it() {
    let (scenes, least_m) = hunted(ground_robot(), [0.0; 4], chase_by_turning);
    assert!(scenes > 40, "{scenes}");
    assert!(least_m > 0.0, "{least_m} m in {scenes} scenes");
}

#[test]
fn people_from_all_sides_leave_no_way_out_where_each_alone_would() {
    let people = [[1.7, 0.0], [0.0, 1.7], [-1.7, 0.0], [0.0, -1.7]]
        .map(|[x, y]: [f64; 2]| person([x, y], [-x / 1.7, -y / 1.7]));
    let mut joint = JointEscape::new(quadrotor(), horizon());
    let mut clearance =
        |people: &[BarrierObstacle]| joint.escape(&[0.0; 4], &[0.0; 2], people, 0.0).clearance_m;
    for alone in &people {
        assert!(clearance(std::slice::from_ref(alone)) >= 0.0, "{alone:?}");
    }
    let together = clearance(&people);
    assert!(together < -0.1, "{together}");
}

#[test]
fn the_control_nearest_to_the_wish_is_taken_where_several_keep_clear() {
    let mut joint = JointEscape::new(quadrotor(), horizon());
    let far = [person([30.0, 0.0], [0.0, 0.0])];
    for wish in [[0.0, 0.0], [2.0, -2.0], [1.0, 0.5]] {
        assert_eq!(joint.escape(&[0.0; 4], &wish, &far, 0.0).u, wish, "a control of the grid");
        assert!(joint.remains_after(&[0.0; 4], &wish, PERIOD_S, &far, 0.0));
    }
    let ahead = [person([1.6, 0.0], [-1.0, 0.0])];
    assert!(!joint.remains_after(&[0.0, 0.0, 1.5, 0.0], &[2.0, 0.0], PERIOD_S, &ahead, 0.0));
    let escape = joint.escape(&[0.0, 0.0, 0.4, 0.0], &[2.0, 0.0], &ahead, 0.0);
    assert!(escape.u != [2.0, 0.0] && escape.clearance_m.is_finite(), "{escape:?}");
}

#[test]
fn nobody_near_is_nobody_to_escape_from_and_nothing_allocates() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let crowd: Vec<_> = (0..64).map(|k| person([1.0 + 0.1 * f64::from(k), 0.5], [-0.5, 0.1])).collect();
    for robot in [quadrotor(), ground_robot()] {
        let mut joint = JointEscape::new(robot, horizon());
        let mut clearances = [0.0; 3];
        let allocations = measure(|| {
            for (clearance, count) in clearances.iter_mut().zip([0, 3, 64]) {
                joint.remains_after(&[0.0; 4], &[0.25, 0.0], PERIOD_S, &crowd[..count], 0.0);
                *clearance = joint.escape(&[0.0; 4], &[0.25, 0.0], &crowd[..count], 0.0).clearance_m;
            }
        });
        assert_eq!(allocations.count_total, 0);
        assert!(clearances[0] == f64::INFINITY && clearances[1] >= clearances[2], "{clearances:?}");
    }
}
