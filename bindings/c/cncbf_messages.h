/* Wire types of cncbf: what travels between its processes through iceoryx2's shared memory.
 *
 * Generated from crates/messages by `cargo run -p bindings`; do not edit.
 *
 * The full name of a service is the stack's name, a slash and the service's name, for example "cncbf/robot_state". When a
 * port is opened, state the type name, sizeof the structure and an alignment of 8; iceoryx2 compares them.
 *
 * Fields that end in _ns are nanoseconds, all but source_ns on the stack clock, which is CLOCK_MONOTONIC; 0 means never.
 * odom is the fixed, locally continuous world frame; base is the robot's own, x forward, y left.
 */
#ifndef CNCBF_MESSAGES_H
#define CNCBF_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define CNCBF_STATIC_ASSERT(condition, text) static_assert(condition, text)
#else
#define CNCBF_STATIC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

/* Obstacles that one message can carry. */
#define CNCBF_MAX_OBSTACLES 64

/* What the two numbers of a control vector mean. */
enum cncbf_control_kind {
    /* `[speed m/s, yaw rate rad/s]` of a unicycle. */
    CNCBF_CONTROL_KIND_UNICYCLE = 1,
    /* `[ax, ay]` m/s² in `odom` of a double integrator. */
    CNCBF_CONTROL_KIND_DOUBLE_INTEGRATOR = 2
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_control_kind_label(uint32_t code)
{
    switch (code) {
    case CNCBF_CONTROL_KIND_UNICYCLE: return "unicycle";
    case CNCBF_CONTROL_KIND_DOUBLE_INTEGRATOR: return "double_integrator";
    default: return "?";
    }
}

/* What a nominal controller wants. */
enum cncbf_intent {
    /* Apply the control. */
    CNCBF_INTENT_DRIVE = 1,
    /* Come to a halt and stay. */
    CNCBF_INTENT_STOP = 2
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_intent_label(uint32_t code)
{
    switch (code) {
    case CNCBF_INTENT_DRIVE: return "drive";
    case CNCBF_INTENT_STOP: return "stop";
    default: return "?";
    }
}

/* Who made a nominal command. */
enum cncbf_controller {
    /* Keeps still. */
    CNCBF_CONTROLLER_HOLD = 1,
    /* Model-predictive controller of the unicycle. */
    CNCBF_CONTROLLER_MPC = 2,
    /* Linear-quadratic regulator of the double integrator. */
    CNCBF_CONTROLLER_LQR = 3,
    /* Pure pursuit of the goal by the unicycle. */
    CNCBF_CONTROLLER_PURE_PURSUIT = 4,
    /* The robot's own: what it would be commanded without this stack, taken from a topic by the bridge. */
    CNCBF_CONTROLLER_UPSTREAM = 5
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_controller_label(uint32_t code)
{
    switch (code) {
    case CNCBF_CONTROLLER_HOLD: return "hold";
    case CNCBF_CONTROLLER_MPC: return "mpc";
    case CNCBF_CONTROLLER_LQR: return "lqr";
    case CNCBF_CONTROLLER_PURE_PURSUIT: return "pure_pursuit";
    case CNCBF_CONTROLLER_UPSTREAM: return "upstream";
    default: return "?";
    }
}

/* Rung of the safety ladder, from best to worst. */
enum cncbf_safety_status {
    /* The nominal command passed the filter; the CBF condition holds. */
    CNCBF_SAFETY_STATUS_FILTERED = 1,
    /* No admissible control satisfies the condition; the least violating one was chosen. */
    CNCBF_SAFETY_STATUS_RELAXED = 2,
    /* Inputs cannot be trusted; the robot slows down to a halt. */
    CNCBF_SAFETY_STATUS_BRAKING = 3,
    /* The robot stands and is kept standing. */
    CNCBF_SAFETY_STATUS_STOPPED = 4
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_safety_status_label(uint32_t code)
{
    switch (code) {
    case CNCBF_SAFETY_STATUS_FILTERED: return "filtered";
    case CNCBF_SAFETY_STATUS_RELAXED: return "relaxed";
    case CNCBF_SAFETY_STATUS_BRAKING: return "braking";
    case CNCBF_SAFETY_STATUS_STOPPED: return "stopped";
    default: return "?";
    }
}

/* Why a rung was chosen, or what went wrong last. */
enum cncbf_reason {
    /* Nothing is wrong. */
    CNCBF_REASON_NONE = 0,
    /* The CBF-QP needed slack beyond its tolerance. */
    CNCBF_REASON_SLACK_NEEDED = 1,
    /* The nominal controller asked for a halt. */
    CNCBF_REASON_STOP_REQUESTED = 2,
    /* The filter took a manoeuvre that keeps clear of everybody at once, as far as one does, not the CBF-QP's control. */
    CNCBF_REASON_JOINT_ESCAPE = 3,
    /* No robot state has arrived yet. */
    CNCBF_REASON_NO_ROBOT_STATE = 10,
    /* The newest robot state is too old. */
    CNCBF_REASON_STALE_ROBOT_STATE = 11,
    /* The newest robot state holds a NaN or an infinity. */
    CNCBF_REASON_NON_FINITE_ROBOT_STATE = 12,
    /* No obstacles message has arrived yet. */
    CNCBF_REASON_NO_OBSTACLES = 20,
    /* The estimator has fallen silent. */
    CNCBF_REASON_SILENT_ESTIMATOR = 21,
    /* The estimator lives but perception has been silent for too long. */
    CNCBF_REASON_STALE_DETECTIONS = 22,
    /* An obstacle holds a NaN, an infinity or a radius that is not positive. */
    CNCBF_REASON_UNSOUND_OBSTACLE = 23,
    /* No nominal command has arrived yet. */
    CNCBF_REASON_NO_NOMINAL_COMMAND = 30,
    /* The nominal controller has fallen silent. */
    CNCBF_REASON_STALE_NOMINAL_COMMAND = 31,
    /* The nominal command holds a NaN or an infinity. */
    CNCBF_REASON_NON_FINITE_NOMINAL_COMMAND = 32,
    /* The nominal command is for another kind of robot, or its codes are unknown. */
    CNCBF_REASON_WRONG_CONTROL_KIND = 33,
    /* The nominal controller has no goal to drive to. */
    CNCBF_REASON_NO_GOAL = 34,
    /* A stamp lies in the future by more than the tolerance. */
    CNCBF_REASON_FUTURE_STAMP = 40,
    /* A stamp runs backwards. */
    CNCBF_REASON_BACKWARD_STAMP = 41,
    /* A stamp is of another clock than the one that was agreed on: simulated time, or the time since a machine began. */
    CNCBF_REASON_FOREIGN_CLOCK = 42,
    /* The sender's clock has jumped. */
    CNCBF_REASON_CLOCK_JUMP = 43,
    /* The evaluation produced a NaN or an infinity. */
    CNCBF_REASON_NON_FINITE_BARRIER = 50,
    /* An optimisation did not converge. */
    CNCBF_REASON_SOLVER_FAILED = 51,
    /* The command sink has heard nothing from the filter for five periods. */
    CNCBF_REASON_SILENT_FILTER = 60,
    /* An input could not be decoded or made no sense. */
    CNCBF_REASON_MALFORMED_INPUT = 70,
    /* A coordinate frame is unknown or its transform too old. */
    CNCBF_REASON_NO_TRANSFORM = 71,
    /* Something appeared twice. */
    CNCBF_REASON_DUPLICATE = 72,
    /* An obstacle jumped farther than anything can move. */
    CNCBF_REASON_TELEPORT = 73,
    /* There was no room for more. */
    CNCBF_REASON_CAPACITY_EXCEEDED = 74,
    /* A port refused to send or to receive. */
    CNCBF_REASON_PORT_FAILED = 80
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_reason_label(uint32_t code)
{
    switch (code) {
    case CNCBF_REASON_NONE: return "none";
    case CNCBF_REASON_SLACK_NEEDED: return "slack_needed";
    case CNCBF_REASON_STOP_REQUESTED: return "stop_requested";
    case CNCBF_REASON_JOINT_ESCAPE: return "joint_escape";
    case CNCBF_REASON_NO_ROBOT_STATE: return "no_robot_state";
    case CNCBF_REASON_STALE_ROBOT_STATE: return "stale_robot_state";
    case CNCBF_REASON_NON_FINITE_ROBOT_STATE: return "non_finite_robot_state";
    case CNCBF_REASON_NO_OBSTACLES: return "no_obstacles";
    case CNCBF_REASON_SILENT_ESTIMATOR: return "silent_estimator";
    case CNCBF_REASON_STALE_DETECTIONS: return "stale_detections";
    case CNCBF_REASON_UNSOUND_OBSTACLE: return "unsound_obstacle";
    case CNCBF_REASON_NO_NOMINAL_COMMAND: return "no_nominal_command";
    case CNCBF_REASON_STALE_NOMINAL_COMMAND: return "stale_nominal_command";
    case CNCBF_REASON_NON_FINITE_NOMINAL_COMMAND: return "non_finite_nominal_command";
    case CNCBF_REASON_WRONG_CONTROL_KIND: return "wrong_control_kind";
    case CNCBF_REASON_NO_GOAL: return "no_goal";
    case CNCBF_REASON_FUTURE_STAMP: return "future_stamp";
    case CNCBF_REASON_BACKWARD_STAMP: return "backward_stamp";
    case CNCBF_REASON_FOREIGN_CLOCK: return "foreign_clock";
    case CNCBF_REASON_CLOCK_JUMP: return "clock_jump";
    case CNCBF_REASON_NON_FINITE_BARRIER: return "non_finite_barrier";
    case CNCBF_REASON_SOLVER_FAILED: return "solver_failed";
    case CNCBF_REASON_SILENT_FILTER: return "silent_filter";
    case CNCBF_REASON_MALFORMED_INPUT: return "malformed_input";
    case CNCBF_REASON_NO_TRANSFORM: return "no_transform";
    case CNCBF_REASON_DUPLICATE: return "duplicate";
    case CNCBF_REASON_TELEPORT: return "teleport";
    case CNCBF_REASON_CAPACITY_EXCEEDED: return "capacity_exceeded";
    case CNCBF_REASON_PORT_FAILED: return "port_failed";
    default: return "?";
    }
}

/* What an obstacle is. */
enum cncbf_obstacle_class {
    /* Perception did not say. */
    CNCBF_OBSTACLE_CLASS_UNKNOWN = 0,
    /* A person on foot. */
    CNCBF_OBSTACLE_CLASS_PEDESTRIAN = 1,
    /* A person on a bicycle or scooter. */
    CNCBF_OBSTACLE_CLASS_CYCLIST = 2,
    /* Something that does not move. */
    CNCBF_OBSTACLE_CLASS_STATIC = 3,
    /* Another robot or vehicle. */
    CNCBF_OBSTACLE_CLASS_VEHICLE = 4
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_obstacle_class_label(uint32_t code)
{
    switch (code) {
    case CNCBF_OBSTACLE_CLASS_UNKNOWN: return "unknown";
    case CNCBF_OBSTACLE_CLASS_PEDESTRIAN: return "pedestrian";
    case CNCBF_OBSTACLE_CLASS_CYCLIST: return "cyclist";
    case CNCBF_OBSTACLE_CLASS_STATIC: return "static";
    case CNCBF_OBSTACLE_CLASS_VEHICLE: return "vehicle";
    default: return "?";
    }
}

/* How far an obstacle's estimate can be trusted. */
enum cncbf_obstacle_quality {
    /* Position measured, velocity not known yet and reported as zero. */
    CNCBF_OBSTACLE_QUALITY_POSITION_ONLY = 1,
    /* Position and velocity known, their rate not yet. */
    CNCBF_OBSTACLE_QUALITY_VELOCITY = 2,
    /* Position, velocity and rate known. */
    CNCBF_OBSTACLE_QUALITY_FULL = 3,
    /* Not measured lately; predicted. */
    CNCBF_OBSTACLE_QUALITY_COASTING = 4
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_obstacle_quality_label(uint32_t code)
{
    switch (code) {
    case CNCBF_OBSTACLE_QUALITY_POSITION_ONLY: return "position_only";
    case CNCBF_OBSTACLE_QUALITY_VELOCITY: return "velocity";
    case CNCBF_OBSTACLE_QUALITY_FULL: return "full";
    case CNCBF_OBSTACLE_QUALITY_COASTING: return "coasting";
    default: return "?";
    }
}

/* A process of the stack. */
enum cncbf_process_id {
    /* `perception_bridge`. */
    CNCBF_PROCESS_ID_BRIDGE = 1,
    /* `obstacle_estimator`. */
    CNCBF_PROCESS_ID_ESTIMATOR = 2,
    /* `nominal_mpc`. */
    CNCBF_PROCESS_ID_NOMINAL = 3,
    /* `cbf_filter`. */
    CNCBF_PROCESS_ID_FILTER = 4,
    /* The recorder. */
    CNCBF_PROCESS_ID_RECORDER = 5,
    /* The launcher. */
    CNCBF_PROCESS_ID_LAUNCHER = 6
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_process_id_label(uint32_t code)
{
    switch (code) {
    case CNCBF_PROCESS_ID_BRIDGE: return "bridge";
    case CNCBF_PROCESS_ID_ESTIMATOR: return "estimator";
    case CNCBF_PROCESS_ID_NOMINAL: return "nominal";
    case CNCBF_PROCESS_ID_FILTER: return "filter";
    case CNCBF_PROCESS_ID_RECORDER: return "recorder";
    case CNCBF_PROCESS_ID_LAUNCHER: return "launcher";
    default: return "?";
    }
}

/* Where the bridge takes the world from. */
enum cncbf_source_kind {
    /* The simulated crowd. */
    CNCBF_SOURCE_KIND_SIMULATION = 1,
    /* A recording, played back. */
    CNCBF_SOURCE_KIND_MCAP = 2,
    /* A live ROS 2 graph. */
    CNCBF_SOURCE_KIND_ROS2 = 3
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_source_kind_label(uint32_t code)
{
    switch (code) {
    case CNCBF_SOURCE_KIND_SIMULATION: return "simulation";
    case CNCBF_SOURCE_KIND_MCAP: return "mcap";
    case CNCBF_SOURCE_KIND_ROS2: return "ros2";
    default: return "?";
    }
}

/* What began a cycle. */
enum cncbf_trigger {
    /* Its due time. */
    CNCBF_TRIGGER_TIMER = 0,
    /* Something arrived for the process. */
    CNCBF_TRIGGER_EVENT = 1
};

/* Name of a code as logs and reports write it; "?" for a code that this version does not know. */
static inline const char *cncbf_trigger_label(uint32_t code)
{
    switch (code) {
    case CNCBF_TRIGGER_TIMER: return "timer";
    case CNCBF_TRIGGER_EVENT: return "event";
    default: return "?";
    }
}

/* Bits of `CNCBF_HEALTH_REALTIME_ASKED` and `CNCBF_HEALTH_REALTIME_GRANTED`. */
enum cncbf_realtime_flags {
    /* Scheduling class SCHED_FIFO. */
    CNCBF_REALTIME_FLAGS_FIFO = 1,
    /* Runs on chosen processors only. */
    CNCBF_REALTIME_FLAGS_PROCESSORS = 2,
    /* All memory locked. */
    CNCBF_REALTIME_FLAGS_MEMORY_LOCK = 4,
    /* Heap and stack touched before the loop. */
    CNCBF_REALTIME_FLAGS_PREFAULT = 8,
    /* Timer slack. */
    CNCBF_REALTIME_FLAGS_TIMER_SLACK = 16,
    /* `/dev/cpu_dma_latency` held. */
    CNCBF_REALTIME_FLAGS_CPU_DMA_LATENCY = 32
};

/* Bits of `CNCBF_DETECTION_FLAGS`. */
enum cncbf_detection_flags {
    /* `velocity_in_odom_mps` was measured. */
    CNCBF_DETECTION_FLAGS_HAS_VELOCITY = 1,
    /* `position_covariance_m2` was given. */
    CNCBF_DETECTION_FLAGS_HAS_COVARIANCE = 2
};

/* When a process' cycle ran and what the kernel did to its thread meanwhile. Every process → recorder, once its outputs are
 * handed over; nothing on the path from sensor to command waits for it.
 *
 * Faults, switches and processor time count since the end of the previous cycle, so that nothing lies between two cycles
 * uncounted; one voluntary switch is the sleep before this cycle. */
typedef struct {
    /* Counts the cycles of one process, from 1. A gap is a lost record, a fall is a restart. */
    uint64_t sequence;
    /* When the cycle was due, stack clock, ns; 0 where an input began it. */
    uint64_t due_ns;
    /* When it began, stack clock, ns. */
    uint64_t woke_ns;
    /* When its outputs had been handed over, stack clock, ns. */
    uint64_t done_ns;
    /* Processor time of its thread, ns. */
    uint64_t cpu_ns;
    /* A `cncbf_process_id` code. */
    uint32_t process;
    /* The processor it ended on. */
    uint32_t processor;
    /* A `cncbf_trigger` code: what began it. */
    uint32_t trigger;
    /* Due times before `due_ns` that passed without a cycle. */
    uint32_t skipped;
    /* Page faults that needed no disk. */
    uint32_t minor_faults;
    /* Page faults that waited for the disk. */
    uint32_t major_faults;
    /* How often the thread gave up its processor. */
    uint32_t voluntary_switches;
    /* How often the thread was pushed off its processor. */
    uint32_t involuntary_switches;
} cncbf_cycle_t;

#define CNCBF_CYCLE_TYPE_NAME "cncbf/Cycle/v1"
#define CNCBF_CYCLE_SERVICE "cycles"
CNCBF_STATIC_ASSERT(sizeof(cncbf_cycle_t) == 72, "size of cncbf_cycle_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, sequence) == 0, "cncbf_cycle_t.sequence");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, due_ns) == 8, "cncbf_cycle_t.due_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, woke_ns) == 16, "cncbf_cycle_t.woke_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, done_ns) == 24, "cncbf_cycle_t.done_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, cpu_ns) == 32, "cncbf_cycle_t.cpu_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, process) == 40, "cncbf_cycle_t.process");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, processor) == 44, "cncbf_cycle_t.processor");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, trigger) == 48, "cncbf_cycle_t.trigger");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, skipped) == 52, "cncbf_cycle_t.skipped");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, minor_faults) == 56, "cncbf_cycle_t.minor_faults");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, major_faults) == 60, "cncbf_cycle_t.major_faults");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, voluntary_switches) == 64, "cncbf_cycle_t.voluntary_switches");
CNCBF_STATIC_ASSERT(offsetof(cncbf_cycle_t, involuntary_switches) == 68, "cncbf_cycle_t.involuntary_switches");

/* Counters of one process since it started. Every process → launcher, a few times a second. */
typedef struct {
    /* When this was published, stack clock, ns. */
    uint64_t published_ns;
    /* Cycles run. */
    uint64_t cycles;
    /* Cycles that began later than one whole period after they were due. */
    uint64_t missed_deadlines;
    /* Largest lateness of a cycle's beginning, ns. Never filtered. */
    uint64_t max_lateness_ns;
    /* Inputs used. */
    uint64_t accepted_inputs;
    /* Inputs refused, each for a stated reason. */
    uint64_t refused_inputs;
    /* A `cncbf_process_id` code. */
    uint32_t process;
    /* Operating-system process id. */
    uint32_t pid;
    /* A `cncbf_reason` code: the last thing that went wrong; `NONE` if nothing did. */
    uint32_t last_reason;
    /* How many things went wrong. */
    uint32_t errors;
    /* `cncbf_realtime_flags` bits of what the process asked the kernel for. */
    uint32_t realtime_asked;
    /* `cncbf_realtime_flags` bits of what the kernel granted. */
    uint32_t realtime_granted;
} cncbf_health_t;

#define CNCBF_HEALTH_TYPE_NAME "cncbf/Health/v2"
#define CNCBF_HEALTH_SERVICE "health"
CNCBF_STATIC_ASSERT(sizeof(cncbf_health_t) == 72, "size of cncbf_health_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, published_ns) == 0, "cncbf_health_t.published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, cycles) == 8, "cncbf_health_t.cycles");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, missed_deadlines) == 16, "cncbf_health_t.missed_deadlines");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, max_lateness_ns) == 24, "cncbf_health_t.max_lateness_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, accepted_inputs) == 32, "cncbf_health_t.accepted_inputs");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, refused_inputs) == 40, "cncbf_health_t.refused_inputs");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, process) == 48, "cncbf_health_t.process");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, pid) == 52, "cncbf_health_t.pid");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, last_reason) == 56, "cncbf_health_t.last_reason");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, errors) == 60, "cncbf_health_t.errors");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, realtime_asked) == 64, "cncbf_health_t.realtime_asked");
CNCBF_STATIC_ASSERT(offsetof(cncbf_health_t, realtime_granted) == 68, "cncbf_health_t.realtime_granted");

/* One perceived obstacle: a disc in `odom`. */
typedef struct {
    /* Identity given by perception; 0 where it gives none. */
    uint64_t track_id;
    /* Centre in `odom`, `[x, y]`, m. */
    double position_in_odom_m[2];
    /* Velocity of the centre in `odom`, `[x, y]`, m/s. Meaningful only with `CNCBF_DETECTION_FLAGS_HAS_VELOCITY`. */
    double velocity_in_odom_mps[2];
    /* Covariance of the position `[xx, xy, yy]`, m². Meaningful only with `CNCBF_DETECTION_FLAGS_HAS_COVARIANCE`. */
    double position_covariance_m2[3];
    /* Radius without the robot's own, m. */
    double radius_m;
    /* An `cncbf_obstacle_class` code. */
    uint32_t class_;
    /* `cncbf_detection_flags` bits. */
    uint32_t flags;
} cncbf_detection_t;

#define CNCBF_DETECTION_TYPE_NAME "cncbf/Detection/v1"
CNCBF_STATIC_ASSERT(sizeof(cncbf_detection_t) == 80, "size of cncbf_detection_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, track_id) == 0, "cncbf_detection_t.track_id");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, position_in_odom_m) == 8, "cncbf_detection_t.position_in_odom_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, velocity_in_odom_mps) == 24, "cncbf_detection_t.velocity_in_odom_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, position_covariance_m2) == 40, "cncbf_detection_t.position_covariance_m2");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, radius_m) == 64, "cncbf_detection_t.radius_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, class_) == 72, "cncbf_detection_t.class_");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detection_t, flags) == 76, "cncbf_detection_t.flags");

