# SPDX-License-Identifier: Apache-2.0
"""The Python module beside the command: the same bytes, the same words. Run by ./check as

    SINEW=build/release/sinew PYTHONPATH=build/release/python /usr/bin/python3 -m pytest tests/python
"""
import csv
import json
import math
import os
import pathlib
import signal
import subprocess
import threading
import time

import numpy
import pytest
import sinew

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ["SINEW"] if os.path.isabs(os.environ["SINEW"]) else str(ROOT / os.environ["SINEW"])
PLANT = "plant/limbs/paper_limb.yaml"
DEMO = "scenarios/demo/recording.csv"


@pytest.fixture(autouse=True)
def in_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def command(*arguments, code=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


def table(path):
    with open(path) as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    return rows[0], numpy.array([[float(cell) if cell else math.nan for cell in row] for row in rows[1:]])


def bytes_in(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


def test_version_is_that_of_the_command():
    assert command("--version").stdout == f"sinew {sinew.__version__} ({sinew.__commit__})\n"


def test_a_recording_is_what_the_file_says():
    header, rows = table(DEMO)
    recording = sinew.Recording(DEMO)
    assert ["time_s", *recording.input_names, *recording.channel_names] == header
    numpy.testing.assert_array_equal(numpy.column_stack([recording.time_s, recording.inputs, recording.channels]), rows)
    numpy.testing.assert_array_equal(recording["angle_deg"], rows[:, -1])
    assert len(recording) == len(rows)
    with pytest.raises(KeyError, match="did you mean angle_deg"):
        recording["angel_deg"]
    with pytest.raises(ValueError, match="read-only"):
        recording.time_s[0] = 1.0


def test_a_recording_of_arrays_is_that_of_the_file(tmp_path):
    recording = sinew.Recording(DEMO)
    columns = {name: recording[name] for name in ["time_s", *recording.input_names, *recording.channel_names]}
    again = sinew.Recording.from_columns(columns)
    numpy.testing.assert_array_equal(again.channels, recording.channels)
    again.save(tmp_path / "again.csv")
    assert sinew.Recording(tmp_path / "again.csv").csv == again.csv
    columns["duty_A"] = columns["duty_A"] + 2.0
    with pytest.raises(sinew.InputError) as caught:
        sinew.Recording.from_columns(columns, name="mine")
    assert caught.value.file == "mine" and "duty_A" in str(caught.value)


def test_errors_are_those_of_the_command(tmp_path):
    bad = tmp_path / "bad.yaml"
    bad.write_text("# Bad.\nformat: 2\nparameters:\n  ambient_temperature_degC: 22.0\neffects:\n  thermocuple_lag: {time_constant_s: 1}\n")
    with pytest.raises(sinew.InputError) as caught:
        sinew.Plant(bad)
    said = command("compare", DEMO, "--plant", bad, code=2).stderr
    assert str(caught.value) + "\n" == said
    assert (caught.value.file, caught.value.line) == (str(bad), 6)


def test_parameters_and_effects_are_maps_that_check():
    plant = sinew.Plant(PLANT)
    ambient = plant.parameters["ambient_temperature_degC"]
    assert ambient.unit == "degC" and ambient.lowest < ambient.value < ambient.highest
    plant.parameters["ambient_temperature_degC"] = numpy.float64(21.5)
    assert plant.parameters["ambient_temperature_degC"].value == 21.5
    with pytest.raises(sinew.InputError, match=r"must lie in \["):
        plant.parameters["ambient_temperature_degC"] = 1e4
    with pytest.raises(sinew.InputError, match="did you mean ambient_temperature_degC"):
        plant.parameters["ambient_temperatur_degC"] = 20.0
    assert not plant.effects["thermocouple_lag"].is_on
    with pytest.raises(sinew.InputError, match="gives all its parameters"):
        plant.effects["thermocouple_lag"] = {}
    plant.effects["thermocouple_lag"] = {"time_constant_s": 1.25}
    assert plant.effects["thermocouple_lag"].is_on
    assert plant.parameters["thermocouple_lag.time_constant_s"].value == 1.25
    assert sinew.Plant.from_yaml(plant.yaml) == plant
    del plant.effects["thermocouple_lag"]
    assert not plant.effects["thermocouple_lag"].is_on
    before = plant.copy()
    plant.parameters["ambient_temperature_degC"] = 23.0
    assert before != plant and before.parameters["ambient_temperature_degC"].value == 21.5


def test_a_simulation_is_what_run_writes_to_truth(tmp_path):
    command("run", "scenarios/step.yaml", "--out", tmp_path / "run")
    recording = sinew.Recording(tmp_path / "run/recording.csv")
    header, truth = table(tmp_path / "run/truth.csv")
    scenario = (tmp_path / "run/scenario.yaml").read_text().splitlines()
    begin = scenario.index("plant:")
    end = next(k for k in range(begin + 1, len(scenario)) if not scenario[k].startswith("  "))
    plant = sinew.Plant.from_yaml("\n".join(line[2:] for line in scenario[begin + 1:end]))
    states = plant.simulate(recording.time_s, recording.inputs)
    for s, name in enumerate(states.state_names):
        # The run restarts its solver for checkpoints, so that both agree to the solver's tolerance: 1e-8 of a state's scale a step.
        numpy.testing.assert_allclose(states.states[:, s], truth[:, header.index(name)], rtol=1e-5, atol=1e-5)
    by_name = plant.simulate(recording.time_s, {name: recording[name] for name in plant.inputs})
    numpy.testing.assert_array_equal(by_name.channels, states.channels)


def test_sensitivities_are_differences_of_simulations():
    plant = sinew.Plant(PLANT)
    time_s = numpy.arange(0.0, 20.0, 0.1)
    inputs = numpy.column_stack([numpy.where(time_s < 8.0, 0.4, 0.0), numpy.zeros_like(time_s)])
    names = ["ambient_temperature_degC", "heat_loss_A_W_K"]
    given = plant.simulate(time_s, inputs, sensitivities=names)
    assert given.parameter_names == names and given.jacobian.shape == (200, len(plant.channels), 2)
    assert plant.simulate(time_s, inputs).jacobian is None
    for p, name in enumerate(names):
        value = plant.parameters[name].value
        step = 1e-4 * value
        sides = []
        for side in (value - step, value + step):
            plant.parameters[name] = side
            sides.append(plant.simulate(time_s, inputs, tolerance=1e-10).channels)
        plant.parameters[name] = value
        difference = (sides[1] - sides[0]) / (2 * step)
        scale = numpy.abs(difference).max(axis=0)
        assert scale.max() > 0
        scale[scale == 0] = 1.0  # a sensor of the other side
        # Central differences: 1e-8 relative by the step's square, and 1e-5 by the solver's tolerance over the step.
        numpy.testing.assert_allclose(given.jacobian[:, :, p] / scale, difference / scale, atol=2e-3)


def test_inputs_that_do_not_fit_are_refused():
    plant = sinew.Plant()
    time_s = numpy.arange(0.0, 1.0, 0.1)
    with pytest.raises(sinew.InputError, match=r"\[samples x 2\]"):
        plant.simulate(time_s, numpy.zeros((10, 3)))
    with pytest.raises(sinew.InputError, match="duty_A"):
        plant.simulate(time_s, numpy.full((10, 2), 1.5))
    with pytest.raises(sinew.InputError, match="tolerance"):
        plant.simulate(time_s, numpy.zeros((10, 2)), tolerance=0.0)
    with pytest.raises(sinew.InputError, match="did you mean heat_loss_A_W_K"):
        plant.simulate(time_s, numpy.zeros((10, 2)), sensitivities=["heat_los_A_W_K"])


def test_the_interpreter_is_free_while_it_simulates():
    plant, ticks, done = sinew.Plant(), [], threading.Event()

    def work():
        time_s = numpy.arange(0.0, 400.0, 0.1)
        plant.simulate(time_s, numpy.column_stack([0.3 + 0.2 * numpy.sin(time_s), 0 * time_s]))
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.is_set():
        ticks.append(time.monotonic())
        time.sleep(0.005)
    worker.join()
    assert len(ticks) > 5  # with the lock held there were one


def test_ctrl_c_is_a_keyboard_interrupt():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what is started in the background of a shell begins with it ignored
    time_s = numpy.arange(0.0, 40000.0, 0.1)
    inputs = numpy.column_stack([0.3 + 0.2 * numpy.sin(time_s), 0 * time_s])
    plant = sinew.Plant()
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        plant.simulate(time_s, inputs)
    assert time.monotonic() - began < 20.0  # all of it takes minutes
    plant.simulate(time_s[:10], inputs[:10])  # and nothing is left of it


def test_calibrate_gives_the_bytes_of_the_command(tmp_path):
    command("calibrate", DEMO, "--plant", PLANT, "--fit-until", 60, "--fit", "heat_loss_A_W_K,heat_loss_B_W_K", "--starts", 1, "--threads", 2,
            "--out", tmp_path / "by_command")
    shares = []
    fit = sinew.calibrate(sinew.Plant(PLANT), [sinew.Recording(DEMO)], fit_until_s=60, fit=["heat_loss_A_W_K", "heat_loss_B_W_K"], starts=1,
                          threads=1, progress=shares.append)
    fit.save(tmp_path / "by_python")
    assert bytes_in(tmp_path / "by_python") == bytes_in(tmp_path / "by_command")
    assert shares and 0.0 <= min(shares) and max(shares) <= 1.0
    assert fit.plant.parameters["heat_loss_A_W_K"].value == pytest.approx(fit.parameters["heat_loss_A_W_K"].value, rel=1e-12)
    with pytest.raises(sinew.InputError, match="did you mean heat_loss_A_W_K"):
        sinew.calibrate(sinew.Plant(PLANT), [sinew.Recording(DEMO)], fit=["heat_los_A_W_K"])
    with pytest.raises(sinew.InputError, match="starts = 0"):
        sinew.calibrate(sinew.Plant(PLANT), [sinew.Recording(DEMO)], starts=0)


def test_diagnose_gives_the_bytes_of_the_command(tmp_path):
    without = [name for name in sinew.Plant(PLANT).effects if name != "thermocouple_lag"]
    short = tmp_path / "short.csv"
    recording = sinew.Recording(DEMO)
    columns = {name: recording[name][:300] for name in ["time_s", *recording.input_names, *recording.channel_names]}
    sinew.Recording.from_columns(columns).save(short)
    command("diagnose", "--train", short, "--plant", PLANT, "--without", *without, "--threads", 2, "--out", tmp_path / "by_command")
    answer = sinew.diagnose(sinew.Plant(PLANT), train=[sinew.Recording(short)], without=without, threads=2)
    answer.save(tmp_path / "by_python")
    assert bytes_in(tmp_path / "by_python") == bytes_in(tmp_path / "by_command")
    by_command = json.loads((tmp_path / "by_command/diagnosis.json").read_text())
    assert answer.verdict == by_command["verdict"] and answer.words
    assert [one.name for one in answer.effects] == [one["name"] for one in by_command["effects"]]
    answer.plant.save(tmp_path / "repaired.yaml")
    assert sinew.Plant(tmp_path / "repaired.yaml") == sinew.Plant(tmp_path / "by_command/plant.yaml")
    answer.report(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_bytes() == (tmp_path / "by_command/report.html").read_bytes()
    with pytest.raises(KeyError, match="no law was found at air"):
        answer.law("air")
    assert answer.apart == []
    answer.json["apart"] = [{"words": "w", "effect": None, "probability": 0.9, "log_odds": 9.0,
                             "values": [{"parameter": "heating_width_K", "part": "A", "value": 7.0, "interval": [6.0, 8.0]}]}]
    assert answer.apart[0].log_odds == 9.0 and answer.apart[0].probability == 0.9 and answer.apart[0].values[0]["part"] == "A"


def test_a_rollout_is_what_the_command_writes(tmp_path):
    command("rollout", "results/lstm4", "--recording", DEMO, "--horizon", 1e6, "--hold-missing", "--out", tmp_path / "rollout")
    header, rows = table(tmp_path / "rollout/rollout.csv")
    model = sinew.Predictor("results/lstm4")
    given = model.rollout(sinew.Recording(DEMO), hold_missing=True)
    with pytest.raises(sinew.InputError, match="angle_deg = not a number"):
        model.rollout(sinew.Recording(DEMO))
    assert model.case == 4 and given.column == header[1]
    numpy.testing.assert_array_equal(numpy.column_stack([given.time_s, given.measured, given.open_loop, given.one_step]), rows)
