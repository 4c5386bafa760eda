"""Wire types of cncbf: what travels between its processes through iceoryx2's shared memory.

Generated from crates/messages by `cargo run -p bindings`; do not edit.

Fields that end in `_ns` are nanoseconds, all but `source_ns` on the stack clock, which is `time.monotonic_ns()`; 0 means
never. `odom` is the fixed, locally continuous world frame; `base` is the robot's own, x forward, y left. Numbers in
brackets after a field's name are how many values it holds.
"""

from __future__ import annotations

import ctypes
import enum


class Code(enum.IntEnum):
    """A code on the wire."""

    @property
    def label(self) -> str:
        """The name in logs and reports."""
        return self.name.lower()


def label_of(codes: type[Code], code: int) -> str:
    """The name of a code in logs and reports; `?` for one that this version does not know."""
    try:
        return codes(code).label
    except ValueError:
        return "?"


def _laid_out(structure: type[ctypes.Structure], size: int, offsets: dict[str, int]) -> None:
    """Refuses the import where this Python lays a structure out differently from the processes."""
    fields = {name: getattr(structure, name) for name, *_ in structure._fields_}
    found = {name: field.offset for name, field in fields.items()}
    whole = (ctypes.sizeof(structure), ctypes.alignment(structure), sum(field.size for field in fields.values()))
    if whole != (size, 8, size) or found != offsets:
        raise ImportError(f"{structure.__name__} is laid out differently here: {found}, {whole[0]} bytes")


#: Obstacles that one message can carry.
MAX_OBSTACLES = 64


class ControlKind(Code):
    """What the two numbers of a control vector mean."""

    #: `[speed m/s, yaw rate rad/s]` of a unicycle.
    UNICYCLE = 1
    #: `[ax, ay]` m/s² in `odom` of a double integrator.
    DOUBLE_INTEGRATOR = 2


class Intent(Code):
    """What a nominal controller wants."""

    #: Apply the control.
    DRIVE = 1
    #: Come to a halt and stay.
    STOP = 2


class Controller(Code):
    """Who made a nominal command."""

    #: Keeps still.
    HOLD = 1
    #: Model-predictive controller of the unicycle.
    MPC = 2
    #: Linear-quadratic regulator of the double integrator.
    LQR = 3
    #: Pure pursuit of the goal by the unicycle.
    PURE_PURSUIT = 4
    #: The robot's own: what it would be commanded without this stack, taken from a topic by the bridge.
    UPSTREAM = 5


class SafetyStatus(Code):
    """Rung of the safety ladder, from best to worst."""

    #: The nominal command passed the filter; the CBF condition holds.
    FILTERED = 1
    #: No admissible control satisfies the condition; the least violating one was chosen.
    RELAXED = 2
    #: Inputs cannot be trusted; the robot slows down to a halt.
    BRAKING = 3
    #: The robot stands and is kept standing.
    STOPPED = 4


class Reason(Code):
    """Why a rung was chosen, or what went wrong last."""

    #: Nothing is wrong.
    NONE = 0
    #: The CBF-QP needed slack beyond its tolerance.
    SLACK_NEEDED = 1
    #: The nominal controller asked for a halt.
    STOP_REQUESTED = 2
    #: The filter took a manoeuvre that keeps clear of everybody at once, as far as one does, not the CBF-QP's control.
    JOINT_ESCAPE = 3
    #: No robot state has arrived yet.
    NO_ROBOT_STATE = 10
    #: The newest robot state is too old.
    STALE_ROBOT_STATE = 11
    #: The newest robot state holds a NaN or an infinity.
    NON_FINITE_ROBOT_STATE = 12
    #: No obstacles message has arrived yet.
    NO_OBSTACLES = 20
    #: The estimator has fallen silent.
    SILENT_ESTIMATOR = 21
    #: The estimator lives but perception has been silent for too long.
    STALE_DETECTIONS = 22
    #: An obstacle holds a NaN, an infinity or a radius that is not positive.
    UNSOUND_OBSTACLE = 23
    #: No nominal command has arrived yet.
    NO_NOMINAL_COMMAND = 30
    #: The nominal controller has fallen silent.
    STALE_NOMINAL_COMMAND = 31
    #: The nominal command holds a NaN or an infinity.
    NON_FINITE_NOMINAL_COMMAND = 32
    #: The nominal command is for another kind of robot, or its codes are unknown.
    WRONG_CONTROL_KIND = 33
    #: The nominal controller has no goal to drive to.
    NO_GOAL = 34
    #: A stamp lies in the future by more than the tolerance.
    FUTURE_STAMP = 40
    #: A stamp runs backwards.
    BACKWARD_STAMP = 41
    #: A stamp is of another clock than the one that was agreed on: simulated time, or the time since a machine began.
    FOREIGN_CLOCK = 42
    #: The sender's clock has jumped.
    CLOCK_JUMP = 43
    #: The evaluation produced a NaN or an infinity.
    NON_FINITE_BARRIER = 50
    #: An optimisation did not converge.
    SOLVER_FAILED = 51
    #: The command sink has heard nothing from the filter for five periods.
    SILENT_FILTER = 60
    #: An input could not be decoded or made no sense.
    MALFORMED_INPUT = 70
    #: A coordinate frame is unknown or its transform too old.
    NO_TRANSFORM = 71
    #: Something appeared twice.
    DUPLICATE = 72
    #: An obstacle jumped farther than anything can move.
    TELEPORT = 73
    #: There was no room for more.
    CAPACITY_EXCEEDED = 74
    #: A port refused to send or to receive.
    PORT_FAILED = 80


