# SPDX-License-Identifier: GPL-3.0-or-later
"""All that Blender says of a data-block, as text: to compare it with what it was."""

import bpy

SKIPPED = {"rna_type", "users", "preview", "is_evaluated", "session_uid", "original", "id_data"}
SKIPPED |= {"uv_sculpt"}  # Blender 4.3 crashes on its brushes in files that were never painted in


def dump(block):
    lines = [f"{key} = {value!r}" for key, value in sorted(block.items()) if not hasattr(value, "keys")]
    _members(block, block.name, lines, {block.as_pointer()})
    return "\n".join(lines)


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
    if value is None or (isinstance(value, bpy.types.ID) and not own) or value.as_pointer() in seen:
        lines.append(f"{path} -> {getattr(value, 'name', value and type(value).__name__)}")
        return
    seen.add(value.as_pointer())
    _members(value, path, lines, seen)
