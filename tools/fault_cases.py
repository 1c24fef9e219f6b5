# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The commands of tools/faults, their small inputs, and the clients of its server."""

import contextlib
import dataclasses
import http.client
import itertools
import json
import re
import signal
import socket
import struct
import subprocess
import time
from pathlib import Path

_PATIENCE_S = 20
_PUSH = "--push=-5,0,0:2,0,0 --tool sphere:4 --threads 2"
_PRESS = """
def press(x, *, folder):
    (folder / "made.txt").write_text(str(x))
    return {"y": x * x}
"""
_STUDY = """
[parameters]
x = [1, 2]
[run]
what = "python"
function = "press.py:press"
"""
_VESSEL = """
[vessel]
phantom = "bend"
layers = 1
[catheter]
length_mm = 100
[entry]
place_mm = [0, 0, 5]
direction = [0, 0, 1]
[[script]]
insert_mm_s = 400
until_inserted_mm = 2
"""
_PYTHON = """
import sys
import pliant
try:
    scan = pliant.read_volume("g.nrrd")
    tissue = pliant.make_chainmail(scan, threads=2)
    tissue.push((-5, 0, 0), (2, 0, 0), sphere_radius_mm=4)
    tissue.volume().save("o.nrrd")
    tissue.displacement_field().save("d.nii.gz")
    tissue.save_state("p.plst")
    tissue.load_state("p.plst")
except pliant.Error as error:
    print(f"pliant: {error}", file=sys.stderr)
    sys.exit(2)
"""


@dataclasses.dataclass
class Case:
    """A command; its outputs, which are there before."""
    command: str
    line: str
    outputs: tuple[str, ...] = ()
    places: tuple[str, ...] = ("work",)  # folders that a message may name for their contents
    writes_to: str = "."
    results: tuple[str, ...] = ()  # files that next_words make
    next_words: object = None  # commands that follow: (given) -> lists of words
    refusals: tuple[int, ...] = (2,)
    is_step_by_step: bool = False
    is_repeated: bool = False  # its client tells, and the replay shows that nothing was lost
    varies: tuple[str, ...] = ()  # beginnings of names of files that differ in each run
    expected: dict = dataclasses.field(default_factory=dict)

    def __str__(self):
        return f"{self.command}: {self.line}"

    def words(self, given) -> list[str]:
        if self.command == "python":
            return [str(given.python), "-c", _PYTHON]
        if self.command == "study":
            return [str(given.python), "-m", "pliant", *self.line.split()]
        return [str(given.program), *self.line.split()]

    def stands_for(self, path: str) -> set[str]:
        """Names of folders that a message may have in place of a file in them."""
        return {name for name in ("d", "cache") if f"/{name}/" in path}


def _go_on_with_study(given):
    return [[given.python, "-m", "pliant", "study", "run", "press.toml", "--retry-failed"],
            [given.python, "-m", "pliant", "study", "merge", "press.toml"]]


def _merge_study(given):
    return [[given.python, "-m", "pliant", "study", "merge", "done.toml"]]


