"""Texts of others on the page: shown, never obeyed."""

import html
from html.parser import HTMLParser

from hypothesis import given, strategies

from teleopctl.base.printable import printable_line
from teleopctl.viewer.html import escaped_html, escaped_markdown


class Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.text = ""
        self.tags: list[str] = []

    def handle_data(self, data):
        self.text += data

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)


@given(strategies.text(max_size=100))
def test_a_browser_reads_the_text_and_no_element(text):
    reader = Reader()
    reader.feed(f"<p>{escaped_html(text)}</p>")
    reader.close()
    assert reader.tags == ["p"]
    assert reader.text == printable_line(text)


@given(strategies.text(strategies.characters(exclude_categories=("C", "Z")), max_size=100))
def test_no_sign_has_a_meaning_in_markdown(text):
    written = escaped_markdown(text)
    assert html.unescape(written) == text
    assert not set(written) & set("<>*_`[]()!|~$\\:/@\"'")


def test_long_texts_are_cut():
    assert escaped_html("x" * 1000, 10) == "x" * 10 + "…"
