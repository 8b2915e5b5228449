import hashlib
import threading
from contextlib import contextmanager
from dataclasses import FrozenInstanceError, replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from imugap.io.catalogue.datasets import CatalogueError, FetchError, RawFile, available, fetch, load, locate

ROOT = Path(__file__).parents[3]
SCHEMAS = ROOT / "workflow" / "schemas"
CONTENT = bytes(range(256)) * 4000


@pytest.fixture
def tables(tmp_path):
    folder = tmp_path / "tables"
    folder.mkdir()
    for name in ("datasets.csv", "files.csv"):
        (folder / name).write_text((ROOT / "data" / name).read_text(encoding="utf-8"), encoding="utf-8")
    return folder


@pytest.fixture
def raw(tmp_path):
    return tmp_path / "raw"


def a_file(url="http://127.0.0.1:9/bench/log.bin", content=CONTENT):
    return RawFile("bench", "log.bin", (1,), len(content), hashlib.sha256(content).hexdigest(), url)


def put(folder, content):
    path = a_file().place(folder)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


@contextmanager
def server(ranges=True, cut_after=None, content=CONTENT, status=200):
    """Serve ``content`` on 127.0.0.1; yields its address and the list of Range headers asked for."""
    asked = []

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.headers.get("Range"))
            start = int(asked[-1].removeprefix("bytes=").removesuffix("-")) if ranges else 0
            self.send_response(206 if ranges and status == 200 else status)
            self.send_header("Content-Length", str(len(content) - start))
            self.end_headers()
            self.wfile.write(content[start:][:cut_after])

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as httpd:
        threading.Thread(target=httpd.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{httpd.server_port}/bench/log.bin", asked
        httpd.shutdown()


def test_the_catalogue_of_the_study_is_valid(sets):
    assert sets["adis16405"].runs == (1, 2, 3, 4, 5, 6)
    assert sets["memsense_turnon"].runs == tuple(range(1, 12))
    assert sets["memsense_turnon"].units == ("deg/s",) * 3
    assert sets["broad"].runs == (1, 6, 10, 24)
    assert sets["broad"].units == ("rad/s",) * 3 + ("m/s^2",) * 3
    assert sets["broad"].reference == ("opt_quat", "movement")
    assert sets["gaitmap_2x20m"].runs == sets["gaitmap_2x20m"].runs_with("positions") == (1, 2)
    assert sets["gaitmap_2x20m"].file(2, "positions").name == "mocap_sample.csv"
    assert sets["gaitmap_2x20m"].file(2).name == "imu_sample.csv"
    assert sets["pyshoe_vicon"].runs == tuple(range(1, 11))
    assert sets["pyshoe_vicon_rest"].runs == tuple(range(11, 57))
    assert sets["pyshoe_vicon_rest"].file(11).place("raw").parent == sets["pyshoe_vicon"].file(1).place("raw").parent
    with pytest.raises(CatalogueError, match="among none: no file holds positions"):
        sets["pyshoe_vicon"].file(1, "positions")
    assert sets["xsens_dot"].columns == ()
    assert sets["euroc_v1_02"].file(1, "poses").name == "V1_02_medium.csv"
    assert sets["adis16405"].file(4).name == "adis_16405_imu4.rda"
    assert all(file.name.endswith(file.url.rpartition("/")[2]) for dataset in sets.values() for file in dataset.files)
    with pytest.raises(FrozenInstanceError):
        sets["adis16405"].rate_hz = 99.0


def test_a_run_that_no_file_holds_is_named(sets):
    with pytest.raises(CatalogueError, match="expected a run among 1, 2, 3, 4, 5, 6; found 7"):
        sets["adis16405"].file(7)


@pytest.mark.parametrize(
    ("table", "old", "new", "message"),
    [
        ("datasets.csv", "static,100,", "static,fast,", "line 2, column rate_hz: expected a number; found 'fast'"),
        ("datasets.csv", "static,100,", "static,-1,", "line 2, column rate_hz"),
        ("datasets.csv", "static,100,", "moving,100,", "line 2, column kind"),
        ("datasets.csv", "gyro_x gyro_y gyro_z accel_x", "gyro_x gyro_y gyr_z accel_x", "line 2, column columns"),
        ("datasets.csv", "_z,,,,,,,deg/s,g,", "_z,,,,,,,deg/s,,", "line 2: expected accel_unit; found none"),
        (
            "datasets.csv",
            "static,100,gyro_x gyro_y gyro_z accel_x accel_y accel_z,",
            "static,100,,",
            "line 2: expected columns",
        ),
        (
            "datasets.csv",
            "recording,200,,",
            "recording,200,gyro_x,",
            "line 15, column columns: expected no columns of a recording",
        ),
        ("datasets.csv", "memsense_turnon,", "adis16405,", "line 3, column dataset"),
        ("datasets.csv", ",remarks\n", ",remark\n", "line 2: expected a key of the schema"),
        ("files.csv", "adis_16405_imu2.rda,2,", "adis_16405_imu2.rda,1,", "line 3, column run: .* found '1'"),
        ("files.csv", "1-11", "11-1", "line 8, column run"),
        ("files.csv", ",3200168,", ",many,", "line 2, column bytes"),
        ("files.csv", "1eb09074", "XYZ", "line 2, column sha256"),
        ("files.csv", "memsense_turnon,", "memsense,", "line 8, column dataset: expected one of adis16405, memsense_t"),
        ("files.csv", "adis_16405_imu1.rda,1,", "../imu1.rda,1,", "line 2, column file"),
        (
            "files.csv",
            "adis_16405_imu1.rda,1,",
            '"imu1.rda\n",1,',
            "line 3, column file: expected plain text of one line",
        ),
        (
            "files.csv",
            "adis16405,adis_16405_imu1",
            '"adis16405\n",adis_16405_imu1',
            "line 3, column dataset: expected plain",
        ),
        ("files.csv", "https://", "http://", "line 2, column url: expected text of the form"),
        ("files.csv", "https://", "file:///", "line 2, column url: expected text of the form"),
    ],
)
def test_a_bad_row_is_named_by_table_line_and_column(tables, table, old, new, message):
    text = (tables / table).read_text(encoding="utf-8")
    assert old in text
    (tables / table).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CatalogueError, match=f"{table}: {message}"):
        load(tables, SCHEMAS)


