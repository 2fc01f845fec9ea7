#!/usr/bin/python3
"""panels.py NPM HOST_SIM SMASERVOD SOURCES [KIND ...]: every panel of every kind of report is drawn, and can
be explored.

Writes one report of each kind into a folder of its own and opens each once in Chromium; in Firefox the fewest
that have all types of panels between them (type_names()), once each, and prints one of these: a print takes
Firefox 5 s. open_reports.js does so, whose packages of npm are kept in NPM. On screen each panel has to have
pixels of the curves' colours; in print the texts of every picture have to be in the PDF. In the replay the
mouse is moved: cursor, zoom of linked panels, and curves that are taken off; it is also opened without its
script. Nothing is left out: where a browser, node, npm or smaservod is missing, or host-sim was built without
the script, the test fails.
"""

import base64
import concurrent.futures
import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unicodedata

from PIL import Image

WIDTH = 1100
PROGRAMS = ("chromium", "firefox-esr", "node", "npm", "pdftotext")
KINDS = ("replay", "inspect", "simulate", "tune", "figures", "can step", "calibrate-plan", "identify", "compare",
         "campaign", "choose")
# What a browser may do differently it does so for a type of panel, and these have all types.
KINDS_OF = {"chromium": KINDS, "firefox": ("replay", "inspect", "simulate", "tune", "figures")}
PRINTED = {"chromium": KINDS, "firefox": ("figures",)}  # of pictures, some below a plot and some not
EXPLORED = "replay"  # with the mouse, and once more without its script
# Colours of points, which no data says (papers 000 and 001).
PICTURES_ONLY = {"figures": 5}
# Only a program that hangs takes so long.
PATIENCE_S = 600
DATA = re.compile(r'<script type="application/json" class="panels">(.*?)</script>', re.DOTALL)
SCRIPT = re.compile(r"<script>.*?</script>\n(?=</body>)", re.DOTALL)


def bath(folder, name, stress):
    """A made-up run in a bath, which is identified in no time."""
    rows = ["temperature_degC,strain_ref,resistance_ohm,stress_MPa"]
    for k in range(400):
        heats = k < 200
        degC = 20 + (k if heats else 400 - k) / 2
        share = min(max((degC - (70 if heats else 50)) / 20, 0), 1)
        rows.append(f"{degC},{0.04 * (1 - share):.6f},{22 - 2 * share:.6f},{stress}")
    (folder / name).write_text("\n".join(rows) + "\n")


def excerpt(trace, rows, every):
    """Its first rows, but only each so many of them: a fit takes as long as what it has to simulate."""
    head, *lines = trace.read_text().splitlines(keepends=True)
    return head + "".join(lines[:rows:every])


def can_step(host_sim, smaservod, sources, folder, page):
    """Two steps of a daemon on a simulated wire, on a bus that nobody else is on.

    The wire's time stands still while the loop waits for the processor, so that is a fault only from one second
    on (firmware/daemon/README.md, "A stall"). The bus's thread has to be heard each 0.1 s of the loop's time
    (bus_lost), and brings commands (command_timeout): on one processor neither thread goes on for long without
    the other.
    """
    device = folder / "device.toml"
    device.write_text("".join((sources / "tests/can" / name).read_text()
                              for name in ("device.toml", "node_1_at_250_Hz.toml"))
                      + "command_timeout_ms = 60000\n")
    session = """
      taskset --cpu-list "$5" "$1" --board sim --bus udp --no-real-time --device "$4" >/dev/null 2>&1 &
      trap "kill $!" EXIT
      # One answer is enough: the node is there.
      until "$2" can --can udp get 1018:1 >/dev/null 2>&1; do kill -0 $! || exit 1; done
      for k in 1 2; do
        "$2" can --can udp --timeout 60 step --amplitude-um 500 --seconds 1 --report "$3" && continue
        "$2" can --can udp --timeout 60 faults >&2
        exit 1
      done"""
    subprocess.run(["timeout", str(PATIENCE_S), sources / "tests/can/own_network.sh", "bash", "-c", session,
                    "session", smaservod, host_sim, page, device, str(min(os.sched_getaffinity(0)))],
                   cwd=folder, check=True, stdout=subprocess.DEVNULL)


