"""What does a diagnosis leave behind? diagnosis.json for programs, report.html for an engineer, corrected.ssv for the FMU."""

from evat.files.writing import OutputError
from evat.gap.report.explanation import explain, explain_verdict
from evat.gap.report.output import check_place, write_diagnosis
from evat.gap.report.summary import headline
from evat.gap.report.words import sentence

__all__ = ["OutputError", "check_place", "explain", "explain_verdict", "headline", "sentence", "write_diagnosis"]
