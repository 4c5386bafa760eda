//! What happened in a run so far: clearance, contacts, path length and arrival.
//!
//! Lives here: bookkeeping over states that others computed. Nothing here acts back on the world.

/// A contact between the robot and a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    /// World time at which it began, ns.
    pub at_ns: u64,
    /// Place of the person in the scenario's list.
    pub person: usize,
}

/// Running figures of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLedger {
    clearance_m: f64,
    min_clearance_m: f64,
    collisions: u32,
    first_contact: Option<Contact>,
    /// By place in the scenario's list; false for everybody who is absent.
    touching: Vec<bool>,
    path_length_m: f64,
    last_position_m: [f64; 2],
    reached_at_ns: Option<u64>,
}

impl RunLedger {
    /// Begins with the robot at `position_m` (m) among `people` people.
    pub(crate) fn new(position_m: [f64; 2], people: usize) -> Self {
        Self {
            clearance_m: f64::INFINITY,
            min_clearance_m: f64::INFINITY,
            collisions: 0,
            first_contact: None,
            touching: vec![false; people],
            path_length_m: 0.0,
            last_position_m: position_m,
            reached_at_ns: None,
        }
    }

    /// Notes the clearances (centre distance minus both radii, m) to everybody who is present at `time_ns`, each with their
    /// place in the scenario's list, in rising order.
    pub(crate) fn note_clearances(&mut self, time_ns: u64, clearances_m: impl Iterator<Item = (usize, f64)>) {
        self.clearance_m = f64::INFINITY;
        let mut next = 0;
        for (person, clearance_m) in clearances_m {
            self.touching[next..person].fill(false);
            self.note_clearance(Contact { at_ns: time_ns, person }, clearance_m);
            next = person + 1;
        }
        self.touching[next..].fill(false);
        self.min_clearance_m = self.min_clearance_m.min(self.clearance_m);
    }

    fn note_clearance(&mut self, contact: Contact, clearance_m: f64) {
        self.clearance_m = self.clearance_m.min(clearance_m);
        let touches = clearance_m < 0.0;
        if touches && !self.touching[contact.person] {
            self.collisions += 1;
            self.first_contact.get_or_insert(contact);
        }
        self.touching[contact.person] = touches;
    }

    /// Notes where the robot is now and whether that is within the goal's tolerance.
    pub(crate) fn note_robot(&mut self, time_ns: u64, position_m: [f64; 2], at_goal: bool) {
        let [dx, dy] = [position_m[0] - self.last_position_m[0], position_m[1] - self.last_position_m[1]];
        self.path_length_m += dx.hypot(dy);
        self.last_position_m = position_m;
        if at_goal {
            self.reached_at_ns.get_or_insert(time_ns);
        }
    }

    /// Clearance between the robot and the nearest person now, m; infinite without people.
    pub fn clearance_m(&self) -> f64 {
        self.clearance_m
    }

    /// Smallest clearance between the robot and anybody so far, m; negative after a contact, infinite without people.
    pub fn min_clearance_m(&self) -> f64 {
        self.min_clearance_m
    }

    /// Distinct contacts so far: moments at which the clearance to a person became negative.
    pub fn collisions(&self) -> u32 {
        self.collisions
    }

    /// When the first of them began, and with whom.
    pub fn first_contact(&self) -> Option<Contact> {
        self.first_contact
    }

    /// Length of the way driven so far, m.
    pub fn path_length_m(&self) -> f64 {
        self.path_length_m
    }

    /// World time at which the goal was first reached, ns.
    pub fn reached_at_ns(&self) -> Option<u64> {
        self.reached_at_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_long_contact_counts_once_and_a_second_one_again() {
        let mut ledger = RunLedger::new([0.0, 0.0], 2);
        for (time_ns, clearance_m) in (0..).zip([0.2, -0.1, -0.2, -0.05, 0.0, 0.1, -0.01, 0.3]) {
            ledger.note_clearances(time_ns, [0.5, clearance_m].into_iter().enumerate());
        }
        assert_eq!(ledger.collisions(), 2);
        assert_eq!(ledger.first_contact(), Some(Contact { at_ns: 1, person: 1 }));
        assert_eq!(ledger.clearance_m(), 0.3);
        assert_eq!(ledger.min_clearance_m(), -0.2);
    }

    #[test]
    fn exactly_zero_clearance_is_no_collision() {
        let mut ledger = RunLedger::new([0.0, 0.0], 1);
        ledger.note_clearances(0, [(0, 0.0)].into_iter());
        assert_eq!(ledger.collisions(), 0);
    }

    #[test]
    fn who_is_absent_touches_nobody_and_makes_a_new_contact_on_return() {
        let mut ledger = RunLedger::new([0.0, 0.0], 3);
        let mut note = |present: &[(usize, f64)]| {
            ledger.note_clearances(0, present.iter().copied());
            (ledger.collisions(), ledger.clearance_m())
        };
        assert_eq!(note(&[(0, 1.0), (1, -0.1), (2, -0.2)]), (2, -0.2));
        assert_eq!(note(&[(0, 1.0), (2, -0.2)]), (2, -0.2));
        assert_eq!(note(&[]), (2, f64::INFINITY));
        assert_eq!(note(&[(1, -0.1)]), (3, -0.1));
        assert_eq!(note(&[(1, -0.1), (2, -0.1)]), (4, -0.1));
    }

    #[test]
    fn arrival_keeps_its_first_time() {
        let mut ledger = RunLedger::new([0.0, 0.0], 0);
        for (time_ns, at_goal) in [(1, false), (2, true), (3, false), (4, true)] {
            ledger.note_robot(time_ns, [0.0, 0.0], at_goal);
        }
        assert_eq!(ledger.reached_at_ns(), Some(2));
    }
}
