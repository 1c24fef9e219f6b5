# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""PliantLib beside a real `pliant serve`: neither Slicer nor VTK."""

import ast
import contextlib
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

import numpy
import pytest
from PliantLib import logic
from PliantLib.client import ConnectionEnded, PliantError, WebSocket
from PliantLib.logic import FLIP, Session, TrackedTool
from PliantLib.server import Server, find_program
from scans import END, HERE, MODULE, RADIUS_MM, START, deform, program, scan, wait_until


@contextlib.contextmanager
def served(voxels, matrix, model="chainmail"):
    session = Session(program(), voxels, matrix, model)
    try:
        yield session
    finally:
        session.stop()


def show(session, voxels, target, step):
    """Updates target until it has the voxels of a step."""
    wait_until(lambda: session.client.step >= step)
    while session.update(voxels, target):
        pass


def run(session, number):
    answer = session.client.wait_for(number)
    assert answer["t"] == "done", answer
    return answer


def test_a_push_shows_what_pliant_deform_writes_and_undo_gives_the_original(tmp_path):
    voxels, matrix = scan()
    out, displacement, transform = deform(tmp_path, voxels, matrix)
    expected = logic.read_nrrd(out)[1]
    assert (expected != voxels).sum() > 500
    with served(voxels, matrix) as session:
        run(session, session.send("materials", limits="rounded"))  # as pliant deform's
        target = voxels.copy()
        assert not session.update(voxels, target)  # the scan itself is no change
        answer = run(session, session.push(START, END, RADIUS_MM))
        assert answer["moved_elements"] > 100
        show(session, voxels, target, answer["step"])
        assert numpy.array_equal(target, expected)  # values below 2048 are exact
        for saved, written in ("displacement", displacement), ("transform", transform):
            assert session.client.save(saved + ".nrrd") == written
        for do, voxels_then in ("undo", voxels), ("redo", expected), ("reset", voxels):
            show(session, voxels, target, run(session, session.send(do))["step"])
            assert numpy.array_equal(target, voxels_then), do


def test_changes_between_two_updates_are_shown_together():
    voxels, matrix = scan()
    with served(voxels, matrix) as session:
        target = voxels.copy()
        for ijk in (4, 5, 4), (25, 4, 21):
            start = matrix[:3, :3] @ ijk + matrix[:3, 3]
            answer = run(session, session.push(start, start + [1, 1, 0], 3.0))
            wait_until(lambda: session.client.step >= answer["step"])
        assert session.update(voxels, target) and not session.update(voxels, target)
        live = target.copy()
        session.exact(voxels, target)
        assert (target != voxels).any() and numpy.array_equal(live, target)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "int32", "float32", "float64"])
def test_values_that_are_no_halves_come_back_to_the_bit(dtype):
    voxels, matrix = scan("int16")
    voxels = ((voxels + 1000) / 8 if dtype == "uint8" else voxels + 5001).astype(dtype)
    if dtype.startswith("float"):
        voxels += voxels.dtype.type(0.1)
    with served(voxels, matrix) as session:
        run(session, session.send("materials", bone_threshold_hu=30000))
        target = voxels.copy()
        answer = run(session, session.push(START, END, RADIUS_MM))
        show(session, voxels, target, answer["step"])
        live = target.copy()
        session.exact(voxels, target)
        assert (live != voxels).any() and numpy.abs(live.astype(float) - target).max() <= 4.0
        show(session, voxels, target, run(session, session.send("undo"))["step"])
        assert target.tobytes() == voxels.tobytes()


def test_the_scan_is_handed_over_in_lps(tmp_path):
    voxels, matrix = scan()
    path = tmp_path / "scan.nrrd"
    logic.write_nrrd(path, voxels, matrix)
    info = json.loads(subprocess.check_output([program(), "info", "--json", path]))
    columns = matrix[:3, :3] * FLIP[:, None]
    assert numpy.allclose(numpy.array(info["direction"]) * info["spacing_mm"], columns)
    assert numpy.allclose(info["origin_mm"], matrix[:3, 3] * FLIP)
    assert info["size"] == [30, 28, 26] and info["min"] == voxels.min()


