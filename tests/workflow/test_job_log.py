import subprocess
import sys

import pytest

from imugap.workflow.job_log import journal


def test_output_lands_in_the_file_and_nowhere_else(tmp_path, capsys):
    with journal(tmp_path / "job.log"):
        print("to stdout")
        print("to stderr", file=sys.stderr)
    assert (tmp_path / "job.log").read_text() == "to stdout\nto stderr\ndone\n"
    assert capsys.readouterr() == ("", "")


def test_warnings_land_in_the_file(tmp_path):
    """In a process of its own: pytest catches warnings ahead of the journal."""
    code = "import sys, warnings\nfrom imugap.workflow.job_log import journal\n"
    code += "with journal(sys.argv[1]):\n    warnings.warn('mind the gap')\n"
    done = subprocess.run([sys.executable, "-c", code, tmp_path / "job.log"], capture_output=True, check=True)
    assert "UserWarning: mind the gap" in (tmp_path / "job.log").read_text()
    assert done.stderr == b""


@pytest.mark.parametrize("kind", [ValueError, KeyboardInterrupt, SystemExit])
def test_an_exception_lands_in_the_file_and_goes_on(tmp_path, kind):
    def job():
        with journal(tmp_path / "job.log"):
            print("before")
            raise kind("lost")

    with pytest.raises(kind, match="lost"):
        job()
    text = (tmp_path / "job.log").read_text()
    assert text.startswith("before\nTraceback")
    assert text.rstrip().endswith(f"{kind.__name__}: lost")
    assert "done" not in text


def test_the_streams_are_given_back(tmp_path, capsys):
    with pytest.raises(ValueError, match="lost"), journal(tmp_path / "job.log"):
        raise ValueError("lost")
    print("after")
    assert capsys.readouterr().out == "after\n"


def test_the_folder_is_made_and_an_old_journal_is_replaced(tmp_path):
    path = tmp_path / "logs" / "deep" / "job.log"
    for text in ("a longer first line", "second"):
        with journal(path):
            print(text)
    assert path.read_text() == "second\ndone\n"


def test_what_is_printed_is_in_the_file_at_once(tmp_path):
    with journal(tmp_path / "job.log"):
        print("first line")
        assert (tmp_path / "job.log").read_text() == "first line\n"
