"""backup, diff and restore against an amplifier of pymodbus, and what goes wrong on the way."""
import fcntl
import json
import random
import socket
import stat
import subprocess
import threading
import time
import unittest
from pathlib import Path

from peer import PROFILE, Peer
from program import ROOT, DeviceTest, program, with_value


class AmplifierTest(DeviceTest):
    """With a peer that serves the second profile, and journals kept in the scratch folder."""

    def peer(self, *options, **more):
        peer = Peer(*options, log=self.folder / "writes.jsonl", **more)
        self.addCleanup(peer.close)
        return peer

    def device(self, peer):
        return "--connect", peer.url, "--profile", "integer_drive"

    def backup(self, peer, name="before.json"):
        answer = self.run_program("backup", *self.device(peer), "-o", name)
        self.assertEqual(answer.code, 0, answer)
        return name

    def changed_backup(self, name, **values):
        """The same backup with other words for some registers."""
        document = json.loads((self.folder / name).read_text())
        for setting in document["settings"]:
            if setting["register"] in values:
                setting["words"] = values[setting["register"]]
        (self.folder / "wanted.json").write_text(json.dumps(document))
        return "wanted.json"

    def setting(self, name, register):
        document = json.loads((self.folder / name).read_text())
        return next(s for s in document["settings"] if s["register"] == register)

    def write_profile(self, path, value, name="profile.json"):
        profile = with_value(json.loads(PROFILE.read_text()), path, value)
        (self.folder / name).write_text(json.dumps(profile))
        return name


