#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the three logs of this folder: recordings of a simulated limb, written down as three laboratories would.

    python3 tests/logs/make_logs.py build/release/sinew

arduino.txt  what a serial monitor showed: its own clock in front of each line, counts of the PWM and of the converter of the bend sensor,
             which bends the other way, words between the numbers, thermocouples that now and then say nan. The thermocouples lag.
matlab.mat   `save -v4` of a MATLAB script: time from the start of the session, percent, kelvin, radians, matrices of two columns. Nothing
             is missing from the plant.
ros.csv      `rostopic echo -p`: nanoseconds since 1970, one column an array's element, volts of a bend sensor, and eight seconds in which
             the bag has no messages. The limb creeps.
"""
import csv
import datetime
import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent

LIMB = """# {what}
format: 1
seed: {seed}
duration_s: 180.0
plant:
  base: paper_limb
  parameters: {{ ambient_temperature_degC: {ambient}, heat_loss_A_W_K: {loss_a}, heat_loss_B_W_K: {loss_b} }}
  effects: {{ {effects} }}
input:
  babble:
    lowest_deg: -30.0
    highest_deg: 30.0
    shortest_hold_s: 1.0
    longest_hold_s: 12.0
    proportional_gain_1_deg: 0.06
    integral_gain_1_deg_s: 1.0e-5
    duty_limit_fraction: 0.3
    positive_drives: A
    both_coils: true
"""


def rows_of(program, what, seed, ambient, loss_a, loss_b, effects=""):
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "limb.yaml"
        scenario.write_text(LIMB.format(what=what, seed=seed, ambient=ambient, loss_a=loss_a, loss_b=loss_b, effects=effects))
        subprocess.run([program, "run", scenario, "--out", Path(folder) / "run"], check=True, capture_output=True)
        text = (Path(folder) / "run/recording.csv").read_text()
    return [{name: float(value) if value else math.nan for name, value in row.items()}
            for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))]


def arduino(rows):
    lines, began = [], datetime.datetime(2026, 3, 4, 14, 3, 9, 412000)
    stamp = lambda s: (began + datetime.timedelta(seconds=s)).strftime("%H:%M:%S.%f")[:-3] + " -> "
    lines += [stamp(-0.2) + "SMA limb v2.1", stamp(-0.1) + "millis pwm1 pwm2 T1 T2 flex"]
    for k, row in enumerate(rows):
        if k % 400 == 399:
            lines.append(stamp(row["time_s"] - 0.03) + "loop ok")
        temperature = ["nan" if k % 173 == i else f"{row[name]:.2f}" for i, name in enumerate(("temperature_A_degC", "temperature_B_degC"))]
        numbers = [str(4182 + round(1000 * row["time_s"]) + k % 3), str(round(255 * row["duty_A"])), str(round(255 * row["duty_B"])),
                   *temperature, str(round(512 - 8 * row["angle_deg"]))]
        lines.append(stamp(row["time_s"] + 0.002) + " ".join(numbers))
    return "\r\n".join(lines) + "\r\n"


def matlab(rows):
    """Level 4 of the format: for each matrix a head of five integers, its name, its numbers column by column."""
    out = b""
    def matrix(name, columns):
        nonlocal out
        out += struct.pack("<5i", 0, len(columns[0]), len(columns), 0, len(name) + 1) + name.encode() + b"\0"
        for column in columns:
            out += struct.pack(f"<{len(column)}d", *column)
    of = lambda name, change: [change(row[name]) for row in rows]
    matrix("t", [of("time_s", lambda t: t + 37.5)])
    matrix("pwm", [of(f"duty_{c}", lambda d: round(100 * d, 3)) for c in "AB"])
    matrix("T", [of(f"temperature_{c}_degC", lambda t: t + 273.15) for c in "AB"])
    matrix("theta", [of("angle_deg", math.radians)])
    matrix("Ts", [[0.1]])
    return out


def ros(rows):
    lines = ["%time,field.header.seq,field.header.stamp,field.header.frame_id,"
             "field.duty0,field.duty1,field.temperature0,field.temperature1,field.bend"]
    for k, row in enumerate(rows):
        if 64.0 < row["time_s"] < 72.0:
            continue
        now = 1772632989412345678 + round(1e9 * row["time_s"]) + (k * 7919 % 11 - 5) * 1000000
        lines.append(f"{now},{k},{now - 350000},limb,{row['duty_A']:.6g},{row['duty_B']:.6g},{row['temperature_A_degC']:g},"
                     f"{row['temperature_B_degC']:g},{2.5 + row['angle_deg'] / 40:.5f}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    program = Path(sys.argv[1]).resolve()
    (HERE / "arduino.txt").write_bytes(arduino(rows_of(program, "For a log of an Arduino.", 11, 24.0, 0.041, 0.036,
                                                       "thermocouple_lag: { time_constant_s: 1.5 }")).encode())
    (HERE / "matlab.mat").write_bytes(matlab(rows_of(program, "For a log of MATLAB.", 12, 21.0, 0.037, 0.040)))
    (HERE / "ros.csv").write_text(ros(rows_of(program, "For a log of ROS.", 13, 26.0, 0.038, 0.038,
                                              "viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 20.0 }")))
