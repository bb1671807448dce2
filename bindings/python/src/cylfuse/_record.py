"""Structs of the library as objects whose attributes have the names of cylfuse.h."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, ClassVar, Iterator


class Record:
    """The fields of a struct, converted when they are asked for first."""

    #: How fields that are not plain numbers become objects of Python.
    _convert: ClassVar[dict[str, Callable[[Any], Any]]] = {}
    #: Python's name for a field whose own is a word of the language.
    _renamed: ClassVar[dict[str, str]] = {"damping": "lambda"}

    def __init__(self, *structs: Any) -> None:
        self._structs = structs

    # Not for checkers of types: they know the fields, and see a misspelt one.
    if not TYPE_CHECKING:

        def __getattr__(self, name):
            field = self._renamed.get(name, name)
            if not name.startswith("_") and field != "struct_size":
                for struct in self._structs:
                    if hasattr(struct, field):
                        value = getattr(struct, field)
                        if field in self._convert:
                            value = self._convert[field](value)
                        self.__dict__[name] = value
                        return value
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")

    def _names(self) -> Iterator[str]:
        back = {field: name for name, field in self._renamed.items()}
        for struct in self._structs:
            for field in (str(entry[0]) for entry in struct._fields_):
                if field != "struct_size":
                    yield back.get(field, field)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._names()})

    def to_dict(self) -> dict[str, Any]:
        """All fields by their names."""
        return {name: getattr(self, name) for name in self._names()}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.to_dict().items())})"
