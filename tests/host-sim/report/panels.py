#!/usr/bin/python3
"""panels.py HOST_SIM SOURCES: every panel of every kind of report is drawn, on screen and in print.

Writes the reports into a folder of its own and opens them in headless Chromium. On screen each panel
has to have drawn pixels, of the curves' colours too; in print its texts have to be in the PDF.
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
# Writes where the panels are, and how high the page is, into the page.
WHERE = """<script>addEventListener("load", () => {
  const boxes = [...document.querySelectorAll(".plots section > :last-child")].map(panel => {
    const box = panel.getBoundingClientRect();
    return [box.left + scrollX, box.top + scrollY, box.width, box.height];
  });
  const all = JSON.stringify([document.documentElement.scrollHeight, boxes]);
  document.documentElement.setAttribute("data-panels", all);
});</script>"""


def reports(host_sim, sources, folder):
    """Name and file of one report of each kind. Those that are left out (compare, can step) hand their
    panels to the same function, plots_html."""
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
    }
    for name, command in commands.items():
        page = folder / f"{name}.html"
        subprocess.run([host_sim, *command, "--report", page], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        yield name, page
    subprocess.run([host_sim, "figures", "--out", "figures", "--paper", "001"], cwd=folder,
                   check=True, stdout=subprocess.DEVNULL)
    yield "figures", folder / "figures/index.html"


def chromium(folder, *arguments):
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
               "--no-first-run", "--disable-background-networking", "--disable-component-update",
               "--disable-sync", f"--user-data-dir={folder / 'profile'}", *arguments]
    return subprocess.run(command, check=True, timeout=120, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL).stdout.decode()


def is_drawn(picture):
    """More than a frame: a few per cent of it are not white, and some of that is not grey."""
    pixels = picture.width * picture.height
    colours = picture.getcolors(maxcolors=pixels)
    inked = sum(n for n, (r, g, b) in colours if min(r, g, b) < 200)
    coloured = sum(n for n, (r, g, b) in colours if max(r, g, b) - min(r, g, b) > 60)
    return inked > 0.005 * pixels and coloured > 0.0005 * pixels


def undrawn_on_screen(page, folder):
    measured = page.with_suffix(".measured.html")
    measured.write_text(page.read_text().replace("</head>", WHERE + "</head>"))
    dom = chromium(folder, f"--window-size={WIDTH},800", "--dump-dom", measured.as_uri())
    height, boxes = json.loads(html.unescape(re.search(r'data-panels="([^"]*)"', dom).group(1)))
    shot = folder / "shot.png"
    chromium(folder, f"--window-size={WIDTH},{height}", f"--screenshot={shot}", page.as_uri())
    screen = Image.open(shot).convert("RGB")
    return [k for k, (x, y, w, h) in enumerate(boxes)
            if not is_drawn(screen.crop((int(x), int(y), int(x + w), int(y + h))))], len(boxes)


def texts_of(svg):
    texts = re.findall(r"<text[^>]*>(.*?)</text>", svg, re.DOTALL)
    return html.unescape(" ".join(re.sub(r"<[^>]*>", "", t) for t in texts))


def words(text):
    """Of four letters and digits or more: other characters may come from another font, in a line of
    their own."""
    return set(re.findall(r"[A-Za-z0-9]{4,}", text))


def unprinted(page, folder):
    pdf = folder / "page.pdf"
    chromium(folder, f"--print-to-pdf={pdf}", page.as_uri())
    print_ = subprocess.run(["pdftotext", "-raw", pdf, "-"], check=True,
                            stdout=subprocess.PIPE).stdout.decode()
    found = words(print_)
    panels = re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]*)", page.read_text())
    missing = []
    for k, panel in enumerate(panels):
        wanted = words(texts_of(base64.b64decode(panel).decode()))
        if not wanted or not wanted <= found:
            missing.append(k)
    return missing


def main(host_sim, sources):
    failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind, page in reports(pathlib.Path(host_sim), pathlib.Path(sources), folder):
            blank, panels = undrawn_on_screen(page, folder)
            missing = unprinted(page, folder)
            print(f"{kind}: {panels} panels, blank on screen: {blank}, not in print: {missing}")
            failed = failed or not panels or bool(blank) or bool(missing)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
