"""From files of pressure and flow to one averaged cycle and its hemodynamic indices."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
