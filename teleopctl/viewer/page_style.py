"""Style of the page: lists that are read in full, a low bar, and on a phone controls for a thumb.

A list is as narrow as its field, and viser cuts the end of what it offers. On a phone viser's sheet
has the width and the buttons of a panel for a mouse: 266 of 390 pixels, and buttons of 50 x 18. The
sections of panels lie side by side in two columns; an open one takes both.

The button that stops or releases the robot stays on the strip of a closed sheet.

While a window is open all else can be used, such as the button that stops the robot: viser would
darken and block it.

What is folded has no height at once. viser folds its settings away while the page is built up,
which takes seconds on a busy machine: the bar would cover the robot with an empty box meanwhile.
"""

from __future__ import annotations

import json

# viser shows its sheet up to this width.
_PHONE = "(max-width: 36em)"
_SHEET = '.mantine-Paper-root[style*="position: fixed"]'
_SECTIONS = "div:has(> .mantine-Tabs-root > [role=button][aria-expanded])"
_FOLDED = '[style*="opacity: 0;"][style*="transition: height"]'
_STOP = ".mantine-Button-root:has([class*=icon-tabler-hand-])"
# An open section of several tabs has its tabs in place of the button that opens it.
_OPEN = ".mantine-Tabs-root:not(:has(> [aria-expanded=false]))"
_STYLE = f"""
{_FOLDED} {{
  height: 0 !important; overflow: hidden; visibility: hidden }}
.mantine-Modal-overlay {{ display: none !important }}
.mantine-Modal-inner {{ pointer-events: none !important }}
.mantine-Modal-content {{ pointer-events: auto !important; border: 1px solid #8a94a080 }}
[role=option] span {{ white-space: normal !important; overflow-wrap: anywhere }}
@media {_PHONE} {{
  {_SHEET}, {_SHEET} div[style*="width: 20em"] {{ width: 100% !important }}
  {_SHEET} div[style*="height: 3.5em"] {{ height: 40px !important }}
  {_SHEET} .mantine-ActionIcon-root {{ width: 40px; height: 40px; min-width: 40px }}
  {_SHEET} .mantine-Button-root {{ height: 38px !important; min-width: 0; flex-basis: 0 }}
  {_SHEET} [role=tab] {{ min-height: 40px }}
  {_SHEET} .mantine-Input-input {{ min-height: 36px }}
  {_SHEET} .mantine-Slider-thumb::after {{ content: ""; position: absolute; inset: -14px }}
  {_SHEET} .teleopctl-marks {{ padding: 0 57px 0 96px !important }}
  {_SHEET} {_FOLDED} {{ opacity: 1 !important }}
  {_SHEET} {_FOLDED} {_STOP} {{
    visibility: visible; pointer-events: auto; position: fixed; z-index: 1;
    right: 8px; bottom: 3px; width: auto; max-width: 70%; height: 34px !important }}
  {_SECTIONS} {{ display: grid; grid-template-columns: 1fr 1fr }}
  {_SECTIONS} > {_OPEN} {{ grid-column: 1 / -1; order: -1 }}
  {_SECTIONS} > * > [role=button] {{ min-height: 40px !important }}
  {_SECTIONS} > * > [role=button] > p {{ white-space: normal; line-height: 1.15 }}
}}
"""

SCRIPT = f"""
const style = document.getElementById("teleopctl-style") ?? document.createElement("style");
style.id = "teleopctl-style";
style.textContent = {json.dumps(_STYLE)};
document.head.append(style);
// What is folded is invisible, but for that button, which "inert" would make useless.
window.teleopctlReach ??= new MutationObserver((changes) => {{
  for (const {{target}} of changes) if (target.closest({json.dumps(_SHEET)})) target.inert = false;
}});
window.teleopctlReach.observe(document.body, {{subtree: true, attributeFilter: ["inert"]}});
"""
"""Script that adds the style to the page."""
