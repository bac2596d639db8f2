#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs `sinew convert` with maps as a person would. See test_cli.py. Looks for recordings in ../shared/data, and says SKIPPED without.

    python3 tests/cli/test_convert.py build/release/sinew
"""
import math
import re
import shutil
import struct
import subprocess
import sys
import zlib

import test_cli as cli
from test_cli import ROOT, check, columns, refused, said, sinew, write

DATA = ROOT.parent / "shared/data"
MAPS = sorted((ROOT / "plant").glob("*/*.map.yaml"))

LOG = """rig 3, warm-up
clock;pwm;thermo;tag_x_1;tag_y_1;tag_x_2;tag_y_2
10:30:00,0;0;20,0;0;0;10;0
10:30:00,5;51;20,0;1;1;11;1
state: heating
10:30:01,0;255;21,5;1;1;1;11
10:30:01,5;255;21,5;1;1;1;11
"""
MAP = """# The rig's logger.
format: 1
file: {lines_before_header: 1, delimiter: semicolon, decimal: comma, text_lines: ["state: *"]}
time: {column: clock, unit: clock}
points:
  base: {x: tag_x_1, y: tag_y_1, missing: 0}
  tip: {x: tag_x_2, y: tag_y_2}
columns:
  duty_A: {column: pwm, unit: counts_255}
  duty_B: {constant: 0}
  temperature_A_degC: {column: thermo, repeats: missing}
  angle_deg: {direction: {from: base, to: tip}, zero: first_row}
