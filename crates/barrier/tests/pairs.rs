//! Conditions of single obstacles against the published composite, against central differences, and against every input that
//! an obstacle's model admits.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use allocation_counter::measure;
use barrier::{
    BarrierConstraint, BarrierObstacle, CompositeBarrier, CompositeSample, Kernel, MAX_OBSTACLES,
    ObstacleInput, RowsQp, SoftminOffset,
};
use dynamics::RobotObstaclePair;
use rand::RngExt;

const BETA: f64 = 4.0;

fn constrained(sample: CompositeSample) -> BarrierConstraint {
    match sample {
        CompositeSample::Constrained(constraint) => constraint,
        CompositeSample::Unconstrained => panic!("there are obstacles"),
    }
}

fn pairs<const NX: usize, P: RobotObstaclePair<NX>>(
    composite: &mut CompositeBarrier,
    pair: &P,
    x: &[f64; NX],
    people: &[BarrierObstacle],
    input: ObstacleInput,
) -> Vec<BarrierConstraint> {
    let mut found = Vec::with_capacity(MAX_OBSTACLES);
    composite.evaluate_pairs(pair, x, people, input, &mut found).unwrap();
    found
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + a.abs())
}

#[test]
fn composed_of_pairs_the_composite_is_the_published_one() {
    let (model, pair, mut rng) = (common::ground_robot_model(1), common::unicycle_pair(), common::rng(2));
    let mut composite = CompositeBarrier::new(&model, Kernel::Portable, BETA).unwrap();
    composite.add_model(&common::static_model(3)).unwrap();
    for count in [1, 2, 7, MAX_OBSTACLES] {
        let mut people = common::people(&mut rng, count, 4.0);
        people[0].model = 1;
        let x = [0.1, -0.2, 0.4];
        let published = constrained(composite.evaluate(&pair, &x, &people).unwrap());
        let weights = composite.weights().to_vec();
        let found = pairs(&mut composite, &pair, &x, &people, ObstacleInput::Measured);
        let composed = constrained(composite.compose(&found, SoftminOffset::Keep).unwrap());
        assert!(composed.h == published.h && composed.sdf == published.sdf, "{composed:?} {published:?}");
        assert_eq!(composite.weights(), weights);
        assert_eq!(
            (composed.critical, composed.outside_domain),
            (published.critical, published.outside_domain)
        );
        for (a, b) in [
            (composed.drift, published.drift),
            (composed.dh_dt, published.dh_dt),
            (composed.lg_h[0], published.lg_h[0]),
            (composed.lg_h[1], published.lg_h[1]),
        ] {
            assert!(near(a, b), "{composed:?} {published:?}");
        }
        for (index, alone) in found.iter().enumerate() {
            let published = constrained(composite.evaluate(&pair, &x, &people[index..=index]).unwrap());
            assert!(near(alone.drift, published.drift) && near(alone.lg_h[1], published.lg_h[1]));
            assert_eq!((alone.h, alone.critical), (published.h, index));
        }
    }
}

/// `∂h/∂t` of every pair is the smallest over the model's inputs, which lies at a corner, and no smaller.
#[test]
fn the_worst_input_is_the_worst_that_the_model_admits_and_no_worse() {
    let mut rng = common::rng(5);
    let (model, pair) = (common::quadrotor_model(4), common::double_integrator_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::Portable, BETA).unwrap();
    let mut within = |bound: f64| rng.random_range(-bound..bound);
    let people: Vec<_> = (0..9)
        .map(|_| {
            let velocity = [within(1.0), within(1.0)];
            BarrierObstacle {
                state: [within(3.0), within(3.0), velocity[0], velocity[1]],
                rate: [velocity[0], velocity[1], within(5.0), within(5.0)],
                radius_m: 0.7,
                model: 0,
            }
        })
        .collect();
    let x = [0.1, 0.2, 0.5, -0.4];
    let worst = pairs(&mut composite, &pair, &x, &people, ObstacleInput::WorstCase);
    let mut smallest = vec![f64::INFINITY; people.len()];
    for a in [-1.0, -0.3, 0.0, 0.6, 1.0] {
        for b in [-1.0, 0.2, 1.0] {
            let pushed: Vec<_> = people
                .iter()
                .map(|person| BarrierObstacle { rate: [person.rate[0], person.rate[1], a, b], ..*person })
                .collect();
            let found = pairs(&mut composite, &pair, &x, &pushed, ObstacleInput::Measured);
            for (index, constraint) in found.iter().enumerate() {
                smallest[index] = smallest[index].min(constraint.dh_dt);
                assert!(near(constraint.drift - constraint.dh_dt, worst[index].drift - worst[index].dh_dt));
            }
        }
    }
    for (found, smallest) in worst.iter().zip(smallest) {
        assert!(near(found.dh_dt, smallest), "{found:?} {smallest}");
    }
}

