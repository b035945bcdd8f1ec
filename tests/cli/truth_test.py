"""Pictures of baked scenes against the path-traced reference. Usage: truth_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import argparse
import pathlib
import sys
import tempfile

import cli_case
from cli_case import Case

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import make_truth_report as report


class Truth(Case):
    def test_reflection_probes_bring_a_glossy_room_nearer(self):
        """4.6 % with the probes and 7.9 % without them; probes at badly chosen places are worse than none."""
        scene = pathlib.Path(cli_case.SHARED, "scenes", "cornell_box_emissive.glb")
        if not scene.exists():
            self.skipTest(f"there is no {scene}")
        with tempfile.TemporaryDirectory() as folder:
            options = argparse.Namespace(keep=None, size="128x72")
            shown = report.Scene(cli_case.HALFLIGHT, scene, options, pathlib.Path(folder))
            truth, noise = shown.truth(256)
            mode = ["--mode", "distance-shadowmask"]
            near = report.error(shown.picture(*mode), truth)
            without = report.error(shown.picture(*mode, "--reflection-probes", "off"), truth)
        self.assertLess(noise, 0.03)
        self.assertLess(near, 0.065)
        self.assertLess(near, 0.8 * without)


if __name__ == "__main__":
    cli_case.main()
