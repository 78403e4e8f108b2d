"""Are options that belong together one value to a command, and options like all others on the command line?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer
from evat.commands.shared import grouped
from typer.testing import CliRunner


@dataclass(frozen=True)
class SearchOptions:
    method: Annotated[str, typer.Option("--search", help="How.")]
    seed: Annotated[int, typer.Option("--seed", "-s", help="Of the search.", min=0)] = 3


@grouped
def command(
    *, place: Annotated[str, typer.Argument()], search: SearchOptions, quick: Annotated[bool, typer.Option("--quick")] = False
) -> None:
    """Tell what came."""
    print(place, search, quick)


def called(*words: str) -> tuple[int, str]:
    app = typer.Typer()
    app.command()(command)
    result = CliRunner().invoke(app, words)
    return result.exit_code, result.output


def test_a_group_comes_as_one_value_with_its_defaults() -> None:
    assert called("here", "--search", "ga") == (0, "here SearchOptions(method='ga', seed=3) False\n")
    assert called("here", "-s", "5", "--quick", "--search", "de") == (0, "here SearchOptions(method='de', seed=5) True\n")


def test_what_an_option_of_a_group_asks_for_is_asked_for() -> None:
    for words in (("here",), ("here", "--search", "ga", "--seed", "-1"), ("here", "--search", "ga", "--method", "de")):
        assert called(*words)[0] == 2


def test_the_help_lists_options_in_the_order_of_the_command() -> None:
    status, text = called("--help")
    assert status == 0
    assert "Tell what came." in text
    assert text.index("--search") < text.index("--seed") < text.index("--quick")
