//! Package `hunav_msgs`: simulated people of HuNavSim. Its second version changed the message without renaming it, so that
//! both are here. The constants are left out of the definitions; decoding needs none.

use super::{Header, Point, Pose, Twist};

ros_message! {
    /// How a person reacts to the robot (HuNavSim 2).
    "hunav_msgs/AgentBehavior" AgentBehavior {
        /// Which reaction.
        r#type: u8,
        /// Whether it shows at present.
        state: u8,
        /// Where its parameters come from.
        configuration: u8,
        /// How long it lasts, s.
        duration: f32,
        /// Whether it shows only once.
        once: bool,
        /// Greatest speed meanwhile, m/s.
        vel: f32,
        /// Distance at which it begins, m.
        dist: f32,
        /// Weight of the force towards the goal.
        goal_force_factor: f32,
        /// Weight of the force off obstacles.
        obstacle_force_factor: f32,
        /// Weight of the force off people.
        social_force_factor: f32,
        /// Weight of any other force.
        other_force_factor: f32,
    }

    /// A person or another agent (HuNavSim 2).
    "hunav_msgs/Agent" Agent {
        /// Identity.
        id: i32,
        /// What it is: see the constants of this type.
        r#type: u8,
        /// Looks.
        skin: u8,
        /// Name.
        name: String,
        /// Group that it walks in, −1 if none.
        group_id: i8,
        /// Where.
        position: Pose,
        /// Direction, rad.
        yaw: f32,
        /// Velocity in the frame of the message.
        velocity: Twist,
        /// Speed it would walk at, m/s.
        desired_velocity: f32,
        /// Its own radius, m.
        radius: f32,
        /// Its speed, m/s.
        linear_vel: f32,
        /// Its yaw rate, rad/s.
        angular_vel: f32,
        /// How it reacts to the robot.
        behavior: AgentBehavior,
        /// Behaviour tree by name.
        behavior_tree: String,
        /// Where it wants to go, in order.
        goals: Vec<Pose>,
        /// Whether it begins anew after the last goal.
        cyclic_goals: bool,
        /// Distance at which a goal counts as reached, m.
        goal_radius: f32,
        /// Nearest points of the walls.
        closest_obs: Vec<Point>,
    }

    /// All agents (HuNavSim 2, with behaviour trees).
    "hunav_msgs/Agents" Agents {
        /// When and in which frame.
        header: Header,
        /// The agents.
        agents: Vec<Agent>,
    }
}

/// The same messages as HuNavSim 1 published them, on Foxy and Humble.
pub mod hunav1 {
    use crate::ros2::{Header, Point, Pose, Twist};

    ros_message! {
        /// A person or another agent (HuNavSim 1).
        "hunav_msgs/Agent" Agent {
            /// Identity.
            id: i32,
            /// What it is: see the constants of [`super::Agent`].
            r#type: u8,
            /// Looks.
            skin: u8,
            /// How it reacts to the robot.
            behavior: u8,
            /// Name.
            name: String,
            /// Whether the reaction shows at present.
            behavior_state: u8,
            /// Group that it walks in, −1 if none.
            group_id: i8,
            /// Where.
            position: Pose,
            /// Direction, rad.
            yaw: f32,
            /// Velocity in the frame of the message.
            velocity: Twist,
            /// Speed it would walk at, m/s.
            desired_velocity: f32,
            /// Its own radius, m.
            radius: f32,
            /// Its speed, m/s.
            linear_vel: f32,
            /// Its yaw rate, rad/s.
            angular_vel: f32,
            /// Where it wants to go, in order.
            goals: Vec<Pose>,
            /// Whether it begins anew after the last goal.
            cyclic_goals: bool,
            /// Distance at which a goal counts as reached, m.
            goal_radius: f32,
            /// Nearest points of the walls.
            closest_obs: Vec<Point>,
        }

        /// All agents (HuNavSim 1).
        "hunav_msgs/Agents" Agents {
            /// When and in which frame.
            header: Header,
            /// The agents.
            agents: Vec<Agent>,
        }
    }
}

impl Agent {
    /// A person.
    pub const PERSON: u8 = 1;
    /// A robot.
    pub const ROBOT: u8 = 2;
}
