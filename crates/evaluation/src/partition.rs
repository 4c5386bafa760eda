//! Which share of the work one machine does.

use std::str::FromStr;

/// Slice `index` (from 1) of `count` equal ones. All methods of one scenario fall into the same slice, so every slice has the
/// same mixture of fast and slow methods, and pairs stay together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Partition {
    index: u64,
    count: u64,
}

/// Why a partition is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PartitionError {
    /// It is not of the form `slice:i/n`.
    #[error("`{0}` is no partition; write slice:i/n with i from 1 to n, such as slice:1/4")]
    Malformed(String),
    /// The environment names an index and not of how many.
    #[error(
        "{index} is set and {count} is not; set it to the number of parts, or give --partition slice:i/n \
         (deploy/ has files that do)"
    )]
    NoCount {
        /// The variable that is set.
        index: &'static str,
        /// The one that is missing.
        count: &'static str,
    },
    /// A variable holds no usable number.
    #[error("{name} is `{value}`, which is no usable number here; unset it, or give --partition slice:i/n")]
    BadVariable {
        /// The variable.
        name: &'static str,
        /// Its value.
        value: String,
    },
}

impl Partition {
    /// Everything.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Slice `index` of `count`, if there is one.
    pub const fn slice(index: u64, count: u64) -> Option<Self> {
        if index >= 1 && index <= count { Some(Self { index, count }) } else { None }
    }

    /// What a scheduler's variables ask for, read through `variable`: those of Slurm's array jobs or of Kubernetes' indexed
    /// jobs, the latter with the number of parts in `JOB_COMPLETION_COUNT`. Nothing if none is set.
    ///
    /// # Errors
    /// [`PartitionError`] if they are set and of no use.
    pub fn from_environment(
        variable: impl Fn(&'static str) -> Option<String>,
    ) -> Result<Option<Self>, PartitionError> {
        let number = |name: &'static str| match variable(name) {
            None => Ok(None),
            Some(value) => {
                value.parse::<u64>().map(Some).map_err(|_| PartitionError::BadVariable { name, value })
            }
        };
        let (index_name, count_name, index, count) = if let Some(id) = number("SLURM_ARRAY_TASK_ID")? {
            let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
            let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
            let index = id.checked_sub(first).map(|offset| offset / step + 1);
            ("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", index, number("SLURM_ARRAY_TASK_COUNT")?)
        } else if let Some(index) = number("JOB_COMPLETION_INDEX")? {
            let count = number("JOB_COMPLETION_COUNT")?;
            ("JOB_COMPLETION_INDEX", "JOB_COMPLETION_COUNT", index.checked_add(1), count)
        } else {
            return Ok(None);
        };
        let count = count.ok_or(PartitionError::NoCount { index: index_name, count: count_name })?;
        let partition = index.and_then(|index| Self::slice(index, count));
        partition.map(Some).ok_or_else(|| PartitionError::BadVariable {
            name: index_name,
            value: variable(index_name).unwrap_or_default(),
        })
    }

    /// Whether scenario number `ordinal` of the plan is in it.
    pub const fn contains(&self, ordinal: usize) -> bool {
        ordinal as u64 % self.count == self.index - 1
    }

    /// Index from 1 and number of slices; nothing for the whole.
    pub fn parts(&self) -> Option<(u64, u64)> {
        (self.count > 1).then_some((self.index, self.count))
    }
}

impl FromStr for Partition {
    type Err = PartitionError;

    fn from_str(text: &str) -> Result<Self, PartitionError> {
        let numbers = text.strip_prefix("slice:").and_then(|slice| slice.split_once('/'));
        let parsed = numbers.and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        parsed
            .and_then(|(index, count)| Self::slice(index, count))
            .ok_or_else(|| PartitionError::Malformed(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from(variables: &[(&'static str, &str)]) -> Result<Option<Partition>, PartitionError> {
        Partition::from_environment(|name| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn slices_cover_everything_once() {
        for count in 1..8 {
            for ordinal in 0..50 {
                let owners = (1..=count)
                    .filter(|&index| {
                        Partition::slice(index, count).is_some_and(|slice| slice.contains(ordinal))
                    })
                    .count();
                assert_eq!(owners, 1);
            }
        }
    }

    #[test]
    fn only_slices_that_exist_are_accepted() {
        assert_eq!("slice:2/3".parse(), Ok(Partition { index: 2, count: 3 }));
        for wrong in ["slice:0/3", "slice:4/3", "slice:1", "1/3", "slice:a/3", "slice:-1/3", "slice:1/0", ""]
        {
            assert_eq!(wrong.parse::<Partition>(), Err(PartitionError::Malformed(wrong.to_owned())));
        }
    }

    #[test]
    fn slurm_counts_from_its_lowest_index_and_kubernetes_from_zero() {
        let slurm =
            [("SLURM_ARRAY_TASK_ID", "7"), ("SLURM_ARRAY_TASK_MIN", "5"), ("SLURM_ARRAY_TASK_COUNT", "4")];
        assert_eq!(from(&slurm), Ok(Partition::slice(3, 4)));
        let stepped = [
            ("SLURM_ARRAY_TASK_ID", "4"),
            ("SLURM_ARRAY_TASK_MIN", "0"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(from(&stepped), Ok(Partition::slice(3, 4)));
        let kubernetes = [("JOB_COMPLETION_INDEX", "0"), ("JOB_COMPLETION_COUNT", "2")];
        assert_eq!(from(&kubernetes), Ok(Partition::slice(1, 2)));
        assert_eq!(from(&[]), Ok(None));
    }

    #[test]
    fn a_scheduler_that_says_half_is_an_error() {
        assert!(matches!(from(&[("JOB_COMPLETION_INDEX", "0")]), Err(PartitionError::NoCount { .. })));
        let beyond = [("JOB_COMPLETION_INDEX", "2"), ("JOB_COMPLETION_COUNT", "2")];
        assert!(matches!(from(&beyond), Err(PartitionError::BadVariable { .. })));
        assert!(matches!(from(&[("SLURM_ARRAY_TASK_ID", "x")]), Err(PartitionError::BadVariable { .. })));
    }
}