#[test]
fn the_worst_input_of_people_turns_them_and_keeps_their_speed_each_by_its_own_model() {
    let (model, pair, mut rng) = (common::ground_robot_model(1), common::unicycle_pair(), common::rng(8));
    let mut composite = CompositeBarrier::new(&model, Kernel::Portable, BETA).unwrap();
    composite.add_model(&common::cyclist_model(2)).unwrap();
    composite.add_model(&common::static_model(3)).unwrap();
    let mut people = common::people(&mut rng, 6, 3.0);
    for (index, person) in people.iter_mut().enumerate() {
        person.model = index % 3;
    }
    let turned = |turn: [f64; 3]| -> Vec<BarrierObstacle> {
        people
            .iter()
            .map(|person| BarrierObstacle {
                rate: [person.rate[0], person.rate[1], turn[person.model], 0.0],
                ..*person
            })
            .collect()
    };
    let x = [0.0, 0.1, 0.2];
    let worst = pairs(&mut composite, &pair, &x, &people, ObstacleInput::WorstCase);
    let left = pairs(&mut composite, &pair, &x, &turned([0.35, 0.8, 0.0]), ObstacleInput::Measured);
    let right = pairs(&mut composite, &pair, &x, &turned([-0.35, -0.8, 0.0]), ObstacleInput::Measured);
    for index in 0..people.len() {
        assert!(near(worst[index].dh_dt, left[index].dh_dt.min(right[index].dh_dt)), "{index}");
    }
}

#[test]
fn the_softmin_s_offset_stays_or_goes_or_goes_by_its_bound() {
    let (model, pair) = (common::ground_robot_model(1), common::unicycle_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::Portable, BETA).unwrap();
    let people = common::people(&mut common::rng(3), 5, 3.0);
    let found = pairs(&mut composite, &pair, &[0.0; 3], &people, ObstacleInput::Measured);
    let smallest = found.iter().map(|constraint| constraint.h).fold(f64::INFINITY, f64::min);
    let mut composed = |offset| constrained(composite.compose(&found, offset).unwrap());
    let keep = composed(SoftminOffset::Keep);
    let remove = composed(SoftminOffset::Remove);
    let bound = composed(SoftminOffset::RemoveBound);
    assert!(keep.h < smallest, "the offset is there: {} {smallest}", keep.h);
    assert_eq!(remove.h, smallest);
    assert!((bound.h - keep.h - 5.0_f64.ln() / BETA).abs() < 1e-15 && bound.h > smallest);
    for other in [remove, bound] {
        assert_eq!((other.lg_h, other.drift, other.critical), (keep.lg_h, keep.drift, keep.critical));
    }
}

#[test]
fn nobody_makes_no_condition_and_bad_input_is_refused() {
    let (model, pair) = (common::ground_robot_model(1), common::unicycle_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::Portable, BETA).unwrap();
    assert!(pairs(&mut composite, &pair, &[0.0; 3], &[], ObstacleInput::WorstCase).is_empty());
    assert_eq!(composite.compose(&[], SoftminOffset::RemoveBound), Ok(CompositeSample::Unconstrained));
    let mut people = common::people(&mut common::rng(3), 2, 3.0);
    people[1].state[0] = f64::NAN;
    let mut found = Vec::new();
    let refusal =
        composite.evaluate_pairs(&pair, &[0.0; 3], &people, ObstacleInput::Measured, &mut found).unwrap_err();
    assert!(refusal.to_string().contains("obstacle 1"), "{refusal}");
}

#[test]
fn a_cycle_over_pairs_allocates_nothing() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let (model, pair) = (common::ground_robot_model(1), common::unicycle_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    let people = common::people(&mut common::rng(3), MAX_OBSTACLES, 3.0);
    let mut found = Vec::with_capacity(MAX_OBSTACLES);
    let mut rows = Vec::with_capacity(MAX_OBSTACLES + 1);
    let qp = RowsQp::new(pair.control);
    let mut slack = 0.0;
    let of_cycles = measure(|| {
        for count in [1, 0, 5, MAX_OBSTACLES, 3] {
            composite
                .evaluate_pairs(&pair, &[0.0; 3], &people[..count], ObstacleInput::WorstCase, &mut found)
                .unwrap();
            let composed = composite.compose(&found, SoftminOffset::Remove).unwrap();
            rows.clear();
            rows.extend(composed.row(4.0));
            rows.extend(found.iter().map(|constraint| constraint.row(4.0)));
            slack += qp.solve(&[0.8, 0.1], &rows).unwrap().slack;
        }
    });
    assert!(slack > 0.0, "some rows cannot be met");
    assert_eq!(of_cycles.count_total, 0);
}
