"""Steps are translated as they are, and what is outside of the subset is refused."""

import pytest

from imugap.interchange.code.translation import draws, to_cpp, to_python


def sound(own, x, now):
    total = 0.0
    first = own.first
    for k in range(len(own.weights) - 1, -1, -1):
        total = total + own.weights[k] * now.at(own.channel, first + k)
    if total > 1.0 and x < 0.0:
        total = -own.draw.normal()
    else:
        own.last = total
    return total if x != 0.0 else own.last


def calling(own, x, now):
    return abs(x)


def looping(own, x, now):
    while x > 1.0:
        x = x / 2.0
    return x


def test_a_step_in_both_languages():
    assert "return total if x != 0.0 else self.last" in to_python(sound)
    text = to_cpp(sound, {"weights": [1.0], "first": 2, "channel": 3, "last": 0.0})
    assert text.splitlines()[:4] == [
        "double total = 0.0;",
        "int first = this->first;",
        "for (int k = (static_cast<int>(this->weights.size()) - 1); k > -1; --k) {",
        "  total = (total + (this->weights[k] * now.at(this->channel, (first + k))));",
    ]
    assert text.splitlines()[-1] == "return (x != 0.0 ? total : this->last);"
    assert draws(sound)
    assert not draws(looping)


def test_what_is_no_step_is_refused():
    with pytest.raises(ValueError, match=r"expected a call of cos, .*; found abs"):
        to_cpp(calling, {})
    with pytest.raises(ValueError, match="expected a statement of the subset; found 'while"):
        to_cpp(looping, {})
