from dataclasses import replace
from types import SimpleNamespace

from imugap.discovery.device import nameless_places
from imugap.discovery.finding import Discrepancy


def test_withheld_effects_are_reported_on_axes_without_a_discrepancy():
    example = Discrepancy("spectrum", "gyro_x", 1.0, 2.0, "Hz", 1e-9)
    places = {axis: replace(example, axis=axis) for axis in ("gyro_x", "gyro_y", "accel_x")}
    weak = replace(example, axis="accel_y", p_value=0.2)
    results = {
        axis: SimpleNamespace(withheld=[SimpleNamespace(location=place)])
        for axis, place in (places | {"accel_y": weak}).items()
    }
    shown = [replace(example, view="coherence", axis="gyro_x,gyro_z")]
    assert nameless_places(results, shown, 0.01) == (places["gyro_y"], places["accel_x"])
