"""The paper as a web page: what Typst exports as HTML, with figures as files beside it and a look for screens."""

import re
from base64 import b64decode
from collections.abc import Iterator

PDF = "paper.pdf"
"""Name of the paper as PDF, beside the page."""
PICTURE = re.compile(r'<img src="data:image/(svg\+xml|png);base64,([^"]+)"')
HEADING = re.compile(r'<h2(?: id="([^"]*)")?>(.*?)</h2>', re.DOTALL)
TAG = re.compile(r"<[^>]+>")
MATHS = re.compile(r'<math display="block".*?</math>', re.DOTALL)
TABLE = re.compile(r"<table.*?</table>", re.DOTALL)
LOOK = """
body{max-width:50rem;margin:0 auto;padding:1rem;color:#1a1a1a;background:#fff;overflow-wrap:anywhere;
font:1.05rem/1.55 Georgia,"Noto Serif","DejaVu Serif",serif}
h1{font-size:1.7rem;line-height:1.25}h2{font-size:1.35rem;margin-top:2.5rem}h3{font-size:1.1rem;margin-top:2rem}
a{color:#00598c}nav ol{list-style:none;padding:0;columns:20rem}
figure{margin:1.75rem 0}figcaption{font-size:.9rem;margin:.5rem 0}img{width:100%;height:auto}
.wide{overflow-x:auto;overflow-wrap:normal}
table{border-collapse:collapse;font-size:.85rem;border-block:2px solid;font-variant-numeric:tabular-nums}
th{border-bottom:1px solid}th,td{text-align:left;vertical-align:top;padding:.2rem .5rem}
pre{overflow-x:auto;font-size:.85rem}.equation-number{text-align:right;margin:-2.2rem 0 1.2rem}
"""


def web_page(exported: str) -> tuple[str, dict[str, bytes]]:
    """Return the page, and the content of each figure by its file name.

    Parameters
    ----------
    exported
        The paper as Typst exports it, figures inside.
    """
    pictures: dict[str, bytes] = {}

    def apart(found: re.Match) -> str:
        name = f"figure_{len(pictures) + 1}.{found[1].partition('+')[0]}"
        pictures[name] = b64decode(found[2])
        return f'<img loading="lazy" src="{name}"'

    text = PICTURE.sub(apart, exported)
    for wide in (TABLE, MATHS):
        text = wide.sub(lambda found: f'<div class="wide" tabindex="0">{found[0]}</div>', text)
    text = _with_anchors(text)
    text = text.replace("</style></head>", f"{LOOK}</style></head>", 1)
    contents = "".join(f'<li><a href="#{anchor}">{title}</a></li>' for anchor, title in _sections(text))
    front = f'<p><a href="{PDF}">The paper as PDF</a></p><nav aria-label="Contents"><ol>{contents}</ol></nav>'
    first = HEADING.search(text)
    return (text if first is None else f"{text[: first.start()]}{front}{text[first.start() :]}"), pictures


def _with_anchors(text: str) -> str:
    """Return the page with an anchor at each section that has none."""
    count = iter(range(1, len(text)))
    return HEADING.sub(lambda found: found[0] if found[1] else f'<h2 id="part-{next(count)}">{found[2]}</h2>', text)


def _sections(text: str) -> Iterator[tuple[str, str]]:
    """Yield anchor and title of each section."""
    for found in HEADING.finditer(text):
        yield found[1], TAG.sub("", found[2])


def link(made: bool) -> str:
    """Return the page of the documentation on the paper, as Markdown, by whether the paper has been made."""
    if not made:
        return (
            "The study makes the paper: `snakemake --cores all`. The site that is built after it has the paper here.\n"
        )
    return (
        "Its numbers, tables and figures are those of the run that this site was built after.\n\n"
        f'<p><a href="paper/index.html">Read it here</a>, or <a href="paper/{PDF}">as PDF</a>.</p>\n'
    )
