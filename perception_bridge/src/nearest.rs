//! The choice of the obstacles nearest to the robot, since a message holds only so many.

/// Fills `order` with the indices of `positions_m`, nearest to `robot_m` first; equally near ones keep their order.
///
/// Allocates only where `order` has to grow.
pub(crate) fn by_distance(
    order: &mut Vec<usize>,
    count: usize,
    robot_m: [f64; 2],
    position_m: impl Fn(usize) -> [f64; 2],
) {
    let distance_m = |index: usize| {
        let [x, y] = position_m(index);
        (x - robot_m[0]).hypot(y - robot_m[1])
    };
    order.clear();
    order.extend(0..count);
    order.sort_unstable_by(|&a, &b| distance_m(a).total_cmp(&distance_m(b)).then(a.cmp(&b)));
}
