#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Nothing that a user owns is overwritten in silence: an output is never an input, results are replaced with --overwrite alone,
sessions with the limb never, one command at a time writes into a folder, and an interrupted one leaves the old or the new.

    python3 tests/cli/test_outputs.py build/release/sinew
"""
import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import test_cli as cli
from test_cli import INTERRUPTED, PAPER_LIMB, ROOT, WRONG_INPUT, check, content, files_in, refused, said, sinew, write

HEADER = "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n"
RECORDING = HEADER + "".join(f"{k / 10},0.1,0.1,{30 + k % 3},30,{k % 7}\n" for k in range(300))
STEP = """# Coil A warm for a while.
format: 1
duration_s: 5
input: { duty_A: { step: { height_fraction: 0.4, from_s: 1, until_s: 3 } } }
"""
LONG = STEP.replace("duration_s: 5", "duration_s: 500000")
LEFT_BY_A_COMMAND = [".sinew.lock", ".sinew.partial", ".sinew.complete"]


def fresh(name):
    path = cli.folder / name
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


def never_an_input(what, arguments, names):
    """Refused without and with --overwrite; `refused` looks at every byte in the folder."""
    for option in ([], ["--overwrite"]):
        refused(" ".join([what, *option]), [*arguments, *option], names)


def test_an_output_is_never_an_input():
    reads = r"would overwrite .*%s.*, which this command reads"
    write("recording.csv", RECORDING)
    write("my.yaml", STEP.replace("input: { duty_A: { step: { height_fraction: 0.4, from_s: 1, until_s: 3 } } }",
                                  "input: { replay: { recording: recording.csv } }"))
    never_an_input("run into the folder of the recording that it replays", ["run", "my.yaml", "--out", "."], reads % r"recording\.csv")
    never_an_input("run, by another name of the folder", ["run", "my.yaml", "--out", cli.folder], reads % r"recording\.csv")
    write("scenario.yaml", STEP)
    never_an_input("run into the folder of its scenario.yaml", ["run", "scenario.yaml", "--out", "."], reads % r"scenario\.yaml")
    os.link(cli.folder / "recording.csv", fresh("hard") / "recording.csv")
    never_an_input("run over a hard link to the recording that it replays", ["run", "my.yaml", "--out", "hard"], reads % r"recording\.csv")
    (fresh("soft") / "truth.csv").symlink_to("../recording.csv")
    never_an_input("run over a symbolic link to it", ["run", "my.yaml", "--out", "soft"], reads % r"recording\.csv")
    fresh("based")
    write("based/scenario.yaml", PAPER_LIMB.read_text())
    write("based/middle.yaml", "base: scenario.yaml\n")
    write("on_base.yaml", STEP + "plant: { base: based/middle.yaml }\n")
    never_an_input("run over the base of the plant's base", ["run", "on_base.yaml", "--out", "based"], reads % r"scenario\.yaml")
    write("plant.yaml", PAPER_LIMB.read_text())
    never_an_input("calibrate over the plant it begins from", ["calibrate", "recording.csv", "--plant", "plant.yaml", "--out", "."], reads % r"plant\.yaml")
    write("heldout_prediction.csv", RECORDING)
    diagnose = ["diagnose", "--plant", PAPER_LIMB, "--out", "."]
    never_an_input("diagnose over a held-out recording", [*diagnose, "--train", "recording.csv", "--heldout", "heldout_prediction.csv"], reads % "heldout_prediction")
    never_an_input("diagnose over a training recording", [*diagnose, "--train", "heldout_prediction.csv"], reads % "heldout_prediction")
    write("comparison.svg", RECORDING)
    never_an_input("compare over its recording", ["compare", "comparison.svg", "--plant", PAPER_LIMB, "--out", "."], reads % r"comparison\.svg")
    fresh("lstm")
    write("lstm/weights.h5", "weights")
    never_an_input("train over the weights it goes on from", ["train", "recording.csv", "--from", "lstm", "--out", "lstm"], reads % r"weights\.h5")
    fresh("roll")
    write("roll/rollout.csv", RECORDING)
    never_an_input("rollout over its recording", ["rollout", "lstm", "--recording", "roll/rollout.csv", "--out", "roll"], reads % r"rollout\.csv")
    write("README.md", "format: 1\nbase: scenario.yaml\n")
    never_an_input("evaluate over its stresses", ["evaluate", "lstm", "--stress", "README.md", "--out", "."], reads % r"README\.md")
    fresh("set/runs")
    write("set/runs/0000.csv", RECORDING)
    write("from_set.yaml", STEP.split("input:")[0] + "input: { replay: { recording: set/runs/0000.csv } }\n")
    never_an_input("dataset over the recording that it replays", ["dataset", "from_set.yaml", "--runs", 2, "--out", "set"], reads % r"0000\.csv")
    write("table.json", "{}\n")
    never_an_input("paper-table over its settings", ["paper-table", "--settings", "table.json", "--out", ".", "--one-coil", "scenario.yaml",
                                                     "--two-coils", "scenario.yaml"], reads % r"table\.json")
    write("score.json", PAPER_LIMB.read_text())
    never_an_input("prove over its plant", ["prove", "--few", "--plant", "score.json", "--out", "."], reads % r"score\.json")
    never_an_input("hil over its scenario", ["hil", "scenario.yaml", "--emulate", "--out", "."], reads % r"scenario\.yaml")
    write("twin.yaml", PAPER_LIMB.read_text())
    never_an_input("hil over its twin", ["hil", "my.yaml", "--emulate", "--twin", "twin.yaml", "--out", "."], reads % r"(twin\.yaml|recording\.csv)")


def logger_text():
    rows = [[35_000_000 + 100 * k, k / 10, 30, 0.5 if 10 <= k < 30 else 0.0, 0.0, 251, 1, 285, 2, 12.5, 22 + k / 4, 23, *[0] * 4, k / 32, 7.5, 1, 1, 1]
            for k in range(60)]
    return "\n".join(["CV Data Logger started on:,2021-03-04", "anything", cli.LOGGER_HEADER, *(",".join(map(str, row)) for row in rows)]) + "\n"


def test_convert():
    write("log.txt", logger_text())
    never_an_input("convert onto its logger file", ["convert", "log.txt", "log.txt"], r"is the file that is read")
    (cli.folder / "link.csv").symlink_to("log.txt")
    never_an_input("convert through a symbolic link", ["convert", "log.txt", "link.csv"], r"is the file that is read \(log\.txt\)")
    os.link(cli.folder / "log.txt", cli.folder / "hard.csv")
    never_an_input("convert through a hard link", ["convert", "hard.csv", "log.txt"], r"is the file that is read")
    write("theirs.csv", "mine\n")
    refused("convert onto a file that is there", ["convert", "log.txt", "theirs.csv"], r"^theirs\.csv\n  is there already; .*--overwrite")
    result = sinew("convert", "log.txt", "theirs.csv", "--overwrite")
    check("convert --overwrite: replaces it", result.returncode == 0 and b"time_s,duty_A" in content("theirs.csv"), said(result))
    write("other.csv.partial", "mine\n")
    write("precious.txt", "mine\n")
    (cli.folder / ".new.csv.sinew.partial").symlink_to("precious.txt")
    results = [sinew("convert", "log.txt", name) for name in ("other.csv", "new.csv")]
    check("convert: on its way it touches no other file, nor what a link leads to", all(r.returncode == 0 for r in results)
          and content("other.csv.partial") == b"mine\n" and content("precious.txt") == b"mine\n" and not (cli.folder / "new.csv").is_symlink(), said(results[1]))
    shutil.copy(cli.folder / "log.txt", cli.folder / ".half.csv.sinew.partial")
    never_an_input("convert of what was left half-written, by its name", ["convert", ".half.csv.sinew.partial", "half.csv"], r"is the file that is read")
    with open(cli.folder / ".busy.csv.sinew.partial", "w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        refused("convert onto a file that another command is writing", ["convert", "log.txt", "busy.csv"], r"^busy\.csv: cannot write\n  another command is writing")
    result = sinew("convert", "log.txt", "busy.csv")
    check("convert: what was left half-written is taken over", result.returncode == 0 and not (cli.folder / ".busy.csv.sinew.partial").exists(), said(result))
    result = sinew("convert", "log.txt", "/dev/stdout")
    check("convert to /dev/stdout: needs no --overwrite", result.returncode == 0 and "time_s" in result.stdout, said(result))


def kept_then_replaced(what, arguments, out, names):
    """The second time it is refused and no byte changes, with --overwrite it succeeds and leaves nothing beside its files."""
    first = sinew(*arguments, "--out", out)
    check(f"{what}: succeeds the first time", first.returncode == 0 and set(names) <= set(files_in(out)), said(first) + str(files_in(out)))
    for name in names:
        if name != "session.json" and (cli.folder / out / name).is_file():  # a session that cannot be read may be of the limb
            write(f"{out}/{name}", "another run's " + name)
    refused(f"{what} into a folder with results", [*arguments, "--out", out], r"^--out = .*\n  holds results already: .*\n  .*--overwrite")
    again = sinew(*arguments, "--out", out, "--overwrite")
    check(f"{what} --overwrite: replaces them all, and leaves nothing else", again.returncode == 0 and sorted(files_in(out)) == sorted(names)
          and not any(content(f"{out}/{n}").startswith(b"another run's") for n in names if (cli.folder / out / n).is_file()), said(again) + str(files_in(out)))


def test_results_are_kept():
    write("step.yaml", STEP)
    write("made_by.yaml", cli.MADE_BY)
    kept_then_replaced("run", ["run", "made_by.yaml"], "kept/run", cli.RUN_FILES)
    recording = "kept/run/recording.csv"
    kept_then_replaced("calibrate", ["calibrate", recording, "--plant", PAPER_LIMB, "--fit", "heat_loss_A_W_K", "--starts", 1], "kept/fit", cli.CALIBRATE_FILES)
    compared = ["compare", recording, "--plant", PAPER_LIMB, "--at-rest"]
    kept_then_replaced("compare", compared, "kept/compared", ["comparison.html", "comparison.svg"])
    plant = content("kept/fit/plant.yaml")
    beside = sinew("compare", recording, "--plant", "kept/fit/plant.yaml", "--out", "kept/fit")
    check("compare beside what calibrate wrote: succeeds, and changes none of it", beside.returncode == 0 and content("kept/fit/plant.yaml") == plant
          and sorted(files_in("kept/fit")) == sorted([*cli.CALIBRATE_FILES, "comparison.html", "comparison.svg"]), said(beside))
    kept_then_replaced("hil --emulate", ["hil", "step.yaml", "--emulate"], "kept/session", ["recording.csv", "scenario.yaml", "session.json", "timed.csv", "wire.bin"])
    kept_then_replaced("replay", ["replay", "kept/session"], "kept/again", ["recording.csv", "scenario.yaml", "session.json", "timed.csv", "wire.bin"])
    kept_then_replaced("diagnose", ["diagnose", "--train", recording, "--plant", PAPER_LIMB], "kept/diagnosis", cli.DIAGNOSE_FILES)
    sinew("dataset", write("minute.yaml", (ROOT / "scenarios/babble_bidirectional.yaml").read_text().replace("duration_s: 600.0", "duration_s: 60.0")),
          "--runs", 2, "--out", "kept/set")
    settings = write("few.yaml", "stateful: { hidden: 8, dense: 8, updates: 20, streams: 30, steps: 30, settling_s: 5, shortest_life_s: 10, "
                     "longest_life_s: 20, validation_every: 20 }\n")
    kept_then_replaced("train", ["train", "kept/set", "--settings", settings], "kept/lstm", ["report.html", "training.json", "weights.h5"])
    kept_then_replaced("rollout", ["rollout", "kept/lstm", "--recording", "kept/set/runs/0000.csv"], "kept/roll", ["report.html", "rollout.csv"])
    stress = write("stress.yaml", "format: 1\nbase: minute.yaml\nseeds: 1\nrows:\n  - { name: hot, parameters: { ambient_temperature_degC: 40 } }\n")
    evaluate = ["evaluate", "kept/lstm", "--stress", stress]
    sinew(*evaluate, "--out", "kept/stress_names")
    kept_then_replaced("evaluate", evaluate, "kept/stress", files_in("kept/stress_names"))
    table = ["paper-table", "--cases", 1, "--seeds", 1, "--methods", "ARX", "--two-coils", "minute.yaml", "--out", "kept/table", "--one-coil"]
    one_coil = ROOT / "scenarios/babble_unidirectional.yaml"
    result = [sinew(*table, one_coil) for _ in range(2)]
    check("paper-table: the same command goes on", result[0].returncode == result[1].returncode == 0 and result[0].stdout == result[1].stdout, said(result[1]))
    write("other_coil.yaml", one_coil.read_text() + "\nstart: { temperature_A_degC: 26 }\n")
    refused("paper-table of another scenario into the same folder", [*table, "other_coil.yaml"], r"1-ARX-1\.json: --out = kept/table\n  other settings, (.*\n)+.*--overwrite")
    check("paper-table --overwrite: makes the cells again", sinew(*table, "other_coil.yaml", "--overwrite").returncode == 0)
    for path in ("kept/session", "kept/../kept/session"):
        never_an_input(f"replay {path} onto itself", ["replay", "kept/session", "--out", path], r"would overwrite .*, which this command reads")
    write("kept/session/prediction.csv", "of an earlier session")
    result = sinew("hil", "step.yaml", "--emulate", "--out", "kept/session", "--overwrite")
    check("--overwrite: what only the earlier run had goes with it", result.returncode == 0 and "prediction.csv" not in files_in("kept/session"), said(result))

    fresh("readme")
    write("readme/README.md", "The user's own.\n")
    scenarios = ["--one-coil", ROOT / "scenarios/babble_unidirectional.yaml"]
    for command in (["prove", "--few"], ["hil-faults"], ["paper-table", "--cases", 1, "--methods", "ARX", *scenarios]):
        refused(f"{command[0]} into a folder with a README.md of the user's", [*command, "--out", "readme"], r"holds results already: README\.md\n")
    fresh("answers")
    write("answers/answers.json", "[]\n")
    refused("prove into a folder with an answers.json that is no proof's", ["prove", "--few", "--out", "answers"], r"holds no answers of a proof")
    (fresh("in_the_way") / "run.json").mkdir()
    refused("run where a folder has the name of an output", ["run", "step.yaml", "--out", "in_the_way", "--overwrite"], r"run\.json there is a folder")
    refused("an empty --out", ["run", "step.yaml", "--out", ""], r"^--out")


def test_runs_that_were_stopped():
    write("parts.yaml", STEP.replace("duration_s: 5", "duration_s: 60") + "numerics: { restart_period_s: 5 }\n")
    sinew("run", "parts.yaml", "--out", "parts", "--seed", 2)
    before = content("parts/recording.csv")
    stopped = sinew("run", "parts.yaml", "--out", "parts", "--overwrite", "--stop-at", 20)
    check("run --overwrite that is stopped: the old result is as it was, beside the checkpoint", stopped.returncode == INTERRUPTED
          and content("parts/recording.csv") == before and "checkpoint.json" in files_in("parts") and "--overwrite --resume" in stopped.stderr, said(stopped))
    refused("run --resume over another run's results", ["run", "parts.yaml", "--out", "parts", "--resume"], r"holds results already")
    result = sinew("run", "parts.yaml", "--out", "parts", "--overwrite", "--resume")
    sinew("run", "parts.yaml", "--out", "parts_whole")
    check("run --overwrite --resume: the new result is whole, and the checkpoint gone", result.returncode == 0 and files_in("parts") == cli.RUN_FILES
          and content("parts/recording.csv") == content("parts_whole/recording.csv"), said(result))
    sinew("run", "parts.yaml", "--out", "anew", "--seed", 2, "--stop-at", 20)
    result = sinew("run", "parts.yaml", "--out", "anew", "--overwrite")
    check("run --overwrite where an earlier one stopped: starts anew", result.returncode == 0 and files_in("anew") == cli.RUN_FILES
          and content("anew/recording.csv") == content("parts_whole/recording.csv"), said(result))


def test_sets():
    write("step.yaml", STEP)
    write("other.yaml", STEP.replace("0.4", "0.3"))
    result = sinew("dataset", "step.yaml", "--runs", 4, "--out", "a_set")
    check("dataset: succeeds", result.returncode == 0, said(result))
    whole = {name: content(f"a_set/{name}") for name in files_in("a_set") if name != "runs"}
    result = sinew("dataset", "step.yaml", "--runs", 4, "--out", "a_set")
    check("dataset: the same command finds its own set", result.returncode == 0 and "4 runs are there already" in result.stderr
          and all(content(f"a_set/{name}") == before for name, before in whole.items()), said(result))
    for what, arguments in (("another scenario", ["other.yaml", "--runs", 4]), ("another seed", ["step.yaml", "--runs", 4, "--seed", 9]),
                            ("fewer runs", ["step.yaml", "--runs", 3])):
        refused(f"dataset of {what} into a finished set", ["dataset", *arguments, "--out", "a_set"], r"^--out = a_set\n  holds another set(.*\n)+.*--overwrite")
    result = sinew("dataset", "step.yaml", "--runs", 6, "--out", "a_set")
    check("dataset of more runs: goes on", result.returncode == 0 and "4 runs are there already" in result.stderr, said(result))
    result = sinew("dataset", "other.yaml", "--runs", 2, "--out", "a_set", "--overwrite")
    sinew("dataset", "other.yaml", "--runs", 2, "--out", "other_set")
    check("dataset --overwrite: nothing of the old set is left", result.returncode == 0 and files_in("a_set") == files_in("other_set")
          and all(content(f"a_set/{n}") == content(f"other_set/{n}") for n in files_in("a_set") if n != "runs"), said(result) + str(files_in("a_set")))
    (cli.folder / "a_set/manifest.json").unlink()
    refused("dataset of another scenario into a set that is not finished", ["dataset", "step.yaml", "--runs", 4, "--out", "a_set"], r"holds another set")
    fresh("own/runs")
    write("own/runs/0001.csv", RECORDING)
    refused("dataset over a recording of the user's", ["dataset", "step.yaml", "--runs", 4, "--out", "own"], r"holds another set")
    write("a_set/runs/.0001.csv.sinew.partial", "half a fi")
    write("a_set/runs/0001.csv.partial", "kept")
    sinew("dataset", "other.yaml", "--runs", 2, "--out", "a_set")
    check("dataset: half-written runs are cleaned away, and nothing else", "runs/.0001.csv.sinew.partial" not in files_in("a_set")
          and "runs/0001.csv.partial" in files_in("a_set"), files_in("a_set"))


def test_sessions_with_the_limb():
    write("step.yaml", STEP)
    sinew("hil", "step.yaml", "--emulate", "--out", "emulated")
    shutil.copytree(cli.folder / "emulated", cli.folder / "physical")
    session = json.loads(content("physical/session.json"))
    write("physical/session.json", json.dumps(session | {"limb": "/dev/ttyACM0"}))
    message = r"^physical/session\.json: --out = physical\n  a session is there already, and cannot be made again"
    for what, arguments in (("hil --emulate", ["hil", "step.yaml", "--emulate"]), ("hil --port", ["hil", "step.yaml", "--port", "/dev/null"]),
                            ("replay", ["replay", "emulated"]), ("run", ["run", "step.yaml"])):
        never_an_input(f"{what} into a session with the limb", [*arguments, "--out", "physical"], message)
    write("log.txt", logger_text())
    never_an_input("convert onto the recording of a session", ["convert", "log.txt", "physical/recording.csv"], r"belongs to a session with the limb")
    before = {name: content(f"physical/{name}") for name in files_in("physical")}
    result = sinew("compare", "physical/recording.csv", "--plant", PAPER_LIMB, "--at-rest", "--out", "physical")
    check("compare beside a session: succeeds, and leaves it as it was", result.returncode == 0
          and all(content(f"physical/{name}") == bytes_ for name, bytes_ in before.items()) and "comparison.html" in files_in("physical"), said(result))
    fresh("unreadable")
    write("unreadable/session.json", "{ half")
    never_an_input("hil into a session that cannot be read", ["hil", "step.yaml", "--emulate", "--out", "unreadable"], r"a session is there already")


def start(*arguments):
    return subprocess.Popen([cli.program, *map(str, arguments)], cwd=cli.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def test_one_at_a_time():
    write("step.yaml", STEP)
    write("long.yaml", LONG)
    lock = cli.folder / "busy/.sinew.lock"
    first = start("run", "long.yaml", "--out", "busy")
    check("a command that runs has a lock in its folder", wait_for(lambda: lock.exists() and lock.read_text()))
    for what, arguments in (("the same", ["run", "long.yaml"]), ("another command", ["compare", ROOT / "scenarios/demo/recording.csv", "--plant", PAPER_LIMB]),
                            ("one with --overwrite", ["run", "step.yaml", "--overwrite"])):
        second = sinew(*arguments, "--out", "busy")
        check(f"{what} into the same folder: refused, and says who is there", second.returncode == WRONG_INPUT and re.search(
            rf"^--out = busy\n  another command is writing into this folder: process {first.pid}, .*run long\.yaml --out busy", second.stderr), said(second))
    check("who was refused leaves the lock alone", files_in("busy") == [".sinew.lock"] and first.poll() is None)
    first.send_signal(signal.SIGINT)
    first.communicate(timeout=60)
    check("Ctrl-C: the lock goes", first.returncode == INTERRUPTED and files_in("busy") == ["checkpoint.json"], files_in("busy"))

    second = start("run", "long.yaml", "--out", "busy", "--overwrite")
    wait_for(lambda: lock.exists() and lock.read_text())
    second.kill()
    second.communicate()
    left = lock.exists()
    result = sinew("run", "step.yaml", "--out", "busy", "--overwrite")
    check("kill -9: the lock stays behind, and the next command takes it over", left and result.returncode == 0 and files_in("busy") == cli.RUN_FILES, said(result))
    fresh("recycled")
    write("recycled/.sinew.lock", f"{os.getpid()} 1\nsinew run that ended long ago\n")
    result = sinew("run", "step.yaml", "--out", "recycled")
    check("a lock whose process id belongs to another process now: taken over", result.returncode == 0 and files_in("recycled") == cli.RUN_FILES, said(result))
    write("wrong.yaml", "format: 1\nduration_s: 5\nplnt: {}\n")
    refused("an error after the lock: neither lock nor folder is left", ["run", "wrong.yaml", "--out", "deep/er/folder"], r"did you mean plant\?")

    write("slow.yaml", STEP.replace("duration_s: 5", "duration_s: 3000"))

    def ranks(*arguments):
        return cli.start_ranks(2, "dataset", "slow.yaml", "--threads", "1", "--out", "ranks", *arguments)
    first = ranks("--runs", "60")
    wait_for(lambda: len(list((cli.folder / "ranks").glob("runs/*.csv"))) > 1)
    second = ranks("--runs", "60")
    words = second.communicate(timeout=60)
    check("a second job of two ranks into the folder of one that runs: refused, and says why", second.returncode != 0
          and "another command is writing into this folder" in words[1], words)
    words = first.communicate(timeout=120)
    check("ranks: the first job is not disturbed, and its lock goes", first.returncode == 0 and "60 runs" in words[0]
          and not (cli.folder / "ranks/.sinew.lock").exists(), words)


# Ends the process at its Nth rename, before or after it is done.
KILLER = """#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
int rename(const char* from, const char* to) {
  static int count;
  const int last = ++count == atoi(getenv("KILL_AT"));
  const int after = getenv("KILL_AFTER")[0] == '1';
  if (last && !after) raise(SIGKILL);
  const int result = ((int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename"))(from, to);
  if (last && after) raise(SIGKILL);
  return result;
}
"""


def folder_bytes(path):
    return {name: content(f"{path}/{name}") for name in files_in(path) if (cli.folder / path / name).is_file()}


def test_interrupted_at_any_point():
    write("killer.c", KILLER)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", "killer.so", "killer.c", "-ldl"], cwd=cli.folder, check=True)
    write("made_by.yaml", cli.MADE_BY)
    write("step.yaml", STEP)
    write("second.yaml", STEP.replace("0.4", "0.35"))
    sinew("run", "made_by.yaml", "--out", "data")
    calibrate = ["calibrate", "data/recording.csv", "--plant", PAPER_LIMB, "--fit", "heat_loss_A_W_K", "--starts"]
    cases = {"run": (["run", "step.yaml"], ["run", "second.yaml"]),
             "calibrate": ([*calibrate, 1], [*calibrate, 2, "--seed", 5, "--fit-until", 50]),
             "hil --emulate": (["hil", "step.yaml", "--emulate"], ["hil", "second.yaml", "--emulate", "--seed", 3])}
    for what, (old_command, new_command) in cases.items():
        sinew(*old_command, "--out", "at/old")
        sinew(*new_command, "--out", "at/new")
        old, new = folder_bytes("at/old"), folder_bytes("at/new")
        check(f"{what}: old and new differ", old and new and old != new)
        seen, points, mixed, left = set(), 0, [], []
        for after in "0", "1":
            for number in range(1, 100):
                shutil.rmtree(cli.folder / "at/here", ignore_errors=True)
                shutil.copytree(cli.folder / "at/old", cli.folder / "at/here")
                environment = os.environ | {"LD_PRELOAD": str(cli.folder / "killer.so"), "KILL_AT": str(number), "KILL_AFTER": after}
                killed = subprocess.run([cli.program, *map(str, new_command), "--out", "at/here", "--overwrite"], cwd=cli.folder, env=environment,
                                        capture_output=True, text=True)
                if killed.returncode != -signal.SIGKILL:
                    break
                points += 1
                # The next command into the folder, here one that is refused, finds the old or the new.
                following = sinew(*old_command, "--out", "at/here")
                now = folder_bytes("at/here")
                if following.returncode != WRONG_INPUT or now not in (old, new):
                    mixed.append((after, number, sorted(now), said(following)))
                seen.add("old" if now == old else "new")
                left += [name for name in files_in("at/here") if "partial" in name or name in LEFT_BY_A_COMMAND]
            check(f"{what}: without the kill it succeeds", killed.returncode == 0 and folder_bytes("at/here") == new, said(killed))
        check(f"{what}: killed at any of {points} points it leaves the old or the new, never a mixture", points >= 8 and not mixed, mixed)
        check(f"{what}: there are points that leave the old and points that leave the new", seen == {"old", "new"}, seen)
        check(f"{what}: what was half-written is cleaned away", not left, left)
        for path in "at/old", "at/new":
            shutil.rmtree(cli.folder / path)
    # A folder from elsewhere, whose order reaches out of it: nothing there is touched, by reading it or by writing into it.
    write("thesis.tex", "years of work")
    (fresh("strange") / "around").symlink_to("..")
    write("strange/recording.csv", RECORDING)
    for name in "../thesis.tex", cli.folder / "thesis.tex", "around/thesis.tex", "./../strange/../thesis.tex":
        for what in "remove", "move":
            shutil.rmtree(cli.folder / "strange/.sinew.complete", ignore_errors=True)
            (cli.folder / "strange/.sinew.complete").mkdir()
            write("strange/.sinew.complete/.order", f"{what} {name}\n")
            for command in (["compare", "strange/recording.csv", "--plant", PAPER_LIMB, "--out", "elsewhere"],
                            ["compare", "data/recording.csv", "--plant", PAPER_LIMB, "--out", "strange"]):
                refused(f"an order to {what} {name}", command, r"\.order: (remove|move) = .*\n  lies outside of this folder")
    # Who only reads a folder finds one result, too.
    sinew("run", "step.yaml", "--out", "read")
    sinew("run", "second.yaml", "--out", "read_new")
    environment = os.environ | {"LD_PRELOAD": str(cli.folder / "killer.so"), "KILL_AFTER": "1"}
    for number in range(1, 100):
        if (cli.folder / "read/.sinew.complete").exists():
            break
        subprocess.run([cli.program, "run", "second.yaml", "--out", "read", "--overwrite"], cwd=cli.folder, capture_output=True,
                       env=environment | {"KILL_AT": str(number)})
    shutil.copytree(cli.folder / "read", cli.folder / "read_alone")
    result = sinew("compare", "read_alone/recording.csv", "--plant", PAPER_LIMB)
    check("a command that only reads, too", result.returncode == 0 and folder_bytes("read_alone") == folder_bytes("read_new"), said(result))
    result = sinew("compare", "read/recording.csv", "--plant", PAPER_LIMB, "--out", "elsewhere")
    check("a command that reads a folder finishes what was complete there", result.returncode == 0 and folder_bytes("read") == folder_bytes("read_new"), said(result))


def test_help():
    writers = ["run", "calibrate", "diagnose", "prove", "compare", "convert", "dataset", "train", "rollout", "evaluate", "paper-table", "hil", "replay", "hil-faults"]
    for command in writers:
        check(f"{command} --help: has --overwrite", "--overwrite" in sinew(command, "--help").stdout)


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_outputs", (test_an_output_is_never_an_input, test_convert, test_results_are_kept, test_runs_that_were_stopped, test_sets,
                                            test_sessions_with_the_limb, test_one_at_a_time, test_interrupted_at_any_point, test_help)))
