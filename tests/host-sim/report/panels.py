#!/usr/bin/python3
"""panels.py HOST_SIM SMASERVOD SOURCES [KIND ...]: every panel of every kind of report is drawn, and can
be explored.

Writes the reports into a folder of its own and opens each in headless Chromium, with and without its
script. Either way each panel has to have drawn pixels on screen, of the curves' colours too; in print the
texts of every picture have to be in the PDF. Of one report the mouse is moved: cursor, zoom of linked
panels, and curves that are taken off. A program that was built without npm has pictures only; then the
parts about the script are left out, which the last line says.
"""

import base64
import html
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from PIL import Image

WIDTH = 1100
# Writes into the page where its panels are: their canvas, or the picture where there is none.
WHERE = """<script>addEventListener("load", () => setTimeout(() => {
  const shown = section => section.querySelector("canvas") ?? section.querySelector("img");
  const boxes = [...document.querySelectorAll(".plots section")].map(section => {
    const box = shown(section).getBoundingClientRect();
    return [box.left + scrollX, box.top + scrollY, box.width, box.height];
  });
  const live = document.querySelectorAll(".plots section.live").length;
  const all = JSON.stringify([document.documentElement.scrollWidth, live, boxes]);
  document.documentElement.setAttribute("data-panels", all);
}, 1000));</script>"""
# Moves the mouse over the first panel, and writes what the others have made of it.
EXPLORE = """<script>addEventListener("load", async () => {
  const pause = ms => new Promise(done => setTimeout(done, ms));
  const plots = [...document.querySelectorAll(".plot")];
  const pixels = () => plots.map(plot => plot.querySelector("canvas").toDataURL());
  const differ = (a, b) => a.map((one, k) => one !== b[k]);
  const send = (plot, type, x, y, more) => {
    const over = plot.querySelector(".u-over");
    const box = over.getBoundingClientRect();
    over.dispatchEvent(new MouseEvent(type, {bubbles: true, cancelable: true, button: 0,
      clientX: box.left + x * box.width, clientY: box.top + y * box.height, ...more}));
  };
  const values = () => plots.map(plot =>
    [...plot.querySelectorAll(".plot-value")].map(value => value.textContent));
  await pause(1000);
  const result = {before: values()};
  const first = pixels();
  send(plots[0], "mouseenter", 0.5, 0.5);
  send(plots[0], "mousemove", 0.5, 0.5);
  await pause(500);
  result.values = values();
  result.cursor = differ(first, pixels());
  send(plots[0], "mousedown", 0.3, 0.5);
  for (let step = 0; step <= 10; ++step) send(plots[0], "mousemove", 0.3 + 0.02 * step, 0.5);
  send(plots[0], "mouseup", 0.5, 0.5);
  await pause(500);
  result.zoomed = differ(first, pixels());
  send(plots[0], "mouseleave", 0.5, 0.5);
  send(plots[0], "dblclick", 0.5, 0.5);
  await pause(500);
  result.reset = differ(first, pixels());
  const key = plots[0].querySelector(".plot-key:last-child");
  key.click();
  await pause(500);
  result.off = [key.getAttribute("aria-pressed"), differ(first, pixels())];
  key.click();
  await pause(500);
  result.on = [key.getAttribute("aria-pressed"), differ(first, pixels())];
  document.documentElement.setAttribute("data-explored", JSON.stringify(result));
});</script>"""
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
    session = """
      "$1" --board sim --bus udp >/dev/null 2>&1 &
      trap "kill $!" EXIT
      sleep 3
      for k in 1 2; do
        timeout 60 "$2" can --can udp step --amplitude-um 500 --seconds 1 --report "$3" || exit
      done"""
    subprocess.run([sources / "tests/can/own_network.sh", "bash", "-c", session, "session", smaservod,
                    host_sim, page], cwd=folder, check=True, stdout=subprocess.DEVNULL)


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


def chromium(folder, page, *arguments):
    """What the page has become when its scripts have run."""
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
               "--no-first-run", "--disable-background-networking", "--disable-component-update",
               "--disable-sync", f"--user-data-dir={folder / 'profile'}",
               "--virtual-time-budget=6000", "--dump-dom", *arguments, page.as_uri()]
    return subprocess.run(command, check=True, timeout=300, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL).stdout.decode()


