#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Debian package of a build: its size, what is in it, and that it works from where it is unpacked. See tests/cli/test_cli.py.

    python3 tests/package/test_package.py build/release
"""
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
build = Path(sys.argv[1]).resolve()
counts = {True: 0, False: 0}


def check(what, holds, detail=""):
    counts[bool(holds)] += 1
    print(("ok      " if holds else "FAILED  ") + what, flush=True)
    if not holds and detail:
        print("        " + str(detail).strip()[-3000:].replace("\n", "\n        "), flush=True)
    return bool(holds)


def run(*arguments, **settings):
    return subprocess.run(list(map(str, arguments)), capture_output=True, text=True, **settings)


with tempfile.TemporaryDirectory(prefix="sinew_package_") as folder:
    folder = Path(folder)
    packed = run("cpack", "--config", build / "CPackConfig.cmake", "-B", folder, cwd=folder)
    packages = list(folder.glob("*.deb"))
    if check("cpack makes one Debian package", packed.returncode == 0 and len(packages) == 1, packed.stdout + packed.stderr):
        package = packages[0]
        size = package.stat().st_size
        print(f"{package.name}: {size / 1e6:.1f} MB")
        check("it has at most 10 MB", size <= 10e6, size)
        check("docs/installing.md installs it by its name",
              f"./build/release/{package.name}\n" in (ROOT / "docs/installing.md").read_text())
        fields = run("dpkg-deb", "--field", package).stdout
        check("it depends on the libraries that it links, and on what reports and Python need",
              all(re.search(rf"^Depends:.*\b{name}", fields, re.M) for name in ("libcholmod3", "libyaml-cpp", "libsundials-cvodes", "libjs-dygraphs", "python3-numpy")), fields)
        root = folder / "root"
        run("dpkg-deb", "-x", package, root)
        usr = root / "usr"
        version = run(build / "sinew", "--version").stdout
        check("the program runs", run(usr / "bin/sinew", "--version").stdout == version)
        commands = re.findall(r"^complete .* -f -a (\S+) -d", (usr / "share/fish/vendor_completions.d/sinew.fish").read_text(), re.M)
        commands = sorted({name for name in commands if "'" not in name})
        pages = {path.name for path in (usr / "share/man/man1").iterdir()}
        check("every command has a page", len(commands) > 10 and pages == {"sinew.1"} | {f"sinew-{name}.1" for name in commands}, (pages, commands))
        check("pages are what `sinew man` prints",
              (usr / "share/man/man1/sinew-diagnose.1").read_text() == run(build / "sinew", "man", "diagnose").stdout)
        check("completions are there", all((usr / name).is_file() for name in (
            "share/bash-completion/completions/sinew", "share/zsh/vendor-completions/_sinew")))
        check("licences are there", all((usr / "share/doc/sinew" / name).is_file() for name in ("copyright", "NOTICE")))
        check("plants, scenarios and schemas are there",
              all((usr / "share/sinew" / name).is_file() for name in
                  ("plant/limbs/paper_limb.yaml", "scenarios/step.yaml", "scenarios/demo/recording.csv", "docs/schema/plant.json")))
        ran = run(usr / "bin/sinew", "run", usr / "share/sinew/scenarios/step.yaml", "--out", folder / "step")
        check("a scenario of the package runs", ran.returncode == 0, ran.stderr)
        exported = run(usr / "bin/sinew", "export-fmu", usr / "share/sinew/plant/limbs/paper_limb.yaml", cwd=folder)
        check("an FMU is made with the shared object that is installed", exported.returncode == 0 and (usr / "lib/sinew/sinew-fmu.so").read_bytes() ==
              zipfile.ZipFile(folder / "paper_limb.fmu").read("binaries/linux64/paper_limb.so"), exported.stdout + exported.stderr)
        module = usr / "lib/python3/dist-packages"
        code = "import sinew; print(f'sinew {sinew.__version__} ({sinew.__commit__})'); print(sinew.Plant().simulate([0, 0.1], [[0, 0]] * 2).channels.shape)"
        imported = run("/usr/bin/python3", "-c", code, env={**os.environ, "PYTHONPATH": str(module)}, cwd=folder)
        check("the Python module is imported and simulates", imported.stdout == version + "(2, 3)\n", imported.stdout + imported.stderr)
        if (build / "sinew-emulator").exists():
            (folder / "short.yaml").write_text("format: 1\nduration_s: 2\ninput: {duty_A: {constant: {value_fraction: 0.1}}}\n")
            emulated = run(usr / "bin/sinew", "hil", folder / "short.yaml", "--emulate", "--out", folder / "session")
            check("the emulated board is found where it is installed, and runs",
                  emulated.returncode == 0 and (folder / "session/recording.csv").is_file(), emulated.stdout + emulated.stderr)

        example = ROOT / "examples/own_plant"
        page = (ROOT / "docs/adding_a_system.md").read_text()
        block = re.search(r"`plant/kettle/system\.cpp`:\n\n```cpp\n(.*?)```", page, re.S)[1]
        check("examples/own_plant/kettle.cpp is the example of docs/adding_a_system.md", (example / "kettle.cpp").read_text() == block)
        configured = run("cmake", "-G", "Ninja", "-S", usr / "share/doc/sinew/examples/own_plant", "-B", folder / "own", f"-DCMAKE_PREFIX_PATH={usr}")
        if check("find_package(sinew) finds the installed libraries", configured.returncode == 0, configured.stdout + configured.stderr):
            built = run("cmake", "--build", folder / "own")
            if check("a plant of one's own is compiled with them", built.returncode == 0, built.stdout + built.stderr):
                answer = run(folder / "own/own_plant")
                # By hand: 20 degC + 200 W / 1.5 W/K (1 - exp(-3000 s 1.5 W/K / 4200 J/K)) = 107.66 degC.
                check("it warms as the equation by hand says", "after 3000 s of 200 W: 107.66 degC" in answer.stdout, answer.stdout + answer.stderr)
                check("its heat loss is found again", "heat_loss_W_K: 1.500 fitted" in answer.stdout, answer.stdout)
print(f"{counts[True]} passed, {counts[False]} failed")
sys.exit(1 if counts[False] else 0)