/* One tracked obstacle: a disc, its motion, and the rate at which that motion changes.
 *
 * Vectors are expressed in `odom`; none is relative to the robot. Both obstacle models of the paper are served: the
 * unicycle o = `[x, y, heading, speed]` and the double integrator o = `[x, y, vx, vy]`, each with its derivative ȯ. */
typedef struct {
    /* Identity kept while the track lives, never 0. */
    uint64_t track_id;
    /* Stack clock time of the newest measurement behind this estimate, ns. Not the send time. */
    uint64_t measured_at_ns;
    /* Stack clock time the estimate holds for, ns; later than `measured_at_ns` while the track coasts. */
    uint64_t valid_at_ns;
    /* Centre `[x, y]`, m. */
    double position_in_odom_m[2];
    /* Velocity of the centre `[x, y]`, m/s. */
    double velocity_in_odom_mps[2];
    /* Acceleration of the centre `[x, y]`, m/s². */
    double acceleration_in_odom_mps2[2];
    /* Direction of motion, rad in [-π, π); kept from the last clear motion while the obstacle stands. */
    double heading_rad;
    /* Rate of `heading_rad`, rad/s. */
    double heading_rate_radps;
    /* Speed along the heading, m/s, ≥ 0. */
    double speed_mps;
    /* Rate of `speed_mps`, m/s². */
    double speed_rate_mps2;
    /* Radius **without** the robot's own, m. Finite and > 0. */
    double radius_m;
    /* An `cncbf_obstacle_class` code. */
    uint32_t class_;
    /* An `cncbf_obstacle_quality` code. */
    uint32_t quality;
} cncbf_obstacle_t;

