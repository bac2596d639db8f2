#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Links of every page, the site, and the blocks of every page that are marked as tests by a line <!-- test --> above them: those of a page
run one after the other, in a folder with the repository's plants, scenarios and results, and `sinew` on the path.

    python3 tests/docs/test_docs.py build/release/sinew
"""
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
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

blocks = 0
for name, text in pages.items():
    tests = re.findall(r"^<!-- test -->\n```sh\n(.*?)^```", text, re.S | re.M)
    if not tests:
        continue
    with tempfile.TemporaryDirectory(prefix="sinew_docs_") as folder:
        for shared in ("plant", "scenarios", "results", "docs"):
            (Path(folder) / shared).symlink_to(ROOT / shared)
        (Path(folder) / "bin").mkdir()
        (Path(folder) / "bin/sinew").symlink_to(program)
        for number, block in enumerate(tests, 1):
            blocks += 1
            ran = subprocess.run(["bash", "-e", "-u", "-c", block], cwd=folder, capture_output=True, text=True,
                                 env={**os.environ, "PATH": f"{folder}/bin:{os.environ['PATH']}"})
            check(f"{name}: test {number} runs", ran.returncode == 0, ran.stdout + ran.stderr)
check("blocks were run", blocks >= 3, blocks)

fitted = subprocess.run(["/usr/bin/python3", ROOT / "tools/fit_confidence"], capture_output=True, text=True)
weights = re.search(r"^weights(\{.*\})$", fitted.stdout, re.M)
check("tools/fit_confidence prints the weights that the program has",
      weights and f"weights{weights[1]};" in (ROOT / "diagnose/confidence.cpp").read_text(), fitted.stdout + fitted.stderr)
cases = re.match(r"(\d+) cases, (\d+) names, (\d+) right", fitted.stdout)
check("and the cases that docs/diagnosis.md tells of",
      cases and re.search(rf"to {cases[1]} concealed cases.*?{cases[2]}\s+names, {cases[3]}\s+of\s+them\s+right", pages["docs/diagnosis.md"], re.S))
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