@pytest.mark.parametrize("table", ["datasets.csv", "files.csv"])
def test_a_row_with_a_cell_too_many_is_named(tables, table):
    with (tables / table).open("a", encoding="utf-8") as handle:
        handle.write("a,b,c,d,e,f,g,h,i,j,k,l,m\n")
    with pytest.raises(CatalogueError, match=rf"{table}: line \d"):
        load(tables, SCHEMAS)


def test_a_set_without_files_is_named(tables):
    text = (tables / "files.csv").read_text(encoding="utf-8")
    (tables / "files.csv").write_text("\n".join(text.splitlines()[:7]) + "\n", encoding="utf-8")
    with pytest.raises(CatalogueError, match="none for 'memsense_turnon'"):
        load(tables, SCHEMAS)


def test_a_whole_file_is_left_alone(raw):
    path = put(raw, CONTENT)
    before = path.stat()
    assert fetch(a_file(), raw) == path
    assert path.stat().st_mtime_ns == before.st_mtime_ns


def test_a_wrong_file_placed_by_hand_is_reported_and_kept(raw, tmp_path):
    put(tmp_path / "mirror", CONTENT)
    path = put(raw, b"something else")
    with pytest.raises(FetchError) as failure:
        fetch(a_file(), raw, tmp_path / "mirror")
    assert path.read_bytes() == b"something else"
    for part in (str(path), a_file().sha256, hashlib.sha256(b"something else").hexdigest(), "14 bytes"):
        assert part in str(failure.value)


def test_the_mirror_is_copied_and_verified(raw, tmp_path):
    mirror = tmp_path / "mirror"
    put(mirror, CONTENT)
    assert fetch(a_file(), raw, mirror).read_bytes() == CONTENT
    assert [path.name for path in (raw / "bench").iterdir()] == ["log.bin"]


