#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hardware in the loop as a person would use it, on the real firmware in the emulator: in lock step, and in real time on a
pseudo-terminal.

    python3 tests/cli/test_hil.py build/release/sinew

One line a check; the last line is `N passed, N failed`; the exit code is 1 where one failed. Python's standard library alone.
"""
import json
import os
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import page_client
import test_cli as cli
from test_cli import check, columns, content, files_in, refused, said, same_bytes, sinew, write

SESSION_FILES = ["recording.csv", "scenario.yaml", "session.json", "timed.csv", "wire.bin"]
BABBLE = """# Half a minute of babbling.
format: 1
seed: 5
duration_s: 30
input: { babble: { lowest_deg: -45, highest_deg: 45, longest_hold_s: 8 } }
"""
STEP = """# Coil A warm for a while.
format: 1
duration_s: 8
input: { duty_A: { step: { height_fraction: 0.4, from_s: 1, until_s: 7 } } }
"""
# So little heat that the coils stay cool enough to arm again at once.
MILD = """# Coil A hardly warm.
format: 1
duration_s: 4
input: { duty_A: { constant: { value_fraction: 0.02 } } }
"""


def session(folder):
    return json.loads(content(f"{folder}/session.json"))


def test_lock_step():
    write("babble.yaml", BABBLE)
    result = sinew("hil", "babble.yaml", "--emulate", "--out", "one", "--twin", cli.PAPER_LIMB)
    check("hil --emulate: succeeds and says what it wrote", result.returncode == 0 and "301 samples, finished" in result.stdout, said(result))
    check("hil: writes its files and nothing else", files_in("one") == sorted(SESSION_FILES + ["twin.yaml"]), files_in("one"))
    sinew("hil", "babble.yaml", "--emulate", "--out", "two", "--twin", cli.PAPER_LIMB)
    same_bytes("two sessions in lock step", "one", "two", SESSION_FILES)
    report = session("one")
    check("hil: ends at rest, every deadline kept, nothing lost", report["status"] == "finished" and report["brought_to_rest"]
          and report["ticks_without_telemetry"] == 0 and report["link"]["frames_missing"] == 0 and report["overruns"] == 0, report)
    check("hil: a limb that is its twin does not leave it", "departures_from_twin" not in report, report)
    recording, duty = columns("one/recording.csv"), []
    for name in ("duty_A", "duty_B"):
        duty += recording[name]
    check("hil: the recording has 301 rows at 10 Hz, driven and warm", recording["time_s"] == [k / 10 for k in range(301)]
          and 0.1 < max(duty) <= 0.7 and max(recording["temperature_A_degC"] + recording["temperature_B_degC"]) > 60)
    check("hil: no coil is measured beyond the host's limit", max(recording["temperature_A_degC"] + recording["temperature_B_degC"]) < 131)
    result = sinew("run", "babble.yaml", "--out", "run")
    check("hil: the same scenario runs on the plant as it is", result.returncode == 0, said(result))
    result = sinew("compare", "one/recording.csv", "--plant", cli.PAPER_LIMB, "--json", "--at-rest")
    shown = json.loads(result.stdout)
    check("hil: compare takes the recording, and the plant explains it", result.returncode == 0
          and cli.rmse(shown, "temperature_A_degC") < 1.5 and cli.rmse(shown, "angle_deg") < 1.5, said(result))
    result = sinew("replay", "one")
    check("replay: the same bytes", result.returncode == 0 and "the same bytes" in result.stdout, said(result))
    result = sinew("replay", "one", "--out", "again")
    same_bytes("replay --out", "one", "again", SESSION_FILES)
    result = sinew("hil", "babble.yaml", "--emulate", "--out", "corrupt", "--corrupt", "0.01")
    counted = session("corrupt")["link"]
    damaged = int(re.search(r"(\d+) frames were damaged", result.stdout).group(1))
    found = counted["refused_by_host_in_all"] + sum(counted["counted_by_device"][n] for n in
                                                    ("too_long", "bad_stuffing", "too_short", "bad_check", "bad_length"))
    check("--corrupt: the session runs on, and damaged frames are refused and counted", result.returncode == 0 and damaged > 5
          # A flipped ending 0x00 makes one frame of two.
          and damaged * 0.9 <= found <= damaged * 1.5, (damaged, counted))
    check("replay of a session with damaged frames: the same bytes", sinew("replay", "corrupt").returncode == 0)


def test_refusals():
    write("step.yaml", STEP)
    refused("hil with neither --port nor --emulate", ["hil", "step.yaml", "--out", "o"], r"one of the two")
    refused("hil with both", ["hil", "step.yaml", "--emulate", "--port", "/dev/null", "--out", "o"], r"one of the two")
    refused("hil with a fault for the limb", ["hil", "step.yaml", "--port", "/dev/null", "--fault", "hang@1"], r"for --emulate")
    refused("hil at a port that is not there", ["hil", "step.yaml", "--port", "/dev/serial/by-id/no", "--out", "o"], r"no such port\n")
    refused("hil at what is no port", ["hil", "step.yaml", "--port", "/dev/null", "--out", "o"], r"--port = /dev/null\n")
    write("fast.yaml", STEP.replace("duration_s: 8", "duration_s: 8\nsample_period_s: 0.001"))
    refused("hil at a kilohertz", ["hil", "fast.yaml", "--emulate", "--out", "o"], r"sample_period_s = 0\.001\n  must be 0\.005 or more")
    write("lazy.yaml", STEP.replace("duration_s: 8", "duration_s: 600\nsample_period_s: 60"))
    refused("hil at a sample a minute", ["hil", "lazy.yaml", "--emulate", "--out", "o"], r"sample_period_s = 60\n  must be 0\.2 or less")
    refused("replay of a folder that is none", ["replay", "nowhere"], r"session\.json: cannot read")
    result = sinew("hil", "step.yaml", "--emulate", "--out", "o", "--fault", "sensor_opn:A@3")
    check("a fault that there is not: said by the emulator, wrong input, nothing written", result.returncode == 2
          and "there is no such fault" in result.stderr and "the emulator refuses" in result.stderr and files_in("o") is None, said(result))
    result = sinew("hil", "step.yaml", "--emulate", "--out", "o", "--fault", "sensor_open:B@0")
    check("a thermocouple that is open from the start: not armed, nothing written", result.returncode == 1
          and "a sensor is not believed" in result.stderr and "B sensor_open" in result.stderr and files_in("o") is None, said(result))
    coils = ", ".join(f"{{name: c{j}, segment: s, direction_deg: {90 * (j % 4)}}}" for j in range(9))
    shown = ", ".join(f"{{column: temperature_c{j}_degC, thermocouple: c{j}}}" for j in range(9))
    nine = f"plant: {{ limb: {{ segments: [{{name: s}}], coils: [{coils}], channels: [{shown}] }} }}\n"
    write("nine.yaml", "format: 1\nduration_s: 8\n" + nine)
    refused("hil with nine coils", ["hil", "nine.yaml", "--emulate", "--out", "o"], r"nine\.yaml: plant\.limb\.coils = 9\n  the wire to a board carries 1 to 8 coils")
    result = subprocess.run([sys.executable, cli.ROOT / "tools/board_schematic", "--check"], capture_output=True, text=True)
    check("docs/board.svg and board.net are as made, and sound", result.returncode == 0, result.stdout)
    project = [sys.executable, cli.ROOT / "tools/firmware_project", "--hash", Path(cli.program).parent / "generated/firmware_hash.h"]
    result = subprocess.run([*project, "--check"], capture_output=True, text=True)
    check("the firmware's layouts for PlatformIO and the Arduino IDE compile and link", result.returncode == 0, result.stdout + result.stderr)
    result = subprocess.run([*project, "platformio", cli.folder / "pio"], capture_output=True, text=True)
    check("a layout is written whole", result.returncode == 0 and (cli.folder / "pio/src/firmware_hash.h").is_file()
          and (cli.folder / "pio/platformio.ini").is_file(), result.stderr)
    result = subprocess.run([*project, "platformio", cli.folder / "pio"], capture_output=True, text=True)
    check("a layout does not go into a folder with content", result.returncode == 2 and "not empty" in result.stderr, result.stderr)
    result = subprocess.run([sys.executable, cli.ROOT / "tools/check_firmware"], capture_output=True, text=True)
    check("cppcheck finds nothing in the firmware, and no MISRA rule is broken without a reason; all but a board's file compiles for a Cortex-M0+",
          result.returncode == 0, result.stdout)
    print(*[line for line in result.stdout.splitlines() if line.startswith("SKIPPED")], sep="\n", end="")
    write("mine.txt", "mine")
    for program in ("sinew-board", "sinew-emulator"):
        command = [Path(cli.program).parent / program, "--link", "mine.txt"]
        if program == "sinew-emulator":
            command += ["step.yaml", "--firmware", Path(cli.program).parent / "firmware.elf"]
        result = subprocess.run(command, cwd=cli.folder, capture_output=True, text=True, timeout=20)
        check(f"{program} --link with the name of a file: the file stays, exit code 2", result.returncode == 2
              and "mine.txt" in result.stderr and content("mine.txt") == b"mine", said(result))
    result = sinew("hil", "step.yaml", "--emulate", "--out", "measured", "--measure-board")
    used = re.search(r"^stack: at most (\d+) bytes; with \d+ of variables that leaves (\d+) of 2048\ninterrupt, millisecond: at most ([\d.]+) us",
                     result.stderr, re.M)
    check("--measure-board: a stack that leaves 100 bytes, a millisecond interrupt below 20 us", result.returncode == 0 and used
          and int(used[1]) > 100 and int(used[2]) >= 100 and 1 < float(used[3]) < 20, said(result))
    hexadecimal = dict(re.findall(r"([lhe]fuse):w:(0x[0-9A-F]{2}):m", (cli.ROOT / "docs/hardware.md").read_text()))
    check("docs/hardware.md sets three fuses", sorted(hexadecimal) == ["efuse", "hfuse", "lfuse"], hexadecimal)
    set_so = [f"--fault=fuse_high@0={int(hexadecimal['hfuse'], 16)}", f"--fault=fuse_extended@0={int(hexadecimal['efuse'], 16)}"]
    result = sinew("hil", "step.yaml", "--emulate", "--out", "fuses", *set_so)
    check("fuses as docs/hardware.md sets them: it arms", result.returncode == 0, said(result))
    result = sinew("hil", "step.yaml", "--emulate", "--out", "o", "--fault", "fuse_high@0=217", "--fault", "fuse_extended@0=255")
    check("fuses of a new chip: not armed, which are wrong and where to read on, nothing written", result.returncode == 1 and
          "the board's fuses are wrong: brown-out detection is off, or not at 4.3 V; the watchdog is not always on\n" in result.stderr
          and "docs/hardware.md, Fuses" in result.stderr and files_in("o") is None, said(result))
    write("hot.yaml", STEP + "start: { temperature_A_degC: 80 }\n")
    result = sinew("hil", "hot.yaml", "--emulate", "--out", "o")
    check("a hot coil: not armed", result.returncode == 1 and "a coil is not cool yet" in result.stderr and files_in("o") is None, said(result))
    sinew("hil", "step.yaml", "--emulate", "--out", "kept")
    text = content("kept/recording.csv").decode()
    (cli.folder / "kept/recording.csv").write_text(text.replace("0.4", "0.3", 1))
    refused("replay of a session whose recording was touched", ["replay", "kept"], r"kept/recording\.csv\n  is not as the session wrote it|kept/recording\.csv: .*|is not as the session wrote it")


def test_trips():
    result = sinew("hil", "step.yaml", "--emulate", "--out", "open", "--fault", "sensor_open:A@4")
    report = session("open")
    check("a thermocouple breaks: exit code 1, the cause on standard error and in session.json", result.returncode == 1
          and "the device tripped: sensor_open" in result.stderr and report["status"] == "tripped" and report["brought_to_rest"], said(result))
    rows = columns("open/recording.csv")["time_s"]
    check("a thermocouple breaks: what was recorded until then is kept", 30 < len(rows) < 45, len(rows))
    check("a tripped session plays again", sinew("replay", "open").returncode == 0)
    result = sinew("hil", "step.yaml", "--emulate", "--out", "sag", "--fault", "supply_V@3=5", "--twin", cli.PAPER_LIMB)
    departures = session("sag").get("departures_from_twin", [])
    check("the supply sags: the session goes on, and says while it runs that the limb has left its twin, where and since when",
          result.returncode == 0 and "temperature_A has left the twin" in result.stderr and departures
          and departures[0]["channel"] == "temperature_A" and 2.5 < departures[0]["onset_s"] < 4.0, said(result))


def test_fault_rows():
    """Rows of the fault table: among them all that is known to go wrong in a first version."""
    for words, rows in (("with relay and dividers", 10), ("fuses:", 3), ("hangs while hot", 2), ("nothing goes through", 1), ("trips, then", 2), ("thermocouple open", 1),
                        ("a bit flipped", 2), ("1 tick late", 1)):
        result = sinew("hil-faults", "--out", "faults", "--only", words, "--quick", timeout=300)
        check(f"fault table, {words}: as due, in time, and not too hot",
              result.returncode == 0 and f"{rows} rows: 0 not as due, 0 late, 0 too hot" in result.stdout, said(result))


class Limb:
    """The emulator in real time on a pseudo-terminal with a name."""

    def __init__(self, name, *options):
        self.port = str(cli.folder / name)
        self.process = subprocess.Popen([str(Path(cli.program).parent / "sinew-emulator"), "mild.yaml", "--firmware",
                                         str(Path(cli.program).parent / "firmware.elf"), "--link", self.port, *options],
                                        cwd=cli.folder, stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()

    def __enter__(self):
        return self

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(20)

    def __exit__(self, *_):
        self.end()


class Wire:
    """A host written from docs/protocol.md alone."""

    def __init__(self, port, session):
        self.file = os.open(port, os.O_RDWR | os.O_NOCTTY)
        self.session, self.sequence, self.rest = session, 0, b""

    def close(self):
        os.close(self.file)

    @staticmethod
    def framed(kind, session, sequence, time_us, payload=b""):
        plain = struct.pack("<BBHII", 4, kind, session, sequence, time_us % 2**32) + payload
        plain += struct.pack("<I", zlib.crc32(plain))
        blocks = plain.split(b"\0")
        return b"\0" + b"".join(bytes([len(block) + 1]) + block for block in blocks) + b"\0"

    def send(self, kind, time_us, payload=b""):
        self.sequence += 1
        os.write(self.file, self.framed(kind, self.session, self.sequence, time_us, payload))

    def hear(self, kind, seconds=1.0):
        """The next frame of a kind: its time and payload; None if none comes."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if select.select([self.file], [], [], left)[0]:
                self.rest += os.read(self.file, 4096)
            *frames, self.rest = self.rest.split(b"\0")
            for i, frame in enumerate(frames):
                plain = b""
                while frame:
                    plain, frame = plain + frame[1 : frame[0]] + b"\0", frame[frame[0] :]
                plain = plain[:-1]
                if len(plain) < 16 or struct.unpack("<I", plain[-4:])[0] != zlib.crc32(plain[:-4]) or plain[1] != kind:
                    continue
                self.rest = b"\0".join([*frames[i + 1 :], self.rest])
                return struct.unpack("<I", plain[8:12])[0], plain[12:-4]
        return None

    def latest(self, kind):
        """The next one that comes from now on."""
        while select.select([self.file], [], [], 0)[0]:
            os.read(self.file, 65536)
        self.rest = b""
        return self.hear(kind)


