"""The strict reader of YAML: what it reads is what other readers read, and what is ambiguous or endless is refused."""

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from imugap.io import strict_yaml
from imugap.io.strict_yaml import StrictYamlError, parse

FLAT = (
    st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.floats(-1e9, 1e9) | st.text("abc 1:#'é\n", max_size=8)
)
NESTED = st.recursive(FLAT, lambda one: st.lists(one, max_size=3) | st.dictionaries(st.text("abc", min_size=1), one))


@given(NESTED)
def test_what_is_dumped_is_read_back(value):
    assert parse(yaml.safe_dump(value), "file") == value


LEVELS = zip("abcdefg", "bcdefgh", strict=True)
BOMB = "[&a [1]" + "".join(f", &{b} [{8 * f'*{a},'}]" for a, b in LEVELS) + "]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 0100", "line 1, column 4: expected a decimal number, true, false, or text in quotes; found '0100'"),
        ("a: 1:30", "line 1, column 4: expected a decimal number, .*; found '1:30'"),
        ("a: 1_000", "expected a decimal number, .*; found '1_000'"),
        ("a: 0x1f", "expected a decimal number, .*; found '0x1f'"),
        ("a: yes", "expected a decimal number, .*; found 'yes'"),
        ("a: .nan", "expected a decimal number, .*; found '.nan'"),
        ("a: 1e999", "line 1, column 4: expected a finite number; found '1e999'"),
        (f"a: {'1' * 400}", r"line 1, column 4: expected a finite number; found '1{39}\.\.\. \(402 characters\)"),
        ("a: 1\na: 2", "line 2, column 1: expected every key once; found 'a' again"),
        ("1: a", "line 1, column 1: expected text as a key; found 1"),
        ("a: &b [*b]", r"line 1, column 8: expected an alias of a complete value above; found \*b"),
        ("a: *b", r"expected an alias of a complete value above; found \*b"),
        ("a: !!python/object:os.system x", "line 1, column 4: expected a value without a tag; found tag:"),
        ("--- 1\n--- 2", "line 2, column 1: expected one document; found another one"),
        ("a: [", "line 2, column 1: expected YAML; found a fault"),
        ("'\x07'", "character 1: expected YAML; found a fault"),
        ("[" * 100_000, "line 1, column 21: expected at most 20 values within one another; found more"),
        ("[" * 20 + "[]" + "]" * 20, "expected at most 20 values within one another; found more"),
        (f"[{'1,' * 60_000}]", "expected at most 50000 values; found more"),
        (BOMB, "expected at most 50000 values; found more, aliases counted by what they stand for"),
    ],
    ids=lambda text: text[:20],
)  # fmt: skip
def test_a_fault_is_named_by_line_and_column(text, message):
    with pytest.raises(StrictYamlError, match=f"^file: .*{message}") as caught:
        parse(text, "file")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None),
        ("# nothing", None),
        ("a: 1e-4", {"a": 1e-4}),
        ("a: +1", {"a": 1}),
        ("a: 5.", {"a": 5.0}),
        ("a: '0100'", {"a": "0100"}),
        ("x: &a {b: 1}\ny: *a", {"x": {"b": 1}, "y": {"b": 1}}),
        ("y: n", {"y": "n"}),
        ("\ufeffa: 1", {"a": 1}),
    ],
)
def test_what_is_meant_is_read(tmp_path, text, value):
    path = tmp_path / "file.yaml"
    path.write_text(text, encoding="utf-8")
    assert strict_yaml.read(path) == value


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"a: \xff", "line 1: expected UTF-8; found the byte 0xff"), (b"#" * 1_000_001, "expected at most 1000000 bytes")],
)
def test_a_file_that_is_no_text_or_too_large_is_refused(tmp_path, content, message):
    path = tmp_path / "file.yaml"
    path.write_bytes(content)
    with pytest.raises(StrictYamlError, match=f"file.yaml: .*{message}"):
        strict_yaml.read(path)