#define CNCBF_OBSTACLE_TYPE_NAME "cncbf/Obstacle/v1"
CNCBF_STATIC_ASSERT(sizeof(cncbf_obstacle_t) == 120, "size of cncbf_obstacle_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, track_id) == 0, "cncbf_obstacle_t.track_id");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, measured_at_ns) == 8, "cncbf_obstacle_t.measured_at_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, valid_at_ns) == 16, "cncbf_obstacle_t.valid_at_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, position_in_odom_m) == 24, "cncbf_obstacle_t.position_in_odom_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, velocity_in_odom_mps) == 40, "cncbf_obstacle_t.velocity_in_odom_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, acceleration_in_odom_mps2) == 56, "cncbf_obstacle_t.acceleration_in_odom_mps2");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, heading_rad) == 72, "cncbf_obstacle_t.heading_rad");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, heading_rate_radps) == 80, "cncbf_obstacle_t.heading_rate_radps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, speed_mps) == 88, "cncbf_obstacle_t.speed_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, speed_rate_mps2) == 96, "cncbf_obstacle_t.speed_rate_mps2");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, radius_m) == 104, "cncbf_obstacle_t.radius_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, class_) == 112, "cncbf_obstacle_t.class_");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacle_t, quality) == 116, "cncbf_obstacle_t.quality");

