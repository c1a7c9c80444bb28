#!/usr/bin/env python3
"""How much faster two nodes of Slurm draw 1,000 frames over a simulation in the cache than one does.

    bench/farm_nodes.py [--program build/release/aspic] [--frames 1000] [--share 0.3] [--pairs 2]

Starts a Slurm of two nodes on this machine (as root; slurm-wlm, munge), each of them held to a share of
a core by a cgroup of its own (cpu.max, or cpu.cfs_quota_us). Both are bound to one core, so neither has
a core that it would not have alone. A core has to be free for 2 x SHARE; its cgroups have the weight to
be served first. The simulation of a soft ball is cooked once; each run begins with a copy of that
cache, on one node and on two in turn. Of each run it prints where the time goes:

    drawing   cooking in the tasks of the frames, summed over nodes (s of the clock)
    processor what both nodes had of it, from the command to its end
    waiting   of a node, from the end of a task to the first frame of the next: Slurm's look at its queue
              and the start of the program
    first     from the command to the first frame: the plan, sbatch, Slurm, the start of the program
    alone     while one node still draws and the other one has nothing left
    last      from the last frame to the end: the last task and the comparison with the manifest
"""
import argparse
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from farm_scale import document

NODES = ("n0", "n1")


class Share:
    """A cgroup whose processes have so much of a core."""

    def __init__(self, name, share):
        period = 20_000  # us: short beside a frame
        one = pathlib.Path("/sys/fs/cgroup/cpu")
        if one.is_dir():
            self.path = one / name
            self.path.mkdir()
            (self.path / "cpu.shares").write_text("20000")
            (self.path / "cpu.cfs_period_us").write_text(str(period))
            (self.path / "cpu.cfs_quota_us").write_text(str(int(share * period)))
            self.account = one.parent / "cpuacct" / name
            self.account.mkdir(exist_ok=True)  # the same folder where both are one hierarchy
        else:
            (one.parent / "cgroup.subtree_control").write_text("+cpu")
            self.path = one.parent / name
            self.path.mkdir()
            (self.path / "cpu.weight").write_text("2000")
            (self.path / "cpu.max").write_text(f"{int(share * period)} {period}")
            self.account = self.path

    def enter(self):
        for path in (self.path, self.account):
            (path / "cgroup.procs").write_text(str(os.getpid()))
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})

    def processor(self):
        """s that its processes have had."""
        usage = self.account / "cpuacct.usage"
        if usage.exists():
            return int(usage.read_text()) / 1e9
        return int((self.account / "cpu.stat").read_text().split()[1]) / 1e6

    def remove(self):
        for path in {self.path, self.account}:
            for _ in range(100):
                try:
                    path.rmdir()
                    break
                except OSError:  # its processes are ending
                    time.sleep(0.1)


class Slurm:
    """Two nodes in a folder; `with` stops them."""

    def __init__(self, folder, share):
        self.folder = folder
        for name in ("log", "state", "spool"):
            (folder / name).mkdir()
        port = 10000 + os.getpid() % 5000 * 4
        (folder / "slurm.conf").write_text(
            f"ClusterName=bench\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort={port}\n"
            f"SlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\nAuthInfo=socket={folder}/munge.sock\n"
            "CredType=cred/munge\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n"
            "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nMpiDefault=none\n"
            f"ReturnToService=2\nStateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool/%n\n"
            f"SlurmdPidFile={folder}/%n.pid\nSlurmctldPidFile={folder}/slurmctld.pid\n"
            f"SlurmdLogFile={folder}/log/%n.log\nSlurmctldLogFile={folder}/log/slurmctld.log\n"
            "AccountingStorageType=accounting_storage/none\nMinJobAge=3600\n"
            "SlurmdParameters=config_overrides\n"
            "SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0,sched_min_interval=0\n"
            f"NodeName=n[0-1] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[{port + 1}-{port + 2}] "
            "CPUs=1 RealMemory=4000\n"
            "PartitionName=main Nodes=n[0-1] Default=YES MaxTime=INFINITE State=UP\n")
        os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
        self.shares = {n: Share(f"aspic_{os.getpid()}_{n}", share) for n in NODES}

    def __enter__(self):
        d = self.folder
        (d / "munge.key").write_bytes(os.urandom(1024))
        (d / "munge.key").chmod(0o400)
        subprocess.run(["munged", "--force", f"--key-file={d}/munge.key", f"--socket={d}/munge.sock",
                        f"--pid-file={d}/munged.pid", f"--log-file={d}/log/munged.log",
                        f"--seed-file={d}/munged.seed"], check=True, stderr=subprocess.DEVNULL)
        subprocess.run(["slurmctld", "-f", d / "slurm.conf"], check=True)
        for n, share in self.shares.items():
            subprocess.run(["slurmd", "-N", n, "-f", d / "slurm.conf"], check=True, preexec_fn=share.enter)
        for _ in range(300):
            if "2idle" in subprocess.run(["sinfo", "-h", "-r", "-o", "%D%t", "-t", "idle"], text=True,
                                         capture_output=True).stdout:
                return self
            time.sleep(0.1)
        raise RuntimeError(f"two nodes are not idle; see {d}/log")

    def __exit__(self, *_):
        subprocess.run(["scancel", "-u", "root"])
        files = [self.folder / f"{name}.pid" for name in (*NODES, "slurmctld", "munged")]
        for file in files:
            if file.exists():
                os.kill(int(file.read_text()), signal.SIGTERM)
        for _ in range(100):
            if not any(f.exists() for f in files):
                break
            time.sleep(0.1)
        for share in self.shares.values():
            share.remove()


