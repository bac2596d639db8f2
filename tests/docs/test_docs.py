#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Links of every page, the site, and the commands of README.md and docs/: those of a page run one after the other in a folder of its own,
with the repository's plants and scenarios, what of the repository they name, and `sinew` on the path. Which are shortened, and which are
run by another test or by hand, and why, is below; a line there that no command needs is an error.

    python3 tests/docs/test_docs.py build/release/sinew
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
from test_cli import LOGGER_HEADER, logger_row  # noqa: E402

program = Path(sys.argv[1]).resolve()
counts = {True: 0, False: 0}


def check(what, holds, detail=""):
    counts[bool(holds)] += 1
    print(("ok      " if holds else "FAILED  ") + what, flush=True)
    if not holds and detail:
        print("        " + str(detail).strip()[-3000:].replace("\n", "\n        "), flush=True)
    return bool(holds)


def without_code(text):
    return re.sub(r"`[^`\n]*`", "``", re.sub(r"^```.*?^```|^(?: {4}[^\n]*\n)+", "", text, flags=re.S | re.M))


def anchors(text):
    found = set()
    for heading in re.findall(r"^#+ +(.+?)\s*$", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M), re.M):
        plain = re.sub(r"[`*]|\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.add(re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain)))
    return found


pages = {name: (ROOT / name).read_text() for name in
         subprocess.run(["git", "-C", ROOT, "ls-files", "*.md"], capture_output=True, text=True).stdout.split()}
links = 0
for name, text in pages.items():
    dead = []
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(text)):
        if re.match(r"\w+:", target):
            continue
        links += 1
        path, _, anchor = target.partition("#")
        file = ((ROOT / name).parent / path).resolve() if path else ROOT / name
        if not file.exists():
            dead.append(target)
        elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text()):
            dead.append(f"{target} (no such heading)")
    check(f"{name}: no dead link", not dead, dead)
check("there are links", links > 50, links)

PROGRAMS = (r"sinew|sinew-board|avrdude|cp|PYTHONPATH=\S+|\$|sudo|cmake|podman|debootstrap|tar|python3|/usr/bin/python3|"
            r"(?:\./|build/|tools/)\S+")
SHORTER = {  # what a command says, what is run in its place
    "--runs 64": "--runs 2",
    "--case 4 --predictor stateful": "--case 4 --predictor stateful --updates 20",
}
ELSEWHERE = {  # part of a command: the test that runs such a one, or why none does
    "./demo": "Containerfile",
    "./check": ".ci/run",
    "prove --few": "tests/prove/few.py",
    "prove --seeds 5": "by hand: five hours",
    "paper-table": "tests/cli/test_predict.py",
    "hil-faults": "tests/cli/test_hil.py",
    "--emulate": "tests/cli/test_hil.py",
    "--port": "tests/cli/test_hil.py",
    "sinew-board": "tests/cli/test_hil.py",
    "investigate --plant": "tests/cli/test_investigate.py",
    "--target package": "tests/package/test_package.py",
    "sudo apt install": "tests/package/test_package.py",
    "podman": "by hand: needs podman and a network",
    "debootstrap": "by hand: needs a network",
    "bare": "by hand: needs a network",
    "avrdude": "by hand: needs a board",
    "cp -r /usr/share": "tests/package/test_package.py",
    "PYTHONPATH=": "tests/python/test_docs.py",
    "$ sinew run": "tests/cli/test_cli.py",
    "--target sinew_firmware": "check",
    "calibrate r1.csv": "by hand: a quarter of an hour, and recordings that are not in the repository",
}
PAGES_ELSEWHERE = {
    "docs/your_own_recording.md": "tests/cli/test_own_recording.py",
    "docs/adding_an_effect.md": "by hand: it changes the program, and has no effect then",
    "docs/adding_a_system.md": "tests/package/test_package.py",
}


