"""Lines of a client of `wpcal rpc`: read, checked, and answered by the methods that write no file."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from cad.rpc import part_methods
from cad.rpc.messages import MessageFaultError, error_line, read_request, result_line
from cad.rpc.open_parts import OpenPart
from cad.rpc.protocol import check_request
from cad.rpc.warm_answers import WarmAnswers
from cad.workpiece.step_file import PartContent, StepFile
from cad.workpiece.workpiece import Workpiece
from tests.fuzz.further import DECISIONS, TABLE
from tests.fuzz.target import FIXTURES, Target
from wpcal.brep.graph_file import read_graph
from wpcal.core.errors import InputError
from wpcal.core.progress import no_progress

WRITES_NOTHING = ("seams", "read_taught", "calibrate", "suggest", "touch_at")
ROWS = {key: TABLE[key] for key in ("columns", "rows")}
PARAMS: dict[str, dict[str, Any]] = {
    "seams": {"handle": "p1", "decisions": DECISIONS, "options": {"min_length_mm": 5.0, "weld": ["*"]}},
    "read_taught": {"handle": "p1", "path": "a.csv", "text": "name,x_mm,y_mm,z_mm\nV1,1,2,3\n"},
    "calibrate": {"handle": "p1", "taught": ROWS, "options": {"sigma_mm": 0.3, "bodies": True}, "frames": True},
    "suggest": {"handle": "p1", "taught": {**ROWS, "rows": []}, "decisions": []},
    "touch_at": {"handle": "p1", "p_mm": [100.0, 20.0, 10.0], "normal": [0.0, 0.0, 1.0]},
    "cancel": {"id": 3},
}


@cache
def part() -> OpenPart:
    """Return an opened part from a saved graph, without the kernel."""
    graph = read_graph(FIXTURES / "graphs" / "tee.npz")
    file = StepFile(Path("tee.step"), b"", WarmAnswers(kernel=False))
    file.__dict__["content"] = PartContent(graph, "mm", ())
    return OpenPart(file.path, Workpiece(graph, (), file), ())


def answer(data: bytes, _: Path) -> object:
    """Answer one line; an answer must be JSON without NaN."""
    try:
        request = read_request(data)
        check_request(request)
    except MessageFaultError as fault:
        json.loads(error_line(fault.id, fault.kind, str(fault)))
        raise InputError(str(fault)) from None
    if request.method not in WRITES_NOTHING:
        return None
    result = part_methods.METHODS[request.method](part(), request.params, no_progress)
    return json.loads(result_line(request.id, result))


def rpc_targets() -> dict[str, Target]:
    """Return the requests of a client, by name."""
    lines = [json.dumps({"id": 7, "method": name, "params": params}) for name, params in PARAMS.items()]
    return {"rpc": Target(answer, tuple(line.encode() for line in lines))}
