"""A position in a program is made of finite numbers, or the program is refused with the point and its line."""

import pytest

from wpcal.controllers.registry import controller_named
from wpcal.controllers.user_frames import parse_uframes
from wpcal.core.errors import FormatError, InputError

RAPID = "MODULE T\nCONST robtarget V1:=[[{x},2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n"
FANUC = (
    '/PROG T\n/POS\nP[1:"V1"]{{\nGP1:\n UF : 0, UT : 1,\n X = {x} mm, Y = 2 mm, Z = 3 mm,\n'
    " W = 0 deg, P = 0 deg, R = 0 deg\n}};\n"
)
KRL = "DEFDAT T\nDECL E6POS XV1={{X {x},Y 2,Z 3,A 0,B 0,C 0}}\nENDDAT\n"
INFORM = "/JOB\n//POS\n///POSTYPE ROBOT\n///RECTAN\nC00001={x},2,3,0,0,0\n//INST\n"
AS = ".TRANS\nv1 {x} 2 3 0 0 0\n.END\n"
LANGUAGES = {"rapid": (RAPID, 2), "fanuc": (FANUC, 3), "krl": (KRL, 2), "inform": (INFORM, 5), "as": (AS, 2)}
READ = {name: controller_named(name).load_reader().read for name in LANGUAGES}
NO_NUMBERS = ["nan", "inf", "-Infinity", "1e400", "2e9", "81_2", "１２", "true", "1.2.3", "0x10"]


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_is_no_number_is_refused_with_its_line(language: str, text: str) -> None:
    program, line = LANGUAGES[language]
    with pytest.raises(FormatError, match=rf"T, line {line}: .*(expected|number)"):
        READ[language](program.format(x=text), "T")


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_number_is_read(language: str) -> None:
    assert READ[language](LANGUAGES[language][0].format(x="-8.125"), "T").points[0].p_mm[0] == -8.125


def test_a_cut_module_is_refused_and_a_missing_semicolon_loses_no_point() -> None:
    joined = RAPID.replace(";\nENDMODULE", "\nVAR robtarget V2:=[[1,2,3],[1,0,0,0]];")
    assert len(READ["rapid"](joined.format(x="1"), "T").points) == 2
    with pytest.raises(FormatError, match="line 2: V1: expected"):
        READ["rapid"](RAPID[:60].format(x="1"), "T")


@pytest.mark.parametrize("value", ["1.5", "#TCP", "9" * 400, "nan"])
def test_a_base_of_krl_is_a_whole_number(value: str) -> None:
    text = KRL.format(x="1").replace("ENDDAT", f"DECL FDAT FV1={{TOOL_NO 1,BASE_NO {value},IPO_FRAME #BASE}}\nENDDAT")
    with pytest.raises(FormatError, match="V1: BASE_NO: expected a whole number"):
        READ["krl"](text, "T")


@pytest.mark.parametrize("text", ["1,2,nan,0,0,0", "2=1e400,0,0,0,0,0", "81_2,0,0,0,0,0"])
def test_a_user_frame_is_made_of_numbers(text: str) -> None:
    with pytest.raises(InputError, match=r"user frame .*expected a"):
        parse_uframes([text])
