"""The cases of the suite of extremes: one module per idea, each with `cases()`."""

from __future__ import annotations

import importlib
import pkgutil

from extreme_cases.case import Case


def all_cases() -> list[Case]:
    """All cases, by module and in the order that each gives."""
    found: list[Case] = []
    for module in pkgutil.iter_modules(__path__):
        if module.name != "case":
            found += importlib.import_module(f"{__name__}.{module.name}").cases()
    titles = [case.title for case in found]
    assert len(set(titles)) == len(titles), "two cases have one title"
    return found
