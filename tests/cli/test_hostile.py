#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hostile inputs over all commands: each is refused with exit code 2 and in words, within 10 s of computing and 4 GiB of addresses, and no
file is touched.

    python3 tests/cli/test_hostile.py build/release/sinew

A table: what is wrong, the command line, what standard error must say. Every recording that is misread is given to each command that
reads recordings, and every broken YAML file to each command that reads one, since the same rule must hold in all.
"""
import json
import os
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import test_cli as cli
from test_cli import PAPER_LIMB, ROOT, WRONG_INPUT, check, write

LONGEST_S, MOST_BYTES = 20.0, 1 << 30
SCENARIO = (ROOT / "scenarios/babble_bidirectional.yaml").read_text()
STEP = "format: 1\nduration_s: 5\ninput: { duty_A: { step: { height_fraction: 0.4, from_s: 1, until_s: 3 } } }\n"
MAP = "format: 1\ntime: {column: time_s}\ncolumns:\n  duty_A: duty_A\n  duty_B: duty_B\n  angle_deg: angle_deg\n"
COLUMNS = ["time_s", "duty_A", "duty_B", "temperature_A_degC", "temperature_B_degC", "angle_deg"]


def state():
    """What each file is: its size and the time of its last change in nanoseconds, and the bytes of those that are not large."""
    found = {}
    for path in cli.folder.rglob("*"):
        facts = path.lstat()
        regular = path.is_file() and not path.is_symlink()
        found[path] = (facts.st_size, facts.st_mtime_ns if regular else 0, path.read_bytes() if regular and facts.st_size < 1e6 else b"")
    return found


def refused(what, arguments, words, stdout=subprocess.PIPE, most_bytes=4 * MOST_BYTES):
    before = state()
    began = time.monotonic()
    process = subprocess.Popen([cli.program, *map(os.fsencode, map(str, arguments))], cwd=cli.folder, stdin=subprocess.DEVNULL,
                               stdout=stdout, stderr=subprocess.PIPE,
                               preexec_fn=lambda: (resource.setrlimit(resource.RLIMIT_AS, (most_bytes, most_bytes)),
                                                   resource.setrlimit(resource.RLIMIT_CPU, (int(LONGEST_S), int(LONGEST_S) + 1))))
    try:
        out, error = process.communicate(timeout=3 * LONGEST_S)
    except subprocess.TimeoutExpired:
        process.kill()
        out, error = process.communicate()
    spent_s = time.monotonic() - began
    said = error.decode(errors="replace")
    wrong = []
    if process.returncode != WRONG_INPUT:
        wrong.append(f"exit code {process.returncode}")
    if not re.search(words, said):
        wrong.append(f"does not say /{words}/")
    if spent_s > 3 * LONGEST_S:  # by the clock; of computing the system allows LONGEST_S
        wrong.append(f"took {spent_s:.1f} s")
    if out:
        wrong.append("wrote to standard output")
    if re.search(r"[\x00-\x09\x0b-\x1f\x7f]", said):
        wrong.append("control characters on standard error")
    if state() != before:
        wrong.append("a file is not what it was")
        shutil.rmtree(cli.folder / "out", ignore_errors=True)  # so that the next line fails by its own fault alone
    check(what, not wrong, "; ".join(wrong) + "\n" + said)


def table(header, rows):
    return ",".join(header) + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows)


def recordings():
    """Pairs: what is wrong with a recording, its text, what must be said; and those that only a plant can tell."""
    write("plain.yaml", SCENARIO.replace("duration_s: 600", "duration_s: 60"))
    subprocess.run([cli.program, "run", "plain.yaml", "--out", "good"], cwd=cli.folder, check=True, capture_output=True)
    lines = [line for line in (cli.folder / "good/recording.csv").read_text().splitlines() if not line.startswith("#")]
    header, rows = lines[0].split(","), [line.split(",") for line in lines[1:602]]
    assert header == COLUMNS, header
    good = table(header, rows)
    write("good.csv", good)

    def mapped(column, change):
        k = header.index(column)
        return table(header, [[*row[:k], change(row[k]), *row[k + 1:]] for row in rows])

    def exchanged(one, other):
        names = [other if name == one else one if name == other else name for name in header]
        return table(names, rows)

    order = sorted(range(len(rows)), key=lambda k: (k * 7919) % len(rows))
    small = [[f"{k / 10}", *row[1:]] for k, row in enumerate(rows[:100])]
    read = [
        ("milliseconds", mapped("time_s", lambda t: round(float(t) * 1e3)), r"time_s, median step = 100 s\n.*milliseconds"),
        ("microseconds", mapped("time_s", lambda t: round(float(t) * 1e6)), r"time_s, median step = 1e\+05 s\n.*microseconds"),
        ("duty in percent", mapped("duty_A", lambda d: float(d) * 100 + 1),
         r"duty_A = .*\n.*must lie in \[0, 1\](.*\n)*.*divide it by 100"),
        ("duty to 255", mapped("duty_B", lambda d: round(float(d) * 255) + 2), r"duty_B = .*\n.*\[0, 1\](.*\n)*.*divide it by 255"),
        ("negative duty", mapped("duty_A", lambda d: "-0.5"), r"duty_A = -0.5\n.*\[0, 1\]"),
        ("infinite angle", mapped("angle_deg", lambda a: "inf"), r"angle_deg = inf\n.*must be a number"),
        ("infinite time", mapped("time_s", lambda a: "-inf"), r"time_s = -inf"),
        ("hexadecimal", mapped("angle_deg", lambda a: "0x10"), r"angle_deg = 0x10"),
        ("words", mapped("angle_deg", lambda a: "OK"), r"angle_deg = OK"),
        ("shuffled rows", table(header, [small[k] for k in order if k < 100]), r"goes back by|rows out of order = \d+"),
        ("rows shuffled a little", table(header, [small[k ^ 1] for k in range(100)]), r"rows out of order = 50\n.*sort the rows by time_s"),
        ("constant time", mapped("time_s", lambda t: "1"), r"time never moves forward"),
        ("quoted header", good.replace(lines[0], ",".join(f'"{c}"' for c in header)), r"missing columns(.*\n)*.*without quotes"),
        ("quoted numbers", mapped("angle_deg", lambda a: f'"{a}"'), r'angle_deg = "(.*\n)*.*without quotes'),
        ("decimal commas", table(header, [[f"{float(v or 0):.3f}".replace(".", ",") for v in row] for row in rows]), r"decimals are written with ','"),
        ("semicolons", good.replace(",", ";"), r"must be separated by ','"),
        ("tabs", good.replace(",", "\t"), r"must be separated by ','"),
        ("column twice", good.replace("duty_B", "duty_A", 1), r"stands twice"),
        ("misspelt column", good.replace("angle_deg", "angel_deg", 1), r"did you mean angel_deg"),
        ("angle in rad by name", good.replace("angle_deg", "angle_rad", 1), r"missing column = angle_deg"),
        ("header alone", lines[0] + "\n", r"at least two rows"),
        ("no header", "\n".join(lines[1:50]) + "\n", r"missing columns"),
        ("empty file", "", r"the file is empty"),
        ("comments alone", "# a\n# b\n", r"no header"),
        ("UTF-16", None, r"UTF-16"),
        ("NUL bytes", good.replace("0", "\0", 3), r"NUL byte"),
        ("CR alone", good.replace("\n", "\r"), r"CR alone"),
        ("first input missing", good.replace(lines[1], ",".join([rows[0][0], "", *rows[0][2:]])), r"duty_A = \(empty\)"),
        ("row too long", good + "1,2,3,4,5,6,7\n", r"fields in this row = 7"),
        ("escapes in a field", mapped("angle_deg", lambda a: "\x1b[31m"), r"angle_deg = \\x1b\[31m"),
        ("line of two megabytes", lines[0] + "\n" + "1" * (2 << 20) + "\n", r"a line has at most 1048576"),
        ("nothing measured", table(header, [[*row[:3], "", "nan", ""] for row in rows]), r"no row has a measurement|case \d needs it"),
        ("time far away", mapped("time_s", lambda t: "1e300"), r"within 1e10"),
    ]
    by_plant = [
        ("kelvin", mapped("temperature_A_degC", lambda t: float(t) + 273.15), r"temperature_A_degC = .*\n.*kelvin"),
        ("radians", mapped("angle_deg", lambda a: float(a) / 57.29578), r"angle_deg = .*\n.*radians"),
        ("exchanged duties", exchanged("duty_A", "duty_B"), r"seem to be exchanged"),
        ("exchanged temperatures", exchanged("temperature_A_degC", "temperature_B_degC"), r"seem to be exchanged"),
    ]
    return read, by_plant


def yaml_files():
    laughs = "a0: &a0 [x,x,x,x,x,x,x,x,x]\n" + "".join(f"a{k}: &a{k} [{','.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 10))
    return [
        ("aliases without end", laughs, r"more than 200000 values"),
        ("an anchor that contains itself", "format: &a [*a]\n", r"nested too deeply|no YAML"),
        ("nesting", "[" * 5000 + "]" * 5000, r"nested too deeply|no YAML"),
        ("nesting of maps", "".join(" " * k + "a:\n" for k in range(200)), r"nested too deeply|no YAML"),
        ("a second document", "format: 1\n---\nformat: 1\n", r":\d+: a second document"),
        ("a tab that indents", "format: 1\nplant:\n\tbase: paper_limb\n", r":3:1\n  no YAML: a tab"),
        ("no YAML", "format: [1\n", r"no YAML"),
        ("a key twice", "format: 1\nformat: 1\n", r"stands twice"),
        ("a list", "- 1\n", r"must be a map"),
        ("an unknown key", "format: 1\nfromat: 1\n", r"fromat|(time|base)\n.*missing|no such key"),
        ("a format of the future", "format: 99\n", r"format = 99|no such key"),
        ("a format beyond 64 bits", "format: 99999999999999999999\n", r"must lie in \[-9223372036854775808|no such key"),
        ("NUL bytes", "format: 1\n\0\0\n", r"."),
        ("a key with escapes", 'format: 1\n"\\e[31mred": 1\n', r"\\x1b|(time|base)\n.*missing|no such key"),
        ("seventeen megabytes", "# " + "x" * (17 << 20), r"larger than 16 MiB"),
    ]


def test_all():
    read, by_plant = recordings()
    limb = PAPER_LIMB
    using = {
        "calibrate": lambda f: ["calibrate", f, "--plant", limb, "--starts", "1", "--out", "out"],
        "compare": lambda f: ["compare", f, "--plant", limb],
        "diagnose": lambda f: ["diagnose", "--train", f, "--plant", limb, "--out", "out"],
        "diagnose --heldout": lambda f: ["diagnose", "--train", "good.csv", "--heldout", f, "--plant", limb, "--out", "out"],
        "train": lambda f: ["train", f, "--out", "out"],
        "rollout": lambda f: ["rollout", "lstm", "--recording", f],
    }
    emulates = (Path(cli.program).resolve().parent / "sinew-emulator").exists()
    if emulates:
        using["investigate"] = lambda f: ["investigate", "--train", f, "--plant", limb, "--emulate", "--out", "out"]
    cli.sinew("train", "good.csv", "--updates", "1", "--out", "lstm")
    write("replay.yaml", "format: 1\nduration_s: 5\ninput: { replay: { recording: bad.csv } }\n")
    for what, text, words in read + by_plant:
        data = text if text is not None else "time_s"
        (cli.folder / "bad.csv").write_bytes(data.encode("utf-16" if text is None else "utf-8"))
        for name, line in using.items():
            refused(f"{name}, {what}", line("bad.csv"), words)
    for name, line in using.items():
        refused(f"{name}, no such recording", line("none.csv"), r"none\.csv")
        refused(f"{name}, a folder as a recording", line("good"), r"good|set\.h5|manifest")
        if name == "compare":  # one reader serves all, and reads a gigabyte first
            refused(f"{name}, a recording without end", line("/dev/zero"), r"/dev/zero: size\n.*larger than 1 GiB")
        refused(f"{name}, an empty name", line(""), r"must not be empty|required")
    (cli.folder / "bad.csv").write_text("")

    plants = {
        "calibrate --plant": lambda f: ["calibrate", "good.csv", "--plant", f, "--out", "out"],
        "compare --plant": lambda f: ["compare", "good.csv", "--plant", f],
        "diagnose --plant": lambda f: ["diagnose", "--train", "good.csv", "--plant", f, "--out", "out"],
        "effects --plant": lambda f: ["effects", "--plant", f],
        "hil --twin": lambda f: ["hil", ROOT / "scenarios/step.yaml", "--emulate", "--twin", f, "--out", "out"],
        "run": lambda f: ["run", f, "--out", "out"],
        "dataset": lambda f: ["dataset", f, "--runs", "2", "--out", "out"],
        "hil": lambda f: ["hil", f, "--emulate", "--out", "out"],
        "convert --map": lambda f: ["convert", "good.csv", "out.csv", "--map", f],
        "train --settings": lambda f: ["train", "good.csv", "--settings", f, "--out", "out"],
        "train --plant": lambda f: ["train", "good.csv", "--plant", f, "--out", "out"],
        "rollout --plant": lambda f: ["rollout", "lstm", "--recording", "good.csv", "--plant", f],
        "evaluate --stress": lambda f: ["evaluate", "lstm", "--stress", f, "--out", "out"],
        "dataset --randomise": lambda f: ["dataset", "plain.yaml", "--runs", "2", "--randomise", f, "--out", "out"],
        "paper-table --settings": lambda f: ["paper-table", "--settings", f, "--out", "out", "--one-coil", "plain.yaml", "--two-coils", "plain.yaml"],
        "prove --plant": lambda f: ["prove", "--few", "--plant", f, "--out", "out"],
    }
    if emulates:
        plants["investigate --plant"] = lambda f: ["investigate", "--plant", f, "--emulate", "--out", "out"]
    for what, text, words in yaml_files():
        write("bad.yaml", text)
        for name, line in plants.items():
            refused(f"{name}, {what}", line("bad.yaml"), words)
    # Logs of any kind, before a map is believed: one line that is as long as a file, of digits and of delimiters.
    write("good.map.yaml", MAP)
    for what, byte in [("digits", "1"), ("commas", ","), ("spaces", " ")]:
        (cli.folder / "line.csv").write_text(",".join(COLUMNS) + "\n" + byte * (300 << 20) + "\n")
        for name, line in {"convert --map": ["convert", "line.csv", "out.csv", "--map", "good.map.yaml"],
                           "convert": ["convert", "line.csv", "out.csv"], "convert --suggest": ["convert", "--suggest", "line.csv"],
                           "compare": using["compare"]("line.csv")}.items():
            refused(f"{name}, a line of 300 MB of {what}", line, r"a line has at most 1048576")
    (cli.folder / "line.csv").unlink()
    os.symlink("loop.yaml", cli.folder / "loop.yaml")
    for name, line in plants.items():
        refused(f"{name}, a link to itself", line("loop.yaml"), r"loop\.yaml")
        refused(f"{name}, an empty name", line(""), r"must not be empty|required")

    write("step.yaml", STEP)
    outs = {
        "run": ["run", "step.yaml"],
        "calibrate": ["calibrate", "good.csv", "--plant", limb],
        "compare": ["compare", "good.csv", "--plant", limb],
        "diagnose": ["diagnose", "--train", "good.csv", "--plant", limb],
        "dataset": ["dataset", "step.yaml", "--runs", "2"],
        "train": ["train", "good.csv"],
        "hil": ["hil", "step.yaml", "--emulate"],
        "paper-table": ["paper-table"],
        "prove": ["prove", "--few"],
        "hil-faults": ["hil-faults"],
        "hil-false-trips": ["hil-false-trips"],
        "rollout": ["rollout", "lstm", "--recording", "good.csv"],
        "evaluate": ["evaluate", "lstm", "--stress", "stress.yaml"],
    }
    write("stress.yaml", "format: 1\nbase: plain.yaml\nseeds: 1\nrows:\n  - { name: hot, parameters: { ambient_temperature_degC: 40 } }\n")
    if emulates:
        outs["investigate"] = ["investigate", "--plant", limb, "--emulate"]
    for name, line in outs.items():
        refused(f"{name}, an empty --out", [*line, "--out", ""], r"must not be empty")
        refused(f"{name}, a file as --out", [*line, "--out", "good.csv"], r"a folder is needed|is a file|good\.csv")
        refused(f"{name}, /dev/full as --out", [*line, "--out", "/dev/full"], r"/dev/full|a folder is needed")
    for name in ["run", "calibrate", "diagnose", "dataset", "train", "hil"] + ["investigate"] * emulates:
        for seed in ["9223372036854775808", "1e3", "-1", "inf", "99999999999999999999999", "0x7"]:
            refused(f"{name}, --seed {seed}", [*outs[name], "--out", "out", "--seed", seed], r"whole number|seed|arguments")
    for name, option in [("investigate", "--limb-seed"), ("prove", "--first-seed")]:
        if name in outs:
            for seed in ["9223372036854775808", "1e3", "-1", "0x7"]:
                refused(f"{name}, {option} {seed}", [*outs[name], "--out", "out", option, seed], option)
    # Numbers that are none, in every option that takes one.
    takes_numbers = {**{name: (line, "out") for name, line in outs.items()}, "doctor": (["doctor"], None)}
    for name, (line, out) in takes_numbers.items():
        options = re.findall(r"^ +(--[a-z-]+)[^\n]*? FLOAT", cli.sinew(name, "--help").stdout, re.M)
        for option in options:
            for number in ("nan", "inf", "-inf"):
                refused(f"{name}, {option} {number}", [*line, *(["--out", out] if out else []), option, number], option)
    refused("run, --stop-at before the beginning", ["run", "step.yaml", "--out", "out", "--stop-at", "-1"], "--stop-at")
    refused("rollout, --predict without --case", ["rollout", "lstm", "--recording", "good.csv", "--predict", "angel_deg"],
            r"--predict = angel_deg\n.*goes with --case")
    # Names that cannot stand in YAML, in JSON or in a comment.
    for name, what in [("a\nb: 1.csv", "a line end"), (os.fsdecode(b"Gr\xf6\xdfe.csv"), "Latin-1"), ("\x1b[31m.csv", "an escape")]:
        shutil.copy(cli.folder / "good.csv", cli.folder / name)
        shutil.copy(limb, cli.folder / (name + ".yaml"))
        lines = {key: line(name) for key, line in using.items()}
        lines |= {f"{key}, plant": line(name + ".yaml") for key, line in plants.items()}
        lines |= {f"{key}, --out": [*line, "--out", name] for key, line in outs.items()}
        lines |= {"convert": ["convert", name, "out.csv"], "convert, written to": ["convert", "good.csv", name + ".out"],
                  "rollout, weights": ["rollout", name, "--recording", "good.csv"], "evaluate": ["evaluate", name, "--stress", name],
                  "replay": ["replay", name]}
        for key, line in lines.items():
            refused(f"{key}: a name with {what}", line, r"is not UTF-8 without control characters")
        os.remove(cli.folder / name)
        os.remove(cli.folder / (name + ".yaml"))
    write("named.yaml", 'format: 1\nduration_s: 5\ninput: { replay: { recording: "good\\n.csv" } }\n')
    refused("run: a recording's name with a line end in YAML", ["run", "named.yaml", "--out", "out"],
            r"named\.yaml:3:\d+: .*(\n.*)*control characters")

    os.symlink("loop.csv", cli.folder / "loop.csv")
    os.symlink("loop_out", cli.folder / "loop_out")
    for name, line in using.items():
        refused(f"{name}, a recording that is a link to itself", line("loop.csv"), r"loop\.csv")
    for name, line in outs.items():
        refused(f"{name}, --out that is a link to itself", [*line, "--out", "loop_out"], r"loop_out")
    refused("convert, a log that is a link to itself", ["convert", "loop.csv", "out.csv"], r"loop\.csv")
    refused("convert, to a link to itself", ["convert", "good.csv", "loop.csv"], r"loop\.csv")

    # A full disk, wherever a result goes.
    refused("convert, to a full disk", ["convert", "good.csv", "/dev/full", "--map", "good.map.yaml"], r"/dev/full(.*\n)*.*No space left")
    with open("/dev/full", "wb") as full:
        for line in (["effects"], ["effects", "--json"], ["convert", "--suggest", "good.csv"], ["--help"],
                     ["compare", "good.csv", "--plant", limb, "--json"]):
            refused(f"{line[0]}, printed to a full disk", line, r"standard output: No space left", stdout=full)

    names = re.findall(r"^([a-z_]+)  ", cli.sinew("effects").stdout, re.M)
    check("`sinew effects` lists more than twenty", len(names) > 20, names)
    refused("diagnose, --without all effects", [*outs["diagnose"], "--out", "out", "--without", ",".join(names)],
            r"--without = all \d+ effects\n.*leaves no effect")
    families = [e["name"] for e in json.loads(cli.sinew("effects", "--json").stdout)["effects"] if "form_of" not in e]
    check("some effects are forms of others", 20 < len(families) < len(names), families)
    refused("diagnose, --without all effects but forms of them", [*outs["diagnose"], "--out", "out", "--without", ",".join(families)],
            r"--without = all \d+ effects\n.*leaves no effect")
    if emulates:
        refused("investigate, --without all effects", [*outs["investigate"], "--out", "out", "--without", ",".join(names)],
                r"--without = all \d+ effects\n.*leaves no effect")
    refused("diagnose, --without an effect that is none", [*outs["diagnose"], "--out", "out", "--without", "thermocuple_lag"],
            r"did you mean thermocouple_lag")
    for given in ("0", "-1", "1.5", "many", "99999999999"):
        refused(f"train, --updates {given}", [*outs["train"], "--out", "out", "--updates", given], r"--updates")
    refused("train, --updates of the published method", [*outs["train"], "--out", "out", "--method", "published", "--updates", "5"],
            r"--updates = 5\n.*counts epochs")

    if emulates:
        for fault in ("nan", "sensor_open", "sensor_open:A", "sensor_opn:A@1", "sensor_open:Z@1", "sensor_open:A@nan", "sensor_open:A@-1"):
            refused(f"hil, --fault {fault}", [*outs["hil"], "--out", "out", "--fault", fault], r"--fault(.*\n)*.*the emulator refuses")

    # Memory that is not there: a file larger than what is left.
    with open(cli.folder / "large.csv", "wb") as large:
        large.truncate(MOST_BYTES - 1)
    for name, line in {**using, "convert": lambda f: ["convert", f, "out.csv"], "run": lambda f: ["run", "large.yaml", "--out", "out"]}.items():
        write("large.yaml", "format: 1\nduration_s: 5\ninput: { replay: { recording: large.csv } }\n")
        refused(f"{name}, out of memory", line("large.csv"), r"^sinew: out of memory; nothing was written\n$", most_bytes=MOST_BYTES // 2)
    (cli.folder / "large.csv").unlink()

    # More samples than memory bears at once.
    (cli.folder / "long.csv").write_text(",".join(COLUMNS) + "\n" + "".join(f"{k / 10},0,0,25,25,0\n" for k in range(200100)))
    for name in ["calibrate", "diagnose"] + ["investigate"] * emulates:
        refused(f"{name}, 200,100 samples", using[name]("long.csv"), r"samples to fit = 200100\n.*at most 200000 .*(--fit-until|give fewer)")
    (cli.folder / "long.csv").unlink()

    for given, meant in [("diagnos", "diagnose"), ("calibrat", "calibrate"), ("rnu", "run"), ("paper_table", "paper-table")]:
        refused(f"sinew {given}", [given], rf"did you mean {meant}\?")
    for line in (["completion", "ba\x1b[31msh"], ["schema", "\x1b[2Jplant"], ["run", "step.yaml", "--out", "out", "\x1b[31m"], ["\x1b]0;title\a"]):
        refused(f"sinew {line[0]!r}, an argument with an escape", line, r"\\x1b")
    for word in ("help", "version"):
        refused(f"sinew {word}", [word], rf"did you mean --{word}\?")
    refused("sinew with no command at all near", ["xyzzyxyzzy"], r"xyzzyxyzzy is no command")


MOST_RESIDENT_BYTES, LATEST_STOP_S = 1 << 30, 2.0


def stopped(what, arguments, after_s):
    """Ctrl-C: how long it takes, what is left, and the most memory that was used."""
    process = subprocess.Popen([cli.program, *map(str, arguments)], cwd=cli.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    time.sleep(after_s)
    running = os.waitpid(process.pid, os.WNOHANG)[0] == 0
    began = time.monotonic()
    if running:
        process.send_signal(signal.SIGINT)
        _, status, used = os.wait4(process.pid, 0)
    took_s = time.monotonic() - began
    check(f"{what}: was still at work", running)
    if not running:
        return
    check(f"{what}: Ctrl-C ends it within two seconds", took_s < LATEST_STOP_S, f"{took_s:.2f} s")
    check(f"{what}: with exit code 130", os.waitstatus_to_exitcode(status) == cli.INTERRUPTED, status)
    check(f"{what}: it used at most 1 GiB", used.ru_maxrss * 1024 < MOST_RESIDENT_BYTES, f"{used.ru_maxrss / 1024:.0f} MiB")
    check(f"{what}: nothing is left of it", not (cli.folder / "stopped").exists())


def test_interrupts():
    """Long recordings, and long work, ended by Ctrl-C in the middle."""
    long = SCENARIO.replace("duration_s: 600", "duration_s: 19000")
    write("hours.yaml", long.replace("paper_limb }", "paper_limb, effects: { thermocouple_lag: { time_constant_s: 1.2 } } }"))
    subprocess.run([cli.program, "run", "hours.yaml", "--out", "hours"], cwd=cli.folder, check=True, capture_output=True)
    recording, limb = "hours/recording.csv", PAPER_LIMB
    for after_s in (0.2, 1.5, 6.0):
        stopped(f"diagnose, after {after_s} s", ["diagnose", "--train", recording, "--plant", limb, "--out", "stopped"], after_s)
        stopped(f"calibrate, after {after_s} s", ["calibrate", recording, "--plant", limb, "--out", "stopped"], after_s)
    stopped("compare", ["compare", recording, "--plant", limb, "--out", "stopped"], 0.6)
    stopped("train", ["train", recording, "--out", "stopped"], 2.0)
    write("days.yaml", SCENARIO.replace("duration_s: 600", "duration_s: 900000"))
    stopped("prove, while it makes its cases", ["prove", "--set", "development", "--seeds", "3", "--out", "stopped"], 1.0)
    stopped("run, which leaves a checkpoint", ["run", "days.yaml", "--out", "checkpoint"], 1.0)
    stopped("dataset, which keeps the runs that are whole", ["dataset", "days.yaml", "--runs", "3", "--out", "set"], 1.0)


def test_terminals():
    """Escapes on a terminal that takes them, and on no other."""
    commands = {"calibrate": ["calibrate", "good.csv", "--plant", PAPER_LIMB, "--starts", "1"]}
    if (Path(cli.program).resolve().parent / "sinew-emulator").exists():
        commands["hil"] = ["hil", ROOT / "scenarios/step.yaml", "--emulate"]
    for settings, wants in (({"TERM": "xterm"}, True), ({"TERM": "dumb"}, False), ({"TERM": "xterm", "NO_COLOR": "1"}, False), ({}, False)):
        environment = {key: value for key, value in os.environ.items() if key not in ("TERM", "NO_COLOR")} | settings
        for name, line in commands.items():
            ours, theirs = pty.openpty()
            process = subprocess.Popen([cli.program, *map(str, line), "--out", "shown", "--overwrite"], cwd=cli.folder,
                                       stdout=subprocess.DEVNULL, stderr=theirs, env=environment)
            os.close(theirs)
            shown = b""
            while True:
                try:
                    shown += os.read(ours, 4096)
                except OSError:  # the other end is closed
                    break
            os.close(ours)
            check(f"{name}, {settings or 'no TERM'}: {'escapes' if wants else 'no escapes'} on a terminal",
                  process.wait() == 0 and (b"\x1b" in shown) == wants, shown[:200])
            shutil.rmtree(cli.folder / "shown", ignore_errors=True)


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_hostile", (test_all, test_interrupts, test_terminals)))
