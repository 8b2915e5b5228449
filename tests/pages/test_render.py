"""Rendering of a page: what stands between backticks is code, and nothing else is taken as markup."""

from imugap.pages.page import Page, Part, Points, Text
from imugap.pages.render import fragment


def test_commands_in_sentences_are_shown_as_code():
    parts = (Part("Next", (Text("Run `imugap check`."), Points(("`<stddev>` & more",)))),)
    shown = fragment(Page("Title", ("See `imugap discover`.",), True, parts))
    assert "<p>See <code>imugap discover</code>.</p>" in shown
    assert "<p>Run <code>imugap check</code>.</p>" in shown
    assert "<li><code>&lt;stddev&gt;</code> &amp; more</li>" in shown
