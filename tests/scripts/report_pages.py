#!/usr/bin/env python3
"""Checks pages that `crepuscular compare` has written, in headless Chromium.

    tests/scripts/report_pages.py [--shots FOLDER] [--browser chromium] PAGE.html ...

Every page is laid out at 1280 and at 390 pixels, in light and in dark, on paper, and
without scripts, folded as it is and with everything unfolded. It fails if

* the page is wider than the screen, or something in a table is cut off;
* a table does not fit 1280 pixels or the paper, or its first column does not stay
  where a narrow screen scrolls it;
* texts in a plot overlap, leave the picture, are too small to read or too pale;
* on paper, a figure or a row is taller than a page or may be broken;
* the slider between pictures does not work, or is there without scripts, or a
  picture is missing without them;
* the page asks for any other file, or its script throws.

Needs Python 3.8 or later and Chromium (package `chromium` of Debian); nothing else.
With --shots, pictures of every layout and the PDF are written there.
"""

import argparse
import base64
import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
]

# A4 within margins of 14 mm, in CSS pixels.
PAPER = (688, 1016)

# So many faults of a layout are told.
MOST = 8

# Name, width, height, dark, paper, scripts.
LAYOUTS = [
    ("wide", 1280, 800, False, False, True),
    ("wide-dark", 1280, 800, True, False, True),
    ("narrow", 390, 844, False, False, True),
    ("narrow-dark", 390, 844, True, False, True),
    ("print", *PAPER, False, True, True),
    ("without-scripts", 1280, 800, False, False, False),
    ("narrow-without-scripts", 390, 844, False, False, False),
]