def test_a_cut_opens_and_a_line_of_one_point_is_refused():
    voxels, matrix = scan()
    with served(voxels, matrix) as session:
        along = matrix[:3, 0]
        points = [START + along * x for x in numpy.linspace(-4, 4, 3000)]
        answer = run(session, session.cut(points, matrix[:3, 2], 12.0))
        assert answer["cut_links"] > 10
        sent = []
        session.client.send = lambda do, **fields: sent.append(fields)
        session.cut(points[:2], 2 * matrix[:3, 2], 12.0)
        del session.client.send
        normal = matrix[:3, 2] / numpy.linalg.norm(matrix[:3, 2])
        assert numpy.allclose(sent[0]["depth"], 12.0 * normal * FLIP)
        middle = numpy.array(sent[0]["line"]) + numpy.array(sent[0]["depth"]) / 2
        assert numpy.allclose(middle, points[:2] * FLIP)
        with pytest.raises(PliantError, match="^cut: expected two points or more, found 1$"):
            session.cut(points[:1], matrix[:3, 2], 12.0)
        refused = session.client.wait_for(session.push(START, END, 4000))
        assert refused["code"] == "out_of_range" and refused["message"].endswith("found 4000")


def test_a_tracked_tool_is_one_step_of_undo():
    voxels, matrix = scan()
    with served(voxels, matrix) as session:
        target, seen = voxels.copy(), []
        tool = TrackedTool(session, RADIUS_MM, 1)

        def follow(position):
            tool.move(position)
            count = len(seen)
            wait_until(lambda: take() > count)

        def take():
            for answer in session.client.take_answers():
                seen.append(answer)
                tool.take(answer)
            return len(seen)

        into = matrix[:3, 1] / numpy.linalg.norm(matrix[:3, 1])
        hole = START + matrix[:3, :3] @ [1, 8, 0]
        tool.move(hole + 1e4)  # outside of the scan: nothing is sent
        tool.move(hole)
        for depth in range(1, 7):
            follow(hole - 2.0 * depth * into)
        tool.stop()
        assert [a["do"] for a in seen] == ["slide"] * 6 and all(a["t"] == "done" for a in seen)
        show(session, voxels, target, seen[-1]["step"])
        assert (target != voxels).sum() > 100
        answer = run(session, session.send("undo"))
        show(session, voxels, target, answer["step"])
        assert numpy.array_equal(target, voxels)


def test_boxes_arrive_although_the_main_thread_keeps_the_lock_of_python():
    voxels, matrix = scan()
    with served(voxels, matrix) as session:
        target, interval = voxels.copy(), sys.getswitchinterval()
        sys.setswitchinterval(100)  # nothing below but update() gives it away
        try:
            session.push(START, END, RADIUS_MM)
            for _ in range(1000):
                if session.update(voxels, target):
                    break
                end = time.monotonic() + 0.01
                while time.monotonic() < end:
                    pass
        finally:
            sys.setswitchinterval(interval)
        assert (target != voxels).sum() > 100


def test_a_server_that_dies_is_one_message_and_the_voxels_stay():
    voxels, matrix = scan()
    with served(voxels, matrix) as session:
        target = voxels.copy()
        show(session, voxels, target, run(session, session.push(START, END, RADIUS_MM))["step"])
        last = target.copy()
        assert session.trouble() is None
        session.server.process.kill()
        wait_until(lambda: session.client.ended)
        line = "pliant serve has ended by signal 9. The volume keeps its last state."
        assert session.trouble() == line
        with pytest.raises(PliantError, match=line):
            session.send("undo")
        with pytest.raises(PliantError, match="^volume.nrrd: not saved: "):
            session.exact(voxels, target)
        assert not session.update(voxels, target) and numpy.array_equal(target, last)


