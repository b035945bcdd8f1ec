#!/usr/bin/env python3
"""Makes assets/tests/fuzz/: small inputs of every reader, from which the fuzzers and their test start.

    make_fuzz_seeds.py HALFLIGHT    HALFLIGHT: the program, which bakes one of them

assets/tests/compressed/ must be there (make_compressed_scenes.mjs). The outputs are committed.
"""

import json
import pathlib
import shutil
import struct
import subprocess
import sys
import zlib

TESTS = pathlib.Path(__file__).resolve().parent.parent / "assets" / "tests"
OUT = TESTS / "fuzz"

SETTINGS = """# Every table and key once.
[sky]
zenith = [0.1, 0.2, 0.3]
horizon = [1, 1, 1]
ground = [0.0, 0.0, 0.0]

[scene]
shadow_color = [0.1, 0.1, 0.1]
probes = [[0, 1, 0], [1.5, 1, -2e1]]

[[node]]
pattern = "Wall*"
static = true
cast_shadows = false
receive_shadows = true
lightmap_scale = 0.5
probes = "volume"
probe_resolution = [2, 3, 4]

[[material]]
pattern = "?lass"
cast_shadows = false

[[light]]
pattern = "*"
mode = "mixed"
radius = 0.1
range = 12.5
intensity = 100.0
color = [1, 0.5, 0.25]

[[add_light]]
name = "sun"
type = "directional"
mode = "mixed"
direction = [0, -1, 0.5]
intensity = 3.0
"""


def glb_parts(path):
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def view_bytes(document, binary, index):
    view = document["bufferViews"][index]
    start = view.get("byteOffset", 0)
    return binary[start : start + view["byteLength"]]


def write_black_png(path, side):
    """One bit per texel, all black: the most texels that few bytes can hold."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = bytes(1 + side // 8) * side
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def main():
    write_black_png(TESTS / "compressed" / "black_4096.png", 4096)
    halflight = sys.argv[1]
    for name in ("gltf", "baked", "settings", "decoders"):
        (OUT / name).mkdir(parents=True, exist_ok=True)
    shutil.copy(TESTS / "penumbra.glb", OUT / "gltf" / "lights.glb")
    # As JSON with data: URIs, which fuzzers change without breaking chunk lengths.
    triangle = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5121, "normalized": True, "count": 3, "type": "VEC3",
                       "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
                                  "values": {"bufferView": 0}}},
                      {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 12, "byteStride": 4}, {"buffer": 0, "byteOffset": 12, "byteLength": 3}],
        "buffers": [{"byteLength": 15, "uri": "data:;base64,AAAAAP8AAAAA/wAAAAEC"}],
    }
    (OUT / "gltf" / "triangle.gltf").write_text(json.dumps(triangle))
    (OUT / "settings" / "all.toml").write_text(SETTINGS)
    baked = OUT / "baked" / "baked.glb"
    subprocess.run([halflight, "bake", str(TESTS / "penumbra.glb"), "-o", str(baked), "--quality", "preview",
                    "--texels-per-meter", "1", "--lightmap-size", "64", "--probe-spacing", "6"], check=True)

    def decoder(name, kind, data):
        (OUT / "decoders" / name).write_bytes(bytes([kind]) + data)

    document, binary = glb_parts(baked)
    root = document["extensions"]["HALFLIGHT_mixed_lighting"]

    def picture(reference):
        texture = document["textures"][reference["index"]]
        source = texture.get("extensions", {}).get("HALFLIGHT_texture_ktx2", texture)["source"]
        return view_bytes(document, binary, document["images"][source]["bufferView"])

    decoder("lightmap.ktx2", 1, picture(root["lightmaps"][0]))
    decoder("mask.png", 0, picture(root["shadowmasks"][0]))
    document, binary = glb_parts(TESTS / "compressed" / "webp.glb")
    decoder("green.webp", 0, view_bytes(document, binary, document["images"][1]["bufferView"]))
    for method in ("edgebreaker", "sequential"):
        document, binary = glb_parts(TESTS / "compressed" / f"draco_{method}.glb")
        extension = document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
        decoder(f"{method}.drc", 2, view_bytes(document, binary, extension["bufferView"]))
    for file in ("meshopt_high", "gltfpack_filters"):
        document, binary = glb_parts(TESTS / "compressed" / f"{file}.glb")
        for view in document["bufferViews"]:
            extension = view.get("extensions", {}).get("EXT_meshopt_compression")
            if extension is None or extension["count"] % 3 != 0 or extension["count"] > 255 * 3:
                continue
            mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"].index(extension["mode"])
            filters = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"].index(extension.get("filter", "NONE"))
            start = extension.get("byteOffset", 0)
            data = binary[start : start + extension["byteLength"]]
            header = bytes([mode, filters, extension["byteStride"], extension["count"] // 3])
            decoder(f"{mode}{filters}.meshopt", 3, header + data)


if __name__ == "__main__":
    main()
