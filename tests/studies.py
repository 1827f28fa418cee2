"""Checks every study of the repository, as its users and CI do."""
import os, pathlib, subprocess, sys

root = pathlib.Path(__file__).resolve().parent.parent
studies = sorted(path.relative_to(root) for path in root.glob("studies/*/study.json"))
folders = [path for path in (root / "studies").iterdir() if path.is_dir()]
if len(studies) != len(folders) or not studies:
    sys.exit(f"{len(studies)} studies in {len(folders)} folders of {root / 'studies'}: each needs a study.json")
sys.exit(subprocess.run([os.environ["GYRATOR"], "study", "check", *studies], cwd=root).returncode)
