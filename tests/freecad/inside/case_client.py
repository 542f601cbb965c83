"""Run by `freecadcmd -t`: the client of `wpcal rpc`, with a process that fails in every way."""

import os
import time
import unittest
from pathlib import Path
from unittest import mock

from freecad.wpcal_wb.client import Client, Executable, executable, find_executable
from freecad.wpcal_wb.client.environment import clean_environment

HERE = Path(__file__).resolve().parent
PYTHON = os.environ["WPCAL_TEST_PYTHON"]
FAKE = Executable((PYTHON, str(HERE / "fake_wpcal.py")), "test")
SOON = 10.0


class ClientTest(unittest.TestCase):
    def setUp(self) -> None:
        self.client = Client(lambda: FAKE)
        self.addCleanup(lambda: self.client.stop())  # noqa: PLW0108  # a test may replace the client

    def failure(self, method, params=None):
        request = self.client.call(method, params)
        with self.assertRaises(RuntimeError):
            request.wait(SOON)
        return request.failure

    def test_an_answer_with_progress(self) -> None:
        seen = []
        request = self.client.call("echo", {"text": "Schweißnaht"}, on_progress=lambda *progress: seen.append(progress))
        self.assertEqual(request.wait(SOON), {"text": "Schweißnaht"})
        self.assertEqual(seen, [("half", 0.5)])
        self.assertEqual(self.client.version, "0.0")

    def test_a_refusal_has_kind_message_and_hint(self) -> None:
        failure = self.failure("refuse")
        self.assertEqual((failure.kind, failure.text), ("InputError", "not so\nbut so"))

    def test_lines_that_are_no_answer_are_passed_over(self) -> None:
        self.assertIs(self.client.call("noise").wait(SOON), True)

    def test_a_crash_fails_what_was_asked_and_the_next_question_starts_anew(self) -> None:
        waiting = self.client.call("wait")
        self.assertIn("the last words", self.failure("crash").message)
        self.assertEqual(waiting.failure.kind, "stopped")
        self.assertEqual(self.client.call("echo", {"a": 1}).wait(SOON), {"a": 1})
        self.assertEqual(self.client.starts, 2)

    def test_cancelling(self) -> None:
        request = self.client.call("wait")
        request.cancel()
        with self.assertRaises(RuntimeError):
            request.wait(SOON)
        self.assertTrue(request.failure.is_cancelled)

    def test_the_caller_does_not_wait(self) -> None:
        self.client.call("echo").wait(SOON)
        begin = time.perf_counter()
        request = self.client.call("slow")
        sent = time.perf_counter() - begin
        request.wait(SOON)
        self.assertLess(sent, (time.perf_counter() - begin) / 2)

    def test_another_protocol_is_one_clear_message(self) -> None:
        with mock.patch.dict(os.environ, {"FAKE_PROTOCOL": "7"}):
            failure = self.failure("wait")
        self.assertEqual(failure.kind, "version")
        self.assertIn("7", failure.message)
        self.assertFalse(self.client.is_running)

    def test_a_program_that_is_not_there(self) -> None:
        self.client = Client(lambda: Executable(("/nowhere/wpcal",), "preferences"))
        failure = self.failure("echo")
        self.assertEqual(failure.kind, "missing")
        self.assertIn("/nowhere/wpcal (preferences)", failure.message)
        self.assertIn("install", failure.message)

    def test_no_program_at_all(self) -> None:
        self.client = Client(lambda: None)
        self.assertIn("pip install", self.failure("echo").message)

    def test_the_process_ends_with_its_input(self) -> None:
        self.client.call("echo").wait(SOON)
        pid = self.client.process_id
        self.client.stop()
        with self.assertRaises(ProcessLookupError):
            os.kill(pid, 0)

    def test_freecads_own_environment_is_not_passed_on(self) -> None:
        bundle = {"PYTHONHOME": "/x", "PYTHONPATH": "/x", "LD_LIBRARY_PATH": "/x", "QT_PLUGIN_PATH": "/x"}
        with mock.patch.dict(os.environ, {**bundle, "LD_LIBRARY_PATH_ORIG": "/users", "HOME_OF_MINE": "kept"}):
            seen = self.client.call("environment").wait(SOON)
        self.assertFalse(set(bundle) - {"LD_LIBRARY_PATH"} & set(seen))
        self.assertEqual((seen["LD_LIBRARY_PATH"], seen["HOME_OF_MINE"]), ("/users", "kept"))


class ExecutableTest(unittest.TestCase):
    def test_the_preference_is_taken_first_and_may_have_arguments(self) -> None:
        self.addCleanup(executable.set_preferred, executable.preferred())
        executable.set_preferred('"/a b/python" -m wpcal')
        self.assertEqual(find_executable().command, ("/a b/python", "-m", "wpcal"))

    def test_a_path_with_spaces_needs_no_quotes(self) -> None:
        self.addCleanup(executable.set_preferred, executable.preferred())
        path = Path(os.environ["WPCAL_TEST_FOLDER"]) / "a folder" / "wpcal"
        path.parent.mkdir()
        path.touch()
        executable.set_preferred(str(path))
        self.assertEqual(find_executable().command, (str(path),))

    def test_the_first_on_path_else_none(self) -> None:
        folder = Path(os.environ["WPCAL_TEST_FOLDER"])
        program = folder / "wpcal"
        program.write_text("")
        program.chmod(0o755)
        with mock.patch.dict(os.environ, {"PATH": str(folder)}):
            self.assertEqual(find_executable(), Executable((str(program),), "PATH"))

    def test_variables_of_appimages(self) -> None:
        seen = clean_environment({"APPDIR": "/x", "CSF_MDTVTexturesDirectory": "/x", "PATH": "/bin"})
        self.assertEqual(seen, {"PATH": "/bin", "PYTHONUTF8": "1"})
