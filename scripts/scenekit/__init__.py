"""What the scene scripts are made with: solids (mesh), pictures (texture) and the glTF writer (gltf).

Python's standard library only, and the same bytes on every run.
"""