def attribute(dom, name):
    return json.loads(html.unescape(re.search(f'{name}="([^"]*)"', dom).group(1)))


def variant(page, name, text):
    copy = page.with_suffix(f".{name}.html")
    copy.write_text(text)
    return copy


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
    their own."""
    return set(re.findall(r"[A-Za-z0-9]{4,}", text))


def pictures(text):
    return [base64.b64decode(panel).decode()
            for panel in re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]*)", text)]


def unprinted(text, pdf):
    """Pictures whose words are not all in the PDF."""
    found = words(subprocess.run(["pdftotext", "-raw", pdf, "-"], check=True,
                                 stdout=subprocess.PIPE).stdout.decode())
    wanted = [words(texts_of(svg)) for svg in pictures(text)]
    return [k for k, these in enumerate(wanted) if not these or not these <= found]


def problems(folder, page, with_script):
    """What is wrong with the page on screen, and in print where its script runs; the number of panels."""
    text = page.read_text()
    shown = text if with_script else SCRIPT.sub("", text)
    name = "live" if with_script else "still"
    copy = variant(page, name, shown.replace("</head>", WHERE + "</head>"))
    shot, pdf = page.with_suffix(f".{name}.png"), page.with_suffix(f".{name}.pdf")
    height = 1500 + 620 * text.count("<section")
    dom = chromium(folder, copy, f"--window-size={WIDTH},{height}", f"--screenshot={shot}",
                   f"--print-to-pdf={pdf}")
    width, live, boxes = attribute(dom, "data-panels")
    screen = Image.open(shot).convert("RGB")
    found = []
    blank = [k for k, (x, y, w, h) in enumerate(boxes)
             if w < 100 or not is_drawn(screen.crop((int(x), int(y), int(x + w), int(y + h))))]
    if blank or not boxes:
        found.append(f"blank on screen: {blank} of {len(boxes)}")
    if width > WIDTH:
        found.append(f"wider than the screen: {width}")
    missing = unprinted(text, pdf)
    if missing:
        found.append(f"not in print: {missing}")
    # Surfaces and colours of points stay pictures; none of the papers' that are opened here has such.
    if live != (len(boxes) if with_script else 0):
        found.append(f"{live} of {len(boxes)} panels are interactive")
    return found, len(boxes)


def unexplored(folder, page):
    """What the mouse does not do that it should. The first panels of a replay are linked by time, its
    last two are loops over the same time."""
    text = page.read_text().replace("</head>", EXPLORE + "</head>")
    dom = chromium(folder, variant(page, "explored", text), f"--window-size={WIDTH},6000")
    did = attribute(dom, "data-explored")
    panels = len(did["before"])
    expected = {
        "no values before": not any(any(values) for values in did["before"]),
        "values of all linked panels under the cursor":
            all(all(value for value in values) for values in did["values"][:-2]),
        "a dot on the loops under the cursor": did["cursor"][-2:] == [True, True],
        "zoom of all panels": did["zoomed"] == [True] * panels,
        "all again by a double click": did["reset"] == [False] * panels,
        "a curve is off, in its panel only": did["off"] == ["false", [True] + [False] * (panels - 1)],
        "and on again": did["on"] == ["true", [False] * panels],
    }
    return [f"missing: {what}" for what, done in expected.items() if not done]


def main(host_sim, smaservod, sources, *wanted):
    failed = False
    scripted = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        programs = [pathlib.Path(program).absolute() for program in (host_sim, smaservod, sources)]
        for kind, page in reports(*programs, folder, wanted):
            has_script = SCRIPT.search(page.read_text()) is not None
            scripted = scripted or has_script
            for with_script in (True, False) if has_script else (False,):
                found, panels = problems(folder, page, with_script)
                if with_script and kind == "replay":
                    found += unexplored(folder, page)
                how = "with" if with_script else "without"
                print(f"{kind}, {how} its script: {panels} panels: {'; '.join(found) or 'good'}",
                      flush=True)
                failed = failed or bool(found)
    if not scripted:
        print("SKIPPED: built without npm, so no report has a script")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