class SettingsTest(AmplifierTest):

    def test_a_backup_has_every_setting_in_words_and_in_si_units(self):
        name = self.backup(self.peer())
        limit = self.setting(name, "current_limit")
        self.assertEqual((limit["words"], limit["value"], limit["unit"]), ([2000], 2, "A"))
        self.assertEqual(limit["address"], "holding 0x00C8 (40201)")
        self.assertAlmostEqual(self.setting(name, "temperature_limit")["value"], 393.15)
        self.assertAlmostEqual(self.setting(name, "damping_capacitance")["value"], 1e-3)
        self.assertEqual(self.setting(name, "back_emf_resistance")["words"], [0, 1500])  # high word first
        registers = [s["register"] for s in json.loads((self.folder / name).read_text())["settings"]]
        self.assertIn("enable", registers)
        self.assertNotIn("watchdog", registers)

    def test_nothing_is_written_without_apply(self):
        peer = self.peer()
        wanted = self.changed_backup(self.backup(peer), current_limit=[1500])
        answer = self.run_program("restore", wanted, *self.device(peer))
        self.assertEqual(answer.code, 0, answer)
        self.assertIn("2000 mA  1500 mA", answer.out)
        self.assertIn("Dry run", answer.out)
        self.assertEqual(peer.writes(), [])
        self.assertEqual(self.run_program("diff", wanted, *self.device(peer)).code, 1)

    def test_a_restore_writes_what_differs_and_reads_it_back(self):
        peer = self.peer()
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[1500], cancellation_resistance=[1200, 0],
                                     back_emf_resistance=[0, 2000], damping_connected=[1])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply", "--json")
        self.assertEqual(answer.code, 0, answer)
        result = answer.json
        self.assertEqual((result["applied"], result["state"]), (True, "changed"))
        plan = {row["register"]: row for row in result["plan"]}
        self.assertEqual(set(plan), {"current_limit", "cancellation_resistance", "back_emf_resistance",
                                     "damping_connected"})
        self.assertAlmostEqual(plan["cancellation_resistance"]["new"], 1.2)
        self.assertEqual(plan["cancellation_resistance"]["unit"], "ohm")
        self.assertEqual(self.run_program("diff", wanted, *self.device(peer)).code, 0)
        changed = self.run_program("diff", before, wanted, "--profile", "integer_drive", "--json")
        self.assertEqual(changed.code, 1)
        self.assertEqual({row["register"] for row in changed.json["plan"]}, set(plan))
        written = {w["register"]: w["value"] for w in peer.writes()}
        self.assertAlmostEqual(written["current_limit"], 1.5)
        self.assertNotIn("damping_resistance", written)  # it was so already

    def test_the_drive_is_off_while_settings_change_and_comes_back_last(self):
        peer = self.peer("--start", "enable=1", "--no-watchdog")
        wanted = self.changed_backup(self.backup(peer), current_limit=[1500])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply")
        self.assertEqual(answer.code, 0, answer)
        order = [(w["register"], w["value"]) for w in peer.writes()
                 if w["register"] in ("enable", "current_limit")]
        self.assertEqual(order, [("enable", 0), ("current_limit", 1.5), ("enable", 1)])

    def test_a_journal_puts_everything_back_by_itself(self):
        peer = self.peer()
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[1500], damping_resistance=[30])
        self.assertEqual(self.run_program("restore", wanted, *self.device(peer), "--apply").code, 0)
        journals = list((self.folder / "state/gyrator").glob("*.jsonl"))
        self.assertEqual(len(journals), 1)
        lines = [json.loads(line) for line in journals[0].read_text().splitlines()]
        self.assertEqual(lines[0]["schema"], "gyrator/amplifier-journal/1")
        self.assertEqual([line["write"] for line in lines if "write" in line][-2:],
                         ["current_limit", "damping_resistance"])
        self.assertEqual(lines[-1]["state"], "changed")
        self.assertEqual(self.run_program("restore", "--journal", journals[0]).code, 0)
        self.assertEqual(self.run_program("diff", wanted, *self.device(peer)).code, 0)
        answer = self.run_program("restore", "--journal", journals[0], "--apply", "--json")
        self.assertEqual((answer.code, answer.json["state"]), (0, "safe"), answer)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)

    def test_a_journal_goes_back_beyond_the_profiles_limits_but_not_beyond_those_given(self):
        peer = self.peer()
        before = self.backup(peer)  # 2 A
        narrow = self.write_profile("/registers/7/max", 1000)
        wanted = self.changed_backup(before, current_limit=[700])
        answer = self.run_program("restore", wanted, "--connect", peer.url, "--profile", narrow, "--apply", "--json")
        self.assertEqual(answer.code, 0, answer)
        journal = answer.json["journal"]
        self.assert_refused(self.run_program("restore", "--journal", journal, "--apply", "--limit", "current_limit=1A"),
                            "2000 mA", "--limit allows at most 1000 mA", "did not come to its end",
                            f"gyrator restore --journal {journal} --apply", code=4)
        answer = self.run_program("restore", "--journal", journal, "--apply")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)

    def test_a_malformed_journal_is_refused_with_its_line(self):
        peer = self.peer()
        answer = self.run_program("restore", self.changed_backup(self.backup(peer), current_limit=[700]),
                                  *self.device(peer), "--apply", "--json")
        good = Path(answer.json["journal"]).read_text()
        for text, words in (('{"schema":5}\n', ("bad.jsonl", "is no journal")),
                            (good + '{"write":5}\n', (f"bad.jsonl: line {good.count(chr(10)) + 1}", '"write": 5')),
                            (good + '{"state":7}\n', (f"bad.jsonl: line {good.count(chr(10)) + 1}", '"state": 7')),
                            (good.replace('"unit":7', '"unit":"x"'), ("bad.jsonl", "line 1", '"unit"'))):
            with self.subTest(text[-20:]):
                (self.folder / "bad.jsonl").write_text(text)
                self.assert_refused(self.run_program("restore", "--journal", "bad.jsonl"), *words)

    def test_words_that_stand_for_no_value_are_refused(self):
        peer = self.peer()
        before = self.backup(peer)
        narrow = self.write_profile("/registers/7/not_implemented", 65535)
        wanted = self.changed_backup(before, current_limit=[65535])
        self.assert_refused(
            self.run_program("restore", wanted, "--connect", peer.url, "--profile", narrow, "--apply"),
            "current_limit", "0xFFFF", "no value", code=4)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)

    def test_killed_at_any_moment_it_is_put_back_from_the_journal(self):
        peer = self.peer("--turnaround", 0.01)
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[1500], damping_resistance=[30], damping_capacitance=[47],
                                     cancellation_resistance=[700, 0], back_emf_damping=[0, 1500])
        draw = random.Random(20)
        for i in range(8):
            journal = self.folder / f"journal{i}"
            process = subprocess.Popen([program(), "restore", wanted, *self.device(peer), "--apply"],
                                       cwd=self.folder, env={**self.environment, "XDG_STATE_HOME": str(journal)},
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(draw.uniform(0.05, 0.4))
            process.kill()
            process.wait()
            for path in journal.glob("gyrator/*.jsonl"):
                if not path.read_bytes().startswith(b'{"backup"'):
                    continue  # not even begun: nothing was written
                answer = self.run_program("restore", "--journal", path, "--apply")
                self.assertEqual(answer.code, 0, answer)
            answer = self.run_program("diff", before, *self.device(peer))
            self.assertEqual(answer.code, 0, answer)
        self.assertGreater(len([w for w in peer.writes() if w["register"] == "current_limit"]), 2)

    def test_what_is_persistent_needs_a_word_of_its_own(self):
        peer = self.peer()
        wanted = self.changed_backup(self.backup(peer), label=[7])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply")
        self.assert_refused(answer, "label", "persistent memory", "100000 writes", "--persist", code=4)
        self.assertNotIn("label", [w["register"] for w in peer.writes()])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply", "--persist")
        self.assertEqual(answer.code, 0, answer)

    def test_limits_of_profile_and_command_line_hold(self):
        peer = self.peer()
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[10010])
        self.assert_refused(self.run_program("restore", wanted, *self.device(peer), "--apply"),
                            "current_limit (holding 0x00C8 (40201))", "10010 mA", "at most 10000 mA", code=4)
        wanted = self.changed_backup(before, current_limit=[1500])
        self.assert_refused(
            self.run_program("restore", wanted, *self.device(peer), "--apply", "--limit", "current_limit=1A"),
            "1500 mA", "--limit allows at most 1000 mA", code=4)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)
        for limit, words in (("current_limit", "NAME=VALUE"), ("curent_limit=1", "did you mean 'current_limit'"),
                             ("current_limit=1V", "current [A]")):
            self.assert_refused(self.run_program("restore", wanted, *self.device(peer), "--limit", limit),
                                "--limit", words)

    def test_a_register_that_does_not_obey_is_named_and_all_is_put_back(self):
        peer = self.peer("--stuck", "damping_resistance")
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[1500], damping_resistance=[30])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply")
        self.assert_refused(answer, "damping_resistance (holding 0x00D4 (40213))", "wrote 16 ohm", "reads 10 ohm",
                            "safe state", code=4)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)

    def test_a_warning_that_nobody_reads_does_not_stand_in_the_way(self):
        peer = self.peer()
        before = self.backup(peer)
        wanted = self.changed_backup(before, current_limit=[1500])
        self.assertEqual(self.run_program("restore", wanted, *self.device(peer), "--apply").code, 0)
        journal, = self.journals()  # as if it had been cut off
        lines = journal.read_text().splitlines(keepends=True)
        self.assertIn('"state":"changed"', lines.pop())
        journal.write_text("".join(lines))
        answer = self.run_program("restore", wanted, *self.device(peer))
        self.assertEqual(answer.code, 0, answer)
        answer = self.run_unheard("restore", before, *self.device(peer), "--apply")
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual(self.run_program("diff", before, *self.device(peer)).code, 0)
        wanted = self.changed_backup(before, current_limit=[1500])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply")
        self.assertIn("an earlier session did not end", answer.err)

    def test_a_serial_line_is_the_same(self):
        peer = self.peer(rtu=self.folder / "line")
        before = self.backup(peer)
        wanted = self.changed_backup(before, cancellation_resistance=[500, 0])
        answer = self.run_program("restore", wanted, *self.device(peer), "--apply")
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual(self.run_program("diff", wanted, *self.device(peer)).code, 0)