# Runs in the page; returns what is wrong with it.
CHECK = r"""
(({ width, pageHeight, paper, narrow, scripts }) => {
  const wrong = [];
  const all = (selector, from = document) => [...from.querySelectorAll(selector)];
  const isSeen = (e) => e.checkVisibility() && e.getBoundingClientRect().width > 0;
  const short = (e) => (e.textContent || e.outerHTML).trim().replace(/\s+/g, " ").slice(0, 60);

  const pageWidth = document.documentElement.scrollWidth;
  if (pageWidth > width) {
    const far = all("body *").filter((e) => isSeen(e) && e.getBoundingClientRect().right > width + 1
      && !e.parentElement.closest(".wide, .stage"));
    wrong.push(`the page is ${pageWidth} wide: ${far.slice(0, 3).map((e) => e.tagName + " " + short(e)).join("; ")}`);
  }

  for (const box of all(".wide").filter(isSeen)) {
    const table = box.querySelector("table");
    const name = short(table ? table.querySelector("tbody th") : box);
    if (!narrow && box.scrollWidth > box.clientWidth + 1) {
      wrong.push(`does not fit (${box.scrollWidth} in ${box.clientWidth}): ${name}`);
    }
    if (!table) continue;
    for (const cell of all("th, td", table)) {
      if (cell.scrollWidth > cell.clientWidth + 1) wrong.push(`cut off in a table: ${short(cell)}`);
    }
    if (narrow && box.scrollWidth > box.clientWidth + 1) {
      box.scrollLeft = box.scrollWidth;
      const head = table.querySelector("tbody th");
      const at = head.getBoundingClientRect();
      const left = box.getBoundingClientRect().left;
      head.scrollIntoView({ block: "center" });
      const here = head.getBoundingClientRect();
      const top = document.elementFromPoint(here.left + here.width / 2, here.top + 6);
      if (Math.abs(at.left - left) > 1) wrong.push(`the first column scrolls away: ${name}`);
      if (!top || !head.contains(top)) wrong.push(`the first column is covered: ${name}`);
      if (at.width > 0.5 * box.clientWidth) wrong.push(`the first column leaves no room: ${name}`);
      box.scrollLeft = 0;
    }
  }

  const channel = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const luminance = (css) => {
    const [r, g, b] = css.match(/[\d.]+/g).map((v) => channel(v / 255));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const page = luminance(getComputedStyle(document.body).backgroundColor);
  const contrast = (css) => {
    const text = luminance(css);
    return (Math.max(text, page) + 0.05) / (Math.min(text, page) + 0.05);
  };
  for (const chart of all("svg.chart").filter(isSeen)) {
    const frame = chart.getBoundingClientRect();
    const scale = frame.width / chart.viewBox.baseVal.width;
    const texts = all("text", chart).map((text) => ({ text, box: text.getBoundingClientRect() }));
    texts.forEach(({ text, box }, index) => {
      if (box.left < frame.left - 1 || box.right > frame.right + 1
        || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) {
        wrong.push(`leaves its plot: ${short(text)}`);
      }
      const style = getComputedStyle(text);
      const size = scale * parseFloat(style.fontSize);
      if (size < (paper ? 8 : 9)) wrong.push(`letters of ${size.toFixed(1)} pixels in a plot: ${short(text)}`);
      if (contrast(style.fill) < 3) wrong.push(`too pale in a plot: ${short(text)} ${style.fill}`);
      for (const other of texts.slice(0, index)) {
        const across = Math.min(box.right, other.box.right) - Math.max(box.left, other.box.left);
        const up = Math.min(box.bottom, other.box.bottom) - Math.max(box.top, other.box.top);
        // Boxes of letters have air above and below.
        if (across > 1 && up > 0.25 * Math.min(box.height, other.box.height)) {
          wrong.push(`overlap in a plot: ${short(text)} and ${short(other.text)}`);
        }
      }
    });
  }
  for (const text of all("p, li, th, td, summary, figcaption, dt, dd").filter(isSeen)) {
    const colour = getComputedStyle(text).color;
    if (contrast(colour) < 4.5) { wrong.push(`too pale: ${short(text)}`); break; }
  }

  for (const figure of all("figure")) {
    const caption = figure.querySelector("figcaption");
    if (figure.querySelector("img") && !caption) wrong.push(`no caption: ${figure.outerHTML.slice(0, 60)}`);
    if (paper && isSeen(figure)) {
      if (getComputedStyle(figure).breakInside !== "avoid") wrong.push(`may be broken: ${short(figure)}`);
      const height = figure.getBoundingClientRect().height;
      if (height > pageHeight) wrong.push(`taller than a page: ${short(figure)}`);
    }
  }
  if (paper) {
    for (const row of all("tr").filter(isSeen)) {
      if (getComputedStyle(row).breakInside !== "avoid") wrong.push(`may be broken: ${short(row)}`);
    }
    for (const head of all("thead").filter(isSeen)) {
      if (getComputedStyle(head).display !== "table-header-group") wrong.push("a head of a table is not repeated");
    }
  }

  for (const image of all("figure img")) {
    if (!image.complete || image.naturalWidth === 0) wrong.push(`a picture is missing: ${image.alt}`);
    if (!image.alt) wrong.push("a picture has no description");
  }
  const viewer = document.getElementById("viewer");
  if (viewer && isSeen(viewer) !== (scripts && !paper)) {
    wrong.push(`the slider is ${isSeen(viewer) ? "there" : "not there"}`);
  }
  if (viewer && isSeen(viewer)) {
    const part = (name) => viewer.querySelector(`[data-part=${name}]`);
    const [slider, after, stage, method, canvas] = ["slider", "after", "stage", "method", "canvas"].map(part);
    // "inset(0px 0px 0px 480px)", or "inset(0px)" for all of it.
    const cut = () => parseFloat(after.style.clipPath.replace(/.*[ (]/, ""));
    const drag = (value) => { slider.value = value; slider.dispatchEvent(new Event("input")); return cut(); };
    const [low, high] = [drag(0), drag(1000)];
    if (!(Math.abs(low) < 1 && Math.abs(high - stage.clientWidth) < 1)) wrong.push(`the slider cuts at ${low} and ${high}`);
    viewer.querySelector("[data-zoom='4']").click();
    if (Math.abs(canvas.clientWidth - 4 * stage.clientWidth) > 2) wrong.push("the zoom does not work");
    viewer.querySelector("[data-zoom='1']").click();
    const seen = new Set();
    for (const option of method.options) {
      method.value = option.value;
      method.dispatchEvent(new Event("change"));
      seen.add(after.src);
    }
    if (method.options.length !== all("figure.pair").length) wrong.push("the slider lacks methods");
    method.selectedIndex = Math.max(0, [...method.options].findIndex((o) => o.defaultSelected));
    method.dispatchEvent(new Event("change"));
    drag(500);
  }
  const asked = performance.getEntriesByType("resource").map((e) => e.name).filter((n) => !n.startsWith("data:"));
  if (asked.length) wrong.push(`asks for ${asked.join(", ")}`);
  return [...new Set(wrong)];
})
"""

