//! One moment seen from above, with the trails that led there: the README's picture.
//!
//! Its colours are fixed, on a light ground of its own, so that it reads on light and dark pages alike.

use messages::{Obstacle, SafeCommand};
use svg::Document;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Text};

use crate::display::number;
use crate::explain::predicted_position_m;
use crate::theme::{Role, rung_role};
use crate::{Moment, RunRecord, Rung, ZeroLevel};

/// Picture width, pixels; its height follows from the scene.
const WIDTH: f64 = 1200.0;

/// How much of the past a person's trail shows, s.
const TRAIL_S: f64 = 2.5;

/// Room around the robot's trail and goal, m.
const MARGIN_M: f64 = 4.0;

/// From metres in `odom` to pixels, y up to y down.
struct View {
    min_m: [f64; 2],
    max_m: [f64; 2],
    scale: f64,
}

/// The corners of the scene: the robot's way and its goals with room around them, `[x, y]` in `odom`, m.
pub(crate) fn scene_m(record: &RunRecord) -> [[f64; 2]; 2] {
    let states = record.robot_states.iter().map(|state| state.position_in_odom_m);
    let goals = record.goals.iter().map(|goal| goal.position_in_odom_m);
    let commands = record.safe_commands.iter().map(|command| command.robot_position_in_odom_m);
    let has_states = !record.robot_states.is_empty();
    let points = states.chain(goals).chain(commands.filter(|_| !has_states));
    let corners = points.filter(|point| point.iter().all(|x| x.is_finite())).fold(None, |corners, point| {
        let [low, high] = corners.unwrap_or([point, point]);
        Some([[0, 1].map(|axis| point[axis].min(low[axis])), [0, 1].map(|axis| point[axis].max(high[axis]))])
    });
    let [low, high]: [[f64; 2]; 2] = corners.unwrap_or([[0.0; 2]; 2]);
    [low.map(|value| value - MARGIN_M), high.map(|value| value + MARGIN_M)]
}

impl View {
    fn of(record: &RunRecord) -> Self {
        let [min_m, max_m] = scene_m(record);
        Self { min_m, max_m, scale: WIDTH / (max_m[0] - min_m[0]) }
    }

    fn height(&self) -> f64 {
        (self.max_m[1] - self.min_m[1]) * self.scale
    }

    fn at(&self, point_m: [f64; 2]) -> [f64; 2] {
        let rounded = |value: f64| (value * 10.0).round() / 10.0;
        [
            rounded((point_m[0] - self.min_m[0]) * self.scale),
            rounded((self.max_m[1] - point_m[1]) * self.scale),
        ]
    }

    fn line(&self, points_m: impl IntoIterator<Item = [f64; 2]>) -> Data {
        points_m.into_iter().fold(Data::new(), |data, point_m| {
            let [x, y] = self.at(point_m);
            if data.is_empty() { data.move_to((x, y)) } else { data.line_to((x, y)) }
        })
    }
}

/// Draws the moment `time_s` seconds after the run began: robot with heading and trail, people with radius, velocity and
/// trail, goal, and the zero level of that moment if `zero_level` gives it. A time outside the run shows its nearest end.
pub fn birds_eye_svg(record: &RunRecord, time_s: f64, zero_level: Option<&ZeroLevel>) -> String {
    let view = View::of(record);
    let time_ns = record.stack_time_ns(time_s).clamp(record.start_ns(), record.end_ns());
    let ground =
        Rectangle::new().set("width", WIDTH).set("height", view.height()).set("fill", Role::Paper.hex());
    let mut picture = Document::new()
        .set("viewBox", (0.0, 0.0, WIDTH, view.height()))
        .set("width", WIDTH)
        .set("height", view.height().round())
        .set("font-family", "system-ui, sans-serif")
        .set("role", "img")
        .set("aria-label", "the robot among people, seen from above")
        .add(ground)
        .add(metre_grid(&view));
    if let Some(level) = zero_level {
        picture = picture.add(unsafe_set(&view, level));
    }
    let moment = record.moment_at(time_ns);
    if let Some(goal) = moment.and_then(|moment| moment.goal) {
        picture = picture.add(goal_cross(&view, goal.position_in_odom_m));
    }
    picture = picture.add(robot_trail(&view, record, time_ns));
    if let Some(moment) = moment {
        let people = moment.obstacles.map_or(&[][..], |obstacles| obstacles.as_slice());
        for person in people {
            picture = picture.add(person_disc(&view, record, &moment, person));
        }
        picture = picture.add(robot_disc(&view, record, &moment)).add(caption(&view, record, &moment));
    }
    picture.to_string()
}

fn metre_grid(view: &View) -> Group {
    let mut group = Group::new().set("stroke", Role::Grid.hex()).set("stroke-width", 1);
    for axis in 0..2 {
        for metre in view.min_m[axis].ceil() as i64..=view.max_m[axis].floor() as i64 {
            let mut from = view.min_m;
            let mut to = view.max_m;
            (from[axis], to[axis]) = (metre as f64, metre as f64);
            let ([x1, y1], [x2, y2]) = (view.at(from), view.at(to));
            group = group.add(Line::new().set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2));
        }
    }
    group
}