def test_a_wrong_file_in_the_mirror_never_gets_the_name(raw, tmp_path):
    wrong = put(tmp_path / "mirror", CONTENT[:-1])
    with pytest.raises(FetchError, match=f"{wrong} gave another file"):
        fetch(a_file(), raw, tmp_path / "mirror")
    assert not list((raw / "bench").iterdir())


def test_a_file_that_the_mirror_lacks_is_downloaded(raw, tmp_path):
    with server() as (url, _):
        assert fetch(a_file(url), raw, tmp_path / "nowhere").read_bytes() == CONTENT


@pytest.mark.parametrize("ranges", [True, False])
def test_a_download_that_broke_off_is_completed(raw, ranges):
    with server(ranges, cut_after=300_000) as (url, _), pytest.raises(FetchError):
        fetch(a_file(url), raw)
    partial = raw / "bench" / "log.bin.partial"
    kept = partial.stat().st_size
    assert 0 < kept <= 300_000
    assert partial.read_bytes() == CONTENT[:kept]
    with server(ranges) as (url, asked):
        assert fetch(a_file(url), raw).read_bytes() == CONTENT
    assert asked == [f"bytes={kept}-"]
    assert not partial.exists()


def test_a_whole_partial_file_is_not_downloaded_again(raw):
    put(raw, CONTENT).rename(raw / "bench" / "log.bin.partial")
    assert fetch(a_file(), raw).read_bytes() == CONTENT


def test_a_spoilt_partial_file_is_removed_and_the_next_call_succeeds(raw):
    put(raw, b"\xff" * 1000).rename(raw / "bench" / "log.bin.partial")
    with server() as (url, _):
        with pytest.raises(FetchError, match="gave another file"):
            fetch(a_file(url), raw)
        assert fetch(a_file(url), raw).read_bytes() == CONTENT


def test_a_file_that_is_longer_than_catalogued_is_cut_off_and_removed(raw):
    with server(content=CONTENT + b"more") as (url, _), pytest.raises(FetchError, match="bytes; found more; what had"):
        fetch(a_file(url), raw)
    assert not list((raw / "bench").iterdir())


def test_a_redirect_to_another_host_is_not_followed(raw):
    with server() as (there, asked):

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(302)
                self.send_header("Location", there)
                self.end_headers()

            def log_message(self, *_):
                pass

        with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as httpd:
            threading.Thread(target=httpd.serve_forever, daemon=True).start()
            with pytest.raises(FetchError, match=f"found a redirect to {there}"):
                fetch(a_file(f"http://127.0.0.1:{httpd.server_port}/bench/log.bin"), raw)
            httpd.shutdown()
    assert not asked


def test_an_error_page_does_not_touch_the_partial_file(raw):
    put(raw, CONTENT[:1000]).rename(raw / "bench" / "log.bin.partial")
    with server(ranges=False, content=b"not found", status=404) as (url, _), pytest.raises(FetchError, match="404"):
        fetch(a_file(url), raw)
    assert (raw / "bench" / "log.bin.partial").read_bytes() == CONTENT[:1000]


def test_offline_the_message_says_all_that_is_needed_to_place_the_file(raw):
    with pytest.raises(FetchError) as failure:
        fetch(a_file(), raw)
    file = a_file()
    for part in (file.name, file.url, file.sha256, str(file.size_bytes), str(raw / "bench" / "log.bin")):
        assert part in str(failure.value)


def test_the_folder_comes_before_the_mirror(raw, sets, tmp_path):
    dataset = replace(sets["adis16405"], files=(a_file(),))
    mirror = tmp_path / "mirror"
    assert not available(dataset, raw, mirror)
    with pytest.raises(FetchError, match="not found"):
        locate(a_file(), raw, mirror)
    there = put(mirror, CONTENT)
    assert available(dataset, raw, mirror)
    assert not available(dataset, raw)
    assert locate(a_file(), raw, mirror) == there
    here = put(raw, CONTENT)
    assert locate(a_file(), raw, mirror) == here
    assert available(dataset, raw)


def test_the_mirror_holds_what_the_catalogue_says(raw, sets, mirror):
    for dataset in sets.values():
        for file in dataset.files:
            assert fetch(file, raw, mirror).stat().st_size == file.size_bytes
