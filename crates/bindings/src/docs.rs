//! Documentation without Rust's links.

/// Replaces each ``[`path`]`` by what `named` makes of the path's parts (without `crate`), in backticks.
pub(crate) fn unlinked(line: &str, named: impl Fn(&[&str]) -> String) -> String {
    let mut text = String::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((path, behind)) = after.split_once("`]") else { break };
        let parts: Vec<&str> = path.split("::").filter(|part| *part != "crate").collect();
        text.push_str(before);
        text.push('`');
        text.push_str(&named(&parts));
        text.push('`');
        rest = behind;
    }
    text.push_str(rest);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_become_names_and_the_rest_stays() {
        let named = |parts: &[&str]| parts.join(".");
        assert_eq!(unlinked("A [`crate::Reason`] code: `[x, y]`.", named), "A `Reason` code: `[x, y]`.");
        assert_eq!(unlinked("with [`crate::Flags::A`] and [`B`]", named), "with `Flags.A` and `B`");
        assert_eq!(unlinked("[`broken", named), "[`broken");
    }
}