/* Stack clock times, ns, of everything that one safe command rests on. Zero where nothing arrived yet. */
typedef struct {
    /* Newest detections: sensor clock stamp. */
    uint64_t detections_source_ns;
    /* Newest detections: first seen by the bridge. */
    uint64_t detections_ingress_ns;
    /* Newest detections: published by the bridge. */
    uint64_t detections_published_ns;
    /* Newest detections: taken by the estimator. */
    uint64_t estimator_received_ns;
    /* Obstacles: published by the estimator. */
    uint64_t estimator_published_ns;
    /* Robot state: sensor clock stamp. */
    uint64_t robot_state_source_ns;
    /* Robot state: first seen by the bridge. */
    uint64_t robot_state_ingress_ns;
    /* Robot state: published by the bridge. */
    uint64_t robot_state_published_ns;
    /* Robot state behind the nominal command: taken by the controller. */
    uint64_t nominal_received_ns;
    /* Nominal command: published by the controller. */
    uint64_t nominal_published_ns;
    /* When this filter cycle was due; `filter_woke_ns` where an input began it. */
    uint64_t filter_due_ns;
    /* When this filter cycle began and took its inputs. */
    uint64_t filter_woke_ns;
    /* When the command was computed. */
    uint64_t filter_computed_ns;
    /* When the command was handed over. */
    uint64_t filter_published_ns;
    /* A `cncbf_trigger` code: what began this filter cycle. */
    uint32_t filter_trigger;
    /* Due times between the last cycle of the timer and `filter_due_ns` that passed without a cycle. */
    uint32_t filter_skipped;
    /* Page faults of the filter's thread since the previous command that needed no disk. */
    uint32_t minor_faults;
    /* Page faults of the filter's thread since the previous command that waited for the disk. */
    uint32_t major_faults;
    /* How often the filter's thread gave up its processor since the previous command; one is the sleep between them. */
    uint32_t voluntary_switches;
    /* How often the filter's thread was pushed off its processor since the previous command. */
    uint32_t involuntary_switches;
} cncbf_ledger_t;