class Board:
    """The board's program as a process of this machine, on a pseudo-terminal with a name."""

    def __init__(self, name, *options):
        self.port = str(cli.folder / name)
        self.process = subprocess.Popen([str(Path(cli.program).parent / "sinew-board"), "--link", self.port, *map(str, options)],
                                        stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(20)


def test_conform():
    """The page, asked of both boards: the chip in the emulator, and the same program on this machine."""
    write("mild.yaml", MILD)
    result = sinew("conform", "--emulate", "--coils-disconnected")
    check("conform: the chip in the emulator does what the page says", result.returncode == 0
          and re.search(r"^[5-9]\d as the page says, 0 not, 0 left out$", result.stdout, re.M), said(result))
    result = sinew("conform", "--emulate", "--port", "/dev/null")
    check("conform: port and emulator at once, exit code 2", result.returncode == 2 and "one of the two" in result.stderr, said(result))
    process = start("conform", "--emulate")
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=20)
    check("conform: Ctrl-C ends it soon, with the board disarmed, and leaves nothing in the folder of temporary files", process.returncode == 130
          and "the board says that it is disarmed" in errors and not list(Path(tempfile.gettempdir()).glob("sinew_conform_*")), out + errors)
    with Board("conform") as board:
        for attempt in range(3):  # a busy machine may be late by more than the page allows a board
            result = sinew("conform", "--port", board.port, "--clear-trip")
            if result.returncode == 0:
                break
        check("conform: the program on this machine does what the page says; too much duty is left out", result.returncode == 0
              and re.search(r"^[5-9]\d as the page says, 0 not, 1 left out$", result.stdout, re.M), said(result))
    with Board("conform") as board:
        result = sinew("conform", "--port", board.port, "--coils-disconnected")
        check("conform: with coils disconnected nothing is left out", re.search(r"too much duty, dropped whole\n.*0 left out$", result.stdout.strip(), re.S),
              said(result))
        result = sinew("hil", "mild.yaml", "--port", board.port, "--out", "on_board", "--allow-overruns")
        check("a session with the program on this machine", "41 samples, finished" in result.stdout or result.returncode == 1, said(result))
        check("... plays again", sinew("replay", "on_board").returncode == 0)
    with Board("stored", "--store", cli.folder / "eeprom"):
        pass
    with Board("stored", "--store", cli.folder / "eeprom") as board:
        result = sinew("conform", "--port", board.port)
        check("conform: a board that was never cleared is tripped, and arming is left out", result.returncode == 0
              and "the board is tripped: latch_damaged" in result.stdout and "arm: while tripped, answered with 3" in result.stdout, said(result))
        result = sinew("conform", "--port", board.port, "--clear-trip")
        check("conform: --clear-trip clears it by its name", "ok    clear_trip of its cause (latch_damaged)" in result.stdout, said(result))
    check("the program on this machine: its store is cleared for the next time", content("eeprom") == bytes([0x40, 0xbf]), content("eeprom"))
    result = sinew("conform", "--port", "/dev/null")
    check("conform: no port, exit code 2", result.returncode == 2 and "--port" in result.stderr, said(result))
    result = sinew("doctor", "--real-time", "1")
    check("doctor --real-time: both rates, with their shares", re.search(r" 10 Hz: [\d.]+ % of 10 commands", result.stdout)
          and re.search(r" 200 Hz: [\d.]+ % of 200 commands", result.stdout), said(result))
    process = start("doctor", "--real-time", "60")
    children, end = [], time.monotonic() + 20
    while not children and time.monotonic() < end:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        time.sleep(0.05)
    process.kill()
    process.communicate()
    lives = lambda: [child for child in children if Path(f"/proc/{child}/exe").exists()]
    while lives() and time.monotonic() < end:
        time.sleep(0.05)
    check("doctor --real-time: the board's program ends with it, also by kill -9", children and not lives(), children)


