# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Cost of a study beside its items, and a check that killed processes change no byte of its table.

    python python/benchmarks/study.py                     # 10,000 small items; 100 of a second
    python python/benchmarks/study.py --items 500 --kills 10

Dask and MPI are left out where they aren't installed.
"""

import argparse
import contextlib
import importlib.util
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable

from pliant.study import LocalPool, Study

SOLVE = """
import time

def solve(n, *, rng, sleep_s=0.0):
    if sleep_s:
        time.sleep(sleep_s)
    return {"value": rng.normal(), "square": rng.normal() ** 2}
"""
ENVIRONMENT = {
    **os.environ,
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
}


def study_of(folder: pathlib.Path, count: int, sleep_s: float) -> Study:
    """A study of items that do nothing but wait."""
    path = folder / f"items{count}_{sleep_s}.toml"
    path.write_text(
        f"[study]\nname = 'items'\n[parameters]\nn = {{count = {count}}}\nsleep_s = [{sleep_s}]\n"
        "[run]\nwhat = 'python'\nfunction = 'solve.py:solve'\n"
    )
    return Study.load(path)


class Cluster:
    """Dask on this machine. Processes that end are started again."""

    def __init__(self, folder: pathlib.Path, workers: int) -> None:
        with socket.socket() as one:
            one.bind(("127.0.0.1", 0))
            self.port = one.getsockname()[1]
        self._folder, self._workers, self._is_kept = folder, workers, True
        self.processes: dict[int, subprocess.Popen[bytes]] = {}
        self._start()
        self._keeper = threading.Thread(target=self._keep)
        self._keeper.start()
        time.sleep(4)

    def _start(self) -> None:
        address, port = f"tcp://127.0.0.1:{self.port}", str(self.port)
        for n in range(-1, self._workers):
            process = self.processes.get(n)
            if process is None or process.poll() is not None:
                words = ["worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
                if n < 0:
                    words = ["scheduler", "--port", port, "--dashboard-address", ":0"]
                log = (self._folder / "dask.log").open("a")
                command = [sys.executable, "-m", f"distributed.cli.dask_{words[0]}", *words[1:]]
                self.processes[n] = subprocess.Popen(
                    command, stdout=log, stderr=log, env=ENVIRONMENT
                )

    def _keep(self) -> None:
        while self._is_kept:
            self._start()
            time.sleep(0.3)

    def close(self) -> None:
        """Ends all processes."""
        self._is_kept = False
        self._keeper.join()
        for process in self.processes.values():
            process.kill()
            process.wait()


def mpi_run(study: pathlib.Path, out: pathlib.Path, processes: int) -> None:
    """One rank gives out the items, the others work."""
    command = ["mpirun", "--oversubscribe", "-n", str(processes + 1), sys.executable]
    command += ["-m", "pliant.study", "run", str(study), "--engine", "mpi", "--out", str(out)]
    subprocess.run(command, check=True, env=ENVIRONMENT, stdout=subprocess.DEVNULL)


def timed(folder: pathlib.Path, study: Study, engine: str, processes: int) -> tuple[float, float]:
    """Seconds of a whole run, and from the first item's start to the last one's end."""
    out = folder / f"{engine}-{processes}-{len(study.items)}"
    shutil.rmtree(out, ignore_errors=True)
    cluster = Cluster(folder, processes) if engine == "dask" else None
    begun = time.monotonic()
    try:
        if engine == "mpi":
            (path,) = folder.glob(f"items{len(study.items)}_*.toml")
            mpi_run(path, out, processes)
        else:
            name = "local" if cluster is None else f"dask://127.0.0.1:{cluster.port}"
            assert study.run(out, name, workers=processes).is_complete
        whole = time.monotonic() - begun
    finally:
        if cluster is not None:
            cluster.close()
    from pliant.study._stores import open_store

    lines = [r for _, r in open_store(str(out)).logs() if r and r["status"] == "done"]
    first = min(r["started"] for r in lines)
    last = max(r["started"] + r["seconds"] for r in lines)
    merging = time.monotonic()
    found = study.merge(out)
    merging = time.monotonic() - merging
    print(f"#   {engine}, {processes}: table {found}, merged in {merging:.2f} s", flush=True)
    return whole, last - first


def kill_at_random(
    pids: Callable[[], list[int]],
    chance: random.Random,
    stop: threading.Event,
    most: int,
    killed: list[int],
) -> None:
    """Kills one of the processes now and then."""
    while len(killed) < most and not stop.wait(chance.uniform(0.05, 0.4)):
        if found := pids():
            victim = chance.choice(found)
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)


def disturbed(folder: pathlib.Path, study: Study, engine: str, kills: int, seed: int) -> None:
    """Runs a study while its processes are killed, and compares the tables."""
    study.run(folder / "quiet")
    expected = study.merge(folder / "quiet")
    stop, killed, chance = threading.Event(), list[int](), random.Random(seed)
    cluster = Cluster(folder, 2) if engine == "dask" else None
    pool = LocalPool(2)
    out = folder / f"killed-{engine}"
    shutil.rmtree(out, ignore_errors=True)

    def pids() -> list[int]:
        if cluster is None:
            return pool.pids
        # One kill of ten is the scheduler's.
        chosen = -1 if chance.random() < 0.1 else chance.choice([0, 1])
        return [cluster.processes[chosen].pid]

    killer = threading.Thread(target=kill_at_random, args=(pids, chance, stop, kills, killed))
    killer.start()
    runs, lost, begun = 0, 0, time.monotonic()
    try:
        while True:
            runs += 1
            name = pool if cluster is None else f"dask://127.0.0.1:{cluster.port}"
            report = study.run(out, name, retry_failed=True)
            lost += report.lost
            if report.is_complete:
                break
    finally:
        stop.set()
        killer.join()
        pool.shutdown()
        if cluster is not None:
            cluster.close()
    is_same = study.merge(out) == expected
    print(
        f"{engine}: {len(killed)} kills (seed {seed}), {lost} calls repeated, {runs} run(s), "
        f"{time.monotonic() - begun:.0f} s; the table is {'the same' if is_same else 'ANOTHER'}",
        flush=True,
    )
    assert is_same


def main() -> None:
    """Prints the tables of docs/howto/study.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--items", type=int, default=10_000, help="small items")
    parser.add_argument("--long", type=int, default=100, help="items of a second, for 4 processes")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--processes", default="1,2,4")
    parser.add_argument("--engines", default="local,dask,mpi")
    options = parser.parse_args()
    engines = options.engines.split(",")
    if importlib.util.find_spec("distributed") is None:
        engines = [e for e in engines if e != "dask"]
    if importlib.util.find_spec("mpi4py") is None or shutil.which("mpirun") is None:
        engines = [e for e in engines if e != "mpi"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "solve.py").write_text(SOLVE)
        small = study_of(folder, options.items, 0.0)
        begun = time.monotonic()
        assert len(study_of(folder, options.items, 0.0).items) == options.items
        print(f"plan of {options.items} items: {time.monotonic() - begun:.2f} s")
        print("| engine | processes | items | s | ms of a process for an item |")
        print("|---|---|---|---|---|")
        for engine in engines:
            for processes in map(int, options.processes.split(",")):
                whole, between = timed(folder, small, engine, processes)
                each = 1e3 * between * processes / options.items
                print(f"| {engine} | {processes} | {options.items} | {whole:.1f} | {each:.2f} |")
        if options.long:
            long = study_of(folder, options.long, 1.0)
            for engine in engines:
                whole, between = timed(folder, long, engine, 4)
                ideal = -(-options.long // 4)
                share = 100 * (between - ideal) / ideal
                count = f"{options.long} of 1 s"
                print(f"| {engine} | 4 | {count} | {whole:.1f} | {share:.2f} % more |")
        if options.kills:
            items = study_of(folder, 30 * options.kills, 0.01)
            for engine in engines:
                if engine != "mpi":  # a killed rank ends the whole job
                    seed = random.SystemRandom().randrange(2**32)
                    disturbed(folder, items, engine, options.kills, seed)


if __name__ == "__main__":
    main()
