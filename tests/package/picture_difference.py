"""The mean difference of two pictures of one size, in steps of 255: picture_difference.py A.png B.png. Exit code 1 above 2 steps,
which another version of a driver stays below (0.4), and another exposure or a picture without antialiasing does not."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from cli_case import decode_png  # noqa: E402

(*size, rows), (*other_size, other_rows) = map(decode_png, sys.argv[1:3])
steps = [abs(x - y) for row, other in zip(rows, other_rows) for a, b in zip(row, other) for x, y in zip(a, b)]
mean = sum(steps) / len(steps)
print(f"{mean:.2f} of 255 from the build tree's picture")
sys.exit(size != other_size or mean > 2.0)
