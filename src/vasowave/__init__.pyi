"""What `import vasowave` offers, and where each name lives; `__init__.py` finds it here when it is asked for."""

__version__: str
__all__: list[str]
