"""The mean difference of the lightmaps that two bakes wrote by --write-images, in per cent: lightmap_difference.py A B. Exit
code 1 above half a per cent, which another version of Embree or of the compiler stays below, and one bounce instead
of all do not."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from make_truth_report import read_exr  # noqa: E402

MOST = 0.005


def texels_of(folder):
    pages = sorted(path for path in pathlib.Path(folder).glob("lightmap_*.exr") if "raw" not in path.name)
    assert pages, f"{folder} has no lightmaps"
    return [value for page in pages for row in read_exr(page) for texel in row for value in texel]


one, other = map(texels_of, sys.argv[1:3])
assert len(one) == len(other), "the lightmaps are of other sizes"
difference = sum(abs(a - b) for a, b in zip(one, other)) / sum(other)
print(f"{100 * difference:.4f} % from the build tree's lightmap")
sys.exit(difference > MOST)
