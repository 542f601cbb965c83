"""Written programs are parsed by grammars that others wrote. None of them is part of wpcal or of its dependencies.

* RAPID: `pip install rapidchecker` (AGPL-3.0, 0.1 MB, pyparsing).
* KRL: the ANTLR grammar of J. Schlößin and T. Everett (LGPL-3.0): a clone of github.com/Roiki11/KRLparser, named by the
  environment variable WPCAL_KRL_PARSER, and `pip install antlr4-python3-runtime==4.9.2`.

For the others nothing was found in November 2026 that runs from Python and knows the instructions of a weld program:

* TP (`.ls`): a language server in C# (L3gume/fanuc-lsp) and an analyser in C++ (kamilkozdro/FanucProgramAnalyze)
  would have to be built; tp_plus only writes TP; the BNFC grammar of afeldman/acc has no moves and no positions.
* URScript: the BNFC grammar of afeldman/acc has neither calls nor lists; Hirebotics/urscript-tools runs scripts in
  URSim and does not parse them.
* INFORM, VAL3 and AS: none.

`tests.moves_of_programs` and the readers of wpcal read these.
"""

import os
from pathlib import Path

import pytest

from tests.running import run_here
from tests.touch_plans import TEE_PLAN
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.registry import controller_named
from wpcal.results.folder import read_finished
from wpcal.weld.find import find_welds
from wpcal.weld.place import StatedWeld
from wpcal.weld.rules import shipped_rules

FIXTURES = Path(__file__).parents[3] / "fixtures"
KRL_PARSER = os.environ.get("WPCAL_KRL_PARSER", "")


def written(name, part, *, few, stated=None):
    """Return the files of a part; `stated` are values of every weld, and make a program with arc instructions."""
    finished = read_finished(FIXTURES / part / "golden").select()
    welds = arc = None
    if stated is not None:
        rows = [StatedWeld(seam.name, None, stated) for seam in finished.seams]
        found = find_welds(
            finished.seams, finished.T_base_part, shipped_rules(), part_glb=finished.part_glb, stated=rows
        )
        welds, arc = found.by_seam(), ArcSettings(4)
    program = build_program(finished, controller=ControllerSettings(), welds=welds, arc=arc)
    return {
        file: str(text) for file, text in controller_named(name).write(fit_program(program) if few else program).items()
    }


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of pyparsing, in rapidchecker
@pytest.mark.parametrize(("part", "few"), [("tee", True), ("saddle", True), ("tee", False)])
def test_rapid_is_what_another_grammar_takes(part, few):
    check = pytest.importorskip("rapidchecker.check", reason="rapidchecker is not installed")
    (text,) = written("rapid", part, few=few).values()
    assert check.check_format(text) == []
    weave = {"shape": "sine", "width_mm": 3, "length_mm": 2}
    (text,) = written("rapid", part, few=few, stated={"leg_mm": 5, "weave": weave}).values()
    assert "ArcLStart" in text
    assert check.check_format(text) == []
    assert check.check_format(text.replace("vAir,fine,", "vAir fine,", 1)) != []  # and it does look


@pytest.fixture
def krl_faults(monkeypatch):
    """Return what counts the faults that the public grammar finds in a text."""
    if not KRL_PARSER:
        pytest.skip("WPCAL_KRL_PARSER does not name a folder with krlParser.py")
    antlr4 = pytest.importorskip("antlr4", reason="antlr4-python3-runtime is not installed")
    monkeypatch.syspath_prepend(KRL_PARSER)
    from krlLexer import krlLexer
    from krlParser import krlParser

    def faults(text):
        parser = krlParser(antlr4.CommonTokenStream(krlLexer(antlr4.InputStream(text))))
        parser.removeErrorListeners()
        parser.module()
        return parser.getNumberOfSyntaxErrors()

    return faults


@pytest.mark.parametrize("part", ["tee", "saddle"])
def test_krl_is_what_another_grammar_takes(part, krl_faults):
    files = written("krl", part, few=True)
    assert [krl_faults(text) for text in files.values()] == [0, 0]
    for stated, word in (({"weld_data": "WDAT1"}, ";FOLD ARCOFF"), ({"job": 3}, "$OUT[4]=TRUE")):
        arcs = written("krl", part, few=True, stated=stated)
        assert word in arcs["WPCAL.src"]
        assert [krl_faults(text) for text in arcs.values()] == [0, 0]
    assert krl_faults(files["WPCAL.src"].replace("\r\nLIN ", "\r\nLIN , ", 1)) > 0


def test_a_touch_program_in_krl_is_what_another_grammar_takes(tmp_path, krl_faults):
    assert run_here("export", TEE_PLAN, "-f", "krl", "-o", tmp_path / "out").returncode == 0
    for file in sorted((tmp_path / "out" / "krl").iterdir()):
        assert krl_faults(file.read_bytes().decode()) == 0, file.name
