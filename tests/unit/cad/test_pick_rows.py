"""The table in the picker's page: nothing that goes in is changed on its way to the file, and faults name their row."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cad.session.rows import NEW_COLUMNS, Rows, read_rows
from cad.session.session import fault_record
from wpcal.core.errors import FormatError, InputError
from wpcal.core.tables import parse_table
from wpcal.taught.table import TaughtPoints, read_taught, taught_from_table

FIXTURES = Path(__file__).parents[3] / "fixtures"
CELL = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), max_size=8)


def taught(rows: Rows) -> TaughtPoints:
    return taught_from_table(parse_table(rows.to_csv().encode(), path=""))


@pytest.mark.parametrize("file", ["tee/taught.csv", "tee/touches_321.csv", "saddle/taught.csv", "frame/taught.csv"])
def test_a_file_comes_through_the_page_as_it_is(file: str) -> None:
    path = FIXTURES / file
    expected, found = read_taught(path), taught(read_rows(path.read_bytes(), path=file))
    assert (found.names, found.features, found.use, found.kinds) == (
        expected.names,
        expected.features,
        expected.use,
        expected.kinds,
    )
    for key in ("p_base", "p_part", "covariances", "radius_mm"):
        np.testing.assert_array_equal(getattr(found, key), getattr(expected, key))


@given(st.lists(st.tuples(CELL, *[st.floats(-1e5, 1e5)] * 3, CELL, st.sampled_from(["yes", "check", ""])), max_size=6))
def test_cells_are_written_as_typed(table: list[tuple[str, float, float, float, str, str]]) -> None:
    record = {"columns": list(NEW_COLUMNS), "rows": [[str(cell) for cell in row] for row in table]}
    rows = Rows.from_record(record)
    assert rows.to_record() == record
    if table:
        again = parse_table(rows.to_csv().encode(), path="")
        assert [list(row) for row in zip(*again.columns.values(), strict=True)] == record["rows"]


def test_rows_without_coordinates_wait() -> None:
    rows = Rows(
        NEW_COLUMNS, (("V1", "", "", "", "V1", "yes"), ("V2", "1", "2", "3", "V2", "yes"), ("V3", "1", "", "3", "", ""))
    )
    assert rows.complete() == (1,)
    assert taught(rows).names == ("V2",)


def test_a_decimal_comma_between_semicolons_becomes_a_point() -> None:
    rows = read_rows(b"name;x_mm;y_mm;z_mm;remark\nV1;812,29;-240,62;165,8;a,b\n", path="t.csv")
    assert rows.cells[0][1:5] == ("812.29", "-240.62", "165.8", "a,b")
    np.testing.assert_array_equal(taught(rows).p_base, [[812.29, -240.62, 165.8]])


def test_points_by_model_coordinates_get_no_feature() -> None:
    raw = b"name,x_mm,y_mm,z_mm,model_x_mm,model_y_mm,model_z_mm\nA,1,2,3,4,5,6\n"
    rows = read_rows(raw, path="t.csv")
    assert "feature" not in rows.columns
    np.testing.assert_array_equal(taught(rows).p_part, [[4, 5, 6]])


def test_a_fault_names_the_row_of_the_page_not_the_line_of_the_text() -> None:
    cells = (("A", "", "", "", "", "yes"), ("B", "1", "2", "3", "", "yes"), ("C", "1", "8x", "3", "", "yes"))
    rows = Rows(NEW_COLUMNS, cells)
    with pytest.raises(FormatError) as caught:
        taught(rows)
    assert fault_record(caught.value, rows) == {
        "message": "C, y_mm: expected a number, got '8x'",
        "code": "format",
        "row": 2,
        "column": "y_mm",
    }


@pytest.mark.parametrize(
    "record",
    [
        None,
        {},
        {"columns": ["name", "x_mm", "y_mm"], "rows": []},
        {"columns": [*NEW_COLUMNS, "use"], "rows": []},
        {"columns": list(NEW_COLUMNS), "rows": [["V1"]]},
        {"columns": list(NEW_COLUMNS), "rows": [["V1", 1, 2, 3, "V1", "yes"]]},
        {"columns": [*NEW_COLUMNS, 3], "rows": []},
        {"columns": list(NEW_COLUMNS), "rows": [["V" * 1001, "1", "2", "3", "V1", "yes"]]},
    ],
)
def test_what_is_no_table_is_refused_in_one_line(record: object) -> None:
    with pytest.raises(InputError, match=r"expected [^\n]+$"):
        Rows.from_record(record)