#define CNCBF_LEDGER_TYPE_NAME "cncbf/Ledger/v2"
CNCBF_STATIC_ASSERT(sizeof(cncbf_ledger_t) == 136, "size of cncbf_ledger_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, detections_source_ns) == 0, "cncbf_ledger_t.detections_source_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, detections_ingress_ns) == 8, "cncbf_ledger_t.detections_ingress_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, detections_published_ns) == 16, "cncbf_ledger_t.detections_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, estimator_received_ns) == 24, "cncbf_ledger_t.estimator_received_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, estimator_published_ns) == 32, "cncbf_ledger_t.estimator_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, robot_state_source_ns) == 40, "cncbf_ledger_t.robot_state_source_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, robot_state_ingress_ns) == 48, "cncbf_ledger_t.robot_state_ingress_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, robot_state_published_ns) == 56, "cncbf_ledger_t.robot_state_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, nominal_received_ns) == 64, "cncbf_ledger_t.nominal_received_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, nominal_published_ns) == 72, "cncbf_ledger_t.nominal_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_due_ns) == 80, "cncbf_ledger_t.filter_due_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_woke_ns) == 88, "cncbf_ledger_t.filter_woke_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_computed_ns) == 96, "cncbf_ledger_t.filter_computed_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_published_ns) == 104, "cncbf_ledger_t.filter_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_trigger) == 112, "cncbf_ledger_t.filter_trigger");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, filter_skipped) == 116, "cncbf_ledger_t.filter_skipped");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, minor_faults) == 120, "cncbf_ledger_t.minor_faults");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, major_faults) == 124, "cncbf_ledger_t.major_faults");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, voluntary_switches) == 128, "cncbf_ledger_t.voluntary_switches");
CNCBF_STATIC_ASSERT(offsetof(cncbf_ledger_t, involuntary_switches) == 132, "cncbf_ledger_t.involuntary_switches");

