#!/usr/bin/python3
"""The workflows for a public CI are well formed, and run what .ci/run runs."""
import re
import shlex
import unittest

import yaml

import daemons

WORKFLOW = daemons.ROOT / ".github" / "workflows" / "ci.yml"
PAGES = WORKFLOW.with_name("pages.yml")
NIGHTLY = WORKFLOW.with_name("nightly.yml")
EXAMPLE = daemons.ROOT / "docs" / "examples" / "github_workflow.yml"


def jobs_of(file):
    return yaml.safe_load(file.read_text())["jobs"]


def stages_of_ci():
    """Of .ci/run: whether a stage is on trial, and its command's words, by name."""
    text = (daemons.ROOT / ".ci" / "run").read_text().replace("\\\n", " ").replace("\n  ", " ")
    for name, words in re.findall(r"^(\w+)=\(([^()]*)\)$", text, re.MULTILINE):
        text = text.replace(f"${{{name}[*]}}", " ".join(words.split()))
    return {name: (kind == "trial", [word for word in shlex.split(command) if word != "$base"])
            for kind, name, command in re.findall(r"^(?:if_changed .*?)?(stage|trial) (\w+) (.+)$", text, re.MULTILINE)}


class WorkflowTest(unittest.TestCase):
    def test_every_stage_of_CI_is_run_alike_and_with_the_same_weight(self):
        matrix = jobs_of(WORKFLOW)["stage"]["strategy"]["matrix"]["include"]
        there = {entry["stage"]: (entry.get("trial", False), shlex.split(entry["run"])) for entry in matrix}
        stages = stages_of_ci()
        self.assertGreaterEqual(stages.keys(), {"checks", "integration", "unit", "laws", "long"})
        self.assertEqual(stages, {name: there.get(name) for name in stages})

    def test_every_script_that_a_stage_runs_is_there_and_knows_its_options(self):
        steps = [step for step in jobs_of(PAGES)["site"]["steps"] if "scripts/" in step.get("run", "")]
        self.assertEqual(len(steps), 1)
        for entry in [*jobs_of(WORKFLOW)["stage"]["strategy"]["matrix"]["include"], *steps]:
            for script in re.findall(r"scripts/\w+", entry["run"].split("[ !")[0]):
                self.assertTrue((daemons.ROOT / script).exists(), script)
                for option in re.findall(r" (--[a-z]+)", entry["run"]):
                    self.assertIn(option, (daemons.ROOT / script).read_text(), entry["run"])

    def test_every_job_runs_in_its_container_within_a_time_by_actions_of_a_named_version(self):
        for file in (WORKFLOW, EXAMPLE, NIGHTLY):
            for name, job in jobs_of(file).items():
                with self.subTest(f"{file.name}: {name}"):
                    self.assertEqual(job["container"]["image"],
                                     "${{ matrix.system }}" if file == NIGHTLY else "debian:12")
                    self.assertLessEqual(job["timeout-minutes"], 120)
                    for step in job["steps"]:
                        self.assertEqual(("run" in step) + ("uses" in step), 1, step)
                        self.assertRegex(step.get("uses", "a@v1"), r"^[\w/-]+@v\d+$")
                    self.assertEqual(job["steps"][-1]["if"], "failure()")
                    self.assertIn("upload-artifact", job["steps"][-1]["uses"])

    def test_the_nightly_workflow_runs_demo_and_tests_on_each_distribution_that_setup_knows(self):
        job = jobs_of(NIGHTLY)["distribution"]
        names = {" ".join(system.capitalize().split(":")) for system in job["strategy"]["matrix"]["system"]}
        tested = re.search(r"^tested='(.*)'$", (daemons.ROOT / "scripts/setup").read_text(), re.MULTILINE)[1]
        self.assertEqual(names, set(tested.replace(" or 13", ", Debian 13").replace("or ", "").split(", ")))
        commands = " ".join(step.get("run", "") for step in job["steps"])
        self.assertIn("scripts/demo", commands)
        self.assertIn("scripts/test", commands)
        self.assertIn("scripts/test --long", commands)


if __name__ == "__main__":
    daemons.main()
