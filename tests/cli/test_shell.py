#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Completion and manual pages, as shells and man read them, and the JSON Schemas, as an editor does. See test_cli.py.

    python3 tests/cli/test_shell.py build/release/sinew
"""
import copy
import json
import re
import shutil
import subprocess
import sys
import tempfile
import pathlib

import test_cli as cli
from test_cli import ROOT, SUBCOMMANDS, check, sinew


def run(*arguments, text=None):
    return subprocess.run(arguments, input=text, capture_output=True, text=True)


def options_of(command):
    head = sinew(command, "--help").stdout.split("Examples:")[0]
    names = re.findall(r"^  (?:-\w,)?(--[a-z][a-z,-]*)", head, re.M)
    return {name for one in names for name in one.split(",")}


def in_bash(*words):
    """What is offered for the last word."""
    script = f'source <("{cli.program}" completion bash)\nCOMP_WORDS=({" ".join(words)})\nCOMP_CWORD={len(words) - 1}\n'
    return run("bash", "-c", script + '_sinew\nprintf "%s\\n" "${COMPREPLY[@]}"').stdout.split()


def test_completion():
    check("bash completes a command", in_bash("sinew", "dia") == ["diagnose"])
    check("bash lists every command", set(in_bash("sinew", '""')) >= set(SUBCOMMANDS))
    check("bash knows the options of every command",
          all(set(in_bash("sinew", command, "--")) >= options_of(command) and options_of(command) for command in SUBCOMMANDS))
    check("bash completes a choice", in_bash("sinew", "train", "--method", "pub") == ["published"])
    check("bash completes an argument that is a choice", in_bash("sinew", "completion", "z") == ["zsh"])
    check("bash leaves the rest to its own completion of files", in_bash("sinew", "run", "scen") == [])
    if shutil.which("fish"):
        with tempfile.TemporaryDirectory() as home:
            def in_fish(line):
                script = f"'{cli.program}' completion fish | source; complete -C '{line}'"
                answer = subprocess.run(["fish", "-c", script], capture_output=True, text=True, env={"HOME": home, "PATH": "/usr/bin:/bin"})
                return [one.split("\t")[0] for one in answer.stdout.splitlines()]
            check("fish completes a command", in_fish("sinew dia") == ["diagnose"])
            check("fish knows the options of every command", all(set(in_fish(f"sinew {one} --")) >= options_of(one) for one in SUBCOMMANDS))
            check("fish completes a choice", in_fish("sinew train --method pub") == ["published"])
    else:
        print("SKIPPED: completion in fish, which is not installed")
    if shutil.which("zsh"):
        script = sinew("completion", "zsh").stdout
        check("zsh reads its script", run("zsh", "-n", text=script).returncode == 0)
        # In a terminal of zsh's own, as a person would: TAB behind the word, and what then stands there.
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "_sinew").write_text(script)
            terminal = (f"zmodload zsh/zpty; zpty z zsh -f -i; zpty -w z 'PS1= ; fpath=({folder} $fpath); autoload -U compinit; compinit -u -d "
                        f"{folder}/dump; sinew() {{ print -r -- \"[$*]\" }}'; sleep 1; zpty -w -n z 'sinew dia\t--held\tnone\n'; sleep 2; "
                        "zpty -r z text '*diagnose*]*' && print -r -- $text")
            told = run("zsh", "-f", "-c", terminal).stdout
            check("zsh completes a command and its option", "[diagnose --heldout none]" in told, told)
    else:
        print("SKIPPED: completion in zsh, which is not installed")
    cli.refused("a shell that is not known", ["completion", "csh"], "csh")


def test_pages():
    lint = shutil.which("mandoc")
    for name in ["", *SUBCOMMANDS]:
        page = sinew("man", *([name] if name else [])).stdout
        title = f"sinew-{name}" if name else "sinew"
        if lint:
            # A page has no date: the same program prints the same bytes.
            faults = [line for line in run("mandoc", "-T", "lint", "-W", "warning", text=page).stdout.splitlines() if "missing date" not in line]
            check(f"mandoc finds no fault in the page of {title}", not faults and page.startswith(".TH"), faults)
            shown = re.sub(r".\x08", "", run("mandoc", "-T", "utf8", text=page).stdout).replace("\u2010", "-")
            wanted = options_of(name) if name else set(SUBCOMMANDS)
            check(f"the page of {title} shows all of its {'options' if name else 'commands'}",
                  all(re.search(rf"(?<![\w-]){one}(?![\w-])", shown) for one in wanted), wanted)
    if not lint:
        print("SKIPPED: pages in mandoc, which is not installed")
    cli.refused("a page of no command", ["man", "diagnos"], "did you mean diagnose")


def test_schemas():
    try:
        import jsonschema
        import yaml
    except ImportError:
        print("SKIPPED: JSON Schemas, without python3-jsonschema and python3-yaml")
        return

    # As an editor reads them: a number such as 1e-3 is one.
    class Reader(yaml.SafeLoader):
        pass
    Reader.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?$"), list("-+.0123456789"))
    Reader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?\d+$"), list("-+0123456789"))

    def read(path):
        return yaml.load(path.read_text(), Reader)

    kinds = {}
    for kind in ("plant", "scenario"):
        printed = sinew("schema", kind).stdout
        check(f"docs/schema/{kind}.json is what `sinew schema {kind}` prints", (ROOT / f"docs/schema/{kind}.json").read_text() == printed)
        jsonschema.Draft7Validator.check_schema(json.loads(printed))
        kinds[kind] = jsonschema.Draft7Validator(json.loads(printed))
    files = subprocess.run(["git", "-C", ROOT, "ls-files", "*.yaml"], capture_output=True, text=True).stdout.split()
    seen = {"plant": 0, "scenario": 0}
    for name in files:
        path, what = ROOT / name, read(ROOT / name)
        kind = "scenario" if "duration_s" in what else "plant"
        if kind == "plant" and not set(what) <= {"format", "base", "limb", "emps", "tanks", "silverbox", "parameters", "effects", "laws"}:
            continue  # a list of cases, a training
        seen[kind] += 1
        if "outer_turns" in path.read_text():  # written before that effect was called junction; the reader refuses it, too
            check(f"{name}, which no reader takes any more, is refused", list(kinds[kind].iter_errors(what)))
            continue
        faults = [f"{'.'.join(map(str, one.absolute_path))}: {one.message[:200]}" for one in kinds[kind].iter_errors(what)]
        if faults or not name.startswith("results/stress4"):
            check(f"{name} is a {kind} by its schema", not faults, faults)
        if not name.startswith("results/"):
            line = re.search(r"^# yaml-language-server: \$schema=(\S+)$", path.read_text(), re.M)
            check(f"{name} tells editors its schema", line and (path.parent / line[1]).resolve() == ROOT / f"docs/schema/{kind}.json")
    check("all kinds of files were seen", seen["plant"] >= 10 and seen["scenario"] >= 60, seen)

    broken_plants = ["format: 3", "format: 2\nlimb:", "format: 1\nparametres: {}", "format: 1\nparameters: {heat_loss_A_W_K: -1}",
                     "format: 1\nparameters: {heat_los_A_W_K: 0.01}", "format: 1\nparameters: {heat_loss_A_W_K: warm}",
                     "format: 1\neffects: {thermocuple_lag: {time_constant_s: 1}}", "format: 1\neffects: {thermocouple_lag: {}}",
                     "format: 1\neffects: {thermocouple_lag: {time_constant_s: 1000}}",
                     "format: 1\neffects: {thermocouple_lag: {time_constant_s: 1, gain: 2}}",
                     "format: 2\nemps: {}\nparameters: {heat_loss_A_W_K: 0.01}", "format: 2\nlaws: [{entry: moment}]"]
    scenario = "format: 1\nduration_s: 10\n"
    broken_scenarios = ["format: 1", "format: 2\nduration_s: 10", "format: 1\nduration_s: -1", scenario + "sede: 1", scenario + "seed: -1",
                        scenario + "seed: 1.5", scenario + "plant: {effects: {thermocuple_lag: {time_constant_s: 1}}}",
                        scenario + "input: {duty_A: {constant: {value_fraction: 2}}}", scenario + "input: {duty_A: {constant: {}}}",
                        scenario + "input: {duty_C: {constant: {value_fraction: 0.5}}}",
                        scenario + "input: {duty_A: {saw: {value_fraction: 0.5}}}",
                        scenario + "plant: {emps: {}}\ninput: {duty_A: {constant: {value_fraction: 0.5}}}",
                        scenario + "sensors: {temperature_C: {noise_degC: 0.1}}", scenario + "sensors: {temperature_A: {noise_deg: 0.1}}",
                        scenario + "numerics: {method: euler}", scenario + "start: {temperature_A_degC: 2000}",
                        scenario + "start: {temperature_X_degC: 20}", scenario + "input: {babble: {highest_deg: 20}}"]
    with tempfile.TemporaryDirectory() as folder:
        for kind, broken in (("plant", broken_plants), ("scenario", broken_scenarios)):
            for text in broken:
                path = pathlib.Path(folder) / "broken.yaml"
                path.write_text("# Broken.\n" + text + "\n")
                refused = (sinew("compare", ROOT / "scenarios/demo/recording.csv", "--plant", path) if kind == "plant" else
                           sinew("run", path, "--out", pathlib.Path(folder) / "out")).returncode == 2
                by_schema = list(kinds[kind].iter_errors(read(path)))
                check(f"reader and schema refuse the {kind} {text!r}", refused and by_schema, (refused, len(by_schema)))
    # A limb of another structure: by name where the schema is made for it.
    two_axis = ROOT / "plant/limbs/two_axis_limb.yaml"
    own = jsonschema.Draft7Validator(json.loads(sinew("schema", "plant", "--plant", two_axis).stdout))
    what = read(two_axis)
    check("a schema made for a limb takes its file", not list(own.iter_errors(what)))
    misspelt = copy.deepcopy(what)
    misspelt["parameters"]["heat_los_W_K"] = 0.01
    check("and refuses a parameter that it has not", list(own.iter_errors(misspelt)) and not list(kinds["plant"].iter_errors(misspelt)))


if __name__ == "__main__":
    sys.exit(cli.run_tests("test_shell", (test_completion, test_pages, test_schemas)))
