"""What does a page look like in a real browser, on a screen, on a phone and on paper? Chromium without a window, told through a pipe."""

from __future__ import annotations

import base64
import fcntl
import io
import itertools
import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pytest
from evat.model import FloatArray
from matplotlib.image import imread

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "chromium-headless-shell")
PAPER = 718  # px between the margins of A4, upright
# Until plotly has drawn every picture, and nothing has changed for a while after that.
DRAWN = """new Promise(done => {
  let before = -1, same = 0, left = 200;
  const look = () => {
    const plots = [...document.querySelectorAll('.plotly-graph-div')].filter(plot => plot.getBoundingClientRect().width);
    const now = document.getElementsByTagName('*').length;
    same = now === before && plots.every(plot => plot.querySelector('.xtick, .barlayer, .scatterlayer')) ? same + 1 : 0;
    before = now;
    same < 4 && left-- ? setTimeout(look, 50) : done(0);
  };
  look();
})"""
# Elements that reach over the right edge of the page, unless they, or what holds them, can be moved to and fro.
RUNS_OFF = """[...document.body.querySelectorAll('*')].filter(e => {
  const box = e.getBoundingClientRect();
  if (!box.width || !box.height || box.right <= document.documentElement.clientWidth + 1) return false;
  for (let a = e; a && a !== document.body; a = a.parentElement)
    if (['auto', 'scroll', 'hidden', 'clip'].includes(getComputedStyle(a).overflowX)) return false;
  return true;
}).map(e => e.tagName + '.' + (e.getAttribute('class') || '') + ' ' + (e.textContent || '').trim().slice(0, 40))"""
# Tables and pictures of which a part is seen only when they are moved to and fro.
CUT = """[...document.querySelectorAll('table, figure')].filter(e => e.scrollWidth > e.clientWidth + 1)
  .map(e => e.textContent.trim().slice(0, 40))"""
SMALLEST = 0.55  # of its own size: letters of 9 pt are then 5 pt high, which a phone still shows
SHRUNK = "[...document.images].map(e => e.getBoundingClientRect().width / e.naturalWidth).filter(share => share > 0)"
# Titles of axes, of panels and legends that lie over one another or over the numbers of an axis, picture by picture.
OVERPRINTS = """[...document.querySelectorAll('.js-plotly-plot')].flatMap(plot => {
  const kinds = '.xtitle, .ytitle, .annotation-text, .legendtext, .xtick text, .ytick text, .updatemenu-item-text';
  const texts = [...plot.querySelectorAll(kinds)].filter(e => e.textContent && getComputedStyle(e).display !== 'none');
  const boxes = texts.map(e => e.getBoundingClientRect());
  const over = [];
  for (let i = 0; i < texts.length; i++) for (let k = i + 1; k < texts.length; k++) {
    const a = boxes[i], b = boxes[k];
    const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left), high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (wide > 2 && high > 2) over.push(texts[i].textContent + ' / ' + texts[k].textContent);
  }
  const whole = plot.getBoundingClientRect(), next = plot.closest('figure').getElementsByTagName('figcaption')[0];
  if (next && next.getBoundingClientRect().top < whole.bottom - 1) over.push('the picture / what stands below it');
  boxes.forEach((box, i) => { if (box.left < whole.left - 1 || box.right > whole.right + 1) over.push(texts[i].textContent + ' / edge'); });
  return over;
})"""


