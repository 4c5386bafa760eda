"""How much people of the social force model turn and accelerate, and what the rule at their goals does to it.

Written from the formulas alone, in numpy, apart from crates/crowd_sim. Two rules are compared: `rest`, as in crates/crowd_sim,
where whoever reaches a goal stays put for one tick and starts from rest; and `carry`, where the same tick keeps the velocity.

    python -m venv /some/venv && /some/venv/bin/pip install numpy
    /some/venv/bin/python tests/judges/crowd_motion.py shares
    /some/venv/bin/python tests/judges/crowd_motion.py scenarios RULE PEOPLE FIRST COUNT FILE.json

`shares` prints shares of all people's time. `scenarios` writes worlds of recorded tracks for `cncbf evaluate --scenarios`; the
same FIRST gives both rules the same starts, goals and speeds, and world FIRST + k is the same in every file. A file has
room for about 25 worlds of 20 people.
"""

import json
import sys

import numpy as np

TICK_S, TRACK_TICKS, TRACK_S = 0.01, 2, 30.0
ARENA_M = np.array([16.0, 10.0])
START_M = np.array([-2.0, 0.0])
GOAL_GAIN_PER_S, SOCIAL_MPS2, LAMBDA, GAMMA = 2.0 / 0.5, 5.0, 2.0, 0.35
ALONG, ACROSS = 3.0, 2.0
GOAL_RADIUS_M, REACHED_MARGIN_M = 0.3, 0.1
WALKING_MPS = 0.1


def wrap(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def norm(vector):
    return np.hypot(vector[..., 0], vector[..., 1])


def draw(first, count, people):
    """Places, three goals each, and speeds: [world, person, ...]."""
    places = np.zeros((count, people, 2))
    goals = np.zeros((count, people, 3, 2))
    speeds = np.zeros((count, people))
    for world in range(count):
        random = np.random.default_rng(first + world)

        def point(random=random):
            return random.uniform(0.0, 1.0, 2) * ARENA_M - [0.0, 0.5 * ARENA_M[1]]

        for person in range(people):
            place = point()
            while norm(place - START_M) < 2.0 or (norm(places[world, :person] - place) < 0.7).any():
                place = point()
            places[world, person] = place
            low, high = [0.0, -0.5 * ARENA_M[1]], [ARENA_M[0], 0.5 * ARENA_M[1]]
            goals[world, person] = np.stack([random.uniform(low[k], high[k], 3) for k in range(2)], -1)
            speeds[world, person] = random.uniform(0.8, 1.5)
    return places, goals, speeds


def forces(places, velocities, to_goal, speeds):
    distance = norm(to_goal)
    pull = GOAL_GAIN_PER_S * (speeds[..., None] * to_goal / np.maximum(distance, 1e-9)[..., None] - velocities)
    inside = distance <= GOAL_RADIUS_M
    pull[inside] = -velocities[inside] / 0.5
    apart = places[:, None] - places[:, :, None]
    away = norm(apart)
    nobody = np.eye(places.shape[1], dtype=bool)
    away[:, nobody] = 1e9
    direction = apart / away[..., None]
    interaction = LAMBDA * (velocities[:, :, None] - velocities[:, None]) + direction
    length = np.maximum(norm(interaction), 1e-12)
    tangent = interaction / length[..., None]
    reach = GAMMA * length
    angle = wrap(np.arctan2(direction[..., 1], direction[..., 0]) - np.arctan2(tangent[..., 1], tangent[..., 0]))
    slowing = -np.exp(-away / reach - (ALONG * reach * angle) ** 2)
    turning = -np.sign(angle) * np.exp(-away / reach - (ACROSS * reach * angle) ** 2)
    sideways = np.stack([-tangent[..., 1], tangent[..., 0]], -1)
    push = slowing[..., None] * tangent + turning[..., None] * sideways
    push[:, nobody] = 0.0
    return pull + SOCIAL_MPS2 * push.sum(2)


def walk(places, goals, speeds, duration_s, rule):
    """Places and velocities at every tick."""
    velocities = np.zeros_like(places)
    at = np.zeros(speeds.shape, int)
    world, person = np.ogrid[: speeds.shape[0], : speeds.shape[1]]
    all_places, all_velocities = [places], [velocities]
    for _ in range(round(duration_s / TICK_S)):
        to_goal = goals[world, person, at] - places
        arrived = norm(to_goal) <= GOAL_RADIUS_M + REACHED_MARGIN_M
        moved = velocities + TICK_S * forces(places, velocities, to_goal, speeds)
        moved *= np.minimum(1.0, speeds / np.maximum(norm(moved), 1e-12))[..., None]
        moved[arrived] = 0.0 if rule == "rest" else velocities[arrived]
        places = np.where(arrived[..., None], places, places + TICK_S * moved)
        at = (at + arrived) % goals.shape[2]
        velocities = moved
        all_places.append(places)
        all_velocities.append(velocities)
    return np.array(all_places), np.array(all_velocities)


def shares(velocities):
    """Shares of walking time beyond 0.35 rad/s and 1 m/s², and of all time beyond 0.35 rad/s."""
    walking = norm(velocities) > WALKING_MPS
    heading = np.arctan2(velocities[..., 1], velocities[..., 0])
    turns = np.abs(wrap(np.diff(heading, axis=0))) / TICK_S > 0.35
    hastens = (np.abs(np.diff(velocities, axis=0)) / TICK_S > 1.0).any(-1)
    both, now = walking[1:] & walking[:-1], walking[1:]
    return [(turns & both).sum() / now.sum(), (hastens & now).sum() / now.sum(), turns.mean()]


def print_shares():
    for people in (5, 10, 15, 20):
        world = draw(7000, 12, people)
        for rule in ("rest", "carry"):
            _, velocities = walk(*world, 120.0, rule)
            for duration_s in (5.0, 9.0, 120.0):
                figures = " ".join(f"{share:.3f}" for share in shares(velocities[: round(duration_s / TICK_S) + 1]))
                print(f"{people:3} people, {rule:5}, first {duration_s:5.0f} s: {figures}", flush=True)


def write_scenarios(rule, people, first, count, path):
    places, _ = walk(*draw(first, count, people), TRACK_S, rule)
    places = np.round(places[::TRACK_TICKS], 6)
    times_s = [round(k * TRACK_TICKS * TICK_S, 2) for k in range(len(places))]
    scenarios = []
    for world in range(count):
        tracks = [{"times_s": times_s, "positions_m": places[:, world, person].tolist()} for person in range(people)]
        scenarios.append({
            "name": f"{rule}-{first + world}",
            "start": {"position_m": START_M.tolist(), "heading_rad": 0.0},
            "goal_m": [13.0, 0.0],
            "goal_tolerance_m": 0.3,
            "time_limit_s": TRACK_S,
            "robot_radius_m": 0.35,
            "arena": {"x_m": [0.0, 16.0], "y_m": [-5.0, 5.0]},
            "people": [{"id": k + 1, "radius_m": 0.35, "motion": {"track": track}} for k, track in enumerate(tracks)],
        })
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"format": "cncbf-scenarios/1", "scenarios": scenarios}, file, separators=(",", ":"))


if __name__ == "__main__":
    if sys.argv[1:2] == ["shares"]:
        print_shares()
    else:
        _, _, rule, people, first, count, path = sys.argv
        write_scenarios(rule, int(people), int(first), int(count), path)