def test_a_program_that_does_not_serve_is_one_line(tmp_path, monkeypatch):
    voxels, matrix = scan()
    wrong = tmp_path / "wrong"
    wrong.write_text("#!/bin/sh\nexit 3\n")
    wrong.chmod(0o755)
    late = tmp_path / "late"  # its last line is read after its end
    late.write_text("#!/bin/sh\n(sleep 0.3; echo pliant: its reason >&2) >/dev/null &\nexit 2\n")
    late.chmod(0o755)
    names = {
        "/nowhere/pliant": "expected the program pliant: No such file or directory",
        str(tmp_path): "expected the program pliant: Permission denied",
        str(wrong): "expected pliant serve to start: exit status 3",
        str(late): "expected pliant serve to start: its reason",
    }
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    for name, expected in names.items():
        with pytest.raises(PliantError) as error:
            Session(name, voxels, matrix)
        assert str(error.value) == f"{name}: {expected}"
    sheared = matrix.copy()
    sheared[:3, 0] += 0.2 * matrix[:3, 1]
    with pytest.raises(PliantError, match="scan.nrrd.*expected") as error:
        Session(program(), voxels, sheared)
    assert "\n" not in str(error.value)
    with pytest.raises(PliantError, match="found bool of shape"):
        Session(program(), voxels > 0, matrix)
    assert not os.listdir(tmp_path / "temporary")


@pytest.mark.parametrize(("last", "expected"), [("", ""), ("echo pliant: full >&2", ": full")])
def test_the_reason_of_an_end_is_the_last_line_after_the_start(tmp_path, last, expected):
    (tmp_path / "program").write_text(
        "#!/bin/sh\necho 'pliant: opening: 10 % after 2 s' >&2\nsleep 0.3\n"
        f"echo 'Open  http://127.0.0.1:1/#token=x'\nsleep 0.3\n{last}\nexit 2\n"
    )
    (tmp_path / "program").chmod(0o755)
    server = Server(str(tmp_path / "program"), [])
    assert server.link == "http://127.0.0.1:1/#token=x"
    server.process.wait(10)
    assert server.reason() == "pliant serve has ended with status 2" + expected


def test_the_program_is_that_of_the_setting_or_of_a_wheel_or_of_the_path(tmp_path, monkeypatch):
    assert find_program("/chosen/pliant") == "/chosen/pliant"
    monkeypatch.setattr(sys, "path", [p for p in sys.path if "python-module" not in p])
    bare = tmp_path / "path"
    bare.mkdir()
    if not sys.modules.get("pliant"):
        with pytest.raises(PliantError, match="^The program pliant was not found"):
            find_program("", str(bare))
    (bare / "pliant").write_text("#!/bin/sh\n")
    (bare / "pliant").chmod(0o755)
    assert find_program("", str(bare)) == str(bare / "pliant")
    wheel = tmp_path / "site" / "pliant"
    (wheel / "bin").mkdir(parents=True)
    (wheel / "__init__.py").write_text("")
    (wheel / "bin" / "pliant").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    assert find_program("", str(bare)) == str(wheel / "bin" / "pliant")


@contextlib.contextmanager
def fake_server(answer):
    """Answers one connection with bytes; `answer` gets the request and the socket."""
    listener = socket.create_server(("127.0.0.1", 0))

    def serve():
        connection, _ = listener.accept()
        with connection:
            answer(connection.recv(4096).decode(), connection)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield listener.getsockname()[1]
    finally:
        listener.close()
        thread.join()


def accept(request, connection):
    import base64
    import hashlib

    key = request.split("Sec-WebSocket-Key: ")[1].split("\r\n")[0]
    digest = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
    connection.sendall(
        b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: "
        + base64.b64encode(digest) + b"\r\n\r\n"
    )  # fmt: skip


