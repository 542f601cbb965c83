"""A part that is larger than its model: by its temperature, and by what the touches told."""

import numpy as np
import pytest

from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.size import PartSize
from wpcal.calibrate.trust.scale import ScaleFit
from wpcal.core.errors import InputError
from wpcal.core.pairs import PointPairs


def test_a_temperature_and_a_fit_are_applied_one_after_the_other():
    size = PartSize.stated(45.0, 1.2e-5).freed(ScaleFit(-7e-4, 0.053, 1e-4))
    assert size.scale == pytest.approx(1.0003 * 0.9993 - 1.0, rel=1e-12)
    assert size.told == "45 °C, 12 ppm per K, and then fitted to the touches, ± 53.00 mm per metre"
    assert "are those of a part that is 0.40 mm per metre smaller than its model (45 °C" in size.issue.message
    assert size.teaching(TeachingError()).scale_error == pytest.approx(0.053 / 1.959964, rel=1e-6)
    p = np.array([[30.0, -50, 70], [900, 20, -10], [-5, 400, 3]])
    pairs = size.of_model(PointPairs(tuple("abc"), p, p + 1000.0))
    np.testing.assert_allclose(pairs.p_target * (1.0 + size.scale), p + 1000.0, rtol=1e-12)
    np.testing.assert_array_equal(pairs.p_source, p)


def test_without_a_temperature_it_has_the_size_of_its_model_and_few_touches_free_none():
    assert PartSize.stated(None, 1.2e-5) == PartSize(0.0, "", None)
    with pytest.raises(InputError, match="a free scale needs at least"):
        PartSize().freed(None)
