"""halflight farm: the bytes of `halflight bake`, whatever workers do and suffer.
Usage: farm_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import concurrent.futures
import glob
import json
import os
import resource
import shutil
import signal
import subprocess
import time

import cli_case
import tiny_scene
from cli_case import QUICK, Case, read, run

# Tiles enough for 16 workers.
BAKE = ["--quality", "preview", "--samples", "16", "--shadow-samples", "4", "--lightmap-size", "256"]


class FarmCase(Case):
    def plan(self, *arguments, folder="plan"):
        result = run("farm", "plan", *arguments, "-o", self.path(folder), "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.path(folder)

    def work(self, plan, index, of, *arguments):
        return run("farm", "work", plan, "--index", index, "--of", of, "--threads", 1, "-q", *arguments)

    def work_all(self, plan, of, *arguments):
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            results = list(pool.map(lambda index: self.work(plan, index, of, *arguments), range(of)))
        for result in results:
            self.assertEqual(result.returncode, 0, result.stderr)

    def join(self, plan, name="joined.glb", *arguments):
        return run("farm", "join", plan, "-o", self.path(name), "-q", *arguments)

    def joined(self, plan, name="joined.glb", *arguments):
        result = self.join(plan, name, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return read(self.path(name))

    def baked(self, scene, *arguments):
        result = run("bake", scene, "-o", self.path("baked.glb"), "-q", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return read(self.path("baked.glb"))

    def parts(self, plan, kind):
        return sorted(glob.glob(os.path.join(plan, "cache", "*", "*.tiles", kind + "-*.part")))

    def assert_names_missing(self, plan, indices, of):
        """`join` fails and writes nothing, and names the workers that have to run again."""
        result = self.join(plan, "none.glb", "--of", of)
        self.assert_one_sentence(result, 1, plan, f"workers {indices} of {of}")
        self.assertFalse(os.path.exists(self.path("none.glb")))
        missing = run("farm", "status", plan, "--of", of, "--missing")
        self.assertEqual(missing.returncode, 0, missing.stderr)
        return missing.stdout.strip()


class Farm(FarmCase):
    def test_same_bytes_in_every_mode_with_any_number_of_workers(self):
        scene = self.scene()
        for mode in ("baked-indirect", "shadowmask", "subtractive"):
            expected = self.baked(scene, *BAKE, "--mode", mode)
            for workers in (1, 3, 16):
                with self.subTest(mode=mode, workers=workers):
                    plan = self.plan(scene, *BAKE, "--mode", mode, folder=f"{mode}{workers}")
                    self.work_all(plan, workers)
                    self.assertEqual(self.joined(plan), expected)

    def test_same_bytes_of_other_bakes(self):
        scene = self.scene()
        for options in (
            ["--integrator", "path"],
            ["--noise", "20%", "--directional", "on"],
            ["--denoise", "off", "--shadowmask-encoding", "distance-field", "--sky", "1,2,3"],
            ["--glossy-bounces", "off", "--probe-layout", "grid", "--seed", "7"],
            ["--export", "unlit"],
        ):
            with self.subTest(options=options):
                expected = self.baked(scene, *QUICK, *options)
                plan = self.plan(scene, *QUICK, *options, folder="plan" + options[0])
                self.work_all(plan, 2)
                self.assertEqual(self.joined(plan), expected)

    def test_stages_by_themselves(self):
        scene = self.scene()
        plan = self.plan(scene, *BAKE)
        early = self.work(plan, 0, 2, "--stage", "tiles")
        self.assert_one_sentence(early, 1, "cache stage")
        self.assert_one_sentence(self.join(plan), 1, "cache stage")
        # One worker of two is enough: it computes the other's parts too.
        self.assertEqual(self.work(plan, 1, 2, "--stage", "cache").returncode, 0)
        state = json.loads(run("farm", "status", plan, "--json").stdout)
        self.assertEqual(state["scenes"][0]["cacheComplete"], True)
        self.assertEqual(state["scenes"][0]["done"], 0)
        self.assertEqual(state["missing"], "0,1")
        self.work_all(plan, 2, "--stage", "tiles")
        self.assertEqual(json.loads(run("farm", "status", plan, "--json").stdout)["missing"], "")
        self.assertEqual(self.joined(plan), self.baked(scene, *BAKE))

    def test_a_plan_needs_nothing_but_its_folder(self):
        os.mkdir(self.path("source"))
        scene = os.path.join(self.path("source"), "tiny.gltf")
        tiny_scene.write(scene)
        document = json.loads(read(scene))
        uri = document["buffers"][0]["uri"]
        if uri.startswith("data:"):  # a file beside the document, as tools write them
            import base64

            os.mkdir(os.path.join(self.path("source"), "data"))
            with open(os.path.join(self.path("source"), "data", "a b.bin"), "wb") as file:
                file.write(base64.b64decode(uri.split(",", 1)[1]))
            document["buffers"][0]["uri"] = "data/a%20b.bin"
            with open(scene, "w") as file:
                json.dump(document, file)
        settings = os.path.join(self.path("source"), "night.toml")
        with open(settings, "w") as file:
            file.write("[sky]\nzenith = [1, 2, 3]\n")
        expected = self.baked(scene, *QUICK, "--settings", settings)
        plan = self.plan(scene, *QUICK, "--settings", settings)
        shutil.rmtree(self.path("source"))
        moved = shutil.move(plan, self.path("elsewhere"))
        self.work_all(moved, 2)
        self.assertEqual(self.joined(moved), expected)

    def test_several_scenes(self):
        one = self.scene()
        os.mkdir(self.path("more"))
        two = os.path.join(self.path("more"), "tiny.gltf")
        shutil.copy(one, two)
        with open(self.path("list.txt"), "w") as file:
            file.write("# levels\ntiny.gltf\n\nmore/tiny.gltf\n")
        expected = self.baked(one, *QUICK)
        plan = self.plan("--list", self.path("list.txt"), *QUICK, "--cache", self.path("cache"))
        self.work_all(plan, 3)
        result = self.join(plan, "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(os.listdir(self.path("out"))), ["tiny-2.glb", "tiny.glb"])
        for name in ("tiny-2.glb", "tiny.glb"):
            self.assertEqual(read(os.path.join(self.path("out"), name)), expected)
        self.assertEqual(self.joined(plan, "single.glb", "--scene", "tiny-2"), expected)
        # Without --cache each has a cache of its own too: one keeps few bakes that are not in use.
        inside = self.plan(one, two, *QUICK, folder="inside")
        self.assertEqual(sorted(os.listdir(os.path.join(inside, "cache"))), ["tiny", "tiny-2"])
        # The next night: tiles of an unchanged scene are there before any worker begins.
        again = self.plan(one, two, *QUICK, "--cache", self.path("cache"), folder="again")
        self.assertEqual(json.loads(run("farm", "status", again, "--json").stdout)["missing"], "")

    def test_wrong_usage_and_bad_plans(self):
        scene = self.scene()
        self.assert_one_sentence(run("farm"), 2)
        self.assert_one_sentence(run("farm", "plan", "-o", self.path("p")), 2, "--list")
        self.assert_one_sentence(run("farm", "plan", scene, "-o", self.path("p"), "--sampels", 3), 2, "--samples")
        wrong = run("farm", "plan", scene, "-o", self.path("p"), "--noise", "2%", "--integrator", "path")
        self.assert_one_sentence(wrong, 2, "--noise")
        self.assert_one_sentence(run("farm", "work", self.path("nothing")), 1, "plan")
        with open(self.path("broken.gltf"), "w") as file:
            file.write("{}")
        before = os.listdir(self.folder.name)
        for folder in ("new/plan", "plan"):
            refused = run("farm", "plan", scene, self.path("broken.gltf"), "-o", self.path(folder), "-q", *QUICK)
            self.assert_one_sentence(refused, 1, "broken.gltf")
            self.assert_folder_holds(*before)
        plan = self.plan(scene, *QUICK)
        self.assert_one_sentence(run("farm", "work", plan, "--index", 2, "--of", 2), 2, "--index")
        self.assert_one_sentence(run("farm", "plan", scene, "-o", plan), 1, "not empty")
        copy = glob.glob(os.path.join(plan, "scenes", "0", "*.gltf"))[0]
        document = json.loads(read(copy))
        document["nodes"][0]["name"] = "renamed"
        with open(copy, "w") as file:
            json.dump(document, file)
        self.assert_one_sentence(self.work(plan, 0, 1), 1, "not the scene that was planned")


class FarmTrouble(FarmCase):
    def setUp(self):
        super().setUp()
        self.source = self.scene()
        self.expected = self.baked(self.source, *BAKE)
        self.folder_of_plan = self.plan(self.source, *BAKE)

    def test_killed_workers(self):
        plan, of = self.folder_of_plan, 3
        killed = 0
        for delay in (0.05, 0.15, 0.3, 0.5):
            worker = subprocess.Popen(
                [cli_case.HALFLIGHT, "farm", "work", plan, "--index", "1", "--of", str(of), "--threads", "1", "-q"],
                stdin=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            time.sleep(delay)
            worker.send_signal(signal.SIGKILL)
            killed += worker.wait() == -signal.SIGKILL
        self.assertGreater(killed, 0)
        for index in (0, 2):
            self.assertEqual(self.work(plan, index, of).returncode, 0)
        for path in self.parts(plan, "lightmap")[::2]:  # as if it had been killed before these
            os.remove(path)
        missing = self.assert_names_missing(plan, "0-2", of)
        self.assertEqual(missing, "0-2")
        self.work_all(plan, of)  # the requeue
        self.assertEqual(self.joined(plan), self.expected)

    def test_a_broken_tile(self):
        plan, of = self.folder_of_plan, 16
        self.work_all(plan, of)
        path = self.parts(plan, "shadowmask")[5]
        whole = bytearray(read(path))
        whole[len(whole) // 2] ^= 1
        with open(path, "wb") as file:
            file.write(whole)
        # Only reading the tile shows it.
        self.assertEqual(run("farm", "status", plan, "--of", of, "--missing").stdout.strip(), "")
        result = self.join(plan, "none.glb", "--of", of)
        self.assertEqual(result.returncode, 1)
        index = int(result.stderr.split("workers ")[1].split(" of")[0])
        self.assertEqual(self.work(plan, index, of).returncode, 0)
        self.assertEqual(self.joined(plan), self.expected)

    def test_a_full_disk(self):
        """Files beyond some size cannot be written, as on a full disk: the worker fails with a sentence, `join` names it."""
        plan, of = self.folder_of_plan, 4
        self.work_all(plan, of, "--stage", "cache")
        for index in range(of):
            result = subprocess.run(
                [cli_case.HALFLIGHT, "farm", "work", plan, "--index", str(index), "--of", str(of), "-q"],
                capture_output=True,
                text=True,
                stdin=subprocess.DEVNULL,
                preexec_fn=(lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))) if index == 2 else None,
            )
            if index == 2:
                self.assert_one_sentence(result, 1, "cannot be written")
            else:
                self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(glob.glob(os.path.join(plan, "cache", "**", "*.tmp*"), recursive=True), [])
        self.assertEqual(self.assert_names_missing(plan, "2", of), "2")
        self.assertEqual(self.work(plan, 2, of).returncode, 0)
        self.assertEqual(self.joined(plan), self.expected)

    def test_an_interrupted_worker_stops_before_its_end(self):
        """The signal comes with the first part, so of the others some are missing; the next worker makes them."""
        interrupted = 0
        for attempt in range(3):
            plan = self.plan(self.source, *BAKE, folder=f"plan{attempt}")
            command = [cli_case.HALFLIGHT, "farm", "work", plan, "--threads", "1"]
            worker = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            while worker.poll() is None and not self.parts(plan, "*"):
                time.sleep(0.01)
            worker.send_signal(signal.SIGINT)
            _, text = worker.communicate()
            if worker.returncode != 0:
                interrupted += 1
                self.assertEqual(worker.returncode, 1, text)
                self.assertIn("interrupted", text)
                self.assertNotEqual(run("farm", "status", plan, "--of", 1, "--missing").stdout.strip(), "")
            self.assertEqual(self.work(plan, 0, 1).returncode, 0)
            self.assertEqual(self.joined(plan), self.expected)
        self.assertGreater(interrupted, 0)


if __name__ == "__main__":
    cli_case.main()