def commands_of(text):
    """Those of a page's blocks that begin with a program, fenced as `sh` or indented; a block of another language has none."""
    blocks, language = [[]], None
    for line in text.splitlines():
        if line.startswith("```"):
            language = line[3:] or "text" if language is None else None
            blocks.append([])
        elif language == "sh" or language is None and line.startswith("    "):
            blocks[-1].append(line if language else line[4:])
        else:
            blocks.append([])
    for block in blocks:
        if block and block[0].startswith("$"):  # with what it prints
            yield from (line for line in block if line.startswith("$"))
        elif block and re.match(rf"(?:{PROGRAMS}) ", block[0] + " "):
            yield from re.sub(r"\\\n *", "", "\n".join(block)).splitlines()


def one_key(table, command):
    found = [key for key in table if key in command]
    used.update(found)
    return found[0] if found else None


def make_files(folder):
    """What commands speak of as the reader's own."""
    scenario = (ROOT / "scenarios/babble_bidirectional.yaml").read_text()
    for name, seed, seconds in (("a", 1, 60), ("b", 2, 60), ("c", 3, 660)):
        (folder / "made").mkdir(exist_ok=True)
        (folder / "made" / f"{name}.yaml").write_text(re.sub(r"duration_s: \S+", f"duration_s: {seconds}", scenario))
        subprocess.run([program, "run", folder / "made" / f"{name}.yaml", "--seed", str(seed), "--out", folder / "made" / name], check=True,
                       capture_output=True)
        shutil.copy(folder / "made" / name / "recording.csv", folder / f"{name}.csv")
    rows = [",".join(map(str, logger_row(k, 35_000_000 + 100 * k))) for k in range(60)]
    (folder / "LOGGER.txt").write_text("\n".join(["CV Data Logger", "anything", LOGGER_HEADER, *rows, ""]))
    for name in "LOGGER.csv", "robot.csv":
        shutil.copy(ROOT / "tests/logs/ros.csv", folder / name)
    log = re.search(r"`ros\.map\.yaml`:\n\n```yaml\n(.*?)^```", pages["docs/your_own_recording.md"], re.S | re.M)[1]
    (folder / "MAP.yaml").write_text(log)


def bring(folder, command):
    """What of the repository's results a command reads and nothing before it made."""
    for path in re.findall(r"(?<!--out )\bresults/[\w./]+", command):
        here, there = folder / path, ROOT / path
        if there.exists() and not here.exists():
            here.parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if there.is_dir() else shutil.copy)(there, here)


used, ran_here, ran_elsewhere = set(), 0, 0
for name, text in pages.items():
    commands = list(commands_of(text)) if name == "README.md" or name.startswith("docs/") else []
    if name in PAGES_ELSEWHERE:
        check(f"{name}: has commands, that another test runs", commands)
        used.add(name)
        ran_elsewhere += len(commands)
        continue
    if not commands:
        continue
    with tempfile.TemporaryDirectory(prefix="sinew_docs_") as outer:
        folder = Path(outer) / "here"
        (folder / "bin").mkdir(parents=True)
        (folder / "bin/sinew").symlink_to(program)
        for shared in ("plant", "scenarios"):
            (folder / shared).symlink_to(ROOT / shared)
        data = ROOT / "../shared"
        if data.exists():
            (Path(outer) / "shared").symlink_to(data.resolve())
        make_files(folder)
        for command in commands:
            if one_key(ELSEWHERE, command):
                ran_elsewhere += 1
                continue
            emps = data / "data/emps/DATA_EMPS.mat"
            if "DATA_EMPS" in command and emps.exists():
                shutil.copy(emps, folder)
            needs_data = any(word in command for word in ("shared/data", "r1.csv", "DATA_EMPS"))
            if needs_data and not data.exists():
                print(f"SKIPPED: {name}: {command.split('#')[0].strip()}, without ../shared/data")
                continue
            shorter = one_key(SHORTER, command)
            bring(folder, command)
            ran = subprocess.run(["bash", "-e", "-u", "-c", command.replace(shorter, SHORTER[shorter]) if shorter else command], cwd=folder,
                                 capture_output=True, text=True, env={**os.environ, "PATH": f"{folder}/bin:{os.environ['PATH']}"})
            ran_here += 1
            check(f"{name}: {command.split('#')[0].strip()}", ran.returncode == 0, ran.stdout + ran.stderr)
