"""Tests of kernel_ratios.py: python3 -m unittest discover -s tests/scripts"""

import json
import pathlib
import tempfile
import unittest
from unittest import mock

import kernel_ratios


class KernelRatios(unittest.TestCase):
    def write(self, folder, name, times, iters):
        place = pathlib.Path(folder) / name.replace("/", "_") / "new"
        place.mkdir(parents=True)
        (place / "benchmark.json").write_text(json.dumps({"full_id": name}))
        (place / "sample.json").write_text(json.dumps({"times": times, "iters": iters}))

    def test_the_shortest_iteration_counts(self):
        with tempfile.TemporaryDirectory() as folder:
            self.write(folder, "easy/copy", [30.0, 40.0, 90.0], [1, 2, 3])
            self.write(folder, "easy/sun/512", [100.0], [2])
            times = kernel_ratios.read_times(folder)
            self.assertEqual(times, {"easy/copy": 20.0, "easy/sun/512": 50.0})

    def test_ratios_are_to_the_peer_and_to_the_copy(self):
        times = {name: 2.0 for name in kernel_ratios.wanted_names()}
        times["easy/table/isotropic, 64 KiB"] = 6.0
        times["easy/copy"] = 1.0
        found, missing = kernel_ratios.ratios(times)
        self.assertEqual(missing, [])
        self.assertEqual(found["easy/table/isotropic, 64 KiB"], {"peer": 3.0, "copy": 6.0})
        del times["easy/sun/512"]
        found, missing = kernel_ratios.ratios(times)
        self.assertEqual(missing, ["easy/sun/512"])
        self.assertNotIn("easy/table/isotropic, 64 KiB", found)

    def test_groups_are_compared_without_the_others(self):
        times = {name: 2.0 for name in kernel_ratios.wanted_names(["voxels"])}
        found, missing = kernel_ratios.ratios(times, ["voxels"])
        self.assertEqual(missing, [])
        self.assertEqual(len(found), len(kernel_ratios.KERNELS["voxels"]))

    def test_every_group_is_in_one_bench(self):
        groups = [group for _, its_groups in kernel_ratios.BENCHES.values() for group in its_groups]
        self.assertEqual(sorted(groups), sorted(kernel_ratios.KERNELS))

    def test_groups_are_those_of_the_benches_that_are_named(self):
        chosen = kernel_ratios.chosen_groups
        self.assertEqual(set(chosen(None, None)), set(kernel_ratios.KERNELS))
        self.assertEqual(chosen(["lookups"], None), ["voxels", "windows"])
        self.assertEqual(chosen(["lookups", "steps"], ["windows"]), ["windows"])
        self.assertEqual(chosen(None, ["windows", "easy"]), ["easy", "windows"])
        with self.assertRaises(ValueError):
            chosen(["lookups"], ["windows", "easy"])

    def test_another_processor_is_said_before_benches_run(self):
        arguments = ["kernel_ratios.py", "--run", "--record", "--bench", "lookups"]
        record = json.dumps({"processor": "another", "ratios": {}})
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "record.json"
            file.write_text(record)
            with mock.patch.object(kernel_ratios, "RECORD", file), mock.patch.object(
                kernel_ratios, "run_benches"
            ) as run, mock.patch("sys.argv", arguments):
                with self.assertRaises(SystemExit):
                    kernel_ratios.main()
            run.assert_not_called()
            self.assertEqual(file.read_text(), record)

    def test_a_kernel_is_slower_if_it_is_so_beside_both(self):
        before = {name: {"peer": 1.0, "copy": 1.0} for name in "abc"}
        now = {
            "a": {"peer": 1.2, "copy": 1.25},
            "b": {"peer": 1.4, "copy": 1.5},
            "c": {"peer": 1.0, "copy": 1.5},
            "d": {"peer": 1.0, "copy": 1.0},
        }
        lines, slower, unknown = kernel_ratios.compare(now, before, 1.3)
        self.assertEqual((slower, unknown), (["b"], ["d"]))
        self.assertTrue(lines[1].endswith("SLOWER"))
        self.assertTrue(lines[2].endswith("slower beside the copy alone"))

    def test_the_record_has_every_kernel(self):
        record = json.loads(kernel_ratios.RECORD.read_text())["ratios"]
        kernels = [f"{g}/{k}" for g, names in kernel_ratios.KERNELS.items() for k in names]
        self.assertEqual(sorted(record), sorted(kernels))

    def test_names_are_matched_as_they_are(self):
        self.assertEqual(kernel_ratios.escaped("a/b (0.6)"), r"a/b \(0\.6\)")


if __name__ == "__main__":
    unittest.main()
