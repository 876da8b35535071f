"""What a recording says about an animal when geometry and model are uncertain too: the posterior."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