class Browser:
    """A headless Chromium that shows one page at a time."""

    def __init__(self, program: str, profile: Path) -> None:
        (read, self._to), (self._from, write) = os.pipe(), os.pipe()
        # Kept clear of 3 and 4, so that putting one there does not close the other.
        there, back = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (read, write))

        def as_three_and_four() -> None:
            os.dup2(there, 3)
            os.dup2(back, 4)

        options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--no-first-run"]
        self._process = subprocess.Popen(
            [program, *options, "--remote-debugging-pipe", f"--user-data-dir={profile}"],
            preexec_fn=as_three_and_four,
            pass_fds=(3, 4),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for end in (read, write, there, back):
            os.close(end)
        self._numbers, self._rest, self._session = itertools.count(1), b"", ""
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._call("Page.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._process.terminate()
        self._process.wait(10)
        os.close(self._to)
        os.close(self._from)

    def show(self, page: Path, width: int, *, paper: bool = False, dark: bool = False) -> None:
        """Lay the page out anew, `width` pixels wide."""
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._call("Emulation.setEmulatedMedia", media="print" if paper else "screen", features=[scheme])
        self._call("Page.navigate", url=page.resolve().as_uri())
        self._until("Page.loadEventFired")
        self.ask(DRAWN)

    def ask(self, expression: str) -> Any:
        """What an expression is in the page."""
        answer = self._call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise ValueError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def picture(self, x: float, y: float, width: float, height: float) -> FloatArray:
        """A part of the page as it is painted: (rows, columns, 3), 0 to 1."""
        clip = {"x": x, "y": y, "width": width, "height": height, "scale": 1}
        answer = self._call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
        painted: FloatArray = imread(io.BytesIO(base64.b64decode(answer["data"])))[..., :3]
        return painted

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        session = {"sessionId": self._session} if self._session else {}
        os.write(self._to, json.dumps({"id": number, "method": method, "params": parameters, **session}).encode() + b"\0")
        answer = next(message for message in self._messages() if message.get("id") == number)
        if "error" in answer:
            raise ValueError(f"{method}: {answer['error']}")
        result: dict[str, Any] = answer["result"]
        return result

    def _until(self, event: str) -> None:
        next(message for message in self._messages() if message.get("method") == event)

    def _messages(self) -> Iterator[dict[str, Any]]:
        while True:
            while b"\0" not in self._rest:
                more = os.read(self._from, 1 << 20)
                if not more:
                    raise ValueError("the browser has ended")
                self._rest += more
            message, _, self._rest = self._rest.partition(b"\0")
            yield json.loads(message)


def check_layout(page: Path, plots: int = 0) -> None:
    """On a screen, a phone and on paper nothing runs off the page and no text of a picture lies over another; pictures have a text of
    their own. plots : how many plotly draws on a screen."""
    with opened() as browser:
        for width, paper in ((1200, False), (390, False), (PAPER, True)):
            browser.show(page, width, paper=paper)
            where = f"{page.name}, {width} px{' on paper' if paper else ''}"
            assert browser.ask("innerWidth") == browser.ask("document.documentElement.scrollWidth") == width, where
            assert browser.ask(RUNS_OFF) == [], where
            if width < 600:
                assert browser.ask(CUT) == [], where
                assert min(browser.ask(SHRUNK), default=1) > SMALLEST, f"{where}: a picture is too small to be read"
            if not paper:
                assert browser.ask("document.querySelectorAll('.js-plotly-plot .main-svg .xtitle').length") >= plots, where
                assert browser.ask(OVERPRINTS) == [], where
                assert len([each for each in _colours_of_plots(browser) if each > 10]) >= plots, f"{where}: a picture stays blank"
        assert browser.ask("[...document.images].filter(image => !image.alt).length") == 0
        browser.show(page, 1200, dark=True)
        ink, paper_colour = (browser.ask(f"getComputedStyle(document.body).{name}") for name in ("color", "backgroundColor"))
        assert sum(_rgb(ink)) > 500 > 200 > sum(_rgb(paper_colour))


def _colours_of_plots(browser: Browser) -> list[int]:
    """How many colours each plot shows as it is painted: what is drawn may lie below something."""
    boxes = "JSON.stringify([...document.querySelectorAll('.js-plotly-plot')].map(e => e.getBoundingClientRect()).map(r => "
    places = json.loads(browser.ask(f"{boxes}[r.x + scrollX, r.y + scrollY, r.width, r.height]))"))
    parts = [np.round(255 * browser.picture(*place).reshape(-1, 3)).astype(int) for place in places if min(place[2:]) > 0]
    return [len(np.unique(part @ [1, 256, 65536])) for part in parts]


def _rgb(colour: str) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", colour)[:3]]


def program() -> str | None:
    """A Chromium on this machine."""
    return next(filter(None, map(shutil.which, NAMES)), None)


@contextmanager
def opened() -> Iterator[Browser]:
    """A browser, or the test is skipped where there is none."""
    name = program()
    if name is None:
        pytest.skip(f"no Chromium on this machine: looked for {', '.join(NAMES)} (Debian: apt install chromium)")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, Browser(name, Path(folder)) as browser:
        yield browser
