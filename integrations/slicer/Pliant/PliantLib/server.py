# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The program `pliant`, as a process that serves one scan to this machine."""

import collections
import importlib.util
import os
import queue
import shutil
import subprocess
import threading
import time

from PliantLib.client import PliantError

START_S = 300.0


def find_program(setting="", search_path=None):
    """The program: that of the setting, else that of an installed wheel, else one of PATH.

    Raises PliantError where there is none.
    """
    if setting:
        return setting
    found = importlib.util.find_spec("pliant")
    for folder in (found.submodule_search_locations or [] if found else []):
        for name in ("pliant", "pliant.exe"):
            path = os.path.join(folder, "bin", name)
            if os.path.exists(path):
                return path
    path = shutil.which("pliant", path=search_path)
    if not path:
        raise PliantError(
            "The program pliant was not found: choose it under Program, or install a wheel."
        )
    return path


class Server:
    """`pliant serve FILE`, until stop(). `link` is the secret link of its page."""

    def __init__(self, program, arguments, environment=None, timeout_s=START_S):
        """Starts it. Raises PliantError with the program's own line if it has one."""
        command = [program, "serve", *arguments, "--port", "0", "--no-open"]
        try:
            self.process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=environment,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            reason = error.strerror or error
            raise PliantError(f"{program}: expected the program pliant: {reason}") from error
        self._errors = collections.deque(maxlen=20)
        lines = queue.Queue()
        out, self._listener = (
            threading.Thread(target=_pass_on, args=arguments, daemon=True)
            for arguments in ((self.process.stdout, lines.put), (self.process.stderr, self._hear))
        )
        out.start()
        self._listener.start()
        self.link = self._link(program, lines, time.monotonic() + timeout_s)

    def _hear(self, line):
        if line:
            self._errors.append(line)

    def _link(self, program, lines, end):
        while True:
            try:
                line = lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                line = None
            if line is None:
                status = self.stop()
                found = self.last_words() or f"exit status {status}"
                raise PliantError(f"{program}: expected pliant serve to start: {found}")
            words = line.split()
            if len(words) >= 2 and words[0] == "Open":
                self._errors.clear()  # of progress
                return words[1]

    def last_words(self):
        """The last line on standard error of an ended process, without its name; may be empty."""
        self._listener.join(2)
        line = self._errors[-1] if self._errors else ""
        return line[len("pliant: ") :] if line.startswith("pliant: ") else line

    def reason(self):
        """Why it has ended, or None while it runs."""
        try:
            status = self.process.wait(1)
        except subprocess.TimeoutExpired:
            return None
        how = f"by signal {-status}" if status < 0 else f"with status {status}"
        words = self.last_words()
        return f"pliant serve has ended {how}" + (f": {words}" if words else "")

    def stop(self):
        """Ends the process. The exit status."""
        if self.process.poll() is None:
            self.process.terminate()
        try:
            return self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


def _pass_on(stream, take):
    for line in stream:
        take(line.decode("utf-8", "replace").strip())
    take(None)
    stream.close()
