"""Whether the answer fits the image: what contradicts it, and where."""