/// The set h < 0 as a tint and its boundary h = 0 as a line, which leaves out the border of the grid.
fn unsafe_set(view: &View, level: &ZeroLevel) -> Group {
    let color = Role::Red.hex();
    let mut fill = Data::new();
    for ring in &level.rings_m {
        for (index, &point_m) in ring.iter().enumerate() {
            let [x, y] = view.at(point_m);
            fill = if index == 0 { fill.move_to((x, y)) } else { fill.line_to((x, y)) };
        }
        fill = fill.close();
    }
    let tint = Path::new()
        .set("d", fill)
        .set("fill", color.clone())
        .set("fill-opacity", 0.10)
        .set("fill-rule", "evenodd");
    let group = Group::new().add(tint);
    level.curves_m().into_iter().fold(group, |group, curve| {
        group.add(stroke(view.line(curve), &color, 2.5).set("stroke-linejoin", "round"))
    })
}

fn stroke(data: Data, color: &str, width: f64) -> Path {
    Path::new().set("d", data).set("fill", "none").set("stroke", color).set("stroke-width", width)
}

fn goal_cross(view: &View, goal_m: [f64; 2]) -> Group {
    let [x, y] = view.at(goal_m);
    let reach = 0.3 * view.scale;
    let cross = Data::new()
        .move_to((x - reach, y))
        .line_to((x + reach, y))
        .move_to((x, y - reach))
        .line_to((x, y + reach));
    let ring = Circle::new().set("cx", x).set("cy", y).set("r", reach * 0.66).set("fill", "none");
    let color = Role::Green.hex();
    Group::new().add(ring.set("stroke", color.clone()).set("stroke-width", 3)).add(stroke(cross, &color, 3.0))
}

fn robot_trail(view: &View, record: &RunRecord, time_ns: u64) -> Path {
    const SHORTEST_STEP_M: f64 = 0.03;
    let mut trail: Vec<[f64; 2]> = Vec::new();
    for state in record.robot_states.iter().take_while(|state| state.stamp.valid_at_ns <= time_ns) {
        let [x, y] = state.position_in_odom_m;
        if trail.last().is_none_or(|last| (x - last[0]).hypot(y - last[1]) > SHORTEST_STEP_M) {
            trail.push([x, y]);
        }
    }
    stroke(view.line(trail), &Role::Blue.hex(), 3.0).set("stroke-opacity", 0.6).set("stroke-linecap", "round")
}

fn person_disc(view: &View, record: &RunRecord, moment: &Moment<'_>, person: &Obstacle) -> Group {
    let is_critical = person.track_id == moment.command.critical_track_id;
    let color = if is_critical { Role::Red.hex() } else { Role::Grey.hex() };
    let place_m = predicted_position_m(person, moment.time_ns);
    let ahead_m = [0, 1].map(|axis| place_m[axis] + person.velocity_in_odom_mps[axis]);
    let since_ns = moment.time_ns.saturating_sub((TRAIL_S * 1e9) as u64);
    let past = record
        .obstacles
        .iter()
        .filter(|message| (since_ns..=moment.time_ns).contains(&message.stamp.published_ns))
        .filter_map(|message| message.as_slice().iter().find(|item| item.track_id == person.track_id))
        .map(|item| item.position_in_odom_m)
        .chain([place_m]);
    let [x, y] = view.at(place_m);
    let disc = Circle::new().set("cx", x).set("cy", y).set("r", person.radius_m * view.scale);
    Group::new()
        .add(stroke(view.line(past), &color, 2.0).set("stroke-opacity", 0.45))
        .add(
            disc.set("fill", color.clone())
                .set("fill-opacity", 0.55)
                .set("stroke", color.clone())
                .set("stroke-width", 2),
        )
        .add(stroke(view.line([place_m, ahead_m]), &color, 3.0))
}

fn robot_disc(view: &View, record: &RunRecord, moment: &Moment<'_>) -> Group {
    let (place_m, heading_rad) = pose(moment);
    let radius = record.robot_radius_m * view.scale;
    let nose_m = [heading_rad.cos(), heading_rad.sin()].map(|part| part * record.robot_radius_m);
    let nose_m = [place_m[0] + nose_m[0], place_m[1] + nose_m[1]];
    let [x, y] = view.at(place_m);
    let color = rung_role(Rung::of_code(moment.command.status)).hex();
    let disc = Circle::new().set("cx", x).set("cy", y).set("r", radius).set("fill", Role::Blue.hex());
    Group::new().add(disc.set("stroke", color).set("stroke-width", 5)).add(stroke(
        view.line([place_m, nose_m]),
        &Role::Paper.hex(),
        4.0,
    ))
}

/// The robot's newest pose: the state where there is one, else what the filter used.
pub(crate) fn pose(moment: &Moment<'_>) -> ([f64; 2], f64) {
    let SafeCommand { robot_position_in_odom_m, robot_heading_rad, .. } = moment.command;
    moment.robot_state.map_or((*robot_position_in_odom_m, *robot_heading_rad), |state| {
        (state.position_in_odom_m, state.heading_rad)
    })
}

fn caption(view: &View, record: &RunRecord, moment: &Moment<'_>) -> Group {
    let command = moment.command;
    let text = format!(
        "{:.1} s · h = {} m · {}",
        record.seconds(moment.time_ns),
        number(command.h_m, 2),
        Rung::of_code(command.status).label()
    );
    let text = Text::new(text).set("x", 18).set("y", view.height() - 18.0).set("fill", Role::Ink.hex());
    let key =
        Text::new("1 m grid, outlined area h < 0").set("x", WIDTH - 18.0).set("y", view.height() - 18.0);
    Group::new()
        .set("font-size", 22)
        .add(text)
        .add(key.set("text-anchor", "end").set("fill", Role::Faint.hex()))
}