class DeviceFailureTest(AmplifierTest):

    def test_another_device_is_recognized(self):
        peer = self.peer("--start", "device_type=1")
        self.assert_refused(self.run_program("backup", *self.device(peer)), "device_type", "reads 1", "19761", code=4)

    def test_another_unit_does_not_answer(self):
        peer = self.peer()
        self.assert_refused(self.run_program("backup", *self.device(peer), "--unit", 9, "--timeout", "0.1s"),
                            peer.url, code=4)

    def test_what_the_device_refuses_is_named_and_the_rest_is_kept(self):
        name = self.write_profile("/link/retries", 1)
        profile = json.loads((self.folder / name).read_text())
        profile["registers"].append({"name": "ghost", "address": 204, "type": "u16"})
        (self.folder / name).write_text(json.dumps(profile))
        peer = self.peer()
        answer = self.run_program("backup", "--connect", peer.url, "--profile", name, "-o", "b.json")
        self.assertEqual(answer.code, 0, answer)
        self.assertIn("ghost (holding 0x00CC (40205)): illegal data address", answer.err)
        self.assertEqual(self.setting("b.json", "current_limit")["value"], 2)

    def test_nobody_there_and_nobody_answering(self):
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            port = silent.getsockname()[1]
            free = f"tcp://127.0.0.1:{port}"
            self.assert_refused(self.run_program("backup", "--connect", free, "--profile", "integer_drive"), free,
                                code=4)
            silent.listen()
            taken = []
            threading.Thread(target=lambda: taken.append(silent.accept()[0]), daemon=True).start()
            self.assert_refused(self.run_program("backup", "--connect", free, "--profile", "integer_drive",
                                                 "--timeout", "0.1s"), free, code=4)
            for connection in taken:
                connection.close()

    def test_two_writers_do_not_fight(self):
        peer = self.peer()
        before = self.backup(peer)
        port = peer.url.rsplit(":", 1)[1]
        common = Path("/run/lock")
        folder = common if common.is_dir() and common.stat().st_mode & stat.S_IWOTH else Path("/tmp")
        path = folder / f"gyrator-tcp___127.0.0.1_{port}_unit_7.lock"
        self.addCleanup(path.unlink, missing_ok=True)
        with open(path, "w+", encoding="utf-8") as lock:
            lock.write("pid 4711\n")
            lock.flush()
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.assert_refused(self.run_program("restore", before, *self.device(peer), "--apply"), "process 4711",
                                code=4)
            self.assertEqual(self.run_program("restore", before, *self.device(peer)).code, 0)  # reading may go on


