"""What does a diagnosis leave behind? diagnosis.json for programs, report.html for an engineer, corrected.ssv for the FMU."""

from evat.gap_report.explanation import explain
from evat.gap_report.fmu_run import host_fmu
from evat.gap_report.output import check_place, write_diagnosis
from evat.gap_report.words import sentence
from evat.writing import OutputError

__all__ = ["OutputError", "check_place", "explain", "host_fmu", "sentence", "write_diagnosis"]
