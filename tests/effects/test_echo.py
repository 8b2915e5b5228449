"""An echo: its spectrum, found, named, and without a name where it is not of the catalogue."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.chance import mean_is
from tests.discovery.simulated import KINDS, KNOWN, behind, names, result_of, sequence
from tests.effects.simulated import RUNS, conditions, draws, tapered_power

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.search.intervals import intervals
from imugap.effects import BandNoise, BiasInstability, Echo, OutputFilter, Sinusoid, WhiteNoise
from imugap.effects.conditions import Run
from imugap.stream import stream


@pytest.mark.parametrize("effect", [Echo(0.4, 12), Echo(0.9, 1), Echo(0.3, 7, 1)])
def test_it_adds_an_earlier_sample(effect):
    values = stream(3, "echo").standard_normal((60, 2))
    output, sign = effect.passed(values, 0.01), 1 - 2 * effect.inverted
    delay = int(effect.delay)
    np.testing.assert_allclose(output[delay:], values[delay:] + sign * effect.size * values[:-delay])
    np.testing.assert_allclose(output[:delay], values[:delay] + sign * effect.size * values[0])
    begun = effect.passed(np.concatenate([np.zeros((delay, 2)), values]), 0.01)[delay:]
    np.testing.assert_allclose(output - begun, np.outer(effect.decay(60, 0.01), values[0]), atol=1e-12)


@pytest.mark.parametrize("effect", [Echo(0.4, 12), Echo(0.3, 2, 1)])
def test_it_colours_white_noise_by_its_gain(effect):
    noise, interval = WhiteNoise(0.3), 0.01
    white = draws(noise, RUNS, 1024, "echo", interval=interval)
    output = np.array([effect.passed(one, interval)[64:] for one in white])
    power, frequency = tapered_power(output, interval)
    np.testing.assert_allclose(np.abs(effect.response(frequency, interval)) ** 2, effect.gain(frequency, interval))
    for band in (slice(8, 40), slice(60, 90), slice(200, 230), slice(400, 460)):
        expected = noise.sampled_psd(frequency[band], interval) * effect.gain(frequency[band], interval)
        assert mean_is((power[:, band] / expected).mean(axis=1), 1.0, share=0.03), band


def test_the_mean_gain_is_the_mean_over_the_band():
    effect, middle, width = Echo(0.4, 12, 1), np.array([3.0, 21.0]), np.array([2.0, 5.0])
    within = middle + width * (np.arange(2000)[:, None] + 0.5 - 1000) / 2000
    np.testing.assert_allclose(effect.mean_gain(middle, width, 0.01), effect.gain(within, 0.01).mean(axis=0), rtol=1e-6)


def test_in_parts_it_is_the_same():
    values, effect = stream(4, "parts").standard_normal(100), Echo(0.4, 12)
    at = conditions(100)
    step = effect.in_parts(Run(100, at.interval, None), stream(1))
    parts = [step(part, at) for part in np.split(values, [5, 9, 40, 41])]
    np.testing.assert_allclose(np.concatenate(parts), effect.apply(values, at, stream(1)))


@pytest.mark.parametrize(
    ("effect", "label"), [(Echo(0.4, 12), 1), (Echo(0.4, 12), 2), (Echo(0.4, 12), 3), (Echo(0.15, 5, 1), 4),
                          (Echo(0.9, 45, 1), 6)]
)  # fmt: skip
def test_an_echo_is_found_and_named(effect, label):
    (one,) = result_of(behind(sequence(label=f"echo {label}"), effect)).findings
    assert one.name == "echo"
    assert (one.parameters["delay"].value, one.parameters["inverted"].value) == (effect.delay, effect.inverted)
    size = one.parameters["size"]
    assert abs(size.value - effect.size) < 1.8 * (size.high - size.low) / 2  # 3.5 standard deviations
    assert size.high - size.low < 5 / np.sqrt(24_000)


@pytest.mark.parametrize("hidden", [Sinusoid(3.0, 1e-3), BiasInstability(1e-3)], ids=lambda one: one.name)
def test_both_an_echo_and_an_effect_ahead_of_it_are_named(hidden):
    assert names(result_of(behind(sequence(hidden), Echo(0.4, 12)))) == sorted(["echo", hidden.name])


@pytest.mark.parametrize(
    "hidden", [(), (BiasInstability(1e-3),), (Sinusoid(3.0, 1e-3),)], ids=["nothing", "slow noise", "a line"]
)
def test_nothing_else_is_called_an_echo(hidden):
    assert names(result_of(sequence(*hidden))) == [one.name for one in hidden]


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [OutputFilter(4.0, 2), OutputFilter(10.0, 1), OutputFilter(8.0, 1, 1)])
def test_a_low_pass_filter_is_none(hidden):
    assert names(result_of(behind(sequence(), hidden))) == ["output_filter"]


@pytest.mark.parametrize(
    ("effect", "label"), [(Echo(0.4, 12), 1), (Echo(0.4, 12), 2), (Echo(0.4, 12), 3), (Echo(0.15, 5, 1), 4)]
)
def test_an_echo_that_is_not_of_the_catalogue_has_no_name(effect, label):
    others = [kind for kind in KINDS if kind is not Echo]
    data = sequence(count=8000, label=f"echo {label}")
    assert names(result_of(behind(data, effect), *others)) == []


@pytest.mark.each
@pytest.mark.slow
@pytest.mark.parametrize(
    ("forward", "back"),
    [
        ([1, *[0] * 11, 0.4, *[0] * 17, 0.3], [1]),
        ([1], [1, *[0] * 11, -0.6]),
        ([1], [1, -1.2, 0.8]),
        ([1 / 8] * 8, [1]),
    ],
    ids=["two copies", "a copy that is copied again", "resonance", "mean of eight samples"],
)
def test_another_filter_has_no_name(forward, back):
    data = sequence()
    assert names(result_of(replace(data, values=lfilter(forward, back, data.values)))) == []


@pytest.mark.slow
def test_a_band_of_noise_is_no_echo():
    assert names(result_of(sequence(BandNoise(1e-3, 5.0, 2.0), label="band"))) == []


@pytest.mark.slow
def test_its_interval_holds_its_size_as_often_as_it_says():
    """In 95 of 100 logs, less four deviations."""
    inside = 0
    for run in range(100):
        data = behind(sequence(count=4000, label=f"inside {run}"), Echo(0.4, 12))
        low_high = intervals(fit(data, KNOWN.adding(Echo(0.3, 12))), 1)["size"]
        inside += low_high.low < 0.4 < low_high.high
    assert inside >= 86


def test_a_delay_beyond_what_a_block_keeps_is_refused():
    with pytest.raises(ValueError, match=r"echo\.delay: expected a whole number in \[1, 100000\]; found 8.*e\+20"):
        Echo(0.5, 8.9e20)
