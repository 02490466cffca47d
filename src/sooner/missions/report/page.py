"""The page itself: its style, for screens light and dark and for paper, and its parts in order."""

from __future__ import annotations

import sooner
from sooner.missions.report.drawn import Pictures
from sooner.missions.report.markup import Html, element, joined
from sooner.missions.report.overview import overview
from sooner.missions.report.pilot import pilot_page
from sooner.missions.report.report import Report

__all__ = ["page"]

# nothing is fetched, nothing runs, whatever stands in names and notes
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"

_STYLE = """
:root { color-scheme: light dark; --ink: #22262b; --grey: #5b6470; --paper: #ffffff; --line: #c4c9d0;
  --tint: #f1f3f6; --mark: #0b5c94; --note: #fff5e0; }
@media (prefers-color-scheme: dark) { :root { --ink: #e7eaee; --grey: #a9b1bc; --paper: #181b1f; --line: #454c55;
  --tint: #23272d; --mark: #7cc0f0; --note: #3a2f17; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 52rem; padding: 1.2rem; background: var(--paper); color: var(--ink);
  font: 16px/1.45 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .2rem; }
h2 { font-size: 1.25rem; margin: 1.8rem 0 .5rem; border-bottom: 2px solid var(--mark); padding-bottom: .2rem; }
h3 { font-size: 1rem; margin: 1.1rem 0 .2rem; }
p { margin: .4rem 0; }
.answer { font-size: 1.25rem; margin: 1rem 0; padding: .7rem 1rem; background: var(--tint);
  border-left: 6px solid var(--mark); }
.answer strong { font-size: 1.7rem; white-space: nowrap; }
.running, footer, caption { color: var(--grey); font-size: .85rem; }
figure { margin: .8rem 0; background: #ffffff; padding: .3rem; border-radius: 4px; text-align: center; }
img { max-width: 100%; height: auto; }
table { border-collapse: collapse; }
th { font-weight: 600; text-align: left; }
th, td { padding: .22rem .6rem; vertical-align: top; }
caption { caption-side: bottom; text-align: left; padding-top: .3rem; }
.facts { width: 100%; }
.facts th { width: 32%; color: var(--grey); font-weight: 500; }
.facts tr { border-bottom: 1px solid var(--line); }
.wide { overflow-x: auto; }
.numbers { width: 100%; font-variant-numeric: tabular-nums; font-size: .9rem; margin: .5rem 0; }
.numbers thead { border-bottom: 2px solid var(--line); }
.numbers tbody tr:nth-child(even) { background: var(--tint); }
.numbers td:nth-child(n + 2), .numbers th:nth-child(n + 2) { text-align: right; }
ul { margin: .3rem 0; padding-left: 1.3rem; }
.notes { background: var(--note); padding: .5rem 1rem .5rem 2rem; border-radius: 4px; }
.blanks { width: 100%; }
.blanks th, .blanks td { border: 1px solid var(--line); height: 2.2rem; }
.blanks th { width: 22%; font-weight: 500; font-size: .85rem; }
.blanks td { width: 28%; }
.blanks tr:last-child td { height: 5rem; }
section.pilot { margin-top: 3rem; }
@page { size: A4; margin: 14mm 13mm; }
@media print {
  :root { color-scheme: light; --ink: #000000; --grey: #444444; --paper: #ffffff; --line: #999999; --tint: #f3f3f3;
    --mark: #0b5c94; --note: #ffffff; }
  body { font-size: 10.5pt; max-width: none; padding: 0; }
  h2, h3 { break-after: avoid; }
  figure, .facts, .blanks, tr { break-inside: avoid; }
  figure { padding: 0; }
  thead { display: table-header-group; }
  .wide { overflow: visible; }
  .notes { border: 1px solid var(--line); }
  figure img { max-height: 100mm; }
  .whole { break-inside: avoid; }
  .numbers { font-size: 8.5pt; }
  .numbers td, .numbers th { padding: .08rem .4rem; }
  .facts th, .facts td { padding: .1rem .4rem; }
  section.pilot { break-before: page; margin: 0; }
  .pilot h2 { margin-top: .4rem; }
  .pilot figure img { max-height: 74mm; }
  .blanks { table-layout: fixed; }
  .blanks th, .blanks td { height: 7mm; padding: .05rem .3rem; font-size: 8.5pt; }
  .blanks tr:last-child td { height: 14mm; }
}
"""


def page(report: Report) -> str:
    """The report as one HTML file."""
    mission, pictures = report.score.mission, Pictures(report)
    head = element(
        "head",
        Html('<meta charset="utf-8">'),
        Html(f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'),
        Html('<meta name="viewport" content="width=device-width, initial-scale=1">'),
        element("title", mission.name),
        Html(f"<style>{_STYLE}</style>"),
    )
    top = element("header", element("p", "Search plan", class_="running"), element("h1", mission.name))
    flown = [sheet for sheet in report.sheets if sheet.flies]
    pages = [pilot_page(report, sheet, (number, len(flown)), pictures) for number, sheet in enumerate(flown, 1)]
    foot = element("footer", f"sooner {sooner.__version__}: plans where drones look, so that a lost person is found.")
    body = element("body", joined([top, element("main", overview(report, pictures), foot), *pages]))
    return f'<!DOCTYPE html>\n<html lang="en">\n{joined([head, body])}\n</html>\n'
