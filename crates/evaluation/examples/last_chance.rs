//! For every contact of the ground robot: until when could it have been avoided, had somebody known what everybody would do?
//! And when did the touched person take the direction in which it met the robot? A chance that ended before that turn was none:
//! nothing that answers what people do could have used it.
//!
//! `cargo run --release -p evaluation --example last_chance -- METHOD PEOPLE FIRST_SEED COUNT`
//!
//! A chance is a manoeuvre of two parts (5 × 9 speeds and yaw rates, one of four moments to change, 5 × 9 again) by which the
//! robot, from its true state at that moment on, stays clear of the true ways of all people for three seconds. People here ignore
//! the robot, so their ways are the same whatever it does.

use evaluation::{Robot, Variant, VirtualStack};
use perception_bridge::SimulatedCrowd;
use settings::Settings;

/// Moments of a way: the filter's timed ticks; every fifth of them is looked at.
const TICK_NS: u64 = 4_000_000;
const TICK_S: f64 = 0.004;
const STRIDE: usize = 5;
const STEP_S: f64 = TICK_S * STRIDE as f64;
const LOOK_AHEAD_STEPS: usize = 150;
/// Chances are looked for this often and this far before a contact, ticks.
const BETWEEN_CHANCES: usize = 10;
const FARTHEST_BACK: usize = 1250;
const CHANGES_S: [f64; 4] = [0.2, 0.4, 0.8, 1.6];
/// Whoever walks in a direction that differs by more has not turned yet, cos.
const SAME_DIRECTION: f64 = 0.5;
const STANDING_MPS: f64 = 0.1;

/// The world at one tick.
struct Moment {
    robot: [f64; 3],
    people: Vec<Person>,
}

#[derive(Clone, Copy)]
struct Person {
    position_m: [f64; 2],
    velocity_mps: [f64; 2],
    contact_m: f64,
}

/// What became of one contact, s before it.
struct Contact {
    at_s: f64,
    turned_s: Option<f64>,
    distance_then_m: f64,
    last_chance_s: Option<f64>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [method, people, first, count] = arguments.as_slice() else {
        return Err("usage: last_chance METHOD PEOPLE FIRST_SEED COUNT".into());
    };
    let variant = Variant::named(Robot::Ground, method, &[])?;
    let model = cbf_filter::load_model(&variant.settings().filter.model)?;
    let mut settings = variant.settings().clone();
    settings.simulation.people = people.parse()?;
    let (first, count): (u64, u64) = (first.parse()?, count.parse()?);
    let (mut contacts, mut lost_before_turn) = (0, 0);
    for seed in first..first + count {
        settings.simulation.seed = seed;
        let mut stack = VirtualStack::new(&settings, &model, Box::new(SimulatedCrowd::new(&settings)?))?;
        let Some(contact) = watched(&mut stack, &settings) else { continue };
        let Contact { at_s, turned_s, distance_then_m, last_chance_s } = contact;
        let before = |s: Option<f64>| s.map_or_else(|| "over 5".to_owned(), |s| format!("{s:.2}"));
        println!(
            "seed {seed}: contact at {at_s:.2} s; turned {} s before, {distance_then_m:.2} m away; last chance {} s before",
            before(turned_s),
            before(last_chance_s)
        );
        contacts += 1;
        lost_before_turn += u32::from(
            turned_s.is_some_and(|turned_s| last_chance_s.is_none_or(|chance_s| chance_s > turned_s)),
        );
    }
    println!(
        "{contacts} contacts in {count} runs; the last chance of {lost_before_turn} was before the turn"
    );
    Ok(())
}

