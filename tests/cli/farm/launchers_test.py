"""The launchers of farm/: real schedulers, workers that are killed and disks that are full, and the bytes of a bake.
Usage: launchers_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …   A scheduler that is not installed is skipped."""

import os
import shutil
import subprocess
import tempfile

import cli_case
import slurm_cluster
from cli_case import read
from farm_test import BAKE, FarmCase

FARM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "farm")

# Each trouble happens once: worker 2 is killed in its tiles, worker 4 cannot write them, worker 0 is killed in the cache.
TROUBLE = """\
#!/bin/bash
killed() { "{program}" "$@" & sleep 0.1; kill -9 $!; wait $!; exit $?; }
case "$*" in
  *"--index 0 "*"--stage cache"*) mkdir "{folder}/once-0" 2>/dev/null && killed "$@" ;;
  *"--index 2 "*"--stage tiles"*) mkdir "{folder}/once-2" 2>/dev/null && killed "$@" ;;
  *"--index 4 "*"--stage tiles"*) mkdir "{folder}/once-4" 2>/dev/null && ulimit -f 1 ;;
esac
exec "{program}" "$@"
"""


class LauncherCase(FarmCase):
    def setUp(self):
        super().setUp()
        self.source = self.scene()
        self.expected = self.baked(self.source, *BAKE)
        self.troubled = self.path("halflight")
        with open(self.troubled, "w") as file:
            file.write(TROUBLE.replace("{program}", cli_case.HALFLIGHT).replace("{folder}", self.folder.name))
        os.chmod(self.troubled, 0o755)

    def launch(self, script, *arguments, **variables):
        return subprocess.run(
            [os.path.join(FARM, script), *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=300,
            stdin=subprocess.DEVNULL,
            env={**os.environ, "HALFLIGHT": self.troubled, **variables},
        )

    def assert_all_troubles_happened(self):
        self.assertEqual([n for n in sorted(os.listdir(self.folder.name)) if n.startswith("once")],
                         ["once-0", "once-2", "once-4"])


class Parallel(LauncherCase):
    def setUp(self):
        if shutil.which("parallel") is None:
            self.skipTest("GNU parallel is not installed")
        super().setUp()

    def test_same_bytes_after_killed_workers_and_a_full_disk(self):
        plan, out = self.plan(self.source, *BAKE), self.path("out.glb")
        result = self.launch("parallel.sh", plan, out, 6, "--jobs", 3)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read(out), self.expected)
        self.assert_all_troubles_happened()

    def test_says_what_is_missing(self):
        plan, out = self.plan(self.source, *BAKE), self.path("out.glb")
        result = self.launch("parallel.sh", plan, out, 6, "--jobs", 3, "--retries", 1)
        self.assertEqual(result.returncode, 1)
        self.assertIn("workers 2,4 of 6", result.stderr)
        self.assertFalse(os.path.exists(out))
        again = self.launch("parallel.sh", plan, out, 6, "--jobs", 3)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(read(out), self.expected)


class Slurm(LauncherCase):
    def setUp(self):
        if reason := slurm_cluster.why_not():
            self.skipTest(reason)
        super().setUp()

    def test_same_bytes_after_requeues_in_arrays_beyond_the_limit(self):
        plan, out = self.plan(self.source, *BAKE), self.path("out.glb")
        folder = tempfile.mkdtemp(prefix="hl-slurm-", dir="/tmp")  # a socket's path is short
        self.addCleanup(shutil.rmtree, folder, True)
        with slurm_cluster.Cluster(folder, nodes=3, most_array_size=4) as cluster:
            result = self.launch("slurm.sh", plan, out, 6, "--wait", SLURM_CONF=cluster.configuration)
            logs = {n: read(os.path.join(plan, "logs", n)).decode() for n in sorted(os.listdir(os.path.join(plan, "logs")))}
            self.assertEqual(result.returncode, 0, f"{result.stderr}\n{logs}")
            self.assertEqual(read(out), self.expected)
            self.assert_all_troubles_happened()
            # Both stages took two arrays: MaxArraySize is 4.
            self.assertEqual(len({n.rsplit("-", 1)[0] for n in logs if n.startswith("tiles")}), 2)
            self.assertIn("cannot be written", "".join(logs.values()))

            # What is broken later is found, named, and alone submitted again.
            os.remove(self.parts(plan, "lightmap")[3])
            os.remove(out)
            before = set(os.listdir(os.path.join(plan, "logs")))
            result = self.launch("slurm.sh", plan, out, 6, "--wait", SLURM_CONF=cluster.configuration)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(read(out), self.expected)
            new = sorted(set(os.listdir(os.path.join(plan, "logs"))) - before)
            self.assertEqual([n.split("-")[0] for n in new], ["join", "tiles"])


if __name__ == "__main__":
    cli_case.main()
