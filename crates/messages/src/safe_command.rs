//! What the robot shall do, why, and the whole path that led there.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Message, layout::assert_layout};

/// Stack clock times, ns, of everything that one safe command rests on. Zero where nothing arrived yet.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Ledger/v2")]
pub struct Ledger {
    /// Newest detections: sensor clock stamp.
    pub detections_source_ns: u64,
    /// Newest detections: first seen by the bridge.
    pub detections_ingress_ns: u64,
    /// Newest detections: published by the bridge.
    pub detections_published_ns: u64,
    /// Newest detections: taken by the estimator.
    pub estimator_received_ns: u64,
    /// Obstacles: published by the estimator.
    pub estimator_published_ns: u64,
    /// Robot state: sensor clock stamp.
    pub robot_state_source_ns: u64,
    /// Robot state: first seen by the bridge.
    pub robot_state_ingress_ns: u64,
    /// Robot state: published by the bridge.
    pub robot_state_published_ns: u64,
    /// Robot state behind the nominal command: taken by the controller.
    pub nominal_received_ns: u64,
    /// Nominal command: published by the controller.
    pub nominal_published_ns: u64,
    /// When this filter cycle was due; `filter_woke_ns` where an input began it.
    pub filter_due_ns: u64,
    /// When this filter cycle began and took its inputs.
    pub filter_woke_ns: u64,
    /// When the command was computed.
    pub filter_computed_ns: u64,
    /// When the command was handed over.
    pub filter_published_ns: u64,
    /// A [`crate::Trigger`] code: what began this filter cycle.
    pub filter_trigger: u32,
    /// Due times between the last cycle of the timer and `filter_due_ns` that passed without a cycle.
    pub filter_skipped: u32,
    /// Page faults of the filter's thread since the previous command that needed no disk.
    pub minor_faults: u32,
    /// Page faults of the filter's thread since the previous command that waited for the disk.
    pub major_faults: u32,
    /// How often the filter's thread gave up its processor since the previous command; one is the sleep between them.
    pub voluntary_switches: u32,
    /// How often the filter's thread was pushed off its processor since the previous command.
    pub involuntary_switches: u32,
}

assert_layout!(Ledger, 136, {
    detections_source_ns: 0, detections_ingress_ns: 8, detections_published_ns: 16, estimator_received_ns: 24,
    estimator_published_ns: 32, robot_state_source_ns: 40, robot_state_ingress_ns: 48, robot_state_published_ns: 56,
    nominal_received_ns: 64, nominal_published_ns: 72, filter_due_ns: 80, filter_woke_ns: 88, filter_computed_ns: 96,
    filter_published_ns: 104, filter_trigger: 112, filter_skipped: 116, minor_faults: 120, major_faults: 124,
    voluntary_switches: 128, involuntary_switches: 132,
});

/// The corrected command with its reasons. Filter → bridge, recorder. One per filter cycle, whatever happens.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/SafeCommand/v2")]
pub struct SafeCommand {
    /// Counts the commands of one filter process, from 1.
    pub sequence: u64,
    /// The command u*, in the unit of `control_kind`. Finite, always.
    pub control: [f64; 2],
    /// The nominal command u_nom it was made from; zero if none was usable.
    pub nominal: [f64; 2],
    /// A [`crate::ControlKind`] code.
    pub control_kind: u32,
    /// A [`crate::SafetyStatus`] code: the rung of the ladder.
    pub status: u32,
    /// A [`crate::Reason`] code: why this rung.
    pub reason: u32,
    /// Obstacles that entered the composite.
    pub obstacle_count: u32,
    /// Composite barrier value h, m; `+∞` with no obstacle.
    pub h_m: f64,
    /// Smallest ℓ: distance between the discs of robot and obstacle (growth by age and buffer included), m; `+∞` with none.
    pub sdf_m: f64,
    /// L_f h + ∂h/∂t, m/s.
    pub drift_mps: f64,
    /// L_g h, m/s per unit of control.
    pub lg_h: [f64; 2],
    /// Class-κ gain α of this cycle, 1/s.
    pub alpha_per_s: f64,
    /// Slack s that the CBF-QP needed, m/s.
    pub slack_mps: f64,
    /// max over the input box of ḣ + αh, m/s: negative means no admissible control satisfies the condition.
    pub hard_margin_mps: f64,
    /// Track that weighs most in the composite; 0 with none.
    pub critical_track_id: u64,
    /// That obstacle's own h̄, m; `+∞` with none.
    pub critical_h_m: f64,
    /// Robot position in `odom` the cycle used (predicted to its beginning), `[x, y]`, m.
    pub robot_position_in_odom_m: [f64; 2],
    /// Robot heading the cycle used, rad.
    pub robot_heading_rad: f64,
    /// Obstacles evaluated outside the domain the model was trained on.
    pub outside_domain: u32,
    /// Evaluation kernel, an index into `barrier`'s kernel names; results are byte-identical only for equal kernels.
    pub kernel: u32,
    /// The path from sensor to command.
    pub ledger: Ledger,
}

assert_layout!(SafeCommand, 304, {
    sequence: 0, control: 8, nominal: 24, control_kind: 40, status: 44, reason: 48, obstacle_count: 52, h_m: 56,
    sdf_m: 64, drift_mps: 72, lg_h: 80, alpha_per_s: 96, slack_mps: 104, hard_margin_mps: 112, critical_track_id: 120,
    critical_h_m: 128, robot_position_in_odom_m: 136, robot_heading_rad: 152, outside_domain: 160, kernel: 164,
    ledger: 168,
});

impl Message for SafeCommand {
    const SERVICE: &'static str = "safe_command";
    const TYPE_NAME: &'static str = "cncbf/SafeCommand/v2";
}