class ObstacleClass(Code):
    """What an obstacle is."""

    #: Perception did not say.
    UNKNOWN = 0
    #: A person on foot.
    PEDESTRIAN = 1
    #: A person on a bicycle or scooter.
    CYCLIST = 2
    #: Something that does not move.
    STATIC = 3
    #: Another robot or vehicle.
    VEHICLE = 4


class ObstacleQuality(Code):
    """How far an obstacle's estimate can be trusted."""

    #: Position measured, velocity not known yet and reported as zero.
    POSITION_ONLY = 1
    #: Position and velocity known, their rate not yet.
    VELOCITY = 2
    #: Position, velocity and rate known.
    FULL = 3
    #: Not measured lately; predicted.
    COASTING = 4


class ProcessId(Code):
    """A process of the stack."""

    #: `perception_bridge`.
    BRIDGE = 1
    #: `obstacle_estimator`.
    ESTIMATOR = 2
    #: `nominal_mpc`.
    NOMINAL = 3
    #: `cbf_filter`.
    FILTER = 4
    #: The recorder.
    RECORDER = 5
    #: The launcher.
    LAUNCHER = 6


class SourceKind(Code):
    """Where the bridge takes the world from."""

    #: The simulated crowd.
    SIMULATION = 1
    #: A recording, played back.
    MCAP = 2
    #: A live ROS 2 graph.
    ROS2 = 3


class Trigger(Code):
    """What began a cycle."""

    #: Its due time.
    TIMER = 0
    #: Something arrived for the process.
    EVENT = 1


class RealtimeFlags(enum.IntFlag):
    """Bits of `Health.realtime_asked` and `Health.realtime_granted`."""

    #: Scheduling class SCHED_FIFO.
    FIFO = 1
    #: Runs on chosen processors only.
    PROCESSORS = 2
    #: All memory locked.
    MEMORY_LOCK = 4
    #: Heap and stack touched before the loop.
    PREFAULT = 8
    #: Timer slack.
    TIMER_SLACK = 16
    #: `/dev/cpu_dma_latency` held.
    CPU_DMA_LATENCY = 32


class DetectionFlags(enum.IntFlag):
    """Bits of `Detection.flags`."""

    #: `velocity_in_odom_mps` was measured.
    HAS_VELOCITY = 1
    #: `position_covariance_m2` was given.
    HAS_COVARIANCE = 2


class Cycle(ctypes.Structure):
    """When a process' cycle ran and what the kernel did to its thread meanwhile. Every process → recorder, once its outputs are
    handed over; nothing on the path from sensor to command waits for it.

    Faults, switches and processor time count since the end of the previous cycle, so that nothing lies between two cycles
    uncounted; one voluntary switch is the sleep before this cycle.

    Fields:
        sequence: Counts the cycles of one process, from 1. A gap is a lost record, a fall is a restart.
        due_ns: When the cycle was due, stack clock, ns; 0 where an input began it.
        woke_ns: When it began, stack clock, ns.
        done_ns: When its outputs had been handed over, stack clock, ns.
        cpu_ns: Processor time of its thread, ns.
        process: A `ProcessId` code.
        processor: The processor it ended on.
        trigger: A `Trigger` code: what began it.
        skipped: Due times before `due_ns` that passed without a cycle.
        minor_faults: Page faults that needed no disk.
        major_faults: Page faults that waited for the disk.
        voluntary_switches: How often the thread gave up its processor.
        involuntary_switches: How often the thread was pushed off its processor.
    """

    SERVICE = "cycles"
    TYPE_NAME = "cncbf/Cycle/v1"
    _fields_ = [
        ("sequence", ctypes.c_uint64),
        ("due_ns", ctypes.c_uint64),
        ("woke_ns", ctypes.c_uint64),
        ("done_ns", ctypes.c_uint64),
        ("cpu_ns", ctypes.c_uint64),
        ("process", ctypes.c_uint32),
        ("processor", ctypes.c_uint32),
        ("trigger", ctypes.c_uint32),
        ("skipped", ctypes.c_uint32),
        ("minor_faults", ctypes.c_uint32),
        ("major_faults", ctypes.c_uint32),
        ("voluntary_switches", ctypes.c_uint32),
        ("involuntary_switches", ctypes.c_uint32),
    ]

    sequence: int
    due_ns: int
    woke_ns: int
    done_ns: int
    cpu_ns: int
    process: int
    processor: int
    trigger: int
    skipped: int
    minor_faults: int
    major_faults: int
    voluntary_switches: int
    involuntary_switches: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Cycle.TYPE_NAME


