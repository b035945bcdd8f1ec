# SPDX-License-Identifier: GPL-3.0-or-later
"""All that Blender says of a data-block, as text: to compare it with what it was."""

import bpy

# Not the user's work, or Blender's own at run time.
NOT_WORK = {"window_managers", "screens", "workspaces", "brushes", "libraries"}
SKIPPED = {"rna_type", "users", "preview", "is_evaluated", "session_uid", "original", "id_data"}
SKIPPED |= {"uv_layer_clone", "uv_layer_stencil"}  # other names of UV sets, whose indices are compared
SKIPPED |= {"uv_sculpt"}  # Blender 4.3 crashes on its brushes in files that were never painted in


def dump(block):
    lines = [f"{key} = {value!r}" for key, value in sorted(block.items()) if not hasattr(value, "keys")]
    _members(block, block.name, lines, {identity(block)})
    return "\n".join(lines)


def blocks():
    """What Blender says of each of the user's data-blocks, but for the settings and results of the bake."""
    for mesh in bpy.data.meshes:
        if hasattr(mesh, "calc_normals_split"):  # before Blender 4.1 these are made when they are first needed
            mesh.calc_normals_split()
    kinds = [each.identifier for each in bpy.data.bl_rna.properties if each.type == "COLLECTION"]
    return {(kind, item.name): dump(item) for kind in kinds if kind not in NOT_WORK for item in getattr(bpy.data, kind)}


def difference(before, after):
    """A sentence about the first lines that differ; empty where all is the same."""
    if before.keys() != after.keys():
        return f"data-blocks: {sorted(before.keys() ^ after.keys())}"
    changed = [key for key in before if before[key] != after[key]]
    pairs = ((key, pair) for key in changed for pair in zip(before[key].splitlines(), after[key].splitlines()))
    first = [(key, pair) for key, pair in pairs if pair[0] != pair[1]][:4]
    return f"changed: {first or changed}" if changed else ""


def identity(value):
    """A UV set and its attribute are at one address in Blender 4.3, sometimes."""
    return value.as_pointer(), type(value).__name__


def _members(owner, path, lines, seen):
    for definition in owner.bl_rna.properties:
        name = definition.identifier
        # Reading a group that an add-on defines would create it.
        if name in SKIPPED or definition.is_runtime and definition.type == "POINTER":
            continue
        value = getattr(owner, name)
        if definition.type == "POINTER":
            _pointer(value, f"{path}.{name}", lines, seen)
        elif definition.type == "COLLECTION":
            for number, item in enumerate(value):
                _pointer(item, f"{path}.{name}[{number}]", lines, seen)
        else:
            is_array = definition.type in {"INT", "FLOAT", "BOOLEAN"} and definition.is_array
            lines.append(f"{path}.{name} = {list(value) if is_array else value!r}")


def _pointer(value, path, lines, seen):
    """Parts of the block are written out once; other blocks, and parts met again, are named."""
    own = isinstance(value, bpy.types.NodeTree) and value.is_embedded_data
    if value is None or (isinstance(value, bpy.types.ID) and not own) or identity(value) in seen:
        lines.append(f"{path} -> {getattr(value, 'name', value and type(value).__name__)}")
        return
    seen.add(identity(value))
    _members(value, path, lines, seen)
