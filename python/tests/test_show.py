# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The page of pliant.show: it is served, may be shown by a notebook, and ends."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest

import pliant


def has_program() -> bool:
    try:
        pliant.program()
    except pliant.Error:
        return False
    return True


needs_program = pytest.mark.skipif(not has_program(), reason="needs the program pliant")


def answer(url: str) -> tuple[int, str]:
    with urllib.request.urlopen(url.split("#")[0], timeout=20) as response:
        return response.status, response.headers["Content-Security-Policy"]


@needs_program
def test_shows_a_scan_until_it_is_closed(airway: pliant.Volume) -> None:
    with pliant.show(airway, threads=1) as page:
        status, policy = answer(page.url)
        assert status == 200
        assert policy.endswith("frame-ancestors http://localhost:* http://127.0.0.1:*")
        assert f'src="{page.url}"' in page._repr_html_() and "#token=" in page.url
        assert page.view_url != page.url
    assert repr(page) == "Page(closed)" and "iframe" not in page._repr_html_()
    with pytest.raises(urllib.error.URLError):
        answer(page.url)
    page.close()


@needs_program
def test_shows_a_tissue_and_labels(airway: pliant.Volume) -> None:
    tissue = pliant.make_chainmail(airway, threads=1)
    tissue.push((-0.2, -1.0, -5.0), (4, 0, 0), sphere_radius_mm=4)
    with pliant.show(tissue, labels=airway, embed_in=(), threads=1) as page:
        assert answer(page.url)[1].endswith("frame-ancestors 'none'")
    with pytest.raises(pliant.Error, match="found one of springs"):
        pliant.show(pliant.make_springs(airway, threads=1, cell_mm=20))


@needs_program
def test_refusals_of_the_program_are_errors(tmp_path: pathlib.Path) -> None:
    with pytest.raises(pliant.Error, match="nothing.nrrd"):
        pliant.show(tmp_path / "nothing.nrrd")
    with pytest.raises(pliant.Error, match="--embed-in: expected http"):
        pliant.show(pliant.make_phantom("cube", (16, 16, 16)), embed_in=("nowhere",))


def test_names_the_program_that_is_missing(
    airway: pliant.Volume, monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path
) -> None:
    monkeypatch.setenv("PLIANT_PROGRAM", str(tmp_path / "absent"))
    with pytest.raises(pliant.Error, match="absent: expected a program"):
        pliant.show(airway)
    assert not list(pathlib.Path(os.environ.get("TMPDIR", "/tmp")).glob("pliant-show-*/scan.nrrd"))


@needs_program
def test_ends_with_the_interpreter() -> None:
    program = (
        "import pliant\n"
        "page = pliant.show(pliant.make_phantom('cube', (16, 16, 16)), threads=1)\n"
        "print(page.url, flush=True)"
    )
    command = [sys.executable, "-c", program]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    url = run.stdout.strip()
    assert url.startswith("http://")
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            answer(url)
        except urllib.error.URLError:
            return
        time.sleep(0.1)
    pytest.fail("the page is still served")


def test_prefers_the_environment_s_program(
    monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path
) -> None:
    monkeypatch.setenv("PLIANT_PROGRAM", "/somewhere/pliant")
    assert pliant.program() == pathlib.Path("/somewhere/pliant")
    monkeypatch.delenv("PLIANT_PROGRAM")
    monkeypatch.setenv("PATH", str(tmp_path))
    if not (pathlib.Path(pliant.__file__).parent / "bin" / "pliant").exists():
        with pytest.raises(pliant.Error, match="PLIANT_PROGRAM"):
            pliant.program()
        shutil.copy(sys.executable, tmp_path / "pliant")
        assert pliant.program() == tmp_path / "pliant"
