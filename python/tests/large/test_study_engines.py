# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Studies on Dask and MPI, and in Zarr and object stores, with processes that are killed."""

import concurrent.futures
import contextlib
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

import numpy
import pytest

import pliant
from pliant.study import Study
from pliant.study.__main__ import main

pytest.importorskip("distributed")  # before anything is made in other environments

SOLVE = """
import time

def solve(x, n=0, *, rng, sleep_s=0.0):
    time.sleep(sleep_s)
    return {"y": x * x + rng.normal(), "field": rng.normal(size=(5, 5))}

def scan_of(scan):
    import pliant
    return {"sum": int(pliant.read_volume(scan).array.sum())}

def grid(n, *, rng):
    import pliant
    values = rng.integers(-1000, 1000, (4, 5, 6)).astype("int16")
    field = pliant.Field(rng.normal(size=(4, 5, 6, 3)).astype("float32"), (1, 2, 3))
    return {"scan": pliant.Volume(values, (1, 2, 3), (4, 5, 6)), "field": field, "n": n}
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(p for p in sys.path if p))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "solve.py").write_text(SOLVE)
    return tmp_path


@pytest.fixture
def chance():
    seed = random.SystemRandom().randrange(2**32)
    print(f"seed {seed}")
    return random.Random(seed)


def study_of(count=60, sleep_s=0.05):
    parameters = {"x": [1, 2], "n": {"count": count // 2}, "sleep_s": [sleep_s]}
    return Study("engines", "solve.py:solve", parameters=parameters, seed=3)


def merged(out):
    return [(out / "merged" / name).read_bytes() for name in ("table.csv", "manifest.json")]


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Cluster:
    """A scheduler and its workers, which are started again when they are gone."""

    def __init__(self, folder, workers=2):
        self.port, self.folder, self.count = free_port(), folder, workers
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.processes = {}
        self.is_kept, self.keeper = True, threading.Thread(target=self._keep)
        self._start()
        self.keeper.start()
        self.wait()

    def wait(self):
        """Until there is a scheduler."""
        for _ in range(600):
            with contextlib.suppress(OSError):
                socket.create_connection(("127.0.0.1", self.port), 1).close()
                return
            time.sleep(0.1)

    def _program(self, name, *words, cache="cache"):
        environment = {**os.environ, "PLIANT_STUDY_CACHE": str(self.folder / cache)}
        log = (self.folder / f"{name}.log").open("a")
        return subprocess.Popen(
            [sys.executable, "-m", *words], stdout=log, stderr=log, env=environment
        )

    def _start(self):
        scheduler = ("--port", str(self.port), "--dashboard-address", ":0")
        worker = (self.address, "--nthreads", "1", "--no-dashboard", "--no-nanny")
        for n in range(-1, self.count):
            process = self.processes.get(n)
            if process is None or process.poll() is not None:
                words = ("distributed.cli.dask_worker", *worker)
                if n < 0:
                    words = ("distributed.cli.dask_scheduler", *scheduler)
                self.processes[n] = self._program(f"dask{n}", *words)

    def _keep(self):
        while self.is_kept:
            self._start()
            time.sleep(0.3)

    def kill(self, n):
        self.processes[n].kill()

    def close(self):
        self.is_kept = False
        self.keeper.join()
        for process in self.processes.values():
            process.kill()
            process.wait()


def test_dask_makes_the_same_bytes_while_processes_are_killed(place, chance):
    study = study_of(200, 0.1)  # 10 s of the two workers: the scheduler is killed within 4 s
    study.run(place / "quiet")
    cluster = Cluster(place)
    kills = []

    def disturb():
        while len(kills) < 12 and not stop.wait(chance.uniform(0.5, 2)):
            victim = -1 if len(kills) == 1 else chance.randrange(2)
            with contextlib.suppress(OSError):
                cluster.kill(victim)
                kills.append(victim)

    stop, killer = threading.Event(), threading.Thread(target=disturb)
    try:
        killer.start()
        engine = f"dask://127.0.0.1:{cluster.port}"
        for _ in range(3):  # an item may be lost five times by chance
            cluster.wait()
            report = study.run(place / "dask", engine, retry_failed=True)
            if report.is_complete:
                break
    finally:
        stop.set()
        killer.join()
        cluster.close()
    assert report.is_complete, report
    assert -1 in kills
    assert study.merge(place / "dask") == study.merge(place / "quiet")
    assert merged(place / "dask") == merged(place / "quiet")


def test_dask_sends_files_once_to_machines_that_lack_them(place):
    """The worker has a cache of its own, and doesn't see the folder of the scan."""
    hidden = place / "hidden"
    hidden.mkdir()
    pliant.make_phantom("airway", (32, 32, 32)).save(hidden / "a.nrrd")
    if shutil.which("unshare") is None or os.geteuid():
        pytest.skip("needs the right to hide a folder")
    study = Study("far", "solve.py:scan_of", parameters={"scan": {"scans": "hidden/*.nrrd"}})
    port = free_port()
    environment = {**os.environ, "PLIANT_STUDY_CACHE": str(place / "far")}
    log = (place / "dask.log").open("w")
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", str(port)]
        + ["--dashboard-address", ":0"],
        stdout=log,
        stderr=log,
    )
    hide = f"mount -t tmpfs none {hidden} && exec {sys.executable} -m distributed.cli.dask_worker "
    worker = subprocess.Popen(
        ["unshare", "-m", "sh", "-c"]
        + [hide + f"tcp://127.0.0.1:{port} --nthreads 1 --no-dashboard --no-nanny"],
        stdout=log,
        stderr=log,
        env=environment,
    )
    try:
        report = study.run(place / "out", f"dask://127.0.0.1:{port}")
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
    if "Operation not permitted" in (place / "dask.log").read_text():
        pytest.skip("needs the right to hide a folder")
    assert report.is_complete, report
    study.run(place / "near")
    assert study.merge(place / "out") == study.merge(place / "near")
    assert len(list((place / "far" / "files").iterdir())) == 1


