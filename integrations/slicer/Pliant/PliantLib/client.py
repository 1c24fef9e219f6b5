# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A client of `pliant serve`, protocol 2, with Python's standard library and NumPy.

Slicer's Python wraps no QWebSocket, and a package from a registry would be installed before the
first push. The protocol needs little of a WebSocket: text out, text and binary in, pings.

A thread reads. It writes boxes into the client's own copy of the voxels (half floats, as sent),
merges them into one changed box, and acknowledges at once, so that a busy user interface neither
stalls the server nor lets a queue grow. The user interface takes the merged box when it can.
Slicer's main thread may keep Python's lock while it runs no Python: let_read() hands it over.
"""

import base64
import hashlib
import http.client
import json
import os
import select
import socket
import struct
import threading
import time
import urllib.parse

import numpy

PROTOCOL = 2
MAX_MESSAGE_BYTES = 16 << 20
CONNECT_S = 30.0
SAVE_S = 600.0


class PliantError(Exception):
    """One line for the user."""


class ConnectionEnded(PliantError):
    """The connection to the server has ended."""


class WebSocket:
    """One connection of RFC 6455. One thread receives; any thread sends."""

    def __init__(self, host, port, path, timeout_s=CONNECT_S):
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except OSError as error:
            raise ConnectionEnded(f"{host}:{port}: no connection: {error}") from error
        self._sending = threading.Lock()
        try:
            self._shake_hands(host, port, path)
        except BaseException:
            self._socket.close()
            raise

    def _shake_hands(self, host, port, path):
        key = base64.b64encode(os.urandom(16)).decode()
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.sendall(
                f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
                f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                "Sec-WebSocket-Version: 13\r\n\r\n".encode()
            )
            self._stream = self._socket.makefile("rb", 1 << 16)
            status = self._stream.readline(4096).decode("latin-1").split(" ", 2)
            fields = {}
            for line in iter(lambda: self._stream.readline(4096).strip(), b""):
                name, _, value = line.decode("latin-1").partition(":")
                fields[name.strip().lower()] = value.strip()
        except OSError as error:
            raise ConnectionEnded(f"{host}:{port}: no answer: {error}") from error
        if len(status) < 2 or status[1] != "101":
            found = " ".join(status[1:]).strip() or "no answer"
            raise ConnectionEnded(f"{host}:{port}: expected a WebSocket, found {found}")
        magic = key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
        accept = base64.b64encode(hashlib.sha1(magic.encode()).digest()).decode()
        if fields.get("sec-websocket-accept") != accept:
            raise ConnectionEnded(f"{host}:{port}: expected a WebSocket, found another answer")
        self._socket.settimeout(None)

    def send(self, payload, opcode=1):
        """Sends one message (bytes). Raises ConnectionEnded."""
        mask = os.urandom(4)
        size = len(payload)
        if size < 126:
            head = struct.pack("!BB", 0x80 | opcode, 0x80 | size)
        elif size < 1 << 16:
            head = struct.pack("!BBH", 0x80 | opcode, 0x80 | 126, size)
        else:
            head = struct.pack("!BBQ", 0x80 | opcode, 0x80 | 127, size)
        masked = bytes(byte ^ mask[i & 3] for i, byte in enumerate(payload))
        try:
            with self._sending:
                self._socket.sendall(head + mask + masked)
        except OSError as error:
            raise ConnectionEnded(f"the connection has ended: {error}") from error

    def _read(self, size):
        try:
            data = self._stream.read(size)
        except (OSError, ValueError) as error:
            raise ConnectionEnded(f"the connection has ended: {error}") from error
        if data is None or len(data) < size:
            raise ConnectionEnded("the connection has ended")
        return data

    def receive(self):
        """The next text (str) or binary (bytes) message. Raises ConnectionEnded."""
        parts, kind, total = [], 0, 0
        while True:
            first, second = self._read(2)
            size = second & 0x7F
            if size == 126:
                (size,) = struct.unpack("!H", self._read(2))
            elif size == 127:
                (size,) = struct.unpack("!Q", self._read(8))
            total += size
            if second & 0x80 or total > MAX_MESSAGE_BYTES:
                raise ConnectionEnded("expected a message of the protocol, found another one")
            data = self._read(size)
            opcode = first & 0x0F
            if opcode == 8:
                code = struct.unpack("!H", data[:2])[0] if len(data) >= 2 else 1005
                reason = data[2:].decode("utf-8", "replace")
                raise ConnectionEnded(f"the server has ended the connection: {code} {reason}")
            if opcode == 9:
                self.send(data, 10)
            elif opcode in (0, 1, 2):
                parts.append(data)
                kind = opcode or kind
                if first & 0x80:
                    whole = b"".join(parts)
                    return whole.decode("utf-8", "replace") if kind == 1 else whole

    def has_more(self):
        """Whether bytes wait in the socket."""
        try:
            return bool(select.select([self._socket], [], [], 0)[0])
        except (OSError, ValueError):
            return False

    def close(self):
        """Ends the connection; a receiver in another thread gets ConnectionEnded."""
        try:
            self.send(struct.pack("!H", 1000), 8)
        except ConnectionEnded:
            pass
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()


def _union(a, b):
    """The smallest box that holds both; a box is (first, end), in i, j, k."""
    if a is None:
        return b
    return (
        tuple(min(p, q) for p, q in zip(a[0], b[0])),
        tuple(max(p, q) for p, q in zip(a[1], b[1])),
    )


class Client:
    """A connection in role `control`: voxels, state, answers.

    Attributes:
        volume: `volume` of `welcome`.
        voxels, rest: The newest half floats (k, j, i), and those of the scan at rest.
        state: The newest state.
        ended: Reason why the connection has ended, or None.
    """

    def __init__(self, link, name="3D Slicer"):
        """Connects to a link with #token=, and waits for the scan. Raises PliantError."""
        parts = urllib.parse.urlsplit(link)
        token = urllib.parse.parse_qs(parts.fragment).get("token", [""])[0]
        self._address = (parts.hostname, parts.port or 80)
        self._query = "token=" + urllib.parse.quote(token)
        self._socket = WebSocket(*self._address, "/ws?" + self._query)
        self._changed = threading.Condition()
        self._closing = False
        self._pending = self._dirty = None
        self._answers, self._events, self._last_id = {}, [], 0
        self.voxels, self.rest, self.volume, self.state, self.step = None, None, {}, {}, 0
        self.ended = None
        self._post({"do": "hello", "protocol": PROTOCOL, "role": "control", "name": name})
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        with self._changed:
            self._changed.wait_for(lambda: self.rest is not None or self.ended, SAVE_S)
        if self.rest is None:
            reason = self.ended or f"the scan has not come within {SAVE_S:.0f} s"
            self.close()
            raise PliantError(reason)

    def _post(self, message):
        self._socket.send(json.dumps(message).encode())

    def send(self, do, **fields):
        """Posts a command; its number, which the answer has. Raises ConnectionEnded."""
        if self.ended:
            raise ConnectionEnded(self.ended)
        with self._changed:
            self._last_id += 1
            number = self._last_id
        self._post({"do": do, "id": number, **fields})
        return number

    def wait_for(self, number, timeout_s=CONNECT_S):
        """The answer (`done`, `error`, …) to a command. Raises PliantError."""
        with self._changed:
            self._changed.wait_for(lambda: number in self._answers or self.ended, timeout_s)
            if number not in self._answers:
                raise PliantError(self.ended or f"no answer within {timeout_s:.0f} s")
            return self._answers[number]

    def let_read(self, max_s=0.015):
        """Lets the reading thread work: a millisecond, and on while there is something to read."""
        end = time.monotonic() + max_s
        while not self.ended:
            with self._changed:
                self._changed.wait(0.001)  # the thread may have read, and wait for the lock
            if not self._socket.has_more() or time.monotonic() > end:
                break

    def take_answers(self):
        """Answers since the last call, in order of arrival."""
        with self._changed:
            events, self._events = self._events, []
            return events

    def take_changes(self):
        """The box that has changed since the last call, as slices k, j, i, and its half floats.

        None if there is none.
        """
        with self._changed:
            box, self._dirty = self._dirty, None
            if box is None:
                return None
            where = tuple(slice(box[0][a], box[1][a]) for a in (2, 1, 0))
            return where, self.voxels[where].copy()

    def save(self, name):
        """A file of the protocol's `Saving`, such as `volume.nrrd`. Raises PliantError."""
        connection = http.client.HTTPConnection(*self._address, timeout=SAVE_S)
        try:
            connection.request("GET", f"/save/{name}?{self._query}")
            answer = connection.getresponse()
            data = answer.read()
        except (OSError, http.client.HTTPException) as error:
            raise PliantError(f"{name}: not saved: {error or 'the server has ended'}") from error
        finally:
            connection.close()
        if answer.status != 200:
            text = data.decode("utf-8", "replace").strip() or answer.reason
            raise PliantError(f"{name}: not saved: {answer.status} {text}")
        return data

    def close(self):
        """Ends the connection; a second time does nothing."""
        self._closing = True
        self._socket.close()
        self._thread.join(10)

    def _run(self):
        try:
            while True:
                message = self._socket.receive()
                if isinstance(message, str):
                    self._take_text(json.loads(message))
                elif message[:4] == b"PLNT" and message[4] == 1:
                    self._take_box(message)
        except PliantError as error:
            reason = str(error)
        except Exception as error:  # a message that is none of the protocol
            reason = f"expected a message of the protocol, found another one: {error}"
            self._socket.close()
        with self._changed:
            self.ended = "closed" if self._closing else (self.ended or reason)
            self._changed.notify_all()

    def _take_text(self, message):
        kind = message.get("t")
        with self._changed:
            if kind == "welcome":
                self.volume, self.state = message["volume"], message["state"]
                self.voxels = numpy.zeros(self.volume["size"][::-1], numpy.float16)
            elif kind == "volume":
                raise ConnectionEnded("another scan was opened in the page")
            elif kind == "state":
                self.state = message
            elif kind == "bye":
                self.ended = "the server has ended the connection: " + message.get("message", "")
            elif message.get("id"):
                self._answers = {message["id"]: message, **dict(list(self._answers.items())[:99])}
                self._events.append(message)
            self._changed.notify_all()

    def _take_box(self, message):
        flags, form, step = struct.unpack_from("<BHI", message, 5)
        first, size = struct.unpack_from("<3H", message, 16), struct.unpack_from("<3H", message, 22)
        if form != 1 or flags & 1:
            return  # not asked for
        end = tuple(a + n for a, n in zip(first, size))
        box = numpy.frombuffer(message, "<f2", offset=32).reshape(size[::-1])
        if any(e > n for e, n in zip(end, self.volume["size"])):
            raise ConnectionEnded("expected a box within the scan, found another one")
        where = tuple(slice(first[a], end[a]) for a in (2, 1, 0))
        with self._changed:
            self.voxels[where] = box
            self._pending = _union(self._pending, (first, end))
            if flags & 2:
                # A new server's scan is at rest, and its first link is this client's.
                if self.rest is None:
                    self.rest = self.voxels.copy()
                else:
                    self._dirty = _union(self._dirty, self._pending)
                self._pending, self.step = None, step
                self._changed.notify_all()
        if flags & 2:
            self._post({"do": "seen", "step": step})
