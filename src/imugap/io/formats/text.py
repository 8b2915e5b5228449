"""Tables as text: any separator, decimal comma, comments, lines before the header, units below it, byte order mark.

The dialect is recognised on the first lines; the rows are read by Arrow. A file is read line by line only to locate an
error.
"""

import codecs
import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, takewhile
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.csv

from imugap.io.formats import clock_text
from imugap.io.formats.source import Source
from imugap.io.formats.text_blocks import BLOCK_BYTES, blocks
from imugap.io.recognition.unit_text import looks_like_unit
from imugap.log import LogError

HEAD_BYTES = 1 << 16
SAMPLE_ROWS = 200
FIRST_ROWS = 3
"""Lines of numbers that follow each other at the begin of a table; a line of numbers alone may be of its head."""
SEPARATORS = (",", ";", "\t", "|", " ")
COMMENT = ("#", "%", "//", ";;", "!")
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.IGNORECASE)
COMMA_NUMBER = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
INTEGER = re.compile(r"[-+]?\d{1,18}")
STAMP = re.compile(r"\d{4}-\d\d-\d\d[ T]\d\d:[0-5]\d:[0-5]\d(\.\d+)?(Z|[+-]\d\d:?\d\d)?")
"""Dates that are read as such by the reader of tables; others are read as texts."""
ZONE = re.compile(r"(Z|[+-]\d\d:?\d\d)$")
ENCODINGS = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16", codecs.BOM_UTF8: "utf-8-sig"}
MISSING = [
    "", "nan", "NaN", "NAN", "Nan", "NA", "N/A", "n/a", "null", "NULL", "None", "#N/A", "-nan", "nan(ind)", "-nan(ind)",
    "-1.#IND", "1.#IND", "1.#QNAN", "-1.#QNAN", "--", "-",
]  # fmt: skip
RATE = re.compile(r"(\w*\s?(?:rate|frequency|frequenz)|odr)\b[^\d\n]{0,12}(\d+\.?\d*)\s*(k?)hz", re.IGNORECASE)
"""Words of a sampling rate in the head of a table."""
VALUE = re.compile(r"[-+\"']*\.?\d|[\[(].*\d")
"""Begin of a cell that is a value and no name."""
STEPS = {
    r"^[-+]?0[xX]": "hexadecimal words: write them as decimal numbers",
    r"^[-+]?[\d.]+[dD][-+]?\d+$": "exponents of Fortran: write E in place of D",
    r"^[\"']*[\[(]": "a list in a cell: write a column for each axis",
}
"""What to do about cells that are no numbers, by their form."""
ODD, MOST_ODD = 1e-3, 10_000
"""Share of lines that are no rows below which they are left out, and the largest number of them."""
EXCERPT = 60
UNENDED = "left out the last line, which has no end"
LONG = 9
"""Digits of a whole number above which a column of such is read as integers."""