unused = {*SHORTER, *ELSEWHERE, *PAGES_ELSEWHERE} - used
check("no line of the tables above is for nothing", not unused, unused)
owners = {*ELSEWHERE.values(), *PAGES_ELSEWHERE.values()}
check("who runs what is not run here exists", all(who.startswith("by hand: ") or (ROOT / who).exists() for who in owners), owners)
check("commands were run", ran_here >= 25, ran_here)
print(f"commands of README.md and docs/: {ran_here} run here, {ran_elsewhere} by other tests or by hand")

# docs/thresholds.md: each number stands in the file that it names, and every number of the settings' structs has a row.
rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \| `([^`]+)` \|", (ROOT / "docs/thresholds.md").read_text(), re.M)
check("docs/thresholds.md has rows", len(rows) > 50, rows)
for number, value, file in rows:
    stands = re.compile(rf"\b{number}(?: = |{{){re.escape(value)}\b" if "," not in value else rf"\b{number}{{{re.escape(value)}}}")
    check(f"docs/thresholds.md: {number} = {value} in {file}", stands.search((ROOT / file).read_text()))
for struct, file in {"Thresholds": "decide", "SearchSettings": "search", "WanderSettings": "wander", "ProposalSettings": "proposals",
                     "ExplanationSettings": "explanation"}.items():
    file = f"diagnose/{file}.h"
    body = re.search(rf"^struct {struct} {{\n(.*?)^}};", (ROOT / file).read_text(), re.M | re.S)[1]
    members = re.findall(r"(\w+) = [-\d.e]+[,;]", body)
    missing = [m for m in members if m not in ("seed", "threads") and not any((n, f) == (m, file) for n, _, f in rows)]
    check(f"docs/thresholds.md has every number of {struct}", members and not missing, missing)

fitted = subprocess.run(["/usr/bin/python3", ROOT / "tools/fit_confidence"], capture_output=True, text=True)
weights = re.search(r"^weights(\{.*\})$", fitted.stdout, re.M)
check("tools/fit_confidence prints the weights that the program has",
      weights and f"weights{weights[1]};" in (ROOT / "diagnose/confidence.cpp").read_text(), fitted.stdout + fitted.stderr)
cases = re.match(r"(\d+) cases, (\d+) finds, (\d+) right", fitted.stdout)
check("and the cases that docs/diagnosis.md tells of",
      cases and re.search(rf"to {cases[1]} concealed cases.*?{cases[2]}\s+finds, {cases[3]}\s+of\s+them\s+right",
                          pages["docs/diagnosis.md"], re.S))
# Figures of pages that a tool prints from what is in the repository.
for tool, data, name in [("tools/gains_by_weighting", "results/proof_fresh", "results/proof/discussion.md")]:
    ran = subprocess.run([ROOT / tool, ROOT / data], capture_output=True, text=True)
    rows = [line for line in ran.stdout.splitlines() if line.startswith("|")]
    said = " ".join((ROOT / name).read_text().split())
    last = ran.stdout.strip().splitlines()[-1] if ran.stdout.strip() else ran.stderr
    check(f"{name}: has the table that `{tool} {data}` prints", ran.returncode == 0 and len(rows) == 5
          and all(" ".join(row.split()) in said for row in rows), ran.stdout + ran.stderr)
    check(f"{name}: has its last line, too", last in said, last)

if os.path.exists("/usr/bin/mkdocs"):
    with tempfile.TemporaryDirectory(prefix="sinew_site_") as folder:
        built = subprocess.run([ROOT / "tools/make_site", program, Path(folder) / "site"], capture_output=True, text=True)
        check("tools/make_site builds the site", built.returncode == 0, built.stdout + built.stderr)
        page = Path(folder) / "site/docs/commands.html"
        check("and the help of every command is on it", page.is_file() and "sinew diagnose" in page.read_text())
else:
    print("SKIPPED: the site, without mkdocs")
print(f"{counts[True]} passed, {counts[False]} failed")
sys.exit(1 if counts[False] else 0)
