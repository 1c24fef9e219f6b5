# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The page: in a notebook, or in a browser beside a program."""

from __future__ import annotations

import os
import queue
import re
import subprocess
import tempfile
import threading
import weakref
from typing import Any

from pliant._core import Tissue, Volume
from pliant._error import Error
from pliant._program import program

_START_S = 60.0


def _end(server: subprocess.Popen[str], folder: tempfile.TemporaryDirectory[str]) -> None:
    server.terminate()
    try:
        server.wait(10)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()
    folder.cleanup()


class Page:
    """A page that shows a scan; ends with close(), with its `with` block or with the interpreter.

    In a notebook it shows itself.

    Attributes:
        url: Link for a browser. It contains a secret: who has it can change the scene.
        view_url: Link for watching only.
    """

    def __init__(self, arguments: list[str], folder: tempfile.TemporaryDirectory[str]) -> None:
        command = [str(program()), "serve", *arguments, "--no-open"]
        try:
            # A Ctrl-C in the terminal is for the interpreter.
            server = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        except OSError as error:
            raise Error(f"{command[0]}: expected a program, found {error}", "not_found") from error
        self._server = server
        self._end = weakref.finalize(self, _end, server, folder)
        self._errors: list[str | None] = []
        lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=_pass_on, args=(server.stdout, lines.put), daemon=True).start()
        self._listener = threading.Thread(
            target=_pass_on, args=(server.stderr, self._errors.append), daemon=True
        )
        self._listener.start()
        self.url = self._link(lines, "Open")
        self.view_url = self._link(lines, "View")

    def _link(self, lines: queue.Queue[str | None], name: str) -> str:
        while True:
            try:
                line = lines.get(timeout=_START_S)
            except queue.Empty:
                line = None
            if line is None:
                self.close()
                self._listener.join(_START_S)
                text = "".join(e for e in self._errors if e).strip()
                raise Error(text or f"pliant serve: expected a link in {_START_S:.0f} s")
            found = re.match(rf"{name}\s+(\S+)", line)
            if found:
                return found[1]

    def close(self) -> None:
        """Ends the server and the page; a second time does nothing."""
        self._end()

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Page({self.url})" if self._end.alive else "Page(closed)"

    def _repr_html_(self) -> str:
        if not self._end.alive:
            return "<p>This page was closed.</p>"
        return (
            f'<iframe src="{self.url}" width="100%" height="720" style="border:0" '
            'allow="fullscreen"></iframe>'
        )


def _pass_on(stream: Any, take: Any) -> None:
    for line in stream:
        take(line)
    take(None)


def show(
    scan: Volume | Tissue | str | os.PathLike[str],
    *,
    labels: Volume | str | os.PathLike[str] | None = None,
    embed_in: tuple[str, ...] = ("http://localhost:*", "http://127.0.0.1:*"),
    threads: int = 0,
) -> Page:
    """Shows a scan in the page: push it, cut it, fly through it.

    It is a copy: the page's changes stay there, unless they are saved there.

    Args:
        scan: A scan, a tissue of make_chainmail in its present state, or a file or folder of
            `pliant serve`, which may be a scene.
        labels: Label map on the scan's grid.
        embed_in: Origins of notebooks that may show the page in a frame.
        threads: 0: one for each core.

    Raises:
        pliant.Error: The program isn't there, or doesn't take the scan; its own line.
    """
    folder = tempfile.TemporaryDirectory(prefix="pliant-show-")

    def name_of(item: Volume | str | os.PathLike[str], name: str) -> str:
        if not isinstance(item, Volume):
            return os.fspath(item)
        path = os.path.join(folder.name, name)
        item.save(path)
        return path

    try:
        arguments = []
        if isinstance(scan, Tissue):
            if scan.model != "chainmail":
                raise Error(
                    f"scan: expected a Volume, a file, or a tissue of make_chainmail, found one of "
                    f"{scan.model}",
                    "unsupported",
                )
            state = os.path.join(folder.name, "state.plst")
            scan.save_state(state)
            arguments += ["--load-state", state]
        rest = scan.scan if isinstance(scan, Tissue) else scan
        arguments += [name_of(rest, "scan.nrrd"), "--port", "0", "--threads", str(threads)]
        if labels is not None:
            arguments += ["--labels", name_of(labels, "labels.nrrd")]
        for origin in embed_in:
            arguments += ["--embed-in", origin]
        return Page(arguments, folder)
    except BaseException:
        folder.cleanup()
        raise
