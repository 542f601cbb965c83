"""Templates of a shop: ours are written the same way, theirs replace ours, and a fault is one line."""

import json
import shutil
from pathlib import Path

import pytest

from tests.running import run_here
from wpcal.controllers.language.post import BLOCKS, TOUCH_BLOCKS, blocks_of, template_languages
from wpcal.controllers.registry import controller_named

OPTIONS = ("--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0")


@pytest.fixture
def export(finished_folder, tmp_path):
    folder = finished_folder()

    def make(language, *options, out="out"):
        return run_here("export", folder, "-f", language, *OPTIONS, "-o", tmp_path / out, "--only", "W1", *options)

    return make


def contents(folder):
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def test_our_templates_written_and_given_back_make_the_same_programs(export, tmp_path):
    languages = [word for language in template_languages() for word in ("-f", language)][1:]
    assert export(*languages, "--write-templates", tmp_path / "shop").returncode == 0
    for language in template_languages():
        assert {path.name for path in (tmp_path / "shop" / language).iterdir()} == {
            f"{b}.txt" for b in blocks_of(language)
        }
    assert export(*languages).returncode == 0
    assert export(*languages, "--template", tmp_path / "shop", out="again").returncode == 0
    for language in template_languages():
        assert contents(tmp_path / "out" / language) == contents(tmp_path / "again" / language)
    assert "exists and is not empty" in export("rapid", "--write-templates", tmp_path / "shop").stderr


@pytest.fixture
def shop(tmp_path):
    """A folder with one template of a shop."""

    def make(language, block, text):
        folder = tmp_path / "shop" / language
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{block}.txt").write_text(text, encoding="utf-8")
        return tmp_path / "shop"

    return make


def test_a_template_of_a_shop_replaces_ours(export, shop, tmp_path):
    welds = tmp_path / "welds.json"
    stated = {"job": 5, "thickness_mm": 8, "speed_mm_s": 6}
    welds.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": stated}]}))
    numbers = "{{ '%.1f' % 0.25 }} {{ '%.2f'|format(0.25) }} {{ '{:.3f}'.format(1) }}"
    text = f"    ! start of {{{{ seam }}}} {numbers}\n"
    text += "    MyArcOn {{ point }},{{ weld.job }},{{ speed_mm_s }};\n"
    folder = shop("rapid", "weld_start", text)
    shop("rapid", "header", "  ! our shop: {{ program }}\n{% for line in about %}\n  ! {{ line }}\n{% endfor %}\n")
    ended = export("rapid", "--template", folder, "--welds", welds, "--arc", "on")
    assert ended.returncode == 1, ended.stderr
    assert "'MyArcOn W1_0001,5,6;'" in ended.stderr
    written = (tmp_path / "out" / "rapid" / "WPCAL.mod").read_text()
    assert written.startswith("MODULE WPCAL\n  ! our shop: WPCAL\n  ! written by wpcal")
    assert "    ! start of W1 0.2 0.25 1.000\n    MyArcOn W1_0001,5,6;\n" in written
    assert "ENDMODULE" in written
    assert "NOT CHECKED: where the arc burns: " in ended.stderr
    assert "leaves out the comments SEAM START and SEAM END" in ended.stderr