def write_report(kind, host_sim, smaservod, sources, folder):
    """The file of a report of this kind."""
    traces = sources / "host-sim/traces"
    commands = {
        "replay": ["replay", "--wire", traces / "units/a.toml", traces / "50MPa.csv"],
        "inspect": ["inspect", "--wire", traces / "units/a.toml", traces / "50MPa.csv"],
        "simulate": ["simulate", sources / "host-sim/scenarios/steps.toml", "--out", "loop.csv"],
        "tune": ["tune", "--wire", "smartflex-76um", "--stress-MPa", "150"],
        "calibrate-plan": ["calibrate-plan", "smartflex-76um", "--stress-MPa", "150",
                           "--duration-s", "20", "--out", "plan.csv"],
        "identify": ["identify", "--from", "smartflex-76um", "--out", "wire.toml", "heated.csv"],
        "compare": ["compare", "--train", "train.csv", "--test", "test.csv", "--out", "compare.json"],
        "campaign": ["campaign", "campaign.toml", "--out", "campaign"],
        "choose": ["choose", "--force-N", "5", "--stroke-mm", "4"],
    }
    page = folder / f"{kind.replace(' ', '-')}.html"
    if kind == "can step":
        can_step(host_sim, smaservod, sources, folder, page)
        return page
    if kind == "figures":
        command = ["figures", "--out", "figures", "--paper", "000", "--paper", "001"]
        page = folder / "figures/index.html"
    else:
        command = [*commands[kind], "--report", page]
    if kind == "identify":
        (folder / "heated.csv").write_text(excerpt(traces / "50MPa.csv", 1000, 10))
    if kind == "campaign":
        (folder / "campaign.toml").write_text("kind = 'gains'\ntrials = 6\n[gains]\nscenario = "
                                              f"'{sources}/host-sim/scenarios/steps.toml'\n")
    if kind == "compare":
        bath(folder, "train.csv", 150)
        bath(folder, "test.csv", 140)
    subprocess.run([host_sim, *command], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return page


class Browser:
    """Opens reports, one after the other."""

    def __init__(self, name, sources, packages):
        here = sources / "tests/host-sim"
        command = [sources / "tests/npm.sh", here / "page/node", packages, "node",
                   here / "report/open_reports.js", name]
        self.name = name
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)

    def open(self, **job):
        self.process.stdin.write(json.dumps(job) + "\n")
        self.process.stdin.flush()
        for line in self.process.stdout:
            # npm may have said something before.
            if line.startswith("{"):
                return json.loads(line)
        raise SystemExit(f"{self.name} has ended: {self.process.wait()}")

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def is_drawn(picture, in_ink):
    """More than a frame: a few per cent of it are not white, and some of that is not grey, or where all curves
    have the colour of ink is black, which axes are not."""
    pixels = picture.width * picture.height
    colours = picture.getcolors(maxcolors=pixels)
    inked = sum(n for n, (r, g, b) in colours if min(r, g, b) < 200)
    curves = sum(n for n, (r, g, b) in colours
                 if (max(r, g, b) < 60 if in_ink else max(r, g, b) - min(r, g, b) > 60))
    return inked > 0.005 * pixels and curves > 0.0005 * pixels


def texts_of(svg):
    texts = re.findall(r"<text[^>]*>(.*?)</text>", svg, re.DOTALL)
    return html.unescape(" ".join(re.sub(r"<[^>]*>", "", t) for t in texts))


def words(text):
    """Of four letters and digits or more: other characters may come from another font, in a line of
    their own. A PDF may have one character for f and i."""
    return set(re.findall(r"[A-Za-z0-9]{4,}", unicodedata.normalize("NFKC", text)))


def pictures(text):
    return [base64.b64decode(panel).decode()
            for panel in re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]*)", text)]


def unprinted(text, pdf):
    """Words of pictures that are nowhere in the PDF."""
    printed = words(subprocess.run(["pdftotext", "-raw", pdf, "-"], check=True,
                                   stdout=subprocess.PIPE).stdout.decode())
    of_pictures = [words(texts_of(svg)) for svg in pictures(text)]
    return [f"picture {k} has no word" for k, these in enumerate(of_pictures) if not these] + [
        f"{word} of picture {k}" for k, these in enumerate(of_pictures) for word in sorted(these - printed)]


def panels_of(text):
    """What the page says of its panels; None for one that is a picture only."""
    return [panel for data in DATA.findall(text) for panel in json.loads(data)["panels"]]


def is_in_ink(panel):
    return panel is not None and all(series["colour"] == "ink" for series in panel["series"])


