# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing of the view gets into files: it is left before a save and shown again after it. Bakes follow their .blend."""

import bpy
from bpy.app.handlers import persistent

from . import baked_view, files, stale
from .groups import state

# Between the start of a save and its end: the file's last name, and the windows that showed a view.
before = ""
shown = []


class Shown:
    """A window's view, to be shown again."""

    def __init__(self, window):
        self.window = window
        view = window.scene
        self.source = baked_view.source_of(view).name
        self.off = [light.name for light in view.halflight_lights if not light.on]
        self.engine = view.render.engine

    def show(self):
        source = bpy.data.scenes.get(self.source)
        if self.window not in baked_view.all_windows() or source is None:
            return
        views = baked_view.views_of(source)
        if views:  # another window showed the same
            self.window.scene = views[0]
            return
        with bpy.context.temp_override(window=self.window, scene=source, view_layer=self.window.view_layer):
            view = baked_view.show(bpy.context, files.of(source))
        view.render.engine = self.engine
        for light in view.halflight_lights:
            light.on = light.name not in self.off


@persistent
def before_save(*_arguments):
    global before
    before = bpy.data.filepath
    shown[:] = [Shown(window) for window in baked_view.all_windows() if baked_view.is_view(window.scene)]
    leave_all()
    for scene in bpy.data.scenes:
        baked_view.forget_deleted(scene)
        state.forget_deleted(scene)


@persistent
def after_save(*_arguments):
    try:
        files.follow(before)
        for each in shown:
            each.show()
    except (OSError, ValueError, KeyError) as error:
        print(f"Halflight: the last bake is not shown after saving: {error}")
    finally:
        shown.clear()


@persistent
def after_failed_save(*_arguments):
    after_save()


def leave_all():
    for source in {baked_view.source_of(scene) for scene in bpy.data.scenes if baked_view.is_view(scene)}:
        baked_view.leave(source)


HANDLERS = (("save_pre", before_save), ("save_post", after_save), ("save_post_fail", after_failed_save))


def register():
    for name, handler in HANDLERS:
        if hasattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).append(handler)


def unregister():
    """The view goes with the extension: without it nobody could leave it. So does the memory of what was baked, as it
    would keep deleted objects in the file."""
    for name, handler in HANDLERS:
        if hasattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(handler)
    leave_all()
    for scene in bpy.data.scenes:
        scene.halflight.baked_objects.clear()
    stale.stale.clear()
