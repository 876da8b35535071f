"""What a reader sees: one function per panel (takes ``ax``, returns it), and `gallery`, the pages made of them."""

from vasowave.figures.gallery import gallery

__all__ = ["gallery"]