def type_names(panel):
    """What there is in a panel that front/src/report draws with code of its own."""
    if panel is None:
        return {"picture only"}
    names = {series["kind"] for series in panel["series"]}
    names |= {name for name in ("link", "follows", "equal", "half") if panel.get(name)}
    names |= {f"logarithmic {axis}" for axis in ("x", "y") if panel[axis].get("log")}
    names |= {f"ticks of {axis}" for axis in ("x", "y") if panel[axis].get("ticks")}
    names |= {"seconds"} if panel["x"].get("label", "").endswith(" in s") else set()
    names |= {name for name in ("rules", "notes") if panel[name]}
    names |= {name for name in ("right", "dashed") if any(series.get(name) for series in panel["series"])}
    return names


def problems(browser, folder, kind, page, with_script):
    """What is wrong with the page on screen and in print; the number of panels."""
    text = page.read_text()
    name = f"{kind}-{browser.name}-{'live' if with_script else 'still'}"
    copy = folder / f"{name}.html"
    copy.write_text(text if with_script else SCRIPT.sub("", text))
    explore = with_script and kind == EXPLORED
    pdf = folder / f"{name}.pdf" if kind in PRINTED[browser.name] else None
    picture = folder / f"{name}.png"
    did = browser.open(page=str(copy), screen=str(picture), pdf=pdf and str(pdf), explore=explore)
    screen = Image.open(picture).convert("RGB")
    boxes = did["boxes"]
    panels = panels_of(text)
    counts = {"on screen": len(boxes), "in the data": len(panels), "as pictures": len(pictures(text))}
    if not boxes or len(set(counts.values())) != 1:
        return [f"not all panels are everywhere: {counts}"], len(boxes)
    found = [f"missing: {what}" for what in did["missing"]]
    found += [f"error: {error}" for error in did["errors"]]
    blank = [k for k, (box, panel) in enumerate(zip(boxes, panels))
             if box[2] - box[0] < 100 or box[3] > screen.height
             or not is_drawn(screen.crop(box), is_in_ink(panel))]
    if blank:
        found.append(f"blank on screen: {blank} of {len(boxes)}")
    if did["width"] > WIDTH:
        found.append(f"wider than the screen: {did['width']}")
    missing = unprinted(text, pdf) if pdf else []
    if missing:
        found.append(f"not in print: {', '.join(missing)}")
    live = len(boxes) - PICTURES_ONLY.get(kind, 0) if with_script else 0
    if did["live"] != live:
        found.append(f"{did['live']} panels are interactive instead of {live}")
    return found, len(boxes)


def check(name, sources, packages, folder, written):
    """Whether all is well with the reports that this browser opens; says what is not."""
    browser = Browser(name, sources, packages)
    well = True
    for kind in KINDS_OF[name]:
        if kind not in written:
            continue
        page = written[kind].result()
        if not SCRIPT.search(page.read_text()):
            raise SystemExit("The reports have no script: host-sim was built without npm.")
        still = kind == EXPLORED and name == "chromium"
        for with_script in (True, False) if still else (True,):
            found, panels = problems(browser, folder, kind, page, with_script)
            how = "" if with_script else " without its script"
            print(f"{kind}, {name}{how}: {panels} panels: {'; '.join(found) or 'good'}", flush=True)
            well = well and not found
    browser.close()
    return well


def untried_types(pages):
    """Types of panels that some report has, but none of those that Firefox opens."""
    types = {kind: set().union(*map(type_names, panels_of(page.read_text()))) for kind, page in pages.items()}
    return set().union(*types.values()).difference(*(types[kind] for kind in KINDS_OF["firefox"]))


def main(packages, host_sim, smaservod, sources, *wanted):
    host_sim, smaservod, sources = (pathlib.Path(path).absolute() for path in (host_sim, smaservod, sources))
    missing = [name for name in PROGRAMS if not shutil.which(name)]
    missing += [str(path) for path in (host_sim, smaservod) if not path.exists()]
    if missing:
        raise SystemExit(f"This test needs what is not there: {', '.join(missing)}.")
    unknown = set(wanted) - set(KINDS)
    if unknown:
        raise SystemExit(f"There is no such kind of report: {', '.join(unknown)}.")
    with tempfile.TemporaryDirectory() as name, concurrent.futures.ThreadPoolExecutor() as browsers, \
            concurrent.futures.ThreadPoolExecutor(max_workers=2) as writer:
        folder = pathlib.Path(name)
        written = {kind: writer.submit(write_report, kind, host_sim, smaservod, sources, folder)
                   for kind in wanted or KINDS}
        checks = [browsers.submit(check, browser, sources, packages, folder, written) for browser in KINDS_OF]
        well = all([each.result() for each in checks])
        if not wanted:
            untried = untried_types({kind: each.result() for kind, each in written.items()})
            if untried:
                print(f"types of panels that Firefox has not opened: {', '.join(sorted(untried))}")
                well = False
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
