import pandas as pd

from imugap.study.walk.walk_naming import score, summary

HIDDEN = {
    "nothing": ("nothing", []),
    "saturation": ("saturation", ["accel_z"]),
    "misalignment": ("misalignment", ["accel_x"]),
    "scale_factor": ("scale_factor", ["gyro_y"]),
}


def found(**names):
    """Rows of one case: names by source, and the scatter."""
    rows = [{"how": how, "name": name, "deviate": 4.5} for how, given in names.items() for name in given]
    return pd.DataFrame([*rows, {"how": "scatter", "value": 1.0}])


def scored(**cases):
    return score(pd.concat([one.assign(case=case) for case, one in cases.items()], ignore_index=True), HIDDEN)


def test_a_wrong_name_by_zero_velocity_counts_though_the_log_alone_is_right():
    told = summary(scored(saturation=found(integrity=["saturation"], innovations=["time_offset"])))
    assert told["integrity"] == {"right": 1, "wrong": 0, "false": 0}
    assert told["innovations"] == {"right": 0, "wrong": 1, "false": 0}
    assert told["largest_wrong_sigma"] == "4.5"


def test_a_name_that_cannot_be_told_from_the_surest_counts_as_given():
    told = summary(scored(misalignment=found(innovations=["scale_factor", "misalignment"])))
    assert told["innovations"] == {"right": 1, "wrong": 0, "false": 0}
    assert told["largest_wrong_sigma"] is None


def test_a_second_name_with_the_exact_reference_is_wrong():
    told = summary(scored(scale_factor=found(exact=["scale_factor", "misalignment"])))
    assert told["exact"] == {"right": 1, "wrong": 1, "false": 0}


def test_any_name_is_false_where_the_device_has_nothing():
    told = summary(scored(nothing=found(innovations=["misalignment"]), saturation=found()))
    assert told["innovations"] == {"right": 0, "wrong": 0, "false": 1}
    assert (told["there"], told["absent"], told["cases"]) == (1, 1, 2)
