"""The base of reports: dataclasses that are mappings, too."""

import pathlib
import re
from dataclasses import fields
from typing import Any, Dict, Iterator, List, Mapping, Optional, Type, TypeVar, Union, get_args, get_origin, get_type_hints

Self = TypeVar("Self", bound="Record")


def snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])([A-Z])", lambda letter: "_" + letter[1].lower(), name)


class Record(Mapping[str, Any]):
    """Fields have names as Python has them: report.peak_memory_bytes. The mapping has those of the program's JSON, and
    report["peakMemoryBytes"] is the same."""

    @classmethod
    def of(cls: Type[Self], values: Mapping[str, Any]) -> Self:
        """The record of an object of the program's JSON. Members that this class lacks are in the mapping alone."""
        types, names = get_type_hints(cls), {snake(name): name for name in values}
        make: Any = cls
        record: Self = make(**{key: _value(values[names[key]], types[key]) for key in _keys(cls) if key in names})
        object.__setattr__(record, "_values", dict(values))
        return record

    def to_dict(self) -> Dict[str, Any]:
        """The program's JSON, as dictionaries and lists."""
        return dict(self.__dict__["_values"])

    def __getitem__(self, name: str) -> Any:
        value = self.__dict__["_values"][name]
        return self.__dict__.get(snake(name), value)

    def __iter__(self) -> Iterator[str]:
        return iter(self.to_dict())

    def __len__(self) -> int:
        return len(self.to_dict())


class Picture(Record):
    """A report of a picture, which notebooks show."""

    output: str

    def _repr_png_(self) -> Optional[bytes]:
        path = pathlib.Path(self.output)
        return path.read_bytes() if path.suffix.lower() == ".png" else None


def _keys(kind: Any) -> List[str]:
    return [field.name for field in fields(kind)]


def _value(value: Any, kind: Any) -> Any:
    """A value of JSON as the field's type has it."""
    if get_origin(kind) is Union:  # Optional
        kind = get_args(kind)[0]
    if isinstance(value, dict) and isinstance(kind, type) and issubclass(kind, Record):
        return kind.of(value)
    if isinstance(value, list) and get_origin(kind) in (list, List):
        return [_value(item, get_args(kind)[0]) for item in value]
    return value
