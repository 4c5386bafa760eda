//! What the environment of every ROS 2 program says.

use super::error::RosError;

const DOMAIN_ID: &str = "ROS_DOMAIN_ID";
const LOCALHOST_ONLY: &str = "ROS_LOCALHOST_ONLY";
const DISCOVERY_RANGE: &str = "ROS_AUTOMATIC_DISCOVERY_RANGE";
/// Highest domain whose ports exist.
const MAX_DOMAIN_ID: u16 = 232;

/// Which graph is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Environment {
    /// DDS domain.
    pub(super) domain_id: u16,
    /// Whether other machines are left out.
    pub(super) localhost_only: bool,
}

impl Environment {
    /// Reads `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY` and `ROS_AUTOMATIC_DISCOVERY_RANGE`; unset means domain 0 and the subnet.
    pub(super) fn read() -> Result<Self, RosError> {
        Self::of(|name| std::env::var_os(name).map(|value| value.to_string_lossy().into_owned()))
    }

    fn of(variable: impl Fn(&'static str) -> Option<String>) -> Result<Self, RosError> {
        let value = |name| variable(name).unwrap_or_default();
        let unusable = |variable, value, expected| RosError::Environment { variable, value, expected };
        let domain_id = match value(DOMAIN_ID) {
            unset if unset.is_empty() => 0,
            text => match text.parse() {
                Ok(id) if id <= MAX_DOMAIN_ID => id,
                Ok(_) | Err(_) => return Err(unusable(DOMAIN_ID, text, "a number from 0 to 232")),
            },
        };
        let old = match value(LOCALHOST_ONLY).as_str() {
            "" | "0" => false,
            "1" => true,
            other => return Err(unusable(LOCALHOST_ONLY, other.to_owned(), "0 or 1")),
        };
        let new = match value(DISCOVERY_RANGE).as_str() {
            "" | "SUBNET" | "SYSTEM_DEFAULT" => false,
            "LOCALHOST" => true,
            other => return Err(unusable(DISCOVERY_RANGE, other.to_owned(), "SUBNET or LOCALHOST")),
        };
        Ok(Self { domain_id, localhost_only: old || new })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Result<Environment, RosError> {
        Environment::of(|name| {
            variables.iter().find(|(other, _)| *other == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn domain_and_reach_are_as_every_ros_program_takes_them() {
        assert_eq!(of(&[]), Ok(Environment { domain_id: 0, localhost_only: false }));
        let narrow = Ok(Environment { domain_id: 42, localhost_only: true });
        assert_eq!(of(&[(DOMAIN_ID, "42"), (LOCALHOST_ONLY, "1")]), narrow);
        assert_eq!(of(&[(DOMAIN_ID, "42"), (DISCOVERY_RANGE, "LOCALHOST")]), narrow);
    }

    #[test]
    fn what_no_program_would_take_is_refused_by_name() {
        for (name, value) in
            [(DOMAIN_ID, "233"), (DOMAIN_ID, "-1"), (LOCALHOST_ONLY, "yes"), (DISCOVERY_RANGE, "OFF")]
        {
            let refusal = of(&[(name, value)]).expect_err("unusable").to_string();
            assert!(refusal.contains(name) && refusal.contains(value), "{refusal}");
        }
    }
}
