"""Chip-tool friction and elliptical vibration assisted turning as a component: kernel, FMUs, parameter sets, command line."""

from importlib.metadata import version

__version__ = version("evat")
