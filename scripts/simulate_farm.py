#!/usr/bin/env python3
"""How many tasks should a bake on a farm be cut into? Simulates a job array with stragglers and failures.

    simulate_farm.py [--work 36000] [--slots 100] [--runs 200] [--seed 1]

A bake of some seconds of one-slot work is cut into N tasks that a scheduler starts on a number of slots, in order, each
slot taking the next task when it is free. Per task, a worker repeats `repeat` seconds (loading the scene, its tree and
the radiance cache) and the scheduler takes `start` seconds. Model of the machines, all of it assumptions:

  - work differs from task to task: a factor of log-normal distribution, coefficient of variation 0.25 x root of the
    tasks' number over 64 at most 0.5 (smaller tasks average over fewer tiles);
  - one slot in 20 is a straggler, at a third of the speed;
  - a slot fails with a mean time between failures of 20 hours: the task in hand starts anew, on the next free slot,
    after 120 s. Finished tiles are kept: a task has `tiles` of them, and only the one in hand is lost.

Printed for each N: median and 95th percentile of the time, efficiency (work / (slots x median)), repeated share.
"""

import argparse
import heapq
import math
import random
import statistics


def simulate(rng, work, tasks, slots, repeat, start, tiles_in_all=1000):
    share = work / tasks
    spread = min(0.5, 0.25 * math.sqrt(tasks / 64))
    sigma = math.sqrt(math.log(1 + spread * spread))
    queue = [share * rng.lognormvariate(-sigma * sigma / 2, sigma) for _ in range(tasks)]
    queue.reverse()
    mean_failure = 20 * 3600.0
    requeue = 120.0
    tile = work / tiles_in_all
    free = [(0.0, slot, 3.0 if rng.random() < 0.05 else 1.0) for slot in range(slots)]
    heapq.heapify(free)
    again = []  # (when, seconds left)
    end = 0.0
    while queue or again:
        now, slot, slowness = heapq.heappop(free)
        if again and (again[0][0] <= now or not queue):
            when, left = heapq.heappop(again)
            now = max(now, when)
        else:
            left = queue.pop()
        needed = start + (repeat + left) * slowness
        failure = rng.expovariate(1 / mean_failure)
        if failure < needed:
            done = max(0.0, failure - start - repeat * slowness) / slowness
            done = math.floor(done / tile) * tile if left > tile else 0.0
            heapq.heappush(again, (now + failure + requeue, left - done))
            heapq.heappush(free, (now + failure + requeue, slot, slowness))
            continue
        end = max(end, now + needed)
        heapq.heappush(free, (now + needed, slot, slowness))
    return end


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=float, default=36000.0, help="seconds of one slot for all tiles")
    parser.add_argument("--slots", type=int, default=100)
    parser.add_argument("--repeat", type=float, default=3.0, help="seconds that every task repeats")
    parser.add_argument("--start", type=float, default=2.0, help="seconds to start a task")
    parser.add_argument("--tasks", type=int, nargs="*", default=[25, 50, 100, 200, 300, 500, 1000, 2000, 4000])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    o = parser.parse_args()
    print(f"{o.work:.0f} s of work on {o.slots} slots; a task repeats {o.repeat:g} s and takes {o.start:g} s to start\n")
    print("| tasks | seconds each | median s | 95 % s | efficiency | repeated |")
    print("|---|---|---|---|---|---|")
    for tasks in o.tasks:
        rng = random.Random(o.seed)
        times = sorted(simulate(rng, o.work, tasks, o.slots, o.repeat, o.start) for _ in range(o.runs))
        median = statistics.median(times)
        late = times[min(len(times) - 1, int(0.95 * len(times)))]
        share = (o.repeat + o.start) * tasks / o.work
        print(f"| {tasks} | {o.work / tasks:.0f} | {median:.0f} | {late:.0f} | {o.work / o.slots / median:.2f} | {100 * share:.1f} % |")


if __name__ == "__main__":
    main()
