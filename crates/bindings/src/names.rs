//! Names as other languages write them.

/// `RobotState` → `robot_state`.
pub(crate) fn snake(name: &str) -> String {
    let mut snake = String::new();
    for (index, letter) in name.char_indices() {
        if letter.is_ascii_uppercase() && index > 0 {
            snake.push('_');
        }
        snake.push(letter.to_ascii_lowercase());
    }
    snake
}

/// `SlackNeeded` → `SLACK_NEEDED`; what is in capitals already stays.
pub(crate) fn screaming(name: &str) -> String {
    if name.bytes().any(|byte| byte.is_ascii_lowercase()) {
        snake(name).to_ascii_uppercase()
    } else {
        name.to_owned()
    }
}

/// A field's name where it is a word of C++ or Python: with an underscore behind it.
pub(crate) fn field(name: &str) -> String {
    match name {
        "class" => "class_".to_owned(),
        other => other.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_change_their_style_and_nothing_else() {
        assert_eq!(snake("RobotState"), "robot_state");
        assert_eq!(screaming("NoNominalCommand"), "NO_NOMINAL_COMMAND");
        assert_eq!(screaming("CPU_DMA_LATENCY"), "CPU_DMA_LATENCY");
        assert_eq!((field("class").as_str(), field("radius_m").as_str()), ("class_", "radius_m"));
    }
}
