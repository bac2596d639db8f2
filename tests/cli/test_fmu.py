#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes FMUs with `sinew export-fmu` and steps them as an importing program does, by ctypes. See test_cli.py. What they compute is compared
with the Python module of the same build and with `sinew run`. With the environment variable SINEW_FMI2_SCHEMA, the folder of the standard's
fmi2ModelDescription.xsd and the six files that it includes, each description is validated by xmllint (Debian: libxml2-utils), too.

    /usr/bin/python3 tests/cli/test_fmu.py build/release/sinew
"""
import ctypes
import math
import os
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
import zipfile

import test_cli as cli
from test_cli import PAPER_LIMB, ROOT, check, columns, refused, said, sinew, write

sys.path.insert(0, str(pathlib.Path(sys.argv[1]).resolve().parent / "python"))
import sinew as module  # noqa: E402

OK, ERROR = 0, 3
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
REFERENCE = ctypes.c_uint
SCHEMA = os.environ.get("SINEW_FMI2_SCHEMA")
ELEMENTS = ["CoSimulation", "UnitDefinitions", "LogCategories", "DefaultExperiment", "ModelVariables", "ModelStructure"]


class Callbacks(ctypes.Structure):
    _fields_ = [("logger", LOGGER)] + [(name, ctypes.c_void_p) for name in ("allocate", "free", "step_finished", "environment")]


class Fmu:
    """An FMU, unpacked into a folder of its own: its shared object stays loaded. A URI has to escape the folder's name."""
    unpacked = 0

    def __init__(self, path):
        Fmu.unpacked += 1
        self.folder = cli.folder / f"{path} ü {Fmu.unpacked}"
        with zipfile.ZipFile(cli.folder / path) as archive:
            archive.extractall(self.folder)
        self.text = (self.folder / "modelDescription.xml").read_text()
        self.root = xml.fromstring(self.text)
        self.name = self.root.find("CoSimulation").get("modelIdentifier")
        self.variables = self.root.findall("ModelVariables/ScalarVariable")
        self.reference = {one.get("name"): int(one.get("valueReference")) for one in self.variables}
        self.library = ctypes.CDLL(str(self.folder / f"binaries/linux64/{self.name}.so"))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        self.library.fmi2GetVersion.restype = self.library.fmi2GetTypesPlatform.restype = ctypes.c_char_p

    def of(self, causality):
        return [one.get("name") for one in self.variables if one.get("causality") == causality]


class Instance:
    def __init__(self, fmu, guid=None, location=None, kind=1, name=b"one"):
        self.fmu, self.said = fmu, []

        def logger(_, __, status, category, message):
            words = message.decode().replace("%%", "%").replace("##", "#")
            assert (status, category) == (ERROR, b"logStatusError") and message.decode().count("%") == 2 * words.count("%")
            self.said.append(words)
        self.callbacks = Callbacks(LOGGER(logger))
        self.component = ctypes.c_void_p(fmu.library.fmi2Instantiate(
            name, kind, (guid or fmu.root.get("guid")).encode(), (location or (fmu.folder / "resources").as_uri()).encode(),
            ctypes.byref(self.callbacks), 0, 0))

    def call(self, function, *arguments):
        return getattr(self.fmu.library, function)(self.component, *arguments)

    def setup(self, tolerance=None, start=0.0, stop=None):
        number = ctypes.c_double
        return self.call("fmi2SetupExperiment", tolerance is not None, number(tolerance or 0), number(start), stop is not None, number(stop or 0))

    def initialized(self, **experiment):
        """Every call that leads to the first step, which must do."""
        assert self.setup(**experiment) == self.call("fmi2EnterInitializationMode") == self.call("fmi2ExitInitializationMode") == OK, self.said
        return self

    def set(self, values):
        references = [name if isinstance(name, int) else self.fmu.reference[name] for name in values]
        count = len(values)
        return self.call("fmi2SetReal", (REFERENCE * count)(*references), ctypes.c_size_t(count), (ctypes.c_double * count)(*values.values()))

    def get(self, names):
        references = [name if isinstance(name, int) else self.fmu.reference[name] for name in names]
        count, values = len(names), (ctypes.c_double * len(names))()
        status = self.call("fmi2GetReal", (REFERENCE * count)(*references), ctypes.c_size_t(count), values)
        return list(values) if status == OK else None

    def step(self, point, size):
        return self.call("fmi2DoStep", ctypes.c_double(point), ctypes.c_double(size), 1)

    def simulated(self, time_s, inputs, names):
        """Rows of these variables at these times. A step ends just where the next begins: their difference is without rounding."""
        rows = [self.get(names)]
        for k in range(len(time_s) - 1):
            assert self.set(dict(zip(self.fmu.of("input"), inputs[k]))) == self.step(time_s[k], time_s[k + 1] - time_s[k]) == OK, self.said
            rows.append(self.get(names))
        return rows

    def free(self):
        self.call("fmi2FreeInstance")


