"""Panels that take ``ax`` and return it, and the figures made of them. Nothing is computed here."""