def test_a_message_in_fragments_with_a_ping_between_them_is_one():
    heard = []

    def answer(request, connection):
        accept(request, connection)
        connection.sendall(b"\x01\x02ab" + b"\x89\x01p" + b"\x80\x7e" + struct.pack("!H", 200))
        connection.sendall(b"c" * 200 + b"\x88\x06" + struct.pack("!H", 4002) + b"slow")
        heard.append(connection.recv(64))

    with fake_server(answer) as port:
        web = WebSocket("127.0.0.1", port, "/ws")
        assert web.receive() == "ab" + "c" * 200
        with pytest.raises(ConnectionEnded, match="4002 slow$"):
            web.receive()
        web.close()
    pong = heard[0]
    assert pong[:2] == b"\x8a\x81" and pong[6] ^ pong[2] == ord("p")


@pytest.mark.parametrize(
    ("sent", "found"),
    [(b"HTTP/1.1 403 Forbidden\r\n\r\n", "403 Forbidden"), (b"SSH-2.0\r\n\r\n", "no answer"),
     (b"", "no answer"), (b"HTTP/1.1 101 Yes\r\nSec-WebSocket-Accept: x\r\n\r\n", "another")],
)  # fmt: skip
def test_an_answer_of_another_program_is_one_line(sent, found):
    with fake_server(lambda _, connection: connection.sendall(sent)) as port:
        with pytest.raises(ConnectionEnded, match=f"expected a WebSocket, found {found}"):
            WebSocket("127.0.0.1", port, "/ws")


@pytest.mark.parametrize("head", [b"\x82\xff", b"\x82\x7f" + struct.pack("!Q", 1 << 40)])
def test_masked_and_huge_frames_end_the_connection(head):
    def answer(request, connection):
        accept(request, connection)
        connection.sendall(head + b"\0" * 20)

    with fake_server(answer) as port:
        web = WebSocket("127.0.0.1", port, "/ws")
        with pytest.raises(ConnectionEnded, match="expected a message of the protocol"):
            web.receive()
        web.close()


def test_a_grid_is_cropped_to_motion_and_one_voxel_more():
    field = numpy.zeros((6, 7, 8, 3), "<f4")
    field[2, 3:5, 7] = (1, 2, 3)
    head = (
        "NRRD0004\ntype: float\nsizes: 3 8 7 6\nencoding: raw\n"
        "space directions: none (0,2,0) (3,0,0) (0,0,4)\nspace origin: (10,20,30)\n\n"
    )
    grid = logic.grid_of_field(head.encode() + field.tobytes())
    assert grid.vectors.shape == (3, 4, 2, 3)  # no voxel beyond the scan's last one
    assert grid.vectors[1, 1, 1].tolist() == [-1, -2, 3] and grid.vectors.any(3).sum() == 2
    assert grid.spacing.tolist() == [2, 3, 4]
    assert grid.directions.tolist() == [[0, -1, 0], [-1, 0, 0], [0, 0, 1]]
    assert grid.origin.tolist() == [-10 - 2 * 3, -20 - 6 * 2, 30 + 4]
    still = logic.grid_of_field(head.encode() + bytes(field.nbytes))
    assert still.vectors.shape == (2, 2, 2, 3) and not still.vectors.any()
    with pytest.raises(PliantError, match="^expected a file that Pliant has written"):
        logic.read_nrrd(head.encode() + b"short")


def test_the_sources_are_python_3_9():
    for path in [*HERE.rglob("*.py"), *MODULE.rglob("*.py")]:
        ast.parse(path.read_text(), str(path), feature_version=(3, 9))


def test_the_catalogue_entry_has_the_fields_of_its_schema():
    entry = json.loads((HERE.parent / "Pliant.json").read_text())
    fields = {
        "$schema", "category", "scm_url", "scm_revision", "scm_type", "build_dependencies",
        "build_subdirectory", "enabled", "tier",
    }  # fmt: skip
    assert {"$schema", "category", "scm_url"} <= set(entry) <= fields
    assert entry["$schema"].endswith("/slicer-extension-catalog-entry-schema-v1.0.1.json#")
    assert entry["tier"] in (1, 3, 5)
