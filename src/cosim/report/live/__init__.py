"""A run seen in a browser as it goes on: `film` keeps what viewers are shown, `steering` carries what they want into the run,
`serving` speaks HTTP on this machine alone, `beginning` is the document that the page begins with.

Viewers are served in threads of their own, each from its own place in the film. The run waits for none of them.
"""

from .beginning import first_page
from .serving import Served
from .steering import Steering

__all__ = ["Served", "Steering", "first_page"]