/// Drives until goal, contact or the end, and looks back if it was a contact.
fn watched(stack: &mut VirtualStack<SimulatedCrowd>, settings: &Settings) -> Option<Contact> {
    let mut moments: Vec<Moment> = Vec::new();
    let mut touched = None;
    while stack.cycle(&mut |_, _| {}).is_some() {
        // A frame of detections begins a cycle of its own, between two ticks.
        if stack.source().world().time_ns() != moments.len() as u64 * TICK_NS {
            continue;
        }
        let moment = moment(stack.source(), settings);
        let nearest = (0..moment.people.len())
            .min_by(|&a, &b| moment.gap_m(a).total_cmp(&moment.gap_m(b)))
            .filter(|&nearest| moment.gap_m(nearest) <= 0.0);
        moments.push(moment);
        match touched {
            None if stack.source().world().reached() => return None,
            None => touched = nearest.map(|person| (moments.len() - 1, person)),
            Some((at, _)) if moments.len() > at + STRIDE * LOOK_AHEAD_STEPS => break,
            Some(_) => {}
        }
    }
    let (at, person) = touched?;
    let before_s = |tick: usize| (at - tick) as f64 * TICK_S;
    let earliest = at.saturating_sub(FARTHEST_BACK);
    let turned = (earliest..at).rev().find(|&tick| !moments[tick].walks_like(&moments[at], person));
    let chance =
        (earliest..at).rev().step_by(BETWEEN_CHANCES).find(|&tick| has_chance(&moments[tick..], settings));
    Some(Contact {
        at_s: at as f64 * TICK_S,
        turned_s: turned.map(before_s),
        distance_then_m: turned.map_or(f64::NAN, |tick| moments[tick].gap_m(person)),
        last_chance_s: chance.map(before_s),
    })
}

fn moment(crowd: &SimulatedCrowd, settings: &Settings) -> Moment {
    let (world, robot) = (crowd.world(), crowd.world().robot());
    let people = world.people().iter().map(|person| Person {
        position_m: person.position_m,
        velocity_mps: person.velocity_mps,
        contact_m: person.radius_m + settings.robot.radius_m,
    });
    let [x, y] = robot.position_m;
    Moment { robot: [x, y, robot.heading_rad], people: people.collect() }
}

impl Moment {
    /// Signed distance of the discs of robot and `person`, m.
    fn gap_m(&self, person: usize) -> f64 {
        let person = &self.people[person];
        (person.position_m[0] - self.robot[0]).hypot(person.position_m[1] - self.robot[1]) - person.contact_m
    }

    /// Whether `person` walks in about the direction in which it walks at `other`.
    fn walks_like(&self, other: &Self, person: usize) -> bool {
        let [a, b] = [self, other].map(|moment| moment.people[person].velocity_mps);
        let (fast, other_fast) = (a[0].hypot(a[1]), b[0].hypot(b[1]));
        fast >= STANDING_MPS && a[0] * b[0] + a[1] * b[1] >= SAME_DIRECTION * fast * other_fast
    }
}

/// Whether some manoeuvre from the first of `moments` on is clear of everybody.
fn has_chance(moments: &[Moment], settings: &Settings) -> bool {
    let [slowest, rightmost] = [settings.robot.control_min[0], settings.robot.control_min[1]];
    let [fastest, leftmost] = [settings.robot.control_max[0], settings.robot.control_max[1]];
    let controls = || {
        (0..45).map(|cell| {
            let (speed, turn) = (f64::from(cell / 9) / 4.0, f64::from(cell % 9) / 8.0);
            [slowest + (fastest - slowest) * speed, rightmost + (leftmost - rightmost) * turn]
        })
    };
    controls().any(|first| {
        CHANGES_S.iter().any(|&change_s| controls().any(|second| is_clear(moments, first, change_s, second)))
    })
}

/// Whether `first` until `change_s` and then `second` (speed m/s, yaw rate rad/s) is clear of everybody.
fn is_clear(moments: &[Moment], first: [f64; 2], change_s: f64, second: [f64; 2]) -> bool {
    let [mut x, mut y, mut heading] = moments[0].robot;
    (1..=LOOK_AHEAD_STEPS).map_while(|step| Some((step, moments.get(step * STRIDE)?))).all(
        |(step, moment)| {
            let [speed, yaw_rate] = if (step as f64) * STEP_S <= change_s { first } else { second };
            let middle = heading + 0.5 * yaw_rate * STEP_S;
            x += speed * STEP_S * middle.cos();
            y += speed * STEP_S * middle.sin();
            heading += yaw_rate * STEP_S;
            moment
                .people
                .iter()
                .all(|person| (person.position_m[0] - x).hypot(person.position_m[1] - y) > person.contact_m)
        },
    )
}
