//! MCAP in and out: ROS 2 messages and raw wire messages.
