#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What sharing a job among MPI ranks costs: measured with 1 to 8 ranks on this machine, replayed for 1000.

    bench/ranks.py        build/release and its target bench_queue must be built; an idle machine, some minutes

The replay gives ranks tasks as long as those that one rank has just done, drawn from them with replacement (seed 1), by the rule of
apps/ranks.h; a number from the queue costs what it costs eight ranks here. The alternative is a fixed share: each rank every size-th
task.
"""
import heapq
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SINEW = ROOT / "build/release/sinew"
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe"]
ENVIRONMENT = os.environ | {"OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
RANKS = (1, 2, 4, 8)


def timed(command, folder):
    """Seconds by the wall, and of processors."""
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before, began = used(), time.perf_counter()
    result = subprocess.run([str(word) for word in command], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{command}: {result.stderr}")
    return time.perf_counter() - began, used() - before


def task_seconds(files):
    """Of tasks that one thread did one after the other, by when their files were written; without the first."""
    times = sorted(file.stat().st_mtime for file in files)
    return [after - before for before, after in zip(times, times[1:])]


def runs_at_a_time(runs, ranks):
    """What a rank takes of a set: parts (model/set.h), several at a time (apps/dataset.cpp)."""
    runs_in_part = -(-runs // 16384)
    parts = -(-runs // runs_in_part)
    return runs_in_part * max(1, min(64, parts // (64 * ranks)))


def replayed(seconds, speeds, chunk, per_number_s):
    """When the last rank ends, where whoever is free takes the next chunk; the counter serves one at a time."""
    free = [(0.0, rank) for rank in range(len(speeds))]
    counter_free_s = last = 0.0
    for at in range(0, len(seconds), chunk):
        now, rank = heapq.heappop(free)
        counter_free_s = max(now, counter_free_s) + per_number_s
        now = counter_free_s + sum(seconds[at : at + chunk]) / speeds[rank]
        last = max(last, now)
        heapq.heappush(free, (now, rank))
    return last


def by_fixed_shares(seconds, speeds):
    return max(sum(seconds[rank :: len(speeds)]) / speed for rank, speed in enumerate(speeds))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made = ["dataset", ROOT / "scenarios/babble_bidirectional.yaml", "--runs", 64, "--randomise", ROOT / "scenarios/domain.yaml"]
        proof = ["prove", "--families", "clean", "--kinds", "core", "--set", "development", "--seeds", 1,
                 "--training", 60, "--held-out", 60, "--plant", ROOT / "plant/limbs/paper_limb.yaml", "--without-baselines"]
        timed([SINEW, *made, "--out", "set"], folder)
        timed([SINEW, "train", "set", "--case", 3, "--predictor", "arx", "--out", "arx"], folder)
        stress = ["evaluate", "arx", "--stress", ROOT / "scenarios/stress.yaml"]
        print("By the wall, and of all processors together, in seconds.\n")
        print("| command | threads 1, no MPI | threads 2, no MPI |" + "".join(f" {n} rank{'s' * (n > 1)} |" for n in RANKS))
        print("|---" * (3 + len(RANKS)) + "|")
        durations = {}
        for what, command in (("dataset, 64 runs of 10 min", made), ("evaluate, ARX under scenarios/stress.yaml", stress),
                              ("prove, 8 cases of 60 s", proof)):
            cells = []
            for before, threads in (([], 1), ([], 2), *(([*MPIRUN, "-n", n], 1) for n in RANKS)):
                shutil.rmtree(folder / "out", ignore_errors=True)
                wall, processors = timed([*before, SINEW, *command, "--threads", threads, "--out", "out"], folder)
                cells.append(f"{wall:.1f}, {processors:.1f}")
                if not before and threads == 1:
                    out = folder / "out"
                    durations[command[0]] = task_seconds([*out.glob("runs/*.csv"), *out.glob("cases/*.json")])
            print(f"| {what} |" + "".join(f" {cell} |" for cell in cells), flush=True)
        print("\nA number from the queue, where nothing is done with it:\n")
        print("| ranks | numbers at a time | us each |\n|---|---|---|")
        lines = []
        for n in RANKS:
            queue = [*MPIRUN, "-n", str(n), ROOT / "build/release/bench/bench_queue"]
            lines += subprocess.check_output(queue, env=ENVIRONMENT, text=True).splitlines()
        print("\n".join(lines))
        per_number_s = max(1e-6 * float(line.split("|")[3]) for line in lines if line.split("|")[2].strip() == "1")

    print(f"\nReplayed with {1e6 * per_number_s:.1f} us for a number: share of the ranks' time in which they work, and with fixed shares."
          "\nIn the last two columns one rank of ten is half as fast.\n")
    print("| job | task, mean and longest measured | ranks | queue | fixed | queue, ranks unlike | fixed, ranks unlike |")
    print("|---" * 7 + "|")
    for what, command, tasks in (("dataset, a million runs of 10 min", "dataset", 1000000), ("prove, 20000 cases of 60 s", "prove", 20000)):
        some = durations[command]
        drawn = random.Random(1).choices(some, k=tasks)
        for n in (10, 100, 1000):
            chunk = runs_at_a_time(tasks, n) if command == "dataset" else 1
            shares = []
            for speeds in ([1.0] * n, [0.5 if rank % 10 == 0 else 1.0 for rank in range(n)]):
                ideal = sum(drawn) / sum(speeds)
                shares += [ideal / replayed(drawn, speeds, chunk, per_number_s), ideal / by_fixed_shares(drawn, speeds)]
            print(f"| {what} | {1e3 * sum(some) / len(some):.0f} ms, {1e3 * max(some):.0f} ms ({len(some)}) | {n} |"
                  + "".join(f" {100 * share:.1f} % |" for share in shares))


if __name__ == "__main__":
    main()
