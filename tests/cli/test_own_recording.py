#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows docs/your_own_recording.md to the letter, once for each log of tests/logs: its maps, its scenario and all its commands.

    python3 tests/cli/test_own_recording.py build/release/sinew
"""
import re
import shlex
import shutil
import subprocess
import sys

import test_cli as cli
from test_cli import ROOT, check, said

PAGE = (ROOT / "docs/your_own_recording.md").read_text()
LOGS = {"arduino": "arduino.txt", "matlab": "matlab.mat", "ros": "ros.csv"}
FILES = dict(re.findall(r"`(\w+(?:\.map)?\.yaml)`:\n\n```yaml\n(.*?)```", PAGE, re.S))
COMMANDS = re.findall(r"^    (sinew .*)$", PAGE, re.M)
VERDICTS = dict(re.findall(r"^\| (Arduino|MATLAB|ROS) \| (.*) \|$", PAGE, re.M))


def follow(log):
    """The page's commands in a folder of this log's own; what each printed."""
    here = cli.folder / log
    here.mkdir()
    for name in "plant", "scenarios":
        (here / name).symlink_to(ROOT / name)
    shutil.copy(ROOT / "tests/logs" / LOGS[log], here / LOGS[log])
    (here / "log.map.yaml").write_text(FILES[f"{log}.map.yaml"])
    (here / "my_babble.yaml").write_text(FILES["my_babble.yaml"])
    printed = {}
    for command in COMMANDS:
        words, to = shlex.split(command)[1:], None
        if ">" in words:
            words, to = words[:words.index(">")], words[-1]
        words = [LOGS[log] if word == "LOG" else word for word in words]
        result = subprocess.run([cli.program, *words], cwd=here, capture_output=True, text=True, timeout=120)
        refused = log == "arduino" and "--suggest" in words  # as the page says
        check(f"{log}: {command}", result.returncode == (2 if refused else 0), said(result))
        if to:
            (here / to).write_text(result.stdout)
            check(f"{log}: --suggest prints a map, or says what to write",
                  "columns:" in result.stdout or "text_lines: ignore" in result.stderr, said(result))
        printed[command] = result.stdout
    return printed


def one(printed, *words):
    """What the only command with these words printed."""
    found = [text for command, text in printed.items() if all(word in command for word in words)]
    assert len(found) == 1, (words, len(found))
    return re.sub(r"\s+", " ", found[0])


def held_out(text):
    """Noise and error on held-out data of each channel."""
    return {name: (float(noise), float(rmse)) for name, noise, rmse in
            re.findall(r"(temperature A|temperature B|angle) / \S+, not fitted +\d+ +([\d.]+) +([\d.]+)", text)}


def test_page():
    files = {*(f"{log}.map.yaml" for log in LOGS), "my_babble.yaml"}
    check("the page has a map for each log, a scenario, and its commands", set(FILES) == files and len(COMMANDS) == 10,
          (sorted(FILES), COMMANDS))
    printed = {log: follow(log) for log in LOGS}
    for log, verdict in zip(LOGS, (VERDICTS["Arduino"], VERDICTS["MATLAB"], VERDICTS["ROS"])):
        found = one(printed[log], "diagnose ")
        check(f"{log}: the diagnosis says what the page says it does", verdict in found, found[:400])
        repaired = held_out(one(printed[log], "compare", "results/diagnosed"))
        check(f"{log}: with the repaired plant held-out temperatures are off by their noise, the angle by twice that at most",
              len(repaired) == 3 and
              all(rmse < (2.0 if name == "angle" else 1.2) * noise for name, (noise, rmse) in repaired.items()), repaired)
        rollout = one(printed[log], "rollout")
        check(f"{log}: the rollout stands beside its baselines", "To hold the first value is" in rollout and "(ARX)" in rollout, rollout)
    calibrated = {log: held_out(one(printed[log], "compare", "results/calibrated")) for log in LOGS}
    check("MATLAB's log: calibrated, every channel is off by its noise",
          all(rmse < 1.2 * noise for noise, rmse in calibrated["matlab"].values()), calibrated)
    check("Arduino's log: calibrated, the temperatures are some 3 degrees off",
          all(2.0 < calibrated["arduino"][f"temperature {c}"][1] < 4.5 for c in "AB"), calibrated)
    check("ROS's log: calibrated, the angle is far off on held-out data",
          calibrated["ros"]["angle"][1] > 10 * calibrated["ros"]["angle"][0], calibrated)
    check("ROS's log: the pause is named, and the state begins anew after it",
          "after this pause the state is estimated anew" in one(printed["ros"], "compare", "paper_limb"))


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_own_recording", (test_page,)))
