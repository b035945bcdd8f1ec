"""What `halflight render` chooses by itself. Usage: render_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …
"""

import json
import sys

import cli_test
from cli_test import Case, read, run


class Choices(Case):
    def test_samples_of_a_pixel(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        view = ["--eye=4,3,5", "--target=0,0,0"]
        exact, fine, usual = (self.rendered(baked, *view, *samples)[0]
                              for samples in (["--samples", "1"], ["--samples", "16"], []))
        self.assertEqual([exact["samples"], fine["samples"], usual["samples"]], [1, 16, 4])
        self.assertEqual(self.rendered(baked, *view, "--view", "probes")[0]["samples"], 1)
        for samples in ("2", "0", "64", "a"):
            result = run("render", baked, "-o", self.path("p.exr"), "--samples", samples)
            self.assert_one_sentence(result, 2, "1, 4, 9 or 16")

    def test_shadow_distance_follows_the_view(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        view = ["--eye=4,3,5", "--target=0,0,0", "--mode", "baked-indirect"]
        shadows = self.rendered(baked, *view)[0]["shadows"]
        self.assertFalse(shadows["given"])
        self.assertEqual(shadows["shareBeyond"], 0)
        self.assertGreater(shadows["distance"], shadows["farthestInView"])
        self.assertLess(shadows["distance"], shadows["farthestInView"] + 2)
        # Half of what is in view, about: said with the share and the cure.
        summary = self.rendered(baked, *view, "--shadow-distance", "7")[0]
        self.assertTrue(summary["shadows"]["given"])
        self.assertGreater(summary["shadows"]["shareBeyond"], 0.05)
        self.assertLess(summary["shadows"]["shareBeyond"], 0.95)
        said = [w for w in summary["warnings"] if "realtime shadows end 7 m" in w and "--shadow-distance" in w]
        self.assertEqual(len(said), 1, summary["warnings"])

    def test_surfaces_of_the_reference(self):
        view = ["--reference", "64", "--bounces", "2", "--size", "48x32", "--eye=4,3,5", "--target=0,0,0"]
        means = {}
        for surfaces, options in (("full", []), ("diffuse-bounces", ["--reference-diffuse"]),
                                  ("diffuse", ["--specular", "off"])):
            result = run("render", self.scene(), "-o", self.path("p.exr"), *view, *options, "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads(result.stdout)["surfaces"], surfaces)
            means[surfaces] = read(self.path("p.exr"))
        self.assertEqual(len(set(means.values())), 3, "an option does nothing")
        for option in ("--reference-diffuse", "--reference-clamp=2"):
            self.assert_one_sentence(run("render", self.scene(), "-o", self.path("p.exr"), option), 2, "--reference")


if __name__ == "__main__":
    cli_test.HALFLIGHT, cli_test.SHARED = sys.argv[1:3]
    cli_test.main(sys.argv[3:])