/* The corrected command with its reasons. Filter → bridge, recorder. One per filter cycle, whatever happens. */
typedef struct {
    /* Counts the commands of one filter process, from 1. */
    uint64_t sequence;
    /* The command u*, in the unit of `control_kind`. Finite, always. */
    double control[2];
    /* The nominal command u_nom it was made from; zero if none was usable. */
    double nominal[2];
    /* A `cncbf_control_kind` code. */
    uint32_t control_kind;
    /* A `cncbf_safety_status` code: the rung of the ladder. */
    uint32_t status;
    /* A `cncbf_reason` code: why this rung. */
    uint32_t reason;
    /* Obstacles that entered the composite. */
    uint32_t obstacle_count;
    /* Composite barrier value h, m; `+∞` with no obstacle. */
    double h_m;
    /* Smallest ℓ: distance between the discs of robot and obstacle (growth by age and buffer included), m; `+∞` with none. */
    double sdf_m;
    /* L_f h + ∂h/∂t, m/s. */
    double drift_mps;
    /* L_g h, m/s per unit of control. */
    double lg_h[2];
    /* Class-κ gain α of this cycle, 1/s. */
    double alpha_per_s;
    /* Slack s that the CBF-QP needed, m/s. */
    double slack_mps;
    /* max over the input box of ḣ + αh, m/s: negative means no admissible control satisfies the condition. */
    double hard_margin_mps;
    /* Track that weighs most in the composite; 0 with none. */
    uint64_t critical_track_id;
    /* That obstacle's own h̄, m; `+∞` with none. */
    double critical_h_m;
    /* Robot position in `odom` the cycle used (predicted to its beginning), `[x, y]`, m. */
    double robot_position_in_odom_m[2];
    /* Robot heading the cycle used, rad. */
    double robot_heading_rad;
    /* Obstacles evaluated outside the domain the model was trained on. */
    uint32_t outside_domain;
    /* Evaluation kernel, an index into `barrier`'s kernel names; results are byte-identical only for equal kernels. */
    uint32_t kernel;
    /* The path from sensor to command. */
    cncbf_ledger_t ledger;
} cncbf_safe_command_t;

#define CNCBF_SAFE_COMMAND_TYPE_NAME "cncbf/SafeCommand/v2"
#define CNCBF_SAFE_COMMAND_SERVICE "safe_command"
CNCBF_STATIC_ASSERT(sizeof(cncbf_safe_command_t) == 304, "size of cncbf_safe_command_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, sequence) == 0, "cncbf_safe_command_t.sequence");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, control) == 8, "cncbf_safe_command_t.control");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, nominal) == 24, "cncbf_safe_command_t.nominal");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, control_kind) == 40, "cncbf_safe_command_t.control_kind");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, status) == 44, "cncbf_safe_command_t.status");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, reason) == 48, "cncbf_safe_command_t.reason");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, obstacle_count) == 52, "cncbf_safe_command_t.obstacle_count");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, h_m) == 56, "cncbf_safe_command_t.h_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, sdf_m) == 64, "cncbf_safe_command_t.sdf_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, drift_mps) == 72, "cncbf_safe_command_t.drift_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, lg_h) == 80, "cncbf_safe_command_t.lg_h");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, alpha_per_s) == 96, "cncbf_safe_command_t.alpha_per_s");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, slack_mps) == 104, "cncbf_safe_command_t.slack_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, hard_margin_mps) == 112, "cncbf_safe_command_t.hard_margin_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, critical_track_id) == 120, "cncbf_safe_command_t.critical_track_id");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, critical_h_m) == 128, "cncbf_safe_command_t.critical_h_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, robot_position_in_odom_m) == 136, "cncbf_safe_command_t.robot_position_in_odom_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, robot_heading_rad) == 152, "cncbf_safe_command_t.robot_heading_rad");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, outside_domain) == 160, "cncbf_safe_command_t.outside_domain");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, kernel) == 164, "cncbf_safe_command_t.kernel");
CNCBF_STATIC_ASSERT(offsetof(cncbf_safe_command_t, ledger) == 168, "cncbf_safe_command_t.ledger");

