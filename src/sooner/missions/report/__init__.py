"""The report of a planned mission: one page for the command post, and one for each pilot."""

from sooner.missions.report.report import Report, make_report

__all__ = ["Report", "make_report"]
