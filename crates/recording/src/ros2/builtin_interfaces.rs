//! Package `builtin_interfaces`: time.

ros_message! {
    /// A moment on a ROS clock.
    "builtin_interfaces/Time" Time {
        /// Whole seconds since the clock's epoch.
        sec: i32,
        /// Nanoseconds within the second.
        nanosec: u32,
    }

    /// A length of time.
    "builtin_interfaces/Duration" Duration {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds within the second.
        nanosec: u32,
    }
}

impl Time {
    /// The moment `time_ns` nanoseconds after the epoch. Later than the format can say (year 2038) becomes its last second.
    pub fn from_ns(time_ns: u64) -> Self {
        let sec = i32::try_from(time_ns / 1_000_000_000).unwrap_or(i32::MAX);
        Self { sec, nanosec: (time_ns % 1_000_000_000) as u32 }
    }

    /// Nanoseconds after the epoch; `None` before it and at zero, which publishers use for "not stamped".
    pub fn to_ns(&self) -> Option<u64> {
        let seconds = u64::try_from(self.sec).ok()?;
        let time_ns = seconds * 1_000_000_000 + u64::from(self.nanosec);
        (time_ns > 0).then_some(time_ns)
    }
}
