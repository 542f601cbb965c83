"""URScript: what the language asks for; `test_program_text` reads its programs back."""

import re

from wpcal.controllers.ur.write import write_urscript


def test_a_name_cannot_break_out_of_its_comment(make_program):
    text = write_urscript(make_program(names=("x\n  movej(home)",)))["WPCAL.script"]
    assert not re.search(r"^\s*movej\(home", text, re.MULTILINE)
