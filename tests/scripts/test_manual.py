"""The manual's tables are those of the core, and its links lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from vernier_tools import manual_tables

MANUAL = Path(__file__).resolve().parents[2] / "docs" / "manual"


def test_the_settings_are_those_of_the_core() -> None:
    text = (MANUAL / "settings.md").read_text()
    assert text == manual_tables.settings_page(), "run scripts/build_manual --tables"


def test_the_nodes_are_those_of_the_core() -> None:
    bpy = pytest.importorskip("bpy")
    if bpy.app.version < (5, 0, 0):
        pytest.skip("the page lists the nodes of the newer Blender")
    text = (MANUAL / "nodes.md").read_text()
    assert text == manual_tables.nodes_page(), "run scripts/build_manual --tables"


def test_links_lead_somewhere() -> None:
    text = (MANUAL / "README.md").read_text()
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert links
    headings = {
        re.sub(r"[^a-z0-9 -]", "", line.lstrip("# ").lower()).replace(" ", "-")
        for line in text.splitlines()
        if line.startswith("#")
    }
    for link in links:
        if link.startswith("#"):
            assert link[1:] in headings, link
        else:
            assert (MANUAL / link).exists(), link
