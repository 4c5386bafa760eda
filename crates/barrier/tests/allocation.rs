//! A filter cycle allocates nothing: a counting allocator around composite and QP.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use allocation_counter::measure;
use barrier::{CbfQp, CompositeBarrier, Kernel};

#[test]
fn a_cycle_of_composite_and_qp_allocates_nothing() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let (model, pair, mut rng) = (common::ground_robot_model(1), common::unicycle_pair(), common::rng(2));
    let mut people = common::people(&mut rng, 64, 5.0);
    for (index, person) in people.iter_mut().enumerate() {
        person.model = index % 3;
    }
    let too_many = common::people(&mut rng, 65, 5.0);
    let qp = CbfQp::new(pair.control, 1e6).unwrap();
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut composite = CompositeBarrier::new(&model, kernel, 4.0).unwrap();
        composite.add_model(&common::cyclist_model(3)).unwrap();
        composite.add_model(&common::static_model(4)).unwrap();
        let mut finite = true;
        // From the first cycle on: no warming up.
        let of_cycles = measure(|| {
            for count in [0, 1, 5, 20, 64, 3] {
                let sample = composite.evaluate(&pair, &[0.1, 0.2, 0.3], &people[..count]).unwrap();
                let solution = qp.solve(&[0.8, 0.1], sample.row(4.0).as_ref()).unwrap();
                finite &= solution.u[0].is_finite();
                finite &= composite.h_at(&pair, &[0.1, 0.2, 0.3], &people[..count]).is_ok();
            }
            finite &= composite.evaluate(&pair, &[0.0; 3], &too_many).is_err();
        });
        assert!(finite);
        assert_eq!(of_cycles.count_total, 0, "{kernel} touched the heap");
    }
}