def exported(plant, *arguments):
    result = sinew("export-fmu", plant, *arguments)
    check(f"{pathlib.Path(plant).name}: is exported", result.returncode == 0, said(result))
    return Fmu(re.search(r"^written: (.*)$", result.stdout, re.M)[1])


def drive(fmu, samples):
    """For each sample a value of each input: steps of some seconds, through the middle of its range."""
    rows = []
    for k in range(samples):
        row = []
        for n, name in enumerate(fmu.of("input")):
            real = fmu.variables[fmu.reference[name]].find("Real")
            lowest, highest = max(float(real.get("min")), -1.0), min(float(real.get("max")), 1.0)
            row.append(lowest + (highest - lowest) * (0.5 * ((k // (23 + 8 * n)) % 2) + 0.05 * n))
        rows.append(row)
    return rows


def check_description(fmu, what):
    names = [one.tag for one in fmu.root]
    check(f"{what}: the elements of the description stand in the standard's order", names == [one for one in ELEMENTS if one in names], names)
    check(f"{what}: it is of FMI 2.0, and has a guid", fmu.root.get("fmiVersion") == "2.0" and re.fullmatch(r"\{[0-9a-f]{32}\}", fmu.root.get("guid")))
    check(f"{what}: names are unique and structured", len(set(fmu.reference)) == len(fmu.variables)
          and all(re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name) for name in fmu.reference), list(fmu.reference))
    units = {one.get("name") for one in fmu.root.findall("UnitDefinitions/Unit")}
    used = {one.find("Real").get("unit") for one in fmu.variables} - {None}
    check(f"{what}: each unit is defined once", units == used and len(units) == len(fmu.root.findall("UnitDefinitions/Unit")), units ^ used)
    known = [one.find("Real") for one in fmu.variables if one.get("causality") in ("input", "parameter")]
    check(f"{what}: inputs and parameters have a start within their range",
          all(float(one.get("min")) <= float(one.get("start")) <= float(one.get("max")) for one in known))
    check(f"{what}: what is calculated has none", all(one.find("Real").get("start") is None for one in fmu.variables if one.get("initial") == "calculated"))
    outputs = [fmu.reference[name] + 1 for name in fmu.of("output")]
    for part in ("Outputs", "InitialUnknowns"):
        check(f"{what}: {part} lists the outputs", [int(one.get("index")) for one in fmu.root.findall(f"ModelStructure/{part}/Unknown")] == outputs)
    if SCHEMA:
        schema = pathlib.Path(SCHEMA) / "fmi2ModelDescription.xsd"
        ran = subprocess.run(["xmllint", "--noout", "--schema", schema, fmu.folder / "modelDescription.xml"], capture_output=True, text=True)
        check(f"{what}: the description is valid by {schema}", ran.returncode == 0, ran.stderr)


def test_file():
    fmu = exported(PAPER_LIMB)
    check_description(fmu, "paper_limb")
    with zipfile.ZipFile(cli.folder / "paper_limb.fmu") as archive:
        check("the archive is sound", archive.testzip() is None)
        check("it holds what an FMU has, and dates of its own alone", [one.filename for one in archive.infolist()] == [
            "modelDescription.xml", "binaries/linux64/paper_limb.so", "resources/plant.yaml", "documentation/licenses/license.txt"]
            and all(one.date_time == (1980, 1, 1, 0, 0, 0) for one in archive.infolist()), archive.namelist())
        print("size of the shared object and of the FMU:", archive.getinfo("binaries/linux64/paper_limb.so").file_size,
              (cli.folder / "paper_limb.fmu").stat().st_size)
    check("inputs and outputs are the plant's", fmu.of("input") == ["duty_A", "duty_B"]
          and fmu.of("output") == ["temperature_A_degC", "temperature_B_degC", "angle_deg"])
    check("a unit says what it is in SI", '<Unit name="deg"><BaseUnit rad="1" factor="0.0174532925199' in fmu.text
          and '<Unit name="degC"><BaseUnit K="1" offset="273.15"/>' in fmu.text
          and '<Unit name="N*m*s/rad"><BaseUnit kg="1" m="2" s="-1" rad="-1"/>' in fmu.text, fmu.text)
    check("the library says its version", fmu.library.fmi2GetVersion() == b"2.0" and fmu.library.fmi2GetTypesPlatform() == b"default")
    binary = fmu.folder / "binaries/linux64/paper_limb.so"
    needed = subprocess.run(["objdump", "-p", binary], capture_output=True, text=True).stdout
    check("the shared object needs nothing but the C library", set(re.findall(r"NEEDED +(\S+)", needed)) <=
          {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}, needed)
    offered = subprocess.run(["nm", "-D", "--defined-only", binary], capture_output=True, text=True).stdout.split()[2::3]
    check("and offers FMI's functions alone", len(offered) > 30 and all(name.startswith("fmi2") for name in offered), offered)
    check("it knows no path of the sources", str(ROOT).encode() not in binary.read_bytes())

    sinew("export-fmu", PAPER_LIMB, "--name", "paper_limb", "--out", "again.fmu")
    check("the same plant gives the same bytes", (cli.folder / "again.fmu").read_bytes() == (cli.folder / "paper_limb.fmu").read_bytes())
    refused("an FMU that is there", ["export-fmu", PAPER_LIMB], r"^paper_limb\.fmu\n?.*is there already.*--overwrite")
    check("--overwrite replaces it", sinew("export-fmu", PAPER_LIMB, "--overwrite").returncode == 0)
    refused("a plant that is not there", ["export-fmu", "nowhere.yaml"], r"^nowhere\.yaml: cannot read")
    write("broken.yaml", "format: 1\nparameters:\n  heat_loss_A_W_K: -1\n")
    refused("a broken plant", ["export-fmu", "broken.yaml"], r"^broken\.yaml:3:20: parameters\.heat_loss_A_W_K = -1\n  must lie in")
    refused("a name that C does not take", ["export-fmu", PAPER_LIMB, "--name", "my limb"], r"^--name = my limb\n.*letters, digits")
    write("plant.yaml", "format: 1\n")
    refused("the plant as the output", ["export-fmu", "plant.yaml", "--out", "plant.yaml", "--overwrite"], r"is the file that is read")
    write("2 limbs.yaml", "format: 1\n")
    check("a name is made of the file's", exported("2 limbs.yaml").name == "plant_2_limbs")


def differ(one, other):
    return [(k, a, b) for k, (a, b) in enumerate(zip(one, other)) if list(a) != list(b)][:2] or len(one) != len(other)


def same_as_module(what, fmu, plant, time_s, start=0.0):
    inputs = drive(fmu, len(time_s))
    instance = Instance(fmu).initialized(start=start)
    names = fmu.of("output") + fmu.of("local")
    rows = instance.simulated([start + t for t in time_s], inputs, names)
    told = plant.simulate(time_s, inputs)
    wanted = [[*channels, *states] for channels, states in zip(told.channels.tolist(), told.states.tolist())]
    check(f"{what}: has the states of the plant", [name.removeprefix("states.") for name in fmu.of("local")] == list(told.state_names), fmu.of("local"))
    check(f"{what}: outputs and states over {time_s[-1]:.0f} s are those of simulate(), bit for bit", not differ(rows, wanted), differ(rows, wanted))
    check(f"{what}: and they move", max(row[len(fmu.of("output")) - 1] for row in rows) > rows[0][len(fmu.of("output")) - 1], rows[-1])
    instance.free()
    return rows


def test_same_as_sinew():
    minute = [k * 0.1 for k in range(601)]
    uneven = [0.0]
    while uneven[-1] < 60:
        uneven.append(uneven[-1] + 0.01 + 0.4 * (len(uneven) * 7 % 11) / 11)
    same_as_module("paper_limb", Fmu("paper_limb.fmu"), module.Plant(PAPER_LIMB), minute)
    same_as_module("paper_limb, uneven steps", Fmu("paper_limb.fmu"), module.Plant(PAPER_LIMB), uneven)
    write("room.yaml", "format: 1\nbase: paper_limb\nparameters: { ambient_temperature_degC: 18.1, angle_offset_deg: 3.7 }\n"
          "effects:\n  thermocouple_lag: { time_constant_s: 1.2 }\n  input_delay: { delay_s: 0.23 }\n  airflow_change: { relative_change: 0.3, onset_s: 20 }\n")
    # As a diagnosis writes it: effects with values of a part's own, and a law.
    write("repaired.yaml", "format: 2\nbase: room.yaml\neffects:\n  latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } }\nlaws:\n  - entry: heat\n"
          "    argument: [angle, angle]\n    times: [heat from the air A, heat from the air B]\n    fading_memory_s: 20\n    knots: [-60, 0, 60]\n    values: [0.2, 0, 0.2]\n")
    for plant in ["repaired.yaml", *(ROOT / "plant" / name for name in (
            "limbs/two_axis_limb.yaml", "limbs/series_limb.yaml", "limbs/lab_two_limbs_2023.yaml", "tanks/no_overflow.yaml"))]:
        fmu = exported(plant)
        check_description(fmu, fmu.name)
        same_as_module(fmu.name, fmu, module.Plant(cli.folder / plant), minute)
    for name in ("repaired.yaml", "room.yaml"):
        (cli.folder / name).unlink()
    fmu = Fmu("repaired.fmu")
    same_as_module("repaired, without the files it was made of", fmu, module.Plant(fmu.folder / "resources/plant.yaml"), minute)
    for name in ("emps/rigid_axis", "silverbox/linear"):  # where simulate() may go on linearly, `run` holds
        fmu = exported(ROOT / f"plant/{name}.yaml")
        check_description(fmu, fmu.name)
        signal, unit = fmu.of("input")[0], fmu.of("input")[0].rpartition("_")[2]
        write("held.yaml", f"format: 1\nduration_s: 2\nsample_period_s: 0.001\nplant: {{ base: {ROOT}/plant/{name}.yaml }}\n"
              f"input: {{ {signal}: {{ sine: {{ mean_{unit}: 0, amplitude_{unit}: 0.5, period_s: 0.7, from_s: 0, until_s: 9 }} }} }}\n")
        ran = sinew("run", "held.yaml", "--out", fmu.name)
        if not check(f"{fmu.name}: runs", ran.returncode == 0, said(ran)):
            continue
        truth, recording = columns(f"{fmu.name}/truth.csv"), columns(f"{fmu.name}/recording.csv")
        instance = Instance(fmu).initialized()
        rows = instance.simulated(truth["time_s"], list(zip(*(recording[one] for one in fmu.of("input")))), fmu.of("local"))
        wanted = list(zip(*(truth[one.removeprefix("states.")] for one in fmu.of("local"))))
        check(f"{fmu.name}: states are those of `sinew run`, bit for bit", not differ(rows, wanted), differ(rows, wanted))
        instance.free()


def test_instances():
    fmu = Fmu("paper_limb.fmu")
    time_s = [k * 0.1 for k in range(201)]
    inputs = drive(fmu, len(time_s))
    names = fmu.of("output")
    alone = {}
    for scale in (1.0, 0.5):
        instance = Instance(fmu).initialized()
        alone[scale] = instance.simulated(time_s, [[scale * u for u in row] for row in inputs], names)
        if scale == 1.0:
            check("after fmi2Reset the same comes again", instance.call("fmi2Reset") == OK
                  and not differ(instance.initialized().simulated(time_s, inputs, names), alone[1.0]))
            check("after fmi2Terminate the last values can be read", instance.call("fmi2Terminate") == OK and instance.get(names) == alone[1.0][-1])
        instance.free()
    two = {scale: Instance(fmu).initialized() for scale in alone}
    rows = {scale: [one.get(names)] for scale, one in two.items()}
    for k in range(len(time_s) - 1):
        for scale, one in two.items():
            one.set(dict(zip(fmu.of("input"), [scale * u for u in inputs[k]])))
            one.step(time_s[k], time_s[k + 1] - time_s[k])
            rows[scale].append(one.get(names))
    check("two instances in turns are what each is alone", not any(differ(rows[scale], alone[scale]) for scale in alone))
    check("and they differ", differ(rows[1.0], rows[0.5]))
    for one in two.values():
        one.free()

    plant = module.Plant(PAPER_LIMB)
    plant.parameters["heat_loss_A_W_K"], plant.parameters["angle_offset_deg"] = 0.06, 3.7
    told = plant.simulate(time_s, inputs).channels.tolist()
    instance = Instance(fmu)
    instance.set({"parameters.heat_loss_A_W_K": 0.06})
    instance.setup()
    instance.call("fmi2EnterInitializationMode")
    before = instance.get(["angle_deg"])[0]
    instance.set({"parameters.angle_offset_deg": 3.7})
    check("a parameter that is set acts on the first outputs", math.isclose(instance.get(["angle_deg"])[0], before + 3.7, abs_tol=1e-9))
    instance.call("fmi2ExitInitializationMode")
    check("set parameters give what a plant file with these values gives", not differ(instance.simulated(time_s, inputs, names), told))
    check("a parameter is what was set", instance.get(["parameters.heat_loss_A_W_K"]) == [0.06])
    check("fmi2Reset brings the plant file's values back", instance.call("fmi2Reset") == OK
          and not differ(instance.initialized().simulated(time_s, inputs, names), alone[1.0]))
    instance.free()

    starts = {name: float(fmu.variables[reference].find("Real").get("start")) for name, reference in fmu.reference.items()
              if name.startswith("parameters.")}
    instance = Instance(fmu)
    instance.set(starts)
    check("all parameters set to their starts change nothing", not differ(instance.initialized().simulated(time_s, inputs, names), alone[1.0]))
    instance.free()

    later = Instance(fmu).initialized(start=1000.0, tolerance=1e-6, stop=1020.0)
    rows = later.simulated([1000.0 + t for t in time_s], inputs, names)
    worst = max(abs(a - b) for one, other in zip(rows, alone[1.0]) for a, b in zip(one, other))
    check("a start at 1000 s and a tolerance of 1e-6 give nearly the same", 0 < worst < 1e-2, worst)
    check("a step beyond stopTime is refused", later.step(1020.0, 0.1) == ERROR and "after stopTime = 1020" in later.said[-1], later.said)
    later.free()


def test_wrong_calls():
    fmu = Fmu("paper_limb.fmu")

    def wrong(what, status, instance, words):
        check(f"{what}: fmi2Error, and says why", status == ERROR and instance.said and re.search(words, instance.said[-1]), (status, instance.said[-1:]))
        instance.said.clear()

    for what, arguments, words in [
            ("another guid", {"guid": "{00}"}, r"fmi2Instantiate: fmuGUID = \{00\} is not that of .*plant\.yaml"),
            ("a location that is no URI", {"location": "http://example.org/"}, "is no file:/// URI"),
            ("a folder that is not there", {"location": "file:///nowhere"}, r"/nowhere/plant\.yaml: cannot read"),
            ("model exchange", {"kind": 0}, "co-simulation alone"), ("no name", {"name": b""}, "instanceName")]:
        instance = Instance(fmu, **arguments)
        check(f"{what}: no instance, and says why", not instance.component.value and re.search(words, instance.said[-1]), instance.said)
    broken = cli.folder / "broken"
    broken.mkdir()
    text = (fmu.folder / "resources/plant.yaml").read_text()
    (broken / "plant.yaml").write_text(text.replace("heat_loss_A_W_K: 0.04", "heat_loss_A_W_K: warm"))
    instance = Instance(fmu, location=broken.as_uri())
    check("a broken plant: no instance, and says the place", not instance.component.value
          and re.search(r"broken/plant\.yaml:\d+:\d+: parameters\.heat_loss_A_W_K = warm", instance.said[-1]), instance.said)
    check("no instance at all: fmi2Error", fmu.library.fmi2DoStep(None, ctypes.c_double(0), ctypes.c_double(1), 1) == ERROR
          and fmu.library.fmi2Reset(None) == ERROR and fmu.library.fmi2GetInteger(None, None, ctypes.c_size_t(0), None) == ERROR)
    fmu.library.fmi2FreeInstance(None)

    instance = Instance(fmu)
    wrong("a step before initialization", instance.step(0, 0.1), instance, "fmi2DoStep: cannot be called before fmi2EnterInit")
    wrong("outputs before initialization", instance.call("fmi2GetReal", (REFERENCE * 1)(0), ctypes.c_size_t(1), (ctypes.c_double * 1)()), instance, "before")
    wrong("an end of initialization that has not begun", instance.call("fmi2ExitInitializationMode"), instance, "before")
    for tolerance in (-1.0, 0.1, math.nan):
        wrong(f"a tolerance of {tolerance}", instance.setup(tolerance=tolerance), instance, r"must lie in \[1e-12, 0\.01\]")
    wrong("a start that is not a number", instance.setup(start=math.nan), instance, "startTime")
    wrong("a stop before the start", instance.setup(stop=-1.0), instance, "stopTime")
    instance.initialized()
    wrong("a second initialization", instance.call("fmi2EnterInitializationMode"), instance, "between communication steps")
    wrong("a value reference that there is not, set", instance.set({100000: 1.0}), instance, "value reference 100000")
    check("a value reference that there is not, read", instance.get([100000]) is None and "value reference 100000" in instance.said[-1])
    wrong("NaN", instance.set({"duty_A": math.nan}), instance, r"duty_A = nan must lie in \[0, 1\]")
    wrong("a value out of range", instance.set({"duty_A": 0.5, "duty_B": 1.5}), instance, r"duty_B = 1\.5 must lie in \[0, 1\]")
    check("and of several values none is taken then", instance.get(["duty_A"]) == [0.0])
    wrong("an output that is set", instance.set({"angle_deg": 1.0}), instance, "angle_deg is calculated")
    wrong("a parameter that is set after initialization", instance.set({"parameters.heat_loss_A_W_K": 0.05}), instance, "fixed once")
    wrong("a list that is missing", instance.call("fmi2SetReal", None, ctypes.c_size_t(1), None), instance, "a list is missing")
    for size in (0.0, -0.1, math.nan, math.inf):
        wrong(f"a step of {size} s", instance.step(0, size), instance, "communicationStepSize = ")
    wrong("a step that does not begin where the last one ended", instance.step(5, 0.1), instance, "is not where the step before it ended, 0")
    wrong("a Boolean", instance.call("fmi2SetBoolean", (REFERENCE * 1)(0), ctypes.c_size_t(1), (ctypes.c_int * 1)(1)), instance, "is a Real")
    check("no Boolean at all is no fault", instance.call("fmi2GetBoolean", None, ctypes.c_size_t(0), None) == OK)
    for function in ("fmi2GetFMUstate", "fmi2CancelStep", "fmi2GetDirectionalDerivative", "fmi2SetRealInputDerivatives"):
        wrong(function, instance.call(function, None, None, None, None, None, None), instance, f"{function}: can|provides|a step ends")
    check("after all that it steps", instance.step(0, 0.1) == OK and not instance.said)
    time = ctypes.c_double()
    check("it tells the time that it has reached", instance.call("fmi2GetRealStatus", 2, ctypes.byref(time)) == OK and time.value == 0.1)
    instance.call("fmi2Terminate")
    wrong("a step after the end", instance.step(0.1, 0.1), instance, "after fmi2Terminate")
    instance.free()
    # Cooling that turns into heating below ambient, where a drift of 1 K/s leaves the wires behind.
    write("failing.yaml", "format: 1\neffects: { convection_nonlinearity: { slope_1_K: 0.1 }, ambient_drift: { rate_K_s: 1 } }\n")
    instance = Instance(exported("failing.yaml")).initialized()
    wrong("a failed integration", next(s for s in (instance.step(k, 1) for k in range(60)) if s != OK), instance, r"failed at [\d.]+ s: At t = ")
    wrong("a step after it", instance.step(0, 0.1), instance, "fmi2Reset or fmi2FreeInstance may follow")
    check("after fmi2Reset it steps again", instance.call("fmi2Reset") == OK and instance.initialized().step(0, 1) == OK)
    instance.free()
    # A sign is one of two.
    instance = Instance(fmu)
    wrong("half a sign", instance.set({"parameters.bend_sign": 0.5}), instance, "must be 1 or -1")
    check("the other sign", instance.set({"parameters.bend_sign": -1.0}) == OK)
    instance.free()
    instance = Instance(Fmu("repaired.fmu"))
    wrong("an effect turned off", instance.set({"effects.thermocouple_lag.time_constant_s": 0.0}), instance, "= 0 turns the effect off")
    instance.free()


if __name__ == "__main__":
    if not SCHEMA:
        print("SKIPPED: descriptions are not validated by the standard's schema; SINEW_FMI2_SCHEMA, its folder, is not set")
    sys.exit(cli.run_tests("test_fmu", (test_file, test_same_as_sinew, test_instances, test_wrong_calls)))
