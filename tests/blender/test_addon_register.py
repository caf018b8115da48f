"""Registration: the engine, its settings, its panels, and back."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import bpy
import pytest

import addon
import engine_core
from addon import core as core_module
from addon import panels


@pytest.fixture
def registered(empty_scene: Any) -> Any:
    addon.register()
    yield empty_scene
    addon.unregister()


def test_register_is_undone_and_can_be_repeated(empty_scene: Any) -> None:
    for _ in range(2):
        addon.register()
        empty_scene.render.engine = "VERNIER"
        addon.unregister()
        assert not hasattr(bpy.types.Scene, "vernier")
        assert not hasattr(bpy.types.ViewLayer, "vernier")
        adopted = [p for p in panels.adopted_panels() if "VERNIER" in p.COMPAT_ENGINES]
        assert adopted == []


def test_settings_are_the_cores_table(registered: Any) -> None:
    rows = {row.name: row for row in engine_core.parameters()}
    found = registered.vernier.bl_rna.properties
    viewport = {"preview_samples", "preview_pause", "checkpoint", "resume"}
    assert set(rows) | viewport == set(found.keys()) - {"rna_type", "name"}
    for name, row in rows.items():
        assert getattr(registered.vernier, name) == pytest.approx(row.default)
        assert found[name].name == row.label
        assert found[name].description == row.description
        if row.type == "enum":
            assert [item.identifier for item in found[name].enum_items] == [
                item[0] for item in row.items
            ]
        else:
            limits = (found[name].hard_min, found[name].hard_max)
            assert limits == pytest.approx((row.min, row.max))


def test_settings_are_kept_in_files(registered: Any, tmp_path: Path) -> None:
    registered.vernier.samples = 77
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    registered.vernier.samples = 5
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert bpy.context.scene.vernier.samples == 77


def test_native_panels_are_adopted(registered: Any) -> None:
    names = {panel.__name__ for panel in panels.adopted_panels()}
    assert {"RENDER_PT_output", "DATA_PT_lens", "EEVEE_MATERIAL_PT_surface"} <= names
    assert "RENDER_PT_freestyle" not in names
    assert all("VERNIER" in panel.COMPAT_ENGINES for panel in panels.adopted_panels())


def test_threads_and_samples_come_from_blender_where_ours_are_not_set(registered: Any) -> None:
    from addon.settings import render_settings

    layer = bpy.context.view_layer
    registered.render.threads_mode, registered.render.threads = "FIXED", 3
    layer.samples = 9
    values = render_settings(registered, layer)
    assert (values["threads"], values["samples"]) == (3, 9)
    registered.vernier.threads, layer.samples = 2, 0
    values = render_settings(registered, layer)
    assert (values["threads"], values["samples"]) == (2, registered.vernier.samples)


def test_without_the_core_the_add_on_registers(
    empty_scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from addon import passes, settings

    def missing() -> None:
        raise core_module.CoreMissingError("gone")

    monkeypatch.setattr(settings, "core", missing)
    monkeypatch.setattr(passes, "core", missing)
    addon.register()
    try:
        assert set(empty_scene.vernier.bl_rna.properties.keys()) == {"rna_type", "name"}
        assert [item.name for item in passes.known_passes()] == ["Combined"]
    finally:
        addon.unregister()


def test_manifest() -> None:
    path = Path(addon.__file__).parent / "blender_manifest.toml"
    manifest = tomllib.loads(path.read_text())
    assert (manifest["id"], manifest["type"]) == ("vernier", "add-on")
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert manifest["blender_version_min"] == "4.5.0"