def start(*arguments):
    # Under `nohup ./check` the hang-up is ignored, and by every child that does not say otherwise.
    return subprocess.Popen([cli.program, *map(str, arguments)], cwd=cli.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))


def running(process, seconds):
    """Until it shows lines of a session, and some time more."""
    line = process.stderr.readline()
    time.sleep(seconds)
    return line


def test_page():
    """The session in a browser, and browsers that do not behave."""
    write("step.yaml", STEP)
    write("babble.yaml", BABBLE)
    sinew("hil", "babble.yaml", "--emulate", "--out", "unshown", "--twin", cli.PAPER_LIMB)
    port = page_client.free_port()
    process = start("hil", "babble.yaml", "--emulate", "--out", "shown", "--twin", cli.PAPER_LIMB, "--page", port)
    follower = page_client.Follower(port)
    at_work = [page_client.get(port, path, method, **headers) for method, path, headers in
               (("GET", "/other", {}), ("POST", "/", {}), ("GET", "/", {"Host": f"elsewhere.example:{port}"}))]
    out, errors = process.communicate(timeout=120)
    follower.join(20)
    check("--page: says where it is, the terminal stays", process.returncode == 0 and f"page: http://127.0.0.1:{port}/" in errors
          and re.search(r"^ +0\.0 s  A ", errors, re.M), errors)
    status, headers, page = follower.page or (0, {}, "")
    check("--page: a page that needs nothing but its events, with the plots of a report", status == 200
          and headers.get("Content-Type") == "text/html; charset=utf-8" and 'id="live" data-events="events"' in page and "Dygraph" in page
          and "connect-src 'self'" in page and page.count('class="plot time"') == 5, follower.wrong or status)
    begun, samples, ended = follower.of("begin"), follower.of("sample"), follower.of("end")
    check("--page: the session begins, ends, and has every sample between", begun == [{"name": "babble.yaml", "duration_s": 30.0}]
          and [one["t"] for one in samples] == [k / 10 for k in range(301)] and ended == ["The session has ended: finished"],
          (follower.wrong, begun, len(samples), ended))
    recording = columns("shown/recording.csv")
    temperatures, angles, duty = ([one["plots"][k] for one in samples] for k in range(3))
    check("--page: what is drawn is what is recorded", [one[:2] for one in temperatures] ==
          [list(pair) for pair in zip(recording["temperature_A_degC"], recording["temperature_B_degC"])]
          and [one[0] for one in angles] == recording["angle_deg"]
          and duty == [list(pair) for pair in zip(recording["duty_A"], recording["duty_B"])])
    check("--page: the twin's residual, small where the limb is its twin", all(len(one["plots"]) == 5 for one in samples)
          and 0 < max(abs(one["plots"][4][0]) for one in samples[1:]) < 3)
    same_bytes("a session with and without --page", "unshown", "shown", [*SESSION_FILES, "twin.yaml"])
    check("--page: another path, another method, another host (DNS rebinding) are refused", [one[0] for one in at_work] == [404, 405, 403], at_work)

    # Long enough that all of them come while it runs. Connected from the beginning: one that never reads, one that goes away, one
    # that never asks, one that talks nonsense.
    write("stare.yaml", BABBLE.replace("duration_s: 30", "duration_s: 200"))
    began = time.monotonic()
    sinew("hil", "stare.yaml", "--emulate", "--out", "alone", "--twin", cli.PAPER_LIMB)
    alone_s = time.monotonic() - began
    process = start("hil", "stare.yaml", "--emulate", "--out", "stared_at", "--twin", cli.PAPER_LIMB, "--page", port)
    began = time.monotonic()
    stalled = page_client.connected(port, buffer_bytes=4096)
    gone = page_client.connected(port)
    gone.recv(300)
    gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    gone.close()
    silent = socket.create_connection(("127.0.0.1", port))
    nonsense = socket.create_connection(("127.0.0.1", port))
    nonsense.sendall(b"\0\xff" * 20000)
    many = [socket.create_connection(("127.0.0.1", port)) for _ in range(40)]
    for one in many:
        one.close()
    follower = page_client.Follower(port)
    out, errors = process.communicate(timeout=120)
    took_s = time.monotonic() - began
    follower.join(20)
    for one in (stalled, silent, nonsense):
        one.close()
    check("browsers that stall, vanish, say nothing or nonsense, or come in crowds: the session ends as it would, and no later than a second",
          process.returncode == 0 and took_s < 2 * alone_s + 3, (errors, took_s, alone_s))
    check("... and one that reads gets all of it", len(follower.of("sample")) == 2001 and follower.of("end"), (follower.wrong, len(follower.events)))
    same_bytes("a session that is stared at", "alone", "stared_at", [*SESSION_FILES, "twin.yaml"])

    write("long.yaml", MILD.replace("duration_s: 4", "duration_s: 60"))
    with Board("paged") as board:
        process = start("hil", "long.yaml", "--port", board.port, "--out", "live", "--allow-overruns", "--clear-trip", "--page", port)
        page_client.get(port, "/")
        stalled = page_client.connected(port, buffer_bytes=4096)
        seen = page_client.events(port, until="sample")
        check("hil --port --page: events while the session runs in real time", [one[0] for one in seen][-1:] == ["sample"], seen)
        again = page_client.events(port, until="sample", last_id=seen[-1][2]) if seen else []
        check("... a browser that comes back goes on after what it has", [one[0] for one in again][-1:] == ["sample"]
              and again[-1][1]["t"] > seen[-1][1]["t"] and all(one[0] != "begin" for one in again), again)
        follower = page_client.Follower(port)
        end = time.monotonic() + 20
        while not follower.page and time.monotonic() < end:
            time.sleep(0.02)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=20)
        follower.join(20)
        stalled.close()
        check("... and is told how the session ended: at Ctrl-C, at rest, with its recording", process.returncode == 130
              and session("live")["brought_to_rest"] and follower.of("end") and "stopped" in follower.of("end")[0],
              (follower.wrong, follower.of("end"), errors))

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        its_port = taken.getsockname()[1]
        refused("--page at a port that is taken: before anything is armed, or opened",
                ["hil", "step.yaml", "--port", "/dev/serial/by-id/no", "--page", its_port, "--out", "o"], rf"--page = {its_port}\n  another program has this port")
        refused("the same in the emulator", ["hil", "step.yaml", "--emulate", "--page", its_port, "--out", "o"], rf"--page = {its_port}\n")
    for wrong in ("80", "65536", "eight", ""):
        refused(f"--page {wrong or 'nothing'}", ["hil", "step.yaml", "--emulate", "--page", wrong, "--out", "o"], r"--page")
    result = sinew("hil", "step.yaml", "--emulate", "--page", port, "--out", "tripped_page", "--fault", "sensor_open:A@4")
    check("--page: a session that trips ends as it would without", result.returncode == 1 and "sensor_open" in result.stderr, said(result))


