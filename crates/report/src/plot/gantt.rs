//! What ran when, one row per process, over a few milliseconds.

use svg::Document;
use svg::node::element::{Line, Rectangle, Text, Title};

use super::axis::{Axis, trimmed};
use crate::theme::Role;

/// Drawn at twice the size it is shown at, like the other plots.
const WIDTH: f64 = 2360.0;
const LEFT: f64 = 170.0;
const RIGHT: f64 = 30.0;
const TOP: f64 = 44.0;
const ROW: f64 = 46.0;
const BOTTOM: f64 = 50.0;
const FONT: f64 = 27.0;
/// Least width of a bar, pixels, so that the shortest cycle can be seen.
const THINNEST: f64 = 5.0;

/// One bar.
pub(crate) struct GanttBar {
    pub(crate) row: usize,
    pub(crate) from_ns: u64,
    pub(crate) to_ns: u64,
    pub(crate) role: Role,
    /// Narrow and on top of others.
    pub(crate) inner: bool,
    /// Shown by a resting pointer.
    pub(crate) hint: String,
}

/// One moment across all rows.
pub(crate) struct GanttMark {
    pub(crate) at_ns: u64,
    pub(crate) role: Role,
    pub(crate) name: &'static str,
}

/// What to draw.
pub(crate) struct Gantt {
    /// Names of the rows, from top to bottom.
    pub(crate) rows: Vec<&'static str>,
    /// First and last moment shown, ns.
    pub(crate) window_ns: (u64, u64),
    /// Where the axis' zero lies, ns.
    pub(crate) zero_ns: u64,
    /// Later ones lie on top.
    pub(crate) bars: Vec<GanttBar>,
    pub(crate) marks: Vec<GanttMark>,
}

impl Gantt {
    pub(crate) fn draw(&self) -> String {
        let height = TOP + ROW * self.rows.len() as f64 + BOTTOM;
        let foot = height - BOTTOM;
        let label = "what each process ran around this moment";
        let mut document = Document::new()
            .set("viewBox", (0, 0, WIDTH as u32, height as u32))
            .set("class", "plot")
            .set("role", "img")
            .set("aria-label", label)
            .set("font-family", "sans-serif")
            .set("font-size", FONT);
        let milliseconds = |at_ns: u64| (i128::from(at_ns) - i128::from(self.zero_ns)) as f64 / 1e6;
        let range = milliseconds(self.window_ns.0)..milliseconds(self.window_ns.1);
        for at_ms in Axis::round(range, 12).marks {
            let x = self.x(self.zero_ns as f64 + at_ms * 1e6);
            document = document.add(line((x, x), (TOP, foot), Role::Grid)).add(text(
                &format!("{} ms", trimmed(at_ms)),
                (x, foot + 34.0),
                "middle",
                Role::Faint,
            ));
        }
        for (index, name) in self.rows.iter().enumerate() {
            let y = TOP + ROW * index as f64;
            document = document.add(line((LEFT, WIDTH - RIGHT), (y, y), Role::Grid)).add(text(
                name,
                (LEFT - 16.0, y + 0.5 * ROW + 0.35 * FONT),
                "end",
                Role::Faint,
            ));
        }
        document = document.add(line((LEFT, WIDTH - RIGHT), (foot, foot), Role::Grid));
        for bar in &self.bars {
            document = document.add(self.bar(bar));
        }
        for (index, mark) in self.marks_from_left().into_iter().enumerate() {
            let x = self.x(mark.at_ns as f64);
            // Names of marks that lie close to one another take turns, right and left of their lines.
            let (anchor, shift) = if index % 2 == 0 { ("start", 8.0) } else { ("end", -8.0) };
            document = document
                .add(line((x, x), (TOP - 30.0, foot), mark.role).set("stroke-dasharray", "10 8"))
                .add(text(mark.name, (x + shift, TOP - 12.0), anchor, mark.role));
        }
        document.to_string()
    }

    fn marks_from_left(&self) -> Vec<&GanttMark> {
        let mut marks: Vec<&GanttMark> = self.marks.iter().collect();
        marks.retain(|mark| (self.window_ns.0..=self.window_ns.1).contains(&mark.at_ns));
        marks.sort_by_key(|mark| mark.at_ns);
        marks
    }

    fn bar(&self, bar: &GanttBar) -> Rectangle {
        let (from, to) = (self.x(bar.from_ns as f64), self.x(bar.to_ns as f64));
        let (room, opacity) = if bar.inner { (16.0, 1.0) } else { (6.0, 0.55) };
        Rectangle::new()
            .set("x", round(from))
            .set("y", TOP + ROW * bar.row as f64 + room)
            .set("width", round((to - from).max(THINNEST)))
            .set("height", ROW - 2.0 * room)
            .set("fill", bar.role.hex())
            .set("fill-opacity", opacity)
            .add(Title::new(bar.hint.clone()))
    }

    /// Horizontal place of a moment, pixels; moments outside lie at the edges.
    fn x(&self, at_ns: f64) -> f64 {
        let (from_ns, to_ns) = (self.window_ns.0 as f64, self.window_ns.1 as f64);
        let share = ((at_ns - from_ns) / (to_ns - from_ns).max(1.0)).clamp(0.0, 1.0);
        round(LEFT + share * (WIDTH - LEFT - RIGHT))
    }
}

fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

fn line(x: (f64, f64), y: (f64, f64), role: Role) -> Line {
    Line::new()
        .set("x1", x.0)
        .set("x2", x.1)
        .set("y1", y.0)
        .set("y2", y.1)
        .set("stroke", role.hex())
        .set("stroke-width", 2)
}

fn text(words: &str, at: (f64, f64), anchor: &str, role: Role) -> Text {
    Text::new(words).set("x", at.0).set("y", at.1).set("text-anchor", anchor).set("fill", role.hex())
}
