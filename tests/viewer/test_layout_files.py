"""Layout files: what they may say, what is wrong with others, and nothing is lost in between."""

import re

import pytest

from teleopctl import plugins
from teleopctl.viewer import LayoutError, PageLayout, layout_of, load_layout, presets
from teleopctl.viewer.layout import PanelColumn
from teleopctl.viewer.rviz_file import View

SMALL = {"version": 1, "title": "Mine", "right": {"width": 300, "panels": [["joints"], ["log"]]}}


def test_each_preset_names_panels_that_exist_and_a_whole_page_has_them_all():
    every = {*plugins.available(plugins.PANELS)}
    for name in presets():
        assert {*load_layout(name).names()} <= every
    for name in ("control", "display", "perception"):
        assert {*load_layout(name).names()} == every


def test_what_is_saved_is_read_again(tmp_path):
    layout = PageLayout(
        "Mine",
        left=PanelColumn((("scene",),), 200, is_minimized=True),
        right=PanelColumn((("joints", "plot"), ("camera",))),
        bar=("simulation",),
        robot="arm",
        view=View((1.0, 2.0, 3.0), (0.0, 0.0, 0.5)),
        states={"camera": {"/left": False}},
    )
    file = tmp_path / "mine.yaml"
    file.write_text(layout.text(), encoding="utf-8")
    assert load_layout(file) == layout


def test_panels_are_added_to_the_last_stack_and_left_out_anywhere():
    layout = layout_of(SMALL, "here")
    assert layout.changed(["plot"], ["joints"]).right.stacks == (("log", "plot"),)
    assert layout.changed(["log"], []).right.stacks == layout.right.stacks
    assert PageLayout().changed(["plot"], []).right.stacks == (("plot",),)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"version": 7}, "version 7; this page reads version 1"),
        ({"right": {"panels": [["joint"]]}}, "there is no panel 'joint'"),
        ({"left": {"panels": [["log"]]}}, "the panel log stands there twice"),
        ({"right": {"width": "wide"}}, "the width of 'right' is 'wide'"),
        ({"right": {"panels": "log"}}, "a list of at most"),
        ({"right": {"panels": ["log"]}}, "it has to be a list of panels"),
        ({"right": ["log"]}, "'right' is a mapping"),
        ({"left": {"minimized": "yes"}}, "neither true nor false"),
        ({"view": {"eye": [1, 2]}}, "'view' is a mapping with 'eye' and 'focus'"),
        ({"view": {"eye": [1, 2, float("nan")], "focus": [0, 0, 0]}}, "each three numbers"),
        ({"panels": ["log"]}, "'panels' is a mapping"),
        ({"top": {}}, "a layout has no 'top'"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(change, words):
    with pytest.raises(LayoutError, match=re.escape(words)) as caught:
        layout_of({**SMALL, **change}, "mine.yaml")
    assert caught.value.message.startswith("mine.yaml: ")


def test_an_unknown_layout_is_refused_with_those_that_exist():
    with pytest.raises(LayoutError, match="no layout controll") as caught:
        load_layout("controll")
    assert "Did you mean control?" in str(caught.value.hint)
