"""Steps of discovery."""

from imugap.discovery.steps import Memory


def test_what_was_made_of_the_same_is_the_same_and_of_others_is_not():
    memory, made = Memory(), []

    def listed(*of):
        made.append(of)
        return [*of]

    first, again, other = (memory.once(listed, *of) for of in ((1, "a"), (1, "a"), (2, "a")))
    assert first is again
    assert other == [2, "a"]
    assert made == [(1, "a"), (2, "a")]
