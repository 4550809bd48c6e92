"""What programs that were killed have left is removed, and nothing else."""

import os
import tempfile

from bathbot_bringup.files import clean_folders, log_folder


def test_only_old_folders_of_ours_are_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("bathbot-demo-1", "bathbot-demo-2", "else-demo-3"):
        (tmp_path / name / "logs").mkdir(parents=True)
        (tmp_path / name / "logs" / "node.log").write_text("x")
    (tmp_path / "bathbot-demo-4").symlink_to(tmp_path / "else-demo-3")
    for path in (tmp_path, *tmp_path.rglob("*")):
        os.utime(path, (0, 0))
    (tmp_path / "bathbot-demo-2" / "logs" / "node.log").write_text("just written")
    with log_folder("record") as new:
        assert clean_folders() == 1
        left = {path.name for path in tmp_path.iterdir()}
    assert left == {"bathbot-demo-2", "else-demo-3", "bathbot-demo-4", new.name}