def tasks_of(farm):
    """(node, first frame begins, last frame ends) of the tasks of the frames."""
    tasks = []
    for part in (farm / "parts").glob("*.frames-*.json"):
        ran = json.loads(part.read_text())["ran"]
        log = (farm / "logs" / (part.stem + ".log")).read_text()
        end = part.stat().st_mtime
        tasks.append((log.split(" on ")[1][:2], end - ran["seconds"], end))
    return sorted(tasks, key=lambda t: t[1])


def run(asked, program, folder, shares, nodes):
    """Seconds that the whole command took on so many nodes."""
    for name in ("cache", "out"):
        shutil.rmtree(folder / name, ignore_errors=True)
    shutil.copytree(folder / "simulated", folder / "cache")
    os.sync()
    command = [program, "farm", folder / "light.json", "--engine", "slurm", "--wait", "--cache",
               folder / "cache", "--out", folder / "out", "--threads", "1", "--task-seconds",
               str(asked.task_seconds)]
    if nodes == 1:
        command.append("--sbatch=--nodelist=n0")
    busy = sum(s.processor() for s in shares)
    begin = time.time()
    said = subprocess.run(command, text=True, capture_output=True)
    end = time.time()
    busy = sum(s.processor() for s in shares) - busy
    if said.returncode != 0:
        raise RuntimeError(said.stdout + said.stderr)
    tasks = tasks_of(folder / "out" / "farm")
    by_node = [[t for t in tasks if t[0] == n] for n in NODES[:nodes]]
    waiting = [b[1] - a[2] for mine in by_node for a, b in zip(mine, mine[1:])]
    ends = [mine[-1][2] for mine in by_node]
    took = sum(t[2] - t[1] for t in tasks)
    print(f"| {nodes} | {len(tasks)} | {end - begin:.0f} s | {took:.0f} s ({took / len(tasks):.1f} a task) "
          f"| {busy:.0f} s | {sum(waiting):.1f} s ({sum(waiting) / len(waiting):.2f} a "
          f"task) | {tasks[0][1] - begin:.1f} s | {max(ends) - min(ends):.1f} s | {end - max(ends):.1f} s |",
          flush=True)
    return end - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", default="build/release/aspic")
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--share", type=float, default=0.3, help="of a core, that each node has")
    parser.add_argument("--task-seconds", type=float, default=30, help="of the clock, of each task")
    parser.add_argument("--width", type=int, default=320, help="of pictures; the height is 9/16 of it")
    parser.add_argument("--pairs", type=int, default=2, help="runs on one node, each beside one on two")
    asked = parser.parse_args()
    if asked.share > 0.5:
        parser.error("--share: expected at most 0.5, since both nodes are on one core")
    program = pathlib.Path(asked.program).resolve()
    scene = document(1, asked.frames)
    del scene["nodes"]["video"]  # one machine makes it, after the light
    scene["nodes"]["picture"]["params"].update(width=asked.width, height=asked.width * 9 // 16)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "light.json").write_text(json.dumps(scene))
        cook = [program, "cook", folder / "light.json", "--cache", folder / "simulated", "--out",
                folder / "first", "-q"]
        subprocess.run(cook + ["--node", "sim"], check=True)
        print("| nodes | tasks | time | drawing | processor | waiting | first | alone | last |\n"
              "|---|---|---|---|---|---|---|---|---|", flush=True)
        times = {1: [], 2: []}
        with Slurm(folder, asked.share) as slurm:
            # What a frame takes on a node: the plan looks at it.
            subprocess.run(cook + ["--threads", "1", "--frames", "1-32"], check=True,
                           preexec_fn=slurm.shares["n0"].enter)
            for _ in range(asked.pairs):
                for nodes in (1, 2):
                    times[nodes].append(run(asked, program, folder, slurm.shares.values(), nodes))
    ratio = sum(times[1]) / sum(times[2])
    print(f"\ntwo nodes are {ratio:.2f} times one: " +
          ", ".join(f"{a:.0f} / {b:.0f} s" for a, b in zip(times[1], times[2])))
    return 0 if ratio >= 1.8 else 1


if __name__ == "__main__":
    sys.exit(main())
