#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/prove_investigations on made-up stories: its scores, its intervals, its page, and what is not run again. No limb is simulated:
in the program's place stands a script that writes the states.

    python3 tests/cli/test_prove_investigations.py
"""
import importlib.machinery
import importlib.util
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools/prove_investigations"
counts = {True: 0, False: 0}

# In the place of sinew: notes the call; `core` is resolved by its first recording, others by an experiment, "once" not at all.
STAND_IN = '''#!/usr/bin/env python3
import json, os, sys, time
from pathlib import Path
folder = Path(__file__).parent
if "--version" in sys.argv:
    print("sinew 0 (" + (folder / "commit").read_text() + ")")
    sys.exit(0)
def of(name, otherwise=None):
    return sys.argv[sys.argv.index(name) + 1] if name in sys.argv else otherwise
out, kind, use = Path(of("--out")), of("--effect"), of("--use", "designed")
with open(folder / "calls", "a") as calls:
    calls.write(f"{of('--limb-seed')} {kind} {use} {of('--budget')}\\n")
if (folder / "fails").exists() and use == "random":
    sys.exit(3)
if (folder / "slow").exists():
    import signal
    signal.signal(signal.SIGINT, lambda *_: sys.exit(130))
    time.sleep(30)
out.mkdir(parents=True, exist_ok=True)
def step(name, origin, answers):
    return {"name": name, "origin": origin, "plan": {"words": origin},
            "recorded": {"status": "finished", "why": "", "duration_s": 120.0, "highest_degC": 80.0, "commands_lowered_by_host": 0, "used": True},
            "believed": {"verdict": "v", "answers": [{"key": k, "kind": "named", "probability": p} for k, p in answers]}}
right = "nothing" if kind == "core" else kind
steps = [step("recording_01", "babbling", [(right, 0.97)] if kind == "core" else [("latent_heat", 0.6), (right, 0.4)])]
if kind != "core":
    steps.append(step("recording_02", "experiment", {"once": [("latent_heat", 0.6)], "random": [("latent_heat", 0.99)]}.get(use, [(right, 0.98)])))
state = {"probability": 0.95, "spent_s": 120.0 * len(steps), "ending": {"why": "resolved", "words": "w"}, "recordings": steps}
(out / "story.txt").write_text("It ended.\\nmore\\n")
(out / "investigation.json").write_text(json.dumps(state))
'''


def check(what, holds, detail=""):
    counts[bool(holds)] += 1
    print(("ok      " if holds else "FAILED  ") + what, flush=True)
    if not holds:
        print("        " + str(detail)[:2000], flush=True)


def read_tool():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("prove_investigations", str(TOOL))
    tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("prove_investigations", loader))
    loader.exec_module(tool)
    return tool


def believed(*answers, answer_kind="named", ending="resolved", measure=()):
    state = {"probability": 0.95, "ending": {"why": ending}, "measure_instead": list(measure)}
    return state, {"answers": [{"key": key, "kind": answer_kind, "probability": probability} for key, probability in answers]}


def test_scores(tool):
    def score(kind, *answers, **more):
        return tool.outcome_of(kind, *believed(*answers, **more))
    wire = "the wire's temperature by another thermometer"
    for what, due, got in (
            ("the true name with what is asked", "right", score("cross_heating", ("cross_heating", 0.96), ("nothing", 0.04))),
            ("the true name with less", "not resolved", score("cross_heating", ("cross_heating", 0.94), ending="cannot_tell")),
            ("the true name, which the diagnosis does not give", "not resolved", score("cross_heating", ("cross_heating", 0.99), answer_kind="unseen")),
            ("another name", "wrong", score("cross_heating", ("body_heat_storage", 0.95))),
            ("the true name and one more", "wrong", score("cross_heating", ("cross_heating+dry_friction", 0.99))),
            ("nothing, where something is", "wrong", score("cross_heating", ("nothing", 0.99))),
            ("something else, where there is a name", "not resolved", score("cross_heating", ("something else", 0.99), ending="budget")),
            ("something else, where there is none", "right", score("rate_shift", ("something else", 0.97), ending="cannot_tell")),
            ("something else with less", "not resolved", score("rate_shift", ("something else", 0.9), ending="cannot_tell")),
            ("a name, where there is none", "wrong", score("rate_shift", ("stress_shift", 0.97))),
            ("nothing, where nothing is", "right", score("core", ("nothing", 0.97))),
            ("a name, where nothing is", "wrong", score("core", ("latent_heat", 0.97))),
            ("another form has its effect's name", "right", score("latent_heat.directional", ("latent_heat", 0.97))),
            ("gain: cannot tell, and what to measure", "right", score("thermocouple_heat_sink", ("nothing", 0.6), ending="cannot_tell", measure=[wire])),
            ("gain: nothing that duty could show, and what to measure", "right", score("thermocouple_heat_sink", ("nothing", 0.96), measure=[wire])),
            ("gain: nothing, without a word of it", "wrong", score("thermocouple_heat_sink", ("nothing", 0.96))),
            ("gain: cannot tell, and something else to measure", "not resolved",
             score("thermocouple_heat_sink", ("nothing", 0.6), ending="cannot_tell", measure=["the angle by a camera"])),
            ("gain: its name", "right", score("thermocouple_heat_sink", ("thermocouple_heat_sink", 0.96))),
            ("gain: the budget is used", "not resolved", score("thermocouple_heat_sink", ("nothing", 0.6), ending="budget", measure=[wire]))):
        check(f"score: {what}: {due}", got == due, got)
    low, high = tool.wilson(9, 10)  # Brown, Cai, DasGupta 2001: by the formula, by hand
    check("interval: 9 of 10 is 59.6 to 98.2 %", abs(low - 0.5958) < 5e-4 and abs(high - 0.9821) < 5e-4, (low, high))
    check("interval: none of none is everything", tool.wilson(0, 0) == (0.0, 1.0))
    cases = tool.cases_of(list(tool.RIGHT), 3001, 40)
    check("cases: every kind comes once before any comes twice, each with a seed of its own", len({kind for _, kind in cases[:len(tool.RIGHT)]})
          == len(tool.RIGHT) and [seed for seed, _ in cases] == list(range(3001, 3041)), cases)


def test_runs(folder):
    program = folder / "sinew"
    program.write_text(STAND_IN)
    program.chmod(0o755)
    (folder / "commit").write_text("abc")
    arguments = [sys.executable, "-B", str(TOOL), "--program", str(program), "--out", str(folder / "out"), "--work", str(folder / "work"),
                 "--kinds", "core,cross_heating", "--first-seed", "7"]

    def run(*more):
        return subprocess.run([*arguments, *more], capture_output=True, text=True, timeout=60)

    def calls():
        text = (folder / "calls").read_text().splitlines() if (folder / "calls").exists() else []
        (folder / "calls").unlink(missing_ok=True)
        return text
    (folder / "fails").touch()
    result = run("--cases", "2")
    check("a program that fails ends the tool, which says with what", result.returncode == 1 and "exit code 3" in result.stderr, result.stderr)
    check("until then: the case that was resolved at once is called once, the other by its budget and by its minutes",
          calls() == ["7 core designed 30min", "8 cross_heating designed 30min", "8 cross_heating babbling 240s", "8 cross_heating random 240s"])
    (folder / "fails").unlink()
    result = run("--cases", "2")
    check("given again, it runs what is not there", result.returncode == 0 and calls() == ["8 cross_heating random 240s", "8 cross_heating once 240s"],
          result.stderr)
    one = json.loads((folder / "out/cases/8_cross_heating.json").read_text())
    outcomes = {use: part["outcome"] for use, part in one["uses"].items()}
    check("each use has its score", outcomes == {"designed": "right", "babbling": "right", "random": "wrong", "once": "not resolved"}, outcomes)
    check("each look has its score and its minutes", [(look["outcome"], look["minutes"]) for look in one["uses"]["designed"]["looks"]]
          == [("not resolved", 2.0), ("right", 4.0)], one["uses"]["designed"]["looks"])
    page = (folder / "out/README.md").read_text()
    check("the page counts: 2 of 2 right by investigation, 1 of 2 by chance, which is wrong once", "| investigation | 2 of 2 (34 to 100 %) | 0 of 2" in page
          and "| programmes by chance | 1 of 2 (9 to 91 %) | 1 of 2 (9 to 91 %) | 0 | 2.0 |" in page, page)
    check("the page says every miss, with the report's words, and what goes on", "| 8 | `cross_heating` | programmes by chance | wrong | 4.0 | latent_heat 99 %"
          in page and "It ended." in page and "--first-seed 7 --cases 2" in page, page)
    check("the page says what probabilities were worth: 0.6 was wrong at the first look, 0.97 there and 0.98 later were right",
          "| 50 to 80 % | 0 of 1 (0 to 79 %), 60 % said | no case | no case |" in page
          and "| 95 to 100 % | 1 of 1 (21 to 100 %), 97 % said | 1 of 1 (21 to 100 %), 98 % said | 2 of 2 (34 to 100 %), 98 % said |" in page, page)
    before = {file: file.read_bytes() for file in (folder / "out").rglob("*") if file.is_file()}
    result = run("--cases", "2")
    check("given once more, nothing is run and nothing changes", result.returncode == 0 and calls() == []
          and before == {file: file.read_bytes() for file in (folder / "out").rglob("*") if file.is_file()}, result.stderr)
    check("no file is left half", not list((folder / "out").rglob("*.partial")))
    (folder / "commit").write_text("def")
    result = run("--cases", "3")
    check("another program's results are not added to", result.returncode == 1 and "commit" in result.stderr and calls() == [], result.stderr)
    (folder / "commit").write_text("abc")
    (folder / "slow").touch()
    process = subprocess.Popen([*arguments, "--cases", "4"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(200):
        if (folder / "calls").exists():
            break
        time.sleep(0.05)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=20)
    check("Ctrl-C ends the investigation and the tool with 130, and writes nothing half", process.returncode == 130
          and before == {file: file.read_bytes() for file in (folder / "out").rglob("*") if file.is_file()}, (process.returncode, said))
    result = run("--kinds", "no_such_kind")
    check("a kind that there is not: said, with those that there are", result.returncode == 2 and "cross_heating" in result.stderr, result.stderr)


def main():
    folder = Path(tempfile.mkdtemp(prefix="sinew_prove_investigations_"))
    try:
        test_scores(read_tool())
        test_runs(folder)
    finally:
        shutil.rmtree(folder)
    print(f"{counts[True]} passed, {counts[False]} failed")
    sys.exit(1 if counts[False] else 0)


if __name__ == "__main__":
    main()