"""


def text_of(name):
    return (cli.folder / name).read_text()


def test_map():
    write("rig.csv", LOG)
    write("rig.map.yaml", MAP)
    result = sinew("convert", "rig.csv", "out.csv", "--map", "rig.map.yaml")
    check("--map: writes what the map says", result.returncode == 0 and text_of("out.csv") ==
          "# rig 3, warm-up\ntime_s,duty_A,duty_B,temperature_A_degC,angle_deg\n"
          "0,0,0,20,\n0.5,0.2,0,,0\n1,1,0,21.5,90\n1.5,1,0,,90\n", said(result) + str((cli.folder / "out.csv").exists()))
    check("--map: says what it did, and counts what it left out", result.stdout ==
          "4 samples over 1.5 s, one every 0.5 s in the median\n"
          "1 line of text between the rows, passed over (line 5)\n"
          "temperature_A_degC: 2 rows repeat the last reading, of 4; each reading is counted once (first on line 4)\n"
          "angle_deg: its zero is 0, of the first row that has it (line 4)\n"
          "angle_deg: 1 missing sample, left missing (line 3)\nwritten: out.csv\n", said(result))
    first = text_of("out.csv")
    sinew("convert", "rig.csv", "again.csv", "--map", "rig.map.yaml")
    check("--map: the same bytes again", text_of("again.csv") == first)
    write("twice.map.yaml", MAP + "  temperature_B_degC: {column: thermo, unit: degC}\n")
    result = sinew("convert", "rig.csv", "twice.csv", "--map", "twice.map.yaml")
    check("--map: says which of the log's columns is read twice",
          "temperature_A_degC, temperature_B_degC: all from the column thermo; is it so?\n" in result.stdout, said(result))


def test_wrong_input():
    write("rig.csv", LOG)

    def wrong(what, change, pattern, log="rig.csv"):
        text = MAP
        for old, new in change.items():
            assert old in text, old
            text = text.replace(old, new)
        write("wrong.map.yaml", text)
        refused(what, ["convert", log, "never.csv", "--map", "wrong.map.yaml"], pattern)

    wrong("a misspelled column", {"column: thermo": "column: termo"},
          r"^wrong\.map\.yaml:11:32: columns\.temperature_A_degC\.column = termo\n.*rig\.csv:2; did you mean thermo\?\n")
    wrong("a misspelled key", {"delimiter": "delimeter"}, r"^wrong\.map\.yaml:3:32: file\.delimeter\n.*did you mean delimiter\?")
    wrong("counts that are taken for a duty", {", unit: counts_255": ""}, r"^rig\.csv:4:12: pwm = 51\n(.*\n)+.*wrong\.map\.yaml:9:3: columns\.duty_A")
    wrong("a line of text that the map does not name", {"state: *": "status*"}, r"^rig\.csv:5: fields in this row = 1\n")
    wrong("a clock that is taken for seconds", {"unit: clock": "unit: s"},
          r"^rig\.csv:3:1: clock = 10:30:00,0\n  must be a number(.*\n)+.*wrong\.map\.yaml:4:16: time\.column")
    write("other.csv", "a,b\n0,1\n1,2\n")
    wrong("a map that matches nothing", {"lines_before_header: 1, delimiter: semicolon, decimal: comma, text_lines: [\"state: *\"]": "lines_before_header: 0"},
          r"^wrong\.map\.yaml:4:16: time\.column = clock\n(.*\n)+.*matches nothing in this file", log="other.csv")
    wrong("a file that is not there", {}, r"^nowhere\.csv: cannot read", log="nowhere.csv")
    write("rig.map.yaml", MAP)
    refused("a map that is not there", ["convert", "rig.csv", "never.csv", "--map", "nowhere.yaml"], r"^nowhere\.yaml: cannot read")
    refused("a log that would be written over", ["convert", "rig.csv", "rig.csv", "--map", "rig.map.yaml"], r"^rig\.csv\n.*is the file that is read")
    refused("a recording in a format that is not written", ["convert", "rig.csv", "never.xlsx", "--map", "rig.map.yaml"],
            r"^never\.xlsx: \.xlsx\n  is no format that is written: \.csv")
    refused("--map with --swap-sides", ["convert", "rig.csv", "never.csv", "--map", "rig.map.yaml", "--swap-sides"], r"^--swap-sides")
    refused("convert without files", ["convert"], r"^sinew convert LOG RECORDING\n.*needs both")
    refused("--suggest with files", ["convert", "rig.csv", "never.csv", "--suggest", "rig.csv"], r"^--suggest FILE\n.*stands alone")
    refused("--suggest of a file without numbers", ["convert", "--suggest", write("letter.txt", "dear reader\n")], r"^letter\.txt: no rows of numbers")
    (cli.folder / "damaged.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    refused("a damaged .mat", ["convert", "damaged.mat", "never.csv", "--map", "rig.map.yaml"], r"^damaged\.mat\n")
    refused("a .mat without a map", ["convert", "damaged.mat", "never.csv"], r"^damaged\.mat\n.*needs --map MAP\.yaml")
    write("whole.csv", "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n"
          + "".join(f"{k / 10},0,0,{25 + k % 7},{25 + k % 5},{k % 11}\n" for k in range(200)))
    sinew("convert", "whole.csv", "whole.mat")
    whole = (cli.folder / "whole.mat").read_bytes()
    packed = compressed_mat(whole)
    flipped = bytearray(packed)
    flipped[-40] ^= 0x55
    for name, content in (("cut.mat", whole[:-500]), ("cut_in_a_tag.mat", whole[:132]), ("packed_cut.mat", packed[:-30]),
                          ("packed_flipped.mat", bytes(flipped))):
        (cli.folder / name).write_bytes(content)
        write("mat.map.yaml", "format: 1\ntime: {column: time_s, unit: s}\ncolumns:\n  angle_deg: {column: angle_deg}\n")
        refused(f"a damaged .mat: {name}", ["convert", name, "never.csv", "--map", "mat.map.yaml"], rf"^{name}\n.*a variable in it is not whole")
    (cli.folder / "packed.mat").write_bytes(packed)
    result = sinew("convert", "packed.mat", "unpacked.csv", "--map", "mat.map.yaml")
    check("a compressed .mat is read", result.returncode == 0, said(result))


def compressed_mat(whole):
    """The same MATLAB file of version 5, each variable compressed."""
    packed, at = whole[:128], 128
    while at < len(whole):
        length = 8 + struct.unpack_from("<I", whole, at + 4)[0]
        variable = zlib.compress(whole[at:at + length])
        packed += struct.pack("<II", 15, len(variable)) + variable
        at += length
    return packed


def test_suggest():
    write("plain.csv", "millis,duty_A,T1,angle\n" + "".join(f"{100 * k},{0.5 * (k % 2)},{20 + k},{-3 * k}\n" for k in range(30)))
    result = sinew("convert", "--suggest", "plain.csv")
    check("--suggest: prints a map", result.returncode == 0 and "format: 1\n" in result.stdout and "looks like a duty" in result.stdout
          and "looks like a temperature" in result.stdout and "looks like an angle" in result.stdout, said(result))
    check("--suggest: a duty of 0 and 1 is no count", "percent" not in result.stdout, said(result))
    write("hundred.csv", "t,pwm,T1\n" + "".join(f"{k},{100 * (k % 2)},{20 + k}\n" for k in range(30)))
    result = sinew("convert", "--suggest", "hundred.csv")
    check("--suggest: what ends at 100 may be counts or percent", "or percent: then unit: percent" in result.stdout, said(result))
    write("plain.map.yaml", sinew("convert", "--suggest", "plain.csv").stdout)
    result = sinew("convert", "plain.csv", "plain_out.csv", "--map", "plain.map.yaml")
    check("--suggest: its map converts the file", result.returncode == 0
          and list(columns("plain_out.csv")) == ["time_s", "duty_A", "temperature_T1_degC", "angle_deg"], said(result))


def test_data_at_hand():
    if not DATA.is_dir():
        print(f"SKIPPED: maps on recordings: no {DATA}")
        return
    logs = {"lab_two_limbs_2023": "lab_two_limbs_2023/2023-4-5_103831.csv", "two_axis_limb": "two_axis_limb/data_random_walk_stiff_1.csv",
            "emps": "emps/DATA_EMPS.mat", "tanks": "cascaded_tanks/estimation.csv", "silverbox": "silverbox/multisine.csv"}
    logs |= {f"two_axis_limb_calibration_{coil}": f"two_axis_limb/calibration_{coil}.csv" for coil in ("px", "nx", "py", "ny")}
    names = {path.name.removesuffix(".map.yaml") for path in MAPS}
    check("every map that ships is tried", names == set(logs) | {"paper_limb"}, names)
    for path in MAPS:
        name = path.name.removesuffix(".map.yaml")
        if name not in logs:
            continue  # no file of that logger is at hand; tests/sim/log_map_test.cpp has one by hand
        result = sinew("convert", DATA / logs[name], f"{name}.csv", "--map", path)
        check(f"{name}: converts", result.returncode == 0, said(result))
        table = columns(f"{name}.csv")
        times = table["time_s"]
        check(f"{name}: time begins at 0 and increases", times[0] == 0 and all(a < b for a, b in zip(times, times[1:])))
        check(f"{name}: duties are within [0, 1] and never missing",
              all(0 <= v <= 1 for column, values in table.items() if column.startswith("duty") for v in values))
    lab = columns("lab_two_limbs_2023.csv")
    check("lab_two_limbs_2023: the coil that is driven warms, and its limb bends forward",
          max(v for v in lab["temperature_limb0_forward_degC"] if v == v) == 71.63
          and max(v for v in lab["temperature_limb0_reverse_degC"] if v == v) < 23
          and 20 < max(v for v in lab["angle_limb0_deg"] if v == v) < 25)
    check("lab_two_limbs_2023: one reading in 0.5 s", 0.35 < sum(v == v for v in lab["temperature_limb0_forward_degC"]) / len(lab["time_s"]) < 0.45)
    check("no column is empty", all(not all(math.isnan(v) for v in values) for values in lab.values()))
    for name, log in logs.items():
        result = sinew("convert", "--suggest", DATA / log)
        write(f"{name}.suggested.yaml", result.stdout)
        again = sinew("convert", DATA / log, f"{name}_suggested.csv", "--map", f"{name}.suggested.yaml")
        check(f"{name}: the suggested map converts", result.returncode == 0 and again.returncode == 0, said(again))


def test_formats():
    """Recordings as MATLAB and HDF5 files, read back by other libraries."""
    header, rows = None, []
    for line in (ROOT / "scenarios/demo/recording.csv").read_text().splitlines():
        if not line.startswith("#"):
            fields = line.split(",")
            if header is None:
                header = fields
            else:
                rows.append([float(field) if field else math.nan for field in fields])
    wanted = dict(zip(header, zip(*rows)))
    check("the demo's recording has samples that are missing", any(math.isnan(value) for values in wanted.values() for value in values))

    def same(found):
        return sorted(found) == sorted(wanted) and all(
            len(found[name]) == len(wanted[name]) and all(a == b or math.isnan(a) and math.isnan(b) for a, b in zip(found[name], wanted[name]))
            for name in wanted)

    for name in ("a.mat", "a.h5"):
        result = sinew("convert", ROOT / "scenarios/demo/recording.csv", name)
        check(f"a recording is written as {name}", result.returncode == 0 and f"written: {name}" in result.stdout, said(result))
        before = cli.content(name)
        refused(f"{name} is there already", ["convert", ROOT / "scenarios/demo/recording.csv", name], "is there already")
        sinew("convert", ROOT / "scenarios/demo/recording.csv", name, "--overwrite")
        check(f"{name}: the same recording gives the same bytes", cli.content(name) == before)
        # By matio and by the HDF5 library, which read the files of loggers.
        map_text = "format: 1\ntime: {column: time_s, unit: s}\ncolumns:\n" + "".join(f"  {c}: {{column: {c}}}\n" for c in header[1:])
        result = sinew("convert", name, "back.csv", "--map", write("back.map.yaml", map_text), "--overwrite")
        check(f"{name}: a map reads it", result.returncode == 0, said(result))
        if result.returncode == 0:
            check(f"{name}: and every number is there", same(columns("back.csv")))
    try:
        import h5py

        with h5py.File(cli.folder / "a.h5") as file:
            check("a.h5: h5py reads every number", same({key: file[key][:].tolist() for key in file}))
    except ImportError:
        print("SKIPPED: HDF5 files in h5py, which is not installed (python3-h5py)")
    script = "s = load('a.mat'); n = fieldnames(s); for k = 1:numel(n), printf('%s', n{k}); printf(' %.17g', s.(n{k})); printf('\\n'); end"
    if shutil.which("octave-cli"):
        told = subprocess.run(["octave-cli", "--eval", script], cwd=cli.folder, capture_output=True, text=True).stdout
        lines = [line.split() for line in told.splitlines()]
        check("a.mat: Octave reads every number", same({line[0]: [float(x) for x in line[1:]] for line in lines}))
    else:
        try:
            import scipy.io

            found = scipy.io.loadmat(cli.folder / "a.mat")
            check("a.mat: SciPy reads every number", same({key: found[key].ravel().tolist() for key in found if not key.startswith("__")}))
        except ImportError:
            print("SKIPPED: MATLAB files in Octave or SciPy, neither of which is installed")
    sinew("run", ROOT / "scenarios/step.yaml", "--out", "step")
    result = sinew("convert", "step/truth.csv", "truth.mat")
    check("truth.csv is written as truth.mat", result.returncode == 0, said(result))
    write("twice.csv", "time_s,a.b,a_b\n0,1,2\n1,3,4\n")
    refused("two columns of one name in MATLAB", ["convert", "twice.csv", "twice.mat"], r"a_b.*\n.*as another column is")
    write("word.csv", "time_s,a\n0,1\n1,one\n")
    refused("a word among numbers", ["convert", "word.csv", "word.h5"], r"word.csv:3:3.*one")


def test_reference():
    """The examples of docs/convert.md are maps that the program reads."""
    page = (ROOT / "docs/convert.md").read_text()
    maps = [block for block in re.findall(r"```yaml\n(.*?)```", page, re.S) if "format: 1" in block]
    check("docs/convert.md: has examples", len(maps) >= 3, len(maps))
    for number, text in enumerate(maps, 1):
        write("example.yaml", text)
        result = sinew("convert", write("empty.csv", "nothing here\n"), "never.csv", "--map", "example.yaml")
        check(f"docs/convert.md: example {number} is a map", "example.yaml" not in result.stderr.split("\n")[0] or "no such column in empty.csv" in result.stderr
              or "there are" in result.stderr, said(result))


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_convert", (test_map, test_wrong_input, test_suggest, test_data_at_hand, test_formats, test_reference)))
