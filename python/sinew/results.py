# SPDX-License-Identifier: Apache-2.0
"""`calibrate` and `diagnose`, and views of what they give: the files that the commands write, by name."""
import json
import math
import os
import pathlib
import types

from . import _core


class Result:
    """The files that the command of the same name writes."""

    def __init__(self, files):
        self.files = types.MappingProxyType(files)

    @property
    def plant(self):
        """The fitted or repaired plant."""
        return _core.Plant.from_yaml(self.files["plant.yaml"], "plant.yaml")

    def report(self, path):
        """Writes the report, one page of HTML."""
        pathlib.Path(path).write_bytes(self.files["report.html"].encode())

    def save(self, folder):
        """Writes all files into a folder."""
        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in self.files.items():
            (folder / name).write_bytes(content.encode())


class Calibration(Result):
    """`json` is calibration.json; `parameters` are its entries by name."""

    def __init__(self, files):
        super().__init__(files)
        self.json = json.loads(files["calibration.json"])

    @property
    def parameters(self):
        return {one["name"]: types.SimpleNamespace(**one) for one in self.json.get("parameters", [])}


class FoundEffect(types.SimpleNamespace):
    """An effect that the diagnosis names: name, probability and what else diagnosis.json says of it."""


class FoundLaw(types.SimpleNamespace):
    """Physics without a name, as a curve: `entry`, `argument`, `knots`, `values` and `band` with their units, as diagnosis.json has them."""

    def plot(self, axes=None):
        """Draws the curve and its 95 % band by matplotlib, and returns the axes."""
        if axes is None:
            from matplotlib import pyplot

            axes = pyplot.gca()
        lowest, highest = zip(*self.band)
        axes.fill_between(self.knots, lowest, highest, alpha=0.3)
        axes.plot(self.knots, self.values)
        axes.set_xlabel(f"{', '.join(self.argument)} / {self.argument_unit or 1}")
        axes.set_ylabel(f"{self.entry} / {self.unit}" if self.unit else f"{self.entry}, as a share of {', '.join(self.times)}")
        return axes


class FoundApart(types.SimpleNamespace):
    """In what parts are not alike: `words`, `effect` (None: the core's), `probability`, `log_odds`, and `values`, each with `parameter`,
    `part`, `value` and `interval`."""


class Answer(Result):
    """`json` is diagnosis.json; `words` is what the command prints."""

    def __init__(self, files, words):
        super().__init__(files)
        self.json = json.loads(files["diagnosis.json"])
        self.words = words

    def __str__(self):
        return self.words

    @property
    def verdict(self):
        return self.json["verdict"]

    @property
    def effects(self):
        """The effects that are named, each with `name`, `probability`, `parameters` and what else diagnosis.json says of it."""
        return [FoundEffect(probability=one["confidence"], **one) for one in self.json["effects"]]

    @property
    def laws(self):
        return [FoundLaw(**one["law"], **{key: value for key, value in one.items() if key != "law"}) for one in self.json["laws"]]

    @property
    def apart(self):
        """In what parts are not alike, with each part's values."""
        return [FoundApart(**one) for one in self.json["apart"]]

    def law(self, entry):
        """The law at this entry, "heat" for one; KeyError where none was found there."""
        for law in self.laws:
            if law.entry == entry:
                return law
        found = ", ".join(law.entry for law in self.laws) or "none"
        raise KeyError(f"no law was found at {entry}; there is: {found}")


def _options(fit_until_s, threads, **others):
    return {"fit_until_s": math.inf if fit_until_s is None else fit_until_s, "threads": threads or os.cpu_count() or 1, **others}


def _list(given):
    return [given] if isinstance(given, (str, _core.Recording)) else list(given)


def calibrate(plant, recordings, *, fit_until_s=None, fit=(), noise=(), ignore=(), starts=3, seed=1, threads=None, at_rest=False,
              progress=False):
    """Fits a plant to recordings: `sinew calibrate`, with its options. `progress`: True, or a function of the share that is done."""
    options = _options(fit_until_s, threads, fit=_list(fit), noise=_list(noise), ignored=_list(ignore), starts=starts, seed=seed,
                       at_rest=at_rest)
    return Calibration(_core._calibrate(plant, _list(recordings), options, progress))


def diagnose(plant, train, heldout=(), *, fit_until_s=None, noise=(), ignore=(), without=(), seed=1, threads=None, at_rest=False,
             progress=False):
    """Finds the physics that a plant leaves out: `sinew diagnose`, with its options. `progress`: True, or a function of the share that
    is done and of what is being done."""
    options = _options(fit_until_s, threads, noise=_list(noise), ignored=_list(ignore), without=_list(without), seed=seed,
                       at_rest=at_rest)
    return Answer(*_core._diagnose(plant, _list(train), _list(heldout), options, progress))
