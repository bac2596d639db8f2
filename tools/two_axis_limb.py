# SPDX-License-Identifier: Apache-2.0
"""What tools/predict_two_axis, predict_two_axis_synthetic and predict_two_axis_trust share: the two recordings of the limb with two
bending axes, four coils and no thermocouples, and how predictors are trained on them and tested.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[1]
DATA = ROOT / "../shared/data/two_axis_limb"
RECORDINGS = {"walk 1": "data_random_walk_stiff_1.csv", "walk 3": "data_walk_stiff_jun_27_1_navy_blue_3.csv"}
PLANT = ROOT / "results/two_axis/plant.yaml"  # fitted to 0-900 s of walk 1 (results/two_axis/README.md)
AXES = ["x", "y"]
SHARE, HORIZON_S, HISTORY_S = 0.8, 600.0, 600.0
WORDS = {"published": "LSTM as published", "stateful": "LSTM with memory", "corrected": "the same, corrected one step ahead",
         "arx": "ARX, one step", "arx_simulation": "ARX, simulation error", "plant": "calibrated plant",
         "gru": "GRU with memory", "hybrid": "LSTM on what the plant leaves"}
RANDOM = {"published", "stateful", "corrected", "gru", "hybrid"}  # their first weights


def parser_of(text, updates):
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sinew", type=pathlib.Path, default=ROOT / "build/release/sinew", help="the program")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/two_axis")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/prediction")
    parser.add_argument("--updates", type=int, default=updates, help="of what has memory")
    parser.add_argument("--seeds", type=int, default=5, help="of what begins with random weights")
    parser.add_argument("--jobs", type=int, default=2, help="seeds at a time")
    return parser


def limb_of(parser, arguments):
    """The limb, or None, said so, where its recordings are not there. Ends with an error where an option makes no sense."""
    for option, value in vars(arguments).items():
        if any(type(one) in (int, float) and one <= 0 for one in (value if isinstance(value, list) else [value])):
            parser.error(f"--{option} must be above 0")
    program = arguments.sinew.resolve()
    if not program.is_file():
        parser.error(f"{program} is not there; cmake --build --preset release makes it")
    if not DATA.exists():
        print(f"SKIPPED: {DATA} is not there")
        return None
    return Limb(program, arguments.work.resolve())


class Limb:
    """Its recordings, converted into `work`, with the program that they are put to. Work that is done is not done again."""

    def __init__(self, program, work):
        self.program, self.work, self.ends = program, work, {}
        work.mkdir(parents=True, exist_ok=True)
        for name, file in RECORDINGS.items():
            if not self.csv(name).exists():
                self.sinew("convert", DATA / file, self.csv(name), "--map", "plant/limbs/two_axis_limb.map.yaml")
            self.ends[name] = float(self.csv(name).read_text().rstrip().rsplit("\n", 1)[1].split(",")[0])

    def csv(self, recording):
        return self.work / f"{recording}.csv"

    def sinew(self, *arguments, but=None):
        """What it prints; None where it ends with these words in its error."""
        done = subprocess.run([self.program, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
        if done.returncode and not (but and but in done.stderr):
            sys.exit(f"sinew {' '.join(map(str, arguments))}\n{done.stdout}{done.stderr}")
        return done.stdout if done.returncode == 0 else None

    def calibrated(self, recording, seconds):
        """The plant fitted to the beginning of a recording, as results/two_axis has it from 900 s, which is the most."""
        if seconds >= 900.0:
            return PLANT
        out = self.work / f"plant_{recording}_{seconds:.0f}".replace(" ", "_")
        if not (out / "plant.yaml").exists():
            self.sinew("calibrate", self.csv(recording), "--plant", "plant/limbs/two_axis_limb.yaml", "--fit-until", seconds, "--starts", 1,
                       "--out", out, "--overwrite")
        return out / "plant.yaml"

    def train(self, name, data, kind, axis, seed, settings, *more):
        """The folder `name` with a predictor of one axis; None where the data are too short."""
        out = self.work / name.replace(" ", "_")
        if (out / "weights.h5").exists():
            return out
        if settings:
            path = self.work / f"{out.name}.yaml"
            path.write_text(settings)
            more = ("--settings", path, *more)
        done = self.sinew("train", data, "--resample", "--case", 3, "--predictor", kind, "--predict", f"angle_{axis}_deg", "--seed", seed,
                          "--threads", 1, *more, "--out", out, but="is too short")
        return out if done is not None else None

    def rollout(self, model, recording, history_s=HISTORY_S):
        """What `rollout` says of the last fifth of a recording, or of its first ten minutes; None where it leaves all bounds."""
        out = self.work / f"{model.name}_on_{recording}_{history_s:.0f}".replace(" ", "_")
        text = self.sinew("rollout", model, "--recording", self.csv(recording), "--resample", "--plant", PLANT, "--from",
                          SHARE * self.ends[recording], "--horizon", HORIZON_S, *(("--history", history_s) if history_s else ()), "--json",
                          "--out", out, "--overwrite", but="goes beyond all bounds")
        return json.loads(text) if text is not None else None

    def tested_s(self):
        """In words, which seconds of each recording are predicted."""
        return ", ".join(f"{n}: from {SHARE * e:.0f} to {min(e, SHARE * e + HORIZON_S):.0f} s" for n, e in self.ends.items())


def settings_text(updates, seconds, more=""):
    """Settings of every kind for so many seconds of data, all of which are trained on."""
    # A validation part needs its lead-in: of a few minutes little is left for it.
    settling = min(40.0, seconds / 20.0)
    life = min(600.0, max(20.0, seconds / 4.0))
    memory = (f"{{ training_fraction: 1.0, updates: {updates}, settling_s: {settling}, shortest_life_s: {life / 4.0}, "
              f"longest_life_s: {life}, validation_fraction: 0.2, steps: {100 if seconds > 300 else 50}{more} }}\n")
    return ("published: { training_fraction: 1.0 }\narx: { training_fraction: 1.0 }\narx_simulation: { training_fraction: 1.0 }\n"
            f"stateful: {memory}gru: {memory}hybrid: {{ base: stateful }}\n")


def number(value):
    return "beyond all bounds" if value == float("inf") else f"{value:.3g}" if value < 1 else f"{value:.1f}"


def degrees(values):
    """Median, lowest and highest of the seeds; of one, itself. None where a rollout left all bounds."""
    if not values:
        return ""
    values = [float("inf") if v is None else v for v in values]
    middle = number(statistics.median(values))
    text = middle if len(values) == 1 else f"{middle} ({number(min(values))} to {number(max(values))})"
    return text if text.startswith("beyond") else text + "°" if len(values) == 1 else middle + "°" + text[len(middle):]


def command_of(tool, parser, arguments, options):
    """The tool's command with the options that are not at their defaults."""
    text = f"tools/{tool}"
    for option in options:
        value = vars(arguments)[option]
        if value == parser.get_default(option):
            continue
        text += " --" + option.replace("_", "-")
        for one in [] if value is True else value if isinstance(value, list) else [value]:
            text += f" {one:g}" if isinstance(one, float) else f" {one}"
    return text


def paragraph(text):
    return textwrap.fill(text, 140)


def find(rows, **keys):
    return [row for row in rows if all(row[key] == value for key, value in keys.items())]


def write(out, stem, lines, rows):
    out.mkdir(parents=True, exist_ok=True)
    (out / f"{stem}.md").write_text("\n".join(lines) + "\n")
    (out / f"{stem}.json").write_text(json.dumps(rows, indent=1) + "\n")
    print("\n".join(lines))
