import pytest

from imugap import spelling

KNOWN = ("white_noise", "random_walk", "gauss_markov", "gyro_x", "gyro_y", "accel_x", "time", "wx")


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("white_nois", "white_noise"), ("WhiteNoise", "white_noise"), ("gausmarkov", "gauss_markov"),
        ("white", "white_noise"), ("giro_x", "gyro_x"), ("GYRO_Y", "gyro_y"), ("tiem", "time"), ("wz", "wx"),
        ("gt_x", None), ("latitude", None), ("", None), ("z", None),
    ],
)  # fmt: skip
def test_the_name_that_was_meant_is_found_and_no_other(name, meant):
    assert spelling.nearest(name, KNOWN) == meant
    assert spelling.hint(name, KNOWN) == (f" (did you mean {meant}?)" if meant else "")


def test_without_a_near_name_all_are_expected():
    assert spelling.expected("latitude", ("a", "b")) == "one of a, b"
    assert spelling.expected("tim", ("time", "b")) == "a known name (did you mean time?)"
