"""What an FMU for Model Exchange is able to do, once it is integrated here."""

from dataclasses import replace

from ..description import SlaveDescription
from ..fmi.description import Description
from ..fmi.events import without_memory

__all__ = ["integrated"]


def integrated(able: SlaveDescription, model: Description) -> SlaveDescription:
    """The slave that is made of an FMU whose own description is `able`.

    It follows polynomials of any degree and counts events; where the FMU cannot save its state, but remembers nothing beyond
    time and continuous states, it is saved by these.
    """
    by_states = not able.can_restore and without_memory(model)
    return replace(
        able, input_degree=2, counts_events=True, can_restore=able.can_restore or by_states,
        can_serialize=able.can_serialize or by_states,
    )  # fmt: skip