/* Progress of the bridge's source and, where the source knows the truth, the outcome so far. Bridge → launcher, recorder. */
typedef struct {
    /* When this was published, stack clock, ns. */
    uint64_t published_ns;
    /* Time the source has run, in its own time, ns. */
    uint64_t elapsed_ns;
    /* Time the source will run, ns; 0 where it has no end of its own. */
    uint64_t total_ns;
    /* Sensor messages handed on. */
    uint64_t accepted;
    /* Sensor messages refused, each logged with a reason. */
    uint64_t refused;
    /* Smallest distance between the true discs of robot and people so far, m; `+∞` if unknown. */
    double min_clearance_m;
    /* The same distance now, m; `+∞` if unknown. */
    double clearance_m;
    /* Length of the robot's path so far, m. */
    double path_length_m;
    /* Distance from the robot to its goal, m; `+∞` without a goal. */
    double goal_distance_m;
    /* Contacts between robot and people so far; each counts once, when it begins. */
    uint32_t collisions;
    /* 1 once the robot came within the goal tolerance, else 0. */
    uint32_t goal_reached;
    /* 1 once the source has nothing more to give, else 0. */
    uint32_t finished;
    /* A `cncbf_source_kind` code. */
    uint32_t kind;
} cncbf_source_status_t;

#define CNCBF_SOURCE_STATUS_TYPE_NAME "cncbf/SourceStatus/v1"
#define CNCBF_SOURCE_STATUS_SERVICE "source_status"
CNCBF_STATIC_ASSERT(sizeof(cncbf_source_status_t) == 88, "size of cncbf_source_status_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, published_ns) == 0, "cncbf_source_status_t.published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, elapsed_ns) == 8, "cncbf_source_status_t.elapsed_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, total_ns) == 16, "cncbf_source_status_t.total_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, accepted) == 24, "cncbf_source_status_t.accepted");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, refused) == 32, "cncbf_source_status_t.refused");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, min_clearance_m) == 40, "cncbf_source_status_t.min_clearance_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, clearance_m) == 48, "cncbf_source_status_t.clearance_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, path_length_m) == 56, "cncbf_source_status_t.path_length_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, goal_distance_m) == 64, "cncbf_source_status_t.goal_distance_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, collisions) == 72, "cncbf_source_status_t.collisions");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, goal_reached) == 76, "cncbf_source_status_t.goal_reached");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, finished) == 80, "cncbf_source_status_t.finished");
CNCBF_STATIC_ASSERT(offsetof(cncbf_source_status_t, kind) == 84, "cncbf_source_status_t.kind");

/* Identity and times of one message. */
typedef struct {
    /* Counts the messages of one publisher on one service, from 1. A gap is a lost message, a fall is a restart. */
    uint64_t sequence;
    /* Time of measurement on the sensor's clock, ns. For the log only: never compare it with the other stamps. */
    uint64_t source_ns;
    /* The same instant on the stack clock, ns: the time the content holds for. Physics uses this one. */
    uint64_t valid_at_ns;
    /* When the bridge first saw the measurement, stack clock, ns. */
    uint64_t ingress_ns;
    /* When the sender handed this message over, stack clock, ns. */
    uint64_t published_ns;
} cncbf_stamp_t;

