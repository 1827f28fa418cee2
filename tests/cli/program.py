"""Runs gyrator as a user does: arguments in, exit code, stdout, stderr and files out.

The program is named by the environment variable GYRATOR.
"""
import copy
import json
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
RC_DISPLAY = EXAMPLES / "rc_display.json"
MODEL_COMMANDS = ("impedance", "passivity", "zwidth", "simulate")
PATIENCE_S = 20  # longer than any command here may take, sanitizers included


def program():
    """The path of the program under test."""
    path = os.environ.get("GYRATOR")
    if not path:
        raise RuntimeError("set the environment variable GYRATOR to the program's path")
    return str(Path(path).resolve())


def example_models():
    models = sorted(EXAMPLES.glob("*.json"))
    assert models, f"no examples in {EXAMPLES}"
    return models


def load_example(name="rc_display"):
    return json.loads((EXAMPLES / f"{name}.json").read_text())


def with_value(model, path, value):
    """A copy of the model with another value at a JSON path such as "/damping/0/kind"."""
    model = copy.deepcopy(model)
    *parents, last = [int(p) if p.isdigit() else p for p in path.strip("/").split("/")]
    place = model
    for key in parents:
        place = place[key]
    place[last] = value
    return model


def without(model, path):
    """A copy of the model without the member at a JSON path."""
    model = copy.deepcopy(model)
    *parents, last = [int(p) if p.isdigit() else p for p in path.strip("/").split("/")]
    place = model
    for key in parents:
        place = place[key]
    del place[last]
    return model


class Answer:
    """What a finished command left behind."""

    def __init__(self, arguments, code, out, err):
        self.arguments, self.code, self.out, self.err = arguments, code, out, err

    @property
    def json(self):
        return json.loads(self.out)

    def __str__(self):
        words = " ".join(str(a) for a in self.arguments)
        return f"\n$ gyrator {words}\nexit {self.code}\n{self.out[:400]}--stderr--\n{self.err[:800]}"


class ProgramTest(unittest.TestCase):
    """A test with a scratch folder, in which the program runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="gyrator-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_program(self, *arguments, timeout=PATIENCE_S, environment=None, stdout=subprocess.PIPE):
        words = [str(a) if not isinstance(a, bytes) else a for a in arguments]
        try:
            done = subprocess.run([program(), *words], cwd=self.folder, stdin=subprocess.DEVNULL,
                                  stdout=stdout, stderr=subprocess.PIPE, timeout=timeout,
                                  env=environment)
        except subprocess.TimeoutExpired:
            self.fail(f"gyrator {' '.join(map(str, words))}: still working after {timeout:g} s")
        text = [(stream or b"").decode("utf-8", "replace") for stream in (done.stdout, done.stderr)]
        return Answer(arguments, done.returncode, *text)

    def ask(self, *arguments):
        """The JSON answer of a command that is expected to succeed (or to say no)."""
        answer = self.run_program(*arguments, "--json")
        self.assertIn(answer.code, (0, 1), answer)
        return answer.json

    def write_model(self, model, name="model.json"):
        text = model if isinstance(model, (str, bytes)) else json.dumps(model, indent=1)
        path = self.folder / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def assert_refused(self, answer, *fragments, code=2):
        """Exit code, nothing on stdout, and a message with all the fragments and no jargon."""
        self.assertEqual(answer.code, code, answer)
        self.assertEqual(answer.out, "", answer)
        for fragment in fragments:
            self.assertIn(fragment, answer.err, answer)
        for jargon in ("internal error", "json.exception", "std::", "terminate called"):
            self.assertNotIn(jargon, answer.err, answer)

    def interrupt(self, *arguments, after_s=0.5, within_s=1.0, may_be_over=False):
        """Presses Ctrl-C while the program works; how long it took to end, and its answer."""
        process = subprocess.Popen([program(), *[str(a) for a in arguments]], cwd=self.folder,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        try:
            time.sleep(after_s)
            over = process.poll() is not None
            self.assertTrue(may_be_over or not over, f"{arguments}: over before Ctrl-C could be pressed")
            pressed = time.monotonic()
            if not over:
                process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=within_s + 0.2)
            took_s = time.monotonic() - pressed
        except subprocess.TimeoutExpired:
            self.fail(f"gyrator {' '.join(map(str, arguments))}: still working {within_s + 0.2:g} s "
                      "after Ctrl-C")
        finally:
            if process.poll() is None:
                process.kill()
                process.communicate()
        self.assertLess(took_s, within_s)
        return Answer(arguments, process.returncode, out.decode(), err.decode())


class DeviceTest(ProgramTest):
    """A test of commands that talk to a device, whose journals and locks stay in the scratch folder."""

    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "XDG_STATE_HOME": str(self.folder / "state"),
                            "XDG_RUNTIME_DIR": str(self.folder)}

    def run_program(self, *arguments, **more):
        return super().run_program(*arguments, environment=self.environment, **more)

    def run_unheard(self, *arguments, broken="stderr", timeout=60):
        """With a stderr or a stdout that nobody reads any more."""
        reader, writer = os.pipe()
        os.close(reader)
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, broken: writer}
        try:
            done = subprocess.run([program(), *map(str, arguments)], cwd=self.folder, env=self.environment, text=True,
                                  stdin=subprocess.DEVNULL, timeout=timeout, **streams)
        finally:
            os.close(writer)
        return Answer(arguments, done.returncode, done.stdout or "", done.stderr or "")

    def journals(self, command=None):
        """Those of a command, or all, whose first line is whole: nothing is written to a device before."""
        begun = [path for path in sorted(self.folder.glob("state/gyrator/*.jsonl")) if b"\n" in path.read_bytes()]
        return [path for path in begun
                if command is None or json.loads(path.read_text().splitlines()[0])["command"] == command]
