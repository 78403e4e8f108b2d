"""What does `python -m evat` run? The command line."""

from evat.commands.main import main

main()
