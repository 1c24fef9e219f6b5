# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The documents' Python, run one after the other as it stands there."""

import pathlib
import re

import pytest

import pliant

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTS = ["README.md", "docs/hello.md", "docs/howto/python.md", "docs/howto/augment.md"]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_its_examples_run(document, tmp_path, monkeypatch):
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(), re.M | re.S)
    assert blocks
    monkeypatch.chdir(tmp_path)
    airway = pliant.make_phantom("airway")
    airway.save("airway.nrrd")
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, document, "exec"), names)
    pushed = pliant.read_volume("pushed.nrrd")
    assert (pushed.array != airway.array).sum() > 1000