CASES = [
    Case("info", "info a.nrrd"),
    Case("info", "info n.nii.gz --json"),
    Case("info", "info d"),
    Case("convert", "convert a.nrrd o.nhdr", ("o.nhdr", "o.raw.gz")),
    Case("convert", "convert d o.nii.gz", ("o.nii.gz",)),
    Case("convert", "convert n.nii.gz o.mha", ("o.mha",)),
    Case("convert", "convert g.nrrd o.vti", ("o.vti",)),
    Case("deform", f"deform a.nrrd --config c.toml {_PUSH} --out o.nrrd --displacement d.nrrd "
         "--transform t.nrrd --jacobian j.nrrd --save-state p.plst --png v.png",
         ("o.nrrd", "d.nrrd", "t.nrrd", "j.nrrd", "p.plst", "v.png")),
    Case("deform", f"deform a.nrrd {_PUSH} --out x/o.nhdr --displacement y/d.nrrd",
         ("x/o.nhdr", "x/o.raw.gz", "y/d.nrrd"), ("work", "x", "y")),
    Case("truth", "truth make a.nrrd --cases 1 --motions 1 --landmarks 10 --threads 2 --out tr",
         places=("work", "tr"), writes_to="tr"),
    Case("truth", "truth score t --field f=t/{case}/forward.nrrd --csv s.csv", ("s.csv",),
         ("work", "t")),
    Case("study", "study run press.toml --workers 1", refusals=(1, 2),
         varies=("press-results/", "home/", "tmp/"), results=("press-results/merged/table.csv",),
         next_words=_go_on_with_study),
    Case("study", "study merge done.toml", places=("work", "done-results", "merged"),
         varies=("done-results/", "home/", "tmp/"), results=("done-results/merged/table.csv",),
         next_words=_merge_study),
    Case("fit", "fit --mesh block.vtk --young 9000 --method closed-form --hold=-1,-1,-1:21,21,1 "
         "--load=9,9,19:21,21,21:0,0,-0.4 --threads 1 --network-out n.json --out f.vtu",
         ("n.json", "f.vtu")),
    Case("vessel", "vessel v.toml --csv m.csv --frames f --every 5 --record h.log",
         ("m.csv", "h.log"), ("work", "f")),
    Case("serve", "serve a.nrrd --model chainmail --session s.pls --no-open --port 0 --threads 2",
         places=("work", "tmp", "s.pls", "127.0.0.1", "--port"), varies=("s.pls",),
         is_repeated=True),
    Case("python", "a script: read_volume, make_chainmail, push, save",
         ("o.nrrd", "d.nii.gz", "p.plst"), is_step_by_step=True),
]