UNFOLD = "document.querySelectorAll('details').forEach((d) => { d.open = true; }); scrollTo(0, 0)"


class Browser:
    """A headless Chromium that is spoken to over a pipe."""

    def __init__(self, program):
        self.profile = tempfile.mkdtemp(prefix="report-pages-")
        to_browser, self.out = os.pipe()
        self.into, from_browser = os.pipe()

        def connect():
            # The browser reads from 3 and writes to 4.
            ends = [os.dup(to_browser), os.dup(from_browser)]
            for end, number in zip([high_copy(end) for end in ends], (3, 4)):
                os.dup2(end, number)

        self.process = subprocess.Popen(
            [program, *FLAGS, "--user-data-dir=" + self.profile, "about:blank"],
            preexec_fn=connect,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        self.number = 0
        self.rest = b""
        self.events = []
        self.session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.session = attached["sessionId"]
        self.call("Page.enable")
        self.call("Runtime.enable")

    def message(self):
        while b"\0" not in self.rest:
            part = os.read(self.into, 1 << 20)
            if not part:
                raise SystemExit("the browser has gone")
            self.rest += part
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data) :]
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, event):
        while not any(e.get("method") == event for e in self.events):
            self.events.append(self.message())

    def evaluate(self, text):
        result = self.call("Runtime.evaluate", expression=text, returnByValue=True)
        if "exceptionDetails" in result:
            raise SystemExit(result["exceptionDetails"])
        return result["result"].get("value")

    def close(self):
        try:
            self.session = None
            self.call("Browser.close")
        finally:
            self.process.wait(timeout=20)
            shutil.rmtree(self.profile, ignore_errors=True)


def high_copy(end):
    """A copy of a file descriptor that is neither 3 nor 4."""
    return fcntl.fcntl(end, fcntl.F_DUPFD, 10)


def shoot(browser, path, width):
    size = browser.call("Page.getLayoutMetrics")["cssContentSize"]
    clip = {"x": 0, "y": 0, "width": width, "height": min(size["height"], 16000), "scale": 1}
    shot = browser.call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)
    path.write_bytes(base64.b64decode(shot["data"]))


def check(browser, page, shots):
    """All layouts of a page; what is wrong with them."""
    wrong = []
    for name, width, height, dark, paper, scripts in LAYOUTS:
        browser.call("Emulation.setScriptExecutionDisabled", value=not scripts)
        browser.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 500,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        media = "print" if paper else "screen"
        browser.call("Emulation.setEmulatedMedia", media=media, features=[scheme])
        browser.events.clear()
        browser.call("Page.navigate", url=page.resolve().as_uri())
        browser.wait_for("Page.loadEventFired")
        options = {
            "width": width,
            "pageHeight": PAPER[1],
            "paper": paper,
            "narrow": width < 500,
            "scripts": scripts,
        }
        for state in ("", "-unfolded"):
            if state:
                browser.evaluate(UNFOLD)
            found = browser.evaluate(f"{CHECK}({json.dumps(options)})")
            wrong += [f"{page}, {name}{state}: {line}" for line in found[:MOST]]
            if len(found) > MOST:
                wrong.append(f"{page}, {name}{state}: and {len(found) - MOST} more")
            if shots:
                shoot(browser, shots / f"{page.parent.name}-{name}{state}.png", width)
            if shots and paper:
                pdf = browser.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
                path = shots / f"{page.parent.name}{state}.pdf"
                path.write_bytes(base64.b64decode(pdf["data"]))
        thrown = [e for e in browser.events if e.get("method") == "Runtime.exceptionThrown"]
        wrong += [f"{page}, {name}: {e['params']['exceptionDetails']}" for e in thrown]
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    parser.add_argument("--shots", type=pathlib.Path)
    parser.add_argument("--browser", default="chromium")
    arguments = parser.parse_args()
    if arguments.shots:
        arguments.shots.mkdir(parents=True, exist_ok=True)
    for page in arguments.pages:
        if not page.is_file():
            parser.error(f"{page} is no file")
    browser = Browser(arguments.browser)
    wrong = []
    try:
        for page in arguments.pages:
            wrong += check(browser, page, arguments.shots)
    finally:
        browser.close()
    for line in wrong:
        print(line)
    print(f"{len(arguments.pages)} pages in {2 * len(LAYOUTS)} layouts, {len(wrong)} faults")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