_laid_out(Cycle, 72, {
    "sequence": 0,
    "due_ns": 8,
    "woke_ns": 16,
    "done_ns": 24,
    "cpu_ns": 32,
    "process": 40,
    "processor": 44,
    "trigger": 48,
    "skipped": 52,
    "minor_faults": 56,
    "major_faults": 60,
    "voluntary_switches": 64,
    "involuntary_switches": 68,
})


class Health(ctypes.Structure):
    """Counters of one process since it started. Every process → launcher, a few times a second.

    Fields:
        published_ns: When this was published, stack clock, ns.
        cycles: Cycles run.
        missed_deadlines: Cycles that began later than one whole period after they were due.
        max_lateness_ns: Largest lateness of a cycle's beginning, ns. Never filtered.
        accepted_inputs: Inputs used.
        refused_inputs: Inputs refused, each for a stated reason.
        process: A `ProcessId` code.
        pid: Operating-system process id.
        last_reason: A `Reason` code: the last thing that went wrong; `NONE` if nothing did.
        errors: How many things went wrong.
        realtime_asked: `RealtimeFlags` bits of what the process asked the kernel for.
        realtime_granted: `RealtimeFlags` bits of what the kernel granted.
    """

    SERVICE = "health"
    TYPE_NAME = "cncbf/Health/v2"
    _fields_ = [
        ("published_ns", ctypes.c_uint64),
        ("cycles", ctypes.c_uint64),
        ("missed_deadlines", ctypes.c_uint64),
        ("max_lateness_ns", ctypes.c_uint64),
        ("accepted_inputs", ctypes.c_uint64),
        ("refused_inputs", ctypes.c_uint64),
        ("process", ctypes.c_uint32),
        ("pid", ctypes.c_uint32),
        ("last_reason", ctypes.c_uint32),
        ("errors", ctypes.c_uint32),
        ("realtime_asked", ctypes.c_uint32),
        ("realtime_granted", ctypes.c_uint32),
    ]

    published_ns: int
    cycles: int
    missed_deadlines: int
    max_lateness_ns: int
    accepted_inputs: int
    refused_inputs: int
    process: int
    pid: int
    last_reason: int
    errors: int
    realtime_asked: int
    realtime_granted: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Health.TYPE_NAME


_laid_out(Health, 72, {
    "published_ns": 0,
    "cycles": 8,
    "missed_deadlines": 16,
    "max_lateness_ns": 24,
    "accepted_inputs": 32,
    "refused_inputs": 40,
    "process": 48,
    "pid": 52,
    "last_reason": 56,
    "errors": 60,
    "realtime_asked": 64,
    "realtime_granted": 68,
})


