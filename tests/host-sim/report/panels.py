#!/usr/bin/python3
"""panels.py NPM HOST_SIM SMASERVOD SOURCES [KIND ...]: every panel of every kind of report is drawn, and can
be explored.

Writes the reports into a folder of its own and opens each in Chromium and, where it is installed, in Firefox,
with and without its script (open_reports.js, whose packages of npm are kept in NPM). Either way each panel has to have drawn pixels on
screen, of the curves' colours too; in print the texts of every picture have to be in the PDF. Of one report
the mouse is moved: cursor, zoom of linked panels, and curves that are taken off. A program that was built
without npm has pictures only; then the parts about the script are left out, which the last line says.
77: neither a browser nor node.
"""

import base64
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unicodedata

from PIL import Image

WIDTH = 1100
BROWSERS = {"chromium": "chromium", "firefox": "firefox-esr"}
SCRIPT = re.compile(r"<script>.*?</script>\n(?=</body>)", re.DOTALL)


def bath(folder, name, stress):
    """A made-up run in a bath, which is identified in no time."""
    rows = ["temperature_degC,strain_ref,resistance_ohm,stress_MPa"]
    for k in range(400):
        heats = k < 200
        degC = 20 + (k if heats else 400 - k) / 2
        share = min(max((degC - (70 if heats else 50)) / 20, 0), 1)
        rows.append(f"{degC},{0.04 * (1 - share):.6f},{8 - share:.6f},{stress}")
    (folder / name).write_text("\n".join(rows) + "\n")


def can_step(host_sim, smaservod, sources, folder, page):
    """Two steps of a daemon on a simulated wire, on a bus that nobody else is on."""
    device = folder / "device.toml"
    device.write_text("".join((sources / "tests/can" / name).read_text()
                              for name in ("device.toml", "node_1_at_250_Hz.toml")))
    # Where a busy machine is a fault of the loop, the step is run again.
    session = """
      "$1" --board sim --bus udp --no-real-time --device "$4" >/dev/null 2>&1 &
      trap "kill $!" EXIT
      sleep 3
      for k in 1 2; do
        for try in 1 2 3 4 5; do
          timeout 60 "$2" can --can udp step --amplitude-um 500 --seconds 1 --report "$3" && continue 2
          timeout 60 "$2" can --can udp reset-faults
        done
        exit 1
      done"""
    subprocess.run([sources / "tests/can/own_network.sh", "bash", "-c", session, "session", smaservod,
                    host_sim, page, device], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def reports(host_sim, smaservod, sources, folder, wanted):
    """Name and file of one report of each kind."""
    traces = sources / "host-sim/traces"
    wire = traces / "units/a.toml"
    commands = {
        "replay": ["replay", "--wire", wire, traces / "50MPa.csv"],
        "simulate": ["simulate", sources / "host-sim/scenarios/steps.toml", "--out", "loop.csv"],
        "tune": ["tune", "--wire", "smartflex-76um", "--stress-MPa", "150"],
        "calibrate-plan": ["calibrate-plan", "smartflex-76um", "--stress-MPa", "150",
                           "--duration-s", "20", "--out", "plan.csv"],
        "identify": ["identify", "--from", "smartflex-76um", "--out", "wire.toml",
                     traces / "50MPa.csv"],
        "compare": ["compare", "--train", "train.csv", "--test", "test.csv", "--out", "compare.json"],
    }
    bath(folder, "train.csv", 150)
    bath(folder, "test.csv", 140)
    for name, command in commands.items():
        page = folder / f"{name}.html"
        if wanted and name not in wanted:
            continue
        subprocess.run([host_sim, *command, "--report", page], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        yield name, page
    if not smaservod.exists():
        print("can step: SKIPPED: there is no smaservod")
    elif not wanted or "can step" in wanted:
        page = folder / "can-step.html"
        can_step(host_sim, smaservod, sources, folder, page)
        yield "can step", page
    if not wanted or "figures" in wanted:
        subprocess.run([host_sim, "figures", "--out", "figures", "--paper", "001"], cwd=folder,
                       check=True, stdout=subprocess.DEVNULL)
        yield "figures", folder / "figures/index.html"


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


def is_drawn(picture):
    """More than a frame: a few per cent of it are not white, and some of that is not grey."""
    pixels = picture.width * picture.height
    colours = picture.getcolors(maxcolors=pixels)
    inked = sum(n for n, (r, g, b) in colours if min(r, g, b) < 200)
    coloured = sum(n for n, (r, g, b) in colours if max(r, g, b) - min(r, g, b) > 60)
    return inked > 0.005 * pixels and coloured > 0.0005 * pixels


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
    """Pictures whose words are not all in the PDF."""
    found = words(subprocess.run(["pdftotext", "-raw", pdf, "-"], check=True,
                                 stdout=subprocess.PIPE).stdout.decode())
    wanted = [words(texts_of(svg)) for svg in pictures(text)]
    return [k for k, these in enumerate(wanted) if not these or not these <= found]


def problems(browser, folder, page, with_script, explore):
    """What is wrong with the page on screen and in print; the number of panels."""
    text = page.read_text()
    name = f"{page.stem}-{browser.name}-{'live' if with_script else 'still'}"
    copy = folder / f"{name}.html"
    copy.write_text(text if with_script else SCRIPT.sub("", text))
    did = browser.open(page=str(copy), folder=str(folder), name=name, explore=explore)
    pictures_there = [Image.open(file).convert("RGB") for file in did["pictures"]]
    found = [f"missing: {what}" for what in did["unexplored"]]
    found += [f"error: {error}" for error in did["errors"]]
    blank = [k for k, picture in enumerate(pictures_there)
             if picture.width < 100 or not is_drawn(picture)]
    if blank or not pictures_there:
        found.append(f"blank on screen: {blank} of {len(pictures_there)}")
    if did["width"] > WIDTH:
        found.append(f"wider than the screen: {did['width']}")
    missing = unprinted(text, folder / f"{name}.pdf")
    if missing:
        found.append(f"not in print: {missing}")
    # Surfaces and colours of points stay pictures; none of the papers' that are opened here has such.
    if did["live"] != (len(pictures_there) if with_script else 0):
        found.append(f"{did['live']} of {len(pictures_there)} panels are interactive")
    return found, len(pictures_there)


def check(browsers, folder, kind, page):
    """Whether all of a report is well; says what is not."""
    has_script = SCRIPT.search(page.read_text()) is not None
    well = True
    for browser in browsers:
        for with_script in (True, False) if has_script else (False,):
            explore = with_script and kind == "replay"
            found, panels = problems(browser, folder, page, with_script, explore)
            how = "with" if with_script else "without"
            print(f"{kind}, {browser.name}, {how} its script: {panels} panels: "
                  f"{'; '.join(found) or 'good'}", flush=True)
            well = well and not found
    return well, has_script


def main(packages, host_sim, smaservod, sources, *wanted):
    there = [name for name, program in BROWSERS.items() if shutil.which(program)]
    if not there or not shutil.which("node") or not shutil.which("npm"):
        print("SKIPPED: there is no browser, or no npm")
        return 77
    failed = scripted = False
    programs = [pathlib.Path(program).absolute() for program in (host_sim, smaservod, sources)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        browsers = [Browser(name, programs[2], packages) for name in there]
        for kind, page in reports(*programs, folder, wanted):
            well, has_script = check(browsers, folder, kind, page)
            failed = failed or not well
            scripted = scripted or has_script
        for browser in browsers:
            browser.close()
    if not scripted:
        print("SKIPPED: built without npm, so no report has a script")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
