"""Which column is it? By its name, its unit, and what was told; a question where several could be."""

from __future__ import annotations

from collections.abc import Sequence

from evat.experiment import ExperimentError
from evat.experiment.begin.files import Recordings
from evat.experiment.begin.understood import Answers, Question
from evat.experiment.begin.words import Meant, meant


class RecordedColumns:
    """The columns of some recordings; `questions` are left open, `look` is what their owner had better look at."""

    def __init__(self, recorded: Recordings, answers: Answers) -> None:
        self.recorded, self.answers = recorded, answers
        self.questions: list[Question] = []
        self.look: list[str] = []
        headers, below = recorded.sniffed.headers, recorded.sniffed.units
        for column in (*answers.signals.values(), *answers.units):
            if column not in headers:
                raise ExperimentError(f"there is no column {column!r}; the files have {', '.join(map(repr, headers[:40]))}.")
        pairs = [(header, unit) for header, unit in zip(headers, below, strict=True) if header.strip() and headers.count(header) == 1]
        self.columns = {header: meant(header, unit, answers.units.get(header, "")) for header, unit in pairs}
        self.told = {column: name for name, column in answers.signals.items()}

    def of(self, *kinds: str) -> list[Meant]:
        return [each for each in self.columns.values() if each.kind in kinds and each.header not in self.told]

    def chosen(self, name: str, kinds: Sequence[str]) -> Meant | None:
        """The column that was told, else the only one of the first kind that there is, by its name rather than by its unit alone, measured
        rather than commanded."""
        if name in self.answers.signals:
            return self.columns[self.answers.signals[name]]
        for kind, by_name in [(kind, by_name) for by_name in (True, False) for kind in kinds]:
            candidates = [each for each in self.of(kind) if bool(each.word) == by_name]
            measured = [each for each in candidates if not each.commanded] or candidates
            stated = [each for each in measured if each.unit] or measured
            if len(stated) > 1:
                longest = max(len(each.word) for each in stated)
                stated = [each for each in stated if len(each.word) == longest]
            if len(stated) == 1:
                return stated[0]
            if len(stated) > 1:
                self.ask_column(name, f"which column is {name}", tuple(each.header for each in stated))
                return stated[0]
        return None

    def only_timestamps(self) -> Meant | None:
        """The clock where no name tells it: the only column that holds times of day."""
        stamped = self.recorded.sniffed.timestamps
        return self.columns.get(stamped[0]) if len(stamped) == 1 else None

    def ask_column(self, name: str, asked: str, choices: tuple[str, ...] = ()) -> None:
        columns = choices or tuple(self.columns)
        self.questions.append(Question(f"--signal {name}=COLUMN", f"{asked}?", columns, name))

    def unit(self, column: Meant, usual: str = "") -> str:
        if not column.unit and usual:
            self.look.append(f"column {column.header!r} states no unit; {usual} was taken")
        if not column.unit and not usual:
            self.questions.append(
                Question(f"--unit '{column.header}=UNIT'", f"in which unit is the column {column.header!r}?", (), column.header)
            )
        return column.unit or usual

    def why(self, name: str, column: Meant, more: str = "", stamped: bool = False) -> str:
        by = "" if name in self.answers.signals else f"by {column.word!r} in its header" if column.word else "by its unit"
        unit = "it holds times of day" if stamped else "" if column.unit else "its unit is usual, the header states none"
        return "; ".join(filter(None, (by, unit, more)))