class Detection(ctypes.Structure):
    """One perceived obstacle: a disc in `odom`.

    Fields:
        track_id: Identity given by perception; 0 where it gives none.
        position_in_odom_m [2]: Centre in `odom`, `[x, y]`, m.
        velocity_in_odom_mps [2]: Velocity of the centre in `odom`, `[x, y]`, m/s. Meaningful only with `DetectionFlags.HAS_VELOCITY`.
        position_covariance_m2 [3]: Covariance of the position `[xx, xy, yy]`, m². Meaningful only with `DetectionFlags.HAS_COVARIANCE`.
        radius_m: Radius without the robot's own, m.
        class_: An `ObstacleClass` code.
        flags: `DetectionFlags` bits.
    """

    TYPE_NAME = "cncbf/Detection/v1"
    _fields_ = [
        ("track_id", ctypes.c_uint64),
        ("position_in_odom_m", ctypes.c_double * 2),
        ("velocity_in_odom_mps", ctypes.c_double * 2),
        ("position_covariance_m2", ctypes.c_double * 3),
        ("radius_m", ctypes.c_double),
        ("class_", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
    ]

    track_id: int
    position_in_odom_m: ctypes.Array[ctypes.c_double]
    velocity_in_odom_mps: ctypes.Array[ctypes.c_double]
    position_covariance_m2: ctypes.Array[ctypes.c_double]
    radius_m: float
    class_: int
    flags: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Detection.TYPE_NAME


_laid_out(Detection, 80, {
    "track_id": 0,
    "position_in_odom_m": 8,
    "velocity_in_odom_mps": 24,
    "position_covariance_m2": 40,
    "radius_m": 64,
    "class_": 72,
    "flags": 76,
})


class Obstacle(ctypes.Structure):
    """One tracked obstacle: a disc, its motion, and the rate at which that motion changes.

    Vectors are expressed in `odom`; none is relative to the robot. Both obstacle models of the paper are served: the
    unicycle o = `[x, y, heading, speed]` and the double integrator o = `[x, y, vx, vy]`, each with its derivative ȯ.

    Fields:
        track_id: Identity kept while the track lives, never 0.
        measured_at_ns: Stack clock time of the newest measurement behind this estimate, ns. Not the send time.
        valid_at_ns: Stack clock time the estimate holds for, ns; later than `measured_at_ns` while the track coasts.
        position_in_odom_m [2]: Centre `[x, y]`, m.
        velocity_in_odom_mps [2]: Velocity of the centre `[x, y]`, m/s.
        acceleration_in_odom_mps2 [2]: Acceleration of the centre `[x, y]`, m/s².
        heading_rad: Direction of motion, rad in [-π, π); kept from the last clear motion while the obstacle stands.
        heading_rate_radps: Rate of `heading_rad`, rad/s.
        speed_mps: Speed along the heading, m/s, ≥ 0.
        speed_rate_mps2: Rate of `speed_mps`, m/s².
        radius_m: Radius **without** the robot's own, m. Finite and > 0.
        class_: An `ObstacleClass` code.
        quality: An `ObstacleQuality` code.
    """

    TYPE_NAME = "cncbf/Obstacle/v1"
    _fields_ = [
        ("track_id", ctypes.c_uint64),
        ("measured_at_ns", ctypes.c_uint64),
        ("valid_at_ns", ctypes.c_uint64),
        ("position_in_odom_m", ctypes.c_double * 2),
        ("velocity_in_odom_mps", ctypes.c_double * 2),
        ("acceleration_in_odom_mps2", ctypes.c_double * 2),
        ("heading_rad", ctypes.c_double),
        ("heading_rate_radps", ctypes.c_double),
        ("speed_mps", ctypes.c_double),
        ("speed_rate_mps2", ctypes.c_double),
        ("radius_m", ctypes.c_double),
        ("class_", ctypes.c_uint32),
        ("quality", ctypes.c_uint32),
    ]

    track_id: int
    measured_at_ns: int
    valid_at_ns: int
    position_in_odom_m: ctypes.Array[ctypes.c_double]
    velocity_in_odom_mps: ctypes.Array[ctypes.c_double]
    acceleration_in_odom_mps2: ctypes.Array[ctypes.c_double]
    heading_rad: float
    heading_rate_radps: float
    speed_mps: float
    speed_rate_mps2: float
    radius_m: float
    class_: int
    quality: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Obstacle.TYPE_NAME


_laid_out(Obstacle, 120, {
    "track_id": 0,
    "measured_at_ns": 8,
    "valid_at_ns": 16,
    "position_in_odom_m": 24,
    "velocity_in_odom_mps": 40,
    "acceleration_in_odom_mps2": 56,
    "heading_rad": 72,
    "heading_rate_radps": 80,
    "speed_mps": 88,
    "speed_rate_mps2": 96,
    "radius_m": 104,
    "class_": 112,
    "quality": 116,
})


class Ledger(ctypes.Structure):
    """Stack clock times, ns, of everything that one safe command rests on. Zero where nothing arrived yet.

    Fields:
        detections_source_ns: Newest detections: sensor clock stamp.
        detections_ingress_ns: Newest detections: first seen by the bridge.
        detections_published_ns: Newest detections: published by the bridge.
        estimator_received_ns: Newest detections: taken by the estimator.
        estimator_published_ns: Obstacles: published by the estimator.
        robot_state_source_ns: Robot state: sensor clock stamp.
        robot_state_ingress_ns: Robot state: first seen by the bridge.
        robot_state_published_ns: Robot state: published by the bridge.
        nominal_received_ns: Robot state behind the nominal command: taken by the controller.
        nominal_published_ns: Nominal command: published by the controller.
        filter_due_ns: When this filter cycle was due; `filter_woke_ns` where an input began it.
        filter_woke_ns: When this filter cycle began and took its inputs.
        filter_computed_ns: When the command was computed.
        filter_published_ns: When the command was handed over.
        filter_trigger: A `Trigger` code: what began this filter cycle.
        filter_skipped: Due times between the last cycle of the timer and `filter_due_ns` that passed without a cycle.
        minor_faults: Page faults of the filter's thread since the previous command that needed no disk.
        major_faults: Page faults of the filter's thread since the previous command that waited for the disk.
        voluntary_switches: How often the filter's thread gave up its processor since the previous command; one is the sleep between them.
        involuntary_switches: How often the filter's thread was pushed off its processor since the previous command.
    """

    TYPE_NAME = "cncbf/Ledger/v2"
    _fields_ = [
        ("detections_source_ns", ctypes.c_uint64),
        ("detections_ingress_ns", ctypes.c_uint64),
        ("detections_published_ns", ctypes.c_uint64),
        ("estimator_received_ns", ctypes.c_uint64),
        ("estimator_published_ns", ctypes.c_uint64),
        ("robot_state_source_ns", ctypes.c_uint64),
        ("robot_state_ingress_ns", ctypes.c_uint64),
        ("robot_state_published_ns", ctypes.c_uint64),
        ("nominal_received_ns", ctypes.c_uint64),
        ("nominal_published_ns", ctypes.c_uint64),
        ("filter_due_ns", ctypes.c_uint64),
        ("filter_woke_ns", ctypes.c_uint64),
        ("filter_computed_ns", ctypes.c_uint64),
        ("filter_published_ns", ctypes.c_uint64),
        ("filter_trigger", ctypes.c_uint32),
        ("filter_skipped", ctypes.c_uint32),
        ("minor_faults", ctypes.c_uint32),
        ("major_faults", ctypes.c_uint32),
        ("voluntary_switches", ctypes.c_uint32),
        ("involuntary_switches", ctypes.c_uint32),
    ]

    detections_source_ns: int
    detections_ingress_ns: int
    detections_published_ns: int
    estimator_received_ns: int
    estimator_published_ns: int
    robot_state_source_ns: int
    robot_state_ingress_ns: int
    robot_state_published_ns: int
    nominal_received_ns: int
    nominal_published_ns: int
    filter_due_ns: int
    filter_woke_ns: int
    filter_computed_ns: int
    filter_published_ns: int
    filter_trigger: int
    filter_skipped: int
    minor_faults: int
    major_faults: int
    voluntary_switches: int
    involuntary_switches: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Ledger.TYPE_NAME


_laid_out(Ledger, 136, {
    "detections_source_ns": 0,
    "detections_ingress_ns": 8,
    "detections_published_ns": 16,
    "estimator_received_ns": 24,
    "estimator_published_ns": 32,
    "robot_state_source_ns": 40,
    "robot_state_ingress_ns": 48,
    "robot_state_published_ns": 56,
    "nominal_received_ns": 64,
    "nominal_published_ns": 72,
    "filter_due_ns": 80,
    "filter_woke_ns": 88,
    "filter_computed_ns": 96,
    "filter_published_ns": 104,
    "filter_trigger": 112,
    "filter_skipped": 116,
    "minor_faults": 120,
    "major_faults": 124,
    "voluntary_switches": 128,
    "involuntary_switches": 132,
})


class SafeCommand(ctypes.Structure):
    """The corrected command with its reasons. Filter → bridge, recorder. One per filter cycle, whatever happens.

    Fields:
        sequence: Counts the commands of one filter process, from 1.
        control [2]: The command u*, in the unit of `control_kind`. Finite, always.
        nominal [2]: The nominal command u_nom it was made from; zero if none was usable.
        control_kind: A `ControlKind` code.
        status: A `SafetyStatus` code: the rung of the ladder.
        reason: A `Reason` code: why this rung.
        obstacle_count: Obstacles that entered the composite.
        h_m: Composite barrier value h, m; `+∞` with no obstacle.
        sdf_m: Smallest ℓ: distance between the discs of robot and obstacle (growth by age and buffer included), m; `+∞` with none.
        drift_mps: L_f h + ∂h/∂t, m/s.
        lg_h [2]: L_g h, m/s per unit of control.
        alpha_per_s: Class-κ gain α of this cycle, 1/s.
        slack_mps: Slack s that the CBF-QP needed, m/s.
        hard_margin_mps: max over the input box of ḣ + αh, m/s: negative means no admissible control satisfies the condition.
        critical_track_id: Track that weighs most in the composite; 0 with none.
        critical_h_m: That obstacle's own h̄, m; `+∞` with none.
        robot_position_in_odom_m [2]: Robot position in `odom` the cycle used (predicted to its beginning), `[x, y]`, m.
        robot_heading_rad: Robot heading the cycle used, rad.
        outside_domain: Obstacles evaluated outside the domain the model was trained on.
        kernel: Evaluation kernel, an index into `barrier`'s kernel names; results are byte-identical only for equal kernels.
        ledger: The path from sensor to command.
    """

    SERVICE = "safe_command"
    TYPE_NAME = "cncbf/SafeCommand/v2"
    _fields_ = [
        ("sequence", ctypes.c_uint64),
        ("control", ctypes.c_double * 2),
        ("nominal", ctypes.c_double * 2),
        ("control_kind", ctypes.c_uint32),
        ("status", ctypes.c_uint32),
        ("reason", ctypes.c_uint32),
        ("obstacle_count", ctypes.c_uint32),
        ("h_m", ctypes.c_double),
        ("sdf_m", ctypes.c_double),
        ("drift_mps", ctypes.c_double),
        ("lg_h", ctypes.c_double * 2),
        ("alpha_per_s", ctypes.c_double),
        ("slack_mps", ctypes.c_double),
        ("hard_margin_mps", ctypes.c_double),
        ("critical_track_id", ctypes.c_uint64),
        ("critical_h_m", ctypes.c_double),
        ("robot_position_in_odom_m", ctypes.c_double * 2),
        ("robot_heading_rad", ctypes.c_double),
        ("outside_domain", ctypes.c_uint32),
        ("kernel", ctypes.c_uint32),
        ("ledger", Ledger),
    ]

    sequence: int
    control: ctypes.Array[ctypes.c_double]
    nominal: ctypes.Array[ctypes.c_double]
    control_kind: int
    status: int
    reason: int
    obstacle_count: int
    h_m: float
    sdf_m: float
    drift_mps: float
    lg_h: ctypes.Array[ctypes.c_double]
    alpha_per_s: float
    slack_mps: float
    hard_margin_mps: float
    critical_track_id: int
    critical_h_m: float
    robot_position_in_odom_m: ctypes.Array[ctypes.c_double]
    robot_heading_rad: float
    outside_domain: int
    kernel: int
    ledger: Ledger

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return SafeCommand.TYPE_NAME


_laid_out(SafeCommand, 304, {
    "sequence": 0,
    "control": 8,
    "nominal": 24,
    "control_kind": 40,
    "status": 44,
    "reason": 48,
    "obstacle_count": 52,
    "h_m": 56,
    "sdf_m": 64,
    "drift_mps": 72,
    "lg_h": 80,
    "alpha_per_s": 96,
    "slack_mps": 104,
    "hard_margin_mps": 112,
    "critical_track_id": 120,
    "critical_h_m": 128,
    "robot_position_in_odom_m": 136,
    "robot_heading_rad": 152,
    "outside_domain": 160,
    "kernel": 164,
    "ledger": 168,
})


class SourceStatus(ctypes.Structure):
    """Progress of the bridge's source and, where the source knows the truth, the outcome so far. Bridge → launcher, recorder.

    Fields:
        published_ns: When this was published, stack clock, ns.
        elapsed_ns: Time the source has run, in its own time, ns.
        total_ns: Time the source will run, ns; 0 where it has no end of its own.
        accepted: Sensor messages handed on.
        refused: Sensor messages refused, each logged with a reason.
        min_clearance_m: Smallest distance between the true discs of robot and people so far, m; `+∞` if unknown.
        clearance_m: The same distance now, m; `+∞` if unknown.
        path_length_m: Length of the robot's path so far, m.
        goal_distance_m: Distance from the robot to its goal, m; `+∞` without a goal.
        collisions: Contacts between robot and people so far; each counts once, when it begins.
        goal_reached: 1 once the robot came within the goal tolerance, else 0.
        finished: 1 once the source has nothing more to give, else 0.
        kind: A `SourceKind` code.
    """

    SERVICE = "source_status"
    TYPE_NAME = "cncbf/SourceStatus/v1"
    _fields_ = [
        ("published_ns", ctypes.c_uint64),
        ("elapsed_ns", ctypes.c_uint64),
        ("total_ns", ctypes.c_uint64),
        ("accepted", ctypes.c_uint64),
        ("refused", ctypes.c_uint64),
        ("min_clearance_m", ctypes.c_double),
        ("clearance_m", ctypes.c_double),
        ("path_length_m", ctypes.c_double),
        ("goal_distance_m", ctypes.c_double),
        ("collisions", ctypes.c_uint32),
        ("goal_reached", ctypes.c_uint32),
        ("finished", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
    ]

    published_ns: int
    elapsed_ns: int
    total_ns: int
    accepted: int
    refused: int
    min_clearance_m: float
    clearance_m: float
    path_length_m: float
    goal_distance_m: float
    collisions: int
    goal_reached: int
    finished: int
    kind: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return SourceStatus.TYPE_NAME


_laid_out(SourceStatus, 88, {
    "published_ns": 0,
    "elapsed_ns": 8,
    "total_ns": 16,
    "accepted": 24,
    "refused": 32,
    "min_clearance_m": 40,
    "clearance_m": 48,
    "path_length_m": 56,
    "goal_distance_m": 64,
    "collisions": 72,
    "goal_reached": 76,
    "finished": 80,
    "kind": 84,
})


class Stamp(ctypes.Structure):
    """Identity and times of one message.

    Fields:
        sequence: Counts the messages of one publisher on one service, from 1. A gap is a lost message, a fall is a restart.
        source_ns: Time of measurement on the sensor's clock, ns. For the log only: never compare it with the other stamps.
        valid_at_ns: The same instant on the stack clock, ns: the time the content holds for. Physics uses this one.
        ingress_ns: When the bridge first saw the measurement, stack clock, ns.
        published_ns: When the sender handed this message over, stack clock, ns.
    """

    TYPE_NAME = "cncbf/Stamp/v1"
    _fields_ = [
        ("sequence", ctypes.c_uint64),
        ("source_ns", ctypes.c_uint64),
        ("valid_at_ns", ctypes.c_uint64),
        ("ingress_ns", ctypes.c_uint64),
        ("published_ns", ctypes.c_uint64),
    ]

    sequence: int
    source_ns: int
    valid_at_ns: int
    ingress_ns: int
    published_ns: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Stamp.TYPE_NAME


_laid_out(Stamp, 40, {
    "sequence": 0,
    "source_ns": 8,
    "valid_at_ns": 16,
    "ingress_ns": 24,
    "published_ns": 32,
})


class Goal(ctypes.Structure):
    """Target pose, or the next point of a path. Bridge → nominal controller. Holds until replaced.

    Fields:
        stamp: Identity and times.
        position_in_odom_m [2]: Target position in `odom`, `[x, y]`, m.
        heading_rad: Target heading in `odom`, rad in [-π, π).
    """

    SERVICE = "goal"
    TYPE_NAME = "cncbf/Goal/v1"
    _fields_ = [
        ("stamp", Stamp),
        ("position_in_odom_m", ctypes.c_double * 2),
        ("heading_rad", ctypes.c_double),
    ]

    stamp: Stamp
    position_in_odom_m: ctypes.Array[ctypes.c_double]
    heading_rad: float

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Goal.TYPE_NAME


_laid_out(Goal, 64, {
    "stamp": 0,
    "position_in_odom_m": 40,
    "heading_rad": 56,
})


class NominalCommand(ctypes.Structure):
    """Command of a nominal controller, which is blind to obstacles. Any nominal controller → filter.

    Fields:
        stamp: Own sequence and publication time; source, validity and ingress are those of the robot state it answers.
        bridge_published_ns: When the bridge published that robot state, stack clock, ns.
        received_ns: When the controller took it, stack clock, ns.
        control [2]: The control u_nom: `[speed m/s, yaw rate rad/s]` or `[ax, ay] m/s²` in `odom`, as `control_kind` says.
        control_kind: A `ControlKind` code.
        intent: An `Intent` code: drive with `control`, or come to a halt whatever `control` says.
        controller: A `Controller` code, or any value ≥ 1,000 that an external controller chooses for itself.
        effort: Iterations or similar effort figure of the controller, for the log.
    """

    SERVICE = "nominal_command"
    TYPE_NAME = "cncbf/NominalCommand/v1"
    _fields_ = [
        ("stamp", Stamp),
        ("bridge_published_ns", ctypes.c_uint64),
        ("received_ns", ctypes.c_uint64),
        ("control", ctypes.c_double * 2),
        ("control_kind", ctypes.c_uint32),
        ("intent", ctypes.c_uint32),
        ("controller", ctypes.c_uint32),
        ("effort", ctypes.c_uint32),
    ]

    stamp: Stamp
    bridge_published_ns: int
    received_ns: int
    control: ctypes.Array[ctypes.c_double]
    control_kind: int
    intent: int
    controller: int
    effort: int

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return NominalCommand.TYPE_NAME


_laid_out(NominalCommand, 88, {
    "stamp": 0,
    "bridge_published_ns": 40,
    "received_ns": 48,
    "control": 56,
    "control_kind": 72,
    "intent": 76,
    "controller": 80,
    "effort": 84,
})


class Detections(ctypes.Structure):
    """One frame of perception. Bridge → estimator. An empty frame says "nobody seen" and is not the same as silence.

    Fields:
        stamp: Identity and times; `valid_at_ns` is when the positions held.
        count: How many of `items` are set.
        left_out: How many were perceived beyond `MAX_OBSTACLES` and left out, the farthest ones.
        items [64]: The detections; entries from `count` on are zero.
    """

    SERVICE = "detections"
    TYPE_NAME = "cncbf/Detections/v1"
    _fields_ = [
        ("stamp", Stamp),
        ("count", ctypes.c_uint32),
        ("left_out", ctypes.c_uint32),
        ("items", Detection * 64),
    ]

    stamp: Stamp
    count: int
    left_out: int
    items: ctypes.Array[Detection]

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Detections.TYPE_NAME


_laid_out(Detections, 5168, {
    "stamp": 0,
    "count": 40,
    "left_out": 44,
    "items": 48,
})


class Obstacles(ctypes.Structure):
    """Everything the estimator believes is around the robot. Estimator → filter and planners.

    Published on every `Detections` frame and, as a sign of life, on the estimator's heartbeat in between; the stamp
    then still tells when perception last spoke.

    Fields:
        stamp: Own sequence and publication time; source, validity and ingress are those of the newest accepted frame.
        bridge_published_ns: When the bridge published that frame, stack clock, ns.
        received_ns: When the estimator took it, stack clock, ns.
        count: How many of `items` are set.
        left_out: How many obstacles were left out on the way for want of room.
        items [64]: The obstacles; entries from `count` on are zero.
    """

    SERVICE = "obstacles"
    TYPE_NAME = "cncbf/Obstacles/v1"
    _fields_ = [
        ("stamp", Stamp),
        ("bridge_published_ns", ctypes.c_uint64),
        ("received_ns", ctypes.c_uint64),
        ("count", ctypes.c_uint32),
        ("left_out", ctypes.c_uint32),
        ("items", Obstacle * 64),
    ]

    stamp: Stamp
    bridge_published_ns: int
    received_ns: int
    count: int
    left_out: int
    items: ctypes.Array[Obstacle]

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return Obstacles.TYPE_NAME


_laid_out(Obstacles, 7744, {
    "stamp": 0,
    "bridge_published_ns": 40,
    "received_ns": 48,
    "count": 56,
    "left_out": 60,
    "items": 64,
})


class RobotState(ctypes.Structure):
    """Pose of `base` in `odom` and the body's velocity. Bridge → everyone.

    Fields:
        stamp: Identity and times; `valid_at_ns` is when the pose held.
        position_in_odom_m [2]: Origin of `base` in `odom`, `[x, y]`, m.
        heading_rad: Angle from the x axis of `odom` to the x axis of `base`, rad in [-π, π).
        velocity_in_base_mps [2]: Velocity of `base` expressed in `base`, `[forward, left]`, m/s.
        yaw_rate_radps: Rate of `heading_rad`, rad/s, positive to the left.
    """

    SERVICE = "robot_state"
    TYPE_NAME = "cncbf/RobotState/v1"
    _fields_ = [
        ("stamp", Stamp),
        ("position_in_odom_m", ctypes.c_double * 2),
        ("heading_rad", ctypes.c_double),
        ("velocity_in_base_mps", ctypes.c_double * 2),
        ("yaw_rate_radps", ctypes.c_double),
    ]

    stamp: Stamp
    position_in_odom_m: ctypes.Array[ctypes.c_double]
    heading_rad: float
    velocity_in_base_mps: ctypes.Array[ctypes.c_double]
    yaw_rate_radps: float

    @staticmethod
    def type_name() -> str:
        """What iceoryx2 compares when a port is opened."""
        return RobotState.TYPE_NAME


_laid_out(RobotState, 88, {
    "stamp": 0,
    "position_in_odom_m": 40,
    "heading_rad": 56,
    "velocity_in_base_mps": 64,
    "yaw_rate_radps": 80,
})


#: Every type that travels on a service of its own.
MESSAGES = (Cycle, Health, SafeCommand, SourceStatus, Goal, NominalCommand, Detections, Obstacles, RobotState)

__all__ = [
    "ControlKind",
    "Controller",
    "Cycle",
    "Detection",
    "DetectionFlags",
    "Detections",
    "Goal",
    "Health",
    "Intent",
    "Ledger",
    "MAX_OBSTACLES",
    "MESSAGES",
    "NominalCommand",
    "Obstacle",
    "ObstacleClass",
    "ObstacleQuality",
    "Obstacles",
    "ProcessId",
    "RealtimeFlags",
    "Reason",
    "RobotState",
    "SafeCommand",
    "SafetyStatus",
    "SourceKind",
    "SourceStatus",
    "Stamp",
    "Trigger",
    "label_of",
]