def _slice(number: int) -> bytes:
    """A DICOM file, explicit little-endian."""
    def element(group, item, kind, value):
        value = value.encode() if isinstance(value, str) else value
        value += (b"\0" if kind in ("UI", "OW", "OB") else b" ") * (len(value) % 2)
        long = kind in ("OW", "OB")
        return struct.pack("<HH2s", group, item, kind.encode()) + struct.pack(
            "<HI" if long else "<H", *([0] if long else []), len(value)) + value
    kind, syntax = "1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.1.2.1"
    meta = element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", kind) + element(
        2, 3, "UI", f"1.2.3.{number}") + element(2, 16, "UI", syntax) + element(2, 18, "UI", "1.2")
    short = struct.Struct("<H").pack
    data = b"".join(itertools.starmap(element, [
        (8, 0x16, "UI", kind), (8, 0x18, "UI", f"1.2.3.{number}"), (8, 0x60, "CS", "CT"),
        (0x20, 0xd, "UI", "1.2.4"), (0x20, 0xe, "UI", "1.2.3"), (0x20, 0x13, "IS", str(number)),
        (0x20, 0x32, "DS", f"0\\0\\{number}"), (0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"),
        (0x20, 0x52, "UI", "1.2.5"), (0x28, 2, "US", short(1)), (0x28, 4, "CS", "MONOCHROME2"),
        (0x28, 0x10, "US", short(4)), (0x28, 0x11, "US", short(4)), (0x28, 0x30, "DS", "1\\1"),
        (0x28, 0x100, "US", short(16)), (0x28, 0x101, "US", short(16)),
        (0x28, 0x102, "US", short(15)), (0x28, 0x103, "US", short(1)),
        (0x28, 0x1052, "DS", "-1000"), (0x28, 0x1053, "DS", "1"),
        (0x7fe0, 0x10, "OW", struct.pack("<16h", *range(16)))]))
    return bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + data


def _block() -> str:
    """27 nodes and 40 tetrahedra, as legacy VTK: eight cubes of five, mirrored in turn."""
    def node(i, j, k):
        return i + 3 * (j + 3 * k)
    cells = []
    for i, j, k in itertools.product(range(2), repeat=3):
        odd = (i + j + k) % 2
        corner = [node(i + ((n & 1) ^ odd), j + (n >> 1 & 1), k + (n >> 2)) for n in range(8)]
        for a, b, c, d in ((0, 1, 2, 4), (3, 2, 1, 7), (5, 1, 4, 7), (6, 4, 2, 7), (1, 2, 4, 7)):
            c, d = (d, c) if odd else (c, d)
            cells.append([corner[n] for n in (a, b, c, d)])
    points = [f"{10 * i} {10 * j} {10 * k}" for k, j, i in itertools.product(range(3), repeat=3)]
    return "\n".join(["# vtk DataFile Version 3.0", "block", "ASCII", "DATASET UNSTRUCTURED_GRID",
                      "POINTS 27 float", *points, f"CELLS {len(cells)} {5 * len(cells)}",
                      *("4 " + " ".join(map(str, cell)) for cell in cells),
                      f"CELL_TYPES {len(cells)}", *["10"] * len(cells), ""])


def make_inputs(folder: Path, given, environment):
    """Scans, settings, scenes, and the outputs of earlier runs."""
    for name in ("d", "x", "y", "tmp", "home"):
        (folder / name).mkdir(parents=True)
    texts = {"c.toml": "[air]\nenabled = false\n", "v.toml": _VESSEL, "block.vtk": _block(),
             "press.py": _PRESS, "press.toml": _STUDY, "done.toml": _STUDY}
    for name, text in texts.items():
        (folder / name).write_text(text)
    for n in range(4):
        (folder / f"d/{n}.dcm").write_bytes(_slice(n))
    lines = ["phantom airway --size 24 --out a.nrrd --raw", "convert a.nrrd g.nrrd",
             "convert a.nrrd n.nii.gz", "convert a.nrrd m.mhd"]
    if "truth" in given.commands:
        lines += ["truth make a.nrrd --cases 1 --motions 1 --landmarks 10 --out t"]
    words = [[given.program, *line.split()] for line in lines]
    if "study" in given.commands:
        words += [[given.python, "-m", "pliant", "study", "run", "done.toml", "--workers", "1"]]
    for line in words:
        subprocess.run(line, cwd=folder, check=True, capture_output=True, env=environment)
    for case in CASES:
        for name in case.outputs:
            (folder / name).write_text("old\n")


class Client:
    """A WebSocket of the server, which answers boxes as it must."""

    def __init__(self, port: int, token: str):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=_PATIENCE_S)
        self.bytes = b""
        self.socket.sendall((f"GET /ws?token={token} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
                             "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                             "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n"
                             "Sec-WebSocket-Version: 13\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.bytes:
            self._more()
        answer, self.bytes = self.bytes.split(b"\r\n\r\n", 1)
        if b" 101 " not in answer.splitlines()[0]:
            raise ConnectionError(answer.splitlines()[0].decode())

    def _more(self):
        some = self.socket.recv(1 << 16)
        if not some:
            raise ConnectionError("the server closed the connection")
        self.bytes += some

    def _take(self, count: int) -> bytes:
        while len(self.bytes) < count:
            self._more()
        taken, self.bytes = self.bytes[:count], self.bytes[count:]
        return taken

    def _send(self, kind: int, data: bytes):
        length = struct.pack("!B", 128 | len(data)) if len(data) < 126 else struct.pack(
            "!BH", 254, len(data))
        mask = b"\x12\x34\x56\x78"
        self.socket.sendall(bytes([128 | kind]) + length + mask + bytes(
            b ^ mask[n % 4] for n, b in enumerate(data)))

    def say(self, **message):
        self._send(1, json.dumps(message).encode())

    def read(self) -> dict:
        """The next text, or "box" after the last box of a step; answers both and pings."""
        while True:
            first, length = self._take(2)
            if length >= 126:
                length = struct.unpack("!H" if length == 126 else "!Q",
                                       self._take(2 if length == 126 else 8))[0]
            data = self._take(length)
            if first & 15 == 1:
                return json.loads(data)
            if first & 15 == 8:
                raise ConnectionError("the server said goodbye")
            if first & 15 == 9:
                self._send(10, data)
            if first & 15 == 2 and data[4] == 1 and data[5] & 2:
                self.say(do="seen", step=struct.unpack("<I", data[8:12])[0])
                return {"t": "box"}

    def wait_for(self, kind: str, number=None) -> dict:
        end = time.monotonic() + _PATIENCE_S
        while time.monotonic() < end:
            text = self.read()
            if text.get("t") == "error":
                raise ConnectionError(text["message"])
            if text.get("t") == kind and number in (None, text.get("id")):
                return text
        raise TimeoutError

    def push(self, number: int):
        self.say(do="push", id=number, point=[-5, 0, 0], push=[2, 0, 0], radius=4)
        self.wait_for("done", number)

    def close(self):
        self.socket.close()


def _ask(port: int, method: str, path: str, body=None) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=_PATIENCE_S)
    with contextlib.closing(connection):
        connection.request(method, path, body)
        answer = connection.getresponse()
        return answer.status, answer.read()


def _visit(port: int, token: str, scan: bytes | None):
    """Pushes; if there is a scan, opens it, pushes and saves. Returns the saved scan."""
    with contextlib.closing(Client(port, token)) as client:
        client.say(do="hello", protocol=2, role="control", name="client")
        client.wait_for("welcome")
        client.push(1)
        if scan is None:
            return None
        status, line = _ask(port, "POST", f"/open?token={token}&name=g.nrrd", scan)
        if status != 200:
            raise ConnectionError(f"{status}: {line.decode().strip()}")
        client.wait_for("volume")
        client.wait_for("box")
        client.push(2)
        status, saved = _ask(port, "GET", f"/save/volume.nrrd?token={token}")
        if status != 200:
            raise ConnectionError(f"{status}: {saved.decode().strip()}")
        return saved


def serve_and_visit(words, place: Path, environment):
    """Status, the saved scan, standard error, and a complaint."""
    out = place.parent / "out"
    with open(out, "w") as stdout, open(place.parent / "err", "w") as stderr:
        server = subprocess.Popen(words, cwd=place, env=environment, stdin=subprocess.DEVNULL,
                                  stdout=stdout, stderr=stderr)
    saved, complaint = b"", ""
    try:
        link, end = None, time.monotonic() + _PATIENCE_S
        while not link and server.poll() is None and time.monotonic() < end:
            link = re.search(r"Open  http://127.0.0.1:(\d+)/#token=(\w+)", out.read_text())
            time.sleep(0.01)
        if link:
            saved, complaint = _clients(int(link[1]), link[2], (place / "g.nrrd").read_bytes())
            server.send_signal(signal.SIGTERM)
        status = server.wait(_PATIENCE_S)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()
        status = None
    return status, saved, (place.parent / "err").read_text(), complaint


def _clients(port: int, token: str, scan: bytes) -> tuple[bytes, str]:
    """One that may meet the fault, and one that is served after it."""
    saved, why = None, []
    for _ in range(2):
        try:
            saved = _visit(port, token, scan)
            break
        except TimeoutError:
            return b"", "a client waits without an end"
        except (OSError, http.client.HTTPException) as error:
            why.append(str(error))
    if saved is None:
        return b"", f"no client is served: {'; '.join(why)}"
    for _ in range(1 if why else 2):  # the fault may still come
        try:
            _visit(port, token, None)
            return saved, ""
        except (OSError, http.client.HTTPException) as error:
            why.append(str(error))
    return saved, f"the next client isn't served: {'; '.join(why)}"
