"""One function per panel; every one takes an axis, labels it with units and returns it."""