@dataclass(frozen=True)
class Dialect:
    """How a text holds its table.

    Attributes
    ----------
    encoding
        Name of the encoding.
    separator
        Character between values; a blank stands for any number of blanks and tabs.
    decimal
        Decimal point or comma.
    names
        Names of the columns; empty texts where there is no header.
    first
        Number of lines before the first row.
    sample
        Cells of the first rows.
    width
        Number of values in a row.
    end
        Number of bytes up to the end of the last line that has one.
    header
        Line before the first row, where there are names; it may stand again among the rows.
    rate
        Sampling rate that the lines before the rows state [Hz], and these words; None where there is none.
    odd
        Lines among and behind the rows that are none, and are left out.
    """

    encoding: str
    separator: str
    decimal: str
    names: tuple[str, ...]
    first: int
    sample: tuple[tuple[str, ...], ...]
    width: int
    end: int
    header: str | None
    rate: tuple[float, str] | None
    odd: frozenset[str] = frozenset()

    def is_row(self, line: str) -> bool:
        """Return whether a line behind the head is a row: neither empty, nor the header again, nor left out."""
        return bool(line.strip()) and line.strip() != self.header and _plain(line) not in self.odd


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is text: no zero bytes, unless in UTF-16."""
    return _encoding(head) == "utf-16" or b"\x00" not in head


def open_source(path: Path, settings) -> Source:
    """Return the columns of a text; LogError where it has no rows of numbers.

    A last line without an end may be cut off within a number, and is left out; LogError where it is one of two rows.
    """
    dialect = _without_odd(path, sniff(path))
    rest = _rest(path, dialect.end)
    if rest and len(dialect.sample) <= 2:
        expected = "a line end after the last row (add it if the row is whole, remove the row if it is cut off)"
        last = rest.decode(dialect.encoding, errors="replace")
        raise LogError(
            path, place(path, dialect, len(dialect.sample) - 1), expected, f"the end of the file after {last!r}"
        )
    orders = _orders(path, dialect)
    dated = [
        order.sentence(dialect.names[k] or f"column {k + 1}")
        for k, order in orders.items()
        if isinstance(order, clock_text.Order)
    ]
    return Source(
        path,
        dialect.names,
        _lines(path),
        lambda columns: _batches(path, dialect, columns, orders),
        lambda row: place(path, dialect, row),
        notes=(*([UNENDED] if rest else []), *_said(path, dialect), *dated),
        heading=f"line {max(dialect.first, 1)}",
        whole=frozenset(name for k, name in enumerate(dialect.names) if _is_whole(dialect, k)),
        clocks=frozenset(k for k in range(len(dialect.names)) if _is_clock(dialect, k)),
        rate=dialect.rate,
        cells=lambda column: _texts(path, dialect, column),
    )


def _without_odd(path: Path, dialect: Dialect) -> Dialect:
    """Return the dialect with the lines of another number of values left out, where they are few or behind all rows."""
    odd: list[str] = []
    try:
        for _ in _read(path, dialect, {0: pa.string()}, odd):
            if len(odd) > MOST_ODD:
                return dialect
    except pa.ArrowInvalid:
        return dialect
    found = frozenset(odd)
    if not odd or not (len(odd) < ODD * _lines(path) or _behind(path, dialect, found) == found):
        return dialect
    sample = tuple(row for row in dialect.sample if len(row) == dialect.width)
    return replace(dialect, odd=found, sample=sample)


def _behind(path: Path, dialect: Dialect, odd: frozenset[str]) -> frozenset[str]:
    """Return which of some lines stand behind all rows and are not of numbers alone, as rows that are cut off are."""
    with path.open("rb") as handle:
        handle.seek(max(dialect.end - HEAD_BYTES, 0))
        lines = handle.read(min(dialect.end, HEAD_BYTES)).decode(dialect.encoding, errors="replace").splitlines()
    last = filter(None, takewhile(lambda line: not line or line in odd, map(_plain, reversed(lines))))
    return frozenset(line for line in last if not all(map(_is_number, filter(None, _cells(line, dialect.separator)))))


def _said(path: Path, dialect: Dialect) -> tuple[str, ...]:
    """Return which lines are left out, a sentence; none where there are none."""
    if not dialect.odd:
        return ()
    with path.open(encoding=dialect.encoding, errors="replace") as handle:
        lines = [
            (number, line.strip())
            for number, line in enumerate(handle, 1)
            if number > dialect.first and _plain(line) in dialect.odd
        ]
    number, text = lines[0]
    count = "1 line that is no row" if len(lines) == 1 else f"{len(lines)} lines that are no rows, the first"
    return (f"left out {count} at line {number}: {text[:EXCERPT]!r}",)


def _plain(line: str) -> str:
    """Return a line with one blank for any number of blanks and tabs."""
    return " ".join(line.split())


def of_lines(path: Path, lines: Iterable[str]) -> Source:
    """Return the columns of lines that hold a table within a file, in memory."""
    with TemporaryDirectory() as folder:
        part = Path(folder) / "lines.csv"
        with part.open("w", encoding="utf-8") as handle:
            handle.writelines(lines)
        return loaded(path, open_source(part, None))


def loaded(path: Path, source: Source) -> Source:
    """Return the columns of a table in memory, numbers or else texts, as those of a file."""
    columns = [_column(source, k) for k in range(len(source.names))]
    return replace(
        source,
        path=path,
        rows=len(columns[0]),
        batches=lambda chosen: iter([[_as_numbers(columns[k]) for k in chosen]]),
        place="row {}".format,
        cells=lambda column: iter([columns[column].astype(str)]),
    )


def _column(source: Source, column: int) -> np.ndarray:
    """Return a column as whole numbers where it is written so, as numbers, or else as texts."""
    try:
        values = np.concatenate([one for (one,) in source.batches([column])])
    except LogError:
        return np.concatenate(list(source.texts(column)))
    return values.astype(np.int64) if source.names[column] in source.whole and np.isfinite(values).all() else values


def _as_numbers(values: np.ndarray) -> np.ndarray:
    """Return values; as numbers, texts are NaN."""
    return values if values.dtype.kind in "iuf" else np.full(len(values), np.nan)


def _lines(path: Path) -> int:
    """Return the number of lines, or a larger one."""
    for end in (b"\n", b"\r"):
        with path.open("rb") as handle:
            ends = sum(block.count(end) for block in iter(lambda: handle.read(BLOCK_BYTES), b""))
        if ends:
            return ends + 1
    return 1


def sniff(path: Path) -> Dialect:
    """Recognise the dialect on the first lines; LogError with the first line where there are no rows of numbers."""
    with path.open("rb") as handle:
        head = handle.read(HEAD_BYTES)
    if not head.strip():
        raise LogError(path, "line 1", "a header and rows of numbers", "an empty file")
    encoding = _encoding(head)
    text = head.decode(encoding, errors="replace")
    lines = text.splitlines()
    whole = lines if len(head) < HEAD_BYTES else lines[:-1]
    best = max((_table(whole, separator) for separator in SEPARATORS), key=lambda one: one[0])
    _, separator, first, rows = best
    if not rows:
        if any(len(_cells(line, mark)) > 1 for line in whole for mark in SEPARATORS):
            raise _no_rows(path, whole)
        raise LogError(path, "line 1", "a header and rows of numbers", repr(lines[0][:EXCERPT]))
    width = Counter(map(len, rows)).most_common(1)[0][0]
    names = _header(whole[:first], separator, width, all(not row[-1] for row in rows if len(row) == width))
    if first and not any(names) and 2 * len(_cells(whole[first - 1], separator)) == width:
        expected = "another separator than the decimal comma, or a decimal point"
        raise LogError(path, f"line {first + 1}", expected, f"{width} values below {width // 2} names")
    rate = _rate(whole[:first])
    decimal = "," if _has_commas(rows) else "."
    header = whole[first - 1].strip() if first and any(names) else None
    return Dialect(encoding, separator, decimal, names, first, tuple(rows), width, _end(path, encoding), header, rate)


def _no_rows(path: Path, lines: list[str]) -> LogError:
    """Return the error of a text without rows of numbers: its first cell that is a value and no number, or its rows."""
    told = [
        (number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith(COMMENT)
    ]
    for number, line in told:
        cells = next((cells for mark in SEPARATORS if len(cells := _cells(line, mark)) > 1), [])
        cell = next((one for one in cells if VALUE.match(one) and not _is_number(one)), None)
        if cell is not None:
            step = next((step for form, step in STEPS.items() if re.search(form, cell)), "write decimal numbers")
            return LogError(path, f"line {number}", f"rows of numbers ({step})", f"{cell[:EXCERPT]!r}")
    if len(told) > 1:
        number, line = told[1]
        return LogError(path, f"line {number}", "rows of numbers, below a line of names", repr(line.strip()[:EXCERPT]))
    return LogError(path, "rows", "at least 2 samples", "0")


def place(path: Path, dialect: Dialect, row: int) -> str:
    """Return the line of a row, counted from 1 with all lines."""
    with path.open(encoding=dialect.encoding, errors="replace", newline=None) as handle:
        rows = (number for number, line in enumerate(handle, 1) if number > dialect.first and dialect.is_row(line))
        return f"line {next(islice(rows, row, None), dialect.first + row + 1)}"


def _encoding(head: bytes) -> str:
    for mark, encoding in ENCODINGS.items():
        if head.startswith(mark):
            return encoding
    try:
        head[: head.rfind(b"\n") + 1].decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _has_commas(rows: list[tuple[str, ...]]) -> bool:
    """Return whether numbers have a decimal comma; where others have a point, commas are between thousands."""
    numbers = [cell for row in rows for cell in row if _is_number(cell)]
    return any("," in one for one in numbers) and not any("." in one for one in numbers if "," not in one)


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def _is_number(cell: str) -> bool:
    """Return whether a cell is a number; with a decimal comma between commas it stood in quotes."""
    return bool(NUMBER.fullmatch(cell) or COMMA_NUMBER.fullmatch(cell))


def _is_row(cells: list[str]) -> bool:
    """Return whether cells are a row: two numbers or more, and a third of the cells that are not empty."""
    numbers = sum(map(_is_number, cells))
    filled = sum(bool(cell) for cell in cells)
    return numbers >= min(2, max(filled, 1)) and 3 * numbers >= filled


def _table(lines: list[str], separator: str) -> tuple[float, str, int, list[tuple[str, ...]]]:
    """Return how much of the lines is a table with this separator, and the first rows of it."""
    cells = [(number, _cells(line, separator)) for number, line in enumerate(lines) if line.strip()]
    are_rows = [_is_row(row) and not lines[number].lstrip().startswith(COMMENT) for number, row in cells]
    begins = [(cells[k][0], all(are_rows[k : k + FIRST_ROWS])) for k in np.flatnonzero(are_rows)]
    first = next((number for number, goes_on in begins if goes_on), begins[0][0] if begins else len(lines))
    rows = [tuple(row) for number, row in cells if number >= first][:SAMPLE_ROWS]
    numbers = sum(_is_number(cell) for row in rows for cell in row)
    texts = sum(bool(cell) and not _is_number(cell) for row in rows for cell in row)
    return (numbers - texts) / max(len(rows), 1), separator, first, rows


def _header(lines: list[str], separator: str, width: int, trailing: bool) -> tuple[str, ...]:
    """Return the names of the columns from the lines before the first row.

    A line of units below the names is joined to them, and lines of one word between them are none of names; names that
    repeat are joined to those of groups above them.
    ``trailing``: whether the rows end with a separator.
    """
    split = (_names(line.lstrip("\ufeff").strip(), separator, width) for line in lines)
    rows = [_fitted(cells, width, trailing) for cells in split if cells is not None]
    if not rows:
        return ("",) * width
    names = rows[-1]
    if len(rows) > 1 and _are_units(names):
        above = next((row for row in reversed(rows[:-1]) if len(set(row)) > 1), rows[-2])
        names = [f"{name} [{unit}]" if unit else name for name, unit in zip(above, names, strict=False)]
    elif len(rows) > 1 and len(set(names)) < width == len(set(zip(rows[-2], names, strict=True))):
        names = [f"{group}.{name}" for group, name in zip(rows[-2], names, strict=True)]
    return tuple(names)


def _rate(lines: list[str]) -> tuple[float, str] | None:
    """Return the sampling rate that a line of the head states [Hz], and its words; None where none or several do."""
    found = {float(one[2]) * (1e3 if one[3].lower() == "k" else 1.0): one[1] for one in map(RATE.search, lines) if one}
    known = [(rate, " ".join(words.split())) for rate, words in found.items() if rate > 0]
    return known[0] if len(known) == 1 else None


def _names(line: str, separator: str, width: int) -> list[str] | None:
    """Return the names in a line, one for each column if any way to split it gives that; None where none is near."""
    splits = [_cells(line, separator)]
    if separator == " ":
        splits += [re.split(r"\s{2,}|\t|:\s*", line.rstrip(": ")), re.sub(r"\s+(?=[\[(])", "", line).split()]
        splits += [cells[1:] for cells in splits if cells and cells[0] in COMMENT]
    for cells in sorted(splits, key=lambda cells: len(cells) != width):
        named = sum(bool(cell) for cell in cells)
        if width - 1 <= len(cells) <= width + 1 and named >= min(2, width):
            return cells
    return None


def _fitted(cells: list[str], width: int, trailing: bool) -> list[str]:
    """Return one name for each value of a row.

    A name less: the values end with a separator, or begin with the number of the row, as tables of R do. A name more:
    that of a remark, which no row has, or of what stands behind a last separator.
    """
    if len(cells) < width:
        return [*cells, ""] if trailing else ["", *cells]
    return cells[:width]


def _are_units(cells: list[str]) -> bool:
    """Return whether cells are units, such as stand in the line below the names."""
    units = [text for cell in cells if (text := cell.strip("[]()"))]
    return 2 * sum(map(looks_like_unit, units)) > len(units)


def _orders(path: Path, dialect: Dialect) -> dict[int, clock_text.Order | ValueError]:
    """Return the order of day, month and year of the columns of such dates, or why it is not known."""
    orders: dict[int, clock_text.Order | ValueError] = {}
    for column in range(len(dialect.names)):
        if not pa.types.is_string(_kind(dialect, column)):
            continue
        try:
            order = clock_text.order_of(batch[column] for batch in _read(path, dialect, {column: pa.string()}))
            orders |= {} if order is None else {column: order}
        except pa.ArrowInvalid:
            continue
        except ValueError as error:
            orders[column] = error
    return orders


def _batches(
    path: Path, dialect: Dialect, columns: Sequence[int], orders: Mapping[int, clock_text.Order | ValueError]
) -> Iterator[list[np.ndarray]]:
    """Yield the numbers of columns, shape (n,); dates are nanoseconds since 1970, times of day since midnight."""
    kinds = {column: _kind(dialect, column) for column in columns}
    for column in columns:
        if isinstance(unknown := orders.get(column), ValueError):
            raise LogError.at(path, f"column {dialect.names[column] or column + 1}", unknown) from unknown
    try:
        for batch in _read(path, dialect, kinds):
            yield [_numbers(batch[k], orders.get(k)) for k in columns]
    except pa.ArrowInvalid as error:
        raise _diagnosis(path, dialect, columns, str(error)) from error


def _texts(path: Path, dialect: Dialect, column: int) -> Iterator[np.ndarray]:
    """Yield the cells of a column, shape (n,), in the rows of the numbers."""
    try:
        for batch in _read(path, dialect, {column: pa.string()}):
            yield batch[column].fill_null("").to_numpy(zero_copy_only=False)
    except pa.ArrowInvalid as error:
        raise _diagnosis(path, dialect, [], str(error)) from error


def _read(
    path: Path, dialect: Dialect, kinds: Mapping[int, pa.DataType], odd: list[str] | None = None
) -> Iterator[Mapping[int, pa.Array]]:
    """Yield the cells of columns of these kinds; ArrowInvalid where one is of another.

    Lines of another number of values are errors, or left out and listed in ``odd`` where it is given.
    """

    def skip(row) -> str:
        line = _plain(row.text or "")
        if odd is not None and not line.startswith(COMMENT):
            odd.append(line)
        return "skip" if odd is not None or line.startswith(COMMENT) or line in dialect.odd else "error"

    names = [str(k) for k in range(max(len(dialect.names), dialect.width))]
    types = {str(column): kind for column, kind in kinds.items()}
    converting = pa.csv.ConvertOptions(
        column_types=types, include_columns=list(types), null_values=MISSING, strings_can_be_null=True,
        decimal_point=dialect.decimal,
    )  # fmt: skip
    parsing = pa.csv.ParseOptions(delimiter=dialect.separator, invalid_row_handler=skip)
    skipped = dialect.first
    for block in _blocks(path, dialect):
        reading = pa.csv.ReadOptions(
            use_threads=False, column_names=names, skip_rows=skipped, block_size=len(block) + 1
        )
        table = pa.csv.read_csv(pa.BufferReader(block), reading, parsing, converting)
        yield {column: table.column(str(column)).combine_chunks() for column in kinds}
        skipped = 0
    pa.default_memory_pool().release_unused()


def _blocks(path: Path, dialect: Dialect) -> Iterator[bytes]:
    """Yield the lines of a text in blocks, without a header that stands again among the rows.

    Where blanks separate the values, blanks and tabs are one blank, and there is none at the ends of lines.
    """
    header, head = dialect.header.encode() if dialect.header else None, dialect.first
    try:
        for block in blocks(path, dialect.encoding, dialect.end):
            if header and header in block:
                lines = enumerate(block.splitlines(keepends=True))
                block = b"".join(line for k, line in lines if k < head or line.strip() != header)
            if dialect.separator == " ":
                block = b"".join(b" ".join(line.split()) + b"\n" for line in block.splitlines())
            if block.strip():
                yield block
            head = 0
    except UnicodeDecodeError as error:
        raise LogError(path, "bytes", f"text in {dialect.encoding}", error.reason) from error


def _is_whole(dialect: Dialect, column: int) -> bool:
    """Return whether the first rows of a column are whole numbers, without a decimal point."""
    return all(INTEGER.fullmatch(row[column]) for row in dialect.sample if column < len(row) and row[column])


def _kind(dialect: Dialect, column: int) -> pa.DataType:
    """Return the type of a column: integers where doubles would lose digits, dates, times of day, else doubles."""
    cells = [row[column] for row in dialect.sample if column < len(row) and row[column]]
    if cells and all(INTEGER.fullmatch(cell) for cell in cells) and max(map(len, cells)) > LONG:
        return pa.int64()
    if cells and all(STAMP.fullmatch(cell) for cell in cells):
        return pa.timestamp("ns", tz="UTC" if all(ZONE.search(cell) for cell in cells) else None)
    if cells and all(map(clock_text.is_time, cells)):
        return pa.string()
    return pa.float64()


def _is_clock(dialect: Dialect, column: int) -> bool:
    """Return whether a column is of times as texts."""
    kind = _kind(dialect, column)
    return pa.types.is_string(kind) or pa.types.is_timestamp(kind)


def _is_readable(cell: str, kind: pa.DataType) -> bool:
    """Return whether a cell is a value of the kind of its column."""
    if pa.types.is_string(kind):
        return clock_text.is_time(cell)
    if pa.types.is_timestamp(kind):
        return bool(STAMP.fullmatch(cell))
    return _is_number(cell)


def _numbers(values: pa.Array, order: clock_text.Order | None) -> np.ndarray:
    if pa.types.is_timestamp(values.type):
        values = values.cast(pa.int64())
    if pa.types.is_string(values.type):
        return clock_text.nanoseconds(values, order)
    return values.to_numpy(zero_copy_only=False)


def _end(path: Path, encoding: str) -> int:
    """Return the number of bytes up to the end of the last line that has one."""
    with path.open("rb") as handle:
        rest = handle.seek(0, io.SEEK_END)
        while rest:
            begin = max(0, rest - BLOCK_BYTES)
            handle.seek(begin)
            block = handle.read(rest - begin)
            found = max(block.rfind(b"\n"), block.rfind(b"\r"))
            if found >= 0:
                handle.seek(begin + found + 1)
                wide = encoding == "utf-16" and handle.read(1) == b"\x00"
                return begin + found + 1 + wide
            rest = begin
    return 0


def _rest(path: Path, end: int) -> bytes:
    """Return the begin of what stands behind the last line that has an end."""
    with path.open("rb") as handle:
        handle.seek(end)
        return handle.read(EXCERPT).strip(b" \t\x00\x1a")


def _diagnosis(path: Path, dialect: Dialect, columns: Sequence[int], cause: str) -> LogError:
    """Return the first error in a text, line by line, after the fast reader failed with ``cause``."""
    width = max(len(dialect.names), dialect.width)
    names = [name or f"{k + 1}" for k, name in enumerate([*dialect.names, *[""] * (width - len(dialect.names))])]
    kinds = {column: _kind(dialect, column) for column in columns}
    with path.open(encoding=dialect.encoding, errors="replace") as handle:
        for number, line in enumerate(handle, 1):
            if number <= dialect.first or not dialect.is_row(line) or line.lstrip().startswith(COMMENT):
                continue
            if not line.endswith("\n"):
                break
            cells = _cells(line.strip("\r\n"), dialect.separator)
            if len(cells) != width:
                expected = f"{width} values ({', '.join(filter(None, dialect.names))})"
                expected += " (remove the lines that are no rows)"
                return LogError(path, f"line {number}", expected, f"{len(cells)}: {line.strip()[:EXCERPT]!r}")
            for column in columns:
                if cells[column] not in MISSING and not _is_readable(cells[column], kinds[column]):
                    where = f"line {number}, column {names[column]}"
                    alike = pa.types.is_string(kinds[column]) or pa.types.is_timestamp(kinds[column])
                    expected = "a value as in the rows above" if alike else "a number"
                    return LogError(path, where, expected, repr(cells[column][:EXCERPT]))
    return LogError(path, "text", "rows of numbers", cause.splitlines()[0][: 4 * EXCERPT])