#define CNCBF_STAMP_TYPE_NAME "cncbf/Stamp/v1"
CNCBF_STATIC_ASSERT(sizeof(cncbf_stamp_t) == 40, "size of cncbf_stamp_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_stamp_t, sequence) == 0, "cncbf_stamp_t.sequence");
CNCBF_STATIC_ASSERT(offsetof(cncbf_stamp_t, source_ns) == 8, "cncbf_stamp_t.source_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_stamp_t, valid_at_ns) == 16, "cncbf_stamp_t.valid_at_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_stamp_t, ingress_ns) == 24, "cncbf_stamp_t.ingress_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_stamp_t, published_ns) == 32, "cncbf_stamp_t.published_ns");

/* Target pose, or the next point of a path. Bridge → nominal controller. Holds until replaced. */
typedef struct {
    /* Identity and times. */
    cncbf_stamp_t stamp;
    /* Target position in `odom`, `[x, y]`, m. */
    double position_in_odom_m[2];
    /* Target heading in `odom`, rad in [-π, π). */
    double heading_rad;
} cncbf_goal_t;

#define CNCBF_GOAL_TYPE_NAME "cncbf/Goal/v1"
#define CNCBF_GOAL_SERVICE "goal"
CNCBF_STATIC_ASSERT(sizeof(cncbf_goal_t) == 64, "size of cncbf_goal_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_goal_t, stamp) == 0, "cncbf_goal_t.stamp");
CNCBF_STATIC_ASSERT(offsetof(cncbf_goal_t, position_in_odom_m) == 40, "cncbf_goal_t.position_in_odom_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_goal_t, heading_rad) == 56, "cncbf_goal_t.heading_rad");

/* Command of a nominal controller, which is blind to obstacles. Any nominal controller → filter. */
typedef struct {
    /* Own sequence and publication time; source, validity and ingress are those of the robot state it answers. */
    cncbf_stamp_t stamp;
    /* When the bridge published that robot state, stack clock, ns. */
    uint64_t bridge_published_ns;
    /* When the controller took it, stack clock, ns. */
    uint64_t received_ns;
    /* The control u_nom: `[speed m/s, yaw rate rad/s]` or `[ax, ay] m/s²` in `odom`, as `control_kind` says. */
    double control[2];
    /* A `cncbf_control_kind` code. */
    uint32_t control_kind;
    /* An `cncbf_intent` code: drive with `control`, or come to a halt whatever `control` says. */
    uint32_t intent;
    /* A `cncbf_controller` code, or any value ≥ 1,000 that an external controller chooses for itself. */
    uint32_t controller;
    /* Iterations or similar effort figure of the controller, for the log. */
    uint32_t effort;
} cncbf_nominal_command_t;

#define CNCBF_NOMINAL_COMMAND_TYPE_NAME "cncbf/NominalCommand/v1"
#define CNCBF_NOMINAL_COMMAND_SERVICE "nominal_command"
CNCBF_STATIC_ASSERT(sizeof(cncbf_nominal_command_t) == 88, "size of cncbf_nominal_command_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, stamp) == 0, "cncbf_nominal_command_t.stamp");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, bridge_published_ns) == 40, "cncbf_nominal_command_t.bridge_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, received_ns) == 48, "cncbf_nominal_command_t.received_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, control) == 56, "cncbf_nominal_command_t.control");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, control_kind) == 72, "cncbf_nominal_command_t.control_kind");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, intent) == 76, "cncbf_nominal_command_t.intent");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, controller) == 80, "cncbf_nominal_command_t.controller");
CNCBF_STATIC_ASSERT(offsetof(cncbf_nominal_command_t, effort) == 84, "cncbf_nominal_command_t.effort");

/* One frame of perception. Bridge → estimator. An empty frame says "nobody seen" and is not the same as silence. */
typedef struct {
    /* Identity and times; `valid_at_ns` is when the positions held. */
    cncbf_stamp_t stamp;
    /* How many of `items` are set. */
    uint32_t count;
    /* How many were perceived beyond `CNCBF_MAX_OBSTACLES` and left out, the farthest ones. */
    uint32_t left_out;
    /* The detections; entries from `count` on are zero. */
    cncbf_detection_t items[64];
} cncbf_detections_t;

#define CNCBF_DETECTIONS_TYPE_NAME "cncbf/Detections/v1"
#define CNCBF_DETECTIONS_SERVICE "detections"
CNCBF_STATIC_ASSERT(sizeof(cncbf_detections_t) == 5168, "size of cncbf_detections_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detections_t, stamp) == 0, "cncbf_detections_t.stamp");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detections_t, count) == 40, "cncbf_detections_t.count");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detections_t, left_out) == 44, "cncbf_detections_t.left_out");
CNCBF_STATIC_ASSERT(offsetof(cncbf_detections_t, items) == 48, "cncbf_detections_t.items");

/* Everything the estimator believes is around the robot. Estimator → filter and planners.
 *
 * Published on every `cncbf_detections_t` frame and, as a sign of life, on the estimator's heartbeat in between; the stamp
 * then still tells when perception last spoke. */
typedef struct {
    /* Own sequence and publication time; source, validity and ingress are those of the newest accepted frame. */
    cncbf_stamp_t stamp;
    /* When the bridge published that frame, stack clock, ns. */
    uint64_t bridge_published_ns;
    /* When the estimator took it, stack clock, ns. */
    uint64_t received_ns;
    /* How many of `items` are set. */
    uint32_t count;
    /* How many obstacles were left out on the way for want of room. */
    uint32_t left_out;
    /* The obstacles; entries from `count` on are zero. */
    cncbf_obstacle_t items[64];
} cncbf_obstacles_t;

#define CNCBF_OBSTACLES_TYPE_NAME "cncbf/Obstacles/v1"
#define CNCBF_OBSTACLES_SERVICE "obstacles"
CNCBF_STATIC_ASSERT(sizeof(cncbf_obstacles_t) == 7744, "size of cncbf_obstacles_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, stamp) == 0, "cncbf_obstacles_t.stamp");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, bridge_published_ns) == 40, "cncbf_obstacles_t.bridge_published_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, received_ns) == 48, "cncbf_obstacles_t.received_ns");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, count) == 56, "cncbf_obstacles_t.count");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, left_out) == 60, "cncbf_obstacles_t.left_out");
CNCBF_STATIC_ASSERT(offsetof(cncbf_obstacles_t, items) == 64, "cncbf_obstacles_t.items");

/* Pose of `base` in `odom` and the body's velocity. Bridge → everyone. */
typedef struct {
    /* Identity and times; `valid_at_ns` is when the pose held. */
    cncbf_stamp_t stamp;
    /* Origin of `base` in `odom`, `[x, y]`, m. */
    double position_in_odom_m[2];
    /* Angle from the x axis of `odom` to the x axis of `base`, rad in [-π, π). */
    double heading_rad;
    /* Velocity of `base` expressed in `base`, `[forward, left]`, m/s. */
    double velocity_in_base_mps[2];
    /* Rate of `heading_rad`, rad/s, positive to the left. */
    double yaw_rate_radps;
} cncbf_robot_state_t;

#define CNCBF_ROBOT_STATE_TYPE_NAME "cncbf/RobotState/v1"
#define CNCBF_ROBOT_STATE_SERVICE "robot_state"
CNCBF_STATIC_ASSERT(sizeof(cncbf_robot_state_t) == 88, "size of cncbf_robot_state_t");
CNCBF_STATIC_ASSERT(offsetof(cncbf_robot_state_t, stamp) == 0, "cncbf_robot_state_t.stamp");
CNCBF_STATIC_ASSERT(offsetof(cncbf_robot_state_t, position_in_odom_m) == 40, "cncbf_robot_state_t.position_in_odom_m");
CNCBF_STATIC_ASSERT(offsetof(cncbf_robot_state_t, heading_rad) == 56, "cncbf_robot_state_t.heading_rad");
CNCBF_STATIC_ASSERT(offsetof(cncbf_robot_state_t, velocity_in_base_mps) == 64, "cncbf_robot_state_t.velocity_in_base_mps");
CNCBF_STATIC_ASSERT(offsetof(cncbf_robot_state_t, yaw_rate_radps) == 80, "cncbf_robot_state_t.yaw_rate_radps");

#endif /* CNCBF_MESSAGES_H */
