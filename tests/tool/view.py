"""Drives headless Chromium through its WebDriver: does the page of millpost view play a run?

Usage: view.py PAGE SCREENSHOT [FOLDER]; FOLDER gets a screenshot of each colouring. Prints a line for each check, and exits 1 when one fails."""
import base64, json, os, socket, subprocess, sys, tempfile, time, urllib.request

page, picture = os.path.abspath(sys.argv[1]), sys.argv[2]
folder = sys.argv[3] if len(sys.argv) > 3 else None
with socket.socket() as s:
    s.bind(("127.0.0.1", 0))
    port = s.getsockname()[1]
driver = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL)
number = failed = 0
session = None


def ask(method, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", data, method=method,
                                     headers={"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)["value"]


def check(good, text):
    global number, failed
    number += 1
    failed += not good
    print(f"{'ok' if good else 'not ok'} {number} - {text}", flush=True)


def wait_for_driver():
    for _ in range(100):
        try:
            return ask("GET", "/status")
        except OSError:
            time.sleep(0.1)


def main(profile):
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             "--window-size=1280,860", f"--user-data-dir={profile}"]
    global session
    session = "/session/" + ask("POST", "/session", {"capabilities": {"alwaysMatch": {
        "browserName": "chrome", "goog:chromeOptions": {"args": flags},
        "goog:loggingPrefs": {"browser": "ALL"}}}})["sessionId"]

    def run(script):
        return ask("POST", session + "/execute/sync", {"script": script, "args": []})

    def shoot(path):
        with open(path, "wb") as out:
            out.write(base64.b64decode(ask("GET", session + "/screenshot")))

    # As a browser without some kinds of canvas would have it, from the next page on.
    def forbid(kinds):
        ask("POST", session + "/goog/cdp/execute", {
            "cmd": "Page.addScriptToEvaluateOnNewDocument", "params": {"source": """
              {
                const own = HTMLCanvasElement.prototype.getContext;
                HTMLCanvasElement.prototype.getContext = function(kind, wish) {
                  return %s.includes(kind) ? null : own.call(this, kind, wish);
                };
              }""" % json.dumps(kinds)}})

    def errors():
        return [m["message"] for m in ask("POST", session + "/se/log", {"type": "browser"})
                if m["level"] == "SEVERE"]

    def key(value):
        ask("POST", session + "/actions", {"actions": [{"type": "key", "id": "k", "actions": [
            {"type": "keyDown", "value": value}, {"type": "keyUp", "value": value}]}]})

    def mouse(*steps):
        ask("POST", session + "/actions", {"actions": [
            {"type": "pointer", "id": "m", "actions": list(steps)}]})

    def move(x, y):
        return {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 0}

    down, up = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}
    probe = lambda: run("return player.probe()")

    ask("POST", session + "/url", {"url": f"file://{page}#paused"})
    check(run("return document.body.dataset.ready") == "yes", "the page loads from a file")
    said = errors()
    check(not said, f"no errors on the console {said or ''}")
    check(run("return performance.getEntriesByType('resource')"
              ".filter(r => !r.name.startsWith('data:')).length") == 0, "nothing is loaded besides")
    first, total = probe(), run("return player.run.count")
    check(first["error"] == 0, "WebGL reports no error")
    check(0.1 < first["drawn"] < 0.9 and first["colours"] > 40,
          f"the picture shows something ({first['drawn']:.2f} drawn, {first['colours']} colours)")
    check(first["shown"] == total, "all balls are shown")
    check(probe()["sum"] == first["sum"], "the same moment is the same picture")

    box = run("const r = document.getElementById('scrub').getBoundingClientRect();"
              "return [r.left, r.top, r.width, r.height]")
    mouse(move(box[0] + 8, box[1] + box[3] / 2), down,
          move(box[0] + 0.6 * box[2], box[1] + box[3] / 2), up)
    later, span = probe(), run("return player.run.last - player.run.first")
    check(abs(later["time"] - 0.6 * span) < 0.03 * span, "the slider moves time")
    check(later["sum"] != first["sum"], "and the picture")
    check(run("return document.getElementById('time').textContent") ==
          f"t = {later['time']:.4f} s", "and the time stamp")

    worst = run("""
      let worst = 0;
      const r = player.run;
      for (let k = 0; k < r.times.length; k++) {
        r.seek(r.times[k]);
        for (let i = 0; i < r.count; i++)
          worst = Math.max(worst, Math.hypot(r.place[3 * i], r.place[3 * i + 2]) + r.radius(i) -
                                  r.diameter / 2);
      }
      return worst;""")
    check(worst < 1e-6, "all balls stay inside the drum")

    mouse(move(500, 400), down, move(560, 430), up)
    turned = probe()
    check(turned["sum"] != later["sum"] and run("return player.stage.camera.turn") != 38,
          "a drag turns the mill")
    key("2")
    axial = probe()
    check(run("return player.stage.camera.turn") == 0, "a key looks along the axis")
    key("r")
    check(probe()["sum"] != axial["sum"], "a key hides the rotor")
    key("r")
    target = run("""
      const c = player.stage.camera, r = player.run, q = document.getElementById('stage');
      let best = 0;
      for (let i = 0; i < r.count; i++) if (r.place[3 * i + 1] < r.place[3 * best + 1]) best = i;
      const p = along([...r.place.slice(3 * best, 3 * best + 3)], -1, c.eye), a = c.axes;
      const x = dot(p, a.right), y = dot(p, a.up), z = -dot(p, a.back);
      return [best, (1 + a.lens / a.aspect * x / z + c.margin.left - c.margin.right) / 2 *
              q.clientWidth, (1 - a.lens * y / z - c.margin.bottom + c.margin.top) / 2 *
              q.clientHeight];""")
    mouse(move(target[1], target[2]), down, up)
    check(run("return player.trails") == [target[0]], "a click on a ball starts its trail")
    check(probe()["sum"] != axial["sum"], "which is seen")

    run("location.hash = '#speeds=1:2'")
    time.sleep(0.3)
    some = probe()
    want = run("return player.run.speed.filter(v => v >= 1 && v <= 2).length")
    check(some["shown"] == want and 0 < want < total, f"only some speeds ({want} of {total})")
    check(run("return player.legend.bins.reduce((a, b) => a + b)") == total,
          "the histogram counts all balls")
    key("s")
    before = run("return player.time")
    key(" ")
    time.sleep(1.0)
    key(" ")
    check(run("return player.time") != before, "it plays")
    run("location.hash = '#paused&turn=38&tilt=18&t=%g'" % (0.6 * span))
    time.sleep(0.3)
    probe()
    shoot(picture)

    kinds = run("return Object.keys(player.legend.kinds)")
    check(kinds[0] == "speed" and "class" in kinds and "spin" in kinds, f"colours tell {kinds}")
    seen = {}
    for kind in kinds:
        run(f"location.hash = '#colour={kind}'")
        time.sleep(0.3)
        seen[kind] = probe()["sum"]
        check(run("return document.getElementById('colour').value") == kind, f"colours by {kind}")
        if folder:
            shoot(f"{folder}/{kind}.png")
    check(len(set(seen.values())) == len(kinds), "each looks otherwise")
    check(run("return player.legend.shares.flatMap(s => [...s]).reduce((a, b) => a + b)") == total,
          "the shares of the histogram count all balls")
    run("location.hash = '#colour=spin&spins=0:%g'" % run("return player.run.spinHigh / 3"))
    time.sleep(0.3)
    want = run("return player.run.spin.filter(s => s <= player.run.spinHigh / 3).length")
    check(probe()["shown"] == want and 0 < want < total, f"only some spins ({want} of {total})")
    said = errors()
    check(not said, f"still no errors {said or ''}")

    view = "#paused&turn=38&tilt=18&t=%g" % (0.6 * span)
    ask("POST", session + "/url", {"url": f"file://{page}?again{view}"})
    modern = probe()
    forbid(["webgl2"])
    ask("POST", session + "/url", {"url": f"file://{page}?old{view}"})
    old = probe()
    check(run("return player.stage.version") == 1 and old["error"] == 0, "WebGL 1 serves as well")
    check(old["shown"] == total and abs(old["drawn"] - modern["drawn"]) < 0.005,
          f"and shows the same ({old['drawn']:.3f} and {modern['drawn']:.3f} drawn)")
    if folder:
        shoot(f"{folder}/webgl1.png")
    said = errors()
    check(not said, f"without errors {said or ''}")
    forbid(["webgl2", "webgl"])
    ask("POST", session + "/url", {"url": f"file://{page}?none"})
    check("no WebGL" in run("return document.getElementById('trouble').textContent"),
          "a browser without WebGL is told so")
    if folder:
        shoot(f"{folder}/none.png")


try:
    wait_for_driver()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        main(profile)
finally:
    if session:
        ask("DELETE", session)  # ends the browser
    driver.terminate()
    driver.wait()
print(f"# {number} checks in the browser")
sys.exit(failed > 0)