def test_a_missing_scheduler_is_told_in_one_line(place):
    with pytest.raises(pliant.Error, match="expected a Dask scheduler at tcp://127.0.0.1:1, found"):
        study_of().run(place / "out", "dask://127.0.0.1:1")


def mpirun(*words):
    pytest.importorskip("mpi4py")
    if shutil.which("mpirun") is None:
        pytest.skip("mpirun is not installed")
    root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.Popen(
        ["mpirun", "--oversubscribe", "-n", "3", sys.executable, "-m", "pliant.study", *words],
        env={**os.environ, **root},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_mpi_makes_the_same_bytes_and_goes_on_after_a_kill(place, chance):
    (place / "engines.toml").write_text(
        "[study]\nseed = 3\n[parameters]\nx = [1, 2]\nn = {count = 30}\nsleep_s = [0.05]\n"
        "[run]\nwhat = 'python'\nfunction = 'solve.py:solve'\n"
    )
    study = study_of()
    study.run(place / "quiet")
    words = ("run", "engines.toml", "--engine", "mpi", "--out", "mpi")
    first = mpirun(*words)
    time.sleep(chance.uniform(1.5, 2.5))
    ranks = subprocess.run(
        ["pgrep", "-P", str(first.pid)], capture_output=True, text=True, check=False
    ).stdout.split()
    with contextlib.suppress(ProcessLookupError):
        os.kill(int(chance.choice(ranks)), signal.SIGKILL)
    first.communicate(timeout=50)
    again = mpirun(*words)
    told, errors = again.communicate(timeout=50)
    assert again.returncode == 0, told + errors
    assert "60 items done" in told
    assert study.merge(place / "mpi") == study.merge(place / "quiet")
    wrong = mpirun("run", "none.toml", "--engine", "mpi")
    _, errors = wrong.communicate(timeout=50)
    assert wrong.returncode == 2
    assert errors.count("pliant study: none.toml: No such file") == 1


@pytest.fixture
def bucket(monkeypatch):
    """A bucket of a local server of S3's protocol."""
    pytest.importorskip("s3fs")
    server_module = pytest.importorskip("moto.server")
    server = server_module.ThreadedMotoServer("127.0.0.1", free_port(), verbose=False)
    server.start()
    for name, value in {
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{server._port}",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
        "AWS_DEFAULT_REGION": "us-east-1",
    }.items():
        monkeypatch.setenv(name, value)
    import s3fs

    s3fs.S3FileSystem.clear_instance_cache()
    name = f"bucket-{random.SystemRandom().randrange(2**32)}"
    s3fs.S3FileSystem().mkdir(name)
    yield f"s3://{name}"
    server.stop()


def test_an_object_store_holds_the_same_results(place, bucket):
    import s3fs

    study = study_of(20, 0.0)
    study.run(place / "quiet")
    out = f"{bucket}/studies/engines"
    assert study.run(out, workers=2).is_complete
    assert study.merge(out) == study.merge(place / "quiet")
    system = s3fs.S3FileSystem()
    system.invalidate_cache()
    assert system.cat_file(f"{out}/merged/table.csv") == merged(place / "quiet")[0]
    item = study.items[0].id
    there = f"{out}/items/{item[:2]}/{item}"
    local = place / "quiet" / "items" / item[:2] / item / "field.npy"
    assert system.cat_file(f"{there}/field.npy") == local.read_bytes()
    system.rm(f"{there}/manifest.json")  # as if the worker had been killed before the last file
    again = study.run(out, workers=2)
    assert (again.done, again.known) == (1, 19)
    assert study.merge(out) == study.merge(place / "quiet")
    assert study.report(out).startswith(f"{bucket}/studies/engines/report.html")
    assert not list((place / "cache" / "staging").iterdir())


def test_scans_of_an_object_store_are_copied_once(place, bucket):
    import s3fs

    pliant.make_phantom("airway", (24, 24, 24)).save(place / "a.nrrd")
    system = s3fs.S3FileSystem()
    system.put(str(place / "a.nrrd"), f"{bucket}/scans/a.nrrd")
    pattern = {"scan": {"scans": f"{bucket}/scans/*.nrrd"}}
    study = Study("scans", "solve.py:scan_of", parameters=pattern)
    assert study.run(place / "out", workers=2).is_complete
    near = Study("scans", "solve.py:scan_of", parameters={"scan": {"scans": "a.nrrd"}})
    assert [i.id for i in near.items] == [i.id for i in study.items]
    assert len(list((place / "cache" / "scans").iterdir())) == 1


@pytest.mark.parametrize("is_far", [False, True])
def test_a_zarr_store_holds_arrays(place, bucket, is_far, capsys):
    zarr = pytest.importorskip("zarr")
    study = Study("grid", "solve.py:grid", parameters={"n": {"count": 4}})
    study.run(place / "quiet")
    out = f"{bucket}/grid.zarr" if is_far else str(place / "grid.zarr")
    assert study.run(out, workers=2).is_complete
    assert study.merge(out) == study.merge(place / "quiet")
    item = study.items[0].id
    group = zarr.open_group(out, path=f"items/{item[:2]}/{item}", mode="r")
    folder = place / "quiet" / "items" / item[:2] / item
    scan, field = pliant.read_volume(folder / "scan.nrrd"), pliant.read_field(folder / "field.nrrd")
    assert (group["scan.nrrd"][...] == scan.array).all()
    assert group["scan.nrrd"].attrs["spacing_mm"] == [1, 2, 3]
    assert (group["field.nrrd"][...] == field.array).all()
    assert group["field.nrrd"].attrs["kind"] == "modeling"
    again = study.run(out)
    assert (again.done, again.known) == (0, 4)
    if not is_far:
        from pliant.study._zarr import ZarrStore

        read = place / "read.nrrd"
        read.write_bytes(ZarrStore(out).read(item, "scan.nrrd"))
        assert (pliant.read_volume(read).array == scan.array).all()
        assert numpy.allclose(pliant.read_volume(read).origin_mm, scan.origin_mm)
        (place / "grid.toml").write_text(
            "[parameters]\nn = {count = 4}\n[run]\nwhat = 'python'\nfunction = 'solve.py:grid'\n"
        )
        assert main(["merge", "grid.toml", "--out", out]) == 0
        named = capsys.readouterr().out.split(": ")[0]
        assert pathlib.Path(named) == pathlib.Path(f"{out}.study/merged/table.csv")
        assert pathlib.Path(named).exists()


def cut(system, manifest, part):
    system.pipe_file(manifest, system.cat_file(manifest)[:50])


def lose(system, manifest, part):
    system.rm(part)


def change(system, manifest, part):
    data = bytearray(system.cat_file(part))
    data[-1] ^= 1
    system.pipe_file(part, bytes(data))


@pytest.mark.parametrize("kind", ["grid", "grid.zarr", "near"])
def test_damaged_items_of_other_stores_are_set_aside_and_repeated(place, bucket, kind):
    fsspec = pytest.importorskip("fsspec")
    pytest.importorskip("zarr")
    study = Study("grid", "solve.py:grid", parameters={"n": {"count": 3}})
    out = str(place / "near.zarr") if kind == "near" else f"{bucket}/{kind}"
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        study.run(place / "quiet", threads)
        assert study.run(out, threads).is_complete
        expected = study.merge(place / "quiet")
        assert study.merge(out) == expected
        system, root = fsspec.core.url_to_fs(out)
        beside = root if kind == "grid" else f"{root}.study"
        item = study.items[1].id
        there = f"items/{item[:2]}/{item}"
        for damage in (cut, lose, change):
            system.invalidate_cache()
            named = [p for p in system.find(f"{root}/{there}") if f"{item}/scan.nrrd" in p]
            part = next(p for p in named if kind == "grid" or "/c/" in p)
            damage(system, f"{beside}/{there}/manifest.json", part)
            assert list(study.verify(out).damaged) == [item], damage
            assert list(study.status(out).damaged) == [item], "the log knows"
            report = study.run(out, threads)
            assert report.done == 1
            (aside,) = report.damaged.values()
            system.invalidate_cache()
            assert system.find(aside), aside
            assert study.verify(out).damaged == {}
            assert study.merge(out) == expected
