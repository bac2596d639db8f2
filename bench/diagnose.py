#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How long a diagnosis takes, how that grows with the recording, and what refitting every effect through SciPy would take.

    bench/diagnose.py        build/release must be built

Recordings are the beginning of the one that ships, which has a concealed effect. By the wall, two threads. The alternative
is not run to its end: one simulation of the same length by SciPy's solve_ivp (LSODA, 1e-4, started again at every jump of
the duty) is timed in this run, and multiplied by the simulations that a fit of each effect by finite differences needs.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np
from scipy.integrate import solve_ivp

ROOT = pathlib.Path(__file__).resolve().parent.parent
EFFECTS = len(json.loads(subprocess.check_output([ROOT / "build/release/sinew", "effects", "--json"]))["effects"])
UNKNOWNS, ITERATIONS = 26, 10  # core parameters, first values and one of the effect; of a fit

lines = (ROOT / "scenarios/demo/recording.csv").read_text().splitlines()
comments = [line for line in lines if line.startswith("#")]
header, *rows = [line for line in lines if not line.startswith("#")]


def diagnose(folder, seconds):
    path = pathlib.Path(folder) / f"{seconds}.csv"
    path.write_text("\n".join([*comments, header, *rows[: 10 * seconds + 1]]) + "\n")
    began = time.perf_counter()
    subprocess.run([ROOT / "build/release/sinew", "diagnose", "--train", path, "--plant", ROOT / "plant/limbs/paper_limb.yaml",
                    "--threads", "2", "--out", pathlib.Path(folder) / f"out_{seconds}"], check=True, capture_output=True)
    return time.perf_counter() - began


def rates(t, y, u):
    temperature, fraction, angle, speed = y[:2], y[2:4], y[4], y[5]
    heat = 1.0 / (1.0 + np.exp((temperature - 75.0) / 7.0))
    cool = 1.0 / (1.0 + np.exp((temperature - 60.0) / 7.0))
    pull = (np.maximum(0.0, cool - fraction) - np.maximum(0.0, fraction - heat)) / 0.1
    stretch = 0.030 + np.array([-0.006, 0.006]) * angle
    tension = (313.0 - 200.0 * fraction) * (stretch - fraction * 0.028)
    moment = 0.006 * (tension[0] - tension[1]) - 0.05 * angle - 0.004 * speed
    return np.concatenate([(u * 49.0 / 2.5 - 0.04 * (temperature - 25.0)) / 0.85, pull, [speed, moment / 2e-5]])


def scipy_simulation(seconds):
    values = np.array([[float(x or "nan") for x in row.split(",")[:3]] for row in rows[: 10 * seconds + 1]])
    y = np.array([25.0, 25.0, 0.99, 0.99, 0.0, 0.0])
    began = time.perf_counter()
    for k in range(len(values) - 1):
        y = solve_ivp(rates, (values[k, 0], values[k + 1, 0]), y, method="LSODA", rtol=1e-4, atol=1e-6, args=(values[k, 1:],)).y[:, -1]
    return time.perf_counter() - began


with tempfile.TemporaryDirectory() as folder:
    times = {seconds: diagnose(folder, seconds) for seconds in (150, 300, 600)}
for seconds, took in times.items():
    print(f"diagnosis of {seconds} s, {EFFECTS} effects: {took:.1f} s")
exponent = np.log(times[600] / times[150]) / np.log(4.0)
print(f"growth with the recording: exponent {exponent:.2f} (goal: 1)")
print(f"goal for 600 s: 30 s, at most 90 s: {'reached' if times[600] <= 30 else 'MISSED'}")
one = 10.0 * scipy_simulation(60)
whole = one * EFFECTS * ITERATIONS * (UNKNOWNS + 1)
print(f"SciPy: one simulation of 600 s {one:.1f} s (ten times 60 s); every effect refitted by differences: {whole / 3600:.1f} h, "
      f"{whole / times[600]:.0f} times as long")
sys.exit(0)
