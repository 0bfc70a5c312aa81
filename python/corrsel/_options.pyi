from typing import Dict, List, NamedTuple

from ._types import OptionValue

class Option(NamedTuple):
    name: str
    value: OptionValue
    range: str
    unit: str
    choices: Dict[str, str]
    description: str

def options(name: str) -> List[Option]: ...
