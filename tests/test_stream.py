import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from imugap.stream import stream, words

labels = st.lists(st.text(max_size=8) | st.integers(), max_size=4).map(tuple)
seeds = st.integers(0, 2**63)
PINNED = [3474495351533628686, 2451652167927102100, 8456769282483839907, 8305219040395017133]


def numbers(seed, *names):
    return stream(seed, *names).integers(2**63, size=4).tolist()


@given(seeds, labels)
def test_the_same_name_gives_the_same_numbers(seed, names):
    assert numbers(seed, *names) == numbers(seed, *names)


@given(seeds, labels, labels)
def test_other_labels_give_other_numbers(seed, first, second):
    assume(tuple(map(str, first)) != tuple(map(str, second)))
    assert numbers(seed, *first) != numbers(seed, *second)


@given(seeds, seeds, labels)
def test_another_seed_gives_other_numbers(first, second, names):
    assume(first != second)
    assert numbers(first, *names) != numbers(second, *names)


@given(st.text(max_size=5), st.text(min_size=1, max_size=5), st.text(max_size=5))
def test_a_border_between_labels_counts(before, moved, after):
    assert numbers(1, before + moved, after) != numbers(1, before, moved + after)


@pytest.mark.parametrize(
    ("first", "second"), [((), ("",)), (("a",), ("a", "")), (("a", "b"), ("b", "a")), (("1", "0"), ("10",))]
)
def test_empty_and_swapped_labels_count(first, second):
    assert numbers(1, *first) != numbers(1, *second)


def test_a_label_is_its_text():
    assert numbers(1, "run", 2) == numbers(1, "run", "2") == numbers(1, "run", np.int64(2))
    assert numbers(1, 2) != numbers(1, 2.0)


def test_the_stream_is_the_one_of_the_first_release():
    """A result must not change with the release: the numbers are pinned, not computed."""
    assert numbers(20230701, "bench", 1, "gyro_x") == PINNED


def test_numbers_up_to_a_million_do_not_collide():
    assert len({words(str(k)) for k in range(10**6)}) == 10**6


def test_streams_of_neighbouring_labels_are_independent():
    drawn = np.array([stream(1, "run", k).standard_normal(4000) for k in range(12)])
    assert np.abs(np.corrcoef(drawn) - np.eye(12)).max() < 5 / np.sqrt(4000)
    assert abs(drawn.mean()) < 4 / np.sqrt(drawn.size)
