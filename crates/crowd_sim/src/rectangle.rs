//! An axis-aligned rectangle: where people walk.

use serde::{Deserialize, Serialize};

/// An axis-aligned rectangle in `odom`, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Smallest and largest x, m.
    pub x_m: [f64; 2],
    /// Smallest and largest y, m.
    pub y_m: [f64; 2],
}

impl Rectangle {
    /// Whether `point_m` lies inside or on the edge.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        (self.x_m[0]..=self.x_m[1]).contains(&point_m[0]) && (self.y_m[0]..=self.y_m[1]).contains(&point_m[1])
    }

    /// Brings back somebody who went through the walls: where reflections would have led, with the velocity turned round
    /// for each odd number of them.
    ///
    /// The rectangle is a valid one and everything finite. Takes the same time however many reflections there were.
    pub(crate) fn reflect(&self, position_m: &mut [f64; 2], velocity_mps: &mut [f64; 2]) {
        for (k, [low, high]) in [self.x_m, self.y_m].into_iter().enumerate() {
            if (low..=high).contains(&position_m[k]) {
                continue;
            }
            // Unfolded, the way repeats after two widths; in the second of them it runs backwards.
            let width = high - low;
            let unfolded = (position_m[k] - low).rem_euclid(2.0 * width);
            let is_backwards = unfolded > width;
            position_m[k] = low + if is_backwards { 2.0 * width - unfolded } else { unfolded };
            if is_backwards {
                velocity_mps[k] = -velocity_mps[k];
            }
        }
    }

    pub(crate) fn is_valid(&self) -> bool {
        [self.x_m, self.y_m].iter().all(|[low, high]| low.is_finite() && high.is_finite() && low < high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Rectangle = Rectangle { x_m: [1.0, 3.0], y_m: [-1.0, 1.0] };

    #[test]
    fn one_wall_turns_one_component_and_a_corner_both() {
        let (mut at, mut going) = ([3.5, 0.25], [1.0, 0.5]);
        ROOM.reflect(&mut at, &mut going);
        assert_eq!((at, going), ([2.5, 0.25], [-1.0, 0.5]));
        let (mut at, mut going) = ([0.75, -1.25], [-1.0, -2.0]);
        ROOM.reflect(&mut at, &mut going);
        assert_eq!((at, going), ([1.25, -0.75], [1.0, 2.0]));
    }

    #[test]
    fn many_widths_away_is_still_inside_and_takes_no_longer() {
        let (mut at, mut going) = ([3.0 + 2.0 * 1e9 + 0.5, 0.0], [1.0, 0.0]);
        ROOM.reflect(&mut at, &mut going);
        assert!(ROOM.contains(at) && going[0].abs() == 1.0, "{at:?}");
        // Through both walls and back in the first direction.
        let (mut at, mut going) = ([1.5 + 4.0, 0.0], [1.0, 0.0]);
        ROOM.reflect(&mut at, &mut going);
        assert_eq!((at, going), ([1.5, 0.0], [1.0, 0.0]));
    }
}
