"""A Slurm cluster on this machine: controller, several nodes, MUNGE, all in one folder and on ports of their own."""

import os
import shutil
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "sinfo")


def why_not():
    """Why there can be no cluster here, as a sentence; empty when there can."""
    missing = [name for name in PROGRAMS if find(name) is None]
    if missing:
        return "Slurm is not installed (no " + ", ".join(missing) + "); Debian: apt-get install slurm-wlm munge"
    if os.geteuid() != 0:
        return "slurmd starts jobs of other users, so this test runs as root"
    return ""


def find(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin:/usr/local/sbin")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


CONFIGURATION = """\
ClusterName=halflight
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/linear
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
ReturnToService=2
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
KillWait=1
MaxArraySize={most}
{nodes}
PartitionName=all Nodes={names} Default=YES MaxTime=INFINITE State=UP
"""


class Cluster:
    def __init__(self, folder, nodes, most_array_size):
        self.folder = folder
        self.processes = []
        self.names = [f"farm{i}" for i in range(nodes)]
        os.chmod(folder, 0o755)
        for name in ("munge", "state"):
            os.mkdir(os.path.join(folder, name), 0o755)
        control, *ports = free_ports(nodes + 1)
        host = socket.gethostname()
        rows = [f"NodeName={n} NodeHostname={host} NodeAddr=127.0.0.1 Port={p} CPUs=1" for n, p in zip(self.names, ports)]
        self.configuration = os.path.join(folder, "slurm.conf")
        with open(self.configuration, "w") as file:
            file.write(
                CONFIGURATION.format(
                    host=host, control=control, folder=folder, most=most_array_size, nodes="\n".join(rows),
                    names=",".join(self.names),
                )
            )
        self.environment = {**os.environ, "SLURM_CONF": self.configuration}

    def __enter__(self):
        try:
            self.start_munge()
            self.start("slurmctld", "-D")
            for name in self.names:
                self.start("slurmd", "-D", "-N", name)
            self.wait_until(lambda: self.run("sinfo", "-h", "-o", "%T %D").split() == ["idle", str(len(self.names))])
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start_munge(self):
        key = os.path.join(self.folder, "munge.key")
        with open(key, "wb") as file:
            file.write(os.urandom(1024))
        os.chmod(key, 0o400)
        at = os.path.join(self.folder, "munge")
        options = {"key-file": key, "socket": f"{at}/socket", "log-file": f"{at}/log", "pid-file": f"{at}/pid"}
        options["seed-file"] = f"{at}/seed"
        # --force: root may run it.
        self.start("munged", "--foreground", "--force", *(f"--{k}={v}" for k, v in options.items()))
        self.wait_until(lambda: os.path.exists(f"{at}/socket"))

    def start(self, name, *arguments):
        with open(os.path.join(self.folder, f"{name}{len(self.processes)}.out"), "wb") as log:
            self.processes.append(
                subprocess.Popen([find(name), *arguments], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                 env=self.environment)
            )

    def stop(self):
        for process in reversed(self.processes):
            process.terminate()
        for process in self.processes:
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def run(self, name, *arguments):
        result = subprocess.run([find(name), *arguments], capture_output=True, text=True, env=self.environment)
        return result.stdout if result.returncode == 0 else ""

    def wait_until(self, condition, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                logs = [f"{p}: {open(os.path.join(self.folder, p), errors='replace').read()[-500:]}"
                        for p in sorted(os.listdir(self.folder)) if p.endswith(".out")]
                raise RuntimeError("the cluster did not come up:\n" + "\n".join(logs))
            time.sleep(0.2)