def test_wire():
    write("mild.yaml", MILD)
    check("wire: the frame of the page", Wire.framed(3, 0x0102, 5, 0x01000000).hex(" ")
          == "00 06 04 03 02 01 05 01 01 01 01 01 06 01 9d 61 58 cd 00")
    hello_request, arm, disarm, hello, answer, telemetry = 1, 2, 3, 0x81, 0x82, 0x83
    with Limb("wire") as limb:
        wire = Wire(limb.port, 0x4711)
        for _ in range(20):  # until the board is awake
            wire.send(hello_request, 0, bytes([20]))
            if heard := wire.hear(hello, 0.5):
                break
        if not check("wire: the board says hello", heard is not None and len(heard[1]) == 15 and heard[1][11:] == bytes([2, 2, 1, 0]), heard):
            return
        hashes = heard[1][:8] + b"\x01"
        stale_count = lambda payload: struct.unpack("<13H", payload[-26:])[7]
        time_us, before = wire.latest(telemetry)
        wire.send(arm, time_us - 400_000, hashes)
        check("wire: an arm frame that lay on its way for 0.4 s has no answer", wire.hear(answer, 0.3) is None)
        _, after = wire.latest(telemetry)
        check("wire: ... is counted as stale, and the board stays disarmed", stale_count(after) == stale_count(before) + 1 and after[4] == 0, after)

        def answered(kind, payload=b""):  # on a busy machine an arm frame may come too late, which has no answer
            for _ in range(5):
                wire.send(kind, wire.latest(telemetry)[0], payload)
                if heard := wire.hear(answer, 0.5):
                    return heard[1][:2]

        check("wire: an arm frame for another firmware is refused", answered(arm, bytes(4) + hashes[4:]) == bytes([arm, 1]))
        check("wire: a fresh one arms", answered(arm, hashes) == bytes([arm, 0]) and wire.hear(telemetry)[1][4] == 1)
        check("wire: and disarm disarms", answered(disarm) == bytes([disarm, 0]) and wire.hear(telemetry)[1][4] != 1)
        wire.close()


