#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands that make data, train and use predictors as a person would. See test_cli.py.

    /usr/bin/python3 tests/cli/test_predict.py build/release/sinew

What is said of ONNX is checked with Debian's python3-onnx and python3-numpy, and said to be SKIPPED without.
"""
import csv
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import test_cli as cli
from test_cli import INTERRUPTED, ROOT, WRONG_INPUT, check, said, sinew, write

HEADER = "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n"


def bytes_of(path):
    """One hash of all files below, with their names."""
    whole = hashlib.sha256()
    for file in sorted((cli.folder / path).rglob("*")):
        if file.is_file():
            whole.update(str(file.relative_to(cli.folder / path)).encode() + file.read_bytes())
    return whole.hexdigest()


def refused(what, result, *words):
    check(what, result.returncode == WRONG_INPUT and all(w in result.stderr for w in words), said(result))


def test_dataset():
    scenario = ROOT / "scenarios/babble_bidirectional.yaml"
    short = write("short.yaml", scenario.read_text().replace("duration_s: 600.0", "duration_s: 60.0"))
    domain = ROOT / "scenarios/domain.yaml"
    make = ["dataset", short, "--runs", 6, "--randomise", domain]
    one = sinew(*make, "--threads", 1, "--out", "set1")
    check("dataset: six runs", one.returncode == 0 and len(list((cli.folder / "set1/runs").glob("*.csv"))) == 6, said(one))
    sinew(*make, "--threads", 2, "--out", "set2")
    check("dataset: two threads write the same bytes as one", bytes_of("set1") == bytes_of("set2"))
    (cli.folder / "set2/manifest.json").unlink()
    (cli.folder / "set2/runs/0003.csv").unlink()
    write("set2/runs/0004.csv", "half a fi")
    again = sinew(*make, "--out", "set2")
    check("dataset: what is missing or damaged is made again, and nothing else",
          bytes_of("set1") == bytes_of("set2") and "4 runs are there already" in again.stderr, said(again))

    def ranks(n, out):
        return cli.start_ranks(n, *make, "--threads", 1, "--out", out)
    process = ranks(2, "set3")
    output = process.communicate(timeout=120)
    check("dataset: two ranks under mpirun write the same bytes", process.returncode == 0 and bytes_of("set1") == bytes_of("set3"), output)
    check("dataset: one rank alone reports", output[0].count("6 runs of 60 s") == 1, output)

    wrong = cli.in_ranks(3, "dataset", "nowhere.yaml", "--runs", 3, "--out", "never")
    check("dataset: what is wrong is said once, and nothing is written", wrong.returncode == 2 and wrong.stderr.count("nowhere.yaml") == 1
          and not (cli.folder / "never").exists(), said(wrong))

    long_one = write("long.yaml", scenario.read_text().replace("duration_s: 600.0", "duration_s: 900.0"))
    make[1:4] = [long_one, "--runs", 40]
    process = ranks(2, "set4")
    deadline = time.time() + 60
    while len(list((cli.folder / "set4").glob("runs/*.json"))) < 3 and time.time() < deadline:
        time.sleep(0.02)
    os.kill(cli.process_ids(process)[-1], signal.SIGKILL)
    process.communicate(timeout=60)
    left = len(list((cli.folder / "set4").glob("runs/*.csv")))
    check("dataset: a rank that is killed ends the job with an error, without a manifest",
          process.returncode != 0 and not (cli.folder / "set4/manifest.json").exists() and 0 < left < 40, left)
    process = ranks(2, "set4")
    output = process.communicate(timeout=200)
    sinew(*make, "--out", "set5")
    check("dataset: restarted, it has the bytes of a job that was not killed",
          process.returncode == 0 and "there already" in output[1] and
          (cli.folder / "set4/manifest.json").read_bytes() == (cli.folder / "set5/manifest.json").read_bytes(), output)

    result = cli.interrupted_in_ranks(2, lambda: len(list((cli.folder / "set6").glob("runs/*.json"))) > 3, *make, "--threads", 1, "--out", "set6")
    left = len(list((cli.folder / "set6").glob("runs/*.csv")))
    check("dataset: an interrupt of one rank stops both, which had both worked, what is whole is kept and nothing gathered",
          result.returncode == 130 and "stopped; what is done is kept" in result.stderr and
          not (cli.folder / "set6/manifest.json").exists() and 0 < left < 40, (said(result), left))
    process = ranks(2, "set6")
    output = process.communicate(timeout=200)
    check("dataset: and the same command goes on", process.returncode == 0 and
          (cli.folder / "set6/manifest.json").read_bytes() == (cli.folder / "set5/manifest.json").read_bytes(), output)

    refused("dataset: a domain that names nothing is refused with its place",
            sinew("dataset", short, "--randomise", write("d.yaml", "parameters:\n  heat_los_A_W_K: { lowest: 1, highest: 2 }\n"), "--out", "no"),
            "d.yaml:2:", "did you mean heat_loss_A_W_K?")
    check("dataset: and nothing is written", not (cli.folder / "no").exists())


def test_train_and_use():
    settings = write("few.yaml", "published: { hidden: 8, dense: 8, epochs: 2 }\n"
                     "stateful: { hidden: 8, dense: 8, updates: 40, streams: 30, steps: 30, settling_s: 5, shortest_life_s: 10, "
                     "longest_life_s: 20, validation_every: 20 }\n"
                     "gru: { hidden: 8, dense: 8, updates: 40, streams: 30, steps: 30, settling_s: 5, shortest_life_s: 10, "
                     "longest_life_s: 20, validation_every: 20 }\n")
    train = ["train", "set1", "--settings", settings]
    for method in "published", "stateful":
        for case in 1, 4:
            result = sinew(*train, "--case", case, "--method", method, "--out", f"{method}{case}")
            check(f"train: case {case}, {method}", result.returncode == 0 and
                  sorted(p.name for p in (cli.folder / f"{method}{case}").iterdir()) == ["report.html", "training.json", "weights.h5"], said(result))
    sinew(*train, "--case", 4, "--threads", 1, "--out", "again")
    check("train: one thread writes the same bytes as two", (cli.folder / "again/weights.h5").read_bytes() == (cli.folder / "stateful4/weights.h5").read_bytes())
    check("train: another seed, other weights",
          sinew(*train, "--case", 4, "--seed", 2, "--out", "other").returncode == 0 and
          (cli.folder / "other/weights.h5").read_bytes() != (cli.folder / "stateful4/weights.h5").read_bytes())

    recording = cli.folder / "set1/runs/0005.csv"
    result = sinew("rollout", "stateful4", "--recording", recording, "--json")
    json_of = json.loads(result.stdout) if result.returncode == 0 else {}
    check("rollout: JSON says how far to trust it", json_of.get("interval", {}).get("share") == 0.95 and
          0 <= json_of["outside"]["share"] <= 1, said(result))
    check("rollout: JSON with the errors", {"rollout_rmse_deg", "one_step_rmse_deg"} <= set(json_of), said(result))
    result = sinew("rollout", "stateful4", "--recording", recording, "--out", "roll", "--count", "30,60")
    rows = [r for r in (cli.folder / "roll/rollout.csv").read_text().splitlines() if not r.startswith("#")]
    off = [float(r["angle_rollout_deg"]) - float(r["angle_deg"]) for r in csv.DictReader(rows)][1:]
    check("rollout: the file gives the error that is said", abs((sum(e * e for e in off) / len(off)) ** 0.5 - json_of["rollout_rmse_deg"]) < 1e-6)
    given = list(csv.DictReader(rows))[1:]
    inside = [float(r["angle_rollout_lowest_deg"]) <= float(r["angle_deg"]) <= float(r["angle_rollout_highest_deg"]) for r in given]
    outside = [r["outside"] == "1" for r in given]
    check("rollout: the file's interval and what is outside give the shares that are said",
          abs(sum(inside) / len(inside) - json_of["interval"]["inside_open_loop"]) < 1e-9 and
          abs(sum(outside) / len(outside) - json_of["outside"]["share"]) < 1e-9, (sum(inside), sum(outside), json_of))
    check("rollout: the report is there", "Rollout of a predictor" in (cli.folder / "roll/report.html").read_text())
    time_of = lambda line: float(line.split(",")[0]) if line[0].isdigit() else 0.0
    paused = write("paused.csv", "".join(l for l in recording.read_text().splitlines(True) if not 20.0 < time_of(l) < 30.0))
    result = sinew("rollout", "stateful4", "--recording", paused, "--resample", "--out", "roll_paused")
    rows = [r for r in (cli.folder / "roll_paused/rollout.csv").read_text().splitlines() if not r.startswith("#")]
    empty = [20.05 < float(r["time_s"]) < 29.95 for r in csv.DictReader(rows) if r["angle_deg"] == ""]
    check("rollout: where nothing was measured, the file says nothing",
          result.returncode == 0 and len(empty) == 99 and all(empty), (said(result), len(empty)))

    stress = write("stress.yaml", "format: 1\nbase: short.yaml\nseeds: 1\nrows:\n  - { name: hot room, parameters: { ambient_temperature_degC: 40 } }\n")
    result = sinew("evaluate", "stateful4", "--stress", stress, "--out", "stress")
    check("evaluate: table, worst first, each with a scenario that runs again", result.returncode == 0 and "hot room" in result.stdout and
          len(list((cli.folder / "stress/scenarios").glob("*.yaml"))) == 2, said(result))
    check("evaluate: without stress is drawn once",
          (cli.folder / "stress/stress.svg").read_text().count(">nothing: the limb of the base</text>") == 1)
    # README.md has the name of the folder.
    result = cli.in_ranks(2, "evaluate", "stateful4", "--stress", stress, "--threads", 1, "--out", "stress_ranks")
    of_ranks, alone = ({file.relative_to(cli.folder / name): file.read_bytes().replace(f"--out {name}`".encode(), b"")
                        for file in (cli.folder / name).rglob("*") if file.is_file()} for name in ("stress_ranks", "stress"))
    check("evaluate: two ranks under mpirun write the same bytes", result.returncode == 0 and of_ranks == alone, said(result))
    long_stress = write("long_stress.yaml", "format: 1\nbase: long.yaml\nseeds: 40\n")
    result = cli.interrupted_in_ranks(2, lambda: True, "evaluate", "stateful4", "--stress", long_stress, "--threads", 1, "--out", "never")
    check("evaluate: an interrupt of one rank stops both, which had both worked", result.returncode == 130
          and result.stderr.count("stopped; nothing was written") == 1 and not (cli.folder / "never").exists(), said(result))
    wrong = cli.in_ranks(2, "evaluate", "stateful4", "--stress", "nowhere.yaml", "--out", "never")
    check("evaluate: what is wrong is said once, and nothing is written", wrong.returncode == 2 and wrong.stderr.count("nowhere.yaml") == 1
          and not (cli.folder / "never").exists(), said(wrong))
    again = sinew("run", next((cli.folder / "stress/scenarios").glob("hot_room*.yaml")), "--out", "hot")
    check("evaluate: the scenario of a row is the room it says", again.returncode == 0 and
          "ambient_temperature_degC: 40" in (cli.folder / "hot/scenario.yaml").read_text(), said(again))

    # A duty that training, of 0.6 at most, never had; and what training had.
    hot = write("hot.yaml", "format: 1\nseed: 5\nduration_s: 40.0\nplant: { base: paper_limb }\ninput:\n"
                "  duty_A: { step: { height_fraction: 0.9, from_s: 10.0, until_s: 14.0 } }\n")
    sinew("run", hot, "--out", "hot_run")
    result = sinew("rollout", "stateful4", "--recording", "hot_run/recording.csv")
    check("rollout: a duty that was never trained on is said, with its time", result.returncode == 0 and
          re.search(r"outside\s+of\s+what\s+the\s+predictor\s+was\s+trained\s+on,\s+first\s+at\s+1\d", result.stdout) and
          re.search(r"duty\s+A\s+is\s+0\.9,", result.stdout), said(result))
    trained_on = json.loads(sinew("rollout", "stateful4", "--recording", cli.folder / "set1/runs/0000.csv", "--horizon", 35, "--json").stdout)
    check("rollout: what it was trained on is inside", trained_on["outside"]["share_by_one_column"] == 0.0, trained_on)
    result = sinew(*train, "--case", 4, "--intervals", "set2", "--out", "wide")
    check("train: intervals from the same runs in another folder are an error", result.returncode == 2 and
          "set2/runs/0000.csv: --intervals" in result.stderr and not (cli.folder / "wide").exists(), said(result))
    others = write("others.yaml", (cli.folder / "short.yaml").read_text().replace("seed: ", "seed: 9"))
    sinew("dataset", others, "--runs", 6, "--randomise", ROOT / "scenarios/domain.yaml", "--out", "others")
    result = sinew(*train, "--case", 4, "--intervals", "others", "--out", "wide")
    check("train: intervals from a set of their own", result.returncode == 0 and "6 recordings" in " ".join(result.stdout.split()), said(result))
    # A file of an older version: the same without what is new.
    older = (cli.folder / "stateful4/weights.h5").read_bytes().replace(b"sinew_trust", b"xinew_trust")
    (cli.folder / "older.h5").write_bytes(older)
    result = sinew("rollout", "older.h5", "--recording", recording)
    check("rollout: a file without intervals loads, and says that it has none", result.returncode == 0 and
          "has no intervals" in " ".join(result.stdout.split()), said(result))

    for kind, more in (("arx", ()), ("arx_simulation", ()), ("least_squares", ()), ("corrected", ("--from", "stateful4")),
                       ("plant", ("--plant", ROOT / "plant/limbs/paper_limb.yaml")), ("gru", ("--settings", settings)),
                       ("hybrid", ("--plant", ROOT / "plant/limbs/paper_limb.yaml", "--settings", settings))):
        result = sinew("train", "set1", "--case", 4, "--predictor", kind, *more, "--out", kind)
        check(f"train --predictor {kind}", result.returncode == 0 and (cli.folder / kind / "weights.h5").exists(), said(result))
        result = sinew("rollout", kind, "--recording", recording, "--json")
        errors = json.loads(result.stdout) if result.returncode == 0 else {}
        check(f"rollout: {kind}", errors.get("method") == kind and 0 < errors["one_step_rmse_deg"] < 60, said(result))
        if kind == "corrected":
            check("rollout: corrected in open loop is what is inside it, and better one step ahead",
                  errors["rollout_rmse_deg"] == json_of["rollout_rmse_deg"] and errors["one_step_rmse_deg"] < 0.5 * json_of["one_step_rmse_deg"], errors)
        result = sinew("evaluate", kind, "--stress", stress)
        check(f"evaluate: {kind}", result.returncode == 0 and "hot room" in result.stdout, said(result))
    refused("train: a plant that is not given", sinew("train", "set1", "--predictor", "plant", "--out", "never"), "--plant", "is needed")
    refused("train: a predictor that is not there", sinew("train", "set1", "--predictor", "oracle", "--out", "never"), "oracle")

    # A file that Keras wrote, as far as this goes: ours, its own description taken out by another name of the attribute.
    bare = (cli.folder / "published1/weights.h5").read_bytes().replace(b"sinew", b"other")
    (cli.folder / "bare.h5").write_bytes(bare)
    described = json.loads(re.search(rb'\{"format":1,"case":1.*?"sha256":"[0-9a-f]+"\}', (cli.folder / "published1/weights.h5").read_bytes())[0])
    duty, angle = ({"lowest": d["offset"], "highest": d["offset"] + d["span"]} for d in (described["inputs"][0], described["output"]))
    entry = lambda column, at, scale: json.dumps({"column": column, **({"at": at} if at else {}), **scale})
    refused("rollout: a file of Keras, without a word of order and scaling", sinew("rollout", "bare.h5", "--recording", recording), "bare.h5.yaml")
    write("bare.h5.yaml", "format: 1\ncase: 1\nmethod: published\ninputs:\n"
          f"  - {entry('duty_A', 't', duty)}\n  - {entry('duty_A', 't-1', duty)}\n  - {entry('angle_deg', 't-1', angle)}\n"
          f"output: {entry('angle_deg', '', angle)}\n")
    two = [json.loads(sinew("rollout", which, "--recording", recording, "--json").stdout) for which in ("published1", "bare.h5")]
    check("rollout: with them beside it, the same as ours", abs(two[0]["rollout_rmse_deg"] - two[1]["rollout_rmse_deg"]) < 1e-4, two)

    result = sinew("train", recording, "--case", 4, "--from", "stateful4", "--settings", settings, "--until", 50, "--out", "tuned")
    check("train: goes on from weights", result.returncode == 0, said(result))
    alone = ["train", recording, "--case", 4, "--until", 50]
    for what, arguments, words in [
            ("intervals from what was trained on", ["--predictor", "arx", "--intervals", recording], "--intervals"),
            ("--from of a kind that goes on from nothing", ["--predictor", "arx", "--from", "stateful4"], "--from = stateful4"),
            ("--updates of a predictor inside that counts none",
             ["--predictor", "hybrid", "--plant", ROOT / "plant/limbs/paper_limb.yaml", "--settings", "inside.yaml", "--updates", 5],
             "--updates = 5")]:
        write("inside.yaml", "hybrid: { base: arx }\n")
        result = sinew(*alone, *arguments, "--out", "never")
        check(f"train: {what} is an error, and nothing is written", result.returncode == 2 and words in result.stderr and
              not (cli.folder / "never").exists(), said(result))
    result = sinew("paper-table", "--cases", 1, "--seeds", 1, "--methods", "least squares,ARX",
                   "--one-coil", ROOT / "scenarios/babble_unidirectional.yaml", "--out", "paper")
    check("paper-table: a part of it", result.returncode == 0 and "ARX" in (cli.folder / "paper/README.md").read_text(), said(result))
    kept = [(cli.folder / "paper" / name).read_bytes() for name in ("table.json", "README.md")]
    shutil.rmtree(cli.folder / "paper")
    result = cli.in_ranks(2, "paper-table", "--cases", 1, "--seeds", 1, "--methods", "least squares,ARX", "--threads", 1,
                          "--one-coil", ROOT / "scenarios/babble_unidirectional.yaml", "--out", "paper")
    check("paper-table: two ranks under mpirun write the same bytes", result.returncode == 0
          and kept == [(cli.folder / "paper" / name).read_bytes() for name in ("table.json", "README.md")], said(result))
    result = cli.interrupted_in_ranks(2, lambda: list((cli.folder / "stopped_paper").glob("cells/*.json")), "paper-table", "--cases", 1,
                                      "--seeds", 9, "--methods", "least squares,ARX,published", "--threads", 1,
                                      "--one-coil", ROOT / "scenarios/babble_unidirectional.yaml", "--out", "stopped_paper")
    check("paper-table: an interrupt of one rank stops both", result.returncode == 130
          and result.stderr.count("stopped; the cells that are done are kept") == 1, said(result))
    shutil.rmtree(cli.folder / "paper")
    sinew("paper-table", "--cases", 1, "--seeds", 1, "--methods", "least squares,ARX",
          "--one-coil", ROOT / "scenarios/babble_unidirectional.yaml", "--out", "paper")
    check("paper-table: made anew, the same bytes", kept == [(cli.folder / "paper" / name).read_bytes() for name in ("table.json", "README.md")])
    check("paper-table: says nothing of methods that were not run", "beats published" not in (cli.folder / "paper/README.md").read_text())


def test_onnx():
    try:
        import numpy as np
        from onnx_evaluator import Evaluator
    except ImportError as missing:
        print(f"SKIPPED: ONNX files ({missing}; python3-onnx)")
        return
    recording = cli.folder / "set1/runs/0005.csv"
    header, *rows = [line.split(",") for line in recording.read_text().splitlines() if not line.startswith("#")]
    table = {name: np.array(column, float) for name, column in zip(header, zip(*rows))}
    # The same numbers, said to be of inputs in another order: v(t-1), y(t-1), v(t) as in the paper's notebook.
    (cli.folder / "notebook.h5").write_bytes((cli.folder / "bare.h5").read_bytes())
    *head, now, before, y_before, output = (cli.folder / "bare.h5.yaml").read_text().splitlines()
    write("notebook.h5.yaml", "\n".join([*head, before, y_before, now, output]))
    all_four = ["duty_A", "temperature_A_degC", "duty_B", "temperature_B_degC"]
    for model, inputs, memory in (("stateful4", all_four, True), ("stateful1", ["duty_A"], True), ("published1", ["duty_A"], False),
                                  ("bare.h5", ["duty_A"], False), ("notebook.h5", ["duty_A"], False)):
        name = model.replace(".h5", "") + ".onnx"
        result = sinew("convert", model, name)
        check(f"convert: {model} into ONNX", result.returncode == 0 and f"written: {name}" in result.stdout, said(result))
        step = Evaluator(cli.folder / name)  # runs the checker, shapes and types included
        features, hidden = len(inputs), 8
        state = {"h": [1, "streams", hidden], "c": [1, "streams", hidden]} if memory else {}
        check(f"{name}: has v, what was before, and its state as inputs, its next state as outputs", step.inputs == {
            "v": ["streams", features], "v_before": ["streams", features], "y_before": ["streams", 1], **state}
            and step.outputs == ["y", *(f"{one}_next" for one in state)], (step.inputs, step.outputs))
        check(f"{name}: says its columns and its period", step.metadata["inputs"] == ",".join(inputs) and step.metadata["output"] == "angle_deg"
              and step.metadata["sample_period_s"] == "0.1", step.metadata)
        sinew("rollout", model, "--recording", recording, "--out", f"roll_{name}")
        text = (cli.folder / f"roll_{name}/rollout.csv").read_text()
        rolled = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
        rolled = {key: np.array(column, float) for key, column in zip(rolled[0], zip(*rolled[1:]))}
        expected = np.stack([rolled["angle_rollout_deg"], rolled["angle_one_step_deg"]], 1)  # two streams side by side
        v = np.stack([table[column] for column in inputs], 1)
        carried = {one: np.zeros((1, 2, hidden)) for one in state}
        y = np.full((2, 1), table["angle_deg"][0])
        found = [y[:, 0]]
        forgot = 0.0
        for k in range(1, len(v)):
            before = y.copy()
            before[1] = table["angle_deg"][k - 1]  # one step ahead: as measured
            now = {"v": np.stack([v[k]] * 2), "v_before": np.stack([v[k - 1]] * 2), "y_before": before}
            out = step(**now, **carried)
            if memory:
                without = step(**now, **{one: np.zeros((1, 2, hidden)) for one in state})["y"]
                forgot = max(forgot, float(np.abs(without - out["y"]).max()))
            y = out["y"].astype(float)
            carried = {one: out[f"{one}_next"] for one in state}
            found.append(y[:, 0])
        span = json.loads(step.metadata["sinew"])["output"]["span"]
        off = np.abs(np.array(found) - expected).max(0) / span
        check(f"{name}: {len(v)} steps as the program's own, in open loop and one step ahead, to 1e-5 of the angle's range",
              (off < 1e-5).all(), off)
        print(f"        off by {off[0]:.1e} and {off[1]:.1e} of {span:.3g} deg")
        if memory:
            check(f"{name}: its state matters", forgot / span > 1e-3, forgot / span)
    sinew("convert", "stateful4", "twice.onnx")
    check("convert: the same bytes again", (cli.folder / "twice.onnx").read_bytes() == (cli.folder / "stateful4.onnx").read_bytes())


def test_onnx_refused():
    sinew("convert", "stateful4", "stateful4.onnx", "--overwrite")
    there = (cli.folder / "stateful4.onnx").read_bytes()
    refused("convert: no model there", sinew("convert", "nowhere", "never.onnx"), "nowhere\n", "is not there", "weights.h5")
    refused("convert: a folder without a model", sinew("convert", "set1/runs", "never.onnx"), "set1/runs/weights.h5", "is not there")
    for kind in ("arx", "corrected", "plant", "gru", "hybrid"):
        refused(f"convert: {kind} is no LSTM", sinew("convert", kind, "never.onnx"), f"{kind}/weights.h5: predictor = {kind}", "published or stateful")
    refused("convert: a recording is no model", sinew("convert", "set1/runs/0005.csv", "never.onnx"), "set1/runs/0005.csv", "is not an HDF5 file")
    refused("convert: a map is not for models", sinew("convert", "stateful4", "never.onnx", "--map", "few.yaml"), "--map", "predictor")
    refused("convert: a place that cannot be written to", sinew("convert", "stateful4", "nowhere/never.onnx"), "nowhere/never.onnx")
    refused("convert: a device", sinew("convert", "stateful4", "/proc/never.onnx"), "/proc/never.onnx")
    refused("convert: what is there already", sinew("convert", "stateful1", "stateful4.onnx"), "stateful4.onnx", "--overwrite")
    check("convert: and nothing of all that is written, or changed", not list(cli.folder.rglob("never.onnx*"))
          and (cli.folder / "stateful4.onnx").read_bytes() == there)


def test_beside_a_session():
    result = sinew("hil", "short.yaml", "--emulate", "--predict", "stateful4", "--out", "session")
    check("hil --predict: a session with a predictor beside it", result.returncode == 0 and "prediction.csv" in result.stdout and
          "off the prediction" in result.stderr and "prediction.json" in result.stdout, said(result))
    trust = json.loads((cli.folder / "session/prediction.json").read_text())
    check("hil --predict: says how far it was to be trusted", trust["interval"]["share"] == 0.95 and 0 <= trust["outside"]["share"] <= 1 and
          "The prediction: " in result.stdout and ("outside of what the predictor was trained on" in result.stderr) == (trust["outside"]["share"] > 0),
          (trust, said(result)))
    sinew("rollout", "stateful4", "--recording", "session/recording.csv", "--out", "again_roll")
    rows = lambda path: [r for r in csv.DictReader(line for line in (cli.folder / path).read_text().splitlines() if not line.startswith("#"))]
    live, later = rows("session/prediction.csv"), rows("again_roll/rollout.csv")
    check("hil --predict: what it said is the rollout of the recording",
          len(live) == len(later) and all(abs(float(a["angle_predicted_deg"]) - float(b["angle_rollout_deg"])) < 1e-9 for a, b in zip(live, later)))
    result = sinew("replay", "session")
    check("hil --predict: the session's replay gives the same bytes", result.returncode == 0 and "the same bytes" in result.stdout, said(result))
    result = sinew("hil", "short.yaml", "--emulate", "--predict", "corrected", "--out", "session_corrected")
    check("hil --predict: a predictor of another kind", result.returncode == 0 and "prediction.csv" in result.stdout, said(result))
    refused("hil --predict: no weights there", sinew("hil", "short.yaml", "--emulate", "--predict", "nowhere", "--out", "never"), "nowhere")


def test_wrong_input():
    bare = write("bare.csv", HEADER + "".join(f"{k / 10},0.1,0.1,,,{k % 7}\n" for k in range(300)))
    fast = write("fast.csv", HEADER + "".join(f"{k / 100},0.1,0.1,30,30,{k % 7}\n" for k in range(300)))
    write("fine.csv", HEADER + "".join(f"{k / 10},0.1,0.1,30,30,{k % 7}\n" for k in range(300)))
    hole = write("hole.csv", HEADER + "".join(f"{k / 10},0.1,0.1,30,30,{'' if k == 200 else k % 7}\n" for k in range(300)))
    refused("rollout: a recording without temperature, case 4", sinew("rollout", "stateful4", "--recording", bare), "temperature_A_degC", "case 4 needs it")
    refused("train: the same", sinew("train", bare, "--case", 4, "--out", "never"), "temperature_A_degC", "case 4 needs it")
    refused("rollout: another sample rate", sinew("rollout", "stateful4", "--recording", fast), "0.01 s", "10 Hz")
    refused("rollout: not a number in the data", sinew("rollout", "stateful4", "--recording", hole), "angle_deg", "20 s", "--hold-missing")
    check("rollout: which can be held", sinew("rollout", "stateful4", "--recording", hole, "--hold-missing").returncode == 0)
    refused("rollout: a horizon that is no time", sinew("rollout", "stateful4", "--recording", "fine.csv", "--horizon", "0.01"), "--horizon")
    check("rollout: a horizon beyond the recording is its end",
          sinew("rollout", "stateful4", "--recording", "fine.csv", "--horizon", "1e300").returncode == 0)
    refused("rollout: a folder", sinew("rollout", "stateful4", "--recording", "set1"), "is a folder")
    refused("train: --out that is a file, known before the work", sinew("train", "set1", "--out", "fine.csv"), "--out = fine.csv", "is a file; a folder is needed")
    refused("hil: the same", sinew("hil", "short.yaml", "--emulate", "--out", "fine.csv"), "--out = fine.csv", "is a file; a folder is needed")
    refused("evaluate: rows that are no list", sinew("evaluate", "stateful4", "--stress", write("st2.yaml", "base: short.yaml\nrows: { name: x }\n")), "st2.yaml:2:", "list")
    refused("evaluate: two rows of one name", sinew("evaluate", "stateful4", "--stress", write("st3.yaml", "base: short.yaml\nrows:\n  - { name: a b, parameters: {} }\n  - { name: a_b, parameters: {} }\n")), "st3.yaml:4:", "already")
    refused("rollout: weights of another case", sinew("rollout", "stateful4", "--case", 1, "--recording", bare), "another case than 1")
    refused("train: from weights of another case", sinew("train", bare, "--case", 3, "--from", "stateful4", "--out", "never"), "another case than 3")
    refused("train: from weights of the other method", sinew("train", "set1", "--case", 4, "--method", "published", "--from", "stateful4", "--out", "never"), "stateful")
    refused("rollout: no HDF5", sinew("rollout", write("w.h5", "nothing"), "--recording", hole), "is not an HDF5 file")
    refused("train: a folder that is no set", sinew("train", ".", "--out", "never"), "no manifest.json")
    refused("train: a setting that is not there", sinew("train", "set1", "--settings", write("s.yaml", "stateful:\n  hiden: 3\n"), "--out", "never"), "s.yaml:2:", "did you mean hidden?")
    refused("evaluate: a stress without name", sinew("evaluate", "stateful4", "--stress", write("st.yaml", "base: short.yaml\nrows:\n  - { parameters: {} }\n")), "st.yaml:3:", "needs a name")
    for length in (2, 3, 12, 30):
        short = write("few.csv", HEADER + "".join(f"{k / 10},0.1,0.{k % 10},30,30,{k % 7}\n" for k in range(length)))
        for predictor in ("arx", "arx_simulation", "corrected", "least_squares", "stateful"):
            result = sinew("train", short, "--predictor", predictor, "--out", "few")
            if predictor in ("corrected", "stateful") or length < 30:
                refused(f"train {predictor}: {length} samples are too few", result, "few.csv", "too short" if length == 2 else "are needed")
            shutil.rmtree(cli.folder / "few", ignore_errors=True)
        result = sinew("train", short, "--predictor", "published", "--out", "few")
        check(f"train published: {length} samples are few or too few, and no crash", result.returncode in (0, 2), said(result))
        shutil.rmtree(cli.folder / "few", ignore_errors=True)
    check("train: nothing of all that is written", not (cli.folder / "never").exists())
    slow = write("slow.yaml", "stateful: { settling_s: 5, updates: 100000, patience: 100000 }\n")
    process = subprocess.Popen([cli.program, "train", "set1", "--settings", slow, "--out", "stopped"], cwd=cli.folder, stderr=subprocess.PIPE, text=True)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, words = process.communicate(timeout=60)
    check("train: Ctrl-C leaves nothing", process.returncode == INTERRUPTED and "nothing was written" in words and not (cli.folder / "stopped").exists(), words)


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_predict", (test_dataset, test_train_and_use, test_onnx, test_onnx_refused, test_beside_a_session,
                                            test_wrong_input)))
