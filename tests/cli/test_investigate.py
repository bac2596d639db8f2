#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Investigations as a person would run them, in lock step on the firmware in the emulator: to the end, stopped in the middle, tripped in
the middle, with bad input.

    python3 tests/cli/test_investigate.py build/release/sinew

One line a check; the last line is `N passed, N failed`; the exit code is 1 where one failed. Python's standard library alone.
"""
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import page_client
import test_cli as cli
from test_cli import check, content, files_in, refused, said, sinew, write

# Most of the catalogue is left out, so that a diagnosis takes seconds.
KEPT = ["latent_heat", "cross_heating", "thermocouple_lag", "input_delay", "viscoelastic_creep"]
SESSION_FILES = ["emulated_limb.json", "recording.csv", "scenario.yaml", "session.json", "timed.csv", "wire.bin"]
REPORTS = ["investigation.json", "plant.yaml", "report.html", "story.txt"]


def without(*also_kept):
    names = [line.split()[0] for line in sinew("effects").stdout.splitlines() if line and not line.startswith(" ") and "(" in line]
    return [name for name in names if name not in KEPT and name not in also_kept]


def call(out, *more):
    return ["investigate", "--plant", cli.PAPER_LIMB, "--emulate", "--first", "40", "--longest", "40", "--seed", "3", "--out", out,
            "--without", ",".join(without()), *more]


def state(out):
    return json.loads(content(f"{out}/investigation.json"))


def test_to_the_end():
    latent = call("latent", "--budget", "150s", "--effect", "latent_heat", "--limb-seed", "2")
    port = page_client.free_port()
    follower = page_client.Follower(port)
    result = sinew(*latent, "--page", port, timeout=600)
    check("investigate: ends by itself", result.returncode == 0, said(result))
    one = state("latent")
    follower.join(20)
    begun = [data["name"] for data in follower.of("begin")]
    check("investigate --page: each session, what is believed after it, and how it ended", begun == [
        step["name"] for step in one["recordings"] if "recorded" in step] and len(follower.of("sample")) > 300 * len(begun)
        and any(line.startswith("Believed: ") and "latent_heat" in line for line in follower.of("said"))
        and follower.of("end")[0].startswith("The investigation has ended."), (follower.wrong, begun, follower.of("said"), follower.of("end")))
    recorded = [step for step in one["recordings"] if "recorded" in step]
    check("investigate: begins with babbling and goes on with an experiment or ends", recorded[0]["origin"] == "babbling"
          and all(step["origin"] == "experiment" for step in recorded[1:]) and "ending" in one, one)
    check("investigate: no session tripped", all(step["recorded"]["status"] == "finished" for step in recorded), one)
    check("investigate: stays within its budget", one["spent_s"] <= 150.0, one["spent_s"])
    check("investigate: latent heat is in the answer, and most probable of what has a name",
          recorded[-1]["believed"]["answers"][0]["key"].find("latent_heat") >= 0, recorded[-1].get("believed"))
    check("investigate: writes its reports, what was concealed, and a folder a recording", all(name in files_in("latent") for name in REPORTS)
          and "concealed.json" in files_in("latent")
          and all(f"{step['name']}/{name}" in files_in("latent") for step in recorded for name in SESSION_FILES), files_in("latent"))
    zeros = [float(content(f"latent/{step['name']}/timed.csv").decode().splitlines()[0].removeprefix("# time_zero_s: "))
             for step in recorded]
    pauses = [later - earlier - step["recorded"]["duration_s"] for earlier, later, step in zip(zeros, zeros[1:], recorded)]
    check("each recording says when it was made: a minute after the one before it ended", zeros[0] == 0.0
          and all(abs(pause - 60.0) < 1.0 for pause in pauses), zeros)
    for step in recorded:
        hashes = json.loads(content(f"latent/{step['name']}/session.json"))["sha256"]
        check(f"{step['name']}: session.json has a checksum of every other file",
              sorted(hashes) == sorted(set(SESSION_FILES) - {"session.json"}), hashes)
        check(f"{step['name']}: a session that plays again", sinew("replay", f"latent/{step['name']}").returncode == 0)
        check(f"{step['name']}: no hotter than the host allows", step["recorded"]["highest_degC"] < 131, step["recorded"])
    result = sinew("run", f"latent/{recorded[-1]['name']}/scenario.yaml", "--out", "alone")
    check("a scenario that was designed runs by itself", result.returncode == 0, said(result))
    result = sinew("investigate", "--replay", "--out", "latent", timeout=600)
    check("investigate --replay: the same bytes", result.returncode == 0 and "the same bytes" in result.stdout, said(result))
    before = {name: content(f"latent/{name}") for name in files_in("latent") if not name.endswith(".lock") and "." in name}
    result = sinew(*latent, timeout=600)
    check("given again, it is over and changes nothing", result.returncode == 0 and all(content(f"latent/{n}") == b for n, b in before.items()), said(result))


def test_other_uses():
    """For comparison: the whole budget is planned ahead, with one look at its end."""
    arguments = call("babbled", "--budget", "90s", "--effect", "latent_heat", "--limb-seed", "2", "--use", "babbling")
    result = sinew(*arguments, timeout=600)
    one = state("babbled")
    steps = one["recordings"]
    check("--use babbling: fills the budget with babbling, each with a seed of its own", result.returncode == 0 and one["spent_s"] == 90.0
          and [step["origin"] for step in steps] == ["babbling", "babbling"] and content("babbled/recording_02/scenario.yaml").find(b"seed: 4") >= 0,
          said(result))
    check("--use babbling: looks once, at the end", ["believed" in step for step in steps] == [False, True], one)
    check("the state that a later call reads does not say what is concealed", "concealed_sha256" in one["identity"]
          and "latent_heat" not in json.dumps(one["identity"]), one["identity"])
    result = sinew("investigate", "--replay", "--out", "babbled", timeout=600)
    check("--use babbling: --replay makes the same bytes", result.returncode == 0 and "the same bytes" in result.stdout, said(result))
    refused("what was begun with --use, without it", arguments[:-2], r"--use\n  is not what this investigation was begun with", cli.WRONG_INPUT)


def test_nothing_concealed():
    write("on_board.yaml", "format: 1\neffects:\n  input_delay:\n    delay_s: 0.02\n")
    arguments = call("clean", "--budget", "60s")
    arguments[arguments.index("--plant") + 1] = "on_board.yaml"
    result = sinew(*arguments, timeout=600)
    answers = state("clean")["recordings"][0]["believed"]["answers"]
    check("a limb that is its plant: nothing is missing, most probably", result.returncode == 0 and answers[0]["key"] == "nothing", answers)
    keys = [answer["key"] for answer in answers]
    check("effects that are further forms of another go by its name, once", "thermocouple_lag" in keys and len(keys) == len(set(keys))
          and not {"stress_shift_curved", "stress_shift_two_slopes", "driver_lag", "thermocouple_two_lags"} & set(keys), keys)
    arguments[arguments.index("--out") + 1] = "warming"
    arguments[arguments.index("--without") + 1] = ",".join(without("ambient_drift"))
    arguments[arguments.index("--budget") + 1] = "300s"
    arguments[arguments.index("--longest") + 1] = "160"
    result = sinew(*arguments, "--probability", "0.7", timeout=600)
    one = state("warming")
    first = one["recordings"][0]["believed"]
    check("nothing is missing, but 40 s could not show a room that warms: it is asked for", result.returncode == 0
          and first["answers"][0]["key"] == "nothing" and first["answers"][0]["probability"] > 0.7
          and "ambient_drift" in first["could_not_be_seen"] and len(one["recordings"]) > 1, said(result) + json.dumps(first))
    arguments[arguments.index("--budget") + 1] = "60s"
    arguments[arguments.index("--longest") + 1] = "40"
    arguments[arguments.index("--out") + 1] = "gain"
    arguments[arguments.index("--without") + 1] = ",".join(without("thermocouple_heat_sink"))
    result = sinew(*arguments, "--probability", "0.5", timeout=600)
    one = state("gain")
    check("where it ends with nothing, it says that duty cannot show the thermocouple's gain, and what would", one["ending"]["why"] == "resolved"
          and "thermocouple_heat_sink cannot be told by duty" in one["ending"]["words"] and "the wire's temperature" in " ".join(one["measure_instead"]),
          said(result))


def test_stopped_and_resumed():
    arguments = call("stopped", "--budget", "90s")
    process = subprocess.Popen([cli.program, *map(str, arguments)], cwd=cli.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if (cli.folder / "stopped/recording_01/.sinew.partial/scenario.yaml").exists():
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)  # at once: of the limb's time next to nothing has gone by
    out, errors = process.communicate(timeout=120)
    session = json.loads(content("stopped/recording_01/session.json"))
    check("Ctrl-C in a session: exit code 130, the coils are off, the recording is kept", process.returncode == 130
          and session["status"] == "stopped" and session["brought_to_rest"], out + errors)
    check("Ctrl-C: the state says that a person stopped it", state("stopped")["ending"]["why"] == "stopped", state("stopped"))
    result = sinew(*arguments, timeout=600)
    after = state("stopped")
    check("the same command goes on from there", result.returncode == 0 and after["ending"]["why"] != "stopped"
          and after["recordings"][0]["recorded"]["status"] == "stopped" and len(after["recordings"]) >= 2, said(result))
    check("what was recorded before is as it was", json.loads(content("stopped/recording_01/session.json")) == session)
    check("a session that was stopped plays again", sinew("replay", "stopped/recording_01").returncode == 0)
    refused("going on with another limb", [*arguments, "--effect", "latent_heat"],
            r"stopped/investigation\.json: --effect, --limb-seed, --strength\n  is not what this investigation was begun with")


def test_a_limb_that_is_gone():
    arguments = call("gone", "--budget", "90s")
    result = sinew(*arguments, "--fault", "sensor_open:A@8", timeout=600)  # too short to be used: it would babble again
    check("a session that tripped leaves its limb", result.returncode == 1 and "recording_01/emulated_limb.json" in files_in("gone"),
          said(result))
    left = json.loads(content("gone/recording_01/emulated_limb.json"))
    (cli.folder / "gone/recording_01/emulated_limb.json").unlink()
    refused("going on where the emulator was killed, and its limb with it", arguments,
            r"gone/recording_01/emulated_limb\.json\n  is not there: the emulator was killed")
    beside = Path(cli.program).resolve().parent
    scenario = write("goes_on.yaml", "format: 1\nduration_s: 5\n")
    command = [beside / "sinew-emulator", scenario, "--firmware", beside / "firmware.elf", "--lock-step"]
    for what, limb, words in (("another limb", left | {"limb": left["limb"] + "0"}, "is another limb"),
                              ("a time before the first session", left | {"time_s": -1.0}, "time_s")):
        result = subprocess.run([*map(str, command), "--goes-on-from", write("limb.json", json.dumps(limb))], cwd=cli.folder,
                                stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
        check(f"sinew-emulator --goes-on-from: {what} is refused", result.returncode == 2 and words in result.stderr, result.stderr)


def test_trip_and_resumed():
    arguments = call("tripped", "--budget", "90s")
    result = sinew(*arguments, "--fault", "sensor_open:A@25", timeout=600)
    one = state("tripped")
    check("a trip in a session ends the call with 1, and says why", result.returncode == 1 and one["ending"]["why"] == "interrupted"
          and "sensor" in one["ending"]["words"], said(result))
    check("a trip: what was recorded until then is kept", one["recordings"][0]["recorded"]["duration_s"] > 20
          and "recording_01/timed.csv" in files_in("tripped"), one)
    result = sinew(*arguments, timeout=600)
    check("after the trip the same command goes on, with what was recorded", result.returncode == 0
          and state("tripped")["recordings"][0]["recorded"]["used"] and state("tripped")["ending"]["why"] != "interrupted", said(result))
    other_seed = list(arguments)
    other_seed[other_seed.index("--seed") + 1] = "4"
    refused("another seed into the same folder", other_seed, r"seed.*\n.*begun with", cli.WRONG_INPUT)


def test_bad_input():
    base = ["investigate", "--plant", cli.PAPER_LIMB, "--out", "bad"]
    refused("investigate without a limb", base, r"--port, --emulate")
    refused("investigate with two limbs", [*base, "--emulate", "--port", "/dev/null"], r"one of the two")
    refused("a budget that is none", [*base, "--emulate", "--budget", "30 parsecs"], r"--budget = 30 parsecs\n.*30min")
    refused("a budget that is too short", [*base, "--emulate", "--budget", "5s"], r"1 min to 24 h")
    refused("an effect that there is not", [*base, "--emulate", "--effect", "latent_hat"], r"--effect = latent_hat\n.*latent_heat")
    refused("a page where no session runs", [*base, "--emulate", "--dry-run", "--page", "8765"], r"--page\n?.*--dry-run")
    refused("an effect in a limb at a port", [*base, "--port", "/dev/null", "--effect", "latent_heat"], r"are for --emulate")
    refused("another use of a limb at a port", [*base, "--port", "/dev/null", "--use", "once"], r"--use = once\n.*comparison")
    refused("a use that there is not", [*base, "--emulate", "--use", "twice"], r"--use.*twice")
    refused("leaving out what there is not", [*base, "--emulate", "--without", "latent_hat"], r"did you mean latent_heat")
    refused("a recording that is not there", [*base, "--emulate", "--train", "none.csv"], r"none\.csv")
    (cli.folder / "damaged").mkdir()
    write("damaged/investigation.json", "{}")
    refused("a state that is none", ["investigate", "--plant", cli.PAPER_LIMB, "--emulate", "--out", "damaged"], r"investigation\.json")
    result = sinew("investigate", "--plant", cli.PAPER_LIMB, "--emulate", "--out", "dry", "--dry-run")
    check("--dry-run: says what it would do, with the scenario, and writes nothing", result.returncode == 0 and "would run recording_01" in result.stdout
          and "babble" in result.stdout and files_in("dry") is None, said(result))


def test_what_is_there_is_kept():
    """Recordings in the folders that it would write into: another investigation's, a person's, a session with the limb."""
    write("made_by.yaml", cli.MADE_BY)
    sinew("run", "made_by.yaml", "--out", "made")
    recording = content("made/recording.csv").decode()
    call_into = ["investigate", "--plant", cli.PAPER_LIMB, "--emulate", "--out"]
    for name in "theirs/recording_01", "later/recording_03", "limb/recording_01", "given/recording_01":
        (cli.folder / name).mkdir(parents=True)
    write("theirs/recording_01/recording.csv", recording)
    refused("a person's recording where it would write", [*call_into, "theirs"], r"^--out = theirs\n  holds results already: recording_01/recording\.csv\n.*--overwrite")
    write("later/recording_03/timed.csv", recording)
    refused("another's recording further on", [*call_into, "later"], r"holds results already: recording_03/timed\.csv\n")
    sinew("hil", write("step.yaml", "format: 1\nduration_s: 5\n"), "--emulate", "--out", "session")
    for name in "recording.csv", "wire.bin", "scenario.yaml":
        (cli.folder / "limb/recording_01" / name).write_bytes(content(f"session/{name}"))
    write("limb/recording_01/session.json", json.dumps(json.loads(content("session/session.json")) | {"limb": "/dev/ttyACM0"}))
    write("given/recording_01/recording.csv", recording)
    for option in [], ["--overwrite"]:
        refused(" ".join(["a session with the limb where it would write", *option]), [*call_into, "limb", *option],
                r"limb/recording_01/session\.json: --out = limb\n  a session is there already")
        refused(" ".join(["over a recording that it is given", *option]),
                [*call_into, "given", "--train", "given/recording_01/recording.csv", *option],
                r"would overwrite given/recording_01/recording\.csv, which this command reads")
    before = files_in("."), cli.all_files()
    result = sinew(*call_into, "dry", "--train", "made/recording.csv", "--dry-run")
    check("--dry-run with a recording: says what it would do, and writes nothing", result.returncode == 0
          and "would run recording_02" in result.stdout and before == (files_in("."), cli.all_files()), said(result))
    # A recording that is given takes the place of all files of another one.
    write("theirs/recording_01/timed.csv", recording)
    result = sinew(*call("theirs", "--budget", "60s", "--train", "made/recording.csv", "--overwrite"), timeout=600)
    check("--overwrite: of another's recording nothing is left beside the given one", result.returncode == 0
          and files_in("theirs/recording_01") == ["recording.csv"], said(result) + str(files_in("theirs")))


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_investigate", (test_bad_input, test_what_is_there_is_kept, test_to_the_end, test_other_uses,
                                                test_nothing_concealed, test_stopped_and_resumed, test_a_limb_that_is_gone,
                                                test_trip_and_resumed)))
