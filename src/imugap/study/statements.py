"""What the paper states in its abstract, in the first paragraphs of its sections and in its conclusion.

The text marks these paragraphs (``statement``) and takes every value in them from a product of the workflow
(``claim``), both in ``paper/style.typ``. Here the values are listed with the cells that they rest on, and checked:

- every section of the main text has a statement;
- each value is the one in its cell, and, but for those of the abstract, a figure, table or section is cited after it;
- nothing else in a statement is a number or a word for a direction. Digits may stand in a name or in the number of a
  standard (ADIS16405, JJF 1535-2015), in the level of an interval or band and in the name of a percentile (95 %
  interval, 95th percentile). A word for a direction may stand in italics, where it is defined.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import typst

NAME = re.compile(r"[A-Za-z]\w*\d\w*|\b[A-Z]{2,} \d[\d-]*")
LEVEL = re.compile(r"\b\d+(?:\s?%\s(?:intervals?|band)|th percentile)\b")
NUMBER = re.compile(r"\d[\d.]*")
DIRECTION = re.compile(
    r"\b(?:better|worse|nearer|farther|missed|met|level|within the floor"
    r"|(?:smaller|larger|greater|higher|lower|fewer) than)\b"
)
CITED = re.compile(r"<((?:fig|tab|sec|app)-.*)>")
SELECTOR = "selector.or(<claim>, <statement>, <statement-end>, heading.where(level: 1), ref)"
ABSTRACT = "abstract or summary"
COLUMNS = ["section", "page", "file", "cell", "value", "cited"]


def collect(main: str | Path) -> tuple[pd.DataFrame, list[str]]:
    """List the values that a text states, and its faults.

    Parameters
    ----------
    main
        The text, in Typst; its products lie in the folders ``numbers`` and ``tables`` beside it.

    Returns
    -------
    table : DataFrame
        A row per value: ``section``, ``page``, ``file`` and ``cell`` where it stands, ``value`` as the text has it, and
        the label of the figure, table or section that is ``cited`` next.
    faults : list of str
        What contradicts the rules of this module.
    """
    folder = Path(main).parent
    section, inside, has, rows, faults = ABSTRACT, False, False, [], []
    for one in json.loads(typst.query(str(main), SELECTOR, root=str(folder))):
        match one:
            case {"label": "<statement>", "value": body}:
                inside, has = True, True
                faults += [f"{section}: typed in a statement: {found}" for found in typed(words(body))]
            case {"label": "<statement-end>"}:
                inside = False
            case {"label": "<claim>", "value": claim} if inside:
                rows.append(row(folder, claim) | {"section": section, "cited": ""})
            case {"func": "ref", "target": target} if inside and (found := CITED.fullmatch(target)):
                for other in rows:
                    if other["section"] == section and not other["cited"]:
                        other["cited"] = found[1]
            case {"func": "heading"}:
                faults += [] if has else [f"{section}: no statement"]
                section = words(one["body"]).strip()
                has = one["numbering"] is None or words(one["supplement"]) == "Appendix"
    faults += [] if has else [f"{section}: no statement"]
    faults += [
        f"{one['section']}: {one['cell']} in {one['file']} is {one['there']}, the text has {one['value']}"
        for one in rows
        if one["there"] != one["value"]
    ]
    faults += [
        f"{one['section']}: nothing is cited after {one['value']} ({one['cell']} in {one['file']})"
        for one in rows
        if not one["cited"] and one["section"] != ABSTRACT
    ]
    return pd.DataFrame(rows, columns=COLUMNS), faults


def row(folder: Path, claim: dict) -> dict[str, object]:
    """Return a row of the list: where a value comes from, as the text has it, and as it is there."""
    there = read(folder, claim["file"], claim["path"])
    return {"page": claim["page"], "file": claim["file"], "cell": place(claim["path"]),
            "value": shown(claim["value"]), "there": shown(there)}  # fmt: skip


def words(content: object) -> str:
    """Return the typed text of a content of Typst; values of the products, formulas and italics are a space."""
    match content:
        case list():
            return "".join(map(words, content))
        case {"func": "emph" | "context" | "equation" | "metadata"}:
            return " "
        case {"func": "space" | "parbreak" | "linebreak"}:
            return " "
        case {"text": text}:
            return str(text)
        case dict():
            return "".join(words(part) for key, part in content.items() if key in ("body", "children", "child"))
    return ""


def typed(text: str) -> Iterator[str]:
    """Yield the numbers and the words for a direction in a typed text."""
    rest = NAME.sub(" ", LEVEL.sub(" ", text.replace("\u00a0", " ")))
    for found in (*NUMBER.finditer(rest), *DIRECTION.finditer(rest)):
        around = rest[max(found.start() - 30, 0) : found.end() + 30].split()
        yield f"{found.group()!r} in “{' '.join(around)}”"


def read(folder: Path, file: str, path: list) -> object:
    """Return the value at a place of a product, or None where there is no such place."""
    found = json.loads((folder / f"{file}.json").read_text())
    for step in path:
        if isinstance(step, dict):
            rows = [dict(zip(found["columns"], row, strict=True)) for row in found["rows"]]
            found = next((row for row in rows if step.items() <= row.items()), None)
        else:
            found = found.get(step) if isinstance(found, dict) else found[step]
    return found


def place(path: list) -> str:
    """Return a place as a reader finds it: the cells that name a row, then keys and heads."""
    steps = [" ".join(step.values()) if isinstance(step, dict) else str(step) for step in path]
    return " / ".join(steps)


def shown(value: object) -> str:
    """Return a value as the text shows it."""
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
