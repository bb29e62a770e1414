"""Pages in a headless Chromium without network, controlled through its debugging protocol (package: websockets; program: chromium)."""

import itertools
import json
import re
import subprocess
import sys

from websockets.sync.client import connect


class Browser:
    """To be used as a context manager, with further options of Chromium. `errors` has what the scripts of the open page did not catch; `trace`, the events
    of its tracing."""

    session = None

    def __init__(self, folder, options=()):
        command = ["chromium", "--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--remote-debugging-port=0",
                   "--proxy-server=127.0.0.1:9", f"--user-data-dir={folder}/profile", "--window-size=1280,900", *options, "about:blank"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        address = next(filter(None, (re.search(r"ws://[\w./:-]+", line) for line in self.process.stderr))).group()
        self.connection = connect(address, max_size=None)
        self.numbers, self.errors, self.trace = itertools.count(1), [], []

    def __enter__(self):
        self.socket = self.connection.__enter__()
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Page.enable")
        self.call("Runtime.enable")
        return self

    def call(self, method, **parameters):
        number = next(self.numbers)
        session = {"sessionId": self.session} if self.session else {}
        self.socket.send(json.dumps({"id": number, "method": method, "params": parameters, **session}))
        return self.until(lambda message: message.get("id") == number)["result"]

    def until(self, wanted):
        while True:
            message = json.loads(self.socket.recv(timeout=600))
            if message.get("method") == "Runtime.exceptionThrown":
                details = message["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description", details["text"]))
            if message.get("method") == "Tracing.dataCollected":
                self.trace += message["params"]["value"]
            if wanted(message):
                if "error" in message:
                    sys.exit(f"chromium: {message['error']['message']}")
                return message

    def open(self, page, size=None):
        """Opens an address, in a window of this width and height."""
        if size:
            self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        self.errors.clear()
        self.call("Page.navigate", url=page)
        self.until(lambda message: message.get("method") == "Page.loadEventFired")

    def value(self, expression):
        """The value of an expression, or of its promise."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            sys.exit(f"the page: {details.get('exception', {}).get('description', details['text'])}")
        return answer["result"]["value"]

    def __exit__(self, *error):
        self.connection.__exit__(*error)
        self.process.terminate()
        self.process.wait()
