//! Tables in HTML, and how times and sizes read.

use core::fmt::Write as _;

use crate::html::escaped;

/// A table with a heading; the first cell of every row is its name. Cells are text and get escaped.
pub(crate) fn table<'a>(
    headings: impl IntoIterator<Item = &'a str>,
    rows: impl IntoIterator<Item = Vec<String>>,
) -> String {
    let head = headings.into_iter().fold(String::new(), |mut text, heading| {
        let _ = write!(text, "<th scope=\"col\">{}</th>", escaped(heading));
        text
    });
    let body = rows.into_iter().fold(String::new(), |mut text, cells| {
        text.push_str("<tr>");
        for (index, cell) in cells.iter().enumerate() {
            let cell = escaped(cell);
            let _ = if index == 0 {
                write!(text, "<th scope=\"row\">{cell}</th>")
            } else {
                write!(text, "<td>{cell}</td>")
            };
        }
        text.push_str("</tr>");
        text
    });
    framed(&head, &body)
}

/// A table of finished cells.
pub(super) fn framed(head: &str, body: &str) -> String {
    format!("<div class=\"scroll\"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>")
}

/// A time with the unit that suits it, to three digits or so.
pub(super) fn time(value_ns: u64) -> String {
    let value = value_ns as f64;
    match value_ns {
        0..1_000 => format!("{value_ns} ns"),
        1_000..100_000 => format!("{:.1} µs", value / 1e3),
        100_000..1_000_000 => format!("{:.0} µs", value / 1e3),
        1_000_000..1_000_000_000 => format!("{:.2} ms", value / 1e6),
        _ => format!("{:.2} s", value / 1e9),
    }
}

/// A time in µs without its unit.
pub(super) fn microseconds(value_ns: u64) -> String {
    format!("{:.1}", value_ns as f64 / 1e3)
}

/// A size in MB.
pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_carry_the_unit_that_suits_them() {
        let found = [999, 1_000, 123_400, 9_876_543, 2_000_000_000].map(time);
        assert_eq!(found, ["999 ns", "1.0 µs", "123 µs", "9.88 ms", "2.00 s"]);
    }

    #[test]
    fn cells_cannot_break_out_of_their_table() {
        let page = table(["a"], [vec!["<script>".to_owned(), "1".to_owned()]]);
        assert!(page.contains("<th scope=\"row\">&lt;script&gt;</th><td>1</td>"), "{page}");
    }
}
