"""The tool that draws the video: its length, its camera, and what it looks up in a recording."""

import pytest

from tools.video import CLOSING, OPENING, SHOTS, glide, latest
from tools.video_runs import RUNS


def test_it_lasts_ninety_seconds_and_every_shot_is_recorded():
    assert OPENING + CLOSING + sum(shot.length for shot in SHOTS) == 90.0
    assert {shot.run for shot in SHOTS} == set(RUNS)


def test_the_camera_rests_at_the_views_and_glides_between_them():
    views = ((0.0, 0.0, 4.0, 4.0), (10.0, 0.0, 14.0, 4.0))
    assert glide(views, 0.0) == glide(views, 0.15) == views[0]
    assert glide(views, 1.0) == glide(views, 0.9) == views[1]
    assert glide(views, 0.5) == pytest.approx((5.0, 0.0, 9.0, 4.0))


@pytest.mark.parametrize(("at", "found"), [(0.5, None), (1.0, "a"), (2.9, "a"), (9.0, "b")])
def test_what_was_said_last(at, found):
    said = latest([(1.0, "a"), (3.0, "b")], at)
    assert (said and said[1]) == found