@pytest.mark.parametrize(
    ("block", "text", "message"),
    [
        (
            "weld_start",
            "one\n{{ jobb }} {{ point }}\n",
            "weld_start.txt, line 2: there is no name 'jobb'; names here: arc",
        ),
        ("weld_end", "{{ weld.jobb }}", "weld_end.txt, line 1: there is no name 'jobb'; names here: crater, current_a"),
        ("weld_end", "a\n{% if %}\n", "weld_end.txt, line 2: Expected an expression"),
        ("weld_end", "{{ speed_mm_s / 0 }}", "weld_end.txt, line 1: cannot be used: float division by zero"),
        ("weld_end", "{{ seam.__class__.__mro__ }}", "weld_end.txt, line 1: "),
        (
            "air_move",
            "    ! no move\n",
            "air_move.txt: writes no move to the point W1_to01: the torch would go another way",
        ),
        (
            "weld_end",
            "{% for a in range(9999) %}{% for b in range(9999) %}{% endfor %}{% endfor %}",
            "a loop is too long",
        ),
        ("weld_end", "{{ 'x' * 5000000000 }}", "weld_end.txt, line 1: cannot be used: makes more than 10000000"),
        ("weld_end", "{{ 'x'.ljust(5000000000) }}", "makes more than 10000000 characters"),
        ("weld_end", "{{ 'x'|center(5000000000) }}", "makes more than 10000000 characters"),
        ("weld_end", "{{ '%5000000000d' % 1 }}", "a field of more than 999 characters"),
        ("weld_end", "{{ '{:5000000000}'.format(1) }}", "a field of more than 999 characters"),
        ("weld_end", "{{ '{:{}}'.format(1, 5000000000) }}", "one whose width is a value"),
        ("weld_end", "{{ '%*d'|format(5000000000, 1) }}", "one whose width is a value"),
        ("weld_end", "{{ 9 ** 999999999 }}", "makes more than 10000000 characters"),
        ("weld_end", "{{ [0] * 5000000000 }}", "makes more than 10000000 characters"),
        ("weld_end", "{{ range(99999)|join('x' * 999999) }}", "makes more than 10000000 characters"),
        (
            "weld_end",
            "{% set n = namespace(x='x' * 99) %}{% for i in range(60) %}{% set n.x = n.x ~ n.x %}{% endfor %}",
            "writes more than 10000000 characters",
        ),
        ("weld_end", "{% for i in range(99999) %}{{ 'x' * 999 }}{% endfor %}", "writes more than 10000000 characters"),
        ("weld_end", "{% macro m() %}{{ m() }}{% endmacro %}{{ m() }}", "a macro calls itself too often"),
        ("weld_end", "{{ " + "(" * 9999 + "1" + ")" * 9999 + " }}", "it is nested too deeply"),
        ("weld_strat", "", "weld_strat.txt: is no template; expected header.txt, weld_start.txt, weld_end.txt"),
    ],
)
def test_a_template_with_a_fault_is_one_line(export, shop, tmp_path, block, text, message):
    ended = export("rapid", "--template", shop("rapid", block, text))
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert message in ended.stderr
    assert not (tmp_path / "out").exists()


def test_a_folder_without_templates_of_the_format_is_one_line(export, shop):
    ended = export("krl", "--template", shop("rapid", "footer", "ENDMODULE\n"))
    assert ended.returncode == 2
    assert "krl: no such folder; expected the templates header.txt" in ended.stderr
    assert "dxf has no templates" in export("dxf", "--write-templates", "new").stderr


def test_a_template_that_loses_poses_is_refused(export, shop, tmp_path):
    folder = shop("urscript", "air_move", "  # {{ point }}\n")
    ended = export("urscript", "--template", folder)
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert f"{folder}: the templates break the program" in ended.stderr
    assert not (tmp_path / "out").exists()


ARC_ON = '{"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": {"job": 5, "thickness_mm": 8}}]}'


def test_arcs_of_templates_are_checked_as_far_as_their_words_are_known(export, shop, tmp_path):
    welds = tmp_path / "welds.json"
    welds.write_text(ARC_ON)
    folder = shop("krl", "header", "; our shop\n{% for line in about %}\n; {{ line }}\n{% endfor %}\n")
    ended = export("krl", "--template", folder, "--welds", welds, "--arc", "on")
    assert ended.returncode == 0
    assert "where the arc burns" not in ended.stderr  # it was checked
    shutil.copytree(folder, tmp_path / "other")
    folder = tmp_path / "other"
    (folder / "krl" / "air_move.txt").write_text('{{ "PTP" if joint else "LIN" }} {{ point }}\nARC_START(5)\n')
    ended = export("krl", "--template", folder, "--welds", welds, "--arc", "on", out="second")
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert "the templates break the program: krl: WPCAL.src, line" in ended.stderr
    assert "arc on between seams" in ended.stderr
    ended = export("krl", "--template", folder, out="third")  # a dry run that would burn
    assert ended.returncode == 2
    assert "an arc instruction in a program of a dry run" in ended.stderr
    assert not (tmp_path / "second").exists()
    assert not (tmp_path / "third").exists()


def test_a_dry_run_with_templates_around_the_weld_says_what_is_not_known(export, shop):
    folder = shop("krl", "weld_start", "LIN {{ point }}\nMyArc()\n; {{ mark }}\n$VEL.CP={{ speed }}\n")
    ended = export("krl", "--template", folder)
    assert ended.returncode == 1, ended.stderr
    assert "NOT CHECKED: whether" in ended.stderr
    assert "weld_start.txt switch the arc in this dry run" in ended.stderr


def test_every_language_has_the_templates_of_weld_programs_and_all_or_none_of_touches():
    for language in template_languages():
        touches = set(TOUCH_BLOCKS) & set(blocks_of(language))
        assert set(BLOCKS) <= set(blocks_of(language))
        assert bool(touches) == (controller_named(language).touch_writer is not None)
        assert touches in (set(), set(TOUCH_BLOCKS))
