# SPDX-License-Identifier: GPL-3.0-or-later
"""The Bake operator: exports, runs the program beside Blender, reads the result, shows it."""

import errno
import json
import os
import queue
import shutil
import subprocess
import threading

import bpy

from . import baked_view, files, messages, preferences, program, stale
from .export import export_scene, findings, scene_copy
from .glb import Glb
from .groups import animation, state

INTERVAL = 0.1  # seconds between looks at the program


class BakeError(Exception):
    pass


class Job:
    """One bake: export() and start(), then poll() until it is not None, then finish()."""

    current = None  # the one that runs, for the panel and for cancel

    def __init__(self, context, selected_only=False):
        self.program = preferences.find_program(context)
        if self.program is None:
            raise BakeError(program.NOT_FOUND)
        files.settle(context.scene)
        self.files = files.of(context.scene)
        self.folder = context.scene.halflight.folder  # the scene's name may change during the bake
        self.progress = program.Progress()
        self.lines = queue.Queue()
        self.process = None
        self.document = None
        self.cancelled = False
        self.reader = None
        self.selected = {item.name for item in context.selected_objects} if selected_only else None
        self.only = []

    def export(self, context):
        messages.clear(context)
        try:
            for folder in (self.files.folder, self.files.sidecar):
                os.makedirs(folder, exist_ok=True)
                if not os.access(folder, os.W_OK):
                    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        except OSError as error:
            raise BakeError(
                f"The bake's folder {folder} cannot be made or written ({error.strerror}): save the .blend in a folder that "
                "can be written, and move away files with the name of the bake's folder"
            ) from error
        units = context.scene.halflight.units
        with state.quietly():
            state.follow(context.scene)
        try:
            warnings = export_scene.export_scene(context, self.files.scene, units, self.files.folder)
        except RuntimeError as error:  # of an operator
            raise BakeError(f"The glTF exporter failed: {error}") from error
        except OSError as error:
            raise BakeError(f"The exported scene cannot be written: {error}") from error
        self.document = Glb(self.files.scene).json
        if not any("mesh" in node for node in self.document.get("nodes", [])):
            raise BakeError("Nothing to bake: no object with a surface renders in this view layer")
        for warning in warnings:
            messages.add(context, "WARNING", warning, self.document)
        settings = context.scene.halflight
        for text, item in findings.of(scene_copy.rendered_objects(context.view_layer), settings.has_pictures):
            messages.add(context, "WARNING", text, item=item)
        baked_view.note_objects(context.scene, self.document, keep_last=True)
        if self.selected is None:
            stale.note_bake(context, context.scene)
            return
        self.only = with_meshes(self.document, self.selected)
        if not self.only:
            raise BakeError("No object with a surface is selected: select what to bake, or use Bake for the whole scene")

    def start(self, context):
        arguments = program.bake_arguments(context.scene.halflight, self.files, self.only)
        try:
            self.process = subprocess.Popen(
                [self.program.path, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                errors="replace",
                **program.HIDDEN,
            )
        except OSError as error:
            raise BakeError(f"{self.program.path} cannot be run: {error.strerror}") from error
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        Job.current = self

    def read(self):
        with self.process.stderr:
            for line in self.process.stderr:
                self.lines.put(line)

    def poll(self, context):
        """The exit code once the program has ended and all it said is in the list, else None."""
        code = self.process.poll()
        if code is not None:
            self.reader.join()
        while not self.lines.empty():
            line = self.lines.get()
            if not self.progress.read(line):
                messages.add_line(context, line, self.files.scene, self.document)
        return code

    def cancel(self):
        self.cancelled = True
        if self.process and self.process.poll() is None:
            program.cancel(self.process)

    def scene(self):
        """None when it is gone."""
        own = (scene for scene in bpy.data.scenes if not baked_view.is_view(scene))
        return next((scene for scene in own if scene.halflight.folder == self.folder), None)

    def finish(self, context, code):
        """Reads the report and copies the file to where it was asked for."""
        Job.current = None
        scene = self.scene()
        if scene is None:
            raise BakeError("The scene was removed during its bake")
        if code != 0:
            if self.selected is None:
                scene.halflight.baked_digest = ""
            if self.cancelled:
                raise BakeError("The bake was cancelled")
            listed = [m.text for m in context.window_manager.halflight_messages if m.severity == "ERROR"]
            raise BakeError(listed[-1] if listed else f"The program ended with code {code}")
        baked_view.note_objects(scene, self.document, keep_last=False)
        with open(self.files.report, encoding="utf-8") as file:
            report = json.load(file)
        scene.halflight.summary = summary_of(report)
        self.take_groups(context, scene)
        output = bpy.path.abspath(scene.halflight.output)
        if output:
            os.makedirs(os.path.dirname(output) or ".", exist_ok=True)
            shutil.copyfile(self.files.baked, output)
        return report


    def take_groups(self, context, scene):
        """The sliders of light groups, and their keyframes in the file."""
        with open(self.files.bindings, encoding="utf-8") as file:
            bindings = json.load(file)
        if "groups" not in bindings and not scene.halflight.light_groups:
            return
        is_unchanged = context.scene == scene and self.selected is None and not stale.check(context)
        with state.quietly():
            state.sync(scene, bindings, Glb(self.files.baked))
            names = [record["name"] for record in bindings.get("groups", [])]
            entries = {entry.name: entry for entry in state.groups_of(scene)}
            animation.write(scene, [entries[name] for name in names], self.files.baked)
        if is_unchanged:  # what the weight 1 is of lamps is known now
            stale.note_bake(context, scene)


def with_meshes(document, names):
    """Those of `names` that are nodes of the file with a mesh, or with one below them, as an instanced collection has."""
    nodes = document.get("nodes", [])

    def has_mesh(node):
        return "mesh" in node or any(has_mesh(nodes[child]) for child in node.get("children", []))

    return sorted({node["name"] for node in nodes if node.get("name") in names and has_mesh(node)})


def summary_of(report):
    lightmap, cache = report["lightmap"], report.get("cache", {})
    pages = "1 page" if lightmap["pages"] == 1 else f"{lightmap['pages']} pages"
    text = f"{report['seconds']:.1f} s, {report['probes']['count']} probes\n{pages} of {lightmap['size']} texels"
    if cache.get("tiles"):
        reused = cache["same"] + cache["unchanged"] + cache["kept"]
        text += f"\n{reused} of {cache['tiles']} tiles as before"
    return text


class BakeOperator:
    """Of both operators. Blender does not find a class whose subclass is registered too."""

    bl_options = {"REGISTER", "UNDO"}

    selected_only = False
    job = None
    timer = None

    @classmethod
    def poll(cls, _context):
        return Job.current is None

    def begin(self, context):
        baked_view.leave(baked_view.source_of(context.scene))
        self.job = Job(context, self.selected_only)
        self.job.export(context)
        self.job.start(context)

    def end(self, context, code):
        try:
            report = self.job.finish(context, code)
            if context.scene == self.job.scene() and context.scene.halflight.show_view:
                baked_view.show(context, self.job.files)
        except (BakeError, OSError, ValueError, KeyError) as error:
            self.report({"ERROR"} if not self.job.cancelled else {"WARNING"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, "Baked: " + summary_of(report).replace("\n", ", "))
        return {"FINISHED"}

    def execute(self, context):
        """Waits for the end: for scripts and headless Blender."""
        try:
            self.begin(context)
        except BakeError as error:
            messages.add(context, "ERROR", str(error))
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.job.process.wait()
        return self.end(context, self.job.poll(context))

    def invoke(self, context, _event):
        try:
            self.begin(context)
        except BakeError as error:
            messages.add(context, "ERROR", str(error))
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(INTERVAL, window=context.window)
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS" and self.has_focus(context, event):
            self.job.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        code = self.job.poll(context)
        if code is None:
            context.workspace.status_text_set(f"Halflight: {self.job.progress.text()}   Esc cancels")
            context.window_manager.progress_update(int(100 * self.job.progress.share))
            redraw()
            return {"PASS_THROUGH"}
        self.stop_showing(context)
        try:
            return self.end(context, code)
        finally:
            redraw()

    def has_focus(self, context, event):
        """Esc is the bake's where the mouse is over an area that shows it, and not while it stops a playback."""
        if any(window.screen.is_animation_playing for window in baked_view.all_windows()):
            return False
        for area in context.window.screen.areas:
            if area.x <= event.mouse_x < area.x + area.width and area.y <= event.mouse_y < area.y + area.height:
                return area.type in {"VIEW_3D", "PROPERTIES"}
        return False

    def stop_showing(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def cancel(self, context):
        """Blender itself ends the operator, as on loading another file."""
        self.job.cancel()
        Job.current = None
        self.stop_showing(context)


def redraw():
    for window in baked_view.all_windows():
        for area in window.screen.areas:
            area.tag_redraw()


class HALFLIGHT_OT_bake(BakeOperator, bpy.types.Operator):
    """Exports, bakes in the background and shows the result"""

    bl_idname = "halflight.bake"
    bl_label = "Bake"
    bl_description = (
        "Bake the scene's light and show it. Only what changed since the last bake is computed, on every object that the "
        "change reaches: nothing has to be selected"
    )


class HALFLIGHT_OT_bake_selected(BakeOperator, bpy.types.Operator):
    """Bakes the selected objects; all others keep the last bake's light"""

    bl_idname = "halflight.bake_selected"
    bl_label = "Bake Selected"
    bl_description = (
        "Bake the selected objects alone, with the present lights and settings. All other objects and the light probes "
        "keep the light of the last bake"
    )
    selected_only = True

    @classmethod
    def poll(cls, context):
        if baked_view.is_view(context.scene):
            cls.poll_message_set("Leave the baked view to select objects")
            return False
        return Job.current is None


class HALFLIGHT_OT_cancel(bpy.types.Operator):
    """Stop the bake. Finished tiles are kept, so that the next bake goes on from there"""

    bl_idname = "halflight.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, _context):
        return Job.current is not None

    def execute(self, _context):
        Job.current.cancel()
        return {"FINISHED"}


CLASSES = (HALFLIGHT_OT_bake, HALFLIGHT_OT_bake_selected, HALFLIGHT_OT_cancel)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)


def unregister():
    if Job.current is not None:
        Job.current.cancel()
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
