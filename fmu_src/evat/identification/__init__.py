"""How is a contact identified from an experiment, and what can the experiment not tell? `identify`, and the words of its answer."""

from evat.identification.result import Estimate, Fit, Identification
from evat.identification.run import identify

__all__ = ["Estimate", "Fit", "Identification", "identify"]
