/* A nominal controller for the unicycle in C: pure pursuit of the goal. It is blind to obstacles; the filter is not.
 *
 *     cargo build --release -p c_ports
 *     cc -std=c11 bindings/c/examples/pure_pursuit.c -Ibindings/c target/release/libcncbf.a -lpthread -ldl -lm -o pure_pursuit
 *     cncbf run --controller external &
 *     ./pure_pursuit [INSTANCE]
 *
 * Started beside another nominal controller, it waits and takes over once that one has gone. It answers robot states as they come,
 * 20 times a second at most.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <signal.h>
#include <stdio.h>

#include "cncbf.h"

/* Who this is, in recordings: external controllers choose a number from 1000 on. */
#define CONTROLLER 1001
#define NS_PER_MS 1000000ull
/* Least time between two commands. */
#define PERIOD_NS (50 * NS_PER_MS)
/* A robot state older than this is not answered. The filter brakes on silence. */
#define MAX_STATE_AGE_NS (100 * NS_PER_MS)
/* Between two looks at the wish to stop while another controller has the place. */
#define PATIENCE_NS (50 * NS_PER_MS)

#define SPEED_MPS 1.0
/* Speed of the tightest turn. */
#define MIN_SPEED_MPS 0.25
#define MAX_YAW_RATE_RADPS 0.8
/* Distance of the point ahead. */
#define LOOKAHEAD_M 1.5
/* Closer than this the goal is reached; who has reached it drives on only when twice as far away. */
#define TOLERANCE_M 0.3
#define RELEASE_TOLERANCES 2.0
#define HALF_TURN_RAD 3.14159265358979323846

static volatile sig_atomic_t stop_requested;

static void request_stop(int number)
{
    (void)number;
    stop_requested = 1;
}

static double clamp(double value, double low, double high)
{
    return fmin(fmax(value, low), high);
}

/* Speed, m/s, and yaw rate, rad/s, along the circle through a point ahead on the way to the goal. */
static void pursue(const cncbf_robot_state_t *state, const cncbf_goal_t *goal, double control[2])
{
    double dx = goal->position_in_odom_m[0] - state->position_in_odom_m[0];
    double dy = goal->position_in_odom_m[1] - state->position_in_odom_m[1];
    double bearing = remainder(atan2(dy, dx) - state->heading_rad, 2 * HALF_TURN_RAD);
    double ahead = clamp(hypot(dx, dy), 1e-3, LOOKAHEAD_M);
    /* Behind the robot the circle would become a straight line again: turn as for a point at its side. */
    double side = fabs(bearing) < HALF_TURN_RAD / 2 ? sin(bearing) : copysign(1.0, bearing);
    double curvature = 2 * side / ahead;
    double speed = clamp(MAX_YAW_RATE_RADPS / fmax(fabs(curvature), 1e-9), MIN_SPEED_MPS, SPEED_MPS);
    control[0] = speed;
    control[1] = clamp(speed * curvature, -MAX_YAW_RATE_RADPS, MAX_YAW_RATE_RADPS);
}

/* Whether the robot is at its goal, or still counts as being there. */
static int has_arrived(const cncbf_robot_state_t *state, const cncbf_goal_t *goal, int was_there)
{
    double distance = hypot(goal->position_in_odom_m[0] - state->position_in_odom_m[0],
                            goal->position_in_odom_m[1] - state->position_in_odom_m[1]);
    return distance <= (was_there ? RELEASE_TOLERANCES : 1.0) * TOLERANCE_M;
}

static int is_fresh(const cncbf_robot_state_t *state, uint64_t now_ns)
{
    uint64_t valid_ns = state->stamp.valid_at_ns;
    return now_ns > valid_ns ? now_ns - valid_ns <= MAX_STATE_AGE_NS : valid_ns - now_ns <= MAX_STATE_AGE_NS;
}

