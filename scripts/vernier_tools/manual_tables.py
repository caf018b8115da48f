"""The manual's tables, from the tables of the core."""

from __future__ import annotations

from engine_core.tables import Parameter

import engine_core

HEAD = "This page is made by `scripts/build_manual`.\n"

# Nodes that are not the engine's to support: they belong to other engines.
FOREIGN = {"ShaderNodeEeveeSpecular", "ShaderNodeShaderToRGB", "ShaderNodeOutputLineStyle"}
# Classes that are no nodes.
ABSTRACT = {"ShaderNode", "ShaderNodeCustomGroup", "ShaderNodeTree"}
# Nodes that the add-on itself resolves before the core sees the tree.
RESOLVED = {
    "ShaderNodeGroup",
    "ShaderNodeOutputLight",
    "ShaderNodeOutputMaterial",
    "ShaderNodeOutputWorld",
    "ShaderNodeRGB",
    "ShaderNodeValue",
}


def settings_page() -> str:
    """What each setting does."""
    groups: dict[str, list[Parameter]] = {}
    for parameter in engine_core.parameters():
        groups.setdefault(parameter.group, []).append(parameter)
    parts = [f"# What each setting does\n\n{HEAD}"]
    for group, parameters in groups.items():
        parts.append(f"## {group.replace('_', ' ').capitalize()}\n")
        rows = ["| Setting | On the command line | Default | What it does |", "|---|---|---|---|"]
        rows += [_setting_row(parameter) for parameter in parameters]
        parts.append("\n".join(rows) + "\n")
        for parameter in parameters:
            if parameter.items:
                rows = [f"| {parameter.label} | |", "|---|---|"]
                rows += [f"| {label} | {about} |" for _, label, about in parameter.items]
                parts.append("\n".join(rows) + "\n")
    return "\n".join(parts)


def _setting_row(parameter: Parameter) -> str:
    option = "--vernier-" + parameter.name.replace("_", "-")
    default: object = parameter.default
    if parameter.items:
        labels = {identifier: label for identifier, label, _ in parameter.items}
        default = labels[str(default)]
    elif isinstance(default, float):
        default = f"{default:g}"
    unit = f" {parameter.unit}" if parameter.unit else ""
    return f"| {parameter.label} | `{option}` | {default}{unit} | {parameter.description} |"


def nodes_page() -> str:
    """Which shader nodes are supported, by the names that Blender shows."""
    import bpy

    rows = {str(row["name"]): str(row["fallback"]) for row in engine_core.probe.node_kind_rows()}
    supported: set[str] = set()
    replaced: set[str] = set()
    missing: set[str] = set()
    for kind in dir(bpy.types):
        if not kind.startswith("ShaderNode") or kind in FOREIGN or kind in ABSTRACT:
            continue
        name = getattr(bpy.types, kind).bl_rna.name
        if kind in RESOLVED or rows.get(kind) == "":
            supported.add(name)
        elif kind in rows:
            replaced.add(name)
        else:
            missing.add(name)
    version = ".".join(map(str, bpy.app.version[:2]))
    return f"""# Shader nodes

{HEAD}
Node trees are those of Blender itself, as Cycles reads them. What a tree holds that is not \
supported is named in a warning when the scene is rendered, by material and node; the rest of the \
tree still counts.

**Supported** (of the nodes of Blender {version}): {_listed(supported)}.

**Replaced by something simpler**, with a warning: {_listed(replaced)}.

**Not supported yet**: {_listed(missing - supported)}.
"""


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names)) or "none"
