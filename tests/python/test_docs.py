# SPDX-License-Identifier: Apache-2.0
"""The examples of docs/python.md, each on its own, and the cells of docs/tutorial.ipynb, one after the other."""
import json
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/python.md").read_text(), re.S | re.M)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    for name in ("plant", "scenarios", "results"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_runs(example):
    exec(compile(example, "docs/python.md", "exec"), {})


def test_there_are_examples():
    assert len(EXAMPLES) == 4


def test_the_notebook_runs_and_finds_what_was_concealed():
    cells = json.loads((ROOT / "docs/tutorial.ipynb").read_text())["cells"]
    names = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), "docs/tutorial.ipynb", "exec"), names)
    assert [effect.name for effect in names["answer"].effects] == ["viscoelastic_creep"]
    assert pathlib.Path("report.html").is_file() and pathlib.Path("repaired.yaml").is_file()