class ProfileTest(AmplifierTest):

    def test_mistakes_are_named_with_their_place(self):
        for path, value, words in (
                ("/registers/7/scale", 0, ("profile.json: /registers/7/scale", "must not be zero")),
                ("/registers/7/address", 201, ("/registers/8/address", "lies on 'current_limit'")),
                ("/registers/7/unit", "mV", ("/registers/7/unit", "current_limit is in A")),
                ("/watchdog/register", "wotchdog", ("/watchdog/register", "did you mean 'watchdog'")),
                ("/order", "abcd", ("/order", "ABCD"))):
            with self.subTest(path):
                name = self.write_profile(path, value)
                self.assert_refused(
                    self.run_program("backup", "--connect", "tcp://127.0.0.1:1", "--profile", name), *words)

    def test_options_are_checked_before_anything_is_connected(self):
        for options, words in (((), ("--connect", "is missing")),
                               (("--connect", "tcp://127.0.0.1:1"), ("--profile", "is missing")),
                               (("--connect", "udp://x", "--profile", "integer_drive"), ("--connect", "udp")),
                               (("--connect", "tcp://127.0.0.1:1", "--profile", "nothing"), ("nothing", "gyrator_twin"))):
            with self.subTest(options):
                self.assert_refused(self.run_program("backup", *options), *words)

    def test_backups_of_other_devices_are_refused(self):
        peer = self.peer()
        name = self.backup(peer)
        self.assert_refused(self.run_program("restore", name, "--connect", peer.url, "--profile", "gyrator_twin"),
                            name)
        (self.folder / "b.json").write_text((self.folder / name).read_text().replace("current_limit", "current_limt"))
        self.assert_refused(self.run_program("restore", "b.json", *self.device(peer)), "/register", "current_limt")
        self.assert_refused(self.run_program("restore", "--journal", name), "is no journal")

    def test_the_shipped_schema_is_the_programs(self):
        self.assertEqual(self.run_program("schema", "--amplifier").out,
                         (ROOT / "schemas/amplifier.schema.json").read_text())

    def test_the_manuals_table_is_the_programs(self):
        manual = self.run_program("schema", "--amplifier", "--manual").out
        self.assertTrue((ROOT / "docs/amplifier-profile.md").read_text().endswith(manual),
                        "docs/amplifier-profile.md must end in `gyrator schema --amplifier --manual`")


if __name__ == "__main__":
    unittest.main()
