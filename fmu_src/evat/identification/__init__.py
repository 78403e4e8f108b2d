"""How is a contact identified from an experiment, and what can the experiment not tell? `identify`, and the words of its answer."""

from evat.identification.result import ChannelFit, Estimate, Identification
from evat.identification.run import identify
from evat.identification.settings import Execution, Settings

__all__ = ["ChannelFit", "Estimate", "Execution", "Identification", "Settings", "identify"]