/* The control loop. */
static void drive(cncbf_reader_t *states, cncbf_reader_t *goals, cncbf_nominal_t *place)
{
    cncbf_robot_state_t state;
    cncbf_goal_t goal;
    int have_state = 0, have_goal = 0, arrived = 0;
    uint64_t received_ns = 0, due_ns = 0, sequence = 0;

    for (; !stop_requested; cncbf_nominal_wait(place, cncbf_now_ns() + PERIOD_NS)) {
        int is_new = cncbf_reader_newest(states, &state, sizeof state) == CNCBF_RESULT_OK;
        have_goal |= cncbf_reader_newest(goals, &goal, sizeof goal) == CNCBF_RESULT_OK;
        /* Only now: a state that came after the clock was read would be from the future. */
        uint64_t now_ns = cncbf_now_ns();
        if (is_new) {
            have_state = 1;
            received_ns = now_ns;
        }
        if (!have_state || !have_goal || now_ns < due_ns || !is_fresh(&state, now_ns))
            continue;
        arrived = has_arrived(&state, &goal, arrived);

        cncbf_nominal_command_t command = {
            .stamp = state.stamp,
            .bridge_published_ns = state.stamp.published_ns,
            .received_ns = received_ns,
            .control_kind = CNCBF_CONTROL_KIND_UNICYCLE,
            .intent = arrived ? CNCBF_INTENT_STOP : CNCBF_INTENT_DRIVE,
            .controller = CONTROLLER,
        };
        if (!arrived)
            pursue(&state, &goal, command.control);
        command.stamp.sequence = ++sequence;
        command.stamp.published_ns = cncbf_now_ns();
        if (cncbf_nominal_send(place, &command) != CNCBF_RESULT_OK)
            fprintf(stderr, "pure_pursuit: %s\n", cncbf_last_error());
        /* A little less than a period, for the next state may come a little early. */
        due_ns = now_ns + PERIOD_NS - NS_PER_MS;
    }
}

/* Takes the place, once the one who has it has gone. Null where that cannot be, or where somebody wants this program to end. */
static cncbf_nominal_t *take_place(const cncbf_node_t *node)
{
    cncbf_nominal_t *place = NULL;
    cncbf_result_t result = CNCBF_RESULT_TAKEN;
    int told = 0;
    while (!stop_requested && result == CNCBF_RESULT_TAKEN) {
        result = cncbf_nominal_open(node, PATIENCE_NS, &place);
        if (result == CNCBF_RESULT_TAKEN && !told++)
            fprintf(stderr, "pure_pursuit: waiting: %s\n", cncbf_last_error());
    }
    if (place != NULL)
        fprintf(stderr, "pure_pursuit: commands\n");
    if (result != CNCBF_RESULT_OK && result != CNCBF_RESULT_TAKEN)
        fprintf(stderr, "pure_pursuit: %s\n", cncbf_last_error());
    return place;
}

int main(int count, char **arguments)
{
    const char *instance = count > 1 ? arguments[1] : "cncbf";
    struct sigaction action = {.sa_handler = request_stop};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (cncbf_abi_version() != CNCBF_ABI_VERSION) {
        fprintf(stderr, "pure_pursuit: compiled against another version of the library; compile it again\n");
        return 1;
    }

    cncbf_node_t *node = NULL;
    cncbf_reader_t *states = NULL, *goals = NULL;
    cncbf_nominal_t *place = NULL;
    int opened = cncbf_node_open(instance, "nominal_c", &node) == CNCBF_RESULT_OK &&
                 cncbf_reader_open(node, CNCBF_ROBOT_STATE_TYPE_NAME, &states) == CNCBF_RESULT_OK &&
                 cncbf_reader_open(node, CNCBF_GOAL_TYPE_NAME, &goals) == CNCBF_RESULT_OK;
    if (!opened)
        fprintf(stderr, "pure_pursuit: %s\n", cncbf_last_error());
    else if ((place = take_place(node)) != NULL)
        drive(states, goals, place);

    cncbf_nominal_close(place);
    cncbf_reader_close(goals);
    cncbf_reader_close(states);
    cncbf_node_close(node);
    return place != NULL || (opened && stop_requested) ? 0 : 1;
}