def test_real_time():
    write("mild.yaml", MILD)
    write("long.yaml", MILD.replace("duration_s: 4", "duration_s: 60"))
    with Limb("board") as limb:
        result = sinew("doctor", "--port", limb.port)
        check("doctor: a board that is well", result.returncode == 0 and "FAIL" not in result.stdout and "thermocouple B: 2" in result.stdout,
              said(result))
        # A busy machine may be late by more than the dead-man allows, which then does what it must: so it has three tries.
        for attempt in range(3):
            result = sinew("hil", "mild.yaml", "--port", limb.port, "--out", f"real{attempt}", "--allow-overruns",
                           *(["--clear-trip"] if attempt else []))
            if result.returncode == 0:
                break
        check("hil --port: a session in real time", result.returncode == 0 and "41 samples, finished" in result.stdout, said(result))
        check("hil --port: a line a second, where there is no terminal", 4 <= len(re.findall(r"^ +\d+\.0 s  A ", result.stderr, re.M)) <= 6, said(result))
        check("a session in real time plays again", sinew("replay", f"real{attempt}").returncode == 0)
        refused("hil into a folder with a session", ["hil", "mild.yaml", "--port", limb.port, "--out", f"real{attempt}"], r"a session is there already")

        first = start("hil", "long.yaml", "--port", limb.port, "--out", "first", "--allow-overruns")
        running(first, 1.0)
        refused("a second opener", ["hil", "mild.yaml", "--port", limb.port, "--out", "second"], r"in use")
        first.send_signal(signal.SIGINT)
        out, errors = first.communicate(timeout=20)
        check("Ctrl-C: exit code 130, at rest, the recording is written", first.returncode == 130 and session("first")["brought_to_rest"]
              and session("first")["status"] == "stopped", errors)
        result = sinew("replay", "first")
        check("a session that Ctrl-C stopped plays again", result.returncode == 0, said(result))
        result = sinew("hil", "mild.yaml", "--port", limb.port, "--out", "after_stop", "--allow-overruns")
        check("after Ctrl-C: the device is disarmed, not tripped", "not armed" not in result.stderr, said(result))

        process = start("hil", "long.yaml", "--port", limb.port, "--out", "hung_up", "--allow-overruns")
        running(process, 1.0)
        process.send_signal(signal.SIGHUP)
        out, errors = process.communicate(timeout=20)
        check("the terminal is closed: brought to rest, the recording is written", process.returncode == 130 and session("hung_up")["brought_to_rest"]
              and session("hung_up")["status"] == "stopped", errors)
        check("a session that was hung up plays again", sinew("replay", "hung_up").returncode == 0)
        for attempt in range(3):
            process = start("hil", "mild.yaml", "--port", limb.port, "--out", f"unread{attempt}", "--allow-overruns", "--clear-trip")
            running(process, 1.0)
            process.stdout.close()
            process.stderr.close()
            if process.wait(timeout=20) == 0:
                break
        check("whoever reads along goes away: the session goes on to its end", process.returncode == 0
              and session(f"unread{attempt}")["status"] == "finished" and len(columns(f"unread{attempt}/recording.csv")["time_s"]) == 41)

        for what, number in (("kill -9", signal.SIGKILL), ("a host that is stopped", signal.SIGSTOP)):
            process = start("hil", "long.yaml", "--port", limb.port, "--out", "killed", "--allow-overruns", "--clear-trip")
            line = running(process, 1.0)
            process.send_signal(number)
            time.sleep(0.6)
            process.kill()
            rest = process.communicate()[1]
            result = sinew("hil", "mild.yaml", "--port", limb.port, "--out", "no", "--allow-overruns")
            check(f"{what}: the device went to zero by itself, and does not arm again unasked",
                  result.returncode == 1 and "the device is tripped: silence" in result.stderr and files_in("no") is None, line + rest + said(result))
            check(f"{what}: nothing half-written", files_in("killed") == [".sinew.lock"])
        result = sinew("doctor", "--port", limb.port)
        check("doctor: says that it is tripped, and why", result.returncode == 1 and "tripped: silence" in result.stdout, said(result))

        process = start("hil", "long.yaml", "--port", limb.port, "--out", "pulled", "--allow-overruns", "--clear-trip")
        running(process, 1.0)
        limb.end()
        out, errors = process.communicate(timeout=20)
        check("the cable is pulled: exit code 1, link lost, the recording until then is kept", process.returncode == 1
              and session("pulled")["status"] == "link_lost" and len(columns("pulled/recording.csv")["time_s"]) > 5, errors)
    # The kernel gives the port another name; the link under which it is opened is the same.
    with Limb("board") as limb:
        result = sinew("hil", "mild.yaml", "--port", limb.port, "--out", "back", "--allow-overruns")
        check("the port comes back under another name: a new session", "no such port" not in result.stderr and result.returncode in (0, 1)
              and session("back")["ticks"] > 5, said(result))


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_hil", (test_lock_step, test_refusals, test_page, test_trips, test_fault_rows, test_wire, test_conform,
                                        test_real_time)))
