import pytest

from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.robot_space import RobotSpace, common_space, space_of_table
from wpcal.core.tables import read_table


def table(tmp_path, *rows):
    path = tmp_path / "points.csv"
    path.write_text("\n".join(rows))
    return read_table(path)


def test_one_space_passes():
    assert common_space([("a", RobotSpace.IDENTIFIED), ("b", RobotSpace.IDENTIFIED)]) is RobotSpace.IDENTIFIED


def test_mixing_is_refused_by_name():
    with pytest.raises(FrameError, match=r"taught\.csv is in nominal robot space and seams\.json in identified"):
        common_space([("taught.csv", RobotSpace.NOMINAL), ("seams.json", RobotSpace.IDENTIFIED)])


def test_nothing_has_no_space():
    with pytest.raises(InputError):
        common_space([])


def test_a_word_is_parsed_or_refused():
    assert RobotSpace.parse("identified") is RobotSpace.IDENTIFIED
    with pytest.raises(InputError, match="nominal or identified"):
        RobotSpace.parse("real")


def test_a_table_without_the_column_is_nominal(tmp_path):
    assert space_of_table(table(tmp_path, "name,x_mm", "a,1")) is RobotSpace.NOMINAL


def test_a_table_tells_its_space_and_may_not_mix(tmp_path):
    assert space_of_table(table(tmp_path, "name,robot_space", "a,identified", "b,identified")) is RobotSpace.IDENTIFIED
    with pytest.raises(FrameError, match=r"line 3, in nominal"):
        space_of_table(table(tmp_path, "name,robot_space", "a,identified", "b,nominal"))
    with pytest.raises(FormatError, match="line 2"):
        space_of_table(table(tmp_path, "name,robot_space", "a,real"))
