"""How much memory and time does a large recording take? Checking streams; holding takes its own numbers and hardly more.

EVAT_RECORD_MEGABYTES=1000 in the environment makes it the gigabyte that is promised.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from report import Summary

MEGABYTES = float(os.environ.get("EVAT_RECORD_MEGABYTES", "60"))
MOST = 1e9  # bytes
LARGE = Path(__file__).resolve().with_name("large_record.py")
COLUMNS = 3  # that are kept, of 8 bytes a row


def in_a_process(*arguments: str) -> str:
    return subprocess.run([sys.executable, str(LARGE), *arguments], capture_output=True, text=True, check=True).stdout


@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is asked of Linux")
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_reading(summary: Summary, tmp_path: Path, suffix: str) -> None:
    """Limit: for time one pass of sha256 and one of pyarrow's reader; for memory one batch of columns, beside the libraries themselves."""
    in_a_process("write", str(tmp_path / "long"), str(MEGABYTES), suffix)
    size = (tmp_path / "long" / f"long{suffix}").stat().st_size
    scan, read = (json.loads(in_a_process(what, str(tmp_path / "long"))) for what in ("scan", "read"))
    assert scan["rows"] == read["rows"]
    assert scan["peak"] < MOST
    held = 8 * COLUMNS * read["rows"]
    summary.add(
        f"checking {size / 1e9:.2f} GB of {suffix[1:]}, {scan['rows'] / 1e6:.1f} million rows",
        f"{scan['seconds']:.1f} s, {scan['peak'] / 1e9:.2f} GB at most, {scan['before'] / 1e9:.2f} GB of it libraries",
        wanted=f"< {MOST / 1e9:g} GB",
    )
    diagnosed = json.loads(in_a_process("diagnose", str(tmp_path / "long")))
    assert diagnosed["peak"] < MOST
    summary.add(
        "    diagnosing it",
        f"{diagnosed['seconds']:.1f} s, {diagnosed['peak'] / 1e9:.2f} GB at most",
        wanted="600 s, 4 GB for 60 million rows of 4 channels",
        limit="one pass of the reader, and a diagnosis of the head",
    )
    summary.add(
        "    holding it",
        f"{read['seconds']:.1f} s, {read['peak'] / 1e9:.2f} GB at most",
        limit=f"{held / 1e9:.2f} GB are kept",
    )
