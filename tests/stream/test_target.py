import pytest

from derod.views.stream.cli import ViewError, parse_increments
from derod.views.stream.target import TargetError, parse_target


def test_places(tmp_path):
    assert parse_target("spawn").kind == "spawn"
    assert parse_target("web").kind == "web"
    assert parse_target("connect").address == ("127.0.0.1", 9876)
    assert parse_target("connect=otherhost:99").address == ("otherhost", 99)
    assert parse_target("connect=rerun+http://[::1]:8000/proxy").address == ("::1", 8000)
    file = parse_target(str(tmp_path / "a.rrd"))
    assert (file.kind, file.place) == ("file", str(tmp_path / "a.rrd"))


@pytest.mark.parametrize("text", ["", "spwan", "a.h5", "connect=http://x", "nowhere/at/all/x.rrd"])
def test_nonsense_is_refused_with_what_is_allowed(text):
    with pytest.raises(TargetError, match="allowed"):
        parse_target(text)


def test_increments():
    assert parse_increments("57,58") == {57, 58}
    assert parse_increments("events") is None
    for text in ("", "a", "-1", "1,,2"):
        with pytest.raises(ViewError, match="allowed"):
            parse_increments(text)
