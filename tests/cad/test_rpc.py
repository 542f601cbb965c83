"""`wpcal rpc`: every answer follows its schema, is what the command says, and names what is wrong in a request."""

import json
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from cad.rpc.front import MOST_HANDLES, Front
from cad.rpc.open_parts import MOST_PARTS, OpenPart, OpenParts, signature_of
from cad.rpc.protocol import ANSWER, method_names, schema_of
from cad.rpc.warm_answers import MOST_ANSWERS, WarmAnswers
from cad.workpiece.workpiece import Workpiece
from tests.rpc_client import RpcClient
from tests.running import kernel_work_here, run_command, run_here
from wpcal.core.progress import no_progress

ROOT = Path(__file__).parents[2]
TEE = ROOT / "fixtures" / "tee"
MISTYPED_MM = "81x.29"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The part and its table; the commands that are compared with work in this process."""
    folder = tmp_path_factory.mktemp("rpc")
    shutil.copy(TEE / "tee.step", folder)
    shutil.copy(TEE / "taught.csv", folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cad.work.child.run_in_child", kernel_work_here)
        yield folder


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[RpcClient]:
    """One warm process for all tests of this file; it starts in the folder of the part."""
    client = RpcClient(cwd=folder)
    yield client
    assert client.close() == 0


@pytest.fixture(scope="module")
def tee(client: RpcClient) -> dict[str, Any]:
    return client.ask("open", path="tee.step")


@pytest.fixture(scope="module")
def rows(client: RpcClient, tee: dict[str, Any]) -> dict[str, Any]:
    found = client.ask("read_taught", handle=tee["handle"], path="taught.csv")
    return {"columns": found["columns"], "rows": found["rows"]}


def test_hello_lists_the_methods(client: RpcClient) -> None:
    found = client.ask("hello")
    assert found["protocol"] == 1
    assert found["methods"] == list(method_names())


def test_the_shown_session_has_every_method_with_params_that_its_schema_takes() -> None:
    import jsonschema

    text = (ROOT / "docs" / "examples" / "rpc_session.jsonl").read_text(encoding="utf-8")
    shown = [json.loads(line) for line in text.splitlines()]
    requests = [message for message in shown if "method" in message]
    assert {message["method"] for message in requests} == set(method_names())
    for message in requests:
        jsonschema.validate(message["params"], schema_of(message["method"])["properties"]["params"])
    for message in shown:
        if "method" not in message:
            jsonschema.validate(message, schema_of(ANSWER))


def test_the_shown_session_has_what_is_answered(client: RpcClient, tee: dict[str, Any], rows: dict[str, Any]) -> None:
    """Every name in an answer of the session is in a real answer."""
    text = (ROOT / "docs" / "examples" / "rpc_session.jsonl").read_text(encoding="utf-8")
    shown = [json.loads(line) for line in text.splitlines()]
    method = {message["id"]: message["method"] for message in shown if "method" in message}
    results = {method[message["id"]]: message["result"] for message in shown if "result" in message}
    on_plane = {"p_mm": [100, 20, 10], "normal": [0, 0, 1]}
    params: dict[str, dict[str, Any]] = {"seams": {}, "suggest": {"taught": rows}, "touch_at": on_plane}
    params |= {"calibrate": {"taught": rows}, "save": {"taught": rows, "table": "shown.csv", "out": "shown"}}
    answers = {name: client.ask(name, handle=tee["handle"], **more) for name, more in params.items()}
    answers |= {"read_taught": client.ask("read_taught", handle=tee["handle"], path="taught.csv")}
    answers |= {"open": tee, "hello": client.ask("hello"), "formats": client.ask("formats")}
    answers |= {"export": client.ask("export", folder="shown", formats=["rapid"])}
    for name, answer in answers.items():
        assert not names_missing(results[name], answer), name


def names_missing(shown: Any, real: Any) -> list[str]:
    """Return the names of a record that another one of this kind has not."""
    if isinstance(shown, list) and shown and real:
        return names_missing(shown[0], real[0])
    if not isinstance(shown, dict) or set(shown) <= {"0"}:  # numbers of rows
        return []
    return [
        missing
        for name, value in shown.items()
        for missing in ([name] if name not in real else names_missing(value, real[name]))
    ]


def test_features_are_those_of_the_command(tee: dict[str, Any], folder: Path) -> None:
    printed = json.loads(run_here("features", folder / "tee.step", "--json").stdout)
    assert sorted(tee["features"], key=json.dumps) == sorted(printed["features"], key=json.dumps)
    assert tee["solids"] == ["base plate", "web"]


@pytest.mark.deep
def test_seams_are_those_of_the_command(client: RpcClient, tee: dict[str, Any], folder: Path) -> None:
    found = client.ask("seams", handle=tee["handle"], options={"min_length_mm": 20, "weld": ["web"]})
    options = ("--min-length-mm", "20", "--weld", "web")
    printed = json.loads(run_here("seams", folder / "tee.step", *options, "--json").stdout)
    assert client.progress
    for ours, theirs in zip(found["seams"], printed["seams"], strict=True):
        assert ours["frames"]["p"] == [[round(v, 3) for v in frame["p_mm"]] for frame in theirs["frames"]]
        assert {**ours, "frames": None} == {**theirs, "frames": None}


@pytest.mark.deep
def test_a_decision_is_carried_out_and_saved_results_are_checked_with_it(
    client: RpcClient, tee: dict[str, Any], rows: dict[str, Any], folder: Path
) -> None:
    before = next(seam for seam in client.ask("seams", handle=tee["handle"])["seams"] if seam["accepted"])
    decision = {"candidate": before["candidate"], "edit": {"reverse": True, "name": "A1"}}
    after = client.ask("seams", handle=tee["handle"], decisions=[decision])["seams"]
    turned = next(seam for seam in after if seam["name"] == "A1")
    assert turned["frames"]["p"] == before["frames"]["p"][::-1]
    client.ask("save", handle=tee["handle"], taught=rows, table="turned.csv", out="turned", decisions=[decision])
    out = folder / "turned"
    files = json.loads((out / "job.json").read_text())["inputs"]["files"]
    assert [each["file"] for each in files] == [str(Path("turned", "seams.json"))]
    assert run_here("verify", out).returncode == 0
    text = (out / "seams.json").read_text()
    (out / "seams.json").write_text(text.replace('"reverse": true', '"reverse": false'))
    assert run_here("verify", out).returncode != 0


def test_a_fit_is_that_of_the_command_and_so_is_the_folder(
    client: RpcClient, tee: dict[str, Any], rows: dict[str, Any], folder: Path
) -> None:
    options = {"tolerance_mm": 0.4, "criterion": "least_squares"}
    words = ("--tolerance-mm", "0.4", "--criterion", "least_squares")
    fit = client.ask("calibrate", handle=tee["handle"], taught=rows, options=options, frames=True)
    saved = client.ask(
        "save", handle=tee["handle"], taught=rows, table=str(folder / "rows.csv"), out="by-rpc", options=options
    )
    assert run_here("calibrate", folder / "tee.step", folder / "rows.csv", *words, "-o", folder / "out").returncode == 0
    for file in sorted((folder / "out").iterdir()):
        assert (folder / "by-rpc" / file.name).read_bytes() == file.read_bytes(), file.name
    record = json.loads((folder / "out" / "calibration.json").read_text())
    assert saved["record"] == record
    assert {**fit["record"], "files": 0, "inputs": 0} == {**record, "files": 0, "inputs": 0}
    assert [point["row"] for point in fit["points"]] == list(range(len(rows["rows"])))
    seams = json.loads((folder / "out" / "seams.json").read_text())["seams"]
    for error, shown, seam in zip(fit["u95_mm"], fit["seams"], seams, strict=True):
        assert error["seam"] == shown["name"] == seam["name"]
        assert error["frames_mm"] == [round(frame["u95_mm"], 6) for frame in seam["frames"]]
    assert saved["command"].startswith("wpcal calibrate ")
    assert client.refused("save", handle=tee["handle"], taught=rows, table="rows.csv", out="by-rpc")["code"] == "exists"


def test_bodies_and_the_suggestion_are_answered(client: RpcClient, tee: dict[str, Any], rows: dict[str, Any]) -> None:
    fit = client.ask("calibrate", handle=tee["handle"], taught=rows, options={"bodies": True})
    assert [body["name"] for body in fit["record"]["bodies"]["bodies"]] == tee["solids"]
    none = {"columns": rows["columns"], "rows": []}
    assert len(client.ask("suggest", handle=tee["handle"], taught=none)["features"]) == 4
    moved = client.ask("suggest", handle=tee["handle"], taught=none, options={"bodies": True})
    assert moved["features"] == [touch["name"] for touch in moved["touches"]]
    assert {touch["body"] for touch in moved["touches"]} == set(tee["solids"])
    bad = client.refused("suggest", handle=tee["handle"], taught=none, options={"tack_mm": 1})
    assert bad["message"] == "--tack-mm and --tack-mrad are for --bodies"
    touched = client.ask("touch_at", handle=tee["handle"], p_mm=[100, 20, 10], normal=[0, 0, 1])
    assert (touched["kind"], touched["p_mm"]) == ("plane", [100, 20, 10])


@pytest.mark.usefixtures("tee")
def test_programs_touches_and_pages(client: RpcClient, tee: dict[str, Any], rows: dict[str, Any], folder: Path) -> None:
    client.ask("save", handle=tee["handle"], taught=rows, table="other.csv", out="result")
    names = {each["name"] for each in client.ask("formats")["formats"]}
    assert {"rapid", "json"} <= names
    known = {each["name"]: each for each in client.ask("options", method="export")["options"]}
    assert known["speed_mm_s"]["type"] == "number"
    written = client.ask("export", folder="result", formats=["abb"], options={"speed_mm_s": 6})
    assert all((folder / file).is_file() for file in written["files"]["rapid"])
    assert Path(client.ask("page", folder="result")["path"]).is_file()
    plan = client.ask("touches", handle=tee["handle"], out="touch", options={"touches": 6})
    assert len(plan["searches"]) == 6
    long = [seam["candidate"] for seam in client.ask("seams", handle=tee["handle"])["seams"] if seam["accepted"]]
    rejected = [{"candidate": candidate, "edit": {"reject": True}} for candidate in long]
    error = client.refused("touches", handle=tee["handle"], out="none", decisions=rejected)
    assert (error["kind"], (folder / "none").exists()) == ("GeometryError", False)
    assert "no such method" in client.refused("options", method="nix")["message"]
    assert client.refused("plan", folder="result", cell="none.json", out="plan")["kind"] == "InputError"


@pytest.mark.deep
def test_a_weld_is_planned_in_a_real_cell(
    client: RpcClient, tee: dict[str, Any], rows: dict[str, Any], folder: Path
) -> None:
    client.ask("save", handle=tee["handle"], taught=rows, table="größe.csv", out="für Plan")
    cell = ROOT / "fixtures" / "cells" / "two-mh6-tee.json"
    params = {"folder": "für Plan", "cell": str(cell), "out": "der Plan", "options": {"only": "W2"}}
    assert client.ask("plan", **params)["seam"] == "W2"
    assert (folder / "der Plan" / "plan.html").is_file()
    assert client.refused("plan", **params)["code"] == "exists"


@pytest.mark.parametrize(
    ("line", "kind", "said"),
    [
        (b"{", "ProtocolError", "not JSON"),
        (b"[1]", "ProtocolError", "expected a JSON object"),
        (b'{"jsonrpc": "2.0", "id": 1}', "ProtocolError", "name of a method"),
        (b'{"id": true, "method": "hello"}', "ProtocolError", "as id"),
        (b'{"id": 1.5, "method": "hello"}', "ProtocolError", "as id"),
        (b'{"id": 1, "method": "hello", "params": [1]}', "ProtocolError", "a list"),
        (b'{"id": 1, "method": "hello", "extra": 1}', "ProtocolError", "extra"),
        (b'{"id": 1, "method": "hello", "params": {"a": NaN}}', "ProtocolError", "NaN"),
        (b'{"id": 1, "method": "hello", "params": {"a": 1e999}}', "ProtocolError", "too large"),
        (b'{"id": 1, "method": "hello", "params": {"a": 1}}', "ProtocolError", "params: a"),
        (b'{"id": 1, "method": "helo"}', "UnknownMethod", "helo"),
        (b'{"id": 1, "method": "open", "params": {"path": 3}}', "ProtocolError", "path"),
        (b'{"id": 1, "method": "open"}', "ProtocolError", "'path' is missing"),
        (b'{"id": 1, "method": "open", "params": {"path": "\\ud800"}}', "ProtocolError", "surrogate"),
        (b'{"id": 1, "method": "hello\xff"}', "ProtocolError", "UTF-8"),
        (b'{"id": 1, "method": "a' + b"[" * 100_000, "ProtocolError", "not JSON"),
        (b"[" * 200_000, "ProtocolError", ""),
        (b"1" * 10_000, "ProtocolError", ""),
        (b'{"id": 1, "method": "hello", "params": {"a": "' + b"x" * 50_000_000 + b'"}}', "ProtocolError", "16 MB"),
    ],
    ids=lambda value: value[:40].decode("latin-1") if isinstance(value, bytes) else None,
)
def test_what_is_no_request_is_said(client: RpcClient, line: bytes, kind: str, said: str) -> None:
    client.write(line)
    error = client.answer()["error"]
    assert error["kind"] == kind
    assert said in error["message"]
    assert client.ask("hello")["protocol"] == 1


def test_wrong_data_is_said_with_its_place(client: RpcClient, tee: dict[str, Any], rows: dict[str, Any]) -> None:
    handle = tee["handle"]
    bad = [list(row) for row in rows["rows"]]
    bad[2][1] = MISTYPED_MM
    error = client.refused("calibrate", handle=handle, taught={**rows, "rows": bad})
    assert (error["kind"], error["row"], error["column"]) == ("FormatError", 2, "x_mm")
    assert "gap_mmm" in client.refused("seams", handle=handle, options={"gap_mmm": 1})["message"]
    assert "a number" in client.refused("seams", handle=handle, options={"gap_mm": "1"})["message"]
    assert "a list" in client.refused("seams", handle=handle, options={"weld": "web"})["message"]
    assert "must be positive" in client.refused("seams", handle=handle, options={"gap_mm": -1})["message"]
    assert client.refused("seams", handle="p77")["kind"] == "UnknownHandle"
    assert client.refused("open", path="none.step")["kind"] == "InputError"
    assert client.refused("open", path="taught.csv")["kind"] in ("FormatError", "InputError")
    assert client.refused("seams", handle=handle, decisions=[{"candidate": {}, "edit": {}}])["kind"] == "FormatError"


def test_an_id_in_use_is_refused_and_the_first_request_goes_on(client: RpcClient, tee: dict[str, Any]) -> None:
    line = json.dumps({"id": "twice", "method": "seams", "params": {"handle": tee["handle"]}}).encode()
    client.write(line + b"\n" + line)
    answers = [client.answer(), client.answer()]
    refused = next(answer for answer in answers if "error" in answer)
    assert (refused["id"], refused["error"]["kind"]) == (None, "ProtocolError")
    assert next(answer for answer in answers if "result" in answer)["id"] == "twice"


def test_a_file_that_changed_is_read_again_and_one_that_is_gone_is_said(client: RpcClient, folder: Path) -> None:
    part = folder / "changing.step"
    shutil.copy(TEE / "tee.step", part)
    opened = client.ask("open", path=str(part))
    part.write_text(part.read_text().replace("'web'", "'wall'"))
    found = client.ask("seams", handle=opened["handle"])
    assert found["reread"]
    assert found["sha256"] != opened["sha256"]
    assert "wall" in found["seams"][0]["solids"]
    assert not client.ask("seams", handle=opened["handle"])["reread"]
    part.unlink()
    assert "is gone since it was opened" in client.refused("seams", handle=opened["handle"])["message"]
    client.ask("close", handle=opened["handle"])
    assert client.refused("seams", handle=opened["handle"])["kind"] == "UnknownHandle"


def test_the_example_client_does_what_the_page_says(folder: Path) -> None:
    script = ROOT / "docs" / "examples" / "rpc_client.py"
    assert len(script.read_text().splitlines()) <= 40
    assert "](../examples/rpc_client.py)" in (ROOT / "docs" / "reference" / "rpc.md").read_text(encoding="utf-8")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = [sys.executable, script, "tee.step", "taught.csv", "by-example"]
    done = run_command(*command, cwd=folder, PATH=path)
    assert done.returncode == 0, done.stderr
    assert "PASS" in done.stdout
    assert "finding seams" in done.stderr
    assert (folder / "by-example" / "calibration.json").is_file()


def test_the_parts_that_were_used_last_are_in_memory(tmp_path: Path) -> None:
    parts, files = OpenParts(), [tmp_path / f"{number}.step" for number in range(MOST_PARTS + 1)]
    opened = []
    for number, file in enumerate(files):
        file.write_text("")
        opened.append(OpenPart(file, cast(Workpiece, None), signature_of(file)))
        parts.put(f"p{number}", opened[-1])
        assert parts.get("p0", files[0], no_progress) is opened[0]  # used again and again
    assert list(parts._parts) == [*(f"p{number}" for number in range(2, MOST_PARTS + 1)), "p0"]
    parts.drop(["p0", "p0"])
    assert "p0" not in parts._parts


def test_the_answers_that_were_used_last_are_in_memory() -> None:
    answers, made = WarmAnswers(), list[Any]()

    def ask(number: int) -> int:
        return answers.answer("number", (number,), lambda: made.append(number) or number)  # type: ignore[func-returns-value]

    for number in range(MOST_ANSWERS + 1):
        assert (ask(0), ask(number)) == (0, number)
    assert made == list(range(MOST_ANSWERS + 1))
    ask(1)
    assert made[-1] == 1  # it had made room


def test_the_handle_that_was_not_used_for_the_longest_time_is_closed() -> None:
    front = Front(0, 1)
    for number in range(MOST_HANDLES + 1):
        front._keep({"handle": f"p{number}", "path": "", "sha256": ""})
    assert len(front._handles) == MOST_HANDLES
    assert "p0" not in front._handles
