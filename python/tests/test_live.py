"""`ilon.live`: `ilon live` from Python."""

import urllib.request

import pytest

import ilon


def test_a_live_run_serves_its_page_until_it_is_stopped(lateral):
    with ilon.live(lateral, settings={"world.floor.friction": 0.3, "robot.roller_bodies": "near"}) as live:
        with urllib.request.urlopen(live.url, timeout=60) as answer:
            page = answer.read().decode()
        assert "mecanum4_lateral" in page and '"friction":0.3' in page
        assert live.running and live.url in repr(live) and live.url in live._repr_html_()
        with pytest.raises(TimeoutError):
            live.wait(0.1)
    assert not live.running and "ended" in repr(live)


def test_it_ends_by_itself_after_its_seconds(lateral):
    live = ilon.live(lateral, seconds=0.5)
    live.wait(60)
    assert not live.running


def test_what_cannot_begin_is_refused_in_the_words_of_the_command(lateral, tmp_path):
    with pytest.raises(ilon.Error, match="there is no such file"):
        ilon.live(tmp_path / "none.toml")
    with pytest.raises(ilon.Error, match="from 0.05 to 20"):
        ilon.live(lateral, speed=1e3)
    with pytest.raises(ilon.Error, match="gravity"):
        ilon.live(lateral, settings={"world.gravitas": 1})
    with pytest.raises(ilon.Error):
        ilon.live(lateral, sandbox=tmp_path)
