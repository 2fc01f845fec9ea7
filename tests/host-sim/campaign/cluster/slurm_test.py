#!/usr/bin/env python3
"""slurm_test.py HOST_SIM SOURCES: campaigns on the real Slurm, a controller and two nodes on this machine.

All of it is in namespaces: network, mounts, processes and host names of its own. So it has the usual ports, touches no
other Slurm, runs beside another one of its kind, and ends with its first process, however that ends. Each node has
process numbers of its own: killing its first process is a computer that loses power.
"""

import os
import re
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HOST_SIM, SOURCES = (Path(argument).resolve() for argument in sys.argv[1:3])
PATIENCE_S = 600  # tests/patience.hpp: only what hangs takes so long
TASKS = 4
TRIALS = 32  # of a fifth of a second each
PLAN = f"""kind = 'scenarios'
trials = {TRIALS}
seed = 1
chunk = 1
[scenarios]
units = 1
wires = '{SOURCES}/tests/golden/evaluate'
"""
NODES = ("n1", "n2")
ADDRESS = "10.77.0.1"


def config(place):
    nodes = "\n".join(
        f"NodeName={name} NodeAddr={ADDRESS} Port={7001 + k} CPUs=2 RealMemory=500 State=UNKNOWN"
        for k, name in enumerate(NODES))
    return f"""ClusterName=test
SlurmctldHost=head({ADDRESS})
SlurmUser=root
SlurmdUser=root
AuthInfo=socket={place}/munge/socket
StateSaveLocation={place}/head
SlurmdSpoolDir={place}/%n
SlurmctldPidFile={place}/head.pid
SlurmdPidFile={place}/%n.pid
SlurmctldLogFile={place}/head.log
SlurmdLogFile={place}/%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
SlurmdTimeout=3
KillWait=5
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def skip(reason):
    print(f"SKIPPED: {reason}")
    sys.exit(77)


def begin():
    """Starts this file again, in its namespaces."""
    if os.geteuid() != 0:
        skip("Slurm's daemons run as root here, and this is not root")
    for name in ("slurmctld", "slurmd", "sbatch", "munged", "unshare", "ip"):
        if not shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin"):
            skip(f"{name} is missing; packages slurm-wlm, munge, util-linux, iproute2")
    # All ends with this process, and in the namespaces with their first one.
    alone = ["setpriv", "--pdeathsig", "KILL", "unshare", "--net", "--mount", "--pid", "--uts", "--fork",
             "--kill-child", "--mount-proc"]
    tried = subprocess.run([*alone, "ip", "link", "add", "here", "type", "veth", "peer", "name", "there"],
                           capture_output=True, text=True)
    if tried.returncode != 0:
        skip(f"no namespaces of its own: {tried.stderr.strip()}")
    with tempfile.TemporaryDirectory(prefix="slurm-") as place:
        inside = subprocess.Popen([*alone, sys.executable, *sys.argv, place])
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: inside.kill())
        return inside.wait()


def becomes(what, condition):
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"in vain: {what}")


def run(*words, **options):
    return subprocess.run(words, capture_output=True, text=True, **options)


def checked(*words, **options):
    ended = run(*words, **options)
    assert ended.returncode == 0, f"{words}: {ended.returncode}\n{ended.stdout}\n{ended.stderr}"
    return ended.stdout


class Cluster:
    def __init__(self, place):
        self.place, self.nodes, self.daemons = place, {}, []
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200m,mode=755", "none", place], check=True)
        # Before the nodes take their copies of all mounts.
        (place / "full").mkdir()
        checked("mount", "-t", "tmpfs", "-o", "size=80k", "none", place / "full")
        # Names are found only where there is an address that is not the loopback's.
        for words in ("link set lo up", "link add here type veth peer name there", f"address add {ADDRESS}/24 dev here",
                      "link set here up", "link set there up"):
            subprocess.run(["ip", *words.split()], check=True)
        subprocess.run(["hostname", "head"], check=True)
        for name in ("munge", "head", *NODES):
            (place / name).mkdir(mode=0o755)
        key = place / "munge/key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(256))
        (place / "slurm.conf").write_text(config(place))
        version = checked("slurmctld", "-V").split()[-1]
        if int(version.split(".")[0]) >= 24:
            (place / "cgroup.conf").write_text("CgroupPlugin=disabled\n")
        os.environ["SLURM_CONF"] = str(place / "slurm.conf")
        print(f"Slurm {version}")
        munge = place / "munge"
        self.start("munged", "--force", "--foreground", "--origin=127.0.0.1", f"--socket={munge}/socket",
                   f"--key-file={key}", f"--pid-file={munge}/pid", f"--log-file={munge}/log",
                   f"--seed-file={munge}/seed")
        becomes("munged answers", lambda: self.lives() and run(
            "munge", f"--socket={munge}/socket", "--no-input").returncode == 0)
        self.start("slurmctld", "-D")
        for name in NODES:
            self.start_node(name)
        becomes("both nodes are idle", lambda: self.lives() and node_states() == ["idle", "idle"])

    def start(self, *words):
        with (self.place / "daemons.out").open("a") as out:
            self.daemons.append(subprocess.Popen(words, stdout=out, stderr=out, stdin=subprocess.DEVNULL))
        return self.daemons[-1]

    def lives(self):
        ended = [daemon.args for daemon in self.daemons if daemon.poll() is not None]
        assert not ended, f"{ended} has ended:\n{(self.place / 'daemons.out').read_text()[-3000:]}\n{self.logs()}"
        return True

    def start_node(self, name):
        self.nodes[name] = self.start(
            "unshare", "--pid", "--uts", "--mount", "--fork", "--kill-child", "--mount-proc", "sh", "-c",
            f"hostname {name} && exec slurmd -D")

    def lose_power(self, name):
        """kill -9 of all processes of a node at once: slurmd, slurmstepd, host-sim."""
        unshare = self.nodes[name]
        first = Path(f"/proc/{unshare.pid}/task/{unshare.pid}/children").read_text().split()[0]
        os.kill(int(first), signal.SIGKILL)
        unshare.wait()

    def logs(self):
        text = ""
        for path in sorted(self.place.glob("*.log")):
            text += f"== {path.name}\n" + "\n".join(path.read_text(errors="replace").splitlines()[-40:]) + "\n"
        return text


def node_states():
    listed = run("sinfo", "-h", "-N", "-o", "%t")
    return listed.stdout.split() if listed.returncode == 0 else []


def jobs(number):
    """Of each task of a job, or of the job: its fields. Of tasks that have not begun there is one record."""
    listed = run("scontrol", "-o", "show", "job", str(number))
    if listed.returncode != 0:
        return []
    return [dict(re.findall(r"(\w+)=(\S*)", line)) for line in listed.stdout.splitlines()]


def state(number):
    return {job["JobState"] for job in jobs(number)}


class Submitted:
    """A campaign that was given to Slurm."""

    def __init__(self, folder, *options, plan):
        self.folder = folder
        said = checked(HOST_SIM, "campaign", plan, "--out", folder, "--slurm", "--tasks", str(TASKS), *options)
        self.shards, self.merge = re.search(r"job (\d+)\. Job (\d+) joins", said).groups()

    def chunks(self):
        """Of each chunk that is there: which file it is, and when it was written."""
        found = {}
        for path in (self.folder / "chunks").glob("*.csv"):
            stat = path.stat()
            found[path.name] = (stat.st_ino, stat.st_mtime_ns)
        return found

    def task_on(self, node, but=()):
        """A task that computes on this node."""
        return next((job["ArrayTaskId"] for job in jobs(self.shards) if job["JobState"] == "RUNNING"
                     and job["NodeList"] == node and job["ArrayTaskId"] not in but), None)

    def log(self, task):
        path = self.folder / f"slurm-{self.shards}_{task}.log"
        return path.read_text() if path.exists() else ""

    def restarts(self, task):
        return int(next(job["Restarts"] for job in jobs(f"{self.shards}_{task}")))

    def begin_at_once(self):
        """Slurm lets a task that was put back wait for two minutes, in which a node that was lost gets the message to
        end the former run: without them the task begins on another node."""
        for job in jobs(self.shards):
            if job["JobState"] == "PENDING" and job["Reason"] == "BeginTime":
                run("scontrol", "update", f"JobId={job['JobId']}", "StartTime=now", "ExcNodeList=n1")

    def ends_well(self):
        def merge_has_ended():
            self.begin_at_once()
            return state(self.merge) & {"COMPLETED", "FAILED", "CANCELLED"}

        becomes("the merge ends", merge_has_ended)
        logs = "".join(path.read_text() for path in sorted(self.folder.glob("slurm-*.log")))
        assert state(self.merge) == {"COMPLETED"}, f"{jobs(self.merge)}\n{logs}"
        assert state(self.shards) == {"COMPLETED"}, f"{jobs(self.shards)}\n{logs}"


def expect_same(folder, reference):
    assert (folder / "trials.csv").read_bytes() == (reference / "trials.csv").read_bytes()
    rows = (folder / "trials.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == [str(k) for k in range(TRIALS)], "each trial once"


def begun(part):
    print(part, flush=True)


def test(cluster):
    plan, reference = cluster.place / "plan.toml", cluster.place / "reference"
    plan.write_text(PLAN)
    checked(HOST_SIM, "campaign", plan, "--out", reference, "--threads", "2", "--report", f"{reference}.html")

    begun("an array of tasks gives the bytes of one process, in a folder with a name that needs quotes")
    folder = cluster.place / "it's \"ours\" #1 $HOME & é"
    report = cluster.place / "a 'report'.html"
    whole = Submitted(folder, "--report", report, plan=plan)
    whole.ends_well()
    assert {job["NodeList"] for job in jobs(whole.shards)} == set(NODES)
    expect_same(folder, reference)
    assert report.read_bytes() == Path(f"{reference}.html").read_bytes()
    for task in range(TASKS):
        assert f"shard {task}/{TASKS}: 8 chunks: 8 computed, 0 were there" in whole.log(task), whole.log(task)
    assert "trials of the kind scenarios" in (folder / f"slurm-{whole.merge}-merge.log").read_text()

    begun("what sbatch refuses is said, and the scripts can be submitted by hand")
    before = whole.chunks()
    refused = run(HOST_SIM, "campaign", plan, "--out", folder, "--slurm", "--tasks", str(TASKS),
                  env={**os.environ, "SBATCH_PARTITION": "none"})
    assert refused.returncode == 1 and "Invalid partition" in refused.stderr, refused.stderr
    (folder / "trials.csv").unlink()
    by_hand = refused.stderr[refused.stderr.index("job=$("):]
    merge = re.search(r"job (\d+)", checked("bash", "-c", by_hand)).group(1)
    becomes("the merge ends", lambda: state(merge) == {"COMPLETED"})
    expect_same(folder, reference)
    assert whole.chunks() == before

    begun("a batch script with two tasks is one process, no two ranks of MPI")
    alone = cluster.place / "alone"
    two = checked("sbatch", "--parsable", "--ntasks=2", "--output", cluster.place / "two.log", "--wrap",
                  f"exec '{HOST_SIM}' campaign '{plan}' --out '{alone}'")
    becomes("the job ends", lambda: state(two.strip()) & {"COMPLETED", "FAILED", "CANCELLED"})
    assert state(two.strip()) == {"COMPLETED"}, (cluster.place / "two.log").read_text()
    expect_same(alone, reference)

    begun("a node is lost, and a task is put back: both go on with what is there")
    lost = Submitted(cluster.place / "lost", plan=plan)
    killed = becomes("a task runs on n1", lambda: lost.task_on("n1"))
    moved = becomes("a task runs on n2", lambda: lost.task_on("n2"))
    becomes("both have a chunk", lambda: {int(name[:6]) % TASKS for name in lost.chunks()} >= {int(killed), int(moved)})
    cluster.lose_power("n1")
    checked("scontrol", "requeue", f"{lost.shards}_{moved}")
    becomes("the task has ended", lambda: "interrupted: 8 chunks" in lost.log(moved))
    before = lost.chunks()
    assert len(before) < TRIALS
    # Slurm would see it by itself after half a minute.
    checked("scontrol", "update", "NodeName=n1", "State=DOWN", "Reason=lost")
    becomes("its tasks wait", lambda: state(f"{lost.shards}_{killed}") == {"PENDING"})
    cluster.start_node("n1")
    becomes("it is back", lambda: node_states() and set(node_states()) <= {"idle", "mix", "alloc"})
    lost.ends_well()
    assert lost.restarts(killed) == 1 and lost.restarts(moved) == 1
    expect_same(lost.folder, reference)
    after = lost.chunks()
    assert {name: after[name] for name in before} == before, "no chunk is computed twice"

    begun("a full disk ends tasks with an error and keeps the merge from beginning; with room they go on")
    full = cluster.place / "full"
    failed = Submitted(full, plan=plan)
    becomes("the merge is cancelled", lambda: state(failed.merge) == {"CANCELLED"})
    becomes("all tasks have ended", lambda: state(failed.shards) <= {"COMPLETED", "FAILED"})
    assert "FAILED" in state(failed.shards)
    assert not (full / "trials.csv").exists()
    before = failed.chunks()
    assert 0 < len(before) < TRIALS
    checked("mount", "-o", "remount,size=10m", full)
    again = Submitted(full, plan=plan)
    again.ends_well()
    expect_same(full, reference)
    after = again.chunks()
    assert {name: after[name] for name in before} == before
    assert not list(full.glob("chunks/*.part"))


def main():
    if len(sys.argv) == 3:
        return begin()
    place = Path(sys.argv[3])
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    for name in list(os.environ):
        if name.startswith(("SLURM_", "SBATCH_")):
            del os.environ[name]
    cluster = Cluster(place)
    began = time.monotonic()
    try:
        test(cluster)
    except BaseException:
        print(cluster.logs())
        raise
    print(f"passed, {time.monotonic() - began:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
