"""What type checkers must take, and refuse: python_module_test.py runs mypy on this file, which is not run. A line with
`type: ignore` is wrong by its types; mypy reports one that is not."""

import pathlib
from typing import List, Optional, Tuple

import halflight

steps: List[Tuple[str, float]] = []


def note(stage: str, share: float) -> None:
    steps.append((stage, share))


baked = halflight.bake(
    pathlib.Path("scene.glb"), "baked.glb", quality="preview", texels_per_meter=20, sky=(1, 2, 3), integrator="path",
    denoise=False, two_sided=True, only=["floor", "wall"], exposure="auto", noise="2%", progress=note,
)  # fmt: skip
seconds: float = baked.seconds
pages: int = baked.lightmap.pages
names: List[str] = [light.name for light in baked.lights]
warnings: List[str] = baked["warnings"]
exported: Optional[float] = baked.export.exposure if baked.export else None
halflight.render("baked.glb", "picture.png", size=(320, 180), eye=[0, 1, 2], target="0,0,0", samples=4).exposure
halflight.info("baked.glb").triangles.drawn.bit_length()
halflight.optimize("baked.glb", "small.glb", lightmap_bits=7).bytes.file.after.bit_length()
halflight.bake("scene.glb", progress=True)

halflight.bake("scene.glb", quality="best")  # type: ignore[arg-type]
halflight.bake("scene.glb", qualty="high")  # type: ignore[call-arg]
halflight.bake("scene.glb", "baked.glb", "high")  # type: ignore[arg-type, misc]
halflight.bake("scene.glb", integrator="cach")  # type: ignore[arg-type]
halflight.bake("scene.glb", samples="many")  # type: ignore[arg-type]
halflight.bake("scene.glb", progress=lambda stage: None)  # type: ignore[arg-type, misc]
halflight.render("baked.glb")  # type: ignore[call-arg]
baked.peakMemoryBytes  # type: ignore[attr-defined]
baked.seconds = 1.0  # type: ignore[misc]
